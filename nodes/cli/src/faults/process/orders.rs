//! C10: the nodes start in random orders, each a random while after the one before.

use super::graph::{Graph, Setting};
use super::observer::Seen;
use super::outcome::Observed;
use super::session::Session;
use crate::faults::catalogue::Bench;
use fdm_loop_msgs::SafetyState;
use models::units::Seconds;
use rand::rngs::StdRng;
use rand::seq::SliceRandom;
use rand::{Rng, SeedableRng};

/// Longest wait for a graph that is whole `[s]`.
const PATIENCE_S: f64 = 12.0;

/// Starts one graph after the other; the times until each is whole.
pub(super) async fn run(setting: &Setting, seed: u64, count: u32, gap_s: f64) -> anyhow::Result<Observed> {
    let mut random = StdRng::seed_from_u64(seed);
    let mut observed = Observed { seed, ..Observed::default() };
    let (mut times, mut ended) = (Vec::new(), 0.0);
    for _ in 0..count {
        let (mut graph, mut recipes) = Graph::prepare(setting, seed, Bench::Own)?;
        recipes.shuffle(&mut random);
        let order: Vec<&str> = recipes.iter().map(|recipe| recipe.name).collect();
        let first = recipes.remove(0);
        graph.launch(first)?;
        let mut session = Session::around(graph)?;
        for recipe in recipes {
            session.until(random.random_range(0.0..gap_s), |_, _| false).await?;
            session.graph.launch(recipe)?;
        }
        let begin = session.observer.now();
        match until_whole(&mut session, begin).await? {
            Some(took_s) => times.push(took_s),
            None => observed.wrong.push(format!("not whole in the order {}", order.join(" "))),
        }
        #[allow(clippy::cast_precision_loss, reason = "a handful")]
        let ended_here = session.take_ended().len() as f64;
        ended += ended_here;
        observed.wrong.extend(session.end().await?);
        session.graph.remove();
    }
    observed.reaction_s = times.iter().copied().max_by(f64::total_cmp);
    observed.measures.insert("whole", times);
    observed.figures.insert("ended", ended);
    Ok(observed)
}

/// Until every node is heard and the supervisor acts: it has what it demands of the others.
async fn until_whole(session: &mut Session, begin: Seconds) -> anyhow::Result<Option<f64>> {
    let mut acts = false;
    while (session.observer.now() - begin).0 < PATIENCE_S {
        let (_, seen) = session.next().await?;
        if let Seen::Safety(state) = &seen {
            acts = state.mode == SafetyState::MODE_ACT;
        }
        if acts && session.unheard().is_empty() {
            return Ok(Some((session.observer.now() - begin).0));
        }
    }
    Ok(None)
}

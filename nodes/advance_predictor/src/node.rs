//! The shell: moves and printer state in, predictions out.

use std::path::{Path, PathBuf};

use models::advance::Physics;
use models::units::Seconds;
use runtime::params::ParamFileError;
use runtime::{Diagnostics, Node, RuntimeError, topics};

use crate::compensation::{Ensemble, Predictor};
use crate::convert;
use crate::network::NetworkError;
use crate::params::Params;
use crate::predictor::AdvancePredictor;
use crate::turn::TurnNetwork;

/// Older messages are refused.
const AGE_LIMIT: Seconds = Seconds(1.0);
/// Heartbeat of a node that hears nothing.
const IDLE_PERIOD: Seconds = Seconds(0.2);

/// Why the node ended.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum NodeError {
    /// The graph.
    #[error(transparent)]
    Runtime(#[from] RuntimeError),
    /// Parameters.
    #[error(transparent)]
    Parameters(#[from] ParamFileError),
    /// A network's file that cannot be read.
    #[error("models: {}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A network's file that is refused.
    #[error("models: {}", path.display())]
    Network {
        /// The file.
        path: PathBuf,
        /// Why.
        source: NetworkError,
    },
}

/// Runs the node to its end.
///
/// # Errors
/// [`NodeError`] where it cannot start.
pub async fn run(mut node: Node) -> Result<(), NodeError> {
    let setup = Setup::read(&node)?;
    let mut motion = node.inlet(&topics::PRINTER_MOTION, AGE_LIMIT)?;
    let mut printer = node.inlet(&topics::PRINTER_STATE, AGE_LIMIT)?;
    let predictions = node.publish_on(&topics::ADVANCE_PREDICTION)?;
    let (clock, work, diagnostics) = (node.clock(), node.work(), node.diagnostics());
    let (mut predictor, mut jumps) = (setup.predictor(), clock.jumps_back());
    let mut idle = node.timer(IDLE_PERIOD);
    node.activated().await;
    loop {
        let taken = tokio::select! {
            biased;
            () = node.shutdown() => return Ok(()),
            taken = motion.next(convert::motion) => taken,
            taken = printer.next(convert::printer) => taken,
            _ = idle.next() => {
                work.done();
                continue;
            }
        };
        if std::mem::replace(&mut jumps, clock.jumps_back()) != clock.jumps_back() {
            predictor = setup.predictor();
        }
        if let Ok(event) = taken {
            if let Some(output) = predictor.on_event(event) {
                predictions.send(convert::prediction(clock.now(), &output));
            }
            show(&diagnostics, &predictor);
        }
        work.done();
    }
}

/// What a predictor is made of.
struct Setup {
    params: Params,
    compensation: Predictor,
    network: TurnNetwork,
}

impl Setup {
    /// What is refused here are parameters and the files that they name.
    fn read(node: &Node) -> Result<Self, NodeError> {
        Self::of(node).inspect_err(|_| node.refuse())
    }

    fn of(node: &Node) -> Result<Self, NodeError> {
        node.check_parameters(|parameters| {
            let physics: Physics = parameters.block("advance_physics")?;
            let params: Params = parameters.without(&["advance_physics"]).parse()?;
            check_polymer(&params, &physics)
        })?;
        let parameters = node.raw_parameters();
        let params: Params = parameters.without(&["advance_physics"]).parse()?;
        let physics: Physics = parameters.block("advance_physics")?;
        let ensemble = network(params.models.of(params.drive), |text| Ensemble::parse(text, params.drive))?;
        let network = network(&params.models.turn, TurnNetwork::parse)?;
        let path = params.models.of(params.drive).clone();
        let compensation = Predictor::new(physics, params.bounds, ensemble)
            .map_err(|source| NodeError::Network { path, source })?;
        Ok(Self { compensation, params, network })
    }

    /// A predictor that has seen nothing: at the start, and when time jumped back.
    fn predictor(&self) -> AdvancePredictor {
        AdvancePredictor::new(self.params.clone(), self.compensation.clone(), self.network.clone())
    }
}

/// Refuses a polymer that nobody knows: nothing would ever be answered.
fn check_polymer(params: &Params, physics: &Physics) -> Result<(), ParamFileError> {
    if physics.polymers.contains_key(&params.polymer) {
        return Ok(());
    }
    let names: Vec<&str> = physics.polymers.keys().map(String::as_str).collect();
    let message = format!("polymer = '{}': must be one of {}", params.polymer, names.join(", "));
    Err(ParamFileError::Refused { at: "advance_predictor".into(), message })
}

fn network<T>(path: &Path, parse: impl Fn(&str) -> Result<T, NetworkError>) -> Result<T, NodeError> {
    let text =
        runtime::input::text(path).map_err(|source| NodeError::File { path: path.to_path_buf(), source })?;
    parse(&text).map_err(|source| NodeError::Network { path: path.to_path_buf(), source })
}

fn show(diagnostics: &Diagnostics, predictor: &AdvancePredictor) {
    let counts = predictor.counts();
    diagnostics.set("moves", counts.moves);
    diagnostics.set("outside_hull", counts.outside_hull);
    diagnostics.set("unanswered", counts.unanswered);
    if let Some(reason) = predictor.refused() {
        diagnostics.set("last_unanswered", reason);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compensation::tests::{params, physics};

    #[test]
    fn a_polymer_that_nobody_knows_is_refused_with_the_choices() {
        let of =
            |polymer: &str| check_polymer(&Params { polymer: polymer.to_owned(), ..params() }, &physics());
        assert!(of("PETG").is_ok());
        let error = of("WOOD").unwrap_err().to_string();
        assert_eq!(error, "advance_predictor: polymer = 'WOOD': must be one of ABS, PETG, PLA");
    }
}

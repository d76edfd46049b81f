use super::training::{EdgeFit, KnownEdge, RawEdgeFit, fit, judge};
use super::*;
use crate::seal::flip_bits;

const RULER: Ruler = Ruler { from_m: -1.5e-4, step_m: 1e-5, count: 90 };
const FIT: RawEdgeFit = RawEdgeFit {
    from_m: -2.4e-4,
    step_m: 2e-5,
    inputs: 28,
    hidden: 8,
    scale_m: 5e-5,
    contrast_min: 0.15,
    epochs: 30,
    batch: 16,
    rate: 1e-2,
    rate_least: 1e-5,
    far_share: 0.35,
    far_m: 9e-5,
    near_m: 1.8e-5,
    pull_max: 0.5,
};

fn stream(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed | 1;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        f64::from(u32::try_from(state >> 32).unwrap()) / 4_294_967_296.0
    }
}

/// A road at level 160 on ground at 90, with a valley 40 deep and 40 um wide just beside its edge.
fn drawn(count: usize, seed: u64) -> Vec<KnownEdge> {
    let mut uniform = stream(seed);
    let one = |look: usize| {
        let (half_m, factor, gain) = (2.2e-4, 0.8 + 0.4 * uniform(), 0.6 + 0.6 * uniform());
        let edge_m = half_m * factor;
        let level = |sample: usize| {
            let away = (RULER.distance_m(f64::from(u32::try_from(sample).unwrap())) - edge_m) / 4e-5;
            let road = 1.0 / (1.0 + (4.0 * away).exp());
            gain * (90.0 + 70.0 * road - 40.0 * (-(away - 0.5).powi(2)).exp())
        };
        let levels = (0..RULER.count).map(level).collect();
        KnownEdge { look: u64::try_from(look / 3).unwrap(), levels, edge_m, half_m }
    };
    (0..count).map(one).collect()
}

fn fitted(epochs: u32) -> EdgeModel {
    let params = EdgeFit::try_from(RawEdgeFit { epochs, ..FIT }).unwrap();
    fit(&drawn(90, 3), &RULER, &params, &mut stream(5), &mut |_, _| {}).unwrap()
}

/// Each profile holds its edge exactly and without noise, so what is left is the network's own error: the window's
/// step is 20 um and linear sampling of a smooth fall places an edge to a small part of it.
#[test]
fn training_finds_edges_of_profiles_that_it_never_saw() {
    let unseen = drawn(60, 17);
    let (early, late) = (fitted(1), fitted(FIT.epochs));
    let rms_m = |model: &EdgeModel| {
        let errors_m = unseen.iter().map(|known| {
            let answer_m = model.answer(&known.levels, &RULER, known.edge_m - 3e-5).unwrap();
            (answer_m - 3e-5).powi(2)
        });
        (errors_m.sum::<f64>() / 60.0).sqrt()
    };
    assert!(rms_m(&late) < 0.5 * rms_m(&early), "{:e} {:e}", rms_m(&late), rms_m(&early));
    let figures = judge(&late, &unseen, &RULER, 0.45);
    assert!(figures.located >= 54 && figures.looks == 20, "{figures:?}");
    assert!(figures.bias_m.abs() < 5e-6 && figures.sd_m < 1e-5, "{figures:?}");
    let [least_m, most_m] = figures.bias_by_look_m;
    assert!(least_m <= figures.bias_m && figures.bias_m <= most_m);
}

#[test]
fn the_same_stream_gives_the_same_file_and_the_file_the_same_network() {
    let model = fitted(2).with_trained("three \"looks\", no more,".to_owned());
    let text = model.text().unwrap();
    assert_eq!(text, fitted(2).with_trained("three \"looks\", no more,".to_owned()).text().unwrap());
    assert_eq!(EdgeModel::parse(&text).unwrap(), model);
}

#[test]
fn the_committed_file_means_the_same_when_it_is_written_again() {
    let path = format!("{}/../../config/models/road_edge.json", env!("CARGO_MANIFEST_DIR"));
    let model = EdgeModel::parse(&std::fs::read_to_string(path).unwrap()).unwrap();
    assert_eq!(EdgeModel::parse(&model.text().unwrap()).unwrap(), model);
}

/// T5: a file that was cut, or of which a bit was flipped: a digit of a weight makes another weight, and nothing else tells.
#[test]
fn a_damaged_file_is_refused() {
    let path = format!("{}/../../config/models/road_edge.json", env!("CARGO_MANIFEST_DIR"));
    let whole = std::fs::read_to_string(path).unwrap();
    flip_bits(&whole, 101, |text| EdgeModel::parse(text).err());
    let cuts = (0..whole.trim_end().len()).step_by(101);
    assert!(cuts.into_iter().all(|length| EdgeModel::parse(&whole[..length]).is_err()));
    let told = EdgeModel::parse(&whole.replace("0.461058", "0.561058")).unwrap_err().to_string();
    assert!(told.starts_with("edge file: sha256 is '") && told.contains("by the contents"), "{told}");
}

#[test]
fn nothing_to_learn_from_is_refused_and_so_is_a_bad_number() {
    let params = EdgeFit::try_from(FIT).unwrap();
    let none = fit(&[], &RULER, &params, &mut stream(1), &mut |_, _| {});
    assert_eq!(none, Err(EdgeError::Profiles));
    let refused = EdgeFit::try_from(RawEdgeFit { near_m: f64::NAN, ..FIT }).unwrap_err();
    assert!(refused.to_string().starts_with("fit.near_m = NaN"), "{refused}");
}

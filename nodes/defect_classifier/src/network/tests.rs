use super::*;
use crate::features::COUNT;
use crate::seal::{flip_bits, sealed};
use serde_json::{Value, json};

fn committed(name: &str) -> String {
    let path = format!("{}/../../config/models/{name}.json", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(path).unwrap()
}

/// Two classes, two inputs, one hidden unit; the probe is worked out by hand:
/// `x = sin 1, sin 2`, `h = tanh(0.5 x1 - 0.25 x2 + 0.1)`, logits `h` and `0.2 - h`.
fn small() -> Value {
    let hidden = (0.5 * 1.0_f64.sin() - 0.25 * 2.0_f64.sin() + 0.1).tanh();
    json!({
        "format": "fdm_loop network", "version": 1, "sha256": "", "view": "toolhead", "hidden_share": 0.0, "trained": "by hand",
        "classes": ["ok", "under"], "inputs": ["level_std", "level_mean"],
        "centre": [0.1, 0.5], "scale": [0.05, 0.2], "clip": 4.0,
        "layers": [
            {"weights": [[0.5, -0.25]], "bias": [0.1]},
            {"weights": [[1.0], [-1.0]], "bias": [0.0, 0.2]},
        ],
        "probe": [hidden, 0.2 - hidden],
    })
}

/// The file as training would write it.
fn text(file: &Value) -> String {
    sealed(&serde_json::to_string_pretty(file).unwrap())
}

fn refusal(file: &Value) -> String {
    Network::parse(&text(file)).unwrap_err().to_string()
}

/// Probabilities as the numbers of a file give them: standardised, cut, weighed, `tanh` between layers, softmax.
fn by_the_file(file: &Value, values: &[f64]) -> Vec<f64> {
    let numbers = |list: &Value| -> Vec<f64> {
        list.as_array().unwrap().iter().map(|number| number.as_f64().unwrap()).collect()
    };
    let (names, clip) = (features::names(), file["clip"].as_f64().unwrap());
    let (centre, scale) = (numbers(&file["centre"]), numbers(&file["scale"]));
    let mut signal: Vec<f64> = Vec::new();
    for (row, input) in file["inputs"].as_array().unwrap().iter().enumerate() {
        let place = names.iter().position(|name| input == name).unwrap();
        signal.push(((values[place] - centre[row]) / scale[row]).clamp(-clip, clip));
    }
    let layers = file["layers"].as_array().unwrap();
    for (place, layer) in layers.iter().enumerate() {
        let mut next = numbers(&layer["bias"]);
        for (sum, weights) in next.iter_mut().zip(layer["weights"].as_array().unwrap()) {
            *sum += numbers(weights).iter().zip(&signal).map(|(weight, value)| weight * value).sum::<f64>();
            *sum = if place + 1 < layers.len() { sum.tanh() } else { sum.exp() };
        }
        signal = next;
    }
    let total: f64 = signal.iter().sum();
    signal.into_iter().map(|value| value / total).collect()
}

#[test]
fn the_committed_networks_judge_as_their_numbers_say() {
    for (name, view) in [("toolhead", "toolhead"), ("photograph", "photograph")] {
        let (text, network) = (committed(name), Network::parse(&committed(name)).unwrap());
        let file: Value = serde_json::from_str(&text).unwrap();
        assert_eq!((network.view(), network.classes()[0].as_str()), (view, OK));
        assert!(network.classes().len() >= 6, "{name}");
        let mut named = Vec::new();
        for turn in 0..8 {
            let values: Vec<f64> = (0..COUNT)
                .map(|place| {
                    0.5 + 0.4 * (f64::from(u16::try_from(place).unwrap()) + 0.7 * f64::from(turn)).sin()
                })
                .collect();
            let scores = network.score(&values).unwrap();
            for (found, wanted) in scores.probabilities.iter().zip(by_the_file(&file, &values)) {
                assert!((found - wanted).abs() < 1e-12, "{name}: {found} and {wanted}");
            }
            named.push(scores.probabilities);
        }
        named.dedup();
        assert_eq!(named.len(), 8, "{name} says the same of everything");
    }
}

#[test]
fn a_small_network_gives_what_the_equations_give() {
    let network = Network::parse(&text(&small())).unwrap();
    let mut values = vec![0.0; COUNT];
    let names = features::names();
    let place = |name: &str| names.iter().position(|known| *known == name).unwrap();
    // Standardised 2 and -40, the latter cut to -4: h = tanh(1 + 1 + 0.1), p(ok) = 1 / (1 + e^(0.2 - 2 h)).
    values[place("level_std")] = 0.2;
    values[place("level_mean")] = -7.5;
    let hidden = 2.1_f64.tanh();
    let ok = 1.0 / (1.0 + (0.2 - 2.0 * hidden).exp());
    let scores = network.score(&values).unwrap();
    assert!((scores.probabilities[0] - ok).abs() < 1e-12 && scores.best() == 0);
    assert!((scores.defect() - (1.0 - ok)).abs() < 1e-12);
}

#[test]
fn a_broken_file_is_refused_with_its_field() {
    type Break = fn(&mut Value);
    let breaks: [(&str, Break); 12] = [
        ("format is", |file| file["version"] = json!(2)),
        ("classes is", |file| file["classes"] = json!(["under", "ok"])),
        ("centre is 1 long", |file| file["centre"] = json!([0.1])),
        ("scale[1] is 0", |file| file["scale"][1] = json!(0.0)),
        ("clip is", |file| file["clip"] = json!(-1.0)),
        ("hidden_share is", |file| file["hidden_share"] = json!(0.6)),
        ("inputs[0] is colour", |file| file["inputs"][0] = json!("colour")),
        ("layers is 0 long", |file| file["layers"] = json!([])),
        ("layers[0].weights[0] is 1 long", |file| file["layers"][0]["weights"][0] = json!([0.5])),
        ("layers[1].bias is 1 long", |file| file["layers"][1]["bias"] = json!([0.0])),
        ("probe is 1 long", |file| file["probe"] = json!([0.0])),
        ("probe[0] is", |file| file["layers"][0]["weights"][0][1] = json!(-0.250_001)),
    ];
    assert!(Network::parse(&text(&small())).is_ok());
    for (text, broken) in breaks {
        let mut file = small();
        broken(&mut file);
        let said = refusal(&file);
        assert!(said.starts_with(&format!("network file: {text}")), "{said} is not {text}");
    }
}

#[test]
fn a_torn_file_and_unknown_fields_are_refused() {
    let whole = committed("toolhead");
    let torn = Network::parse(&whole[..whole.len() / 2]).unwrap_err().to_string();
    assert!(torn.contains("line"), "{torn}");
    let mut file = small();
    file["colour"] = json!(1);
    assert!(refusal(&file).contains("unknown field `colour`"));
    file = small();
    file["layers"][0]["bias"][0] = Value::Null;
    assert!(refusal(&file).contains("invalid type: null"));
}

/// T5: any bit of a small file, and many of those that are shipped: also of a number that no probe wakes, and of one that
/// nothing reckons with.
#[test]
fn a_file_with_a_flipped_bit_is_refused() {
    flip_bits(&text(&small()), 1, |text| Network::parse(text).err());
    for name in ["toolhead", "photograph"] {
        flip_bits(&committed(name), 997, |text| Network::parse(text).err());
    }
    let hidden = committed("toolhead").replace("\"hidden_share\": 0.19", "\"hidden_share\": 0.29");
    let told = Network::parse(&hidden).unwrap_err().to_string();
    assert!(told.starts_with("network file: sha256 is '"), "{told}");
}

/// T5: cut anywhere but in the blanks at its end.
#[test]
fn a_file_that_was_cut_is_refused() {
    let whole = text(&small());
    assert!((0..whole.len()).all(|length| Network::parse(&whole[..length]).is_err()));
    let whole = committed("toolhead");
    let whole = whole.trim_end();
    assert!((0..whole.len()).step_by(997).all(|length| Network::parse(&whole[..length]).is_err()));
}

#[test]
fn features_that_are_too_few_or_not_finite_get_no_scores() {
    let network = Network::parse(&text(&small())).unwrap();
    assert!(network.score(&[0.0]).is_err());
    assert!(network.score(&vec![f64::NAN; COUNT]).is_err());
}

/// Two clouds that a line parts: a fit must part them, and the same chance must give the same file.
#[test]
fn a_fit_parts_what_can_be_parted_and_repeats() {
    use training::{FitParams, Labelled, Purpose, RawFit, fit};
    let params = FitParams::try_from(RawFit {
        hidden: vec![4],
        epochs: 40,
        batch: 8,
        rate: 0.03,
        decay: 0.0,
        jitter: 0.0,
        clip: 4.0,
    })
    .unwrap();
    let examples: Vec<Labelled> = (0..64_u8)
        .map(|step| {
            let (x, y) = (f64::from(step % 8) / 8.0, f64::from(step / 8) / 8.0);
            let mut values = vec![0.0; COUNT];
            values[..2].copy_from_slice(&[x, y]);
            Labelled { values, class: usize::from(x + y > 0.9), weight: 1.0 }
        })
        .collect();
    let names = features::names();
    let purpose = Purpose {
        view: "toolhead",
        hidden: features::Hidden(0.0),
        trained: "in a test",
        classes: &["ok", "under"],
        inputs: &names[..2],
    };
    let run = || {
        // A linear congruence (Knuth's MMIX constants) is chance enough here.
        let mut state = 1_u64;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            f64::from(u32::try_from(state >> 32).unwrap()) / 4_294_967_296.0
        };
        fit(&purpose, &examples, &params, &mut uniform).unwrap()
    };
    let text = run();
    assert_eq!(text, run());
    let network = Network::parse(&text).unwrap();
    let right =
        examples.iter().filter(|example| network.score(&example.values).unwrap().best() == example.class);
    assert!(right.count() >= 61, "of 64 points on a grid, at most the three nearest the line may fall wrong");
    assert!(fit(&purpose, &[], &params, &mut || 0.5).is_err());
}

use super::*;
use models::params::{ParamError, in_range, ordered};
use serde::Deserialize;
use std::sync::atomic::{AtomicU64, Ordering};

mod other;

#[derive(Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct Params {
    rate_hz: f64,
    limits: Limits,
    #[serde(default)]
    names: Vec<String>,
}

#[derive(Debug, PartialEq, Deserialize)]
#[serde(try_from = "RawLimits")]
struct Limits {
    flow_min: f64,
    flow_max: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawLimits {
    flow_min: f64,
    flow_max: f64,
}

impl TryFrom<RawLimits> for Limits {
    type Error = ParamError;
    fn try_from(raw: RawLimits) -> Result<Self, ParamError> {
        ordered(("flow_min", raw.flow_min), ("flow_max", raw.flow_max))?;
        Ok(Self {
            flow_min: in_range("flow_min", raw.flow_min, "-", (0.0, 1.0))?,
            flow_max: in_range("limits.flow_max", raw.flow_max, "-", (1.0, 2.0))?,
        })
    }
}

const GOOD: &str = "/**:\n  ros__parameters:\n    rate_hz: 4    # [Hz]\n    limits:\n      flow_min: 0.8\n      flow_max: 1.2\n";

fn node() -> NodePath {
    NodePath { qualified: "/printer/mpc".into(), base: "mpc".into() }
}

static FILES: AtomicU64 = AtomicU64::new(0);

/// Writes the texts to files of their own and reads them.
fn read(texts: &[&str], overrides: &[(&str, &str)]) -> Result<Parameters, ParamFileError> {
    let folder = std::env::temp_dir().join(format!("runtime_params_{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let files: Vec<PathBuf> = texts
        .iter()
        .map(|text| {
            // Tests run side by side: each file is written once.
            let file = folder.join(format!("{}.yaml", FILES.fetch_add(1, Ordering::Relaxed)));
            std::fs::write(&file, text).unwrap();
            file
        })
        .collect();
    let overrides: Vec<_> = overrides.iter().map(|(a, b)| ((*a).to_owned(), (*b).to_owned())).collect();
    Parameters::read(&files, &overrides, &node())
}

fn parse(texts: &[&str], overrides: &[(&str, &str)]) -> Result<Params, ParamFileError> {
    read(texts, overrides)?.parse()
}

/// The error without its folder and file name: `:line: message`.
fn refusal(text: &str) -> String {
    let error = parse(&[text], &[]).unwrap_err().to_string();
    error.split_once(".yaml").map_or(error.clone(), |(_, rest)| rest.to_owned())
}

#[test]
fn a_later_file_wins_and_overrides_win_over_files() {
    let second = "mpc:\n  ros__parameters:\n    limits.flow_max: 1.5\n    names: [a, b]\n";
    let third =
        "other:\n  ros__parameters:\n    rate_hz: 100\n/printer/mpc:\n  ros__parameters: {rate_hz: 5}\n";
    let params = parse(&[GOOD, second, third], &[("limits.flow_min", "0.9")]).unwrap();
    let limits = Limits { flow_min: 0.9, flow_max: 1.5 };
    assert_eq!(params, Params { rate_hz: 5.0, limits, names: vec!["a".into(), "b".into()] });
}

#[test]
fn a_refused_value_is_named_with_file_line_field_and_range() {
    assert_eq!(refusal(&GOOD.replace("1.2", "3")), ":6: limits.flow_max = 3 (no unit): must be in [1, 2]");
    assert_eq!(refusal(&GOOD.replace("0.8", "-1")), ":5: limits.flow_min = -1 (no unit): must be in [0, 1]");
    assert_eq!(
        refusal(&GOOD.replace("0.8", "1.9")),
        ":5: limits.flow_min = 1.9: must be below flow_max = 1.2"
    );
}

#[test]
fn unknown_missing_and_mistyped_keys_are_named_with_their_line() {
    let unknown = refusal(&GOOD.replace("flow_max: 1.2", "flow_max: 1.2\n      flow_mux: 1"));
    assert!(unknown.starts_with(":7: limits.flow_mux") && unknown.contains("unknown field"), "{unknown}");
    let missing = refusal(&GOOD.replace("      flow_max: 1.2\n", ""));
    assert_eq!(missing, ":4: limits.flow_max: missing");
    let flat = refusal(&GOOD[..GOOD.find("    limits").unwrap()]);
    assert_eq!(flat, ": limits: missing");
    let mistyped = refusal(&GOOD.replace("rate_hz: 4", "rate_hz: fast"));
    assert_eq!(mistyped, ":3: rate_hz = \"fast\": must be a number");
    let error = parse(&[GOOD], &[("limits", "3")]).unwrap_err().to_string();
    assert_eq!(error, "-p limits:=3: limits = 3: must be a block of names and values");
}

/// What is missing is blamed on no file alone, the last one say: all are named, and those that say nothing.
#[test]
fn a_file_that_says_nothing_is_named() {
    let other = "/**:\n  ros__parameters:\n    names: [a]\n";
    let said = |texts: &[&str], pairs: &[(&str, &str)]| {
        let parameters = read(texts, pairs).unwrap();
        let error = parameters.parse::<Params>().unwrap_err().to_string();
        let names = parameters.files.iter().enumerate().map(|(at, file)| (file.display().to_string(), at));
        names.fold(error, |error, (name, at)| error.replace(&name, &at.to_string()))
    };
    let wrong = GOOD.replace("/**", "mpcs");
    for silent in ["", "# nothing\n", "/**:\n  ros__parameters:\n", "mpc: {ros__parameters: {}}\n", &wrong] {
        assert_eq!(said(&[silent, other], &[]), "0 (holds nothing for mpc), 1: rate_hz: missing", "{silent}");
    }
    assert_eq!(said(&[other, other], &[]), "0, 1: rate_hz: missing");
    let option = [("rate_hz", "4"), ("limits.flow_max", "1.2")];
    assert_eq!(said(&[&wrong], &option), "0 (holds nothing for mpc): limits.flow_min: missing");
    let error = read(&[other], &[]).unwrap().block::<Limits>("limits").unwrap_err().to_string();
    assert!(
        error.ends_with(": limits: missing; a parameter file is lacking, or a name in one is misspelt"),
        "{error}"
    );
}

#[test]
fn values_that_are_not_finite_are_refused() {
    assert_eq!(refusal(&GOOD.replace("rate_hz: 4", "rate_hz: .nan")), ":3: rate_hz = NaN Hz: must be finite");
    assert_eq!(refusal(&GOOD.replace("0.8", ".inf")), ":5: limits.flow_min = inf: must be finite");
}

#[test]
fn text_that_is_no_parameter_file_is_refused_with_its_line() {
    let text = refusal("/**:\n  rate_hz: 4\n");
    assert!(text.starts_with(":2: 'rate_hz' stands outside of ros__parameters"), "{text}");
    let text = refusal("/**:\n  ros__parameters:\n    a: 1\n    a: 2\n");
    assert_eq!(text, ":3: 'a' stands twice in the same block: lines 3 and 4");
    let text = refusal("/**:\n  ros__parameters: [\n");
    assert!(text.starts_with(':'), "{text}");
    let gone = Parameters::read(&["/no/such.yaml".into()], &[], &node()).unwrap_err().to_string();
    assert!(gone.starts_with("/no/such.yaml: "), "{gone}");
}

#[test]
fn an_override_is_named_in_its_error() {
    let error = parse(&[GOOD], &[("limits.flow_max", "9")]).unwrap_err().to_string();
    assert_eq!(error, "-p limits.flow_max:=9: limits.flow_max = 9 (no unit): must be in [1, 2]");
}

/// Of two that must stand in order that one is named which was set.
#[test]
fn what_was_set_is_blamed_and_not_its_neighbour() {
    let error = parse(&[&GOOD.replace("0.8", "1")], &[("limits.flow_max", "1")]).unwrap_err().to_string();
    assert_eq!(error, "-p limits.flow_max:=1: limits.flow_max = 1: must be above limits.flow_min = 1");
    let mine = "/**:\n  ros__parameters:\n    limits.flow_max: 1\n";
    let error = parse(&[&GOOD.replace("0.8", "1"), mine], &[]).unwrap_err().to_string();
    assert!(error.ends_with("yaml:3: limits.flow_max = 1: must be above limits.flow_min = 1"), "{error}");
}

/// The range beside a value holds, whoever sets it and whatever the struct takes.
#[test]
fn the_range_in_a_comment_holds() {
    let file = GOOD.replace("[Hz]", "[Hz] in [1, 9]").replace("flow_max: 1.2", "flow_max: 1.2 # [-] 1..1.5");
    let said = |pair: (&str, &str)| parse(&[&file], &[pair]).unwrap_err().to_string();
    assert_eq!(said(("rate_hz", "1e12")), "-p rate_hz:=1e12: rate_hz = 1e12 Hz: must be in [1, 9]");
    assert_eq!(said(("rate_hz", ".inf")), "-p rate_hz:=.inf: rate_hz = inf Hz: must be finite and in [1, 9]");
    assert_eq!(
        said(("rate_hz", "fast")),
        "-p rate_hz:=fast: rate_hz = \"fast\": must be a number; allowed in [1, 9] Hz"
    );
    assert!(
        said(("limits.flow_max", "1.8")).ends_with("limits.flow_max = 1.8 (no unit): must be in [1, 1.5]")
    );
    let wider = "/**:\n  ros__parameters:\n    rate_hz: 20 # [Hz] in [1, 50]\n";
    assert!(
        parse(&[&file, wider], &[]).unwrap_err().to_string().ends_with("rate_hz = 20 Hz: must be in [1, 9]")
    );
}

#[test]
fn simulated_time_belongs_to_the_runtime() {
    let parameters = read(&[GOOD], &[("use_sim_time", "true")]).unwrap();
    assert!(parameters.use_sim_time());
    assert!(parameters.parse::<Params>().is_ok());
    let error = read(&[GOOD], &[("use_sim_time", "3")]).unwrap_err().to_string();
    assert_eq!(error, "-p use_sim_time:=3: use_sim_time = 3: must be a boolean");
}

#[test]
fn the_text_and_its_hash_depend_on_the_values_alone() {
    let nested = read(&[GOOD], &[]).unwrap();
    let dotted =
        "mpc:\n  ros__parameters:\n    limits.flow_max: 1.2\n    limits.flow_min: 0.8\n    rate_hz: 4\n";
    let dotted = read(&[dotted], &[]).unwrap();
    assert_eq!(
        nested.text(),
        "limits.flow_max: 1.2\nlimits.flow_min: 0.8\nrate_hz: 4\nuse_sim_time: false\n"
    );
    assert_eq!(nested.sha256(), dotted.sha256());
    assert_eq!(sha256_hex(b""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

#[test]
fn namespaced_blocks_are_found() {
    let text = "/printer:\n  mpc:\n    ros__parameters:\n      rate_hz: 7\n/**/mpc:\n  ros__parameters:\n    limits: {flow_min: 0.5, flow_max: 1.5}\n/left:\n  mpc:\n    ros__parameters:\n      rate_hz: 1\n";
    assert!((parse(&[text], &[]).unwrap().rate_hz - 7.0).abs() < f64::EPSILON);
}

/// Names with and without slashes, stars for one part and for any number; another printer's values are not ours.
#[test]
fn blocks_are_of_the_node_that_they_name() {
    let own =
        ["/printer/mpc", "/*/mpc", "/**/*", "/printer/*", "/printer/**", "/**/printer/mpc", "mpc", "/**"];
    let others = ["/left/mpc", "/*/*/mpc", "/*", "/printer", "/printer/mpc/x", "mp"];
    let good = |name: &str| GOOD.replace("/**", name);
    for name in own {
        assert!(parse(&[&good(name)], &[]).is_ok(), "{name}");
    }
    for name in others {
        assert!(parse(&[&good(name)], &[]).is_err(), "{name}");
    }
    let nested = |namespace: &str| {
        let text = format!("{namespace}:\n  mpc:\n    ros__parameters: {{rate_hz: 9}}\n");
        parse(&[GOOD, &text], &[]).unwrap().rate_hz
    };
    for (namespace, rate_hz) in [("left", 4.0), ("printer", 9.0), ("/left", 4.0), ("/printer", 9.0)] {
        assert!((nested(namespace) - rate_hz).abs() < f64::EPSILON, "{namespace}");
    }
}

/// `-p node:name:=value`, with the patterns of the files in front: for whom it is meant, and nobody else.
#[test]
fn an_override_may_be_for_one_node_alone() {
    for (name, rate_hz) in [
        ("rate_hz", 9.0),
        ("mpc:rate_hz", 9.0),
        ("/printer/mpc:rate_hz", 9.0),
        ("/**:rate_hz", 9.0),
        ("imu:rate_hz", 4.0),
        ("/left/mpc:rate_hz", 4.0),
    ] {
        let params = parse(&[GOOD], &[(name, "9")]).unwrap();
        assert!((params.rate_hz - rate_hz).abs() < f64::EPSILON, "{name}");
    }
    for bad in ["mpc:", "mpc:a:rate_hz"] {
        let error = parse(&[GOOD], &[(bad, "9")]).unwrap_err().to_string();
        assert!(error.ends_with("expected name:=value or node:name:=value"), "{error}");
    }
}

/// A megabyte where a number should stand is named, not said again; the rule behind it is.
#[test]
fn a_refusal_of_a_long_value_is_short() {
    let long = "x".repeat(1_000_000);
    let by_file = refusal(&GOOD.replace("rate_hz: 4", &format!("rate_hz: {long}")));
    assert!(by_file.len() < 1500 && by_file.ends_with("must be a number"), "{by_file:.2000}");
    for name in ["rate_hz", "limits.flow_max", "names", "use_sim_time"] {
        let text = parse(&[GOOD], &[(name, &long)]).unwrap_err().to_string();
        assert!(text.len() < 1500, "{name}: {text:.2000}");
    }
}

/// A line of a log stays one, whatever a name holds.
#[test]
fn a_refusal_of_any_name_is_one_line() {
    for name in ["rate\n_hz", "limits.flow\u{1b}[31m", "other.a\nb"] {
        let text = parse(&[GOOD], &[(name, "9")]).unwrap_err().to_string();
        assert!(!text.contains(char::is_control) && text.contains("\\"), "{text:?}");
    }
    let long = "k".repeat(1 << 20);
    for key in ["a\t", "\"a\\e[2J\"", "\"a\\nb\"", &long] {
        let text = parse(&[&format!("{key}: 1\n")], &[]).unwrap_err().to_string();
        assert!(!text.contains(char::is_control) && text.len() < 1500, "{text:.2000?}");
    }
    let found = read(&[], &[("a\nuse_sim_time", "true")]).unwrap();
    assert_eq!(found.text(), "a\\nuse_sim_time: true\nuse_sim_time: false\n");
}

//! Arguments of a node, as `ros2 run`, a launch file or a person passes them.

use super::laws::is_one_line;
use super::shipped;
use runtime::{Args, Parameters};

/// Words are divided by a byte of zero, as the kernel hands them over.
pub fn arguments(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let words: Vec<String> = text.split('\0').map(str::to_owned).collect();
    match Args::parse(words.clone()) {
        Err(error) => is_one_line(&error.to_string()),
        Ok(args) => {
            nothing_is_made_up(&args, &words);
            if let Some(namespace) = &args.namespace {
                runtime::check_namespace(namespace)
                    .err()
                    .iter()
                    .for_each(|error| is_one_line(&error.to_string()));
            }
            // What stands behind -p is YAML.
            match Parameters::read(&[], &args.parameters, &shipped::node("thermistor")) {
                Err(error) => is_one_line(&error.to_string()),
                Ok(read) => assert!(read.text().lines().all(|line| line.contains(": ")), "{}", read.text()),
            }
        }
    }
}

/// Each word is in one place, and nowhere is what no word said.
fn nothing_is_made_up(args: &Args, words: &[String]) {
    let is_said = |part: &str| words.iter().any(|word| word.contains(part));
    assert!(args.rest.iter().all(|word| words.contains(word)));
    assert!(args.node.iter().chain(&args.namespace).all(|name| is_said(name)));
    let pairs = args.remaps.iter().chain(&args.parameters);
    assert!(pairs.into_iter().all(|(from, to)| !from.is_empty() && is_said(&format!("{from}:={to}"))));
    assert!(args.params_files.iter().all(|file| file.to_str().is_some_and(is_said)));
    args.remarks.iter().for_each(|remark| is_one_line(remark));
    let values = args.remaps.len() + args.parameters.len() + args.params_files.len() + args.log_levels.len();
    assert!(args.rest.len() + 2 * values <= words.len());
}

pub(super) fn seeds() -> Vec<Vec<u8>> {
    let lines = [
        "--ros-args -r __ns:=/left -r __node:=a -r a:b:=c -p start_mode:=act -p a.b:=[1,2] --params-file x.yaml",
        "mine --ros-args --log-level rcl:=debug --log-level warn --disable-stdout-logs -e /x --log-config-file f -- rest",
        "--ros-args -p thermistor:hotend.sigma_k:=0.5 --remap rostopic://a:=b --param /printer/thermistor:x:={a: 1}",
    ];
    lines.map(|line| line.replace(' ', "\0").into_bytes()).to_vec()
}

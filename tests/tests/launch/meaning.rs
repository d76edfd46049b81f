//! What a process is started with, whoever starts it and however it is written.

use crate::root;
use runtime::Args;
use runtime::params::{NodePath, Parameters};
use serde_json::Value;
use std::path::PathBuf;

/// Node, program, namespace, remapped names and every parameter after merging, as text.
pub(crate) fn meaning(process: &Value) -> [String; 5] {
    let text = |name: &str| process[name].as_str().unwrap().to_owned();
    let words = process["arguments"].as_array().unwrap().iter().map(|word| word.as_str().unwrap().to_owned());
    let args = Args::parse(words).unwrap();
    let (node, namespace) = (text("node"), args.namespace.unwrap());
    let path = NodePath { qualified: format!("{namespace}/{node}"), base: node.clone() };
    // Relative paths are those of the folder that both were started in.
    let files: Vec<PathBuf> = args.params_files.iter().map(|file| root().join(file)).collect();
    let parameters = Parameters::read(&files, &args.parameters, &path).unwrap();
    let remaps = args.remaps.iter().map(|(from, to)| format!("{from}:={to} ")).collect();
    [node, text("program"), namespace, remaps, parameters.text()]
}

/// After whom a process starts by itself: no part of [`meaning`], since `fdm up` keeps the order in its own way.
pub(crate) fn start_after(process: &Value) -> Vec<String> {
    let words: Vec<&str> =
        process["arguments"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
    let told = words.windows(2).find_map(|pair| match pair {
        ["-p", value] => Some(value.strip_prefix("start_after:=")?.trim_matches(['[', ']']).to_owned()),
        ["--params-file", file] => {
            // What the launch file decides is JSON here.
            let values: Value =
                serde_json::from_str(&std::fs::read_to_string(root().join(file)).ok()?).ok()?;
            let names = values["/**"]["ros__parameters"]["start_after"].as_array()?.clone();
            Some(names.iter().filter_map(Value::as_str).collect::<Vec<_>>().join(","))
        }
        _ => None,
    });
    told.unwrap_or_default().split(',').filter(|name| !name.is_empty()).map(str::to_owned).collect()
}

pub(crate) fn to_owned(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}

//! `fdm wire up`: machine, controller and supervisor as processes; a wall from its first layer to its last.

use super::follow::{Built, Follow};
use crate::config::ConfigDir;
use crate::options::in_range;
use crate::output::{self, Failed, Json};
use crate::programs;
use crate::up::fleet::{Fleet, Recipe};
use crate::up::{check_new_bag, close};
use anyhow::Context;
use clap::Args;
use runtime::params::{NodePath, Parameters};
use std::path::{Path, PathBuf};

/// Starts the node processes of a wire machine and builds a simulated wall, over DDS.
#[derive(Debug, Args)]
pub struct UpArgs {
    /// Layers of the wall.
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    layers: u32,
    /// Simulated over wall time.
    #[arg(long, default_value_t = 5.0)]
    speed: f64,
    /// Seed of scatter, noise, dips and bumps.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Mode of the supervisor: observe, advise or act.
    #[arg(long, default_value = "act", value_parser = ["observe", "advise", "act"])]
    mode: String,
    /// Record into this new folder; the nodes' messages go beside it. Nothing is recorded without it.
    #[arg(long)]
    bag: Option<PathBuf>,
    /// Namespace of the machine.
    #[arg(long, default_value = "/printer", value_parser = runtime::check_namespace)]
    namespace: String,
    /// Folder with the parameter files.
    #[arg(long)]
    config: Option<PathBuf>,
    /// Print the processes that would be started, as JSON, and start none.
    #[arg(long)]
    dry_run: bool,
    /// Write the figures to a file, or to standard output with `-`.
    #[arg(long)]
    json: Option<PathBuf>,
}

/// One process to be: name of the node, its parameter files, its overrides.
struct Member {
    name: &'static str,
    files: &'static [&'static str],
    overrides: Vec<(&'static str, String)>,
}

/// The nodes of a wall and their parameter files.
pub(crate) const FILES: [(&str, &[&str]); 3] = [
    ("safety_supervisor", &["safety_supervisor.param.yaml", "wire/safety_supervisor.param.yaml"]),
    ("mpc_controller", &["wire/mpc_controller.param.yaml", "wire/controller.yaml", "wire/process.yaml"]),
    ("printer_sim", &["wire/printer_sim.param.yaml", "plants/wire.yaml", "wire/process.yaml"]),
];

/// Runs the command.
///
/// # Errors
/// What is refused of parameters, a process that cannot be started, a wall that was not finished.
pub fn run(args: &UpArgs) -> anyhow::Result<()> {
    let config = ConfigDir::find(args.config.as_deref())?;
    in_range("--speed", args.speed, "-", (0.1, 20.0))?;
    let json = Json::new(args.json.as_deref());
    json.check()?;
    let bag = args.bag.as_deref().map(std::path::absolute).transpose()?;
    if let Some(bag) = &bag {
        check_new_bag(bag)?;
    }
    let members = members(args, bag.as_deref());
    let recipes: Vec<Recipe> =
        members.iter().map(|member| recipe(args, &config, member)).collect::<anyhow::Result<_>>()?;
    recipes.iter().try_for_each(|recipe| programs::built(&recipe.program))?;
    if args.dry_run {
        let process = |recipe: &Recipe| serde_json::json!({"node": recipe.name, "program": recipe.program, "arguments": recipe.arguments});
        let processes: Vec<_> = recipes.iter().map(process).collect();
        return output::line(&serde_json::to_string_pretty(&processes)?);
    }
    let executor = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    let built = executor.block_on(build(args, recipes, &logs(bag.as_deref()), json.is_stdout()))?;
    bag.as_deref().into_iter().for_each(close);
    if !json.is_stdout() {
        output::line(&built.text())?;
    }
    json.write(&built)?;
    if built.is_done() {
        return Ok(());
    }
    Err(Failed(format!("the wall was not finished: {}", built.ended())).into())
}

async fn build(args: &UpArgs, recipes: Vec<Recipe>, logs: &Path, quiet: bool) -> anyhow::Result<Built> {
    let mut follow = Follow::start(&args.namespace, quiet)?;
    follow.refuse_second_graph(&recipes).await?;
    let mut fleet = Fleet::start(recipes, logs).context("a node could not be started")?;
    output::note(&format!("{} node processes; their messages are in {}", fleet.pids().len(), logs.display()));
    let ended = follow.to_the_end(&mut fleet).await;
    follow.stop(&mut fleet).await;
    Ok(follow.built(ended, &args.mode, args.seed))
}

/// Who records and who guards come first.
fn members(args: &UpArgs, bag: Option<&Path>) -> Vec<Member> {
    // A JSON string is a YAML string: whatever a folder is called.
    let quoted = |path: &Path| serde_json::json!(path.to_string_lossy()).to_string();
    let recorder = bag.map(|bag| Member {
        name: "bag_recorder",
        files: &["bag_recorder.param.yaml"],
        overrides: vec![("bag_dir", quoted(bag)), ("use_sim_time", "true".into())],
    });
    let [supervisor, controller, machine] = FILES;
    let nodes = [
        Member {
            name: supervisor.0,
            files: supervisor.1,
            overrides: vec![("start_mode", args.mode.clone()), ("use_sim_time", "true".into())],
        },
        Member { name: controller.0, files: controller.1, overrides: vec![("use_sim_time", "true".into())] },
        Member {
            name: machine.0,
            files: machine.1,
            overrides: vec![
                ("run.layers", args.layers.to_string()),
                ("run.seed", args.seed.to_string()),
                ("run.speed", format!("{:?}", args.speed)),
            ],
        },
    ];
    recorder.into_iter().chain(nodes).collect()
}

/// How a node is started; its parameters are parsed, so that a mistake is told before anything runs.
fn recipe(args: &UpArgs, config: &ConfigDir, member: &Member) -> anyhow::Result<Recipe> {
    let program = programs::beside(member.name)?;
    let files: Vec<PathBuf> = member.files.iter().map(|file| config.file(file)).collect();
    let overrides: Vec<(String, String)> =
        member.overrides.iter().map(|(name, value)| ((*name).to_owned(), value.clone())).collect();
    let path =
        NodePath { qualified: format!("{}/{}", args.namespace, member.name), base: member.name.to_owned() };
    check(member.name, &Parameters::read(&files, &overrides, &path)?)?;
    let mut arguments: Vec<String> =
        ["--ros-args", "--log-level", "info", "-r", &format!("__ns:={}", args.namespace)]
            .map(str::to_owned)
            .to_vec();
    arguments.extend(files.iter().flat_map(|file| ["--params-file".to_owned(), file.display().to_string()]));
    arguments
        .extend(overrides.iter().flat_map(|(name, value)| ["-p".to_owned(), format!("{name}:={value}")]));
    // A machine that was started again would begin its wall anew.
    Ok(Recipe { name: member.name, program, arguments, replaceable: member.name != "printer_sim" })
}

fn check(name: &str, parameters: &Parameters) -> anyhow::Result<()> {
    match name {
        "safety_supervisor" => _ = parameters.parse::<safety_supervisor::Params>()?,
        "mpc_controller" => {
            let own = parameters.without(&["wire_controller", "wire_process"]);
            _ = own.parse::<mpc_controller::wire::LoopParams>()?;
            _ = parameters.block::<mpc_controller::wire::Params>("wire_controller")?;
        }
        "printer_sim" => _ = printer_sim::load::wall::machine_params(parameters)?,
        _ => {}
    }
    Ok(())
}

/// Folder of the nodes' messages: beside the bag, or among temporary files.
fn logs(bag: Option<&Path>) -> PathBuf {
    let Some(bag) = bag else {
        return std::env::temp_dir().join(format!("fdm_wire_{}", std::process::id()));
    };
    let mut name = bag.file_name().unwrap_or_default().to_os_string();
    name.push("_logs");
    bag.with_file_name(name)
}

/// Parses the parameters of all nodes of a wall, for `fdm doctor`.
///
/// # Errors
/// File, line, field, value and range of what is refused.
pub(crate) fn check_config(config: &ConfigDir) -> anyhow::Result<()> {
    let args = UpArgs {
        layers: 1,
        speed: 1.0,
        seed: 1,
        mode: "act".into(),
        bag: None,
        namespace: "/printer".into(),
        config: None,
        dry_run: true,
        json: None,
    };
    members(&args, None).iter().try_for_each(|member| recipe(&args, config, member).map(drop))
}

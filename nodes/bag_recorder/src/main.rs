//! Entry point.

fn main() -> std::process::ExitCode {
    runtime::run("bag_recorder", bag_recorder::node::run)
}

//! Entry point.

fn main() -> std::process::ExitCode {
    runtime::run("state_estimator", state_estimator::node::run)
}

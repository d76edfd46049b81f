//! Entry point.

fn main() -> std::process::ExitCode {
    runtime::run("advance_predictor", advance_predictor::node::run)
}

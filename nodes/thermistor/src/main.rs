//! Entry point.

fn main() -> std::process::ExitCode {
    runtime::run("thermistor", thermistor::node::run)
}

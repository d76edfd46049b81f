//! Entry point.

fn main() -> std::process::ExitCode {
    runtime::run("printer_bridge", printer_bridge::node::run)
}

//! The node `printer_sim`.

fn main() -> std::process::ExitCode {
    runtime::run("printer_sim", printer_sim::node::run)
}

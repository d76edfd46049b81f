//! Entry point.

fn main() -> std::process::ExitCode {
    runtime::run("safety_supervisor", safety_supervisor::node::run)
}

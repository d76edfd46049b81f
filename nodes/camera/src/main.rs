//! Entry point.

fn main() -> std::process::ExitCode {
    runtime::run("camera", camera::node::run)
}

//! Entry point.

fn main() -> std::process::ExitCode {
    runtime::run("mpc_controller", mpc_controller::node::run)
}

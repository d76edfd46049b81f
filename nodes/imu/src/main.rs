//! Entry point.

fn main() -> std::process::ExitCode {
    runtime::run("imu", imu::node::run)
}

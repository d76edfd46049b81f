//! Entry point.

fn main() -> std::process::ExitCode {
    runtime::run("filament_encoder", filament_encoder::node::run)
}

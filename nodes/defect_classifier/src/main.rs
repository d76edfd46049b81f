//! Entry point.

fn main() -> std::process::ExitCode {
    runtime::run("defect_classifier", defect_classifier::node::run)
}

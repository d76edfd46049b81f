//! The command `fdm`.

fn main() -> std::process::ExitCode {
    cli::main()
}

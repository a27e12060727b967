//! The coordinator as the tests start it.

fn main() -> std::process::ExitCode {
    coordinator::cli::main()
}

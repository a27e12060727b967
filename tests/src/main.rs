//! The coordinator as the tests start it.

fn main() -> std::process::ExitCode {
    terminal::program::run(|| coordinator::cli::main("tidelock-node"))
}

//! Starts and steps a coupled run; see `coordinator --help`.

fn main() -> std::process::ExitCode {
    terminal::program::run(coordinator::cli::main)
}

//! `tidelock` under its former name, with the same options.

fn main() -> std::process::ExitCode {
    terminal::program::run(|| coordinator::cli::main("coordinator"))
}

//! The program of Tidelock, which starts itself as the servers; see `tidelock --help`.

fn main() -> std::process::ExitCode {
    terminal::program::run(|| coordinator::cli::main("tidelock"))
}

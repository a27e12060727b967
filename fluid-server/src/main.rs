//! The fluid server program.

fn main() -> std::process::ExitCode {
    terminal::program::run(|| fluid_server::main_with(std::env::args_os()))
}

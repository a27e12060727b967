//! The fluid server program.

fn main() -> std::process::ExitCode {
    fluid_server::main_with(std::env::args_os())
}

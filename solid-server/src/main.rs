//! The solid server program.

fn main() -> std::process::ExitCode {
    terminal::program::run(|| solid_server::main_with(std::env::args_os()))
}

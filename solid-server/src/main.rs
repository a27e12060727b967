//! The solid server program.

fn main() -> std::process::ExitCode {
    solid_server::main_with(std::env::args_os())
}

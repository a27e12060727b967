//! A solid solver whose process ends in the middle of its run, at the same half-step each time.

use std::process::ExitCode;

use sph::coupling::stage::{Stage, StepStage};
use tests::doubles::{Double, Wrong};

fn main() -> ExitCode {
    let at = StepStage { step: 20, stage: Stage::Corrector };
    terminal::program::run(|| proto::transport::node::main_with(std::env::args_os(), Double(Wrong::Exit(at))))
}

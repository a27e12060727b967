//! What a fluid in parts exchanges and costs: measured, against a model, and a forecast by the model.

use std::process::ExitCode;

use clap::Parser;
use coordinator::case::Case;
use sph::coupling::solver::{PartCount, Role};
use sph::space::AnySpace;
use tests::first_steps::first_steps_of;
use tests::scaling::{Costs, Cube, Exchange, StepTime};

/// Runs a cube of water at rest in some numbers of parts, as threads of this process; compares what they exchange with the model; fits
/// what a particle and a copy cost; and prints a forecast for many parts, one core each.
#[derive(Debug, Parser)]
struct Arguments {
    /// Particles along an edge of the cube.
    #[arg(long, default_value_t = 48)]
    across: u32,
    /// Numbers of parts.
    #[arg(long, value_delimiter = ',', default_values_t = [2, 4, 8])]
    parts: Vec<usize>,
    /// Steps that are measured.
    #[arg(long, default_value_t = 16)]
    steps: u64,
    /// Time of a message between two processes, for the forecast \[s\].
    #[arg(long, default_value_t = 2e-5)]
    message: f64,
    /// Bytes that a process can send in a second, for the forecast.
    #[arg(long, default_value_t = 1e9)]
    bandwidth: f64,
}

/// Steps before the measurement: the lists of the first are thinner.
const WARM_UP: u64 = 8;

/// Numbers of particles and of parts of the forecast.
const PARTICLES: [f64; 4] = [1e6, 1e7, 1e8, 1e9];
const PARTS: [usize; 8] = [8, 16, 32, 64, 128, 256, 512, 1024];

fn main() -> ExitCode {
    terminal::program::run(|| match measure(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            terminal::note(format_args!("error: {message}"));
            ExitCode::FAILURE
        }
    })
}

/// What a run was measured to exchange and to cost in a step.
#[derive(Clone, Copy, Debug)]
struct Measured {
    exchange: Exchange,
    /// CPU time of all parts \[s\].
    seconds: f64,
}

fn measure(arguments: &Arguments) -> Result<(), String> {
    let case = cube(arguments.across)?;
    let cell = cell_over_spacing(&case)?;
    terminal::say("parts  copies      bytes of a step        messages         CPU time");
    terminal::say("       measured    measured    of model   measured  model  of a step");
    let alone = of_parts(&case, 1, arguments.steps)?;
    let particles = f64::from(arguments.across).powi(3);
    // Least squares of the time beyond that of one part, over copies.
    let (mut over, mut square) = (0.0, 0.0);
    for parts in &arguments.parts {
        let cube = Cube { across: f64::from(arguments.across), cell, parts: *parts };
        let model = cube.exchanges().iter().fold(Exchange::default(), sum);
        let Measured { exchange, seconds } = of_parts(&case, *parts, arguments.steps)?;
        terminal::say(format_args!(
            "{parts:>5}  {:>8.0}  {:>10.3e}  {:>8.1} %  {:>9.1}  {:>5.1}  {seconds:.4} s",
            exchange.copies,
            exchange.bytes,
            100.0 * model.bytes / exchange.bytes,
            exchange.messages,
            model.messages,
        ));
        over += (seconds - alone.seconds) * exchange.copies;
        square += exchange.copies * exchange.copies;
    }
    let costs = Costs {
        particle: alone.seconds / particles,
        copy: (over / square).max(0.0),
        message: arguments.message,
        bandwidth: arguments.bandwidth,
    };
    terminal::say(format_args!(
        "\nA particle costs {:.2} us in a step, a copy {:.2} us. Forecast, with {:.0} us for a message and {:.1e} bytes/s:",
        1e6 * costs.particle,
        1e6 * costs.copy,
        1e6 * costs.message,
        costs.bandwidth
    ));
    print_forecast(cell, &costs);
    Ok(())
}

fn print_forecast(cell: f64, costs: &Costs) {
    terminal::say("seconds of a step, and share of the speed that one part times their number would have");
    let header: Vec<_> = PARTICLES.iter().map(|particles| format!("{particles:>16.0e}")).collect();
    terminal::say(format_args!("parts  {}", header.concat()));
    for parts in PARTS {
        let row: Vec<_> = PARTICLES
            .iter()
            .map(|particles| {
                let step = StepTime::of(&Cube { across: particles.cbrt(), cell, parts }, costs).total();
                let ideal = costs.particle * particles / parts as f64;
                format!("{step:>9.4} {:>4.0} %", 100.0 * ideal / step)
            })
            .collect();
        terminal::say(format_args!("{parts:>5}  {}", row.concat()));
    }
}

/// Water at rest in a cube of `across` particles along each edge.
fn cube(across: u32) -> Result<Case, String> {
    let edge = 0.01 * f64::from(across);
    let text = format!(
        "name = \"cube\"\n[domain]\nlower_m = [0.0, 0.0, 0.0]\nupper_m = [{edge}, {edge}, {0}]\n[body_force]\ngravity_m_s2 = [0.0, 0.0, -9.81]\n\
         [time]\nend_time_s = 10.0\nstep = {{ type = \"adaptive\" }}\n[fluid]\nparticle_spacing_m = 0.01\nsound_speed_m_s = 30.0\n\
         rest_density_kg_m3 = 1000.0\n[[fluid.region]]\nname = \"water\"\n\
         shape = {{ type = \"box\", lower_m = [0.0, 0.0, 0.0], upper_m = [{edge}, {edge}, {edge}] }}\n\
         start = {{ type = \"hydrostatic\", surface_m = {edge} }}\n[[wall]]\nname = \"tank\"\ntype = \"container\"\nopen_sides = [\"+z\"]\n",
        1.5 * edge
    );
    let folder = tempfile::tempdir().map_err(|problem| problem.to_string())?;
    let path = folder.path().join("cube.toml");
    std::fs::write(&path, text).map_err(|problem| problem.to_string())?;
    coordinator::run::load(&path).map_err(|failure| failure.to_string())
}

/// Edge of a cell of the lists over the particle spacing.
fn cell_over_spacing(case: &Case) -> Result<f64, String> {
    match case.fluid_setup() {
        Some(AnySpace::Spatial(setup)) => {
            // The skin of water at rest: the thickest.
            Ok(2.0 * setup.parameters.kernel_ratio + 0.15)
        }
        _ => Err("the cube is not in space".into()),
    }
}

/// What all of `parts` exchange and cost in a step.
fn of_parts(case: &Case, parts: usize, steps: u64) -> Result<Measured, String> {
    let run = |steps: u64| -> Result<(Exchange, f64), String> {
        let before = proto::trace::process_cpu();
        let sides = first_steps_of(case, steps, parts)?;
        let seconds = (proto::trace::process_cpu() - before).as_secs_f64();
        let fluid = sides.iter().find(|side| side.role == Role::Fluid);
        let counts = fluid.and_then(|side| side.parts.as_ref()).map_or(&[][..], |parts| &parts.each);
        Ok((counts.iter().map(exchange_of).fold(Exchange::default(), |all, one| sum(all, &one)), seconds))
    };
    let ((start, from), (end, to)) = (run(WARM_UP)?, run(WARM_UP + steps)?);
    let steps = steps as f64;
    Ok(Measured {
        exchange: Exchange {
            messages: (end.messages - start.messages) / steps,
            bytes: (end.bytes - start.bytes) / steps,
            ..end
        },
        seconds: (to - from) / steps,
    })
}

/// All that a part has exchanged.
fn exchange_of(count: &PartCount) -> Exchange {
    // All far below 2^53.
    Exchange {
        particles: count.particles as f64,
        inner: 0.0,
        copies: count.copies as f64,
        messages: count.copy_messages as f64,
        bytes: count.copy_bytes as f64,
    }
}

fn sum(all: Exchange, one: &Exchange) -> Exchange {
    Exchange {
        particles: all.particles + one.particles,
        inner: all.inner + one.inner,
        copies: all.copies + one.copies,
        messages: all.messages + one.messages,
        bytes: all.bytes + one.bytes,
    }
}

//! Made-up input for everything that reads files, frames and command lines: good input, damaged by random of a stated seed.
//!
//! Input number n of seed s is always the same, so that a finding is repeated by its number.

mod restoring;

use std::ffi::OsString;
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use clap::{Parser, ValueEnum};
use coordinator::checkpoint::{Manifest, OutputState, RunCheckpoint, Store, seal};
use coordinator::results::process::Process;
use proto::checkpoint::CheckpointData;
use proto::transport::node::NodeArgs;
use sph::setup::ParticipantSetup;

use crate::bench::Bench;
use crate::random::RandomNumbers;
use crate::source_tree;
use restoring::Kept;

/// An input that takes longer than this hangs: above the slowest good one by far.
const HANGS: Duration = Duration::from_secs(60);

/// Scenes of more particles are not given to solvers, which take memory for each.
const MOST_OPENED: usize = 100_000;

/// What is fed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Target {
    /// Case files, up to the particles of their scenes and what `check` reports of them.
    Cases,
    /// Half-step frames of a partner.
    Frames,
    /// Messages of the control plane.
    Messages,
    /// Manifests, states of both solvers and the coordinator's share of a checkpoint.
    Checkpoints,
    /// A folder with two checkpoints, one file of the newer damaged: it must be found out, and the older used.
    Stores,
    /// States with digests that fit, into solvers that then step.
    Restores,
    /// Command lines of the coordinator and of servers.
    Commands,
}

/// Good input to begin with.
pub struct Seeds {
    inputs: Vec<Vec<u8>>,
    checkpoint: Option<RunCheckpoint>,
    kept: Option<Kept>,
}

/// An input at which something panicked.
#[derive(Clone, Debug)]
pub struct Panic {
    /// Number of the input.
    pub number: u64,
    /// Text of the panic.
    pub text: String,
    /// The input.
    pub input: Vec<u8>,
}

/// What was found.
#[derive(Clone, Debug, Default)]
pub struct Findings {
    /// Inputs that were fed.
    pub inputs: u64,
    /// Inputs that were taken for good.
    pub accepted: u64,
    /// Inputs at which something panicked.
    pub panics: Vec<Panic>,
    /// Longest time for an input.
    pub slowest: Duration,
    /// Number of that input.
    pub slowest_input: u64,
    /// Growth of this process's peak memory \[bytes\].
    pub memory_growth: u64,
}

/// Words that mean something to one of the readers.
const WORDS: [&str; 40] = [
    "-1",
    "0",
    "1e308",
    "-1e308",
    "1e-320",
    "nan",
    "inf",
    "-inf",
    "9223372036854775807",
    "18446744073709551615",
    "1e-9",
    "0.5",
    "true",
    "\"\"",
    "[]",
    "{}",
    "[",
    "]",
    "{",
    "}",
    "\n",
    "=",
    "[[",
    "#",
    "\"",
    "'",
    "\u{e4}",
    "[solid]",
    "[[wall]]",
    "[[probe]]",
    "type = ",
    "name = ",
    "sin(x)^t",
    "((((((((",
    "--",
    "=-",
    "--out",
    "/dev/null",
    "127.0.0.1:0",
    "\0",
];

fn below(random: &mut RandomNumbers, count: usize) -> usize {
    // Counts of bytes and words are far below 2^53.
    ((random.fraction() * count as f64) as usize).min(count.saturating_sub(1))
}

/// A damaged copy of one of `seeds`.
pub fn mutate(random: &mut RandomNumbers, seeds: &[Vec<u8>]) -> Vec<u8> {
    let mut input = seeds[below(random, seeds.len())].clone();
    for _ in 0..=below(random, 5) {
        let at = below(random, input.len() + 1);
        let end = (at + 1 + below(random, 40)).min(input.len());
        match below(random, 9) {
            0 if at < input.len() => input[at] ^= 1 << below(random, 8),
            1 if at < input.len() => input[at] = [0, 1, 0x7f, 0x80, 0xff][below(random, 5)],
            2 => drop(input.drain(at.min(end)..end)),
            3 => {
                let piece = input[at.min(end)..end].repeat(1 + below(random, 20));
                input.splice(at..at, piece);
            }
            4 => {
                let other = &seeds[below(random, seeds.len())];
                let from = below(random, other.len() + 1);
                let to = (from + below(random, 200)).min(other.len());
                input.splice(at..at, other[from..to].iter().copied());
            }
            5 => drop(input.splice(at..at, WORDS[below(random, WORDS.len())].bytes())),
            6 => replace_number(random, &mut input, at),
            // Eight bytes of a number that is none, or is huge.
            7 if at + 8 <= input.len() => {
                let number = [f64::NAN, f64::INFINITY, -1e308, 5e-324, -0.0][below(random, 5)];
                input[at..at + 8].copy_from_slice(&number.to_le_bytes());
            }
            8 => input.truncate(at.max(1)),
            _ => {}
        }
    }
    input
}

/// Replaces the next number of a text at `at`.
fn replace_number(random: &mut RandomNumbers, input: &mut Vec<u8>, at: usize) {
    let digit = |byte: &u8| byte.is_ascii_digit();
    let Some(from) = input[at..].iter().position(digit).map(|k| at + k) else { return };
    let part = |byte: &u8| byte.is_ascii_digit() || b".e+-_".contains(byte);
    let to = input[from..].iter().position(|byte| !part(byte)).map_or(input.len(), |k| from + k);
    input.splice(from..to, WORDS[below(random, 12)].bytes());
}

impl Seeds {
    /// Good input for `target`: the tank, shipped cases, and a run of the tank in `bench` where the target needs one.
    pub fn in_bench(bench: &Bench, target: Target) -> Self {
        let tank = bench.tank("seed.toml", &[]);
        let cases = source_tree::root().join("cases");
        let shipped = ["drifting_body_coarse", "obstacle"].map(|name| cases.join(format!("{name}.toml")));
        let texts: Vec<String> =
            [&tank].into_iter().chain(&shipped).map(|path| std::fs::read_to_string(path).unwrap()).collect();
        if [Target::Checkpoints, Target::Stores, Target::Restores].contains(&target) {
            let arguments = ["--in-process", "--threads", "1", "--checkpoint-every-steps", "40"];
            bench.run(&tank, "seed", &arguments);
        }
        Self::new(target, &texts, &bench.path("seed"))
    }

    /// Good input for `target`: `cases` are texts of cases, `results` a folder with a finished run.
    fn new(target: Target, cases: &[String], results: &Path) -> Self {
        let (mut checkpoint, mut kept) = (None, None);
        let inputs = match target {
            Target::Cases => cases.iter().map(|text| text.clone().into_bytes()).collect(),
            Target::Frames => proto::testing::hostile::frames(),
            Target::Messages => {
                let case = read_case(&cases[0]).expect("the first case is good");
                let fluid = case.fluid_setup().map(ParticipantSetup::Fluid);
                let solid = case.solid_setup().map(ParticipantSetup::Solid);
                fluid.iter().chain(&solid).flat_map(proto::testing::hostile::control).collect()
            }
            Target::Checkpoints => {
                let found = Store::new(results.join("checkpoints")).newest();
                let good = found.checkpoint.expect("the run left a checkpoint");
                let folder = results.join(format!("checkpoints/step_{:012}", good.step));
                let manifest = std::fs::read(folder.join("manifest.json")).unwrap();
                let mut inputs = vec![manifest, good.outputs.to_bytes().unwrap()];
                inputs.extend(good.sides.iter().map(|side| side.data.to_vec()));
                checkpoint = Some(good);
                inputs
            }
            Target::Stores | Target::Restores => {
                let found = kept.insert(Kept::of(results, &cases[0]));
                if target == Target::Stores { found.files() } else { found.states() }
            }
            Target::Commands => [
                "run case.toml --out x --force --threads 2 --window 64 --silence 5 --fluid 127.0.0.1:1 --quiet",
                "resume results/x --until 0.5 --accept-other-build --checkpoint-every-steps 10 --max-restarts 0",
                "check case.toml --picture a.png --resolved",
                "conform 127.0.0.1:7001 --junit x.xml --kind loads --deadline 10",
                "node-fluid --listen 127.0.0.1:0 --threads 2",
                "--listen 127.0.0.1:0 --threads 2 --lease 5 --arithmetic portable --insecure --tls-cert a --tls-key b",
            ]
            .iter()
            .map(|line| line.as_bytes().to_vec())
            .collect(),
        };
        Self { inputs, checkpoint, kept }
    }
}

fn read_case(text: &str) -> Result<coordinator::case::Case, String> {
    let nowhere = |path: &Path| Err(format!("no such file: {}", path.display()));
    coordinator::case::parse(text, "case.toml", Path::new("/nowhere"), &nowhere).map_err(|e| e.to_string())
}

/// Feeds one input; whether it was taken for good.
fn feed(target: Target, seeds: &Seeds, input: &[u8]) -> bool {
    match target {
        Target::Cases => {
            let text = String::from_utf8_lossy(input);
            read_case(&text).is_ok_and(|case| {
                // What `check` and the header of a run show.
                std::hint::black_box(case.summary());
                // What the solvers refuse is a mistake at its key before they see it. Only the step that they state is
                // theirs alone: it depends on bodies that touch.
                if case.particles().iter().sum::<usize>() < MOST_OPENED
                    && let Err(refused) = coordinator::check::open(&case)
                {
                    panic!("accepted, but {refused}");
                }
                case.fluid_setup().is_some() || case.solid_setup().is_some()
            })
        }
        Target::Frames => proto::testing::hostile::read_frame(input).is_ok_and(|taken| taken > 0),
        Target::Messages => proto::testing::hostile::read_control(input) > 0,
        Target::Checkpoints => {
            let text = String::from_utf8_lossy(input);
            let sealed = seal(&text).is_ok_and(|text| Manifest::parse(&text).is_ok());
            let outputs = OutputState::parse(input).is_ok();
            let state = seeds.checkpoint.iter().flat_map(|good| &good.sides).any(|side| {
                // With a digest that fits: what is read behind it is tried, too.
                let sha256 = proto::checkpoint::digest(input);
                CheckpointData { header: side.header.clone(), data: input.to_vec().into(), sha256 }
                    .state()
                    .is_ok()
            });
            sealed | Manifest::parse(&text).is_ok() | outputs | state
        }
        Target::Stores => seeds.kept.as_ref().is_some_and(|kept| kept.find(input)),
        Target::Restores => seeds.kept.as_ref().is_some_and(|kept| kept.take_over(input)),
        Target::Commands => {
            let text = String::from_utf8_lossy(input).into_owned();
            let words: Vec<OsString> =
                std::iter::once("coordinator").chain(text.split(' ')).map(OsString::from).collect();
            coordinator::cli::accepts(&words).is_ok() | NodeArgs::try_parse_from(&words).is_ok()
        }
    }
}

/// Feeds inputs number `first` to `first + count` of `seed` to `target`. A hang ends the process with its number.
pub fn fuzz(target: Target, seeds: &Seeds, seed: u64, first: u64, count: u64) -> Findings {
    fuzz_for(target, seeds, seed, first..first.saturating_add(count), Duration::MAX)
}

/// Feeds the inputs `numbers` of `seed` to `target` until `longest` is over. A hang ends the process with its number.
pub fn fuzz_for(
    target: Target,
    seeds: &Seeds,
    seed: u64,
    numbers: Range<u64>,
    longest: Duration,
) -> Findings {
    let begun = Instant::now();
    let first = numbers.start;
    let watched = Arc::new(AtomicU64::new(first));
    let watchdog = Arc::downgrade(&watched);
    std::thread::spawn(move || {
        let mut last = (u64::MAX, Instant::now());
        while let Some(at) = watchdog.upgrade().map(|at| at.load(Ordering::Relaxed)) {
            if at != last.0 {
                last = (at, Instant::now());
            } else if last.1.elapsed() > HANGS {
                terminal::note(format_args!("input {at} of seed {seed} hangs {target:?}"));
                std::process::exit(1);
            }
            std::thread::sleep(Duration::from_millis(200));
        }
    });
    let memory = || Process::own().peak_memory_bytes.unwrap_or(0);
    let before = memory();
    let mut findings = Findings::default();
    for number in numbers.take_while(|_| begun.elapsed() < longest) {
        watched.store(number, Ordering::Relaxed);
        // Neighbouring numbers must not fall alike: the random are shaken by a product.
        let mut random =
            RandomNumbers::new((seed ^ number.wrapping_mul(0xd134_2543_de82_ef95)).wrapping_add(number));
        let input = mutate(&mut random, &seeds.inputs);
        let started = Instant::now();
        match catch_unwind(AssertUnwindSafe(|| feed(target, seeds, &input))) {
            Ok(accepted) => findings.accepted += u64::from(accepted),
            Err(panic) => {
                let text = panic.downcast_ref::<&str>().map(ToString::to_string);
                let text = text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default();
                findings.panics.push(Panic { number, text, input });
            }
        }
        let took = started.elapsed();
        if took > findings.slowest {
            (findings.slowest, findings.slowest_input) = (took, number);
        }
        findings.inputs += 1;
    }
    findings.memory_growth = memory().saturating_sub(before);
    findings
}

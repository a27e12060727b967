//! What the coupling costs, and whole cases: `cargo bench -p tests`.
//!
//! Words after `--` choose parts whose titles hold them. Exchange is measured with solvers that compute nothing; the
//! cases are run as a user would, each side a process. Seconds of other work on the machine show in the wall times;
//! user seconds, and the ratio to a fixed kernel loop timed before each row, move less.

mod solids;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use coordinator::study::cost;
use serde_json::Value;
use sph::coupling::solver::Role;
use tests::bench::{Bench, text};
use tests::delay::DelayLine;
use tests::doubles::serve;
use tests::idle::Idle;
use tests::nodes::Node;
use tests::validation::template;

const PROGRAM: &str = env!("CARGO_BIN_EXE_tidelock-node");

/// Interface particles of each side.
const INTERFACES: [u32; 3] = [300, 1000, 5000];
/// Delays of the way between the servers.
const DELAYS: [Duration; 4] =
    [Duration::ZERO, Duration::from_micros(200), Duration::from_micros(500), Duration::from_millis(1)];
/// Runs of which the median counts.
const REPEATS: usize = 5;

/// A part: its title and what prints it.
type Part = (&'static str, fn());

const PARTS: [Part; 5] = [
    ("stages of the solids on one thread", solids::print),
    ("exchange of frames between solvers that compute nothing", exchange),
    ("delayed frames in the drifting-body case", delayed),
    ("whole cases", cases),
    ("lock-step at 1e-5 s, whole", lock_step),
];

fn main() {
    machine();
    // cargo hands its own words on, such as --bench.
    let words: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with('-')).collect();
    for (title, print) in PARTS {
        if words.is_empty() || words.iter().any(|word| title.contains(word.as_str())) {
            terminal::say(format_args!("\n{title}"));
            print();
        }
    }
}

fn machine() {
    let processor = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = processor.lines().find_map(|line| line.strip_prefix("model name"));
    let model = model.map_or("unknown processor", |rest| rest.trim_start_matches([' ', '\t', ':']));
    let cores = std::thread::available_parallelism().map_or(0, usize::from);
    let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    let load = load.split(' ').next().unwrap_or("unknown");
    terminal::say(format_args!(
        "{model}, {cores} cores, arithmetic {}, load average {load}",
        sph::lanes::Arithmetic::chosen().name()
    ));
}

fn number(summary: &Value, pointer: &str) -> f64 {
    summary.pointer(pointer).and_then(Value::as_f64).unwrap_or(f64::NAN)
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Wall time of a half-step in which both sides only swap frames, check and book them.
fn exchange() {
    let bench = Bench::new(PROGRAM);
    terminal::say(format_args!("{:>12}{:>18}{:>22}", "particles", "us per half-step", "of it waiting, us"));
    for particles in INTERFACES {
        let idle = |role| serve(Idle { role, particles, own_sums: Duration::ZERO });
        let (fluid, solid) = (idle(Role::Fluid), idle(Role::Solid));
        let [fluid, solid] = [&fluid, &solid].map(|served| served.address.to_string());
        let case = bench.tank_for_idle(0.02);
        let half_steps = |k: usize| {
            let name = format!("exchange_{particles}_{k}");
            let summary = bench.run(&case, &name, &["--fluid", &fluid, "--solid", &solid]);
            let half_steps = 2.0 * number(&summary, "/steps");
            ["step", "waited"]
                .map(|what| 1e6 * number(&summary, &format!("/fluid/{what}_seconds")) / half_steps)
        };
        let measured: Vec<[f64; 2]> = (0..REPEATS).map(half_steps).collect();
        let [all, waited] = [0, 1].map(|k| median(measured.iter().map(|m| m[k]).collect()));
        terminal::say(format_args!("{particles:>12}{all:>18.0}{waited:>22.0}"));
    }
}

/// A case of the repository with values replaced.
fn instance(bench: &Bench, file: &str, changes: &[(&str, toml::Value)]) -> PathBuf {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../cases").join(file);
    let changes: Vec<_> = changes.iter().map(|(place, value)| ((*place).to_owned(), value.clone())).collect();
    let text = template::instantiate(&path, &changes).unwrap_or_else(|reason| panic!("{reason}"));
    bench.write(path.file_name().and_then(|name| name.to_str()).unwrap_or("case.toml"), &text)
}

/// Exposed wait of both sides when each frame is held back on its way.
fn delayed() {
    let bench = Bench::new(PROGRAM);
    let short =
        [("time.end_time_s", 0.02.into()), ("outputs.picture_times_s", toml::Value::Array(Vec::new()))];
    let case = instance(&bench, "drifting_body.toml", &short);
    terminal::say(format_args!(
        "{:>10}{:>16}{:>20}{:>20}",
        "held, ms", "ms per step", "fluid waits, ms", "solid waits, ms"
    ));
    for delay in DELAYS {
        let solid = Node::start(Path::new(PROGRAM), "solid", &[]);
        let target = solid.address.parse().unwrap_or_else(|e| panic!("{e}"));
        let line = DelayLine::start(target, delay);
        let address = line.address.to_string();
        let name = format!("delayed_{}", delay.as_micros());
        let summary = bench.run(&case, &name, &["--solid", &address, "--threads", "1"]);
        let steps = number(&summary, "/steps");
        let per_step = |place: &str| 1e3 * number(&summary, place) / steps;
        terminal::say(format_args!(
            "{:>10.1}{:>16.2}{:>20.3}{:>20.3}",
            1e3 * delay.as_secs_f64(),
            per_step("/fluid/step_seconds"),
            per_step("/fluid/waited_seconds"),
            per_step("/solid/waited_seconds")
        ));
    }
}

/// Whole cases: what a user waits for.
fn cases() {
    let bench = Bench::new(PROGRAM);
    let end: (&str, toml::Value) = ("time.end_time_s", 0.1.into());
    let quiet = [
        ("outputs.snapshot_interval_s", 0.1.into()),
        ("outputs.picture_times_s", toml::Value::Array(Vec::new())),
    ];
    let column: &[(&str, toml::Value)] = &[
        end.clone(),
        quiet[0].clone(),
        quiet[1].clone(),
        ("fluid.particle_spacing_m", 0.002.into()),
        ("fluid.sound_speed_m_s", 23.94.into()),
    ];
    let obstacle: &[(&str, toml::Value)] = &[
        end,
        quiet[0].clone(),
        ("fluid.sound_speed_m_s", 23.94.into()),
        ("solid.body.0.material.young_modulus_pa", 1e6.into()),
    ];
    heading();
    for (name, file, changes, further) in [
        ("dam break, 2 mm, to 0.1 s", "validation/dam_break.toml", column, [].as_slice()),
        ("elastic obstacle, 2 mm, to 0.1 s", "obstacle.toml", obstacle, &[]),
        ("drifting body, 2 mm, to 0.5 s", "drifting_body.toml", &[], &[]),
        ("the same in one process", "drifting_body.toml", &[], &["--in-process"]),
    ] {
        let case = instance(&bench, file, changes);
        for threads in [Some("1"), Some("2"), None] {
            row(&bench, name, &case, threads, further);
        }
    }
}

/// The drifting body with the time step of the source paper, in lock-step.
fn lock_step() {
    let bench = Bench::new(PROGRAM);
    heading();
    let step: &[(&str, toml::Value)] = &[("time.step.time_step_s", 1e-5.into())];
    for (name, file) in [("source paper", "drifting_body_paper.toml"), ("recommended", "drifting_body.toml")]
    {
        row(&bench, name, &instance(&bench, file, step), None, &[]);
    }
}

fn heading() {
    terminal::say(format_args!(
        "{:34}{:>8}{:>9}{:>9}{:>8}{:>10}{:>14}{:>12}{:>12}{:>11}",
        "case",
        "threads",
        "wall, s",
        "user, s",
        "steps",
        "ns/stage",
        "/fixed kernel",
        "fluid waits",
        "solid waits",
        "front, m"
    ));
}

/// Runs `case` with `threads` on each side, or with what the coordinator gives them by itself.
fn row(bench: &Bench, name: &str, case: &Path, threads: Option<&str>, further: &[&str]) {
    let fixed = cost::fixed_kernel();
    let out = bench.path("whole");
    drop(std::fs::remove_dir_all(&out));
    let started = Instant::now();
    let arguments = threads.map_or(further.to_vec(), |threads| [&["--threads", threads], further].concat());
    let threads = threads.unwrap_or("shared");
    let summary = bench.run(case, text(Path::new("whole")), &arguments);
    let wall = started.elapsed().as_secs_f64();
    let cpu: f64 = ["/coordinator/cpu_seconds", "/fluid/process/cpu_seconds", "/solid/process/cpu_seconds"]
        .iter()
        .map(|place| summary.pointer(place).and_then(Value::as_f64).unwrap_or(0.0))
        .sum();
    let particles = ["fluid", "solid"].iter().map(|side| {
        summary.pointer(&format!("/{side}/counts/particles")).and_then(Value::as_f64).unwrap_or(0.0)
    });
    let stages = 2.0 * number(&summary, "/steps") * particles.sum::<f64>();
    let waits = |side: &str| match summary.pointer(&format!("/{side}/waited_share")).and_then(Value::as_f64) {
        Some(share) => format!("{:.1} %", 100.0 * share),
        None => "-".into(),
    };
    let front = tests::bench::probe_rows(&out)[0]
        .iter()
        .find(|(column, _)| column.starts_with("front"))
        .map_or("-".into(), |(_, at)| format!("{at:.4}"));
    terminal::say(format_args!(
        "{name:34}{threads:>8}{wall:>9.2}{cpu:>9.2}{:>8}{:>10.0}{:>14.0}{:>12}{:>12}{front:>11}",
        number(&summary, "/steps"),
        1e9 * cpu / stages,
        cpu / stages / fixed,
        waits("fluid"),
        waits("solid")
    ));
}

//! Cost of the fluid's stage, pass by pass: `cargo bench -p fluid`.
//!
//! Prints CPU nanoseconds per particle on one thread, so that other work on the machine counts little, then the ratio
//! to a fixed kernel loop of the same run, and at the end wall time on two threads over one.

mod scene;
mod table;

use std::hint::black_box;
use std::time::{Duration, Instant};

use criterion::measurement::{Measurement, ValueFormatter};
use criterion::{BenchmarkGroup, BenchmarkId, Criterion, SamplingMode, Throughput};
use fluid::{FluidSolver, FluidSpace};
use rayon::ThreadPool;
use rustix::time::{ClockId, clock_gettime};
use sph::coupling::exchange::StateColumns;
use sph::coupling::solver::Solver;
use sph::coupling::stage::{Stage, StageTime, StepStage};
use sph::kernel::CubicSpline;
use sph::space::{Plane, Spatial};

use scene::Settings;

/// Particles of the blocks.
const SIZES: [usize; 3] = [10_000, 100_000, 1_000_000];

/// Particles of the block on which features are compared.
const FEATURE_PARTICLES: usize = 40_000;

/// A part of a stage.
type Pass<S> = fn(&mut Case<S>);

/// Parts of a step, and the whole step.
const PASSES: [&str; 6] = ["begin", "gradients", "tensors", "forces", "advance", "stage"];

/// Those with the stage that they belong to.
const fn passes<S: FluidSpace>() -> [(&'static str, Stage, Pass<S>); 6] {
    [
        ("begin", Stage::Predictor, Case::begin),
        ("gradients", Stage::Predictor, Case::own),
        ("tensors", Stage::Corrector, Case::own),
        ("forces", Stage::Corrector, Case::cross),
        ("advance", Stage::Corrector, Case::advance),
        ("stage", Stage::Predictor, Case::step),
    ]
}

/// Blocks on which the passes are timed.
const BLOCKS: [(&str, Settings); 2] = [("recommended", scene::RECOMMENDED), ("lean", scene::LEAN)];
/// The same in space.
const CUBES: [(&str, Settings); 2] = [("space", scene::DEFAULT), ("space, lean", scene::LEAN)];

/// Begins of a stage that build lists: in an open box and in a periodic one.
const BUILDS: [(&str, Settings); 2] =
    [("begin", scene::DRIFTING), ("begin, periodic", scene::DRIFTING_PERIODIC)];

/// CPU time of all threads of this process.
struct CpuTime;

fn cpu_nanoseconds() -> u64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    // Neither is negative: the clock starts with the process.
    time.tv_sec.cast_unsigned() * 1_000_000_000 + time.tv_nsec.cast_unsigned()
}

impl Measurement for CpuTime {
    type Intermediate = u64;
    type Value = u64;

    fn start(&self) -> u64 {
        cpu_nanoseconds()
    }

    fn end(&self, start: u64) -> u64 {
        cpu_nanoseconds() - start
    }

    fn add(&self, a: &u64, b: &u64) -> u64 {
        a + b
    }

    fn zero(&self) -> u64 {
        0
    }

    fn to_f64(&self, value: &u64) -> f64 {
        *value as f64
    }

    fn formatter(&self) -> &dyn ValueFormatter {
        &Nanoseconds
    }
}

/// Plain nanoseconds, or nanoseconds per element.
struct Nanoseconds;

impl ValueFormatter for Nanoseconds {
    fn scale_values(&self, _typical: f64, _values: &mut [f64]) -> &'static str {
        "ns"
    }

    fn scale_throughputs(&self, _typical: f64, throughput: &Throughput, values: &mut [f64]) -> &'static str {
        if let Throughput::Elements(elements) = throughput {
            values.iter_mut().for_each(|value| *value /= *elements as f64);
        }
        "ns/element"
    }

    fn scale_for_machines(&self, _values: &mut [f64]) -> &'static str {
        "ns"
    }
}

/// A solver with the half-step that it computes again and again.
struct Case<S: FluidSpace> {
    solver: FluidSolver<S>,
    time: StageTime,
    none: StateColumns,
}

impl<S: FluidSpace> Case<S> {
    fn new(settings: Settings, particles: usize, time_step: f64) -> Self {
        let solver = FluidSolver::new(scene::block::<S>(settings, particles))
            .unwrap_or_else(|errors| panic!("the scene can not be run: {errors:?}"));
        let at = StepStage { step: 0, stage: Stage::Predictor };
        let time = StageTime { at, step_start: 0.0, time_step };
        let mut case = Self { solver, time, none: StateColumns::default() };
        // Lists, and buffers at their size.
        case.begin();
        case.own();
        case.cross();
        case
    }

    fn at(&mut self, stage: Stage) -> &mut Self {
        self.time.at.stage = stage;
        self
    }

    fn begin(&mut self) {
        self.solver.begin_stage(&self.time).unwrap_or_else(|divergence| panic!("{divergence}"));
    }

    fn own(&mut self) {
        self.solver.evaluate_own(&self.time);
    }

    fn cross(&mut self) {
        self.solver.evaluate_cross(&self.time, &self.none, &self.none);
    }

    fn advance(&mut self) {
        let budgets = self.solver.advance(&self.time);
        black_box(budgets.unwrap_or_else(|divergence| panic!("{divergence}")));
    }

    /// Predictor and corrector.
    fn step(&mut self) {
        for stage in Stage::BOTH {
            self.at(stage).begin();
            self.own();
            self.cross();
            self.advance();
        }
    }
}

fn pool(threads: usize) -> ThreadPool {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap_or_else(|error| panic!("{error}"))
}

fn time_passes<S: FluidSpace>(
    criterion: &mut Criterion<CpuTime>,
    pool: &ThreadPool,
    blocks: [(&str, Settings); 2],
) {
    for (name, settings) in blocks {
        let mut group = group(criterion, name);
        for particles in SIZES {
            group.throughput(Throughput::Elements(scene::particles::<S>(particles) as u64));
            // So short a step that no list is rebuilt.
            let mut case = pool.install(|| Case::<S>::new(settings, particles, 1e-12));
            for (pass, stage, run) in passes::<S>() {
                pool.install(|| case.at(stage).begin());
                group.bench_function(BenchmarkId::new(pass, particles), |bencher| {
                    pool.install(|| bencher.iter(|| run(&mut case)));
                });
            }
        }
    }
}

/// The whole stage of the recommended settings with one thing left out or added.
fn features(criterion: &mut Criterion<CpuTime>, pool: &ThreadPool) {
    let mut group = group(criterion, "features");
    group.throughput(Throughput::Elements(FEATURE_PARTICLES as u64));
    for (k, (_, settings)) in scene::FEATURES.into_iter().enumerate() {
        let mut case = pool.install(|| Case::<Plane>::new(settings, FEATURE_PARTICLES, 1e-12));
        group.bench_function(BenchmarkId::new("stage", k), |bencher| {
            pool.install(|| bencher.iter(|| case.step()));
        });
    }
}

/// The begin of a stage whose particles have drifted farther than lists bear: order, lists and records.
fn builds<S: FluidSpace>(criterion: &mut Criterion<CpuTime>, pool: &ThreadPool, name: &str) {
    let mut group = group(criterion, name);
    let cases =
        BUILDS.iter().flat_map(|(name, settings)| SIZES.map(|particles| (name, *settings, particles)));
    for (name, settings, particles) in cases {
        group.throughput(Throughput::Elements(scene::particles::<S>(particles) as u64));
        let mut case =
            pool.install(|| Case::<S>::new(settings, particles, scene::drift_step::<S>(particles)));
        group.bench_function(BenchmarkId::new(*name, particles), |bencher| {
            let mut build = || {
                case.advance();
                let start = cpu_nanoseconds();
                case.begin();
                cpu_nanoseconds() - start
            };
            pool.install(|| bencher.iter_custom(|builds| (0..builds).map(|_| build()).sum()));
        });
    }
}

fn group<'a>(criterion: &'a mut Criterion<CpuTime>, name: &str) -> BenchmarkGroup<'a, CpuTime> {
    let mut group = criterion.benchmark_group(name);
    group.sample_size(10);
    group.sampling_mode(SamplingMode::Flat);
    group.warm_up_time(Duration::from_millis(200));
    group.measurement_time(Duration::from_secs(1));
    group
}

/// Kernel gradients one by one: a measure of the machine that no work on this code changes.
fn fixed_kernel(criterion: &mut Criterion<CpuTime>) {
    let kernel = CubicSpline::<Plane>::new(1.2);
    let distances: Vec<f64> = (0..4096).map(|k| 2.4 * f64::from(k * 1021 % 4096) / 4096.0).collect();
    let mut group = group(criterion, "fixed");
    group.throughput(Throughput::Elements(4096));
    group.bench_function("kernel", |bencher| {
        bencher.iter(|| {
            let sum = |sum, distance: &f64| sum + kernel.gradient_factor(*distance);
            black_box(distances.iter().fold(0.0, sum))
        });
    });
}

/// Wall time per step \[s\], the least of many, on this many threads.
fn least_wall_time<S: FluidSpace>(settings: Settings, particles: usize, threads: usize) -> f64 {
    let pool = pool(threads);
    let mut case = pool.install(|| Case::<S>::new(settings, particles, 1e-12));
    let repeats = (3_000_000 / particles).max(5);
    let time = |case: &mut Case<S>| {
        let start = Instant::now();
        pool.install(|| case.step());
        start.elapsed().as_secs_f64()
    };
    (0..repeats).map(|_| time(&mut case)).fold(f64::INFINITY, f64::min)
}

fn main() {
    table::machine();
    let mut criterion = Criterion::default().with_measurement(CpuTime).configure_from_args();
    let one = pool(1);
    fixed_kernel(&mut criterion);
    time_passes::<Plane>(&mut criterion, &one, BLOCKS);
    time_passes::<Spatial>(&mut criterion, &one, CUBES);
    features(&mut criterion, &one);
    builds::<Plane>(&mut criterion, &one, "build");
    builds::<Spatial>(&mut criterion, &one, "space, build");
    criterion.final_summary();
    table::print();
    for particles in [11_000, 100_000] {
        speed_of_two_threads::<Plane>(scene::RECOMMENDED, particles);
    }
    speed_of_two_threads::<Spatial>(scene::DEFAULT, 100_000);
}

fn speed_of_two_threads<S: FluidSpace>(settings: Settings, particles: usize) {
    let [one, two] = [1, 2].map(|threads| least_wall_time::<S>(settings, particles, threads));
    terminal::say(format_args!(
        "{particles} particles in {} dimensions, wall time of one thread over two: {:.2}",
        S::DIMENSIONS,
        one / two
    ));
}

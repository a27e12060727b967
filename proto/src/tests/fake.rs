//! Small solvers: two rows of masses that repel each other across the interface, and servers that run them.

use std::net::SocketAddr;
use std::time::Duration;

use sph::domain::Domain;
use sph::exchange::{Extent, InterfaceStates};
use sph::ledger::{Energies, InterfaceSums, StageBooks};
use sph::saved::{RestoreError, SavedState};
use sph::setup::{
    BodyForce, BodySetup, BreachAction, ContactLaw, Coupling, CouplingKind, DensityDiffusion,
    ElasticMaterial, FluidConstants, FluidParticles, FluidSetup, Formulation, GradientCorrection,
    InterfaceLaw, Iterate, LedgerPolicy, Outflow, OutputPlan, ParticipantSetup, Relaxation, RunSetup,
    SolidParticles, SolidSetup, SolidStepping, StepPolicy, TimePlan, Unsettled, WallParticles,
};
use sph::solver::{Counts, Divergence, Field, ParticleFields, Role, Solver};
use sph::stage::{Stage, StageTime};
use sph::vector::{SymmetricTensor, Vector};
use tokio_util::sync::CancellationToken;

use crate::client::{Deadlines, ParticipantClient, RunAccess};
use crate::description::{Constants, Description, LinkPlan, Partner};
use crate::service::{Opened, ServeOptions, Server, SetupProblems, SolverFactory};

/// Masses per side.
pub(crate) const MASSES: usize = 40;
/// Distance at which masses repel \[m\].
const RANGE: f64 = 0.2;
/// Stiffness of the repulsion \[N/m²\].
const STIFFNESS: f64 = 3000.0;

/// A short coupled run. Some run ids make the fake solver misbehave: see `Row` and `RowFactory`.
pub(crate) fn run_setup(run_id: &str, steps: u32) -> RunSetup {
    let time_step = 1e-3;
    RunSetup {
        run_id: run_id.into(),
        domain: Domain { lower: Vector::new(-1.0, -1.0), upper: Vector::new(1.0, 1.0), periodic: [false; 2] },
        time: TimePlan {
            start_time: 0.0,
            end_time: f64::from(steps) * time_step,
            step: StepPolicy::Fixed { time_step },
        },
        body_force: BodyForce { gravity: Vector::zeros(), expressions: None },
        outputs: OutputPlan { snapshot_interval: Some(0.01), probe_interval: Some(0.005) },
        // Sums over some hundred pairs round near 1e-15.
        ledger: LedgerPolicy { action: BreachAction::Stop, ..LedgerPolicy::default() },
        coupling: Some(Coupling {
            kind: CouplingKind::States,
            law: InterfaceLaw::Wall,
            fluid: constants(),
            solid_spacing: 0.01,
            repulsion: 0.5,
            margin: 0.05,
            iterate: None,
        }),
    }
}

/// An iterated half-step.
pub(crate) const ITERATE: Iterate = Iterate {
    relaxation: Relaxation::Fixed(0.1 + 0.2),
    tolerance: 1e-7 / 3.0,
    limit: 17,
    unsettled: Unsettled::Accept,
};

pub(crate) fn constants() -> FluidConstants {
    FluidConstants {
        rest_density: 1000.0,
        sound_speed: 20.0,
        exponent: 7.0,
        dynamic_viscosity: 0.0,
        smoothing_length: RANGE / 2.0,
        particle_spacing: 0.01,
        viscosity_a: 0.1,
        viscosity_b: 0.0,
        lambda: 0.01,
        correction: GradientCorrection::LatticeMoment,
    }
}

/// Position and velocity of mass `k` of a row.
fn start(role: Role, k: usize) -> (Vector, Vector) {
    let side = if role == Role::Fluid { -1.0 } else { 1.0 };
    let y = 0.02 * (k as f64 - 0.5 * MASSES as f64) + 0.003 * side;
    // Irregular on purpose: equal terms would hide a wrong order of sums.
    let bend = 1e-3 * ((7 * k) % 5) as f64 / 3.0;
    (Vector::new(side * (0.11 + bend), y), Vector::new(-side * (0.5 + bend), 0.01 * bend))
}

pub(crate) fn fluid_setup(run: RunSetup) -> ParticipantSetup {
    let (position, velocity) = (0..MASSES).map(|k| start(Role::Fluid, k)).unzip();
    ParticipantSetup::Fluid(FluidSetup {
        run,
        constants: constants(),
        diffusion: DensityDiffusion::None,
        damping: None,
        regions: vec!["row".into()],
        walls: Vec::new(),
        particles: FluidParticles {
            id: (0..MASSES as u32).map(|k| 3 * k).collect(),
            region: vec![0; MASSES],
            mass: vec![0.1; MASSES],
            position,
            velocity,
            density: vec![1000.0; MASSES],
        },
        wall_particles: WallParticles::default(),
        probes: Vec::new(),
        outflow: Outflow::default(),
        wall_repulsion: 1.0,
        acoustic_damping: 0.0,
        order: None,
        viscous_form: sph::setup::ViscousForm::Pairwise,
        tension_limit: None,
        scheme: sph::setup::FluidScheme::PredictorCorrector,
        lost_particle_limit: 0,
    })
}

pub(crate) fn solid_setup(run: RunSetup) -> ParticipantSetup {
    let (position, velocity): (Vec<_>, _) = (0..MASSES).map(|k| start(Role::Solid, k)).unzip();
    ParticipantSetup::Solid(SolidSetup {
        run,
        particle_spacing: 0.01,
        bodies: vec![BodySetup {
            name: "row".into(),
            material: ElasticMaterial { density: 1100.0, bulk_modulus: 2e7, shear_modulus: 4e6 },
            formulation: Formulation::Rigid,
            supports: Vec::new(),
            acceleration: None,
            loads: Vec::new(),
        }],
        particles: SolidParticles {
            id: (0..MASSES as u32).collect(),
            body: vec![0; MASSES],
            support: vec![0; MASSES],
            mass: vec![0.3; MASSES],
            reference_position: position.clone(),
            position,
            velocity,
            density: vec![1100.0; MASSES],
            deviatoric_stress: vec![SymmetricTensor::default(); MASSES],
        },
        contact: ContactLaw::Sums,
        walls: Vec::new(),
        wall_particles: WallParticles::default(),
        damping: None,
        stepping: SolidStepping::StageRule,
        probes: Vec::new(),
        lost_particle_limit: 0,
    })
}

pub(crate) fn setup(role: Role, run_id: &str, steps: u32) -> ParticipantSetup {
    match role {
        Role::Fluid => fluid_setup(run_setup(run_id, steps)),
        Role::Solid => solid_setup(run_setup(run_id, steps)),
    }
}

/// The same set-up without a partner.
pub(crate) fn alone(role: Role, run_id: &str, steps: u32) -> ParticipantSetup {
    let run = RunSetup { coupling: None, ..run_setup(run_id, steps) };
    match role {
        Role::Fluid => fluid_setup(run),
        Role::Solid => solid_setup(run),
    }
}

/// A row of masses that the partner's row repels.
pub(crate) struct Row {
    role: Role,
    run_id: String,
    states: InterfaceStates,
    set_version: u64,
    position_start: Vec<Vector>,
    velocity_start: Vec<Vector>,
    force: Vec<Vector>,
    sums: InterfaceSums,
    extent: Extent,
}

impl Row {
    pub(crate) fn new(setup: &ParticipantSetup) -> Self {
        let mut states = InterfaceStates::default();
        match setup {
            ParticipantSetup::Fluid(s) => {
                states.id.clone_from(&s.particles.id);
                states.mass.clone_from(&s.particles.mass);
                states.position.clone_from(&s.particles.position);
                states.velocity.clone_from(&s.particles.velocity);
                states.density.clone_from(&s.particles.density);
            }
            ParticipantSetup::Solid(s) => {
                states.id.clone_from(&s.particles.id);
                states.mass.clone_from(&s.particles.mass);
                states.position.clone_from(&s.particles.position);
                states.velocity.clone_from(&s.particles.velocity);
                states.density.clone_from(&s.particles.density);
            }
        }
        let count = states.id.len();
        states.group = vec![0; count];
        states.pressure = (0..count).map(|k| k as f64).collect();
        let role = match setup {
            ParticipantSetup::Fluid(_) => Role::Fluid,
            ParticipantSetup::Solid(_) => Role::Solid,
        };
        let mut row = Self {
            role,
            run_id: setup.run().run_id.clone(),
            position_start: states.position.clone(),
            velocity_start: states.velocity.clone(),
            force: vec![Vector::zeros(); count],
            states,
            set_version: 1,
            sums: InterfaceSums::default(),
            extent: Extent::default(),
        };
        row.update_extent();
        row
    }

    fn update_extent(&mut self) {
        let inside = self
            .extent
            .boxes
            .iter()
            .any(|(lower, upper)| self.states.position.iter().all(|x| *x >= *lower && *x <= *upper));
        if inside {
            return;
        }
        let first = self.states.position[0];
        let slack = Vector::repeat(0.01);
        let lower = self.states.position.iter().fold(first, |a, b| a.inf(b)) - slack;
        let upper = self.states.position.iter().fold(first, |a, b| a.sup(b)) + slack;
        self.extent = Extent { version: self.extent.version + 1, boxes: vec![(lower, upper)] };
    }

    fn momentum(&self, velocities: &[Vector]) -> (Vector, f64) {
        let terms = || velocities.iter().zip(&self.states.mass).map(|(v, m)| v * *m);
        (terms().sum(), terms().map(|p| p.norm()).sum())
    }
}

/// Force on a fluid mass by a solid mass, x_fs apart.
fn repulsion(x_fs: &Vector) -> Option<Vector> {
    let distance = x_fs.norm();
    (distance < RANGE).then(|| x_fs * (STIFFNESS * (RANGE - distance).powi(2) / distance))
}

impl Solver for Row {
    fn role(&self) -> Role {
        self.role
    }

    fn begin_stage(&mut self, time: &StageTime) -> Result<(), Divergence> {
        assert!(!(self.run_id == "panic" && time.at.step == 3), "seeded panic");
        if self.run_id == "diverge" && time.at.step == 3 {
            return Err(Divergence {
                at: time.at,
                particle: Some(6),
                position: Some([0.0, 1.0]),
                quantity: "speed [m/s]".into(),
                value: f64::NAN,
                allowed: "finite".into(),
                hint: "seeded by a test".into(),
            });
        }
        if self.run_id == "slow" {
            std::thread::sleep(Duration::from_millis(20));
        }
        if time.at.stage == Stage::Predictor {
            self.position_start.clone_from(&self.states.position);
            self.velocity_start.clone_from(&self.states.velocity);
            // A new version of the same set: the wire must carry it again.
            self.set_version = 1 + time.at.step / 5;
        }
        self.update_extent();
        Ok(())
    }

    fn time_step_limit(&self) -> f64 {
        match self.role {
            Role::Fluid => 2e-3,
            Role::Solid => f64::INFINITY,
        }
    }

    fn extent(&self) -> &Extent {
        &self.extent
    }

    fn interface(&mut self, _: &Extent, _: f64, states: &mut InterfaceStates) -> u64 {
        states.clone_from(&self.states);
        self.set_version
    }

    fn covered_by(&self, _: &Extent, _: f64) -> Result<(), f64> {
        Ok(())
    }

    fn evaluate_own(&mut self, _: &StageTime) {}

    fn evaluate_cross(&mut self, _: &StageTime, own: &InterfaceStates, partner: &InterfaceStates) {
        self.sums = InterfaceSums::default();
        self.force.fill(Vector::zeros());
        for i in 0..own.len() {
            for j in 0..partner.len() {
                let (sign, x_fs) = match self.role {
                    Role::Fluid => (1.0, own.position[i] - partner.position[j]),
                    Role::Solid => (-1.0, partner.position[j] - own.position[i]),
                };
                if let Some(force) = repulsion(&x_fs).map(|force| force * sign) {
                    self.force[i] += force;
                    let sums = &mut self.sums;
                    sums.force += force;
                    sums.gross_force += force.norm();
                    sums.torque += sph::vector::cross(&own.position[i], &force);
                    sums.gross_torque += own.position[i].norm() * force.norm();
                    sums.power += force.dot(&own.velocity[i]);
                    sums.pairs += 1;
                }
            }
        }
    }

    fn advance(&mut self, time: &StageTime) -> Result<StageBooks, Divergence> {
        let duration = time.duration();
        let (before, gross_before) = self.momentum(&self.velocity_start);
        for k in 0..self.states.len() {
            let velocity = self.states.velocity[k];
            self.states.position[k] = self.position_start[k] + velocity * duration;
            self.states.velocity[k] =
                self.velocity_start[k] + self.force[k] * (duration / self.states.mass[k]);
        }
        let (after, gross_after) = self.momentum(&self.states.velocity);
        Ok(StageBooks {
            interface: self.sums,
            duration,
            momentum_change: after - before,
            gross_momentum: gross_before + gross_after,
            ..StageBooks::default()
        })
    }

    fn end_step(&mut self, _: &StageTime) -> Result<(), Divergence> {
        Ok(())
    }

    fn energies(&self) -> Energies {
        Energies::default()
    }

    fn probes(&self, time: f64, values: &mut Vec<f64>) {
        values.extend([time, f64::NAN, self.states.position[0].x]);
    }

    fn snapshot(&self, step: u64, time: f64) -> ParticleFields {
        let field = |name: &str, unit: &str, values: &[Vector]| Field {
            name: name.into(),
            unit: unit.into(),
            components: 2,
            values: values.iter().flat_map(|v| [v.x, v.y]).collect(),
        };
        ParticleFields {
            step,
            time,
            id: self.states.id.clone(),
            group: self.states.group.clone(),
            group_names: vec!["row".into()],
            fields: vec![
                field("position", "m", &self.states.position),
                field("velocity", "m/s", &self.states.velocity),
            ],
        }
    }

    fn counts(&self) -> Counts {
        Counts { particles: MASSES as u64, ..Counts::default() }
    }

    fn save(&self, state: &mut SavedState) {
        state.put_vectors("position", &self.states.position);
        state.put_vectors("velocity", &self.states.velocity);
    }

    fn restore(&mut self, state: &SavedState) -> Result<(), RestoreError> {
        self.states.position = state.vectors("position", MASSES)?;
        self.states.velocity = state.vectors("velocity", MASSES)?;
        self.update_extent();
        Ok(())
    }
}

/// Makes rows.
pub(crate) struct RowFactory(pub Role);

impl SolverFactory for RowFactory {
    fn describe(&self) -> Description {
        Description::of_solver("row", "0.0.1", self.0, "f64 scalar")
    }

    fn open(&self, setup: ParticipantSetup) -> Result<Opened, SetupProblems> {
        let problems = match setup.run().run_id.as_str() {
            "bad" => vec!["first problem".into(), "second problem".into()],
            "open-panic" => panic!("seeded panic in open"),
            "open-slow" => {
                std::thread::sleep(Duration::from_millis(300));
                Vec::new()
            }
            _ => Vec::new(),
        };
        if !problems.is_empty() {
            return Err(SetupProblems(problems));
        }
        let constants = Constants::of(setup.run());
        Ok(Opened { solver: Box::new(Row::new(&setup)), constants, facts: Vec::new() })
    }
}

/// A server in this process, ended by [`TestServer::end`] or when dropped.
pub(crate) struct TestServer {
    pub(crate) address: SocketAddr,
    stop: CancellationToken,
    serving: tokio::task::JoinHandle<()>,
}

impl TestServer {
    pub(crate) fn start(role: Role) -> Self {
        Self::with_options(role, ServeOptions { threads: 2, ..ServeOptions::default() })
    }

    pub(crate) fn with_options(role: Role, options: ServeOptions) -> Self {
        let server = Server::bind("127.0.0.1:0".parse().unwrap()).unwrap();
        let address = server.address();
        let stop = CancellationToken::new();
        let stopped = stop.clone();
        let serving = tokio::spawn(async move {
            server.serve(RowFactory(role), options, stopped.cancelled()).await.unwrap();
        });
        Self { address, stop, serving }
    }

    pub(crate) async fn client(&self) -> ParticipantClient {
        ParticipantClient::connect(&self.address.to_string(), Deadlines::default()).await.unwrap()
    }

    /// Asks the server to end and waits for it.
    pub(crate) async fn end(mut self) {
        self.stop.cancel();
        (&mut self.serving).await.unwrap();
    }
}

impl Drop for TestServer {
    fn drop(&mut self) {
        self.stop.cancel();
    }
}

/// Both servers with an opened and linked run.
pub(crate) struct Pair {
    pub(crate) servers: [TestServer; 2],
    pub(crate) fluid: ParticipantClient,
    pub(crate) solid: ParticipantClient,
}

impl Pair {
    pub(crate) async fn linked(run_id: &str, steps: u32) -> Self {
        let servers = [TestServer::start(Role::Fluid), TestServer::start(Role::Solid)];
        let mut fluid = servers[0].client().await;
        let mut solid = servers[1].client().await;
        link(&mut fluid, &mut solid, run_id, steps).await;
        Self { servers, fluid, solid }
    }
}

/// Opens and links a run on two servers.
pub(crate) async fn link(
    fluid: &mut ParticipantClient,
    solid: &mut ParticipantClient,
    run_id: &str,
    steps: u32,
) {
    let access = RunAccess::new("a test").unwrap();
    let f = fluid.open(&setup(Role::Fluid, run_id, steps), &access).await.unwrap();
    let s = solid.open(&setup(Role::Solid, run_id, steps), &access).await.unwrap();
    assert_eq!(crate::handshake::mismatches(&f, &s), Vec::<String>::new());
    let first_limit = f.time_step_limit.min(s.time_step_limit);
    let plan = |partner_extent: &Extent, partner| LinkPlan {
        first_limit,
        partner_extent: partner_extent.clone(),
        partner,
    };
    solid.link(&plan(&f.extent, Partner::Listen)).await.unwrap();
    fluid.link(&plan(&s.extent, Partner::Dial(solid.address().into()))).await.unwrap();
}

/// Waits until `client` can open and close a run again: the server is free and whole.
pub(crate) async fn assert_usable(client: &mut ParticipantClient, role: Role) {
    let access = RunAccess::new("the next").unwrap();
    let deadline = tokio::time::Instant::now() + Duration::from_secs(10);
    loop {
        match client.open(&alone(role, "next", 1), &access).await {
            Ok(_) => break,
            Err(error) if tokio::time::Instant::now() > deadline => panic!("server is not usable: {error}"),
            Err(_) => tokio::time::sleep(Duration::from_millis(20)).await,
        }
    }
    client.close().await.unwrap();
}

/// Fails instead of hanging.
pub(crate) async fn soon<T>(what: &str, future: impl Future<Output = T>) -> T {
    match tokio::time::timeout(Duration::from_secs(20), future).await {
        Ok(value) => value,
        Err(_) => panic!("{what} hangs"),
    }
}

//! Values of the fluid's probes.

use std::cell::OnceCell;
use std::ops::AddAssign;
use std::sync::Arc;

use sph::coupling::ledger::Energies;
use sph::neighbours::largest_body;
use sph::setup::FluidProbeKind;
use sph::space::Space;
use sph::space::components::Components;
use sph::space::tensors::{SpaceSymmetric, SpaceTensor, SpaceVector};
use sph::sums::{Numbers, ordered_sum};

use crate::system::model::{FluidModel, Parallelogram, Probe, Segment};
use crate::system::state::FluidState;
use crate::system::tasks::sum_over_particles;
use crate::system::walls::place;

sph::constants! {
    const LINK_LENGTH: f64 = 1.5, "probes.link_length",
        "distance below which particles belong to one connected body of fluid, in spacings [-]";
    const FRONT_PERCENTILE: f64 = 0.995, "probes.front_percentile",
        "share of the connected fluid that lies behind the reported front [-]";
    /// Half of it is left at a surface, and at the face of a solid; disorder takes a little more.
    const WET_SHARE: f64 = 0.4, "probes.wet_share",
        "share of fluid in the space that walls leave around a point, from which on the point counts as wet [-]";
    /// Errors of the integral below 0.1 %.
    const FLUX_INTERVALS: u32 = 32, "probes.flux_intervals",
        "intervals of the midpoint rule across the support of a particle in a flow rate [-]";
}

/// For each wall whether a probe of `model` reads the force on it.
pub fn walls_with_forces<S: Space>(model: &FluidModel<S>) -> Vec<bool> {
    let mut read = vec![false; model.walls.names.len()];
    for probe in &model.probes {
        if let Probe::Plain(FluidProbeKind::WallForce(wall)) = probe {
            read[*wall as usize] = true;
        }
    }
    read
}

/// Values of `model`'s probes at `time` \[s\]; `forces` are those on the walls \[N/m\] where they are needed, `immersed` is the number of
/// particles inside solids.
pub fn values<S: Space>(
    model: &FluidModel<S>,
    state: &FluidState<S>,
    time: f64,
    forces: &[S::Vector],
    immersed: u32,
    values: &mut Vec<f64>,
) {
    let connected = OnceCell::new();
    let link = LINK_LENGTH * model.constants.particle_spacing;
    let connected = || connected.get_or_init(|| largest_body(&model.domain, &state.position, link));
    let walls = OnceCell::new();
    let walls = || walls.get_or_init(|| ActingWalls::new(model, time));
    for probe in &model.probes {
        match probe {
            Probe::Point(x) => point(model, state, walls(), time, x, values),
            Probe::FlowRate(segment) => values.push(flow_rate(model, state, segment)),
            // Prepared as probes of their own when the model is built.
            Probe::SurfaceFlux(surface) => values.push(surface_flux(model, state, surface)),
            Probe::Plain(
                FluidProbeKind::Point(_) | FluidProbeKind::FlowRate(..) | FluidProbeKind::SurfaceFlux(..),
            ) => {}
            Probe::Plain(FluidProbeKind::WaterLevel(x)) => {
                let mut place = S::Vector::zeros();
                place[0] = *x;
                values.push(surface_along(model, state, connected(), &place, S::DIMENSIONS - 1))
            }
            Probe::Plain(FluidProbeKind::Gauge(place, axis)) => {
                values.push(surface_along(model, state, connected(), place, *axis as usize))
            }
            Probe::Plain(FluidProbeKind::Front) => values.push(front(state, connected())),
            Probe::Plain(FluidProbeKind::Region(region)) => {
                let sums = region_sums(model, state, *region);
                with_second_moments(state, *region, sums).write(values);
            }
            Probe::Plain(FluidProbeKind::WallForce(wall)) => {
                values.extend_from_slice(forces[*wall as usize].row().as_ref())
            }
            Probe::Plain(FluidProbeKind::Immersed) => values.push(f64::from(immersed)),
        }
    }
}

/// Wall particles that act at a time.
struct ActingWalls<S: Space> {
    /// Where they are \[m\].
    position: Arc<Vec<S::Vector>>,
    /// Time \[s\].
    time: f64,
}

impl<S: Space> ActingWalls<S> {
    fn new(model: &FluidModel<S>, time: f64) -> Self {
        let mut position = Arc::default();
        place(&mut position, &model.walls, &model.domain, time);
        Self { position, time }
    }

    /// Share of the support of `x` that they fill \[-\].
    fn share(&self, model: &FluidModel<S>, x: &S::Vector) -> f64 {
        let walls = &model.walls;
        let volume = walls.mass / model.constants.rest_density;
        let weight = |(x_w, wall): (&S::Vector, &u32)| {
            let distance = model.domain.separation(x, x_w).norm();
            let near = distance < model.kernel.support_radius() && walls.acts(*wall, self.time);
            if near { volume * model.kernel.value(distance) } else { 0.0 }
        };
        self.position.iter().zip(&walls.wall).map(weight).sum()
    }
}

/// Pressure and velocity at `x` at `time` \[s\]; zero where no fluid is within support.
///
/// ```text
/// p(x) = c Σ w_j [p_j + ρ_j f·(x − x_j)] / Σ w_j,   v(x) = Σ w_j v_j / Σ w_j,   w_j = V_j W(|x − x_j|)
/// ```
/// But for c the pressure is that of a wall particle at rest, Eq. (28). Next to a wall the fluid lies to one side, and the mean
/// of p_j alone is the pressure farther in. A linear fit is exact there without the body force f, but doubles what scatters
/// between neighbours.
///
/// c = min(1, Σ w_j / (0.4 (1 − Σ_w V_w W))), with the second sum over walls: a point two spacings above the water does not read
/// the pressure of the drop that comes nearest.
fn point<S: Space>(
    model: &FluidModel<S>,
    state: &FluidState<S>,
    walls: &ActingWalls<S>,
    time: f64,
    x: &S::Vector,
    values: &mut Vec<f64>,
) {
    let force = model.body_force.at(time).acceleration(x);
    let (mut weight, mut pressure, mut velocity) = (0.0, 0.0, S::Vector::zeros());
    for (i, x_i) in state.position.iter().enumerate() {
        let d = model.domain.separation(x, x_i);
        let distance = d.norm();
        if distance < model.kernel.support_radius() {
            let share = state.mass[i] / state.density[i] * model.kernel.value(distance);
            weight += share;
            pressure +=
                (state.pressure(&model.equation_of_state, i) + state.density[i] * force.dot(&d)) * share;
            velocity += state.velocity[i] * share;
        }
    }
    if weight > 0.0 {
        let left = (1.0 - walls.share(model, x)).max(0.0);
        pressure /= weight.max(WET_SHARE * left);
        velocity = velocity / weight;
    }
    values.push(pressure);
    values.extend_from_slice(velocity.row().as_ref());
}

/// Volume flux per depth through `segment` \[m²/s\].
///
/// ```text
/// Q = Σ V_j v_j·n ∫ W(|x(s) − x_j|) ds
/// ```
fn flow_rate<S: Space>(model: &FluidModel<S>, state: &FluidState<S>, segment: &Segment<S>) -> f64 {
    let (Segment { middle, along, normal, length }, support) = (*segment, model.kernel.support_radius());
    let flux = |i: usize| {
        let offset = model.domain.separation(&state.position[i], &middle);
        let (s, distance) = (offset.dot(&along) + 0.5 * length, offset.dot(&normal).abs());
        let half = (support * support - distance * distance).max(0.0).sqrt();
        let (start, end) = ((s - half).max(0.0), (s + half).min(length));
        if end <= start {
            return 0.0;
        }
        let step = (end - start) / f64::from(FLUX_INTERVALS);
        let kernel = |k: u32| model.kernel.value((start + (f64::from(k) + 0.5) * step - s).hypot(distance));
        let integral = (0..FLUX_INTERVALS).map(kernel).sum::<f64>() * step;
        state.mass[i] / state.density[i] * state.velocity[i].dot(&normal) * integral
    };
    ordered_sum(state.len(), flux)
}

/// Volume flux through the parallelogram `surface` \[m³/s\].
///
/// ```text
/// Q = Σ V_j v_j·n ∫ W(|x − x_j|) dA
/// ```
fn surface_flux<S: Space>(model: &FluidModel<S>, state: &FluidState<S>, surface: &Parallelogram<S>) -> f64 {
    let (Parallelogram { corner, edges, gradients, normal, area }, kernel) = (*surface, &model.kernel);
    let support = kernel.support_radius();
    let flux = |i: usize| {
        let offset = model.domain.separation(&state.position[i], &corner);
        let distance = offset.dot(&normal);
        let half = (support * support - distance * distance).max(0.0).sqrt();
        // Of the square around the support's disc, in coordinates along the edges, what is inside.
        let ranges = gradients.map(|gradient| {
            let (middle, reach) = (offset.dot(&gradient), half * gradient.norm());
            (middle - reach).max(0.0)..(middle + reach).min(1.0)
        });
        if half == 0.0 || ranges.iter().any(|range| range.is_empty()) {
            return 0.0;
        }
        let steps = ranges.each_ref().map(|range| (range.end - range.start) / f64::from(FLUX_INTERVALS));
        let place = |axis: usize, k: u32| ranges[axis].start + (f64::from(k) + 0.5) * steps[axis];
        let mut integral = 0.0;
        for j in 0..FLUX_INTERVALS {
            let from_row = offset - edges[0] * place(0, j);
            integral += (0..FLUX_INTERVALS)
                .map(|k| kernel.value((from_row - edges[1] * place(1, k)).norm()))
                .sum::<f64>();
        }
        let share = integral * steps[0] * steps[1] * area;
        state.mass[i] / state.density[i] * state.velocity[i].dot(&normal) * share
    };
    ordered_sum(state.len(), flux)
}

/// Farthest place against gravity, along `axis`, of the connected fluid within a spacing of the line along it through
/// `place`, with half a spacing added; not a number where that is dry.
fn surface_along<S: Space>(
    model: &FluidModel<S>,
    state: &FluidState<S>,
    connected: &[u32],
    place: &S::Vector,
    axis: usize,
) -> f64 {
    let spacing = model.constants.particle_spacing;
    let near = |i: &&u32| {
        let offset = model.domain.separation(place, &state.position[**i as usize]);
        (0..S::DIMENSIONS).filter(|other| *other != axis).all(|other| offset[other].abs() <= spacing)
    };
    let up = if model.body_force.gravity()[axis] > 0.0 { -1.0 } else { 1.0 };
    let height = |i: &u32| up * state.position[*i as usize][axis];
    let highest = connected.iter().filter(near).map(height).reduce(f64::max);
    highest.map_or(f64::NAN, |height| up * (height + 0.5 * spacing))
}

/// 99.5 percentile (nearest rank) of x of the connected fluid; not a number without fluid.
fn front<S: Space>(state: &FluidState<S>, connected: &[u32]) -> f64 {
    let mut x: Vec<f64> = connected.iter().map(|i| state.position[*i as usize][0]).collect();
    x.sort_unstable_by(f64::total_cmp);
    // Rank from 1; exact for any count far below 2^53.
    let rank = (FRONT_PERCENTILE * x.len() as f64).ceil() as usize;
    x.get(rank.saturating_sub(1)).copied().unwrap_or(f64::NAN)
}

/// Sums over the particles of a region or of all fluid.
#[derive(Clone, Copy, Debug, Default)]
pub struct RegionSums<S: Space> {
    /// Mass \[kg\], in the plane per depth, as all that follows.
    mass: f64,
    /// Σ m x \[kg m\].
    first_moment: S::Vector,
    /// Σ m v \[kg m/s\].
    momentum: S::Vector,
    /// Σ m x × v about the centre of the domain \[kg m²/s\].
    angular_momentum: S::Spin,
    /// Energies; the potential one is zero at the origin of coordinates.
    energies: Energies,
    /// Σ m (x − c)(x − c)/Σ m about the centre of mass c \[m²\].
    second_moment: S::SymmetricTensor,
}

impl<S: Space> AddAssign for RegionSums<S> {
    fn add_assign(&mut self, other: Self) {
        self.mass += other.mass;
        self.first_moment += other.first_moment;
        self.momentum += other.momentum;
        self.angular_momentum += other.angular_momentum;
        self.energies += other.energies;
        self.second_moment = self.second_moment.plus(&other.second_moment);
    }
}

/// Energies as numbers to be added.
#[derive(Clone, Copy, Debug, Default)]
struct EnergyTerms(Energies);

impl Numbers for EnergyTerms {
    fn each(&mut self, visit: &mut dyn FnMut(&mut f64)) {
        let Energies { kinetic, potential, internal, relaxation } = &mut self.0;
        [kinetic, potential, internal, relaxation].into_iter().for_each(visit);
    }
}

/// Energies of the fluid of all parts as the energy budget takes them: gravity counts where it has a potential.
pub fn energies<S: Space>(model: &FluidModel<S>, state: &FluidState<S>) -> Energies {
    let terms = |i| EnergyTerms(energies_of(model, state, &model.falling, i));
    sum_over_particles(&model.team, state.len(), EnergyTerms::default(), terms).0
}

/// Energies of particle `i`.
#[inline(always)]
pub fn energies_of<S: Space>(
    model: &FluidModel<S>,
    state: &FluidState<S>,
    gravity: &S::Vector,
    i: usize,
) -> Energies {
    let (mass, density) = (state.mass[i], state.density[i]);
    let internal = mass * model.equation_of_state.compression_energy(density);
    let relaxation = match (&model.acoustic_relaxation, state.relaxation.get(i)) {
        (Some(law), Some(q)) => law.stored_energy(*q, mass, density),
        _ => 0.0,
    };
    Energies {
        kinetic: 0.5 * mass * state.velocity[i].norm_squared(),
        potential: -mass * gravity.dot(&state.position[i]),
        internal,
        relaxation,
    }
}

/// Sums over the particles of `region`, or of all fluid for `None`; positions count as they are, unwrapped.
///
/// Leaves the second moments out.
pub fn region_sums<S: Space>(
    model: &FluidModel<S>,
    state: &FluidState<S>,
    region: Option<u32>,
) -> RegionSums<S> {
    let (origin, gravity) = (model.domain.torque_origin(), model.body_force.gravity());
    ordered_sum(state.len(), |i| {
        if region.is_some_and(|region| state.region[i] != region) {
            return RegionSums::default();
        }
        let (m, x, v) = (state.mass[i], state.position[i], state.velocity[i]);
        RegionSums {
            mass: m,
            first_moment: x * m,
            momentum: v * m,
            angular_momentum: S::cross(&(x - origin), &v) * m,
            energies: energies_of(model, state, &gravity, i),
            second_moment: S::SymmetricTensor::default(),
        }
    })
}

/// Adds the second moments about the centre of mass to `sums` over `region`.
///
/// A sum of its own: the difference of Σ m x² and M c² would lose the small spread of a far-off body.
fn with_second_moments<S: Space>(
    state: &FluidState<S>,
    region: Option<u32>,
    sums: RegionSums<S>,
) -> RegionSums<S> {
    let centre = sums.first_moment / sums.mass;
    let spread: RegionSums<S> = ordered_sum(state.len(), |i| {
        if region.is_some_and(|region| state.region[i] != region) {
            return RegionSums::default();
        }
        let (share, d) = (state.mass[i] / sums.mass, state.position[i] - centre);
        let second_moment = S::SymmetricTensor::of(&S::Tensor::outer(&d, &d)).scaled(share);
        RegionSums { second_moment, ..RegionSums::default() }
    });
    RegionSums { second_moment: spread.second_moment, ..sums }
}

impl<S: Space> RegionSums<S> {
    /// Appends the values in the order of [`ProbeKind::columns`](sph::setup::ProbeKind::columns); centre and moments
    /// are not numbers without mass.
    fn write(&self, values: &mut Vec<f64>) {
        let centre = self.first_moment / self.mass;
        let spread = self.second_moment.scaled(if self.mass > 0.0 { 1.0 } else { f64::NAN });
        values.push(self.mass);
        values.extend_from_slice(self.momentum.row().as_ref());
        values.extend_from_slice(self.angular_momentum.row().as_ref());
        values.extend([self.energies.kinetic, self.energies.potential]);
        values.extend([self.energies.internal + self.energies.relaxation]);
        values.extend_from_slice(centre.row().as_ref());
        values.extend_from_slice(spread.row().as_ref());
    }
}

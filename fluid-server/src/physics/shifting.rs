//! Control of the particles' order: shifting away from crowded places, and pair repulsion where pressure is negative.
//!
//! Both need the concentration gradient Σ V_j ∇W and where the free surface is; one pass over the neighbours makes
//! them, only when the case names either.
//!
//! - Shifting (Lind et al. 2012; Sun et al. 2017, 2019) moves positions. A particle that is shifted by δu takes the
//!   velocity of the fluid where it comes to: dv/dt gains δu·∇v, which stands in the ledger under the stabilisers.
//! - Tensile control (Sun et al. 2018) replaces p_i + p_j by p_j − p_i where p_i is negative, inside the fluid. It is
//!   not antisymmetric: its force stands in the ledger under the stabilisers.

use rayon::prelude::*;
use sph::neighbours::NeighbourList;
use sph::setup::OrderControl;
use sph::vector::Vector;

use super::lanes::{LANES, Lanes};
use super::lists::Lists;
use super::model::FluidModel;
use super::pair::{Batch, Geometry, Matrix, Record, Symmetric, for_each_batch};
use super::rates::{Rates, TASK};

/// Smallest eigenvalue of the moment matrix below which a particle lies at the free surface (Marrone et al. 2010).
const SURFACE: f64 = 0.75;

/// Below this eigenvalue a particle is spray: it has too few neighbours for a shift to mean anything.
const SPRAY: f64 = 0.3;

/// R and n of the anti-pairing term R (W/W(Δx))ⁿ (Monaghan 2000).
const PAIRING: f64 = 0.2;

/// Sums over the neighbours of one particle.
#[derive(Clone, Copy, Debug, Default)]
pub struct OrderSums {
    /// Σ V_j (x_j − x_i) ⊗ ∇W \[-\].
    moment: Symmetric,
    /// Σ V_j ∇W \[1/m\].
    concentration: [f64; 2],
    /// Σ V_j R (W/W(Δx))⁴ ∇W \[1/m\].
    pairing: [f64; 2],
    /// Σ V_j (v_j − v_i) ⊗ ∇W \[1/s\].
    velocity: Matrix,
    /// Largest |v_ij|² of the fluid near by, fading out between h and 2h \[m²/s²\].
    square_speed: f64,
}

/// What follows for one particle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Control {
    /// Velocity by which the position is shifted \[m/s\].
    pub shift: Vector,
    /// Acceleration by the tensile control and by the shift through a velocity gradient \[m/s²\].
    pub acceleration: Vector,
}

/// Results of the pass; empty where the case names no control.
#[derive(Debug, Default)]
pub struct Order {
    /// Sums over own particles and walls, then over a partner's.
    pub sums: Vec<OrderSums>,
    /// Smallest eigenvalue of each particle's moment matrix.
    eigenvalue: Vec<f64>,
    /// Whether each particle lies at the free surface.
    surface: Vec<bool>,
    control: Vec<Control>,
}

/// The kernel beside its gradient, for W/W(Δx).
#[derive(Clone, Copy, Debug)]
struct Ratio {
    inverse_h: f64,
    /// 1 over (2−s)³/4 − (1−s)³ at s = Δx/h.
    norm: f64,
}

impl Ratio {
    fn new(model: &FluidModel) -> Self {
        let c = &model.constants;
        let s = c.particle_spacing / c.smoothing_length;
        let value = 0.25 * (2.0 - s).max(0.0).powi(3) - (1.0 - s).max(0.0).powi(3);
        Self { inverse_h: 1.0 / c.smoothing_length, norm: 1.0 / value }
    }

    /// R (W(r)/W(Δx))⁴ and how much a neighbour at r² \[m²\] counts for the speed.
    #[inline(always)]
    fn pairing(self, square: Lanes) -> (Lanes, Lanes) {
        let s = self.inverse_h * square.sqrt();
        let outer = (Lanes::splat(2.0) - s).at_least(0.0);
        let inner = (Lanes::splat(1.0) - s).at_least(0.0);
        let ratio = self.norm * (0.25 * (outer * outer * outer) - inner * inner * inner);
        let square_ratio = ratio * ratio;
        (PAIRING * (square_ratio * square_ratio), outer.at_most(1.0))
    }
}

impl OrderSums {
    /// Smallest eigenvalue of the moment matrix.
    fn smallest_eigenvalue(&self) -> f64 {
        let [xx, xy, yy] = self.moment;
        0.5 * (xx + yy) - (0.25 * (xx - yy).powi(2) + xy * xy).sqrt()
    }

    /// δu·∇v \[m/s²\]: how fast the velocity of the fluid changes where a shift by `shift` \[m/s\] leads.
    fn velocity_change(&self, shift: &Vector) -> Vector {
        let [xx, xy, yy] = self.moment;
        let determinant = xx * yy - xy * xy;
        if determinant < 0.3 {
            return Vector::zeros();
        }
        // L δu, so that ∇v is corrected by L_i.
        let s = Vector::new(yy * shift.x - xy * shift.y, xx * shift.y - xy * shift.x) / determinant;
        let v = &self.velocity;
        Vector::new(v[0] * s.x + v[1] * s.y, v[2] * s.x + v[3] * s.y)
    }

    /// Σ V_j ∇W \[1/m\].
    pub fn concentration_gradient(&self) -> Vector {
        self.concentration.into()
    }

    /// Adds one neighbour of another owner at separation `d` = x_ij \[m\], with `weight` = V_j (dW/dr)/r \[1/m²\] and
    /// W/W(Δx).
    pub fn add_pair(&mut self, d: &Vector, weight: f64, ratio: f64) {
        let w = d * weight;
        for (sum, term) in self.moment.iter_mut().zip([w.x * d.x, w.x * d.y, w.y * d.y]) {
            *sum -= term;
        }
        for axis in 0..2 {
            self.concentration[axis] += w[axis];
            self.pairing[axis] += PAIRING * ratio.powi(4) * w[axis];
        }
    }

    /// Adds the sums over another owner's particles.
    pub fn merge(&mut self, other: &Self) {
        self.moment.iter_mut().zip(other.moment).for_each(|(a, b)| *a += b);
        self.concentration.iter_mut().zip(other.concentration).for_each(|(a, b)| *a += b);
        self.pairing.iter_mut().zip(other.pairing).for_each(|(a, b)| *a += b);
    }
}

impl Order {
    /// Sums over fluid and walls.
    pub fn accumulate<G: Geometry>(
        &mut self,
        geometry: G,
        model: &FluidModel,
        lists: &Lists,
        fluid: &[Record],
        walls: &[Record],
    ) {
        if model.order.is_none() {
            return;
        }
        let (kernel, ratio) = (&model.law.kernel, Ratio::new(model));
        self.sums.resize(fluid.len(), OrderSums::default());
        self.sums.par_iter_mut().with_min_len(TASK).enumerate().for_each(|(i, sums)| {
            let own = &fluid[i];
            let mut moment = [Lanes::default(); 3];
            let mut concentration = [Lanes::default(); 2];
            let mut pairing = [Lanes::default(); 2];
            let mut velocity = [Lanes::default(); 4];
            let mut speed = [0.0_f64; LANES];
            for (list, others, is_fluid) in [(&lists.fluid, fluid, true), (&lists.walls, walls, false)] {
                for_each_batch(list.of(i), |indices, count| {
                    let batch = Batch::gather(geometry, own, others, indices, count);
                    let square = batch.square();
                    let (factor, nearness) = ratio.pairing(square);
                    let weight = batch.volume * kernel.gradient_factor(square);
                    let (weight_x, weight_y) = (weight * batch.x, weight * batch.y);
                    moment[0] -= weight_x * batch.x;
                    moment[1] -= weight_x * batch.y;
                    moment[2] -= weight_y * batch.y;
                    concentration[0] += weight_x;
                    concentration[1] += weight_y;
                    pairing[0] += factor * weight_x;
                    pairing[1] += factor * weight_y;
                    // v_j − v_i = −v_ij
                    velocity[0] -= batch.v_x * weight_x;
                    velocity[1] -= batch.v_x * weight_y;
                    velocity[2] -= batch.v_y * weight_x;
                    velocity[3] -= batch.v_y * weight_y;
                    if is_fluid {
                        let v = nearness * nearness * (batch.v_x * batch.v_x + batch.v_y * batch.v_y);
                        speed.iter_mut().zip(v.to_array()).for_each(|(most, v)| *most = most.max(v));
                    }
                });
            }
            *sums = OrderSums {
                moment: moment.map(Lanes::sum),
                concentration: concentration.map(Lanes::sum),
                pairing: pairing.map(Lanes::sum),
                velocity: velocity.map(Lanes::sum),
                square_speed: speed.into_iter().fold(0.0, f64::max),
            };
        });
    }

    /// Shifts and accelerations from the present sums.
    pub fn finish<G: Geometry>(
        &mut self,
        geometry: G,
        model: &FluidModel,
        lists: &Lists,
        fluid: &[Record],
        walls: &[Record],
    ) {
        let Some(order) = &model.order else { return };
        let Self { sums, eigenvalue, surface, control } = self;
        eigenvalue.resize(sums.len(), 0.0);
        eigenvalue.par_iter_mut().zip(&*sums).with_min_len(TASK).for_each(|(value, sums)| {
            *value = sums.smallest_eigenvalue();
        });
        let eigenvalue = &*eigenvalue;
        surface.resize(sums.len(), false);
        surface.par_iter_mut().with_min_len(TASK).enumerate().for_each(|(i, surface)| {
            *surface = eigenvalue[i] < SURFACE
                && cone_is_empty(
                    geometry,
                    model,
                    &sums[i],
                    i,
                    [(&lists.fluid, fluid), (&lists.walls, walls)],
                );
        });
        let surface = &*surface;
        control.resize(sums.len(), Control::default());
        control.par_iter_mut().with_min_len(TASK).enumerate().for_each(|(i, control)| {
            let place = Place::of(geometry, model, i, eigenvalue, surface, lists, fluid);
            let shift = shift(order, model, &sums[i], &place);
            let advection = sums[i].velocity_change(&shift);
            *control =
                Control { shift, acceleration: tensile(order, &sums[i], &place, &fluid[i]) + advection };
        });
    }

    /// Adds the control to the rates.
    pub fn add_to(&self, model: &FluidModel, rates: &mut [Rates]) {
        if model.order.is_none() {
            return;
        }
        rates.par_iter_mut().zip(&self.control).with_min_len(TASK).for_each(|(rates, control)| {
            rates.shift = control.shift;
            rates.stabilisers += control.acceleration;
            rates.acceleration += control.acceleration;
        });
    }
}

/// Where a particle lies relative to the free surface.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Place {
    /// No surface within the support.
    Inside,
    /// A particle of the surface lies within the support; unit normal out of the fluid, zero where there is none.
    Near(Vector),
    /// At the surface; its unit normal likewise.
    Surface(Vector),
    /// Spray.
    Alone,
}

impl Place {
    fn of<G: Geometry>(
        geometry: G,
        model: &FluidModel,
        i: usize,
        eigenvalue: &[f64],
        surface: &[bool],
        lists: &Lists,
        fluid: &[Record],
    ) -> Self {
        if eigenvalue[i] < SPRAY {
            return Self::Alone;
        }
        let support = model.kernel.support_radius();
        let (mut near, mut outward) = (false, Vector::zeros());
        for &j in lists.fluid.of(i) {
            let j = j as usize;
            let [x, y] = geometry.separation(&fluid[i], &fluid[j]);
            let d = Vector::new(x, y);
            let distance = d.norm();
            if distance >= support {
                continue;
            }
            near |= surface[j];
            // −∇λ: the eigenvalue falls toward the surface.
            let weight = fluid[j].volume * model.kernel.gradient_factor(distance);
            outward -= d * (weight * (eigenvalue[j] - eigenvalue[i]));
        }
        let normal = || outward.try_normalize(1e-12).unwrap_or_else(Vector::zeros);
        match (surface[i], near) {
            (true, _) => Self::Surface(normal()),
            (false, true) => Self::Near(normal()),
            (false, false) => Self::Inside,
        }
    }
}

/// Whether no neighbour of particle `i` lies in the cone of half-angle 45° along −Σ V_j ∇W, away from the crowd.
///
/// Tells the surface from disorder inside, which lowers the eigenvalue too (Marrone et al. 2010).
fn cone_is_empty<G: Geometry>(
    geometry: G,
    model: &FluidModel,
    sums: &OrderSums,
    i: usize,
    neighbours: [(&NeighbourList, &[Record]); 2],
) -> bool {
    let Some(outward) = (-sums.concentration_gradient()).try_normalize(1e-12) else { return false };
    let support = model.kernel.support_radius();
    let [(_, fluid), _] = neighbours;
    neighbours.into_iter().all(|(list, others)| {
        list.of(i).iter().all(|j| {
            let [x, y] = geometry.separation(&others[*j as usize], &fluid[i]);
            let d = Vector::new(x, y);
            let r = d.norm();
            r >= support || d.dot(&outward) < std::f64::consts::FRAC_1_SQRT_2 * r
        })
    })
}

/// Velocity of the shift \[m/s\].
///
/// ```text
/// δu_i = −C 2h U_i Σ_j V_j [1 + R (W_ij/W(Δx))⁴] ∇W,  |δu_i| ≤ U_i/2      Sun et al. 2017, 2019
/// ```
/// U_i is the largest relative speed of neighbours: a fluid that moves as one is left alone. No shift at the surface,
/// none along its normal near it.
fn shift(order: &OrderControl, model: &FluidModel, sums: &OrderSums, place: &Place) -> Vector {
    let speed = sums.square_speed.sqrt();
    let [x, y] = [0, 1].map(|axis| sums.concentration[axis] + sums.pairing[axis]);
    let scale = -order.shifting * 2.0 * model.constants.smoothing_length * speed;
    let shift = match place {
        Place::Alone => return Vector::zeros(),
        Place::Near(normal) | Place::Surface(normal) => {
            let shift = Vector::new(x, y) * scale;
            shift - normal * shift.dot(normal)
        }
        Place::Inside => Vector::new(x, y) * scale,
    };
    shift.cap_magnitude(0.5 * speed)
}

/// Acceleration \[m/s²\] that turns p_i + p_j into p_j − p_i where p_i is negative, inside the fluid.
///
/// ```text
/// 2 p_i/ρ_i Σ_j V_j ∇W                                                     Sun et al. 2018
/// ```
fn tensile(order: &OrderControl, sums: &OrderSums, place: &Place, own: &Record) -> Vector {
    if !order.tensile_control || own.pressure >= 0.0 || *place != Place::Inside {
        return Vector::zeros();
    }
    sums.concentration_gradient() * (2.0 * own.pressure / own.density)
}

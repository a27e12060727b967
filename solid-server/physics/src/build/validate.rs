//! Checks of a set-up, and of the model built from it.

use std::ops::Range;

use sph::setup::{InterfaceLaw, SolidSetup, SolidStepping, SubstepCount};

use crate::neighbours::lists::{CONTACT_SKIN, OWN_SKIN};
use crate::space::SolidSpace;
use crate::system::model::{ContactModel, SolidModel};

/// Ranges of the bodies' particles, or all errors of the arrays.
pub fn check_arrays<S: SolidSpace>(setup: &SolidSetup<S>) -> Result<Vec<Range<usize>>, Vec<String>> {
    let p = &setup.particles;
    let n = p.id.len();
    let lengths = [
        ("body", p.body.len()),
        ("support", p.support.len()),
        ("mass", p.mass.len()),
        ("reference_position", p.reference_position.len()),
        ("position", p.position.len()),
        ("velocity", p.velocity.len()),
        ("density", p.density.len()),
        ("deviatoric_stress", p.deviatoric_stress.len()),
    ];
    let mut errors: Vec<String> = lengths
        .iter()
        .filter(|(_, length)| *length != n)
        .map(|(name, length)| format!("solid particles: `{name}` has {length} entries, `id` has {n}"))
        .collect();
    if setup.wall_particles.wall.len() != setup.wall_particles.position.len() {
        errors.push("wall particles: `wall` and `position` differ in length".into());
    }
    if let Some(wall) = setup.wall_particles.wall.iter().find(|w| **w as usize >= setup.walls.len()) {
        errors.push(format!("wall particles: wall {wall} does not exist; there are {}", setup.walls.len()));
    }
    if !p.id.windows(2).all(|pair| pair[0] < pair[1]) {
        errors.push("solid particles: `id` must ascend".into());
    }
    if !p.body.is_sorted() {
        errors.push("solid particles: particles of a body must be contiguous, bodies in order".into());
    }
    if !errors.is_empty() {
        return Err(errors);
    }
    let mut ranges = Vec::new();
    for (k, body) in (0u32..).zip(&setup.bodies) {
        let range = p.body.partition_point(|b| *b < k)..p.body.partition_point(|b| *b <= k);
        if range.is_empty() {
            errors.push(format!("body `{}` has no particles", body.name));
        }
        if let Some(i) = range.clone().find(|i| p.support[*i] as usize > body.supports.len()) {
            let (support, count) = (p.support[i], body.supports.len());
            errors.push(format!("body `{}`: support {support} does not exist; there are {count}", body.name));
        }
        ranges.push(range);
    }
    if p.body.last().is_some_and(|last| *last as usize >= setup.bodies.len()) {
        errors.push(format!("solid particles: body index beyond the {} bodies", setup.bodies.len()));
    }
    if errors.is_empty() { Ok(ranges) } else { Err(errors) }
}

/// Bodies that take part in sums with others need a stress, and one kernel between them.
pub fn check_sums<S: SolidSpace>(model: &SolidModel<S>, law: Option<InterfaceLaw>, errors: &mut Vec<String>) {
    let contact_sums = matches!(model.contact, ContactModel::Sums(_));
    let plain_sum = law == Some(InterfaceLaw::PlainSum);
    if plain_sum && model.stepping != SolidStepping::StageRule {
        errors.push(
            "the plain-sum interface needs the stage rule: the fluid takes part in the stress of the solid, which can \
             not be frozen over sub-steps"
                .into(),
        );
    }
    if matches!(model.stepping, SolidStepping::Substeps(SubstepCount::Fixed(count)) if count == 0 || count % 2 > 0)
    {
        errors.push("the number of sub-steps must be even and at least 2".into());
    }
    let mut first = None;
    for body in &model.bodies {
        let Some(law) = body.formulation.sum_law() else {
            for (used, what) in
                [(contact_sums, "contact through the sums"), (plain_sum, "the plain-sum interface")]
            {
                if used {
                    errors.push(format!(
                        "body `{}` is not updated-Lagrangian, which {what} needs; make it so or choose another law",
                        body.name
                    ));
                }
            }
            continue;
        };
        let own = (law.kernel, law.artificial_stress, law.exponent);
        if contact_sums && own != *first.get_or_insert(own) {
            errors.push(format!(
                "body `{}`: contact through the sums needs the same smoothing length and artificial stress in all bodies",
                body.name
            ));
        }
    }
}

/// A pair may interact through one periodic image only.
pub fn check_periods<S: SolidSpace>(model: &SolidModel<S>, errors: &mut Vec<String>) {
    let own = model.bodies.iter().filter_map(|body| body.formulation.list_radius()).fold(0.0, f64::max);
    let needed = 2.0
        * (own + OWN_SKIN * model.spacing)
            .max(model.contact.radii().largest() + CONTACT_SKIN * model.spacing);
    for axis in (0..S::DIMENSIONS).filter(|axis| model.domain.periodic[*axis]) {
        let period = model.domain.size()[axis];
        // Not by round-off.
        if period < needed * (1.0 - 1e-12) {
            let name = ["x", "y", "z"][axis];
            errors.push(format!(
                "period of {period} m along {name} is too short: the solids need {} m",
                rounded_up(needed)
            ));
        }
    }
}

/// `length` \[m\] upward to four digits, so that what a message asks for is enough.
fn rounded_up(length: f64) -> f64 {
    let digit = 10.0_f64.powf(length.log10().floor() - 3.0);
    // Without the round-off of the product.
    format!("{:.3e}", (length / digit).ceil() * digit).parse().unwrap_or(length)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_period_of_the_length_that_a_message_asks_for_is_long_enough() {
        assert_eq!(rounded_up(0.008_100_000_1), 0.008_101);
        assert_eq!(rounded_up(1.234_5), 1.235);
        for length in [0.008_1, 0.1, 1.0 / 3.0, 12.345_6, 7e-9] {
            let shown = rounded_up(length);
            assert!(shown >= length * (1.0 - 1e-12) && shown < 1.001 * length, "{length} {shown}");
        }
    }
}

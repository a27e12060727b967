//! What the page shows of particles.

use sph::coupling::solver::ParticleFields;
use sph::random::SplitMix64;

/// Fields of the page, in the order of its columns after the position.
pub const FIELDS: [&str; 4] = ["pressure", "speed", "density", "von_mises"];
/// Fields that are read from a snapshot.
pub const SOURCES: [&str; 5] = ["pressure", "velocity", "density", "von_mises", "mass"];

/// What a particle is drawn as.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Matter {
    /// The fluid.
    Fluid,
    /// A solid body.
    Solid,
    /// A wall.
    Wall,
}

/// A particle by its name: group and number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Slot {
    /// Index of its group.
    pub group: u16,
    /// Its id on its side.
    pub id: u32,
}

/// A group of particles.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Group {
    /// Name in the case.
    pub name: String,
    /// What its particles are drawn as.
    pub matter: Matter,
}

/// Particles at one time: position, then [`FIELDS`]; NaN where a particle has no such value.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Particles {
    /// Time \[s\].
    pub time: f64,
    /// Completed steps.
    pub step: u64,
    /// Particles, ascending.
    pub slots: Vec<Slot>,
    /// Columns x, y, z and fields, one value per particle.
    pub columns: [Vec<f32>; 3 + FIELDS.len()],
}

impl Particles {
    /// Particles of both sides, of which about one in `every` is kept, the same at all times. New groups are added to
    /// `groups`; those of `walls` are walls.
    pub fn add(
        &mut self,
        fields: &ParticleFields,
        is_solid: bool,
        walls: &[String],
        groups: &mut Vec<Group>,
        every: u32,
    ) {
        let indices: Vec<u16> = fields
            .group_names
            .iter()
            .map(|name| {
                let matter = match (is_solid, walls.contains(name)) {
                    (true, _) => Matter::Solid,
                    (false, true) => Matter::Wall,
                    (false, false) => Matter::Fluid,
                };
                index_of(groups, Group { name: name.clone(), matter })
            })
            .collect();
        let field = |name: &str| {
            fields.field(name).filter(|field| field.values.len() == field.components * fields.id.len())
        };
        let (position, velocity) = (field("position"), field("velocity"));
        let scalars = ["pressure", "density", "von_mises"].map(field);
        for (i, id) in fields.id.iter().enumerate() {
            let Some(group) = fields.group.get(i).and_then(|g| indices.get(*g as usize)).copied() else {
                continue;
            };
            if !keeps(*id, every) {
                continue;
            }
            self.slots.push(Slot { group, id: *id });
            let part = |field: Option<&sph::coupling::solver::Field>, k: usize| {
                field.filter(|f| k < f.components).map_or(f64::NAN, |f| f.values[i * f.components + k])
            };
            for axis in 0..3 {
                let planar = position.is_some_and(|p| axis >= p.components);
                self.columns[axis].push(if planar { 0.0 } else { part(position, axis) as f32 });
            }
            let speed = velocity.map_or(f64::NAN, |v| {
                v.values[i * v.components..(i + 1) * v.components].iter().map(|c| c * c).sum::<f64>().sqrt()
            });
            let is_wall = groups[usize::from(group)].matter == Matter::Wall;
            // Dummy values of walls belong to the method, not to the answer.
            let values = [part(scalars[0], 0), speed, part(scalars[1], 0), part(scalars[2], 0)];
            for (column, value) in self.columns[3..].iter_mut().zip(values) {
                column.push(if is_wall { f32::NAN } else { value as f32 });
            }
        }
    }

    /// Brings the particles into the order of their slots.
    pub fn sort(&mut self) {
        let mut order: Vec<usize> = (0..self.slots.len()).collect();
        order.sort_by_key(|i| self.slots[*i]);
        self.slots = order.iter().map(|i| self.slots[*i]).collect();
        for column in &mut self.columns {
            *column = order.iter().map(|i| column[*i]).collect();
        }
    }

    /// The position of a particle.
    pub fn position(&self, i: usize) -> [f32; 3] {
        [self.columns[0][i], self.columns[1][i], self.columns[2][i]]
    }

    /// Only one in `every` of the particles.
    pub fn thin(&mut self, every: u32) {
        let keep: Vec<bool> = self.slots.iter().map(|slot| keeps(slot.id, every)).collect();
        let mut kept = keep.iter();
        self.slots.retain(|_| kept.next() == Some(&true));
        for column in &mut self.columns {
            let mut kept = keep.iter();
            column.retain(|_| kept.next() == Some(&true));
        }
    }
}

fn index_of(groups: &mut Vec<Group>, group: Group) -> u16 {
    let known = groups.iter().position(|other| *other == group);
    let index = known.unwrap_or_else(|| {
        groups.push(group);
        groups.len() - 1
    });
    // Cases have far fewer groups.
    u16::try_from(index).unwrap_or(u16::MAX)
}

/// Whether a particle is among the one in `every` that is shown: as if drawn by lot, so that no row of a lattice is kept
/// or left out whole. Those kept at a multiple of `every` are among those kept at `every`.
pub fn keeps(id: u32, every: u32) -> bool {
    every <= 1 || SplitMix64(u64::from(id)).bits() < u64::MAX / u64::from(every)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Particles of a block are numbered along its rows, those of a column a row's length apart.
    #[test]
    fn thinning_keeps_the_same_share_of_each_column_of_a_lattice() {
        for every in [2, 4, 8] {
            for row in 2..64 {
                for column in 0..row {
                    let kept = (0..2000).filter(|k| keeps(column + k * row, every)).count() as f64;
                    let mean = 2000.0 / f64::from(every);
                    // Five times the scatter of so many draws.
                    assert!((kept - mean).abs() < 5.0 * mean.sqrt(), "{every}, {row}, {column}: {kept}");
                }
            }
        }
    }

    #[test]
    fn thinning_keeps_the_stated_share_and_is_nested() {
        for every in [2, 3, 8, 50] {
            let kept: Vec<u32> = (0..100_000).filter(|id| keeps(*id, every)).collect();
            let share = kept.len() as f64 * f64::from(every) / 1e5;
            // A share of n random particles scatters by 1/√n, here below 3 %.
            assert!((share - 1.0).abs() < 0.1, "{every}: {share}");
            assert!((0..100_000).filter(|id| keeps(*id, 2 * every)).all(|id| keeps(id, every)));
        }
    }
}

//! Members of an ensemble: the same case with all water particles displaced a little.

use sph::setup::FluidParticles;
use sph::shapes::displace;
use sph::space::Space;

use super::file::CaseFile;

/// Displaces every water particle as `[run]` says. Masses, densities and velocities stay.
///
/// It comes after a start from another run, whose particles are displaced too.
pub fn apply<S: Space>(file: &CaseFile, particles: &mut FluidParticles<S>) {
    let (Some(run), Some(fluid)) = (&file.run, &file.fluid) else { return };
    let amplitude = run.displacement_fraction * fluid.parameters.particle_spacing;
    displace(&mut particles.position, amplitude, run.seed, &file.domain.domain::<S>());
}

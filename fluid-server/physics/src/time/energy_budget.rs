//! The energy budget of the fluid: what a step adds to its accounts, and the report.

use sph::coupling::ledger::{Energies, EnergyAccount as A, EnergyReport, EnergyTally, EnergyValues};

use super::compression_budget::CompressionBudget;

/// The stores among the accounts \[J/m\].
pub fn stores(energies: &Energies) -> EnergyValues {
    let mut values = EnergyValues::default();
    values.add(A::Kinetic, energies.kinetic);
    values.add(A::Potential, energies.potential);
    values.add(A::Compression, energies.internal);
    values.add(A::Relaxation, energies.relaxation);
    values
}

/// Enters what a step did to compression and relaxation.
///
/// What the relaxation absorbs comes from the compression by continuity, as what it stores does; that is entered in
/// [`report`].
pub fn enter_compression(flows: &mut EnergyValues, compression: &CompressionBudget) {
    flows.add(A::CorrectedGradients, -compression.continuity - compression.relaxation_loss);
    flows.add(A::DensityDiffusion, -compression.diffusion);
    flows.add(A::VolumeCorrection, -compression.volume);
    flows.add(A::AcousticRelaxation, compression.relaxation_loss);
}

/// Enters the work of solids in `duration` \[s\]: that of their forces, and that of their approach, which compresses the
/// fluid and so is not the fluid's own \[W/m\].
pub fn enter_interface(flows: &mut EnergyValues, [forces, approach]: [f64; 2], duration: f64) {
    flows.add(A::Interface, duration * (forces + approach));
    flows.add(A::CorrectedGradients, duration * approach);
}

/// Enters a particle of these `energies` \[J/m\] that leaves.
pub fn enter_removed(flows: &mut EnergyValues, energies: &Energies) {
    let Energies { kinetic, potential, internal, relaxation } = *energies;
    flows.add(A::Removed, kinetic + potential + internal + relaxation);
    // `report` takes the change of this store for that of the particles present.
    flows.add(A::CorrectedGradients, -relaxation);
}

/// The report of the `listed` accounts at a boundary with these `energies` \[J/m\].
pub fn report(listed: &[A], tally: &EnergyTally, energies: &Energies) -> EnergyReport {
    let (now, mut flows) = (stores(energies), tally.flows);
    flows.add(A::CorrectedGradients, tally.start.get(A::Relaxation) - now.get(A::Relaxation));
    EnergyReport::new(listed, &tally.start, &now, &flows)
}

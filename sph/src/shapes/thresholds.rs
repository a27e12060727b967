//! Thresholds of fitted filling that differ from space to space.

crate::thresholds! {
    /// Further inside, a lattice is as good. In space a layer has many more particles.
    LAYERS = 6.0, in space 3.0, "packing.layers",
        "layers along the faces of a thick shape; the lattice fills the rest [-]";
    /// In space a cell has as many samples from three along a spacing as in the plane from five.
    SAMPLES = 8.0, in space 3.0, "packing.samples",
        "samples along a spacing by which cells are measured [-]";
    /// A square lattice has places 0.71 spacings from its points, a cubic one 0.87.
    HOLE = 0.85, in space 0.97, "packing.hole",
        "distance from all particles of a place that gets a particle of its own, in spacings [-]";
    /// In space layers are even before.
    SWEEPS = 15.0, in space 6.0, "packing.sweeps",
        "moves to the centroids after each time that particles are added [-]";
}

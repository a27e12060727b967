pub(super) static SHAPES: &[Shape] = &[
    Shape { name: "Aborted", fields: &[
        Field { number: 1, name: "at", list: None, entry: Entry::Message(88) },
    ] },
    Shape { name: "Acceptance", fields: &[
    ] },
    Shape { name: "AccountEntry", fields: &[
        Field { number: 2, name: "force_n", list: None, entry: Entry::Message(94) },
        Field { number: 3, name: "torque_n_m", list: None, entry: Entry::Message(94) },
    ] },
    Shape { name: "AdaptiveStep", fields: &[
        Field { number: 4, name: "exact", list: None, entry: Entry::Message(36) },
    ] },
    Shape { name: "AngularBudget", fields: &[
        Field { number: 1, name: "change_kg_m2_per_s", list: None, entry: Entry::Message(94) },
    ] },
    Shape { name: "Attempt", fields: &[
        Field { number: 10, name: "fluid_extent", list: None, entry: Entry::Message(38) },
        Field { number: 11, name: "solid_extent", list: None, entry: Entry::Message(38) },
    ] },
    Shape { name: "Beat", fields: &[
        Field { number: 4, name: "awaited", list: None, entry: Entry::Message(88) },
    ] },
    Shape { name: "Block", fields: &[
    ] },
    Shape { name: "BodyForce", fields: &[
        Field { number: 1, name: "gravity_m_per_s2", list: None, entry: Entry::Message(94) },
        Field { number: 2, name: "expressions_m_per_s2", list: None, entry: Entry::Message(37) },
    ] },
    Shape { name: "BodyReport", fields: &[
    ] },
    Shape { name: "BodySetup", fields: &[
        Field { number: 2, name: "material", list: Some(0), entry: Entry::Message(62) },
        Field { number: 4, name: "parameters", list: Some(1), entry: Entry::Message(62) },
        Field { number: 5, name: "supports", list: Some(2), entry: Entry::Message(90) },
        Field { number: 6, name: "acceleration_m_per_s2", list: None, entry: Entry::Message(37) },
        Field { number: 7, name: "loads", list: Some(3), entry: Entry::Message(91) },
    ] },
    Shape { name: "Breach", fields: &[
        Field { number: 1, name: "at", list: None, entry: Entry::Message(88) },
    ] },
    Shape { name: "Capabilities", fields: &[
    ] },
    Shape { name: "CheckpointChunk", fields: &[
        Field { number: 2, name: "header", list: None, entry: Entry::Message(14) },
        Field { number: 4, name: "trailer", list: None, entry: Entry::Message(16) },
    ] },
    Shape { name: "CheckpointHeader", fields: &[
    ] },
    Shape { name: "CheckpointRequest", fields: &[
    ] },
    Shape { name: "CheckpointTrailer", fields: &[
    ] },
    Shape { name: "ClockDifference", fields: &[
        Field { number: 1, name: "at", list: None, entry: Entry::Message(88) },
    ] },
    Shape { name: "CloseReply", fields: &[
    ] },
    Shape { name: "CloseRequest", fields: &[
    ] },
    Shape { name: "Command", fields: &[
        Field { number: 4, name: "stop", list: None, entry: Entry::Message(93) },
        Field { number: 5, name: "abort", list: None, entry: Entry::Message(93) },
        Field { number: 6, name: "pause", list: None, entry: Entry::Message(93) },
    ] },
    Shape { name: "Constants", fields: &[
        Field { number: 2, name: "body_force", list: None, entry: Entry::Message(8) },
        Field { number: 3, name: "coupling", list: None, entry: Entry::Message(25) },
        Field { number: 4, name: "domain", list: None, entry: Entry::Message(31) },
        Field { number: 5, name: "time", list: None, entry: Entry::Message(92) },
    ] },
    Shape { name: "ContactLaw", fields: &[
        Field { number: 2, name: "parameters", list: Some(4), entry: Entry::Message(62) },
    ] },
    Shape { name: "Contradiction", fields: &[
        Field { number: 1, name: "at", list: None, entry: Entry::Message(88) },
    ] },
    Shape { name: "Counts", fields: &[
        Field { number: 10, name: "parts", list: None, entry: Entry::Message(64) },
    ] },
    Shape { name: "Coupling", fields: &[
        Field { number: 2, name: "fluid", list: Some(5), entry: Entry::Message(62) },
        Field { number: 7, name: "implicit", list: None, entry: Entry::Message(50) },
    ] },
    Shape { name: "CoverageGap", fields: &[
        Field { number: 1, name: "at", list: None, entry: Entry::Message(88) },
    ] },
    Shape { name: "Damping", fields: &[
    ] },
    Shape { name: "DescribeRequest", fields: &[
    ] },
    Shape { name: "Description", fields: &[
        Field { number: 5, name: "lowest_protocol", list: None, entry: Entry::Message(74) },
        Field { number: 6, name: "highest_protocol", list: None, entry: Entry::Message(74) },
        Field { number: 7, name: "roles", list: Some(6), entry: Entry::PackedVarint },
        Field { number: 8, name: "dimensions", list: Some(7), entry: Entry::PackedVarint },
        Field { number: 9, name: "coupling_kinds", list: Some(8), entry: Entry::PackedVarint },
        Field { number: 10, name: "interface_laws", list: Some(9), entry: Entry::PackedVarint },
        Field { number: 12, name: "capabilities", list: None, entry: Entry::Message(12) },
        Field { number: 13, name: "limits", list: None, entry: Entry::Message(53) },
    ] },
    Shape { name: "Divergence", fields: &[
        Field { number: 1, name: "at", list: None, entry: Entry::Message(88) },
        Field { number: 3, name: "position_m", list: None, entry: Entry::Message(94) },
    ] },
    Shape { name: "Domain", fields: &[
        Field { number: 1, name: "lower_m", list: None, entry: Entry::Message(94) },
        Field { number: 2, name: "upper_m", list: None, entry: Entry::Message(94) },
        Field { number: 3, name: "periodic", list: None, entry: Entry::Message(46) },
    ] },
    Shape { name: "Energies", fields: &[
    ] },
    Shape { name: "EnergyEntry", fields: &[
    ] },
    Shape { name: "Event", fields: &[
        Field { number: 1, name: "step", list: None, entry: Entry::Message(87) },
        Field { number: 2, name: "probes", list: None, entry: Entry::Message(73) },
        Field { number: 3, name: "snapshot", list: None, entry: Entry::Message(81) },
        Field { number: 4, name: "finished", list: None, entry: Entry::Message(44) },
        Field { number: 5, name: "failed", list: None, entry: Entry::Message(40) },
        Field { number: 6, name: "beat", list: None, entry: Entry::Message(6) },
        Field { number: 7, name: "paused", list: None, entry: Entry::Message(68) },
    ] },
    Shape { name: "EventBatch", fields: &[
        Field { number: 3, name: "events", list: Some(10), entry: Entry::Message(34) },
    ] },
    Shape { name: "ExactTimes", fields: &[
    ] },
    Shape { name: "Expressions", fields: &[
        Field { number: 1, name: "components", list: Some(11), entry: Entry::Text },
    ] },
    Shape { name: "Extent", fields: &[
    ] },
    Shape { name: "Fact", fields: &[
    ] },
    Shape { name: "Failed", fields: &[
        Field { number: 1, name: "fault", list: None, entry: Entry::Message(42) },
        Field { number: 4, name: "counts", list: None, entry: Entry::Message(24) },
    ] },
    Shape { name: "Farewell", fields: &[
    ] },
    Shape { name: "Fault", fields: &[
        Field { number: 1, name: "diverged", list: None, entry: Entry::Message(30) },
        Field { number: 2, name: "ledger", list: None, entry: Entry::Message(11) },
        Field { number: 3, name: "stale_frame", list: None, entry: Entry::Message(86) },
        Field { number: 4, name: "coverage", list: None, entry: Entry::Message(26) },
        Field { number: 5, name: "clock", list: None, entry: Entry::Message(17) },
        Field { number: 6, name: "peer", list: None, entry: Entry::Message(69) },
        Field { number: 7, name: "aborted", list: None, entry: Entry::Message(0) },
        Field { number: 8, name: "contradiction", list: None, entry: Entry::Message(23) },
    ] },
    Shape { name: "FieldSpec", fields: &[
    ] },
    Shape { name: "Finished", fields: &[
        Field { number: 4, name: "counts", list: None, entry: Entry::Message(24) },
    ] },
    Shape { name: "FixedStep", fields: &[
    ] },
    Shape { name: "Flags", fields: &[
        Field { number: 1, name: "components", list: Some(12), entry: Entry::PackedVarint },
    ] },
    Shape { name: "FluidParticles", fields: &[
    ] },
    Shape { name: "FluidSetup", fields: &[
        Field { number: 1, name: "run", list: None, entry: Entry::Message(77) },
        Field { number: 2, name: "parameters", list: Some(13), entry: Entry::Message(62) },
        Field { number: 4, name: "damping", list: None, entry: Entry::Message(27) },
        Field { number: 5, name: "regions", list: Some(14), entry: Entry::Text },
        Field { number: 6, name: "walls", list: Some(15), entry: Entry::Message(96) },
        Field { number: 7, name: "particles", list: None, entry: Entry::Message(47) },
        Field { number: 8, name: "wall_particles", list: None, entry: Entry::Message(95) },
        Field { number: 9, name: "probes", list: Some(16), entry: Entry::Message(71) },
        Field { number: 10, name: "outflow", list: None, entry: Entry::Message(60) },
    ] },
    Shape { name: "Frame", fields: &[
        Field { number: 10, name: "set", list: None, entry: Entry::Message(65) },
        Field { number: 11, name: "blocks", list: Some(17), entry: Entry::Message(7) },
        Field { number: 14, name: "extent", list: None, entry: Entry::Message(38) },
        Field { number: 18, name: "previous", list: None, entry: Entry::Message(70) },
        Field { number: 19, name: "farewell", list: None, entry: Entry::Message(41) },
        Field { number: 20, name: "acceptance", list: None, entry: Entry::Message(1) },
    ] },
    Shape { name: "ImplicitCoupling", fields: &[
    ] },
    Shape { name: "InterfaceSums", fields: &[
        Field { number: 1, name: "force_n", list: None, entry: Entry::Message(94) },
        Field { number: 3, name: "torque_n_m", list: None, entry: Entry::Message(94) },
        Field { number: 5, name: "couple_n_m", list: None, entry: Entry::Message(94) },
    ] },
    Shape { name: "LedgerPolicy", fields: &[
    ] },
    Shape { name: "Limits", fields: &[
    ] },
    Shape { name: "LinkReply", fields: &[
    ] },
    Shape { name: "LinkRequest", fields: &[
        Field { number: 3, name: "partner_extent", list: None, entry: Entry::Message(38) },
        Field { number: 4, name: "alone", list: None, entry: Entry::Message(93) },
        Field { number: 6, name: "listen", list: None, entry: Entry::Message(93) },
        Field { number: 7, name: "partner_particles", list: None, entry: Entry::Message(67) },
    ] },
    Shape { name: "MomentumReport", fields: &[
        Field { number: 1, name: "change_kg_m_per_s", list: None, entry: Entry::Message(94) },
        Field { number: 3, name: "angular", list: None, entry: Entry::Message(4) },
    ] },
    Shape { name: "Motion", fields: &[
        Field { number: 1, name: "displacement_m", list: None, entry: Entry::Message(37) },
        Field { number: 3, name: "pivot_m", list: None, entry: Entry::Message(94) },
        Field { number: 4, name: "axis", list: None, entry: Entry::Message(94) },
    ] },
    Shape { name: "OpenReply", fields: &[
        Field { number: 3, name: "protocol", list: None, entry: Entry::Message(74) },
        Field { number: 7, name: "constants", list: None, entry: Entry::Message(21) },
        Field { number: 8, name: "fields_sent", list: Some(18), entry: Entry::Message(43) },
        Field { number: 9, name: "fields_needed", list: Some(19), entry: Entry::Message(43) },
        Field { number: 10, name: "extent", list: None, entry: Entry::Message(38) },
        Field { number: 12, name: "counts", list: None, entry: Entry::Message(24) },
        Field { number: 13, name: "facts", list: Some(20), entry: Entry::Message(39) },
        Field { number: 15, name: "bodies", list: Some(21), entry: Entry::Message(9) },
        Field { number: 16, name: "remarks", list: Some(22), entry: Entry::Text },
    ] },
    Shape { name: "OpenRequest", fields: &[
        Field { number: 1, name: "protocol", list: None, entry: Entry::Message(74) },
        Field { number: 4, name: "fluid", list: None, entry: Entry::Message(48) },
        Field { number: 5, name: "solid", list: None, entry: Entry::Message(84) },
    ] },
    Shape { name: "Outflow", fields: &[
        Field { number: 1, name: "lower", list: None, entry: Entry::Message(46) },
        Field { number: 2, name: "upper", list: None, entry: Entry::Message(46) },
    ] },
    Shape { name: "OutputPlan", fields: &[
    ] },
    Shape { name: "Parameter", fields: &[
    ] },
    Shape { name: "PartCount", fields: &[
    ] },
    Shape { name: "PartCounts", fields: &[
        Field { number: 1, name: "each", list: Some(23), entry: Entry::Message(63) },
    ] },
    Shape { name: "ParticleSet", fields: &[
    ] },
    Shape { name: "PartnerBody", fields: &[
    ] },
    Shape { name: "PartnerParticles", fields: &[
        Field { number: 5, name: "bodies", list: Some(24), entry: Entry::Message(66) },
    ] },
    Shape { name: "Paused", fields: &[
    ] },
    Shape { name: "PeerFault", fields: &[
        Field { number: 1, name: "at", list: None, entry: Entry::Message(88) },
    ] },
    Shape { name: "PreviousStage", fields: &[
        Field { number: 1, name: "at", list: None, entry: Entry::Message(88) },
        Field { number: 2, name: "sums", list: None, entry: Entry::Message(51) },
        Field { number: 4, name: "momentum", list: None, entry: Entry::Message(56) },
    ] },
    Shape { name: "Probe", fields: &[
        Field { number: 3, name: "arguments", list: Some(25), entry: Entry::Message(72) },
        Field { number: 4, name: "columns", list: Some(26), entry: Entry::Text },
    ] },
    Shape { name: "ProbeArgument", fields: &[
        Field { number: 3, name: "point_m", list: None, entry: Entry::Message(94) },
    ] },
    Shape { name: "ProbeRow", fields: &[
    ] },
    Shape { name: "ProtocolVersion", fields: &[
    ] },
    Shape { name: "RestoreChunk", fields: &[
        Field { number: 3, name: "header", list: None, entry: Entry::Message(14) },
        Field { number: 5, name: "trailer", list: None, entry: Entry::Message(16) },
    ] },
    Shape { name: "RestoreReply", fields: &[
        Field { number: 5, name: "extent", list: None, entry: Entry::Message(38) },
    ] },
    Shape { name: "RunSetup", fields: &[
        Field { number: 3, name: "domain", list: None, entry: Entry::Message(31) },
        Field { number: 4, name: "time", list: None, entry: Entry::Message(92) },
        Field { number: 5, name: "body_force", list: None, entry: Entry::Message(8) },
        Field { number: 6, name: "outputs", list: None, entry: Entry::Message(61) },
        Field { number: 7, name: "ledger", list: None, entry: Entry::Message(52) },
        Field { number: 8, name: "coupling", list: None, entry: Entry::Message(25) },
    ] },
    Shape { name: "SnapshotChunk", fields: &[
        Field { number: 2, name: "header", list: None, entry: Entry::Message(80) },
    ] },
    Shape { name: "SnapshotField", fields: &[
    ] },
    Shape { name: "SnapshotHeader", fields: &[
        Field { number: 5, name: "group_names", list: Some(27), entry: Entry::Text },
        Field { number: 6, name: "fields", list: Some(28), entry: Entry::Message(79) },
    ] },
    Shape { name: "SnapshotTaken", fields: &[
    ] },
    Shape { name: "SnapshotsRequest", fields: &[
    ] },
    Shape { name: "SolidParticles", fields: &[
    ] },
    Shape { name: "SolidSetup", fields: &[
        Field { number: 1, name: "run", list: None, entry: Entry::Message(77) },
        Field { number: 3, name: "bodies", list: Some(29), entry: Entry::Message(10) },
        Field { number: 4, name: "particles", list: None, entry: Entry::Message(83) },
        Field { number: 5, name: "contact", list: None, entry: Entry::Message(22) },
        Field { number: 6, name: "walls", list: Some(30), entry: Entry::Message(96) },
        Field { number: 7, name: "wall_particles", list: None, entry: Entry::Message(95) },
        Field { number: 8, name: "damping", list: None, entry: Entry::Message(27) },
        Field { number: 9, name: "probes", list: Some(31), entry: Entry::Message(71) },
        Field { number: 11, name: "substeps", list: None, entry: Entry::Message(89) },
    ] },
    Shape { name: "StageBudget", fields: &[
        Field { number: 1, name: "interface", list: None, entry: Entry::Message(51) },
        Field { number: 2, name: "accounts", list: Some(32), entry: Entry::Message(2) },
        Field { number: 4, name: "momentum_change_kg_m_per_s", list: None, entry: Entry::Message(94) },
        Field { number: 6, name: "angular", list: None, entry: Entry::Message(4) },
    ] },
    Shape { name: "StaleFrame", fields: &[
        Field { number: 1, name: "at", list: None, entry: Entry::Message(88) },
    ] },
    Shape { name: "StepReport", fields: &[
        Field { number: 4, name: "predictor", list: None, entry: Entry::Message(85) },
        Field { number: 5, name: "corrector", list: None, entry: Entry::Message(85) },
        Field { number: 6, name: "energies", list: None, entry: Entry::Message(32) },
        Field { number: 14, name: "energy_accounts", list: Some(33), entry: Entry::Message(33) },
    ] },
    Shape { name: "StepStage", fields: &[
    ] },
    Shape { name: "Substeps", fields: &[
        Field { number: 2, name: "automatic", list: None, entry: Entry::Message(93) },
    ] },
    Shape { name: "Support", fields: &[
        Field { number: 2, name: "held", list: None, entry: Entry::Message(46) },
        Field { number: 3, name: "motion", list: None, entry: Entry::Message(57) },
        Field { number: 5, name: "pivot_m", list: None, entry: Entry::Message(94) },
    ] },
    Shape { name: "SurfaceLoad", fields: &[
        Field { number: 3, name: "traction_pa", list: None, entry: Entry::Message(37) },
    ] },
    Shape { name: "TimePlan", fields: &[
        Field { number: 3, name: "fixed", list: None, entry: Entry::Message(45) },
        Field { number: 4, name: "adaptive", list: None, entry: Entry::Message(3) },
    ] },
    Shape { name: "Unit", fields: &[
    ] },
    Shape { name: "Vector", fields: &[
    ] },
    Shape { name: "WallParticles", fields: &[
    ] },
    Shape { name: "WallSetup", fields: &[
        Field { number: 3, name: "motion", list: None, entry: Entry::Message(57) },
    ] },
];
pub(super) const LISTS: usize = 34;
impl Counted for crate::wire::Vector { const SHAPE: usize = 94; }
impl Counted for crate::wire::Flags { const SHAPE: usize = 46; }
impl Counted for crate::wire::ProtocolVersion { const SHAPE: usize = 74; }
impl Counted for crate::wire::StepStage { const SHAPE: usize = 88; }
impl Counted for crate::wire::FieldSpec { const SHAPE: usize = 43; }
impl Counted for crate::wire::Extent { const SHAPE: usize = 38; }
impl Counted for crate::wire::InterfaceSums { const SHAPE: usize = 51; }
impl Counted for crate::wire::AngularBudget { const SHAPE: usize = 4; }
impl Counted for crate::wire::Parameter { const SHAPE: usize = 62; }
impl Counted for crate::wire::RunSetup { const SHAPE: usize = 77; }
impl Counted for crate::wire::Domain { const SHAPE: usize = 31; }
impl Counted for crate::wire::TimePlan { const SHAPE: usize = 92; }
impl Counted for crate::wire::FixedStep { const SHAPE: usize = 45; }
impl Counted for crate::wire::AdaptiveStep { const SHAPE: usize = 3; }
impl Counted for crate::wire::ExactTimes { const SHAPE: usize = 36; }
impl Counted for crate::wire::BodyForce { const SHAPE: usize = 8; }
impl Counted for crate::wire::Expressions { const SHAPE: usize = 37; }
impl Counted for crate::wire::OutputPlan { const SHAPE: usize = 61; }
impl Counted for crate::wire::LedgerPolicy { const SHAPE: usize = 52; }
impl Counted for crate::wire::Coupling { const SHAPE: usize = 25; }
impl Counted for crate::wire::ImplicitCoupling { const SHAPE: usize = 50; }
impl Counted for crate::wire::FluidSetup { const SHAPE: usize = 48; }
impl Counted for crate::wire::Damping { const SHAPE: usize = 27; }
impl Counted for crate::wire::FluidParticles { const SHAPE: usize = 47; }
impl Counted for crate::wire::WallSetup { const SHAPE: usize = 96; }
impl Counted for crate::wire::Motion { const SHAPE: usize = 57; }
impl Counted for crate::wire::WallParticles { const SHAPE: usize = 95; }
impl Counted for crate::wire::Outflow { const SHAPE: usize = 60; }
impl Counted for crate::wire::Probe { const SHAPE: usize = 71; }
impl Counted for crate::wire::ProbeArgument { const SHAPE: usize = 72; }
impl Counted for crate::wire::Unit { const SHAPE: usize = 93; }
impl Counted for crate::wire::SolidSetup { const SHAPE: usize = 84; }
impl Counted for crate::wire::Substeps { const SHAPE: usize = 89; }
impl Counted for crate::wire::BodySetup { const SHAPE: usize = 10; }
impl Counted for crate::wire::SurfaceLoad { const SHAPE: usize = 91; }
impl Counted for crate::wire::Support { const SHAPE: usize = 90; }
impl Counted for crate::wire::SolidParticles { const SHAPE: usize = 83; }
impl Counted for crate::wire::ContactLaw { const SHAPE: usize = 22; }
impl Counted for crate::wire::DescribeRequest { const SHAPE: usize = 28; }
impl Counted for crate::wire::Description { const SHAPE: usize = 29; }
impl Counted for crate::wire::Capabilities { const SHAPE: usize = 12; }
impl Counted for crate::wire::Limits { const SHAPE: usize = 53; }
impl Counted for crate::wire::OpenRequest { const SHAPE: usize = 59; }
impl Counted for crate::wire::OpenReply { const SHAPE: usize = 58; }
impl Counted for crate::wire::BodyReport { const SHAPE: usize = 9; }
impl Counted for crate::wire::Constants { const SHAPE: usize = 21; }
impl Counted for crate::wire::Fact { const SHAPE: usize = 39; }
impl Counted for crate::wire::LinkRequest { const SHAPE: usize = 55; }
impl Counted for crate::wire::PartnerParticles { const SHAPE: usize = 67; }
impl Counted for crate::wire::PartnerBody { const SHAPE: usize = 66; }
impl Counted for crate::wire::LinkReply { const SHAPE: usize = 54; }
impl Counted for crate::wire::Command { const SHAPE: usize = 20; }
impl Counted for crate::wire::EventBatch { const SHAPE: usize = 35; }
impl Counted for crate::wire::Event { const SHAPE: usize = 34; }
impl Counted for crate::wire::Paused { const SHAPE: usize = 68; }
impl Counted for crate::wire::StepReport { const SHAPE: usize = 87; }
impl Counted for crate::wire::StageBudget { const SHAPE: usize = 85; }
impl Counted for crate::wire::AccountEntry { const SHAPE: usize = 2; }
impl Counted for crate::wire::Energies { const SHAPE: usize = 32; }
impl Counted for crate::wire::EnergyEntry { const SHAPE: usize = 33; }
impl Counted for crate::wire::ProbeRow { const SHAPE: usize = 73; }
impl Counted for crate::wire::SnapshotTaken { const SHAPE: usize = 81; }
impl Counted for crate::wire::Finished { const SHAPE: usize = 44; }
impl Counted for crate::wire::Failed { const SHAPE: usize = 40; }
impl Counted for crate::wire::Beat { const SHAPE: usize = 6; }
impl Counted for crate::wire::Counts { const SHAPE: usize = 24; }
impl Counted for crate::wire::PartCounts { const SHAPE: usize = 64; }
impl Counted for crate::wire::PartCount { const SHAPE: usize = 63; }
impl Counted for crate::wire::Fault { const SHAPE: usize = 42; }
impl Counted for crate::wire::Divergence { const SHAPE: usize = 30; }
impl Counted for crate::wire::Breach { const SHAPE: usize = 11; }
impl Counted for crate::wire::StaleFrame { const SHAPE: usize = 86; }
impl Counted for crate::wire::CoverageGap { const SHAPE: usize = 26; }
impl Counted for crate::wire::ClockDifference { const SHAPE: usize = 17; }
impl Counted for crate::wire::PeerFault { const SHAPE: usize = 69; }
impl Counted for crate::wire::Contradiction { const SHAPE: usize = 23; }
impl Counted for crate::wire::Aborted { const SHAPE: usize = 0; }
impl Counted for crate::wire::SnapshotsRequest { const SHAPE: usize = 82; }
impl Counted for crate::wire::SnapshotChunk { const SHAPE: usize = 78; }
impl Counted for crate::wire::SnapshotHeader { const SHAPE: usize = 80; }
impl Counted for crate::wire::SnapshotField { const SHAPE: usize = 79; }
impl Counted for crate::wire::CheckpointRequest { const SHAPE: usize = 15; }
impl Counted for crate::wire::CheckpointChunk { const SHAPE: usize = 13; }
impl Counted for crate::wire::CheckpointHeader { const SHAPE: usize = 14; }
impl Counted for crate::wire::CheckpointTrailer { const SHAPE: usize = 16; }
impl Counted for crate::wire::RestoreChunk { const SHAPE: usize = 75; }
impl Counted for crate::wire::RestoreReply { const SHAPE: usize = 76; }
impl Counted for crate::wire::CloseRequest { const SHAPE: usize = 19; }
impl Counted for crate::wire::CloseReply { const SHAPE: usize = 18; }
impl Counted for crate::wire::Frame { const SHAPE: usize = 49; }
impl Counted for crate::wire::Acceptance { const SHAPE: usize = 1; }
impl Counted for crate::wire::ParticleSet { const SHAPE: usize = 65; }
impl Counted for crate::wire::Block { const SHAPE: usize = 7; }
impl Counted for crate::wire::PreviousStage { const SHAPE: usize = 70; }
impl Counted for crate::wire::MomentumReport { const SHAPE: usize = 56; }
impl Counted for crate::wire::Farewell { const SHAPE: usize = 41; }
impl Counted for crate::wire::Attempt { const SHAPE: usize = 5; }

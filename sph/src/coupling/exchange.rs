//! What two solvers swap at each half-step, and the trait by which they do.

use serde::{Deserialize, Serialize};

use crate::coupling::ledger::{InterfaceSums, MomentumReport};
use crate::coupling::stage::{StageTime, StepStage};
use crate::space::components::Components;

/// One field of all particles of a frame: `components` numbers per particle, particle by particle.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Column {
    /// Numbers per particle; 0 in an empty column.
    pub components: usize,
    /// The numbers.
    pub values: Vec<f64>,
}

impl Column {
    /// Number of particles.
    pub fn len(&self) -> usize {
        self.values.len() / self.components.max(1)
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// The numbers of each particle.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = &[f64]> {
        self.values.chunks_exact(self.components.max(1))
    }

    /// The numbers of particle `i`.
    #[inline]
    pub fn row(&self, i: usize) -> &[f64] {
        &self.values[i * self.components..(i + 1) * self.components]
    }

    /// Takes over `quantities` in place of what it held.
    #[inline]
    pub fn fill<C: Components>(&mut self, quantities: impl IntoIterator<Item = C>) {
        let quantities = quantities.into_iter();
        self.components = C::COUNT;
        self.values.clear();
        self.values.reserve(C::COUNT * quantities.size_hint().0);
        quantities.for_each(|quantity| self.values.extend_from_slice(quantity.row().as_ref()));
    }

    /// The quantity of each particle; none in a column of another number of components.
    #[inline]
    pub fn quantities<C: Components>(&self) -> impl Iterator<Item = C> {
        self.rows().filter_map(C::of_row)
    }

    /// Replaces what `quantities` held by [`Column::quantities`].
    pub fn read_into<C: Components>(&self, quantities: &mut Vec<C>) {
        quantities.clear();
        quantities.extend(self.quantities::<C>());
    }

    fn clear(&mut self) {
        self.values.clear();
    }
}

impl<C: Components> FromIterator<C> for Column {
    fn from_iter<I: IntoIterator<Item = C>>(quantities: I) -> Self {
        let mut column = Self::default();
        column.fill(quantities);
        column
    }
}

/// States of the particles of one side that may lie within support of the other, ids ascending: what frames carry.
///
/// Solvers work on [`InterfaceStates`](crate::interface::states::InterfaceStates) in the vectors of their space.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StateColumns {
    /// Identity among the sender's particles, strictly ascending.
    pub id: Vec<u32>,
    /// Region (fluid) or body (solid) of each particle.
    pub group: Vec<u32>,
    /// Mass \[kg\].
    pub mass: Vec<f64>,
    /// Position \[m\].
    pub position: Column,
    /// Velocity \[m/s\].
    pub velocity: Column,
    /// Density \[kg/m³\].
    pub density: Vec<f64>,
    /// Pressure \[Pa\]; of a solid, −σ_kk/3 by Eq. (5).
    pub pressure: Vec<f64>,
    /// Cauchy stress σ \[Pa\]: xx, yy, xy in the plane; empty unless the law needs it.
    pub stress: Column,
}

impl StateColumns {
    /// Number of particles.
    pub fn len(&self) -> usize {
        self.id.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.id.is_empty()
    }

    /// Volume of each particle \[m³\].
    pub fn volumes(&self) -> impl Iterator<Item = f64> {
        self.mass.iter().zip(&self.density).map(|(mass, density)| mass / density)
    }

    /// Removes all particles, keeping the allocations.
    pub fn clear(&mut self) {
        let Self { id, group, mass, position, velocity, density, pressure, stress } = self;
        id.clear();
        group.clear();
        [mass, density, pressure].into_iter().for_each(Vec::clear);
        [position, velocity, stress].into_iter().for_each(Column::clear);
    }
}

/// What the frames of one side carry.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FrameContent {
    /// States of particles, for the partner to evaluate the pair law with.
    #[default]
    States,
    /// Coupling points of a solid with force coupling: of its states the fluid uses position, velocity and volume m/ρ.
    CouplingPoints,
    /// The fluid's force on each coupling point of the partner's frame of the same half-step.
    Forces,
}

/// Where one side's particles are: boxes whose union contains all of them that can interact with the other side.
///
/// One bounding box is always valid; finer boxes make the partner send fewer particles.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Extent {
    /// Counts the changes of `boxes`.
    pub version: u64,
    /// Boxes, each the lower corner and then the upper corner \[m\].
    pub boxes: Column,
}

/// One side's message of one half-step.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Half-step to which the states belong.
    pub time: StageTime,
    /// Iteration of the half-step; 0 without implicit coupling.
    pub iteration: u32,
    /// Ends the iterations of a half-step; nothing of such a frame is valid but clock and iteration.
    pub acceptance: Option<Acceptance>,
    /// Which of the following the partner gets.
    pub content: FrameContent,
    /// States of the particles within reach of the partner; not sent with [`FrameContent::Forces`].
    pub states: StateColumns,
    /// With [`FrameContent::Forces`], the force on each of the partner's coupling points \[N\]; otherwise empty.
    pub forces: Column,
    /// Counts the changes of ids, groups and masses: when it is the partner's last, they are not sent again. With
    /// [`FrameContent::Forces`] that of the coupling points on which the forces act.
    pub set_version: u64,
    /// Where the sender's particles are.
    pub extent: Extent,
    /// Version of the partner's extent for which `states` was chosen.
    pub partner_extent_version: u64,
    /// `states` holds every particle of the sender that lies within this distance of that extent \[m\].
    pub reach: f64,
    /// Largest stable next step of the sender \[s\].
    pub time_step_limit: f64,
    /// The sender's interface sums of the half-step before.
    pub previous: Option<PreviousStage>,
}

/// The solid's message that ends the iterations of a half-step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Acceptance {
    /// Whether it converged; otherwise the limit of iterations was reached.
    pub converged: bool,
    /// Largest residual of a body, see [`crate::setup::ImplicitCoupling::tolerance`] \[-\].
    pub residual: f64,
}

/// What a frame reports of the half-step before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PreviousStage {
    /// The half-step.
    pub at: StepStage,
    /// The sender's interface sums.
    pub sums: InterfaceSums,
    /// Digest of the partner frame from which they were computed.
    pub used_digest: u32,
    /// What a solid reports of its momentum.
    pub momentum: Option<MomentumReport>,
}

impl Frame {
    /// A frame of `time` without particles.
    pub fn empty(time: StageTime) -> Self {
        Self {
            time,
            iteration: 0,
            acceptance: None,
            content: FrameContent::States,
            states: StateColumns::default(),
            forces: Column::default(),
            set_version: 0,
            extent: Extent::default(),
            partner_extent_version: 0,
            reach: 0.0,
            time_step_limit: f64::INFINITY,
            previous: None,
        }
    }

    /// Digest of what the partner computes with: half-step, ids, then the columns that are sent, one after the other.
    pub fn digest(&self) -> u32 {
        // Small pieces are many times slower to digest than a full buffer.
        let mut digest = WordDigest { hasher: crc32fast::Hasher::new(), buffer: [0; 4096], used: 0 };
        digest.word(self.time.at.step);
        digest.word(self.time.at.stage as u64);
        let s = &self.states;
        if self.content != FrameContent::Forces {
            s.id.iter().for_each(|id| digest.word(u64::from(*id)));
            digest.numbers(&s.position.values);
            digest.numbers(&s.velocity.values);
        }
        match self.content {
            FrameContent::States => {
                digest.numbers(&s.density);
                digest.numbers(&s.pressure);
                digest.numbers(&s.stress.values);
            }
            FrameContent::CouplingPoints => s.volumes().for_each(|volume| digest.word(volume.to_bits())),
            FrameContent::Forces => digest.numbers(&self.forces.values),
        }
        digest.finish()
    }
}

/// CRC-32 of 64-bit words in little-endian order.
struct WordDigest {
    hasher: crc32fast::Hasher,
    buffer: [u8; 4096],
    used: usize,
}

impl WordDigest {
    #[inline]
    fn word(&mut self, bits: u64) {
        if self.used == self.buffer.len() {
            self.hasher.update(&self.buffer);
            self.used = 0;
        }
        self.buffer[self.used..self.used + 8].copy_from_slice(&bits.to_le_bytes());
        self.used += 8;
    }

    fn numbers(&mut self, numbers: &[f64]) {
        numbers.iter().for_each(|number| self.word(number.to_bits()));
    }

    fn finish(mut self) -> u32 {
        self.hasher.update(&self.buffer[..self.used]);
        self.hasher.finalize()
    }
}

/// Why a partner could not be met.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PeerError {
    /// The partner is gone or unreachable.
    #[error("lost the partner: {0}")]
    Lost(String),
    /// The partner's message was refused.
    #[error("refused the partner's frame: {0}")]
    Refused(String),
    /// The run was stopped while waiting.
    #[error("stopped while waiting for the partner")]
    Cancelled,
}

/// How a solver meets its partner at one half-step: over gRPC, or through a channel inside one process.
pub trait Exchange: Send {
    /// Sends own states; returns before the partner has them.
    ///
    /// # Errors
    /// When the partner can no longer be reached.
    fn send(&mut self, frame: &Frame) -> Result<(), PeerError>;

    /// Waits for the partner's next frame of half-step `at` into `frame`, whose old content may be reused.
    ///
    /// # Errors
    /// When the partner is lost, or sends anything else than this half-step.
    fn receive(&mut self, at: StepStage, frame: &mut Frame) -> Result<(), PeerError>;
}

/// Two ends of an exchange inside one process.
pub fn in_process_pair() -> (InProcess, InProcess) {
    // Lock-step lets one side be one frame ahead at most.
    let (to_b, from_a) = std::sync::mpsc::sync_channel(2);
    let (to_a, from_b) = std::sync::mpsc::sync_channel(2);
    (InProcess { sender: to_b, receiver: from_b }, InProcess { sender: to_a, receiver: from_a })
}

/// One end of an exchange inside one process.
pub struct InProcess {
    sender: std::sync::mpsc::SyncSender<Frame>,
    receiver: std::sync::mpsc::Receiver<Frame>,
}

impl Exchange for InProcess {
    fn send(&mut self, frame: &Frame) -> Result<(), PeerError> {
        self.sender.send(frame.clone()).map_err(|_| PeerError::Lost("its thread has ended".into()))
    }

    fn receive(&mut self, _at: StepStage, frame: &mut Frame) -> Result<(), PeerError> {
        *frame = self.receiver.recv().map_err(|_| PeerError::Lost("its thread has ended".into()))?;
        Ok(())
    }
}

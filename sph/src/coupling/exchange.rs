//! What two solvers swap at each half-step, and the trait by which they do.

use crate::coupling::ledger::{InterfaceSums, MomentumReport};
use crate::coupling::stage::{StageTime, StepStage};
use crate::space::{DIMENSIONS, SymmetricTensor, Vector};

/// States of the particles of one side that may lie within support of the other, ids ascending.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InterfaceStates {
    /// Identity among the sender's particles, strictly ascending.
    pub id: Vec<u32>,
    /// Region (fluid) or body (solid) of each particle.
    pub group: Vec<u32>,
    /// Mass per depth \[kg/m\].
    pub mass: Vec<f64>,
    /// Position \[m\].
    pub position: Vec<Vector>,
    /// Velocity \[m/s\].
    pub velocity: Vec<Vector>,
    /// Density \[kg/m³\].
    pub density: Vec<f64>,
    /// Pressure \[Pa\]; of a solid, −σ_kk/3 by Eq. (5).
    pub pressure: Vec<f64>,
    /// Cauchy stress σ \[Pa\]; empty unless the law needs it.
    pub stress: Vec<SymmetricTensor>,
}

impl InterfaceStates {
    /// Number of particles.
    pub fn len(&self) -> usize {
        self.id.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.id.is_empty()
    }

    /// Volume per depth of particle `i` \[m²\].
    pub fn volume(&self, i: usize) -> f64 {
        self.mass[i] / self.density[i]
    }

    /// Removes all particles, keeping the allocations.
    pub fn clear(&mut self) {
        let Self { id, group, mass, position, velocity, density, pressure, stress } = self;
        id.clear();
        group.clear();
        mass.clear();
        position.clear();
        velocity.clear();
        density.clear();
        pressure.clear();
        stress.clear();
    }
}

/// What the frames of one side carry.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FrameContent {
    /// States of particles, for the partner to evaluate the pair law with.
    #[default]
    States,
    /// Samples of a solid that is coupled by loads: of its states the fluid uses position, velocity and volume m/ρ.
    Samples,
    /// The fluid's force on each sample of the partner's frame of the same half-step.
    Forces,
}

/// Where one side's particles are: boxes whose union holds all of them that can meet the other side.
///
/// One bounding box is always right; finer boxes make the partner send fewer particles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Extent {
    /// Counts the changes of `boxes`.
    pub version: u64,
    /// Boxes as (lower, upper) corners \[m\].
    pub boxes: Vec<(Vector, Vector)>,
}

/// One side's message of one half-step.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Half-step to which the states belong.
    pub time: StageTime,
    /// Repetition of the half-step; 0 unless it is iterated.
    pub iteration: u32,
    /// Ends an iterated half-step: its iteration stands, and of the frame nothing but clock and iteration counts.
    pub acceptance: Option<Acceptance>,
    /// Which of the following the partner gets.
    pub content: FrameContent,
    /// States of the particles within reach of the partner; not sent with [`FrameContent::Forces`].
    pub states: InterfaceStates,
    /// With [`FrameContent::Forces`], the force on each of the partner's samples \[N/m\]; otherwise empty.
    pub forces: Vec<Vector>,
    /// Counts the changes of ids, groups and masses: when it is the partner's last, they are not sent again. With
    /// [`FrameContent::Forces`] that of the samples which the forces belong to.
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

/// The solid's word that an iterated half-step is done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Acceptance {
    /// Whether it has settled to the tolerance; otherwise the limit of iterations was reached.
    pub settled: bool,
    /// Largest residual of a body, see [`crate::setup::Iterate::tolerance`] \[-\].
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
            states: InterfaceStates::default(),
            forces: Vec::new(),
            set_version: 0,
            extent: Extent::default(),
            partner_extent_version: 0,
            reach: 0.0,
            time_step_limit: f64::INFINITY,
            previous: None,
        }
    }

    /// Digest of what the partner computes with: half-step, then ids and state bits, or forces.
    pub fn digest(&self) -> u32 {
        // Small pieces are many times slower to digest than a full buffer.
        let mut digest = WordDigest { hasher: crc32fast::Hasher::new(), buffer: [0; 4096], used: 0 };
        digest.word(self.time.at.step);
        digest.word(self.time.at.stage as u64);
        match self.content {
            FrameContent::States => digest.states(&self.states),
            FrameContent::Samples => digest.samples(&self.states),
            FrameContent::Forces => self.forces.iter().for_each(|force| digest.vector(force)),
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

    fn vector(&mut self, vector: &Vector) {
        vector.iter().for_each(|value| self.word(value.to_bits()));
    }

    #[inline]
    fn motion(&mut self, s: &InterfaceStates, i: usize) {
        self.word(u64::from(s.id[i]));
        for axis in 0..DIMENSIONS {
            self.word(s.position[i][axis].to_bits());
            self.word(s.velocity[i][axis].to_bits());
        }
    }

    fn states(&mut self, s: &InterfaceStates) {
        for i in 0..s.len() {
            self.motion(s, i);
            self.word(s.density[i].to_bits());
            self.word(s.pressure[i].to_bits());
        }
        for stress in &s.stress {
            self.word(stress.xx.to_bits());
            self.word(stress.yy.to_bits());
            self.word(stress.xy.to_bits());
        }
    }

    fn samples(&mut self, s: &InterfaceStates) {
        for i in 0..s.len() {
            self.motion(s, i);
            self.word(s.volume(i).to_bits());
        }
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

//! Kinds of probes, one row each: word, arguments, columns.
//!
//! Case files, set-up messages, `probes.csv` and `docs/parameters.md` read the rows; a solver evaluates a kind.

use std::fmt;

use crate::space::Vector;

/// A named quantity to report at probe times.
#[derive(Clone, Debug, PartialEq)]
pub struct Probe<K> {
    /// Name of the probe.
    pub name: String,
    /// What it reports.
    pub kind: K,
}

/// A probe of the fluid.
pub type FluidProbe = Probe<FluidProbeKind>;

/// A probe of the solids.
pub type SolidProbe = Probe<SolidProbeKind>;

/// The row of a kind of probe.
#[derive(Clone, Copy, Debug)]
pub struct ProbeSpec {
    /// Word in case files and messages.
    pub word: &'static str,
    /// Lines of its meaning.
    meaning: &'static [&'static str],
    /// What it needs to know.
    pub arguments: &'static [ArgumentSpec],
    /// Column suffixes `<quantity>_<unit>` in the order in which values are reported.
    pub columns: &'static [&'static str],
}

impl ProbeSpec {
    /// Its meaning.
    pub fn meaning(&self) -> String {
        let lines: Vec<&str> = self.meaning.iter().map(|line| line.trim()).collect();
        lines.join(" ").replace('\\', "")
    }
}

/// An argument of a kind of probe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ArgumentSpec {
    /// Name in case files and messages, with the unit.
    pub name: &'static str,
    /// Its type.
    pub kind: ArgumentKind,
}

/// Type of an argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ArgumentKind {
    /// A number.
    Number,
    /// A point \[m\].
    Point,
    /// Index of a region, wall, body or support; a case file names it.
    Index,
    /// The same, or none for all.
    OptionalIndex,
}

impl ArgumentKind {
    /// The type in words.
    pub fn text(self) -> &'static str {
        match self {
            Self::Number => "number",
            Self::Point => "point",
            Self::Index => "name",
            Self::OptionalIndex => "name, or all",
        }
    }
}

/// Value of an argument.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Argument {
    /// A number.
    Number(f64),
    /// A point \[m\].
    Point(Vector),
    /// An index.
    Index(u32),
}

/// A type that an argument may have.
trait ArgumentType: Sized {
    const KIND: ArgumentKind;
    fn argument(&self) -> Option<Argument>;
    fn taken(argument: Option<Argument>) -> Option<Self>;
}

impl ArgumentType for f64 {
    const KIND: ArgumentKind = ArgumentKind::Number;

    fn argument(&self) -> Option<Argument> {
        Some(Argument::Number(*self))
    }

    fn taken(argument: Option<Argument>) -> Option<Self> {
        if let Some(Argument::Number(number)) = argument { Some(number) } else { None }
    }
}

impl ArgumentType for Vector {
    const KIND: ArgumentKind = ArgumentKind::Point;

    fn argument(&self) -> Option<Argument> {
        Some(Argument::Point(*self))
    }

    fn taken(argument: Option<Argument>) -> Option<Self> {
        if let Some(Argument::Point(point)) = argument { Some(point) } else { None }
    }
}

impl ArgumentType for u32 {
    const KIND: ArgumentKind = ArgumentKind::Index;

    fn argument(&self) -> Option<Argument> {
        Some(Argument::Index(*self))
    }

    fn taken(argument: Option<Argument>) -> Option<Self> {
        if let Some(Argument::Index(index)) = argument { Some(index) } else { None }
    }
}

impl ArgumentType for Option<u32> {
    const KIND: ArgumentKind = ArgumentKind::OptionalIndex;

    fn argument(&self) -> Option<Argument> {
        self.map(Argument::Index)
    }

    fn taken(argument: Option<Argument>) -> Option<Self> {
        if argument.is_none() { Some(None) } else { u32::taken(argument).map(Some) }
    }
}

/// A closed list of kinds of probes.
pub trait ProbeKind: Clone + PartialEq + fmt::Debug + 'static {
    /// The rows.
    const SPECIFICATIONS: &'static [ProbeSpec];

    /// Word of this kind.
    fn word(&self) -> &'static str;

    /// Names and values of the arguments.
    fn arguments(&self) -> Vec<(&'static str, Argument)>;

    /// The kind `word` with arguments by name; the name of the argument that is missing or of another type, or `kind`
    /// for an unknown word.
    ///
    /// # Errors
    /// There is no such kind, or an argument does not fit.
    fn build(word: &str, argument: impl Fn(&str) -> Option<Argument>) -> Result<Self, &'static str>;

    /// Column suffixes `<quantity>_<unit>` in the order in which values are reported.
    fn columns(&self) -> &'static [&'static str] {
        let word = self.word();
        Self::SPECIFICATIONS.iter().find(|spec| spec.word == word).map_or(&[], |spec| spec.columns)
    }
}

/// Defines kinds of probes: `Variant(argument: type, ..) = "word", [columns];`, with the meaning as doc comment.
macro_rules! probes {
    ($(#[$attribute:meta])* pub enum $name:ident {
        $($(#[doc = $meaning:literal])+ $variant:ident $(($($argument:ident: $type:ty),+))? = $word:literal,
            [$($column:literal),+ $(,)?];)+
    }) => {
        $(#[$attribute])*
        #[derive(Clone, Debug, PartialEq)]
        pub enum $name {
            $($(#[doc = $meaning])+ $variant $(($($type),+))?,)+
        }

        impl ProbeKind for $name {
            const SPECIFICATIONS: &'static [ProbeSpec] = &[$(ProbeSpec {
                word: $word,
                meaning: &[$($meaning),+],
                arguments: &[$($(ArgumentSpec {
                    name: stringify!($argument),
                    kind: <$type as ArgumentType>::KIND,
                },)+)?],
                columns: &[$($column),+],
            },)+];

            fn word(&self) -> &'static str {
                match self {
                    $(Self::$variant { .. } => $word,)+
                }
            }

            fn arguments(&self) -> Vec<(&'static str, Argument)> {
                let all: Vec<(&'static str, Option<Argument>)> = match self {
                    $(Self::$variant $(($($argument),+))? =>
                        vec![$($((stringify!($argument), $argument.argument()),)+)?],)+
                };
                all.into_iter().filter_map(|(name, argument)| Some((name, argument?))).collect()
            }

            fn build(word: &str, argument: impl Fn(&str) -> Option<Argument>) -> Result<Self, &'static str> {
                match word {
                    $($word => Ok(Self::$variant $(($(
                        <$type>::taken(argument(stringify!($argument))).ok_or(stringify!($argument))?
                    ),+))?),)+
                    _ => Err("kind"),
                }
            }
        }
    };
}

probes! {
    /// What a fluid probe reports. Sums are per metre of depth.
    pub enum FluidProbeKind {
        /// Shepard means of pressure and velocity over the fluid in the support of a point; zero where there is none.
        Point(at_m: Vector) = "fluid-point", ["pressure_pa", "velocity_x_m_s", "velocity_y_m_s"];
        /// Highest connected fluid at an x; not a number where it is dry.
        WaterLevel(x_m: f64) = "water-level", ["level_m"];
        /// 99.5 percentile of x of the connected fluid.
        Front = "front", ["front_x_m"];
        /// Mass, momentum, energies, and second moments about the centre of mass, of a region or of all fluid.
        Region(region: Option<u32>) = "fluid-sums", [
            "mass_kg_per_m", "momentum_x_kg_per_s", "momentum_y_kg_per_s", "angular_momentum_kg_m_per_s",
            "kinetic_energy_j_per_m", "potential_energy_j_per_m", "compression_energy_j_per_m", "centre_x_m",
            "centre_y_m", "second_moment_xx_m2", "second_moment_yy_m2", "second_moment_xy_m2",
        ];
        /// Volume flux of the fluid through a segment, positive to the right of the way from its first to its second
        /// point: Σ V_j v_j·n ∫ W(|x − x_j|) ds; zero where it is dry.
        FlowRate(from_m: Vector, to_m: Vector) = "flow-rate", ["flow_rate_m2_s"];
        /// Force of the fluid on a wall.
        WallForce(wall: u32) = "wall-force", ["force_x_n_per_m", "force_y_n_per_m"];
        /// Number of fluid particles inside solids: those with Σ V W > 1/2 over solid particles, as of the last corrector.
        Immersed = "immersed-fluid", ["immersed_count"];
    }
}

probes! {
    /// What a solid probe reports. Sums are per metre of depth.
    pub enum SolidProbeKind {
        /// Displacement, velocity, stress, its invariants and the strain energy of the material at a point of the
        /// undeformed body; principal stresses are those in the plane.
        MaterialPoint(body: u32, at_m: Vector) = "material-point", [
            "displacement_x_m", "displacement_y_m", "velocity_x_m_s", "velocity_y_m_s", "stress_xx_pa", "stress_yy_pa",
            "stress_xy_pa", "von_mises_pa", "principal_largest_pa", "principal_smallest_pa",
            "strain_energy_density_j_per_m3",
        ];
        /// Centre of mass, velocity, angle and angular velocity of a body.
        Motion(body: u32) = "body-motion", [
            "centre_x_m", "centre_y_m", "velocity_x_m_s", "velocity_y_m_s", "angle_rad", "angular_velocity_rad_s",
        ];
        /// Force of the fluid on a body.
        BodyForce(body: u32) = "body-force", ["force_x_n_per_m", "force_y_n_per_m"];
        /// Reaction of a support on its body.
        Reaction(body: u32, support: u32) = "support-reaction", ["force_x_n_per_m", "force_y_n_per_m"];
        /// Mass, momentum, energies, and second moments about the centre of mass, of a body or of all.
        Sums(body: Option<u32>) = "body-sums", [
            "mass_kg_per_m", "momentum_x_kg_per_s", "momentum_y_kg_per_s", "angular_momentum_kg_m_per_s",
            "kinetic_energy_j_per_m", "potential_energy_j_per_m", "strain_energy_j_per_m", "centre_x_m", "centre_y_m",
            "second_moment_xx_m2", "second_moment_yy_m2", "second_moment_xy_m2",
        ];
        /// Smallest distance from a particle of a body, or of any, to one of another body, and from one that no support
        /// holds to one of a wall; not a number beyond three spacings.
        Gap(body: Option<u32>) = "gap", ["gap_body_m", "gap_wall_m"];
        /// Contact of a body, or of all: forces of other bodies and of walls on it, deepest penetration so far of it
        /// into others or of others into it, and the sum over its particles and time of the magnitudes of the forces.
        Contact(body: Option<u32>) = "contact", [
            "contact_bodies_x_n_per_m", "contact_bodies_y_n_per_m", "contact_walls_x_n_per_m",
            "contact_walls_y_n_per_m", "deepest_m", "impulse_n_s_per_m",
        ];
    }
}

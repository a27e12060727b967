//! Kinds of probes, one row each: word, arguments, columns.
//!
//! Case files, set-up messages, `probes.csv` and `docs/parameters.md` read the rows; a solver evaluates a kind.

use std::fmt;

use crate::space::{Plane, Space};

/// A named quantity to report at probe times.
#[derive(Clone, Debug, PartialEq)]
pub struct Probe<K> {
    /// Name of the probe.
    pub name: String,
    /// What it reports.
    pub kind: K,
}

/// A probe of the fluid.
pub type FluidProbe<S = Plane> = Probe<FluidProbeKind<S>>;

/// A probe of the solids.
pub type SolidProbe<S = Plane> = Probe<SolidProbeKind<S>>;

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
pub enum Argument<S: Space = Plane> {
    /// A number.
    Number(f64),
    /// A point \[m\].
    Point(S::Vector),
    /// An index.
    Index(u32),
}

impl<S: Space> Argument<S> {
    fn number(self) -> Option<f64> {
        if let Self::Number(number) = self { Some(number) } else { None }
    }

    fn point(self) -> Option<S::Vector> {
        if let Self::Point(point) = self { Some(point) } else { None }
    }

    fn index(self) -> Option<u32> {
        if let Self::Index(index) = self { Some(index) } else { None }
    }
}

/// A closed list of kinds of probes.
pub trait ProbeKind: Clone + PartialEq + fmt::Debug + 'static {
    /// The space that is probed.
    type In: Space;

    /// The rows.
    const SPECIFICATIONS: &'static [ProbeSpec];

    /// Word of this kind.
    fn word(&self) -> &'static str;

    /// Names and values of the arguments.
    fn arguments(&self) -> Vec<(&'static str, Argument<Self::In>)>;

    /// The kind `word` with arguments by name; the name of the argument that is missing or of another type, or `kind`
    /// for an unknown word.
    ///
    /// # Errors
    /// There is no such kind, or an argument does not fit.
    fn build(word: &str, argument: impl Fn(&str) -> Option<Argument<Self::In>>)
    -> Result<Self, &'static str>;

    /// Column suffixes `<quantity>_<unit>` in the order in which values are reported.
    fn columns(&self) -> &'static [&'static str] {
        let word = self.word();
        Self::SPECIFICATIONS.iter().find(|spec| spec.word == word).map_or(&[], |spec| spec.columns)
    }
}

/// Types of arguments as rows name them.
type Number = f64;
type Point<S> = <S as Space>::Vector;
type Index = u32;
type OptionalIndex = Option<u32>;

/// Kind of the argument of a row, a value as argument, and the way back.
macro_rules! argument {
    (kind $kind:ident) => {
        ArgumentKind::$kind
    };
    (value Number $value:ident) => {
        Some(Argument::Number(*$value))
    };
    (value Point $value:ident) => {
        Some(Argument::Point(*$value))
    };
    (value Index $value:ident) => {
        Some(Argument::Index(*$value))
    };
    (value OptionalIndex $value:ident) => {
        $value.map(Argument::Index)
    };
    (taken Number $argument:expr) => {
        $argument.and_then(Argument::number)
    };
    (taken Point $argument:expr) => {
        $argument.and_then(Argument::point)
    };
    (taken Index $argument:expr) => {
        $argument.and_then(Argument::index)
    };
    (taken OptionalIndex $argument:expr) => {
        match $argument {
            None => Some(None),
            Some(argument) => argument.index().map(Some),
        }
    };
}

/// Columns in the plane and in space: the same where a row states one list.
macro_rules! columns {
    ($($column:literal),+) => { &[$($column),+] };
    ($($column:literal),+; $($spatial:literal),+) => {
        if S::DIMENSIONS == 2 { &[$($column),+] } else { &[$($spatial),+] }
    };
}

/// Defines kinds of probes: `Variant(argument: type, ..) = "word", [columns], in space [columns];`, with the meaning as doc
/// comment; `in space` only where the columns differ there.
macro_rules! probes {
    ($(#[$attribute:meta])* pub enum $name:ident {
        $($(#[doc = $meaning:literal])+ $variant:ident $(($($argument:ident: $kind:ident $(<$space:ident>)?),+))? = $word:literal,
            [$($column:literal),+ $(,)?] $(, in space [$($spatial:literal),+ $(,)?])?;)+
    }) => {
        $(#[$attribute])*
        #[derive(Clone, Debug, PartialEq)]
        pub enum $name<S: Space = Plane> {
            $($(#[doc = $meaning])+ $variant $(($($kind $(<$space>)?),+))?,)+
        }

        impl<S: Space> ProbeKind for $name<S> {
            type In = S;

            const SPECIFICATIONS: &'static [ProbeSpec] = &[$(ProbeSpec {
                word: $word,
                meaning: &[$($meaning),+],
                arguments: &[$($(ArgumentSpec { name: stringify!($argument), kind: argument!(kind $kind) },)+)?],
                columns: columns!($($column),+ $(; $($spatial),+)?),
            },)+];

            fn word(&self) -> &'static str {
                match self {
                    $(Self::$variant { .. } => $word,)+
                }
            }

            fn arguments(&self) -> Vec<(&'static str, Argument<S>)> {
                let all: Vec<(&'static str, Option<Argument<S>>)> = match self {
                    $(Self::$variant $(($($argument),+))? =>
                        vec![$($((stringify!($argument), argument!(value $kind $argument)),)+)?],)+
                };
                all.into_iter().filter_map(|(name, argument)| Some((name, argument?))).collect()
            }

            fn build(
                word: &str,
                argument: impl Fn(&str) -> Option<Argument<S>>,
            ) -> Result<Self, &'static str> {
                match word {
                    $($word => Ok(Self::$variant $(($(
                        argument!(taken $kind argument(stringify!($argument))).ok_or(stringify!($argument))?
                    ),+))?),)+
                    _ => Err("kind"),
                }
            }
        }
    };
}

probes! {
    /// What a fluid probe reports. Sums are per metre of depth in the plane.
    pub enum FluidProbeKind {
        /// Pressure and velocity at a point, means over the fluid in its support; the pressure follows the body force to the point,
        /// on the face of a wall too. Zero where there is no fluid.
        Point(at_m: Point<S>) = "fluid-point", ["pressure_pa", "velocity_x_m_s", "velocity_y_m_s"],
            in space ["pressure_pa", "velocity_x_m_s", "velocity_y_m_s", "velocity_z_m_s"];
        /// Highest connected fluid at an x; not a number where it is dry.
        WaterLevel(x_m: Number) = "water-level", ["level_m"];
        /// Free surface along an axis: the farthest place against gravity, at the highest coordinate where gravity does
        /// not act along the axis, of the connected fluid within a spacing of the line along it through a point; not a
        /// number where that is dry.
        Gauge(at_m: Point<S>, axis: Index) = "gauge", ["level_m"];
        /// 99.5 percentile of x of the connected fluid.
        Front = "front", ["front_x_m"];
        /// Mass, momentum, energies, and second moments about the centre of mass, of a region or of all fluid.
        Region(region: OptionalIndex) = "fluid-sums", [
            "mass_kg_per_m", "momentum_x_kg_per_s", "momentum_y_kg_per_s", "angular_momentum_kg_m_per_s",
            "kinetic_energy_j_per_m", "potential_energy_j_per_m", "compression_energy_j_per_m", "centre_x_m",
            "centre_y_m", "second_moment_xx_m2", "second_moment_yy_m2", "second_moment_xy_m2",
        ], in space [
            "mass_kg", "momentum_x_kg_m_per_s", "momentum_y_kg_m_per_s", "momentum_z_kg_m_per_s",
            "angular_momentum_x_kg_m2_per_s", "angular_momentum_y_kg_m2_per_s", "angular_momentum_z_kg_m2_per_s",
            "kinetic_energy_j", "potential_energy_j", "compression_energy_j", "centre_x_m", "centre_y_m", "centre_z_m",
            "second_moment_xx_m2", "second_moment_yy_m2", "second_moment_zz_m2", "second_moment_xy_m2",
            "second_moment_yz_m2", "second_moment_xz_m2",
        ];
        /// Volume flux of the fluid through a segment, positive to the right of the way from its first to its second
        /// point: Σ V_j v_j·n ∫ W(|x − x_j|) ds; zero where it is dry.
        FlowRate(from_m: Point<S>, to_m: Point<S>) = "flow-rate", ["flow_rate_m2_s"];
        /// Volume flux of the fluid in space through the parallelogram with a corner and the two corners next to it, positive
        /// along (first − corner) × (second − corner): Σ V_j v_j·n ∫ W(|x − x_j|) dA; zero where it is dry.
        SurfaceFlux(corner_m: Point<S>, first_m: Point<S>, second_m: Point<S>) = "surface-flux", ["flow_rate_m3_s"];
        /// Force of the fluid on a wall.
        WallForce(wall: Index) = "wall-force", ["force_x_n_per_m", "force_y_n_per_m"],
            in space ["force_x_n", "force_y_n", "force_z_n"];
        /// Number of fluid particles inside solids: those with Σ V W > 1/2 over solid particles, as of the last corrector.
        Immersed = "immersed-fluid", ["immersed_count"];
    }
}

probes! {
    /// What a solid probe reports. Sums are per metre of depth in the plane.
    pub enum SolidProbeKind {
        /// Displacement, velocity, stress, its invariants and the strain energy of the material at a point of the
        /// undeformed body; principal stresses are those in the plane.
        MaterialPoint(body: Index, at_m: Point<S>) = "material-point", [
            "displacement_x_m", "displacement_y_m", "velocity_x_m_s", "velocity_y_m_s", "stress_xx_pa", "stress_yy_pa",
            "stress_xy_pa", "von_mises_pa", "principal_largest_pa", "principal_smallest_pa",
            "strain_energy_density_j_per_m3",
        ], in space [
            "displacement_x_m", "displacement_y_m", "displacement_z_m", "velocity_x_m_s", "velocity_y_m_s",
            "velocity_z_m_s", "stress_xx_pa", "stress_yy_pa", "stress_zz_pa", "stress_xy_pa", "stress_yz_pa",
            "stress_xz_pa", "von_mises_pa", "principal_largest_pa", "principal_smallest_pa",
            "strain_energy_density_j_per_m3",
        ];
        /// Centre of mass, velocity, angle and angular velocity of a body.
        Motion(body: Index) = "body-motion", [
            "centre_x_m", "centre_y_m", "velocity_x_m_s", "velocity_y_m_s", "angle_rad", "angular_velocity_rad_s",
        ], in space [
            "centre_x_m", "centre_y_m", "centre_z_m", "velocity_x_m_s", "velocity_y_m_s", "velocity_z_m_s",
            "quaternion_w", "quaternion_x", "quaternion_y", "quaternion_z", "angular_velocity_x_rad_s",
            "angular_velocity_y_rad_s", "angular_velocity_z_rad_s",
        ];
        /// Force of the fluid on a body.
        BodyForce(body: Index) = "body-force", ["force_x_n_per_m", "force_y_n_per_m"],
            in space ["force_x_n", "force_y_n", "force_z_n"];
        /// Reaction of a support on its body.
        Reaction(body: Index, support: Index) = "support-reaction", ["force_x_n_per_m", "force_y_n_per_m"],
            in space ["force_x_n", "force_y_n", "force_z_n"];
        /// Mass, momentum, energies, and second moments about the centre of mass, of a body or of all.
        Sums(body: OptionalIndex) = "body-sums", [
            "mass_kg_per_m", "momentum_x_kg_per_s", "momentum_y_kg_per_s", "angular_momentum_kg_m_per_s",
            "kinetic_energy_j_per_m", "potential_energy_j_per_m", "strain_energy_j_per_m", "centre_x_m", "centre_y_m",
            "second_moment_xx_m2", "second_moment_yy_m2", "second_moment_xy_m2",
        ], in space [
            "mass_kg", "momentum_x_kg_m_per_s", "momentum_y_kg_m_per_s", "momentum_z_kg_m_per_s",
            "angular_momentum_x_kg_m2_per_s", "angular_momentum_y_kg_m2_per_s", "angular_momentum_z_kg_m2_per_s",
            "kinetic_energy_j", "potential_energy_j", "strain_energy_j", "centre_x_m", "centre_y_m", "centre_z_m",
            "second_moment_xx_m2", "second_moment_yy_m2", "second_moment_zz_m2", "second_moment_xy_m2",
            "second_moment_yz_m2", "second_moment_xz_m2",
        ];
        /// Smallest distance from a particle of a body, or of any, to one of another body, and from one that no support
        /// holds to one of a wall; not a number beyond three spacings.
        Gap(body: OptionalIndex) = "gap", ["gap_body_m", "gap_wall_m"];
        /// Contact of a body, or of all: forces of other bodies and of walls on it, deepest penetration so far of it
        /// into others or of others into it, and the sum over its particles and time of the magnitudes of the forces.
        Contact(body: OptionalIndex) = "contact", [
            "contact_bodies_x_n_per_m", "contact_bodies_y_n_per_m", "contact_walls_x_n_per_m",
            "contact_walls_y_n_per_m", "deepest_m", "impulse_n_s_per_m",
        ], in space [
            "contact_bodies_x_n", "contact_bodies_y_n", "contact_bodies_z_n", "contact_walls_x_n", "contact_walls_y_n",
            "contact_walls_z_n", "deepest_m", "impulse_n_s",
        ];
    }
}

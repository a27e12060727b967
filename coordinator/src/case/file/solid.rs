//! Solids, their sub-steps and contact as a case file writes them.

use serde::Serialize;
use sph::setup::{
    Choice, ContactKind, ContactLaw, LARGEST_CONTACT_DISTANCE, RepulsionParameters, SolidStepping,
    SubstepCount,
};

use super::Preset;
use super::body::{BODY, BodyTable};
use super::fluid::{DAMPING, DampingTable, FluidTable};
use super::material::{BodyDefaults, FormulationTable};
use crate::case::errors::CaseError;
use crate::case::reader::{Allowed, At, Parameters, Table};
use crate::case::spec::{Kind, SetSpec, TableSpec, Variant, Variants, key};

/// Rows of `[solid]`.
pub static SOLID: TableSpec = TableSpec::new(
    "solid",
    "The solids.",
    &[
        key("particle_spacing_m", Kind::Number(Allowed::POSITIVE), "particle spacing Δx of the solids")
            .or_else("the fluid's; must be written without a fluid"),
        key(
            "kernel_ratio",
            Kind::Number(Allowed::KERNEL_RATIO),
            "kernel ratio h/Δx of updated-Lagrangian bodies and of contact by sums",
        )
        .or(1.3),
        key(
            "lost_particle_limit",
            Kind::Count(0, 1_000_000_000),
            "particles that may leave the domain; the run ends when more have left",
        )
        .or_count(0),
        DAMPING,
        key(
            "substeps",
            Kind::CountOrWord(
                2,
                10_000,
                &[
                    ("auto", "as many as the solid's stability limit requires"),
                    ("none", "the stage rule, Eq. (30)-(31)"),
                ],
            ),
            "sub-steps of the solids per step, an even number",
        )
        .or_else("\"auto\" with a total-Lagrangian or rigid body, else \"none\""),
        key("contact", Kind::Table(&CONTACT), "how bodies touch each other and walls").or_else("repulsion"),
        key("body", Kind::Tables(&BODY), "the bodies").or_else("none"),
    ],
);

/// Rows of `contact`.
static CONTACT: TableSpec = TableSpec::new("contact", "How bodies touch each other and walls.", &[]).by(
    Variants::new("law", "contact law", &[
        Variant::new("repulsion", "repulsion by the depth in the other that never pulls", &[key(
            "gap_m",
            Kind::Number(Allowed::NOT_NEGATIVE),
            "in place of `distance`: the gap that faces keep when they touch, as rough faces do; at most nine spacings",
        )
        .or_else("`distance` holds")])
        .with_set(SetSpec::of::<RepulsionParameters>(&[("distance", "2 in a case with a fluid, else 1")])),
        Variant::new("sums", "that of the source paper: bodies interact through the sums (22)", &[]),
    ])
    .or_else("\"repulsion\"; \"sums\" with the preset \"paper\""),
);

/// `[solid]`.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)]
pub struct SolidTable {
    pub particle_spacing_m: At<f64>,
    pub kernel_ratio: At<f64>,
    pub lost_particle_limit: u64,
    pub substeps: SubstepsKey,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damping: Option<DampingTable>,
    pub contact: ContactTable,
    #[serde(rename = "body")]
    pub bodies: Vec<BodyTable>,
    #[serde(skip)]
    pub intact: bool,
}

impl SolidTable {
    /// Reads the table; the spacing is the fluid's unless it is written.
    pub fn read(mut table: Table<'_>, fluid: Option<&FluidTable>, preset: Preset) -> Self {
        let particle_spacing_m = match fluid {
            Some(fluid) => table.number_or("particle_spacing_m", fluid.parameters.particle_spacing),
            None => table.number("particle_spacing_m"),
        };
        let known_spacing = table.has("particle_spacing_m") || fluid.is_none_or(FluidTable::lattice_intact);
        let kernel_ratio = table.number("kernel_ratio");
        let lost_particle_limit = table.count("lost_particle_limit").value;
        let damping = DampingTable::read(&mut table);
        let substeps = SubstepsKey::read(&mut table);
        let intact = table.intact() && known_spacing;
        let spacing = intact.then_some(particle_spacing_m.value);
        let contact = ContactTable::read(table.table_or_empty("contact"), preset, fluid.is_some(), spacing);
        let intact = intact && table.intact();
        let defaults = BodyDefaults { preset, kernel_ratio: kernel_ratio.value, is_wet: fluid.is_some() };
        let bodies: Vec<BodyTable> =
            table.tables("body").into_iter().map(|body| BodyTable::read(body, defaults)).collect();
        let updated = |body: &BodyTable| matches!(body.formulation, FormulationTable::UpdatedLagrangian(_));
        let word = if bodies.iter().all(updated) { SubstepsWord::None } else { SubstepsWord::Auto };
        let substeps = substeps.unwrap_or(SubstepsKey::Word(word));
        table.finish();
        Self {
            particle_spacing_m,
            kernel_ratio,
            lost_particle_limit,
            damping,
            substeps,
            contact,
            bodies,
            intact,
        }
    }

    /// Widest smoothing length of all bodies \[m\].
    pub fn smoothing_length(&self) -> f64 {
        let widest =
            self.bodies.iter().filter_map(BodyTable::kernel_ratio).fold(self.kernel_ratio.value, f64::max);
        widest * self.particle_spacing_m.value
    }
}

/// `substeps`: a number, or how it is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(untagged)]
#[allow(missing_docs)]
pub enum SubstepsKey {
    Count(u32),
    Word(SubstepsWord),
}

/// Words of `substeps`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[allow(missing_docs)]
pub enum SubstepsWord {
    None,
    Auto,
}

impl SubstepsKey {
    fn read(table: &mut Table<'_>) -> Option<Self> {
        const WORDS: [(&str, SubstepsWord); 2] = [("auto", SubstepsWord::Auto), ("none", SubstepsWord::None)];
        let found = table.optional_count_or_word("substeps", &WORDS)?;
        let count = match found {
            Err(word) => return Some(Self::Word(word.value)),
            Ok(count) => u32::try_from(count).ok()?,
        };
        if count % 2 != 0 {
            let error = CaseError::new(&table.place_of("substeps"), "not an even number").value(count);
            table.error(error.allowed("an even number from 2 to 10000, \"auto\" or \"none\""));
            return None;
        }
        Some(Self::Count(count))
    }

    /// Set-up of the solvers.
    pub fn to_setup(self) -> SolidStepping {
        match self {
            Self::Count(count) => SolidStepping::Substeps(SubstepCount::Fixed(count)),
            Self::Word(SubstepsWord::Auto) => SolidStepping::Substeps(SubstepCount::Automatic),
            Self::Word(SubstepsWord::None) => SolidStepping::StageRule,
        }
    }
}

/// Default contact distance in water in particle spacings \[-\]: a row of water fits between. Where bodies are thrown about, less
/// crushes particles that cannot drain.
const WET_DISTANCE: f64 = 2.0;

/// `[solid.contact]`.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "law", rename_all = "kebab-case")]
#[allow(missing_docs)]
pub enum ContactTable {
    Repulsion(Parameters<RepulsionParameters>),
    Sums,
}

impl ContactTable {
    /// Reads the table; `spacing` \[m\] of the solids, if it is known.
    fn read(mut table: Table<'_>, preset: Preset, is_wet: bool, spacing: Option<f64>) -> Self {
        let default = if preset == Preset::Paper { ContactKind::Sums } else { ContactKind::Repulsion };
        let read = match table.choice_or("law", ContactKind::NAMES, default).value {
            ContactKind::Sums => Self::Sums,
            ContactKind::Repulsion => {
                let base = preset.values::<RepulsionParameters>();
                let by_gap = Self::distance_of_gap(&mut table, spacing);
                let distance = by_gap.unwrap_or(if is_wet { WET_DISTANCE } else { base.distance });
                Self::Repulsion(table.parameters(RepulsionParameters { distance, ..base }, &[]))
            }
        };
        table.finish();
        read
    }

    /// The contact distance \[-\] at which the outer rows of two bodies keep their faces `gap_m` apart.
    fn distance_of_gap(table: &mut Table<'_>, spacing: Option<f64>) -> Option<f64> {
        let gap = table.optional_number("gap_m")?;
        let place = table.place_of("gap_m");
        if table.has("distance") {
            let error = CaseError::new(&place, "stands beside `distance`, which it takes the place of");
            table.error(error.value(gap).hint("leave out one of the two"));
            return None;
        }
        let spacing = spacing?;
        let distance = 1.0 + gap / spacing;
        if distance > LARGEST_CONTACT_DISTANCE {
            let largest = (LARGEST_CONTACT_DISTANCE - 1.0) * spacing;
            let error = CaseError::new(&place, "is more particles wide than contact reaches").value(gap);
            table.error(error.allowed(format!("up to {largest} m, nine spacings of the solids")));
            return None;
        }
        Some(distance)
    }

    /// Set-up of the solvers.
    pub fn to_setup(&self) -> ContactLaw {
        match self {
            Self::Repulsion(set) => ContactLaw::Repulsion(set.values()),
            Self::Sums => ContactLaw::Sums,
        }
    }
}

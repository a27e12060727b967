//! A case without a run.

mod preview;
mod text;

pub use preview::draw;

use std::path::Path;

use proto::service::{SetupProblems, SolverFactory, open_checked};
use sph::coupling::solver::Role;
use sph::setup::ParticipantSetup;

use crate::case::overrides::Override;
use crate::case::{Case, Server, Summary};
use crate::failure::Failure;

/// A case that a run accepts.
pub struct Checked {
    /// The case.
    pub case: Case,
    /// What a run of it would do.
    pub summary: Summary,
}

/// Checks the case file at `path` with `overrides` set over its values, as a run does before its first step.
///
/// # Errors
/// All errors of the file and of the overrides, and all that a built-in solver refuses.
pub fn check(path: &Path, overrides: &[Override]) -> Result<Checked, Failure> {
    let case = crate::run::load_with(path, overrides)?;
    crate::run::memory::check(&case)?;
    let opened = open(&case)?;
    for (role, limit) in opened.limits {
        case.check_stated_limit(role, limit)?;
    }
    let mut summary = case.summary();
    summary.warnings.extend(opened.remarks);
    summary.warnings.extend(opened.left_out);
    Ok(Checked { case, summary })
}

/// Memory of the solvers for each particle \[bytes\], measured; solids keep the pairs of their reference.
const FLUID_BYTES: usize = 130;
const SOLID_BYTES: usize = 1000;

/// Most memory that a check takes for a solver \[bytes\].
const MOST_BYTES: usize = 400 << 20;

/// What the solvers of this program say of a case.
#[derive(Clone, Debug, Default)]
pub struct Opened {
    /// Largest step \[s\] that each states for the start.
    pub limits: Vec<(Role, f64)>,
    /// What deserves a second look about the start, in words.
    pub remarks: Vec<String>,
    /// Solvers that were not asked, in words.
    pub left_out: Vec<String>,
}

/// Builds the solvers of this program for `case` as `Open` does at the start of a run; solvers that the case names are
/// left out, and those of scenes so large that a check would need much memory.
///
/// # Errors
/// All that a solver refuses.
pub fn open(case: &Case) -> Result<Opened, Failure> {
    let Opened { mut limits, mut remarks, mut left_out } = Opened::default();
    let [fluid, solid] = case.particles();
    let walls = case.wall_particles();
    let mut asked = |role: Role, server: &Server, bytes: usize| {
        let small = bytes <= MOST_BYTES;
        if *server == Server::BuiltIn && !small {
            let size = bytes >> 20;
            left_out.push(format!(
                "the {role} solver is asked when a run starts, not now: it needs some {size} MiB"
            ));
        }
        *server == Server::BuiltIn && small
    };
    // One after the other: each needs memory.
    if case.has(Role::Fluid) && asked(Role::Fluid, &case.servers.fluid, FLUID_BYTES * (fluid + walls)) {
        let setup = case.fluid_setup().map(ParticipantSetup::Fluid);
        limits.extend(try_open(Role::Fluid, &fluid_server::FluidFactory::default(), setup, &mut remarks)?);
    }
    if case.has(Role::Solid)
        && asked(Role::Solid, &case.servers.solid, SOLID_BYTES * solid + FLUID_BYTES * walls)
    {
        let setup = case.solid_setup().map(ParticipantSetup::Solid);
        limits.extend(try_open(Role::Solid, &solid_server::SolidFactory, setup, &mut remarks)?);
    }
    Ok(Opened { limits, remarks, left_out })
}

fn try_open(
    role: Role,
    factory: &impl SolverFactory,
    setup: Option<ParticipantSetup>,
    remarks: &mut Vec<String>,
) -> Result<Option<(Role, f64)>, Failure> {
    let Some(setup) = setup else { return Ok(None) };
    let (opened, limit) = open_checked(factory, setup).map_err(|SetupProblems(problems)| {
        Failure::input(format!("the {role} solver refuses the case:\n  {}", problems.join("\n  ")))
    })?;
    remarks.extend(opened.solver.remarks());
    Ok(Some((role, limit)))
}

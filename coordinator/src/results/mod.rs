//! Everything a run leaves behind: tables, particle files, final states, summary and report.
//!
//! | file | written by | content |
//! |---|---|---|
//! | `probes.csv` | [`probes`] | every probe over time |
//! | `ledger.csv` | [`ledger`] | what crossed the interface, and whether it balances |
//! | `snapshots/` | [`snapshots`], [`vtk`] | particle fields for ParaView and PyVista, one `.pvd` per side and one of all |
//! | `final/*.state` | [`state`] | all particles with full precision, from which another run can start |
//! | `divergence.csv` | [`neighbourhood`] | the offending particle of a run that broke down, and those around it |
//! | `summary.json` | [`summary`] | verdict and figures of the run |
//! | `report.html` | [`report`] | pictures and facts in one file |
//!
//! A file is written beside its place and renamed when complete, so that no half-written file looks complete. Tables
//! that grow during a run are called `*.partial` until the run ends, and the folder holds [`names::MARKER`] until
//! all of its outputs are complete.

pub mod directory;
pub(crate) mod earlier;
pub mod energy;
pub mod error;
pub mod files;
pub mod font;
pub mod ledger;
pub mod ledger_sums;
mod marker;
pub mod matched_step;
pub mod names;
pub mod neighbourhood;
pub mod plots;
pub mod probes;
pub mod process;
pub mod progress;
pub mod quality;
pub mod recorder;
pub mod report;
pub mod snapshots;
pub mod state;
pub mod summary;
pub mod table;
pub mod tally;
pub mod vtk;
pub mod writer;

//! The page that shows a run: one application, fed by data inside `report.html` or by a server on this machine.
//!
//! | module | what it does |
//! |---|---|
//! | [`vtp`] | reads the particle files of a run |
//! | [`folder`] | snapshots of a finished or running folder, both sides and walls at one time |
//! | [`particles`] | what the page shows of a particle; thinning |
//! | [`packing`] | frames of particles as few bytes |
//! | [`scene`] | window, groups, fields and colour scales, the same for all frames |
//! | [`film`] | all frames of a finished run within a size |
//! | [`plots`], [`story`] | lines over time, key figures, the result in a sentence |
//! | [`run`] | the messages that the page reads |
//! | [`document`] | the HTML |
//! | [`live`] | what a run of this process says of itself |
//! | [`server`] | HTTP on loopback: `run --view` and `view` |
//!
//! The page needs snapshots, tables and `summary.json` of a folder, and nothing of the solvers: it reads what a run
//! writes anyway, so a run with a page does the same as one without.

pub mod document;
pub mod film;
pub mod folder;
pub mod live;
pub mod packing;
pub mod particles;
pub mod plots;
pub mod run;
pub mod scene;
pub mod server;
pub mod story;
pub mod vtp;

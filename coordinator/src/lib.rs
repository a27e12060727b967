//! The coordinator: reads case files, starts and steps the solvers in lock-step, audits their interface, writes results.
//!
//! | module | what it does |
//! |---|---|
//! | [`case`] | case files: parse once, all errors at once |
//! | [`run`] | a run: solvers as servers or threads, control of their steps, checkpoint times |
//! | [`results`] | everything that a run writes |
//! | [`checkpoint`] | states from which a run continues |
//! | [`resume`], [`replay`], [`check`], [`conform`] | the other commands |
//! | [`page`] | the page that shows a run, in `report.html` and live |
//! | [`messages`], [`failure`], [`quote`], [`brief`] | what is printed and returned |
//! | [`new`] | case files to start from |
//! | [`batch`] | many runs of one case, several at a time, kept when finished |
//! | [`family`] | one case at several spacings, sound speeds and seeds |
//! | [`sweep`], [`overlay`] | a case over values of its keys; finished runs side by side |
//! | [`study`] | what accuracy costs: `report` |
//! | [`cli`] | the command line, which nothing else depends on |
//!
//! It computes no force.
//!
//! A run is a function: a request in, an outcome out.
//!
//! ```no_run
//! use coordinator::run::{RunOptions, RunRequest, run};
//!
//! let request = RunRequest {
//!     case: "cases/drifting_body_coarse.toml".into(),
//!     out: Some("results/drifting_body".into()),
//!     options: RunOptions { threads: Some(2), ..RunOptions::default() },
//!     ..RunRequest::default()
//! };
//! let outcome = run(&request)?.completed()?;
//! println!("{} steps in {:.1} s", outcome.summary.steps, outcome.summary.wall_seconds);
//! # Ok::<(), coordinator::failure::Failure>(())
//! ```

pub mod batch;
pub mod brief;
pub mod case;
pub mod check;
pub mod checkpoint;
pub mod cli;
pub mod conform;
pub mod failure;
pub mod family;
pub mod messages;
pub mod new;
pub mod overlay;
pub mod page;
pub mod quote;
pub mod replay;
pub mod results;
pub mod resume;
pub mod run;
pub mod study;
pub mod sweep;

/// Name of the program in commands that messages suggest.
pub const PROGRAM: &str = "tidelock";

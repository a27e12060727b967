//! The coordinator: reads case files, starts and steps the solvers in lock-step, audits their interface, writes results.
//!
//! | module | what it does |
//! |---|---|
//! | [`case`] | case files: parse once, all mistakes at once |
//! | [`launch`], [`guard`], [`remote`], [`in_process`] | the solvers as servers or as threads |
//! | [`threads`] | how they share the cores of this machine |
//! | [`control`], [`lockstep`] | grants, events, checks of the books |
//! | [`results`] | everything that a run leaves behind |
//! | [`checkpoint`], [`keeper`], [`origin`] | states from which a run continues, when they are taken, and what it started from |
//! | [`study`] | what accuracy costs: `report` |
//! | [`trace`] | what is done when, of all processes of a run |
//! | [`quote`], [`colour`] | text of users in messages; colours of messages |
//! | [`run`], [`resume`], [`check`], [`conform`], [`cli`] | the commands |
//!
//! It computes no force.

pub mod between;
pub mod case;
pub mod check;
pub mod checkpoint;
pub mod cli;
pub mod colour;
pub mod conform;
pub mod control;
pub mod failure;
pub mod guard;
pub mod header;
mod hints;
pub mod in_process;
pub mod keeper;
pub mod launch;
pub mod lockstep;
mod logs;
pub mod origin;
pub mod participants;
pub mod preview;
pub mod quote;
pub mod remote;
pub mod replay;
pub mod results;
pub mod resume;
pub mod run;
pub mod study;
pub mod threads;
pub mod trace;

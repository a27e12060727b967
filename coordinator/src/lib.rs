//! The coordinator: reads case files, starts and steps the solvers in lock-step, audits their interface, writes results.
//!
//! | module | what it does |
//! |---|---|
//! | [`case`] | case files: parse once, all errors at once |
//! | [`run`] | a run: solvers as servers or threads, control of their steps, checkpoint times |
//! | [`results`] | everything that a run writes |
//! | [`checkpoint`] | states from which a run continues |
//! | [`resume`], [`replay`], [`check`], [`conform`] | the other commands |
//! | [`study`] | what accuracy costs: `report` |
//! | [`cli`] | the command line, which nothing else depends on |
//!
//! It computes no force.

pub mod case;
pub mod check;
pub mod checkpoint;
pub mod cli;
pub mod conform;
pub mod failure;
pub mod quote;
pub mod replay;
pub mod results;
pub mod resume;
pub mod run;
pub mod study;

//! The run header: every fact that decides the answer, in the report and, where asked for, on the screen.

use std::path::Path;

use sph::constants::Constant;
use sph::coupling::ledger::{EnergyKind, SignRule};
use sph::lanes::Arithmetic;
use sph::setup::{
    BreachAction, CouplingKind, ImplicitCoupling, InterfaceLaw, NonConvergence, Relaxation, StepPolicy,
};

use terminal::style::{Style, Tone};

use crate::brief::{self, Layout};
use crate::case::Case;
use crate::messages::Messages;
use crate::quote;
use crate::results::energy::{AccountSummary, EnergySummary};
use crate::results::quality;
use crate::results::summary::{Summary, Verdict};
use crate::run::participants::remote::Remote;

/// A named fact.
pub type Fact = (String, String);

fn fact(name: &str, text: impl Into<String>) -> Fact {
    (name.to_owned(), text.into())
}

/// Facts of a run before its first step.
pub fn facts(case: &Case, remote: Option<&Remote>) -> Vec<Fact> {
    let summary = case.summary();
    let setup = case.run_plan();
    let mut facts = vec![fact("case", case.name.clone())];
    for count in &summary.counts {
        let held = if count.held > 0 { format!(", and {} held", count.held) } else { String::new() };
        facts
            .push((format!("{} {}", count.kind, count.name), format!("{} particles{held}", count.particles)));
    }
    facts.push(fact("time step", time_step(&setup.time.step, summary.ratio_to_limit)));
    if let Some(factor) = summary.limit_override {
        facts.push(fact(
            "time-step limit",
            format!("overridden by the case: {factor} of the stability limit"),
        ));
    }
    if let Some(coupling) = &setup.coupling {
        let law = match coupling.law {
            InterfaceLaw::Wall => "wall with reaction, slip",
            InterfaceLaw::WallNoSlip => "wall with reaction, no-slip",
            InterfaceLaw::PlainSum => "plain sum over all particles",
        };
        facts.push(fact("interface law", law));
        let agreed =
            remote.and_then(|remote| remote.servers.first()).map(|server| server.report.coupling_kind);
        facts.push(fact(
            "coupling",
            match agreed.unwrap_or(coupling.kind) {
                CouplingKind::States => "states: both sides evaluate the pair law",
                CouplingKind::Loads => "loads: the fluid returns the force on each sample of the solid",
            },
        ));
        facts.extend(coupling.implicit.as_ref().map(|plan| fact("implicit coupling", implicit(plan))));
        facts.extend(remote.map(|remote| fact("frames", remote.frames())));
        facts.push(fact("interface margin", format!("{:.3e} m", coupling.margin)));
        let action = match setup.ledger.action {
            BreachAction::Warn => "warn",
            BreachAction::Stop => "stop",
            BreachAction::StopAndCheckpoint => "stop with a checkpoint",
        };
        let tolerance = setup.ledger.balance_tolerance;
        facts.push(fact("ledger", format!("{action} above {tolerance:.0e} of gross")));
    }
    facts.extend(summary.constants.iter().map(|text| fact("constants", text.clone())));
    facts.extend(
        summary.active_terms.iter().map(|term| fact(&format!("term of {}", term.owner), term.text.clone())),
    );
    for server in remote.iter().flat_map(|remote| &remote.servers) {
        let report = &server.report;
        facts.push((
            format!("{} solver", report.role),
            format!(
                "{} {} at {}, protocol {}, arithmetic {}, stable step {:.3e} s",
                report.name,
                report.version,
                server.address(),
                report.protocol,
                report.arithmetic,
                report.time_step_limit
            ),
        ));
    }
    if remote.is_none() {
        let arithmetic = Arithmetic::chosen().name();
        facts.push(fact("solvers", format!("threads of this process, arithmetic {arithmetic}")));
    }
    facts.extend(summary.adjusted.iter().map(|line| fact("fitted", line.clone())));
    facts.extend(summary.cuts.iter().map(|cut| fact("cut", cut.clone())));
    facts
}

fn time_step(step: &StepPolicy, ratio: f64) -> String {
    match step {
        StepPolicy::Fixed { time_step } => {
            format!("fixed, {time_step:.3e} s, {}", brief::of_limit(ratio))
        }
        StepPolicy::Adaptive { factor, maximum, growth, exact } => {
            let times = if exact.is_some() { ", shortened to meet the times of outputs" } else { "" };
            format!(
                "adaptive, {factor} of both solvers' limits, at most {maximum:.3e} s, growing by at most {growth} a \
                 step{times}"
            )
        }
    }
}

fn implicit(plan: &ImplicitCoupling) -> String {
    let relaxation = match plan.relaxation {
        Relaxation::Fixed(factor) => format!("relaxation {factor}"),
        Relaxation::Aitken => "Aitken's relaxation".to_owned(),
    };
    let then = match plan.non_convergence {
        NonConvergence::Stop => "the run stops",
        NonConvergence::Accept => "the last is accepted and counted",
    };
    format!(
        "{relaxation}, until forces agree to {:.0e} of gross; after {} iterations {then}",
        plan.tolerance, plan.limit
    )
}

/// The limits of the time step, in words: the smallest, and what sets it.
pub fn step_limits(case: &Case) -> String {
    let summary = case.summary();
    let least = summary.limits.iter().min_by(|a, b| a.stability.total_cmp(&b.stability));
    least.map_or(String::new(), |limit| format!("{:.3e} s ({})", limit.stability, limit.origin))
}

/// Results of a run, in words.
pub fn results(summary: &Summary) -> Vec<Fact> {
    let mut facts = vec![
        fact("verdict", format!("{}: {}", summary.verdict_text(), summary.reason)),
        fact("simulated", format!("{:.6} s in {} steps", summary.simulated.end_s, summary.steps)),
        fact("wall time", format!("{:.1} s", summary.wall_seconds)),
    ];
    facts.extend(summary.reservations.iter().map(|text| fact("reservation", text.clone())));
    facts.push(fact("quality", quality::line(&summary.quality)));
    if let Some(rate) = summary.particle_stages_per_second {
        facts.push(fact("speed", format!("{rate:.3e} particle-stages per second")));
    }
    if summary.fluid.is_some() && summary.solid.is_some() {
        let value = |worst: Option<f64>| worst.map_or("not finite".to_owned(), |v| format!("{v:.2e}"));
        facts.push(fact(
            "largest imbalance",
            format!(
                "force {}, torque {} of gross; {} breaches",
                value(summary.ledger.largest_force_imbalance.value),
                value(summary.ledger.largest_torque_imbalance.value),
                summary.ledger.breaches
            ),
        ));
    }
    facts.extend(energy(&summary.energy, if summary.dimensions == 2 { "J/m" } else { "J" }));
    if let Some(iterations) = &summary.iterations {
        let mean = iterations.mean.map_or(String::new(), |mean| format!("{mean:.2} a step, "));
        let text = format!(
            "{mean}at most {}; {} steps had not converged at the limit",
            iterations.largest, iterations.unsettled_steps
        );
        facts.push(fact("iterations", text));
    }
    for (role, side) in [("fluid", &summary.fluid), ("solid", &summary.solid)] {
        let Some(side) = side else { continue };
        let waited = side.waited_share.map_or(String::new(), |share| {
            format!(
                ", waited {:.1} s for its partner ({:.1} % of its steps)",
                side.waited_seconds,
                100.0 * share
            )
        });
        let memory = side.process.peak_memory_bytes.map_or(String::new(), |bytes| {
            format!(", peak memory {:.0} MiB", bytes as f64 / f64::from(1 << 20))
        });
        let counts = &side.counts;
        facts.push(fact(
            &format!("{role} side"),
            format!(
                "{} particles at the end, {} escaped, {} left as outflow, {} list builds{waited}{memory}",
                counts.particles, counts.escaped, counts.outflow, counts.list_builds
            ),
        ));
        let angular = match role {
            "fluid" => &summary.ledger.largest_fluid_angular_momentum_residual,
            _ => &summary.ledger.largest_solid_angular_momentum_residual,
        };
        if angular.is_none() && summary.steps > 0 {
            let why = "not audited: no budget of angular momentum was reported (a periodic domain has none)";
            facts.push(fact(&format!("{role} torques"), why));
        }
        if counts.contact_impulse_n_s > 0.0 {
            facts.push(fact(
                "contact",
                format!(
                    "deepest {:.2e} m, impulse {:.3e} N s/m",
                    counts.deepest_contact_m, counts.contact_impulse_n_s
                ),
            ));
        }
    }
    facts
}

/// Prints what a run will be, in six lines or with all `facts`, and what deserves a second look; `out` is its folder.
pub fn print_start(facts: &[Fact], case: &Case, remote: Option<&Remote>, out: &Path, messages: Messages) {
    let layout = Layout::of_errors();
    if messages >= Messages::Details {
        print(facts, messages);
        let line = |c: &Constant| fact(c.name, format!("{}, {}", c.value, c.meaning));
        print(&case.fixed_constants().map(line).collect::<Vec<_>>(), messages);
    } else {
        print(&outline(facts, case, remote, out), messages);
    }
    for warning in &case.summary().warnings {
        messages.progress(layout.warning(warning));
    }
}

/// The facts of a run in six lines.
fn outline(facts: &[Fact], case: &Case, remote: Option<&Remote>, out: &Path) -> Vec<Fact> {
    let summary = case.summary();
    let known = |name: &str| facts.iter().find(|(known, _)| known == name).map(|(_, text)| text.as_str());
    let mut lines = vec![
        fact("case", case.name.clone()),
        fact("particles", brief::particles(case, &summary)),
        fact("time step", brief::time_step(&summary)),
    ];
    if let Some(law) = known("interface law") {
        let kind = known("coupling").and_then(|text| text.split(':').next()).unwrap_or_default();
        let ledger = known("ledger").unwrap_or_default();
        lines.push(fact("interface", format!("{law}; {kind}; {ledger}")));
    }
    let solvers = remote.map(|remote| {
        let names =
            remote.servers.iter().map(|server| format!("{} {}", server.report.name, server.report.version));
        names.collect::<Vec<_>>().join(", ")
    });
    lines.push(fact("solvers", solvers.or_else(|| known("solvers").map(str::to_owned)).unwrap_or_default()));
    let cost = brief::duration(summary.forecast());
    lines.push(fact("results", format!("{} in about {cost} of one core", quote::path(out))));
    lines
}

fn print(facts: &[Fact], messages: Messages) {
    let layout = Layout::of_errors();
    let names = facts.iter().map(|(name, _)| name.chars().count() + 2).max().unwrap_or(0);
    for (name, text) in facts {
        messages.progress(layout.fact(name, text, names));
    }
}

/// Results that are printed unless all are asked for.
const FIRST_RESULTS: [&str; 6] =
    ["simulated", "wall time", "reservation", "largest imbalance", "energy residual", "iterations"];

/// Prints the results of a run, the verdict first.
pub fn print_results(summary: &Summary, messages: Messages) {
    let verdict = format!("{}: {}", summary.verdict_text(), summary.reason);
    // A failure is returned and says why by itself.
    if messages == Messages::Verdict && summary.verdict == Verdict::Completed {
        let (case, time) = (quote::clean(&summary.case), summary.wall_seconds);
        terminal::note(format_args!("{case}: {}, after {time:.1} s", painted(summary, &verdict)));
    }
    let results = results(summary);
    let shown: Vec<Fact> = match messages {
        Messages::Details => results.into_iter().skip(1).collect(),
        _ => results.into_iter().filter(|(name, _)| FIRST_RESULTS.contains(&name.as_str())).collect(),
    };
    messages.progress(painted(summary, &verdict));
    print(&shown, messages);
}

/// `text` in the colour of the verdict.
fn painted(summary: &Summary, text: &str) -> String {
    let tone = match summary.verdict {
        Verdict::Completed if summary.reservations.is_empty() => Tone::Good,
        Verdict::Completed | Verdict::Stopped => Tone::Doubt,
        Verdict::Failed => Tone::Bad,
    };
    Style::of_errors().paint(tone, quote::clean(text))
}

/// Works and losses that are named in words.
const NAMED_FLOWS: usize = 4;

/// The energy budget: the largest accounts of each side, and the residual.
fn energy(energy: &EnergySummary, unit: &str) -> Vec<Fact> {
    let mut facts = Vec::new();
    let mark = |flow: &AccountSummary| if flow.sign == SignRule::Either { "±" } else { "" };
    for (name, side) in [("energy of fluid", &energy.fluid), ("energy of solids", &energy.solid)] {
        let Some(side) = side else { continue };
        let flows: Vec<String> = side
            .largest_flows()
            .iter()
            .take(NAMED_FLOWS)
            .filter(|flow| flow.value_j_per_m != 0.0)
            .map(|flow| {
                let kind = if flow.kind == EnergyKind::Work { "work" } else { "loss" };
                let name = flow.account.name().replace('_', " ");
                format!("{kind} {name}{} {:.3e}", mark(flow), flow.value_j_per_m)
            })
            .collect();
        let flows = if flows.is_empty() { String::new() } else { format!("; {}", flows.join(", ")) };
        facts.push(fact(name, format!("change {:.3e} {unit}{flows}", side.change())));
    }
    if let Some(residual) = energy.residual_j_per_m {
        let share =
            energy.residual_share.map_or(String::new(), |share| format!(", {share:.1e} of the energy spent"));
        let slip = energy
            .interface_slip_j_per_m
            .map_or(String::new(), |slip| format!("; lost between the sides± {slip:.3e} {unit}"));
        facts.push(fact("energy residual", format!("{residual:.2e} {unit}{share}{slip}")));
    }
    facts
}

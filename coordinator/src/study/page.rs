//! The page of a study: per case a picture, what is read from it, and a table of all runs.

use std::fmt::Write as _;

use super::Row;
use super::cases::ALL;
use super::picture::{self, Panel};
use crate::results::plots::PlotError;
use crate::results::report::page::{Section, document, escaped, table};

/// The whole page.
///
/// # Errors
/// When a picture cannot be drawn.
pub(super) fn html(panels: &[(usize, Panel<'_>)], full: bool) -> Result<String, PlotError> {
    let mut sections = Vec::new();
    for (study, panel) in panels {
        let study = &ALL[*study];
        let mut figures = vec![match picture::svg(panel)? {
            Some(svg) => format!("<figure class=\"field\">{svg}</figure>"),
            None => "<figure><p class=\"none\">No run has an error to show.</p></figure>".to_owned(),
        }];
        figures.push(findings(panel));
        figures.push(runs(panel));
        let note = format!("Error: {}.", study.about);
        sections.push(Section { id: study.name, headline: study.title, note, figures });
    }
    let mut before = String::from("<div class=\"tables\">\n");
    table(&mut before, "facts", "Study", &facts(panels, full));
    before.push_str("</div>\n");
    let head = "<p>Error against the CPU time of all steps on one thread. A run is on the front when no other of its case \
                is at least as cheap and as good; such rows are bold.</p>\n";
    Ok(document("What accuracy costs", head, &before, &sections))
}

fn facts(panels: &[(usize, Panel<'_>)], full: bool) -> Vec<(String, String)> {
    let rows = || panels.iter().flat_map(|(_, panel)| &panel.rows);
    let total: f64 = rows().map(|row| row.measured.process_cpu_seconds).sum();
    let mut kernel: Vec<f64> = rows().map(|row| 1e9 * row.measured.kernel_seconds).collect();
    kernel.sort_by(f64::total_cmp);
    let middle = kernel.get(kernel.len() / 2).copied().unwrap_or(f64::NAN);
    let spread = match (kernel.first(), kernel.last()) {
        (Some(low), Some(high)) => format!("{middle:.2} ns in the median, {low:.2} to {high:.2} ns"),
        _ => String::new(),
    };
    let extent = if full { "full" } else { "quick" };
    vec![
        ("Extent".into(), format!("{extent}, {} runs", rows().count())),
        ("CPU time of all runs".into(), format!("{total:.0} s")),
        ("Machine".into(), machine()),
        ("Arithmetic".into(), sph::lanes::Arithmetic::chosen().name().into()),
        ("Fixed kernel loop, before each run".into(), spread),
    ]
}

/// The processor, as the system names it.
fn machine() -> String {
    let information = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = information.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    let model = model.map_or("unknown processor", |(_, name)| name.trim());
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    format!("{model}, {cores} cores")
}

/// What the runs of a case show: the best of each scheme, and the cost by pass of the finest on the front.
fn findings(panel: &Panel<'_>) -> String {
    let mut rows: Vec<(String, String)> = Vec::new();
    for scheme in &panel.schemes {
        let best = panel
            .rows
            .iter()
            .filter(|row| row.scheme == *scheme && row.error().is_finite())
            .min_by(|a, b| a.error().total_cmp(&b.error()));
        if let Some(best) = best {
            let text = format!(
                "{} at {} m, {}, in {:.2} s",
                percent(best.error()),
                short(best.spacing),
                best.step,
                best.measured.cpu_seconds
            );
            rows.push((format!("Smallest error, {scheme}"), text));
        }
    }
    let dearest = panel.rows.iter().filter(|row| row.on_front);
    let dearest = dearest.max_by(|a, b| a.measured.cpu_seconds.total_cmp(&b.measured.cpu_seconds));
    if let Some(row) = dearest {
        let shares: Vec<String> = row
            .measured
            .shares()
            .iter()
            .map(|(name, share)| format!("{name} {:.0} %", 100.0 * share))
            .collect();
        rows.push(("Where the time goes, most exact run of the front".into(), shares.join(", ")));
    }
    let mut html = String::from("<figure>");
    table(&mut html, "", "Read from it", &rows);
    html + "</figure>"
}

const HEADS: [&str; 11] = [
    "scheme",
    "step",
    "Δx [m]",
    "particles",
    "steps",
    "error",
    "order",
    "CPU [s]",
    "over fixed kernel, 1e6",
    "ns per particle-stage",
    "most costly",
];

fn runs(panel: &Panel<'_>) -> String {
    let mut html = String::from("<figure class=\"wide\"><table><thead><tr>");
    for head in HEADS {
        let _ = write!(html, "<th scope=\"col\">{head}</th>");
    }
    html.push_str("</tr></thead><tbody>");
    for row in &panel.rows {
        html.push_str(if row.on_front { "<tr class=\"front\">" } else { "<tr>" });
        for cell in cells(row) {
            let _ = write!(html, "<td>{}</td>", escaped(&cell));
        }
        html.push_str("</tr>");
    }
    html + "</tbody></table></figure>"
}

fn cells(row: &Row) -> [String; 11] {
    let measured = &row.measured;
    let error = match (&measured.error, &measured.flaw) {
        (Some(error), _) => percent(*error),
        (None, flaw) => flaw.clone().unwrap_or_default(),
    };
    let most = measured
        .shares()
        .first()
        .map_or(String::new(), |(name, share)| format!("{name} {:.0} %", 100.0 * share));
    [
        row.scheme.to_owned(),
        row.step.to_owned(),
        short(row.spacing),
        measured.particles.to_string(),
        measured.steps.to_string(),
        error,
        row.order.map_or(String::new(), |order| format!("{order:.1}")),
        format!("{:.2}", measured.cpu_seconds),
        format!("{:.0}", 1e-6 * measured.cpu_seconds / measured.kernel_seconds),
        format!("{:.0}", 1e9 * measured.per_particle_stage()),
        most,
    ]
}

fn percent(value: f64) -> String {
    format!("{:.3} %", 100.0 * value)
}

/// A spacing without the noise of its last bits.
fn short(value: f64) -> String {
    let text = format!("{value:.5}");
    text.trim_end_matches('0').to_owned()
}

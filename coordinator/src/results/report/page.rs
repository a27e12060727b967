//! Sections of figures, and pages made of them alone.

use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

pub use crate::page::document::escaped;
use crate::results::plots::colour::Rgb;

/// A part of the page with its own headline.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Section {
    /// Anchor.
    pub id: &'static str,
    /// Headline.
    pub headline: &'static str,
    /// A sentence on what is shown, as text.
    pub note: String,
    /// Figures, as HTML.
    pub figures: Vec<String>,
}

/// A figure with a picture given as PNG.
pub fn png_figure(png: &[u8], description: &str) -> String {
    format!(
        "<figure class=\"field\"><img alt=\"{}\" src=\"data:image/png;base64,{}\"></figure>",
        escaped(description),
        STANDARD.encode(png)
    )
}

/// A figure with a drawing given as SVG, its title and its legend; without a drawing it says `empty`.
pub fn svg_figure(title: &str, legend: &[(String, Rgb)], svg: Option<&str>, empty: &str) -> String {
    let mut html = format!("<figure><figcaption><b>{}</b>", escaped(title));
    for (name, [r, g, b]) in legend.iter().filter(|(name, _)| !name.is_empty()) {
        let _ =
            write!(html, " <span class=\"key\" style=\"--key:rgb({r},{g},{b})\">{}</span>", escaped(name));
    }
    html.push_str("</figcaption>");
    match svg {
        Some(svg) => html.push_str(svg),
        None => {
            let _ = write!(html, "<p class=\"none\">{}</p>", escaped(empty));
        }
    }
    html.push_str("</figure>");
    html
}

/// Appends a section that is folded away.
pub fn folded_section(html: &mut String, section: &Section) {
    let (id, headline, note) = (section.id, escaped(section.headline), escaped(&section.note));
    let _ = writeln!(
        html,
        "<section id=\"{id}\"><details><summary><h2>{headline}</h2></summary>\n<p class=\"note\">{note}</p>\n<div class=\"figures\">"
    );
    for figure in &section.figures {
        html.push_str(figure);
        html.push('\n');
    }
    html.push_str("</div></details></section>\n");
}

/// A page that needs no network: title as text, below it `head`, then `before` and the sections, as HTML.
pub fn document(title: &str, head: &str, before: &str, sections: &[Section]) -> String {
    let title = escaped(title);
    let mut html = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{title}</title>\n\
         <style>{STYLE}</style>\n</head>\n<body>\n<header>\n<h1>{title}</h1>\n{head}"
    );
    if sections.len() > 1 {
        html.push_str("<nav>");
        for section in sections {
            let _ = write!(html, "<a href=\"#{}\">{}</a> ", section.id, escaped(section.headline));
        }
        html.push_str("</nav>\n");
    }
    let _ = write!(html, "</header>\n<main>\n{before}");
    for section in sections {
        let _ = writeln!(
            html,
            "<section id=\"{}\"><h2>{}</h2>\n<p class=\"note\">{}</p>\n<div class=\"figures\">",
            section.id,
            escaped(section.headline),
            escaped(&section.note)
        );
        for figure in &section.figures {
            html.push_str(figure);
            html.push('\n');
        }
        html.push_str("</div></section>\n");
    }
    html.push_str("</main>\n</body>\n</html>\n");
    html
}

/// Appends a table of names and values, as text, under its own headline; nothing without rows.
pub fn table(html: &mut String, id: &str, headline: &str, rows: &[(String, String)]) {
    if rows.is_empty() {
        return;
    }
    let _ = write!(html, "<section id=\"{id}\"><h2>{headline}</h2><table><tbody>");
    for (name, value) in rows {
        let _ = write!(html, "<tr><th scope=\"row\">{}</th><td>{}</td></tr>", escaped(name), escaped(value));
    }
    html.push_str("</tbody></table></section>\n");
}

const STYLE: &str = "
:root { color-scheme: light dark; --ink: #1d2126; --soft: #5b6570; --paper: #f6f7f8; --card: #ffffff; --rule: #dfe3e7;
  --good: #1a7f4b; --bad: #b3261e; --warn: #9a6700; }
@media (prefers-color-scheme: dark) { :root { --ink: #e4e7ea; --soft: #9aa4ae; --paper: #15181b; --card: #1e2226;
  --rule: #343a40; --good: #58c38a; --bad: #f28b82; --warn: #e3b341; } }
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 1.5rem clamp(0.8rem, 3vw, 2.5rem) 3rem; max-width: 100rem; background: var(--paper);
  color: var(--ink); font: 1rem/1.5 system-ui, 'DejaVu Sans', sans-serif; }
h1 { font-size: 1.6rem; margin: 0 0 0.4rem; }
h2 { font-size: 1.15rem; margin: 2.2rem 0 0.4rem; }
header p { margin: 0.2rem 0 0.6rem; overflow-wrap: anywhere; }
.verdict { display: inline-block; padding: 0.05rem 0.6rem; margin-right: 0.4rem; border: 1px solid; border-radius: 1rem;
  font-weight: 600; color: var(--warn); }
.verdict.completed { color: var(--good); }
.verdict.failed { color: var(--bad); }
nav { display: flex; flex-wrap: wrap; gap: 0.3rem 1.2rem; }
a { color: inherit; text-underline-offset: 0.2em; }
.note { margin: 0 0 0.8rem; color: var(--soft); max-width: 60rem; }
.warnings li { color: var(--warn); }
.tables { display: grid; gap: 0 2.5rem; grid-template-columns: repeat(auto-fit, minmax(min(100%, 26rem), 1fr)); }
table { border-collapse: collapse; width: 100%; font-size: 0.9rem; }
th, td { padding: 0.22rem 0.5rem 0.22rem 0; text-align: left; vertical-align: top; border-bottom: 1px solid var(--rule); }
th { font-weight: 400; color: var(--soft); width: 42%; }
td { overflow-wrap: anywhere; font-variant-numeric: tabular-nums; }
.figures { display: grid; gap: 1rem; grid-template-columns: repeat(auto-fill, minmax(min(100%, 27rem), 1fr)); }
figure.wide { grid-column: 1 / -1; overflow-x: auto; }
tr.front td { font-weight: 600; }
figure { margin: 0; padding: 0.7rem; background: var(--card); border: 1px solid var(--rule); border-radius: 0.5rem; }
figure.field { background: #ffffff; display: flex; align-items: start; justify-content: center; }
img { display: block; max-width: 100%; max-height: 40rem; height: auto; }
svg { display: block; width: 100%; height: auto; }
figcaption { font-size: 0.9rem; margin-bottom: 0.3rem; }
.key { white-space: nowrap; margin-left: 0.7rem; }
.key::before { content: ''; display: inline-block; width: 1.1rem; height: 0.2rem; margin-right: 0.35rem;
  vertical-align: middle; background: var(--key); }
.none { color: var(--soft); text-align: center; padding: 2rem 0; }
@media print { :root { color-scheme: light; --ink: #000; --soft: #444; --paper: #fff; --card: #fff; --rule: #ccc; }
  body { padding: 0; max-width: none; font-size: 0.85rem; } nav { display: none; }
  .figures { grid-template-columns: 1fr 1fr; } figure, tr, .note { break-inside: avoid; } h2, .note { break-after: avoid; }
  * { print-color-adjust: exact; -webkit-print-color-adjust: exact; } }
";

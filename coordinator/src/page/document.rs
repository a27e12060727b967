//! The HTML of the page: style, script, the message of [`super::run`] and the frames in one file that needs no network.

use std::fmt::Write;

use super::film::Film;
use super::run::RunPage;

const STYLE: &str = include_str!("assets/page.css");
/// In this order one script: later ones use what earlier ones define.
const SCRIPTS: [&str; 8] = [
    include_str!("assets/frames.js"),
    include_str!("assets/colours.js"),
    include_str!("assets/draw.js"),
    include_str!("assets/camera.js"),
    include_str!("assets/points.js"),
    include_str!("assets/player.js"),
    include_str!("assets/plots.js"),
    include_str!("assets/page.js"),
];

/// Text as HTML.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// The page with its data and frames inside; `pictures` is HTML that stands below what the script makes.
///
/// # Errors
/// When a message cannot be written as JSON.
pub fn report(page: &RunPage, film: Option<&Film>, pictures: &str) -> serde_json::Result<String> {
    let mut data = String::new();
    let _ = writeln!(data, "<script type=\"application/json\" id=\"run\">{}</script>", inside_script(page)?);
    for frame in film.iter().flat_map(|film| &film.frames) {
        let _ = writeln!(data, "<script type=\"text/plain\" class=\"frame\">{}</script>", frame.data);
    }
    Ok(document(page, &without_script(page), pictures, &data))
}

/// The page of a server: it asks for data itself.
///
/// # Errors
/// As [`report`].
pub fn live(page: &RunPage) -> serde_json::Result<String> {
    let json = inside_script(page)?;
    let data = format!("<script type=\"application/json\" id=\"run\" data-live=\"yes\">{json}</script>\n");
    Ok(document(page, "<noscript><p>This page needs JavaScript.</p></noscript>", "", &data))
}

fn document(page: &RunPage, fallback: &str, pictures: &str, data: &str) -> String {
    let title = if page.title.is_empty() { "Run".to_owned() } else { escaped(&page.title) };
    let verdict = escaped(&page.verdict);
    let class = if verdict.contains("reservations") { "reserved" } else { verdict.as_str() };
    let mut head = format!("<h1>{title}</h1>\n");
    if !verdict.is_empty() {
        let _ = writeln!(
            head,
            "<p class=\"result\"><span class=\"verdict {class}\" id=\"verdict\">{verdict}</span> <span id=\"sentence\">{}</span></p>",
            escaped(&page.sentence)
        );
        let _ = writeln!(head, "<p class=\"reason {class}\" id=\"reason\">{}</p>", escaped(&page.reason));
    }
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{title}</title>\n\
         <link rel=\"icon\" href=\"data:,\">\n\
         <style>\n{STYLE}</style>\n</head>\n<body>\n<header>\n{head}</header>\n<main>\n<div id=\"page\"></div>\n{fallback}\n\
         {pictures}</main>\n{data}<script>\n\"use strict\";\n{}</script>\n</body>\n</html>\n",
        SCRIPTS.concat()
    )
}

/// JSON that no script element ends early.
fn inside_script(page: &RunPage) -> serde_json::Result<String> {
    Ok(serde_json::to_string(page)?.replace('<', "\\u003c"))
}

/// What a reader without scripts sees: key figures, quality and facts as tables.
fn without_script(page: &RunPage) -> String {
    let mut html = String::from("<noscript>\n");
    let mut table = |headline: &str, rows: Vec<[String; 2]>| {
        if rows.is_empty() {
            return;
        }
        let _ = write!(html, "<section><h2>{headline}</h2><table><tbody>");
        for [name, value] in rows {
            let _ = write!(
                html,
                "<tr><th scope=\"row\">{}</th><td>{}</td></tr>",
                escaped(&name),
                escaped(&value)
            );
        }
        html.push_str("</tbody></table></section>\n");
    };
    table("Warnings", page.warnings.iter().map(|text| ["warning".into(), text.clone()]).collect());
    let figures = page.figures.iter().map(|f| {
        let least = if f.smallest.is_empty() {
            String::new()
        } else {
            format!("; smallest {} at {}", f.smallest, f.smallest_at)
        };
        let place = if f.place.is_empty() { String::new() } else { format!(" in {}", f.place) };
        [f.name.clone(), format!("largest {} at {}{place}{least}", f.largest, f.largest_at)]
    });
    table("Key figures", figures.collect());
    let quality = page
        .quality
        .iter()
        .map(|q| [q.name.clone(), format!("{} ({}): {}", q.value, q.threshold, q.meaning)]);
    table("Quality", quality.collect());
    for facts in &page.tables {
        table(facts.headline, facts.rows.iter().map(|(name, value)| [name.clone(), value.clone()]).collect());
    }
    html.push_str("</noscript>\n");
    html
}

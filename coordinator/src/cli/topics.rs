//! The list of commands in the help, grouped by topic.

use clap::Command;

/// Commands by topic, in the order of the help.
const TOPICS: [(&str, &[&str]); 6] = [
    ("Run", &["run", "resume", "sweep"]),
    ("Look", &["view", "report"]),
    ("Compare", &["overlay", "converge", "ensemble"]),
    ("Check", &["check"]),
    ("Participants", &["fluid-server", "solid-server", "conform", "replay", "compare"]),
    ("Set up", &["new", "schema", "completions", "man", "help"]),
];

/// `command` with a help that groups its commands by topic.
pub(super) fn grouped(command: Command) -> Command {
    let template = format!(
        "{{before-help}}{{about-with-newline}}\n{{usage-heading}} {{usage}}\n{}\n{}\n{{options}}{{after-help}}",
        list(&command),
        heading(&command, "Options")
    );
    command.help_template(template)
}

/// `title` as the help shows the titles of its parts.
fn heading(command: &Command, title: &str) -> String {
    let style = command.get_styles().get_header();
    format!("{style}{title}:{style:#}")
}

fn list(command: &Command) -> String {
    let style = command.get_styles().get_literal();
    let of = |name: &str| command.get_subcommands().find(|sub| sub.get_name() == name && !sub.is_hide_set());
    let names = TOPICS.iter().flat_map(|(_, names)| *names);
    let width = names.map(|name| name.len()).max().unwrap_or(0);
    let mut text = String::new();
    for (topic, names) in TOPICS {
        text.push_str(&format!("\n{}\n", heading(command, topic)));
        for name in names {
            let about = match (of(name), *name) {
                (Some(sub), _) => sub.get_about().map(ToString::to_string).unwrap_or_default(),
                // Clap adds it later.
                (None, "help") => "Print the help of a command".to_owned(),
                (None, _) => continue,
            };
            text.push_str(&format!("  {style}{name:width$}{style:#}  {about}\n"));
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Columns of a usual terminal.
    const WIDTH: usize = 80;

    #[test]
    fn every_command_is_under_one_topic_and_fits_a_line() {
        let command = super::super::command("tidelock");
        let listed: Vec<&str> = TOPICS.iter().flat_map(|(_, names)| *names).copied().collect();
        for sub in command.get_subcommands().filter(|sub| !sub.is_hide_set()) {
            let name = sub.get_name();
            assert_eq!(listed.iter().filter(|known| **known == name).count(), 1, "{name}");
        }
        let help = command.clone().render_help().to_string();
        for line in help.lines() {
            assert!(line.chars().count() <= WIDTH, "{line}");
        }
        assert!(help.contains("\nLook:\n  view "), "{help}");
    }
}

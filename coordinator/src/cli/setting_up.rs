//! `completions` and `man`: what a shell and its manual want to know of this program.

use std::path::PathBuf;

use clap::builder::Resettable;
use clap::builder::styling::Styles;
use clap::{Args, Command};
use clap_complete::Shell;
use clap_mangen::Man;
use clap_mangen::roff::{self, Roff};

use crate::PROGRAM;
use crate::failure::{Failure, Kind};
use crate::quote;

/// Arguments of `completions`.
#[derive(Debug, Args)]
pub(super) struct CompletionsArguments {
    /// Shell that reads them.
    shell: Shell,
}

/// Arguments of `man`.
#[derive(Debug, Args)]
pub(super) struct ManArguments {
    /// Folder for the pages, such as ~/.local/share/man/man1; it is made where it is not there.
    folder: PathBuf,
}

impl CompletionsArguments {
    pub(super) fn execute(&self) -> Result<(), Failure> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut super::command(PROGRAM), PROGRAM, &mut script);
        terminal::say(String::from_utf8_lossy(&script).trim_end());
        Ok(())
    }
}

impl ManArguments {
    pub(super) fn execute(&self) -> Result<(), Failure> {
        let failed = |e: std::io::Error| {
            Failure::output(format!("cannot write pages to {}: {e}", quote::path(&self.folder)))
        };
        std::fs::create_dir_all(&self.folder).map_err(failed)?;
        let pages = pages(super::command(PROGRAM));
        for (name, page) in &pages {
            std::fs::write(self.folder.join(name), page).map_err(failed)?;
        }
        terminal::say(format_args!("{} pages in {}", pages.len(), quote::path(&self.folder)));
        Ok(())
    }
}

/// File names and texts of the pages of `command` and of all its commands that are shown.
fn pages(command: Command) -> Vec<(String, Vec<u8>)> {
    let mut command = command.disable_help_subcommand(true).styles(Styles::plain());
    command.build();
    let mut pages = vec![page(&command)];
    pages.extend(command.get_subcommands().filter(|sub| !sub.is_hide_set()).map(page));
    pages
}

fn page(command: &Command) -> (String, Vec<u8>) {
    let name = command.get_bin_name().unwrap_or(PROGRAM).replace(' ', "-");
    let mut page = command.clone().name(name.clone()).display_name(name.clone());
    // A server has codes of its own, in what follows its help.
    let is_server = name.ends_with("-server");
    if !is_server {
        page = page.after_help(Resettable::Reset).after_long_help(Resettable::Reset);
    }
    let mut text = Vec::new();
    // Writing to memory cannot fail.
    drop(Man::new(page).render(&mut text));
    if !is_server {
        text.extend(exit_codes().to_roff().bytes());
    }
    (format!("{name}.1"), text)
}

/// The section on exit codes.
fn exit_codes() -> Roff {
    let mut section = Roff::new();
    section.control("SH", ["EXIT STATUS"]);
    for (code, meaning) in Kind::codes() {
        section.control("TP", []);
        section.text([roff::bold(code.to_string())]);
        section.text([roff::roman(meaning)]);
    }
    section
}

#[cfg(test)]
mod tests {
    use super::*;

    fn page_of(name: &str) -> String {
        let pages = pages(crate::cli::command(PROGRAM));
        let found = pages.into_iter().find(|(file, _)| file == name);
        String::from_utf8(found.unwrap_or_else(|| panic!("no {name}")).1).unwrap()
    }

    #[test]
    fn every_command_that_is_shown_has_a_page() {
        let command = crate::cli::command(PROGRAM);
        let shown: Vec<_> = command.get_subcommands().filter(|sub| !sub.is_hide_set()).collect();
        assert!(shown.len() > 10);
        for sub in shown {
            let page = page_of(&format!("tidelock-{}.1", sub.get_name()));
            let codes =
                if sub.get_name().ends_with("-server") { "Exit codes: " } else { "\n.SH \"EXIT STATUS\"\n" };
            assert!(page.contains("\n.SH OPTIONS\n") && page.contains(codes), "{page}");
        }
        assert!(!pages(command).iter().any(|(name, _)| name.contains("guard")));
    }

    #[test]
    fn pages_hold_options_and_codes_and_no_escapes() {
        let page = page_of("tidelock-run.1");
        for words in ["\\-\\-checkpoint\\-every\\-steps", "--strict", "a fault of this program"] {
            let plain = page.replace('\\', "");
            assert!(plain.contains(&words.replace('\\', "")), "no {words} in {page}");
        }
        assert!(!page.contains('\u{1b}'), "{page}");
        assert!(page_of("tidelock.1").contains("tidelock\\-resume(1)"));
    }
}

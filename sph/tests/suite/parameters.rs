//! `docs/parameters.md` lists all parameters and kinds of probes as their rows state them.

use std::fmt::Write;
use std::path::Path;

use sph::setup::{
    ElasticParameters, FluidParameters, FluidProbeKind, Kind, ParameterSet, ParameterSpec, ProbeKind,
    ProbeSpec, RepulsionParameters, SolidProbeKind, TotalLagrangian, UpdatedLagrangian,
};

const HEAD: &str = "# Parameters

Made of the rows in `sph/src/setup`; `UPDATE_DOCS=1 cargo test --test suite parameters` in `sph` writes it again.

A name is the key of a case file and the name in the set-up messages of the protocol. *Off* is the value that leaves the
feature out: messages do not state it then. Parameters marked *pair law* are also in `Coupling.fluid`, since both sides
evaluate pairs of fluid and solid with them. [method.md](method.md) explains the equations.
";

fn set<T: ParameterSet>(page: &mut String, title: &str, place: &str) {
    let _ = write!(page, "\n## {title}\n\n{place}\n\n");
    page.push_str("| name | meaning | allowed | default | off | source paper |\n|---|---|---|---|---|---|\n");
    let default = T::default();
    for spec in T::SPECIFICATIONS {
        let pair = if spec.is_of_pair_law { " *Pair law.*" } else { "" };
        let value =
            |value: Option<sph::setup::Value<'_>>| value.map_or_else(String::new, |value| value.to_string());
        let (default, off) = match (spec.is_stated, spec.is_optional) {
            (true, _) => ("must be stated".to_owned(), String::new()),
            (_, true) => ("none".to_owned(), "none".to_owned()),
            _ => (value(default.get(spec.key)), value(spec.off)),
        };
        let _ = writeln!(
            page,
            "| `{}` | {}{pair} | {} | {default} | {off} | {} |",
            spec.key,
            spec.meaning().replace('|', "\\|"),
            spec.allowed(),
            value(spec.paper),
        );
    }
    T::SPECIFICATIONS.iter().for_each(|spec| words(page, spec));
}

/// The words of a closed choice, and what a departure from the default costs.
fn words(page: &mut String, spec: &ParameterSpec) {
    if let Kind::Choice(words) = spec.kind {
        let _ = write!(page, "\n`{}`:\n\n", spec.key);
        for (word, meaning) in words {
            let _ = writeln!(page, "- `{word}`: {}", meaning.trim());
        }
    }
    if let Some(cost) = spec.cost {
        let _ = write!(page, "\n`{}` other than the default: {cost}.\n", spec.key);
    }
}

fn probes(page: &mut String, title: &str, specs: &[ProbeSpec]) {
    let _ = write!(page, "\n## {title}\n\n| kind | meaning | arguments | columns |\n|---|---|---|---|\n");
    for spec in specs {
        let arguments: Vec<String> = spec
            .arguments
            .iter()
            .map(|argument| format!("`{}` ({})", argument.name, argument.kind.text()))
            .collect();
        let columns: Vec<String> = spec.columns.iter().map(|column| format!("`{column}`")).collect();
        let _ = writeln!(
            page,
            "| `{}` | {} | {} | {} |",
            spec.word,
            spec.meaning().replace('|', "\\|"),
            arguments.join(", "),
            columns.join(", ")
        );
    }
}

#[test]
fn the_page_lists_all_parameters() {
    let mut page = HEAD.to_owned();
    set::<FluidParameters>(&mut page, "fluid", "`[fluid]`; `FluidSetup.parameters`.");
    set::<ElasticParameters>(
        &mut page,
        "material",
        "`material` of a body; `BodySetup.material`. A case may state E and ν in place of K and G.",
    );
    let place = "`formulation` of a body; `BodySetup.parameters`.";
    set::<TotalLagrangian>(&mut page, "total-lagrangian", place);
    set::<UpdatedLagrangian>(&mut page, "updated-lagrangian", place);
    set::<RepulsionParameters>(&mut page, "repulsion", "`[solid.contact]`; `ContactLaw.parameters`.");
    probes(&mut page, "probes of the fluid", <FluidProbeKind>::SPECIFICATIONS);
    probes(&mut page, "probes of the solids", <SolidProbeKind>::SPECIFICATIONS);
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/parameters.md");
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::write(&path, &page).unwrap();
    }
    let written = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(written == page, "docs/parameters.md is not what the rows say: run the test with UPDATE_DOCS=1");
}

//! Input that is made to hurt ends in a report, soon and without harm.

use std::time::{Duration, Instant};

use super::*;
use crate::case::{LARGEST_FILE, load};

/// Far above what any of these takes, far below a hang.
const SOON: Duration = Duration::from_secs(20);

fn refused_soon(text: &str, words: &str) {
    let start = Instant::now();
    let errors = bad(text);
    let report = errors.render(false);
    assert!(start.elapsed() < SOON, "{:?}", start.elapsed());
    assert!(
        report.contains(words),
        "`{words}` is missing in\n{}",
        report.chars().take(2000).collect::<String>()
    );
}

#[test]
fn deep_nesting() {
    let deep = 100_000;
    refused_soon(&format!("a = {}{}", "[".repeat(deep), "]".repeat(deep)), "not TOML");
    refused_soon(&format!("a = {}1{}", "{a=".repeat(deep), "}".repeat(deep)), "not TOML");
    let mut shape = "{ type = \"circle\", centre_m = [0.1, 0.05], radius_m = 0.02 }".to_owned();
    for _ in 0..30 {
        shape = format!("{{ type = \"union\", parts = [{shape}] }}");
    }
    let text = tank_with(&[("{ type = \"rectangle\", lower_m = [0.0, 0.0], upper_m = [0.4, 0.1] }", &shape)]);
    refused_soon(&text, "nested more than 16 deep");
    let brackets =
        format!("name = \"water\"\nvelocity_m_s = [\"{}x{}\", 0]", "(".repeat(1000), ")".repeat(1000));
    refused_soon(&tank_with(&[("name = \"water\"", &brackets)]), "nested too deeply");
}

#[test]
fn too_many_particles_are_refused_before_they_exist() {
    refused_soon(&TANK.replace("particle_spacing_m = 0.01", "particle_spacing_m = 1e-9"), "lattice points");
    refused_soon(&TANK.replace("particle_spacing_m = 0.01", "particle_spacing_m = 1e-29"), "lattice points");
    refused_soon(
        &TANK.replace("particle_spacing_m = 0.01", "particle_spacing_m = 1e-320"),
        "a magnitude from",
    );
    let far = tank_with(&[(
        "lower_m = [0.0, 0.0], upper_m = [0.4, 0.1]",
        "lower_m = [1e15, 0.0], upper_m = [1e15, 0.1]",
    )]);
    refused_soon(&far, "upper must lie above lower");
    let far = tank_with(&[(
        "lower_m = [0.0, 0.0], upper_m = [0.4, 0.1]",
        "lower_m = [1e12, 0.0], upper_m = [1000000000000.4, 0.1]",
    )]);
    refused_soon(&far, "spacings from the lattice origin");
    let huge = tank_with(&[(
        "lower_m = [0.0, 0.0], upper_m = [0.4, 0.1]",
        "lower_m = [-1e30, -1e30], upper_m = [1e30, 1e30]",
    )]);
    refused_soon(&huge, "lattice points");
    // Each shape is allowed, both together are not: 2 × 2500².
    let square = |name: &str, left: f64| {
        let right = left + 0.25;
        format!(
            "[[fluid.region]]\nname = \"{name}\"\nshape = {{ type = \"rectangle\", lower_m = [{left}, 0], upper_m = [{right}, 0.25] }}\n"
        )
    };
    let head = &TANK[..TANK.find("[[fluid.region]]").unwrap()];
    let head = head.replace("particle_spacing_m = 0.01", "particle_spacing_m = 0.0001");
    let head = head.replace("upper_m = [0.4, 0.3]", "upper_m = [0.6, 0.3]");
    refused_soon(&format!("{head}{}{}", square("a", 0.0), square("b", 0.25)), "at most 5000000 particles");
}

#[test]
fn long_lists_and_many_errors() {
    let points = "[0.0, 0.0],".repeat(20_000);
    let text = tank_with(&[(
        "{ type = \"rectangle\", lower_m = [0.0, 0.0], upper_m = [0.4, 0.1] }",
        &format!("{{ type = \"polygon\", vertices_m = [{points}] }}"),
    )]);
    refused_soon(&text, "has 20000 entries");
    let many: String = (0..20_000).map(|k| format!("unknown_{k} = 1\n")).collect();
    let text = format!("{many}{TANK}");
    let errors = bad(&text);
    assert_eq!(errors.count, 20_000);
    assert!(errors.list.len() <= 200);
    refused_soon(&text, "20000 errors");
    let long = tank_with(&[("name = \"water\"", &format!("name = \"{}\"", "w".repeat(1_000_000)))]);
    refused_soon(&long, "1 to 64 letters");
}

#[test]
fn texts_in_other_scripts_keep_their_columns() {
    let text = tank_with(&[("name = \"water\"", "name = \"水\" # 水\nstrat = 1")]);
    let errors = bad(&text);
    assert_eq!(errors.list[0].position, Some(place_of(&text, "\"水\"")));
    assert_eq!(errors.list[1].position, Some(place_of(&text, "strat")));
    // Control characters do not reach the terminal.
    let text = tank_with(&[("name = \"water\"", "name = \"\\u001b[31m\"")]);
    assert!(!bad(&text).render(false).contains('\u{1b}'));
}

#[test]
fn files_that_are_no_case_files() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |name: &str, words: &str| {
        let errors = load(&folder.path().join(name), &|_| Err(String::new())).unwrap_err();
        assert!(errors.to_string().contains(words), "{errors}");
        assert_eq!(errors.list[0].position, None);
    };
    refused("missing.toml", "no such file");
    refused("", "not a regular file");
    std::fs::write(folder.path().join("binary.toml"), [0xff, 0xfe, 0x00]).unwrap();
    refused("binary.toml", "not UTF-8");
    let large = std::fs::File::create(folder.path().join("large.toml")).unwrap();
    large.set_len(LARGEST_FILE + 1).unwrap();
    refused("large.toml", "at most");
    #[cfg(unix)]
    assert!(
        load(Path::new("/dev/zero"), &|_| Err(String::new()))
            .unwrap_err()
            .to_string()
            .contains("not a regular file")
    );
}

#[test]
fn damaged_cases_never_panic() {
    // Every line left out, doubled or cut once.
    let lines: Vec<&str> = TANK.lines().collect();
    for k in 0..lines.len() {
        let mut without = lines.clone();
        without.remove(k);
        let _ = read(&without.join("\n"));
        let mut doubled = lines.clone();
        doubled.insert(k, lines[k]);
        let _ = read(&doubled.join("\n"));
        let cut = &lines[k][..lines[k].len() / 2];
        let mut shortened = lines.clone();
        shortened[k] = cut;
        let _ = read(&shortened.join("\n"));
    }
    // Every number replaced by ones that computers stumble over.
    for value in
        ["0", "-0.0", "1e-300", "1e300", "-1e300", "9223372036854775807", "nan", "-inf", "\"\"", "[]", "{}"]
    {
        for (k, line) in lines.iter().enumerate() {
            if let Some((key, _)) = line.split_once(" = ") {
                let changed = format!("{key} = {value}");
                let mut text = lines.clone();
                text[k] = &changed;
                if let Err(errors) = read(&text.join("\n")) {
                    assert!(!errors.render(false).is_empty());
                }
            }
        }
    }
}

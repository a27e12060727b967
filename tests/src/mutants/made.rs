//! Cases that were thought of one by one: each is good but for what its name says.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use super::Mutant;

const TANK: &str = include_str!("../tank.toml");

const HEAD: &str = "name = \"made\"\n[domain]\nlower_m = [0, 0]\nupper_m = [1, 1]\n[time]\nend_time_s = 0.001\n\
                    step = { type = \"adaptive\" }\n";
const FLUID: &str = "[fluid]\nparticle_spacing_m = 0.01\nrest_density_kg_m3 = 1000\nsound_speed_m_s = 20\n";
const SOLID: &str = "[solid]\nparticle_spacing_m = 0.01\n";
const HERE: &str = "lower_m = [0.1, 0.1], upper_m = [0.2, 0.2]";

fn body(k: usize, place: &str) -> String {
    format!(
        "[[solid.body]]\nname = \"b{k}\"\nshape = {{ type = \"rectangle\", {place} }}\n\
         material = {{ density_kg_m3 = 1000, young_modulus_pa = 1e6, poisson_ratio = 0.3 }}\n"
    )
}

fn bodies(count: usize) -> String {
    (0..count).map(|k| body(k, HERE)).collect()
}

fn region(k: usize, place: &str) -> String {
    format!("[[fluid.region]]\nname = \"r{k}\"\nshape = {{ type = \"rectangle\", {place} }}\n")
}

fn wall(k: usize, place: &str) -> String {
    format!("[[wall]]\nname = \"w{k}\"\ntype = \"solid\"\nshape = {{ type = \"rectangle\", {place} }}\n")
}

/// Boxes of 12.5 mm on a grid that fills a metre.
fn cell(k: usize) -> String {
    let (x, y) = ((k % 50) as f64 * 0.02, (k / 50) as f64 * 0.02);
    format!("lower_m = [{x:.4}, {y:.4}], upper_m = [{:.4}, {:.4}]", x + 0.0125, y + 0.0125)
}

/// All of them; files that they name are put into `folder`.
pub fn all(folder: &Path) -> Vec<Mutant> {
    let mut mutants = Vec::new();
    let mut add = |name: &str, text: String| {
        mutants.push(Mutant { name: name.to_owned(), text: text.into_bytes() });
    };
    crowds(&mut add);
    sizes(&mut add);
    names(&mut add);
    times(&mut add);
    expressions(&mut add);
    files(folder, &mut add);
    mutants.push(Mutant { name: "no text".into(), text: vec![0xff, 0xfe, 0, 0x80] });
    mutants
}

type Add<'a> = &'a mut dyn FnMut(&str, String);

/// Many things on one spot or in one file.
fn crowds(add: Add<'_>) {
    add("3000 bodies on one spot", format!("{HEAD}{SOLID}{}", bodies(3000)));
    add("9999 bodies on one spot", format!("{HEAD}{SOLID}{}", bodies(9999)));
    let spots = |count: usize, one: fn(usize, &str) -> String, place: &str| {
        (0..count).map(|k| one(k, place)).collect::<String>()
    };
    let wide = "lower_m = [0.0, 0.0], upper_m = [1.0, 0.5]";
    add("400 regions on one spot", format!("{HEAD}{FLUID}{}", spots(400, region, wide)));
    add("9999 regions on one spot", format!("{HEAD}{FLUID}{}", spots(9999, region, HERE)));
    add("6 regions on one spot", format!("{HEAD}{FLUID}{}", spots(6, region, wide)));
    let apart = body(0, "lower_m = [0.5, 0.5], upper_m = [0.7, 0.7]");
    add("3000 walls on one spot", format!("{HEAD}{SOLID}{apart}{}", spots(3000, wall, HERE)));
    add("9999 walls on one spot", format!("{HEAD}{SOLID}{apart}{}", spots(9999, wall, HERE)));
    let fine = SOLID.replace("0.01", "0.004");
    let each: String = (0..2500).map(|k| body(k, &cell(k))).collect();
    add("2500 bodies apart", format!("{HEAD}{fine}{each}"));
    add("2500 bodies apart in a region", format!("{HEAD}{FLUID}{}{fine}{each}", region(0, wide)));
    let walls: String = (0..2500).map(|k| wall(k, &cell(k))).collect();
    add(
        "2500 walls apart",
        format!("{HEAD}{FLUID}{}{walls}", region(0, "lower_m = [0.0, 0.0], upper_m = [0.1, 0.1]")),
    );
    let supports: String = (0..9000)
        .map(|k| {
            format!("[[solid.body.support]]\nname = \"s{k}\"\nshape = {{ type = \"rectangle\", {HERE} }}\n")
        })
        .collect();
    add("9000 supports on one spot", format!("{HEAD}{SOLID}{}{supports}", body(0, HERE)));
    let probe = |k: usize, name: &str| {
        format!("[[probe]]\nname = \"p{k}\"\ntype = \"body-motion\"\nbody = \"{name}\"\n")
    };
    let all: String = (0..9999).map(|k| probe(k, "b0")).collect();
    add("9999 probes", format!("{HEAD}{SOLID}{}{all}", body(0, HERE)));
    let lost: String = (0..9999).map(|k| probe(k, &format!("{}{k}", "z".repeat(50)))).collect();
    add("9999 probes of bodies that are not there", format!("{HEAD}{SOLID}{}{lost}", bodies(1000)));
    let turned = HEAD.replace("[0, 0]", "[0, 0]\nperiodic = [\"x\"]");
    let long = region(0, "lower_m = [0.0, 0.0], upper_m = [4000.0, 0.1]");
    add("a region that wraps 4000 times", format!("{turned}{FLUID}{long}"));
}

/// Texts of a size or depth that hurts.
fn sizes(add: Add<'_>) {
    let tank = |key: &str, value: &str| TANK.replacen(key, value, 1);
    for deep in [20, 100, 100_000] {
        add(&format!("lists {deep} deep"), format!("a = {}{}\n{TANK}", "[".repeat(deep), "]".repeat(deep)));
        add(
            &format!("tables {deep} deep"),
            format!("a = {}1{}\n{TANK}", "{a=".repeat(deep), "}".repeat(deep)),
        );
    }
    add("keys of 70 dots", format!("k{} = 1\n", ".a".repeat(70)).repeat(10) + TANK);
    let dotted: String = (0..25_000).map(|k| format!("k{k}{} = 1\n", ".a".repeat(70))).collect();
    add("1.7 million tables by dots", dotted);
    add("600,000 inline tables", format!("x = [{}]\n", "{a=1},".repeat(600_000)));
    add("1.3 million lists", format!("x = [{}]\n", "[],".repeat(1_300_000)));
    add("300,000 headers", (0..300_000).map(|k| format!("[[a{k}]]\n")).collect());
    add("100,000 keys", (0..100_000).map(|k| format!("unknown_{k} = 1\n")).collect::<String>() + TANK);
    add("400,000 keys in a line", format!("x = {{ {} a = 1 }}\n{TANK}", "".to_owned() + &numbered(300_000)));
    add("a million mistakes of notation", "= \n".repeat(1_000_000));
    add(
        "an expression of 10 MB",
        tank("end_time_s", &format!("x = \"{}\"\nend_time_s", "x+".repeat(5 << 20))),
    );
    add("an expression of 3.9 MB", force(&format!("[\"{}1\", 0]", "x+".repeat(1_900_000))));
    add("an expression of 4 kB", force(&format!("[\"{}1\", 0]", "sin(x)*".repeat(580))));
    add("brackets 1000 deep", force(&format!("[\"{}x{}\", 0]", "(".repeat(1000), ")".repeat(1000))));
    let mut shape = "{ type = \"circle\", centre_m = [0.1, 0.05], radius_m = 0.02 }".to_owned();
    for _ in 0..40 {
        shape = format!("{{ type = \"union\", parts = [{shape}] }}");
    }
    add("shapes 40 deep", with_shape(&shape));
    for corners in [9_999, 20_001] {
        add(&format!("a polygon of {corners} corners"), with_shape(&polygon(corners)));
    }
    let many: String =
        (0..12).map(|k| format!("[[fluid.region]]\nname = \"r{k}\"\nshape = {}\n", polygon(9_999))).collect();
    add("12 polygons of 9999 corners", format!("{HEAD}{FLUID}{many}"));
    add("2 million numbers", format!("x = [{}]\n{TANK}", "1,".repeat(1_900_000)));
    for spacing in ["1e-9", "1e-7", "0.00013", "0.0001"] {
        add(
            &format!("spacing {spacing}"),
            TANK.replace("particle_spacing_m = 0.01", &format!("particle_spacing_m = {spacing}")),
        );
    }
}

fn numbered(count: usize) -> String {
    (0..count).fold(String::new(), |mut text, k| {
        // Writing to a string cannot fail.
        let _ = write!(text, "k{k} = 1, ");
        text
    })
}

fn force(pair: &str) -> String {
    TANK.replacen("[body_force]", &format!("[body_force]\nacceleration_m_s2 = {pair}"), 1)
}

fn with_shape(shape: &str) -> String {
    TANK.replacen("{ type = \"rectangle\", lower_m = [0.0, 0.0], upper_m = [0.2, 0.12] }", shape, 1)
}

/// A star, so that its corners cross nothing.
fn polygon(corners: usize) -> String {
    let corner = |k: usize| {
        let angle = std::f64::consts::TAU * k as f64 / corners as f64;
        let radius = if k.is_multiple_of(2) { 0.05 } else { 0.04 };
        format!("[{:.6}, {:.6}],", 0.1 + radius * angle.cos(), 0.06 + radius * angle.sin())
    };
    format!("{{ type = \"polygon\", vertices_m = [{}] }}", (0..corners).map(corner).collect::<String>())
}

/// Names that act on a terminal, are no names, or are long.
fn names(add: Add<'_>) {
    let long = "n".repeat(500_000);
    for (what, name) in [
        ("escape sequences", "\\u001b[31mred\\u001b]0;title\\u0007"),
        ("C1 controls and turned text", "\\u009b31m\\u202ex"),
        ("a path", "../../x"),
        ("markup", "<script>alert(1)</script>"),
        ("500 kB", &long),
        ("nothing", ""),
        ("control characters", "a\\u0000b\\nc\\r\\u0008"),
    ] {
        add(
            &format!("a body named by {what}, a probe that misses it"),
            TANK.replacen("\"block\"", &format!("\"{name}\""), 1),
        );
        add(
            &format!("a probe of {what}"),
            format!("{TANK}\n[[probe]]\nname = \"lost\"\ntype = \"body-motion\"\nbody = \"{name}\"\n"),
        );
        add(&format!("a key of {what}"), format!("\"{name}\" = 1\n{TANK}"));
        add(&format!("a table of {what}"), format!("{TANK}\n[fluid.\"{name}\"]\nx = 1\n"));
        add(&format!("a word of {what}"), TANK.replacen("\"container\"", &format!("\"{name}\""), 1));
        add(&format!("an expression of {what}"), force(&format!("[\"{name}\", 0]")));
        add(
            &format!("a file of {what}"),
            with_shape(&format!("{{ type = \"polygon\", file = \"{name}\" }}")),
        );
        add(&format!("an earlier run in {what}"), format!("start_from = \"{name}\"\n{TANK}"));
    }
}

/// Runs that never end.
fn times(add: Add<'_>) {
    let step = "step = { type = \"fixed\", time_step_s = 4e-5 }";
    let end = "end_time_s = 0.002";
    for (what, from, to) in [
        ("an end at 1e308", end, "end_time_s = 1e308"),
        ("an end at 1e29", end, "end_time_s = 1e29"),
        ("a step of 1e-300", step, "step = { type = \"fixed\", time_step_s = 1e-300 }"),
        ("a step of 1e-29", step, "step = { type = \"fixed\", time_step_s = 1e-29 }"),
        ("a largest step of 1e-25", step, "step = { type = \"adaptive\", maximum_s = 1e-25 }"),
        ("a factor of 1e-25", step, "step = { type = \"adaptive\", factor = 1e-25 }"),
        ("a start at 1e20", end, "start_time_s = 1e20\nend_time_s = 1.0000001e20"),
        ("a start at -1e20", end, "start_time_s = -1e20\nend_time_s = 0.002"),
        ("snapshots each 1e-25 s", "snapshot_interval_s = 0.0004", "snapshot_interval_s = 1e-25"),
        ("sound at 1e29 m/s", "sound_speed_m_s = 25.0", "sound_speed_m_s = 1e29"),
    ] {
        add(what, TANK.replacen(from, to, 1));
    }
}

/// Expressions without a value at the start, and some that lose it later.
fn expressions(add: Add<'_>) {
    for text in [
        "1/t",
        "ln(-t)",
        "sqrt(-1-t)",
        "1e308*1e308",
        "1e300",
        "1/(x-0.105)",
        "t/t",
        "sqrt(0.0004-t)",
        "1/(0.0004-t)",
    ] {
        add(&format!("a force of {text}"), force(&format!("[\"{text}\", 0]")));
        let moving =
            format!("name = \"box\"\nmotion = {{ displacement_x_m = \"{}\" }}", text.replace('x', "t"));
        add(&format!("a wall moved by {text}"), TANK.replacen("name = \"box\"", &moving, 1));
        let pushed = format!("name = \"block\"\nacceleration_m_s2 = [0, \"{text}\"]");
        add(&format!("a body pushed by {text}"), TANK.replacen("name = \"block\"", &pushed, 1));
    }
    for (what, from, to) in [
        ("gravity of 1e300", "[0.0, -9.81]", "[0.0, -1e300]"),
        ("gravity of 1e30", "[0.0, -9.81]", "[0.0, -1e30]"),
        ("water faster than sound", "name = \"water\"", "name = \"water\"\nvelocity_m_s = [25, 0]"),
        ("water 1e28 m deep", "surface_m = 0.12", "surface_m = 1e28"),
        ("a body faster than its waves", "name = \"block\"", "name = \"block\"\nvelocity_m_s = [1e4, 0]"),
        ("a body that spins at 1e20", "name = \"block\"", "name = \"block\"\nrotation_speed_rad_s = 1e20"),
        (
            "a wall that moves by sqrt(t)",
            "name = \"box\"",
            "name = \"box\"\nmotion = { displacement_x_m = \"sqrt(t)\" }",
        ),
        ("the plain sum with sub-steps", "margin_spacings = 1", "margin_spacings = 1\nlaw = \"plain-sum\""),
        ("contact through the sums", "[solid]", "[solid]\ncontact = { law = \"sums\" }\nsubsteps = 2"),
    ] {
        add(what, TANK.replacen(from, to, 1));
    }
}

/// Files that are none, and files that hurt.
fn files(folder: &Path, add: Add<'_>) {
    let path = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    let sparse = |name: &str, length: u64| {
        std::fs::File::create(folder.join(name)).unwrap().set_len(length).unwrap();
        path(name)
    };
    let pipe = |name: &str| {
        assert!(Command::new("mkfifo").arg(path(name)).status().unwrap().success());
        path(name)
    };
    let link = path("loop");
    std::os::unix::fs::symlink(&link, &link).unwrap();
    std::fs::write(folder.join("words.csv"), format!("x_m,y_m\n{},1\n", "\\u{1b}[31m".repeat(100_000)))
        .unwrap();
    std::fs::write(folder.join("raw.csv"), b"x_m,y_m\n\x1b[31m,1\n").unwrap();
    let corners: String = (0..9_999).fold("x_m,y_m\n".to_owned(), |mut text, k| {
        let angle = std::f64::consts::TAU * f64::from(k) / 9_999.0;
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{},{}", 0.1 + 0.05 * angle.cos(), 0.06 + 0.05 * angle.sin());
        text
    });
    std::fs::write(folder.join("corners.csv"), corners).unwrap();
    for file in [
        "/dev/zero",
        "/dev/random",
        "/proc/self/mem",
        "/dev/stdin",
        &folder.display().to_string(),
        &pipe("pipe"),
        &sparse("sparse.csv", 200 << 30),
        &link,
        &path("words.csv"),
        &path("raw.csv"),
    ] {
        add(
            &format!("a polygon from {file}"),
            with_shape(&format!("{{ type = \"polygon\", file = \"{file}\" }}")),
        );
        add(
            &format!("an outline from {file}"),
            with_shape(&format!("{{ type = \"outline\", file = \"{file}\", unit = \"m\" }}")),
        );
    }
    let shape = format!("{{ type = \"polygon\", file = \"{}\" }}", path("corners.csv"));
    let many: String =
        (0..3000).map(|k| format!("[[fluid.region]]\nname = \"r{k}\"\nshape = {shape}\n")).collect();
    add("a file of 9999 corners 3000 times", format!("{HEAD}{FLUID}{many}"));
    let earlier = |name: &str| {
        std::fs::create_dir_all(folder.join(name).join("final")).unwrap();
        folder.join(name).join("final/fluid.state")
    };
    std::fs::File::create(earlier("vast")).unwrap().set_len(100 << 30).unwrap();
    let state = earlier("piped");
    assert!(Command::new("mkfifo").arg(state).status().unwrap().success());
    std::os::unix::fs::symlink("/dev/zero", earlier("endless")).unwrap();
    std::fs::write(earlier("torn"), b"TIDESTAT\x01\0\0\0\xff\xff\xff\xff\xff\xff\xff\x7f").unwrap();
    for name in ["vast", "piped", "endless", "torn", "nowhere"] {
        add(&format!("an earlier run that is {name}"), format!("start_from = \"{}\"\n{TANK}", path(name)));
    }
}

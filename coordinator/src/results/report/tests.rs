//! Reports of made-up runs.

use sph::coupling::driver::StepReport;
use sph::coupling::ledger::{
    EnergyAccount, EnergyEntry, EnergyReport, Imbalance, InterfaceSums, LedgerVector, StageBudget,
};
use sph::coupling::solver::{Field, ParticleFields, Role};

use serde_json::json;

use super::*;
use crate::page::folder::{CaseFacts, Snapshots};
use crate::page::run::{FactTable, Sources};
use crate::results::energy::LedgerSide;
use crate::results::ledger::LedgerFile;
use crate::results::names;
use crate::results::table::Table;
use crate::results::vtk::Series;

/// How many times the fields are shown at.
const PICTURES: usize = 6;

/// Particles on a lattice over a box; `values` gives the value of the last field from the position.
fn block(
    lower: [f64; 2],
    counts: [u32; 2],
    spacing: f64,
    name: &str,
    quantity: &str,
    value: impl Fn([f64; 2]) -> f64,
) -> ParticleFields {
    let position: Vec<[f64; 2]> = (0..counts[0] * counts[1])
        .map(|k| {
            let (i, j) = (f64::from(k % counts[0]), f64::from(k / counts[0]));
            [lower[0] + (i + 0.5) * spacing, lower[1] + (j + 0.5) * spacing]
        })
        .collect();
    let n = position.len();
    let field = |name: &str, unit: &str, components, values| Field {
        name: name.into(),
        unit: unit.into(),
        components,
        values,
    };
    ParticleFields {
        step: 0,
        time: 0.0,
        id: (0..).take(n).collect(),
        group: vec![0; n],
        group_names: vec![name.into()],
        fields: vec![
            field("position", "m", 2, position.iter().flatten().copied().collect()),
            field("mass", "kg/m", 1, vec![1000.0 * spacing * spacing; n]),
            field("density", "kg/m3", 1, vec![1000.0; n]),
            field(quantity, "Pa", 1, position.iter().map(|x| value(*x)).collect()),
        ],
    }
}

/// `a` with the particles of `b` in a group of their own.
fn joined(mut a: ParticleFields, b: ParticleFields) -> ParticleFields {
    let (next_id, next_group) = (a.id.len() as u32, a.group_names.len() as u32);
    a.id.extend(b.id.iter().map(|id| id + next_id));
    a.group.extend(b.group.iter().map(|group| group + next_group));
    a.group_names.extend(b.group_names);
    for (field, other) in a.fields.iter_mut().zip(b.fields) {
        field.values.extend(other.values);
    }
    a
}

/// `particles` without those that `inside` holds.
fn cut(mut particles: ParticleFields, inside: impl Fn([f64; 2]) -> bool) -> ParticleFields {
    let keep: Vec<bool> = particles.fields[0].values.chunks(2).map(|x| !inside([x[0], x[1]])).collect();
    let kept = |k: usize| keep.get(k).copied().unwrap_or(false);
    let mut k = 0;
    particles.id.retain(|_| {
        k += 1;
        kept(k - 1)
    });
    for field in &mut particles.fields {
        let mut k = 0;
        field.values.retain(|_| {
            k += 1;
            kept((k - 1) / field.components)
        });
    }
    particles.group.truncate(particles.id.len());
    particles
}

/// A collapsing column in a tank, about as in case 5.2, without any physics.
fn fluid(time: f64) -> ParticleFields {
    let width = 73 + (400.0 * time) as u32;
    let height = (10_658.0 / f64::from(width)) as u32;
    let top = 0.002 * f64::from(height);
    let water = block([0.0, 0.0], [width, height], 0.002, "column", "pressure", |x| {
        9810.0 * (top - x[1]) * (1.0 + 2.0 * time * (20.0 * x[0]).sin())
    });
    let start = 0.234 + 0.22 * time;
    let water = cut(water, |[x, y]| {
        let body = (start..start + 0.036).contains(&x) && (0.008..0.044).contains(&y);
        body || ((0.398..0.41).contains(&x) && y < 0.08)
    });
    let zero = |_| 0.0;
    let floor = block([-0.006, -0.006], [298, 3], 0.002, "tank", "pressure", zero);
    let left = block([-0.006, 0.0], [3, 292], 0.002, "tank", "pressure", zero);
    let right = block([0.584, 0.0], [3, 292], 0.002, "tank", "pressure", zero);
    let mut all = joined(joined(joined(water, floor), left), right);
    all.time = time;
    all
}

fn solid(time: f64) -> ParticleFields {
    let bend = |x: [f64; 2]| (4e5 * time * (0.404 - x[0]) / 0.006 * (1.0 - x[1] / 0.08)).abs();
    let plate = block([0.398, 0.0], [6, 40], 0.002, "plate", "von_mises", bend);
    let start = 0.234 + 0.22 * time;
    let body = block([start, 0.008], [18, 18], 0.002, "body", "von_mises", |x| 800.0 * (0.05 - x[1]) / 0.05);
    let mut all = joined(plate, body);
    all.time = time;
    all
}

fn snapshots(sides: &[Role]) -> Vec<PairedSnapshot> {
    let at = |time| PairedSnapshot {
        time,
        fluid: sides.contains(&Role::Fluid).then(|| fluid(time)),
        solid: sides.contains(&Role::Solid).then(|| solid(time)),
    };
    [0.0, 0.1, 0.2, 0.3, 0.4, 0.5].map(at).into()
}

fn probes() -> Table {
    let columns = [
        "t_s",
        "p1_pressure_pa",
        "p1_velocity_x_m_s",
        "p1_velocity_y_m_s",
        "gauge_level_m",
        "all_mass_kg_per_m",
        "drift_centre_x_m",
        "drift_centre_y_m",
        "tip_displacement_x_m",
        "tip_displacement_y_m",
        "sums_kinetic_energy_j_per_m",
        "sums_potential_energy_j_per_m",
        "sums_strain_energy_j_per_m",
    ];
    let mut table = Table::new(columns.map(String::from).into());
    for k in 0..=2000 {
        let t = 0.00025 * f64::from(k);
        // A gauge that stands dry at first.
        let level = if t < 0.1 { f64::NAN } else { 0.02 * (t - 0.1) };
        table.push(&[
            t,
            2800.0 * (1.0 - t) + 300.0 * (150.0 * t).sin(),
            (9.0 * t).sin(),
            -0.4 * t,
            level,
            42.632,
            0.252 + 0.4 * t,
            0.026 + 0.1 * t * t,
            -1e-3 * (40.0 * t).sin(),
            2e-5 * (40.0 * t).cos(),
            3e-3 * t,
            -2e-3 * t,
            1e-4 * (80.0 * t).sin().powi(2),
        ]);
    }
    table
}

fn ledger(sides: &[Role]) -> Table {
    let root = tempfile::tempdir().unwrap();
    let path = root.path().join("ledger.csv");
    let accounts = vec![EnergyAccount::Kinetic, EnergyAccount::Potential, EnergyAccount::Viscosity];
    let ledger_sides: Vec<LedgerSide> = sides
        .iter()
        .map(|role| LedgerSide { role: *role, dimensions: 2, accounts: accounts.clone() })
        .collect();
    let mut file = LedgerFile::create(&path, &ledger_sides).unwrap();
    for step in 0..1000u64 {
        let t = 5e-4 * step as f64;
        let force = LedgerVector::new(40.0 * (20.0 * t).sin(), 12.0, 0.0);
        let report = |sign: f64| {
            let interface = InterfaceSums {
                force: sign * force,
                gross_force: 100.0,
                power: 0.5 * sign,
                ..InterfaceSums::default()
            };
            let budget = |duration: f64| StageBudget {
                interface,
                duration,
                momentum_change: duration * sign * force * (1.0 + 1e-15 * (2.0 + (900.0 * t).sin())),
                gross_momentum: 10.0,
                ..StageBudget::default()
            };
            let mut energies = EnergyReport::default();
            for (account, value, start) in [
                (EnergyAccount::Kinetic, 50.0 * t, 0.0),
                (EnergyAccount::Potential, 60.0 - 52.0 * t, 60.0),
                (EnergyAccount::Viscosity, 2.0 * t, 0.0),
            ] {
                energies.set(account, EnergyEntry { value, start });
            }
            StepReport {
                step,
                end_time: t + 5e-4,
                time_step: 5e-4,
                budgets: [budget(2.5e-4), budget(5e-4)],
                energies,
                ..StepReport::default()
            }
        };
        let imbalance = |k: f64| Imbalance {
            force: if t < 0.1 { 0.0 } else { k * 1e-15 * (1.5 + (700.0 * t).sin()) },
            torque: 3e-16 * k,
        };
        let (fluid, solid) = (report(1.0), report(-1.0));
        let of = |role, report| sides.contains(&role).then_some(report);
        file.record(of(Role::Fluid, &fluid), of(Role::Solid, &solid), &[imbalance(1.0), imbalance(4.0)]);
        if step % 2 == 1 {
            file.write_row().unwrap();
        }
    }
    Table::read(&file.finish().unwrap()).unwrap()
}

fn data(sides: &[Role]) -> ReportData {
    let pair = |(a, b): (&str, &str)| (a.to_string(), b.to_string());
    let snapshots = snapshots(sides);
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join(names::SNAPSHOTS);
    std::fs::create_dir(&folder).unwrap();
    let mut series = [Series::new(&folder, Role::Fluid), Series::new(&folder, Role::Solid)];
    for (step, pair) in (0..).zip(&snapshots) {
        for (series, fields) in series.iter_mut().zip([&pair.fluid, &pair.solid]) {
            if let Some(fields) = fields {
                series.write(&ParticleFields { step, ..fields.clone() }).unwrap();
            }
        }
    }
    let case = CaseFacts {
        title: "Drifting <body> & plate".into(),
        dimensions: 2,
        up_axis: 1,
        walls: vec!["tank".into()],
        spacings: [Some(0.002); 2],
        span: [0.0, 0.5],
        tolerance: Some(1e-12),
    };
    let film = Film::of(&case, &Snapshots::list(root.path(), false)).unwrap();
    let summary = json!({
        "verdict": "completed", "reason": "the end time 0.5 s was reached", "steps": 50000, "reservations": ["mach_number = 0.5"],
        "quality": [{"name": "mach_number", "value": 0.5, "threshold": 0.3, "verdict": "reservation",
            "meaning": "largest speed", "advice": "raise the sound speed"}],
    });
    let facts = [("wall time", "312 s"), ("particles", "11510 fluid, 564 solid")].map(pair).into();
    let sources = Sources {
        summary: Some(&summary),
        probes: probes(),
        ledger: ledger(sides),
        extremes: film.as_ref().map_or(&[], |film| &film.extremes),
        tables: vec![FactTable { id: "facts", headline: "Run", rows: facts }],
    };
    let page = RunPage::new(root.path(), &case, sources);
    let page = film.iter().fold(page, |page, film| page.with_film(film));
    ReportData { page, film, snapshots, walls: case.walls, up_axis: 1 }
}

fn count(html: &str, part: &str) -> usize {
    html.matches(part).count()
}

/// The message inside a report.
fn message(html: &str) -> serde_json::Value {
    let start = html.split("id=\"run\">").nth(1).unwrap();
    serde_json::from_str(start.split("</script>").next().unwrap()).unwrap()
}

#[test]
fn a_report_is_one_file_with_film_and_pictures() {
    let html = html(&data(&[Role::Fluid, Role::Solid])).unwrap();
    for id in ["run", "page", "pressure", "stress"] {
        assert_eq!(count(&html, &format!("id=\"{id}\"")), 1, "{id}");
    }
    assert_eq!(count(&html, "class=\"frame\">"), PICTURES);
    assert_eq!(count(&html, "data:image/png;base64,iVBOR"), 2 * PICTURES);
    assert!(html.contains("Drifting &lt;body&gt; &amp; plate") && !html.contains("<body> &"));
    for outside in ["src=\"http", "href=\"http", "url(", "@import", "src=\"/", "import("] {
        assert_eq!(count(&html, outside), 0, "{outside}");
    }
    // Names of XML vocabularies are no addresses that a browser would open.
    let without_names = html.replace("http://www.w3.org/2000/svg", "");
    assert_eq!(count(&without_names, "http://") + count(&without_names, "https://"), 0);
    assert!(html.len() < 2_000_000, "{} bytes", html.len());
}

#[test]
fn a_report_says_what_came_out() {
    let html = html(&data(&[Role::Fluid, Role::Solid])).unwrap();
    let message = message(&html);
    let sentence = message["sentence"].as_str().unwrap();
    // The largest displacement of the probe is −1 mm · sin(40 t), at t = π/80.
    assert!(sentence.contains("tip displacement, x reaches −1\u{a0}mm at 0.0393"), "{sentence}");
    assert!(sentence.contains("largest von Mises stress ") && sentence.contains(" in plate"), "{sentence}");
    assert!(html.contains(&document::escaped(sentence)), "readable without scripts");
    assert_eq!(message["verdict"], "completed, with reservations");
    assert_eq!(message["quality"][0]["advice"], "raise the sound speed");
    let names: Vec<&str> =
        message["plots"].as_array().unwrap().iter().map(|group| group["id"].as_str().unwrap()).collect();
    assert_eq!(names, ["motion", "water", "energies-of-probes", "sums", "energies", "ledger"]);
    let figure = &message["figures"][0];
    assert_eq!(figure["name"], "von Mises stress, solids");
    assert!(figure["place"].as_str().unwrap().starts_with("plate, (0."), "{figure}");
    let budget = &message["budgets"][0]["accounts"];
    assert_eq!(budget.as_array().unwrap().last().unwrap()["kind"], "residual");
}

#[test]
fn one_side_alone_is_enough() {
    let fluid = html(&data(&[Role::Fluid])).unwrap();
    assert_eq!(count(&fluid, "<img"), PICTURES);
    assert!(!fluid.contains("id=\"stress\"") && !fluid.contains("solids orange"));
    assert!(!message(&fluid).to_string().contains("Action = reaction"), "no partner, no balance");
    let solid = html(&data(&[Role::Solid])).unwrap();
    assert!(solid.contains("id=\"stress\"") && !solid.contains("id=\"pressure\""));
}

#[test]
fn a_run_that_left_nothing_still_has_its_facts() {
    let empty = ReportData {
        page: RunPage {
            title: "t".into(),
            verdict: "failed".into(),
            reason: "diverged at step 0 predictor".into(),
            warnings: vec!["1 particle lost".into()],
            ..RunPage::default()
        },
        ..ReportData::default()
    };
    let html = html(&empty).unwrap();
    assert!(html.contains("diverged at step 0") && html.contains("<td>1 particle lost</td>"));
    assert_eq!(count(&html, "<img") + count(&html, "class=\"frame\">"), 0);
}

#[test]
fn fields_that_are_missing_or_no_numbers_are_survived() {
    let mut odd = data(&[Role::Fluid, Role::Solid]);
    for (k, snapshot) in odd.snapshots.iter_mut().enumerate() {
        let (Some(fluid), Some(solid)) = (&mut snapshot.fluid, &mut snapshot.solid) else { panic!() };
        match k {
            0 => fluid.fields.retain(|field| field.name != "pressure"),
            1 => fluid.fields[0].values[7] = f64::NAN,
            2 => solid.fields.retain(|field| field.name == "position"),
            3 => solid.fields.clear(),
            _ => fluid.fields[3].values.fill(f64::INFINITY),
        }
    }
    assert!(count(&html(&odd).unwrap(), "<img") > PICTURES);
}

#[test]
fn a_film_keeps_to_its_size_by_coarser_values_and_fewer_particles() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join(names::SNAPSHOTS);
    std::fs::create_dir(&folder).unwrap();
    let mut series = Series::new(&folder, Role::Fluid);
    for (step, time) in [(0, 0.0), (1, 0.1), (2, 0.2)] {
        series.write(&ParticleFields { step, ..fluid(time) }).unwrap();
    }
    let case = CaseFacts { dimensions: 2, walls: vec!["tank".into()], ..CaseFacts::default() };
    let list = Snapshots::list(root.path(), false);
    let whole = Film::within(&case, &list, 12_000_000).unwrap().unwrap();
    assert!(whole.notes.is_empty() && whole.columns.iter().all(|column| column.bits == 16));
    let size = |film: &Film| film.frames.iter().map(|frame| frame.data.len()).sum::<usize>();
    let small = Film::within(&case, &list, size(&whole) / 20).unwrap().unwrap();
    assert!(size(&small) <= size(&whole) / 20);
    assert!(
        small.scene.every > 1 && small.notes[0].contains(&format!("one particle in {}", small.scene.every))
    );
    // Extremes are those of all particles.
    assert_eq!(small.extremes, whole.extremes);
}

#[test]
fn the_file_is_written_whole() {
    let root = tempfile::tempdir().unwrap();
    let path = root.path().join("report.html");
    write(&path, &ReportData::default()).unwrap();
    assert!(std::fs::read_to_string(&path).unwrap().trim_end().ends_with("</html>"));
}

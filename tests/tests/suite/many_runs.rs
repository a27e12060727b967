//! Many runs of one case through the program: values set over it, sweeps here and by a scheduler, convergence, ensembles,
//! overlays.

use std::path::Path;
use std::process::{Command, Output};
use std::time::{Duration, Instant};

use crate::{PROGRAM, bench};
use tests::bench::{Bench, text};

/// Water in a box: 200 particles and 20 steps.
const BOX: &str = r#"name = "box"
[domain]
lower_m = [0.0, 0.0]
upper_m = [0.2, 0.2]
[body_force]
gravity_m_s2 = [0.0, -9.81]
[time]
end_time_s = 0.004
step = { type = "adaptive" }
[outputs]
probe_interval_s = 0.001
[fluid]
particle_spacing_m = 0.01
sound_speed_m_s = 20.0
rest_density_kg_m3 = 1000.0
[[fluid.region]]
name = "water"
shape = { type = "rectangle", lower_m = [0.0, 0.0], upper_m = [0.1, 0.1] }
[[wall]]
name = "box"
type = "container"
open_sides = ["top"]
[[probe]]
name = "water"
type = "fluid-sums"
"#;

fn said(output: &Output) -> (String, String) {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (text(&output.stdout), text(&output.stderr))
}

/// Calls the program, which must succeed; what it prints on standard output.
fn call(bench: &Bench, arguments: &[&str]) -> String {
    let output = bench.call(arguments);
    let (out, errors) = said(&output);
    assert!(output.status.success(), "{arguments:?}: {out}\n{errors}");
    out
}

#[test]
fn values_set_by_the_command_line_are_checked_as_those_of_the_file_and_recorded() {
    let bench = bench();
    let case = bench.write("box.toml", BOX);
    let set = ["--set", "fluid.sound_speed_m_s=25", "--set", "wall.box.condition=no-slip"];
    let summary = bench.run(&case, "out", &[&set[..], &["--in-process"]].concat());
    assert_eq!(summary["set"][0]["key"], "fluid.sound_speed_m_s");
    assert_eq!(summary["set"][1]["value"], "\"no-slip\"");
    assert_eq!(summary["parameters"]["fluid.sound_speed_m_s"], 25.0);
    let recorded = std::fs::read_to_string(bench.path("out/case.toml")).unwrap();
    assert!(
        recorded.starts_with("# set: fluid.sound_speed_m_s = 25\n# set: wall.box.condition = "),
        "{recorded}"
    );
    // A run of the recorded case, and one that continues, remember what was set.
    let again = bench.run(&bench.path("out/case.toml"), "again", &["--in-process"]);
    assert_eq!(again["set"], summary["set"]);
    assert_eq!(again["fluid"]["state_digest"], summary["fluid"]["state_digest"]);
    let out = bench.path("out");
    call(&bench, &["resume", text(&out), "--until", "0.005", "--quiet", "--in-process"]);
    assert_eq!(bench.summary("out")["set"], summary["set"]);

    let said = call(&bench, &["check", text(&case), "--set", "fluid.particle_spacing_m=0.02"]);
    assert!(said.contains("1 set over the file") && said.contains("25 fluid"), "{said}");
    let unknown = ["check", text(&case), "--set", "fluid.sound_sped_m_s=25"];
    bench.refused(&unknown, 2, &["values set over the file", "did you mean `sound_speed_m_s`?"]);
    bench.run_refused(&case, &["--set", "wall.bax.condition=slip"], 2, &["did you mean `box`?"]);
    bench.run_refused(&case, &["--set", "fluid.sound_speed_m_s"], 2, &["KEY=VALUE"]);
}

#[test]
fn a_sweep_keeps_what_is_finished_names_what_is_wrong_and_its_runs_are_overlaid() {
    let bench = bench();
    let case = bench.write("box.toml", BOX);
    let out = bench.path("swept");
    let over = "fluid.sound_speed_m_s=20,-1,30";
    let sweep = ["sweep", text(&case), "--over", over, "--jobs", "2", "--out", text(&out), "--in-process"];
    let output = bench.call(&sweep);
    let (table, errors) = said(&output);
    assert_eq!(output.status.code(), Some(12), "{table}\n{errors}");
    assert!(errors.contains("[2/2]") && errors.contains("1 of 3 members are not finished: 2;"), "{errors}");
    assert!(
        table.contains("member 2, sound_speed_m_s=-1: wrong case") && table.contains("above 0"),
        "{table}"
    );
    let csv = std::fs::read_to_string(out.join("sweep.csv")).unwrap();
    assert_eq!(csv.lines().filter(|line| line.contains(",finished,")).count(), 2, "{csv}");
    // Once more: nothing is run.
    let (_, errors) = said(&bench.call(&sweep));
    assert_eq!(errors.matches(": kept").count(), 2, "{errors}");

    let run = |name: &str| out.join(format!("members/sound_speed_m_s={name}/results"));
    let (a, b, page) = (run("20"), run("30"), bench.path("overlay"));
    let shown = call(&bench, &["overlay", text(&a), text(&b), "--out", text(&page)]);
    assert!(shown.contains("fluid.sound_speed_m_s") && shown.contains("sound_speed_m_s=30"), "{shown}");
    assert!(page.join("overlay.html").is_file() && page.join("overlay.csv").is_file());
    bench.refused(&["overlay", text(&a), text(&bench.path("no"))], 2, &["holds no `probes.csv`"]);
    let sampled = ["sweep", text(&case), "--over", "fluid.sound_speed_m_s=20..30"];
    bench.refused(&sampled, 2, &["--latin N"]);
}

/// Runs the emitted script as Slurm does for one element.
fn element(script: &Path, number: &str) -> Output {
    let mut bash = Command::new("bash");
    bash.arg(script).env("SLURM_ARRAY_TASK_ID", number).env("SLURM_CPUS_PER_TASK", "1").output().unwrap()
}

#[test]
fn an_array_job_is_made_element_by_element_and_joined_by_a_second_call() {
    let bench = bench();
    let case = bench.write("box.toml", BOX);
    let out = bench.path("my sweep");
    let over = ["--over", "fluid.sound_speed_m_s=20..30", "--latin", "3", "--latin-seed", "7"];
    let emit = ["--emit", "slurm", "--program", PROGRAM, "--threads", "1", "--out", text(&out)];
    let said_first = call(&bench, &[&["sweep", text(&case)][..], &over, &emit].concat());
    assert!(said_first.contains("start:   sbatch '"), "{said_first}");
    let script = out.join("sweep.sbatch");
    assert!(Command::new("bash").arg("-n").arg(&script).status().unwrap().success());
    // The nodes need the folder of the sweep and nothing else.
    std::fs::remove_file(&case).unwrap();
    assert_eq!(Command::new("bash").arg(&script).output().unwrap().status.code(), Some(2));
    let output = element(&script, "2");
    let (printed, errors) = said(&output);
    assert!(
        output.status.success() && printed.starts_with("member 2, sound_speed_m_s="),
        "{printed}{errors}"
    );
    let join = ["sweep", "--join", text(&out)];
    let output = bench.call(&join);
    assert_eq!(output.status.code(), Some(12));
    assert!(said(&output).1.contains("2 of 3 members are not finished: 1,3;"), "{output:?}");
    for number in ["1", "2", "3"] {
        let output = element(&script, number);
        assert_eq!(said(&output).0.contains(": kept"), number == "2", "{output:?}");
    }
    let table = call(&bench, &join);
    assert_eq!(table.matches("finished").count(), 3, "{table}");
    let output = element(&script, "4");
    assert!(!output.status.success() && said(&output).1.contains("members 1 to 3"), "{output:?}");
}

#[test]
fn a_member_that_was_killed_continues_from_its_checkpoint() {
    let bench = bench();
    let case = bench.write("box.toml", &BOX.replace("0.004", "2.0"));
    let out = bench.path("swept");
    let sweep = ["sweep", text(&case), "--seeds", "1", "--out", text(&out), "--emit", "snakemake"];
    call(&bench, &sweep);
    let snakefile = std::fs::read_to_string(out.join("Snakefile")).unwrap();
    assert!(snakefile.contains("PROGRAM = \"tidelock\""), "{snakefile}");
    let member =
        ["sweep", "--member", "1", "--out", text(&out), "--in-process", "--checkpoint-every-steps", "40"];
    let mut killed = Command::new(PROGRAM).args(member).spawn().unwrap();
    let checkpoints = out.join("members/seed=1/results/checkpoints");
    let start = Instant::now();
    // One whose folder still has a partial name may not count.
    let is_complete = |folder: &Path| {
        folder.join("manifest.json").is_file() && folder.extension().is_none_or(|end| end != "partial")
    };
    // A step takes some 0.1 ms; five minutes are for a machine that is busy with other things.
    while !std::fs::read_dir(&checkpoints)
        .is_ok_and(|mut folder| folder.any(|entry| entry.is_ok_and(|entry| is_complete(&entry.path()))))
    {
        assert!(start.elapsed() < Duration::from_secs(300), "no checkpoint");
        assert!(killed.try_wait().unwrap().is_none(), "it ended before it was killed");
        std::thread::sleep(Duration::from_millis(5));
    }
    killed.kill().unwrap();
    killed.wait().unwrap();
    let (table, errors) = said(&bench.call(&["sweep", "--join", text(&out)]));
    assert!(table.contains("unfinished") && table.contains("was interrupted"), "{table}{errors}");
    let printed = call(&bench, &member);
    assert!(printed.contains("continued from step "), "{printed}");
    assert!(call(&bench, &member).contains(": kept"));
    call(&bench, &["sweep", "--join", text(&out)]);
}

#[test]
fn convergence_and_ensembles_say_what_they_found() {
    let bench = bench();
    let case = bench.write("box.toml", BOX);
    let out = bench.path("converged");
    let figure = "water_kinetic_energy_j_per_m at 0.004 s";
    let common = ["--figure", figure, "--in-process", "--threads", "1"];
    let converge = ["converge", text(&case), "--out", text(&out)];
    let printed = call(&bench, &[&converge[..], &common].concat());
    // Spacings 2.25, 1.5 and 1 times that of the case.
    for word in ["0.0225 m", "0.015 m", "0.01 m", figure, "onverged"] {
        assert!(printed.contains(word), "{word}: {printed}");
    }
    let sentence =
        printed.lines().find(|line| line.contains("CONVERGED") || line.starts_with("Converged")).unwrap();
    let page = std::fs::read_to_string(out.join("convergence.html")).unwrap();
    assert!(page.contains(&sentence[..20]) && page.contains("<svg"), "{sentence}");
    let members = std::fs::read_to_string(out.join("members.csv")).unwrap();
    assert_eq!(members.lines().count(), 7, "{members}");
    // With a tolerance that nothing meets.
    let strict = call(&bench, &[&converge[..], &common, &["--tolerance", "1e-12"]].concat());
    assert!(
        strict.contains("NOT CONVERGED: 1 of 1 key figures") && strict.contains("`ensemble`"),
        "{strict}"
    );

    let out = bench.path("ensemble");
    let ensemble = ["ensemble", text(&case), "--seeds", "3", "--out", text(&out)];
    let printed = call(&bench, &[&ensemble[..], &common].concat());
    let row = printed.lines().find(|line| line.starts_with(figure)).unwrap();
    assert!(row.ends_with(" 3") && out.join("ensemble.html").is_file(), "{printed}");
    let page = std::fs::read_to_string(out.join("ensemble.html")).unwrap();
    assert!(page.contains(">mean</span>"));
}

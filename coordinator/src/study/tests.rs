//! The study as a whole, on rows that are made up.

use std::collections::BTreeMap;

use super::*;

fn row(scheme: &'static str, spacing: f64, error: Option<f64>, cpu: f64) -> Row {
    let seconds = |share: f64| share * cpu;
    let passes =
        BTreeMap::from([("own sums".to_owned(), seconds(0.6)), ("cross sums".to_owned(), seconds(0.4))]);
    let flaw = error.is_none().then(|| "torn <apart>".to_owned());
    let measured = Measured {
        made_by: String::new(),
        error,
        flaw,
        cpu_seconds: cpu,
        process_cpu_seconds: cpu,
        kernel_seconds: 1e-9,
        steps: 10,
        particles: 100,
        passes,
    };
    Row { study: 0, scheme, step: "step of the case", spacing, measured, on_front: false, order: None }
}

fn rows() -> Vec<Row> {
    let mut rows = vec![
        row("recommended", 0.1, Some(0.04), 1.0),
        row("recommended", 0.05, Some(0.01), 8.0),
        row("lattice moment", 0.1, Some(0.05), 2.0),
        row("lattice moment", 0.05, None, 4.0),
    ];
    judge(&mut rows);
    rows
}

#[test]
fn the_front_and_the_orders_are_those_of_each_scheme_and_case() {
    let rows = rows();
    assert_eq!(rows.iter().map(|row| row.on_front).collect::<Vec<_>>(), [true, true, false, false]);
    // Exact in binary: a quarter of the error at half the spacing.
    assert_eq!(rows.iter().map(|row| row.order).collect::<Vec<_>>(), [None, Some(2.0), None, None]);
}

#[test]
fn a_report_holds_every_run_its_picture_and_where_the_time_went() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ReportArguments {
        cases: Vec::new(),
        full: false,
        out: folder.path().to_owned(),
        fresh: false,
        list: false,
    };
    write(folder.path(), &rows(), &arguments).unwrap();
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    let html = read("report.html");
    for expected in ["<svg", "own sums 60 %", "torn &lt;apart&gt;", "4.000 %", "class=\"front\""] {
        assert!(html.contains(expected), "{expected}");
    }
    assert!(
        !html.contains("http://")
            || html.matches("http://").count() == html.matches("http://www.w3.org").count()
    );
    let csv = read("report.csv");
    assert_eq!(csv.lines().count(), 5);
    assert_eq!(csv.lines().next().map(|line| line.split(',').count()), Some(COLUMNS.len()));
    assert!(
        csv.contains("recommended,step of the case,0.05,100,10,0.01,8,8000000000,4000000,yes,2,8,"),
        "{csv}"
    );
    assert!(std::fs::metadata(folder.path().join("report.png")).unwrap().len() > 1000);
}

#[test]
fn an_unknown_case_is_refused_with_those_there_are() {
    let arguments = ReportArguments {
        cases: vec!["drip".into()],
        full: false,
        out: "unused".into(),
        fresh: false,
        list: true,
    };
    let failure = report(&arguments).unwrap_err();
    assert!(failure.message.contains("`drip`") && failure.message.contains("drop"), "{failure:?}");
}

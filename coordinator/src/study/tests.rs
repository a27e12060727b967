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
        // A power of two: quotients by it are exact.
        kernel_seconds: 2f64.powi(-30),
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
    write(folder.path(), &rows(), false).unwrap();
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
        csv.contains("recommended,step of the case,0.05,100,10,0.01,8,8589934592,4000000,yes,2,8,"),
        "{csv}"
    );
    assert!(std::fs::metadata(folder.path().join("report.png")).unwrap().len() > 1000);
}

#[test]
fn an_unknown_case_is_refused_with_those_there_are() {
    let request = StudyRequest { cases: vec!["drip".into()], ..StudyRequest::default() };
    let failure = list(&request).unwrap_err();
    assert!(failure.message.contains("`drip`") && failure.message.contains("drop"), "{failure:?}");
}

#[test]
fn a_finished_run_is_kept_until_its_case_or_its_maker_changes() {
    let folder = tempfile::tempdir().unwrap();
    let mut request = StudyRequest { out: folder.path().to_owned(), ..StudyRequest::default() };
    let mut member = Study::members(0, false).unwrap().remove(0);
    // The one test that records: a process does so once.
    let totals = Totals::default();
    trace::record(totals.clone()).unwrap();
    let (first, kept) = measured(&member, &request, &totals).unwrap();
    assert!(!kept && first.error.is_some_and(|error| error < 0.1), "{first:?}");
    assert!(first.cpu_seconds > 0.0 && first.passes["own sums"] < first.cpu_seconds, "{first:?}");
    let (again, kept) = measured(&member, &request, &totals).unwrap();
    // Read back from decimal text, which may cost the last bit.
    assert!(kept && (again.cpu_seconds / first.cpu_seconds - 1.0).abs() < 1e-12, "{again:?}");

    let kept = folder.path().join("runs/drop").join(member.label()).join(MEASURED);
    let stranger = Measured { made_by: "another build".into(), ..first };
    std::fs::write(&kept, serde_json::to_vec(&stranger).unwrap()).unwrap();
    assert!(!measured(&member, &request, &totals).unwrap().1, "another build made it");
    std::fs::remove_file(&kept).unwrap();
    assert!(!measured(&member, &request, &totals).unwrap().1, "it was not finished");
    member.text.push_str("# other\n");
    assert!(!measured(&member, &request, &totals).unwrap().1, "the case is another");
    request.fresh = true;
    assert!(!measured(&member, &request, &totals).unwrap().1, "all runs were asked for again");
}

//! Overlays of synthetic runs.

use super::*;

fn history(values: &[f64]) -> Vec<(f64, f64)> {
    values.iter().enumerate().map(|(k, value)| (k as f64, *value)).collect()
}

#[test]
fn peaks_are_the_first_of_several_and_pass_over_what_is_no_number() {
    let peaks = Peaks::of(&history(&[1.0, 3.0, f64::NAN, 3.0, -2.0, -2.0])).unwrap();
    assert_eq!((peaks.largest, peaks.smallest, peaks.last), ((3.0, 1.0), (-2.0, 4.0), -2.0));
    assert_eq!(Peaks::of(&history(&[f64::NAN])), None);
}

#[test]
fn differences_are_at_all_times_of_both_within_both() {
    // A ramp, and the same with a peak between its rows that ends later.
    let ramp = [(0.0, 0.0), (2.0, 2.0), (4.0, 4.0)];
    let other = [(0.0, 0.0), (1.0, 5.0), (2.0, 2.0), (4.0, 4.0), (6.0, 100.0)];
    let difference = Difference::of(&other, &ramp).unwrap();
    assert_eq!((difference.largest, difference.range), ((4.0, 1.0), 4.0));
    // Squares 0, 16, 0, 0 at 0, 1, 2, 4 by trapezia: 16 over 4.
    assert_eq!(difference.root_mean_square, 2.0);
    assert_eq!(Difference::of(&ramp, &ramp).unwrap().largest.0, 0.0);
    assert_eq!(Difference::of(&ramp, &[(10.0, 0.0), (11.0, 0.0)]), None);
}

fn put(folder: &Path, probes: &str, case: &str) {
    std::fs::create_dir_all(folder).unwrap();
    std::fs::write(folder.join("probes.csv"), probes).unwrap();
    std::fs::write(folder.join("case.toml"), case).unwrap();
    std::fs::write(folder.join("summary.json"), "{\"verdict\": \"completed\"}").unwrap();
}

#[test]
fn runs_are_named_apart_and_compared_key_by_key_and_column_by_column() {
    let root = tempfile::tempdir().unwrap();
    let [a, b] = ["a/results", "b/results"].map(|name| root.path().join(name));
    let case = |e: &str| format!("x = 1\n[[body]]\nname = \"plate\"\nmaterial = {{ e_pa = {e} }}\n");
    put(&a, "t_s,tip_displacement_y_m,old\n0,0,1\n1,2,1\n", &case("1e5"));
    put(&b, "t_s,tip_displacement_y_m\n0,0\n0.5,3\n1,1\n", &case("2e5"));
    let mut request =
        OverlayRequest { runs: vec![a, b], columns: Vec::new(), out: root.path().join("overlay") };
    let overlay = make(&request).unwrap();
    let names: Vec<&str> = overlay.runs.iter().map(|run| run.name.as_str()).collect();
    assert_eq!(names, ["a", "b"]);
    let [(key, values)] = &overlay.differing_keys[..] else { panic!("{:?}", overlay.differing_keys) };
    assert_eq!(key, "body.plate.material.e_pa");
    assert_eq!(*values, [Some("100000.0".to_owned()), Some("200000.0".to_owned())]);
    assert_eq!(overlay.columns.len(), 2);
    assert_eq!(overlay.columns[0].differences[1].unwrap().largest, (2.0, 0.5));
    assert_eq!(overlay.columns[1].peaks[1], None, "a column that a run lacks");
    let csv = std::fs::read_to_string(root.path().join("overlay/overlay.csv")).unwrap();
    assert!(csv.contains("tip_displacement_y_m,b,3,0.5,0,0,1,2,0.5,"), "{csv}");
    let page = std::fs::read_to_string(root.path().join("overlay/overlay.html")).unwrap();
    assert_eq!(page.matches("<svg").count(), 2, "{page}");
    assert!(page.contains(">a</span>") && page.contains(">b</span>"));
    let text = output::lines(&overlay).join("\n");
    assert!(text.contains("100 % of `tip_displacement_y_m`") || text.contains("100.00 %"), "{text}");

    request.columns = vec!["tip_displacement_m".to_owned()];
    let message = read(&request).unwrap_err().message;
    assert!(message.contains("did you mean `tip_displacement_y_m`?"), "{message}");
    request.runs.push(root.path().join("none"));
    let message = read(&request).unwrap_err().message;
    assert!(message.contains("none` holds no `probes.csv`"), "{message}");
}

#[test]
fn numbers_have_five_digits() {
    let shown = [0.0, 1.0, 0.019_123_456, 123_456.0, 1.5e-7, -2.5e9].map(page::short);
    assert_eq!(shown, ["0", "1.0000", "0.019123", "123456", "1.5000e-7", "-2.5000e9"]);
}

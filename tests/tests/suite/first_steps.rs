//! Every shipped case runs: two steps with both solvers.

use tests::first_steps::first_steps;
use tests::source_tree::case_files;

#[test]
fn every_shipped_case_takes_two_steps() {
    let cases = case_files();
    assert!(cases.len() > 50, "{} cases", cases.len());
    for path in cases {
        let sides = first_steps(&path, 2).unwrap();
        assert!(!sides.is_empty(), "{}", path.display());
        for side in sides {
            assert_eq!(side.step, 2, "{}: {side:?}", path.display());
            assert!(side.time > 0.0, "{}: {side:?}", path.display());
        }
    }
}

use super::*;

#[test]
fn every_member_is_a_case_without_errors_with_a_folder_of_its_own() {
    let mut labels = Vec::new();
    for (index, study) in ALL.iter().enumerate() {
        for member in Study::members(index, true).unwrap() {
            let folder = tempfile::tempdir().unwrap();
            let file = folder.path().join("case.toml");
            std::fs::write(&file, &member.text).unwrap();
            crate::run::load(&file).unwrap_or_else(|e| panic!("{} {}: {e:?}", study.name, member.label()));
            labels.push(format!("{}/{}", study.name, member.label()));
        }
    }
    let count = labels.len();
    labels.sort();
    labels.dedup();
    assert_eq!(labels.len(), count);
}

#[test]
fn a_step_policy_divides_the_step_and_a_scheme_changes_the_settings() {
    let index = ALL.iter().position(|study| study.name == "taylor_green").unwrap();
    let members = Study::members(index, false).unwrap();
    let find = |scheme: &str, step: &str| -> toml::Table {
        let member = members.iter().find(|m| m.scheme == scheme && m.step == step).unwrap();
        member.text.parse().unwrap()
    };
    let (whole, half) = (find("recommended", "step of the case"), find("lattice moment", "half the step"));
    let factor = |case: &toml::Table| case["time"]["step"]["factor"].as_float().unwrap();
    assert_eq!(factor(&half), 0.5 * factor(&whole));
    assert_eq!(half["fluid"]["gradient_correction"].as_str(), Some("lattice-moment"));
    assert!(whole["fluid"].get("gradient_correction").is_none(), "the recommended settings are the defaults");
}

//! Tables of a run that is resumed: as they were, changed, cut, gone.

use super::*;

fn columns() -> Vec<String> {
    vec!["t_s".into(), "a, b".into()]
}

/// A table of `rows` rows under its partial name, and its mark.
fn table(root: &Path, rows: u32) -> (PathBuf, TableMark) {
    let path = root.join("probes.csv");
    let mut file = TableFile::create(&path, &columns()).unwrap();
    for k in 0..rows {
        file.push(&[f64::from(k), 1.0 / f64::from(k + 1)]).unwrap();
    }
    (path, file.mark())
}

/// Replaces `from` by `to` in the table under its partial name.
fn change(path: &Path, from: &str, to: &str) {
    let partial = with_suffix(path);
    let text = fs::read_to_string(&partial).unwrap();
    assert!(text.contains(from), "{from}");
    fs::write(&partial, text.replacen(from, to, 1)).unwrap();
}

fn refusal(path: &Path, mark: &TableMark) -> String {
    let before = fs::read(with_suffix(path)).ok();
    let message = TableFile::examine(path, &columns(), mark).unwrap_err().to_string();
    let Err(error) = TableFile::resume(path, &columns(), mark, Changed::Refuse) else {
        panic!("continued though {message}")
    };
    assert_eq!(error.to_string(), message);
    assert_eq!(fs::read(with_suffix(path)).ok(), before, "changed by a refusal");
    message
}

#[test]
fn rows_after_the_mark_go_and_the_next_mark_is_that_of_one_run() {
    let root = tempfile::tempdir().unwrap();
    let (path, _) = table(root.path(), 300);
    let whole = fs::read(with_suffix(&path)).unwrap();
    for kept in [0, 1, 63, 64, 65, 130, 299] {
        let (path, mark) = table(root.path(), kept);
        let longer = fs::read_to_string(with_suffix(&path)).unwrap() + "1e9,1e9\n7.0";
        fs::write(with_suffix(&path), longer).unwrap();
        TableFile::examine(&path, &columns(), &mark).unwrap();
        let resumed = TableFile::resume(&path, &columns(), &mark, Changed::Refuse).unwrap();
        assert_eq!(resumed.warning, None);
        let mut file = resumed.file;
        for k in kept..300 {
            file.push(&[f64::from(k), 1.0 / f64::from(k + 1)]).unwrap();
        }
        assert_eq!(fs::read(with_suffix(&path)).unwrap(), whole);
        let mark = file.mark();
        TableFile::examine(&path, &columns(), &mark).unwrap();
        let last = "299.0,0.0033333333333333335\n".len() as u64;
        assert_eq!(file.mark_before_last().length(), mark.length() - last);
    }
}

#[test]
fn a_changed_digit_is_found_and_confined() {
    let root = tempfile::tempdir().unwrap();
    // Few rows: the line itself.
    let (path, mark) = table(root.path(), 10);
    change(&path, "3.0,0.25", "3.0,0.26");
    let message = refusal(&path, &mark);
    for word in ["probes.csv", "line 5 ", "--accept-changed-outputs", "run --force", "put it back"] {
        assert!(message.contains(word), "no {word:?} in {message}");
    }
    // The line of names.
    let (path, mark) = table(root.path(), 10);
    change(&path, "t_s", "t_m");
    assert!(refusal(&path, &mark).contains("between line 1 and line 2"));
    // Many rows: a range of lines around it, a small part of the table.
    let (path, mark) = table(root.path(), 10_000);
    change(&path, "\n5000.0,", "\n5001.0,");
    let message = refusal(&path, &mark);
    let numbers: Vec<u64> = message
        .split("line ")
        .skip(1)
        .map(|rest| rest.split(|c: char| !c.is_ascii_digit()).next().unwrap().parse().unwrap())
        .collect();
    assert!(numbers[0] <= 5002 && 5002 <= numbers[1], "{message}");
    assert!(numbers[1] - numbers[0] < 400, "{message}");
}

#[test]
fn cut_and_missing_tables_links_and_pipes_are_refused() {
    let root = tempfile::tempdir().unwrap();
    let (path, mark) = table(root.path(), 10);
    let partial = with_suffix(&path);
    let bytes = fs::read(&partial).unwrap();
    fs::write(&partial, &bytes[..60]).unwrap();
    assert!(refusal(&path, &mark).contains(&format!("has 60 bytes, but had {}", bytes.len())));
    fs::remove_file(&partial).unwrap();
    assert!(refusal(&path, &mark).contains("is missing"));
    let elsewhere = root.path().join("elsewhere");
    fs::write(&elsewhere, &bytes).unwrap();
    std::os::unix::fs::symlink(&elsewhere, &partial).unwrap();
    assert!(refusal(&path, &mark).contains("is a link"));
    assert_eq!(fs::read(&elsewhere).unwrap(), bytes);
    fs::remove_file(&partial).unwrap();
    assert!(std::process::Command::new("mkfifo").arg(&partial).status().unwrap().success());
    let message = TableFile::examine(&path, &columns(), &mark).unwrap_err().to_string();
    assert!(message.contains("no file"), "{message}");
}

#[test]
fn what_is_there_may_be_accepted() {
    let root = tempfile::tempdir().unwrap();
    let accepted = |path: &Path, mark: &TableMark| {
        let Resumed { mut file, warning } =
            TableFile::resume(path, &columns(), mark, Changed::Accept).unwrap();
        file.push(&[10.0, 0.5]).unwrap();
        TableFile::examine(path, &columns(), &file.mark()).unwrap();
        (fs::read_to_string(with_suffix(path)).unwrap(), warning.unwrap())
    };
    // A changed digit stays.
    let (path, mark) = table(root.path(), 4);
    change(&path, "1.0,0.5", "1.0,0.6");
    let (text, warning) = accepted(&path, &mark);
    assert_eq!(text, "t_s,\"a, b\"\n0.0,1.0\n1.0,0.6\n2.0,0.3333333333333333\n3.0,0.25\n10.0,0.5\n");
    assert!(warning.contains("line 3") && warning.contains("4 rows were kept"), "{warning}");
    // A removed row: none that came after the checkpoint moves up.
    let (path, mark) = table(root.path(), 3);
    change(&path, "1.0,0.5\n", "");
    let more = fs::read_to_string(with_suffix(&path)).unwrap() + "3.0,0.25\n4.0,0.2\n";
    fs::write(with_suffix(&path), more).unwrap();
    assert_eq!(accepted(&path, &mark).0, "t_s,\"a, b\"\n0.0,1.0\n2.0,0.3333333333333333\n10.0,0.5\n");
    // Cut in the middle of a row.
    let (path, mark) = table(root.path(), 3);
    fs::File::options().write(true).open(with_suffix(&path)).unwrap().set_len(25).unwrap();
    assert_eq!(accepted(&path, &mark).0, "t_s,\"a, b\"\n0.0,1.0\n10.0,0.5\n");
    // Gone.
    let (path, mark) = table(root.path(), 3);
    fs::remove_file(with_suffix(&path)).unwrap();
    let (text, warning) = accepted(&path, &mark);
    assert_eq!(text, "t_s,\"a, b\"\n10.0,0.5\n");
    assert!(warning.contains("was missing"), "{warning}");
    // Of another run.
    let (path, mark) = table(root.path(), 3);
    change(&path, "t_s", "x_m");
    let Err(error) = TableFile::resume(&path, &columns(), &mark, Changed::Accept) else { panic!("taken") };
    assert!(error.to_string().contains("columns are not those of this run"), "{error}");
}

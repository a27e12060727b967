//! A table that grows during a run.

use std::fs::{self, File};
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use super::super::error::OutputError;
use super::super::files::{fresh, with_suffix};
use super::mark::{Before, Difference, Marked, TableMark};

/// What to do about a table that is not as it was at the checkpoint.
const REMEDY: &str = "put it back as the run left it, add `--accept-changed-outputs` to continue with the rows that are \
                      there, which `summary.json` will say, or repeat the run by `run --force`";
/// Longest line that is read as a row \[bytes\].
const LONGEST_LINE: u64 = 1 << 20;

/// A CSV file that grows during a run, under a partial name until [`TableFile::finish`].
///
/// Numbers are the shortest decimals that read back to the same bits. Every row reaches the system at once, so that
/// a run can be watched. A digest of all rows is kept, so that a checkpoint knows what they were.
pub struct TableFile {
    path: PathBuf,
    partial: PathBuf,
    table: Marked<File>,
    columns: usize,
    row: Vec<u8>,
    before_last: Before,
}

/// What to do with outputs that are not as they were at the checkpoint from which a run continues.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Changed {
    /// Refuse to continue.
    #[default]
    Refuse,
    /// Continue with what is there, and say so.
    Accept,
}

/// A table of an earlier run, and a warning about it, if any.
pub struct Resumed {
    /// The table.
    pub file: TableFile,
    /// How it differs from what the run had written, where that was accepted.
    pub warning: Option<String>,
}

impl TableFile {
    /// Starts the file with its line of column names.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn create(path: &Path, columns: &[String]) -> Result<Self, OutputError> {
        let partial = with_suffix(path);
        let failed = |e| OutputError::file("write", &partial, e);
        let mut table = Marked::new(fresh(&partial).map_err(failed)?);
        header(columns).and_then(|header| table.write_all(&header)).map_err(failed)?;
        Ok(Self::of(path, partial.clone(), table, columns))
    }

    fn of(path: &Path, partial: PathBuf, table: Marked<File>, columns: &[String]) -> Self {
        let before_last = table.now();
        Self { path: path.into(), partial, table, columns: columns.len(), row: Vec::new(), before_last }
    }

    /// That the file of an earlier run, complete or not, holds what it held at `mark`. Nothing is changed.
    ///
    /// # Errors
    /// When there is no such file, rows are missing or were changed, or it has other columns.
    pub fn examine(path: &Path, columns: &[String], mark: &TableMark) -> Result<(), OutputError> {
        let Some(found) = EarlierTable::at(path)? else { return Err(missing(path)) };
        found.compare(columns, mark)?.map(drop).map_err(|difference| found.refusal(&difference, mark))
    }

    /// Continues the file of an earlier run, complete or not, from what it held at `mark`.
    ///
    /// # Errors
    /// When it cannot be written, has other columns, or is not as it was then and `changed` says to refuse that.
    pub fn resume(
        path: &Path,
        columns: &[String],
        mark: &TableMark,
        changed: Changed,
    ) -> Result<Resumed, OutputError> {
        let Some(found) = EarlierTable::at(path)? else {
            return match changed {
                Changed::Refuse => Err(missing(path)),
                Changed::Accept => {
                    let warning =
                        format!("`{}` was missing: it has no rows before the checkpoint", name(path));
                    Ok(Resumed { file: Self::create(path, columns)?, warning: Some(warning) })
                }
            };
        };
        let (at, warning) = match (found.compare(columns, mark)?, changed) {
            (Ok(at), _) => (Ok(at), None),
            (Err(difference), Changed::Refuse) => return Err(found.refusal(&difference, mark)),
            (Err(difference), Changed::Accept) => {
                let kept = found.sound_rows(columns, mark)?;
                let text = found.words(&difference, mark);
                let warning = format!("`{}` {text}; {} rows were kept as they are", name(path), kept.rows());
                (Err(kept), Some(warning))
            }
        };
        let partial = with_suffix(path);
        let failed = |e| OutputError::file("continue", &partial, e);
        if found.place != partial {
            fs::rename(&found.place, &partial).map_err(failed)?;
        }
        let file = File::options().write(true).open(&partial).map_err(failed)?;
        let mut table = match at {
            Ok(at) => Marked::resumed(file, at, mark),
            Err(kept) => kept.over(file),
        };
        table.to.set_len(table.length()).map_err(failed)?;
        table.to.seek(SeekFrom::End(0)).map_err(failed)?;
        Ok(Resumed { file: Self::of(path, partial.clone(), table, columns), warning })
    }

    /// What it holds now.
    pub fn mark(&self) -> TableMark {
        self.table.mark(&self.table.now())
    }

    /// What it held before the last row that was added.
    pub fn mark_before_last(&self) -> TableMark {
        self.table.mark(&self.before_last)
    }

    /// A second handle of the file, by which it can be brought to the disk elsewhere.
    ///
    /// # Errors
    /// When the system has no more handles.
    pub fn handle(&self) -> Result<File, OutputError> {
        self.table.to.try_clone().map_err(|e| OutputError::file("open", &self.partial, e))
    }

    /// Adds a row.
    ///
    /// # Errors
    /// When it cannot be written or has another length than the line of names.
    pub fn push(&mut self, row: &[f64]) -> Result<(), OutputError> {
        if row.len() != self.columns {
            let reason = format!("a row of {} values for {} columns", row.len(), self.columns);
            return Err(OutputError::content(&self.path, reason));
        }
        self.before_last = self.table.now();
        self.row.clear();
        for (column, value) in row.iter().enumerate() {
            let comma = if column == 0 { "" } else { "," };
            // Into memory, which takes everything.
            let _ = write!(self.row, "{comma}{value:?}");
        }
        self.row.push(b'\n');
        self.table.write_all(&self.row).map_err(|e| OutputError::file("write", &self.partial, e))?;
        self.table.row_ends(row.first().copied().unwrap_or(f64::NAN));
        Ok(())
    }

    /// Gives the file its final name.
    ///
    /// # Errors
    /// When it cannot be renamed.
    pub fn finish(self) -> Result<PathBuf, OutputError> {
        fs::rename(&self.partial, &self.path).map_err(|e| OutputError::file("complete", &self.path, e))?;
        Ok(self.path)
    }
}

/// The line of names.
fn header(columns: &[String]) -> io::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(columns).map_err(io::Error::other)?;
    writer.into_inner().map_err(|e| io::Error::other(e.to_string()))
}

fn name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

fn missing(path: &Path) -> OutputError {
    OutputError::content(path, format!("is missing, but was there at the checkpoint; {REMEDY}"))
}

/// The file of an earlier run.
struct EarlierTable {
    place: PathBuf,
}

impl EarlierTable {
    /// The file of `path`, complete or not; none where there is neither.
    fn at(path: &Path) -> Result<Option<Self>, OutputError> {
        for place in [with_suffix(path), path.to_path_buf()] {
            match fs::symlink_metadata(&place) {
                Ok(facts) if facts.is_file() => return Ok(Some(Self { place })),
                // What a link points to may be anybody's.
                Ok(_) => {
                    let reason = format!("is a link or no file, but was a file at the checkpoint; {REMEDY}");
                    return Err(OutputError::content(&place, reason));
                }
                Err(e) if e.kind() == io::ErrorKind::NotFound => {}
                Err(e) => return Err(OutputError::file("look at", &place, e)),
            }
        }
        Ok(None)
    }

    fn open(&self) -> Result<File, OutputError> {
        File::open(&self.place).map_err(|e| OutputError::file("read", &self.place, e))
    }

    fn compare(
        &self,
        columns: &[String],
        mark: &TableMark,
    ) -> Result<Result<Before, Difference>, OutputError> {
        let failed = |e| OutputError::file("read", &self.place, e);
        let compared = mark.compare(&mut self.open()?).map_err(failed)?;
        if compared.is_ok() {
            self.check_columns(columns)?;
        }
        Ok(compared)
    }

    /// The rows from the first on that are complete and not beyond `mark`.
    fn sound_rows(&self, columns: &[String], mark: &TableMark) -> Result<Marked<()>, OutputError> {
        let failed = |e| OutputError::file("read", &self.place, e);
        let names = self.check_columns(columns)?;
        let mut kept = Marked::new(());
        kept.take_in(&names);
        let mut file = BufReader::new(self.open()?);
        file.seek(SeekFrom::Start(kept.length())).map_err(failed)?;
        loop {
            let mut line = Vec::new();
            file.by_ref().take(LONGEST_LINE).read_until(b'\n', &mut line).map_err(failed)?;
            let Some((b'\n', row)) = line.split_last() else { return Ok(kept) };
            let mut values = row.split(|byte| *byte == b',');
            let first = values.next().and_then(|first| str::from_utf8(first).ok()?.parse().ok());
            match first {
                Some(first) if first <= mark.last() && values.count() + 1 == columns.len() => {
                    kept.take_in(&line);
                    kept.row_ends(first);
                }
                _ => return Ok(kept),
            }
        }
    }

    /// The line of names, which must be that of `columns`.
    fn check_columns(&self, columns: &[String]) -> Result<Vec<u8>, OutputError> {
        let failed = |e| OutputError::file("read", &self.place, e);
        let expected = header(columns).map_err(failed)?;
        let mut found = Vec::new();
        // A usize fits in 64 bits on every platform that Rust supports.
        self.open()?.take(expected.len() as u64).read_to_end(&mut found).map_err(failed)?;
        if found == expected {
            return Ok(found);
        }
        Err(OutputError::content(
            &self.place,
            "its columns are not those of this run; put it back as the run left it, or move it elsewhere and add \
             `--accept-changed-outputs` to start a new one",
        ))
    }

    fn words(&self, difference: &Difference, mark: &TableMark) -> String {
        match difference {
            Difference::Shorter(found) => {
                format!("has {found} bytes, but had {} at the checkpoint", mark.length())
            }
            Difference::Changed(first, last) if first == last => {
                format!("has another line {first} than the run wrote")
            }
            Difference::Changed(first, last) => {
                format!("has other lines than the run wrote, between line {first} and line {last}")
            }
        }
    }

    fn refusal(&self, difference: &Difference, mark: &TableMark) -> OutputError {
        OutputError::content(&self.place, format!("{}; {REMEDY}", self.words(difference, mark)))
    }
}

#[cfg(test)]
mod tests;

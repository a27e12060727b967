//! Tables of numbers as CSV: written row by row during a run, read back for the report.

use std::fs::{self, File};
use std::io::{self, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use super::directory::{OutputError, with_suffix};

/// A table of numbers in memory.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    columns: Vec<String>,
    /// Row after row.
    values: Vec<f64>,
}

impl Table {
    /// A table without rows.
    pub fn new(columns: Vec<String>) -> Self {
        Self { columns, values: Vec::new() }
    }

    /// Names of the columns.
    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.values.len().checked_div(self.columns.len()).unwrap_or(0)
    }

    /// Adds a row; surplus values are dropped and missing ones become NaN.
    pub fn push(&mut self, row: &[f64]) {
        let missing = self.columns.len().saturating_sub(row.len());
        self.values.extend(row.iter().take(self.columns.len()));
        self.values.extend(std::iter::repeat_n(f64::NAN, missing));
    }

    /// Values of the column at `index`; empty where there is none.
    pub fn column_at(&self, index: usize) -> Vec<f64> {
        self.values.chunks(self.columns.len().max(1)).filter_map(|row| row.get(index)).copied().collect()
    }

    /// Values of the column called `name`.
    pub fn column(&self, name: &str) -> Option<Vec<f64>> {
        self.columns.iter().position(|column| column == name).map(|index| self.column_at(index))
    }

    /// Reads a CSV file with one line of column names; a last line that was cut off is left out.
    ///
    /// # Errors
    /// When the file cannot be read or a value is no number.
    pub fn read(path: &Path) -> Result<Self, OutputError> {
        let file = File::open(path).map_err(|e| OutputError::file("read", path, e))?;
        Self::parse(file).map_err(|reason| OutputError::content(path, reason))
    }

    /// As [`Table::read`], from anything that gives bytes.
    ///
    /// # Errors
    /// When a value is no number, with its line and column.
    pub fn parse(csv: impl io::Read) -> Result<Self, String> {
        let mut reader = csv::ReaderBuilder::new().flexible(true).from_reader(csv);
        let columns: Vec<String> =
            reader.headers().map_err(|e| e.to_string())?.iter().map(String::from).collect();
        let mut table = Self::new(columns);
        for record in reader.records() {
            let record = record.map_err(|e| e.to_string())?;
            if record.len() != table.columns.len() {
                // Only a killed run leaves such a line, and only at the end.
                break;
            }
            for (value, column) in record.iter().zip(&table.columns) {
                let value: f64 = value.trim().parse().map_err(|_| {
                    let line = record.position().map_or(0, |p| p.line());
                    format!("line {line}, column `{column}`: `{value}` is no number")
                })?;
                table.values.push(value);
            }
        }
        Ok(table)
    }
}

/// A CSV file that grows during a run, under a partial name until [`TableFile::finish`].
///
/// Numbers are the shortest decimals that read back to the same bits. Every row reaches the system at once, so that
/// a run can be watched.
pub struct TableFile {
    path: PathBuf,
    partial: PathBuf,
    writer: csv::Writer<File>,
    columns: usize,
    before_last: u64,
}

impl TableFile {
    /// Starts the file with its line of column names.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn create(path: &Path, columns: &[String]) -> Result<Self, OutputError> {
        let partial = with_suffix(path);
        let file = File::create(&partial).map_err(|e| OutputError::file("write", &partial, e))?;
        let mut table = Self {
            path: path.to_path_buf(),
            writer: csv::Writer::from_writer(file),
            partial,
            columns: columns.len(),
            before_last: 0,
        };
        table.record(columns)?;
        Ok(table)
    }

    /// Goes on with the file of an earlier run, complete or not, from its first `length` bytes.
    ///
    /// # Errors
    /// When there is no such file, it is shorter, has other columns, or cannot be written.
    pub fn resume(path: &Path, columns: &[String], length: u64) -> Result<Self, OutputError> {
        let partial = with_suffix(path);
        if !partial.exists() {
            fs::rename(path, &partial).map_err(|e| OutputError::file("go on with", path, e))?;
        }
        let failed = |e| OutputError::file("go on with", &partial, e);
        let mut file = File::options().read(true).write(true).open(&partial).map_err(failed)?;
        let found = file.metadata().map_err(failed)?.len();
        if found < length {
            let reason =
                format!("has {found} bytes, but had {length} at the checkpoint; it was cut or replaced");
            return Err(OutputError::content(&partial, reason));
        }
        file.set_len(length).map_err(failed)?;
        let known = Self::read_columns(&file).map_err(failed)?;
        if known != columns {
            return Err(OutputError::content(&partial, "its columns are not those of this run"));
        }
        file.seek(SeekFrom::End(0)).map_err(failed)?;
        let writer = csv::Writer::from_writer(file);
        Ok(Self { path: path.to_path_buf(), writer, partial, columns: columns.len(), before_last: length })
    }

    fn read_columns(mut file: &File) -> io::Result<Vec<String>> {
        file.seek(SeekFrom::Start(0))?;
        let mut reader = csv::ReaderBuilder::new().flexible(true).from_reader(file);
        Ok(reader.headers().map_err(io::Error::other)?.iter().map(String::from).collect())
    }

    /// Bytes so far.
    ///
    /// # Errors
    /// When the system does not tell.
    pub fn length(&self) -> Result<u64, OutputError> {
        let metadata = self.writer.get_ref().metadata();
        metadata.map(|data| data.len()).map_err(|e| OutputError::file("look at", &self.partial, e))
    }

    /// Bytes before the last row that was added.
    pub fn length_before_last(&self) -> u64 {
        self.before_last
    }

    /// A second handle of the file, by which it can be brought to the disk elsewhere.
    ///
    /// # Errors
    /// When the system has no more handles.
    pub fn handle(&self) -> Result<File, OutputError> {
        self.writer.get_ref().try_clone().map_err(|e| OutputError::file("open", &self.partial, e))
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
        self.before_last = self.length()?;
        self.record(row.iter().map(|value| format!("{value:?}")))
    }

    fn record<I: IntoIterator<Item = T>, T: AsRef<[u8]>>(&mut self, fields: I) -> Result<(), OutputError> {
        let written = self.writer.write_record(fields).map_err(std::io::Error::other);
        written.and_then(|()| self.writer.flush()).map_err(|e| OutputError::file("write", &self.partial, e))
    }

    /// Gives the file its final name.
    ///
    /// # Errors
    /// When it cannot be renamed.
    pub fn finish(mut self) -> Result<PathBuf, OutputError> {
        let flushed = self.writer.flush().and_then(|()| fs::rename(&self.partial, &self.path));
        flushed.map_err(|e| OutputError::file("complete", &self.path, e))?;
        Ok(self.path)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_back_to_the_same_bits() {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("t.csv");
        let columns = vec!["t_s".to_string(), "a, b".to_string(), "c".to_string()];
        let mut file = TableFile::create(&path, &columns).unwrap();
        let rows = [
            [0.1 + 0.2, 1e-5, -0.0],
            [f64::MIN_POSITIVE / 3.0, f64::MAX, 1.0 / 3.0],
            [f64::INFINITY, f64::NEG_INFINITY, 123_456_789.0],
        ];
        for row in &rows {
            file.push(row).unwrap();
        }
        assert!(file.push(&[1.0]).is_err());
        assert!(!path.exists(), "not complete yet");
        assert_eq!(file.finish().unwrap(), path);
        assert_eq!(fs::read_dir(root.path()).unwrap().count(), 1);
        let table = Table::read(&path).unwrap();
        assert_eq!(table.columns(), columns);
        assert_eq!(table.rows(), 3);
        for (k, row) in rows.iter().enumerate() {
            for (c, value) in row.iter().enumerate() {
                assert_eq!(table.column_at(c)[k].to_bits(), value.to_bits());
            }
        }
    }

    #[test]
    fn gaps_are_nan_and_a_cut_line_is_left_out() {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("t.csv");
        fs::write(&path, "t_s,a\n0.0,NaN\n1.0,2.0\n2.0").unwrap();
        let table = Table::read(&path).unwrap();
        assert_eq!(table.rows(), 2);
        assert!(table.column("a").unwrap()[0].is_nan());
        fs::write(&path, "t_s,a\n0.0,high\n").unwrap();
        let message = Table::read(&path).unwrap_err().to_string();
        assert!(
            message.contains("line 2") && message.contains("`a`") && message.contains("high"),
            "{message}"
        );
    }
}

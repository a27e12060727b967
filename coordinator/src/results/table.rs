//! Tables of numbers as CSV: written row by row during a run by [`TableFile`], read back for the report.

mod file;
mod mark;

use std::fs::File;
use std::io;
use std::path::Path;

use super::error::OutputError;

pub use file::{Changed, Resumed, TableFile};
pub use mark::TableMark;

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

#[cfg(test)]
mod tests {
    use std::fs;

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

//! Verdicts by probe, for families with more key figures than anyone reads.

use super::verdict::Verdict;

/// The key figures of one probe under refinement.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// Name of the probe, or of a column that belongs to none.
    pub name: String,
    /// How many are converged.
    pub converged: usize,
    /// Estimated errors over the values, ascending; infinite where one is unknown or the value is zero.
    pub errors: Vec<f64>,
}

impl Group {
    /// Key figures.
    pub fn count(&self) -> usize {
        self.errors.len()
    }

    /// The error that half of the key figures do not exceed; the upper of two in the middle. `None` when it is unknown.
    pub fn median_error(&self) -> Option<f64> {
        self.errors.get(self.count() / 2).copied().filter(|error| error.is_finite())
    }
}

/// Joins `verdicts` by the probe whose name their columns begin with, in the order of `probes`.
pub fn groups(verdicts: &[Verdict], probes: &[&str]) -> Vec<Group> {
    let belongs = |column: &str, probe: &str| {
        column.strip_prefix(probe).is_some_and(|rest| rest.is_empty() || rest.starts_with('_'))
    };
    let mut found: Vec<(usize, Group)> = Vec::new();
    for verdict in verdicts {
        // Of `body` and `body_load` the longer one.
        let owner = (0..probes.len())
            .filter(|k| belongs(&verdict.column, probes[*k]))
            .max_by_key(|k| probes[*k].len());
        let name = owner.map_or(verdict.column.as_str(), |k| probes[k]);
        let at = found.iter().position(|(_, group)| group.name == name).unwrap_or_else(|| {
            let group = Group { name: name.to_owned(), converged: 0, errors: Vec::new() };
            found.push((owner.unwrap_or(probes.len()), group));
            found.len() - 1
        });
        let group = &mut found[at].1;
        group.converged += usize::from(verdict.converged);
        group.errors.push(verdict.error_over_value().unwrap_or(f64::INFINITY));
    }
    found.sort_by_key(|(place, _)| *place);
    let groups = found.into_iter().map(|(_, group)| group);
    let sorted = |mut group: Group| {
        group.errors.sort_by(f64::total_cmp);
        group
    };
    groups.map(sorted).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn verdict(column: &str, error: Option<f64>, finest: f64) -> Verdict {
        let converged = error.is_some_and(|error| error <= 0.05 * finest.abs());
        Verdict {
            figure: format!("last {column}"),
            column: column.to_owned(),
            over_spacing: vec![Some(finest)],
            finest: Some(finest),
            order: None,
            error,
            converged,
            reason: String::new(),
        }
    }

    #[test]
    fn columns_go_to_the_probe_with_the_longest_name() {
        let verdicts = [
            verdict("other_m", Some(0.0), 1.0),
            verdict("body_load_x_n", Some(0.1), 1.0),
            verdict("body_x_m", Some(0.01), 1.0),
            verdict("body_y_m", None, 1.0),
            verdict("bodyguard_m", Some(0.1), 0.0),
            verdict("body_angle_rad", Some(0.5), 2.0),
        ];
        let groups = groups(&verdicts, &["body", "body_load"]);
        let names: Vec<(&str, usize, usize)> =
            groups.iter().map(|g| (g.name.as_str(), g.converged, g.count())).collect();
        assert_eq!(names, [("body", 1, 3), ("body_load", 0, 1), ("other_m", 1, 1), ("bodyguard_m", 0, 1)]);
        assert_eq!(groups[0].median_error(), Some(0.25));
        assert_eq!(groups[3].median_error(), None, "no share of a value of zero");
    }
}

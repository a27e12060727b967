//! Which columns of `probes.csv` belong into one picture.

/// A kind of quantity: column suffix without component, words, components and unit.
struct Family {
    /// Start of the column suffix, such as `velocity`.
    stem: &'static str,
    /// End of the column suffix, such as `m_s`; empty for a number without unit.
    unit_key: &'static str,
    /// Unit as shown.
    unit: &'static str,
}

const fn family(stem: &'static str, unit_key: &'static str, unit: &'static str) -> Family {
    Family { stem, unit_key, unit }
}

/// All quantities that probes report, longer stems before shorter ones that end them.
const FAMILIES: [Family; 37] = [
    family("strain_energy_density", "j_per_m3", "J/m³"),
    family("contact_bodies", "n_per_m", "N/m"),
    family("contact_walls", "n_per_m", "N/m"),
    family("angular_momentum", "kg_m_per_s", "kg m/s"),
    family("angular_velocity", "rad_s", "rad/s"),
    family("second_moment", "m2", "m²"),
    family("displacement", "m", "m"),
    family("energy", "j_per_m", "J/m"),
    family("momentum", "kg_per_s", "kg/s"),
    family("flow_rate", "m2_s", "m²/s"),
    family("pressure", "pa", "Pa"),
    family("velocity", "m_s", "m/s"),
    family("stress", "pa", "Pa"),
    family("principal", "pa", "Pa"),
    family("von_mises", "pa", "Pa"),
    family("immersed", "count", "particles"),
    family("impulse", "n_s_per_m", "N s/m"),
    family("deepest", "m", "m"),
    family("centre", "m", "m"),
    family("front", "m", "m"),
    family("force", "n_per_m", "N/m"),
    family("level", "m", "m"),
    family("angle", "rad", "rad"),
    family("mass", "kg_per_m", "kg/m"),
    family("gap", "m", "m"),
    family("contact_bodies", "n", "N"),
    family("contact_walls", "n", "N"),
    family("angular_momentum", "kg_m2_per_s", "kg m²/s"),
    family("energy", "j", "J"),
    family("momentum", "kg_m_per_s", "kg m/s"),
    family("flow_rate", "m3_s", "m³/s"),
    family("impulse", "n_s", "N s"),
    family("force", "n", "N"),
    family("torque", "n_m", "N m"),
    family("torque", "n", "N"),
    family("quaternion", "", "-"),
    family("mass", "kg", "kg"),
];

/// Kinds of energy, which stand before the stem.
const ENERGIES: [&str; 4] = ["kinetic", "potential", "compression", "strain"];
/// Components, which stand after the stem; the empty one is a scalar.
const COMPONENTS: [&str; 15] =
    ["", "x", "y", "z", "w", "xx", "yy", "zz", "xy", "yz", "xz", "body", "wall", "largest", "smallest"];

/// What a column of `probes.csv` means.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Meaning {
    /// Name of the probe; the whole column where the quantity is not known.
    pub probe: String,
    /// Quantity in words, such as `angular momentum`.
    pub quantity: String,
    /// Component, such as `x` or `kinetic`; empty for a scalar.
    pub component: String,
    /// SI unit as shown.
    pub unit: String,
}

/// Splits a column name `<probe>_<quantity>_<unit>`; a probe's name may hold underscores.
pub fn meaning(column: &str) -> Meaning {
    for family in &FAMILIES {
        let stem = family.stem.replace('_', " ");
        let found = |probe: &str, component: &str| Meaning {
            probe: probe.to_string(),
            quantity: stem.clone(),
            component: component.to_string(),
            unit: family.unit.to_string(),
        };
        for component in COMPONENTS {
            let separator = if component.is_empty() { "" } else { "_" };
            let unit_separator = if family.unit_key.is_empty() { "" } else { "_" };
            let suffix = format!("_{}{separator}{component}{unit_separator}{}", family.stem, family.unit_key);
            let Some(before) = column.strip_suffix(&suffix) else { continue };
            if family.stem != "energy" {
                return found(before, component);
            }
            for kind in ENERGIES {
                if let Some(probe) = before.strip_suffix(kind).and_then(|rest| rest.strip_suffix('_')) {
                    return found(probe, kind);
                }
            }
        }
    }
    Meaning {
        probe: column.to_string(),
        quantity: String::new(),
        component: String::new(),
        unit: String::new(),
    }
}

/// Columns that share one picture: same probe, quantity and unit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Group {
    /// What all of them mean; the component is that of the first.
    pub meaning: Meaning,
    /// Component and index of each column.
    pub columns: Vec<(String, usize)>,
}

/// Groups all columns but the first, which is time, in the order of their first column.
pub fn groups(columns: &[String]) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    for (index, column) in columns.iter().enumerate().skip(1) {
        let meaning = meaning(column);
        let entry = (meaning.component.clone(), index);
        let same = |group: &&mut Group| {
            group.meaning.probe == meaning.probe && group.meaning.quantity == meaning.quantity
        };
        match groups.iter_mut().find(same) {
            Some(group) => group.columns.push(entry),
            None => groups.push(Group { meaning, columns: vec![entry] }),
        }
    }
    groups
}

#[cfg(test)]
mod tests {
    use sph::setup::{FluidProbeKind, ProbeKind, SolidProbeKind};
    use sph::space::Spatial;

    use super::*;

    #[test]
    fn every_column_of_every_kind_of_probe_is_understood() {
        let plane = <FluidProbeKind>::SPECIFICATIONS.iter().chain(<SolidProbeKind>::SPECIFICATIONS);
        let spatial =
            <FluidProbeKind<Spatial>>::SPECIFICATIONS.iter().chain(<SolidProbeKind<Spatial>>::SPECIFICATIONS);
        let suffixes = plane.chain(spatial).flat_map(|spec| spec.columns);
        for suffix in suffixes {
            let meaning = meaning(&format!("left_gauge_2_{suffix}"));
            assert_eq!(meaning.probe, "left_gauge_2", "{suffix}");
            assert!(!meaning.unit.is_empty(), "{suffix}");
        }
    }

    #[test]
    fn components_share_a_picture_and_other_quantities_do_not() {
        let columns: Vec<String> = [
            "t_s",
            "p_pressure_pa",
            "p_velocity_x_m_s",
            "p_velocity_y_m_s",
            "q_kinetic_energy_j_per_m",
            "q_strain_energy_j_per_m",
            "odd",
        ]
        .map(String::from)
        .into();
        let groups = groups(&columns);
        let sizes: Vec<usize> = groups.iter().map(|group| group.columns.len()).collect();
        assert_eq!(sizes, [1, 2, 2, 1]);
        assert_eq!(groups[1].columns, [("x".into(), 2), ("y".into(), 3)]);
        assert_eq!(groups[2].columns[1].0, "strain");
        assert_eq!(groups[3].meaning.probe, "odd");
    }
}

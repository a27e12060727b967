//! Units of keys, as their ends name them.

/// Ends of keys, the longer before those that they end in, and the units.
const ENDS: [(&str, &str); 20] = [
    ("_kg_m3", "kg/m³"),
    ("_rad_s", "rad/s"),
    ("_m3_s", "m³/s"),
    ("_m2_s", "m²/s"),
    ("_m_s2", "m/s²"),
    ("_m_s", "m/s"),
    ("_pa_s", "Pa s"),
    ("_per_s", "1/s"),
    ("_n_m", "N m"),
    ("_wall_s", "s"),
    ("_rad", "rad"),
    ("_pa", "Pa"),
    ("_kg", "kg"),
    ("_n", "N"),
    ("_m", "m"),
    ("_s", "s"),
    ("_every_steps", "steps"),
    ("every_steps", "steps"),
    ("_spacings", "Δx of the fluid"),
    ("layers", "rows"),
];

/// The unit of what `key` holds; `-` without one.
pub fn unit(key: &str) -> &'static str {
    ENDS.iter().find(|(end, _)| key.ends_with(end)).map_or("-", |(_, unit)| unit)
}

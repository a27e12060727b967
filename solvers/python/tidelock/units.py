"""Units of columns, which are the ends of their names."""

from __future__ import annotations

# Longest first, so that `n_per_m` is not taken for `m`.
SUFFIXES = {
    "kg_m2_per_s": "kg m²/s",
    "kg_m_per_s": "kg m/s",
    "n_s_per_m": "N s/m",
    "j_per_m3": "J/m³",
    "kg_per_m": "kg/m",
    "kg_per_s": "kg/s",
    "n_m_s": "N m s",
    "w_per_m": "W/m",
    "n_per_m": "N/m",
    "j_per_m": "J/m",
    "kg_m3": "kg/m³",
    "rad_s": "rad/s",
    "m2_s": "m²/s",
    "m3_s": "m³/s",
    "n_s": "N s",
    "n_m": "N m",
    "m_s": "m/s",
    "rad": "rad",
    "kg": "kg",
    "pa": "Pa",
    "m2": "m²",
    "m5": "m⁵",
    "m": "m",
    "n": "N",
    "j": "J",
    "w": "W",
    "s": "s",
}


def split(column: str) -> tuple[str, str]:
    """Name and unit of a column; without a unit it is a pure number.

    >>> split("tip_displacement_x_m"), split("load_force_x_n_per_m"), split("tip_velocity_x_m_s")
    (('tip_displacement_x', 'm'), ('load_force_x', 'N/m'), ('tip_velocity_x', 'm/s'))
    >>> split("immersed_count")
    ('immersed_count', '')
    """
    for suffix, unit in SUFFIXES.items():
        if column.endswith("_" + suffix):
            return column[: -len(suffix) - 1], unit
    return column, ""

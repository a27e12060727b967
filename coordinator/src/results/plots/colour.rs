//! Colours: perceptually uniform maps for fields, and colours that stay apart for lines.

/// Red, green, blue.
pub type Rgb = [u8; 3];

/// Walls in particle pictures.
pub const WALL: Rgb = [176, 176, 176];
/// Solids where a picture shows the fluid's field: a hue that no map here contains.
pub const SOLID: Rgb = [214, 112, 48];
/// Water where a picture shows the solids' field: neither red nor blue.
pub const WATER: Rgb = [203, 231, 222];
/// Values that are no number.
pub const INVALID: Rgb = [255, 0, 200];

/// Line colours after Okabe & Ito (2008), distinct with all common kinds of colour vision; the blue is lighter than
/// theirs, to be seen on dark pages too.
pub const LINES: [Rgb; 7] = [
    [38, 132, 200],
    [213, 94, 0],
    [0, 158, 115],
    [204, 121, 167],
    [230, 159, 0],
    [86, 180, 233],
    [128, 128, 128],
];

/// A map from [0, 1] to colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColourMap {
    /// Viridis (Smith & van der Walt 2015): lightness grows with the value.
    Viridis,
    /// Cool-warm (Moreland 2009): blue below the middle, red above, neutral at it.
    CoolWarm,
}

/// Viridis at equal distances.
const VIRIDIS: [Rgb; 17] = [
    [68, 1, 84],
    [72, 24, 106],
    [71, 45, 123],
    [66, 64, 134],
    [59, 82, 139],
    [51, 99, 141],
    [44, 114, 142],
    [38, 130, 142],
    [33, 145, 140],
    [31, 160, 136],
    [40, 174, 128],
    [63, 188, 115],
    [94, 201, 98],
    [132, 212, 75],
    [173, 220, 48],
    [216, 226, 25],
    [253, 231, 37],
];

/// Cool-warm at equal distances.
const COOL_WARM: [Rgb; 17] = [
    [59, 76, 192],
    [78, 104, 216],
    [98, 130, 234],
    [119, 154, 247],
    [141, 176, 254],
    [163, 194, 254],
    [185, 208, 249],
    [204, 217, 237],
    [221, 220, 220],
    [236, 211, 197],
    [245, 196, 172],
    [247, 176, 147],
    [244, 152, 122],
    [235, 125, 98],
    [221, 95, 75],
    [202, 59, 55],
    [180, 4, 38],
];

impl ColourMap {
    /// Colour at `fraction`, clamped to [0, 1]; [`INVALID`] when it is no number.
    pub fn at(self, fraction: f64) -> Rgb {
        if fraction.is_nan() {
            return INVALID;
        }
        let stops = match self {
            ColourMap::Viridis => &VIRIDIS,
            ColourMap::CoolWarm => &COOL_WARM,
        };
        let x = fraction.clamp(0.0, 1.0) * (stops.len() - 1) as f64;
        // In range by the clamp.
        let k = (x as usize).min(stops.len() - 2);
        let weight = x - k as f64;
        std::array::from_fn(|c| {
            let (a, b) = (f64::from(stops[k][c]), f64::from(stops[k + 1][c]));
            (a + weight * (b - a)).round() as u8
        })
    }
}

/// A range of values with its colours.
#[derive(Clone, Debug, PartialEq)]
pub struct ColourScale {
    /// Map.
    pub map: ColourMap,
    /// Value of the first colour.
    pub lower: f64,
    /// Value of the last colour.
    pub upper: f64,
    /// Quantity shown, without unit.
    pub quantity: String,
    /// SI unit.
    pub unit: String,
}

impl ColourScale {
    /// Colour of `value`.
    pub fn colour(&self, value: f64) -> Rgb {
        self.map.at((value - self.lower) / (self.upper - self.lower))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Relative luminance of sRGB without gamma: enough to order colours.
    fn lightness(rgb: Rgb) -> f64 {
        0.2126 * f64::from(rgb[0]) + 0.7152 * f64::from(rgb[1]) + 0.0722 * f64::from(rgb[2])
    }

    #[test]
    fn viridis_only_grows_lighter_and_clamps() {
        let map = ColourMap::Viridis;
        let steps: Vec<f64> = (0..=100).map(|k| lightness(map.at(f64::from(k) / 100.0))).collect();
        assert!(steps.windows(2).all(|pair| pair[1] > pair[0]));
        assert_eq!(map.at(-3.0), VIRIDIS[0]);
        assert_eq!(map.at(1.0), VIRIDIS[16]);
        assert_eq!(map.at(f64::INFINITY), VIRIDIS[16]);
        assert_eq!(map.at(f64::NAN), INVALID);
    }

    #[test]
    fn cool_warm_is_neutral_at_zero_and_blue_below() {
        let scale = ColourScale {
            map: ColourMap::CoolWarm,
            lower: -2.0,
            upper: 2.0,
            quantity: "stress".into(),
            unit: "Pa".into(),
        };
        let [r, g, b] = scale.colour(0.0);
        assert!(r.abs_diff(g) < 3 && g.abs_diff(b) < 3);
        let ([r, _, b], [r2, _, b2]) = (scale.colour(-1.9), scale.colour(1.9));
        assert!(b > r && r2 > b2);
    }
}

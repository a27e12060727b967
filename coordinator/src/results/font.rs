//! The one font of all pictures, carried inside the executable: pictures look alike on every machine.

use plotters::style::{FontStyle, register_font};

/// Family under which the font is known to plotters.
pub const FAMILY: &str = "sans-serif";

/// Subset of DejaVu Sans; licence in `assets/DejaVuSans-subset.LICENSE.txt`.
static BYTES: &[u8] = include_bytes!("../../assets/DejaVuSans-subset.ttf");

/// Makes the font known to plotters as [`FAMILY`]; cheap, and harmless when repeated.
pub fn register() {
    let readable = register_font(FAMILY, FontStyle::Normal, BYTES).is_ok();
    // The bytes are part of the executable: only a broken build can fail here.
    debug_assert!(readable, "the embedded font is not readable");
}

#[cfg(test)]
mod tests {
    use plotters::style::{IntoFont, TextStyle};

    use super::*;

    #[test]
    fn text_can_be_measured_after_registration() {
        register();
        register();
        let style = TextStyle::from((FAMILY, 20).into_font());
        let width = |text: &str| style.font.layout_box(text).map(|(_, (x, _))| x).unwrap_or_default();
        assert!(width("pressure") > 50, "eight letters at 20 px take more than 50 px");
        assert!(width("iiii") < width("MMMM"), "the font is proportional");
    }

    #[test]
    fn signs_used_in_labels_are_in_the_font() {
        register();
        let style = TextStyle::from((FAMILY, 40).into_font());
        // A missing sign falls back to the box of an unknown one: all of these differ from it in ink or advance.
        let ink = |text: &str| {
            let mut pixels = Vec::new();
            let drawn = style.font.draw(text, (0, 0), |x, y, v| {
                if v > 0.5 {
                    pixels.push((x, y));
                }
                Ok::<(), ()>(())
            });
            assert!(drawn.is_ok());
            pixels
        };
        let unknown = ink("\u{4e00}");
        for sign in ["σ", "ρ", "²", "³", "₂", "−", "·", "×", "Σ", "Δ", "°", "⁻", "≤"] {
            assert_ne!(ink(sign), unknown, "{sign}");
            assert!(!ink(sign).is_empty(), "{sign}");
        }
    }
}

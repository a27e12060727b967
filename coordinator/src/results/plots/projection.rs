//! What pictures show of a scene in space: views from outside and cuts.

use sph::space::AXIS_NAMES;

/// A place \[m\]; z is zero in the plane.
pub type Place = [f64; 3];

/// Thickness of a cut in particle spacings: rows that leave their place a little stay in it.
pub const SLICE: f64 = 1.5;

/// How places become points of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// Whether the scene has a third axis.
    pub in_space: bool,
    /// Axis that points to the right.
    pub right: usize,
    /// Axis that points upward in the picture.
    pub upward: usize,
    /// The slice of matter that is shown along the axis of view \[m\]; `None` for all of it, seen from outside.
    pub slice: Option<[f64; 2]>,
}

impl Projection {
    /// The plane as it is.
    pub const PLANE: Self = Self { in_space: false, right: 0, upward: 1, slice: None };

    /// Whether the picture shows matter from outside: the plane and a cut show it as it is.
    pub fn is_from_outside(&self) -> bool {
        self.in_space && self.slice.is_none()
    }

    /// Axis along which one looks.
    pub fn depth_axis(&self) -> usize {
        3 - self.right - self.upward
    }

    /// Where `place` stands in the picture \[m\].
    pub fn point(&self, place: &Place) -> [f64; 2] {
        [place[self.right], place[self.upward]]
    }

    /// How near `place` is to the viewer, larger for nearer \[m\].
    pub fn nearness(&self, place: &Place) -> f64 {
        let axis = self.depth_axis();
        // Right, up and toward the viewer are right-handed.
        if (self.right + 1) % 3 == self.upward { place[axis] } else { -place[axis] }
    }

    /// Whether `place` is shown.
    pub fn shows(&self, place: &Place) -> bool {
        let depth = place[self.depth_axis()];
        self.slice.is_none_or(|[from, to]| (from..=to).contains(&depth))
    }

    /// The view in words, such as `cut at z = 0.1 m`; empty in the plane.
    pub fn title(&self, up: usize) -> String {
        let axis = AXIS_NAMES[self.depth_axis()];
        match self.slice {
            Some([from, to]) => format!("cut at {axis} = {:.4} m", 0.5 * (from + to)),
            None if self.depth_axis() == up => "from above".to_owned(),
            None => format!("seen along {axis}"),
        }
    }
}

/// The views of a scene in space whose matter lies between two corners \[m\] and in which `up` points against gravity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Views {
    /// From the side that shows most.
    pub side: Projection,
    /// From above.
    pub above: Projection,
    /// A cut across the middle, parallel to the view from the side.
    pub cut: Projection,
}

impl Views {
    /// Those of matter from `lower` to `upper` \[m\]; the cut goes through `middle` \[m\] and is `thickness` \[m\] thick.
    pub fn of(up: usize, lower: Place, upper: Place, middle: Place, thickness: f64) -> Self {
        let [a, b] = [(up + 1) % 3, (up + 2) % 3];
        // The longer horizontal side to the right; x where both are of one length.
        let [a_length, b_length] = [upper[a] - lower[a], upper[b] - lower[b]];
        let level = (a_length - b_length).abs() <= 1e-9 * a_length.abs();
        let right = if (level && a < b) || (!level && a_length > b_length) { a } else { b };
        let side = Projection { in_space: true, right, upward: up, slice: None };
        let at = middle[side.depth_axis()];
        let slice = Some([at - 0.5 * thickness, at + 0.5 * thickness]);
        let above = Projection { in_space: true, right: a, upward: b, slice: None };
        Self { side, above, cut: Projection { slice, ..side } }
    }
}

/// The axis along which `gravity` \[m/s²\] pulls most; y where it does not.
pub fn up_axis(gravity: &[f64]) -> usize {
    let strongest = gravity.iter().map(|g| g.abs()).fold(0.0, f64::max);
    gravity.iter().position(|g| strongest > 0.0 && g.abs() == strongest).unwrap_or(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_are_right_handed_and_show_the_nearer_particle() {
        let views = Views::of(2, [0.0; 3], [3.0, 1.0, 1.0], [1.5, 0.5, 0.5], 0.1);
        // x to the right and z upward: the viewer stands at negative y.
        assert_eq!((views.side.right, views.side.upward), (0, 2));
        assert!(views.side.nearness(&[0.0, -1.0, 0.0]) > views.side.nearness(&[0.0, 1.0, 0.0]));
        assert_eq!((views.above.right, views.above.upward), (0, 1));
        assert!(views.above.nearness(&[0.0, 0.0, 1.0]) > views.above.nearness(&[0.0, 0.0, 0.0]));
        assert_eq!(views.cut.title(2), "cut at y = 0.5000 m");
        assert!(views.cut.shows(&[9.0, 0.54, 9.0]) && !views.cut.shows(&[9.0, 0.56, 9.0]));
        // Up along y, longest along z: z cannot point to the right unless one looks along x.
        let views = Views::of(1, [0.0; 3], [1.0, 1.0, 3.0], [0.5; 3], 0.1);
        assert_eq!((views.side.right, views.side.depth_axis()), (2, 0));
        assert_eq!(views.above.title(1), "from above");
        assert_eq!(views.side.title(1), "seen along x");
    }

    #[test]
    fn up_is_against_gravity() {
        assert_eq!(up_axis(&[0.0, -9.81, 0.0]), 1);
        assert_eq!(up_axis(&[0.0, 0.0, -9.81]), 2);
        assert_eq!(up_axis(&[0.0; 3]), 1);
    }
}

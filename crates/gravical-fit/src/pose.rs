//! What an estimator knows of a placement.

use gravical_core::matrix3::{cross, dot, norm};

/// A face: one axis of the case points up (`+`, it reads +g) or down (`-`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Face {
    /// 0, 1, 2 for x, y, z.
    pub axis: usize,
    /// True if the axis points up.
    pub up: bool,
}

impl Face {
    /// All six: +x −x +y −y +z −z.
    pub fn all() -> [Face; 6] {
        std::array::from_fn(|i| Face {
            axis: i / 2,
            up: i % 2 == 0,
        })
    }

    /// `+x`, `-z` ….
    pub fn name(self) -> String {
        let sign = if self.up { '+' } else { '-' };
        format!("{sign}{}", ['x', 'y', 'z'][self.axis])
    }

    /// Its number in [`Face::all`].
    pub fn index(self) -> usize {
        2 * self.axis + usize::from(!self.up)
    }

    /// Unit vector of the specific force at rest.
    pub fn direction(self) -> [f64; 3] {
        let mut direction = [0.0; 3];
        direction[self.axis] = if self.up { 1.0 } else { -1.0 };
        direction
    }

    /// The opposite face.
    pub fn opposite(self) -> Face {
        Face {
            axis: self.axis,
            up: !self.up,
        }
    }

    /// The face nearest to a vector, and the angle between them in degrees.
    pub fn nearest(vector: [f64; 3]) -> (Face, f64) {
        let axis = nalgebra::Vector3::from(vector).iamax();
        let face = Face {
            axis,
            up: vector[axis] >= 0.0,
        };
        (face, angle_deg(vector, face.direction()))
    }
}

/// Angle between two vectors in degrees, accurate for small angles; 90 for a vector without length.
pub fn angle_deg(a: [f64; 3], b: [f64; 3]) -> f64 {
    let (sine, cosine) = (norm(&cross(&a, &b)), dot(&a, &b));
    if sine == 0.0 && cosine == 0.0 {
        return 90.0;
    }
    sine.atan2(cosine).to_degrees()
}

/// What is known of the direction of a pose. Faces are axes of the case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Hint {
    /// Nothing: it may lie on the face that it is nearest to.
    #[default]
    Open,
    /// A name or a label says so.
    Named(Face),
    /// The user says so.
    Face(Face),
    /// The user says that it lies on no face.
    Free,
}

/// A mean reading at rest.
#[derive(Debug, Clone, PartialEq)]
pub struct Pose {
    /// Mean of the channels, input unit.
    pub mean: [f64; 3],
    /// Standard deviation of this mean, input unit, above 0.
    pub sd: [f64; 3],
    /// Mean temperature, °C.
    pub temperature_c: Option<f64>,
    /// What is known of its direction.
    pub hint: Hint,
}

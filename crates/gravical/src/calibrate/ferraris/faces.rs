//! Placements sorted into the six faces, repeats pooled.

use gravical_core::six_position::SixPositionMeans;

use crate::poses::face::{Face, angle_deg};
use crate::poses::{MAX_FACE_ANGLE_DEG, Pose};
use crate::recording::Recording;
use crate::{Error, Result};

/// A repeat of a face that points this far from the best one is an oblique
/// pose, degrees.
const REPEAT_WITHIN_DEG: f64 = 5.0;

/// What lies on each face, in the order of [`Face::all`].
#[derive(Debug, Clone)]
pub struct Faces {
    /// Placements, by index.
    pub(in crate::calibrate) of_face: [Vec<usize>; 6],
    pub(super) means: [[f64; 3]; 6],
    pub(super) standard_errors: Option<[[f64; 3]; 6]>,
}

/// Means in the order of [`Face::all`] as the closed form takes them.
pub(in crate::calibrate) fn six_positions(means: &[[f64; 3]; 6]) -> SixPositionMeans<f64> {
    SixPositionMeans {
        plus: std::array::from_fn(|axis| means[2 * axis]),
        minus: std::array::from_fn(|axis| means[2 * axis + 1]),
    }
}

impl Faces {
    /// The face for which placement `index` is used; none when it is oblique.
    #[must_use]
    pub fn face_of(&self, index: usize) -> Option<Face> {
        Face::all()
            .into_iter()
            .find(|f| self.of_face[f.index()].contains(&index))
    }
}

/// Sorts placements into the six faces. Repeats of a face are pooled, weighted
/// by their rows.
///
/// # Errors
///
/// `missing-face` with the faces that are there, or `same-face-twice` when there
/// are six placements and one face takes two of them.
pub fn sort_into_faces(placements: &[Pose], recordings: &[Recording]) -> Result<Faces> {
    let mut of_face: [Vec<usize>; 6] = Default::default();
    for face in Face::all() {
        let mut there: Vec<usize> = (0..placements.len())
            .filter(|&i| {
                placements[i].face == Some(face) && placements[i].mean.iter().all(|v| v.is_finite())
            })
            .collect();
        let best = there
            .iter()
            .copied()
            .min_by(|&a, &b| placements[a].angle_deg.total_cmp(&placements[b].angle_deg));
        if let Some(best) = best {
            let mean = placements[best].mean;
            there.retain(|&i| angle_deg(placements[i].mean, mean) <= REPEAT_WITHIN_DEG);
        }
        of_face[face.index()] = there;
    }
    if of_face.iter().any(Vec::is_empty) {
        return Err(incomplete(placements, &of_face, recordings));
    }
    let mut means = [[0.0; 3]; 6];
    let mut variances = Some([[0.0; 3]; 6]);
    for (face, indices) in of_face.iter().enumerate() {
        let rows: f64 = indices.iter().map(|&i| placements[i].count as f64).sum();
        for placement in indices.iter().map(|&i| &placements[i]) {
            let weight = placement.count as f64 / rows;
            variances = variances.filter(|_| placement.standard_error.is_some());
            for axis in 0..3 {
                means[face][axis] += weight * placement.mean[axis];
                if let (Some(variances), Some(error)) = (&mut variances, placement.standard_error) {
                    variances[face][axis] += (weight * error[axis]).powi(2);
                }
            }
        }
    }
    Ok(Faces {
        means,
        standard_errors: variances.map(|faces| faces.map(|face| face.map(f64::sqrt))),
        of_face,
    })
}

fn incomplete(placements: &[Pose], of_face: &[Vec<usize>; 6], recordings: &[Recording]) -> Error {
    let missing: Vec<String> = Face::all()
        .into_iter()
        .filter(|f| of_face[f.index()].is_empty())
        .map(Face::name)
        .collect();
    let oblique: Vec<&Pose> = placements.iter().filter(|p| p.face.is_none()).collect();
    let twice = Face::all()
        .into_iter()
        .find(|f| of_face[f.index()].len() > 1)
        .filter(|_| placements.len() == 6 && oblique.is_empty());
    let next = missing
        .iter()
        .map(|face| {
            let (sign, axis) = face.split_at(1);
            format!("{axis} {}", if sign == "+" { "up" } else { "down" })
        })
        .collect::<Vec<_>>()
        .join(", ");
    let error = if let Some(face) = twice {
        let sources: Vec<&str> = of_face[face.index()]
            .iter()
            .map(|&i| match recordings {
                [_] => placements[i].label.as_str(),
                _ => placements[i].source.as_str(),
            })
            .collect();
        Error::input(
            "same-face-twice",
            format!(
                "{} points up in {} poses ({}), and no pose has {} up",
                face.name(),
                sources.len(),
                sources.join(" and "),
                missing.join(", ")
            ),
        )
    } else {
        let list: Vec<String> = oblique
            .iter()
            .take(6)
            .map(|p| format!("{} {:.0}°", p.label, p.angle_deg))
            .collect();
        let aside = if oblique.is_empty() {
            String::new()
        } else {
            format!(
                "; {} of {} poses are more than {MAX_FACE_ANGLE_DEG}° from every axis: {}",
                oblique.len(),
                placements.len(),
                list.join(", ")
            )
        };
        Error::input(
            "missing-face",
            format!(
                "{} of six faces found; missing: {}{aside}",
                6 - missing.len(),
                missing.join(" ")
            ),
        )
    };
    let error = match recordings {
        [one] => error.at(one.name.as_ref(), None),
        _ => error,
    };
    error.with_hint(format!(
        "record 3 s or more at rest with each of these axes: {next}; then calibrate again with all poses"
    ))
}

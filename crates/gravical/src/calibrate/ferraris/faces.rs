//! Placements sorted into the six faces, repeats pooled.

use gravical_core::six_position::SixPositionMeans;

use crate::recording::Recording;
use crate::segment::face::{Face, angle_deg};
use crate::segment::{MOST_FACE_ANGLE_DEG, Placement};
use crate::{Error, Result};

/// A repeat of a face that points this far from the best one is an oblique
/// pose, degrees.
const REPEAT_WITHIN_DEG: f64 = 5.0;

/// Placements of each face, by index, in the order of [`Face::all`].
#[derive(Debug, Clone)]
pub struct Faces {
    pub(in crate::calibrate) of_face: [Vec<usize>; 6],
    pub(super) means: SixPositionMeans<f64>,
    pub(super) standard_errors: Option<SixPositionMeans<f64>>,
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
pub fn sort_into_faces(placements: &[Placement], recordings: &[Recording]) -> Result<Faces> {
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
    let pooled = |face: Face| pool(placements, &of_face[face.index()]);
    let side = |up: bool| std::array::from_fn(|axis| pooled(Face { axis, up }));
    let (plus, minus): ([Pooled; 3], [Pooled; 3]) = (side(true), side(false));
    let errors_of = |side: &[Pooled; 3]| -> Option<[[f64; 3]; 3]> {
        let mut out = [[0.0; 3]; 3];
        for (row, pooled) in out.iter_mut().zip(side) {
            *row = pooled.standard_error?;
        }
        Some(out)
    };
    let standard_errors = errors_of(&plus)
        .zip(errors_of(&minus))
        .map(|(plus, minus)| SixPositionMeans { plus, minus });
    Ok(Faces {
        means: SixPositionMeans {
            plus: plus.map(|p| p.mean),
            minus: minus.map(|p| p.mean),
        },
        standard_errors,
        of_face,
    })
}

struct Pooled {
    mean: [f64; 3],
    standard_error: Option<[f64; 3]>,
}

fn pool(placements: &[Placement], indices: &[usize]) -> Pooled {
    let rows: f64 = indices.iter().map(|&i| placements[i].count as f64).sum();
    let weight = |i: usize| placements[i].count as f64 / rows;
    let mean = std::array::from_fn(|axis| {
        indices
            .iter()
            .map(|&i| weight(i) * placements[i].mean[axis])
            .sum()
    });
    let mut squares = Some([0.0; 3]);
    for &i in indices {
        squares = match (squares, placements[i].standard_error) {
            (Some(sum), Some(own)) => Some(std::array::from_fn(|axis| {
                sum[axis] + (weight(i) * own[axis]).powi(2)
            })),
            _ => None,
        };
    }
    Pooled {
        mean,
        standard_error: squares.map(|s: [f64; 3]| s.map(f64::sqrt)),
    }
}

fn incomplete(
    placements: &[Placement],
    of_face: &[Vec<usize>; 6],
    recordings: &[Recording],
) -> Error {
    let names = |wanted: bool| -> Vec<String> {
        Face::all()
            .into_iter()
            .filter(|f| of_face[f.index()].is_empty() != wanted)
            .map(Face::name)
            .collect()
    };
    let (there, missing) = (names(true), names(false));
    let oblique: Vec<&Placement> = placements.iter().filter(|p| p.face.is_none()).collect();
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
        let sources: Vec<String> = of_face[face.index()]
            .iter()
            .map(|&i| {
                let p = &placements[i];
                if recordings.len() > 1 {
                    p.source.clone()
                } else {
                    p.label.clone()
                }
            })
            .collect();
        Error::input(
            "same-face-twice",
            format!(
                "{} points up in {} ({}), and no pose has {} up",
                face.name(),
                if sources.len() == 2 {
                    "two poses".to_owned()
                } else {
                    format!("{} poses", sources.len())
                },
                sources.join(" and "),
                missing.join(", ")
            ),
        )
    } else {
        let mut message = format!(
            "{} of six faces found ({}); missing: {}",
            there.len(),
            if there.is_empty() {
                "none".to_owned()
            } else {
                there.join(" ")
            },
            missing.join(" ")
        );
        if !oblique.is_empty() {
            let list: Vec<String> = oblique
                .iter()
                .take(6)
                .map(|p| format!("{} {:.0}°", p.label, p.angle_deg))
                .collect();
            message.push_str(&format!(
                "; {} pose{} more than {MOST_FACE_ANGLE_DEG}° from every axis ({})",
                oblique.len(),
                if oblique.len() == 1 { " lies" } else { "s lie" },
                list.join(", ")
            ));
        }
        Error::input("missing-face", message)
    };
    let error = match recordings {
        [one] => error.at(one.name.as_ref(), None),
        _ => error,
    };
    error.with_hint(format!(
        "record 3 s or more at rest with each of these axes: {next}; then calibrate again with all poses"
    ))
}

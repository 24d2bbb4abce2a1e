//! Ferraris' six-position calibration: from placements to what the closed form
//! of [`gravical_core::six_position`] needs, and back.

use gravical_core::calibration::Calibration;
use gravical_core::six_position::{
    self, AccelerometerParameters, SixPositionMeans, TurnIntegral, ferraris_accelerometer,
    ferraris_covariance, ferraris_gyroscope,
};

use crate::calibration_file::GyroscopeSection;
use crate::recording::units::{GyroScale, GyroUnit};
use crate::recording::{Finding, Recording};
use crate::segment::face::{AXES, Face, angle_deg};
use crate::segment::turns::sample_period_s;
use crate::segment::{MOST_FACE_ANGLE_DEG, Placement, Segmentation};
use crate::{Error, Result};

/// A repeat of a face that lies this much further off than the best one is an
/// oblique pose, degrees.
const REPEAT_WITHIN_DEG: f64 = 5.0;

/// Placements of each face, by index, in the order of [`Face::all`].
#[derive(Debug, Clone)]
pub struct Faces {
    of_face: [Vec<usize>; 6],
    means: SixPositionMeans<f64>,
    standard_errors: Option<SixPositionMeans<f64>>,
}

impl Faces {
    /// How many placements take part.
    #[must_use]
    pub fn placements(&self) -> usize {
        self.of_face.iter().map(Vec::len).sum()
    }

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
            .map(|&i| placements[i].angle_deg)
            .fold(f64::INFINITY, f64::min);
        there.retain(|&i| placements[i].angle_deg <= best + REPEAT_WITHIN_DEG);
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
            format!(
                "the {axis} axis pointing {}",
                if sign == "+" { "up" } else { "down" }
            )
        })
        .collect::<Vec<_>>()
        .join(", and with ");
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
                "{} points up in {} ({}), and no placement has {} up",
                face.name(),
                if sources.len() == 2 {
                    "two placements".to_owned()
                } else {
                    format!("{} placements", sources.len())
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
                "; {} placement{} more than {MOST_FACE_ANGLE_DEG}° from every axis ({})",
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
        "record 3 s or more at rest with {next}, and calibrate again with that recording added"
    ))
}

/// A fitted accelerometer.
#[derive(Debug, Clone)]
pub struct AccelerometerFit {
    /// K, R and b.
    pub parameters: AccelerometerParameters<f64>,
    /// matrix · (raw − bias).
    pub calibration: Calibration<f64>,
}

impl AccelerometerFit {
    /// Angle of each face that placement and misalignment leave when bias and
    /// scale are taken off, rms over the faces, degrees. Ferraris' method
    /// cannot tell the two apart, so this bounds the tilt from above.
    #[must_use]
    pub fn face_angle_rms_deg(&self, faces: &Faces) -> f64 {
        let k = &self.parameters.scale;
        let squares: f64 = Face::all()
            .into_iter()
            .map(|face| {
                let side = if face.up {
                    &faces.means.plus
                } else {
                    &faces.means.minus
                };
                let reading = side[face.axis];
                let channels: [f64; 3] =
                    std::array::from_fn(|i| (reading[i] - self.parameters.bias[i]) / k[i]);
                angle_deg(self.to_case(channels), face.direction()).powi(2)
            })
            .sum();
        (squares / 6.0).sqrt()
    }

    /// Board channels in the order of the case's axes: each row of R says
    /// which axis its channel measures.
    fn to_case(&self, channels: [f64; 3]) -> [f64; 3] {
        let mut out = channels;
        for (channel, row) in self.parameters.orientation.iter().enumerate() {
            let axis = (0..3).fold(0, |best, i| {
                if row[i].abs() > row[best].abs() {
                    i
                } else {
                    best
                }
            });
            out[axis] = channels[channel] * row[axis].signum();
        }
        out
    }

    /// Covariance of row-major M and b by the noise of the means and a
    /// placement tilt (sd of each component); none without standard errors.
    #[must_use]
    pub fn covariance(
        &self,
        faces: &Faces,
        gravity: f64,
        tilt_rad: f64,
    ) -> Option<[[f64; 12]; 12]> {
        let errors = faces.standard_errors.as_ref()?;
        Some(ferraris_covariance(&faces.means, errors, gravity, tilt_rad))
    }
}

/// Fits K, R and b.
///
/// # Errors
///
/// `not-finite`, `singular`; `left-handed` when the faces were taken from names
/// and contradict each other.
pub fn accelerometer(faces: &Faces, gravity: f64, by_name: bool) -> Result<AccelerometerFit> {
    let failed = |e: six_position::SixPositionError| {
        Error::input(
            "singular",
            format!("the six means determine no parameters: {e}"),
        )
        .with_hint("`gravical inspect` shows what each placement reads")
    };
    let parameters = ferraris_accelerometer(&faces.means, gravity).map_err(failed)?;
    let sign_clash = (0..3).find(|&i| faces.means.plus[i][i] <= faces.means.minus[i][i]);
    if by_name
        && (parameters.orientation_determinant() <= 0.0
            || sign_clash.is_some_and(|_| is_diagonal(&parameters)))
    {
        let why = match sign_clash {
            Some(i) if is_diagonal(&parameters) => format!(
                "{a} reads less with +{a} up ({:.4}) than with −{a} up ({:.4})",
                faces.means.plus[i][i],
                faces.means.minus[i][i],
                a = AXES[i]
            ),
            _ => format!("det R = {:.3}", parameters.orientation_determinant()),
        };
        return Err(Error::input(
            "left-handed",
            format!(
                "the faces as named make a left-handed sensor ({why}): two placements are swapped"
            ),
        )
        .with_hint("leave --faces names out, and the faces are taken from the data"));
    }
    let calibration = parameters
        .calibration()
        .ok_or_else(|| failed(six_position::SixPositionError::Singular))?;
    Ok(AccelerometerFit {
        parameters,
        calibration,
    })
}

/// True when each channel measures its own axis, one way or the other.
fn is_diagonal(parameters: &AccelerometerParameters<f64>) -> bool {
    (0..3).all(|i| parameters.orientation[i][i].abs() > 0.7)
}

/// A gyroscope, or why there is none.
#[derive(Debug, Default)]
pub struct GyroscopeFit {
    /// The parameters; none without a turn about each axis.
    pub section: Option<GyroscopeSection>,
    /// What is odd.
    pub findings: Vec<Finding>,
}

/// Fits the gyroscope from its readings at rest and the turns by `angle_rad`.
///
/// # Errors
///
/// `missing-gyro` when there are turns and no gyroscope, `rate-unknown` when
/// neither stamps nor `--rate` tell the time, `singular`.
pub fn gyroscope(
    recordings: &[Recording],
    session: &Segmentation,
    faces: &Faces,
    accelerometer: &Calibration<f64>,
    gravity: f64,
    angle_rad: f64,
) -> Result<GyroscopeFit> {
    let mut fit = GyroscopeFit::default();
    if session.turns.is_empty() {
        return Ok(fit);
    }
    let missing: Vec<String> = (0..3)
        .filter(|axis| session.turns.iter().all(|t| t.axis != *axis))
        .map(|axis| AXES[axis].to_string())
        .collect();
    if !missing.is_empty() {
        fit.findings.push(Finding::note(
            "turns-incomplete",
            format!(
                "no full turn about {}: the gyroscope is not calibrated",
                missing.join(" and ")
            ),
        ));
        return Ok(fit);
    }
    let (bias, means) = at_rest(&session.placements, faces)?;
    let sensitivity = six_position::g_sensitivity(&means, gravity).map_err(singular)?;
    let mut turns = [[0.0; 3]; 3];
    for (axis, sum) in turns.iter_mut().enumerate() {
        let about: Vec<_> = session.turns.iter().filter(|t| t.axis == axis).collect();
        for turn in &about {
            let recording = &recordings[turn.recording];
            let integral = integrate(
                recording,
                turn.rows.clone(),
                bias,
                sensitivity,
                accelerometer,
            )?;
            (0..3).for_each(|i| sum[i] += integral[i] / about.len() as f64);
        }
    }
    let parameters =
        ferraris_gyroscope(bias, &means, gravity, &turns, angle_rad).map_err(singular)?;
    let calibration = parameters.calibration().ok_or_else(|| {
        Error::input(
            "singular",
            "the three turns do not span space: were two about the same axis?",
        )
    })?;
    let diagonal: [f64; 3] = std::array::from_fn(|i| parameters.orientation[i][i]);
    let backwards: Vec<String> = (0..3)
        .filter(|&i| diagonal[i] < 0.0)
        .map(|i| AXES[i].to_string())
        .collect();
    if !backwards.is_empty() {
        let degrees = angle_rad.to_degrees();
        fit.findings.push(Finding::warning(
            "turned-other-way",
            format!(
                "about {} the sensor turned the other way than {degrees}°, or its gyroscope is left-handed: R_g has {} on its diagonal and det {:.3}; with --turn-angle {} it comes out right-handed",
                backwards.join(", "),
                diagonal.map(|d| format!("{d:.3}")).join(", "),
                gravical_core::matrix3::det(&parameters.orientation),
                -degrees
            ),
        ));
    }
    let unit = session
        .gyro_scale
        .map_or(GyroUnit::Unknown, |s: GyroScale| s.unit);
    fit.section = Some(GyroscopeSection {
        input_unit: unit,
        output_unit: GyroUnit::RadianPerSecond,
        bias: parameters.bias,
        matrix: calibration.matrix,
        scale: parameters.scale,
        orientation: parameters.orientation,
        g_sensitivity: parameters.g_sensitivity,
    });
    Ok(fit)
}

fn singular(e: six_position::SixPositionError) -> Error {
    Error::input("singular", format!("the turns determine no gyroscope: {e}"))
}

/// Bias (mean over all samples of the six faces) and the mean of each face.
fn at_rest(placements: &[Placement], faces: &Faces) -> Result<([f64; 3], SixPositionMeans<f64>)> {
    let sum_of = |indices: &[usize]| {
        let (mut sum, mut count) = ([0.0; 3], 0);
        for (s, n) in indices.iter().filter_map(|&i| placements[i].gyro_sum) {
            count += n;
            (0..3).for_each(|i| sum[i] += s[i]);
        }
        (sum, count)
    };
    let (mut total, mut rows) = ([0.0; 3], 0);
    let mut means = SixPositionMeans {
        plus: [[0.0; 3]; 3],
        minus: [[0.0; 3]; 3],
    };
    for face in Face::all() {
        let (sum, count) = sum_of(&faces.of_face[face.index()]);
        if count == 0 {
            return Err(Error::input(
                "missing-gyro",
                format!(
                    "the placement {} has no reading of the gyroscope, which the turns need",
                    face.name()
                ),
            )
            .with_hint(
                "record all placements with the gyroscope's columns, or leave the turns out",
            ));
        }
        rows += count;
        (0..3).for_each(|i| total[i] += sum[i]);
        let mean = sum.map(|s| s / count as f64);
        if face.up {
            means.plus[face.axis] = mean;
        } else {
            means.minus[face.axis] = mean;
        }
    }
    Ok((total.map(|t| t / rows as f64), means))
}

fn integrate(
    recording: &Recording,
    rows: std::ops::Range<usize>,
    bias: [f64; 3],
    sensitivity: [[f64; 3]; 3],
    accelerometer: &Calibration<f64>,
) -> Result<[f64; 3]> {
    let Some(gyro) = &recording.gyro else {
        return Err(Error::input("missing-gyro", "a turn needs a gyroscope")
            .at(recording.name.as_ref(), None));
    };
    let mut integral = TurnIntegral::new(bias, sensitivity);
    for row in rows {
        let period = sample_period_s(recording, row).ok_or_else(|| {
            Error::input(
                "rate-unknown",
                "there are no time stamps, and a turn needs the time between samples",
            )
            .at(recording.name.as_ref(), None)
            .with_hint("say the sampling rate: --rate 100")
        })?;
        let rate: [f64; 3] = std::array::from_fn(|i| gyro[i][row]);
        let accel = accelerometer.apply(recording.accel_at(row));
        if rate.iter().chain(&accel).all(|v| v.is_finite()) {
            integral.add(rate, accel, period);
        }
    }
    Ok(integral.finish())
}

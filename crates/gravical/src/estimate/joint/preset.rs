//! The fit with assumptions in place of all that [`joint`](super::joint()) finds out:
//! no prior, no tilt or model error to be estimated, no bad poses.
//!
//! # `magnitude9`, `magnitude6`
//!
//! All poses are free, and only the length of gravity counts, alike in all of them:
//!
//! ```text
//! Σ (‖M⁻¹(u_k − b)‖ − g)²
//! ```
//!
//! Nine parameters: M upper triangular, and b. A full matrix would have three more that
//! no length can tell, those of a rotation; the triangle fixes them by the convention that
//! z is the sensor's own z axis and y lies in its y–z plane. Six parameters: M diagonal.
//!
//! Source: Tedaldi, Pretto and Menegatti, ICRA 2014, eq. 4–10 (program imu_tk, whose
//! A = M⁻¹ is T·K, T with a diagonal of one). Its cost is the difference of squares; this
//! is the difference of lengths, whose minimum is the same but for terms of the size of the
//! residual over g. All poses count alike since real sensors miss the model by more than
//! the noise of their means.
//!
//! # `linear12`
//!
//! Faces without any tilt: u_k = M g n_k + b with n_k known, weighed by the standard
//! errors of the means, or all alike when a reading has none. The classical fit of a
//! precise fixture. On a table it is the worst of all: a placement that is tilted by 1°
//! moves the bias by 6 mg, since nothing says that it may be tilted.
//!
//! Source: Grip and Sabourova, Mech. Syst. Signal Process. 25 (2011) 493, with directions
//! instead of tilting angles.
//!
//! Both fail where poses leave parameters open; the error names poses that would not.

use gravical_core::matrix3;
use nalgebra::{DMatrix, DVector};

use crate::estimate::observability::{coverage, settling, undetermined};
use crate::estimate::{Reading, reading, solve};
use crate::predicted;
use crate::segment::face::{Face, angle_deg};
use crate::stats::median;
use crate::{Error, Result};

use super::fit::{Fit, Held, Pose, Start, fit_with};
use super::leave_out::NEIGHBOUR_DEG;
use super::model::{self, Elements};

/// What is assumed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Preset<'a> {
    /// The length of gravity alone; M is upper triangular.
    Magnitude9,
    /// The length of gravity alone; M is diagonal.
    Magnitude6,
    /// Exactly these faces, one for each reading.
    Linear12(&'a [Face]),
}

/// What is known beside the readings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PresetOptions<'a> {
    /// What is assumed.
    pub preset: Preset<'a>,
    /// Local gravity, m/s².
    pub gravity: f64,
    /// Nominal scale, input unit per m/s²; none where the range is not known. It is only
    /// a start.
    pub nominal: Option<f64>,
}

/// The fitted accelerometer.
#[derive(Debug, Clone, PartialEq)]
pub struct PresetFit {
    /// M of u = M a + b, input unit per m/s².
    pub model: [[f64; 3]; 3],
    /// M⁻¹ of a = M⁻¹(u − b).
    pub matrix: [[f64; 3]; 3],
    /// b, input unit.
    pub bias: [f64; 3],
    /// Lengths, or readings of three components, less parameters.
    pub freedom: f64,
    /// Of row-major M and b, zero for the elements that are fixed. By the standard errors,
    /// times χ²/freedom where that exceeds 1; by the scatter of the residuals where all
    /// count alike. None when there is neither. The tilt of faces that are taken as exact,
    /// which is larger, is not in it.
    pub covariance: Option<[[f64; 12]; 12]>,
    /// Largest over smallest singular value of the derivatives of what is fitted, columns
    /// of length one. Above 30 a few poses carry the result.
    pub condition: f64,
}

impl PresetFit {
    /// M⁻¹(u − b) of a reading, m/s².
    #[must_use]
    pub fn calibrated(&self, reading: [f64; 3]) -> [f64; 3] {
        matrix3::mul_vec(&self.matrix, &matrix3::sub(&reading, &self.bias))
    }
}

/// An error of a mean is not enlarged more than this: a tenth of a mm/s² in the poses
/// would be a m/s² elsewhere. What is enlarged less may still be too much; that depends on
/// the noise. Faces are held to a tenth of it.
const MOST_ENLARGED: [f64; 2] = [1e4, 1e3];
/// ‖a‖ that is less well known than this share of gravity in some direction is not known:
/// the data sheet alone says as much.
const UNKNOWN: f64 = 0.035;

/// Fits M and b under the assumptions of a preset.
///
/// # Errors
///
/// `underdetermined` when the poses leave parameters open, naming poses that would
/// determine them; `reading-values` for numbers that are none; `no-poses`;
/// `not-converged`.
pub fn preset(readings: &[Reading], options: &PresetOptions<'_>) -> Result<PresetFit> {
    let fit = fitted(readings, options)?;
    if options.lengths().is_some()
        && let Some(covariance) = &fit.covariance
    {
        let g = options.gravity;
        let (n, sd) = predicted::weakest(&fit.matrix, covariance, g);
        if sd > UNKNOWN * g {
            return Err(Error::input(
                "underdetermined",
                format!(
                    "{} poses leave |a| open to ±{:.0} mg along ({:.2}, {:.2}, {:.2})",
                    readings.len(),
                    1000.0 * sd / g,
                    n[0],
                    n[1],
                    n[2]
                ),
            )
            .with_hint(
                "record it with that direction up, and leave out poses that moved or are in another unit",
            ));
        }
    }
    Ok(fit)
}

/// ‖M⁻¹(u − b)‖ − g of every pose under a fit that knows neither it nor any pose within
/// `neighbour_deg` of it, m/s², none where the others do not determine the parameters;
/// with 0 the pose alone is left out. Usually 25°.
///
/// # Errors
///
/// As [`preset`], of all poses together; but ‖a‖ need not be known well in every
/// direction: how well it is shows in the errors.
pub fn preset_left_out(
    readings: &[Reading],
    options: &PresetOptions<'_>,
    neighbour_deg: Option<f64>,
) -> Result<Vec<Option<f64>>> {
    let neighbour_deg = neighbour_deg.unwrap_or(NEIGHBOUR_DEG);
    let whole = fitted(readings, options)?;
    let forces: Vec<[f64; 3]> = readings.iter().map(|r| whole.calibrated(r.mean)).collect();
    let without = |k: usize| {
        let far = |i: usize| i != k && angle_deg(forces[i], forces[k]) > neighbour_deg;
        let rest = (0..readings.len()).filter(|&i| far(i));
        let rest: Vec<Reading> = rest.map(|i| readings[i]).collect();
        let fit = fitted(&rest, options).ok()?;
        Some(matrix3::norm(&fit.calibrated(readings[k].mean)) - options.gravity)
    };
    Ok((0..readings.len()).map(without).collect())
}

impl PresetOptions<'_> {
    /// The elements that are fitted to lengths; none where faces are known.
    fn lengths(&self) -> Option<Elements> {
        match self.preset {
            Preset::Magnitude9 => Some(Elements::Triangular),
            Preset::Magnitude6 => Some(Elements::Diagonal),
            Preset::Linear12(_) => None,
        }
    }

    fn faces(&self) -> &[Face] {
        match self.preset {
            Preset::Linear12(faces) => faces,
            Preset::Magnitude9 | Preset::Magnitude6 => &[],
        }
    }
}

/// The fit, however well it is known.
fn fitted(readings: &[Reading], options: &PresetOptions<'_>) -> Result<PresetFit> {
    reading::check(readings)?;
    let (m, b) = start(readings, options)
        .ok_or_else(|| Error::input("no-poses", "there is no reading of gravity's length"))?;
    let errors = reading::standard_errors(readings);
    // Of lengths all count alike, in m/s².
    let lengths = options.lengths();
    let weights = errors.clone().filter(|_| lengths.is_none());
    let alike = vec![[1.0; 3]; readings.len()];
    let begin = Start {
        m,
        b,
        at: Vec::new(),
    };
    observed(readings, options, (&m, b))?;
    let sd = weights.as_ref().unwrap_or(&alike);
    let no_minimum = || no_minimum(readings.len());
    let found = search(readings, sd, options, &begin).ok_or_else(no_minimum)?;
    let (m, b) = (found.state.m, found.state.b);
    let condition = observed(readings, options, (&m, b))?;
    let matrix = matrix3::inverse(&m).ok_or_else(|| {
        Error::input(
            "singular",
            "the fitted matrix has no inverse: an axis does not answer",
        )
        .with_hint("is an axis dead, or are poses the same?")
    })?;
    let per_freedom = found.chi2 / found.freedom.max(1.0);
    let known = found.full_covariance();
    let scaled = |factor: f64| known.map(|c| c.map(|row| row.map(|c| c * factor)));
    let covariance = match (&weights, found.freedom >= 1.0) {
        (Some(_), _) => scaled(per_freedom.max(1.0)),
        (None, true) => scaled(per_freedom),
        // No poses to spare: what the standard errors say of the lengths, where there are
        // any.
        (None, false) => errors.filter(|_| lengths.is_some()).and_then(|errors| {
            let along = |(r, s): (&Reading, &[f64; 3])| {
                let n = model::unit(matrix3::mul_vec(&matrix, &matrix3::sub(&r.mean, &b)));
                let w = matrix3::mul_vec(&matrix3::transpose(&matrix), &n);
                [matrix3::norm(&[0, 1, 2].map(|i| w[i] * s[i])); 3]
            };
            let sd: Vec<[f64; 3]> = readings.iter().zip(&errors).map(along).collect();
            search(readings, &sd, options, &found.start())?.full_covariance()
        }),
    };
    Ok(PresetFit {
        model: m,
        matrix,
        bias: b,
        freedom: found.freedom,
        covariance,
        condition,
    })
}

/// The minimum with these standard deviations; none without one.
fn search(
    readings: &[Reading],
    sd: &[[f64; 3]],
    options: &PresetOptions<'_>,
    start: &Start,
) -> Option<Fit> {
    let pose = |(k, reading): (usize, &Reading)| Pose {
        mean: reading.mean,
        sd: sd[k],
        face: options.faces().get(k).copied(),
        group: k,
        left_out: false,
    };
    let poses: Vec<Pose> = readings.iter().enumerate().map(pose).collect();
    let held = Held {
        gravity: options.gravity,
        tilt: 0.0,
        prior: None,
        model_error: 0.0,
        scatter: 0.0,
        lengths: options.lengths(),
    };
    fit_with(&solve::Options::default(), &poses, &held, start).filter(|found| found.converged)
}

fn no_minimum(poses: usize) -> Error {
    Error::input(
        "not-converged",
        format!("{poses} poses lead to no calibration"),
    )
    .with_hint("is one of them moving, or in another unit? leave out the ones that differ")
}

/// The sphere nearest to the readings: ‖u‖² = 2 b·u + (s²g² − ‖b‖²) is linear in b and
/// the bracket. Where the poses do not carry it, the nominal scale.
fn start(readings: &[Reading], options: &PresetOptions<'_>) -> Option<([[f64; 3]; 3], [f64; 3])> {
    let mut lengths: Vec<f64> = readings.iter().map(|r| matrix3::norm(&r.mean)).collect();
    let usual = median(&mut lengths).filter(|l| *l > 0.0)?;
    let sphere = || {
        if readings.len() < 4 {
            return None;
        }
        let rows = DMatrix::from_fn(readings.len(), 4, |k, j| {
            if j < 3 {
                2.0 * readings[k].mean[j] / usual
            } else {
                1.0
            }
        });
        let right = DVector::from_fn(readings.len(), |k, _| {
            (matrix3::norm(&readings[k].mean) / usual).powi(2)
        });
        // The decomposition may never end on what is not finite.
        if rows.iter().chain(&right).any(|v| !v.is_finite()) {
            return None;
        }
        let svd = rows.svd(true, true);
        if svd.singular_values.min() < svd.singular_values.max() / 100.0 {
            return None;
        }
        let x = svd.solve(&right, 0.0).ok()?;
        let b = [x[0], x[1], x[2]];
        let radius = x[3] + b.iter().map(|v| v * v).sum::<f64>();
        (radius > 0.0).then(|| {
            (
                radius.sqrt() * usual / options.gravity,
                b.map(|v| v * usual),
            )
        })
    };
    // A nominal scale that is far off is a wrong unit, not a start.
    let near = |s: f64, to: f64| (0.5..2.0).contains(&(s / to));
    let by_length = usual / options.gravity;
    let nominal = options.nominal.filter(|n| near(by_length, *n));
    let (scale, bias) = sphere()
        .filter(|(s, _)| nominal.is_none_or(|n| near(*s, n)))
        .unwrap_or((nominal.unwrap_or(by_length), [0.0; 3]));
    Some((matrix3::diagonal([scale; 3]), bias))
}

/// The condition of what is fitted; an error that says which poses are missing where the
/// present ones leave parameters open.
///
/// Of lengths, columns are derivatives by M⁻¹ and b in natural units (shares of the scale,
/// and of gravity), in which all are of the size of one: a small one means a small angle,
/// not a unit. Of faces they are directions and one, the same for each channel.
fn observed(
    readings: &[Reading],
    options: &PresetOptions<'_>,
    (m, b): (&[[f64; 3]; 3], [f64; 3]),
) -> Result<f64> {
    let n = readings.len();
    let inverse = matrix3::inverse(m).ok_or_else(|| no_minimum(n))?;
    let calibrated = |u: &[f64; 3]| matrix3::mul_vec(&inverse, &matrix3::sub(u, &b));
    let scale = matrix3::row_norms(&inverse).iter().sum::<f64>() / 3.0;
    let by_length = |elements: Elements, u: [f64; 3]| {
        let along = model::unit(calibrated(&u));
        let w = matrix3::mul_vec(&matrix3::transpose(&inverse), &along);
        let v = matrix3::sub(&u, &b);
        let row = elements.list().iter().map(|&e| match e {
            0..9 => along[e / 3] * v[e % 3] * scale / options.gravity,
            _ => -w[e - 9] / scale,
        });
        DVector::from_iterator(elements.list().len(), row)
    };
    let by_direction = |n: [f64; 3]| DVector::from_vec(vec![n[0], n[1], n[2], 1.0]);
    let (rows, directions): (Vec<DVector<f64>>, Vec<[f64; 3]>) = match options.lengths() {
        Some(elements) => readings
            .iter()
            .map(|r| {
                (
                    by_length(elements, r.mean),
                    model::unit(calibrated(&r.mean)),
                )
            })
            .unzip(),
        None => options
            .faces()
            .iter()
            .map(|face| (by_direction(face.direction()), face.direction()))
            .unzip(),
    };
    let faces_only = options.lengths().is_none();
    let enlarged = MOST_ENLARGED[usize::from(faces_only)];
    let seen = undetermined(&rows, enlarged).ok_or_else(|| no_minimum(n))?;
    if seen.open.is_empty() {
        return Ok(seen.condition);
    }
    let (all, left) = match options.lengths() {
        Some(elements) => (elements.list().len(), seen.open.len()),
        None => (12, 3 * seen.open.len()),
    };
    let needs = match options.preset {
        Preset::Magnitude9 => "nine parameters need 9 poses or more, between the axes too",
        Preset::Magnitude6 => "six parameters need 6 poses or more, about one on each face",
        Preset::Linear12(_) => {
            "twelve parameters need 4 faces that do not lie in one plane, better all six"
        }
    };
    let settling = settling(&seen.open, faces_only, |n| match options.lengths() {
        Some(elements) => {
            let at = matrix3::mul_vec(m, &n.map(|v| v * options.gravity));
            by_length(elements, [0, 1, 2].map(|i| at[i] + b[i]))
        }
        None => by_direction(n),
    });
    let mut hint = needs.to_owned();
    if !settling.is_empty() {
        hint.push_str(&format!("; record {}", settling.join("; ")));
    }
    Err(Error::input(
        "underdetermined",
        format!(
            "{n} poses determine {} of the {all} parameters: {}",
            all - left,
            coverage(&directions)
        ),
    )
    .with_hint(hint))
}

/// On sensors whose truth is known.
#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    use super::*;
    use crate::predicted::sphere;

    const G: f64 = 9.81;
    /// The upper triangle of the convention.
    const M: [[f64; 3]; 3] = [
        [1638.0, 31.0, -12.0],
        [0.0, 1690.0, 25.0],
        [0.0, 0.0, 1652.0],
    ];
    const B: [f64; 3] = [310.0, -450.0, 120.0];

    fn reading(n: [f64; 3], standard_error: Option<[f64; 3]>) -> Reading {
        let force = matrix3::mul_vec(&M, &model::unit(n).map(|v| v * G));
        Reading {
            mean: [0, 1, 2].map(|i| force[i] + B[i]),
            standard_error,
        }
    }

    fn with(preset: Preset<'_>) -> PresetOptions<'_> {
        PresetOptions {
            preset,
            gravity: G,
            nominal: Some(1670.0),
        }
    }

    fn noisy(rng: &mut ChaCha8Rng, poses: usize, s: [f64; 3]) -> Vec<Reading> {
        let turn = nalgebra::Rotation3::from_euler_angles(
            rng.random::<f64>(),
            rng.random::<f64>(),
            rng.random::<f64>(),
        );
        sphere(poses)
            .map(|n| {
                let n = turn * nalgebra::Vector3::from(n);
                let mut r = reading([n[0], n[1], n[2]], Some(s));
                for i in 0..3 {
                    r.mean[i] += s[i] * rng.sample::<f64, _>(StandardNormal);
                }
                r
            })
            .collect()
    }

    fn on(faces: &[Face], s: Option<[f64; 3]>) -> Vec<Reading> {
        faces.iter().map(|f| reading(f.direction(), s)).collect()
    }

    fn rms(errors: &[f64]) -> f64 {
        (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt()
    }

    #[test]
    fn exact_readings_give_the_parameters_back() {
        let faces = Face::all();
        let nine: Vec<Reading> = sphere(9).map(|n| reading(n, None)).collect();
        let six = on(&faces, None);
        // With and without a nominal scale.
        for nominal in [Some(1670.0), None] {
            for (preset, readings, freedom) in [
                (Preset::Magnitude9, &nine, 0.0),
                (Preset::Linear12(&faces), &six, 6.0),
            ] {
                let options = PresetOptions {
                    nominal,
                    ..with(preset)
                };
                let fit = super::preset(readings, &options).unwrap();
                for i in 0..3 {
                    assert!((fit.bias[i] - B[i]).abs() < 1e-7, "{:?}", fit.bias);
                    for j in 0..3 {
                        assert!((fit.model[i][j] - M[i][j]).abs() < 1e-7);
                    }
                }
                let product = matrix3::mul(&fit.matrix, &fit.model);
                assert!((product[0][0] - 1.0).abs() < 1e-12 && product[0][1].abs() < 1e-12);
                assert_eq!(fit.freedom, freedom);
                assert_eq!(fit.covariance.is_some(), freedom > 0.0);
            }
        }
    }

    #[test]
    fn six_parameters_are_the_diagonal_ones() {
        let diagonal = |n: [f64; 3]| Reading {
            mean: [0, 1, 2].map(|i| M[i][i] * G * n[i] + B[i]),
            standard_error: Some([2.0; 3]),
        };
        let faces = Face::all().map(|f| diagonal(f.direction()));
        let fit = preset(&faces, &with(Preset::Magnitude6)).unwrap();
        let c = fit.covariance.unwrap();
        for i in 0..3 {
            assert!((fit.bias[i] - B[i]).abs() < 1e-8);
            assert!((fit.model[i][i] - M[i][i]).abs() < 1e-8);
            // (u₊ + u₋)/2 and (u₊ − u₋)/2g.
            assert!((c[9 + i][9 + i] / 2.0 - 1.0).abs() < 1e-6);
            assert!((c[4 * i][4 * i] / (2.0 / G / G) - 1.0).abs() < 1e-6);
            for j in 0..12 {
                assert!(j == i || (0..12).all(|k| c[3 * i + (i + 1) % 3][k] == 0.0));
            }
        }
        assert_eq!(fit.freedom, 0.0);
    }

    /// 300 sensors of 14 poses: mean squares of error over standard deviation. Student's
    /// t of 5 degrees of freedom: its mean square is 5/3, which scatters by
    /// √(22/300) = 0.27; bounds are three times that.
    #[test]
    fn errors_are_as_large_as_the_covariance_says() {
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let mut squares = [0.0; 12];
        let runs = 300;
        for _ in 0..runs {
            let readings = noisy(&mut rng, 14, [5.0; 3]);
            let fit = preset(&readings, &with(Preset::Magnitude9)).unwrap();
            let c = fit.covariance.unwrap();
            let off: [f64; 12] = std::array::from_fn(|e| match e {
                0..9 => fit.model[e / 3][e % 3] - M[e / 3][e % 3],
                _ => fit.bias[e - 9] - B[e - 9],
            });
            for e in Elements::Triangular.list() {
                squares[*e] += off[*e].powi(2) / c[*e][*e] / f64::from(runs);
            }
            for e in [3, 6, 7] {
                assert_eq!((off[e], c[e][e]), (0.0, 0.0));
            }
        }
        println!("{squares:.2?}");
        for e in Elements::Triangular.list() {
            assert!((0.9..2.5).contains(&squares[*e]), "{e}: {squares:?}");
        }
    }

    #[test]
    fn faces_have_the_covariance_that_stands_on_paper() {
        // Var b = s²/6 and Var M_ij = s²/(2g²): pairs of faces.
        let s = [1.0, 2.0, 3.0];
        let faces = Face::all();
        let fit = preset(&on(&faces, Some(s)), &with(Preset::Linear12(&faces))).unwrap();
        let c = fit.covariance.unwrap();
        for i in 0..3 {
            let (b, m) = (s[i] * s[i] / 6.0, s[i] * s[i] / 2.0 / G / G);
            assert!((c[9 + i][9 + i] / b - 1.0).abs() < 1e-12);
            for j in 0..3 {
                assert!((c[3 * i + j][3 * i + j] / m - 1.0).abs() < 1e-12);
                assert!(c[3 * i + j][9 + i].abs() < 1e-12 * b);
            }
        }
        assert!((fit.condition - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_reading_that_is_known_less_counts_less() {
        // +z twice, once off by 1000 and a hundred times less sure.
        let mut faces = Face::all().to_vec();
        let top = Face { axis: 2, up: true };
        faces.push(top);
        let mut readings = on(&faces, Some([1.0; 3]));
        readings[6].mean[2] += 1000.0;
        readings[6].standard_error = Some([100.0; 3]);
        let weighed = preset(&readings, &with(Preset::Linear12(&faces))).unwrap();
        assert!((weighed.bias[2] - B[2]).abs() < 0.1);
        // χ² = (1000/100)² over 9 degrees of freedom widens the covariance.
        let alone = preset(&readings[..6], &with(Preset::Linear12(&faces[..6]))).unwrap();
        let variance = |fit: &PresetFit| fit.covariance.unwrap()[9][9];
        assert!((variance(&weighed) / variance(&alone) / (100.0 / 9.0) - 1.0).abs() < 1e-2);
        readings.iter_mut().for_each(|r| r.standard_error = None);
        let alike = preset(&readings, &with(Preset::Linear12(&faces))).unwrap();
        assert!((alike.bias[2] - B[2]).abs() > 50.0 && alike.covariance.is_some());
    }

    #[test]
    fn what_is_missing_is_said() {
        let said = |poses: &[[f64; 3]], preset| {
            let readings: Vec<Reading> = poses.iter().map(|n| reading(*n, None)).collect();
            let error = super::preset(&readings, &with(preset)).unwrap_err();
            assert_eq!(error.code(), "underdetermined");
            println!("{error}; {:?}", error.hint());
            let hint = error.hint().unwrap_or("").to_owned();
            (error.message().to_owned(), hint)
        };
        // Turned about z only.
        let flat = [0.0_f64, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0].map(|k| [k.cos(), k.sin(), 0.0]);
        let (what, hint) = said(&flat, Preset::Magnitude9);
        assert_eq!(
            what,
            "7 poses determine 5 of the 9 parameters: only x and y are covered; z is missing"
        );
        assert!(hint.contains("; record "), "{hint}");
        // Six sides say nothing of the angles between axes: edges do.
        let faces = Face::all().map(Face::direction);
        let (what, hint) = said(&[faces, faces].concat(), Preset::Magnitude9);
        assert!(
            what.ends_with("all three axes are covered, but parameters remain open"),
            "{what}"
        );
        assert_eq!(hint.matches("tilted 45°").count(), 3, "{hint}");
        // Five of six sides.
        let (what, hint) = said(&faces[..5], Preset::Magnitude6);
        assert!(what.contains("determine 5 of the 6 parameters"), "{what}");
        assert!(hint.ends_with("record z down"), "{hint}");
        // +x, −x, +y, −y: nothing along z.
        let flat = Face::all();
        let (what, hint) = said(&faces[..4], Preset::Linear12(&flat[..4]));
        assert_eq!(
            what,
            "4 poses determine 9 of the 12 parameters: only x and y are covered; z is missing"
        );
        assert!(hint.ends_with("record z up"), "{hint}");
        // +x, +y, +z lie in a plane.
        let corner = [faces[0], faces[2], faces[4]];
        let of = [flat[0], flat[2], flat[4]];
        let (what, hint) = said(&corner, Preset::Linear12(&of));
        assert!(what.contains("9 of the 12"), "{what}");
        assert!(hint.ends_with(" down"), "{hint}");
    }

    #[test]
    fn nothing_and_no_number_are_no_readings() {
        let code = |readings: &[Reading], preset| {
            let error = super::preset(readings, &with(preset)).unwrap_err();
            error.code()
        };
        let mut one = [reading([0.0, 0.0, 1.0], None)];
        one[0].mean[1] = f64::NAN;
        let up = [Face { axis: 2, up: true }];
        for (preset, none) in [
            (Preset::Magnitude6, Preset::Magnitude6),
            (Preset::Linear12(&up), Preset::Linear12(&[])),
        ] {
            assert_eq!(code(&one, preset), "reading-values");
            assert_eq!(code(&[], none), "no-poses");
        }
    }

    #[test]
    fn noise_does_not_make_a_plane_a_space() {
        // Two dozen poses that all lie within half a degree of a plane, with noise
        // of 2 mg: z is guessed, not measured.
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let readings: Vec<Reading> = (0..24)
            .map(|k| {
                let angle = f64::from(k) * 0.7;
                let z = 0.008 * rng.sample::<f64, _>(StandardNormal);
                let mut r = reading([angle.cos(), angle.sin(), z], Some([32.0; 3]));
                for i in 0..3 {
                    r.mean[i] += 32.0 * rng.sample::<f64, _>(StandardNormal);
                }
                r
            })
            .collect();
        let error = preset(&readings, &with(Preset::Magnitude9)).unwrap_err();
        assert_eq!(error.code(), "underdetermined", "{error}");
    }

    #[test]
    fn errors_on_poses_that_were_left_out() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let readings = noisy(&mut rng, 40, [4.0; 3]);
        let errors = |preset| -> Vec<f64> {
            let errors = preset_left_out(&readings, &with(preset), None).unwrap();
            errors.into_iter().map(Option::unwrap).collect()
        };
        let nine = rms(&errors(Preset::Magnitude9));
        // About the noise of a mean, a little more for the parameters.
        let noise = 4.0 / 1660.0;
        assert!((0.9..1.6).contains(&(nine / noise)), "{}", nine / noise);
        // The diagonal model misses the angles: 31/1690 of gravity and less.
        assert!(rms(&errors(Preset::Magnitude6)) > 10.0 * nine);
    }
}

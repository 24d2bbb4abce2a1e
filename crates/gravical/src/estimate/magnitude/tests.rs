//! On sensors whose truth is known.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::*;
use crate::validate::predicted::sphere;

const G: f64 = 9.81;
/// The upper triangle of the convention.
const M: [[f64; 3]; 3] = [
    [1638.0, 31.0, -12.0],
    [0.0, 1690.0, 25.0],
    [0.0, 0.0, 1652.0],
];
const B: [f64; 3] = [310.0, -450.0, 120.0];

fn reading(n: [f64; 3]) -> Reading {
    let force = matrix3::mul_vec(&M, &n.map(|v| v * G));
    Reading {
        mean: [0, 1, 2].map(|i| force[i] + B[i]),
        standard_error: None,
    }
}

fn unit(n: [f64; 3]) -> [f64; 3] {
    let length = matrix3::norm(&n);
    n.map(|v| v / length)
}

fn options(kind: Kind) -> MagnitudeOptions {
    MagnitudeOptions {
        gravity: G,
        nominal: Some(1670.0),
        kind,
        weights: Weights::StandardErrors,
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
            let mut r = reading([n[0], n[1], n[2]]);
            for i in 0..3 {
                r.mean[i] += s[i] * rng.sample::<f64, _>(StandardNormal);
            }
            r.standard_error = Some(s);
            r
        })
        .collect()
}

#[test]
fn nine_exact_poses_give_nine_parameters_back() {
    let readings: Vec<Reading> = sphere(9).map(reading).collect();
    // With and without a nominal scale.
    for nominal in [Some(1670.0), None] {
        let fit = magnitude(
            &readings,
            &MagnitudeOptions {
                nominal,
                ..options(Kind::Nine)
            },
        )
        .unwrap();
        for i in 0..3 {
            assert!((fit.bias[i] - B[i]).abs() < 1e-7, "{:?}", fit.bias);
            for j in 0..3 {
                assert!((fit.model[i][j] - M[i][j]).abs() < 1e-7);
            }
        }
        assert!(fit.rms_mps2() < 1e-11);
        assert_eq!((fit.freedom, fit.covariance, fit.chi2), (0, None, None));
    }
}

#[test]
fn six_parameters_are_the_diagonal_ones() {
    let diagonal = |n: [f64; 3]| Reading {
        mean: [0, 1, 2].map(|i| M[i][i] * G * n[i] + B[i]),
        standard_error: Some([2.0; 3]),
    };
    let faces = crate::segment::face::Face::all().map(|f| diagonal(f.direction()));
    let fit = magnitude(&faces, &options(Kind::Six)).unwrap();
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
    assert_eq!(fit.freedom, 0);
}

/// 300 sensors of 14 poses whose axes differ in noise: mean squares of error
/// over standard deviation. Normal errors: √(2/300) = 0.08 each; bounds are
/// three times that.
#[test]
fn errors_are_as_large_as_the_covariance_says() {
    for (weights, s) in [
        (Weights::StandardErrors, [3.0, 5.0, 8.0]),
        (Weights::Alike, [5.0; 3]),
    ] {
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let mut squares = [0.0; 12];
        let (mut chi2, runs) = (0.0, 300);
        for _ in 0..runs {
            let readings = noisy(&mut rng, 14, s);
            let fit = magnitude(
                &readings,
                &MagnitudeOptions {
                    weights,
                    ..options(Kind::Nine)
                },
            )
            .unwrap();
            let c = fit.covariance.unwrap();
            let off: [f64; 12] = std::array::from_fn(|e| match e {
                0..9 => fit.model[e / 3][e % 3] - M[e / 3][e % 3],
                _ => fit.bias[e - 9] - B[e - 9],
            });
            for e in [0, 1, 2, 4, 5, 8, 9, 10, 11] {
                squares[e] += off[e].powi(2) / c[e][e];
            }
            for e in [3, 6, 7] {
                assert_eq!((off[e], c[e][e]), (0.0, 0.0));
            }
            chi2 += fit.chi2.unwrap_or(5.0);
        }
        let runs = f64::from(runs);
        let mean: Vec<f64> = squares.iter().map(|z| z / runs).collect();
        println!("{weights:?}: {mean:.2?}, chi2 {:.2} of 5", chi2 / runs);
        if weights == Weights::StandardErrors {
            // χ²/freedom is only used where it widens, which makes z smaller.
            assert!((chi2 / runs - 5.0).abs() < 3.0 * (10.0 / runs).sqrt());
            for e in [0, 1, 2, 4, 5, 8, 9, 10, 11] {
                assert!((0.5..1.24).contains(&mean[e]), "{e}: {mean:?}");
            }
        } else {
            // Student's t of 5 degrees of freedom: its mean square is 5/3, which
            // scatters by √(22/300) = 0.27.
            for e in [0, 1, 2, 4, 5, 8, 9, 10, 11] {
                assert!((0.9..2.5).contains(&mean[e]), "{e}: {mean:?}");
            }
        }
    }
}

#[test]
fn what_is_missing_is_said() {
    let said = |poses: Vec<[f64; 3]>, kind| {
        let readings: Vec<Reading> = poses.into_iter().map(|n| reading(unit(n))).collect();
        let error = magnitude(&readings, &options(kind)).unwrap_err();
        assert_eq!(error.code(), "underdetermined");
        (
            error.message().to_owned(),
            error.hint().unwrap_or("").to_owned(),
        )
    };
    // Turned about z only.
    let flat = (0..7).map(|k| [f64::from(k).cos(), f64::from(k).sin(), 0.0]);
    let (what, hint) = said(flat.collect(), Kind::Nine);
    assert_eq!(
        what,
        "7 poses span 2 of 3 directions and determine 5 of the 9 parameters"
    );
    assert!(hint.contains("record it with"), "{hint}");
    println!("{what}; {hint}");
    // Six sides say nothing of the angles between axes: edges do.
    let faces = crate::segment::face::Face::all().map(crate::segment::face::Face::direction);
    let doubled: Vec<_> = faces.iter().chain(&faces).copied().collect();
    let (what, hint) = said(doubled, Kind::Nine);
    assert!(
        what.starts_with("12 poses span 3 of 3 directions"),
        "{what}"
    );
    assert_eq!(hint.matches("leaned 45°").count(), 3, "{hint}");
    println!("{what}; {hint}");
    // Five of six sides.
    let (what, hint) = said(faces[..5].to_vec(), Kind::Six);
    assert!(what.ends_with("determine 5 of the 6 parameters"), "{what}");
    assert!(hint.ends_with("record it with z down"), "{hint}");
    println!("{what}; {hint}");
    assert!(magnitude(&[], &options(Kind::Six)).is_err());
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
            let mut r = reading(unit([angle.cos(), angle.sin(), z]));
            for i in 0..3 {
                r.mean[i] += 32.0 * rng.sample::<f64, _>(StandardNormal);
            }
            r.standard_error = Some([32.0; 3]);
            r
        })
        .collect();
    let error = magnitude(&readings, &options(Kind::Nine)).unwrap_err();
    assert_eq!(error.code(), "underdetermined", "{error}");
    println!("{error}; {:?}", error.hint());
}

#[test]
fn errors_on_poses_that_were_left_out() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let s = [4.0; 3];
    let readings = noisy(&mut rng, 40, s);
    let errors = leave_out(&readings, &options(Kind::Nine), NEIGHBOUR_DEG).unwrap();
    let (rms, count) = errors.rms_mps2().unwrap();
    // About the noise of a mean, a little more for the parameters.
    let noise = 4.0 / 1660.0;
    assert_eq!(count, 40);
    assert!((0.9..1.6).contains(&(rms / noise)), "{}", rms / noise);
    // The diagonal model misses the angles: 31/1690 of gravity and less.
    let six = leave_out(&readings, &options(Kind::Six), NEIGHBOUR_DEG).unwrap();
    assert!(six.rms_mps2().unwrap().0 > 10.0 * rms);
}

#[test]
fn derivatives_equal_differences() {
    let state = State {
        a: matrix3::inverse(&M).unwrap(),
        b: B,
    };
    for kind in [Kind::Nine, Kind::Six] {
        let model = Model {
            readings: vec![reading(unit([0.3, -0.5, 0.7])).mean],
            sd: vec![0.01],
            gravity: G,
            kind,
        };
        let exact = model.row(&state, model.readings[0]);
        for column in 0..model.shared() {
            let size = if model.elements()[column] < 9 {
                1e-9
            } else {
                1e-3
            };
            let value = |sign: f64| {
                let mut step = vec![0.0; model.shared()];
                step[column] = sign * size;
                let mut r = [0.0];
                model.evaluate(&model.moved(&state, &step, &[]), 0, &mut r, None);
                r[0]
            };
            let difference = 0.01 * (value(1.0) - value(-1.0)) / (2.0 * size);
            let tolerance = 1e-5 * exact[column].abs().max(1e-9);
            assert!((difference - exact[column]).abs() < tolerance, "{column}");
        }
    }
}

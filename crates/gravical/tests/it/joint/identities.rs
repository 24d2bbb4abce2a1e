//! What the joint fit has in common with other methods, to the digit.

use super::*;

/// Largest difference, over standard deviations.
fn apart(a: &[[f64; 3]; 3], b: &[[f64; 3]; 3], sd: f64) -> f64 {
    (0..9)
        .map(|e| (a[e / 3][e % 3] - b[e / 3][e % 3]).abs() / sd)
        .fold(0.0, f64::max)
}

fn free(means: &[MeanReading]) -> Vec<JointPose> {
    let free = |pose| JointPose {
        role: Role::Free,
        ..pose
    };
    poses(means, true).into_iter().map(free).collect()
}

fn assuming(elements: Elements) -> JointOptions {
    JointOptions {
        prior: false,
        elements: Some(elements),
        find_bad: false,
        ..options(Some(0.0))
    }
}

#[test]
fn without_tilt_it_is_linear_least_squares() {
    for index in 0..10 {
        let mut part = Part::draw(&parts(0.0), 12, index);
        let means = part.place(&each_face(2));
        let fit = joint(&poses(&means, true), &assuming(Elements::All)).unwrap();
        // An exact face is one of 1e-7 rad, 1e-3 of a standard deviation.
        assert!((fit.freedom - 24.0).abs() < 1e-4, "{}", fit.freedom);
        // Pairs of faces: b is the mean of all, a column half of the difference over g. An
        // element's standard deviation is 1.24e-3/(2 g) = 6e-5.
        let mean = |of: &dyn Fn(&MeanReading) -> bool, i: usize| {
            let some: Vec<f64> = means.iter().filter(|m| of(m)).map(|m| m.mean[i]).collect();
            some.iter().sum::<f64>() / some.len() as f64
        };
        for i in 0..3 {
            assert!((fit.bias[i] - mean(&|_| true, i)).abs() < 1e-6, "{index}");
            for axis in 0..3 {
                let on = |up| move |m: &MeanReading| m.face == Some(Face { axis, up });
                let column = (mean(&on(true), i) - mean(&on(false), i)) / (2.0 * G);
                assert!((fit.model[i][axis] - column).abs() < 6e-8, "{index}");
            }
        }
    }
}

#[test]
fn faces_that_are_said_to_be_exact_are_fitted_however_they_lie() {
    for index in 0..20 {
        let mut part = Part::draw(&parts(3.0), 12, index);
        let means = part.place(&Planned::six_faces());
        let fit = joint(&poses(&means, true), &assuming(Elements::All)).unwrap();
        assert!((fit.freedom - 6.0).abs() < 1e-4, "{}", fit.freedom);
    }
}

#[test]
fn with_any_tilt_it_is_the_magnitude_alone() {
    let flat = JointOptions {
        prior: false,
        find_bad: false,
        ..options(Some(57.0))
    };
    let gram = |m: &[[f64; 3]; 3]| matrix3::mul(m, &matrix3::transpose(m));
    for index in 0..10 {
        let mut part = Part::draw(&parts(1.0), 12, index);
        let mut means = part.place(&faces_and(Planned::spread(9, 4)));
        // Lengths count alike in m/s² and poses by their readings: the same where these
        // are calibrated.
        let first = joint(&free(&means), &assuming(Elements::Triangular)).unwrap();
        let matrix = matrix3::inverse(&first.model).unwrap();
        means
            .iter_mut()
            .for_each(|m| m.mean = matrix3::mul_vec(&matrix, &matrix3::sub(&m.mean, &first.bias)));
        let by_length = joint(&free(&means), &assuming(Elements::Triangular)).unwrap();
        let fit = joint(&poses(&means, true), &flat).unwrap();
        // Standard deviations are above 1e-4 and 5e-4.
        let off = apart(&gram(&fit.model), &gram(&by_length.model), 1e-4);
        assert!(off < 0.05, "{index}: {off}");
        for i in 0..3 {
            let off = (fit.bias[i] - by_length.bias[i]).abs() / 5e-4;
            assert!(off < 0.05, "{index}: {off}");
        }
    }
}

/// An analog sensor whose zero is not subtracted reads gravity about a centre of several g.
#[test]
fn a_bias_of_several_g_moves_with_its_readings() {
    for elements in [Elements::Triangular, Elements::Diagonal] {
        for index in 0..10 {
            let mut part = Part::draw(&parts(1.0), 12, index);
            let mut means = part.place(&faces_and(Planned::spread(9, 4)));
            let near = joint(&free(&means), &assuming(elements)).unwrap();
            means.iter_mut().for_each(|m| m.mean[0] += 50.0);
            let far = joint(&free(&means), &assuming(elements)).unwrap();
            let moved = far.bias[0] - near.bias[0];
            assert!((moved - 50.0).abs() < 1e-4, "{elements:?} {index}: {moved}");
        }
    }
}

#[test]
fn six_faces_without_a_prior_are_ferraris() {
    let flat = JointOptions {
        prior: false,
        ..options(Some(0.1))
    };
    for index in 0..10 {
        let mut part = Part::draw(&parts(0.1), 12, index);
        let means = part.place(&Planned::six_faces());
        let fit = joint(&poses(&means, true), &flat).unwrap();
        let side = |up: bool| std::array::from_fn(|axis| means[2 * axis + usize::from(!up)].mean);
        let six = SixPositionMeans {
            plus: side(true),
            minus: side(false),
        };
        let closed = ferraris_accelerometer(&six, G).unwrap();
        let model = closed.model();
        for e in 0..9 {
            let sd = fit.covariance[e][e].sqrt();
            let off = (fit.model[e / 3][e % 3] - model[e / 3][e % 3]).abs() / sd;
            // The square of a tilt, (0.1°)² of 1, is a twentieth of it: the mean
            // of the posterior lies so much higher.
            assert!(off < 0.2, "{index}: element {e}, {off}");
        }
    }
}

#[test]
fn a_pose_left_out_has_the_error_of_a_fit_without_it() {
    for index in 0..5 {
        let mut part = Part::draw(&parts(1.0), 13, index);
        let means = part.place(&faces_and(Planned::spread(8, 5)));
        let all = poses(&means, true);
        let fit = joint(&all, &options(Some(1.0))).unwrap();
        let mut seen = 0;
        for (k, pose) in fit.poses.iter().enumerate() {
            let Some(error) = pose.left_out_error else {
                continue;
            };
            let rest: Vec<JointPose> = (0..all.len())
                .filter(|&j| angle_deg(fit.poses[j].direction, pose.direction) > 25.0)
                .map(|j| all[j])
                .collect();
            let Ok(without) = joint(&rest, &options(Some(1.0))) else {
                continue;
            };
            let inverse = matrix3::inverse(&without.model).unwrap();
            let force = matrix3::mul_vec(&inverse, &matrix3::sub(&all[k].mean, &without.bias));
            let expected = matrix3::norm(&force) - G;
            // The fit without it finds a model error of its own.
            assert!(
                (error - expected).abs() < 0.1 * expected.abs() + 3e-4,
                "{index} {k}: {error} {expected}"
            );
            seen += 1;
        }
        assert!(seen >= 8, "{seen}");
    }
}

#[test]
fn poses_that_say_nothing_are_refused() {
    let mut part = Part::draw(&parts(1.0), 14, 0);
    let means = part.place(&Planned::lattice(4));
    let found = joint(&poses(&means, true), &options(None));
    assert!(
        matches!(found, Err(JointError::Undetermined { .. })),
        "{found:?}"
    );
    assert_eq!(joint(&[], &options(None)).unwrap_err(), JointError::NoPoses);
    let one_face = vec![poses(&part.place(&Planned::six_faces()[..1]), true)[0]; 8];
    let found = joint(&one_face, &options(None));
    assert!(
        matches!(found, Err(JointError::Undetermined { .. })),
        "{found:?}"
    );
}

#[test]
fn six_magnitudes_are_fitted_exactly() {
    // Nothing is left over, and the search has to know that it is done.
    for index in 0..100 {
        let mut part = Part::draw(&parts(0.1), 15, index);
        let means = part.place(&Planned::six_faces());
        let fit = joint(&free(&means), &assuming(Elements::Diagonal)).unwrap();
        let matrix = matrix3::inverse(&fit.model).unwrap();
        let off = means.iter().map(|m| {
            let force = matrix3::mul_vec(&matrix, &matrix3::sub(&m.mean, &fit.bias));
            matrix3::norm(&force) - G
        });
        let worst = off.fold(0.0_f64, |worst, off| worst.max(off.abs()));
        assert!(worst < 1e-9, "{index}: {worst}");
    }
}

//! What must not matter to the fit, and what must not break it.

use gravical_fit::{Fit, Hint, Options, Pose, fit};
use nalgebra::Vector3;
use proptest::prelude::*;

use crate::sessions::{G, Plan, Session};

fn options(nominal: f64) -> Options {
    Options {
        gravity: G,
        nominal: Some(nominal),
        ..Options::default()
    }
}

fn session(seed: u64) -> Vec<Pose> {
    let mut session = Session::new(seed);
    let directions = session.directions(Plan::Spread(6));
    directions
        .iter()
        .map(|n| session.pose(n, Vector3::zeros()))
        .collect()
}

/// Differences of M and b over their standard deviations, the largest.
fn apart(a: &Fit, model: &[[f64; 3]; 3], bias: &[f64; 3]) -> f64 {
    let covariance = a.covariance();
    let own = a.model().concat().into_iter().chain(a.bias());
    let others = model.concat().into_iter().chain(*bias);
    let differences = own.zip(others).enumerate();
    let scores = differences.map(|(e, (own, other))| (own - other).abs() / covariance[e][e].sqrt());
    scores.fold(0.0, f64::max)
}

fn turned(rows: [(usize, f64); 3], v: [f64; 3]) -> [f64; 3] {
    rows.map(|(axis, sign)| sign * v[axis])
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    // Tilt and model error are searched for to a percent: a twentieth of a standard deviation is the
    // same.
    #[test]
    fn order_and_unit_do_not_matter(seed in 0_u64..1000, by in 1_usize..12, unit in 0_usize..3) {
        let mut poses = session(seed);
        let one = fit(&poses, &options(1.0)).unwrap();
        let scale = [16384.0 / G, 1.0 / G, 1000.0 / G][unit];
        for pose in &mut poses {
            pose.mean = pose.mean.map(|v| v * scale);
            pose.sd = pose.sd.map(|v| v * scale);
        }
        let other = fit(&poses, &options(scale)).unwrap();
        let model = other.model().map(|row| row.map(|v| v / scale));
        prop_assert!(apart(&one, &model, &other.bias().map(|v| v / scale)) < 0.05);
        prop_assert!((other.tilt() / one.tilt() - 1.0).abs() < 0.03);
        poses.rotate_left(by);
        poses.swap(0, 5);
        let again = fit(&poses, &options(scale)).unwrap();
        prop_assert!(apart(&other, &again.model(), &again.bias()) < 0.05);
    }

    #[test]
    fn the_way_the_board_sits_does_not_matter(
        seed in 0_u64..1000,
        rows in prop::sample::select(vec![
            [(1, 1.0), (0, -1.0), (2, 1.0)],
            [(0, -1.0), (1, -1.0), (2, 1.0)],
            [(2, 1.0), (0, 1.0), (1, 1.0)],
        ]),
        free in any::<bool>(),
    ) {
        // Channels in another order and with other signs, of a case that is the same.
        let mut poses = session(seed);
        if free {
            poses.iter_mut().for_each(|p| p.hint = Hint::Free);
        }
        let one = fit(&poses, &options(1.0)).unwrap();
        let seen: Vec<Pose> = poses
            .iter()
            .map(|p| Pose { mean: turned(rows, p.mean), ..p.clone() })
            .collect();
        let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let start = rows.map(|(axis, sign): (usize, f64)| identity[axis].map(|v| sign * v));
        let other = fit(&seen, &Options { start: Some(start), ..options(1.0) }).unwrap();
        let model = rows.map(|(axis, sign)| one.model()[axis].map(|v| sign * v));
        if free {
            // The frame is a convention in the order of the channels.
            let predicted = |fit: &Fit| fit.sensor(1.0).predicted_mps2();
            prop_assert!((predicted(&one) / predicted(&other) - 1.0).abs() < 0.05);
        } else {
            prop_assert!(apart(&other, &model, &turned(rows, one.bias())) < 0.05);
        }
    }

    #[test]
    fn whatever_is_read_is_refused_or_answered(
        numbers in prop::collection::vec(
            prop_oneof![
                8 => -20.0..20.0_f64,
                1 => Just(0.0),
                1 => -1e12..1e12_f64,
                1 => Just(9.80665),
                1 => Just(f64::MAX),
                1 => Just(f64::NAN),
            ],
            0..60,
        ),
        noise in prop_oneof![Just(0.0), Just(1e-300), 1e-6..1.0_f64, Just(1e300)],
        prior in any::<bool>(),
    ) {
        let poses: Vec<Pose> = numbers
            .chunks_exact(3)
            .map(|m| Pose {
                mean: [m[0], m[1], m[2]],
                sd: [noise; 3],
                temperature_c: None,
                hint: Hint::Open,
            })
            .collect();
        if let Ok(found) = fit(&poses, &Options { prior, ..options(1.0) }) {
            prop_assert!(found.model().iter().flatten().all(|v| v.is_finite()));
            prop_assert!(found.bias().iter().all(|v| v.is_finite()));
            prop_assert!(found.covariance().iter().flatten().all(|v| v.is_finite()));
            let _ = found.trust().grade();
        }
    }
}

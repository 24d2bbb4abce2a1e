//! What must not matter to the joint fit, and what must not break it.

use proptest::prelude::*;

use crate::means::{MeansOptions, Part, Planned};
use gravical::estimate::joint::{JointFit, JointOptions, JointPose, Role, joint};
use gravical::segment::face::AxisMap;

const G: f64 = 9.80665;

fn options(nominal: f64) -> JointOptions {
    JointOptions {
        gravity: G,
        nominal: Some(nominal),
        prior: true,
        tilt: None,
        ..JointOptions::default()
    }
}

fn session(seed: u64) -> Vec<JointPose> {
    let parts = MeansOptions::default();
    let mut part = Part::draw(&parts, seed, 0);
    let mut planned = Planned::six_faces();
    planned.extend(Planned::spread(6, seed));
    part.place(&planned)
        .iter()
        .map(|m| JointPose {
            mean: m.mean,
            standard_error: [parts.noise_mps2; 3],
            role: Role::Open,
            temperature_c: None,
        })
        .collect()
}

/// Differences of M and b over their standard deviations, the largest.
fn apart(a: &JointFit, model: &[[f64; 3]; 3], bias: &[f64; 3]) -> f64 {
    let mut worst = 0.0_f64;
    for e in 0..12 {
        let (x, y) = if e < 9 {
            (a.model[e / 3][e % 3], model[e / 3][e % 3])
        } else {
            (a.bias[e - 9], bias[e - 9])
        };
        worst = worst.max((x - y).abs() / a.covariance[e][e].sqrt());
    }
    worst
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    // Tilt and model error are searched for to a thousandth: a hundredth of a
    // standard deviation is the same.
    #[test]
    fn order_does_not_matter(seed in 0_u64..1000, turn in 1_usize..12) {
        let mut poses = session(seed);
        let one = joint(&poses, &options(1.0)).unwrap();
        poses.rotate_left(turn);
        poses.swap(0, 5);
        let other = joint(&poses, &options(1.0)).unwrap();
        prop_assert!(apart(&one, &other.model, &other.bias) < 0.01);
    }

    #[test]
    fn the_unit_does_not_matter(seed in 0_u64..1000, counts in 0_usize..3) {
        let scale = [16384.0 / G, 1.0 / G, 1000.0 / G][counts];
        let poses = session(seed);
        let one = joint(&poses, &options(1.0)).unwrap();
        let scaled: Vec<JointPose> = poses
            .iter()
            .map(|p| JointPose {
                mean: p.mean.map(|v| v * scale),
                standard_error: p.standard_error.map(|v| v * scale),
                role: p.role,
                temperature_c: None,
            })
            .collect();
        let other = joint(&scaled, &options(scale)).unwrap();
        let model = other.model.map(|row| row.map(|v| v / scale));
        prop_assert!(apart(&one, &model, &other.bias.map(|v| v / scale)) < 0.01);
        prop_assert!((other.tilt / one.tilt - 1.0).abs() < 0.01);
    }

    #[test]
    fn the_way_the_board_sits_does_not_matter(
        seed in 0_u64..1000,
        axes in prop::sample::select(vec!["y,-x,z", "-x,-y,z", "z,x,y", "x,-z,y"]),
    ) {
        let axes: AxisMap = axes.parse().unwrap();
        let poses = session(seed);
        let one = joint(&poses, &options(1.0)).unwrap();
        let seen: Vec<JointPose> = poses
            .iter()
            .map(|p| JointPose { mean: axes.to_case(p.mean), ..*p })
            .collect();
        let other = joint(&seen, &options(1.0)).unwrap();
        // Rows and columns of M both turn.
        let model = axes.rows_to_case(&one.model).map(|row| axes.to_case(row));
        prop_assert!(apart(&other, &model, &axes.to_case(one.bias)) < 0.01);
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
        let poses: Vec<JointPose> = numbers
            .chunks_exact(3)
            .map(|m| JointPose {
                mean: [m[0], m[1], m[2]],
                standard_error: [noise; 3],
                role: Role::Open,
                temperature_c: None,
            })
            .collect();
        if let Ok(fit) = joint(&poses, &JointOptions { prior, ..options(1.0) }) {
            prop_assert!(fit.model.iter().flatten().all(|v| v.is_finite()));
            prop_assert!(fit.bias.iter().all(|v| v.is_finite()));
            prop_assert!(fit.covariance.iter().flatten().all(|v| v.is_finite()));
        }
    }
}

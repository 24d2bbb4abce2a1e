use std::format;
use std::string::ToString;

use proptest::prelude::*;

use super::*;

/// The report's six mean readings in m/s², rounded to 0.01 as printed.
const REPORT: SixPositionMeans<f64> = SixPositionMeans {
    plus: [
        [10.20, -0.04, -0.10],
        [0.29, 9.73, 0.49],
        [0.83, -0.18, 10.42],
    ],
    minus: [
        [-9.43, -0.27, 0.92],
        [0.46, -9.99, 0.39],
        [-0.05, -0.08, -9.54],
    ],
};

/// A sensor of a few per cent of scale error and up to 3° of misalignment.
pub(super) const MODEL: [[f64; 3]; 3] = [
    [1.02, 0.013, -0.021],
    [-0.008, 0.97, 0.034],
    [-0.052, 0.005, 1.01],
];

/// What a sensor with u = M a + b reads in six perfect placements.
pub(super) fn placements(
    model: [[f64; 3]; 3],
    bias: [f64; 3],
    gravity: f64,
) -> SixPositionMeans<f64> {
    let hold = |axis: usize, g: f64| from_fn(|r| bias[r] + model[r][axis] * g);
    SixPositionMeans {
        plus: from_fn(|axis| hold(axis, gravity)),
        minus: from_fn(|axis| hold(axis, -gravity)),
    }
}

pub(super) fn assert_close(got: &[[f64; 3]; 3], expected: &[[f64; 3]; 3], tolerance: f64) {
    for (g, e) in got.iter().flatten().zip(expected.iter().flatten()) {
        assert!((g - e).abs() <= tolerance, "{got:?} for {expected:?}");
    }
}

fn narrow(means: &SixPositionMeans<f64>) -> SixPositionMeans<f32> {
    SixPositionMeans {
        plus: means.plus.map(|row| row.map(|x| x as f32)),
        minus: means.minus.map(|row| row.map(|x| x as f32)),
    }
}

fn all_close(got: [f64; 3], expected: [f64; 3], tolerance: f64) {
    for (g, e) in got.iter().zip(expected) {
        assert!((g - e).abs() <= tolerance, "{got:?} for {expected:?}");
    }
}

#[test]
fn simulated_parameters_come_back() {
    let (bias, g) = ([0.385, -0.13, 0.44], 9.793);
    let means = placements(MODEL, bias, g);
    let double = ferraris_accelerometer(&means, g).unwrap();
    assert_close(&double.model(), &MODEL, 1e-12);
    all_close(double.bias, bias, 1e-12);

    let single = ferraris_accelerometer(&narrow(&means), g as f32).unwrap();
    assert_close(&single.model().map(|row| row.map(f64::from)), &MODEL, 1e-5);
    all_close(single.bias.map(f64::from), bias, 1e-5);

    let accel = [3.0, -4.0, 9.0];
    let raw = from_fn(|r| bias[r] + matrix3::dot(&MODEL[r], &accel));
    let back = double.calibration().unwrap().apply(raw);
    all_close(back, accel, 1e-12);
    let back = single.calibration().unwrap().apply(raw.map(|x| x as f32));
    all_close(back.map(f64::from), accel, 1e-5 * 9.0);
}

#[test]
fn what_is_wrong_is_named() {
    let run = |means: &SixPositionMeans<f64>, g| ferraris_accelerometer(means, g).unwrap_err();
    let mut broken = REPORT;
    broken.minus[1][2] = f64::NAN;
    let input = "mean readings of the accelerometer";
    assert_eq!(run(&broken, 9.81), SixPositionError::NotFinite { input });
    for g in [f64::NAN, f64::INFINITY] {
        let input = "gravity";
        assert_eq!(run(&REPORT, g), SixPositionError::NotFinite { input });
    }
    for g in [0.0, -9.81] {
        assert_eq!(run(&REPORT, g), SixPositionError::GravityNotPositive);
    }

    // A frozen channel, once exactly and once as sums round it.
    for step in [0.0, 1e-14] {
        let mut frozen = REPORT;
        for axis in 0..3 {
            frozen.plus[axis][1] = 9.7 + step;
            frozen.minus[axis][1] = 9.7;
        }
        let error = run(&frozen, 9.81);
        assert_eq!(error, SixPositionError::VanishedRow { channel: 1 });
        let text = "channel y reads the same in opposite positions";
        assert_eq!(error.to_string(), text);
    }

    // The z channel is wired to x.
    let mut doubled = REPORT;
    for axis in 0..3 {
        doubled.plus[axis][2] = doubled.plus[axis][0];
        doubled.minus[axis][2] = doubled.minus[axis][0];
    }
    assert_eq!(run(&doubled, 9.81), SixPositionError::Singular);
    assert!(format!("{}", SixPositionError::Singular).contains("three directions"));
}

/// Sensors with up to 10 % of scale error and about 6° of misalignment.
fn sensor() -> impl Strategy<Value = SixPositionMeans<f64>> {
    let element = || prop::array::uniform3(-0.1..0.1);
    let tilted = prop::array::uniform3(prop::array::uniform3(-0.02..0.02));
    (prop::array::uniform3(element()), element(), tilted).prop_map(|(mut model, bias, noise)| {
        for (i, row) in model.iter_mut().enumerate() {
            row[i] += 1.0;
        }
        let mut means = placements(model, bias, 9.81);
        for (hold, noise) in means.plus.iter_mut().zip(noise) {
            *hold = from_fn(|r| hold[r] + noise[r]);
        }
        means
    })
}

proptest! {
    /// Axes renamed in the placements and the channels alike rename the result.
    #[test]
    fn ferraris_does_not_care_for_names(
        means in sensor(),
        order in Just([0_usize, 1, 2]).prop_shuffle(),
    ) {
        let rename = |m: &[[f64; 3]; 3]| -> [[f64; 3]; 3] {
            from_fn(|i| from_fn(|r| m[order[i]][order[r]]))
        };
        let renamed = SixPositionMeans {
            plus: rename(&means.plus),
            minus: rename(&means.minus),
        };
        let original = ferraris_accelerometer(&means, 9.81).unwrap();
        let got = ferraris_accelerometer(&renamed, 9.81).unwrap();
        // Sums in another order: a few roundings of numbers near 1.
        all_close(got.scale, order.map(|i| original.scale[i]), 1e-14);
        all_close(got.bias, order.map(|i| original.bias[i]), 0.0);
        assert_close(&got.orientation, &rename(&original.orientation), 1e-14);
    }

    /// Another unit multiplies K and b and leaves R alone.
    #[test]
    fn a_unit_is_a_factor(means in sensor(), factor in 1e-3..1e4) {
        let times = |m: &[[f64; 3]; 3]| m.map(|row| row.map(|x| x * factor));
        let other = SixPositionMeans {
            plus: times(&means.plus),
            minus: times(&means.minus),
        };
        let original = ferraris_accelerometer(&means, 9.81).unwrap();
        let got = ferraris_accelerometer(&other, 9.81).unwrap();
        let tolerance = 1e-13 * factor;
        all_close(got.scale, original.scale.map(|k| k * factor), tolerance);
        all_close(got.bias, original.bias.map(|b| b * factor), tolerance);
        assert_close(&got.orientation, &original.orientation, 1e-13);
    }

}

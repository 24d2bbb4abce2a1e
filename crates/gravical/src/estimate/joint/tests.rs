use super::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

const G: f64 = 9.80665;

struct Sensor {
    m: [[f64; 3]; 3],
    b: [f64; 3],
}

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    rng.sample::<f64, _>(StandardNormal)
}

/// Scale sd 2 %, misalignment 1°, bias ±0.5 m/s².
fn sensor(rng: &mut ChaCha8Rng) -> Sensor {
    let mut m = [[0.0; 3]; 3];
    for i in 0..3 {
        let k = 1.0 + 0.02 * normal(rng);
        for j in 0..3 {
            let r = if i == j {
                1.0
            } else {
                normal(rng).to_radians()
            };
            m[i][j] = k * r;
        }
    }
    Sensor {
        m,
        b: std::array::from_fn(|_| rng.random::<f64>() - 0.5),
    }
}

impl Sensor {
    fn read(&self, n: [f64; 3], noise: f64, rng: &mut ChaCha8Rng) -> [f64; 3] {
        std::array::from_fn(|i| G * matrix3::dot(&self.m[i], &n) + self.b[i] + noise * normal(rng))
    }
}

fn free(rng: &mut ChaCha8Rng) -> [f64; 3] {
    matrix3::unit(&std::array::from_fn(|_| normal(rng)))
}

fn session(sensor: &Sensor, frees: usize, tilt: f64, rng: &mut ChaCha8Rng) -> Vec<JointPose> {
    let noise = 1.24e-3;
    let mut out: Vec<JointPose> = Face::all()
        .into_iter()
        .map(|face| {
            let d = [tilt * normal(rng), tilt * normal(rng)];
            JointPose {
                mean: sensor.read(model::tilted(face, d).0, noise, rng),
                standard_error: [noise; 3],
                role: Role::Face(face),
                temperature_c: None,
            }
        })
        .collect();
    for _ in 0..frees {
        out.push(JointPose {
            mean: sensor.read(free(rng), noise, rng),
            standard_error: [noise; 3],
            role: Role::Open,
            temperature_c: None,
        });
    }
    out
}

const OPTIONS: JointOptions = JointOptions {
    gravity: G,
    nominal: Some(1.0),
    prior: true,
    tilt: None,
    quantisation: [0.0; 3],
    start: None,
    elements: None,
    find_bad: true,
    drift: false,
};

/// 160 poses, nobody placed, between 20 and 33 °C in the order of time.
fn wear(sensor: &Sensor, drift: [f64; 3], rng: &mut ChaCha8Rng) -> Vec<JointPose> {
    (0..160)
        .map(|k| {
            let t = 26.5 + 6.5 * (f64::from(k) / 9.0).sin();
            let mean = sensor.read(free(rng), 5e-3, rng);
            JointPose {
                mean: std::array::from_fn(|i| mean[i] + drift[i] * (t - 26.5)),
                standard_error: [5e-3; 3],
                role: Role::Free,
                temperature_c: Some(t),
            }
        })
        .collect()
}

#[test]
fn a_drift_is_found_where_there_is_one() {
    let mut rng = ChaCha8Rng::seed_from_u64(21);
    let (mut found, mut inside, mut all) = (0, 0, 0);
    for run in 0..40 {
        let sensor = sensor(&mut rng);
        let drift = match run % 2 {
            0 => [0.0; 3],
            _ => std::array::from_fn(|_| 0.01 * normal(&mut rng)),
        };
        let poses = wear(&sensor, drift, &mut rng);
        let test = test_drift(&poses, &OPTIONS).unwrap();
        if run % 2 == 0 {
            found += i32::from(test.helps);
            continue;
        }
        assert!(test.helps && test.with_mps2 < test.without_mps2, "{test:?}");
        let with = JointOptions {
            drift: true,
            ..OPTIONS
        };
        let fit = joint(&poses, &with).unwrap();
        let fitted = fit.drift.unwrap();
        assert!((fitted.reference_c - 26.5).abs() < 0.5);
        for i in 0..3 {
            all += 1;
            inside += i32::from((fitted.per_c[i] - drift[i]).abs() < NORMAL_95 * fitted.sd[i]);
        }
        // M and b hold at the reference, where the drift is not zero.
        let at = Sensor {
            m: sensor.m,
            b: std::array::from_fn(|i| sensor.b[i] + drift[i] * (fitted.reference_c - 26.5)),
        };
        let (good, bad) = (
            norm_error(&at, &fit),
            norm_error(&at, &joint(&poses, &OPTIONS).unwrap()),
        );
        assert!(good < 0.25 && good < bad + 0.02, "{good} {bad}");
    }
    assert!(found <= 4, "a drift in {found} of 20 without one");
    // 60 intervals of 95 %: fewer than 52 inside has a chance of 0.5 %.
    assert!(inside >= 52, "{inside} of {all}");
}

#[test]
fn without_a_drift_the_temperature_changes_nothing() {
    let mut rng = ChaCha8Rng::seed_from_u64(22);
    let sensor = sensor(&mut rng);
    let poses = wear(&sensor, [0.01, 0.0, -0.01], &mut rng);
    let cold: Vec<JointPose> = poses
        .iter()
        .map(|p| JointPose {
            temperature_c: None,
            ..*p
        })
        .collect();
    let [a, b] = [&poses, &cold].map(|poses| joint(poses, &OPTIONS).unwrap());
    assert_eq!(
        (a.model, a.bias, a.covariance),
        (b.model, b.bias, b.covariance)
    );
}

/// RMS over the sphere of ‖a‖ − g, mg.
fn norm_error(sensor: &Sensor, found: &JointFit) -> f64 {
    let inverse = matrix3::inverse(&found.model).unwrap();
    let squares: f64 = predicted::sphere(200)
        .map(|n| {
            let u: [f64; 3] =
                std::array::from_fn(|i| G * matrix3::dot(&sensor.m[i], &n) + sensor.b[i]);
            let a = matrix3::mul_vec(&inverse, &matrix3::sub(&u, &found.bias));
            (matrix3::norm(&a) - G).powi(2)
        })
        .sum();
    (squares / 200.0).sqrt() / G * 1000.0
}

#[test]
fn faces_and_free_poses_give_the_magnitude() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    for _ in 0..20 {
        let sensor = sensor(&mut rng);
        let poses = session(&sensor, 12, 1.0_f64.to_radians(), &mut rng);
        let found = joint(&poses, &OPTIONS).unwrap();
        let error = norm_error(&sensor, &found);
        println!(
            "{error:.3} mg, tilt {:.2}°, gamma {:.1}",
            found.tilt.to_degrees(),
            found.gamma
        );
        assert!(error < 0.6, "{error}");
    }
}

/// Nothing but the poses of these faces tells of +x and −y, and two of each contradict each
/// other.
#[test]
fn each_disputed_direction_has_two_sides_of_its_own() {
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let sensor = sensor(&mut rng);
    let disputed = [(0, true), (1, false)].map(|(axis, up)| Face { axis, up });
    let mut poses = Vec::new();
    let mut expected = Vec::new();
    for face in Face::all() {
        let first = poses.len();
        let pair = disputed.contains(&face);
        for k in 0..if pair { 2 } else { 10 } {
            let d = [0.0, 0.0].map(|_: f64| 0.1_f64.to_radians() * normal(&mut rng));
            let longer = if pair && k == 1 { 1.0 + 0.06 / G } else { 1.0 };
            let n = model::tilted(face, d).0.map(|v| v * longer);
            poses.push(JointPose {
                mean: sensor.read(n, 1.24e-3, &mut rng),
                standard_error: [1.24e-3; 3],
                role: Role::Face(face),
                temperature_c: None,
            });
        }
        if pair {
            expected.push([vec![first], vec![first + 1]]);
        }
    }
    let mut found = joint(&poses, &OPTIONS).unwrap().disputed;
    found.iter_mut().for_each(|sides| sides.sort_unstable());
    found.sort_unstable();
    assert_eq!(found, expected);
}

use rand::{RngExt, SeedableRng};

use super::*;
use crate::calibration_file::ChannelDrift;
use crate::recording::{ReadOptions, read_bytes};

fn seeded_normal(seed: u64) -> impl FnMut() -> f64 {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    move || rng.sample(rand_distr::StandardNormal)
}

/// Rows of `seconds` at 10 Hz: temperature and the six channels from `at`.
fn recorded(seconds: u32, mut at: impl FnMut(f64) -> (f64, [f64; 6])) -> Recording {
    let mut noise = seeded_normal(7);
    let mut csv = String::from(
        "t (s),ax (m/s^2),ay (m/s^2),az (m/s^2),temp (C),gx (rad/s),gy (rad/s),gz (rad/s)\n",
    );
    for i in 0..10 * seconds {
        let t_s = 0.1 * f64::from(i);
        let (t_c, mut v) = at(t_s);
        for (axis, value) in v.iter_mut().enumerate() {
            *value += if axis < 3 { 4e-3 } else { 2e-4 } * noise();
        }
        csv += &format!(
            "{t_s:.1},{:.6},{:.6},{:.6},{t_c:.3},{:.7},{:.7},{:.7}\n",
            v[0], v[1], v[2], v[3], v[4], v[5]
        );
    }
    read_bytes(csv.as_bytes(), "soak.csv", &ReadOptions::default()).unwrap()
}

/// 50 → −10 → 50 °C in 600 s.
fn down_and_up(t_s: f64) -> f64 {
    -10.0 + 0.2 * (t_s - 300.0).abs()
}

fn channel<'a>(model: &'a TemperatureModel, name: &str) -> &'a ChannelDrift {
    model.channel(name).unwrap()
}

fn verdicts(model: &TemperatureModel) -> String {
    let all = model.channels.iter().filter(|c| c.is_corrected());
    all.map(|c| c.channel.as_str())
        .collect::<Vec<_>>()
        .join(" ")
}

#[test]
fn sweeps_that_do_not_predict_each_other_are_refused() {
    let rising = |t: f64| 20.0 + 0.1 * (t - 150.0);
    let falling = |t: f64| 20.0 - 0.1 * (t - 150.0);
    // 50 → 20 °C, then back by 4 °C only.
    let back = |t: f64| 20.0 + 0.1 * (t - 300.0).abs();
    let with_time = "hysteresis or drift with time";
    for (seconds, at, per_c, per_s, words) in [
        (300, &rising as &dyn Fn(f64) -> f64, 2e-3, 0.0, "only rose"),
        (300, &falling, 2e-3, 0.0, "only fell"),
        (340, &back, 2e-3, 0.0, "share only 3."),
        (600, &down_and_up, 0.0, 1e-4, with_time),
    ] {
        let recording = recorded(seconds, |t| {
            let ax = per_c * at(t) + per_s * t;
            (at(t), [ax, 0.0, 9.81, 0.0, 0.0, 0.0])
        });
        let model = study(&[recording]).unwrap();
        assert_eq!(verdicts(&model), "");
        let ax = channel(&model, "ax");
        assert!(ax.reason.contains(words), "{}", ax.reason);
    }
}

#[test]
fn a_tilt_in_the_middle_starts_another_pose() {
    let recording = recorded(600, |t| {
        let t_c = down_and_up(t);
        // Tilted by 1° at 200 s, within half a second.
        let tilt = 0.171 * ((t - 200.0) / 0.5).clamp(0.0, 1.0);
        (t_c, [tilt + 2e-3 * t_c, 0.0, 9.81, 0.0, 0.0, 0.0])
    });
    let model = study(&[recording]).unwrap();
    let ax = channel(&model, "ax");
    assert!(ax.is_corrected(), "{}", ax.reason);
    assert!((ax.per_c.unwrap() / 2e-3 - 1.0).abs() < 0.02);
}

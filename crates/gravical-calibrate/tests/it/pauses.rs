//! Pauses that are not used as poses are reported, and nothing else is.

use gravical_calibrate::calibrate::{CalibrateOptions, calibrate};
use gravical_calibrate::recording::AccelUnit;

use crate::support::{FACES, GRAVITY, Noise, read_options, read_with};

const OBLIQUE: [[f64; 3]; 4] = [
    [0.6, 0.64, 0.48],
    [-0.6, 0.48, 0.64],
    [0.48, -0.64, -0.6],
    [-0.64, -0.6, 0.48],
];

/// Six faces, oblique pauses of so many rows that tremble by so many mg at 5 Hz, and a face; at 100 Hz, or without
/// time stamps. Motions take `motion` rows.
fn session(face: usize, pause: usize, tremor_mg: f64, motion: usize, has_clock: bool) -> String {
    let faces = FACES.iter().map(|(_, up)| (*up, face, 0.0));
    let pauses = OBLIQUE.iter().map(|up| (*up, pause, tremor_mg));
    let pauses = pauses.filter(|_| pause > 0);
    let mut text = if has_clock { "t_ms," } else { "" }.to_owned() + "ax,ay,az\n";
    let (mut noise, mut before, mut row) = (Noise::new(1), FACES[5].1, 0);
    for (up, rows, tremor_mg) in faces.clone().chain(pauses).chain(faces.take(1)) {
        for k in 0..motion + rows {
            let share = ((k + 1) as f64 / (motion + 1) as f64).min(1.0);
            let share = share * share * (3.0 - 2.0 * share);
            // Not through the centre, which lies between opposite faces.
            let bow = [0.9, 0.7, 0.8].map(|v| v * share * (1.0 - share));
            let way = [0, 1, 2].map(|c| before[c] + share * (up[c] - before[c]) + bow[c]);
            let length = way.iter().map(|v| v * v).sum::<f64>().sqrt();
            if has_clock {
                text += &format!("{},", 10 * row);
            }
            let cell = |c: usize| {
                let phase = std::f64::consts::TAU * row as f64 / 20.0 + c as f64;
                let tremor = 1.414e-3 * tremor_mg * phase.sin();
                let force = GRAVITY * (way[c] / length + tremor);
                format!("{:.4}", force + 0.02 * noise.normal())
            };
            text += &([0, 1, 2].map(cell).join(",") + "\n");
            row += 1;
        }
        before = up;
    }
    text
}

#[test]
fn pauses_that_are_not_used_are_reported() {
    let (short, few) = ("a pose at least 1.0 s", "a pose at least 40 rows");
    for (session, poses, says) in [
        (session(300, 35, 0.0, 80, true), 7, Some(short)),
        (session(60, 12, 0.0, 3, false), 7, Some(few)),
        (session(300, 300, 15.0, 80, true), 7, Some("by 15 mg rms")),
        // All of them are used, or there is none between the faces.
        (session(300, 200, 0.0, 80, true), 11, None),
        (session(60, 60, 0.0, 3, false), 11, None),
        (session(300, 0, 0.0, 250, true), 7, None),
    ] {
        let options = read_options(|o| o.accel_unit = Some(AccelUnit::MetrePerSecondSquared));
        let recording = read_with(session.as_bytes(), &options);
        let calibrated = calibrate(&[recording], &CalibrateOptions::default()).unwrap();
        let mut findings = calibrated.calibration.findings;
        findings.retain(|f| f.kind == "unused-pauses");
        let said = |says| format!("{findings:?}").contains(says);
        assert_eq!(findings.len(), usize::from(says.is_some()), "{findings:?}");
        assert!(
            says.is_none_or(|says| said(says) && said("4 directions")),
            "{findings:?}"
        );
        assert_eq!(calibrated.calibration.poses.len(), poses, "{says:?}");
    }
}

//! The unit of a gyroscope that nothing else tells: by its noise at rest.
//!
//! Per sample, gyroscopes that people can afford have 0.02 to 0.5 °/s of noise;
//! read as rad/s that would be 0.0004 to 0.009. Where no turn of gravity decides
//! and no header can be believed, this does.

use std::ops::Range;

use crate::recording::resolution::floors;
use crate::recording::units::{GyroScale, GyroUnit, Origin};
use crate::recording::{Finding, Recording};
use crate::segment::still::moments;

/// Between the noise of a usual gyroscope in rad/s and in °/s: 0.09 °/s is
/// 0.0016 rad/s, and this is their geometric mean.
const BETWEEN: f64 = 0.012;

/// Rows that noise is looked at over.
const BLOCK: usize = 50;

/// Decides by noise where `scale`, found by header or not at all, is doubtful.
pub(super) fn by_noise(
    recording: &Recording,
    stills: &[Range<usize>],
    scale: GyroScale,
    findings: &mut Vec<Finding>,
) -> GyroScale {
    let unverified = findings.iter().any(|f| f.kind == "gyro-unit-unverified");
    let header_lies = recording.findings.iter().any(|f| f.kind == "unit-mismatch");
    let doubtful = match scale.unit {
        GyroUnit::Unknown => true,
        GyroUnit::RadianPerSecond | GyroUnit::DegreePerSecond => {
            scale.origin == Origin::Header && unverified && header_lies
        }
        GyroUnit::Counts => false,
    };
    if !doubtful {
        return scale;
    }
    let Some(noise) = noise(recording, stills) else {
        return scale;
    };
    let unit = if noise < BETWEEN {
        GyroUnit::RadianPerSecond
    } else {
        GyroUnit::DegreePerSecond
    };
    if unit == scale.unit {
        return scale;
    }
    findings.retain(|f| f.kind != "gyro-unit-unverified");
    let why = match scale.unit {
        GyroUnit::Unknown => "nothing states the unit of the gyroscope".to_owned(),
        claimed => format!(
            "the header says {} for the gyroscope, and is wrong about the accelerometer",
            claimed.name()
        ),
    };
    findings.push(Finding::warning(
        "gyro-unit-by-noise",
        format!(
            "{why}; its noise at rest, {noise:.2e}, is that of a gyroscope in {}; taken so (--gyro-unit decides)",
            unit.name()
        ),
    ));
    GyroScale {
        unit,
        lsb_per_deg_s: None,
        origin: Origin::Data,
    }
}

/// Standard deviation of a sample in the quietest quarter of short blocks at
/// rest, mean of the axes, unit of the file; none for whole numbers (counts),
/// without noise, and where rounding may hide the noise of either unit.
fn noise(recording: &Recording, stills: &[Range<usize>]) -> Option<f64> {
    let gyro = recording.gyro.as_ref()?;
    let mut levels: Vec<f64> = stills
        .iter()
        .flat_map(|s| s.clone().step_by(BLOCK).map(|i| i..(i + BLOCK).min(s.end)))
        .filter(|b| b.len() >= 10)
        .map(|b| (moments(gyro, b).1 / 3.0).sqrt())
        .collect();
    let rounding = (floors(&recording.gyro_resolution()) / 3.0).sqrt();
    let whole = stills.iter().flat_map(Clone::clone).take(2000).all(|row| {
        gyro.iter()
            .all(|c| c[row].fract() == 0.0 || c[row].is_nan())
    });
    if whole || levels.is_empty() {
        return None;
    }
    levels.sort_by(f64::total_cmp);
    let level = levels.get(levels.len() / 4).copied()?.max(rounding);
    (level > 0.0 && (level > rounding || rounding < BETWEEN)).then_some(level)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{ReadOptions, read_bytes};

    /// A still recording whose gyroscope has noise of `sigma` around `bias`.
    fn recording(header: &str, sigma: f64, bias: f64) -> Recording {
        let mut text = format!("{header}\n");
        for i in 0..400_u32 {
            let wave = |k: u32| f64::from((i * k) % 7) / 2.0 - 1.5;
            text += &format!(
                "{},{:.3},{:.3},{:.3},{:.5},{:.5},{:.5}\n",
                i * 10,
                0.01 * wave(3),
                0.01 * wave(5),
                9.81 + 0.01 * wave(2),
                bias + sigma * wave(4),
                bias + sigma * wave(3),
                sigma * wave(5)
            );
        }
        read_bytes(text.as_bytes(), "still.csv", &ReadOptions::default()).unwrap()
    }

    fn decided(recording: &Recording) -> (GyroUnit, usize) {
        let mut findings = vec![Finding::note("gyro-unit-unverified", "")];
        let whole = 0..recording.rows();
        let scale = recording.gyro_scale.unwrap();
        let scale = by_noise(
            recording,
            std::slice::from_ref(&whole),
            scale,
            &mut findings,
        );
        let told = findings
            .iter()
            .filter(|f| f.kind == "gyro-unit-by-noise")
            .count();
        (scale.unit, told)
    }

    #[test]
    fn without_a_header_the_noise_tells() {
        let header = "t_ms,ax,ay,az,gx,gy,gz";
        assert_eq!(
            decided(&recording(header, 0.001, 0.01)),
            (GyroUnit::RadianPerSecond, 1)
        );
        assert_eq!(
            decided(&recording(header, 0.06, 1.0)),
            (GyroUnit::DegreePerSecond, 1)
        );
    }

    #[test]
    fn a_header_that_lies_once_is_not_believed_twice() {
        let lies = "Timestamp,aX (g),aY (g),aZ (g),gX (°/s),gY (°/s),gZ (°/s)";
        assert_eq!(
            decided(&recording(lies, 0.001, 0.01)),
            (GyroUnit::RadianPerSecond, 1)
        );
        assert_eq!(
            decided(&recording(lies, 0.06, 1.0)),
            (GyroUnit::DegreePerSecond, 0)
        );
        let honest = "t_ms,ax (m/s^2),ay (m/s^2),az (m/s^2),gx (deg/s),gy (deg/s),gz (deg/s)";
        assert_eq!(
            decided(&recording(honest, 0.001, 0.01)),
            (GyroUnit::DegreePerSecond, 0)
        );
    }
}

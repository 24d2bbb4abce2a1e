//! What a result says, in words.

use std::ops::Range;

use super::series::Counts;
use super::{ChannelNoise, NotObservable, Term};
use crate::finding::{Finding, LineSpans, finding};
use crate::numfmt;
use crate::recording::Recording;
use gravical_core::unit::STANDARD_GRAVITY_MPS2;

/// The density may differ from that of the model by this fraction of its power, and by so many
/// standard deviations.
const DENSITY_TOLERANCE: f64 = 0.15;
const DENSITY_SIGMAS: f64 = 4.0;
/// Noise before rounding below this fraction of the resolution does not average it away
/// ([`gravical_core::rounding`]).
const MIN_OF_RESOLUTION: f64 = 0.34;
/// Fraction of samples that are replaced beyond which it is a finding.
const MAX_FILLED: f64 = 0.05;

/// The unit in which a parameter is printed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// Its name.
    pub name: &'static str,
    /// Printed values per value in SI units.
    pub factor: f64,
    /// The unit in SI.
    pub si: &'static str,
}

impl Unit {
    /// The usual unit of a term, of the gyroscope or of the accelerometer.
    #[must_use]
    pub fn of(term: Term, gyroscope: bool) -> Self {
        let g = STANDARD_GRAVITY_MPS2;
        let degrees = 1_f64.to_degrees();
        let (name, factor, si) = match (gyroscope, term) {
            (false, Term::N) => ("µg/√Hz", 1e6 / g, "m/s²/√Hz"),
            (false, Term::B) => ("mg", 1e3 / g, "m/s²"),
            (false, Term::K) => ("mg/√h", 1e3 / g * 60.0, "m/s²/√s"),
            (true, Term::N) => ("°/√h", degrees * 60.0, "rad/s/√Hz"),
            (true, Term::B) => ("°/h", degrees * 3600.0, "rad/s"),
            (true, Term::K) => ("°/h/√h", degrees * 3600.0 * 60.0, "rad/s/√s"),
        };
        Unit { name, factor, si }
    }
}

/// A duration with two or three digits: `45 s`, `12 min`, `2.5 h`, `3.1 d`.
#[must_use]
pub fn duration_text(seconds: f64) -> String {
    let (value, unit) = match seconds {
        s if s < 120.0 => (s, "s"),
        s if s < 5400.0 => (s / 60.0, "min"),
        s if s < 48.0 * 3600.0 => (s / 3600.0, "h"),
        s => (s / 86400.0, "d"),
    };
    match value {
        v if v < 9.95 => format!("{v:.1} {unit}"),
        v => format!("{v:.0} {unit}"),
    }
}

/// Why a term is not observable.
pub(super) fn not_observable(longest_s: f64, record_s: Option<f64>) -> String {
    let what = format!("not observable in {}", duration_text(longest_s));
    match record_s {
        Some(s) => format!("{what}: record at least {}", duration_text(s)),
        None => format!("{what}, nor in a thousand times that"),
    }
}

/// A channel without a fit.
pub(super) fn nothing_fitted(channel: &mut ChannelNoise, has_changes: bool) {
    let reason = if has_changes {
        "the values change too rarely for any averaging time to show noise"
    } else {
        "the values do not change: the noise is below the resolution"
    };
    all_missing(channel, reason, None);
}

fn all_missing(channel: &mut ChannelNoise, reason: &str, limit_n: Option<f64>) {
    (channel.n, channel.b, channel.k) = (None, None, None);
    (channel.fit, channel.density) = (None, None);
    let missing = |term: Term| NotObservable {
        term: term.symbol().to_owned(),
        reason: reason.to_owned(),
        at_most: limit_n.filter(|_| term == Term::N),
        record_s: None,
    };
    channel.not_observable = Term::ALL.map(missing).into();
}

/// What is odd about a channel whose samples have that resolution and standard deviation. Noise
/// below the resolution is taken out of the result.
pub(super) fn judge(
    channel: &mut ChannelNoise,
    step: f64,
    deviation: f64,
    period_s: f64,
) -> Vec<Finding> {
    let name = channel.channel.clone();
    let before = (deviation * deviation - step * step / 12.0).max(0.0).sqrt();
    let rounding = gravical_core::rounding::floor(step).sqrt();
    if step > 0.0 && before < MIN_OF_RESOLUTION * step {
        let reason = format!(
            "the values change in steps of {step:.2e} {}, which hide the noise",
            numfmt::unit(&channel.unit)
        );
        let most = MIN_OF_RESOLUTION.hypot(rounding / step) * step * period_s.sqrt();
        all_missing(channel, &reason, Some(most));
        return vec![finding!(
            NoiseBelowResolution,
            "{name}: {reason}; only an upper limit of N is known, for noise that no low-pass has reduced"
        )];
    }
    let mut findings = Vec::new();
    let Some(fit) = channel.fit else {
        return findings;
    };
    if let Some(misfit) = fit.misfit {
        findings.push(finding!(
            NoiseMisfit,
            "{name}: at an averaging time of {} the Allan variance is {:.2} times that of the model: vibration or another disturbance adds to the noise",
            duration_text(misfit.tau_s),
            misfit.ratio
        ));
    }
    if let Some(drift_per_s) = fit.drift_per_s {
        let unit = Unit::of(Term::B, channel.is_gyroscope());
        findings.push(finding!(
            NoiseDrift,
            "{name}: the bias drifts steadily by {} {} per hour; B and K are what remains without that line",
            numfmt::digits(unit.factor * 3600.0 * drift_per_s, 2),
            unit.name
        ));
    }
    if let Some(density) = channel.density.filter(|_| channel.n.is_some()) {
        let tolerance = DENSITY_TOLERANCE.max(DENSITY_SIGMAS * density.ratio_sd);
        if (density.ratio - 1.0).abs() > tolerance {
            let [low_hz, high_hz] = density.band_hz;
            findings.push(finding!(
                NoiseDensityDiffers,
                "{name}: between {low_hz:.0} and {high_hz:.0} Hz the power is {:.2} times that of the fitted curve: not white there, by vibration or a low-pass",
                density.ratio
            ));
        }
    }
    findings
}

/// What is odd about the samples that were used.
pub(super) fn of_recording(
    recording: &Recording,
    ranges: &[Range<usize>],
    counts: &Counts,
    period_s: f64,
) -> Vec<Finding> {
    let mut findings = Vec::new();
    let rows = recording.rows();
    let rest: usize = ranges.iter().map(Range::len).sum();
    if (rest as f64) < 0.95 * rows as f64 {
        let mut lines = LineSpans::default();
        for range in ranges {
            let (from, to) = (recording.line(range.start), recording.line(range.end - 1));
            lines.push_range(from, to, range.len() as u64);
        }
        let finding = finding!(
            NoiseFromRests,
            "the sensor moved: {} used, {} of {}",
            match ranges.len() {
                1 => "the longest static interval is".to_owned(),
                n => format!("the {n} longest static intervals are"),
            },
            duration_text(rest as f64 * period_s),
            duration_text(rows as f64 * period_s)
        );
        findings.push(finding.at_lines(&lines));
    }
    let share = counts.filled as f64 / rest.max(1) as f64;
    if share > MAX_FILLED {
        let finding = finding!(
            NoiseSamplesFilled,
            "{} missing samples ({:.1} %) are replaced by samples a moment before them",
            counts.filled,
            100.0 * share
        );
        findings.push(finding.counting(counts.filled));
    }
    findings
}

/// Which channels follow a temperature that moved.
pub(super) fn of_temperature(
    channels: &[ChannelNoise],
    range_c: Option<[f64; 2]>,
) -> Option<Finding> {
    let [low, high] = range_c?;
    let follow = channels.iter().filter_map(|c| {
        let drift = c.temperature?;
        let unit = Unit::of(Term::B, c.is_gyroscope());
        let slope = numfmt::digits(unit.factor * drift.slope_per_c, 2);
        let share = 100.0 * drift.explained;
        Some(format!(
            "{} {slope} {} per °C ({share:.0} %)",
            c.channel, unit.name
        ))
    });
    let follow: Vec<String> = follow.collect();
    (!follow.is_empty()).then(|| {
        finding!(
            NoiseTemperature,
            "the temperature moved by {:.1} °C, and it explains most of the slow changes of {}: what looks like random walk or bias instability there is drift with temperature",
            high - low,
            follow.join(", ")
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations() {
        for (s, text) in [
            (12.34, "12 s"),
            (5.04, "5.0 s"),
            (600.0, "10 min"),
            (7200.0, "2.0 h"),
            (86400.0, "24 h"),
            (604_800.0, "7.0 d"),
        ] {
            assert_eq!(duration_text(s), text);
        }
    }

    #[test]
    fn units_of_data_sheets() {
        // 400 µg/√Hz is 3.92e-3 m/s²/√Hz; 1 °/√h is 2.909e-4 rad/s/√Hz.
        assert!((3.92266e-3 * Unit::of(Term::N, false).factor - 400.0).abs() < 1e-3);
        assert!((2.908_882e-4 * Unit::of(Term::N, true).factor - 1.0).abs() < 1e-6);
        assert!((4.848_137e-6 * Unit::of(Term::B, true).factor - 1.0).abs() < 1e-6);
    }
}

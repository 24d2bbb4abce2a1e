//! What is found in recordings and results.

use gravical_judge::numfmt::{count, digits, duration_text};

#[doc(hidden)]
pub use gravical_calibrate::finding::Case as CalibrationCase;
#[doc(hidden)]
pub use gravical_calibrate::finding::*;
#[doc(inline)]
pub use gravical_calibrate::finding::{Advice, Finding, LineSpans, Severity};

gravical_judge::findings! {
    "not-filtered" Warning "segments between gaps or breaks are shorter than the filter needs" / "":
        NotFiltered { filter: String, samples: usize, shortest: usize } =>
            "{filter}: {samples} samples in parts of channels that are shorter than the {shortest} it needs are left unchanged";
    "short-for-cutoff" Warning "one period of the cutoff is longer than the recording: the ends dominate" / "":
        ShortForCutoff { filter: String, cutoff_hz: f64, duration_s: f64 } =>
            "{filter}: {cutoff_hz} Hz has a period of {:.3} s and the recording lasts {duration_s:.3} s: the result depends mainly on the treatment of the ends", 1.0 / cutoff_hz;
    "never-static" Note "no static interval" / "Lay the sensor down for 3 s or more":
        NeverStatic { why: Restless } => "never at rest: {why}";
        EffectUnknown =>
            "no static interval was found: the effect of the filters on the noise of this recording is unknown";
    "no-gyro" Warning "without a gyroscope the tilt between rests is unknown; the band allows for half a degree" / "":
        NoGyro { longest_s: f64, swing_m: f64 } =>
            "without a gyroscope the tilt between rests is not known: one swing of 1° during the longest move ({longest_s:.1} s) is {swing_m:.2} m; the band allows for tilts of half a degree";
    "gyro-not-used" Warning "the unit of the gyroscope is unknown" / "":
        GyroNotUsed =>
            "the unit of the gyroscope is unknown, so it is not used: the tilt between rests is not measured; give the unit, and the range for counts";
        GyroNoiseLeftOut =>
            "the unit of the gyroscope is unknown, so its noise is left out; give the unit, and the range for counts";
    "dead-gyro" Warning "the gyroscope never changes" / "":
        DeadGyro => "the gyroscope never changes; motion is computed without it";
    "covariance-unknown" Note "the calibration has no covariance: typical uncertainties are assumed" / "":
        CovarianceUnknown =>
            "the calibration does not state its covariance: 0.5 % of scale, 0.02 m/s² of bias and 0.6° between the axes are assumed for the band";
    "gravity-off" Warning "without a calibration: at rest the magnitude differs from gravity (a note up to 2 %)" / "Calibrate":
        GravityOff { norm_mps2: f64, off_percent: f64, gravity_mps2: f64 } =>
            "at rest the magnitude is {norm_mps2:.2} m/s², {off_percent:+.1} % off gravity ({gravity_mps2:.2}): a bias, which levelling takes off, or an error of scale, by which displacements are then off as well; the band allows for both, a calibration decides";
    "values-replaced" Warning "values in a move at the end of the range, or far from their neighbours, are interpolated; the band includes it" / "Record with a wider range":
        ValuesReplaced { runs: usize } =>
            "values at the end of the range, or far from all around them, are no measurement ({runs} runs in moves): they follow what is on both sides, and the band holds what they may have been";
    "closure-contradicts" Warning "at the end of a move velocity or tilt is off by more than its uncertainty; its band is widened" / "Rest for 2 s before and after a move; calibrate; stay within the ranges":
        ClosureContradicts { widened: usize, moves: usize } =>
            "at the end of {widened} of {moves} moves the velocity, or the tilt, is off by more than the noise explains: a bias that drifts, a hand that did not stop, a reading out of range; the bands of these moves are widened by it, along all axes";
    "rows-left-out" Note "rows are incomplete, or their time stamp does not advance" / "":
        RowsLeftOut =>
            "rows without a complete sample, or whose time stamp is not after that of the row before; the steps go over them";
    "noise-from-rests" Warning "the sensor moved; the longest static intervals are used" / "":
        NoiseFromRests { intervals: usize, rest_s: f64, recorded_s: f64 } =>
            "the sensor moved: the result rests on {}, {} of {}",
            count(intervals, "static interval"), duration_text(*rest_s), duration_text(*recorded_s);
    "noise-below-resolution" Warning "the noise is below 0.4 steps of rounding: only an upper limit of N is known" / "Print more decimals":
        NoiseBelowResolution { channel: String, step: f64, unit: String } =>
            "{channel}: {}; only an upper limit of N is known, for noise that no low-pass has reduced", hidden(*step, unit);
    "noise-misfit" Warning "the Allan variance deviates from the model by more than chance" / "Look at the figure: a bump is a vibration":
        NoiseMisfit { channel: String, tau_s: f64, ratio: f64 } =>
            "{channel}: at an averaging time of {} the Allan variance is {ratio:.2} times that of the model: vibration or another disturbance adds to the noise", duration_text(*tau_s);
    "noise-drift" Warning "the bias drifts along a line or an exponential, which is removed first" / "":
        NoiseDrift { channel: String, change: f64, unit: &'static str, during_s: f64, constant_s: Option<f64> } =>
            "{channel}: the bias drifts by {} {unit} in {}, along {}; N, B and K are what remains without that",
            digits(*change, 2), duration_text(*during_s), drift_shape(*constant_s);
    "noise-temperature" Warning "the temperature moved by more than 1 °C: B and K contain its effect" / "":
        NoiseTemperature { changed_c: f64 } =>
            "the temperature moved by {changed_c:.1} °C: drift of the bias with temperature looks like bias instability and random walk";
}

fn drift_shape(constant_s: Option<f64>) -> String {
    let exponential = |s| {
        format!(
            "an exponential with a time constant of {}",
            duration_text(s)
        )
    };
    constant_s.map_or_else(|| "a line".to_owned(), exponential)
}

/// Why noise is not seen.
pub(crate) fn hidden(step: f64, unit: &str) -> String {
    format!("the values change in steps of {step:.2e} {unit}, which hide the noise")
}

/// The kinds of all crates, in the order of the documents.
#[doc(hidden)]
pub fn kinds() -> Vec<Kind> {
    [RecordingCase::KINDS, CalibrationCase::KINDS, Case::KINDS].concat()
}

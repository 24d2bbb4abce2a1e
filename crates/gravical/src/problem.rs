//! What the verbs refuse, each with its sentence.

use gravical_core::filter::butterworth::{DesignError, MAX_ORDER};
use gravical_judge::numfmt::digits;
use gravical_judge::utc::UtcTime;
use gravical_signal::NoiseTerm;

use crate::finding::GyroMismatch;
use crate::poses::rests::Restless;
use crate::recording::AccelScale;

/// Calibrations that an error lists.
const MAX_LISTED: usize = 8;
/// Of filters.
const EXAMPLES: &str = "savgol:5,2 (window, order), butter:4,5Hz (low-pass), highpass:4,0.5Hz, hampel:7,3 (window, sigmas)";
const A_REST: &str = "record the sensor while it lies still, away from fans and footsteps, for two hours or more; ten seconds are the least";
const ITS_FILE: &str = "give the file of `gravical noise REST.csv -o noise.json`";
const MORE_NOISE: &str =
    "record accelerometer and gyroscope at rest, with more decimals or for longer";

gravical_judge::errors! {
    "target-is-input" usage:
        TargetIsInput => "this is an input file; a result must not replace it" => "name another file for the result";
        TargetMayBeInput => "this may be a recording of an input folder; a result must not replace it" => "name another file for the result";
    "same-target" usage:
        SameTarget => "two results would be written here" => "name a separate place for each";
    "sensor-of-several" usage:
        SensorOfSeveral => "the id of the sensor is to be the name of the session, and there are several inputs" => "give one folder";
    "unit-mismatch" input:
        GyroMismatch { why: GyroMismatch } => "{why}" => "give its unit, if this is the right one";
    "sensors-differ" input:
        NotOfSensor { named: String, given: String } => "the recording is of the sensor {named}, not of {given}"
            => "leave the sensor out, or name the file of the calibration";
    "sensor-id-missing" usage:
        SensorUnnamed { there: Vec<String> } => "the recording names no sensor, and the calibrations in the folder may be of several{}", there_is(&there)
            => "name the sensor, or the file of its calibration";
    "no-calibration" input:
        NoneFits { sensor: Option<String>, scale: Option<AccelScale>, recorded: Option<UtcTime>, there: Vec<String> } => "no calibration{} is in this folder{}",
            if there.is_empty() { String::new() } else { wanted(sensor, scale, recorded) }, there_is(&there)
            => "calibrate the sensor at this setting with -o in this folder, or name a file";
    "gyro-not-calibrated" usage:
        GyroNotCalibrated => "the calibration has no gyroscope, so it cannot be applied to one" => "leave it out, or calibrate with it";
    "no-date" input:
        NoDate => "nothing in this recording says when it was made" => "leave absolute time out: times are seconds since the first row";
    "no-filter" usage:
        FilterMissing => "no filter was given" => "give one of: {EXAMPLES}";
    "filter-syntax" usage:
        NoFilter { text: String } => "\"{text}\" is not a filter" => "{EXAMPLES}";
    "filter-range" usage:
        FilterRange { filter: String, window: usize, hampel: usize, polynomial: usize } => "{filter}: a parameter is out of range"
            => "windows are odd, up to {window} (savgol) or 3 to {hampel} (hampel); orders are below the window and at most {polynomial} (savgol), or 1 to {MAX_ORDER}; a cutoff is above 0 Hz, sigmas are 0 to 1e6";
        PolynomialOpen { filter: String } => "{filter}: the window does not determine the polynomial" => "{EXAMPLES}";
        Cutoff { rate_hz: f64, margin_hz: f64 } => "the cutoff has to be between 0 and {} Hz, half the rate, and {} Hz from both",
            digits(0.5 * rate_hz, 4), digits(margin_hz, 1) => "choose another cutoff; `gravical inspect` shows the rate";
        NoDesign { why: DesignError } => "{why}" => "{EXAMPLES}";
    "uneven-stamps" input:
        UnevenStamps { share: f64, rate_hz: f64 } =>
            "{:.1} % of the steps between time stamps are no whole number of periods at {rate_hz:.6} Hz; filters need evenly spaced samples", 100.0 * share
            => "resample it to an even rate first; if only its clock is uneven, ignore it and give the rate; hampel filters take samples as they come";
    "rate-unknown" usage:
        FilterWithoutRate { filter: String } => "{filter} needs the sampling rate, and the recording has no time stamps" => "give the rate in Hz";
        NoiseWithoutRate => "there are no time stamps and no sampling rate: averaging times are unknown" => "give the rate in Hz";
    "rate-unknown" input:
        MotionWithoutRate => "there are no usable time stamps, and no rate is stated"
            => "give the sampling rate, or the unit of the time stamps if there are any";
    "unit-unknown" input:
        UnitUnknown => "the unit of the accelerometer is unknown, so there is no velocity in m/s" => "give it, and the range for counts; or give a calibration";
    "no-samples" input:
        FewSamples { complete: usize, rows: usize } => "{complete} of {rows} rows hold a complete sample; two at least are needed"
            => "`gravical inspect` shows what is in it";
    "rests-syntax" usage:
        NoInterval { text: String } => "{text:?} is no start and later end, in seconds with a dash between"
            => "write seconds as 0-5,7.2-: from 0 to 5 s, and from 7.2 s to the end";
    "rests-outside" usage:
        RestOutside { rest_s: [f64; 2], recorded_s: [f64; 2] } =>
            "there are fewer than two samples in the rest from {} s to {} s: the recording goes from {:.3} s to {:.3} s", rest_s[0], rest_s[1], recorded_s[0], recorded_s[1]
            => "seconds count from the first row of the recording";
    "not-at-rest" input:
        NeverAtRest { why: Restless } => "noise is what a sensor shows while nothing moves, and {why}" => "{A_REST}";
        ShortRest { longest_s: f64 } =>
            "noise is what a sensor shows while nothing moves, and the longest static interval takes {longest_s:.1} s" => "{A_REST}";
    "not-noise" input:
        NoNoise { why: String } => "no result of `gravical noise`: {why}" => "{ITS_FILE}";
        OtherFormat { format: String, wanted: &'static str } => "the format is {format:?}, not {wanted}" => "{ITS_FILE}";
        NotPositive => "a parameter is not a positive number" => "{ITS_FILE}";
    "noise-unknown" input:
        TermUnknown { term: NoiseTerm, channel: String, upper_limit: bool } =>
            "Kalibr wants numbers above zero, but {} of {channel} is not determined", term.symbol()
            => "{}", if upper_limit { MORE_NOISE } else { "record longer (`gravical noise` says how long), or take upper limits" };
        NoiseUnknown { sensor: &'static str } => "Kalibr wants numbers above zero, but the noise of the {sensor} is not known" => "{MORE_NOISE}";
        NoiseOfCalibration { target: &'static str } => "{target} holds noise only, and a calibration contains none" => "export the result of `gravical noise`";
    "export-target" input:
        NotDiagonal => "the axes of the sensor are more than 25° from those of its case, or have the other sign, and this target has one scale for each axis"
            => "export to a target with a full matrix, such as c or ros, or calibrate in the axes of the sensor";
    "export-unit" input:
        NoNominalScale { unit: String } => "this target takes m/s², and the calibration is for {unit} of unknown nominal scale"
            => "calibrate with the range, which gives the counts their nominal scale; or export to c, which takes the counts themselves";
        OtherScale { own: f64, unit: &'static str, wanted: f64 } => "the calibration's own scale is {own:.1} counts per {unit}, not {wanted}"
            => "give those of the range in which the recordings were made";
    "export-option" usage:
        NoOption { target: &'static str } => "means nothing to the target {target}" => "leave it out";
        NoCounts { counts: f64 } => "{counts} counts per unit is no positive number" => "these are of an MPU6050 in the ranges ±2 g and ±250 °/s";
        CalibrationOfNoise { target: &'static str } => "{target} holds a calibration, and this is the result of noise" => "export a calibration";
    "export-name" usage:
        NoIdentifier { name: String, longest: usize } => "{name} is no identifier"
            => "use letters, digits and single underscores, a letter first, at most {longest}: for example imu_left";
}

/// What a calibration has to be for, as far as known.
fn wanted(sensor: Option<String>, scale: Option<AccelScale>, recorded: Option<UtcTime>) -> String {
    let of = sensor.map(|id| format!(" of the sensor {id}"));
    let unit = scale.map(|scale| match scale.lsb_per_g {
        Some(lsb) => format!(" in {}, {lsb:.0} per g,", scale.unit),
        None => format!(" in {}", scale.unit),
    });
    let before = recorded.map(|time| format!(" from before {}", time.minute()));
    [of, unit, before].into_iter().flatten().collect()
}

/// `; there is: FILE: SENSOR, UNIT, TIME; …`
fn there_is(all: &[String]) -> String {
    if all.is_empty() {
        return String::new();
    }
    let more = all.len().saturating_sub(MAX_LISTED);
    let mut lines = all[..all.len() - more].to_vec();
    lines.extend((more > 0).then(|| format!("and {more} more")));
    format!("; there is: {}", lines.join("; "))
}

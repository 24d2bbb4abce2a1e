//! What is found in sessions and calibrations, each with its sentence.

use std::fmt;

use gravical_fit::MIN_MOTIONS;
use gravical_judge::numfmt::{COVERAGE, count, milli_g, small};
use gravical_judge::units::{AccelUnit, GyroUnit};
use serde::Serialize;

use crate::attitude::AXES;

gravical_judge::findings! {
    "folder-left-out" Note "a subfolder with files that may be recordings is not read" / "":
        FolderLeftOut { files: usize } =>
            "a folder with {} that may be recordings; not read", count(files, "file");
    "no-recording" Note "a file of the folder is not a recording" / "":
        Rescued =>
            "what `gravical log` rescued when its file was lost: another name makes it a recording; left out";
        NoRecording { why: String } => "{why}; left out";
        LinearLeftOut =>
            "left out: by its values or its name it lacks gravity, and another file holds the acceleration with gravity";
    "already-calibrated" Warning "the values are calibrated. `apply`, and files given by name, use them; `motion` widens its bands; files of a folder are ignored" / "Give the raw recording":
        ResultLeftOut =>
            "a result of this program, by its column names, not a recording; left out";
        CalibratedForSession { by_board: bool } =>
            "{}: a session needs raw recordings", why_calibrated(*by_board);
        CalibratedForCheck { by_board: bool } =>
            "{}: a check needs the raw recording", why_calibrated(*by_board);
        CalibratedForApply { by_board: bool } =>
            "{}: calibrating again would apply the correction twice", why_calibrated(*by_board);
        CalibratedForMotion { by_board: bool } =>
            "{}: the calibration may be applied for the second time, and the bands are widened by what it changes; leave the calibration out, or use a raw recording", why_calibrated(*by_board);
    "gyro-joined" Note "a file with only a gyroscope is joined to the recording beside it by time" / "":
        GyroJoined { recording: String } =>
            "a gyroscope alone, beside one recording: joined to {recording} on time";
    "gyro-left-out" Warning "a file with only a gyroscope is beside several recordings, or its time does not match" / "":
        GyroOfAnother { recording: String, why: String } =>
            "a gyroscope alone, which does not belong to {recording}: {why}; left out";
        GyroAlone @ Note =>
            "a gyroscope alone, and no pose; left out. With one recording, it can be joined to it";
    "same-file-twice" Warning "two inputs are identical; both count" / "":
        SameFileTwice { file: String } => "it is the same as {file}, byte for byte, and counts twice";
    "rows-as-poses" Note "rows of similar magnitude point everywhere: each is the mean of a pose" / "":
        RowsAsPoses { rows: usize } =>
            "{rows} rows without a static interval; they lie far apart and are alike in magnitude, so that each is used as the mean of a pose";
    "labels-left-out" Note "labels name neither a pose nor a turn" / "Check the spelling":
        LabelsLeftOut { rows: usize, labels: Vec<String> } =>
            "{rows} rows labelled \"{}\" name no pose or turn; left out", labels.join("\", \"");
        TurnsNotUsed =>
            "the named turns do not calibrate the gyroscope: that takes all six faces and a full turn about each axis, without a gap or a clipped reading, whose scale is within 10 % of the stated one";
    "empty-pose" Warning "a section or label has no value of one axis" / "":
        EmptyPose { pose: String, axis: char } =>
            "\"{pose}\" has no value of a{axis} in any of its rows; left out";
    "short-pose" Warning "an interval is too short to search for a static interval; all its rows are used" / "Record 3 s or more":
        ShortPose { pose: String, rows: usize } => "{pose}: {rows} rows only; all are used";
    "no-static-interval" Warning "the sensor never rests in an interval" / "":
        PoseNeverAtRest { pose: String, lines: [u64; 2] } =>
            "{pose} is never at rest in lines {} to {}: left out", lines[0], lines[1];
        NeverAtRest { why: Restless } => "never at rest: {why}; not used";
    "unsteady-pose" Warning "the sensor moves slightly all the time, as if held by hand" / "Put it down and record the pose again":
        UnsteadyPose { pose: String, lines: [u64; 2], rms_mg: f64 } =>
            "{pose}: never quite at rest; the longest quiet part, lines {} to {}, moves by {rms_mg:.0} mg rms and is used", lines[0], lines[1];
    "unused-pauses" Warning "pauses in other directions than the poses are too short or too unsteady" / "Hold each for a second or more, leaned against something":
        ShortPauses { directions: usize, lines: [u64; 2], lasts: usize, least: usize, rate_hz: Option<f64> } =>
            "pauses in {} other than those of the poses are not used; that in lines {} to {} lasts {} with the ends of motions, a pose at least {} without: hold each for longer",
            count(directions, "direction"), lines[0], lines[1], duration(*lasts, *rate_hz), duration(*least, *rate_hz);
        UnsteadyPauses { directions: usize, lines: [u64; 2], rms_mg: f64 } =>
            "pauses in {} other than those of the poses are not used; that in lines {} to {} moves by {rms_mg:.0} mg rms, as in a hand: lean the sensor against something",
            count(directions, "direction"), lines[0], lines[1];
    "spikes-left-out" Warning "2 % or more of the samples of a pose are [spikes](method.md#the-mean-of-a-pose-and-its-standard-error)" / "Check wiring and supply; the bus may be too fast for its length":
        SpikesLeftOut { samples: usize } =>
            "{samples} samples at rest stand out from their neighbours by more than 6 standard deviations: left out";
    "orientation-mismatch" Warning "a file name claims another face than the data" / "":
        OrientationMismatch { pose: String, claimed: String, up: String } =>
            "\"{pose}\" claims {claimed}, but {up} points up there; the data are believed";
    "names-reversed" Note "all six names have the opposite sign of the data" / "If the sensor reads −g on the axis that points up, as iPhones do, give `--axes -x,-y,-z`":
        NamesReversed =>
            "every name says the opposite of the data, which are believed: either a sign means the axis that points down here, or the sensor reads −g where an axis points up, as iPhones do; then other axes give calibrated values the usual sign";
    "names-turned" Warning "the names describe a board that is rotated in its case" / "":
        NamesTurned { axes: String, named: String } =>
            "the names describe another way of sitting in the case than the axes {axes}, which are believed; {named} explains all names";
    "names-mirrored" Gate "the names contradict every possible mounting" / "Find the two recordings that were swapped":
        NamesMirrored =>
            "the names contradict the data in a way that no mounting explains (two poses swapped?); the faces were taken from the data, but check which recording is which";
    "gravity-assumed" Note "local gravity was not given: 9.80665 m/s² is up to 0.27 % of scale off at sea level" / "":
        GravityAssumed =>
            "local gravity is assumed to be 9.80665 m/s²: the scale may be off by up to 0.27 % at sea level (0.34 % in La Paz); give it, or latitude and altitude";
    "bad-pose" Warning "the magnitude at one pose contradicts all others; it is left out of the fit" / "":
        BadPose { pose: String, error_mps2: f64, chance: f64 } =>
            "{pose}: reads {:+.1} mg off the magnitude that all others agree on (chance {chance:.0e}); left out. Was it moving?", milli_g(*error_mps2);
    "several-explanations" Warning "the poses contradict each other, and [several causes](method.md#verdict) explain it; the claimed error holds for each" / "Warm the sensor up, and record again without a break or with more free poses":
        SeveralExplanations { explanations: Vec<(String, f64)>, order: OrderOf, difference_mps2: f64 } =>
            "the poses contradict each other, and this would explain it: {}; {order}. The results differ by up to {:.1} mg, which is in the error that is claimed",
            likeliest(explanations), milli_g(*difference_mps2);
    "no-face" Warning "a pose named after a face is tilted so far that it is a free pose" / "":
        NoFace { pose: String, angle_deg: f64 } =>
            "{pose} is named a face but lies {angle_deg:.1}° off it, much further than the others: taken as a free pose, unless it is given as a face";
    "missing-face" Gate "one of the six face poses is missing, and there are no free poses" / "":
        MissingFaces { sd_mps2: Vec<(String, f64)> } =>
            "{} of six faces are there; the magnitude is known only to {}. Record what is missing, or oblique poses",
            6 - sd_mps2.len(), list(sd_mps2, |(face, sd)| format!("{face} up: ±{:.0} mg", milli_g(COVERAGE * *sd)));
    "few-orientations" Gate "of many poses without a face none is beyond ±0.3 g on some side of an axis" / "Record longer, or point each axis up and down for a while":
        FewOrientations { ranges_g: [[f64; 2]; 3], least_g: f64 } =>
            "not enough orientations: only {} are covered; each axis has to be beyond ±{least_g} g on both sides",
            list(AXES.iter().zip(ranges_g), |(axis, [low, high])| format!("{axis} {low:+.2} to {high:+.2} g"));
    "same-face-twice" Gate "one face is recorded twice, once under the name of the missing face" / "Record the named file again":
        SameFaceTwice { up: String, one: String, other: String, missing: String } =>
            "{up} points up in \"{one}\" and in \"{other}\", and no pose has {missing} up: record \"{other}\" with {missing} up";
    "orientation-open" Note "face poses on fewer than two axes: the matrix is triangular by convention" / "If directions matter, record face poses":
        OrientationOpen =>
            "faces on fewer than two axes: the orientation of the sensor in its case is unknown. The frame was fixed by convention (triangular matrix); magnitudes are not affected";
    "model-error" Warning "the model misfit of the poses exceeds 20 mm/s²" / "Warm the sensor up, and keep it at rest":
        ModelError { error_mps2: f64 } =>
            "the poses differ from the model by {:.0} mm/s² beyond their noise: was the sensor at rest, and warm?", 1000.0 * error_mps2;
    "noise-assumed" Note "the rows are means of unknown standard error: 4 mm/s² is assumed" / "Give the recordings":
        NoiseAssumed =>
            "each row is a mean of unknown standard error: 4 mm/s² were assumed for the uncertainty";
    "free-pose-off" Gate "at free poses that the fit does not use ‖a‖ is off by more than three times the predicted error" / "Check these and the six faces":
        FreePosesOff { poses: usize, error_mps2: f64, limit: f64 } =>
            "{poses} free poses, which took no part in the fit, read the magnitude off by {:.0} mg rms, more than {limit} times what was predicted: was the sensor moving there, or is one of the faces wrong?", milli_g(*error_mps2);
    "pose-tilt" Warning "the tilt of the face poses exceeds 1.6°" / "Use a box or a jig":
        PoseTilt { tilt_deg: f64 } =>
            "the poses lie {tilt_deg:.1}° off their faces in each of two components. A box or a jig would help";
    "clipped-pose" Gate "samples in a pose are clipped: its mean is too small" / "":
        ClippedPose { pose: String, samples: usize } =>
            "{pose}: {samples} samples at the end of the range; its mean is too small";
        ClippedInterval { samples: usize, lines: [u64; 2] } @ Warning =>
            "{samples} samples at the end of the range in lines {} to {}: the mean is too small, and the interval does not count unless there is no other", lines[0], lines[1];
    "scale-off" Gate "a scale factor is more than 10 % off nominal" / "Check unit and range":
        ScaleOff { deviation_percent: [f64; 3], limit_percent: f64 } =>
            "the scale is off by more than {limit_percent} % ({}): a data sheet allows 3; is the unit or the range right?",
            beyond(*deviation_percent, *limit_percent, |v| format!("{v:+.1} %"));
    "large-bias" Gate "a bias exceeds 0.35 g" / "Check unit and zero offset; the sensor may be damaged":
        LargeBias { bias_mps2: [f64; 3], limit_mps2: f64 } =>
            "a bias above 0.35 g ({}): no sensor of this kind has that; was every side that is named really up, and is the unit right?",
            beyond(*bias_mps2, *limit_mps2, |v| format!("{v:+.2} m/s²"));
    "gyro-motions-left-out" Warning "motions between poses last more than 60 s, are interrupted or clipped, or contradict the others" / "Rotate more slowly, or record with a wider range":
        MotionsBroken { motions: u64, max_s: f64, gap_periods: f64 } =>
            "motions between static intervals are left out of the gyroscope's fit ({motions}): they last longer than {max_s} s, have a break, or miss its readings for more than {gap_periods} periods";
        MotionsClipped { motions: u64 } =>
            "motions between static intervals are left out of the gyroscope's fit ({motions}): they reach the end of its range, turned too fast";
        MotionsContradict { motions: u64 } =>
            "motions between static intervals are left out of the gyroscope's fit ({motions}): they contradict the others, by a bump, lost samples, or too fast a turn";
    "gyro-undetermined" Note "the motions do not determine the matrix of the gyroscope to 3 %: only its bias is estimated" / "Rotate about the named axes, each while it is level":
        GyroUndetermined { motions: usize, sd: f64, weak: Vec<String>, is_scaled: bool } =>
            "{motions} usable motions between static intervals leave the gyroscope's matrix {}; {}. Turn it about {} by 90° and more, with that axis level, and at least {MIN_MOTIONS} times in all, better twice as often",
            known(*sd), if *is_scaled { "it gets its bias only, with the nominal scale" } else { "it is not calibrated" }, weak.join(", ");
    "gyro-misfit" Warning "after a typical motion the direction of gravity is more than 3° off" / "Check clock, rate and the accelerometer":
        GyroMisfit { angle_deg: f64 } =>
            "after a typical motion, gravity rotated by the integrated rate is wrong by {angle_deg:.1}°: do both sensors have one clock, is the rate right, and the accelerometer's calibration sound?";
    "gyro-left-handed" Warning "gyroscope and accelerometer differ in handedness" / "":
        GyroLeftHanded =>
            "the gyroscope counts left-handed against the axes of the accelerometer: the sign of one axis is inverted in one of the two; after calibration they agree";
    "gyro-scale-off" Warning "a scale factor of the gyroscope is more than 10 % off nominal" / "Check range and unit":
        GyroScaleOff { of_nominal: [f64; 3] } =>
            "by the motions the gyroscope's scale is {} of nominal about x, y, z: is the range or the unit another one, or are its axes not the accelerometer's?",
            list(of_nominal, |d| format!("{d:.3}"));
    "gyro-scale-unknown" Note "neither a range nor a motion gives the scale of the gyroscope" / "":
        GyroScaleUnknown { bias: [f64; 3] } =>
            "the gyroscope reads {} at rest, and its scale follows neither from its unit nor from rotations: it is not calibrated; give its unit and, for counts, its range",
            list(bias, |b| format!("{b:.4}"));
    "gyro-rate-unknown" Note "without a rate only the bias of the gyroscope is estimated" / "":
        GyroAveraged =>
            "the samples were averaged: the turns between static intervals cannot be integrated, and the gyroscope gets its bias only";
        GyroRateUnknown =>
            "no time stamps and no rate: the turns between static intervals cannot be integrated, and the gyroscope gets its bias only";
    "gyro-unit-unverified" Warning "no rotation shows the unit of the gyroscope; a warning where only the noise at rest distinguishes rad/s from °/s" / "":
        GyroScaleUnread { what: &'static str } @ Note =>
            "the {what} of the gyroscope is unknown: neither the file nor a rotation between static intervals shows it; give it";
        GyroUnitOfCalibration { unit: GyroUnit } @ Note =>
            "the gyroscope is read in {unit}, the unit of the calibration: the recording does not name one, and it is not verified by a rotation between static intervals";
        GyroUnitUnverified { unit: GyroUnit } @ Note =>
            "the gyroscope is read in {unit}, not verified by a rotation between static intervals";
        GyroUnitByNoise { unit: GyroUnit, noise: f64 } =>
            "the gyroscope is read in {unit}, the unit in which its noise at rest, {noise:.2e}, is usual: no rotation shows another, and the header has none or is wrong about the accelerometer; give the unit if it is another";
    "unit-unverified" Note "the unit of a recording, soak or calibration is unknown: that of the other is assumed" / "":
        UnitTaken { unit: AccelUnit, wanted: AccelUnit, at_rest: String, norm_mps2: Option<f64> } =>
            "the recording is in {unit}, the calibration for {wanted}; taken as the same: {}", measured(at_rest, *norm_mps2);
        ScalesAlike =>
            "the input unit of a calibration is unknown; the scales are alike, so the units are taken as the same";
    "temperature-refused" Warning "the temperature changes at rest, but the drift of no channel [can be predicted](method.md#drift-with-temperature)" / "":
        TemperatureRefused { range_c: [f64; 2] } =>
            "the temperature changes at rest ({:.1} to {:.1} °C), but the drift of no channel is predictable: none is subtracted", range_c[0], range_c[1];
    "temperature-outside" Warning "temperatures are outside those of the calibration or its model. `apply` uses the drift at the nearest limit" / "":
        PosesOutside { poses_c: f64, soak_c: [f64; 2], valid_c: f64 } =>
            "the poses were at {poses_c:.1} °C, the soak spans {:.1} to {:.1} °C: bias and matrix are assumed to be valid at {valid_c:.1} °C; soak over the temperatures at which the sensor is calibrated and used", soak_c[0], soak_c[1];
        IntervalsOutside { intervals_c: [f64; 2], calibration_c: [f64; 2] } =>
            "the static intervals are at {:.1} to {:.1} °C, the calibration is for {:.1} to {:.1} °C: the bias of an MPU6050 moves by 0.5 mg (x, y) to 0.9 mg (z) per °C, which the uncertainty does not include; calibrate at this temperature",
            intervals_c[0], intervals_c[1], calibration_c[0], calibration_c[1];
        RowsOutside { rows: u64, rows_c: [f64; 2], model_c: [f64; 2] } =>
            "{rows} rows at {:.1} to {:.1} °C are outside the range of {:.1} to {:.1} °C in which the drift was measured: the drift at its edge is subtracted, which may be wrong",
            rows_c[0], rows_c[1], model_c[0], model_c[1];
    "temperature-not-applied" Warning "the calibration has a temperature model, the recording no temperatures" / "":
        DriftNotApplied { why: NoTemperature, range_c: [f64; 2], changes: Vec<(String, f64, String)> } =>
            "{why}, so the calibration's drift with temperature is not taken off there: between {:.1} and {:.1} °C it changes {}",
            range_c[0], range_c[1], list(changes, |(channel, most, unit)| format!("{channel} by up to {} {unit}", small(*most, 3)));
    "poor-calibration" Warning "the verdict of a calibration that is used or compared is poor" / "":
        PoorCalibration { reasons: Vec<String> } =>
            "the calibration's own verdict is poor: {}", reasons.join("; ");
    "gravity-differs" Warning "two values of gravity. `compare` counts the uncertainty of both; `check` uses the given one" / "":
        GravityDiffers { gravity_mps2: [f64; 2], of: [String; 2], percent: f64 } =>
            "gravity is {:.5} m/s² {} and {:.5} m/s² {}: if both are of one place, {percent:.3} % of scale, and of ‖a‖, come from that alone; use the same gravity for both",
            gravity_mps2[0], of[0], gravity_mps2[1], of[1];
    "same-recordings" Warning "both calibrations share recordings, or `check` got one of the calibration: agreement proves nothing" / "":
        RecordingsShared { shared: usize, all: usize, first: String } =>
            "{shared} of {all} recordings of the first calibration went into the second one, too ({first}): their errors are shared, so that agreement proves nothing";
        RecordingOfCalibration =>
            "the calibration was made from this recording: static intervals that it was fitted to cannot test it, and count only where there are no others";
    "frames-mirrored" Warning "one calibration is the mirror image of the other" / "Look for two poses that were swapped":
        FramesMirrored =>
            "one calibration describes the mirror image of the other: in one of the sessions two poses were swapped, or an axis has the wrong sign";
}

/// The axes on which a value is beyond the limit, and these values.
fn beyond(values: [f64; 3], limit: f64, shown: impl Fn(f64) -> String) -> String {
    let axes = AXES.iter().zip(values).filter(|(_, v)| v.abs() > limit);
    list(axes, |(axis, value)| format!("{axis} {}", shown(value)))
}

fn list<T>(of: impl IntoIterator<Item = T>, shown: impl Fn(T) -> String) -> String {
    of.into_iter().map(shown).collect::<Vec<_>>().join(", ")
}

/// How well a matrix of this relative standard uncertainty is known.
fn known(sd: f64) -> String {
    if sd < 10.0 {
        format!("known to {:.0} % only", 100.0 * sd)
    } else {
        "not known".to_owned()
    }
}

fn duration(samples: usize, rate_hz: Option<f64>) -> String {
    match rate_hz {
        Some(rate_hz) => format!("{:.1} s", samples as f64 / rate_hz),
        None => count(samples, "row"),
    }
}

/// What the order of poses in time is taken from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum OrderOf {
    /// Lines of one recording.
    Lines,
    /// Time stamps of several.
    Stamps,
    /// Names of the files.
    Names,
}

impl fmt::Display for OrderOf {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            OrderOf::Lines => "before and after are by the lines of the recording",
            OrderOf::Stamps => "before and after are by the time stamps",
            OrderOf::Names => {
                "before and after are by the names of the files, which may not be the order in time"
            }
        })
    }
}

/// The first five of some explanations with their probabilities, and how many others there are.
fn likeliest(explanations: &[(String, f64)]) -> String {
    const SHOWN: usize = 5;
    let word =
        |(what, p): &(String, f64)| format!("{what} ({:.0} %)", (100.0 * p).clamp(1.0, 99.0));
    let mut text = list(explanations.iter().take(SHOWN), word);
    if explanations.len() > SHOWN {
        text += &format!(", or {}", count(explanations.len() - SHOWN, "other"));
    }
    text
}

/// Why a recording has no static interval.
#[doc(hidden)]
#[derive(Debug, Clone, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Restless {
    UnknownUnit,
    Moves { mps2: f64 },
    Turns { deg_per_s: f64 },
    Short { least_s: f64 },
}

impl fmt::Display for Restless {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Restless::UnknownUnit => {
                f.write_str("its unit is not known, so that noise cannot be told from motion")
            }
            Restless::Moves { mps2 } => write!(
                f,
                "where it is quietest each axis moves by {mps2:.1} m/s² rms, at rest by less than 0.3"
            ),
            Restless::Turns { deg_per_s } => write!(
                f,
                "where it is quietest it turns by {deg_per_s:.0} °/s rms, at rest by less than 2"
            ),
            // Blocks have five rows or more.
            Restless::Short { least_s } => write!(
                f,
                "what is quiet is shorter than {least_s} s or 20 rows (without a rate 40 readings, or 10 over most of the recording), or turns"
            ),
        }
    }
}

/// Why a drift is not taken off.
#[doc(hidden)]
#[derive(Debug, Clone, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum NoTemperature {
    NotRecorded,
    NotCelsius,
    SomeIntervals { without: usize, intervals: usize },
}

impl fmt::Display for NoTemperature {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NoTemperature::NotRecorded => f.write_str("the recording has no temperatures"),
            NoTemperature::NotCelsius => f.write_str("the recording's temperatures are not in °C"),
            NoTemperature::SomeIntervals { without, intervals } => {
                write!(
                    f,
                    "{without} of {intervals} static intervals have no temperature"
                )
            }
        }
    }
}

/// Why a recording is taken for a calibrated one.
fn why_calibrated(by_board: bool) -> &'static str {
    if by_board {
        "the board calibrated it, as the line with its settings says (`gravical log --format si` records raw values)"
    } else {
        "its columns have the names of calibrated columns"
    }
}

/// The magnitude of what is `at_rest`, in words.
fn measured(at_rest: &str, norm_mps2: Option<f64>) -> String {
    match norm_mps2 {
        Some(norm) => format!("calibrated, {at_rest} measure {norm:.2} m/s²"),
        None => "no row is complete".to_owned(),
    }
}

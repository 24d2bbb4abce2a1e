//! Every kind of finding: its name, how much it matters, what it means, what was done
//! about it, and what the user should do. The tables of `docs/recording.md` are made of it.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::Severity;

/// How much a kind matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Weight {
    Note,
    Warning,
    /// It depends: a warning, unless it is said to be a note.
    Either,
    /// A warning that makes a calibration poor.
    Gate,
}
use Weight::{Either, Gate, Note, Warning};

/// A row of the tables.
struct Row {
    section: &'static str,
    name: &'static str,
    weight: Weight,
    meaning: &'static str,
    done: &'static str,
    remedy: &'static str,
}

macro_rules! kinds {
    ($($section:literal {$(
        $kind:ident $name:literal $weight:ident $meaning:literal $done:literal $remedy:literal;
    )*})*) => {
        /// What is odd, as a case that scripts and commands can tell from others.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        #[non_exhaustive]
        pub enum FindingKind {
            $($(#[doc = $meaning] $kind,)*)*
            /// A kind of another version of this program, out of a file.
            Other,
        }

        impl FindingKind {
            /// All of them, in the order of the documents.
            pub const ALL: &'static [FindingKind] = &[$($(FindingKind::$kind,)*)*];
        }

        /// In the order of the kinds.
        const ROWS: &[Row] = &[$($(Row {
            section: $section,
            name: $name,
            weight: $weight,
            meaning: $meaning,
            done: $done,
            remedy: $remedy,
        },)*)*];
    };
}

kinds! {
    "Lines of the file" {
        NamedGap "named-gap" Warning
            "a line `# gap: …`: [the logger](logging.md) reports rows that were lost"
            "a break; the clock may restart there"
            "nothing for a mean; find the cause";
        BlankRows "blank-rows" Note
            "empty lines, or lines of delimiters only"
            "taken as a break between poses, except a single line across which the clock continues"
            "nothing, if a break was meant";
        RepeatedHeader "repeated-header" Warning
            "the header once more in the middle"
            "skipped; a break unless the clock continues"
            "check whether two recordings are in one file";
        OtherSensor "other-sensor" Note
            "rows of a sensor other than the selected one (`several-sensors`)"
            "not read"
            "nothing";
        TornLine "torn-line" Warning
            "fewer fields than the other rows"
            "skipped"
            "nothing for a single last line; many indicate a bad connection";
        TooManyFields "too-many-fields" Warning
            "more fields than the other rows"
            "skipped"
            "check whether lines run together; lower the baud rate or the sampling rate";
        NotANumber "not-a-number" Warning
            "a value that is not a number"
            "skipped"
            "check the line";
        ZeroRows "zero-rows" Warning
            "the accelerometer reads zero on all axes, together with the gyroscope or in five consecutive rows"
            "left out: the sensor was not read; empty cells where the gyroscope was"
            "check the wiring";
        SensorHung "sensor-hung" Warning
            "all channels repeat to the last digit for longer than noise allows"
            "those rows are left out: they are a gap"
            "check wiring and power of the sensor";
        ShiftedColumns "shifted-columns" Warning
            "from a line on the magnitude at rest is gravity only in other columns: the bus lost a byte"
            "those rows are left out"
            "check the wiring; restart the sensor";
        RejectedSamples "rejected-samples" Note
            "lines `# rejected: …` of the logger"
            "counted"
            "nothing";
        NulBytes "nul-bytes" Warning
            "NUL bytes in lines"
            "removed"
            "the file may be damaged; close it before unplugging the board";
        TruncatedFile "truncated-file" Warning
            "a truncated gzip file"
            "the part that can be unpacked is used"
            "copy the file again";
        CorruptBlock "corrupt-block" Warning
            "blocks of a [file of a wearable](wearables.md) with a wrong checksum, an unknown coding, no date, or cut off at the end"
            "skipped; a break"
            "copy the file from the device again; if that does not help, its memory is worn or it lost power";
        RepeatedBlock "repeated-block" Warning
            "blocks of such a file that repeat the one before"
            "skipped"
            "nothing";
        LateBlock "late-block" Warning
            "blocks of such a file that are earlier than the one before: repeated or out of order"
            "skipped"
            "copy the file from the device again";
        MissingBlocks "missing-blocks" Warning
            "blocks of such a file are missing by their sequence numbers, or the time stamps jump"
            "a break; no sample is stretched over it"
            "nothing for a mean; copy the file again if it is long";
        SeveralSessions "several-sessions" Warning
            "several sessions in one such file"
            "a break between them"
            "check that one person wore it in one setting";
        SamplesAveraged "samples-averaged" Note
            "such a file has more than 1,048,576 samples"
            "`inspect`, `calibrate` and `check` use [means of neighbouring samples](#long-recordings), at 2.5 Hz or faster"
            "nothing";
    }
    "Columns and files" {
        FirstRowsDiffer "first-rows-differ" Warning
            "clock, cells or units of the whole recording differ from those of the first 256 KiB, which `apply` uses"
            "read according to the first rows"
            "give `--accel-unit`, `--time-unit` or `--rate`, or remove the rows that differ";
        ColumnsGuessed "columns-guessed" Warning
            "no header, or a header that does not fit the columns"
            "recognised from the values; the message says how"
            "give the printed `--columns` option";
        NotAnAccelerometer "not-an-accelerometer" Warning
            "columns recognised from their values behave like a gyroscope"
            "used anyway"
            "give `--columns`";
        SeveralSensors "several-sensors" Warning
            "more than one accelerometer, in columns side by side or in rows distinguished by a column (`I`, `instance`, `sensor_id`)"
            "the first is used"
            "select another one with `--sensor`, as the message says";
        UnnamedClock "unnamed-clock" Warning
            "no column is named as time, and one or several increase steadily"
            "a single one is used as time, none of several"
            "give the printed `--columns t=…`; `--columns t=-` for none";
        WithoutGravity "without-gravity" Warning
            "at rest the acceleration is near zero, or the column is named linear and its magnitude is not gravity: the device has subtracted gravity"
            "the unit stays unknown; `calibrate` stops (`unit-unknown`)"
            "record the raw acceleration, or use its file: `Acceleration (with g)` in phyphox, `TotalAcceleration.csv` of Sensor Logger";
        NoRecording "no-recording" Note
            "a file of the folder is not a recording: a text such as a licence, or other columns"
            "ignored"
            "nothing";
        FolderLeftOut "folder-left-out" Note
            "a subfolder contains files that may be recordings"
            "not read"
            "give it separately if it is a session";
        GyroJoined "gyro-joined" Note
            "one recording, and one file with only a gyroscope beside it"
            "joined by time, as with `--gyro`"
            "nothing";
        GyroLeftOut "gyro-left-out" Either
            "a file with only a gyroscope beside several recordings, or one whose time does not match"
            "ignored: it contains no pose"
            "with one recording, name its file with `--gyro`";
        GyroRowByRow "gyro-row-by-row" Note
            "`--gyro`: at least one of the files has no time stamps"
            "joined row by row"
            "check that both start with the same sample";
        GyroInterpolated "gyro-interpolated" Note
            "`--gyro`: rows of the accelerometer are between two time stamps of the gyroscope"
            "the angular rate is interpolated linearly"
            "nothing";
        GyroUncovered "gyro-uncovered" Warning
            "`--gyro`: rows of the accelerometer without a reading of the gyroscope nearby"
            "empty there; motions with such rows are not used"
            "start both before the session, and stop them after it";
        RenamedColumn "renamed-column" Note
            "`apply`: the input has a column with the name of a calibrated column"
            "renamed to `input_…`"
            "nothing";
    }
    "Time" {
        TimeUnitAssumed "time-unit-assumed" Warning
            "the unit of the time stamps is not stated, and more than one fits"
            "the most likely is used; the message names it"
            "give `--time-unit`";
        TimeUnitUnknown "time-unit-unknown" Warning
            "the steps fit no unit, or no usual sampling rate"
            "the time stamps are not used"
            "give `--time-unit` or `--rate`";
        FrozenTime "frozen-time" Warning
            "the time stamps never advance"
            "not used"
            "give `--rate`";
        AbsentTime "absent-time" Warning
            "some rows have no time stamp"
            "the rows are used"
            "check the lines";
        RestartedTime "restarted-time" Warning
            "the time stamps restart: the board was reset"
            "a break; the clock is continued"
            "find the cause of the reset";
        BadStamps "bad-stamps" Warning
            "time stamps far off the line of their neighbours, or that run backwards"
            "a single one is replaced by the mean of its neighbours; others are used as recorded"
            "check the lines";
        StampsUnread "stamps-unread" Warning
            "a column of time holds text that is no date; the message quotes the first"
            "not used"
            "give `--rate`, or write seconds";
        DuplicateTime "duplicate-time" Warning
            "time stamps repeat"
            "the rows are used"
            "use a finer clock, or a lower rate";
        BurstTime "burst-time" Warning
            "many rows share a time stamp, followed by a long step: arrival times, whole seconds, or rounding by a spreadsheet"
            "the mean rate between the first and the last change is used instead"
            "record time stamps on the board";
        Gap "gap" Warning
            "more than four consecutive samples are missing"
            "counted; the message gives the longest"
            "nothing for a mean";
        MissingSamples "missing-samples" Warning
            "more than 0.1 % of the samples are missing; of a file per axis, rows that the first lacks"
            "counted"
            "lower the rate, or raise the baud rate";
        RateMismatch "rate-mismatch" Warning
            "the stated sampling rate differs by more than 2 % from the time stamps"
            "the time stamps are used"
            "correct the stated rate";
        RateUnknown "rate-unknown" Note
            "neither time stamps nor `--rate`"
            "static intervals are counted in rows"
            "give `--rate`";
    }
    "Units" {
        UnitMismatch "unit-mismatch" Warning
            "the unit of header, option or calibration contradicts gravity or the turns"
            "the data override a header; an option is used as given; `apply` stops unless `--accel-unit` is given"
            "correct the header";
        UnitAssumed "unit-assumed" Note
            "the magnitude at rest fits mg and cm/s²"
            "read as mg"
            "give `--accel-unit`, or name the unit in the header";
        UnitChanged "unit-changed" Gate
            "at rest the magnitude changes from one unit or range to another without a header"
            "used anyway; `apply` stops unless `--accel-unit` is given"
            "split the file at this line";
        UnitUnknown "unit-unknown" Warning
            "the magnitude at rest fits no unit, or several"
            "`inspect` continues; `calibrate` stops"
            "give `--accel-unit`: `mg`, or `counts` for counts of any scale";
        WrongFullScale "wrong-full-scale" Warning
            "the magnitude at rest is gravity times a power of two: the program that wrote the file assumed another range than the sensor was set to"
            "`inspect` continues; `calibrate` stops (`unit-unknown`)"
            "correct the factor where the file is written, or record again with one range";
        RangeMismatch "range-mismatch" Warning
            "the range of `--accel-range` or of the board's header contradicts gravity at rest"
            "the option is used as given; gravity overrides the header"
            "remove or correct the option";
        UnsignedCounts "unsigned-counts" Note
            "16-bit values written as unsigned: around 32768, or 65535 for −1"
            "32768 is subtracted; the bias includes it again; no range is assumed; 65535 is read as −1"
            "nothing, or `--zero-offset`";
        GyroUnitUnverified "gyro-unit-unverified" Note
            "no rotation between static intervals shows the unit of the gyroscope"
            "the unit of the calibration or of the header is used, if there is one"
            "give `--gyro-unit` if it matters";
        GyroUnitByNoise "gyro-unit-by-noise" Warning
            "no rotation shows the unit of the gyroscope, and the header has none or is wrong about the accelerometer; the noise at rest distinguishes rad/s and °/s"
            "that unit is used"
            "give `--gyro-unit` if it matters";
        UnitUnverified "unit-unverified" Note
            "`apply`, `check`, `compare`: the unit of the recording cannot be verified"
            "assumed to be that of the calibration"
            "compare the magnitude at rest with gravity";
    }
    "Samples" {
        Clipped "clipped" Warning
            "values at the end of the range: counts from 32764; in physical units repeats of the largest value at a usual full scale, or at `--gyro-range`"
            "used anyway"
            "record with a wider range";
        FrozenAxis "frozen-axis" Warning
            "an axis keeps one value for 100 rows while another axis of the sensor varies by more than its last digit (coarse digits at rest are not reported)"
            "used anyway"
            "check wiring and code; the axis may be defective";
        RepeatedRows "repeated-rows" Warning
            "throughout the recording rows repeat the row before in every channel (repeats at rest due to coarse digits are not reported)"
            "used anyway"
            "read no faster than the sensor measures";
        EmptyCells "empty-cells" Warning
            "cells without a value, and temperatures that no sensor can have (below −60 or above 150 °C)"
            "left empty and not part of means; if each channel is written when it arrives, the last value is held"
            "nothing, or record whole rows";
        TemperatureModel "temperature-model" Note
            "the drift of these channels with temperature can be predicted"
            "it is subtracted; the means of the poses refer to one temperature"
            "nothing";
        TemperatureRefused "temperature-refused" Warning
            "the temperature changes at rest, but the drift of no channel can be predicted"
            "nothing is subtracted; the table gives the reasons"
            "see [method.md](method.md#drift-with-temperature)";
        TemperatureReference "temperature-reference" Warning
            "a temperature recording is given, but the poses have no temperature"
            "bias and matrix are assumed to hold at the middle of the temperature recording"
            "record the temperature with the session";
        TemperatureOutside "temperature-outside" Warning
            "rows, poses or static intervals are outside the temperatures of the calibration or its model"
            "`apply`: the drift at the limit of the range is used; `check`: the uncertainty does not include it"
            "record the sensor at rest over all temperatures of use";
        TemperatureHeld "temperature-held" Note
            "`apply`: rows without a temperature"
            "the last known temperature is used"
            "nothing";
        TemperatureNotApplied "temperature-not-applied" Warning
            "`apply`, `check`: the calibration has a temperature model, the recording (or some of its rows) no temperatures"
            "the drift is not corrected; the message says how large it may be"
            "record the temperature";
        GyroUnitUnknown "gyro-unit-unknown" Warning
            "the unit of the gyroscope is unknown"
            "its values are used as they are"
            "give `--gyro-unit`";
        TemperatureUnit "temperature-unit" Note
            "the temperature column is not in °C, e.g. raw counts"
            "it is not used"
            "record °C if the temperature is needed";
    }
    "Poses" {
        MotionLeftOut "motion-left-out" Note
            "a tenth or more of a file is motion, or shorter static intervals of the same pose"
            "the longest static interval is used"
            "nothing";
        RowsAsPoses "rows-as-poses" Note
            "rows that point everywhere and are similar in magnitude"
            "each row is treated as the mean of a pose"
            "name the rows in a label column to make this explicit";
        LabelsLeftOut "labels-left-out" Note
            "labels that name neither a pose nor a turn"
            "their rows are not used"
            "check the spelling";
        EmptyPose "empty-pose" Warning
            "a pose given by a section or label has no value of one axis in all its rows"
            "it is not used"
            "check these rows, or remove the section";
        ShortPose "short-pose" Warning
            "an interval too short to search for a static interval"
            "all its rows are used"
            "record 3 s or more";
        FewRows "few-rows" Warning
            "`--rows` is larger than the number of rows of a pose"
            "all its rows are used"
            "record longer, or ask for fewer";
        NoStaticInterval "no-static-interval" Warning
            "an interval in which the sensor never rests"
            "not used"
            "record it again";
        WornSensor "worn-sensor" Note
            "a recording of half a day or longer with more static intervals than poses that somebody places a sensor in"
            "rests of less than 10 s are not used"
            "nothing";
        UnsteadyPose "unsteady-pose" Warning
            "the sensor moves slightly all the time, as if held by hand"
            "the longest quiet part is used; the message gives the residual motion"
            "put the sensor down and record the pose again";
        SpikesLeftOut "spikes-left-out" Warning
            "2 % or more of the samples of a pose differ from their neighbours by more than six standard deviations"
            "not used for its mean, unless they are more than a third"
            "check wiring and supply; the bus may be too fast for its length";
        OrientationMismatch "orientation-mismatch" Warning
            "a file name claims another face than the data show"
            "the data are used"
            "rename the file";
        NamesReversed "names-reversed" Note
            "all six names have the opposite sign of the data"
            "the data are used"
            "nothing if the names give the axis that points *down*; `--axes -x,-y,-z` if the sensor reads −g on the axis that points up, as iPhones do";
        NamesTurned "names-turned" Warning
            "the names describe a board that is rotated in its case"
            "the data are used: axes of the board"
            "give `--axes` for the axes of the case";
        NamesMirrored "names-mirrored" Gate
            "the names contradict every possible mounting"
            "the data are used"
            "find the two recordings that were swapped";
    }
    "Result" {
        GravityAssumed "gravity-assumed" Note
            "local gravity was not given"
            "9.80665 m/s² is used: up to 0.27 % of scale at sea level"
            "give `--latitude` and `--altitude`, or `--gravity`";
        BadPose "bad-pose" Warning
            "the magnitude at one pose contradicts all others significantly"
            "not used in the fit; the table shows its readings"
            "check whether the sensor moved; record the pose again";
        NoFace "no-face" Warning
            "a pose is named after a face but tilted so far that an intended free pose is more likely"
            "used as a free pose: only its magnitude is used"
            "record it again, or give `--face-pose NAME`";
        MissingFace "missing-face" Gate
            "only face poses, and one of the six faces is missing"
            "computed; the message gives the uncertainty of the magnitude with that face up"
            "record that face, or any free poses";
        FewOrientations "few-orientations" Gate
            "many poses without a face, as in days of wear, and none beyond ±0.3 g on some side of an axis"
            "computed; the message gives the range of each axis"
            "record longer, or turn the sensor so that each axis points up and down for a while";
        SameFaceTwice "same-face-twice" Gate
            "one face is recorded twice, once under the name of the missing face (or as two of six poses)"
            "computed without the missing face"
            "record the file that the message names again";
        OrientationOpen "orientation-open" Note
            "face poses on fewer than two axes, or a method without faces"
            "the matrix is triangular by convention"
            "record face poses if directions matter; the magnitude does not need them";
        CrossAxisHigh "cross-axis-high" Warning
            "the angle between two axes differs from 90° by more than 2.9°; data sheets allow 1.6°"
            "computed"
            "record more poses; one of them may be wrong";
        ModelError "model-error" Warning
            "the model misfit of the poses beyond their noise exceeds 20 mm/s²"
            "included in the uncertainty"
            "keep the sensor at rest, and warm it up first";
        NoiseAssumed "noise-assumed" Note
            "the rows are means of unknown standard error"
            "4 mm/s² are assumed"
            "give the recordings instead of their means";
        FaceTilt "face-tilt" Warning
            "a face pose is tilted by more than 10° (bias included)"
            "used"
            "record it again";
        FreePoseOff "free-pose-off" Gate
            "at free poses, which are not used by the fit, the error of the magnitude is more than three times the predicted one"
            "computed anyway"
            "check whether the sensor moved there, and check the six faces";
        PoseTilt "pose-tilt" Warning
            "the tilt of the face poses exceeds 1.6 times the usual 1°"
            "the uncertainty is computed with the estimated tilt"
            "use a box or a jig, or give `--pose-tilt`";
        ClippedPose "clipped-pose" Gate
            "clipped samples in a pose"
            "used; the mean is too small"
            "record with a wider range";
        ScaleHigh "scale-high" Warning
            "a scale factor differs by more than 5 % from nominal"
            "used"
            "data sheets allow 3 %: check range and gravity";
        ScaleOff "scale-off" Gate
            "a scale factor differs by more than 10 % from nominal"
            "used"
            "the unit or the range is wrong";
        BiasHigh "bias-high" Warning
            "a bias of more than twice the data sheet limit (±0.6 m/s²)"
            "used"
            "check poses and unit; give `--prior off` if the sensor is like that";
        LargeBias "large-bias" Gate
            "a bias above 0.35 g"
            "used"
            "check unit and zero offset; the sensor may be damaged";
        TurnsIncomplete "turns-incomplete" Note
            "not every axis has a full turn"
            "the turns do not calibrate the gyroscope"
            "record the missing turns";
        GyroMotionGap "gyro-motion-gap" Warning
            "motions between poses of more than 60 s, with a break, or without a reading for more than 4.5 periods"
            "not used for the gyroscope"
            "check the lines";
        GyroMotionClipped "gyro-motion-clipped" Warning
            "motions in which the gyroscope reaches the end of its range"
            "not used for the gyroscope"
            "rotate more slowly, or record with a wider range";
        GyroMotionOutlier "gyro-motion-outlier" Warning
            "motions that contradict the others"
            "not used for the gyroscope"
            "check the lines for bumps and lost samples";
        GyroUndetermined "gyro-undetermined" Note
            "the motions do not determine the whole matrix of the gyroscope to 3 %"
            "only the bias is estimated; the scale is nominal"
            "rotate about the axes that the message names, with that axis level";
        GyroMisfit "gyro-misfit" Warning
            "after a typical motion the direction of gravity is wrong by more than 3°"
            "computed anyway"
            "check the clock, the rate and the calibration of the accelerometer";
        GyroLeftHanded "gyro-left-handed" Warning
            "gyroscope and accelerometer differ in handedness"
            "after calibration they agree"
            "correct the sign of one axis if it is a mistake";
        GyroScaleOff "gyro-scale-off" Warning
            "the scale factor of the gyroscope differs by more than 10 % from nominal"
            "used"
            "check range, unit and order of the columns";
        GyroScaleFound "gyro-scale-found" Note
            "the range of the gyroscope counts is not stated"
            "the scale is determined from the motions"
            "nothing";
        GyroScaleUnknown "gyro-scale-unknown" Note
            "the range of the gyroscope is not stated, and no motion determines the scale"
            "the gyroscope is not calibrated"
            "give `--gyro-unit`, and `--gyro-range` for counts";
        GyroRateUnknown "gyro-rate-unknown" Note
            "neither time stamps nor `--rate`: rotations cannot be integrated"
            "only the bias of the gyroscope is estimated"
            "give `--rate`";
        TurnedOtherWay "turned-other-way" Gate
            "the direction of a turn contradicts `--turn-angle`"
            "computed as given: R_g has a negative diagonal"
            "give the angle with the other sign";
        PoorCalibration "poor-calibration" Warning
            "`apply`, `check`, `compare`: the verdict of the calibration is poor"
            "used anyway"
            "fix what the verdict names";
        AlreadyCalibrated "already-calibrated" Warning
            "the columns have the names of calibrated columns, or the board says that it calibrates"
            "`apply` and files given by name: used anyway, in `motion` with wider bands; files of a folder: ignored"
            "give the raw recording; from a board that calibrates: `gravical log --format si`";
        SameFileTwice "same-file-twice" Warning
            "two inputs are identical"
            "both are used"
            "give it once";
    }
    "Denoise" {
        LostSamplesFilled "lost-samples-filled" Note
            "samples are missing"
            "interpolated linearly for the filter; not written"
            "nothing";
        Resampled "resampled" Warning
            "uneven sampling"
            "interpolated to an even grid for the filter and back, which also smooths"
            "sample at an even rate";
        Parted "parted" Warning
            "time steps longer than ten usual ones, or decreasing time stamps"
            "the filters restart there"
            "check the lines named by `gap` and `backward-time`";
        StampsFilled "stamps-filled" Warning
            "rows without a time stamp"
            "assumed evenly spaced between their neighbours"
            "check the lines named by `absent-time`";
        EmptyKept "empty-kept" Warning
            "cells without a value"
            "they stay empty and are treated as lost samples by the filter"
            "nothing";
        NotFiltered "not-filtered" Warning
            "segments between gaps or breaks are shorter than the filter needs"
            "not filtered"
            "use a shorter window, or a recording without gaps";
        ShortForCutoff "short-for-cutoff" Warning
            "one period of the cutoff frequency is longer than the recording"
            "filtered anyway; the ends dominate the result"
            "use a higher cutoff";
        EvenWindow "even-window" Warning
            "`savgol` with an even window"
            "the output is delayed by half a sample"
            "use an odd window";
        Delayed "delayed" Note
            "`butter1`, `highpass1`"
            "the output is delayed, as on a microcontroller"
            "use `butter` or `highpass` for a recording";
        NeverStatic "never-static" Note
            "no static interval was found"
            "there is no pose to calibrate with; `denoise` filters, but does not measure what that does to the noise"
            "for a calibration, lay the sensor down for 3 s or more";
    }
    "Motion" {
        NoGyro "no-gyro" Warning
            "no gyroscope: the tilt between rests is not measured"
            "it is that of the rests; the band allows for half a degree in between"
            "record a gyroscope, or keep the sensor level";
        GyroNotUsed "gyro-not-used" Warning
            "the unit of the gyroscope is unknown"
            "motion is computed without it"
            "give `--gyro-unit`, and `--gyro-range` for counts";
        DeadGyro "dead-gyro" Warning
            "the gyroscope never changes"
            "motion is computed without it"
            "check wiring and code";
        CovarianceUnknown "covariance-unknown" Note
            "the calibration has no covariance"
            "typical uncertainties are assumed for the band"
            "calibrate again from the recordings";
        GravityOff "gravity-off" Either
            "at rest the magnitude differs from gravity"
            "with a calibration the bands are widened; without, the message gives the effect of a scale error"
            "calibrate, or test the calibration with `gravical check`";
        ValuesReplaced "values-replaced" Warning
            "values in a move stand at the end of the range, or far from all around them"
            "they follow what is on both sides; the band holds what they may have been"
            "record at a wider range; check the wiring";
        AveragedRowsMove "averaged-rows-move" Warning
            "the sensor moves within the rows whose mean is subtracted"
            "their mean is subtracted all the same"
            "hold the sensor still for longer at the start";
        ClosureContradicts "closure-contradicts" Warning
            "at the end of a move the closure of velocity or tilt exceeds its uncertainty"
            "the band of that move is widened accordingly"
            "rest for 2 s before and after a move; calibrate; stay within the ranges of the sensors";
        SlowMovesHidden "slow-moves-hidden" Note
            "a rest of 14 s or more, or no move at all: a slow or small move would not be visible"
            "the message gives its largest displacement"
            "move faster";
        StartsMoving "starts-moving" Warning
            "the recording starts in motion"
            "computed backwards from the first rest"
            "rest before the first move";
        EndsMoving "ends-moving" Warning
            "the recording ends in motion"
            "computed forwards from the last rest without drift correction"
            "rest after the last move";
        RowsLeftOut "rows-left-out" Note
            "incomplete rows, or rows whose time stamp is not after that of the row before"
            "skipped; the time step spans them"
            "nothing";
        V0NotUsed "v0-not-used" Warning
            "`--v0` is given together with zero-velocity updates at rests"
            "not used"
            "remove it, or give `--zero-velocity off`";
        MoveUnusable "move-unusable" Warning
            "rows are missing while the sensor moves, or its only rest is shorter than 1 s"
            "that displacement and all later positions are unknown"
            "record again; exit code 4 if no move is usable";
        TruthGaps "truth-gaps" Note
            "rows of the reference without a position"
            "skipped"
            "nothing";
        TruthLines "truth-lines" Warning
            "lines of the reference that are not rows"
            "skipped"
            "check them";
        TruthOffset "truth-offset" Warning
            "the speeds are too dissimilar to determine the time offset"
            "zero if the time ranges overlap, else the best one"
            "let both see a move from its start to its end";
        TruthMoves "truth-moves" Note
            "moves that are not usable, or whose ends the reference does not cover"
            "not compared individually"
            "nothing";
    }
    "Noise" {
        NoiseFromRests "noise-from-rests" Warning
            "`noise`: the sensor moved in a part of the recording"
            "the longest static intervals are used"
            "record it lying still throughout";
        NoiseBumps "noise-bumps" Note
            "`noise`: short disturbances in a static interval, e.g. a knock on the table"
            "left out like gaps"
            "nothing; many of them: another place, another time of day";
        NoiseGaps "noise-gaps" Note
            "`noise`: missing rows or breaks within a static interval"
            "each ends a segment; the segments are pooled by their numbers of differences"
            "nothing, unless long averaging times are wanted";
        NoiseSamplesFilled "noise-samples-filled" Either
            "`noise`: up to eight consecutive samples are missing; a warning from 5 % of the samples"
            "replaced by samples a moment before, which have the noise of the sensor"
            "nothing; many: find out why rows are lost";
        NoiseBelowResolution "noise-below-resolution" Warning
            "`noise`: the noise is smaller than a third of the resolution of a channel"
            "an upper limit of N; no other parameter"
            "record raw counts, or print more decimals";
        NoiseFiltered "noise-filtered" Note
            "`noise`: for the shortest averaging times the noise is not white, as behind a low-pass"
            "the fit begins where it is"
            "nothing";
        NoiseMisfit "noise-misfit" Warning
            "`noise`: the Allan variance deviates from the model by more than chance"
            "the parameters are those of the best curve"
            "look at the figure; a bump is a vibration: a fan, the mains, footsteps";
        NoiseDensityDiffers "noise-density-differs" Warning
            "`noise`: the power spectral density at 1 to 10 Hz disagrees with the fitted curve by more than 15 %"
            "nothing"
            "look for vibration; compare `density` in the JSON";
        NoiseDrift "noise-drift" Warning
            "`noise`: the bias of a channel drifts steadily, as it does while a sensor warms up"
            "the line is removed before B and K are estimated; the curve in the figure contains it"
            "record after half an hour of warming, at constant temperature";
        NoiseTemperature "noise-temperature" Either
            "`noise`: the temperature moved; a warning if it explains most of the slow changes of a channel"
            "B and K are not corrected"
            "record at constant temperature, after half an hour of warming";
        NoiseChannelEmpty "noise-channel-empty" Warning
            "`noise`: a channel has hardly two samples in a row"
            "the channel is left out"
            "look at the cells of its column";
        NoiseUsed "noise-used" Note
            "`motion --noise`: N of the Allan deviation is used in place of the noise at rest"
            "the bands follow it"
            "nothing";
    }
    "Check and compare" {
        SameRecordings "same-recordings" Warning
            "both calibrations share recordings, or `check` was given a recording of the calibration"
            "agreement proves nothing; `check` does not count the intervals that the calibration was fitted to; alone they give `undecided`"
            "make a new recording";
        GravityDiffers "gravity-differs" Warning
            "two values of gravity"
            "`compare` counts the uncertainty of both; `check` uses the given one"
            "use the same `--gravity` for both if they were made in one place";
        FramesMirrored "frames-mirrored" Warning
            "`compare`: one calibration is the mirror image of the other"
            "they differ"
            "look for two poses that were swapped";
        IntervalsLeftOut "intervals-left-out" Note
            "`check`: more than 400 static intervals"
            "the longest are used"
            "nothing; split the recording if the others matter";
    }
}

impl FindingKind {
    fn row(self) -> Option<&'static Row> {
        ROWS.get(self as usize)
    }

    /// Its stable name for scripts: `unit-mismatch`, `torn-line` ….
    #[must_use]
    pub fn name(self) -> &'static str {
        self.row().map_or("other", |row| row.name)
    }

    /// The usual severity; where it is found it may differ.
    #[must_use]
    pub fn severity(self) -> Severity {
        match self.row().map(|row| row.weight) {
            Some(Note) => Severity::Note,
            _ => Severity::Warning,
        }
    }

    /// True for a kind that makes a calibration poor.
    #[must_use]
    pub fn is_gate(self) -> bool {
        self.row().is_some_and(|row| row.weight == Gate)
    }

    /// True if samples were lost or could not be read.
    pub(crate) fn is_loss(self) -> bool {
        use FindingKind as K;
        matches!(
            self,
            K::NamedGap
                | K::TornLine
                | K::TooManyFields
                | K::NotANumber
                | K::ZeroRows
                | K::TruncatedFile
                | K::EmptyCells
                | K::MissingSamples
                | K::FrozenAxis
        )
    }

    /// True for what the values show once there are enough: a channel that does not change, the end
    /// of the range.
    #[must_use]
    pub fn is_of_samples(self) -> bool {
        use FindingKind as K;
        matches!(
            self,
            K::FrozenAxis | K::Clipped | K::RepeatedRows | K::SensorHung
        )
    }

    /// The kind of that name.
    #[must_use]
    pub fn of_name(name: &str) -> Option<Self> {
        let is_it = |kind: &&FindingKind| kind.name() == name;
        FindingKind::ALL.iter().find(is_it).copied()
    }

    /// The table of the kinds of `section` in Markdown.
    #[must_use]
    pub fn table(section: &str) -> String {
        let mut text =
            "| kind | | meaning | what was done | what you should do |\n|---|---|---|---|---|\n"
                .to_owned();
        for row in ROWS.iter().filter(|row| row.section == section) {
            let weight = match row.weight {
                Note => "note",
                Warning => "warning",
                Either => "note, or warning",
                Gate => "warning, [gate](#quality-gates)",
            };
            text += &format!(
                "| `{}` | {weight} | {} | {} | {} |\n",
                row.name, row.meaning, row.done, row.remedy
            );
        }
        text
    }

    /// Sections of the tables, in order.
    #[must_use]
    pub fn sections() -> Vec<&'static str> {
        let mut sections: Vec<&str> = ROWS.iter().map(|row| row.section).collect();
        sections.dedup();
        sections
    }
}

impl fmt::Display for FindingKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl PartialEq<str> for FindingKind {
    fn eq(&self, name: &str) -> bool {
        self.name() == name
    }
}

impl PartialEq<&str> for FindingKind {
    fn eq(&self, name: &&str) -> bool {
        self.name() == *name
    }
}

impl Serialize for FindingKind {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl<'de> Deserialize<'de> for FindingKind {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        Ok(FindingKind::of_name(&name).unwrap_or(FindingKind::Other))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_has_a_name_of_its_own_and_its_row() {
        assert_eq!(ROWS.len(), FindingKind::ALL.len());
        for (i, kind) in FindingKind::ALL.iter().enumerate() {
            assert_eq!((*kind as usize, kind.name()), (i, ROWS[i].name));
            assert_eq!(FindingKind::of_name(kind.name()), Some(*kind));
            let kebab = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
            assert!(kind.name().chars().all(kebab), "{kind}");
        }
        let json = "\"of-tomorrow\"";
        assert_eq!(
            serde_json::from_str::<FindingKind>(json).unwrap(),
            FindingKind::Other
        );
    }
}

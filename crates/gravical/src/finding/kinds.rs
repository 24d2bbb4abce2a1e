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
        MetadataLines "metadata-lines" Note
            "lines before the header"
            "kept out of the data; a claimed rate is read from them"
            "nothing";
        CommentLines "comment-lines" Note
            "lines that begin with `#`, `%` or `//` among the data"
            "kept out"
            "nothing";
        NamedGap "named-gap" Warning
            "a line `# gap: …`: [the logger](logging.md) names rows that it could not get"
            "taken as a break; the clock may start anew there"
            "nothing for a mean; find out why";
        RegularBlankRows "regular-blank-rows" Note
            "blank lines between the rows all through the file, every so many rows: line ends that were written twice, say"
            "they part nothing; more of them in a row than usual do (`blank-rows`)"
            "nothing";
        BlankRows "blank-rows" Note
            "empty lines, or lines of delimiters only"
            "taken as a break between placements, but for a single line where the clock goes on"
            "nothing, if a break was meant";
        RepeatedHeader "repeated-header" Warning
            "the header once more in the middle"
            "kept out; taken as a break"
            "look for two recordings in one file";
        HeaderChanged "header-changed" Warning
            "a header in the middle names other columns, another order or another unit than the first"
            "its rows are read as the first header has them: columns in its order, values in its unit; where that cannot be, it is an error (`header-differs`)"
            "look for two recordings in one file";
        OtherSensor "other-sensor" Note
            "rows of another sensor than the one that is read (`several-sensors`)"
            "not read"
            "nothing";
        TornLine "torn-line" Warning
            "fewer fields than the other rows"
            "set aside"
            "nothing for a single last line; many mean a bad connection";
        TooManyFields "too-many-fields" Warning
            "more fields than the other rows"
            "set aside"
            "look whether lines run together; lower the baud rate or the sample rate";
        NotANumber "not-a-number" Warning
            "a channel that is no number"
            "set aside"
            "look at the line";
        ZeroRows "zero-rows" Warning
            "the accelerometer reads zero on all axes: with the gyroscope too, or in five rows in a row"
            "the sensor was not read: taken as empty cells"
            "check the wiring";
        ZeroTail "zero-tail" Warning
            "rows of zeros up to the end of the file"
            "set aside as never written; `apply` and `motion --causal` take more than 65,536 of them for rows that are empty"
            "nothing";
        NulBytes "nul-bytes" Warning
            "NUL bytes in lines"
            "taken out"
            "expect a damaged file; close the file before unplugging";
        NotUtf8 "not-utf8" Note
            "text in another encoding"
            "read as Windows-1252, or as the UTF-16 that it is"
            "nothing";
        TruncatedFile "truncated-file" Warning
            "a gzip file ends in the middle"
            "what could be unpacked is used"
            "copy the file again";
    }
    "Columns and files" {
        FirstRowsDiffer "first-rows-differ" Warning
            "clock, cells or units of all rows are others than those of the first 256 KiB, by which `apply` and `motion --causal` read a recording"
            "read by the first rows"
            "say what is right (`--accel-unit`, `--time-unit`, `--rate`), or cut off the rows that differ";
        ColumnsGuessed "columns-guessed" Warning
            "there is no header, or a line of names that does not fit the columns"
            "the numbers decided; the message says how"
            "give the printed `--columns` option";
        NotAnAccelerometer "not-an-accelerometer" Warning
            "columns taken by their numbers behave like a gyroscope"
            "used all the same"
            "give `--columns`";
        SeveralSensors "several-sensors" Warning
            "more than one accelerometer, in columns side by side or in rows that a column (`I`, `instance`, `sensor_id`) tells apart"
            "the first is read"
            "choose another with `--sensor`, as the message says";
        UnnamedClock "unnamed-clock" Warning
            "no column is named as the time, and one rises steadily, or several do"
            "the only one is taken; of several none"
            "give the printed `--columns t=…`; `--columns t=-` takes none";
        WithoutGravity "without-gravity" Warning
            "at rest the acceleration is near zero, or named as linear and not as long as gravity: the device took gravity out"
            "the unit stays unknown; `calibrate` stops (`unit-unknown`)"
            "record the raw acceleration, or take its file: `Acceleration (with g)` in phyphox, `TotalAcceleration.csv` of Sensor Logger";
        NoRecording "no-recording" Note
            "a file of the folder holds no recording: text, such as a licence, or other columns"
            "left out"
            "nothing";
        FolderLeftOut "folder-left-out" Note
            "a folder in the folder holds files that may be recordings"
            "not read"
            "give it by itself, if it is a session";
        GyroJoined "gyro-joined" Note
            "one recording, and beside it one file with a gyroscope alone"
            "joined on time, as `--gyro` does"
            "nothing";
        GyroLeftOut "gyro-left-out" Either
            "a file with a gyroscope alone beside several recordings, or one whose time does not fit"
            "left out: it is no placement"
            "with one recording, `--gyro` says which file belongs to it";
        GyroRowByRow "gyro-row-by-row" Note
            "`--gyro`: not both files have time stamps"
            "joined row by row"
            "look whether both start with the same sample";
        GyroInterpolated "gyro-interpolated" Note
            "`--gyro`: rows of the accelerometer lie between two stamps of the gyroscope"
            "its rate is interpolated linearly"
            "nothing";
        GyroUncovered "gyro-uncovered" Warning
            "`--gyro`: rows of the accelerometer have no reading of the gyroscope near them"
            "empty there; motions with such rows are left out"
            "start both before the session, and stop them after it";
        RenamedColumn "renamed-column" Note
            "`apply`: the input has a column with the name of a calibrated one"
            "kept as `input_…`"
            "nothing";
    }
    "Time" {
        TimeUnitAssumed "time-unit-assumed" Warning
            "the unit of the stamps is not stated, and more than one fits"
            "the likeliest was taken; the message says which"
            "give `--time-unit`";
        TimeUnitUnknown "time-unit-unknown" Warning
            "the steps fit no unit, or no rate that a sensor has"
            "the stamps are not used"
            "give `--time-unit` or `--rate`";
        FrozenTime "frozen-time" Warning
            "the stamps never advance"
            "not used"
            "give `--rate`";
        AbsentTime "absent-time" Warning
            "some rows have no stamp"
            "the rows are kept"
            "look at the lines";
        WrappedTime "wrapped-time" Note
            "a counter of 16, 24 or 32 bits overflowed, or a clock began anew at the end of a second, a minute, an hour, a day or a week"
            "unwrapped"
            "nothing";
        RestartedTime "restarted-time" Warning
            "the stamps start anew: the board was reset"
            "taken as a break; the clock goes on"
            "find out why it was reset";
        BackwardTime "backward-time" Warning
            "stamps run backwards"
            "kept as recorded"
            "look at the lines";
        DuplicateTime "duplicate-time" Warning
            "stamps repeat"
            "the rows are kept"
            "use a finer clock, or a lower rate";
        BurstTime "burst-time" Warning
            "many rows share a stamp, then a long step: times of arrival, clocks of whole seconds, or stamps that a spreadsheet rounded"
            "the mean rate between the first and the last change is used instead"
            "stamp the samples on the board";
        Gap "gap" Warning
            "more than four samples are missing in one place"
            "named with the longest"
            "nothing for a mean";
        Pause "pause" Note
            "where the recording is parted, by blank lines or a header, the stamps jump: it was stopped and goes on"
            "nothing is counted as missing there, and the pause does not lower the rate"
            "nothing";
        MissingSamples "missing-samples" Warning
            "more than 0.1 % of the samples are missing"
            "counted"
            "lower the rate, or raise the baud rate";
        RateMismatch "rate-mismatch" Warning
            "the claimed rate is more than 2 % off"
            "the stamps are used"
            "correct the claim";
        RateUnknown "rate-unknown" Note
            "neither stamps nor `--rate`"
            "stills are looked for as at 100 Hz"
            "give `--rate`";
    }
    "Units" {
        UnitMismatch "unit-mismatch" Warning
            "header, option or calibration say one unit, gravity or the turns show another"
            "against a header the data win; an option is obeyed; `apply` refuses unless `--accel-unit` insists"
            "correct the header";
        UnitChanged "unit-changed" Gate
            "at rest the magnitude jumps from one unit, or range, to another, and no header says so"
            "used all the same; `apply` and `motion --causal` stop, unless `--accel-unit` insists"
            "cut the file in front of the line";
        UnitUnknown "unit-unknown" Warning
            "gravity fits no unit, or several"
            "`inspect` goes on; `calibrate` stops"
            "give `--accel-unit`: `mg`, or `counts` for counts of any scale";
        WrongFullScale "wrong-full-scale" Warning
            "the magnitude at rest is gravity times a power of two: the chip was set to another range than the program that wrote the file assumed"
            "`inspect` goes on; `calibrate` stops (`unit-unknown`)"
            "correct the factor where the file is written, or record again with one range";
        RangeMismatch "range-mismatch" Warning
            "`--accel-range`, or the board's own line, says one range, gravity at rest shows another"
            "the option is taken as given; against the board's line gravity decides"
            "leave the option out, or correct it";
        UnsignedCounts "unsigned-counts" Note
            "16-bit values around 32768"
            "32768 is subtracted; no range is claimed; the bias contains it again"
            "nothing, or `--zero-offset`";
        GyroUnitUnverified "gyro-unit-unverified" Note
            "no turn between stills shows the unit of the gyroscope"
            "that of the calibration or of the header is taken, if there is one"
            "give `--gyro-unit` where it matters";
        GyroUnitByNoise "gyro-unit-by-noise" Warning
            "no turn shows the unit of the gyroscope, and no header does, or it is wrong about the accelerometer; its noise at rest tells rad/s from °/s"
            "that unit is taken"
            "give `--gyro-unit` where it matters";
        UnitUnverified "unit-unverified" Note
            "`apply`, `check`, `compare`: nothing shows whether the recording is in the calibration's unit"
            "taken as the same"
            "compare the magnitude at rest with gravity";
        UnitsConverted "units-converted" Note
            "`compare`: one calibration takes counts, the other g or m/s² (or one of them unsigned counts)"
            "both are brought to m/s² by the nominal scale"
            "nothing";
    }
    "Samples" {
        Clipped "clipped" Warning
            "values at the end of the range: counts from 32764 on; in physical units repeats of the largest value at a full scale that is sold, or at `--gyro-range`"
            "used all the same"
            "record at a wider range";
        FrozenAxis "frozen-axis" Warning
            "an axis keeps one value for 100 rows, beside another of its sensor that scatters by more than its last digit hides, or while both others move far; one that lies still with coarse digits is not meant"
            "used all the same"
            "look at wiring and code; the axis may be dead";
        RepeatedRows "repeated-rows" Warning
            "all through the recording rows repeat the row before in every channel, and the next new one is more than two steps of the last digit away; rows that repeat at rest since the digits are coarse are not meant"
            "used all the same"
            "read no faster than the sensor measures";
        EmptyCells "empty-cells" Warning
            "cells without a value"
            "left empty, and out of means; where each channel is written when it arrives, the last value is held"
            "nothing, or record whole rows";
        TemperatureModel "temperature-model" Note
            "the drift of these channels with temperature can be predicted"
            "it is taken off; the means of the placements are brought to one temperature"
            "nothing";
        TemperatureRefused "temperature-refused" Warning
            "the temperature moves while still, but no channel's drift can be predicted"
            "none is taken off; the reasons stand in the table"
            "see [method.md](method.md#drift-with-temperature)";
        TemperatureReference "temperature-reference" Warning
            "a soak was given, but the placements have no temperature"
            "bias and matrix are taken to hold at the middle of the soak"
            "record the temperature with the session";
        TemperatureOutside "temperature-outside" Warning
            "rows, or the placements, are outside of the temperatures of the soak"
            "the drift at the edge is held"
            "soak over all temperatures of use";
        TemperatureHeld "temperature-held" Note
            "`apply`: rows without a temperature"
            "the last one known is taken"
            "nothing";
        TemperatureNotApplied "temperature-not-applied" Warning
            "`apply`: the calibration has a temperature model, the recording (or its first rows) no temperatures"
            "the drift stays; the message says how large it may be"
            "record the temperature";
        GyroUnitUnknown "gyro-unit-unknown" Warning
            "`--method thermal`: nothing tells the unit of the gyroscope"
            "it is left as it is"
            "give `--gyro-unit`";
        TemperatureUnit "temperature-unit" Note
            "the temperature column is far from any °C, such as raw counts"
            "it is not used"
            "log °C, if you want the temperature in the file";
    }
    "Placements" {
        MotionLeftOut "motion-left-out" Note
            "a tenth or more of a file is motion, or shorter stills of the same placement"
            "the longest still is used"
            "nothing";
        RowsAsPlacements "rows-as-placements" Note
            "a few rows without a still, alike in magnitude and far apart in direction"
            "each is taken as the mean of a placement"
            "name the rows in a label column to be sure";
        LabelsLeftOut "labels-left-out" Note
            "labels that name no placement and no turn"
            "their rows are left out"
            "check the spelling";
        EmptyPlacement "empty-placement" Warning
            "a placement that a section or label names has no value of one axis in any of its rows"
            "it is left out"
            "look at these rows, or leave the section out";
        ShortHold "short-hold" Warning
            "a stretch too short to look for a still in"
            "all its rows are taken"
            "record 3 s or more";
        FewRows "few-rows" Warning
            "`--rows` asks for more rows than a placement has"
            "all it has are taken"
            "record longer, or ask for fewer";
        NoStill "no-still" Warning
            "a stretch that is never still"
            "left out"
            "record it again";
        UnsteadyHold "unsteady-hold" Warning
            "never quite still, as in the hand"
            "the calmest part is taken; the message says how much it shakes"
            "lay it down and record it again";
        OrientationMismatch "orientation-mismatch" Warning
            "a name claims another side than gravity shows"
            "the data are believed"
            "rename the file";
        NamesReversed "names-reversed" Note
            "all six names say the opposite of the data"
            "the data are believed"
            "nothing where a sign means the axis that points *down*; `--axes -x,-y,-z` where the sensor reads −g on the axis that points up, as iPhones do";
        NamesTurned "names-turned" Warning
            "the names describe a board that sits turned in its case"
            "the data are believed: axes of the board"
            "give `--axes` if the case is meant";
        NamesMirrored "names-mirrored" Gate
            "no way of mounting explains the names"
            "the data are believed"
            "find the two recordings that were swapped";
        StillsShortened "stills-shortened" Note
            "stills of a [long recording](#long-recordings) have no room in memory as a whole"
            "the first and the last seconds of them are used; the message says how many"
            "nothing; cut the recording where all rows matter";
        MotionsLeftOut "motions-left-out" Note
            "motions between stills of a [long recording](#long-recordings) have no room in memory"
            "those beside a still that is left out, those longer than 60 s, and the longer ones about each axis are not used for the gyroscope"
            "nothing; cut the recording where they matter";
    }
    "Result" {
        GravityAssumed "gravity-assumed" Note
            "local gravity was not given"
            "9.80665 m/s² is used: up to 0.27 % of scale at sea level"
            "give `--latitude` and `--altitude`, or `--gravity`";
        BadPose "bad-pose" Warning
            "the magnitude of one placement contradicts all others by more than chance"
            "left out of the fit; the table shows what it reads"
            "was it moving? record it again";
        RepeatsContradict "repeats-contradict" Warning
            "placements of one direction differ in magnitude by more than chance, as many one way as the other"
            "all of them count; the model error, and with it every uncertainty, is larger"
            "record that side again when the sensor is warm";
        NoFace "no-face" Warning
            "a placement is named a face but lies so far off that a deliberate lean is likelier"
            "used as a free pose: its magnitude counts, its direction does not"
            "lay it down again, or `--face NAME`";
        MissingFace "missing-face" Gate
            "faces only, and one of the six is not there"
            "computed; the message says how badly the magnitude is known with that side up"
            "record it, or any oblique placements";
        SameFaceTwice "same-face-twice" Gate
            "one side is there twice, once under the name of a side that is missing (or as two of six placements)"
            "computed without the side that is missing"
            "record the file that the message names again";
        SamePlacement "same-placement" Note
            "some repeats of a side lay the same way"
            "they share one tilt: they average noise only"
            "turn the sensor by 180° on the table between repeats";
        OrientationOpen "orientation-open" Note
            "no faces on two axes, or a method that knows no faces"
            "the matrix is triangular by convention"
            "record faces if directions matter; the magnitude does not need them";
        IllConditioned "ill-conditioned" Either
            "the magnitudes alone tell nine parameters apart badly (condition above 30)"
            "`joint` uses faces and data sheet too (a note); `magnitude9` and `magnitude6` have nothing else (a warning)"
            "record the placements that the verdict proposes";
        CrossAxisHigh "cross-axis-high" Warning
            "two axes are further from a right angle than 2.9°; a data sheet allows 1.6°"
            "computed"
            "too few placements for the method, or a wrong one";
        ModelError "model-error" Warning
            "the placements contradict each other by more than 20 mm/s² beyond their noise"
            "it is part of the uncertainty"
            "keep the sensor still, and warm it up first";
        NoiseAssumed "noise-assumed" Note
            "the rows are means whose scatter nobody knows"
            "4 mm/s² are assumed for the uncertainty"
            "give the recordings instead of their means";
        FacesExact "faces-exact" Warning
            "`--method linear12` takes every side as exactly level"
            "its uncertainty does not contain the tilt"
            "use it with a precise fixture only";
        FaceTilt "face-tilt" Warning
            "a side lies more than 10° off (bias included)"
            "used"
            "lay it down again";
        ObliqueOff "oblique-off" Gate
            "oblique placements, which took no part in the fit, read the magnitude off by more than three times what was predicted"
            "computed all the same"
            "look whether the sensor moved there, and at the six sides";
        PlacementTilt "placement-tilt" Warning
            "the sides together lie further off than 1.6 times the usual 1°"
            "the uncertainty is computed with the tilt that they show"
            "use a box or a jig, or give `--placement-tilt` if you know better";
        ClippedHold "clipped-hold" Gate
            "clipped samples in a placement"
            "used; its mean is too small"
            "record at a wider range";
        ScaleHigh "scale-high" Warning
            "a scale is more than 5 % from nominal"
            "used"
            "data sheets allow 3 %: check range and gravity";
        ScaleOff "scale-off" Gate
            "a scale is more than 10 % from nominal"
            "used"
            "the unit or the range is wrong";
        BiasHigh "bias-high" Warning
            "a bias of more than twice what a data sheet allows (±0.6 m/s²)"
            "used"
            "check placements and unit; `--prior off` if the part is like that";
        LargeBias "large-bias" Gate
            "a bias above 0.35 g"
            "used"
            "check unit and zero offset; the part may be damaged";
        TurnsIncomplete "turns-incomplete" Note
            "not every axis has its full turn"
            "the turns do not calibrate the gyroscope"
            "record the missing turns";
        GyroMotionGap "gyro-motion-gap" Warning
            "motions between stills with a break, or without a reading for more than 4.5 periods"
            "left out of the gyroscope's fit"
            "look at the lines";
        GyroMotionClipped "gyro-motion-clipped" Warning
            "motions in which the gyroscope reaches the end of its range"
            "left out of the gyroscope's fit"
            "turn more slowly, or record at a wider range";
        GyroMotionOutlier "gyro-motion-outlier" Warning
            "motions that contradict the others"
            "left out of the gyroscope's fit"
            "look at the lines: a bump, lost samples?";
        GyroUndetermined "gyro-undetermined" Note
            "the motions determine not all of the gyroscope's matrix to 3 %"
            "it gets its bias only, with the nominal scale"
            "turn it about the axes that the message names, with that axis level";
        GyroMisfit "gyro-misfit" Warning
            "the usual motion misses gravity by more than 3°"
            "computed all the same"
            "look at the clock, the rate and the accelerometer's calibration";
        GyroLeftHanded "gyro-left-handed" Warning
            "gyroscope and accelerometer differ in handedness"
            "calibrated, both agree"
            "correct the sign of one axis, if it is a mistake";
        GyroScaleOff "gyro-scale-off" Warning
            "the gyroscope's scale is more than 10 % from nominal"
            "used"
            "look at range, unit and order of the columns";
        GyroScaleFound "gyro-scale-found" Note
            "nothing says the scale of the gyroscope's counts"
            "the motions give it"
            "nothing";
        GyroScaleUnknown "gyro-scale-unknown" Note
            "nothing says the scale, and no motion gives it"
            "the gyroscope is not calibrated"
            "give `--gyro-unit`, and `--gyro-range` for counts";
        GyroRateUnknown "gyro-rate-unknown" Note
            "neither stamps nor `--rate`: turns cannot be integrated"
            "the gyroscope gets its bias only"
            "give `--rate`";
        TurnedOtherWay "turned-other-way" Gate
            "a turn went the other way than `--turn-angle` says"
            "computed as told: R_g has a negative diagonal"
            "give the angle with the other sign";
        PoorCalibration "poor-calibration" Warning
            "`apply`, `check`, `compare`: the calibration's own verdict is poor"
            "used all the same"
            "mend what the verdict names";
        AlreadyCalibrated "already-calibrated" Warning
            "the columns are named as this program names calibrated ones"
            "`apply` and files that you name: used all the same; in a folder: left out"
            "give the raw recording";
        SameFileTwice "same-file-twice" Warning
            "two inputs are the same, byte for byte"
            "both count"
            "give it once";
    }
    "Denoise" {
        FittedOverStamps "fitted-over-stamps" Note
            "some windows hold uneven steps"
            "there the polynomial is fitted over the stamps themselves"
            "nothing";
        TooFewStamps "too-few-stamps" Warning
            "windows in which so many stamps are the same that the polynomial is not determined"
            "filtered as if even"
            "use a finer clock";
        LostSamplesFilled "lost-samples-filled" Note
            "samples are missing between the stamps"
            "put in by linear interpolation for the filter; not written"
            "nothing";
        Resampled "resampled" Warning
            "samples came at uneven times"
            "interpolated to an even grid for the filter and back, which smooths by itself"
            "sample at an even rate, or take `savgol`";
        Parted "parted" Warning
            "steps longer than ten usual ones, or stamps that run backwards"
            "the filters begin anew there"
            "look at the lines that `gap` and `backward-time` name";
        StampsFilled "stamps-filled" Warning
            "rows without a time stamp"
            "taken to lie evenly between their neighbours"
            "look at the lines that `absent-time` names";
        EmptyKept "empty-kept" Warning
            "cells without a value"
            "they stay empty; the samples around them are filtered as if one were lost"
            "nothing";
        NotFiltered "not-filtered" Warning
            "stretches between gaps or breaks that are shorter than the filter takes"
            "they stay as they are"
            "a shorter window, or a recording without gaps";
        ShortForCutoff "short-for-cutoff" Warning
            "one period of the cutoff lasts longer than the recording"
            "filtered all the same: the ends decide the result"
            "a higher cutoff";
        EvenWindow "even-window" Warning
            "`savgol` with an even window"
            "the values belong half a step later"
            "take an odd one";
        Delayed "delayed" Note
            "`butter1`, `highpass1`"
            "the result lags behind, as on a microcontroller"
            "take `butter` or `highpass` for a recording";
        NeverStill "never-still" Note
            "no span at rest was found"
            "filtered; the effect on the noise is not measured"
            "nothing";
    }
    "Motion" {
        NoGyro "no-gyro" Warning
            "no gyroscope: the tilt between rests is not measured"
            "it goes from that of one rest to that of the next; the band allows for `--wobble`"
            "record the gyroscope, or keep the sensor level";
        GyroNotUsed "gyro-not-used" Warning
            "the unit of the gyroscope cannot be told"
            "motion is computed without it"
            "give `--gyro-unit`, and `--gyro-range` for counts";
        DeadGyro "dead-gyro" Warning
            "the gyroscope never changes"
            "motion is computed without it"
            "check wiring and code";
        CovarianceUnknown "covariance-unknown" Note
            "the calibration does not state its covariance"
            "usual uncertainties are assumed for the band"
            "calibrate again from the recordings";
        GravityOff "gravity-off" Either
            "at rest the magnitude is not gravity"
            "nothing; the message says what a scale would change"
            "calibrate, or `gravical check` the calibration";
        ConstantSpeed "constant-speed" Note
            "a quiet stretch in which the velocity is far from zero"
            "not taken for a rest"
            "nothing; `--still` says otherwise";
        RestAtSpeed "rest-at-speed" Warning
            "a quiet stretch looks like constant speed, but nothing after it comes nearer to a rest"
            "taken for a rest"
            "name the rests with `--still`";
        ClosureContradicts "closure-contradicts" Warning
            "at the end of a move the velocity is further from zero than its uncertainty allows"
            "the band of that move is widened by what the velocity may have done"
            "lie still for 2 s before and after a move; calibrate; stay within the ranges of the sensors";
        RestTakenBack "rest-taken-back" Note
            "with `--causal`, a short rest from which the velocity does not come to zero at the next one"
            "taken back there: the moves on either side of it are one"
            "nothing";
        SlowMoveDoubted "slow-move-doubted" Warning
            "within a rest the force changes as in a slow move, but not enough to be certain"
            "taken for a rest"
            "name the rests with `--still`, or move faster";
        SlowMovesHidden "slow-moves-hidden" Note
            "a rest of 14 s or more, or no move at all: a slow or small one would not show"
            "the message says how far one may go; without any move the position's band covers it"
            "move faster where you move";
        RestUnconfirmed "rest-unconfirmed" Warning
            "the rests are too short to be told from a part of the move or from constant speed"
            "no move is usable, and nothing has a band"
            "hold it still for 2 s at both ends, or name the rests with `--still`";
        StartsMoving "starts-moving" Warning
            "the recording starts in motion"
            "computed backwards from the first rest"
            "hold it still before you move it";
        EndsMoving "ends-moving" Warning
            "the recording ends in motion"
            "computed forwards from the last rest; nothing corrects the drift"
            "hold it still at the end";
        RowsLeftOut "rows-left-out" Note
            "rows without a whole sample, or whose stamp does not advance"
            "the steps go over them"
            "nothing";
        V0NotUsed "v0-not-used" Warning
            "`--v0` is given, and velocity is zero at rests"
            "it has no part in the result"
            "leave it out, or `--zero-velocity off`";
        StartLost "start-lost" Note
            "something is missing before the first rest"
            "position counts from that rest"
            "nothing";
        GapAtRest "gap-at-rest" Note
            "rows are missing while the sensor rests in one pose"
            "taken as not moved"
            "nothing";
        MoveUnusable "move-unusable" Warning
            "rows are missing while the sensor moves"
            "that displacement, and every position after it, is not known"
            "record again; exit code 4 when no move is usable";
        TruthGaps "truth-gaps" Note
            "rows of the reference without a position"
            "stepped over"
            "nothing";
        TruthLines "truth-lines" Warning
            "lines of the reference that are no rows"
            "left out"
            "look at them";
        TruthUnit "truth-unit" Note
            "no unit in the names of the reference's columns"
            "m or mm, whichever fits the result better"
            "name them `px_m` or `px_mm`";
        TruthOffset "truth-offset" Warning
            "the speeds are too little alike to find the offset of the clocks"
            "none is assumed where the stamps overlap, else the best one"
            "give `--truth-offset`";
        TruthNotLevel "truth-not-level" Warning
            "z of the reference is not up"
            "it is turned by a full rotation, which hides errors of tilt"
            "turn the reference, or give `--truth-align`";
        TruthLine "truth-line" Note
            "the motion is along one line: a turn about it is open"
            "the smallest rotation is taken"
            "nothing";
        TruthMoves "truth-moves" Note
            "moves that are not usable, or whose ends the reference does not see"
            "not compared one by one"
            "nothing";
    }
    "Check and compare" {
        CovarianceMissing "covariance-missing" Warning
            "a calibration does not say how uncertain it is (imucal's never do)"
            "differences are shown; `compare` does not judge them, `check` only errors above 20 mg"
            "calibrate again from the recordings";
        SameCalibration "same-calibration" Warning
            "`compare`: both files hold the same parameters"
            "not judged"
            "give a calibration of another session";
        SameRecordings "same-recordings" Warning
            "recordings of one calibration went into the other, or `check` was given a recording that the calibration was made from"
            "errors are shared: agreement proves nothing"
            "record anew";
        SensorDiffers "sensor-differs" Warning
            "`compare`: two names or types of sensor"
            "compared all the same"
            "give two calibrations of one sensor";
        GravityDiffers "gravity-differs" Warning
            "two values of gravity"
            "`compare` tests once more with both brought to one; `check` takes the one that is given"
            "the same `--gravity` for both, if both were made in one place";
        TemperatureDiffers "temperature-differs" Warning
            "`compare`: the sessions are more than 3 °C apart; the message says what an MPU6050's bias may have moved"
            "nothing: the uncertainties know nothing of it"
            "compare sessions at one temperature";
        FramesMirrored "frames-mirrored" Warning
            "`compare`: one calibration is the mirror image of the other"
            "judged as different"
            "look for two placements that were swapped";
        OrientationUnknown "orientation-unknown" Note
            "`compare`: how the frame of one lies in its case is a convention (too few faces)"
            "the rotation is not judged"
            "nothing, or record faces";
        UndeterminedDirection "undetermined-direction" Note
            "`compare`: the two differ where neither states an uncertainty"
            "that part is not judged"
            "record more poses";
        StillsLeftOut "stills-left-out" Note
            "`check`: more than 400 stills; or a [long recording](#long-recordings) has more than there is room for in memory"
            "the longest are used, of a long recording the longest of each direction"
            "nothing; cut the recording where the others matter";
        OffByShare "off-by-share" Warning
            "`check`: all stills are off by one share"
            "the message gives it"
            "was it the right gravity? else the scale has changed: calibrate again";
        OffAlongAxis "off-along-axis" Warning
            "`check`: a bias that has moved explains the errors"
            "the message names axis and size"
            "calibrate again";
    }
}

impl FindingKind {
    fn row(self) -> Option<&'static Row> {
        ROWS.get(self as usize)
    }

    /// Its name, stable, for scripts: `unit-mismatch`, `torn-line` ….
    #[must_use]
    pub fn name(self) -> &'static str {
        self.row().map_or("other", |row| row.name)
    }

    /// How much it matters, unless it is said otherwise where it is found.
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

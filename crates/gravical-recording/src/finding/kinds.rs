//! Every kind of finding: its name, how much it matters, what it means. What was done about it, and
//! what the user should do, is in the tables of `docs/recording.md`, whose names and severities a test holds to these.

use std::fmt;

use super::{Kind, Weight};

macro_rules! kinds {
    ($($kind:ident $name:literal $weight:ident $meaning:literal;)*) => {
        /// What is odd, as a case that scripts and commands can tell from others.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum FindingKind {
            $(#[doc = $meaning] $kind,)*
        }

        impl FindingKind {
            /// All of them, in the order of the documents.
            pub const ALL: &'static [FindingKind] = &[$(FindingKind::$kind,)*];

            pub(crate) fn row(self) -> Kind {
                let (name, weight) = match self {
                    $(FindingKind::$kind => ($name, Weight::$weight),)*
                };
                Kind { name, weight, meaning: "", done: "", remedy: "" }
            }
        }
    };
}

kinds! {
    NoRecording "no-recording" Note "a file of the folder is not a recording: a text such as a licence, or other columns";
    FolderLeftOut "folder-left-out" Note "a subfolder contains files that may be recordings";
    GyroJoined "gyro-joined" Note "one recording, and one file with only a gyroscope beside it";
    GyroLeftOut "gyro-left-out" Warning "a file with only a gyroscope beside several recordings, or one whose time does not match";
    GyroUnitUnverified "gyro-unit-unverified" Note "no rotation between static intervals shows the unit of the gyroscope";
    GyroUnitByNoise "gyro-unit-by-noise" Warning "no rotation shows the unit of the gyroscope, and the header has none or is wrong about the accelerometer; the noise at rest distinguishes rad/s and °/s";
    UnitUnverified "unit-unverified" Note "the unit of a recording, soak or calibration is unknown";
    TemperatureRefused "temperature-refused" Warning "the temperature changes at rest, but the drift of no channel can be predicted";
    TemperatureOutside "temperature-outside" Warning "rows, poses or static intervals are outside the temperatures of the calibration or its model";
    TemperatureNotApplied "temperature-not-applied" Warning "the calibration has a temperature model, the recording (or some of its rows) no temperatures";
    RowsAsPoses "rows-as-poses" Note "rows that point everywhere and are similar in magnitude";
    LabelsLeftOut "labels-left-out" Note "labels that name neither a pose nor a turn, or turns that cannot be used";
    EmptyPose "empty-pose" Warning "a pose given by a section or label has no value of one axis in all its rows";
    ShortPose "short-pose" Warning "an interval too short to search for a static interval";
    NoStaticInterval "no-static-interval" Warning "an interval in which the sensor never rests";
    UnsteadyPose "unsteady-pose" Warning "the sensor moves slightly all the time, as if held by hand";
    UnusedPauses "unused-pauses" Warning "pauses in other directions than the poses, too short for a pose or unsteady, as if held by hand";
    SpikesLeftOut "spikes-left-out" Warning "2 % or more of the samples of a pose differ from their neighbours by more than six standard deviations";
    OrientationMismatch "orientation-mismatch" Warning "a file name claims another face than the data show";
    NamesReversed "names-reversed" Note "all six names have the opposite sign of the data";
    NamesTurned "names-turned" Warning "the names describe a board that is rotated in its case";
    NamesMirrored "names-mirrored" Gate "the names contradict every possible mounting";
    GravityAssumed "gravity-assumed" Note "local gravity was not given";
    BadPose "bad-pose" Warning "the magnitude at one pose contradicts all others significantly";
    NoFace "no-face" Warning "a pose is named after a face but tilted so far that an intended free pose is more likely";
    MissingFace "missing-face" Gate "only face poses, and one of the six faces is missing";
    FewOrientations "few-orientations" Gate "many poses without a face, as in days of wear, and none beyond ±0.3 g on some side of an axis";
    SameFaceTwice "same-face-twice" Gate "one face is recorded twice, once under the name of the missing face";
    OrientationOpen "orientation-open" Note "face poses on fewer than two axes, or a method without faces";
    ModelError "model-error" Warning "the model misfit of the poses beyond their noise exceeds 20 mm/s²";
    NoiseAssumed "noise-assumed" Note "the rows are means of unknown standard error";
    FreePoseOff "free-pose-off" Gate "at free poses, which are not used by the fit, the error of the magnitude is more than three times the predicted one";
    PoseTilt "pose-tilt" Warning "the tilt of the face poses exceeds 1.6 times the usual 1°";
    ClippedPose "clipped-pose" Gate "clipped samples in a pose";
    ScaleOff "scale-off" Gate "a scale factor differs by more than 10 % from nominal";
    GyroMotionGap "gyro-motion-gap" Warning "motions between poses of more than 60 s, with a break, or without a reading for more than 4.5 periods";
    GyroMotionClipped "gyro-motion-clipped" Warning "motions in which the gyroscope reaches the end of its range";
    GyroMotionOutlier "gyro-motion-outlier" Warning "motions that contradict the others";
    GyroUndetermined "gyro-undetermined" Note "the motions do not determine the whole matrix of the gyroscope to 3 %";
    GyroMisfit "gyro-misfit" Warning "after a typical motion the direction of gravity is wrong by more than 3°";
    GyroLeftHanded "gyro-left-handed" Warning "gyroscope and accelerometer differ in handedness";
    GyroScaleOff "gyro-scale-off" Warning "the scale factor of the gyroscope differs by more than 10 % from nominal";
    GyroScaleUnknown "gyro-scale-unknown" Note "the range of the gyroscope is not stated, and no motion determines the scale";
    GyroRateUnknown "gyro-rate-unknown" Note "neither time stamps nor `--rate`: rotations cannot be integrated";
    PoorCalibration "poor-calibration" Warning "the verdict of a calibration that is used or compared is poor";
    AlreadyCalibrated "already-calibrated" Warning "the columns have the names of calibrated columns, or the board says that it calibrates";
    SameFileTwice "same-file-twice" Warning "two inputs are identical";
    NotFiltered "not-filtered" Warning "segments between gaps or breaks are shorter than the filter needs";
    ShortForCutoff "short-for-cutoff" Warning "one period of the cutoff frequency is longer than the recording";
    NeverStatic "never-static" Note "no static interval was found";
    NoGyro "no-gyro" Warning "no gyroscope: the tilt between rests is not measured";
    GyroNotUsed "gyro-not-used" Warning "the unit of the gyroscope is unknown";
    DeadGyro "dead-gyro" Warning "the gyroscope never changes";
    CovarianceUnknown "covariance-unknown" Note "the calibration has no covariance";
    GravityOff "gravity-off" Warning "without a calibration: at rest the magnitude differs from gravity";
    ValuesReplaced "values-replaced" Warning "values in a move stand at the end of the range, or far from all around them";
    ClosureContradicts "closure-contradicts" Warning "at the end of a move the closure of velocity or tilt exceeds its uncertainty";
    RowsLeftOut "rows-left-out" Note "incomplete rows, or rows whose time stamp is not after that of the row before";
    TruthGaps "truth-gaps" Note "rows of the reference without a position";
    TruthOffset "truth-offset" Warning "the speeds are too dissimilar to determine the time offset";
    NoiseFromRests "noise-from-rests" Warning "`noise`: the sensor moved in a part of the recording";
    NoiseBelowResolution "noise-below-resolution" Warning "`noise`: the noise is smaller than a third of the resolution of a channel";
    NoiseMisfit "noise-misfit" Warning "`noise`: the Allan variance deviates from the model by more than chance";
    NoiseDrift "noise-drift" Warning "`noise`: the bias of a channel drifts steadily, as it does while a sensor warms up";
    SameRecordings "same-recordings" Warning "both calibrations share recordings, or `check` was given a recording of the calibration";
    GravityDiffers "gravity-differs" Warning "two values of gravity";
    FramesMirrored "frames-mirrored" Warning "`compare`: one calibration is the mirror image of the other";
}

impl fmt::Display for FindingKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.row().name)
    }
}

//! Every kind of finding: its name, how much it matters, what it means. What was done about it, and
//! what the user should do, is in the tables of `docs/recording.md`, whose names and severities a test holds to these.

use std::fmt;

use super::{Kind, Weight};

crate::findings! {
    "nul-bytes" Warning "NUL bytes in lines" / "removed" / "the file may be damaged; close it before unplugging the board":
        NulBytes { lines: u64 } => "NUL bytes in {lines} lines; removed";
}

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
    NamedGap "named-gap" Warning "a line `# gap: …`: [the logger](logging.md) reports rows that were lost";
    BlankRows "blank-rows" Note "empty lines, or lines of delimiters only";
    RepeatedHeader "repeated-header" Warning "the header once more in the middle";
    TornLine "torn-line" Warning "fewer fields than the other rows";
    TooManyFields "too-many-fields" Warning "more fields than the other rows";
    NotANumber "not-a-number" Warning "a value that is not a number";
    ZeroRows "zero-rows" Warning "the accelerometer reads zero on all axes, together with the gyroscope or in five consecutive rows";
    SensorHung "sensor-hung" Warning "all channels repeat to the last digit for longer than noise allows";
    TruncatedFile "truncated-file" Warning "a truncated gzip file";
    CorruptBlock "corrupt-block" Warning "blocks of a [file of a wearable](wearables.md) with a wrong checksum, an unknown coding, no date, or cut off at the end";
    LateBlock "late-block" Warning "blocks of such a file that are not later than the one before: repeated or out of order";
    SamplesAveraged "samples-averaged" Note "more than 2²⁰ samples of a `.cwa` file";
    ColumnsGuessed "columns-guessed" Warning "no header, or a header that does not fit the columns";
    ColumnsUnread "columns-unread" Note "columns of changing numbers that are used for nothing, whose names tell no other quantity";
    NotAnAccelerometer "not-an-accelerometer" Warning "columns recognised from their values behave like a gyroscope";
    SeveralSensors "several-sensors" Warning "more than one accelerometer, in columns side by side or in rows distinguished by a column (`I`, `instance`, `type`)";
    UnnamedClock "unnamed-clock" Warning "no column is named as time, and one or several increase steadily";
    WithoutGravity "without-gravity" Warning "at rest the acceleration is near zero, or the column is named linear and its magnitude is not gravity: the device has subtracted gravity";
    GyroRowByRow "gyro-row-by-row" Note "`--gyro`: at least one of the files has no time stamps";
    GyroUncovered "gyro-uncovered" Warning "`--gyro`: rows of the accelerometer without a reading of the gyroscope nearby";
    TimeUnitAssumed "time-unit-assumed" Warning "the unit of the time stamps is not stated, and more than one fits; or the stated one gives less than 0.9 Hz or more than 20 kHz";
    TimeUnitUnknown "time-unit-unknown" Warning "the steps fit no unit, or no usual sampling rate; or the header names a unit that is not known (`Time [frames]`)";
    FrozenTime "frozen-time" Warning "the time stamps never advance";
    AbsentTime "absent-time" Warning "some rows have no time stamp";
    RestartedTime "restarted-time" Warning "the time stamps restart: the board was reset, or its clock set";
    BadStamps "bad-stamps" Warning "time stamps far off the line of their neighbours, or that run backwards";
    StampsUnread "stamps-unread" Warning "a column of time holds text that is no date; the message quotes the first";
    DuplicateTime "duplicate-time" Warning "time stamps repeat";
    BurstTime "burst-time" Warning "many rows share a time stamp, followed by a long step: arrival times, whole seconds, or rounding by a spreadsheet";
    Gap "gap" Warning "more than four consecutive samples are missing";
    MissingSamples "missing-samples" Warning "more than 0.1 % of the samples are missing";
    RateMismatch "rate-mismatch" Warning "the stated sampling rate differs by more than 2 % from the time stamps";
    RateUnknown "rate-unknown" Note "neither time stamps nor `--rate`";
    UnitMismatch "unit-mismatch" Warning "the unit of header, option or calibration contradicts gravity or the turns";
    UnitAssumed "unit-assumed" Note "the magnitude at rest fits mg and cm/s²";
    UnitUnknown "unit-unknown" Warning "the magnitude at rest fits no unit, or several; if it is gravity times a power of two, the sensor was set to another range than the program assumed";
    RangeMismatch "range-mismatch" Warning "the range of `--accel-range` or of the board's header contradicts gravity at rest";
    UnsignedCounts "unsigned-counts" Note "16-bit values written as unsigned: around 32768, or 65535 for −1";
    Clipped "clipped" Warning "values at the end of the range: counts from 32764; in physical units repeats of the largest value at a usual full scale, or at `--gyro-range`";
    FrozenAxis "frozen-axis" Warning "an axis keeps one value for 100 rows while another axis of the sensor varies by more than its last digit (coarse digits at rest are not reported)";
    RepeatedRows "repeated-rows" Warning "throughout the recording rows repeat the row before in every channel (repeats at rest due to coarse digits are not reported)";
    EmptyCells "empty-cells" Warning "cells without a value, counts of -32768 alone between ordinary ones, and temperatures that no sensor can have (below −60 or above 150 °C)";
    TemperatureUnit "temperature-unit" Note "the temperature column is not in °C, e.g. raw counts";
    TruthGaps "truth-gaps" Note "rows of the reference without a position";
    TruthOffset "truth-offset" Warning "the speeds are too dissimilar to determine the time offset";
}

impl fmt::Display for FindingKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.row().name)
    }
}

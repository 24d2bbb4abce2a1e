//! What whoever uses a recording should know of it.

use std::fmt;

use crate::spans::LineSpans;

macro_rules! kinds {
    ($($kind:ident $name:literal $meaning:literal;)*) => {
        /// Kind of a note.
        #[derive(Clone, Copy, PartialEq, Eq, Debug)]
        pub enum NoteKind {
            $(#[doc = $meaning] $kind,)*
        }

        impl NoteKind {
            /// All kinds.
            pub const ALL: &'static [NoteKind] = &[$(NoteKind::$kind,)*];

            /// Stable name, for scripts.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self {
                    $(NoteKind::$kind => $name,)*
                }
            }
        }
    };
}

kinds! {
    NamedGap "named-gap" "Lines `# gap:` of a logger";
    BlankRows "blank-rows" "Blank lines part the rows";
    RepeatedHeader "repeated-header" "The header once more";
    OtherSensor "other-sensor" "Rows of another sensor";
    TornLine "torn-line" "Fewer fields than the other rows";
    TooManyFields "too-many-fields" "More fields than the other rows";
    NotANumber "not-a-number" "Text where the rows have numbers";
    RejectedSamples "rejected-samples" "Samples that the logger says it rejected";
    NulBytes "nul-bytes" "NUL bytes in the text";
    TruncatedFile "truncated-file" "The compressed file ends in the middle";
    ColumnsGuessed "columns-guessed" "Columns told by their numbers";
    NotAnAccelerometer "not-an-accelerometer" "Columns told by their numbers behave like a gyroscope";
    SeveralSensors "several-sensors" "One of several sensors is read";
    UnnamedClock "unnamed-clock" "No column is named as the time";
    StampsUnread "stamps-unread" "Stamps that are no numbers or dates";
    TimeUnitAssumed "time-unit-assumed" "The unit of the stamps is likely, not stated";
    TimeUnitUnknown "time-unit-unknown" "No unit of the stamps gives a usual rate";
    FrozenTime "frozen-time" "The stamps never advance";
    AbsentTime "absent-time" "Rows without a stamp";
    RestartedTime "restarted-time" "The clock begins again";
    BadStamps "bad-stamps" "Stamps far off the line of their neighbours, or backwards";
    DuplicateTime "duplicate-time" "Stamps repeat";
    BurstTime "burst-time" "Rows share a stamp or arrive in bursts";
    Gap "gap" "More than four samples in a row are missing";
    MissingSamples "missing-samples" "Samples are missing by the clock";
    RateMismatch "rate-mismatch" "The stated rate contradicts the stamps";
    RateUnknown "rate-unknown" "Neither stamps nor a stated rate";
    UnitMismatch "unit-mismatch" "Gravity contradicts the stated unit";
    UnitAssumed "unit-assumed" "Of two units that fit the likelier is taken";
    UnitChanged "unit-changed" "The unit changes among the rows";
    UnitUnknown "unit-unknown" "Gravity in no unit, or in several";
    WithoutGravity "without-gravity" "Gravity was removed";
    WrongFullScale "wrong-full-scale" "Gravity times a power of two";
    RangeMismatch "range-mismatch" "Gravity contradicts the stated range";
    UnsignedCounts "unsigned-counts" "Counts written as unsigned numbers";
    EmptyCells "empty-cells" "Cells without a value";
    ZeroRows "zero-rows" "Rows of zeros";
    SensorHung "sensor-hung" "All channels repeat for longer than noise allows";
    ShiftedColumns "shifted-columns" "Values stand in the columns of others";
    Clipped "clipped" "Values at the end of the range";
    FrozenAxis "frozen-axis" "One axis keeps its value while others change";
    RepeatedRows "repeated-rows" "Rows repeat throughout";
    CorruptBlock "corrupt-block" "Blocks of a binary file that cannot be decoded";
    RepeatedBlock "repeated-block" "Blocks that repeat the one before";
    LateBlock "late-block" "Blocks that are earlier than the one before";
    MissingBlocks "missing-blocks" "Blocks are missing by their numbers or stamps";
    SeveralSessions "several-sessions" "Several sessions in one file";
    SamplesAveraged "samples-averaged" "Means of neighbouring samples are held";
    TemperatureUnit "temperature-unit" "The temperature is not in °C";
}

/// Something about a recording that whoever uses it should know.
#[derive(Clone, PartialEq, Debug)]
pub struct Note {
    /// Kind, for scripts
    pub kind: NoteKind,
    /// What was found, with numbers, and what was done
    pub message: String,
    /// Lines concerned
    pub lines: LineSpans,
}

impl Note {
    pub(crate) fn new(kind: NoteKind, message: impl Into<String>) -> Self {
        Note {
            kind,
            message: message.into(),
            lines: LineSpans::default(),
        }
    }

    pub(crate) fn at(mut self, lines: LineSpans) -> Self {
        self.lines = lines;
        self
    }
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

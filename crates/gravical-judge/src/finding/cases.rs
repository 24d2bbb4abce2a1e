//! What is found in recordings: its rows in `docs/recording.md`, and its sentences.

use std::collections::BTreeMap;
use std::fmt;

use serde::Serialize;

use crate::encoding::Encoding;
use crate::numfmt::{count, digits};
use crate::units::{AccelUnit, GyroUnit, POSSIBLE_C, TimeUnit};

/// Columns that a sentence names.
const MAX_NAMED: usize = 12;
const RAW_DATA: &str = "a calibration needs gravity; use the raw data (phyphox: \"Acceleration (with g)\"; Sensor Logger: TotalAcceleration.csv; Android: TYPE_ACCELEROMETER)";

crate::findings! {
    "named-gap" Loss "a line `# gap: …` of [the logger](logging.md): rows were lost" / "":
        NamedGap { lines: u64, first: String } =>
            "{}: the logger reports missing rows; treated as a break between segments, first: \"{first}\"", count(lines, "line");
    "blank-rows" Note "empty lines separate poses; a single one does not where the clock continues" / "":
        BlankRows { lines: u64 } =>
            "{}: blank; a break between segments, unless it is a single line and the clock continues", count(lines, "line");
    "repeated-header" Warning "the header is repeated in the middle" / "":
        RepeatedHeader { lines: u64 } =>
            "{}: the header repeated; kept out of the data, and a break unless the clock continues", count(lines, "line");
    "torn-line" Loss "fewer fields than the other rows" / "Many such lines indicate a bad connection":
        TornLine { lines: u64, first: String } =>
            "{}: fewer fields than the other rows (half-written); set aside, first: \"{first}\"", count(lines, "line");
    "too-many-fields" Loss "more fields than the other rows: lines run together" / "Lower the baud rate or the sampling rate":
        TooManyFields { lines: u64, first: String } =>
            "{}: more fields than the other rows (lines run together?); set aside, first: \"{first}\"", count(lines, "line");
    "not-a-number" Loss "a value is not a number" / "":
        NotANumber { lines: u64, first: String } =>
            "{}: no number where the rows have numbers; set aside, first: \"{first}\"", count(lines, "line");
        TextCells { cells: usize, first: String } =>
            "{cells} cells hold text where the rows have numbers; they are empty, first: \"{first}\"";
    "zero-rows" Loss "the accelerometer reads zero on all axes, together with the gyroscope or in five consecutive rows" / "":
        ZeroRows { lines: u64 } => "{}: all channels zero: the sensor was not read; set aside", count(lines, "line");
        ZeroAccel { rows: usize } =>
            "the accelerometer reads zero on all axes in {rows} rows: it was not read; treated as empty";
    "sensor-hung" Warning "all channels repeat to the last digit for longer than noise allows" / "Check wiring and power of the sensor":
        SensorHung { lines: u64 } =>
            "{}: all channels repeat for longer than noise allows: the sensor or its bus hung; set aside like a gap", count(lines, "line");
    "nul-bytes" Warning "NUL bytes were removed" / "Close the file before you unplug the board":
        NulBytes { lines: u64 } => "NUL bytes in {lines} lines; removed";
    "truncated-file" Loss "a gzip file is truncated" / "":
        TruncatedFile { rows: usize } =>
            "the packed file is damaged or ends in the middle; {rows} rows could be unpacked";
    "corrupt-block" Warning "blocks of a [`.cwa` file](wearables.md) are damaged, repeated or out of order" / "Copy it from the device again":
        CorruptBlock { blocks: u64, first: String } => "{}: damaged; skipped, first: {first}", count(blocks, "block");
        LateBlock { blocks: u64, first: String } =>
            "{}: not later than the one before (repeated or out of order); skipped, first: {first}", count(blocks, "block");
    "samples-averaged" Note "more than 2²⁰ samples in a `.cwa` file: [means](#long-recordings) are used" / "":
        SamplesAveraged { samples: usize, means: usize, neighbours: usize } =>
            "{samples} samples are too many to hold: they are used as {means} means of {neighbours} neighbours";
    "columns-guessed" Warning "no header, or one that does not fit" / "":
        NoHeader => "no header; assigned by the numbers; give the columns to be sure";
        NamesMisfit { misfit: Misfit } => "{misfit}; assigned by the numbers; give the columns to be sure";
    "columns-unread" Note "columns of changing numbers are not used" / "Assign those that belong to the sensor: `--columns`":
        ColumnsUnread { columns: Vec<String> } => "columns of numbers that are not read: {}", named(columns);
    "not-an-accelerometer" Warning "columns recognised from their values behave like a gyroscope" / "Give `--columns`":
        NotAnAccelerometer { norm_at_rest: f64, norm_in_motion: f64 } =>
            "the magnitude is {norm_at_rest:.0} at rest and up to {norm_in_motion:.0} in motion: these columns look like a gyroscope";
    "several-sensors" Warning "more than one accelerometer, in columns or rows; the first is read" / "":
        SeveralSensors { sensors: Vec<String>, read: String } =>
            "{} accelerometers: {}; {read} is read, unless another is chosen", sensors.len(), sensors.join(", ");
        SilentSensors { sensors: Vec<String>, read: String } =>
            "{} accelerometers: {}; {read} is read: of those before none answers and shows gravity at rest", sensors.len(), sensors.join(", ");
        SensorsInRows { column: String, sensors: Vec<String>, read: String } =>
            "rows of {} sensors, distinguished by column {column}: {}; those of {read} are read, unless another is chosen", sensors.len(), sensors.join(", ");
        GravityAdded { read: String, gravity: String } =>
            "the acceleration ({read} …) lacks gravity, which stands in other columns ({gravity} …): their sum is read";
        RawAndCalibrated { read: String } =>
            "a table of this program with raw and calibrated columns: the raw ones ({read} …) are read, unless the calibrated ones are named";
    "unnamed-clock" Warning "no column is named as time; one that rises steadily is used, of several none" / "":
        UnnamedClock { column: String } =>
            "no column is named as the time; {column} rises steadily and is used as the time; name the one that is";
        UnnamedClocks { columns: Vec<String> } =>
            "no column is named as the time; {} rise steadily: each could be the time, and none is used; name the one that is", columns.join(", ");
    "without-gravity" Warning "the device has subtracted gravity" / "Record the raw acceleration: `Acceleration (with g)` in phyphox, `TotalAcceleration.csv` of Sensor Logger":
        WithoutGravity { norm: f64 } =>
            "the magnitude at rest is {}: gravity was removed from this acceleration, but {RAW_DATA}", digits(*norm, 4);
        NamedLinear =>
            "the columns are named as acceleration without gravity, and the sensor is never at rest to show another; {RAW_DATA}";
    "gyro-row-by-row" Note "`--gyro`: files without time stamps are joined row by row" / "":
        GyroRowByRow => "one of the files has no time stamps: joined row by row";
    "gyro-uncovered" Warning "`--gyro`: rows have no reading of the gyroscope nearby; motions with such rows are not used" / "Start it before the session, and stop it after":
        GyroUncovered { uncovered: u64, rows: u64, percent: f64, within_ms: f64 } =>
            "{uncovered} of {rows} rows of the accelerometer ({percent:.1} %) have no reading of the gyroscope within {within_ms:.0} ms: before it starts, after it ends, or in its gaps; left empty there";
    "time-unit-assumed" Warning "several units fit the time stamps, or the stated one gives an unusual rate" / "":
        TimeUnitAssumed { unit: TimeUnit, rate_hz: f64 } =>
            "the time stamps are assumed to be in {unit} ({rate_hz:.2} Hz); give the unit if it is another";
        TimeUnitStated { unit: TimeUnit, rate_hz: f64 } =>
            "the time stamps are stated to be in {unit} ({rate_hz:.2} Hz); give the unit if it is another";
    "time-unit-unknown" Warning "the time stamps fit no unit, or the header names an unknown one" / "":
        NoTimeUnit { step: f64 } =>
            "steps of {step} give a plausible sampling rate in no unit of time; the time stamps are not used; give their unit";
        TimeUnitUnknown { stated: String, unit: TimeUnit, rate_hz: f64 } =>
            "the unit of the time stamps, \"{stated}\", is not known; they are assumed to be in {unit} ({rate_hz:.2} Hz)";
    "frozen-time" Warning "the time stamps never advance" / "":
        FrozenTime => "the time stamps never advance; they are not used";
    "restarted-time" Warning "the time stamps restart" / "Find out why the board was reset or its clock set":
        RestartedTime => "the time stamps restart (the board was reset, or its clock set); a break";
    "bad-stamps" Warning "time stamps are off the line of their neighbours, run backwards or are absent" / "":
        BadStamps { stamps: usize } =>
            "{stamps} time stamps are off the line of their neighbours, or run backwards; those between good ones are replaced, others are kept";
        UnorderedStamps { backwards: usize, rows: usize } =>
            "{backwards} of {rows} time stamps run backwards: the rows are out of order, and the time stamps are not used; sort the rows by time";
        AbsentStamps { rows: usize } => "{rows} rows have no time stamp";
    "stamps-unread" Warning "a column of time holds text that is not a date" / "":
        StampsUnread { first: String } => "time stamps like \"{first}\" are not understood; they are not used";
    "duplicate-time" Warning "time stamps repeat" / "Use a finer clock, or a lower rate":
        DuplicateTime { stamps: usize, percent: f64 } =>
            "{stamps} time stamps repeat the one before ({percent:.1} % of the rows); the rows are kept";
    "burst-time" Warning "many rows share a time stamp before a long step: arrival times, or rounding by a spreadsheet" / "Record time stamps on the board":
        BurstTime { bursty_steps: usize, steps: usize, rate_hz: f64 } =>
            "{bursty_steps} of {steps} rows share their stamp with the row before or follow it far sooner than the mean: the stamps are coarser than the sampling (rounded by a spreadsheet), or times of arrival; the mean rate of {rate_hz:.2} Hz is used instead";
    "gap" Warning "more than four consecutive samples are missing" / "":
        Gap { gaps: usize, longest_s: f64 } =>
            "{} of more than four samples, the longest {longest_s:.3} s", count(gaps, "gap");
    "missing-samples" Loss "more than 0.1 % of the samples are missing" / "Lower the rate, or raise the baud rate":
        MissingSamples { samples: f64, percent: f64 } =>
            "{samples:.0} samples ({percent:.1} %) are missing between the time stamps";
    "rate-mismatch" Warning "the stated rate differs by more than 2 % from the time stamps, which are used" / "":
        RateMismatch { stated_hz: f64, rate_hz: f64 } =>
            "the claimed rate is {stated_hz} Hz, the time stamps give {rate_hz:.2} Hz; the time stamps are used";
    "rate-unknown" Note "neither time stamps nor `--rate`: intervals are counted in rows" / "":
        RateUnknown => "no time stamps and no rate: static intervals are counted in rows";
    "unit-mismatch" Warning "gravity or the turns contradict a unit. The data override a header; an option is used as given; `apply` stops without `--accel-unit`" / "":
        UnitOfHeader { stated: AccelUnit, norm: f64, unit: AccelUnit } =>
            "the header gives {stated}, but the magnitude at rest is {}: the values are read as {unit}", digits(*norm, 4);
        UnitGiven { unit: AccelUnit, norm_g: f64 } =>
            "read as {unit} as given, but then the magnitude at rest is {norm_g:.2} g, and should be 1";
        OtherRange { lsb_per_g: f64, wanted_lsb_per_g: f64 } =>
            "the recording has {lsb_per_g:.0} counts per g, the calibration is for {wanted_lsb_per_g:.0}: another range";
        OtherGravity { at_rest: String, norm_mps2: f64, gravity_mps2: f64 } =>
            "calibrated, {at_rest} measure {norm_mps2:.2} m/s², gravity is {gravity_mps2:.2}: another sensor, range or unit";
        GyroUnitOfHeader { stated: GyroUnit, unit: GyroUnit } =>
            "the header says {stated} for the gyroscope, but its rotations agree with gravity only in {unit}, which is used";
        GyroUnitOfCalibration { unit: GyroUnit, stated: GyroUnit } =>
            "the gyroscope is read in {unit}, the unit of the calibration, although the header says {stated}: its noise at rest, or the accelerometer, contradicts the header; give the unit if it is another";
        GyroUncalibrated { mismatch: GyroMismatch } => "{mismatch}; it is used uncalibrated";
    "unit-assumed" Note "the magnitude at rest fits mg, which is used, and cm/s²" / "":
        UnitAssumed { norm: f64 } =>
            "the magnitude at rest is {}: read as mg; cm/s² would fit as well: give the unit if it is that", digits(*norm, 4);
    "unit-unknown" Warning "the magnitude at rest fits no unit, or several; gravity times a power of two indicates another range" / "":
        UnitAmbiguous { norm: f64 } =>
            "the magnitude at rest is {}: mg, cm/s² or counts at 1024 per g; give the unit", digits(*norm, 4);
        NeverAtRest { norm: f64 } =>
            "the sensor is never at rest, and the magnitude where it is quietest, {}, need not be gravity: give the unit, likely this one", digits(*norm, 4);
        OtherFullScale { norm: f64, unit: AccelUnit, factor: f64 } =>
            "the magnitude at rest is {}: it would be gravity in {} with the full-scale setting wrong by a factor of {factor}: was the sensor set to another range than the program assumed?", digits(*norm, 4), unit.name();
        UnitUnknown { norm: f64 } =>
            "the magnitude at rest is {}: gravity in no known unit; check the factor in the program that wrote the file, or give counts as the unit, which uses the values as they are", digits(*norm, 4);
    "range-mismatch" Warning "gravity at rest contradicts `--accel-range`, which is used, or the range of the header, which is not" / "":
        RangeGiven { given_g: f64, shown_g: f64 } =>
            "±{} g was given, but the magnitude at rest corresponds to ±{} g; the given range is used", digits(*given_g, 4), digits(*shown_g, 4);
        RangeGivenForCounts { given_g: f64, lsb_per_g: f64 } =>
            "±{} g was given, but the magnitude at rest corresponds to {} counts per g; the given range is used", digits(*given_g, 4), digits(*lsb_per_g, 4);
        RangeOfHeader { stated_lsb_per_g: f64, lsb_per_g: f64 } =>
            "the file claims {} counts per g, the magnitude at rest is that of {}; that of gravity is used", digits(*stated_lsb_per_g, 4), digits(*lsb_per_g, 4);
    "unsigned-counts" Note "16-bit values written as unsigned, around 32768 or 65535 for −1" / "If that is wrong, give `--zero-offset`":
        UnsignedCounts { encoding: Encoding } => "unsigned numbers of 16 bits: {encoding}";
    "clipped" Warning "values at the end of the range" / "Record with a wider range":
        Clipped { channel: String, rows: u64 } =>
            "{channel} reaches the end of its range in {rows} rows: the true value is larger; record at a wider range";
    "frozen-axis" Loss "an axis keeps one value for 100 rows while another varies" / "Check wiring and code; the axis may be defective":
        FrozenAxis { channel: String, rows: usize } =>
            "{channel} keeps exactly one value for {rows} rows while the other axes change";
    "repeated-rows" Warning "throughout the recording rows repeat the row before in every channel" / "Read no faster than the sensor measures":
        RepeatedRows { rows: u64, percent: f64 } =>
            "{rows} rows ({percent:.0} %) repeat the row before in every channel: the sensor was read faster than it measures";
    "empty-cells" Loss "cells without a value, single counts of −32768, temperatures below −60 or above 150 °C" / "":
        EmptyCells { cells: EmptyCells } => "{cells}; they stay empty";
        HeldCells { cells: EmptyCells } =>
            "{cells}; each channel is written when it arrives: its last value is held, that of the gyroscope for a few rows";
        NoNeighbours { channel: String } =>
            "{channel}: hardly two samples at rest follow each other; its noise is left out";
    "temperature-unit" Note "the temperature is not in °C and not used" / "":
        TemperatureUnit { middle: f64 } =>
            "the temperature column is around {middle:.0}, not °C (raw counts?); it is not used";
}

/// Cells without a value.
#[derive(Debug, Clone, Default, Serialize)]
pub struct EmptyCells {
    /// How many, in all channels
    pub count: usize,
    /// Rows that lack a value
    pub lacking: usize,
    /// All rows
    pub rows: usize,
    /// Channels that lack values, and how many
    pub channels: BTreeMap<&'static str, usize>,
    /// Counts of -32768 alone, which mark an invalid sample
    pub invalid: usize,
    /// Temperatures that no sensor can have
    pub impossible: usize,
}

impl fmt::Display for EmptyCells {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (invalid, impossible) = (self.invalid, self.impossible);
        let channels = self.channels.iter();
        let mut parts: Vec<String> = channels.map(|(name, n)| format!("{name} {n}")).collect();
        if invalid > 0 {
            parts.push(format!(
                "{invalid} of them held -32768 alone, which marks an invalid sample"
            ));
        }
        if impossible > 0 {
            let (low, high) = (POSSIBLE_C.start(), POSSIBLE_C.end());
            parts.push(format!("{impossible} of them outside {low} to {high} °C"));
        }
        let (count, lacking, rows) = (self.count, self.lacking, self.rows);
        let parts = parts.join(", ");
        write!(
            f,
            "{count} empty cells in {lacking} of {rows} rows ({parts})"
        )
    }
}

/// Why a gyroscope is not that of a calibration.
#[derive(Debug, Clone, Copy, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum GyroMismatch {
    /// It has no counts, and the calibration is for these
    Fractions,
    /// Its unit and that of the calibration
    Unit(GyroUnit, GyroUnit),
    /// Its counts per °/s and those of the calibration
    Range(f64, f64),
}

impl fmt::Display for GyroMismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            GyroMismatch::Fractions => f.write_str(
                "the gyroscope has values with fractions, the calibration is for counts",
            ),
            GyroMismatch::Unit(unit, wanted) => write!(
                f,
                "the gyroscope is in {unit}, the calibration is for {wanted}"
            ),
            GyroMismatch::Range(lsb, wanted) => write!(
                f,
                "the gyroscope has {lsb:.1} counts per °/s, the calibration is for {wanted:.1}: another range"
            ),
        }
    }
}

/// The first names.
fn named(columns: &[String]) -> String {
    let more = if columns.len() > MAX_NAMED {
        ", …"
    } else {
        ""
    };
    columns[..columns.len().min(MAX_NAMED)].join(", ") + more
}

/// Why a line of names is no header.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Misfit {
    /// It has not as many names as there are columns
    Names {
        line: usize,
        names: usize,
        columns: usize,
    },
    /// The columns that it names are no accelerometer
    NoGravity,
}

impl fmt::Display for Misfit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Misfit::Names {
                line,
                names,
                columns,
            } => write!(
                f,
                "line {line} has {names} names for {columns} columns, so it cannot be their header"
            ),
            Misfit::NoGravity => f.write_str("the columns named so hold no gravity"),
        }
    }
}

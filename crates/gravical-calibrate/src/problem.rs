//! What sessions and calibrations are refused for, each with its sentence.

use std::ops::Range;

use gravical_core::six_position::SixPositionError;
use gravical_fit::Face;
use gravical_judge::finding::Case as RecordingCase;
use gravical_judge::numfmt::{count, milli_g};
use gravical_judge::units::{AccelScale, AccelUnit, GyroUnit, Origin};

use crate::attitude::in_words;
use crate::finding::Restless;

const A_CALIBRATION: &str =
    "a calibration is what `gravical calibrate … -o cal.json` writes, or a file of imucal";
const OWN_FILE: &str =
    "use the file written by `gravical calibrate … -o cal.json`, or calibrate again";
const AXES: &str =
    "give three axes with signs, such as x,-z,y: the new x, y and z, each as an axis of the sensor";
const SECTION_LIST: &str =
    "a section list is {\"x_p\": {\"start\": 0, \"end\": 500}, …} or lines of label,start,end";
const POSES_SHOWN: &str = "`gravical inspect` shows what each pose reads";

gravical_judge::errors! {
    "no-recordings" input:
        NoRecording => "there is no recording";
        NoneInFolder { endings: &'static [&'static str] } => "there is no recording in this folder"
            => "folders inside this one are not read; recordings end in .{}; `gravical inspect` says of each file what helps", endings.join(", .");
    "no-rows" input:
        Prose => "this is text, not rows of numbers";
    "gyro-inputs" usage:
        GyroOfSeveral { inputs: usize } => "it belongs to one recording of the accelerometer; there are {inputs}"
            => "give one continuous recording, or files that hold both sensors";
    "several-files" usage:
        SectionsOfSeveral { recordings: usize } => "a section list belongs to one recording; there are {recordings}"
            => "calibrate that recording alone, or name each file after its face";
    "sections-empty" input:
        NoSection => "the section list has no section";
    "sections-syntax" input:
        NoSectionList { why: String } => "{why}" => "{SECTION_LIST}";
        NotWhole { label: String, start: f64, end: f64 } =>
            "section \"{label}\": start {start} and end {end} have to be whole row numbers from 0" => "{SECTION_LIST}";
    "sections-order" input:
        SectionEndsFirst { label: String, start: f64, end: f64 } => "section \"{label}\" ends at {end} and starts at {start}: it has no rows"
            => "the end is exclusive: rows 0 to 499 are start 0, end 500";
    "sections-range" input:
        SectionBeyond { label: String, section: Range<usize>, rows: usize } => "section \"{label}\" has the rows {section:?}, the recording has {rows} rows"
            => "rows are data rows counted from 0 (header and blank lines do not count), the end is exclusive";
    "axes-syntax" usage:
        NoAxis { text: String } => "{text}: not an axis" => "{AXES}";
        NotEachOnce { text: String } => "{text}: each axis has to occur once" => "{AXES}";
        Mirrors { text: String } => "{text}: this mirrors the sensor, which no mounting does" => "{AXES}";
    "unit-unknown" input:
        RangeUnknown => "counts of unknown range have no unit" => "give the range, for example of ±2 g";
        UnitUnknown { why: Option<String> } => "{}", why.as_deref().unwrap_or("the unit is not known")
            => "use raw acceleration, and give its unit; counts stands for counts of any scale";
    "units-differ" input:
        RecordingsDiffer { first: String, scales: [AccelScale; 2] } =>
            "the recordings are not in the same unit: {first} is in {}, this one in {}", describe(scales[0]), describe(scales[1])
            => "record all poses with the same settings; if they are in one unit, give it";
        SoakDiffers { session: GyroUnit, soak: GyroUnit } => "the gyroscope's unit is {session} in the session and {soak} in the soak"
            => "record the soak with the same sensor, range and program as the session, or give its unit";
        CalibrationsDiffer { names: [String; 2], units: [AccelUnit; 2], per_mps2: [f64; 2] } =>
            "the calibrations are for different units: {} for {} ({:.5} per m/s²), {} for {} ({:.5} per m/s²)",
            names[0], units[0].name(), per_mps2[0], names[1], units[1].name(), per_mps2[1] => "calibrate both from recordings in one unit and range";
    "unit-mismatch" input:
        OtherUnit { unit: AccelUnit, origin: Origin, wanted: AccelUnit } => "the recording is in {unit} ({}), the calibration is for {wanted}", source(origin)
            => "use a calibration from recordings in {unit}; to use this one all the same, give the unit";
        OtherSetting { found: RecordingCase } => "{found}" => "use {}; to use this one all the same, give the unit",
            if let RecordingCase::OtherRange { .. } = found { "a calibration for this range" } else { "the calibration of this sensor at this setting" };
    "sensors-differ" input:
        SerialsDiffer { files: [String; 2], serials: [String; 2] } =>
            "{} is of the sensor with the serial number {}, {} of {}", files[0], serials[0], files[1], serials[1]
            => "calibrate the recordings of each sensor alone; or name the sensor if they are of one";
        FitsDiffer { files: [String; 2], scale_percent: f64, bias_mps2: f64 } =>
            "{} and {} are of different sensors: fitted alone, their scales are {scale_percent:.1} % and their biases {:.0} mg apart, more than one sensor changes",
            files[0], files[1], milli_g(bias_mps2) => "calibrate the recordings of each sensor alone";
    "never-static" input:
        FewRows { rows: usize } => "{rows} rows: no recording of poses, and no table of means";
        NeverAtRest { why: Restless } => "never at rest: {why}";
        HardlyAtRest { rows_at_rest: usize, rows: usize, poses: usize } =>
            "at rest in {rows_at_rest} of {rows} rows, in {}: too little for a calibration", count(poses, "pose");
        NoneToCheck => "never at rest long enough to compare with gravity" => "lay the sensor down for 3 s or more, in any pose, better in several";
        NoneOfSoak => "it is never static for some seconds" => "leave the sensor untouched while its temperature changes";
    "no-poses" input:
        NoPoses => "no pose has a mean reading" => "`gravical inspect` shows what is in the recording";
    "no-such-pose" usage:
        NoSuchPose { name: String, known: Vec<String> } => "there is no pose {name}" => "give one of: {}", known.join(", ");
        NoFacePose { name: String, angle_deg: f64 } => "{name} is {angle_deg:.0}° from the nearest axis; beyond 25° it is no face pose"
            => "leave it to the fit, which treats it as a free pose";
    "missing-face" input:
        MissingFaces { missing: Vec<Face>, oblique: usize, poses: usize, limit_deg: f64 } =>
            "{} of six faces found; missing: {}{}", 6 - missing.len(), list(&missing, " ", |face| face.name()),
            if oblique == 0 { String::new() } else { format!("; {oblique} of {poses} poses are more than {limit_deg}° from every axis") }
            => "record 3 s or more at rest with each of these axes: {}; then calibrate again with all poses",
            list(&missing, ", ", |face| in_words(face.direction()));
    "underdetermined" input:
        Underdetermined { poses: usize, covered: Vec<String>, missing: Vec<String>, open: [f64; 3], sd_mps2: f64 } =>
            "{}; axes covered: {}{}", count(poses, "pose"), covered.join(", "),
            if sd_mps2.is_finite() { format!("; ‖a‖ with {} would be known to ±{:.0} mg only", in_words(open), milli_g(sd_mps2)) } else { String::new() }
            => "record {} too, at rest for 3 s or more each, and calibrate again with all poses",
            if missing.is_empty() { in_words(open) } else { list(&missing, ", ", |a| format!("{a} up and {a} down")) };
    "singular" input:
        SixMeans { why: SixPositionError } => "the six means determine no parameters: {why}" => "{POSES_SHOWN}";
        NoInverse { hand: f64 } => "the model has no inverse, or is left-handed (det R = {hand:.3})" => "{POSES_SHOWN}";
    "missing-temperature" input:
        NoTemperature => "the recording has no temperature" => "record the sensor's own temperature in a column called temperature, or name its column";
        PosesWithout => "the poses have no temperature at which a drift could be zero"
            => "record the temperature with the session, or leave the soak recordings out";
    "temperature-span" input:
        TooNarrow { span_c: f64, least_c: f64 } => "the temperature spans {span_c:.1} °C at rest; more than {least_c:.0} °C are needed"
            => "cool the sensor and let it warm up again, untouched, over all temperatures at which it will be used";
    "too-large" input:
        TooLarge { role: String, most_bytes: u64 } => "more than {} MiB, too large for: {role}", most_bytes >> 20 => "check the order of the arguments";
    "calibration-syntax" input:
        EmptyFile => "the file is empty" => "{A_CALIBRATION}";
        NotValid { why: String } => "this is not a valid calibration: {why}" => "{A_CALIBRATION}";
        NotJson { why: String } => "this is not a calibration file: not valid JSON ({why})" => "{A_CALIBRATION}";
        NotWritten { why: String } => "{why}";
    "calibration-format" input:
        OtherFormat { format: String, wanted: &'static str } => "the format is \"{format}\"; this program reads {wanted}";
        NoFormat => "this JSON is not a calibration: it has neither \"format\" nor \"K_a\" of imucal";
        ImucalVersion { version: String } => "imucal's format {version}; versions 2.x and before 2.0 are read";
        ImucalUnit { unit: String, wanted: &'static str } => "its output unit is {unit}; only {wanted} can be read";
    "calibration-values" input:
        ImucalNotDiagonal => "K of the imucal file is not diagonal";
        ImucalSingular => "K or R of the imucal file is singular";
        Singular => "the accelerometer's matrix is singular";
        NoGravity { mps2: f64 } => "gravity_mps2: {mps2} m/s² is not a possible gravity" => "{OWN_FILE}";
        NoSize { field: &'static str } => "{field}: it has to be 0 or more and below 1e9" => "{OWN_FILE}";
        BeyondSensors { section: &'static str, field: &'static str } => "{section}.{field}: a value is beyond any sensor" => "{OWN_FILE}";
        BiasTooLarge { section: &'static str, bias: f64, most: f64, unit: &'static str } => "{section}.bias: matrix · bias is {bias:.3} {unit}; no sensor has more than {most} {unit}" => "{OWN_FILE}";
        SingularMatrix { section: &'static str } => "{section}.matrix: the matrix is singular" => "{OWN_FILE}";
        OtherParameters { field: &'static str, possible: [Vec<String>; 2] } => "{field}.parameters: they have to be {}, in this order",
            possible.map(|names| names.join(", ")).join("; or ") => "{OWN_FILE}";
        NotSquare { field: &'static str, size: usize } => "{field}.values: there have to be {size} rows of {size}" => "{OWN_FILE}";
        NoVariance { field: &'static str } => "{field}.values: a variance is negative, beyond any sensor, or not a number" => "{OWN_FILE}";
        NoCovariance { field: &'static str } => "{field}.values: not a covariance: it is not symmetric, or not positive semidefinite" => "{OWN_FILE}";
        DriftRange { range_c: [f64; 2] } => "drift: its range is {} to {} °C", range_c[0], range_c[1] => "{OWN_FILE}";
        DriftChannel { channel: String } => "drift: {channel} is no channel, or its per_c no number" => "{OWN_FILE}";
}

fn list<T>(of: &[T], between: &str, shown: impl Fn(&T) -> String) -> String {
    of.iter().map(shown).collect::<Vec<_>>().join(between)
}

fn describe(scale: AccelScale) -> String {
    match scale.lsb_per_g {
        Some(lsb) => format!("counts at {lsb} per g"),
        None => scale.unit.name().to_owned(),
    }
}

fn source(origin: Origin) -> &'static str {
    match origin {
        Origin::Given => "as given",
        Origin::Data => "according to gravity",
        Origin::Header => "according to its header",
        Origin::Assumed => "assumed",
    }
}

//! Meaning of column names.
//!
//! `aX (g)`, `acc_x`, `ax`, `AccX`, `scaledAccelX`, `Accelerometer X (g)`, `imu.acc.x`,
//! `linear_acceleration.x`, `accSmooth[0]`, `gyr_x`, `w_RS_S_x`, `angularVelocityZ`, `Temp (C)`,
//! `t_s`, `ustime`, `Timestamp` … A name is split into words; one word gives the quantity, one
//! the axis; the rest may be a unit or the name of the sensor. The words are listed in one table,
//! `WORDS`.

use super::TimeUnit;
use super::row::{ACCEL, GYRO, TEMPERATURE, TIME};
use super::units::{AccelUnit, GyroUnit};

/// A quantity that gravical reads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Time stamp.
    Time,
    /// Time since the row before.
    TimeStep,
    /// A row counter; not a time.
    Index,
    /// Number of the sensor that measured the row.
    Instance,
    /// Specific force along axis 0, 1 or 2.
    Accel(usize),
    /// Angular rate about axis 0, 1 or 2.
    Gyro(usize),
    /// Temperature of the sensor.
    Temperature,
    /// Label of the section of the row.
    Label,
}

impl Quantity {
    /// Slot of its values in a row; `None` if they are no values of a sample.
    pub(super) fn slot(self) -> Option<usize> {
        match self {
            Quantity::Time => Some(TIME),
            Quantity::Accel(i) => Some(ACCEL + i),
            Quantity::Gyro(i) => Some(GYRO + i),
            Quantity::Temperature => Some(TEMPERATURE),
            Quantity::TimeStep | Quantity::Index | Quantity::Instance | Quantity::Label => None,
        }
    }
}

/// Meaning of a column name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ColumnName {
    /// What the column holds.
    pub quantity: Quantity,
    /// The unit as written in the name, in lower case.
    pub unit: Option<String>,
    /// Remaining words: the name of the sensor (`left sensor`), or empty.
    pub sensor: String,
    /// True if the name says that gravity was removed (`userAcceleration`, `Linear
    /// Acceleration`); such a column is used only as a last resort.
    pub without_gravity: bool,
}

/// Meaning of one word of a name.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Word {
    Accel,
    Gyro,
    /// A quantity without an axis.
    Scalar(Quantity),
    /// Makes a time a time step (`delta`).
    Difference,
    /// Gravity was removed.
    WithoutGravity,
    /// A quantity that is not read here.
    Foreign,
    /// Without meaning.
    Filler,
}

/// Whole words. A unit of time (`ms`) can be written before or after the words for time.
const WORDS: &[(Word, &[&str])] = &[
    (
        Word::Accel,
        &["a", "acc", "accel", "accl", "acce", "xl", "sf", "alpha"],
    ),
    (
        Word::Gyro,
        &["g", "gyr", "gyro", "w", "omega", "rate", "rot", "angvel"],
    ),
    (
        Word::Scalar(Quantity::Time),
        &[
            "t",
            "ts",
            "time",
            "stamp",
            "timestamp",
            "timestamps",
            "epoch",
            "epoc",
            "clock",
            "elapsed",
            "utc",
            "gpst",
            "datetime",
            "date",
            "ticks",
            "tick",
            "seconds",
            "millis",
            "milliseconds",
            "micros",
            "microseconds",
            "nanos",
            "nanoseconds",
            "msec",
            "msecs",
            "millisec",
            "usec",
            "usecs",
            "microsec",
            "nsec",
            "nsecs",
            "nanosec",
        ],
    ),
    (
        Word::Scalar(Quantity::TimeStep),
        &[
            "dt",
            "deltat",
            "dtime",
            "timestep",
            "deltatime",
            "timedelta",
        ],
    ),
    (Word::Difference, &["delta", "diff", "difference"]),
    (
        Word::Scalar(Quantity::Index),
        &[
            "sample",
            "samples",
            "index",
            "idx",
            "row",
            "counter",
            "count",
            "cnt",
            "seq",
            "iteration",
            "frame",
            "packet",
            "packetcounter",
            "record",
            "line",
            "nr",
            "no",
            "num",
        ],
    ),
    (Word::Scalar(Quantity::Instance), &["instance"]),
    (
        Word::Scalar(Quantity::Temperature),
        &["temp", "temperature", "tmp"],
    ),
    (
        Word::Scalar(Quantity::Label),
        &["part", "label", "section", "placement", "pose", "face"],
    ),
    (Word::WithoutGravity, &["linear", "lin", "user", "free"]),
    (
        Word::Foreign,
        &[
            "gravity",
            "grav",
            "quat",
            "quaternion",
            "pos",
            "position3d",
            "vel",
            "velocity3d",
            "jerk",
            "bias",
            "offset",
            "std",
            "sigma",
            "var",
            "variance",
        ],
    ),
    (Word::Filler, &["data", "value", "field", "axis"]),
];

/// Beginnings of words that are not in [`WORDS`].
const BEGINNINGS: &[(Word, &[&str])] = &[
    (Word::Accel, &["accel"]),
    (
        Word::Gyro,
        &["gyro", "rotationrate", "angularvelocity", "angularrate"],
    ),
    (
        Word::Foreign,
        &["mag", "baro", "press", "humid", "orient", "euler", "cov"],
    ),
];

/// Pairs of words that mean one quantity.
const PAIRS: &[(Word, [&str; 2])] = &[
    (Word::Gyro, ["angular", "velocity"]),
    (Word::Gyro, ["angular", "rate"]),
    (Word::Gyro, ["rotation", "rate"]),
    (Word::Gyro, ["turn", "rate"]),
];

/// Names that mean a quantity only as a whole.
const NAMES: &[(Quantity, &[&str])] = &[
    (
        Quantity::Instance,
        &[
            "i",
            "imu",
            "imu id",
            "sensor",
            "sensor id",
            "instance id",
            "sensor index",
        ],
    ),
    (Quantity::Time, &["s", "ms", "us", "ns", "sec", "secs"]),
];

fn look_up(table: &[(Word, &[&str])], fits: impl Fn(&str) -> bool) -> Option<Word> {
    let of = |(word, list): &(Word, &[&str])| list.iter().any(|w| fits(w)).then_some(*word);
    table.iter().find_map(of)
}

fn meaning(word: &str) -> Option<Word> {
    look_up(WORDS, |w| w == word).or_else(|| {
        // `accelx` is an axis of a word that begins with `accel`.
        let begins = |w: &str| word.starts_with(w) && !word.ends_with(['x', 'y', 'z']);
        look_up(BEGINNINGS, begins)
            .or_else(|| time_with_unit(word).map(|_| Word::Scalar(Quantity::Time)))
    })
}

/// `ustime`, `timems`, `timestampus` → the unit; `uptime`, `systime` have none.
fn time_with_unit(word: &str) -> Option<Option<TimeUnit>> {
    let (before, after) = word
        .split_once("timestamp")
        .or_else(|| word.split_once("time"))?;
    Some(TimeUnit::parse(before).or_else(|| TimeUnit::parse(after)))
}

/// Parses a column name; `None` if it names no quantity that is read.
#[must_use]
pub fn understand(name: &str) -> Option<ColumnName> {
    let Parts {
        mut words,
        bracketed,
    } = Parts::of(name);
    if words.is_empty() || words.iter().any(|w| meaning(w) == Some(Word::Foreign)) {
        return None;
    }
    let (quantity, hinted_unit) = find_axis_quantity(&mut words)
        .or_else(|| find_rate_by_unit(&mut words, bracketed.as_deref()))
        .or_else(|| find_scalar_quantity(&mut words))?;
    let (unit_words, sensor_words): (Vec<String>, Vec<String>) = match bracketed {
        Some(_) => (Vec::new(), words),
        None => words.into_iter().partition(|w| is_unit_word(w)),
    };
    let says = |word: Word| move |w: &String| meaning(w) == Some(word);
    let without_gravity = sensor_words.iter().any(says(Word::WithoutGravity));
    let unit = bracketed
        .or_else(|| (!unit_words.is_empty()).then(|| unit_words.join("/")))
        .or(hinted_unit);
    Some(ColumnName {
        quantity,
        unit,
        sensor: sensor_words
            .into_iter()
            .filter(|w| !says(Word::WithoutGravity)(w) && !says(Word::Filler)(w))
            .collect::<Vec<_>>()
            .join(" "),
        without_gravity,
    })
}

/// A name that consists of an axis only (`x`, `X (m/s^2)`, `x-axis (g)`): the axis and its unit.
#[must_use]
pub fn bare_axis(name: &str) -> Option<(usize, Option<String>)> {
    let Parts { words, bracketed } = Parts::of(name);
    let mut left = words.iter().filter(|w| meaning(w) != Some(Word::Filler));
    let axis = axis_of(left.next()?)?;
    left.next().is_none().then_some((axis, bracketed))
}

/// `mean_x_g`, `std x mg`: an axis of an accelerometer, whose last word is its unit. Elsewhere a
/// `g` beside an axis means the gyroscope; use this only where no column names an accelerometer.
pub(super) fn axis_in_g(name: &str) -> Option<ColumnName> {
    let Parts { words, bracketed } = Parts::of(name);
    let (unit, before) = words.split_last()?;
    if bracketed.is_some() || !matches!(unit.as_str(), "g" | "mg") {
        return None;
    }
    let (axis, sensor) = before.split_last()?;
    Some(ColumnName {
        quantity: Quantity::Accel(axis_of(axis)?),
        unit: Some(unit.clone()),
        sensor: sensor.join(" "),
        without_gravity: false,
    })
}

/// Sensor named by a file such as `Gyroscope.csv`, for columns that do not name it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SensorKind {
    /// The accelerometer; `true` if gravity was removed.
    Accelerometer(bool),
    /// The gyroscope.
    Gyroscope,
    /// Another sensor, such as a magnetometer.
    Other,
}

/// The sensor named by a file name; `None` without one.
#[must_use]
pub fn sensor_of_file(name: &str) -> Option<SensorKind> {
    let file = name.rsplit(['/', '\\']).next().unwrap_or(name);
    let words = split_words(file.split('.').next().unwrap_or(file));
    // Short words are ambiguous in file names.
    let says = |word: Word| {
        let mut long = words.iter().filter(|w| w.len() > 2);
        long.any(|w| meaning(w) == Some(word))
    };
    let together = PAIRS
        .iter()
        .any(|(_, pair)| words.windows(2).any(|w| w[0] == pair[0] && w[1] == pair[1]));
    if says(Word::Accel) {
        Some(SensorKind::Accelerometer(says(Word::WithoutGravity)))
    } else if says(Word::Gyro) || together {
        Some(SensorKind::Gyroscope)
    } else if says(Word::Foreign) {
        Some(SensorKind::Other)
    } else {
        None
    }
}

/// True for the name of a quantity that is not read here and may rise steadily.
pub(super) fn is_foreign(name: &str) -> bool {
    let foreign = |w: &String| meaning(w) == Some(Word::Foreign);
    Parts::of(name).words.iter().any(foreign)
}

/// Words of a name, and the unit in its brackets.
struct Parts {
    words: Vec<String>,
    bracketed: Option<String>,
}

impl Parts {
    /// `Accelerometer X (g)` → `accelerometer`, `x`; `g`. An index in brackets is the axis if no
    /// letter is: `gyroADC[0]`.
    fn of(name: &str) -> Self {
        let mut outside = name.trim().trim_matches('"').to_owned();
        let mut inside = Vec::new();
        while let Some((from, to)) = bracket(&outside) {
            let text = outside[from + 1..to].trim().to_lowercase();
            inside.extend((!text.is_empty()).then_some(text));
            outside.replace_range(from..=to, " ");
        }
        let mut words = split_words(&outside);
        let has_axis = words.iter().any(|w| axis_of(w).is_some());
        if let Some(at) = inside.iter().position(|text| index_axis(text).is_some()) {
            let axis = index_axis(&inside.remove(at)).filter(|_| !has_axis);
            words.extend(axis.map(str::to_owned));
        }
        let is_unit = |text: &&String| {
            AccelUnit::parse(text).is_some()
                || GyroUnit::parse(text).is_some()
                || TimeUnit::parse(text).is_some()
        };
        Parts {
            words,
            bracketed: inside.iter().find(is_unit).or(inside.first()).cloned(),
        }
    }
}

/// Positions of the first opening bracket and of its closing one; brackets may be nested.
fn bracket(name: &str) -> Option<(usize, usize)> {
    let from = name.find(['(', '[', '{'])?;
    let (open, close) = match name.as_bytes()[from] {
        b'(' => ('(', ')'),
        b'[' => ('[', ']'),
        _ => ('{', '}'),
    };
    let mut depth = 0;
    for (at, c) in name[from..].char_indices() {
        depth += i32::from(c == open) - i32::from(c == close);
        if depth == 0 {
            return Some((from, from + at));
        }
    }
    None
}

fn index_axis(text: &str) -> Option<&'static str> {
    match text {
        "0" => Some("x"),
        "1" => Some("y"),
        "2" => Some("z"),
        _ => None,
    }
}

/// Splits a name into lower-case words: at every character that is not a letter or digit, between
/// a lower-case and an upper-case letter, and between letters and digits that form no unit
/// together (`mps2`).
pub(super) fn split_words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut before = ' ';
    for c in name.chars() {
        if !c.is_alphanumeric() {
            words.push(String::new());
        } else {
            if c.is_uppercase() && before.is_lowercase() {
                words.push(String::new());
            }
            if let Some(word) = words.last_mut() {
                word.extend(c.to_lowercase());
            }
        }
        before = c;
    }
    let cut = |word: String| -> Vec<String> {
        let digits = word.find(|c: char| c.is_ascii_digit());
        match digits {
            Some(at) if at > 0 && !is_unit_word(&word) && meaning(&word).is_none() => {
                vec![word[..at].to_owned(), word[at..].to_owned()]
            }
            _ => vec![word],
        }
    };
    words.retain(|w| !w.is_empty());
    words.into_iter().flat_map(cut).collect()
}

fn axis_of(word: &str) -> Option<usize> {
    match word {
        "x" => Some(0),
        "y" => Some(1),
        "z" => Some(2),
        _ => None,
    }
}

/// Sensor and axis in one word: `ax`, `gyroz`, `xacc`; `gfx`, g-force.
fn kind_with_axis(word: &str) -> Option<(Word, usize, Option<String>)> {
    let kind = |stem: &str| meaning(stem).filter(|k| matches!(k, Word::Accel | Word::Gyro));
    let mut letters = word.chars();
    if let Some(axis) = letters.next_back().and_then(|c| axis_of(&c.to_string())) {
        let stem = letters.as_str();
        if stem == "gf" {
            return Some((Word::Accel, axis, Some("g".to_owned())));
        }
        if let Some(kind) = kind(stem) {
            return Some((kind, axis, None));
        }
    }
    let mut letters = word.chars();
    let axis = letters.next().and_then(|c| axis_of(&c.to_string()))?;
    let stem = letters.as_str();
    (stem.len() > 2).then(|| Some((kind(stem)?, axis, None)))?
}

/// Quantity with an axis, in one word (`ax`, `gyroz`) or in several.
fn find_axis_quantity(words: &mut Vec<String>) -> Option<(Quantity, Option<String>)> {
    let as_quantity = |kind, axis| match kind {
        Word::Accel => Quantity::Accel(axis),
        _ => Quantity::Gyro(axis),
    };
    // `gFx` was split into two words.
    if let [first, second] = &words[..]
        && first == "g"
        && second.starts_with('f')
        && second.len() == 2
    {
        *words = vec![format!("{first}{second}")];
    }
    for i in (0..words.len()).rev() {
        if let Some((kind, axis, unit)) = kind_with_axis(&words[i]) {
            words.remove(i);
            return Some((as_quantity(kind, axis), unit));
        }
    }
    let axis_at = words.iter().rposition(|w| axis_of(w).is_some());
    let (axis_at, axis) = match axis_at {
        Some(at) => (at, axis_of(&words[at])?),
        // `acc_0`: a number in place of the letter.
        None => {
            let at = words.len().checked_sub(1)?;
            (at, index_axis(&words[at]).and_then(axis_of)?)
        }
    };
    let pair = PAIRS.iter().find_map(|(word, pair)| {
        let at = words
            .windows(2)
            .position(|w| w[0] == pair[0] && w[1] == pair[1])?;
        Some((*word, at, 2))
    });
    // Prefer long words: in `imu_a acc x` the `a` belongs to the name of the sensor.
    let single = || {
        (0..words.len())
            .filter(|&i| i != axis_at)
            .filter_map(|i| Some((meaning(&words[i])?, i, 1)))
            .filter(|(kind, ..)| matches!(kind, Word::Accel | Word::Gyro))
            .max_by_key(|&(_, i, _)| words[i].len())
    };
    let (kind, at, length) = pair.or_else(single)?;
    let mut i = 0;
    words.retain(|_| {
        let taken = i == axis_at || (at..at + length).contains(&i);
        i += 1;
        !taken
    });
    Some((as_quantity(kind, axis), None))
}

/// `Rotation X (rad/s)`, `AsX(°/s)`: an axis with a unit of angular rate.
fn find_rate_by_unit(
    words: &mut Vec<String>,
    unit: Option<&str>,
) -> Option<(Quantity, Option<String>)> {
    // `deg` alone is an angle here.
    let per_time = |u: &str| {
        ["/s", "/h", "s-1", "s^-1", "s⁻¹", "dps"]
            .iter()
            .any(|t| u.contains(t))
    };
    let is_rate = |u: &str| per_time(u) && GyroUnit::parse(u).is_some();
    let at = words.iter().rposition(|w| axis_of(w).is_some())?;
    let axis = axis_of(&words[at]).filter(|_| words.len() > 1 && unit.is_some_and(is_rate))?;
    words.remove(at);
    Some((Quantity::Gyro(axis), None))
}

/// Order of precedence if several words name a quantity.
const SCALARS: [Quantity; 6] = [
    Quantity::TimeStep,
    Quantity::Time,
    Quantity::Temperature,
    Quantity::Label,
    Quantity::Instance,
    Quantity::Index,
];

fn find_scalar_quantity(words: &mut Vec<String>) -> Option<(Quantity, Option<String>)> {
    let whole = words.join(" ");
    if let Some((quantity, _)) = NAMES.iter().find(|(_, n)| n.contains(&whole.as_str())) {
        words.clear();
        return Some((*quantity, Some(whole)));
    }
    let (quantity, at) = SCALARS.iter().find_map(|q| {
        let at = words
            .iter()
            .position(|w| meaning(w) == Some(Word::Scalar(*q)))?;
        Some((*q, at))
    })?;
    let word = words.remove(at);
    let unit = TimeUnit::parse(&word).or_else(|| time_with_unit(&word).flatten());
    let differences = words.len();
    words.retain(|w| meaning(w) != Some(Word::Difference));
    let is_step = quantity == Quantity::Time && words.len() < differences;
    let quantity = if is_step {
        Quantity::TimeStep
    } else {
        quantity
    };
    // Ticks of 100 µs or of 1 µs: the steps decide which.
    let fine = quantity == Quantity::Time && words.iter().any(|w| w == "fine");
    let unit = match fine {
        true => Some("fine".to_owned()),
        false => unit.map(|u| u.name().to_owned()),
    };
    Some((quantity, unit))
}

fn is_unit_word(word: &str) -> bool {
    matches!(
        word,
        "g" | "mg"
            | "mps2"
            | "ms2"
            | "m"
            | "s2"
            | "rad"
            | "deg"
            | "dps"
            | "mdps"
            | "s"
            | "ms"
            | "us"
            | "ns"
            | "sec"
            | "c"
            | "degc"
            | "f"
            | "k"
            | "lsb"
            | "counts"
            | "rads"
            | "degs"
    ) || TimeUnit::parse(word).is_some()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn q(name: &str) -> (Quantity, Option<String>) {
        let c = understand(name).unwrap_or_else(|| panic!("{name} is not recognised"));
        (c.quantity, c.unit)
    }

    #[test]
    fn column_names_have_quantity_and_unit() {
        use Quantity::*;
        for (name, quantity, unit) in [
            ("aX (g)", Accel(0), Some("g")),
            ("acc_x", Accel(0), None),
            ("ax", Accel(0), None),
            ("AccY", Accel(1), None),
            ("accelZ", Accel(2), None),
            ("scaledAccelX", Accel(0), None),
            ("Accelerometer X (g)", Accel(0), Some("g")),
            ("imu.acc.x", Accel(0), None),
            ("x_acc", Accel(0), None),
            ("acceleration_y [m/s²]", Accel(1), Some("m/s²")),
            ("ax_mps2", Accel(0), Some("mps2")),
            ("ax_calibrated_g", Accel(0), Some("g")),
            ("acc_z_mg", Accel(2), Some("mg")),
            ("linear_acceleration.z", Accel(2), None),
            ("gX (°/s)", Gyro(0), Some("°/s")),
            ("gx", Gyro(0), None),
            ("gyr_y", Gyro(1), None),
            ("Gyroscope Z (deg/s)", Gyro(2), Some("deg/s")),
            ("scaledGyroX", Gyro(0), None),
            ("imu.gyro.x", Gyro(0), None),
            ("gx_rad_s", Gyro(0), Some("rad/s")),
            ("angular_velocity.x", Gyro(0), None),
            ("angularVelocityZ", Gyro(2), None),
            ("wz", Gyro(2), None),
            ("Temp (C)", Temperature, Some("c")),
            ("imu.temperature", Temperature, None),
            ("temperature_c", Temperature, Some("c")),
            ("Timestamp", Time, None),
            ("relative_time", Time, None),
            ("Time (s)", Time, Some("s")),
            ("t_s", Time, Some("s")),
            ("time_ms", Time, Some("ms")),
            ("millis", Time, Some("ms")),
            ("w_RS_S_x [rad s^-1]", Gyro(0), Some("rad s^-1")),
            ("a_RS_S_z [m s^-2]", Accel(2), Some("m s^-2")),
            ("DEVICE_Accel_LN_X_CAL", Accel(0), None),
            ("gyro_rad[0]", Gyro(0), Some("rad")),
            ("accelerometer_m_s2[2]", Accel(2), Some("m/s2")),
            ("gyroADC[1]", Gyro(1), None),
            ("accSmooth[2] (counts)", Accel(2), Some("counts")),
            ("field.linear_acceleration.x", Accel(0), None),
            ("AccelerationX", Accel(0), None),
            ("gFx", Accel(0), Some("g")),
            ("GyrX", Gyro(0), None),
            ("AsX(°/s)", Gyro(0), Some("°/s")),
            ("Rotation Z (rad/s)", Gyro(2), Some("rad/s")),
            ("gx [mdps]", Gyro(0), Some("mdps")),
            ("omega_y", Gyro(1), None),
            ("alpha_y", Accel(1), None),
            ("header.stamp.nanosec", Time, Some("nanosec")),
            ("nanosec", Time, Some("ns")),
            ("zacc", Accel(2), None),
            ("Accel_X (m/(s^2))", Accel(0), Some("m/(s^2)")),
            ("Static/Angular Velocity/X", Gyro(0), None),
            ("ustime", Time, Some("us")),
            ("TimeUS", Time, Some("us")),
            ("GPST", Time, None),
            ("SampleTimeFine", Time, Some("fine")),
            ("seconds_elapsed", Time, Some("s")),
            ("epoc (ms)", Time, Some("ms")),
            ("elapsed (s)", Time, Some("s")),
            ("us", Time, Some("us")),
            ("timestamp [ns]", Time, Some("ns")),
            ("dt", TimeStep, None),
            ("delta_t (ms)", TimeStep, Some("ms")),
            ("gyro_integral_dt", TimeStep, None),
            ("I", Instance, Some("i")),
            ("loopIteration", Index, None),
            ("PacketCounter", Index, None),
            ("n_samples", Index, None),
            ("samples", Index, None),
            ("part", Label, None),
        ] {
            assert_eq!(q(name), (quantity, unit.map(str::to_owned)), "{name}");
        }
    }

    #[test]
    fn similar_names_of_other_quantities_are_ignored() {
        for name in [
            "LinearAccelerometerSensor",
            "mag_x",
            "pos_x",
            "qw",
            "movement",
            "imu.status",
            "gravity.x",
            "x",
            "L_TOE.x",
            "field.linear_acceleration_covariance0",
            "Mat[1][1]",
            "motor[0]",
            "VelInc_X",
            "device_id",
            "foot",
            "start",
            "AngleX(deg)",
            "Tilt X (rad)",
            "Velocity X (m/s)",
        ] {
            assert_eq!(understand(name), None, "{name}");
        }
    }

    #[test]
    fn remaining_words_name_the_sensor() {
        assert_eq!(
            understand("left_sensor.acc_x").unwrap().sensor,
            "left sensor"
        );
        for name in [
            "userAcceleration.x",
            "Linear Acceleration x (m/s^2)",
            "FreeAcc_Z",
        ] {
            assert!(understand(name).unwrap().without_gravity, "{name}");
        }
        let (left, right) = ("DEVICE_Accel_LN_X_CAL", "DEVICE_Accel_WR_X_CAL");
        assert_eq!(understand(left).unwrap().sensor, "device ln cal");
        assert_eq!(understand(right).unwrap().sensor, "device wr cal");
        assert_eq!(understand("acc1_x").unwrap().sensor, "1");
    }

    #[test]
    fn bare_axes_and_sensors_of_file_names() {
        for (name, axis, unit) in [
            ("x", 0, None),
            ("X (m/s^2)", 0, Some("m/s^2")),
            ("y-axis (g)", 1, Some("g")),
            ("\"Z (rad/s)\"", 2, Some("rad/s")),
        ] {
            assert_eq!(
                bare_axis(name),
                Some((axis, unit.map(str::to_owned))),
                "{name}"
            );
        }
        assert!(bare_axis("L_TOE.x").is_none() && bare_axis("t").is_none());
        use SensorKind::*;
        for (file, kind) in [
            ("a/Gyroscope.csv", Some(Gyroscope)),
            ("gyr_1.txt", Some(Gyroscope)),
            ("TotalAcceleration.csv", Some(Accelerometer(false))),
            ("LinearAcceleration.csv", Some(Accelerometer(true))),
            ("accel_x.csv", Some(Accelerometer(false))),
            ("Magnetometer.csv", Some(Other)),
            ("Gravity.csv", Some(Other)),
            ("x_up.csv", None),
        ] {
            assert_eq!(sensor_of_file(file), kind, "{file}");
        }
    }
}

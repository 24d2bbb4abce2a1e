//! What the name of a column says.

use gravical_judge::Role;
use gravical_judge::units::{AccelUnit, GyroUnit, is_celsius, is_listed, time_scale_s};

/// A column as its name, or the row of units, describes it.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Column {
    /// What it holds
    pub role: Role,
    /// Unit as written, lower case; empty if none is given
    pub unit: String,
    /// Words of the name beside quantity and axis: tells several sensors apart
    pub sensor: String,
    /// Acceleration from which gravity was removed
    pub is_linear: bool,
    /// The cells are dates or times of day, which count in seconds
    pub is_dated: bool,
    /// The user says what it holds
    pub is_given: bool,
    /// The user says that it is not read as what its name says
    pub is_dropped: bool,
    /// Its name tells a quantity that is not read: a magnetic field, an angle
    pub is_foreign: bool,
}

const ACCEL: &str = "a ac acc accl acce xl sf alpha";
const GYRO: &str = "g gy gyr w omega rate rot rotation angular angvel";
const GYRO_STEMS: [&str; 4] = ["gyro", "giro", "dreh", "angularvel"];
const TIME: &str = "t ts time stamp timestamp timestamps epoch epoc clock elapsed gpst date datetime \
    utc millis micros nanos seconds minutes hours days us ms ns s";
const TIME_UNITS: &str =
    "us ms ns s secs nsecs nanosec micros millis seconds fine min minutes h hours days";
const STEP: &str = "dt delta deltat timestep diff";
const LABEL: &str = "label part section pose face placement";
/// Words of quantities that have axes too, or belong to a result.
const FOREIGN: &str = "mag magnetometer baro pressure quat orientation euler cov covariance pos vel \
    light lux humidity battery gravity grav angle angles roll pitch yaw std sd variance velocity3d position3d true";
const UNIT_WORDS: &str = "g mg mps mps2 ms2 m s2 rad deg dps s ms us ns c counts cal 2";

/// `accX_raw` → `acc`, `x`, `raw`.
pub(crate) fn words(name: &str) -> Vec<String> {
    let mut out = vec![String::new()];
    let mut before = ' ';
    for c in name.chars() {
        let begins = c.is_uppercase() && before.is_lowercase()
            || c.is_ascii_digit() && before.is_alphabetic();
        if !c.is_alphanumeric() || begins {
            out.push(String::new());
        }
        if c.is_alphanumeric()
            && let Some(word) = out.last_mut()
        {
            word.extend(c.to_lowercase());
        }
        before = c;
    }
    out.retain(|w| !w.is_empty());
    out
}

pub(crate) fn axis(word: &str) -> Option<usize> {
    ["x", "y", "z"].iter().position(|a| *a == word)
}

/// The sensor that a word names: `Accel(0)` or `Gyro(0)`, to be given its axis.
pub(crate) fn sensor(word: &str) -> Option<fn(usize) -> Role> {
    if is_listed(ACCEL, word) || word.starts_with("accel") || word.ends_with("acceleration") {
        Some(Role::Accel)
    } else if is_listed(GYRO, word) || GYRO_STEMS.iter().any(|stem| word.starts_with(stem)) {
        Some(Role::Gyro)
    } else {
        None
    }
}

/// Name and unit in brackets: `accX (g)` → `accX `, `g`.
fn split_unit(name: &str) -> (String, String) {
    match (name.find(['(', '[']), name.rfind([')', ']'])) {
        (Some(a), Some(b)) if b > a => (
            format!("{} {}", &name[..a], &name[b + 1..]),
            name[a + 1..b].to_lowercase(),
        ),
        _ => (name.to_owned(), String::new()),
    }
}

impl Column {
    pub(crate) fn is_accel(&self) -> bool {
        matches!(self.role, Role::Accel(_))
    }

    /// Gravity may be removed from it: ROS calls raw acceleration linear, too. Where another accelerometer
    /// stands beside it, it is.
    pub(crate) fn may_be_linear(&self) -> bool {
        self.is_linear || self.sensor.split(' ').any(|word| word == "linear")
    }

    pub(crate) fn is_gyro(&self) -> bool {
        matches!(self.role, Role::Gyro(_))
    }

    /// Seconds of the unit of a clock, if the file states it.
    pub(crate) fn stated_unit_s(&self) -> Option<f64> {
        let seconds = self.is_dated.then_some(1.0);
        seconds.or_else(|| time_scale_s(&self.unit))
    }

    /// What a name says by known words.
    pub(crate) fn from_name(name: &str) -> Self {
        let (outside, unit) = split_unit(name);
        let words = words(&outside);
        let has = |list: &str| words.iter().any(|w| is_listed(list, w));
        let index = unit.parse::<usize>().ok().filter(|i| *i < 3);
        let mut column = Column {
            unit,
            ..Column::default()
        };
        if has(FOREIGN) {
            column.is_foreign = true;
            return column;
        }
        if let Some((role, places)) = axis_in_word(&words).or_else(|| axis_apart(&words, index)) {
            let rest = words.iter().enumerate();
            let rest = rest.filter(|(at, _)| !places.contains(at));
            let (units, sensor): (Vec<&str>, Vec<&str>) = rest
                .map(|(_, word)| word.as_str())
                .partition(|w| is_listed(UNIT_WORDS, w));
            if column.unit.is_empty() || index.is_some() {
                // `m`, `s`, `2` are m/s2.
                column.unit = units.join("/").replace("/2", "2");
            }
            column.role = role;
            // `totalacceleration` is not the `accelerometer` beside it.
            let compound = words[places[1]].strip_suffix("acceleration");
            let sensor = sensor
                .into_iter()
                .chain(compound)
                .filter(|word| !word.is_empty());
            column.sensor = sensor.collect::<Vec<_>>().join(" ");
            let is_linear = words.iter().any(|w| is_linear(w));
            column.is_linear = is_linear && !has("field") && !outside.contains(['_', '.']);
        } else if !has("x y z") {
            column.role = role_without_axis(&words, &column.unit);
            if column.unit.is_empty() {
                let units: Vec<&str> = words.iter().filter_map(|w| time_unit(w)).collect();
                column.unit = units.join(" ");
            }
        }
        column
    }
}

/// `ax`, `gyroz`, `gFx`, `accz`: sensor and axis in one word, and its place.
fn axis_in_word(words: &[String]) -> Option<(Role, [usize; 2])> {
    (0..words.len()).rev().find_map(|at| {
        let word = &words[at];
        let (stem, last) = word.split_at(word.char_indices().next_back()?.0);
        let is_g_force = stem == "gf" || stem == "f" && at > 0 && words[at - 1] == "g";
        let stem = if is_g_force { "accel" } else { stem };
        // `GyX` is no `gy`.
        let is_before_axis = words.get(at + 1).is_some_and(|next| axis(next).is_some());
        let role = sensor(stem).filter(|_| !is_before_axis)?;
        Some((role(axis(last)?), [at, at]))
    })
}

/// Sensor and axis with the places of their words; the axis is a word of its own, an index in
/// brackets, or the last digit.
fn axis_apart(words: &[String], index: Option<usize>) -> Option<(Role, [usize; 2])> {
    let (at, axis) = if let Some(at) = words.iter().rposition(|w| axis(w).is_some()) {
        (at, axis(&words[at])?)
    } else if let Some(index) = index {
        (words.len(), index)
    } else {
        let digit = words.last()?.parse().ok().filter(|i| *i < 3)?;
        (words.len() - 1, digit)
    };
    // A single letter is a sensor only before its axis: `x_g` is in g.
    let (named_at, role) = (0..words.len())
        .filter(|k| *k < at || *k != at && words[*k].len() > 1)
        .filter_map(|k| Some((k, sensor(&words[k])?)))
        .max_by_key(|(k, _)| words[*k].len())?;
    Some((role(axis), [at, named_at]))
}

/// What a name without an axis says.
fn role_without_axis(words: &[String], unit: &str) -> Role {
    let has = |list: &str| words.iter().any(|w| is_listed(list, w));
    let is_temperature = has("temperature tmp") || words.iter().any(|w| w.ends_with("temp"));
    match () {
        _ if has(STEP) => Role::Step,
        _ if has(TIME) || words.iter().any(|w| w.contains("time") && w != "uptime") => Role::Time,
        _ if is_temperature || is_celsius(unit) => Role::Temperature,
        _ if has(LABEL) => Role::Label,
        _ => Role::Other,
    }
}

/// `us` of `us`, `timeus` and `ustime`.
fn time_unit(word: &str) -> Option<&'static str> {
    TIME_UNITS.split(' ').find(|unit| {
        word == *unit
            || word.strip_prefix("time") == Some(unit)
            || word.strip_suffix("time") == Some(unit)
    })
}

/// The sensor that the name of a file (without its folder) tells: a role of its first axis,
/// [`Role::Other`] for one that is not read. Short words are ambiguous in file names.
pub(crate) fn sensor_of_file(name: &str) -> Option<Role> {
    let mut words = words(name.split('.').next().unwrap_or(name));
    words.retain(|w| w.len() > 2);
    let named: Vec<Role> = words.iter().filter_map(|w| Some(sensor(w)?(0))).collect();
    let is_other = words.iter().any(|w| is_listed(FOREIGN, w));
    let mut sensors = [Role::Accel(0), Role::Gyro(0)].into_iter();
    let first = sensors.find(|role| named.contains(role));
    first.or(is_other.then_some(Role::Other))
}

pub(crate) fn is_linear(word: &str) -> bool {
    matches!(word, "linear" | "lin" | "user" | "free")
}

/// What unit and last letter say where no word is known: `Beschleunigung x (m/s^2)`, `x_g`.
pub(crate) fn role_from_unit(name: &str, unit: &str, file: Option<Role>) -> Option<Role> {
    let (outside, _) = split_unit(name);
    let mut words = words(&outside);
    let mut unit = unit.to_owned();
    while words.len() > 1
        && let Some(word) = words.pop_if(|w| is_listed(UNIT_WORDS, w) || is_listed("axis value", w))
    {
        if unit.is_empty() && !is_listed("axis value", &word) {
            unit = word;
        }
    }
    let last = words.last()?;
    let axis = axis(&last[last.char_indices().next_back()?.0..])?;
    let is_bare = words.len() == 1 && last.len() == 1;
    let is_axis_word = last.len() == 1 || !last.is_ascii();
    let accel_unit = AccelUnit::parse(&unit);
    let is_accel = accel_unit.is_some();
    // Both sensors may be in counts.
    let may_be_gyro = !is_accel || accel_unit == Some(AccelUnit::Counts);
    match () {
        _ if is_axis_word && !is_accel && GyroUnit::parse(&unit).is_some() => {
            Some(Role::Gyro(axis))
        }
        _ if is_bare && may_be_gyro && file == Some(Role::Gyro(0)) => Some(Role::Gyro(axis)),
        _ if is_bare && !is_accel && file == Some(Role::Other) => None,
        _ if is_bare || is_accel && is_axis_word => Some(Role::Accel(axis)),
        _ => None,
    }
}

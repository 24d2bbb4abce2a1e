//! What a column is called in the wild, and what it therefore holds.
//!
//! `aX (g)`, `acc_x`, `ax`, `AccX`, `scaledAccelX`, `Accelerometer X (g)`,
//! `imu.acc.x`, `linear_acceleration.x`, `gyr_x`, `angularVelocityZ`,
//! `Temp (C)`, `t_s`, `Timestamp` … A name is cut into words; one word says
//! the quantity, one the axis, what is left may be a unit or the name of the
//! sensor.

/// A quantity that gravical reads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Time stamp.
    Time,
    /// A row counter; no time.
    Index,
    /// Specific force along axis 0, 1 or 2.
    Accel(usize),
    /// Angular rate about axis 0, 1 or 2.
    Gyro(usize),
    /// Temperature of the sensor.
    Temperature,
    /// Which section the row belongs to.
    Label,
}

/// A column name, understood.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ColumnName {
    /// What it holds.
    pub quantity: Quantity,
    /// The unit it claims, in its own words, lower case.
    pub unit: Option<String>,
    /// What is left: the name of the sensor (`left sensor`), or nothing.
    pub sensor: String,
    /// True for acceleration that has gravity taken out by somebody else
    /// (`userAcceleration`, `LinearAcceleration`): a last resort.
    pub without_gravity: bool,
}

/// Understands a column name; none when it holds nothing that is read here.
#[must_use]
pub fn understand(name: &str) -> Option<ColumnName> {
    let (plain, bracketed) = take_bracket(name.trim().trim_matches('"'));
    let mut words = split_words(&plain);
    if words.is_empty() {
        return None;
    }
    if words.iter().any(|w| is_foreign(w)) {
        return None;
    }
    let found = find_axis_quantity(&mut words).or_else(|| find_scalar_quantity(&mut words))?;
    let (quantity, hinted_unit) = found;
    let (unit_words, sensor_words): (Vec<String>, Vec<String>) = match bracketed {
        Some(_) => (Vec::new(), words),
        None => words.into_iter().partition(|w| is_unit_word(w)),
    };
    let without_gravity = sensor_words
        .iter()
        .any(|w| matches!(w.as_str(), "linear" | "user"));
    let unit = bracketed
        .or_else(|| (!unit_words.is_empty()).then(|| unit_words.join("/")))
        .or_else(|| hinted_unit.map(str::to_owned));
    Some(ColumnName {
        quantity,
        unit,
        sensor: sensor_words
            .into_iter()
            .filter(|w| !matches!(w.as_str(), "linear" | "user" | "data" | "value"))
            .collect::<Vec<_>>()
            .join(" "),
        without_gravity,
    })
}

/// `Accelerometer X (g)` → `Accelerometer X`, `g`.
fn take_bracket(name: &str) -> (String, Option<String>) {
    for (open, close) in [('(', ')'), ('[', ']'), ('{', '}')] {
        if let (Some(from), Some(to)) = (name.find(open), name.rfind(close))
            && from < to
        {
            let inside = name[from + open.len_utf8()..to].trim().to_lowercase();
            let outside = format!("{} {}", &name[..from], &name[to + close.len_utf8()..]);
            if !inside.is_empty() {
                return (outside, Some(inside));
            }
        }
    }
    (name.to_owned(), None)
}

/// Words of a name: cut at anything that is no letter or digit and where a
/// lower-case letter is followed by an upper-case one; lower case.
fn split_words(name: &str) -> Vec<String> {
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
    words.retain(|w| !w.is_empty());
    words
}

fn axis_of(word: &str) -> Option<usize> {
    match word {
        "x" => Some(0),
        "y" => Some(1),
        "z" => Some(2),
        _ => None,
    }
}

/// Quantities that look alike and are something else.
fn is_foreign(word: &str) -> bool {
    matches!(
        word,
        "gravity" | "grav" | "quat" | "quaternion" | "pos" | "position3d" | "vel" | "velocity3d"
    ) || ["mag", "baro", "press", "humid", "orient", "euler"]
        .iter()
        .any(|p| word.starts_with(p))
}

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Accel,
    Gyro,
}

fn kind_of(word: &str) -> Option<Kind> {
    let is = |list: &[&str]| list.contains(&word);
    if is(&["a", "acc", "accel", "accl", "acce", "xl", "sf"])
        || (word.starts_with("accel") && !word.ends_with(|c| "xyz".contains(c)))
    {
        Some(Kind::Accel)
    } else if is(&["g", "gyr", "gyro", "w", "omega", "rate", "rot", "angvel"])
        || (word.starts_with("gyro") && !word.ends_with(|c| "xyz".contains(c)))
        || (word.starts_with("rotationrate") || word.starts_with("angularvelocity"))
    {
        Some(Kind::Gyro)
    } else {
        None
    }
}

/// A quantity with an axis, in one word (`ax`, `gyroz`) or in several.
fn find_axis_quantity(words: &mut Vec<String>) -> Option<(Quantity, Option<&'static str>)> {
    let as_quantity = |kind, axis| match kind {
        Kind::Accel => Quantity::Accel(axis),
        Kind::Gyro => Quantity::Gyro(axis),
    };
    // One word that carries both: the last letter is the axis.
    for i in (0..words.len()).rev() {
        let word = words[i].clone();
        let mut letters = word.chars();
        let Some(axis) = letters.next_back().and_then(|c| axis_of(&c.to_string())) else {
            continue;
        };
        let stem = letters.as_str();
        if !stem.is_empty()
            && let Some(kind) = kind_of(stem)
        {
            words.remove(i);
            return Some((as_quantity(kind, axis), None));
        }
    }
    let axis_at = words.iter().rposition(|w| axis_of(w).is_some())?;
    let axis = axis_of(&words[axis_at])?;
    // `angular velocity x`, `rotation rate x`: two words that belong together.
    let pair = words.windows(2).position(|w| {
        matches!(
            (w[0].as_str(), w[1].as_str()),
            ("angular", "velocity") | ("angular", "rate") | ("rotation", "rate") | ("turn", "rate")
        )
    });
    if let Some(at) = pair {
        let mut rest = Vec::new();
        for (i, word) in words.drain(..).enumerate() {
            if i != at && i != at + 1 && i != axis_at {
                rest.push(word);
            }
        }
        *words = rest;
        return Some((Quantity::Gyro(axis), None));
    }
    // Long words before short ones: in `imu_a acc x` the `a` is a name.
    let at = (0..words.len())
        .filter(|&i| i != axis_at && kind_of(&words[i]).is_some())
        .max_by_key(|&i| words[i].len())?;
    let kind = kind_of(&words[at])?;
    for i in [axis_at.max(at), axis_at.min(at)] {
        words.remove(i);
    }
    Some((as_quantity(kind, axis), None))
}

fn find_scalar_quantity(words: &mut Vec<String>) -> Option<(Quantity, Option<&'static str>)> {
    let scalar = |word: &str| -> Option<(Quantity, Option<&'static str>)> {
        Some(match word {
            "t" | "ts" | "time" | "timestamp" | "timestamps" | "epoch" | "clock" | "elapsed"
            | "utc" | "datetime" => (Quantity::Time, None),
            "seconds" => (Quantity::Time, Some("s")),
            "millis" | "milliseconds" => (Quantity::Time, Some("ms")),
            "micros" | "microseconds" => (Quantity::Time, Some("us")),
            "nanos" | "nanoseconds" => (Quantity::Time, Some("ns")),
            "sample" | "samples" | "index" | "idx" | "row" | "counter" | "seq" => {
                (Quantity::Index, None)
            }
            "temp" | "temperature" | "tmp" => (Quantity::Temperature, None),
            "part" | "label" | "section" | "placement" | "pose" | "face" => (Quantity::Label, None),
            _ => return None,
        })
    };
    let at = words.iter().position(|w| scalar(w).is_some())?;
    let found = scalar(&words[at])?;
    words.remove(at);
    Some(found)
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
            | "seconds"
            | "millis"
            | "micros"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn q(name: &str) -> (Quantity, Option<String>) {
        let c = understand(name).unwrap_or_else(|| panic!("{name} was not understood"));
        (c.quantity, c.unit)
    }

    #[test]
    fn spellings_of_the_wild() {
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
            ("n_samples", Index, None),
            ("samples", Index, None),
            ("part", Label, None),
        ] {
            assert_eq!(q(name), (quantity, unit.map(str::to_owned)), "{name}");
        }
    }

    #[test]
    fn what_only_looks_alike_is_left_alone() {
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
            "foot",
            "start",
        ] {
            assert_eq!(understand(name), None, "{name}");
        }
    }

    #[test]
    fn the_rest_of_the_name_is_the_sensor() {
        assert_eq!(
            understand("left_sensor.acc_x").unwrap().sensor,
            "left sensor"
        );
        assert!(understand("userAcceleration.x").unwrap().without_gravity);
    }
}

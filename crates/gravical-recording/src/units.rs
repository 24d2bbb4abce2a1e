//! Units as people write them.

/// Unit of an accelerometer.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum AccelUnit {
    /// m/s²
    Mps2,
    /// cm/s²
    Cmps2,
    /// Standard gravity
    G,
    /// Thousandths of standard gravity
    MilliG,
    /// Numbers of the converter
    Counts,
}

impl AccelUnit {
    /// Standard gravity in this unit; `None` for counts.
    #[must_use]
    pub fn gravity(self) -> Option<f64> {
        match self {
            AccelUnit::Mps2 => Some(9.80665),
            AccelUnit::Cmps2 => Some(980.665),
            AccelUnit::G => Some(1.0),
            AccelUnit::MilliG => Some(1000.0),
            AccelUnit::Counts => None,
        }
    }

    /// The unit that a text names.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        Some(match squeeze(text).as_str() {
            "m/s2" | "mps2" | "ms-2" | "ms2" | "m/s/s" | "m/s2r" => AccelUnit::Mps2,
            "cm/s2" => AccelUnit::Cmps2,
            "g" | "gs" => AccelUnit::G,
            "mg" => AccelUnit::MilliG,
            "counts" | "lsb" | "raw" => AccelUnit::Counts,
            _ => return None,
        })
    }

    /// `m/s^2`, `g`, `mg`, …
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            AccelUnit::Mps2 => "m/s^2",
            AccelUnit::Cmps2 => "cm/s^2",
            AccelUnit::G => "g",
            AccelUnit::MilliG => "mg",
            AccelUnit::Counts => "counts",
        }
    }
}

/// Unit of a gyroscope.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum GyroUnit {
    /// rad/s
    RadS,
    /// °/s
    DegS,
    /// Thousandths of °/s
    MilliDegS,
    /// Numbers of the converter
    Counts,
}

impl GyroUnit {
    /// The unit that a text names.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        Some(match squeeze(text).as_str() {
            "rad/s" | "rads" | "rad" | "rads-1" => GyroUnit::RadS,
            "deg/s" | "dps" | "degs" | "deg" | "°/s" | "º/s" | "degs-1" => GyroUnit::DegS,
            "mdps" | "mdeg/s" => GyroUnit::MilliDegS,
            "counts" | "lsb" | "raw" => GyroUnit::Counts,
            _ => return None,
        })
    }

    /// `rad/s`, `deg/s`, …
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            GyroUnit::RadS => "rad/s",
            GyroUnit::DegS => "deg/s",
            GyroUnit::MilliDegS => "mdeg/s",
            GyroUnit::Counts => "counts",
        }
    }
}

/// Seconds of one unit of time: `ms`, `[10ms]`.
pub(crate) fn time_scale_s(text: &str) -> Option<f64> {
    let text = squeeze(text);
    let word = text.trim_start_matches(|c: char| c.is_ascii_digit());
    let many: f64 = text[..text.len() - word.len()].parse().unwrap_or(1.0);
    let one_s = match word {
        "s" | "sec" | "seconds" => 1.0,
        "ms" | "millis" | "msec" => 1e-3,
        "us" | "µs" | "μs" | "micros" => 1e-6,
        "ns" | "nanosec" => 1e-9,
        _ => return None,
    };
    (many > 0.0).then_some(many * one_s)
}

pub(crate) fn is_celsius(text: &str) -> bool {
    matches!(
        text.to_lowercase().as_str(),
        "c" | "°c" | "℃" | "degc" | "deg c" | "'c" | "degrees celsius"
    )
}

/// Whether a text is the unit of anything that an IMU measures.
pub(crate) fn is_unit(text: &str) -> bool {
    AccelUnit::parse(text).is_some()
        || GyroUnit::parse(text).is_some()
        || time_scale_s(text).is_some()
        || is_celsius(text)
}

/// Lower case without blanks, brackets and signs of power.
fn squeeze(text: &str) -> String {
    let lower = text.to_lowercase();
    let kept = lower
        .chars()
        .filter(|c| !c.is_whitespace() && !"^*_[]()".contains(*c));
    kept.map(|c| if c == '²' { '2' } else { c }).collect()
}

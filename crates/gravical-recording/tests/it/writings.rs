//! The same samples in many dialects must come out the same.

use gravical_recording::{AccelUnit, Recording};

use crate::support::{Dice, RATE_HZ, Row, has_rate, is_near, six_faces, try_read};

const WRITINGS: u64 = 600;

/// How a file is written.
#[derive(Debug, Clone)]
struct Writing {
    separator: &'static str,
    decimal_comma: bool,
    header: Header,
    unit: Unit,
    gyro: Option<GyroPlace>,
    stamps: Stamps,
    encoding: Encoding,
    line_end: &'static str,
    quotes: bool,
    preamble: bool,
    comments: bool,
    is_torn: bool,
    blank_every: usize,
    has_temperature: bool,
    open_end: bool,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Header {
    None,
    Short,
    Units,
    Phyphox,
    Dotted,
    Repeated,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Unit {
    Mps2,
    G,
    MilliG,
    Counts,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum GyroPlace {
    Behind,
    Before,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Stamps {
    None,
    Seconds,
    Millis,
    Micros,
    UnixNanos,
    Dates,
    TimesOfDay,
    Steps,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Encoding {
    Utf8,
    Bom,
    Utf16,
    Utf16Bare,
    Latin1,
}

fn pick<T: Copy>(dice: &mut Dice, choices: &[T]) -> T {
    choices[dice.below(choices.len())]
}

impl Writing {
    fn random(seed: u64) -> Self {
        let d = &mut Dice::new(seed);
        let separator = pick(d, &[",", ", ", ";", "\t", " ", "  ", "|"]);
        let mut writing = Writing {
            separator,
            decimal_comma: !separator.starts_with([',', '|']) && d.below(3) == 0,
            header: pick(
                d,
                &[
                    Header::None,
                    Header::Short,
                    Header::Units,
                    Header::Phyphox,
                    Header::Dotted,
                    Header::Repeated,
                ],
            ),
            unit: pick(d, &[Unit::Mps2, Unit::G, Unit::MilliG, Unit::Counts]),
            gyro: pick(d, &[None, Some(GyroPlace::Behind), Some(GyroPlace::Before)]),
            stamps: pick(
                d,
                &[
                    Stamps::None,
                    Stamps::Seconds,
                    Stamps::Millis,
                    Stamps::Micros,
                    Stamps::UnixNanos,
                    Stamps::Dates,
                    Stamps::TimesOfDay,
                    Stamps::Steps,
                ],
            ),
            encoding: pick(
                d,
                &[
                    Encoding::Utf8,
                    Encoding::Utf8,
                    Encoding::Bom,
                    Encoding::Utf16,
                    Encoding::Utf16Bare,
                    Encoding::Latin1,
                ],
            ),
            line_end: pick(d, &["\n", "\n", "\r\n", "\r\r\n", "\r"]),
            quotes: d.below(4) == 0,
            preamble: d.below(3) == 0,
            comments: d.below(4) == 0,
            is_torn: d.below(4) == 0,
            blank_every: pick(d, &[0, 0, 1, 100]),
            has_temperature: d.below(3) == 0,
            open_end: d.below(6) == 0,
        };
        writing.make_possible();
        writing
    }

    /// Some choices exclude each other: nobody could read them.
    fn make_possible(&mut self) {
        let is_blank_separated = self.separator.starts_with(' ');
        if is_blank_separated {
            self.quotes = false;
            self.open_end = false;
            if matches!(self.header, Header::Units | Header::Phyphox) {
                self.header = Header::Short;
            }
            if self.stamps == Stamps::Dates {
                self.stamps = Stamps::TimesOfDay;
            }
        }
        if self.header == Header::None {
            // Numbers alone do not show steps; thermometers need their names.
            self.has_temperature = false;
            if self.stamps == Stamps::Steps {
                self.stamps = Stamps::Seconds;
            }
        }
        if self.line_end == "\r" {
            self.preamble = false;
        }
    }

    fn number(&self, value: f64, decimals: usize) -> String {
        let text = format!("{value:.decimals$}");
        if self.decimal_comma {
            text.replace('.', ",")
        } else {
            text
        }
    }

    fn accel(&self, row: &Row) -> [String; 3] {
        row.accel_g.map(|g| match self.unit {
            Unit::Mps2 => self.number(g * 9.80665, 4),
            Unit::G => self.number(g, 5),
            Unit::MilliG => self.number(g * 1000.0, 1),
            Unit::Counts => format!("{:.0}", g * 16_384.0),
        })
    }

    fn stamp(&self, row: usize) -> Option<String> {
        let t = row as f64 / RATE_HZ;
        Some(match self.stamps {
            Stamps::None => return None,
            Stamps::Seconds => self.number(t, 3),
            Stamps::Millis => format!("{:.0}", 5000.0 + t * 1e3),
            Stamps::Micros => format!("{:.0}", 5e6 + t * 1e6),
            Stamps::UnixNanos => format!("{}", 1_700_000_000_000_000_000 + row as u64 * 40_000_000),
            Stamps::Dates => format!("2024-03-01 10:00:{:06.3}", t),
            Stamps::TimesOfDay => format!("10:59:{:06.3}", t),
            Stamps::Steps => format!("{}", 39 + row % 3),
        })
    }

    fn names(&self) -> Vec<String> {
        let accel_unit = match self.unit {
            Unit::Mps2 => "m/s^2",
            Unit::G => "g",
            Unit::MilliG => "mg",
            Unit::Counts => "counts",
        };
        let (time, accel, gyro): (&str, [&str; 3], [&str; 3]) = match self.header {
            Header::Dotted => (
                "time",
                [
                    "linear_acceleration.x",
                    "linear_acceleration.y",
                    "linear_acceleration.z",
                ],
                [
                    "angular_velocity.x",
                    "angular_velocity.y",
                    "angular_velocity.z",
                ],
            ),
            Header::Phyphox => (
                "Time",
                ["Acceleration x", "Acceleration y", "Acceleration z"],
                ["Gyroscope x", "Gyroscope y", "Gyroscope z"],
            ),
            _ => ("t", ["ax", "ay", "az"], ["gx", "gy", "gz"]),
        };
        let with_units = matches!(self.header, Header::Units | Header::Phyphox);
        let unit = |name: &str, unit: &str| {
            if with_units {
                format!("{name} ({unit})")
            } else {
                name.to_owned()
            }
        };
        let mut names = Vec::new();
        if self.stamps != Stamps::None {
            let time_unit = match self.stamps {
                Stamps::Seconds => Some("s"),
                Stamps::Millis | Stamps::Steps => Some("ms"),
                Stamps::Micros => Some("us"),
                Stamps::UnixNanos => Some("ns"),
                _ => None,
            };
            let name = if self.stamps == Stamps::Steps {
                "dt"
            } else {
                time
            };
            names.push(time_unit.map_or(name.to_owned(), |u| unit(name, u)));
        }
        let accel = accel.map(|n| unit(n, accel_unit));
        let gyro = gyro.map(|n| unit(n, "°/s"));
        match self.gyro {
            None => names.extend(accel),
            Some(GyroPlace::Behind) => names.extend(accel.into_iter().chain(gyro)),
            Some(GyroPlace::Before) => names.extend(gyro.into_iter().chain(accel)),
        }
        if self.has_temperature {
            names.push(unit("temp", "°C"));
        }
        names
    }

    fn line(&self, cells: Vec<String>) -> String {
        let quote = |c: String| if self.quotes { format!("\"{c}\"") } else { c };
        let mut line = cells
            .into_iter()
            .map(quote)
            .collect::<Vec<_>>()
            .join(self.separator);
        if self.open_end {
            line.push_str(self.separator.trim_end_matches(' '));
        }
        line
    }

    fn text(&self, rows: &[Row]) -> String {
        let mut lines = Vec::new();
        if self.preamble {
            lines.extend([
                "MPU6050 found".to_owned(),
                "calibrating, keep it still...".to_owned(),
            ]);
        }
        if self.header != Header::None {
            lines.push(self.line(self.names()));
        }
        for (k, row) in rows.iter().enumerate() {
            if self.comments && k % 97 == 50 {
                lines.push("# rejected: 1 sample".to_owned());
            }
            if self.header == Header::Repeated && k == 150 {
                lines.push(self.line(self.names()));
            }
            let gyro = row.gyro_deg_s.map(|w| self.number(w, 3));
            let mut cells: Vec<String> = self.stamp(k).into_iter().collect();
            match self.gyro {
                None => cells.extend(self.accel(row)),
                Some(GyroPlace::Behind) => cells.extend(self.accel(row).into_iter().chain(gyro)),
                Some(GyroPlace::Before) => cells.extend(gyro.into_iter().chain(self.accel(row))),
            }
            if self.has_temperature {
                cells.push(self.number(row.temperature_c, 2));
            }
            lines.push(self.line(cells));
            if self.blank_every > 0 && k % self.blank_every == 0 {
                lines.push(String::new());
            }
        }
        let mut text = lines.join(self.line_end);
        if self.is_torn {
            let torn = lines.iter().rev().find(|l| !l.is_empty()).unwrap();
            text.push_str(self.line_end);
            text.push_str(torn.split(self.separator).next().unwrap());
        }
        text.push_str(self.line_end);
        text
    }

    fn bytes(&self, text: &str) -> Vec<u8> {
        let wide = |text: &str| text.encode_utf16().flat_map(u16::to_le_bytes).collect();
        match self.encoding {
            Encoding::Utf8 => text.as_bytes().to_vec(),
            Encoding::Bom => format!("\u{feff}{text}").into_bytes(),
            Encoding::Utf16 => wide(&format!("\u{feff}{text}")),
            Encoding::Utf16Bare => wide(text),
            Encoding::Latin1 => text.chars().map(|c| c as u8).collect(),
        }
    }

    /// What is wrong with a recording of these rows.
    fn fault(&self, rows: &[Row], recording: &Recording) -> Option<String> {
        if recording.rows() != rows.len() {
            return Some(format!("{} rows", recording.rows()));
        }
        let unit = match self.unit {
            Unit::Mps2 => AccelUnit::MetrePerSecondSquared,
            Unit::G => AccelUnit::StandardGravity,
            Unit::MilliG => AccelUnit::MilliGravity,
            Unit::Counts => AccelUnit::Counts,
        };
        if recording.accel_scale.unit != unit {
            return Some(format!("unit {:?}", recording.accel_scale));
        }
        let scale = recording.accel_scale.nominal().unwrap().recip() / 9.80665;
        for (k, row) in rows.iter().enumerate() {
            for axis in 0..3 {
                if !is_near(recording.accel[axis][k] * scale, row.accel_g[axis], 1e-4) {
                    return Some(format!("row {k}: {}", recording.accel[axis][k]));
                }
                if let Some(gyro) = &recording.gyro
                    && !is_near(gyro[axis][k], row.gyro_deg_s[axis], 1e-3)
                {
                    return Some(format!("row {k}: gyroscope {}", gyro[axis][k]));
                }
            }
        }
        if recording.gyro.is_some() != self.gyro.is_some() {
            return Some("gyroscope".to_owned());
        }
        if recording.temperature_c.is_some() != self.has_temperature {
            return Some("temperature".to_owned());
        }
        let rate_is_right = match self.stamps {
            Stamps::None => recording.rate_hz().is_none(),
            _ => has_rate(recording, RATE_HZ),
        };
        (!rate_is_right).then(|| format!("rate {:?}", recording.rate_hz()))
    }
}

#[test]
fn the_same_samples_come_out_of_every_writing() {
    let rows = six_faces(1);
    let mut failures = Vec::new();
    for seed in 0..WRITINGS {
        let writing = Writing::random(seed);
        let text = writing.text(&rows);
        let fault = match try_read(writing.bytes(&text), "data.csv") {
            Ok(recording) => writing.fault(&rows, &recording),
            Err(e) => Some(e.to_string()),
        };
        if let Some(fault) = fault {
            let head: String = text.chars().take(160).collect();
            failures.push(format!("{seed}: {fault}\n{writing:?}\n{head:?}\n"));
        }
    }
    assert!(
        failures.is_empty(),
        "{} writings:\n{}",
        failures.len(),
        failures.join("\n")
    );
}

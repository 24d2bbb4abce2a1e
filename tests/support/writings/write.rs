//! From columns to the bytes of files.

use std::io::Write as _;

use super::session::{Columns, Session};
use super::*;

const STANDARD_GRAVITY_MPS2: f64 = 9.80665;
/// 2024-05-19 11:41:59 UTC.
const START_S: u64 = 1_716_118_919;

/// A file as somebody has it.
#[derive(Debug, Clone)]
pub struct File {
    pub name: String,
    pub bytes: Vec<u8>,
}

/// A recording: its file, and that of the gyroscope where it is another one.
#[derive(Debug, Clone)]
pub struct Written {
    pub file: File,
    pub gyro: Option<File>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Channel {
    /// Or a part of it.
    Time(usize),
    Accel(usize),
    Gyro(usize),
    Magnetometer(usize),
    Linear(usize),
    Temperature,
    Counter,
    Text(usize),
}

use Channel as C;

/// The files of a session.
pub fn write(writing: &Writing, session: &Session) -> Vec<Written> {
    let written = |columns: &Columns| {
        let file = |stem: &str, channels: &[Channel]| File {
            name: format!("{stem}.csv"),
            bytes: bytes_of(writing, session.rate_hz, columns, channels),
        };
        let is_apart = writing.sensors == Sensors::GyroscopeInOtherFile;
        let gyro = is_apart.then(|| file("Gyroscope", &gyro_channels(writing)));
        let stem = match (writing.names, session.files.len()) {
            (Names::Bare, 1) => "TotalAcceleration",
            (Names::Bare, _) => &format!("{}_acc", columns.stem),
            _ => &columns.stem,
        };
        let file = file(stem, &channels(writing));
        Written { file, gyro }
    };
    session.files.iter().map(written).collect()
}

/// `--columns` as somebody gives it who knows the file.
pub fn columns_option(writing: &Writing) -> String {
    // Whether a column is the time of each row.
    let is_one_clock = writing.clock != Clock::Differences && clock_channels(writing).count() == 1;
    let name = |channel| match channel {
        C::Time(_) if is_one_clock => "t".to_owned(),
        C::Accel(i) => format!("a{}", AXES[i]),
        C::Gyro(i) => format!("g{}", AXES[i]),
        C::Temperature => "temp".to_owned(),
        _ => "_".to_owned(),
    };
    let names: Vec<String> = channels(writing).into_iter().map(name).collect();
    names.join(",")
}

fn clock_channels(writing: &Writing) -> impl Iterator<Item = Channel> + use<> {
    let count = match writing.clock {
        Clock::Absent => 0,
        Clock::DateAndTime => 2,
        Clock::Parts => 4,
        _ => 1,
    };
    (0..count).map(C::Time)
}

const AXES: [char; 3] = ['x', 'y', 'z'];

fn channels(writing: &Writing) -> Vec<Channel> {
    let axes = axes(writing);
    let accel = axes.map(C::Accel);
    let gyro = match writing.sensors {
        Sensors::Both => axes.map(C::Gyro).to_vec(),
        _ => Vec::new(),
    };
    let mut out = Vec::new();
    if writing.order == Order::CounterFirst {
        out.push(C::Counter);
    }
    out.extend(clock_channels(writing));
    if writing.order == Order::TextColumns {
        out.extend([C::Text(0), C::Text(1)]);
    }
    let [magnetometer, linear] =
        [C::Magnetometer, C::Linear].map(|of: fn(usize) -> C| axes.map(of).to_vec());
    let (first, second) = match writing.order {
        Order::GyroFirst => (gyro, accel.to_vec()),
        _ if writing.header == Header::Letters && writing.order == Order::MagnetometerFirst => {
            (accel.to_vec(), [gyro, magnetometer].concat())
        }
        Order::MagnetometerFirst => (magnetometer, [accel.to_vec(), linear, gyro].concat()),
        Order::LinearFirst => (linear, [accel.to_vec(), magnetometer, gyro].concat()),
        _ if writing.header == Header::Letters => (accel.to_vec(), gyro),
        Order::TemperatureBetween => ([&accel[..], &[C::Temperature]].concat(), gyro),
        _ if writing.names == Names::Bare => (accel.to_vec(), gyro),
        _ => (accel.to_vec(), [gyro, vec![C::Temperature]].concat()),
    };
    out.extend(first);
    out.extend(second);
    if writing.order == Order::TextColumns {
        out.push(C::Text(2));
    }
    out
}

fn gyro_channels(writing: &Writing) -> Vec<Channel> {
    let gyro = axes(writing).map(C::Gyro);
    clock_channels(writing).chain(gyro).collect()
}

fn axes(writing: &Writing) -> [usize; 3] {
    match writing.order {
        Order::ZyxAxes => [2, 1, 0],
        _ => [0, 1, 2],
    }
}

fn bytes_of(writing: &Writing, rate_hz: f64, columns: &Columns, channels: &[Channel]) -> Vec<u8> {
    let delimiter = [",", ", ", ";", "\t", "|", " ", ";", "\t"][writing.delimiter as usize];
    use Delimiter::{SemicolonDecimalComma, TabDecimalComma};
    let comma = [SemicolonDecimalComma, TabDecimalComma].contains(&writing.delimiter);
    let end = ["\n", "\r\n", "\r\n\r\n", "\r\r\n", "\r"][writing.line_end as usize];
    let line_of = |fields: &[String], is_row: bool| -> String {
        let letters = channels.iter().zip(fields).map(|(c, field)| match c {
            _ if writing.header != Header::Letters => field.clone(),
            C::Time(0) => format!("T: {field}"),
            C::Accel(0) => format!("A: {field}"),
            C::Gyro(0) => format!("G: {field}"),
            C::Magnetometer(0) => format!("M: {field}"),
            _ => field.clone(),
        });
        let fields: Vec<String> = letters.collect();
        let is_padded = writing.header != Header::Letters && writing.delimiter == Delimiter::Padded;
        let width = if is_padded { 14 } else { 0 };
        let fields: Vec<String> = fields.iter().map(|f| format!("{f:>width$}")).collect();
        let mut line = fields.join(delimiter);
        let is_trailing = match writing.trailing {
            Trailing::Nothing => false,
            Trailing::Delimiter => true,
            Trailing::RowsOnly => is_row,
        };
        if is_trailing {
            line.push_str(delimiter.trim_end_matches(' '));
        }
        line.push_str(end);
        line
    };
    let head_line = |fields: &[String]| line_of(fields, false);
    let header = header(writing, rate_hz, channels, &head_line, delimiter, end);
    let mut text = header.before.clone();
    let field = |row: usize, channel: Channel| -> String {
        let field = cell(writing, columns, row, channel);
        match channel {
            C::Text(_) if writing.header == Header::Quoted => format!("\"{field}\""),
            C::Text(_) => field,
            _ if comma => field.replace('.', ","),
            _ => field,
        }
    };
    for row in 0..columns.rows() {
        if columns.pauses.contains(&row) {
            (0..3).for_each(|_| text.push_str(end));
        } else if let Some(every) = writing.blank.every()
            && row > 0
            && row.is_multiple_of(every)
        {
            text.push_str(end);
        }
        if writing.header == Header::Repeated && row > 0 && row.is_multiple_of(50) {
            text.push_str(&header.names);
        }
        let fields: Vec<String> = channels.iter().map(|c| field(row, *c)).collect();
        text.push_str(&line_of(&fields, true));
    }
    encode(writing.encoding, &text)
}

struct Head {
    /// All that stands before the first row.
    before: String,
    /// The line with the names alone.
    names: String,
}

fn header(
    writing: &Writing,
    rate_hz: f64,
    channels: &[Channel],
    line_of: &dyn Fn(&[String]) -> String,
    delimiter: &str,
    end: &str,
) -> Head {
    let with_units = !matches!(
        writing.header,
        Header::UnitsRow | Header::CalAndUnitsRow | Header::TwoRows
    );
    let quote = writing.header == Header::Quoted;
    let name = |c: &Channel| match name_of(writing, *c, with_units) {
        name if quote => format!("\"{name}\""),
        name => name,
    };
    let line =
        |of: &dyn Fn(&Channel) -> String| line_of(&channels.iter().map(of).collect::<Vec<_>>());
    let names = line(&name);
    let units = || line(&|c| unit_of(writing, *c));
    let before = match writing.header {
        Header::Absent | Header::Letters => String::new(),
        Header::Plain | Header::Quoted | Header::Repeated => names.clone(),
        Header::Commented => format!("# {names}"),
        Header::UnitsRow => format!("{names}{}", units()),
        Header::CalAndUnitsRow => format!("{names}{}{}", line(&|_| "CAL".to_owned()), units()),
        Header::TwoRows => {
            let row = |k: usize| line(&|c| in_two_rows(writing, *c)[k].clone());
            row(0) + &row(1)
        }
        Header::Metadata => format!(
            "Device: IMU 42{end}Serial Number: 0017{end}Sample Rate: {rate_hz} Hz{end}Start: 2024-05-19{end}{names}"
        ),
        Header::SepLine => format!("sep={}{end}{names}", delimiter.trim_end_matches(' ')),
    };
    Head { before, names }
}

/// Sensor above, axis or unit below.
fn in_two_rows(writing: &Writing, channel: Channel) -> [String; 2] {
    let (upper, lower) = match channel {
        C::Accel(i) => ("Accelerometer", AXES[i].to_string()),
        C::Gyro(i) => ("Gyroscope", AXES[i].to_string()),
        C::Magnetometer(i) => ("Magnetometer", AXES[i].to_string()),
        C::Linear(i) => ("Linear Acceleration", AXES[i].to_string()),
        C::Temperature => ("Temperature", "C".to_owned()),
        other => ("Time", unit_of(writing, other)),
    };
    [upper.to_owned(), lower]
}

fn unit_of(writing: &Writing, channel: Channel) -> String {
    use Values as V;
    match channel {
        C::Time(part) => match writing.clock {
            Clock::Parts => ["h", "min", "s", "ms"][part],
            Clock::Minutes => "min",
            Clock::Days => "d",
            Clock::Milliseconds | Clock::EpochMilliseconds => "ms",
            Clock::Seconds | Clock::EpochSeconds | Clock::Differences => "s",
            Clock::Microseconds => "us",
            Clock::EpochNanoseconds => "ns",
            Clock::DateTime | Clock::DateAndTime | Clock::TimeOfDay | Clock::Absent => "time",
        },
        C::Accel(_) | C::Linear(_) => match (writing.values, writing.names) {
            (V::GRad | V::GDeg | V::Mislabelled, _) => "g",
            (V::MilliGDeg, _) => "mg",
            (V::Counts, _) => "counts",
            (_, Names::Euroc) => "m s^-2",
            (_, Names::Shimmer) => "m/(s^2)",
            _ => "m/s^2",
        },
        C::Gyro(_) => match (writing.values, writing.names) {
            (V::Mps2Rad | V::GRad, Names::Euroc) => "rad s^-1",
            (V::Mps2Rad | V::GRad, _) => "rad/s",
            (V::Counts, _) => "counts",
            (_, Names::Sketch) => "°/s",
            (_, Names::Snake) => "dps",
            _ => "deg/s",
        },
        C::Magnetometer(_) => "uT",
        C::Temperature => "C",
        C::Counter | C::Text(_) => "no units",
    }
    .to_owned()
}

fn name_of(writing: &Writing, channel: Channel, with_units: bool) -> String {
    use Names as N;
    let within = |name: String, [open, close]: [char; 2]| match with_units {
        true => format!("{name} {open}{}{close}", unit_of(writing, channel)),
        false => name,
    };
    let unit = |name: String| within(name, ['(', ')']);
    let bracketed = |name: String| within(name, ['[', ']']);
    let lower = match channel {
        C::Accel(i) | C::Gyro(i) | C::Magnetometer(i) | C::Linear(i) => AXES[i],
        _ => ' ',
    };
    let upper = lower.to_ascii_uppercase();
    match channel {
        C::Time(part) if writing.clock == Clock::Parts => {
            let names = match writing.clock_name {
                ClockName::Logger => ["h", "m", "s", "ms"],
                _ => ["hour", "minute", "second", "millisecond"],
            };
            return names[part].to_owned();
        }
        C::Time(0) if writing.clock == Clock::DateAndTime => return "date".to_owned(),
        C::Time(_) => return clock_name(writing, with_units),
        C::Linear(_) => {
            return match writing.names {
                N::Phyphox | N::Xio => unit(format!("Linear Acceleration {lower}")),
                // Theirs is the accelerometer itself.
                N::Ros => format!("user_acceleration.{lower}"),
                N::Sketch | N::Snake => unit(format!("linear_acceleration_{lower}")),
                _ => format!("linear_acceleration_{lower}"),
            };
        }
        C::Counter => return "counter".to_owned(),
        C::Text(i) => return ["DeviceOrientation", "Activity", "Remark"][i].to_owned(),
        C::Temperature => {
            return match writing.names {
                N::Shimmer => "Shimmer_A1B2_Temperature_BMP280_CAL".to_owned(),
                N::Sketch | N::Snake | N::Phyphox | N::Xio => unit("Temp".to_owned()),
                _ => "temp".to_owned(),
            };
        }
        _ => {}
    }
    let (short, camel, word, long) = match channel {
        C::Accel(_) => ('a', "Acc", "acc", "Accelerometer"),
        C::Gyro(_) => ('g', "Gyr", "gyro", "Gyroscope"),
        _ => ('m', "Mag", "mag", "Magnetometer"),
    };
    match (writing.names, channel) {
        (N::Sketch, _) => unit(format!("{short}{upper}")),
        (N::Short, _) => format!("{short}{lower}"),
        (N::Camel | N::ArduPilot, _) => format!("{camel}{upper}"),
        (N::Snake, _) => bracketed(format!("{word}_{lower}")),
        (N::Phyphox, C::Accel(_)) => unit(format!("Acceleration {lower}")),
        (N::Phyphox, _) => unit(format!("{long} {lower}")),
        (N::Xio, _) => unit(format!("{long} {upper}")),
        (N::Euroc, C::Accel(_)) => bracketed(format!("a_RS_S_{lower}")),
        (N::Euroc, C::Gyro(_)) => bracketed(format!("w_RS_S_{lower}")),
        (N::Ros, C::Accel(_)) => format!("field.linear_acceleration.{lower}"),
        (N::Ros, C::Gyro(_)) => format!("field.angular_velocity.{lower}"),
        (N::Px4, C::Accel(i)) => format!("accelerometer_m_s2[{i}]"),
        (N::Px4, C::Gyro(i)) => format!("gyro_rad[{i}]"),
        (N::Shimmer, C::Accel(_)) => format!("Shimmer_A1B2_Accel_LN_{upper}_CAL"),
        (N::Shimmer, _) => format!("Shimmer_A1B2_{word}_{upper}_CAL"),
        (N::Phone, C::Accel(_)) => format!("gF{lower}"),
        (N::Phone, C::Gyro(_)) => format!("w{lower}"),
        (N::Bare, C::Accel(_) | C::Gyro(_)) => lower.to_string(),
        _ => format!("{word}_{lower}"),
    }
}

fn clock_name(writing: &Writing, with_units: bool) -> String {
    let own = match (writing.names, writing.clock) {
        (Names::Euroc, Clock::EpochNanoseconds) => Some("timestamp [ns]"),
        (Names::Ros, Clock::EpochNanoseconds) => Some("%time"),
        (Names::Px4, Clock::Microseconds) => Some("timestamp"),
        (Names::ArduPilot, Clock::Microseconds) => Some("TimeUS"),
        (Names::Shimmer, Clock::EpochMilliseconds) => Some("Shimmer_A1B2_Timestamp_Unix_CAL"),
        (Names::Phyphox | Names::Xio, Clock::Seconds) => Some("Time (s)"),
        (Names::Bare, Clock::EpochNanoseconds) => Some("time"),
        (Names::Bare, Clock::Seconds) => Some("seconds_elapsed"),
        _ => None,
    };
    if let (Some(name), true) = (own, with_units) {
        return name.to_owned();
    }
    let spaced = writing.delimiter == Delimiter::Padded;
    match (writing.clock_name, writing.clock) {
        (_, Clock::Differences) if writing.clock_name == ClockName::WithUnit => "dt_s",
        (_, Clock::Differences) => "dt",
        (ClockName::Plain, _) => "time",
        (ClockName::WithUnit, Clock::Milliseconds) => "time_ms",
        (ClockName::WithUnit, Clock::Seconds) => "t_s",
        (ClockName::WithUnit, Clock::Minutes) if spaced => "time_min",
        (ClockName::WithUnit, Clock::Minutes) => "t (min)",
        (ClockName::WithUnit, Clock::Microseconds) if spaced => "time_us",
        (ClockName::WithUnit, Clock::Microseconds) => "Time (us)",
        (ClockName::WithUnit, Clock::EpochSeconds) => "timestamp_s",
        (ClockName::WithUnit, Clock::EpochMilliseconds) if spaced => "epoch_ms",
        (ClockName::WithUnit, Clock::EpochMilliseconds) => "epoc (ms)",
        (ClockName::WithUnit, Clock::EpochNanoseconds) => "time_ns",
        (ClockName::WithUnit, Clock::DateTime) => "datetime",
        (ClockName::WithUnit, _) => "clock",
        (ClockName::Logger, Clock::Milliseconds) => "millis",
        (ClockName::Logger, Clock::Seconds) => "seconds_elapsed",
        (ClockName::Logger, Clock::Minutes) => "minutes",
        (ClockName::Logger, Clock::Microseconds) => "ustime",
        (ClockName::Logger, Clock::EpochSeconds) => "GPST",
        (ClockName::Logger, Clock::EpochMilliseconds) => "unixtime",
        (ClockName::Logger, Clock::EpochNanoseconds) => "nanos",
        (ClockName::Logger, _) => "UTC",
        (ClockName::Unheard, _) => "chrono",
    }
    .to_owned()
}

fn cell(writing: &Writing, columns: &Columns, row: usize, channel: Channel) -> String {
    let digits = writing.decimals.digits();
    match channel {
        C::Time(part) => time_cell(writing, columns, row, part),
        C::Accel(i) | C::Linear(i) => {
            let mut mps2 = columns.accel_mps2[i][row];
            if channel == C::Linear(i) {
                // Without what was there a little while ago, gravity above all.
                mps2 -= columns.accel_mps2[i][row.saturating_sub(5)];
            }
            let g = mps2 / STANDARD_GRAVITY_MPS2;
            match writing.values {
                Values::Counts => count(g * writing.range.lsb_per_g()).to_string(),
                Values::GRad | Values::GDeg => format!("{g:.digits$}"),
                Values::MilliGDeg => format!("{:.digits$}", 1000.0 * g),
                _ => format!("{mps2:.digits$}"),
            }
        }
        C::Gyro(i) => {
            let rad_s = columns.gyro_rad_s[i][row];
            let deg_s = rad_s.to_degrees();
            match writing.values {
                Values::Counts => count(deg_s * writing.range.lsb_per_deg_s()).to_string(),
                Values::Mps2Rad | Values::GRad | Values::Mislabelled => format!("{rad_s:.digits$}"),
                _ => format!("{deg_s:.digits$}"),
            }
        }
        C::Magnetometer(i) => {
            let along = columns.accel_mps2[(i + 1) % 3][row];
            format!("{:.digits$}", 12.0 + 3.0 * along + 7.0 * i as f64)
        }
        C::Temperature => format!("{:.2}", columns.temperature_c[row]),
        C::Counter => row.to_string(),
        C::Text(i) => ["portrait", "none", "as found"][i].to_owned(),
    }
}

fn count(value: f64) -> i64 {
    (value.round() as i64).clamp(-32768, 32767)
}

fn time_cell(writing: &Writing, columns: &Columns, row: usize, part: usize) -> String {
    let t_s = columns.t_s[row];
    let ns = (t_s * 1e9).round() as u64;
    let us = ns / 1000;
    let of_day_s = START_S % 86_400 + ns / 1_000_000_000;
    let [hours, minutes, seconds] = [of_day_s / 3600, of_day_s / 60 % 60, of_day_s % 60];
    match writing.clock {
        // Between 2 s and 71 min after the board was started.
        Clock::Milliseconds => format!("{}", 2345 + ns.div_ceil(1_000_000)),
        Clock::Microseconds => format!("{}", 2_345_678 + us),
        Clock::Seconds => format!("{t_s:.6}"),
        Clock::EpochSeconds => format!("{}.{:06}", START_S + us / 1_000_000, us % 1_000_000),
        Clock::EpochMilliseconds => format!("{}.{:03}", START_S * 1000 + us / 1000, us % 1000),
        Clock::EpochNanoseconds => format!("{}", START_S * 1_000_000_000 + ns),
        Clock::Minutes => format!("{:.8}", t_s / 60.0),
        // Days since 1899-12-30.
        Clock::Days => format!("{:.10}", 25_569.0 + (START_S as f64 + t_s) / 86_400.0),
        Clock::DateAndTime if part == 0 => "2024-05-19".to_owned(),
        Clock::Parts => [hours, minutes, seconds, us / 1000 % 1000][part].to_string(),
        Clock::DateTime | Clock::DateAndTime | Clock::TimeOfDay => {
            let (before, point) = match writing.clock {
                Clock::DateTime => ("2024-05-19 ", '.'),
                _ => ("", ':'),
            };
            let fraction = us % 1_000_000 / 100;
            format!("{before}{hours:02}:{minutes:02}:{seconds:02}{point}{fraction:04}")
        }
        Clock::Differences => format!("{:.6}", t_s - columns.t_s[row.saturating_sub(1)]),
        Clock::Absent => String::new(),
    }
}

fn encode(encoding: Encoding, text: &str) -> Vec<u8> {
    let marked = || std::iter::once(0xfeff).chain(text.encode_utf16());
    match encoding {
        Encoding::Utf8 => text.as_bytes().to_vec(),
        Encoding::Utf8Mark => [b"\xef\xbb\xbf", text.as_bytes()].concat(),
        Encoding::Utf16Le => marked().flat_map(u16::to_le_bytes).collect(),
        Encoding::Utf16Be => marked().flat_map(u16::to_be_bytes).collect(),
        Encoding::Utf16LeBare => text.encode_utf16().flat_map(u16::to_le_bytes).collect(),
        Encoding::Latin1 => text.chars().map(|c| u8::try_from(c).unwrap()).collect(),
        Encoding::Gzip => {
            let mut gz = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
            gz.write_all(text.as_bytes()).unwrap();
            gz.finish().unwrap()
        }
    }
}

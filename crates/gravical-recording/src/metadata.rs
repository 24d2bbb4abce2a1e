//! Metadata above the header: sampling rate, range, serial number, start.

use gravical_judge::units::{POSSIBLE, is_listed};

use crate::date::parse_date;

/// Words and numbers of a line.
fn words(line: &str) -> Vec<&str> {
    line.split(|c: char| !(c.is_alphanumeric() || c == '.'))
        .filter(|w| !w.is_empty())
        .collect()
}

/// Words before the sampling rate; those of [`WITH_UNIT`] only if a unit stands beside it.
const NAMES: &str = "fs rate odr sampling frequency at";
const WITH_UNIT: &str = "sampling frequency at";
/// Words before `rate` that make it another one.
const OTHER_RATES: &str = "baud bit heart";
/// Words before a number that make it a property of a filter.
const OF_FILTER: &str = "cutoff cut off corner bandwidth filter pass lowpass";

/// The sampling rate in the metadata, Hz: `Fs,100`, `# rate: 62.5 Hz`, `Sample Rate:,128,Hz`, `//
/// Update Rate: 40.0Hz`, `# output data rate: 104 Hz`, `… at 100 Hz Filter Normal`. A frequency and
/// the words `sampling` and `at` need the unit; those of a filter and of other rates are ignored.
pub fn rate_hz(metadata: &[String]) -> Option<f64> {
    metadata.iter().find_map(|line| {
        let line = line.to_lowercase();
        let words = words(&line);
        let mut names = (0..words.len()).filter(|at| is_listed(NAMES, words[*at]));
        names.find_map(|name| rate_behind(&words, name))
    })
}

fn rate_behind(words: &[&str], name: usize) -> Option<f64> {
    let number = |word: &str| -> Option<f64> {
        let rate: f64 = word.strip_suffix("hz").unwrap_or(word).parse().ok()?;
        POSSIBLE.contains(&rate).then_some(rate)
    };
    // The number follows, possibly after its unit or another word.
    let at = (name + 1..words.len().min(name + 4)).find(|at| number(words[*at]).is_some())?;
    let (before, between) = (&words[name.saturating_sub(2)..name], &words[name + 1..at]);
    let is_rate_of = |list: &str| {
        words[name] == "rate" && before.last().is_some_and(|last| is_listed(list, last))
    };
    let mut around = before.iter().chain(between);
    let is_of_filter = around.any(|w| is_listed(OF_FILTER, w));
    let has_unit =
        words[at].ends_with("hz") || between.contains(&"hz") || words.get(at + 1) == Some(&"hz");
    // A data rate without a unit is in bits.
    let is_data_rate = is_rate_of("data") && before != ["output", "data"];
    let is_clear = has_unit || !is_listed(WITH_UNIT, words[name]) && !is_data_rate;
    number(words[at]).filter(|_| is_clear && !is_of_filter && !is_rate_of(OTHER_RATES))
}

/// Plausible ranges of accelerometers, g.
const RANGES_G: std::ops::RangeInclusive<f64> = 0.5..=400.0;

/// The range of the accelerometer, g: `Range: 4 g`, `Dynamic range,±8g`, `Accelerometer Full
/// Scale: +/-16 g`. The unit is required, and other sensors are ignored.
pub fn range_g(metadata: &[String]) -> Option<f64> {
    metadata.iter().find_map(|line| {
        let line = line.to_lowercase();
        let words = words(&line);
        let foreign = |w: &&str| w.starts_with("gyro") || w.starts_with("mag");
        let at = words.iter().position(|w| is_listed("range scale", w))?;
        let (number, rest) = words[at + 1..].split_first()?;
        let has_unit = number.ends_with('g') || rest.first() == Some(&"g");
        let range: f64 = number.strip_suffix('g').unwrap_or(number).parse().ok()?;
        let is_ours = has_unit && !words.iter().any(foreign);
        (is_ours && RANGES_G.contains(&range)).then_some(range)
    })
}

/// Names of a serial number, in lower case.
const SERIAL: &str =
    "serial number,serial no,serialnumber,device serial,device id,deviceid,serial code";
/// Largest number of characters of a serial number.
const MAX_SERIAL_CHARS: usize = 64;

/// The sensor's serial number: `Serial Number: MOS2D12345678`, `// DeviceId: 00B41234`,
/// `Serial no.,1234`.
pub fn serial(metadata: &[String]) -> Option<String> {
    metadata.iter().find_map(|line| {
        // ASCII lower case leaves byte positions unchanged.
        let small = line.to_ascii_lowercase();
        let mut names = SERIAL.split(',');
        let behind = names.find_map(|name| small.find(name).map(|at| at + name.len()))?;
        let value = line
            .get(behind..)?
            .trim_start_matches(|c: char| !c.is_alphanumeric())
            .split(|c: char| c.is_whitespace() || ",;\"'".contains(c))
            .next()?;
        let usual = |c: char| c.is_ascii_alphanumeric() || "-_:./".contains(c);
        let digits = value.chars().any(|c| c.is_ascii_digit());
        (digits && value.len() <= MAX_SERIAL_CHARS && value.chars().all(usual))
            .then(|| value.to_owned())
    })
}

/// Whether dates have the day before the month: `date format d/M/yyyy`.
pub fn is_day_first(metadata: &[impl AsRef<str>]) -> Option<bool> {
    metadata.iter().find_map(|line| {
        let line = line.as_ref().to_ascii_lowercase();
        let (_, order) = line.split_once("date format")?;
        Some(order.trim_start().starts_with('d'))
    })
}

/// When the recording starts, s since 1970: `Start Time 12:00:00` and `Start Date 5/19/2017`, or
/// both in one line.
pub fn start_s(metadata: &[String]) -> Option<f64> {
    let after = |name: &str| {
        metadata.iter().find_map(|line| {
            let (start, value) = line.split_at_checked(name.len())?;
            let value = value.trim_matches([' ', ':', ',', ';', '\t']);
            start.eq_ignore_ascii_case(name).then_some(value)
        })
    };
    let time = after("start time")?;
    let both = match after("start date") {
        Some(date) => format!("{date} {time}"),
        None => time.to_owned(),
    };
    // A time of day alone is no start.
    parse_date(&both, is_day_first(metadata) == Some(true)).filter(|s| *s >= 86_400.0)
}

//! One file per axis: three files of one channel each, put side by side.
//!
//! `accel_[xyz].txt` names `accel_x.txt`, `accel_y.txt` and `accel_z.txt` as one recording.

use std::collections::{HashMap, HashSet};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use super::names::{Column, FileSensor, sensor_of_file};
use super::number::parse_cell;
use crate::bytes;
use crate::error::{Error, Kind};
use crate::role::Role;

/// Letters of the axes in the name of a file, and what stands for them.
const LETTERS: [([char; 3], &str); 2] = [(['x', 'y', 'z'], "[xyz]"), (['X', 'Y', 'Z'], "[XYZ]")];
/// Bytes by which a file of one channel is told.
const HEAD_BYTES: u64 = 16_384;

/// Puts one name, `accel_[xyz].txt`, in the place of three files of one channel each.
#[must_use]
pub fn group(paths: &[PathBuf]) -> Vec<PathBuf> {
    let given: HashSet<&PathBuf> = paths.iter().collect();
    let mut seen = HashSet::new();
    let group = |path: &PathBuf| {
        let files =
            |group: &PathBuf| files(group).is_some_and(|f| f.iter().all(|f| given.contains(f)));
        match group_of(path).filter(files) {
            Some(group) => seen.insert(group.clone()).then_some(group),
            None => Some(path.clone()),
        }
    };
    paths.iter().filter_map(group).collect()
}

/// The name of the three files of one channel each to which this one belongs.
#[must_use]
pub fn group_of(path: &Path) -> Option<PathBuf> {
    let name = path.file_name()?.to_str()?;
    if sensor_of_file(name) == Some(FileSensor::Other) {
        return None;
    }
    let is_part = |c: Option<char>| c.is_some_and(char::is_alphanumeric);
    name.char_indices().find_map(|(at, letter)| {
        let (before, after) = (&name[..at], &name[at + letter.len_utf8()..]);
        let (_, pattern) = LETTERS.iter().find(|(l, _)| l.contains(&letter))?;
        let is_word = !is_part(before.chars().next_back());
        let is_end = after.is_empty() || after.starts_with('.');
        if is_part(after.chars().next()) || !(is_word || is_end) {
            return None;
        }
        let group = path.with_file_name(format!("{before}{pattern}{after}"));
        let holds_channel = |file: &PathBuf| {
            let read = || io::read_to_string(bytes::open(file)?.take(HEAD_BYTES));
            // Opening a pipe would take its first bytes.
            file.is_file() && read().is_ok_and(|head| Channel::parse(&head).is_some())
        };
        files(&group)?.iter().all(holds_channel).then_some(group)
    })
}

/// The files x, y and z that one name stands for.
fn files(group: &Path) -> Option<[PathBuf; 3]> {
    let name = group.file_name()?.to_str()?;
    let (letters, pattern) = LETTERS.iter().find(|(_, pattern)| name.contains(pattern))?;
    Some(letters.map(|l| group.with_file_name(name.replacen(pattern, &l.to_string(), 1))))
}

/// The text of three files of one channel each, side by side, in the lines of the first; `None`
/// for any other path.
///
/// # Errors
///
/// A file cannot be read; their rows do not belong together.
pub fn open(path: &Path) -> Option<Result<String, Error>> {
    let files = files(path).filter(|_| !path.exists())?;
    files.iter().all(|f| f.is_file()).then(|| read(&files))
}

fn read(files: &[PathBuf; 3]) -> Result<String, Error> {
    let text = |path: &PathBuf| io::read_to_string(bytes::open(path)?);
    let texts = [text(&files[0])?, text(&files[1])?, text(&files[2])?];
    let names = files
        .each_ref()
        .map(|f| f.file_name().unwrap_or_default().to_string_lossy());
    let channel = |axis: usize| {
        let none = || Kind::AxesDiffer(format!("{} does not hold one channel", names[axis]));
        Channel::parse(&texts[axis]).ok_or_else(none)
    };
    let [x, y, z] = [channel(0)?, channel(1)?, channel(2)?];
    let of_row = |row: usize| {
        (
            y.rows.get(row).map(|r| r.value),
            z.rows.get(row).map(|r| r.value),
        )
    };
    let mut values: Vec<(Option<&str>, Option<&str>)> = (0..x.rows.len()).map(of_row).collect();
    if !(x.is_parallel(&y) && x.is_parallel(&z)) {
        let (by_y, by_z) = (y.by_stamp(), z.by_stamp());
        let at = |stamp: &str| (by_y.get(stamp).copied(), by_z.get(stamp).copied());
        values = x.rows.iter().map(|r| at(r.stamp)).collect();
        let complete = values.iter().filter(|v| v.0.and(v.1).is_some()).count();
        if complete * 2 < x.rows.len().max(y.rows.len()).max(z.rows.len()) {
            let channels = [&x, &y, &z];
            let lengths = channels
                .iter()
                .zip(&names)
                .map(|(c, n)| format!("{n} has {} rows", c.rows.len()));
            let lengths = lengths.collect::<Vec<_>>().join(", ");
            return Err(
                Kind::AxesDiffer(format!("{lengths}, without time stamps in common")).into(),
            );
        }
    }
    let mut values = x.rows.iter().zip(values).peekable();
    let mut out = String::new();
    for (number, line) in texts[0].lines().enumerate() {
        if let Some((row, (y, z))) = values.next_if(|(row, _)| row.line == number) {
            if x.delimiter.is_some() {
                out += row.stamp;
                out.push(';');
            }
            out += &[row.value, y.unwrap_or_default(), z.unwrap_or_default()].join(";");
        } else if x.header == Some(number) {
            out += &header(&x, [&x, &y, &z], &texts, &names[0]);
        } else {
            out += line;
        }
        out.push('\n');
    }
    Ok(out)
}

/// Names of the columns: as written where they name the axes, else by sensor and unit.
fn header(
    first: &Channel<'_>,
    channels: [&Channel<'_>; 3],
    texts: &[String; 3],
    file: &str,
) -> String {
    let sensor = match sensor_of_file(file) {
        Some(FileSensor::Gyro) => "g",
        Some(FileSensor::Accel { is_linear: true }) => "linear acceleration ",
        _ => "a",
    };
    let mut names: Vec<String> = Vec::new();
    for (axis, channel) in channels.into_iter().enumerate() {
        let line = channel.header.and_then(|at| texts[axis].lines().nth(at));
        let (stamp, name) = channel.split(line.unwrap_or_default().trim_start_matches(['#', ' ']));
        if axis == 0 && first.delimiter.is_some() {
            names.push(stamp.to_owned());
        }
        let role = Column::from_name(name).role;
        let names_axis = role == Role::Accel(axis) || role == Role::Gyro(axis);
        let unit = name.find(['(', '[']).map_or("", |at| &name[at..]);
        names.push(if names_axis {
            name.to_owned()
        } else {
            format!("{sensor}{} {unit}", ["x", "y", "z"][axis])
        });
    }
    names.join(";")
}

/// A file of one channel.
struct Channel<'a> {
    /// Between a stamp and its value.
    delimiter: Option<char>,
    /// Line of the names, from 0.
    header: Option<usize>,
    rows: Vec<Row<'a>>,
}

struct Row<'a> {
    /// From 0.
    line: usize,
    stamp: &'a str,
    value: &'a str,
}

impl<'a> Channel<'a> {
    /// Reads lines of one number, or of a time stamp and a number; `None` if most are not.
    fn parse(text: &'a str) -> Option<Self> {
        let lines = || {
            text.lines()
                .enumerate()
                .filter(|(_, l)| !l.trim().is_empty())
        };
        let count = lines().count();
        [Some(','), None, Some(';'), Some('\t'), Some(' ')]
            .into_iter()
            .find_map(|delimiter| {
                let mut channel = Channel {
                    delimiter,
                    header: None,
                    rows: Vec::new(),
                };
                for (line, text) in lines() {
                    let (stamp, value) = channel.split(text);
                    let number = |field: &str| parse_cell(field, delimiter != Some(','));
                    let is_stamp = delimiter.is_none() || number(stamp).is_some_and(f64::is_finite);
                    if is_stamp && number(value).is_some() {
                        channel.rows.push(Row { line, stamp, value });
                    } else if channel.rows.is_empty() {
                        channel.header = Some(line);
                    }
                }
                // `0,12` is a number, or a stamp and a number if the first rises.
                let rises = || channel.times().windows(2).filter(|t| t[0] < t[1]).count();
                let is_clock = delimiter != Some(',') || rises() * 2 >= channel.rows.len();
                (is_clock && channel.rows.len() * 2 > count).then_some(channel)
            })
    }

    /// Stamp and value of a line.
    fn split(&self, line: &'a str) -> (&'a str, &'a str) {
        let line = line.trim().trim_end_matches([',', ';']);
        let parts = self.delimiter.and_then(|d| line.rsplit_once(d));
        let (stamp, value) = parts.unwrap_or(("", line));
        (stamp.trim(), value.trim())
    }

    fn times(&self) -> Vec<f64> {
        let is_comma = self.delimiter == Some(',');
        self.rows
            .iter()
            .map(|r| parse_cell(r.stamp, !is_comma).unwrap_or(f64::NAN))
            .collect()
    }

    /// Whether each row of the two is of one sample: by their stamps, if both have them.
    fn is_parallel(&self, other: &Channel<'_>) -> bool {
        let rows = self.rows.len();
        if rows != other.rows.len() {
            return false;
        }
        if self.delimiter.is_none() || other.delimiter.is_none() {
            return true;
        }
        let (own, other) = (self.times(), other.times());
        let period = (own[rows - 1] - own[0]).abs() / rows as f64;
        own.iter()
            .zip(&other)
            .all(|(a, b)| a == b || (a - b).abs() < period / 2.0)
    }

    fn by_stamp(&self) -> HashMap<&str, &str> {
        let stamped = self.rows.iter().filter(|_| self.delimiter.is_some());
        stamped.map(|r| (r.stamp, r.value)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ReadOptions, Recording};

    /// The recording of three files with these texts.
    fn recording(name: &str, texts: [&str; 3]) -> Result<Recording, Error> {
        let folder = std::env::temp_dir().join(format!("axes-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let paths = ["X", "Y", "Z"].map(|axis| folder.join(format!("accel_{axis}.txt")));
        for (path, text) in paths.iter().zip(texts) {
            std::fs::write(path, text).unwrap();
        }
        let groups = group(&paths);
        assert_eq!(groups, [folder.join("accel_[XYZ].txt")]);
        let recording = Recording::open(&groups[0], &ReadOptions::default());
        std::fs::remove_dir_all(&folder).unwrap();
        recording
    }

    #[test]
    fn numbers_with_decimal_commas_stand_side_by_side() {
        let r = recording(
            "commas",
            ["0,11\n0,13\n0,12\n", "0,1\n0,2\n0,1\n", "9,81\n9,8\n9,79\n"],
        );
        let r = r.unwrap();
        assert_eq!(r.accel[0], [0.11, 0.13, 0.12]);
        assert_eq!(r.accel[2], [9.81, 9.8, 9.79]);
        assert_eq!(r.time_s, None);
    }

    #[test]
    fn whole_numbers_may_have_stamps() {
        let r = recording(
            "counts",
            [
                "0,5\n10,7\n20,6\n",
                "1,3\n11,2\n21,3\n",
                "2,250\n12,251\n22,249\n",
            ],
        );
        let r = r.unwrap();
        assert_eq!(r.accel[2], [250.0, 251.0, 249.0]);
        assert_eq!(r.time_s.unwrap(), [0.0, 0.01, 0.02]);
    }

    #[test]
    fn rows_are_joined_by_their_stamps() {
        let r = recording(
            "stamps",
            [
                "ms,value (g)\n0,0.01\n10,0.02\n20,0.01\n30,0.02\n",
                "ms,value (g)\n0,0.03\n20,0.04\n30,0.03\n",
                "ms,value (g)\n0,0.99\n10,1.01\n20,0.98\n30,0.97\n40,0.99\n",
            ],
        );
        let r = r.unwrap();
        assert_eq!(r.time_s.unwrap(), [0.0, 0.01, 0.02, 0.03]);
        assert!(r.accel[1][1].is_nan());
        assert_eq!(r.accel[1][2], 0.04);
        assert_eq!(r.accel[2], [0.99, 1.01, 0.98, 0.97]);
        assert_eq!(r.header_unit, Some(crate::AccelUnit::StandardGravity));
    }

    #[test]
    fn files_of_unlike_length_are_refused_by_name() {
        let refused = recording("lengths", ["1\n2\n3\n", "1\n2\n", "9\n9\n8\n"]).unwrap_err();
        assert_eq!(refused.code(), "axes-differ");
        let message = refused.to_string();
        assert!(
            message.contains("accel_X.txt has 3 rows, accel_Y.txt has 2"),
            "{message}"
        );
    }
}

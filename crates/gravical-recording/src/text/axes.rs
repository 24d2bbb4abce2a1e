//! One file per axis: three files of one channel each, put side by side.
//!
//! `accel_[xyz].txt` names `accel_x.txt`, `accel_y.txt` and `accel_z.txt` as one recording.

use std::collections::HashSet;
use std::fs::File;
use std::io::{self, BufRead, Read};
use std::path::{Path, PathBuf};

use super::names::{Column, sensor_of_file};
use super::number::parse_cell;
use crate::bytes::{self, Input};
use crate::error::Error;
use crate::role::Role;

/// Letters of the axes in the name of a file, and what stands for them.
const LETTERS: [([char; 3], &str); 2] = [(['x', 'y', 'z'], "[xyz]"), (['X', 'Y', 'Z'], "[XYZ]")];
/// Bytes by which a file of one channel is told.
const CHANNEL_BYTES: usize = 16_384;

/// Puts one name, `accel_[xyz].txt`, in the place of three files of one channel each.
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
pub fn group_of(path: &Path) -> Option<PathBuf> {
    let name = path.file_name()?.to_str()?;
    if sensor_of_file(name) == Some(Role::Other) {
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
            let read = || bytes::read_head(&mut open_file(file)?.1, CHANNEL_BYTES);
            let holds = |head: Vec<u8>| Channel::parse(&String::from_utf8_lossy(&head)).is_some();
            // Opening a pipe would take its first bytes.
            file.is_file() && read().is_ok_and(holds)
        };
        files(&group)?.iter().all(holds_channel).then_some(group)
    })
}

/// The files x, y and z that one name stands for.
pub fn files(group: &Path) -> Option<[PathBuf; 3]> {
    let name = group.file_name()?.to_str()?;
    let (letters, pattern) = LETTERS.iter().find(|(_, pattern)| name.contains(pattern))?;
    Some(letters.map(|l| group.with_file_name(name.replacen(pattern, &l.to_string(), 1))))
}

/// The text of three files of one channel each, side by side, in the lines of the first; `None`
/// for any other path.
///
/// # Errors
///
/// A file cannot be read, or is packed and cut off; their rows or stamps differ.
pub fn open(path: &Path) -> Option<Result<String, Error>> {
    let files = files(path).filter(|_| !path.exists())?;
    files.iter().all(|f| f.is_file()).then(|| read(&files))
}

fn axes_differ(why: &str) -> Error {
    let text = format!("the files of the axes do not belong together: {why}");
    Error::input("axes-differ", text)
        .with_hint("cut the files to the same samples, or record all axes in one file: t,ax,ay,az")
}

fn read(files: &[PathBuf; 3]) -> Result<String, Error> {
    let names = files.each_ref().map(|file| file.file_name());
    let names = names.map(|name| name.unwrap_or_default().to_string_lossy());
    let text = |axis: usize| {
        let named = |e: io::Error| io::Error::new(e.kind(), format!("{}: {e}", names[axis]));
        read_file(&files[axis]).map_err(named)
    };
    let texts = [text(0)?, text(1)?, text(2)?];
    let channel = |axis: usize| {
        let none = || axes_differ(&format!("{} does not hold one channel", names[axis]));
        Channel::parse(&texts[axis]).ok_or_else(none)
    };
    let channels = [channel(0)?, channel(1)?, channel(2)?];
    let [x, y, z] = &channels;
    if !(y.is_parallel(x) && z.is_parallel(x)) {
        let rows = channels.iter().zip(&names);
        let rows = rows.map(|(c, name)| format!("{name} has {} rows", c.rows.len()));
        let rows: Vec<String> = rows.collect();
        let why = format!("{}, or their time stamps differ", rows.join(", "));
        return Err(axes_differ(&why));
    }
    let mut out = String::new();
    let mut rows = x.rows.iter().zip(&y.rows).zip(&z.rows).peekable();
    for (number, line) in texts[0].lines().enumerate() {
        if let Some(((x, y), z)) = rows.next_if(|((x, _), _)| x.line == number) {
            if channels[0].delimiter.is_some() {
                out += x.stamp;
                out.push(';');
            }
            out += &[x.value, y.value, z.value].join(";");
        } else if x.header.is_some_and(|(line, _)| line == number) {
            out += &header(&channels);
        } else {
            out += line;
        }
        out.push('\n');
    }
    Ok(out)
}

/// The text of a file, whatever bytes are in it.
fn read_file(path: &Path) -> io::Result<String> {
    let (input, mut text) = open_file(path)?;
    let mut bytes = Vec::new();
    text.read_to_end(&mut bytes)?;
    if input.is_cut_off() {
        let what = "the packed file is damaged or ends in the middle";
        return Err(io::Error::new(io::ErrorKind::UnexpectedEof, what));
    }
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

fn open_file(path: &Path) -> io::Result<(Input, Box<dyn BufRead>)> {
    let mut input = bytes::from_reader(Box::new(File::open(path)?), false)?;
    let text = bytes::utf8(input.take_reader())?;
    Ok((input, text))
}

/// Names of the columns: as written where they name the axes, else axis and unit; the name of the
/// file tells the sensor.
fn header(channels: &[Channel<'_>; 3]) -> String {
    let mut names = Vec::new();
    for (axis, channel) in channels.iter().enumerate() {
        let line = channel.header.map_or("", |(_, line)| line);
        let (stamp, name) = split(line.trim_start_matches(['#', ' ']), channel.delimiter);
        if axis == 0 && channel.delimiter.is_some() {
            names.push(stamp.to_owned());
        }
        let role = Column::from_name(name).role;
        names.push(if role == Role::Accel(axis) || role == Role::Gyro(axis) {
            name.to_owned()
        } else {
            let unit = name.find(['(', '[']).map_or("", |at| &name[at..]);
            format!("{} {unit}", ["x", "y", "z"][axis])
        });
    }
    names.join(";")
}

/// A file of one channel.
struct Channel<'a> {
    /// Between a stamp and its value.
    delimiter: Option<char>,
    /// Number, from 0, and text of the line of the names.
    header: Option<(usize, &'a str)>,
    rows: Vec<Row<'a>>,
}

struct Row<'a> {
    /// From 0.
    line: usize,
    stamp: &'a str,
    /// The stamp as a number; NaN without one.
    time: f64,
    value: &'a str,
}

impl<'a> Channel<'a> {
    /// Reads lines of one number, or of a time stamp and a number; `None` if most are not.
    fn parse(text: &'a str) -> Option<Self> {
        let mut delimiters = [Some(','), None, Some(';'), Some('\t'), Some(' ')].into_iter();
        delimiters.find_map(|delimiter| Channel::parted_by(delimiter, text))
    }

    fn parted_by(delimiter: Option<char>, text: &'a str) -> Option<Self> {
        let (mut header, mut rows, mut filled) = (None, Vec::new(), 0);
        let number = |field: &str| parse_cell(field, delimiter != Some(','));
        for (line, text) in text.lines().enumerate() {
            if text.trim().is_empty() {
                continue;
            }
            filled += 1;
            let (stamp, value) = split(text, delimiter);
            let time = number(stamp).filter(|time| delimiter.is_none() || time.is_finite());
            if let Some(time) = time.filter(|_| number(value).is_some()) {
                rows.push(Row {
                    line,
                    stamp,
                    time,
                    value,
                });
            } else if rows.is_empty() {
                header = Some((line, text));
            }
        }
        // `0,12` is a number, or a stamp and a number if the first rises.
        let rises = rows.windows(2).filter(|w| w[0].time < w[1].time).count();
        let is_clock = delimiter != Some(',') || rises * 2 >= rows.len();
        (is_clock && rows.len() * 2 > filled).then_some(Channel {
            delimiter,
            header,
            rows,
        })
    }

    /// Whether each row of the two is of one sample: by their stamps, if both have them.
    fn is_parallel(&self, other: &Channel<'_>) -> bool {
        let count = self.rows.len();
        let are_stamped = self.delimiter.is_some() && other.delimiter.is_some();
        let period = (self.rows[count - 1].time - self.rows[0].time).abs() / count as f64;
        let mut pairs = self.rows.iter().zip(&other.rows);
        let is_same = |a: f64, b: f64| a == b || (a - b).abs() < period / 2.0;
        count == other.rows.len() && (!are_stamped || pairs.all(|(a, b)| is_same(a.time, b.time)))
    }
}

/// Stamp and value of a line.
fn split(line: &str, delimiter: Option<char>) -> (&str, &str) {
    let line = line.trim().trim_end_matches([',', ';']);
    let parts = delimiter.and_then(|d| line.rsplit_once(d));
    let (stamp, value) = parts.unwrap_or(("", line));
    (stamp.trim(), value.trim())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ReadOptions, Recording};

    /// The recording of three files with these texts.
    fn read_bytes(name: &str, texts: [&[u8]; 3]) -> Result<Recording, Error> {
        let folder = std::env::temp_dir().join(format!("axes-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let paths = ["X", "Y", "Z"].map(|axis| folder.join(format!("accel_{axis}.txt")));
        for (path, text) in paths.iter().zip(texts) {
            std::fs::write(path, text).unwrap();
        }
        let groups = group(&paths);
        assert_eq!(groups, [folder.join("accel_[XYZ].txt")]);
        let recording = crate::read(&groups[0], &ReadOptions::default());
        std::fs::remove_dir_all(&folder).unwrap();
        recording
    }

    #[test]
    fn columns_of_numbers_are_decimal_commas_or_stamps_and_counts() {
        let commas = ["0,11\n0,13\n0,12\n", "0,1\n0,2\n0,1\n", "9,81\n9,8\n9,79\n"];
        let counts = [
            "0,5\n10,7\n20,6\n",
            "1,3\n11,2\n21,3\n",
            "2,250\n12,251\n22,249\n",
        ];
        for (name, texts, z, time_s) in [
            ("commas", commas, [9.81, 9.8, 9.79], None),
            (
                "counts",
                counts,
                [250.0, 251.0, 249.0],
                Some(vec![0.0, 0.01, 0.02]),
            ),
        ] {
            let r = read_bytes(name, texts.map(str::as_bytes)).unwrap();
            assert_eq!((&r.accel[2][..], r.time_s), (&z[..], time_s));
        }
    }

    #[test]
    fn bad_bytes_are_as_in_any_recording() {
        let rows = |level: &str| {
            format!("# \u{e4}\u{e4}\nms,value (g)\n0,{level}1\n10,{level}2\n20,{level}1\n")
        };
        let (x, z) = (rows("0.0"), rows("0.9"));
        let y = [b"# \xff\n", &x.as_bytes()[7..]].concat();
        let r = read_bytes("bytes", [x.as_bytes(), &y, z.as_bytes()]).unwrap();
        assert_eq!(r.accel[1], [0.01, 0.02, 0.01]);
        // The head ends within the letter.
        let long = |row: &str| format!("{}\u{e4}\n{row}", row.repeat((CHANNEL_BYTES - 1) / 4));
        let texts = ["1.2\n", "0.1\n", "9.8\n"].map(long);
        let r = read_bytes("head", texts.each_ref().map(|t| t.as_bytes())).unwrap();
        assert_eq!(r.accel[2][..2], [9.8, 9.8]);
    }
}

//! The first rows of a recording, from which its facts are determined.

use crate::Result;

use super::monitor::{Facts, RecordingClaims};
use super::row::{ACCEL, GYRO, SLOTS, TEMPERATURE, Values};
use super::rows::{Item, Rows, Source};

/// Largest number of passes over the head.
const MOST_PASSES: u32 = 3;

/// Usual number of lines of a head.
const USUAL_LINES: usize = 1 << 13;

/// The first lines of a recording.
#[derive(Debug, Clone)]
pub(crate) struct Head {
    claims: RecordingClaims,
    lines: Vec<(u64, Item, Values)>,
}

/// Channels of the first rows in the unit of the file, with cells filled.
#[derive(Debug, Clone, Default)]
pub(crate) struct HeadChannels {
    pub accel: [Vec<f64>; 3],
    /// `None` without all three axes.
    pub gyro: Option<[Vec<f64>; 3]>,
    /// °C according to the recording; empty cells are NaN.
    pub temperature: Vec<f64>,
}

impl HeadChannels {
    pub fn rows(&self) -> usize {
        self.accel[0].len()
    }

    /// The accelerometer converted by `calibrate` from its values and the temperature.
    pub fn calibrated(&self, calibrate: impl Fn([f64; 3], f64) -> [f64; 3]) -> [Vec<f64>; 3] {
        let [x, y, z] = &self.accel;
        let mut out: [Vec<f64>; 3] = Default::default();
        for (((x, y), z), t_c) in x.iter().zip(y).zip(z).zip(&self.temperature) {
            let a = calibrate([*x, *y, *z], *t_c);
            for (channel, value) in out.iter_mut().zip(a) {
                channel.push(value);
            }
        }
        out
    }
}

impl Head {
    /// Reads all lines of `source`, up to an error.
    pub fn read(mut source: impl Source, claims: &RecordingClaims) -> Self {
        let mut lines = Vec::with_capacity(USUAL_LINES);
        let mut values = [f64::NAN; SLOTS];
        while let Ok(Some(item)) = source.next(&mut values) {
            lines.push((source.number(), item, values));
        }
        Head {
            claims: claims.clone(),
            lines,
        }
    }

    /// Facts of the recording.
    pub fn facts(&self) -> Facts {
        determine_facts(|facts| self.rows(facts))
    }

    /// About how many rows a file of `size` bytes has, whose first `bytes` bytes these are; 0 if
    /// its size is unknown.
    pub fn expected(&self, bytes: usize, size: Option<u64>) -> usize {
        let each = bytes as f64 / self.lines.len() as f64;
        size.map_or(0, |size| (1.01 * size as f64 / each) as usize)
    }

    /// Channels of its rows.
    pub fn channels(&self, facts: &Facts) -> HeadChannels {
        let channels = self.claims.channels(facts);
        let mut out = HeadChannels {
            gyro: channels.gyro.then(Default::default),
            ..HeadChannels::default()
        };
        let mut rows = self.rows(*facts);
        while let Ok(Some(row)) = rows.next_row() {
            for (i, channel) in out.accel.iter_mut().enumerate() {
                channel.push(row.values[ACCEL + i]);
            }
            for (i, channel) in out.gyro.iter_mut().flatten().enumerate() {
                channel.push(row.values[GYRO + i]);
            }
            out.temperature.push(row.values[TEMPERATURE]);
        }
        out
    }

    fn rows(&self, facts: Facts) -> Rows<HeadRows<'_>> {
        let source = HeadRows {
            lines: &self.lines,
            next: 0,
        };
        Rows::new(source, "", self.claims.clone(), facts)
    }
}

/// Facts of `rows`, determined repeatedly until they agree with those assumed. Errors of reading
/// end the rows.
pub(super) fn determine_facts<S: Source>(rows: impl Fn(Facts) -> Rows<S>) -> Facts {
    let mut facts = Facts::none();
    let mut passes = 0;
    // How to read stamps depends on the steps, and even spacing on how they are read.
    loop {
        let mut rows = rows(facts);
        while let Ok(Some(_)) = rows.next_row() {}
        let found = rows.monitor().finish().facts;
        passes += 1;
        if found.agrees(&facts) || passes == MOST_PASSES {
            return Facts {
                resolution: rows.monitor().resolution(),
                ..found
            };
        }
        facts = found;
    }
}

/// Source that repeats the stored lines.
struct HeadRows<'a> {
    lines: &'a [(u64, Item, Values)],
    next: usize,
}

impl Source for HeadRows<'_> {
    fn next(&mut self, values: &mut Values) -> Result<Option<Item>> {
        let Some((_, item, kept)) = self.lines.get(self.next) else {
            return Ok(None);
        };
        self.next += 1;
        *values = *kept;
        Ok(Some(*item))
    }

    fn number(&self) -> u64 {
        let last = self.next.checked_sub(1);
        last.and_then(|at| self.lines.get(at)).map_or(0, |l| l.0)
    }
}

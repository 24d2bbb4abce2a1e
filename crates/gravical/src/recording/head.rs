//! The first rows of a recording, by which it is judged before the others are read.

use crate::Result;

use super::monitor::{Facts, RecordingClaims};
use super::row::{ACCEL, GYRO, SLOTS, TEMPERATURE, Values};
use super::rows::{Item, Rows, Source};
use super::timing::Treatment;

/// How often a head is judged at most.
const MOST_PASSES: u32 = 3;

/// Lines that a head has as a rule.
const USUAL_LINES: usize = 1 << 13;

/// Lines at the start of a recording, kept.
#[derive(Debug, Clone)]
pub(crate) struct Head {
    claims: RecordingClaims,
    keeps_zeros: bool,
    lines: Vec<(u64, Item, Values)>,
}

/// The rows of a head as channels in the unit of the file, cells filled.
#[derive(Debug, Clone, Default)]
pub(crate) struct HeadChannels {
    pub accel: [Vec<f64>; 3],
    /// None without all three axes.
    pub gyro: Option<[Vec<f64>; 3]>,
    /// °C, by what the recording says; empty cells are NaN.
    pub temperature: Vec<f64>,
}

impl HeadChannels {
    pub fn rows(&self) -> usize {
        self.accel[0].len()
    }

    /// The accelerometer as `calibrate` makes it of its values and the temperature.
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
    /// All lines that `source` has; what reading reports ends it.
    pub fn read(mut source: impl Source, claims: &RecordingClaims, keeps_zeros: bool) -> Self {
        let mut lines = Vec::with_capacity(USUAL_LINES);
        let mut values = [f64::NAN; SLOTS];
        while let Ok(Some(item)) = source.next(&mut values) {
            lines.push((source.number(), item, values));
        }
        Head {
            claims: claims.clone(),
            keeps_zeros,
            lines,
        }
    }

    /// What is to be known of a recording that begins so.
    pub fn facts(&self) -> Facts {
        judge(|facts| self.rows(facts))
    }

    /// Its rows as channels.
    pub fn channels(&self, facts: &Facts) -> HeadChannels {
        let channels = self.claims.channels();
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
        let rows = Rows::new(source, "", self.claims.clone(), facts);
        match self.keeps_zeros {
            true => rows.keeping_zeros(),
            false => rows,
        }
    }
}

/// What is to be known of `rows`: judged until what is found is what was assumed. What
/// reading reports ends them.
pub(super) fn judge<S: Source>(rows: impl Fn(Facts) -> Rows<S>) -> Facts {
    let mut facts = Facts::none();
    let mut passes = 0;
    // The steps tell how stamps are read, which tells whether they are even.
    loop {
        let mut rows = rows(facts);
        while let Ok(Some(_)) = rows.next_row() {}
        let found = rows.monitor().finish(Treatment::Repaired).facts;
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

/// Lines that were kept, once more.
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

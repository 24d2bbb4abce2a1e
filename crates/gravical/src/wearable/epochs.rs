//! Rows in, rows of the table out.

use std::collections::VecDeque;
use std::io::{self, Read, Seek, Write};
use std::path::Path;

use gravical_core::calibration::Calibration;
use gravical_core::matrix3;
use tempfile::SpooledTempFile;

use super::measures::{Epoch, EpochSamples};
use super::nonwear::{NonWear, PART_S};
use super::table::{TimeColumn, write_row};
use super::totals::Totals;
use super::{SummariseOptions, Zone};
use crate::apply::drift::Drift;
use crate::apply::sensor::Sensor;
use crate::calibration_file::CalibrationFile;
use crate::recording::collect::Sink;
use crate::recording::file::HeadChannels;
use crate::recording::format::Format;
use crate::recording::metadata;
use crate::recording::monitor::{Facts, QuietBlocks};
use crate::recording::row::{TEMPERATURE, TIME};
use crate::recording::rows::{Rows, Source};
use crate::recording::timing::BreakKind;
use crate::recording::{Finding, LineSpans};
use crate::utc::UtcTime;
use crate::{Error, Result};
use gravical_core::unit::STANDARD_GRAVITY_MPS2;

/// Longest gap that is filled with empty rows, s: a week. Beyond it a stamp is more likely wrong.
pub(super) const MOST_FILLED_S: i64 = 7 * 86_400;
/// Empty epochs for each one with samples, beside those of one such gap.
const FILLED_EACH: i64 = 10;

/// Size of a table that is kept in memory until it is complete; a larger one goes to a file without
/// a name.
const IN_MEMORY: usize = 1 << 20;

/// Times are rounded by this, s: a stamp of 1970 in seconds is known to a quarter of it.
const TIME_TOLERANCE_S: f64 = 1e-6;

/// No recording is that long, s: such a stamp is none.
const FARTHEST_S: f64 = 1e12;

/// A longer step, in usual ones, has missing samples in it.
const MISSED: f64 = 1.5;

/// Times of the rows.
#[derive(Debug, Clone, Copy)]
enum Clock {
    /// Of each row, from its stamp; the usual step, s.
    Stamps {
        usual_s: f64,
        stamp_s: f64,
    },
    /// At this rate, Hz.
    Rate(f64),
    Unknown,
}

/// The fold over the rows.
pub(super) struct Epochs {
    epoch_s: i64,
    sensor: Option<Sensor>,
    drift_findings: Vec<Finding>,
    /// m/s² in one g.
    g_mps2: f64,
    clock: Clock,
    zone: Option<Zone>,
    /// When it starts by the lines above the header, s since 1970.
    stated_start_s: Option<f64>,
    celsius: bool,
    /// The time in the first column; known from the first row with a time.
    pub time: Option<TimeColumn>,
    rows: u64,
    /// Latest time of a row, s since 1970 or since the first sample.
    last_s: f64,
    /// The epoch that is being filled.
    now: Option<i64>,
    /// Epochs that were begun, and empty ones between them.
    begun: i64,
    empty: i64,
    samples: EpochSamples,
    missing: u64,
    /// End of the part of the non-wear rule that is being filled, s.
    part_end_s: f64,
    nonwear: Option<NonWear>,
    judged: VecDeque<Option<bool>>,
    /// Epochs that wait for the verdict on their block, the next verdict is for this one.
    waiting: VecDeque<Epoch>,
    block: i64,
    pub totals: Totals,
    /// Magnitude where the sensor is quiet, m/s².
    pub quiet: QuietBlocks,
    /// Rows before the first time stamp.
    pub untimed: LineSpans,
    /// Rows at which the table begins anew: the clock went back, or a gap is too long to fill.
    pub jumps: LineSpans,
    line: Vec<u8>,
    table: SpooledTempFile,
}

impl Epochs {
    /// For rows of this format and with these facts.
    pub fn new(
        options: &SummariseOptions,
        calibration: Option<&CalibrationFile>,
        format: &Format,
        facts: &Facts,
    ) -> Self {
        let mut drift_findings = Vec::new();
        let sensor = match calibration {
            Some(file) => {
                let drift = Drift::new(
                    file,
                    &HeadChannels::default(),
                    &format.layout,
                    facts.celsius,
                    false,
                    &mut drift_findings,
                );
                Some(Sensor::new(file, false, options.axes).with_drift(drift))
            }
            None => facts.accel.nominal().map(|nominal| {
                let by_scale = Calibration {
                    matrix: matrix3::diagonal([1.0 / nominal; 3]),
                    bias: [facts.zero_offset; 3],
                };
                Sensor::of(by_scale, None, options.axes)
            }),
        };
        Epochs {
            epoch_s: i64::from(options.epoch_s),
            sensor,
            drift_findings,
            g_mps2: calibration.map_or(STANDARD_GRAVITY_MPS2, |file| file.gravity_mps2),
            clock: match facts.stamp_reading {
                Some(reading) => Clock::Stamps {
                    // Evenly spaced by definition: nothing is missing.
                    usual_s: match reading.even_hz {
                        Some(_) => f64::INFINITY,
                        None => reading.usual * reading.unit.seconds(),
                    },
                    stamp_s: reading.unit.seconds(),
                },
                None => Clock::Unknown,
            },
            zone: options.time_zone.clone(),
            stated_start_s: metadata::start_s(&format.dialect.metadata),
            celsius: facts.celsius,
            time: None,
            rows: 0,
            last_s: f64::NAN,
            now: None,
            begun: 0,
            empty: 0,
            samples: EpochSamples::default(),
            missing: 0,
            part_end_s: f64::NEG_INFINITY,
            nonwear: None,
            judged: VecDeque::new(),
            waiting: VecDeque::new(),
            block: 0,
            totals: Totals::default(),
            quiet: QuietBlocks::default(),
            untimed: LineSpans::default(),
            jumps: LineSpans::default(),
            line: Vec::with_capacity(256),
            table: SpooledTempFile::new(IN_MEMORY),
        }
    }

    /// What one g is, m/s².
    pub fn g_mps2(&self) -> f64 {
        self.g_mps2
    }

    /// The findings of the calibration's drift.
    pub fn drift_findings(&mut self) -> Vec<Finding> {
        let mut findings = std::mem::take(&mut self.drift_findings);
        if let Some(drift) = self.sensor.as_ref().and_then(|s| s.drift.as_ref()) {
            drift.finish(&mut findings);
        }
        findings
    }

    /// Why there is no table, if there is none.
    ///
    /// # Errors
    ///
    /// `unit-unknown`, `rate-unknown` (input); `time-zone-unused` (usage).
    pub fn check(&self, name: &str) -> Result<()> {
        let here = Path::new(name);
        if self.sensor.is_none() {
            return Err(Error::input(
                "unit-unknown",
                "the unit of the accelerometer is unknown, so nothing can be said in g",
            )
            .at(here, None)
            .with_hint("say it with --accel-unit, and --accel-range for counts; or give a calibration with --calibration"));
        }
        let Some(time) = &self.time else {
            return Err(Error::input(
                "rate-unknown",
                "there are no usable time stamps and no sampling rate, so there are no epochs",
            )
            .at(here, None)
            .with_hint("give --rate"));
        };
        if matches!(time, TimeColumn::Relative) && self.zone.is_some() {
            return Err(Error::usage(
                "time-zone-unused",
                "--time-zone: the time stamps of the recording are no dates",
            )
            .at(here, None)
            .with_hint("leave --time-zone out: the epochs then count from the first sample"));
        }
        Ok(())
    }

    /// Copies the table to `out`.
    ///
    /// # Errors
    ///
    /// Errors of the temporary file and of writing.
    pub fn copy_table(&mut self, out: &mut dyn Write) -> Result<()> {
        let spool = |e| Error::io(Path::new("temporary file"), e);
        self.table.rewind().map_err(spool)?;
        let mut block = vec![0; 1 << 16];
        loop {
            let n = match self.table.read(&mut block) {
                Ok(0) => break,
                Ok(n) => n,
                Err(e) if e.kind() == io::ErrorKind::Interrupted => continue,
                Err(e) => return Err(spool(e)),
            };
            let written = block.get(..n).map_or(Ok(()), |bytes| out.write_all(bytes));
            written.map_err(|e| Error::io(Path::new("output"), e))?;
        }
        out.flush().map_err(|e| Error::io(Path::new("output"), e))
    }

    /// Time of a row in seconds since 1970, or since the first sample; `None` before the first stamp.
    #[inline]
    fn time_s(&mut self, row_s: f64, stamp: f64) -> Option<f64> {
        let t_s = match self.clock {
            Clock::Rate(rate_hz) => (self.rows - 1) as f64 / rate_hz,
            Clock::Stamps { .. } | Clock::Unknown => row_s,
        };
        let origin_s = match &self.time {
            Some(time) => time.origin_s(),
            None if t_s.abs() < FARTHEST_S => self.start(t_s, stamp),
            None => return None,
        };
        // A row without a stamp was measured after the one before.
        Some(match t_s.abs() < FARTHEST_S {
            true => origin_s + t_s + TIME_TOLERANCE_S,
            false => self.last_s,
        })
    }

    /// The first row with a time: whether stamps are dates, or those that follow a stated start.
    #[cold]
    fn start(&mut self, t_s: f64, stamp: f64) -> f64 {
        let date = match self.clock {
            Clock::Stamps { stamp_s, .. } => stamp * stamp_s,
            Clock::Rate(_) | Clock::Unknown => f64::NAN,
        };
        let stamped_s = UtcTime::of_stamp(date).map(|_| date);
        let time = match stamped_s.or(self.stated_start_s) {
            Some(start_s) => TimeColumn::Dates {
                origin_s: start_s - t_s,
                zone: self.zone.clone().unwrap_or_default(),
            },
            None => TimeColumn::Relative,
        };
        time.header(&mut self.line);
        self.time.insert(time).origin_s()
    }

    /// The clock of the recording begins anew: dates are those of its stamps from here on.
    #[cold]
    fn restart(&mut self, t_s: f64, stamp: f64) {
        if let (Some(TimeColumn::Dates { origin_s, .. }), Clock::Stamps { stamp_s, .. }) =
            (&mut self.time, self.clock)
            && t_s.is_finite()
            && UtcTime::of_stamp(stamp * stamp_s).is_some()
        {
            *origin_s = stamp * stamp_s - t_s;
        }
    }

    /// Moves on to the time of a row.
    #[inline]
    fn advance(&mut self, t_s: f64, paused: bool, line: u64) -> Result<()> {
        let number = (t_s / self.epoch_s as f64).floor() as i64;
        if self.now == Some(number) && t_s < self.part_end_s && !self.is_step(t_s) {
            return Ok(());
        }
        self.advance_far(t_s, number, paused, line)
    }

    /// Whether samples are missing between the last row and this one.
    #[inline]
    fn is_step(&self, t_s: f64) -> bool {
        match self.clock {
            Clock::Stamps { usual_s, .. } => t_s - self.last_s > MISSED * usual_s,
            Clock::Rate(_) | Clock::Unknown => false,
        }
    }

    fn advance_far(&mut self, t_s: f64, number: i64, paused: bool, line: u64) -> Result<()> {
        let part = (t_s / PART_S as f64).floor() as i64;
        // So that a few rows far apart do not make a table without end.
        let filled = MOST_FILLED_S / self.epoch_s;
        let in_all = filled + FILLED_EACH * self.begun - self.empty;
        self.begun += 1;
        match self.now {
            // Stamps that step back by less than an epoch are noise of the clock.
            Some(now) if number + 1 == now => return Ok(()),
            Some(now) if number < now || number - now > filled.min(in_all) => {
                self.jumps.push(line);
                self.last_s = t_s;
                self.end_stretch()?;
                self.begin(number, part);
            }
            Some(now) => {
                self.empty += (number - now - 1).max(0);
                let mut lost = match paused || !self.is_step(t_s) {
                    true => Lost::none(),
                    false => Lost::between(self.last_s, t_s, self.usual_s()),
                };
                self.missing += lost.before((now + 1) as f64 * self.epoch_s as f64);
                for ended in now..number {
                    self.end_epoch(ended)?;
                    self.missing = lost.before((ended + 2) as f64 * self.epoch_s as f64);
                }
                // Judged last: an epoch waits for its block in any case.
                while let Some(nonwear) = &mut self.nonwear
                    && nonwear.now() < part
                {
                    nonwear.end_part(&mut self.judged);
                }
                self.now = Some(number);
                self.write_judged()?;
            }
            None => self.begin(number, part),
        }
        self.part_end_s = (part + 1) as f64 * PART_S as f64;
        Ok(())
    }

    fn usual_s(&self) -> f64 {
        match self.clock {
            Clock::Stamps { usual_s, .. } => usual_s,
            Clock::Rate(_) | Clock::Unknown => f64::INFINITY,
        }
    }

    fn begin(&mut self, number: i64, part: i64) {
        self.now = Some(number);
        self.nonwear = Some(NonWear::new(part));
        self.block = NonWear::block_of(part);
        self.last_s = f64::NEG_INFINITY;
    }

    fn end_epoch(&mut self, number: i64) -> Result<()> {
        self.waiting.push_back(Epoch {
            number,
            measures: self.samples.take(),
            missing: std::mem::take(&mut self.missing),
        });
        self.write_judged()
    }

    /// Ends a stretch of time without jumps.
    fn end_stretch(&mut self) -> Result<()> {
        if let Some(now) = self.now.take() {
            self.end_epoch(now)?;
        }
        if let Some(nonwear) = self.nonwear.take() {
            nonwear.finish(&mut self.judged);
        }
        let written = self.write_judged();
        self.judged.clear();
        written
    }

    /// Writes the epochs whose blocks have a verdict.
    fn write_judged(&mut self) -> Result<()> {
        while let (Some(epoch), Some(verdict)) = (self.waiting.front(), self.judged.front()) {
            let start_s = epoch.number * self.epoch_s;
            let block = NonWear::block_of(start_s.div_euclid(PART_S));
            if block > self.block {
                self.judged.pop_front();
                self.block += 1;
                continue;
            }
            let Some(time) = &self.time else {
                break;
            };
            let nonwear = verdict.filter(|_| epoch.measures.samples > 0);
            write_row(&mut self.line, time, start_s, epoch, nonwear);
            self.totals.add(time, start_s, self.epoch_s, epoch, nonwear);
            self.waiting.pop_front();
        }
        let written = self.table.write_all(&self.line);
        self.line.clear();
        written.map_err(|e| Error::io(Path::new("temporary file"), e))
    }
}

/// Samples that are missing between two rows, evenly spaced.
#[derive(Debug, Clone, Copy)]
struct Lost {
    from_s: f64,
    step_s: f64,
    number: f64,
    /// How many of them were counted.
    counted: f64,
}

impl Lost {
    fn none() -> Self {
        Lost {
            from_s: 0.0,
            step_s: 1.0,
            number: 0.0,
            counted: 0.0,
        }
    }

    fn between(from_s: f64, to_s: f64, usual_s: f64) -> Self {
        let number = ((to_s - from_s) / usual_s).round() - 1.0;
        Lost {
            from_s,
            step_s: (to_s - from_s) / (number + 1.0),
            number: number.max(0.0),
            counted: 0.0,
        }
    }

    /// How many of those that were not counted are before `end_s`.
    fn before(&mut self, end_s: f64) -> u64 {
        let all = ((end_s - self.from_s) / self.step_s).ceil() - 1.0;
        let all = all.clamp(self.counted, self.number.max(self.counted));
        let new = all - self.counted;
        self.counted = all;
        new as u64
    }
}

impl Sink for Epochs {
    fn collect<S: Source>(&mut self, rows: &mut Rows<S>) -> Result<()> {
        rows.hold_default();
        if matches!(self.clock, Clock::Unknown)
            && let Some(rate_hz) = rows.monitor().finish().timing.rate_hz()
        {
            self.clock = Clock::Rate(rate_hz);
        }
        let per_g = 1.0 / self.g_mps2;
        while let Some(row) = rows.next_row()? {
            self.rows += 1;
            let Some(sensor) = &mut self.sensor else {
                continue;
            };
            let [x, y, z, ..] = sensor.calibrate(row.values, row.line);
            if row.restarted {
                self.restart(row.t_s, row.values[TIME]);
            }
            let Some(t_s) = self.time_s(row.t_s, row.values[TIME]) else {
                if !matches!(self.clock, Clock::Unknown) {
                    self.untimed.push(row.line);
                }
                continue;
            };
            let pause = |reason| BreakKind::of(reason) == Some(BreakKind::Pause);
            let paused = row.before.iter().any(|reason| pause(*reason));
            self.advance(t_s, paused, row.line)?;
            self.last_s = self.last_s.max(t_s);
            if self.celsius {
                self.samples.push_temperature(row.values[TEMPERATURE]);
            }
            // All axes are NaN if one is missing.
            if x.is_nan() {
                self.missing += 1;
                continue;
            }
            self.quiet.push([x, y, z]);
            let accel_g = [x * per_g, y * per_g, z * per_g];
            self.samples.push(accel_g);
            if let Some(nonwear) = &mut self.nonwear {
                nonwear.push(accel_g);
            }
        }
        self.end_stretch()
    }
}

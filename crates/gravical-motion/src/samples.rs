//! Calibrated samples, and what is known of the sensor that made them.

use std::ops::Range;

use gravical_signal::{Channels, pieces, sampling_period};

use crate::odd::Bridged;

/// No MEMS sensor reads more, m/s² and rad/s: a row beyond it is no measurement.
const MAX_FORCE_MPS2: f64 = 1e4;
const MAX_RATE_RAD_S: f64 = 1e3;
/// Times beyond it, s, lose the microsecond in an f64.
const MAX_TIME_S: f64 = 4e9;
/// A period of zero makes no more samples of a duration.
const MAX_COUNT: usize = 1 << 30;
/// A hand moves by a few decimetres in so long, s: what it did in a longer gap is not known.
const MAX_MISSING_S: f64 = 0.5;
/// Standard deviation of the angle that a clipped gyroscope may have missed in a move, rad: 4°. Bands of
/// simulated turns of 1 s hold where the range is 0.4 of the highest rate, whatever the angle. Where it is
/// 0.24 they are too narrow by half; from 0.5 rad on that is 5° and more.
const MAX_MISSED_TURN_RAD: f64 = 0.07;

/// Why nobody knows how far a move went: its deviations do not hold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Unusable {
    /// More than half a second is missing.
    Gap {
        /// The longest gap, less a period, s.
        missing_s: f64,
    },
    /// It was interrupted for an unknown time ([`crate::Samples::with_breaks`]).
    Interrupted,
    /// The gyroscope was clipped, and the turn that it missed has a standard deviation above 4°: bands may
    /// be too narrow by half. They hold smaller ones.
    Turn,
}

/// Calibrated samples of an IMU, m/s² and rad/s, sensor axes.
#[derive(Debug, Clone)]
pub struct Samples {
    pub(crate) time_s: Vec<f64>,
    pub(crate) force: Vec<[f64; 3]>,
    /// Empty without a gyroscope.
    pub(crate) rate: Vec<[f64; 3]>,
    pub(crate) period_s: f64,
    pub(crate) pieces: Vec<Range<usize>>,
    resolution: [f64; 6],
    /// In the order of their ends.
    pub(crate) bridged: Vec<Bridged>,
    rows: Vec<usize>,
    /// Samples before which something is missing, whatever the times say.
    pub(crate) breaks: Vec<usize>,
}

impl Samples {
    /// Takes rows of time (s), specific force (m/s²) and angular rate (rad/s; none without a gyroscope: what
    /// the first row has, all have). `bridged` holds rows whose values were replaced ([`crate::bridge_odd`]),
    /// `resolution` the steps of the channels, m/s² and rad/s, 0 where they are unknown ([`crate::resolutions`]).
    ///
    /// Rows that are no measurement are left out: values that are not finite or beyond any sensor, and times
    /// that do not increase. Where that leaves a hole there is a gap.
    pub fn new(
        rows: impl Iterator<Item = (f64, [f64; 3], Option<[f64; 3]>)>,
        bridged: Vec<Bridged>,
        resolution: [f64; 6],
    ) -> Samples {
        let count = rows.size_hint().0;
        let mut samples = Samples {
            time_s: Vec::with_capacity(count),
            force: Vec::with_capacity(count),
            rate: Vec::with_capacity(count),
            period_s: 0.0,
            pieces: Vec::new(),
            resolution,
            bridged: Vec::new(),
            rows: Vec::with_capacity(count),
            breaks: Vec::new(),
        };
        for (row, (time_s, force, rate)) in rows.enumerate() {
            let is_first = samples.is_empty();
            let is_like_the_others = is_first || rate.is_some() == samples.has_gyro();
            let is_later = samples.time_s.last().is_none_or(|last| time_s > *last);
            let is_possible = time_s.abs() < MAX_TIME_S
                && force.iter().all(|v| v.abs() < MAX_FORCE_MPS2)
                && rate.iter().flatten().all(|v| v.abs() < MAX_RATE_RAD_S);
            if is_like_the_others && is_later && is_possible {
                samples.time_s.push(time_s);
                samples.force.push(force);
                samples.rate.extend(rate);
                samples.rows.push(row);
            }
        }
        samples.period_s = sampling_period(&samples.time_s);
        samples.pieces = pieces(&samples.time_s, samples.period_s, &[]);
        // In samples, where a row of it was kept.
        let kept = bridged.into_iter().map(|b| Bridged {
            rows: samples.first_sample(b.rows.start)..samples.first_sample(b.rows.end),
            ..b
        });
        samples.bridged = kept.filter(|b| !b.rows.is_empty()).collect();
        samples.bridged.sort_by_key(|b| b.rows.end);
        samples
    }

    /// Ends a piece before each of `rows`, where an unknown time is missing that the stamps may not show.
    pub fn with_breaks(mut self, rows: &[usize]) -> Samples {
        self.breaks = rows.iter().map(|row| self.first_sample(*row)).collect();
        self.breaks.sort_unstable();
        self.pieces = pieces(&self.time_s, self.period_s, &self.breaks);
        self
    }

    /// The same rows with other values, each given by its row.
    pub fn with_values(&self, values: impl Fn(usize) -> ([f64; 3], Option<[f64; 3]>)) -> Samples {
        let mut force = Vec::with_capacity(self.len());
        let mut rate = Vec::with_capacity(self.rate.len());
        for row in &self.rows {
            let (of_force, of_rate) = values(*row);
            force.push(of_force);
            rate.extend(of_rate);
        }
        Samples {
            force,
            rate,
            time_s: self.time_s.clone(),
            pieces: self.pieces.clone(),
            bridged: self.bridged.clone(),
            rows: self.rows.clone(),
            breaks: self.breaks.clone(),
            ..*self
        }
    }

    /// The first sample of row `row` or later.
    fn first_sample(&self, row: usize) -> usize {
        self.rows.partition_point(|r| *r < row)
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// True without samples.
    pub fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }

    /// The row of each sample.
    pub fn rows(&self) -> &[usize] {
        &self.rows
    }

    /// Times, values and pieces.
    pub fn channels(&self) -> Channels<'_> {
        Channels {
            time_s: &self.time_s,
            force_mps2: &self.force,
            rate_rad_s: &self.rate,
            period_s: self.period_s,
            pieces: &self.pieces,
            resolution: self.resolution,
        }
    }

    pub(crate) fn has_gyro(&self) -> bool {
        !self.rate.is_empty()
    }

    /// Samples in `seconds`.
    pub(crate) fn count_in(&self, seconds: f64) -> usize {
        ((seconds / self.period_s.max(f64::MIN_POSITIVE)) as usize).min(MAX_COUNT)
    }

    /// The first sample that is `seconds` or more after sample `from`.
    pub(crate) fn after_s(&self, from: usize, seconds: f64) -> usize {
        let until_s = self.time_s[from] + seconds;
        self.time_s.partition_point(|t| *t < until_s)
    }

    /// Samples after the first of a span, its end included, before which there is a gap; with its length by
    /// the times, s, and true if that is not all.
    pub(crate) fn gaps(&self, span: &Range<usize>) -> impl Iterator<Item = (f64, bool)> + '_ {
        let (start, end) = (span.start, span.end);
        let first = self.pieces.partition_point(|p| p.start <= start);
        let starts = self.pieces[first..].iter().map(|p| p.start);
        starts.take_while(move |i| *i <= end).map(|i| {
            let seconds = self.time_s[i] - self.time_s[i - 1];
            (seconds, self.breaks.binary_search(&i).is_ok())
        })
    }

    /// Whether so much is missing in a span that nobody knows how far the sensor went.
    pub(crate) fn unusable(&self, span: &Range<usize>) -> Option<Unusable> {
        if self.gaps(span).any(|(_, interrupted)| interrupted) {
            return Some(Unusable::Interrupted);
        }
        let gaps = self.gaps(span).map(|(seconds, _)| seconds);
        let missing_s = gaps.fold(0.0, f64::max) - self.period_s;
        if missing_s > MAX_MISSING_S {
            return Some(Unusable::Gap { missing_s });
        }
        let turns = self
            .bridged_in(span)
            .filter(|(b, _)| b.channel >= 3 && b.is_clipped);
        let variance: f64 = turns.map(|(_, sd)| sd * sd).sum();
        (variance.sqrt() > MAX_MISSED_TURN_RAD).then_some(Unusable::Turn)
    }

    /// What was bridged and ends in a span, its first sample left out and its end included, with the
    /// standard deviation of its integral over time.
    pub(crate) fn bridged_in(&self, span: &Range<usize>) -> impl Iterator<Item = (&Bridged, f64)> {
        let (start, end) = (span.start, span.end);
        let first = self.bridged.partition_point(|b| b.rows.end <= start);
        let within = self.bridged[first..].iter();
        let within = within.take_while(move |b| b.rows.end <= end);
        within.map(move |b| {
            let seconds = self.time_s[b.rows.end] - self.time_s[b.rows.start.saturating_sub(1)];
            (b, b.sd * seconds)
        })
    }

    /// Seconds from the first to the last sample of a span.
    pub(crate) fn duration_s(&self, span: &Range<usize>) -> f64 {
        if span.is_empty() {
            return 0.0;
        }
        self.time_s[span.end - 1] - self.time_s[span.start]
    }
}

//! Samples in pieces without a gap.

use std::ops::Range;

use crate::quantile::quantile;

/// A step longer than this many periods, and than [`MIN_GAP_S`], is a gap: lost rows up to that length
/// are interpolated by the trapezoid.
const MIN_GAP_PERIODS: f64 = 5.0;
/// A slow motion does not change more within this time than a trapezoid follows.
const MIN_GAP_S: f64 = 0.1;
/// No MEMS sensor reads more, m/s² and rad/s: a value beyond is not a measurement.
const MAX_FORCE_MPS2: f64 = 1e4;
const MAX_RATE_RAD_S: f64 = 1e3;
/// Times beyond it, s, lose the microsecond in an f64.
const MAX_TIME_S: f64 = 4e9;
/// A period of zero makes no more samples of a duration.
const MAX_COUNT: usize = 1 << 30;

/// A run of one channel that was no measurement and was replaced.
#[derive(Debug, Clone, PartialEq)]
pub struct Interpolated {
    /// The rows.
    pub rows: Range<usize>,
    /// 0 to 2 for x, y, z of the accelerometer, 3 to 5 of the gyroscope.
    pub channel: usize,
    /// They stood at the end of the range, and the truth lies beyond it; else out of all others for a few rows.
    pub is_clipped: bool,
    /// What the mean of the bridge may be off, unit of the channel.
    pub sd: f64,
}

/// Samples of an IMU, m/s² and rad/s.
#[derive(Debug, Clone)]
pub struct Samples {
    /// Times, s, increasing.
    pub time_s: Vec<f64>,
    /// Specific force, m/s², one for each time.
    pub force_mps2: Vec<[f64; 3]>,
    /// Angular rate, rad/s, one for each time; empty without a gyroscope.
    pub rate_rad_s: Vec<[f64; 3]>,
    /// Usual step, s: the median.
    pub period_s: f64,
    /// Spans without a gap: of more than five periods, and 0.1 s.
    pub pieces: Vec<Range<usize>>,
    /// Steps that the channels are written in, SI; 0 where they are fine.
    pub resolution: [f64; 6],
    /// Row of the recording of each sample.
    pub rows: Vec<u32>,
    /// Samples before which something is missing, whatever the times say.
    pub breaks: Vec<usize>,
    /// Values that were replaced, in the order of their ends.
    pub interpolated: Vec<Interpolated>,
}

impl Samples {
    /// Takes rows of time (s), specific force (m/s²) and angular rate (rad/s; none without a gyroscope: what
    /// the first row has, all have). `interpolated` holds rows whose values were replaced,
    /// `resolution` the steps of the channels, m/s² and rad/s, 0 where they are unknown.
    ///
    /// Rows that are no measurement are left out: values that are not finite or beyond any sensor, and times
    /// that do not increase. Where that leaves a hole there is a gap.
    pub fn new(
        rows: impl Iterator<Item = (f64, [f64; 3], Option<[f64; 3]>)>,
        interpolated: Vec<Interpolated>,
        resolution: [f64; 6],
    ) -> Samples {
        let count = rows.size_hint().0;
        let mut samples = Samples {
            time_s: Vec::with_capacity(count),
            force_mps2: Vec::with_capacity(count),
            rate_rad_s: Vec::with_capacity(count),
            period_s: 0.0,
            pieces: Vec::new(),
            resolution,
            interpolated: Vec::new(),
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
                samples.force_mps2.push(force);
                samples.rate_rad_s.extend(rate);
                samples.rows.push(row as u32);
            }
        }
        samples.period_s = sampling_period(&samples.time_s);
        samples.pieces = pieces(&samples.time_s, samples.period_s, &[]);
        // In samples, where a row of it was kept.
        let kept = interpolated.into_iter().map(|b| Interpolated {
            rows: samples.first_sample(b.rows.start)..samples.first_sample(b.rows.end),
            ..b
        });
        samples.interpolated = kept.filter(|b| !b.rows.is_empty()).collect();
        samples.interpolated.sort_by_key(|b| b.rows.end);
        samples
    }

    /// Ends a piece before each of `rows`, where an unknown time is missing that the stamps may not show.
    pub fn with_breaks(mut self, rows: &[usize]) -> Samples {
        self.breaks = rows.iter().map(|row| self.first_sample(*row)).collect();
        self.breaks.sort_unstable();
        self.pieces = pieces(&self.time_s, self.period_s, &self.breaks);
        self
    }

    /// With another period than the median step: of rows that were left out it knows nothing.
    pub fn with_period(mut self, period_s: f64) -> Samples {
        self.period_s = period_s;
        self.pieces = pieces(&self.time_s, period_s, &self.breaks);
        self
    }

    /// The same rows with other values, each given by its row.
    pub fn with_values(&self, values: impl Fn(usize) -> ([f64; 3], Option<[f64; 3]>)) -> Samples {
        let mut force = Vec::with_capacity(self.len());
        let mut rate = Vec::with_capacity(self.rate_rad_s.len());
        for row in &self.rows {
            let (of_force, of_rate) = values(*row as usize);
            force.push(of_force);
            rate.extend(of_rate);
        }
        Samples {
            force_mps2: force,
            rate_rad_s: rate,
            time_s: self.time_s.clone(),
            pieces: self.pieces.clone(),
            interpolated: self.interpolated.clone(),
            rows: self.rows.clone(),
            breaks: self.breaks.clone(),
            ..*self
        }
    }

    /// The first sample of row `row` or later.
    pub fn first_sample(&self, row: usize) -> usize {
        self.rows.partition_point(|r| (*r as usize) < row)
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// True without samples.
    pub fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }

    /// True with a gyroscope.
    pub fn has_gyro(&self) -> bool {
        !self.rate_rad_s.is_empty()
    }

    /// Samples in `seconds`.
    pub fn count_in(&self, seconds: f64) -> usize {
        ((seconds / self.period_s.max(f64::MIN_POSITIVE)) as usize).min(MAX_COUNT)
    }

    /// The first sample that is `seconds` or more after sample `from`.
    pub fn after_s(&self, from: usize, seconds: f64) -> usize {
        let until_s = self.time_s[from] + seconds;
        self.time_s.partition_point(|t| *t < until_s)
    }

    /// Samples after the first of a span, its end included, before which there is a gap; with its length by
    /// the times, s, and true if that is not all.
    pub fn gaps(&self, span: &Range<usize>) -> impl Iterator<Item = (f64, bool)> + '_ {
        let (start, end) = (span.start, span.end);
        let first = self.pieces.partition_point(|p| p.start <= start);
        let starts = self.pieces[first..].iter().map(|p| p.start);
        starts.take_while(move |i| *i <= end).map(|i| {
            let seconds = self.time_s[i] - self.time_s[i - 1];
            (seconds, self.breaks.binary_search(&i).is_ok())
        })
    }

    /// What was interpolated and ends in a span, its first sample left out and its end included, with the
    /// standard deviation of its integral over time.
    pub fn interpolated_in(
        &self,
        span: &Range<usize>,
    ) -> impl Iterator<Item = (&Interpolated, f64)> {
        let (start, end) = (span.start, span.end);
        let first = self.interpolated.partition_point(|b| b.rows.end <= start);
        let within = self.interpolated[first..].iter();
        let within = within.take_while(move |b| b.rows.end <= end);
        within.map(move |b| {
            let seconds = self.time_s[b.rows.end] - self.time_s[b.rows.start.saturating_sub(1)];
            (b, b.sd * seconds)
        })
    }

    /// Seconds from the first to the last sample of a span.
    pub fn duration_s(&self, span: &Range<usize>) -> f64 {
        if span.is_empty() {
            return 0.0;
        }
        self.time_s[span.end - 1] - self.time_s[span.start]
    }

    /// All channels of a sample; the rate is zero without a gyroscope.
    pub fn sample(&self, i: usize) -> [f64; 6] {
        let [x, y, z] = self.force_mps2[i];
        let [p, q, r] = self.rate_rad_s.get(i).copied().unwrap_or_default();
        [x, y, z, p, q, r]
    }

    /// Three channels, or six with a gyroscope.
    pub fn count(&self) -> usize {
        if self.rate_rad_s.is_empty() { 3 } else { 6 }
    }

    /// Mean of the channels; zero over an empty span.
    pub fn mean(&self, span: &Range<usize>) -> [f64; 6] {
        let mut sum = [0.0; 6];
        for i in span.clone() {
            let x = self.sample(i);
            (0..6).for_each(|c| sum[c] += x[c]);
        }
        sum.map(|s| s / span.len().max(1) as f64)
    }

    /// The piece that holds a sample.
    pub fn piece(&self, i: usize) -> Range<usize> {
        let after = self.pieces.partition_point(|p| p.end <= i);
        self.pieces.get(after).cloned().unwrap_or(i..i + 1)
    }
}

/// Median step of the times, s; 0 with fewer than two.
fn sampling_period(time_s: &[f64]) -> f64 {
    quantile(time_s.windows(2).map(|w| w[1] - w[0]).collect(), 0.5)
}

/// True if a step of the times is a gap. The last digit of a time decides nothing.
fn is_gap(step_s: f64, period_s: f64) -> bool {
    step_s > (1.0 + 1e-6) * (MIN_GAP_PERIODS * period_s).max(MIN_GAP_S)
}

/// Spans between gaps, and `breaks`: samples, in order, before which something is missing whatever the times
/// say.
fn pieces(time_s: &[f64], period_s: f64, breaks: &[usize]) -> Vec<Range<usize>> {
    let mut out = Vec::new();
    let mut from = 0;
    for i in 1..=time_s.len() {
        if i == time_s.len()
            || is_gap(time_s[i] - time_s[i - 1], period_s)
            || breaks.binary_search(&i).is_ok()
        {
            out.push(from..i);
            from = i;
        }
    }
    out
}

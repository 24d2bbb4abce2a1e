//! What a session says of its gyroscope: means at rest, and the readings of the motions between.

use std::array::from_fn;
use std::ops::Range;

use gravical_core::matrix3;
use gravical_fit::{Motion, Sample, StaticInterval};
use gravical_judge::GAP_PERIODS;
use gravical_judge::full_scale::range_end;
use gravical_signal::rounding;
use gravical_signal::stats::mean_of_finite;

use crate::finding::{Case, Finding};
use crate::poses::mean::pooled_noise;
use crate::poses::rests::with_slow_ends;
use crate::poses::{Pose, Segmentation, sum_of_rows};
use crate::recording::{GyroScale, Recording};

/// Over a longer motion the bias drifts more than the closure tells, s.
pub(super) const MAX_MOTION_S: f64 = 60.0;
/// Length of the blocks that the noise is taken from, s: longer than the correlation behind any low-pass
/// in use, shorter than a static interval.
const BLOCK_S: f64 = 0.25;

/// Why a motion takes no part in the fit of the gyroscope.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LeftOut {
    /// Too long, with a break, or not read throughout.
    Gap,
    /// At the end of the range.
    Clipped,
    /// The others say otherwise.
    Outlier,
}

/// Static intervals and motions of all recordings.
#[derive(Default)]
pub(super) struct Readings<'a> {
    pub recordings: &'a [Recording],
    pub scale: Option<GyroScale>,
    /// Of every recording whose rates can be integrated.
    pub tracks: Vec<Option<Track<'a>>>,
    pub intervals: Vec<StaticInterval>,
    pub motions: Vec<Motion>,
    /// Of each motion.
    pub places: Vec<Place>,
    /// Motions that take no part in the fit, and why.
    pub left_out: Vec<(LeftOut, Place)>,
    /// Allan N, input unit · √s.
    pub noise: [f64; 3],
    /// What rounding leaves of every mean alike, input unit.
    pub rounding: [f64; 3],
    pub findings: Vec<Finding>,
}

/// Where a motion is.
#[derive(Clone)]
pub(super) struct Place {
    pub recording: usize,
    /// From the end of the rest before it to the start of the one after it, with their slow ends.
    pub rows: Range<usize>,
    /// From a reading at rest to one at rest.
    pub lines: [u64; 2],
}

/// A gyroscope whose rates can be integrated: samples at a known rate.
pub(super) struct Track<'a> {
    recording: &'a Recording,
    gyro: &'a [Vec<f64>; 3],
    /// Ends of the range of each axis.
    ends: [Option<[f64; 2]>; 3],
    rate_hz: f64,
}

/// The gyroscope in a static interval.
struct Rest<'a> {
    rows: Range<usize>,
    rates: [&'a [f64]; 3],
    period_s: f64,
}

impl<'a> Readings<'a> {
    pub fn new(recordings: &'a [Recording], session: &Segmentation) -> Self {
        let scale = session.gyro_scale;
        let mut readings = Readings {
            recordings,
            scale,
            tracks: recordings.iter().map(|r| Track::new(r, scale)).collect(),
            ..Readings::default()
        };
        let (mut rests, mut step) = (Vec::new(), [0.0_f64; 3]);
        for (index, recording) in recordings.iter().enumerate() {
            let Some(gyro) = &recording.gyro else {
                continue;
            };
            let [_, finest] = recording.units.resolution;
            step = from_fn(|i| step[i].max(finest[i]));
            let first = rests.len();
            // Without a time the noise only weighs static intervals against each other.
            let period_s = recording.working_rate_hz().recip();
            let of_recording = session.poses.iter().filter(|p| p.recording == index);
            let mut poses: Vec<&Pose> = of_recording.collect();
            poses.sort_by_key(|p| p.rows.start);
            for pose in poses {
                // One without a reading parts two motions.
                let Some((sum, count)) = sum_of_rows(gyro, pose.rows.clone()) else {
                    continue;
                };
                readings.intervals.push(StaticInterval {
                    rate: sum.map(|s| s / count as f64),
                    seconds: count as f64 * period_s,
                    accel: pose.mean,
                    accel_sd: pose.standard_error.unwrap_or([0.0; 3]),
                });
                rests.push(Rest {
                    rows: pose.rows.clone(),
                    rates: gyro.each_ref().map(|channel| &channel[pose.rows.clone()]),
                    period_s,
                });
            }
            readings.add_motions(index, first, &rests[first..]);
        }
        let rates: Vec<[&[f64]; 3]> = rests.iter().map(|rest| rest.rates).collect();
        let samples = Recording::samples_per_row(recordings);
        readings.rounding = pooled_noise(&rates, step, samples).rounding;
        readings.noise = from_fn(|axis| allan_noise(&rests, axis, step[axis]));
        readings
    }

    /// Input units per rad/s, if the unit tells.
    pub fn nominal(&self) -> Option<f64> {
        self.scale.and_then(|scale| scale.nominal())
    }

    /// The motions between the static intervals of a recording, `first` being the index of the first of these
    /// among all.
    fn add_motions(&mut self, index: usize, first: usize, rests: &[Rest<'_>]) {
        let recording = &self.recordings[index];
        // Files of one placement each, or of two that blank rows part, hold no motions: nothing is
        // missing in them.
        let is_parted = |pair: &[Rest<'_>]| {
            recording.is_broken(&(pair[0].rows.end.saturating_sub(1)..pair[1].rows.start + 1))
        };
        if rests.len() < 2 || self.recordings.len() > 1 && rests.windows(2).all(is_parted) {
            return;
        }
        let Some(track) = &self.tracks[index] else {
            self.findings.push(rate_unknown(recording));
            return;
        };
        for (before, pair) in rests.windows(2).enumerate() {
            let between = track.between(&pair[0].rows, &pair[1].rows);
            let Some((inner, rows)) = between.filter(|(_, rows)| rows.len() >= 3) else {
                continue;
            };
            let place = Place {
                recording: index,
                rows: inner,
                lines: recording.lines_of(&rows),
            };
            match track.samples(rows) {
                Ok(samples) => {
                    let (before, after) = (first + before, first + before + 1);
                    self.motions.push(Motion {
                        before,
                        after,
                        samples,
                    });
                    self.places.push(place);
                }
                Err(why) => self.left_out.push((why, place)),
            }
        }
    }
}

fn rate_unknown(recording: &Recording) -> Finding {
    let finding = if recording.is_averaged() {
        Case::GyroAveraged.finding()
    } else {
        Case::GyroRateUnknown.finding().advise("rate", "")
    };
    finding.in_file(&recording.name)
}

impl<'a> Track<'a> {
    fn new(recording: &'a Recording, scale: Option<GyroScale>) -> Option<Self> {
        let gyro = recording.gyro.as_ref()?;
        let rate_hz = recording.clock.rate_hz()?;
        (!recording.is_averaged()).then(|| Track {
            recording,
            gyro,
            ends: gyro.each_ref().map(|c| range_end(c, scale)),
            rate_hz,
        })
    }

    fn rate_at(&self, row: usize) -> [f64; 3] {
        self.gyro.each_ref().map(|channel| channel[row])
    }

    fn is_at_end(&self, rate: [f64; 3]) -> bool {
        let beyond = |i: usize, [low, high]: [f64; 2]| rate[i] <= low || rate[i] >= high;
        (0..3).any(|i| self.ends[i].is_some_and(|ends| beyond(i, ends)))
    }

    /// Rows of the motion between two static intervals, and these from a reading at rest to one at rest.
    fn between(
        &self,
        before: &Range<usize>,
        after: &Range<usize>,
    ) -> Option<(Range<usize>, Range<usize>)> {
        let is_read = |row: &usize| {
            let mut channels = self.recording.time_s.iter().chain(self.gyro);
            channels.all(|c| c[*row].is_finite())
        };
        let inner = with_slow_ends(self.recording, before, after);
        let from = (before.start..inner.start).rfind(is_read)?;
        let to = (inner.end..after.end).find(is_read)?;
        Some((inner, from..to + 1))
    }

    /// The readings in `rows`, or why they cannot be used.
    fn samples(&self, rows: Range<usize>) -> Result<Vec<Sample>, LeftOut> {
        let seconds = |from: usize, to: usize| match &self.recording.time_s {
            Some(t) => t[to] - t[from],
            None => (to - from) as f64 / self.rate_hz,
        };
        if self.recording.is_broken(&rows) || seconds(rows.start, rows.end - 1) > MAX_MOTION_S {
            return Err(LeftOut::Gap);
        }
        let mut samples: Vec<Sample> = Vec::new();
        let (mut before, mut is_clipped) = (rows.start, false);
        for row in rows {
            let rate = self.rate_at(row);
            is_clipped |= self.is_at_end(rate);
            let step_s = seconds(before, row);
            if !(step_s.is_finite() && rate.iter().all(|v| v.is_finite())) {
                continue;
            }
            // Over a shorter step the rate is a straight line, whether rows are lost or their cells empty.
            if step_s.abs() >= GAP_PERIODS / self.rate_hz {
                return Err(LeftOut::Gap);
            }
            if let Some(last) = samples.last_mut() {
                last.step_s = step_s;
            }
            samples.push(Sample {
                rate,
                accel: self.recording.accel_at(row),
                step_s: 0.0,
            });
            before = row;
        }
        if is_clipped {
            Err(LeftOut::Clipped)
        } else {
            Ok(samples)
        }
    }

    /// ∫ u dt of what is `left` of the readings in `rows`, unit of the file · s. Each sample stands for half
    /// the time between its neighbours. None with a gap or a clipped reading.
    pub fn integral(
        &self,
        rows: &Range<usize>,
        left: impl Fn([f64; 3], [f64; 3]) -> [f64; 3],
    ) -> Option<[f64; 3]> {
        let recording = self.recording;
        if recording.is_broken(rows) {
            return None;
        }
        let last = recording.rows() - 1;
        let mut sum = [0.0; 3];
        for row in rows.clone() {
            let rate = self.rate_at(row);
            let period_s = match &recording.time_s {
                Some(t) if (1..last).contains(&row) => 0.5 * (t[row + 1] - t[row - 1]),
                _ => self.rate_hz.recip(),
            };
            let part = left(rate, recording.accel_at(row)).map(|rate| rate * period_s);
            let is_gap = !(period_s > 0.0 && period_s * self.rate_hz < GAP_PERIODS);
            if is_gap || self.is_at_end(rate) || part.iter().any(|p| !p.is_finite()) {
                return None;
            }
            sum = matrix3::add(&sum, &part);
        }
        Some(sum)
    }
}

/// Allan deviation at [`BLOCK_S`] as a density, N = σ(τ)·√τ. Rounding counts as noise too, since at rest
/// it may hide all other.
fn allan_noise(rests: &[Rest<'_>], axis: usize, step: f64) -> f64 {
    let longest_s = rests.iter().map(|r| r.period_s).fold(0.0, f64::max);
    let (mut squares, mut pairs) = (0.0, 0.0);
    for rest in rests {
        let width = ((BLOCK_S / rest.period_s).round() as usize).max(1);
        let block_s = width as f64 * rest.period_s;
        let blocks = rest.rates[axis].chunks_exact(width);
        let means: Vec<f64> = blocks.map(mean_of_finite).collect();
        for pair in means.windows(2) {
            let change = pair[1] - pair[0];
            if change.is_finite() {
                squares += 0.5 * change.powi(2) * block_s;
                pairs += 1.0;
            }
        }
    }
    let white = if pairs > 0.0 { squares / pairs } else { 0.0 };
    white.max(rounding::floor(step) * longest_s).sqrt()
}

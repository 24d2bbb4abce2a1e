//! What a session says of its gyroscope: means at rest, and the readings of the motions between.

use std::ops::Range;

use gravical_fit::{Motion, Sample, StaticInterval};

use crate::finding::{Finding, finding};
use crate::poses::mean::pooled_noise;
use crate::poses::rests::with_slow_ends;
use crate::poses::{Pose, Segmentation, sum_of_rows};
use crate::recording::{LineSpans, Recording};
use crate::rounding;
use crate::stats::mean_of_finite;
use gravical_recording::range_end;

/// A longer step is a gap, in periods: what happened in it is not known. Over a shorter one the rate is a
/// straight line, whether rows are lost or their cells empty.
pub(super) const GAP_PERIODS: f64 = 4.5;
/// Over a longer motion the bias drifts more than the closure tells, s.
const MAX_MOTION_S: f64 = 60.0;
/// Length of the blocks that the noise is taken from, s: longer than the correlation behind any low-pass
/// in use, shorter than a static interval.
const BLOCK_S: f64 = 0.25;

/// Static intervals and motions of all recordings.
#[derive(Default)]
pub(super) struct Readings {
    pub intervals: Vec<StaticInterval>,
    pub motions: Vec<Motion>,
    /// Recording and lines of each motion.
    pub places: Vec<(usize, [u64; 2])>,
    /// Motions that cannot be used: too long, gaps, clipped samples.
    pub left_out: usize,
    /// Allan N, input unit · √s.
    pub noise: [f64; 3],
    /// What rounding leaves of every mean alike, input unit.
    pub rounding: [f64; 3],
    pub findings: Vec<Finding>,
}

/// The gyroscope in a static interval.
struct Hold<'a> {
    rates: [&'a [f64]; 3],
    period_s: f64,
}

impl Readings {
    pub fn new(recordings: &[Recording], session: &Segmentation) -> Readings {
        let mut readings = Readings::default();
        let (mut holds, mut step) = (Vec::new(), [0.0_f64; 3]);
        let samples = Recording::samples_per_row(recordings);
        for (index, recording) in recordings.iter().enumerate() {
            let Some(gyro) = &recording.gyro else {
                continue;
            };
            let [_, finest] = recording.resolution;
            step = std::array::from_fn(|i| step[i].max(finest[i]));
            let first = readings.intervals.len();
            let rows = readings.add_intervals(recording, gyro, session, index, &mut holds);
            // Files of one placement each, or of two that blank rows part, hold no motions: nothing is
            // missing in them.
            if recordings.len() == 1 || moves(recording, &rows) {
                readings.add_motions(recording, gyro, session, &rows, (index, first));
            }
        }
        let rates: Vec<[&[f64]; 3]> = holds.iter().map(|h| h.rates).collect();
        readings.rounding = pooled_noise(&rates, step, samples).rounding;
        readings.noise = std::array::from_fn(|axis| allan_noise(&holds, axis, step[axis]));
        readings
    }

    /// The static intervals of a recording in the order of its rows; one without a reading parts two motions.
    fn add_intervals<'a>(
        &mut self,
        recording: &Recording,
        gyro: &'a [Vec<f64>; 3],
        session: &Segmentation,
        index: usize,
        holds: &mut Vec<Hold<'a>>,
    ) -> Vec<Range<usize>> {
        // Without a time the noise only weighs static intervals against each other.
        let period_s = recording.working_rate_hz().recip();
        let of_recording = session.poses.iter().filter(|p| p.recording == index);
        let mut rests: Vec<&Pose> = of_recording.collect();
        rests.sort_by_key(|p| p.rows.start);
        let mut kept = Vec::new();
        for placement in rests {
            let rows = &placement.rows;
            let Some((sum, count)) = sum_of_rows(gyro, rows.clone()) else {
                continue;
            };
            self.intervals.push(StaticInterval {
                rate: sum.map(|s| s / count as f64),
                seconds: count as f64 * period_s,
                accel: placement.mean,
                accel_sd: placement.standard_error.unwrap_or([0.0; 3]),
            });
            holds.push(Hold {
                rates: gyro.each_ref().map(|channel| &channel[rows.clone()]),
                period_s,
            });
            kept.push(rows.clone());
        }
        kept
    }

    /// The motions between static intervals at `rows`, `first` being the index of the first among all.
    fn add_motions(
        &mut self,
        recording: &Recording,
        gyro: &[Vec<f64>; 3],
        session: &Segmentation,
        rows: &[Range<usize>],
        (index, first): (usize, usize),
    ) {
        let is_averaged = recording.is_averaged();
        let Some(rate_hz) = recording.timing.rate_hz().filter(|_| !is_averaged) else {
            let why = if is_averaged {
                "the samples were averaged"
            } else {
                "no time stamps and no rate"
            };
            if rows.len() > 1 {
                let mut finding = finding!(
                    GyroRateUnknown,
                    "{why}: the turns between static intervals cannot be integrated, and the gyroscope gets its bias only"
                );
                if !is_averaged {
                    finding = finding.advise("rate", "");
                }
                self.findings.push(finding.in_file(&recording.name));
            }
            return;
        };
        let ends = gyro.each_ref().map(|c| range_end(c, session.gyro_scale));
        // Motions that are left out, and their lines.
        let (mut gaps, mut clips) = ((0, LineSpans::default()), (0, LineSpans::default()));
        for (before, pair) in rows.windows(2).enumerate() {
            let Some(rows) = between(recording, gyro, pair).filter(|rows| rows.len() >= 3) else {
                continue;
            };
            let [from, to] = [recording.line(rows.start), recording.line(rows.end - 1)];
            match samples(recording, gyro, rows, &ends, rate_hz) {
                Ok(samples) => {
                    let (before, after) = (first + before, first + before + 1);
                    self.motions.push(Motion {
                        before,
                        after,
                        samples,
                    });
                    self.places.push((index, [from, to]));
                }
                Err(clipped) => {
                    let is_gap = clipped == 0;
                    let (count, lines) = if is_gap { &mut gaps } else { &mut clips };
                    *count += 1;
                    lines.push_range(from, to, if is_gap { to - from + 1 } else { clipped });
                }
            }
        }
        self.left_out += gaps.0 + clips.0;
        if let (count @ 1.., lines) = gaps {
            let gap = finding!(
                GyroMotionGap,
                "{count} of the motions between static intervals last longer than {MAX_MOTION_S} s, have a break, or miss readings of the gyroscope for more than {GAP_PERIODS} periods; left out of its fit"
            );
            self.findings
                .push(gap.at_lines(&lines).in_file(&recording.name));
        }
        if let (count @ 1.., lines) = clips {
            let clip = finding!(
                GyroMotionClipped,
                "in {count} of the motions between static intervals the gyroscope reaches the end of its range ({} rows): turned too fast; left out of its fit",
                lines.count()
            );
            self.findings
                .push(clip.at_lines(&lines).in_file(&recording.name));
        }
    }
}

/// True where a static interval follows another without a break between them.
fn moves(recording: &Recording, intervals: &[Range<usize>]) -> bool {
    intervals.windows(2).any(|pair| {
        let rows = pair[0].end.saturating_sub(1)..pair[1].start + 1;
        !recording.is_broken(&rows)
    })
}

/// Rows of the motion between two static intervals, from a reading at rest to one at rest.
fn between(
    recording: &Recording,
    gyro: &[Vec<f64>; 3],
    pair: &[Range<usize>],
) -> Option<Range<usize>> {
    let is_read = |row: &usize| {
        let channels = recording.time_s.iter().chain(gyro);
        channels.into_iter().all(|c| c[*row].is_finite())
    };
    let inner = with_slow_ends(recording, &pair[0], &pair[1]);
    let from = (pair[0].start..inner.start).rfind(is_read)?;
    let to = (inner.end..pair[1].end).find(is_read)?;
    Some(from..to + 1)
}

/// The readings in `rows`; `ends` are the ends of the range of each axis. A motion that cannot be used
/// is the number of its rows at such an end, or 0 where it has a gap or is too long.
fn samples(
    recording: &Recording,
    gyro: &[Vec<f64>; 3],
    rows: Range<usize>,
    ends: &[Option<[f64; 2]>; 3],
    rate_hz: f64,
) -> Result<Vec<Sample>, u64> {
    let seconds = |from: usize, to: usize| match &recording.time_s {
        Some(t) => t[to] - t[from],
        None => (to - from) as f64 / rate_hz,
    };
    if recording.is_broken(&rows) || seconds(rows.start, rows.end - 1) > MAX_MOTION_S {
        return Err(0);
    }
    let at_end = |rate: [f64; 3]| {
        (0..3).any(|i| ends[i].is_some_and(|[low, high]| rate[i] <= low || rate[i] >= high))
    };
    let (mut samples, mut before, mut clipped): (Vec<Sample>, usize, u64) =
        (Vec::new(), rows.start, 0);
    for row in rows.clone() {
        let rate = gyro.each_ref().map(|channel| channel[row]);
        clipped += u64::from(at_end(rate));
        let step_s = seconds(before, row);
        if !(step_s.is_finite() && rate.iter().all(|v| v.is_finite())) {
            continue;
        }
        if step_s.abs() >= GAP_PERIODS / rate_hz {
            return Err(0);
        }
        if let Some(last) = samples.last_mut() {
            last.step_s = step_s;
        }
        samples.push(Sample {
            rate,
            accel: recording.accel_at(row),
            step_s: 0.0,
        });
        before = row;
    }
    if clipped > 0 {
        Err(clipped)
    } else {
        Ok(samples)
    }
}

/// Allan deviation at [`BLOCK_S`] as a density, N = σ(τ)·√τ. Rounding counts as noise too, since at rest
/// it may hide all other.
fn allan_noise(holds: &[Hold<'_>], axis: usize, step: f64) -> f64 {
    let longest_s = holds.iter().map(|h| h.period_s).fold(0.0, f64::max);
    let (mut squares, mut pairs) = (0.0, 0.0);
    for hold in holds {
        let width = ((BLOCK_S / hold.period_s).round() as usize).max(1);
        let block_s = width as f64 * hold.period_s;
        let blocks = hold.rates[axis].chunks_exact(width);
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

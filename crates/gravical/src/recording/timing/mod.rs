//! Time stamps as they were recorded: unit, wraps, repeats, gaps, true rate.

mod clock;
mod date;
mod odd;
mod steps;
#[cfg(test)]
mod tests;
mod unit;

use serde::Serialize;

use super::POSSIBLE;
use super::finding::Finding;
use crate::stats::{median, standard_deviation};

pub(crate) use clock::{Clock, Follower, Parting, Parts, Stamps};
use clock::{Followed, follow};
pub use date::parse_date;
pub(crate) use odd::Treatment;
pub(crate) use steps::Steps;
pub use unit::TimeUnit;
use unit::guess_unit;

/// What the time stamps say about the sampling.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Timing {
    /// Unit of the stamps; none without stamps.
    pub unit: Option<TimeUnit>,
    /// The rate that somebody claims (metadata, `--rate`), in Hz.
    pub nominal_rate_hz: Option<f64>,
    /// One over the median step, in Hz.
    pub median_rate_hz: Option<f64>,
    /// Rows per second over the whole recording but its pauses, in Hz: what is
    /// really there.
    pub mean_rate_hz: Option<f64>,
    /// From the first stamp to the last, in s; without stamps rows over rate.
    pub duration_s: Option<f64>,
    /// Standard deviation of the steps that are no gaps, in s.
    pub jitter_s: Option<f64>,
    /// Share of samples that are missing, 0 to 1.
    pub missing_share: Option<f64>,
}

impl Timing {
    /// The rate to work with, in Hz: that of the stamps, else the claimed one.
    #[must_use]
    pub fn rate_hz(&self) -> Option<f64> {
        self.median_rate_hz.or(self.nominal_rate_hz)
    }
}

/// True for a step between stamps that is not odd: it advances, and by no gap.
#[inline]
pub(crate) fn is_usual_step(step: f64, usual: f64) -> bool {
    step > 0.0 && step < PAUSE * usual
}

/// Result of looking at the stamps.
pub(crate) struct Timed {
    pub timing: Timing,
    /// Seconds from the first row; none when the stamps are of no use.
    pub time_s: Option<Vec<f64>>,
    /// The first stamp itself, s: where `time_s` is 0.
    pub origin_s: Option<f64>,
    /// Rows at which the clock started anew.
    pub restarts: Vec<usize>,
    /// Breaks across which the clock goes on.
    pub bridged: Vec<usize>,
    pub findings: Vec<Finding>,
}

/// What is known about the stamps from outside.
#[derive(Clone, Copy)]
pub(crate) struct Claims {
    pub unit: Option<TimeUnit>,
    pub nominal_rate_hz: Option<f64>,
    /// Span of the temperature in the recording, °C: a sensor cannot warm by
    /// tens of degrees within seconds.
    pub temperature_span_c: f64,
}

/// A step of more than so many usual ones waits for something.
const PAUSE: f64 = 4.5;
/// A buffer that is passed on at once holds fewer samples than this.
const RAREST_BURST: usize = 20;
/// Waits of one length are bursts, from so many on.
const FEWEST_BURSTS: usize = 5;

/// Judges raw stamps; `line` gives the line of a row.
pub(crate) fn judge(
    raw: Vec<f64>,
    parts: Parts<'_>,
    claims: &Claims,
    line: impl Fn(usize) -> u64,
) -> Timed {
    let mut findings = Vec::new();
    let mut steps: Vec<f64> = raw.windows(2).map(|w| w[1] - w[0]).collect();
    let mut rising: Vec<f64> = steps.iter().copied().filter(|d| *d > 0.0).collect();
    let Some(median) = median(&mut rising) else {
        findings.push(Finding::warning(
            "frozen-time",
            "the time stamps never advance; they are not used",
        ));
        return untimed(raw.len(), claims, findings);
    };
    // Stamps that most rows share with their neighbours are coarser than the sampling.
    let coarse = coarse_rate(&steps, median);
    let usual = coarse.map_or(median, |rate| 1.0 / rate);
    let unit = match claims.unit {
        Some(unit) if POSSIBLE.contains(&(1.0 / (usual * unit.seconds()))) => unit,
        Some(unit) => {
            findings.push(Finding::warning(
                "time-unit-unknown",
                format!("steps of {usual:e} {} are no rate that a sensor has; the stamps are not used (give --time-unit)", unit.name()),
            ));
            return untimed(raw.len(), claims, findings);
        }
        None => match guess_unit(raw[0], steps.len(), usual, claims, &mut findings) {
            Some(unit) => unit,
            None => {
                findings.push(Finding::warning(
                    "time-unit-unknown",
                    format!("steps of {usual} fit no unit of time at a usual rate; the stamps are not used (give --time-unit)"),
                ));
                return untimed(raw.len(), claims, findings);
            }
        },
    };
    let per_s = unit.seconds();
    let goes_on = |row: &usize| {
        let before = row.checked_sub(1).and_then(|at| raw.get(at));
        let step = before.zip(raw.get(*row)).map(|(a, b)| b - a);
        step.is_some_and(|step| is_usual_step(step, median))
    };
    let bridged: Vec<usize> = parts.breaks.iter().copied().filter(goes_on).collect();
    let origin_s = raw.iter().find(|t| t.is_finite()).map(|t| t * per_s);
    let Followed {
        time_s,
        restarts,
        pauses,
        wraps,
        duration_s,
        stamps,
    } = follow(&raw, parts, median, per_s, line);
    let mut mend = |row: usize, by: f64| {
        if let Some(step) = row.checked_sub(1).and_then(|at| steps.get_mut(at)) {
            *step += by;
        }
    };
    for (row, period) in wraps {
        mend(row, period);
    }
    for row in pauses {
        // Neither lost samples nor bunches.
        mend(row, f64::NAN);
    }
    let n = time_s.iter().filter(|t| t.is_finite()).count();
    let mean_rate = coarse
        .map(|rate| rate / per_s)
        .filter(|rate| POSSIBLE.contains(rate))
        .or_else(|| mean_rate(n, duration_s, &stamps));
    let median_s = median * per_s;
    let regular: Vec<f64> = steps
        .iter()
        .map(|d| d * per_s)
        .filter(|d| *d >= 0.0 && *d < 1.5 * median_s)
        .collect();
    let missing: f64 = steps
        .iter()
        .filter(|d| **d > 1.5 * median && **d < 1e6 * median)
        .map(|d| (d / median).round() - 1.0)
        .sum();
    stamps.report(Treatment::Repaired, &mut findings);

    // Several samples that arrive with one stamp, then a long step: stamps of
    // arrival at the computer, not of sampling.
    let bunched = steps
        .iter()
        .filter(|d| **d >= 0.0 && **d * per_s * mean_rate.unwrap_or(0.0) < 0.2)
        .count();
    if bunched * 2 > steps.len() && n > 20 && !pauses_only(&steps, median) {
        let repeated = steps.iter().filter(|d| **d == 0.0).count();
        let why = if repeated == bunched {
            "rows share their stamp with the row before: the stamps are coarser than the sampling (rounded by a spreadsheet, or times of arrival)"
        } else {
            "steps are far shorter than the mean: the stamps are times of arrival"
        };
        findings.push(
            Finding::warning(
                "burst-time",
                format!(
                    "{bunched} of {} {why}; the mean rate of {:.2} Hz is used instead",
                    steps.len(),
                    mean_rate.unwrap_or(f64::NAN)
                ),
            )
            .counting(bunched as u64),
        );
        let rate = mean_rate.unwrap_or(1.0);
        let timing = Timing {
            unit: Some(unit),
            nominal_rate_hz: claims.nominal_rate_hz,
            median_rate_hz: mean_rate,
            mean_rate_hz: mean_rate,
            duration_s: Some(duration_s),
            jitter_s: None,
            missing_share: None,
        };
        let time_s = (0..raw.len()).map(|i| i as f64 / rate).collect();
        return Timed {
            timing,
            time_s: Some(time_s),
            origin_s,
            restarts,
            bridged,
            findings,
        };
    }
    let timing = Timing {
        unit: Some(unit),
        nominal_rate_hz: claims.nominal_rate_hz,
        median_rate_hz: Some(steady_rate(&regular, median_s)),
        mean_rate_hz: mean_rate,
        duration_s: Some(duration_s),
        jitter_s: (regular.len() > 2).then(|| standard_deviation(&regular)),
        missing_share: Some((missing / (n as f64 + missing).max(1.0)).max(0.0)),
    };
    rate_findings(&timing, missing, &mut findings);
    Timed {
        timing,
        time_s: Some(time_s),
        origin_s,
        restarts,
        bridged,
        findings,
    }
}

/// Rows per unit of stamps that most rows share with the row before: those from one
/// change of the stamp to the next, since the recording begins and ends somewhere within
/// a stamp; without waits, and steps back. `median` is that of the steps that advance.
/// None for other stamps, and for fewer than three.
fn coarse_rate(steps: &[f64], median: f64) -> Option<f64> {
    let repeats = steps.iter().filter(|d| **d == 0.0).count();
    if repeats * 2 <= steps.len() {
        return None;
    }
    let changes: Vec<usize> = (0..steps.len()).filter(|i| steps[*i] != 0.0).collect();
    let (mut rows, mut span) = (0, 0.0);
    for pair in changes.windows(2) {
        let step = steps[pair[1]];
        if is_usual_step(step, median) {
            rows += pair[1] - pair[0];
            span += step;
        }
    }
    (rows > 0).then(|| rows as f64 / span)
}

/// Rows a second while it was recorded, Hz.
fn mean_rate(rows: usize, duration_s: f64, stamps: &Stamps) -> Option<f64> {
    let (pauses, paused_s) = stamps.paused();
    let steps = (rows as f64) - 1.0 - (pauses as f64);
    let recorded_s = duration_s - paused_s;
    (steps > 0.0 && recorded_s > 0.0)
        .then(|| steps / recorded_s)
        .filter(|rate| POSSIBLE.contains(rate))
}

/// Without stamps: the claimed rate is all there is.
pub(crate) fn untimed(rows: usize, claims: &Claims, findings: Vec<Finding>) -> Timed {
    Timed {
        timing: Timing {
            unit: None,
            nominal_rate_hz: claims.nominal_rate_hz,
            median_rate_hz: None,
            mean_rate_hz: None,
            duration_s: claims.nominal_rate_hz.map(|r| rows as f64 / r),
            jitter_s: None,
            missing_share: None,
        },
        time_s: None,
        origin_s: None,
        restarts: Vec::new(),
        bridged: Vec::new(),
        findings,
    }
}

/// Whether the long steps are pauses of the recorder, and no waiting for a full
/// buffer: between them the stamps run evenly, they are rare, and they differ in
/// length. `median` is that of the steps that advance.
fn pauses_only(steps: &[f64], median: f64) -> bool {
    let mut long: Vec<f64> = steps
        .iter()
        .copied()
        .filter(|d| *d > PAUSE * median)
        .collect();
    let even = steps
        .iter()
        .filter(|d| (0.5 * median..=1.5 * median).contains(*d))
        .count();
    // Not counting what is lost here and there.
    if long.len() * RAREST_BURST > steps.len() || even * 10 < (steps.len() - long.len()) * 9 {
        return false;
    }
    long.sort_unstable_by(f64::total_cmp);
    let quarter = long.len() / 4;
    let from_the_end = long.len().checked_sub(1 + quarter);
    match (long.get(quarter), from_the_end.and_then(|at| long.get(at))) {
        (Some(low), Some(high)) if long.len() >= FEWEST_BURSTS => *high > 1.5 * low,
        _ => true,
    }
}

/// The median of millisecond stamps at 62.5 Hz is 16 ms exactly never: use the
/// mean of the steps near the median.
fn steady_rate(regular: &[f64], median_s: f64) -> f64 {
    let near: Vec<f64> = regular
        .iter()
        .copied()
        .filter(|d| *d > 0.5 * median_s)
        .collect();
    if near.is_empty() {
        return 1.0 / median_s;
    }
    near.len() as f64 / near.iter().sum::<f64>()
}

fn rate_findings(timing: &Timing, missing: f64, findings: &mut Vec<Finding>) {
    if let (Some(nominal), Some(rate)) = (timing.nominal_rate_hz, timing.rate_hz())
        && (rate / nominal - 1.0).abs() > 0.02
    {
        findings.push(Finding::warning(
            "rate-mismatch",
            format!(
                "{nominal} Hz is claimed, the time stamps say {rate:.2} Hz; the stamps are used"
            ),
        ));
    }
    if let Some(share) = timing.missing_share
        && share > 0.001
        && missing >= 1.0
    {
        findings.push(
            Finding::warning(
                "missing-samples",
                format!(
                    "{missing:.0} samples ({:.1} %) are missing between the time stamps",
                    100.0 * share
                ),
            )
            .counting(missing as u64),
        );
    }
}

//! Time stamps: unit, wraps, repeats, gaps, sampling rate.

mod clock;
mod date;
mod odd;
mod steps;
mod unit;

use serde::{Deserialize, Serialize};

use super::POSSIBLE;
use crate::finding::{Finding, FindingKind};

pub(crate) use clock::{BreakKind, Clock, Follower};
pub use date::{parse_date, parse_date_day_first};
pub use gravical_recording::{TimeUnit, Timing};
use steps::Steps;
use unit::guess_unit;

/// True for a usual step: it advances and is not a gap.
#[inline]
pub(crate) fn is_usual_step(step: f64, usual: f64) -> bool {
    step > 0.0 && step < PAUSE * usual
}

/// What file and user specify about the time stamps.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Claims {
    pub unit: Option<TimeUnit>,
    pub nominal_rate_hz: Option<f64>,
    /// Range of the temperature in the recording, °C: a sensor cannot warm by tens of degrees
    /// within seconds.
    pub temperature_span_c: f64,
}

/// A step longer than this number of usual steps is a pause, a gap or a wait for a buffer.
const PAUSE: f64 = 4.5;
/// A buffer that is sent at once holds fewer samples than this.
const RAREST_BURST: u64 = 20;
/// Smallest number of waits of equal length that are bursts.
const FEWEST_BURSTS: u64 = 5;

/// How time stamps are read.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(crate) struct StampReading {
    /// Unit of the stamps.
    pub unit: TimeUnit,
    /// Their usual step, in this unit: the median of the positive steps.
    pub usual: f64,
    /// The stamps are times of arrival: samples are assumed to be equally spaced, at this rate,
    /// Hz.
    pub even_hz: Option<f64>,
}

impl StampReading {
    /// True if times, breaks and gaps are the same with either.
    pub fn agrees(&self, other: &StampReading) -> bool {
        let near = |a: f64, b: f64, share: f64| (a / b - 1.0).abs() <= share;
        let even = match (self.even_hz, other.even_hz) {
            (None, None) => true,
            (Some(a), Some(b)) => near(a, b, 0.01),
            _ => false,
        };
        even && self.unit == other.unit && near(self.usual, other.usual, 0.1)
    }
}

/// Converts time stamps to time, row by row, and determines how to read them.
#[derive(Debug, Clone)]
pub(crate) struct ClockMonitor {
    stamp_reading: Option<StampReading>,
    follower: Option<Follower>,
    /// All steps.
    steps: Steps,
    /// The steps that are wraps and pauses, and their corrected values.
    odd: Steps,
    corrected: Steps,
    rows: u64,
    /// Rows with a time stamp.
    stamped: u64,
    /// The first finite time stamp.
    origin: f64,
    before: f64,
    latest_s: f64,
}

/// Time of a row.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RowTime {
    /// Seconds since the first row; NaN if unknown.
    pub t_s: f64,
    /// The clock restarted at this row.
    pub restarted: bool,
}

impl RowTime {
    pub const UNKNOWN: RowTime = RowTime {
        t_s: f64::NAN,
        restarted: false,
    };
}

/// Results of the time stamps of a recording.
pub(crate) struct ClockSummary {
    pub timing: Timing,
    /// How to read the time stamps; `None` if they cannot be used.
    pub stamp_reading: Option<StampReading>,
    /// The first time stamp, s: where the time is 0.
    pub origin_s: Option<f64>,
}

impl ClockMonitor {
    /// `stamp_reading`: as far as it is known; without it no time is computed.
    pub fn new(stamp_reading: Option<StampReading>) -> Self {
        ClockMonitor {
            stamp_reading,
            follower: stamp_reading.map(|b| Follower::new(b.usual, b.unit.seconds())),
            steps: Steps::default(),
            odd: Steps::default(),
            corrected: Steps::default(),
            rows: 0,
            stamped: 0,
            origin: f64::NAN,
            before: f64::NAN,
            latest_s: f64::NEG_INFINITY,
        }
    }

    /// Processes the next row; `break_kind`: the kind of break before it.
    #[inline]
    pub fn observe(&mut self, stamp: f64, line: u64, break_kind: Option<BreakKind>) -> RowTime {
        let step = stamp - self.before;
        let first = self.rows == 0;
        self.before = stamp;
        self.rows += 1;
        if !first {
            self.steps.push(step);
        }
        if stamp.is_finite() {
            self.stamped += 1;
            if self.origin.is_nan() {
                self.origin = stamp;
            }
        }
        let Some(follower) = &mut self.follower else {
            return RowTime::UNKNOWN;
        };
        if let Some(how) = break_kind {
            follower.mark_break(how);
        }
        let (clock, stamp_s) = follower.observe(stamp, line);
        let corrected = match clock {
            // Not counted as missing samples or as bursts.
            Clock::Paused | Clock::Wrapped { paused: true, .. } => Some(f64::NAN),
            Clock::Wrapped { period, .. } => Some(step + period),
            _ => None,
        };
        if let Some(corrected) = corrected {
            self.odd.push(step);
            self.corrected.push(corrected);
        }
        // `max` ignores NaN of absent stamps.
        self.latest_s = self.latest_s.max(stamp_s);
        RowTime {
            t_s: match self.stamp_reading.and_then(|b| b.even_hz) {
                Some(rate_hz) => (self.rows - 1) as f64 / rate_hz,
                None => stamp_s,
            },
            restarted: clock == Clock::Restarted,
        }
    }

    /// The unit of the time stamps and their usual step, from all rows so far.
    fn judge_unit(&self, claims: &Claims, findings: &mut Vec<Finding>) -> Option<(TimeUnit, f64)> {
        let Some(usual) = self.steps.median() else {
            findings.push(Finding::new(
                FindingKind::FrozenTime,
                "the time stamps never advance; they are not used",
            ));
            return None;
        };
        // If most rows repeat the stamp before, the stamps are coarser than the sampling.
        let coarse = self.steps.coarse_rate(PAUSE * usual);
        let period = coarse.map_or(usual, |rate| 1.0 / rate);
        let unit = match claims.unit {
            Some(unit) if POSSIBLE.contains(&(1.0 / (period * unit.seconds()))) => unit,
            Some(unit) => {
                findings.push(Finding::new(
                    FindingKind::TimeUnitUnknown,
                    format!("steps of {period:e} {} give no plausible sampling rate; the time stamps are not used (give --time-unit)", unit.name()),
                ));
                return None;
            }
            None => {
                let steps = self.steps.count() as usize;
                let Some(unit) = guess_unit(self.origin, steps, period, claims, findings) else {
                    findings.push(Finding::new(
                        FindingKind::TimeUnitUnknown,
                        format!("steps of {period} give a plausible sampling rate in no unit of time; the time stamps are not used (give --time-unit)"),
                    ));
                    return None;
                };
                unit
            }
        };
        Some((unit, usual))
    }

    /// Results, after the last row. Rates and gaps are right if the usual step that was assumed
    /// [agrees](StampReading::agrees) with the one that was determined.
    pub fn finish(&self, claims: &Claims, findings: &mut Vec<Finding>) -> ClockSummary {
        let Some((unit, usual)) = self.judge_unit(claims, findings) else {
            return ClockSummary {
                timing: untimed(self.rows, claims),
                stamp_reading: None,
                origin_s: None,
            };
        };
        let per_s = unit.seconds();
        let mut stamp_reading = StampReading {
            unit,
            usual,
            even_hz: None,
        };
        let origin_s = self.origin.is_finite().then_some(self.origin * per_s);
        let Some(follower) = &self.follower else {
            return ClockSummary {
                timing: untimed(self.rows, claims),
                stamp_reading: Some(stamp_reading),
                origin_s,
            };
        };
        follower.report(findings);
        let coarse = self.steps.coarse_rate(PAUSE * usual);
        let mean_rate = coarse
            .map(|rate| rate / per_s)
            .filter(|rate| POSSIBLE.contains(rate))
            .or_else(|| self.mean_rate(follower));
        let steps = &self.steps.with(&self.odd, &self.corrected);
        let mut timing = Timing {
            unit: Some(unit),
            nominal_rate_hz: claims.nominal_rate_hz,
            median_rate_hz: mean_rate,
            mean_rate_hz: mean_rate,
            duration_s: Some(self.latest_s),
            jitter_s: None,
            missing_share: None,
        };
        // Several samples with one stamp, then a long step: the stamps are times of arrival at
        // the computer.
        let bunched = steps.shorter(0.2 / (per_s * mean_rate.unwrap_or(0.0)));
        let bunches = bunched * 2 > steps.count() && self.stamped > RAREST_BURST;
        if bunches && !steps.pauses_only(usual, PAUSE * usual) {
            findings.push(bursts(steps, bunched, mean_rate));
            stamp_reading.even_hz = Some(mean_rate.unwrap_or(1.0));
        } else {
            let missing = steps.missing(usual);
            timing.median_rate_hz = Some(steady_rate(steps, usual) / per_s);
            let regular = steps.between(-1.0, 1.5 * usual);
            timing.jitter_s = regular.deviation().map(|d| d * per_s);
            let all = (self.stamped as f64 + missing).max(1.0);
            timing.missing_share = Some((missing / all).max(0.0));
            rate_findings(&timing, missing, findings);
        }
        ClockSummary {
            timing,
            stamp_reading: Some(stamp_reading),
            origin_s,
        }
    }

    /// Rows per second while recording, Hz.
    fn mean_rate(&self, follower: &Follower) -> Option<f64> {
        let (pauses, paused_s) = follower.paused();
        let steps = (self.stamped as f64) - 1.0 - (pauses as f64);
        let recorded_s = self.latest_s - paused_s;
        (steps > 0.0 && recorded_s > 0.0)
            .then(|| steps / recorded_s)
            .filter(|rate| POSSIBLE.contains(rate))
    }
}

fn bursts(steps: &Steps, bunched: u64, mean_rate: Option<f64>) -> Finding {
    let why = if steps.repeats() == bunched {
        "rows share their stamp with the row before: the stamps are coarser than the sampling (rounded by a spreadsheet, or times of arrival)"
    } else {
        "steps are far shorter than the mean: the stamps are times of arrival"
    };
    Finding::new(
        FindingKind::BurstTime,
        format!(
            "{bunched} of {} {why}; the mean rate of {:.2} Hz is used instead",
            steps.count(),
            mean_rate.unwrap_or(f64::NAN)
        ),
    )
    .counting(bunched)
}

/// Mean of the steps near the median, as a rate in rows per unit of the stamps. The median itself
/// is not used: that of millisecond stamps at 62.5 Hz (16 ms) is never exact.
fn steady_rate(steps: &Steps, usual: f64) -> f64 {
    let near = steps.between(0.5 * usual, 1.5 * usual);
    1.0 / if near.count > 0 { near.mean } else { usual }
}

/// Timing without time stamps: only the claimed rate is known.
pub(crate) fn untimed(rows: u64, claims: &Claims) -> Timing {
    Timing {
        unit: None,
        nominal_rate_hz: claims.nominal_rate_hz,
        median_rate_hz: None,
        mean_rate_hz: None,
        duration_s: claims.nominal_rate_hz.map(|r| rows as f64 / r),
        jitter_s: None,
        missing_share: None,
    }
}

fn rate_findings(timing: &Timing, missing: f64, findings: &mut Vec<Finding>) {
    if let (Some(nominal), Some(rate)) = (timing.nominal_rate_hz, timing.rate_hz())
        && (rate / nominal - 1.0).abs() > 0.02
    {
        findings.push(Finding::new(
            FindingKind::RateMismatch,
            format!(
                "the claimed rate is {nominal} Hz, the time stamps give {rate:.2} Hz; the time stamps are used"
            ),
        ));
    }
    if let Some(share) = timing.missing_share
        && share > 0.001
        && missing >= 1.0
    {
        findings.push(
            Finding::new(
                FindingKind::MissingSamples,
                format!(
                    "{missing:.0} samples ({:.1} %) are missing between the time stamps",
                    100.0 * share
                ),
            )
            .counting(missing as u64),
        );
    }
}

//! Time stamps as they were recorded: unit, wraps, repeats, gaps, true rate.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::finding::{Finding, LineSpans};

/// Unit of the time stamps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum TimeUnit {
    /// Seconds.
    #[serde(rename = "s")]
    Second,
    /// Milliseconds.
    #[serde(rename = "ms")]
    Millisecond,
    /// Microseconds.
    #[serde(rename = "us")]
    Microsecond,
    /// Nanoseconds.
    #[serde(rename = "ns")]
    Nanosecond,
}

impl TimeUnit {
    const ALL: [TimeUnit; 4] = [
        TimeUnit::Second,
        TimeUnit::Millisecond,
        TimeUnit::Microsecond,
        TimeUnit::Nanosecond,
    ];

    /// Seconds per unit.
    #[must_use]
    pub fn seconds(self) -> f64 {
        match self {
            TimeUnit::Second => 1.0,
            TimeUnit::Millisecond => 1e-3,
            TimeUnit::Microsecond => 1e-6,
            TimeUnit::Nanosecond => 1e-9,
        }
    }

    /// As it is written in options.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            TimeUnit::Second => "s",
            TimeUnit::Millisecond => "ms",
            TimeUnit::Microsecond => "us",
            TimeUnit::Nanosecond => "ns",
        }
    }

    /// Understands a unit as people write it.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        Some(match text.trim().to_lowercase().as_str() {
            "s" | "sec" | "secs" | "second" | "seconds" => TimeUnit::Second,
            "ms" | "msec" | "millis" | "millisecond" | "milliseconds" => TimeUnit::Millisecond,
            "us" | "µs" | "μs" | "usec" | "micros" | "microsecond" | "microseconds" => {
                TimeUnit::Microsecond
            }
            "ns" | "nsec" | "nanos" | "nanosecond" | "nanoseconds" => TimeUnit::Nanosecond,
            _ => return None,
        })
    }
}

/// What the time stamps say about the sampling.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Timing {
    /// Unit of the stamps; none without stamps.
    pub unit: Option<TimeUnit>,
    /// The rate that somebody claims (metadata, `--rate`), in Hz.
    pub nominal_rate_hz: Option<f64>,
    /// One over the median step, in Hz.
    pub median_rate_hz: Option<f64>,
    /// Rows per second over the whole recording, in Hz: what is really there.
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

/// Result of looking at the stamps.
pub(crate) struct Timed {
    pub timing: Timing,
    /// Seconds from the first row; none when the stamps are of no use.
    pub time_s: Option<Vec<f64>>,
    /// Rows at which the clock started anew.
    pub restarts: Vec<usize>,
    pub findings: Vec<Finding>,
}

/// What is known about the stamps from outside.
pub(crate) struct Claims {
    pub unit: Option<TimeUnit>,
    pub nominal_rate_hz: Option<f64>,
    /// Span of the temperature in the recording, °C: a sensor cannot warm by
    /// tens of degrees within seconds.
    pub temperature_span_c: f64,
}

/// Rates that recordings have, Hz.
const PLAUSIBLE_HZ: std::ops::RangeInclusive<f64> = 0.9..=20_000.0;

/// Judges raw stamps; `line` gives the line of a row.
pub(crate) fn judge(raw: Vec<f64>, claims: &Claims, line: impl Fn(usize) -> u64) -> Timed {
    let mut findings = Vec::new();
    let steps: Vec<f64> = raw.windows(2).map(|w| w[1] - w[0]).collect();
    let mut rising: Vec<f64> = steps.iter().copied().filter(|d| *d > 0.0).collect();
    let Some(median) = median(&mut rising) else {
        findings.push(Finding::warning(
            "frozen-time",
            "the time stamps never advance; they are not used",
        ));
        return untimed(raw.len(), claims, findings);
    };
    let unit = match claims.unit {
        Some(unit) => unit,
        None => match guess_unit(median, steps.len(), claims, &mut findings) {
            Some(unit) => unit,
            None => {
                findings.push(Finding::warning(
                    "time-unit-unknown",
                    format!("steps of {median} fit no unit of time at a usual rate; the stamps are not used (give --time-unit)"),
                ));
                return untimed(raw.len(), claims, findings);
            }
        },
    };
    let per_s = unit.seconds();
    let mut time_s = Vec::with_capacity(raw.len());
    let mut stamps = Stamps::new(median, per_s);
    let first = raw.iter().copied().find(|t| t.is_finite()).unwrap_or(0.0);
    let mut offset = -first;
    let mut restarts = Vec::new();
    let mut latest = f64::NEG_INFINITY;
    for (row, &stamp) in raw.iter().enumerate() {
        let before = stamps.before;
        match stamps.see(stamp, || line(row)) {
            Clock::Absent => {
                time_s.push(f64::NAN);
                continue;
            }
            Clock::Wrapped(period) => offset += period,
            Clock::Restarted => {
                restarts.push(row);
                offset += before + median - stamp;
            }
            Clock::GoesOn => {}
        }
        let t = stamp + offset;
        latest = latest.max(t);
        time_s.push(t * per_s);
    }
    let n = time_s.iter().filter(|t| t.is_finite()).count();
    let duration_s = latest * per_s;
    let mean_rate = (n > 1 && duration_s > 0.0).then(|| (n - 1) as f64 / duration_s);
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
    if bunched * 2 > steps.len() && n > 20 {
        findings.push(
            Finding::warning(
                "burst-time",
                format!(
                    "{bunched} of {} steps are far shorter than the mean: the stamps are times of arrival; the mean rate of {:.2} Hz is used instead",
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
            restarts,
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
        missing_share: Some(missing / (n as f64 + missing).max(1.0)),
    };
    rate_findings(&timing, missing, &mut findings);
    Timed {
        timing,
        time_s: Some(time_s),
        restarts,
        findings,
    }
}

/// Without stamps: the claimed rate is all there is.
pub(super) fn untimed(rows: usize, claims: &Claims, findings: Vec<Finding>) -> Timed {
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
        restarts: Vec::new(),
        findings,
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

/// What a stamp says about the clock.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Clock {
    /// The stamp stands as it is, odd or not.
    GoesOn,
    /// The row has none.
    Absent,
    /// The counter began at zero again after this many.
    Wrapped(f64),
    /// The board was reset.
    Restarted,
}

/// What becomes of stamps that wrap or start anew.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Treatment {
    /// They are made to go on.
    Repaired,
    /// They stay as they stand in the file.
    Kept,
}

/// Follows raw stamps one after the other and books what is odd about them.
pub(crate) struct Stamps {
    /// Usual step, in the unit of the stamps.
    median: f64,
    /// Seconds per unit.
    per_s: f64,
    before: f64,
    /// Rows with a stamp.
    rows: u64,
    faults: Faults,
}

impl Stamps {
    /// With an infinite `median` there are no gaps and no restarts.
    pub(crate) fn new(median: f64, per_s: f64) -> Self {
        Stamps {
            median,
            per_s,
            before: f64::NAN,
            rows: 0,
            faults: Faults::default(),
        }
    }

    #[inline]
    pub(crate) fn see(&mut self, stamp: f64, line: impl Fn() -> u64) -> Clock {
        let step = stamp - self.before;
        if step > 0.0 && step < 4.5 * self.median {
            self.before = stamp;
            self.rows += 1;
            return Clock::GoesOn;
        }
        self.see_odd(stamp, line())
    }

    #[cold]
    fn see_odd(&mut self, stamp: f64, line: u64) -> Clock {
        if !stamp.is_finite() {
            self.faults.absent.push(line);
            return Clock::Absent;
        }
        let before = std::mem::replace(&mut self.before, stamp);
        self.rows += 1;
        let step = stamp - before;
        if step < 0.0 {
            if let Some(period) = wrap_period(before, stamp) {
                self.faults.wrapped.push(line);
                return Clock::Wrapped(period);
            }
            if stamp < 0.5 * before
                && -step > 20.0 * self.median
                && stamp < 100.0 * self.median.max(1.0 / self.per_s)
            {
                // The board began to count anew: it was reset.
                self.faults.restarted.push(line);
                return Clock::Restarted;
            }
            self.faults.backward.push(line);
        } else if step == 0.0 {
            self.faults.duplicate.push(line);
        } else if step > 4.5 * self.median {
            // Below that, single lost samples: they are in the missing share.
            self.faults.gaps.push(line);
            self.faults.longest_gap_s = self.faults.longest_gap_s.max(step * self.per_s);
        }
        Clock::GoesOn
    }

    pub(crate) fn report(&self, treatment: Treatment, findings: &mut Vec<Finding>) {
        self.faults.report(findings, self.rows, treatment);
    }
}

#[derive(Default)]
struct Faults {
    wrapped: LineSpans,
    restarted: LineSpans,
    backward: LineSpans,
    duplicate: LineSpans,
    absent: LineSpans,
    gaps: LineSpans,
    longest_gap_s: f64,
}

impl Faults {
    fn report(&self, findings: &mut Vec<Finding>, rows: u64, treatment: Treatment) {
        let share = |spans: &LineSpans| 100.0 * spans.count() as f64 / rows.max(1) as f64;
        let mut add = |spans: &LineSpans, finding: Finding| {
            if !spans.is_empty() {
                findings.push(finding.at_lines(spans));
            }
        };
        add(
            &self.wrapped,
            Finding::note(
                "wrapped-time",
                match treatment {
                    Treatment::Repaired => {
                        "the 32-bit counter of the time stamps wrapped; unwrapped"
                    }
                    Treatment::Kept => {
                        "the 32-bit counter of the time stamps wrapped; kept as recorded"
                    }
                },
            ),
        );
        add(
            &self.restarted,
            Finding::warning(
                "restarted-time",
                match treatment {
                    Treatment::Repaired => {
                        "the time stamps start anew (the board was reset); taken as a break, the clock goes on from the row before"
                    }
                    Treatment::Kept => {
                        "the time stamps start anew (the board was reset); kept as recorded"
                    }
                },
            ),
        );
        add(
            &self.backward,
            Finding::warning(
                "backward-time",
                format!(
                    "{} time stamps run backwards; kept as recorded",
                    self.backward.count()
                ),
            ),
        );
        add(
            &self.duplicate,
            Finding::warning(
                "duplicate-time",
                format!(
                    "{} time stamps repeat the one before ({:.1} % of the rows); the rows are kept",
                    self.duplicate.count(),
                    share(&self.duplicate)
                ),
            ),
        );
        add(
            &self.absent,
            Finding::warning(
                "absent-time",
                format!("{} rows have no time stamp", self.absent.count()),
            ),
        );
        add(
            &self.gaps,
            Finding::warning(
                "gap",
                format!(
                    "{} gaps of more than four samples, the longest {:.3} s",
                    self.gaps.count(),
                    self.longest_gap_s
                ),
            ),
        );
    }
}

/// A 32-bit counter that fell from near its end to near its start.
fn wrap_period(before: f64, now: f64) -> Option<f64> {
    let period = 4_294_967_296.0; // 2³²
    (before > 0.95 * period && before < period && now < 0.05 * period && now >= 0.0)
        .then_some(period)
}

/// The unit at which the median step gives a usual rate, nearest to 100 Hz
/// where two do.
fn guess_unit(
    median: f64,
    steps: usize,
    claims: &Claims,
    findings: &mut Vec<Finding>,
) -> Option<TimeUnit> {
    let mut fitting: Vec<(TimeUnit, f64)> = TimeUnit::ALL
        .into_iter()
        .map(|u| (u, 1.0 / (median * u.seconds())))
        .filter(|(_, rate)| PLAUSIBLE_HZ.contains(rate))
        .collect();
    if let Some(nominal) = claims.nominal_rate_hz
        && let Some(at) = fitting
            .iter()
            .position(|(_, rate)| (rate / nominal - 1.0).abs() < 0.5)
    {
        return Some(fitting[at].0);
    }
    // Faster than 2 °C a second is no temperature of a sensor.
    let slowest_s = claims.temperature_span_c / 2.0;
    let calm: Vec<_> = fitting
        .iter()
        .copied()
        .filter(|(_, rate)| steps as f64 / rate >= slowest_s)
        .collect();
    let by_temperature = calm.len() < fitting.len() && !calm.is_empty();
    if !calm.is_empty() {
        fitting = calm;
    }
    fitting.sort_by(|a, b| {
        let far = |rate: f64| (rate / 100.0).ln().abs();
        far(a.1).total_cmp(&far(b.1))
    });
    let &(unit, rate) = fitting.first()?;
    if by_temperature || fitting.len() > 1 {
        findings.push(Finding::warning(
            "time-unit-assumed",
            format!(
                "the time stamps are taken as {} ({rate:.2} Hz){}; --time-unit says otherwise",
                unit.name(),
                if by_temperature {
                    ", since in a finer unit the temperature would change impossibly fast"
                } else {
                    ""
                }
            ),
        ));
    }
    Some(unit)
}

/// Median; the slice is reordered. None when empty.
pub(crate) fn median(values: &mut [f64]) -> Option<f64> {
    if values.is_empty() {
        return None;
    }
    let even = values.len().is_multiple_of(2);
    let middle = values.len() / 2;
    let (low, upper, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    let upper = *upper;
    Some(if even {
        0.5 * (low.iter().copied().fold(f64::NEG_INFINITY, f64::max) + upper)
    } else {
        upper
    })
}

fn standard_deviation(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn judged(raw: Vec<f64>) -> Timed {
        let claims = Claims {
            unit: None,
            nominal_rate_hz: None,
            temperature_span_c: 0.0,
        };
        judge(raw, &claims, |row| row as u64 + 1)
    }

    fn kinds(timed: &Timed) -> Vec<&str> {
        timed.findings.iter().map(|f| f.kind.as_str()).collect()
    }

    #[test]
    fn millisecond_stamps_at_62_5_hz_give_the_true_rate() {
        let timed = judged((0..1000).map(|i| (f64::from(i) * 16.0).floor()).collect());
        let rate = timed.timing.rate_hz().unwrap();
        assert_eq!(timed.timing.unit, Some(TimeUnit::Millisecond));
        assert!((rate - 62.5).abs() < 0.01, "{rate}");
        assert!(timed.findings.is_empty());
    }

    #[test]
    fn a_wrapped_counter_goes_on() {
        let start = 4_294_967_296.0 - 50.0;
        let raw = (0..20)
            .map(|i| (start + 10.0 * f64::from(i)) % 4_294_967_296.0)
            .collect();
        let timed = judged(raw);
        assert_eq!(kinds(&timed), ["wrapped-time"]);
        let t = timed.time_s.unwrap();
        assert!(t.windows(2).all(|w| (w[1] - w[0] - 0.01).abs() < 1e-9));
    }

    #[test]
    fn repeats_steps_back_and_gaps_are_named_with_their_lines() {
        let mut raw: Vec<f64> = (0..200).map(|i| 10.0 * f64::from(i)).collect();
        raw[50] = raw[49];
        raw[70] = raw[68] - 5.0;
        for t in &mut raw[100..] {
            *t += 300.0;
        }
        let timed = judged(raw);
        assert_eq!(
            kinds(&timed),
            ["backward-time", "duplicate-time", "gap", "missing-samples"]
        );
        assert_eq!(timed.findings[1].lines, [[51, 51]]);
        assert!((timed.timing.median_rate_hz.unwrap() - 100.0).abs() < 0.5);
    }

    #[test]
    fn a_reset_of_the_board_is_a_break() {
        let mut raw: Vec<f64> = (0..100).map(|i| 5000.0 + 10.0 * f64::from(i)).collect();
        raw.extend((0..100).map(|i| 120.0 + 10.0 * f64::from(i)));
        let timed = judged(raw);
        assert_eq!(kinds(&timed), ["restarted-time"]);
        assert_eq!(timed.restarts, [100]);
    }

    #[test]
    fn bursts_are_arrival_times() {
        let raw = (0..300).map(|i| f64::from(i / 10) * 100.0).collect();
        let timed = judged(raw);
        assert!(kinds(&timed).contains(&"burst-time"));
        assert!((timed.timing.rate_hz().unwrap() - 103.0).abs() < 1.0);
    }

    #[test]
    fn an_undocumented_unit_is_settled_by_the_temperature() {
        let raw: Vec<f64> = (0..5000).map(|i| 505_700.0 * f64::from(i)).collect();
        let claims = |span| Claims {
            unit: None,
            nominal_rate_hz: None,
            temperature_span_c: span,
        };
        let warm = judge(raw.clone(), &claims(70.0), |r| r as u64);
        assert_eq!(warm.timing.unit, Some(TimeUnit::Microsecond));
        let plain = judge(raw, &claims(0.0), |r| r as u64);
        assert_eq!(plain.timing.unit, Some(TimeUnit::Nanosecond));
        assert_eq!(kinds(&plain), ["time-unit-assumed"]);
    }

    #[test]
    fn the_median_of_few() {
        assert_eq!(median(&mut []), None);
        assert_eq!(median(&mut [3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(&mut [4.0, 1.0, 2.0, 3.0]), Some(2.5));
    }
}

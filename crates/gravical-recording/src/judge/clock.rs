//! Stamps to times and a rate.

use gravical_signal::is_gap;

use super::cells::{median, trend};

/// Rates of recordings, Hz.
const RATES_HZ: std::ops::Range<f64> = 0.9..20_000.0;
/// Rates beyond which stamps or their unit are wrong, Hz.
const POSSIBLE_RATES_HZ: std::ops::Range<f64> = 1e-5..1e6;
/// Seconds since 1970 of a recording: the years 2000 to 2100.
const DATES_S: std::ops::Range<f64> = 946_684_800.0..4_102_444_800.0;
/// Rate that is likeliest where nothing else tells the unit of the stamps.
const LIKELY_RATE_HZ: f64 = 50.0;
/// Rows over which the rate of bursts and uneven stamps is taken.
const SPAN_ROWS: usize = 32;

/// What the head says of the stamps.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct ClockOptions {
    /// Seconds of one unit of the stamps
    pub unit_s: Option<f64>,
    /// Nominal rate
    pub rate_hz: Option<f64>,
}

/// Times and rate of a recording.
#[derive(Clone, PartialEq, Debug)]
pub struct Clock {
    /// Time of each row from the first on; NaN where a stamp is empty and its neighbours do not
    /// tell it
    pub time_s: Vec<f64>,
    /// Rate at which rows follow each other
    pub rate_hz: f64,
    /// Rows that rate and span ask for, less the rows that are there
    pub missing: usize,
    /// Stamps far off the line of their neighbours, which were mended
    pub bad_stamps: usize,
}

/// Rows between the changes of a stamp that stays the same for several rows.
struct Coarse {
    rows_per_tick: f64,
}

/// Times and rate by the stamps of the rows.
///
/// The unit is the one that is claimed, else the one with which the nominal rate, a date of this
/// century, or a likely rate results. `None` if the stamps do not rise.
#[must_use]
pub fn clock(mut stamps: Vec<f64>, options: ClockOptions) -> Option<Clock> {
    let usual = median(positive_steps(&stamps))?;
    let bad_stamps = mend(&mut stamps, usual);
    let coarse = Coarse::detect(&stamps);
    let period = coarse.as_ref().map_or(usual, |c| usual / c.rows_per_tick);
    let start = stamps.iter().copied().find(|s| s.is_finite())?;
    let unit_s = options
        .unit_s
        .or_else(|| guess_unit_s(start, period, options.rate_hz))?;
    let mut time_s = continued(&stamps, usual, unit_s);
    let (rate_hz, is_even) = match &coarse {
        Some(c) => (c.rows_per_tick / (usual * unit_s), true),
        None => rate_of(&time_s, usual * unit_s)?,
    };
    let duration_s = time_s.iter().rev().find(|t| t.is_finite())?;
    let slack = coarse.as_ref().map_or(1.5, |c| 1.0 + c.rows_per_tick);
    let missing = duration_s * rate_hz + 1.0 - time_s.len() as f64;
    let missing = if is_even && missing > slack {
        missing.round() as usize
    } else {
        0
    };
    if coarse.is_some() {
        spread_ticks(&mut time_s, 1.0 / rate_hz);
    }
    POSSIBLE_RATES_HZ.contains(&rate_hz).then_some(Clock {
        time_s,
        rate_hz,
        missing,
        bad_stamps,
    })
}

fn positive_steps(values: &[f64]) -> impl Iterator<Item = f64> + '_ {
    values.windows(2).map(|w| w[1] - w[0]).filter(|s| *s > 0.0)
}

impl Coarse {
    /// `None` for stamps that change with most rows.
    fn detect(stamps: &[f64]) -> Option<Self> {
        let changes: Vec<usize> = (1..stamps.len())
            .filter(|i| stamps[*i] != stamps[i - 1])
            .collect();
        if 2 * (changes.len() + 1) >= stamps.len() {
            return None;
        }
        let rows = changes.windows(2).map(|w| (w[1] - w[0]) as f64);
        let middle = median(rows.clone())?;
        let near = rows.filter(|r| (r - middle).abs() <= 1.0 + 0.2 * middle);
        let (sum, count) = near.fold((0.0, 0.0), |(sum, n), r| (sum + r, n + 1.0));
        Some(Coarse {
            rows_per_tick: sum / count,
        })
    }
}

/// Mends single stamps far off the line of their neighbours, and fills in empty ones.
fn mend(stamps: &mut [f64], usual: f64) -> usize {
    let n = stamps.len();
    let mut bad = 0;
    if n < 4 {
        return bad;
    }
    for i in 0..n {
        // The step between the neighbours, what they expect, and how many steps are far off.
        let (step, expected, far) = if i == 0 {
            (stamps[2] - stamps[1], stamps[1] - usual, 1000.0)
        } else if i == n - 1 {
            (stamps[n - 2] - stamps[n - 3], stamps[n - 2] + usual, 1000.0)
        } else {
            (
                stamps[i + 1] - stamps[i - 1],
                0.5 * (stamps[i - 1] + stamps[i + 1]),
                10.0,
            )
        };
        let is_off = (stamps[i] - expected).abs() > far * usual;
        if step > 0.0 && step < 10.0 * usual && (is_off || stamps[i].is_nan()) {
            stamps[i] = expected;
            bad += usize::from(is_off);
        }
    }
    bad
}

fn guess_unit_s(start: f64, period: f64, nominal_hz: Option<f64>) -> Option<f64> {
    let rate_hz = |unit_s: f64| 1.0 / (period * unit_s);
    let units: Vec<f64> = [1.0, 1e-3, 1e-6, 1e-9]
        .into_iter()
        .filter(|u| RATES_HZ.contains(&rate_hz(*u)))
        .collect();
    let is_nominal = |u: &f64| nominal_hz.is_some_and(|r| (rate_hz(*u) / r - 1.0).abs() < 0.5);
    let is_dated = |u: &f64| DATES_S.contains(&(start * u));
    let distance = |u: &f64| (rate_hz(*u) / LIKELY_RATE_HZ).ln().abs();
    let likely = || {
        units
            .iter()
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))
    };
    let nominal = units.iter().find(|u| is_nominal(u));
    nominal
        .or_else(|| units.iter().find(|u| is_dated(u)))
        .or_else(likely)
        .copied()
}

/// Times from the first stamp on, over counters that wrap, clocks without a date, and restarts.
fn continued(stamps: &[f64], usual: f64, unit_s: f64) -> Vec<f64> {
    let wraps = [
        65_536.0,
        16_777_216.0,
        4_294_967_296.0,
        1.0 / unit_s,
        60.0 / unit_s,
        3600.0 / unit_s,
        86_400.0 / unit_s,
        604_800.0 / unit_s,
    ];
    let start = stamps
        .iter()
        .copied()
        .find(|s| s.is_finite())
        .unwrap_or(0.0);
    let (mut offset, mut before) = (-start, start);
    let mut times_s = Vec::with_capacity(stamps.len());
    for &stamp in stamps {
        let step = stamp - before;
        if step < 0.0 {
            let fits = |wrap: &&f64| {
                **wrap > 20.0 * usual
                    && before < **wrap
                    && (0.0..4.5 * usual).contains(&(step + **wrap))
            };
            if let Some(wrap) = wraps.iter().find(fits) {
                offset += wrap;
            } else if stamp < 0.5 * before && -step > 20.0 * usual {
                offset += before + usual - stamp;
            }
        }
        if stamp.is_finite() {
            before = stamp;
        }
        times_s.push((stamp + offset) * unit_s);
    }
    times_s
}

/// Mean of regular steps; of bursts and uneven stamps the median over spans. True if regular.
fn rate_of(time_s: &[f64], tick_s: f64) -> Option<(f64, bool)> {
    let is_regular = |s: &f64| (0.4 * tick_s..1.6 * tick_s).contains(s);
    let (sum_s, count) = positive_steps(time_s)
        .filter(is_regular)
        .fold((0.0, 0_usize), |(sum, n), s| (sum + s, n + 1));
    if count * 10 >= time_s.len() * 9 || time_s.len() <= 2 * SPAN_ROWS {
        return (count > 0).then(|| (count as f64 / sum_s, true));
    }
    let spans_s = time_s.windows(SPAN_ROWS + 1).map(|w| w[SPAN_ROWS] - w[0]);
    Some((SPAN_ROWS as f64 / median(spans_s)?, false))
}

/// Parts the rows of one stamp by the period.
fn spread_ticks(time_s: &mut [f64], period_s: f64) {
    let mut tick = f64::NAN;
    let mut row = 0.0;
    for t in time_s {
        if *t == tick {
            row += 1.0;
        } else {
            (tick, row) = (*t, 0.0);
        }
        *t += row * period_s;
    }
}

/// Whether a column holds the time since the row before rather than the time.
#[must_use]
pub fn holds_steps(values: &[f64]) -> bool {
    let (up, down) = trend(values);
    let low = values.iter().copied().fold(f64::MAX, f64::min);
    let high = values.iter().copied().fold(f64::MIN, f64::max);
    let middle = median(values.iter().copied());
    low > 0.0 && down >= 0.4 * up && middle.is_some_and(|m| high < 20.0 * m)
}

/// Times of rows that hold the time since the row before.
#[must_use]
pub fn sum_steps(steps: &[f64]) -> Vec<f64> {
    let mut sum = 0.0;
    let add = |step: &f64| {
        sum += if step.is_finite() { *step } else { 0.0 };
        sum
    };
    steps.iter().map(add).collect()
}

/// How good a clock a column is: it rises with every row (1), and evenly.
#[must_use]
pub fn steadiness(stamps: &[f64]) -> Option<f64> {
    let usual = median(positive_steps(stamps))?;
    let steps = stamps.len() as f64 - 1.0;
    let rises = positive_steps(stamps).count() as f64 / steps;
    let uneven: f64 = positive_steps(stamps)
        .map(|s| (s - usual).abs().min(usual))
        .sum();
    Some(rises - 0.5 * uneven / usual / steps)
}

/// Rows before which the recording breaks: gaps of the clock, and what stands between the rows.
///
/// Blank lines count if they are few: some loggers end every line twice.
#[must_use]
pub fn breaks(
    time_s: &[f64],
    rate_hz: Option<f64>,
    marked: &[usize],
    blanks: &[usize],
    rows: usize,
) -> Vec<usize> {
    let mut out = marked.to_vec();
    if blanks.len() * 20 <= rows {
        out.extend(blanks);
    }
    if let Some(rate_hz) = rate_hz {
        let gaps = time_s.windows(2).enumerate();
        out.extend(
            gaps.filter(|(_, w)| is_gap(w[1] - w[0], 1.0 / rate_hz))
                .map(|(i, _)| i + 1),
        );
    }
    out.retain(|row| (1..rows).contains(row));
    out.sort_unstable();
    out.dedup();
    out
}

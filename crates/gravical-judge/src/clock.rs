//! Stamps to times and a rate.

use std::ops::Range;

use crate::cells::{median, trend};
use crate::units::TIME_UNITS;
use crate::utc::UtcTime;

/// Rates of recordings, Hz.
pub const RATES_HZ: std::ops::RangeInclusive<f64> = 0.9..=20_000.0;
/// Rates beyond which stamps or their unit are wrong, Hz.
const POSSIBLE_RATES_HZ: Range<f64> = 1e-6..1e9;
/// Stamps in minutes that are taken for seconds give 1500 Hz and more. A recording at a higher rate is
/// rare enough to have its unit stated, Hz.
const MAX_UNDOUBTED_RATE_HZ: f64 = 1200.0;
/// Unit of the stamps of some motion trackers, s: taken where the stated rate asks for it.
const TICK_S: f64 = 1e-4;
/// Rate that is likeliest where nothing else tells the unit of the stamps.
const LIKELY_RATE_HZ: f64 = 100.0;
const DAY_S: f64 = 86_400.0;
/// A sensor cannot warm faster, °C/s.
const MAX_WARMING_C_PER_S: f64 = 2.0;
/// A longer step, in usual ones, is a gap: a pause, a wait for a buffer, or more than four samples are missing.
pub const GAP_PERIODS: f64 = 4.5;
/// A buffer that is sent at once holds fewer samples than this.
const MAX_BURST_ROWS: usize = 20;
/// Smallest number of waits of equal length that are bursts.
const MIN_BURSTS: usize = 5;
/// Periods after which clocks begin again, s: parts of a second, seconds of a minute, of an hour,
/// of a day, of a week.
const WRAPS_S: [f64; 5] = [1.0, 60.0, 3600.0, 86_400.0, 604_800.0];
/// A longer step ahead is a clock that was set, s: recordings do not pause for years.
const MAX_PAUSE_S: f64 = 3e7;
/// Largest number of consecutive stamps off the line that are mended.
const MAX_BAD_RUN: usize = 256;
/// Steps of the median by which mended stamps are off: a single one or equal ones, and others. Rows out
/// of order are nearer.
const MIN_OFF: f64 = 10.0;
const MIN_OFF_IN_RUN: f64 = 1000.0;
/// Days that spreadsheets count from 1899-12-30 and MATLAB from the year 0, from 1954 to 2119, and
/// what is 1970 in them: only these show by their value that they are days.
const DATED_DAYS: [(Range<f64>, f64); 2] = [
    (20_000.0..80_000.0, 25_569.0),
    (714_000.0..774_000.0, 719_529.0),
];
/// Steps in a burst are shorter than this share of the mean period.
const MAX_BURST_STEP: f64 = 0.25;
/// Counters of 16, 24 and 32 bits.
const COUNTERS: [f64; 3] = [65_536.0, 16_777_216.0, 4_294_967_296.0];
/// Blank lines after every so many rows or fewer belong to the way a file is written.
const REGULAR_ROWS: usize = 20;
/// So many blank lines, or more, at even distances part no poses either: nobody places a sensor so often.
const MANY_POSES: usize = 64;
/// Stamps of rows out of order run backwards at least once in so many rows.
const ROWS_OUT_OF_ORDER: usize = 5;
/// Fraction of regular steps above which missing rows can be distinguished from jitter.
const REGULAR: f64 = 0.9;

/// What is known of the stamps beside themselves.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct ClockOptions<'a> {
    /// Seconds of one unit of the stamps
    pub unit_s: Option<f64>,
    /// Seconds of their likeliest unit
    pub likely_unit_s: Option<f64>,
    /// Nominal rate
    pub rate_hz: Option<f64>,
    /// Highest less lowest temperature in the recording, °C
    pub temperature_span_c: f64,
    /// Rows before which a logger reports missing rows: the clock may begin again
    pub gaps: &'a [usize],
    /// Rows before which the recorder was stopped: rows are not missing there
    pub pauses: &'a [usize],
}

/// Why stamps cannot be used.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum ClockFault {
    /// They never advance
    Frozen,
    /// Their period, in their unit, gives a usual rate in no unit of time
    NoUnit(f64),
    /// So many of them run backwards that they tell no rate
    Unordered(usize),
}

/// Times and rate of a recording.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Times {
    /// Time of each row from the first on; NaN where a stamp is empty and its neighbours do not
    /// tell it
    pub time_s: Vec<f64>,
    /// The first stamp
    pub start_s: f64,
    /// Seconds of one unit of the stamps
    pub unit_s: f64,
    /// The unit is neither stated nor a date: the likeliest was taken
    pub is_unit_assumed: bool,
    /// Rate at which rows follow each other
    pub rate_hz: f64,
    /// Rows over the recorded time without pauses
    pub mean_rate_hz: Option<f64>,
    /// From the first row to the last
    pub duration_s: f64,
    /// Standard deviation of the steps that are no gaps
    pub jitter_s: Option<f64>,
    /// Rows that rate and span ask for, less the rows that are there
    pub missing: f64,
    /// Steps that are far shorter than the mean, where rows were parted evenly: stamps of arrival
    pub bursty_steps: Option<usize>,
    /// Rows whose stamp was far off the line of its neighbours, or runs backwards
    pub bad: Vec<usize>,
    /// Rows without a stamp
    pub absent: Vec<usize>,
    /// Rows at which the clock begins again, and what would then be the first stamp, s
    pub restarts: Vec<(usize, f64)>,
    /// Rows with the stamp of the row before
    pub duplicates: Vec<usize>,
    /// Rows before which more than four are missing, and the steps to them, s
    pub gaps: Vec<(usize, f64)>,
}

/// Times and rate by the stamps of the rows.
///
/// The unit is the one that is claimed, else the one with which the nominal rate, a date of this
/// century, or a likely rate results.
///
/// # Errors
///
/// The stamps never advance, give a usual rate in no unit, or run backwards again and again.
pub fn clock(mut stamps: Vec<f64>, options: ClockOptions<'_>) -> Result<Times, ClockFault> {
    let usual = median(positive_steps(&stamps)).ok_or(ClockFault::Frozen)?;
    let is_absent = |row: &usize| stamps[*row].is_nan();
    let mut clock = Times {
        absent: (0..stamps.len()).filter(is_absent).collect(),
        ..Times::default()
    };
    clock.bad = repair_timestamps(&mut stamps, usual);
    let start = stamps.iter().copied().find(|s| s.is_finite());
    let mut start = start.ok_or(ClockFault::Frozen)?;
    let ticks = positive_steps(&stamps).count();
    let coarse =
        burst_rate(&stamps, 0.0..GAP_PERIODS * usual).filter(|_| 2 * ticks + 1 < stamps.len());
    let period = coarse.map_or(usual, f64::recip);
    let is_possible = |unit: &(f64, bool)| POSSIBLE_RATES_HZ.contains(&(1.0 / (period * unit.0)));
    let unit = match options.unit_s {
        Some(unit_s) => Some((unit_s, false)).filter(is_possible),
        None => guess_unit_s(start, stamps.len(), period, &options),
    };
    (clock.unit_s, clock.is_unit_assumed) = unit.ok_or(ClockFault::NoUnit(period))?;
    if clock.unit_s == DAY_S
        && let Some(zero) = day_of_1970(start)
    {
        stamps.iter_mut().for_each(|stamp| *stamp -= zero);
        start -= zero;
    }
    clock.start_s = start * clock.unit_s;
    let backwards = stamps.windows(2).filter(|w| w[1] < w[0]).count();
    if stamps.len() >= MANY_POSES && backwards * ROWS_OUT_OF_ORDER > stamps.len() {
        return Err(ClockFault::Unordered(backwards));
    }
    clock.continue_over(stamps, usual, options.gaps);
    clock.judge_steps(coarse, usual, &options);
    clock.scale();
    Ok(clock)
}

fn positive_steps(values: &[f64]) -> impl Iterator<Item = f64> + '_ {
    values.windows(2).map(|w| w[1] - w[0]).filter(|s| *s > 0.0)
}

fn is_one(rows: &[usize], row: usize) -> bool {
    rows.binary_search(&row).is_ok()
}

/// A usual step advances and is no gap.
fn is_usual(step: f64, usual: f64) -> bool {
    step > 0.0 && step < GAP_PERIODS * usual
}

fn is_near(step: f64, usual: f64) -> bool {
    (0.5 * usual..1.5 * usual).contains(&step)
}

/// Rows per unit of the stamps where rows arrive in bursts, or share coarse stamps: from the beginning
/// of one burst to that of the next, since the recording begins and ends within one, without pauses. A
/// step longer than the start of `waits` begins a burst, and one beyond its end a pause.
fn burst_rate(stamps: &[f64], waits: Range<f64>) -> Option<f64> {
    let (mut rows, mut span) = (0, 0.0);
    let mut begin = None;
    for (row, step) in (1..).zip(stamps.windows(2).map(|w| w[1] - w[0])) {
        if step < 0.0 || step >= waits.end {
            begin = Some(row);
        } else if step > waits.start
            && let Some(begin) = begin.replace(row)
        {
            (rows, span) = (rows + row - begin, span + stamps[row] - stamps[begin]);
        }
    }
    (rows > 0).then(|| rows as f64 / span)
}

/// Mends stamps far off the line of the good ones around them, and fills in single empty ones. The
/// rows that were mended.
fn repair_timestamps(stamps: &mut [f64], usual: f64) -> Vec<usize> {
    let n = stamps.len();
    let mut bad = Vec::new();
    if n < 4 {
        return bad;
    }
    for row in 0..n {
        // The good stamp before, the step from row to row, and the rows that are far off.
        let (before, step, run) = if row > 0 && row < n - 1 {
            let run = bad_run(&stamps[row - 1..], usual);
            let span = stamps[row + run] - stamps[row - 1];
            (stamps[row - 1], span / (run as f64 + 1.0), run)
        } else {
            let (before, beside) = if row == 0 {
                (stamps[1] - 2.0 * usual, stamps[2] - stamps[1])
            } else {
                (stamps[n - 2], stamps[n - 2] - stamps[n - 3])
            };
            let off = (stamps[row] - before - usual).abs();
            let is_off = off > MIN_OFF_IN_RUN * usual || stamps[row].is_nan();
            let is_near = beside > 0.0 && beside < MIN_OFF * usual;
            (before, usual, usize::from(is_near && is_off))
        };
        for k in 0..run {
            let expected = before + step * (k as f64 + 1.0);
            let is_off = (stamps[row + k] - expected).abs() > MIN_OFF * usual;
            bad.extend(is_off.then_some(row + k));
            stamps[row + k] = expected;
        }
    }
    bad
}

/// Stamps behind the first one that are far off the line from it to the one behind them.
fn bad_run(stamps: &[f64], usual: f64) -> usize {
    let continues = |run: usize| {
        let step = stamps[run + 1] - stamps[0];
        (0.0..(MIN_OFF + run as f64 - 1.0) * usual).contains(&step)
    };
    let off = |middle: f64| (stamps[1] - middle).abs() / usual;
    let middle = 0.5 * (stamps[0] + stamps[2]);
    if continues(1) && (stamps[1].is_nan() || off(middle) > MIN_OFF) {
        return 1;
    }
    let mut runs = 2..stamps.len().min(MAX_BAD_RUN + 2) - 1;
    let is_run = |run: &usize| {
        let run = &stamps[1..=*run];
        let min_off = if run.iter().all(|s| *s == run[0]) {
            MIN_OFF
        } else {
            MIN_OFF_IN_RUN
        };
        run.iter().all(|s| (s - stamps[0]).abs() > min_off * usual)
    };
    if off(stamps[0]) > MIN_OFF {
        return runs.find(|run| continues(*run)).filter(is_run).unwrap_or(0);
    }
    0
}

/// The unit, and whether it is only the likeliest.
fn guess_unit_s(
    start: f64,
    rows: usize,
    period: f64,
    options: &ClockOptions<'_>,
) -> Option<(f64, bool)> {
    let rate_hz = |unit_s: f64| 1.0 / (period * unit_s);
    let is_nominal = |unit_s: f64| {
        let share = options.rate_hz.map(|nominal| rate_hz(unit_s) / nominal);
        share.is_some_and(|s| (s - 1.0).abs() < 0.5)
    };
    let ticks = Some(TICK_S).filter(|tick| is_nominal(*tick));
    let days = day_of_1970(start).map(|_| DAY_S);
    // Nothing else tells minutes, hours and days.
    let units = TIME_UNITS.into_iter().map(|u| u.1).filter(|u| *u <= 1.0);
    let units = units.chain(ticks).chain(days);
    let units: Vec<f64> = units.filter(|u| RATES_HZ.contains(&rate_hz(*u))).collect();
    let slowest_s = options.temperature_span_c / MAX_WARMING_C_PER_S;
    // What speaks for a unit, the strongest first; the last does not tell it.
    let reasons = |unit_s: f64| {
        let is_dated = UtcTime::of_stamp(start * unit_s).is_some();
        let is_likely = options.likely_unit_s == Some(unit_s);
        let is_calm = rows as f64 * period * unit_s >= slowest_s;
        [is_nominal(unit_s), is_dated, is_likely, is_calm]
    };
    let distance = |unit_s: f64| (rate_hz(unit_s) / LIKELY_RATE_HZ).ln().abs();
    let best = units.iter().copied().min_by(|a, b| {
        let by_reasons = reasons(*b).cmp(&reasons(*a));
        by_reasons.then(distance(*a).total_cmp(&distance(*b)))
    })?;
    let is_told = reasons(best)[..3].contains(&true);
    let is_doubtful = units.len() > 1 || rate_hz(best) > MAX_UNDOUBTED_RATE_HZ;
    Some((best, is_doubtful && !is_told))
}

/// What is 1970 in a count of days that is a date.
fn day_of_1970(start: f64) -> Option<f64> {
    let dated = DATED_DAYS.iter().find(|(dates, _)| dates.contains(&start));
    dated.map(|(_, zero)| *zero)
}

impl Times {
    /// Times from the first stamp on, in its unit, over counters that wrap, clocks without a date,
    /// and restarts.
    fn continue_over(&mut self, stamps: Vec<f64>, usual: f64, gaps: &[usize]) {
        let (mut offset, mut before) = (f64::NAN, f64::NAN);
        self.time_s.reserve_exact(stamps.len());
        for (row, stamp) in stamps.into_iter().enumerate() {
            if offset.is_nan() {
                offset = -stamp;
            }
            let step = stamp - before;
            if step < 0.0 {
                let is_near_zero = stamp < 0.5 * before
                    && -step > 20.0 * usual
                    && stamp < 100.0 * usual.max(1.0 / self.unit_s);
                if let Some(period) = wrap_period(before, stamp, usual, self.unit_s) {
                    offset += period;
                } else if is_near_zero || is_one(gaps, row) {
                    offset += before + usual - stamp;
                    self.restarts.push((row, -offset));
                } else {
                    self.bad.push(row);
                }
            } else if step > MAX_PAUSE_S / self.unit_s {
                offset += usual - step;
                self.restarts.push((row, -offset));
            }
            if stamp.is_finite() {
                before = stamp;
            }
            self.time_s.push(stamp + offset);
        }
        self.bad.sort_unstable();
    }

    /// Rates, gaps and missing rows by the steps of the times, all in the unit of the stamps: in it
    /// the steps of most clocks are exact. Rows that arrive in bursts, or that share coarse stamps,
    /// are parted evenly.
    fn judge_steps(&mut self, coarse: Option<f64>, usual: f64, options: &ClockOptions<'_>) {
        let mut steps = Vec::with_capacity(self.time_s.len());
        let (mut stamped, mut pauses, mut paused) = (0, 0, 0.0);
        let mut before = f64::NAN;
        let times = self.time_s.iter().enumerate();
        for (row, t) in times.filter(|(_, t)| t.is_finite()) {
            let step = t - std::mem::replace(&mut before, *t);
            stamped += 1;
            self.duration_s = self.duration_s.max(*t);
            if step > GAP_PERIODS * usual {
                if is_one(options.pauses, row) && !is_one(options.gaps, row) {
                    (pauses, paused) = (pauses + 1, paused + step);
                    continue;
                }
                self.gaps.push((row, step));
            } else if step == 0.0 {
                self.duplicates.push(row);
            }
            steps.extend(Some(step).filter(|s| s.is_finite()));
        }
        let recorded = self.duration_s - paused;
        let rows = stamped as f64 - 1.0 - f64::from(pauses);
        let mean = (rows > 0.0 && recorded > 0.0).then(|| rows / recorded);
        self.mean_rate_hz = coarse.or(mean);
        let waits = steps.iter().copied().filter(|s| *s > GAP_PERIODS * usual);
        let wait = median(waits).filter(|_| coarse.is_none());
        let pause = GAP_PERIODS * wait.unwrap_or(usual);
        let bursts = coarse.or_else(|| burst_rate(&self.time_s, GAP_PERIODS * usual..pause));
        let bursts = bursts.or(mean).unwrap_or(0.0);
        let is_bunched = |s: &&f64| (0.0..MAX_BURST_STEP / bursts).contains(*s);
        let bursty_steps = steps.iter().filter(is_bunched).count();
        let are_many = bursty_steps * 2 > steps.len() && stamped > MAX_BURST_ROWS;
        if are_many && bursts > 0.0 && !has_only_pauses(&steps, usual) {
            self.bursty_steps = Some(bursty_steps);
            self.rate_hz = bursts;
            self.mean_rate_hz = Some(bursts);
            self.gaps.retain(|gap| gap.1 > pause);
            self.respace_bursts(options);
            return;
        }
        let near = || steps.iter().filter(|s| is_near(**s, usual));
        let count = near().count() as f64;
        let period = if count > 0.0 {
            near().sum::<f64>() / count
        } else {
            usual
        };
        self.rate_hz = 1.0 / period;
        let expected = recorded / period + 1.0 + f64::from(pauses);
        if count >= REGULAR * steps.len() as f64 {
            self.missing = (expected - stamped as f64).round().max(0.0);
        }
        steps.retain(|s| *s >= 0.0 && *s < 1.5 * usual);
        self.jitter_s = deviation(&steps);
    }

    /// Rows at equal distances between breaks and gaps.
    fn respace_bursts(&mut self, options: &ClockOptions<'_>) {
        let period = 1.0 / self.rate_hz;
        let (mut start, mut from) = (0.0, 0);
        for row in 0..self.time_s.len() {
            let gap = self.gaps.binary_search_by_key(&row, |gap| gap.0);
            let is_apart = is_one(options.gaps, row)
                || is_one(options.pauses, row)
                || self.restarts.iter().any(|restart| restart.0 == row)
                || gap.is_ok();
            if is_apart && row > 0 {
                let before = self.time_s[row - 1];
                (start, from) = (self.time_s[row].max(before + period), row);
                if let Ok(gap) = gap {
                    self.gaps[gap].1 = start - before;
                }
            }
            self.time_s[row] = start + (row - from) as f64 * period;
        }
        self.duplicates.clear();
        self.duration_s = self.time_s.last().copied().unwrap_or(0.0);
    }

    /// From the unit of the stamps to seconds.
    fn scale(&mut self) {
        let unit_s = self.unit_s;
        self.time_s.iter_mut().for_each(|t| *t *= unit_s);
        self.duration_s *= unit_s;
        self.restarts.iter_mut().for_each(|r| r.1 *= unit_s);
        self.gaps.iter_mut().for_each(|gap| gap.1 *= unit_s);
        self.jitter_s = self.jitter_s.map(|jitter| jitter * unit_s);
        self.rate_hz /= unit_s;
        let mean_hz = self.mean_rate_hz.map(|mean| mean / unit_s);
        self.mean_rate_hz = mean_hz.filter(|hz| hz.is_finite());
    }
}

/// Period of a clock that stepped back, in its unit: a 32-bit counter that fell from near its end
/// to near its start, or any other period that makes the step a usual one.
fn wrap_period(before: f64, now: f64, usual: f64, unit_s: f64) -> Option<f64> {
    let whole = COUNTERS[2];
    if before > 0.95 * whole && before < whole && (0.0..0.05 * whole).contains(&now) {
        return Some(whole);
    }
    let periods = COUNTERS.into_iter().chain(WRAPS_S.map(|s| s / unit_s));
    let fits = |period: &f64| {
        // A clock that has passed the period did not wrap but step back; so did a clock with few
        // steps in the period.
        let is_within =
            before < *period && now >= 0.0 || before < 0.5 * period && now >= -0.5 * period;
        is_within && *period > 20.0 * usual && is_usual(now + period - before, usual)
    };
    periods.into_iter().find(fits)
}

/// Whether the long steps are pauses of the recorder and not waits for a full buffer: they are
/// rare and of different lengths, and the stamps between them are evenly spaced.
fn has_only_pauses(steps: &[f64], usual: f64) -> bool {
    let waits = steps.iter().copied().filter(|s| *s > GAP_PERIODS * usual);
    let mut waits: Vec<f64> = waits.collect();
    let even = steps.iter().filter(|s| is_near(**s, usual)).count();
    // Allows for some lost samples.
    if waits.len() * MAX_BURST_ROWS > steps.len() || even * 10 < (steps.len() - waits.len()) * 9 {
        return false;
    }
    waits.sort_unstable_by(f64::total_cmp);
    let quarter = waits.len() / 4;
    waits.len() < MIN_BURSTS || waits[waits.len() - 1 - quarter] > 1.5 * waits[quarter]
}

/// Sample standard deviation; `None` for fewer than three values.
fn deviation(values: &[f64]) -> Option<f64> {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    (values.len() > 2).then(|| (squares / (n - 1.0)).sqrt())
}

/// Whether stamps count rows, some of which may be lost.
pub fn counts_rows(values: &[f64]) -> bool {
    let steps = || values.windows(2).map(|w| w[1] - w[0]);
    steps().all(|step| step.fract() == 0.0) && median(steps()) == Some(1.0)
}

/// Whether a column holds the time since the row before rather than the time.
pub fn holds_steps(values: &[f64]) -> bool {
    let (up, down) = trend(values);
    if down == 0.0 || down < 0.4 * up {
        return false;
    }
    let Some(usual) = median(values.iter().copied()) else {
        return false;
    };
    let quarter = values.len().div_ceil(4);
    let ends = [&values[..quarter], &values[values.len() - quarter..]];
    let lows = ends.map(|end| end.iter().copied().fold(f64::MAX, f64::min));
    let highs = ends.map(|end| end.iter().copied().fold(f64::MIN, f64::max));
    // A clock of rows that are out of order, or stand the last one first, has a trend all the same;
    // one that never changes has stopped.
    let is_wide = down > 0.9 || highs[0].max(highs[1]) - lows[0].min(lows[1]) > 0.5 * usual;
    let has_trend = is_wide && (highs[0] < lows[1] || highs[1] < lows[0]);
    let are_alike = values
        .iter()
        .all(|v| v.is_nan() || *v > 0.0 && *v < 20.0 * usual);
    !has_trend && are_alike
}

/// Times of rows that hold the time since the row before.
pub fn sum_steps(steps: &[f64]) -> Vec<f64> {
    let mut sum = 0.0;
    let sums = steps.iter().map(|step| {
        sum += if step.is_finite() { *step } else { 0.0 };
        sum
    });
    sums.collect()
}

/// How good a clock a column is: it rises with every row (1), and evenly.
pub fn regularity(stamps: &[f64]) -> Option<f64> {
    let usual = median(positive_steps(stamps))?;
    let steps = stamps.len() as f64 - 1.0;
    let rises = positive_steps(stamps).count() as f64 / steps;
    let uneven: f64 = positive_steps(stamps)
        .map(|s| (s - usual).abs().min(usual))
        .sum();
    Some(rises - 0.5 * uneven / usual / steps)
}

/// Rows after a repeated header, or after blank lines (and how many), before which the recording
/// breaks.
///
/// A header or a single blank line is no break if the clock continues across it; several blank
/// lines are deliberate. Some loggers end every line twice: then only more blank lines count.
pub fn breaks(
    headers: &[usize],
    blanks: &[(usize, usize)],
    time_s: &[f64],
    rate_hz: Option<f64>,
    rows: usize,
) -> Vec<usize> {
    let usual = rate_hz.map_or(f64::NAN, f64::recip);
    let continues = |row: usize| match (row.checked_sub(1), time_s.get(row)) {
        (Some(before), Some(now_s)) => is_usual(now_s - time_s[before], usual),
        _ => false,
    };
    let regular = regular_blanks(blanks, rows);
    let parts = |(row, n): &&(usize, usize)| *n > regular && (*n > regular + 1 || !continues(*row));
    let headers = headers.iter().copied().filter(|row| !continues(*row));
    let blanks = blanks.iter().filter(parts).map(|blank| blank.0);
    headers.chain(blanks).collect()
}

/// Blank lines between most rows.
pub fn regular_blanks(blanks: &[(usize, usize)], rows: usize) -> usize {
    let between = blanks.windows(2).map(|b| (b[1].0 - b[0].0) as f64);
    let between: Vec<f64> = between.collect();
    let usual = median(between.iter().copied());
    let as_usual = between.iter().filter(|n| Some(**n) == usual).count();
    let is_even = between.len() >= MANY_POSES && as_usual as f64 >= REGULAR * between.len() as f64;
    let is_often = blanks.len() >= 3 && blanks.len() * REGULAR_ROWS >= rows;
    if !is_even && !is_often {
        return 0;
    }
    median(blanks.iter().map(|b| b.1 as f64)).unwrap_or(0.0) as usize
}

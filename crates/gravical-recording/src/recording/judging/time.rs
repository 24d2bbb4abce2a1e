//! Times of the rows, and what was found of them.

use crate::finding::{Finding, FindingKind};
use crate::judge::{self, Clock, ClockFault, ClockOptions};
use crate::recording::Timing;
use crate::role::Role;
use crate::text::{Column, Format, Rows};
use crate::units::{TimeUnit, time_scale_s};

/// Tables of fewer rows are means or a single pose and need no rate.
const MIN_ROWS: usize = 40;
/// Stated and measured rates may differ by this share.
const RATE_TOLERANCE: f64 = 0.02;
/// Share of missing samples from which on it is told.
const MISSING: f64 = 0.001;

/// Times of the rows, and what was found of them.
#[derive(Default)]
pub(crate) struct JudgedTime {
    /// Empty without usable stamps.
    pub time_s: Vec<f64>,
    pub start_s: Option<f64>,
    pub timing: Timing,
    /// Rows at which the clock begins again, and what would then be the first stamp, s.
    pub restarts: Vec<(usize, f64)>,
}

impl JudgedTime {
    pub fn new(
        format: &Format,
        rows: &Rows,
        temperature_c: Option<&[f64]>,
        findings: &mut Vec<Finding>,
    ) -> Self {
        let nominal_rate_hz = format.options.rate_hz.or(format.rate_hz);
        let mut judged = JudgedTime::default();
        judged.timing.nominal_rate_hz = nominal_rate_hz;
        judged.timing.duration_s = nominal_rate_hz.map(|r| rows.rows() as f64 / r);
        let possible = temperature_c.into_iter().flatten();
        let possible = possible.filter(|t| judge::POSSIBLE_C.contains(t));
        let (low, high) = possible.fold((f64::MAX, f64::MIN), |(l, h), t| (l.min(*t), h.max(*t)));
        let mut pauses = rows.headers.clone();
        pauses.extend(rows.blanks.iter().map(|b| b.0));
        pauses.sort_unstable();
        let stamps = find_stamps(format, rows);
        let unit_s = stamps.as_ref().and_then(|stamps| stamps.unit_s);
        let given_s = format.options.time_unit.map(TimeUnit::seconds);
        let options = ClockOptions {
            unit_s: given_s.or(unit_s),
            likely_unit_s: format.options.likely_time_unit.map(TimeUnit::seconds),
            rate_hz: nominal_rate_hz,
            temperature_span_c: (high - low).max(0.0),
            gaps: &rows.breaks,
            pauses: &pauses,
        };
        let column = stamps.as_ref().and_then(|stamps| stamps.column);
        match stamps.map(|stamps| judge::clock(stamps.values, options)) {
            Some(Ok(clock)) => {
                let is_dated = column.is_none_or(|c| format.columns[c].is_dated);
                let is_stated = unit_s.is_some() && given_s.is_none() && !is_dated;
                judged.report(clock, rows, is_stated, findings);
            }
            Some(Err(ClockFault::Frozen)) if rows.rows() < 2 => {}
            Some(Err(ClockFault::Frozen)) => {
                let text = "the time stamps never advance; they are not used";
                findings.push(Finding::new(FindingKind::FrozenTime, text));
            }
            Some(Err(ClockFault::NoUnit(period))) => {
                let text = format!(
                    "steps of {period} give a plausible sampling rate in no unit of time; the time stamps are not used; give their unit"
                );
                let unknown = Finding::new(FindingKind::TimeUnitUnknown, text);
                findings.push(unknown.advise("time_unit", ""));
            }
            Some(Err(ClockFault::Unordered(backwards))) => {
                let text = format!(
                    "{backwards} of {} time stamps run backwards: the rows are out of order, and the time stamps are not used; sort the rows by time",
                    rows.rows()
                );
                findings.push(Finding::new(FindingKind::BadStamps, text));
            }
            None => findings.extend(unread_stamps(format, rows)),
        }
        let needs_rate = rows.rows() >= MIN_ROWS && !format.options.is_gyroscope;
        if judged.timing.rate_hz().is_none() && needs_rate {
            let text = "no time stamps and no rate: static intervals are counted in rows";
            findings.push(Finding::new(FindingKind::RateUnknown, text).advise("rate", ""));
        }
        judged
    }

    /// `is_stated`: the file states the unit of the stamps.
    fn report(&mut self, clock: Clock, rows: &Rows, is_stated: bool, findings: &mut Vec<Finding>) {
        use FindingKind as Kind;
        let count = rows.rows() as f64;
        let rate_hz = clock.rate_hz;
        let missing_share = clock.missing / (clock.missing + count);
        let is_off = |nominal: &f64| (rate_hz / nominal - 1.0).abs() > RATE_TOLERANCE;
        let stated = self.timing.nominal_rate_hz.filter(is_off);
        self.timing.unit = TimeUnit::of_seconds(clock.unit_s);
        let is_odd = is_stated && rows.rows() >= MIN_ROWS && !judge::RATES_HZ.contains(&rate_hz);
        let source = if is_odd { "stated" } else { "assumed" };
        let unsure = self.timing.unit.filter(|_| is_odd || clock.is_unit_assumed);
        if let Some(unit) = unsure.map(TimeUnit::name) {
            let text = format!(
                "the time stamps are {source} to be in {unit} ({rate_hz:.2} Hz); give the unit if it is another"
            );
            findings.push(Finding::new(Kind::TimeUnitAssumed, text).advise("time_unit", ""));
        }
        let mut found = |kind, at: &[usize], text: String| {
            let lines = at.iter().map(|row| u64::from(rows.lines[*row])).collect();
            if !at.is_empty() {
                findings.push(Finding::new(kind, text).at_lines(&lines));
            }
        };
        let restarts: Vec<usize> = clock.restarts.iter().map(|r| r.0).collect();
        let restarted = "the time stamps restart (the board was reset); a break";
        found(Kind::RestartedTime, &restarts, restarted.to_owned());
        let text = format!(
            "{} time stamps are off the line of their neighbours, or run backwards; a single one is replaced, others are kept",
            clock.bad.len()
        );
        found(Kind::BadStamps, &clock.bad, text);
        let text = format!(
            "{} time stamps repeat the one before ({:.1} % of the rows); the rows are kept",
            clock.duplicates.len(),
            100.0 * clock.duplicates.len() as f64 / count
        );
        found(Kind::DuplicateTime, &clock.duplicates, text);
        let text = format!("{} rows have no time stamp", clock.absent.len());
        found(Kind::AbsentTime, &clock.absent, text);
        let (gaps, steps_s): (Vec<usize>, Vec<f64>) = clock.gaps.iter().copied().unzip();
        let plural = if gaps.len() == 1 { "" } else { "s" };
        let text = format!(
            "{} gap{plural} of more than four samples, the longest {:.3} s",
            gaps.len(),
            steps_s.into_iter().fold(0.0, f64::max)
        );
        found(Kind::Gap, &gaps, text);
        let of_all = [
            (Kind::BurstTime, clock.bunched.map(|bunched| format!(
                "{bunched} of {} rows share their stamp with the row before or follow it far sooner than the mean: the stamps are coarser than the sampling (rounded by a spreadsheet), or times of arrival; the mean rate of {rate_hz:.2} Hz is used instead",
                rows.rows() - 1
            ))),
            (Kind::RateMismatch, stated.filter(|_| clock.bunched.is_none()).map(|nominal| format!(
                "the claimed rate is {nominal} Hz, the time stamps give {rate_hz:.2} Hz; the time stamps are used"
            ))),
            (Kind::MissingSamples, (missing_share > MISSING).then(|| format!(
                "{:.0} samples ({:.1} %) are missing between the time stamps",
                clock.missing,
                100.0 * missing_share
            ))),
        ];
        let of_all = of_all.into_iter();
        findings.extend(of_all.filter_map(|(kind, text)| Some(Finding::new(kind, text?))));
        self.restarts = clock.restarts;
        self.timing.median_rate_hz = Some(rate_hz);
        self.timing.mean_rate_hz = clock.mean_rate_hz;
        self.timing.duration_s = Some(clock.duration_s);
        self.timing.jitter_s = clock.jitter_s;
        self.timing.missing_share = clock.bunched.is_none().then_some(missing_share);
        self.start_s = Some(clock.start_s);
        self.time_s = clock.time_s;
    }
}

/// Stamps, not yet as times.
struct Stamps {
    values: Vec<f64>,
    /// Seconds of their unit, if the file states it.
    unit_s: Option<f64>,
    /// The column; none of two.
    column: Option<usize>,
}

/// The stamps of the column of time that rises most often and most evenly; steps only if there is no
/// other.
fn find_stamps(format: &Format, rows: &Rows) -> Option<Stamps> {
    if let Some(values) = in_two_columns(format, rows) {
        return Some(Stamps {
            values,
            unit_s: Some(1.0),
            column: None,
        });
    }
    let mut candidates = Vec::new();
    for (c, (column, values)) in format.columns.iter().zip(&rows.columns).enumerate() {
        let is_step = match column.role {
            Role::Time => !column.is_dated && judge::holds_steps(values),
            Role::Step => true,
            _ => continue,
        };
        if values.iter().all(|v| v.is_nan()) {
            continue;
        }
        let (values, penalty) = if is_step {
            (judge::sum_steps(values), 1.0)
        } else {
            (values.clone(), 0.0)
        };
        let unit_s = match column.unit.as_str() {
            "fine" => fine_ticks_s(&values),
            _ => stated_unit_s(column),
        };
        let score = judge::steadiness(&values).unwrap_or(f64::MIN) - penalty;
        let column = Some(c);
        candidates.push((
            score,
            Stamps {
                values,
                unit_s,
                column,
            },
        ));
    }
    // The last of equals: files begin with the coarser clock.
    let candidates = candidates.into_iter();
    let best = candidates.max_by(|a, b| a.0.total_cmp(&b.0));
    best.map(|(_, stamps)| stamps)
}

fn stated_unit_s(column: &Column) -> Option<f64> {
    let seconds = column.is_dated.then_some(1.0);
    seconds.or_else(|| time_scale_s(&column.unit))
}

/// Xsens' `SampleTimeFine` counts 100 µs in files of MT Manager and 1 µs in those of the DOT, whose
/// shortest step is 8333 µs.
fn fine_ticks_s(stamps: &[f64]) -> Option<f64> {
    let steps = stamps.windows(2).map(|w| w[1] - w[0]);
    let step = judge::median(steps.filter(|s| *s > 0.0))?;
    Some(if step < 8000.0 { 1e-4 } else { 1e-6 })
}

/// Stamps in two columns: whole seconds, and the fraction in ms, µs or ns (`stamp.sec` and
/// `nanosec`).
fn in_two_columns(format: &Format, rows: &Rows) -> Option<Vec<f64>> {
    let is_time = |c: &usize| format.columns[*c].role == Role::Time;
    let times = || (0..format.columns.len()).filter(is_time);
    let unit_s = |c: usize| stated_unit_s(&format.columns[c]);
    let mut wholes = times().filter(|c| unit_s(*c).is_none_or(|u| u == 1.0));
    wholes.find_map(|whole| {
        times().find_map(|below| {
            let unit_s = unit_s(below).filter(|u| *u < 1.0)?;
            add_parts(&rows.columns[whole], &rows.columns[below], unit_s)
        })
    })
}

/// The sum of seconds and their fraction, if they are that: it rises. An independent clock falls where
/// it begins again, and the duration of a loop at any time.
fn add_parts(seconds: &[f64], fraction: &[f64], unit_s: f64) -> Option<Vec<f64>> {
    let parts = seconds.iter().zip(fraction);
    let mut known = parts
        .clone()
        .filter(|(s, f)| s.is_finite() && f.is_finite());
    let are_parts = known.all(|(s, f)| s.fract() == 0.0 && (0.0..1.0).contains(&(f * unit_s)));
    let sum: Vec<f64> = parts.map(|(s, f)| s + f * unit_s).collect();
    let ((rises, falls), (turns, _)) = (judge::trend(&sum), judge::trend(seconds));
    (are_parts && turns < 1.0 && rises >= 0.9 && falls <= 0.2 * turns).then_some(sum)
}

/// A column of time that holds text, where no other column is a clock.
fn unread_stamps(format: &Format, rows: &Rows) -> Option<Finding> {
    let mut columns = format.columns.iter().zip(&rows.words);
    let first = columns.find_map(|(c, words)| words.first().filter(|_| c.role == Role::Time))?;
    let has_rate = format.options.rate_hz.or(format.rate_hz).is_some();
    let text = format!("time stamps like \"{first}\" are not understood; they are not used");
    let unread = Finding::new(FindingKind::StampsUnread, text);
    Some(if has_rate {
        unread
    } else {
        unread.advise("rate", "")
    })
}

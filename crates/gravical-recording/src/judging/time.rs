//! Times of the rows, and what was found of them.

use crate::finding::{Finding, FindingKind};
use crate::judge::{self, ClockFault, ClockOptions, Times};
use crate::metadata;
use crate::recording::Clock;
use crate::role::Role;
use crate::text::{Column, Format, Rows, StampPart};
use crate::units::{TimeUnit, is_listed, is_unit};

/// Tables of fewer rows are means or a single pose and need no rate.
const MIN_ROWS: usize = 40;
/// Stated and measured rates may differ by this share.
const RATE_TOLERANCE: f64 = 0.02;
/// Share of missing samples from which on it is told.
const MISSING: f64 = 0.001;

/// Times of the rows, and what was found of them.
pub(crate) struct JudgedTime {
    /// Empty without usable stamps.
    pub time_s: Vec<f64>,
    pub clock: Clock,
}

impl JudgedTime {
    /// The rows break where the clock begins again.
    pub fn new(
        format: &Format,
        rows: &mut Rows,
        temperature_c: Option<&[f64]>,
        findings: &mut Vec<Finding>,
    ) -> Self {
        let nominal_rate_hz = format.options.rate_hz.or(format.rate_hz);
        let clock = Clock {
            nominal_rate_hz,
            duration_s: nominal_rate_hz.map(|r| rows.rows() as f64 / r),
            stated_start_s: metadata::start_s(&format.metadata),
            rows_per_reading: 1.0,
            ..Clock::default()
        };
        let mut judged = JudgedTime {
            time_s: Vec::new(),
            clock,
        };
        let possible = temperature_c.into_iter().flatten();
        let possible = possible.filter(|t| judge::POSSIBLE_C.contains(t));
        let (low, high) = possible.fold((f64::MAX, f64::MIN), |(l, h), t| (l.min(*t), h.max(*t)));
        let blanks = rows.blanks.iter().map(|b| b.0);
        let mut pauses: Vec<usize> = rows.headers.iter().copied().chain(blanks).collect();
        pauses.sort_unstable();
        let options = ClockOptions {
            unit_s: format.options.time_unit.map(TimeUnit::seconds),
            likely_unit_s: format.options.likely_time_unit.map(TimeUnit::seconds),
            rate_hz: nominal_rate_hz,
            temperature_span_c: (high - low).max(0.0),
            gaps: &rows.breaks,
            pauses: &pauses,
        };
        match find_stamps(format, rows) {
            Some(stamps) => judged.judge_stamps(stamps, options, rows, findings),
            None => findings.extend(unread_stamps(format, rows)),
        }
        let needs_rate = rows.rows() >= MIN_ROWS && !format.options.is_gyroscope;
        if judged.clock.rate_hz().is_none() && needs_rate {
            let text = "no time stamps and no rate: static intervals are counted in rows";
            findings.push(Finding::new(FindingKind::RateUnknown, text).advise("rate", ""));
        }
        for (line, _) in &judged.clock.restarts {
            let row = rows.lines.partition_point(|l| l < line);
            rows.breaks.push(row);
        }
        judged
    }

    /// Times by stamps; `options` has the unit that the user gives.
    fn judge_stamps(
        &mut self,
        stamps: Stamps,
        options: ClockOptions<'_>,
        rows: &Rows,
        findings: &mut Vec<Finding>,
    ) {
        let given_s = options.unit_s.filter(|_| !stamps.is_dated);
        let options = ClockOptions {
            unit_s: given_s.or(stamps.unit_s),
            ..options
        };
        let times = match judge::clock(stamps.values, options) {
            Ok(times) => times,
            Err(_) if rows.rows() < 2 => return,
            Err(fault) => return findings.push(not_used(fault, rows.rows())),
        };
        self.clock.unit = TimeUnit::of_seconds(times.unit_s);
        self.clock.unit_s = Some(times.unit_s);
        let is_stated = stamps.unit_s.is_some() && given_s.is_none() && !stamps.is_dated;
        let is_odd =
            is_stated && rows.rows() >= MIN_ROWS && !judge::RATES_HZ.contains(&times.rate_hz);
        let source = if is_odd { "stated" } else { "assumed" };
        let unknown = stamps.unknown_unit.filter(|_| options.unit_s.is_none());
        let is_unsure = is_odd || times.is_unit_assumed || unknown.is_some();
        self.clock.is_unit_unsure = is_unsure;
        let rate_hz = times.rate_hz;
        self.report(times, rows, findings);
        let Some(unit) = self.clock.unit.filter(|_| is_unsure).map(TimeUnit::name) else {
            return;
        };
        let what = format!("{source} to be in {unit} ({rate_hz:.2} Hz)");
        findings.push(match unknown {
            Some(unknown) => {
                let text = format!(
                    "the unit of the time stamps, \"{unknown}\", is not known; they are {what}"
                );
                let unknown = Finding::new(FindingKind::TimeUnitUnknown, text);
                unknown.advise("rate", "").advise("time_unit", "")
            }
            None => {
                let text = format!("the time stamps are {what}; give the unit if it is another");
                Finding::new(FindingKind::TimeUnitAssumed, text).advise("time_unit", "")
            }
        });
    }

    fn report(&mut self, times: Times, rows: &Rows, findings: &mut Vec<Finding>) {
        use FindingKind as Kind;
        let count = rows.rows() as f64;
        let rate_hz = times.rate_hz;
        let missing_share = times.missing / (times.missing + count);
        let is_off = |nominal: &f64| (rate_hz / nominal - 1.0).abs() > RATE_TOLERANCE;
        let stated = self.clock.nominal_rate_hz.filter(is_off);
        let mut found = |kind, at: &[usize], text: String| {
            let lines = at.iter().map(|row| u64::from(rows.lines[*row])).collect();
            if !at.is_empty() {
                findings.push(Finding::new(kind, text).at_lines(&lines));
            }
        };
        let restarts: Vec<usize> = times.restarts.iter().map(|r| r.0).collect();
        let restarted = "the time stamps restart (the board was reset, or its clock set); a break";
        found(Kind::RestartedTime, &restarts, restarted.to_owned());
        let text = format!(
            "{} time stamps are off the line of their neighbours, or run backwards; those between good ones are replaced, others are kept",
            times.bad.len()
        );
        found(Kind::BadStamps, &times.bad, text);
        let text = format!(
            "{} time stamps repeat the one before ({:.1} % of the rows); the rows are kept",
            times.duplicates.len(),
            100.0 * times.duplicates.len() as f64 / count
        );
        found(Kind::DuplicateTime, &times.duplicates, text);
        let text = format!("{} rows have no time stamp", times.absent.len());
        found(Kind::AbsentTime, &times.absent, text);
        let (gaps, steps_s): (Vec<usize>, Vec<f64>) = times.gaps.iter().copied().unzip();
        let plural = if gaps.len() == 1 { "" } else { "s" };
        let text = format!(
            "{} gap{plural} of more than four samples, the longest {:.3} s",
            gaps.len(),
            steps_s.into_iter().fold(0.0, f64::max)
        );
        found(Kind::Gap, &gaps, text);
        let of_all = [
            (Kind::BurstTime, times.bursty_steps.map(|bursty_steps| format!(
                "{bursty_steps} of {} rows share their stamp with the row before or follow it far sooner than the mean: the stamps are coarser than the sampling (rounded by a spreadsheet), or times of arrival; the mean rate of {rate_hz:.2} Hz is used instead",
                rows.rows() - 1
            ))),
            (Kind::RateMismatch, stated.filter(|_| times.bursty_steps.is_none()).map(|nominal| format!(
                "the claimed rate is {nominal} Hz, the time stamps give {rate_hz:.2} Hz; the time stamps are used"
            ))),
            (Kind::MissingSamples, (missing_share > MISSING).then(|| format!(
                "{:.0} samples ({:.1} %) are missing between the time stamps",
                times.missing,
                100.0 * missing_share
            ))),
        ];
        let of_all = of_all.into_iter();
        findings.extend(of_all.filter_map(|(kind, text)| Some(Finding::new(kind, text?))));
        let line = |(row, start_s): (usize, f64)| (rows.lines[row], start_s);
        self.clock = Clock {
            median_rate_hz: Some(rate_hz),
            mean_rate_hz: times.mean_rate_hz,
            duration_s: Some(times.duration_s),
            jitter_s: times.jitter_s,
            missing_share: times.bursty_steps.is_none().then_some(missing_share),
            start_s: Some(times.start_s),
            restarts: times.restarts.into_iter().map(line).collect(),
            ..std::mem::take(&mut self.clock)
        };
        self.time_s = times.time_s;
    }
}

/// Why the stamps of so many rows are not used.
fn not_used(fault: ClockFault, rows: usize) -> Finding {
    match fault {
        ClockFault::Frozen => {
            let text = "the time stamps never advance; they are not used";
            Finding::new(FindingKind::FrozenTime, text)
        }
        ClockFault::NoUnit(period) => {
            let text = format!(
                "steps of {period} give a plausible sampling rate in no unit of time; the time stamps are not used; give their unit"
            );
            Finding::new(FindingKind::TimeUnitUnknown, text).advise("time_unit", "")
        }
        ClockFault::Unordered(backwards) => {
            let text = format!(
                "{backwards} of {rows} time stamps run backwards: the rows are out of order, and the time stamps are not used; sort the rows by time"
            );
            Finding::new(FindingKind::BadStamps, text)
        }
    }
}

/// Stamps, not yet as times.
#[derive(Default)]
struct Stamps {
    values: Vec<f64>,
    /// They are steps, or numbers of rows.
    is_last_resort: bool,
    /// Seconds of their unit, if the file states it.
    unit_s: Option<f64>,
    /// They are dates or times of day.
    is_dated: bool,
    /// The unit as the file states it, if it is no unit of time.
    unknown_unit: Option<String>,
}

/// The clock that rises most often and most evenly; steps and numbers of rows only if there is no
/// other.
fn find_stamps(format: &Format, rows: &Rows) -> Option<Stamps> {
    let parts = &format.stamp_parts;
    let mut candidates = Vec::new();
    for (c, (column, values)) in format.columns.iter().zip(&rows.columns).enumerate() {
        let is_step = match column.role {
            Role::Time => !column.is_dated && judge::holds_steps(values),
            Role::Step => true,
            _ => continue,
        };
        let is_part = parts.iter().any(|part| part.columns().contains(&c));
        if is_part || values.iter().all(|v| v.is_nan()) {
            continue;
        }
        let values = if is_step {
            judge::sum_steps(values)
        } else {
            values.clone()
        };
        // Xsens' `SampleTimeFine` counts 100 µs in files of MT Manager and 1 µs in those of the DOT, whose
        // shortest step is 8333 µs.
        let stated_s = match column.unit.as_str() {
            "fine" => usual_step(&values).map(|step| if step < 8000.0 { 1e-4 } else { 1e-6 }),
            _ => column.stated_unit_s(),
        };
        let counts_rows = stated_s.is_none() && judge::counts_rows(&values);
        let unknown = unknown_unit(column).filter(|_| stated_s.is_none());
        // With the rate frames, cycles, jiffies are a time.
        let rate_hz = format.rate_hz.filter(|_| counts_rows);
        let rate_hz = format
            .options
            .rate_hz
            .or(rate_hz)
            .filter(|_| unknown.is_some());
        let by_rate_s = rate_hz
            .zip(usual_step(&values))
            .map(|(rate, step)| 1.0 / (rate * step));
        candidates.push(Stamps {
            is_last_resort: is_step || counts_rows,
            values,
            unit_s: stated_s.or(by_rate_s),
            is_dated: column.is_dated,
            unknown_unit: unknown.filter(|_| by_rate_s.is_none()),
        });
    }
    candidates.extend((!parts.is_empty()).then(|| Stamps {
        values: StampPart::sum(parts, rows),
        unit_s: Some(1.0),
        is_dated: true,
        ..Stamps::default()
    }));
    let score = |stamps: &Stamps| {
        let regularity = judge::regularity(&stamps.values).unwrap_or(f64::MIN);
        regularity - f64::from(u8::from(stamps.is_last_resort))
    };
    // The last of equals: files begin with the coarser clock.
    let candidates = candidates.into_iter();
    candidates.max_by(|a, b| score(a).total_cmp(&score(b)))
}

/// What the file states as the unit of a clock, if it is no unit at all: `frames`, `jiffies`.
fn unknown_unit(column: &Column) -> Option<String> {
    const NO_UNITS: &str = "cal raw utc gmt unix posix epoch local gps time";
    let unit = &column.unit;
    let is_word = !unit.is_empty() && unit.chars().all(char::is_alphabetic);
    (is_word && !is_unit(unit) && !is_listed(NO_UNITS, unit)).then(|| unit.clone())
}

fn usual_step(stamps: &[f64]) -> Option<f64> {
    let steps = stamps.windows(2).map(|w| w[1] - w[0]);
    judge::median(steps.filter(|s| *s > 0.0))
}

/// A column of time that holds text, where no other column is a clock.
fn unread_stamps(format: &Format, rows: &Rows) -> Option<Finding> {
    let mut columns = format.columns.iter().zip(&rows.words);
    let first = columns.find_map(|(c, words)| words.first().filter(|_| c.role == Role::Time))?;
    let text = format!("time stamps like \"{first}\" are not understood; they are not used");
    let unread = Finding::new(FindingKind::StampsUnread, text);
    Some(match format.options.rate_hz.or(format.rate_hz) {
        Some(_) => unread,
        None => unread.advise("rate", ""),
    })
}

//! Times of the rows, and what was found of them.

use gravical_judge::finding::Case;
use gravical_judge::units::{POSSIBLE_C, TimeUnit, is_listed, is_unit};
use gravical_judge::{self as judge, ClockFault, ClockOptions, Finding, Role, Times};

use crate::metadata;
use crate::recording::Clock;
use crate::text::{Column, Format, Rows, StampPart};

/// Tables of fewer rows are means or a single pose and need no rate.
const MIN_ROWS: usize = 40;
/// Stated and measured rates may differ by this share.
const RATE_TOLERANCE: f64 = 0.02;
/// Share of missing samples from which on it is reported.
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
        let possible = possible.filter(|t| POSSIBLE_C.contains(t));
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
            findings.push(Case::RateUnknown.finding().advise("rate", ""));
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
        let unknown = stamps.unknown_unit.filter(|_| options.unit_s.is_none());
        let is_unsure = is_odd || times.is_unit_assumed || unknown.is_some();
        self.clock.is_unit_unsure = is_unsure;
        let rate_hz = times.rate_hz;
        self.report(times, rows, findings);
        let Some(unit) = self.clock.unit.filter(|_| is_unsure) else {
            return;
        };
        let unsure = match unknown {
            Some(stated) => {
                let case = Case::TimeUnitUnknown {
                    stated,
                    unit,
                    rate_hz,
                };
                case.finding().advise("rate", "")
            }
            None if is_odd => Case::TimeUnitStated { unit, rate_hz }.finding(),
            None => Case::TimeUnitAssumed { unit, rate_hz }.finding(),
        };
        findings.push(unsure.advise("time_unit", ""));
    }

    fn report(&mut self, times: Times, rows: &Rows, findings: &mut Vec<Finding>) {
        let count = rows.rows() as f64;
        let rate_hz = times.rate_hz;
        let missing_share = times.missing / (times.missing + count);
        let is_off = |nominal: &f64| (rate_hz / nominal - 1.0).abs() > RATE_TOLERANCE;
        let stated = self.clock.nominal_rate_hz.filter(is_off);
        let mut found = |at: &[usize], case: Case| {
            let lines = at.iter().map(|row| u64::from(rows.lines[*row])).collect();
            if !at.is_empty() {
                findings.push(case.finding().at_lines(&lines));
            }
        };
        let restarts: Vec<usize> = times.restarts.iter().map(|r| r.0).collect();
        found(&restarts, Case::RestartedTime);
        let stamps = times.bad.len();
        found(&times.bad, Case::BadStamps { stamps });
        let stamps = times.duplicates.len();
        let percent = 100.0 * stamps as f64 / count;
        found(&times.duplicates, Case::DuplicateTime { stamps, percent });
        let lacking = times.absent.len();
        found(&times.absent, Case::AbsentStamps { rows: lacking });
        let (gaps, steps_s): (Vec<usize>, Vec<f64>) = times.gaps.iter().copied().unzip();
        let gap = Case::Gap {
            gaps: gaps.len(),
            longest_s: steps_s.into_iter().fold(0.0, f64::max),
        };
        found(&gaps, gap);
        let bursts = times.bursty_steps.map(|bursty_steps| Case::BurstTime {
            bursty_steps,
            steps: rows.rows() - 1,
            rate_hz,
        });
        let stated = stated.filter(|_| times.bursty_steps.is_none());
        let other_rate = stated.map(|stated_hz| Case::RateMismatch { stated_hz, rate_hz });
        let missing = (missing_share > MISSING).then_some(Case::MissingSamples {
            samples: times.missing,
            percent: 100.0 * missing_share,
        });
        let of_all = [bursts, other_rate, missing].into_iter().flatten();
        findings.extend(of_all.map(Case::finding));
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
        ClockFault::Frozen => Case::FrozenTime.finding(),
        ClockFault::NoUnit(step) => {
            let unknown = Case::NoTimeUnit { step }.finding();
            unknown.advise("time_unit", "")
        }
        ClockFault::Unordered(backwards) => Case::UnorderedStamps { backwards, rows }.finding(),
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
    let first = first.clone();
    let unread = Case::StampsUnread { first }.finding();
    Some(match format.options.rate_hz.or(format.rate_hz) {
        Some(_) => unread,
        None => unread.advise("rate", ""),
    })
}

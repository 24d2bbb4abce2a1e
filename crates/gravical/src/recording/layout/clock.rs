//! Choice of the time column, by name and by values.

use super::Named;
use crate::recording::TimeUnit;
use crate::recording::names::{ColumnName, Quantity, is_foreign};
use crate::stats::median;

/// Smallest number of rows to recognise an unnamed clock.
const FEWEST_ROWS: usize = 10;

/// Largest unevenness of an unnamed clock: mean deviation of its steps from the usual one,
/// relative to it.
const MOST_UNEVEN: f64 = 0.3;

/// The time column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Clock {
    pub field: usize,
    /// It holds the time since the row before.
    pub is_steps: bool,
    /// It holds whole seconds; this field holds the fraction, in this unit, s.
    pub fraction: Option<(usize, f64)>,
}

/// Statistics of a column in the first rows.
struct Trend {
    /// Number of steps.
    steps: usize,
    /// Shares of positive and of negative steps.
    advancing: f64,
    backward: f64,
    /// Mean deviation of the positive steps from their median, relative to it; NaN without any.
    uneven: f64,
    /// All steps are 1.
    counts: bool,
    /// The usual step is 1 and all are whole: a counter with lost rows.
    counts_mostly: bool,
    /// No value is negative, and not all are zero.
    positive: bool,
}

impl Trend {
    fn of(sample: &[&Vec<f64>], field: usize) -> Option<Self> {
        let values: Vec<f64> = sample
            .iter()
            .filter_map(|row| row.get(field).copied())
            .filter(|v| v.is_finite())
            .collect();
        // A column that is empty in most rows is not the time.
        if values.len() * 2 < sample.len() {
            return None;
        }
        let all: Vec<f64> = values.windows(2).map(|w| w[1] - w[0]).collect();
        let mut up: Vec<f64> = all.iter().copied().filter(|d| *d > 0.0).collect();
        let steps = all.len();
        let share = |n: usize| n as f64 / steps.max(1) as f64;
        let down = all.iter().filter(|d| **d < 0.0).count();
        let (advancing, backward) = (share(up.len()), share(down));
        let usual = median(&mut up).unwrap_or(f64::NAN);
        // A gap counts as one deviating step, whatever its length.
        let off: f64 = up.iter().map(|d| (d - usual).abs().min(usual)).sum();
        Some(Trend {
            steps,
            advancing,
            backward,
            uneven: off / usual / up.len() as f64,
            counts: all.iter().all(|d| *d == 1.0),
            counts_mostly: usual == 1.0 && all.iter().all(|d| d.fract() == 0.0),
            positive: values.iter().all(|v| *v >= 0.0) && values.iter().any(|v| *v > 0.0),
        })
    }

    /// Plausible for a column that is named as a clock: stamps may repeat and sometimes run
    /// backwards.
    fn advances(&self) -> bool {
        self.advancing > 0.0 && self.backward <= 0.25
    }

    /// Only a clock behaves so.
    fn is_clock(&self) -> bool {
        self.steps + 1 >= FEWEST_ROWS
            && self.advancing >= 0.98
            && self.backward == 0.0
            && self.uneven <= MOST_UNEVEN
            && !self.counts_mostly
    }

    /// True if it advances in more rows, or in as many and twice as evenly.
    fn is_better_than(&self, other: &Trend) -> bool {
        let more = self.advancing - other.advancing;
        more > 0.05 || (more > -0.05 && other.uneven > 0.02 && self.uneven < 0.5 * other.uneven)
    }
}

/// Whether the first column of a file without a header rises as time does, and whether it is a
/// counter.
pub(super) fn first_column_rises(sample: &[Vec<f64>]) -> (bool, bool) {
    let rows: Vec<&Vec<f64>> = sample.iter().collect();
    match Trend::of(&rows, 0) {
        Some(c) if c.steps >= 3 => {
            // Whole seconds: steps of 1, and none negative.
            let seconds =
                c.advancing * c.steps as f64 >= 2.0 && c.backward == 0.0 && c.counts_mostly;
            let rises = seconds
                || c.advancing >= 0.1 && c.backward <= 0.1 && c.backward < 0.2 * c.advancing;
            (rises, rises && c.counts)
        }
        _ => (false, false),
    }
}

/// A time stamp in two fields: whole seconds, and the fraction in ms, µs or ns
/// (`header.stamp.sec` and `nanosec`). The fraction falls where the seconds rise, and rises
/// elsewhere; an independent clock and the duration of a loop do not.
fn in_two_fields(sample: &[&Vec<f64>], stamps: &[&Named]) -> Option<Clock> {
    let unit = |c: &ColumnName| c.unit.as_deref().and_then(TimeUnit::parse);
    let fits = |seconds: usize, below: usize, unit_s: f64| {
        let rows: Vec<[f64; 2]> = sample
            .iter()
            .filter_map(|row| Some([*row.get(seconds)?, *row.get(below)?]))
            .filter(|pair| pair.iter().all(|v| v.is_finite()))
            .collect();
        let (mut rising, mut within) = (0, 0);
        let turns = rows.windows(2).all(|w| {
            let [more, less] = [0, 1].map(|i| w[1][i] - w[0][i]);
            within += usize::from(more == 0.0);
            rising += usize::from(more == 0.0 && less > 0.0);
            more == 0.0 || less < 0.0
        });
        let parts = |[s, b]: &[f64; 2]| s.fract() == 0.0 && (0.0..1.0).contains(&(b * unit_s));
        turns && within > 0 && rising * 10 >= within * 9 && rows.iter().all(parts)
    };
    let seconds = stamps
        .iter()
        .filter(|(_, c)| matches!(unit(c), None | Some(TimeUnit::Second)));
    seconds
        .flat_map(|s| stamps.iter().map(move |b| (s, b)))
        .find_map(|((seconds, _), (below, c))| {
            let unit_s = unit(c)?.seconds();
            (unit_s < 1.0 && fits(*seconds, *below, unit_s)).then_some(Clock {
                field: *seconds,
                is_steps: false,
                fraction: Some((*below, unit_s)),
            })
        })
}

/// Chooses the time column among `columns`: the finest and most even of the named clocks that
/// advance, preferably of `sensor`; otherwise differences from row to row; otherwise an unnamed
/// column that rises steadily, if it is the only one; otherwise a named one that does not
/// advance.
pub(super) fn choose(
    sample: &[&Vec<f64>],
    columns: &[Named],
    names: &[String],
    sensor: &str,
) -> Option<Clock> {
    let of = |quantity: Quantity| {
        let mut fields: Vec<&Named> = columns
            .iter()
            .filter(|(_, c)| c.quantity == quantity)
            .collect();
        fields.sort_by_key(|(_, c)| sensor.is_empty() || c.sensor != sensor);
        fields
    };
    let stamps = of(Quantity::Time);
    if let Some(clock) = in_two_fields(sample, &stamps) {
        return Some(clock);
    }
    let mut best: Option<(usize, Trend)> = None;
    let own = stamps.iter().any(|(field, c)| {
        !sensor.is_empty()
            && c.sensor == sensor
            && Trend::of(sample, *field).is_some_and(|c| c.advances())
    });
    for (field, _) in stamps.iter().filter(|(_, c)| !own || c.sensor == sensor) {
        let Some(trend) = Trend::of(sample, *field).filter(Trend::advances) else {
            continue;
        };
        if best.as_ref().is_none_or(|(_, b)| trend.is_better_than(b)) {
            best = Some((*field, trend));
        }
    }
    let clock = |field, is_steps| {
        Some(Clock {
            field,
            is_steps,
            fraction: None,
        })
    };
    if let Some((field, _)) = best {
        return clock(field, false);
    }
    let stamps_decide = sample.is_empty() && !stamps.is_empty();
    for (field, _) in of(Quantity::TimeStep).iter().filter(|_| !stamps_decide) {
        let is_step = |c: &Trend| c.positive || sample.is_empty();
        if let Some(trend) = Trend::of(sample, *field).filter(is_step) {
            // A column named as a step may hold time stamps.
            return clock(*field, trend.advancing < 0.95);
        }
    }
    let taken = |field: usize| columns.iter().any(|(f, _)| *f == field);
    let others: Vec<usize> = (0..names.len())
        .filter(|&field| !taken(field) && !is_foreign(&names[field]))
        .filter(|&field| Trend::of(sample, field).is_some_and(|c| c.is_clock()))
        .collect();
    if let [only] = others[..] {
        return clock(only, false);
    }
    // Columns that are empty throughout are skipped; without rows the name decides.
    let filled = |field: usize| {
        let is_number = |row: &&Vec<f64>| row.get(field).is_some_and(|v| v.is_finite());
        sample.is_empty() || sample.iter().any(is_number)
    };
    let (field, _) = stamps.iter().find(|(field, _)| filled(*field))?;
    clock(*field, false)
}

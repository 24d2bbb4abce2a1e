//! The first rows of a recording, by which its unit and clock are judged.

use gravical_core::calibration::Calibration;

use crate::recording::dialect::{Dialect, terminator};
use crate::recording::layout::Layout;
use crate::recording::names::Quantity;
use crate::recording::row::{ACCEL, GYRO, SLOTS, TEMPERATURE, TIME, Values};
use crate::recording::timing::{Claims, Parts, Stamps, judge};
use crate::recording::{ReadOptions, hold_last_values, is_sparse, metadata};
use crate::scan::Lines;
use crate::stats::median;

use super::drift::Drift;

/// Channels of the head, in the unit of the file.
pub(crate) struct Head {
    pub accel: [Vec<f64>; 3],
    /// None without all three axes.
    pub gyro: Option<[Vec<f64>; 3]>,
    time: Vec<f64>,
    /// °C, by what the recording says; empty cells are NaN.
    pub temperature: Vec<f64>,
    temperature_span_c: f64,
    /// The recorder writes each channel when it arrives; the last values hold.
    pub accel_held: bool,
    /// The same for the gyroscope.
    pub gyro_held: bool,
    /// There is no more than this.
    pub whole: bool,
}

impl Head {
    /// Scans `bytes`; of a head that is not `whole` the last line is cut off
    /// and not used.
    pub fn read(bytes: &[u8], whole: bool, dialect: &Dialect, layout: &Layout) -> Self {
        let scanner = layout.scanner(dialect);
        let mut stamps = layout.stamps();
        let mut slots: [Vec<f64>; SLOTS] = Default::default();
        let mut values: Values = [f64::NAN; SLOTS];
        let mut lines = Lines::new(bytes).with_terminator(terminator(bytes));
        // Reading from memory does not fail.
        while let Ok(Some(line)) = lines.next_line() {
            if line.number < dialect.first_data_line || !(line.terminated || whole) {
                continue;
            }
            if scanner.scan(line.bytes, &mut values, &mut (0, 0)).is_ok() {
                stamps.stamp(&mut values);
                for (slot, value) in slots.iter_mut().zip(values) {
                    slot.push(value);
                }
            }
        }
        let (low, high) = slots[TEMPERATURE]
            .iter()
            .filter(|v| v.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
                (l.min(*v), h.max(*v))
            });
        let mut take = |slot: usize| std::mem::take(&mut slots[slot]);
        let time = match layout.field(Quantity::Time) {
            Some(_) => take(TIME),
            None => Vec::new(),
        };
        let mut accel = [take(ACCEL), take(ACCEL + 1), take(ACCEL + 2)];
        let mut gyro = layout
            .has_gyro()
            .then(|| [take(GYRO), take(GYRO + 1), take(GYRO + 2)]);
        Head {
            accel_held: hold_sparse(&mut accel),
            gyro_held: gyro.as_mut().is_some_and(hold_sparse),
            accel,
            gyro,
            temperature: std::mem::take(&mut slots[TEMPERATURE]),
            time,
            temperature_span_c: (high - low).max(0.0),
            whole,
        }
    }

    pub fn rows(&self) -> usize {
        self.accel[0].len()
    }

    /// The accelerometer, calibrated, its drift with temperature taken off.
    pub fn calibrated(
        &self,
        calibration: &Calibration<f64>,
        drift: Option<&Drift>,
    ) -> [Vec<f64>; 3] {
        let [x, y, z] = &self.accel;
        let mut out: [Vec<f64>; 3] = Default::default();
        for (((x, y), z), t_c) in x.iter().zip(y).zip(z).zip(&self.temperature) {
            let raw = [*x, *y, *z];
            let a = calibration.apply(drift.map_or(raw, |d| d.accel_at(raw, *t_c)));
            for (channel, value) in out.iter_mut().zip(a) {
                channel.push(value);
            }
        }
        out
    }

    /// Median of the steps of the raw stamps that advance; none without any.
    pub fn usual_step(&self) -> Option<f64> {
        let steps = self.time.windows(2).map(|w| w[1] - w[0]);
        median(&mut steps.filter(|step| *step > 0.0).collect::<Vec<f64>>())
    }

    /// What follows the stamps of the whole recording; none without stamps.
    pub fn stamps(
        &self,
        dialect: &Dialect,
        layout: &Layout,
        options: &ReadOptions,
    ) -> Option<Stamps> {
        if self.time.is_empty() {
            return None;
        }
        let claims = Claims {
            unit: options.time_unit.or(layout.time_claim),
            nominal_rate_hz: options
                .rate_hz
                .or_else(|| metadata::rate_hz(&dialect.metadata)),
            temperature_span_c: self.temperature_span_c,
        };
        let unit = judge(self.time.clone(), Parts::default(), &claims, |row| {
            row as u64
        })
        .timing
        .unit;
        Some(match (unit, self.usual_step()) {
            (Some(unit), Some(step)) => Stamps::new(step, unit.seconds()),
            _ => Stamps::new(f64::INFINITY, 1.0),
        })
    }
}

/// Rows below which nothing is held: a few empty cells are no habit.
const SPARSE_ROWS: usize = 20;

/// Holds the last values by the rule of reading, and says whether it applies.
fn hold_sparse(channels: &mut [Vec<f64>; 3]) -> bool {
    let sparse = channels[0].len() >= SPARSE_ROWS && is_sparse(channels);
    if sparse {
        hold_last_values(channels, f64::INFINITY);
    }
    sparse
}

//! What a person wants to see while it records.

use std::collections::VecDeque;

use serde::Serialize;

use super::item::Row;

/// Seconds that the rate is counted over.
const RATE_S: f64 = 3.0;
/// Seconds over which it has to lie still.
const STILL_S: f64 = 0.5;
/// Rows that are kept at most.
const KEPT: usize = 4096;
/// Spread of an axis over the magnitude, below which it lies still: 0.02 g, thrice the
/// noise of a bad MPU6050 without a low-pass, a tenth of what a hand does.
const STILL_SPREAD: f64 = 0.02;

/// One look at the stream. Values are in the board's own units.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Status {
    /// Rows a second over the last three, by the computer's clock.
    pub rate_hz: Option<f64>,
    /// Magnitude of the accelerometer, mean of the last half second.
    pub norm: Option<f64>,
    /// Temperature column of the last row.
    pub temperature: Option<f64>,
    /// Whether it lay still for the last half second.
    pub still: Option<bool>,
}

/// The last few seconds.
#[derive(Debug, Clone, Default)]
pub struct Live {
    rows: VecDeque<(f64, Row)>,
}

impl Live {
    /// A row that came at `now_s`.
    pub fn see(&mut self, now_s: f64, row: Row) {
        self.rows.push_back((now_s, row));
        while self.rows.len() > KEPT || self.rows.front().is_some_and(|(t, _)| now_s - t > RATE_S) {
            self.rows.pop_front();
        }
    }

    /// Seconds between two of them, by the computer's clock.
    pub fn step_s(&self) -> Option<f64> {
        let (first_s, last_s) = (self.rows.front()?.0, self.rows.back()?.0);
        (self.rows.len() > 1).then(|| (last_s - first_s) / (self.rows.len() - 1) as f64)
    }

    /// What they say at `now_s`.
    pub fn status(&self, now_s: f64) -> Status {
        let recent: Vec<&Row> = self
            .rows
            .iter()
            .filter(|(t, _)| now_s - t <= STILL_S)
            .map(|(_, row)| row)
            .collect();
        let (Some((first_s, _)), Some((last_s, last))) = (self.rows.front(), self.rows.back())
        else {
            return Status::default();
        };
        if recent.is_empty() {
            return Status::default();
        }
        let n = recent.len() as f64;
        let mean = |value: &dyn Fn(&Row) -> f64| recent.iter().map(|r| value(r)).sum::<f64>() / n;
        let norm = mean(&|r| (0..3).map(|k| r.values[k].powi(2)).sum::<f64>().sqrt());
        let spread = (0..3)
            .map(|k| {
                let middle = mean(&|r| r.values[k]);
                mean(&|r| (r.values[k] - middle).powi(2)).sqrt()
            })
            .fold(0.0, f64::max);
        Status {
            rate_hz: (last_s > first_s).then(|| (self.rows.len() - 1) as f64 / (last_s - first_s)),
            norm: Some(norm),
            temperature: Some(last.values[3]),
            still: (recent.len() >= 5).then_some(spread < STILL_SPREAD * norm),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn still_moving_and_silent() {
        let mut live = Live::default();
        assert_eq!(live.status(0.0), Status::default());
        let row = |x| Row {
            stamp: 0.0,
            values: [x, 0.0, 9.8, 25.5, 0.0, 0.0, 0.0],
            sequence: None,
        };
        for i in 0..500 {
            live.see(f64::from(i) * 0.01, row(0.02 * f64::from(i % 2)));
        }
        let status = live.status(5.0);
        assert!((status.rate_hz.unwrap() - 100.0).abs() < 0.5);
        assert!((status.norm.unwrap() - 9.8).abs() < 0.01);
        assert_eq!((status.still, status.temperature), (Some(true), Some(25.5)));
        for i in 500..560 {
            live.see(f64::from(i) * 0.01, row(3.0 * f64::from(i % 2)));
        }
        assert_eq!(live.status(5.6).still, Some(false));
        // Silence: what was is no status.
        assert_eq!(live.status(9.0), Status::default());
    }
}

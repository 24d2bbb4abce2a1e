//! Integers of 16 bits that were printed as unsigned.

use std::fmt;

use serde::Serialize;

/// How numbers of the converter were written.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Encoding {
    /// 65535 is −1
    TwosComplement,
    /// 32768 is 0
    OffsetBinary,
}

impl fmt::Display for Encoding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Encoding::TwosComplement => "65535 is -1",
            Encoding::OffsetBinary => "32768 is 0",
        })
    }
}

impl Encoding {
    /// The encoding that the accelerometer shows, if any.
    pub fn of(accel: [&[f64]; 3]) -> Option<Self> {
        if !accel.iter().all(|c| are_unsigned(c)) {
            return None;
        }
        let share_is = |low: f64, high: f64, is: fn(f64) -> bool| {
            accel.iter().all(|c| is(share_within(c, low, high)))
        };
        let has_high = accel.iter().any(|c| c.iter().any(|v| *v >= 45_056.0));
        // Between ±1.25 g of a range of 2 g nothing lies beyond 20,480.
        if has_high && share_is(20_480.0, 45_056.0, |share| share < 0.02) {
            return Some(Encoding::TwosComplement);
        }
        share_is(12_288.0, 53_248.0, |share| share > 0.5).then_some(Encoding::OffsetBinary)
    }

    /// The numbers that were written.
    pub fn undo(self, values: &mut [f64]) {
        let (from, zero) = match self {
            Encoding::TwosComplement => (32_768.0, 65_536.0),
            Encoding::OffsetBinary => (f64::NEG_INFINITY, 32_768.0),
        };
        let written = values.iter_mut().filter(|v| **v >= from);
        written.for_each(|v| *v -= zero);
    }
}

/// Whether all numbers may be unsigned integers of 16 bits.
pub fn are_unsigned(channel: &[f64]) -> bool {
    let mut values = channel.iter().filter(|v| !v.is_nan());
    values.all(|v| v.fract() == 0.0 && (0.0..65_536.0).contains(v))
}

fn share_within(column: &[f64], low: f64, high: f64) -> f64 {
    let within = column.iter().filter(|v| (low..high).contains(*v)).count();
    let known = column.iter().filter(|v| !v.is_nan()).count();
    within as f64 / known as f64
}

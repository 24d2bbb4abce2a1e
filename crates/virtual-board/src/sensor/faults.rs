//! What goes wrong, and when.

use std::str::FromStr;

use gravical::{Error, Result};

/// One thing that can go wrong with the sensor or the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FaultKind {
    /// The sensor does not answer: a wire is off.
    NoAnswer,
    /// The data line is held low: no transfer ends.
    StuckBus,
    /// One axis of the accelerometer (0 to 2) keeps its last value.
    Frozen(usize),
    /// `WHO_AM_I` reads this.
    Identity(u8),
    /// The sensor's supply dips at the start: all registers as after power-up,
    /// asleep.
    Dip,
    /// The program stops going on at the start.
    Hang,
}

/// A fault from one moment to another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fault {
    /// What.
    pub kind: FaultKind,
    /// From when on, s after the start.
    pub start_s: f64,
    /// Until when, s; infinite where it stays. Of no meaning for a dip and a hang.
    pub end_s: f64,
}

/// Faults on a schedule.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Faults(pub Vec<Fault>);

impl Faults {
    /// Whether a fault that `is` picks lasts at `time_s`.
    pub fn now<T>(&self, time_s: f64, is: impl Fn(FaultKind) -> Option<T>) -> Option<T> {
        self.0
            .iter()
            .filter(|f| f.start_s <= time_s && time_s < f.end_s)
            .find_map(|f| is(f.kind))
    }

    /// Whether `kind` begins in `from_s < start ≤ to_s`.
    #[must_use]
    pub fn begins(&self, kind: FaultKind, from_s: f64, to_s: f64) -> bool {
        self.0
            .iter()
            .any(|f| f.kind == kind && from_s < f.start_s && f.start_s <= to_s)
    }
}

impl FromStr for Faults {
    type Err = Error;

    /// `WHAT@START[-END]`, parted by commas, in seconds: `no-answer@5-8`,
    /// `stuck-bus@12-13`, `frozen-x@20-25`, `who-am-i=0x70@30-33`, `dip@40`,
    /// `hang@50`.
    fn from_str(text: &str) -> Result<Self> {
        text.split(',')
            .filter(|part| !part.trim().is_empty())
            .map(|part| {
                one(part.trim()).ok_or_else(|| {
                    Error::usage("usage", format!("`{part}` is no fault")).with_hint(
                        "WHAT@START[-END] in seconds; WHAT is no-answer, stuck-bus, \
                         frozen-x, frozen-y, frozen-z, who-am-i=0x70, dip or hang",
                    )
                })
            })
            .collect::<Result<_>>()
            .map(Faults)
    }
}

fn one(text: &str) -> Option<Fault> {
    let (what, when) = text.split_once('@')?;
    let kind = match what {
        "no-answer" => FaultKind::NoAnswer,
        "stuck-bus" => FaultKind::StuckBus,
        "frozen-x" => FaultKind::Frozen(0),
        "frozen-y" => FaultKind::Frozen(1),
        "frozen-z" => FaultKind::Frozen(2),
        "dip" => FaultKind::Dip,
        "hang" => FaultKind::Hang,
        other => {
            let digits = other.strip_prefix("who-am-i=0x")?;
            FaultKind::Identity(u8::from_str_radix(digits, 16).ok()?)
        }
    };
    let (start, end) = match when.split_once('-') {
        Some((start, end)) => (start, Some(end)),
        None => (when, None),
    };
    let start_s: f64 = start.parse().ok()?;
    let end_s = end.map_or(Some(f64::INFINITY), |e| e.parse().ok())?;
    (start_s >= 0.0 && end_s > start_s).then_some(Fault {
        kind,
        start_s,
        end_s,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_schedule() {
        let faults: Faults = "no-answer@5-8, frozen-y@1,who-am-i=0x70@2-3,dip@4"
            .parse()
            .unwrap();
        assert_eq!(faults.0.len(), 4);
        let frozen = |t| {
            faults.now(t, |k| match k {
                FaultKind::Frozen(axis) => Some(axis),
                _ => None,
            })
        };
        assert_eq!(
            (frozen(0.9), frozen(1.0), frozen(1e9)),
            (None, Some(1), Some(1))
        );
        let silent = |t| faults.now(t, |k| (k == FaultKind::NoAnswer).then_some(()));
        assert_eq!(
            (silent(4.9), silent(5.0), silent(8.0)),
            (None, Some(()), None)
        );
        assert!(faults.begins(FaultKind::Dip, 3.9, 4.0));
        assert!(!faults.begins(FaultKind::Dip, 4.0, 4.1));
        assert_eq!("".parse::<Faults>().unwrap(), Faults::default());
    }

    #[test]
    fn no_schedule() {
        for text in [
            "x",
            "no-answer",
            "no-answer@",
            "no-answer@-1",
            "no-answer@3-2",
            "no-answer@nan",
            "frozen-w@1",
            "who-am-i@1",
            "who-am-i=0x170@1",
            "dip@1-x",
        ] {
            assert!(text.parse::<Faults>().is_err(), "{text}");
        }
    }
}

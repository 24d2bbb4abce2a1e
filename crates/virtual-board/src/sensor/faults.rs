//! What goes wrong, and when.

use std::ops::Range;
use std::str::FromStr;

use gravical::{Error, Result};

/// One thing that can go wrong with the sensor or the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FaultKind {
    /// The sensor does not answer: a wire is off.
    NoAnswer,
    /// The data line is held low: no transfer ends.
    StuckBus,
    /// `WHO_AM_I` reads this.
    Identity(u8),
    /// The sensor's supply dips at the start: all registers as after power-up,
    /// asleep.
    Dip,
    /// The program stops going on at the start.
    Hang,
}

/// Faults on a schedule, s after the start. The end of a dip or a hang has no meaning.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Faults(Vec<(FaultKind, Range<f64>)>);

impl Faults {
    /// The faults that last at `time_s`.
    pub fn at(&self, time_s: f64) -> impl Iterator<Item = FaultKind> {
        let faults = self.0.iter();
        faults
            .filter(move |(_, span)| span.contains(&time_s))
            .map(|(kind, _)| *kind)
    }

    /// Whether `kind` begins in `from_s < start ≤ to_s`.
    #[must_use]
    pub fn begins(&self, kind: FaultKind, from_s: f64, to_s: f64) -> bool {
        let starts_in = |span: &Range<f64>| from_s < span.start && span.start <= to_s;
        self.0.iter().any(|(k, span)| *k == kind && starts_in(span))
    }
}

impl FromStr for Faults {
    type Err = Error;

    /// `WHAT@START[-END]`, separated by commas, in seconds: `no-answer@5-8`,
    /// `stuck-bus@12-13`, `who-am-i=0x70@30-33`, `dip@40`, `hang@50`.
    fn from_str(text: &str) -> Result<Self> {
        let parts = text.split(',').map(str::trim).filter(|p| !p.is_empty());
        let faults = parts.map(|part| {
            parse_fault(part).ok_or_else(|| {
                Error::usage("usage", format!("`{part}` is no fault")).with_hint(
                    "WHAT@START[-END] in seconds; WHAT is no-answer, stuck-bus, \
                     who-am-i=0x70, dip or hang",
                )
            })
        });
        faults.collect::<Result<_>>().map(Faults)
    }
}

fn parse_fault(text: &str) -> Option<(FaultKind, Range<f64>)> {
    let (what, when) = text.split_once('@')?;
    let kind = match what {
        "no-answer" => FaultKind::NoAnswer,
        "stuck-bus" => FaultKind::StuckBus,
        "dip" => FaultKind::Dip,
        "hang" => FaultKind::Hang,
        other => {
            let digits = other.strip_prefix("who-am-i=0x")?;
            FaultKind::Identity(u8::from_str_radix(digits, 16).ok()?)
        }
    };
    let (start, end) = when.split_once('-').unwrap_or((when, "inf"));
    let span: Range<f64> = start.parse().ok()?..end.parse().ok()?;
    (span.start >= 0.0 && span.end > span.start).then_some((kind, span))
}

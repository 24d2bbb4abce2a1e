//! Named gaps of a recording.

/// Beginning of the line in which missing rows are reported: after it the clock of the board may
/// have restarted.
const GAP_LINE: &str = "# gap:";
use serde::Serialize;

/// Why rows are missing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Cause {
    /// The port was lost: a cable was pulled, a hub was suspended.
    Unplugged,
    /// The board restarted.
    Reset,
    /// The board lost its sensor and set it up again.
    Sensor,
    /// The board had other settings until they were restored.
    Settings,
    /// The board sent no rows.
    Silent,
    /// The board's clock jumped for no other known cause.
    Lost,
    /// The disk took no rows.
    DiskFull,
    /// The recording had ended and was continued.
    Continued,
}

impl Cause {
    /// For messages and for the file.
    pub fn text(self) -> &'static str {
        match self {
            Cause::Unplugged => "unplugged",
            Cause::Reset => "the board was reset",
            Cause::Sensor => "the sensor was set up again",
            Cause::Settings => "the board had other settings",
            Cause::Silent => "the board sent no rows",
            Cause::Lost => "rows were lost on the way from the board",
            Cause::DiskFull => "the disk was full",
            Cause::Continued => "the recording was ended and continued",
        }
    }
}

/// Rows that are missing, why, and how many.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Gap {
    /// The first cause.
    pub cause: Cause,
    /// Rows that are known to be missing, by the board's clock or because they arrived and
    /// could not be stored.
    pub rows: u64,
    /// The board's clock restarted meanwhile: more may be missing.
    pub clock_anew: bool,
    /// No row arrived after it: the number of missing rows is not known.
    pub until_end: bool,
    /// The computer's time from the last row before it to the first one after it, s.
    pub duration_s: f64,
}

impl Gap {
    /// A gap of which only the cause is known.
    pub fn new(cause: Cause) -> Self {
        Gap {
            cause,
            rows: 0,
            clock_anew: false,
            until_end: false,
            duration_s: 0.0,
        }
    }

    /// Rows are missing in it, or may be. Rows before a continuation are not part of this
    /// recording.
    pub fn is_incomplete(&self) -> bool {
        let unknown = self.clock_anew || self.until_end;
        self.rows > 0 || (unknown && self.cause != Cause::Continued)
    }

    /// The line of the recording, with its line break.
    pub fn line(&self) -> String {
        let rows = match (self.rows, self.clock_anew) {
            _ if self.until_end => "no row arrived until the end".to_owned(),
            _ if self.cause == Cause::Continued => "the time between is not recorded".to_owned(),
            (0, true) => "an unknown number of rows is missing".to_owned(),
            (n, true) => format!("{n} rows are missing, or more"),
            (n, false) => format!("{n} rows are missing"),
        };
        let clock = if self.clock_anew {
            ", the clock of the board restarts"
        } else {
            ""
        };
        // The end of the earlier part is not known here.
        let time = if self.cause == Cause::Continued {
            String::new()
        } else {
            format!(", {:.1} s", self.duration_s)
        };
        format!("{GAP_LINE} {}: {rows}{time}{clock}\n", self.cause.text())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_name_cause_rows_and_time() {
        let mut gap = Gap {
            rows: 320,
            duration_s: 3.21,
            ..Gap::new(Cause::Unplugged)
        };
        assert_eq!(
            gap.line(),
            "# gap: unplugged: 320 rows are missing, 3.2 s\n"
        );
        gap.clock_anew = true;
        gap.rows = 0;
        gap.cause = Cause::Continued;
        assert_eq!(
            gap.line(),
            "# gap: the recording was ended and continued: the time between is not recorded, the clock of the board restarts\n"
        );
    }
}

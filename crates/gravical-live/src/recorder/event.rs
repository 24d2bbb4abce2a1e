//! Events of a recording, for scripts and in words.

use gravical_calibrate::poses::face::Face;
use gravical_core::matrix3::norm;
use gravical_judge::units::AccelScale;
use gravical_recording::Recording;
use serde::Serialize;

use super::gaps::Gap;

/// Magnitude and direction are means over this time, s.
const RECENT_S: f64 = 0.5;
/// Columns of the status line.
const MAX_COLUMNS: usize = 79;

/// One event. As JSON an object a line with its `type`.
#[derive(Debug, Clone, Serialize)]
#[serde(tag = "type", rename_all = "kebab-case")]
pub enum Event {
    /// Something is waited for.
    Waiting {
        /// What.
        text: String,
    },
    /// A port is open; most boards reset on that.
    Opened {
        /// Its name.
        port: String,
        /// The device behind it, if it has a name.
        device: Option<String>,
    },
    /// A message of the board.
    Board {
        /// A line that begins with `#`.
        text: String,
    },
    /// The first row is in the file.
    Started {
        /// What its columns hold.
        columns: String,
    },
    /// The state of the recording, once a second.
    Status(Status),
    /// Rows are not stored.
    Paused,
    /// The recording continues.
    Resumed,
    /// A line is no row. Reported of the 1st, 2nd, 4th, 8th …
    Rejected {
        /// How many so far.
        count: u64,
        /// The last one, shortened.
        line: String,
    },
    /// Rows are missing; the gap is named in the file.
    Gap(Gap),
    /// Something to do, or to know.
    Warning {
        /// The sentence.
        text: String,
    },
    /// The port is lost.
    Lost {
        /// What the system says.
        text: String,
    },
    /// The board sends nothing.
    Silent {
        /// For so long, s.
        duration_s: f64,
    },
}

/// How many lines went where.
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub struct Counts {
    /// Rows in the file.
    pub rows: u64,
    /// Lines that are no rows: `# rejected:` in the file.
    pub rejected: u64,
    /// Rows that are missing by the clock of the board, in gaps.
    pub missing: u64,
    /// Gaps that the file names.
    pub gaps: u64,
}

/// Why it ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum End {
    /// All rows that were asked for are stored.
    Rows,
    /// The time that was asked for has passed.
    Duration,
    /// The user ended it.
    User,
}

impl Event {
    /// The message for people, a warning with `!` before it; none where it needs none.
    pub fn words(&self, keyboard: bool) -> Option<String> {
        Some(match self {
            Event::Opened { port, device } => {
                let device = device.as_deref().unwrap_or("open");
                format!("{port}: {device}; waiting for the board (opening its port may reset it)")
            }
            Event::Waiting { text } | Event::Board { text } => text.clone(),
            Event::Started { .. } if keyboard => {
                "recording; space pauses, q or Ctrl-C ends".to_owned()
            }
            Event::Started { .. } | Event::Resumed => "recording".to_owned(),
            Event::Paused => "paused; space resumes".to_owned(),
            Event::Warning { text } => format!("! {text}"),
            Event::Rejected { count: 1, line } => format!("! a line is no row: {line:?}"),
            Event::Rejected { count, line } => {
                format!("! {count} lines so far are no rows; the last of them: {line:?}")
            }
            Event::Gap(gap) => format!("! {}", gap.line().trim_start_matches("# ")),
            Event::Lost { text } => format!(
                "! the port is lost ({text}); plug the board in again, the recording resumes by itself"
            ),
            Event::Silent { duration_s } => {
                format!("! the board has sent nothing for {duration_s:.0} s")
            }
            Event::Status(_) => return None,
        })
    }
}

/// The recording at one moment.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Status {
    /// Rows stored.
    pub rows: u64,
    /// Since the first row, without pauses, s.
    pub elapsed_s: f64,
    /// Rows are not stored.
    pub paused: bool,
    /// Lines rejected so far.
    pub rejected: u64,
    /// Rows a second, by their stamps.
    pub rate_hz: Option<f64>,
    /// Magnitude of the mean acceleration of the last half second, in the unit of the file.
    pub norm: Option<f64>,
    /// Scale of the accelerometer.
    #[serde(skip)]
    pub accel: Option<AccelScale>,
    /// Temperature of the sensor, °C.
    pub temperature_c: Option<f64>,
    /// The face that is nearest to up: `+x`.
    pub up: Option<String>,
}

impl Status {
    /// Adds what the last rows say.
    pub fn observe(&mut self, recording: &Recording) {
        self.rate_hz = recording.clock.rate_hz();
        let rows = (RECENT_S * self.rate_hz.unwrap_or(1.0)).ceil().max(1.0);
        let mean = recording.accel.each_ref().map(|axis| {
            let recent = axis.iter().rev().take(rows as usize).copied();
            let recent: Vec<f64> = recent.filter(|v| v.is_finite()).collect();
            recent.iter().sum::<f64>() / recent.len() as f64
        });
        self.norm = Some(norm(&mean)).filter(|norm| norm.is_finite());
        self.up = self.norm.map(|_| Face::nearest(mean).0.name());
        self.accel = Some(recording.units.accel);
        let temperatures = recording.temperature_c.iter().flatten();
        self.temperature_c = temperatures.copied().rfind(|t| t.is_finite());
    }

    /// One line of at most 79 columns: what is needed most comes first, and the rest where there is
    /// room.
    pub fn line(&self) -> String {
        let mut parts = vec![
            format!("{:.1} s", self.elapsed_s),
            format!("{} rows", self.rows),
        ];
        parts.extend(self.paused.then(|| "PAUSED".to_owned()));
        parts.extend(self.rate_hz.map(|rate| format!("{rate:.1} Hz")));
        parts.extend(self.norm.map(|norm| {
            // In m/s², or as it stands in a file of unknown unit.
            match self.accel.and_then(|accel| accel.nominal()) {
                Some(per_mps2) => format!("‖a‖ {:.2} m/s²", norm / per_mps2),
                None => format!("‖a‖ {norm:.2}"),
            }
        }));
        parts.extend(self.up.as_ref().map(|up| format!("up: {up}")));
        parts.extend((self.rejected > 0).then(|| format!("{} rejected", self.rejected)));
        parts.extend(self.temperature_c.map(|t| format!("{t:.1} °C")));
        while parts.join("  ").chars().count() > MAX_COLUMNS && parts.pop().is_some() {}
        parts.join("  ")
    }
}

//! Events and commands of a guided calibration, as JSON.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use gravical_calibrate::calibration_file::Grade;
use gravical_calibrate::gravity::Gravity;
use gravical_calibrate::recording::{AccelUnit, GyroUnit};
use gravical_judge::Result;

use crate::problem::Problem;
use crate::words::{face_of, sentence};

/// Version of the events. From the first release on types and fields are only added to it.
pub const EVENTS_VERSION: u32 = 1;

/// An event with its time: one JSON object.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Message {
    /// [`EVENTS_VERSION`].
    pub v: u32,
    /// Seconds since the first row, by the clock of the recording.
    pub t_s: f64,
    /// The event in words: whole sentences, for page and terminal.
    pub text: String,
    /// What happened.
    #[serde(flatten)]
    pub event: Event,
}

/// What happened. Directions are unit vectors of specific force at rest, in the axes of the
/// sensor; faces have the names `+x` … `-z`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum Event {
    /// Which port is the board is not clear, it cannot be opened, or no row arrives: the user chooses.
    /// Before the session.
    Ports {
        /// The ports of this computer, boards first.
        ports: Vec<PortInfo>,
        /// The one that was opened, or could not be.
        tried: Option<String>,
        /// Commands that flash our sketch, where the board sends no rows.
        flash: Vec<String>,
        /// A simulated sensor can take the place of the board.
        simulate: bool,
    },
    /// A port is open; no row has arrived yet. Before the session.
    Connecting {
        /// The port.
        name: String,
    },
    /// The session begins.
    Session {
        /// Where the rows come from.
        source: SourceKind,
        /// Port, file or sensor.
        name: String,
        /// Folder of the session.
        folder: Option<String>,
        /// Local gravity: with the source `standard` it has to be asked for.
        #[serde(flatten)]
        gravity: Gravity,
    },
    /// Columns, clock and units as far as the first second shows them.
    Identified {
        /// Sampling rate, Hz.
        rate_hz: Option<f64>,
        /// Unit of the accelerometer.
        unit: AccelUnit,
        /// Unit of the gyroscope; null without one.
        gyro_unit: Option<GyroUnit>,
    },
    /// The noise at rest is known.
    Floor,
    /// The state, ten times a second.
    Status(Box<Status>),
    /// A pose was accepted; it is safe when this is shown.
    PoseAccepted(Pose),
    /// A hold was not accepted. Poses before it are untouched.
    PoseRejected {
        /// The reason.
        reason: Rejection,
    },
    /// A pose no longer counts.
    PoseUndone {
        /// Its number.
        pose: u32,
        /// Its face.
        face: Option<String>,
    },
    /// What is wanted next.
    NextPose {
        /// A face, a free pose, or nothing.
        kind: Wanted,
        /// The faces of which any is wanted.
        faces: Vec<String>,
        /// The direction of the free pose.
        up: Option<[f64; 3]>,
        /// How to hold the sensor.
        hint: Option<String>,
    },
    /// The calibration from the poses so far.
    Fit {
        /// Bias, mg.
        bias_mg: [f64; 3],
        /// Predicted error of ‖a‖ in the worst direction, 95 %, mg.
        worst_mg: Option<f64>,
        /// Leave-one-out error of ‖a‖, rms, mg.
        leave_one_out_mg: Option<f64>,
        /// What an undetected error of one pose could change ‖a‖ by, mg.
        undetected_mg: Option<f64>,
        /// Number of poses.
        poses: u32,
    },
    /// The grade changed, or the session ends.
    Verdict {
        /// The grade.
        grade: Grade,
        /// The session ends with it.
        r#final: bool,
        /// Reasons.
        reasons: Vec<String>,
    },
    /// Gravity was given; with the source `standard` it has to be asked for.
    Gravity(Gravity),
    /// Something to know; a command that cannot be done now.
    Warning,
    /// The calibration is on the disk.
    Saved {
        /// The file.
        file: String,
        /// The folder of the session.
        folder: Option<String>,
        /// The calibration report, where it was written.
        report: Option<String>,
        /// Commands to go on with.
        next: Vec<String>,
    },
    /// No rows arrive.
    Lost {
        /// Why.
        why: Loss,
        /// Poses that are safe.
        poses: u32,
    },
    /// Rows arrive again.
    Resumed {
        /// Poses that are kept.
        poses: u32,
    },
    /// The true error of a simulated sensor.
    Truth {
        /// Error of ‖a‖ with the calibration, rms over all directions, mg.
        norm_error_mg: f64,
        /// The same without.
        before_mg: f64,
    },
    /// The last event.
    End {
        /// Why.
        reason: EndReason,
        /// Number of poses.
        poses: u32,
        /// The command that goes on.
        resume: Option<String>,
    },
}

impl Message {
    /// An event, and its sentences: `text` with a capital letter, a mark at its end, and minus signs.
    pub fn new(t_s: f64, event: Event, text: &str) -> Self {
        Message {
            v: EVENTS_VERSION,
            t_s: (t_s * 1e3).round() / 1e3,
            text: sentence(text),
            event,
        }
    }

    /// Whether it belongs to the journal: all but the status, and what precedes the first row.
    pub fn is_recorded(&self) -> bool {
        let is_passing = matches!(
            self.event,
            Event::Status(_) | Event::Connecting { .. } | Event::Ports { .. }
        );
        !is_passing
    }

    /// One line of JSON, without its end.
    pub fn to_json(&self) -> String {
        // Names and numbers are always JSON.
        serde_json::to_string(self).unwrap_or_default()
    }
}

/// A port that can be chosen.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct PortInfo {
    /// Its name, by which it is chosen.
    pub name: String,
    /// The device behind it.
    pub device: Option<String>,
    /// Vendor and product of its USB device, as `2341:0043`.
    pub usb: Option<String>,
    /// Serial number of the device.
    pub serial: Option<String>,
    /// It has the vendor of a known board.
    pub board: bool,
}

/// Where rows come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SourceKind {
    /// A serial port.
    Port,
    /// A recording.
    Replay,
    /// A simulated sensor.
    Simulate,
}

/// State of the session.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum State {
    /// Columns, rate and units are determined.
    Identify,
    /// The noise at rest is measured.
    Floor,
    /// The sensor moves, or its pose is done.
    Wait,
    /// The pose is measured.
    Capture,
    /// The session has ended.
    Done,
    /// No rows arrive.
    Lost,
}

/// State of a face.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Tile {
    /// Not recorded yet.
    ToDo,
    /// Being measured.
    Capturing,
    /// Recorded.
    Done,
    /// To be recorded again: the user wants it, or it contradicts the other poses.
    Redo,
}

/// What a renderer needs continuously.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Status {
    /// State of the session.
    pub state: State,
    /// After five seconds without progress: which test fails, and by how much.
    pub hint: Option<String>,
    /// Direction of specific force.
    pub up: [f64; 3],
    /// Magnitude of specific force over gravity, mean of the last 0.2 s.
    pub norm_g: f64,
    /// Scatter of the last block, three axes together, mg.
    pub noise_mg: f64,
    /// The largest of a quiet block, mg.
    pub limit_mg: Option<f64>,
    /// The sensor rests.
    pub still: bool,
    /// Progress of the state, 0 to 1.
    pub ring: f64,
    /// The nearest face.
    pub face: String,
    /// Angle to it, degrees.
    pub tilt_deg: f64,
    /// Sampling rate, Hz.
    pub rate_hz: f64,
    /// Temperature, °C.
    pub temperature_c: Option<f64>,
    /// The six faces.
    pub tiles: BTreeMap<String, Tile>,
}

/// An accepted pose.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Its number, which is never used again.
    pub pose: u32,
    /// The face that is up; null for a free pose.
    pub face: Option<String>,
    /// Direction of specific force.
    pub up: [f64; 3],
    /// Angle to the nearest face, degrees.
    pub tilt_deg: f64,
    /// Mean reading, in the unit of the recording.
    pub mean: [f64; 3],
    /// Its length by the nominal scale, m/s².
    pub norm_mps2: f64,
    /// Standard deviation of a sample, three axes together, mg.
    pub noise_mg: f64,
    /// Mean temperature, °C.
    pub temperature_c: Option<f64>,
    /// Length, s.
    pub seconds: f64,
    /// Its first and last line in the recording.
    pub lines: [u32; 2],
}

/// Why a hold is not accepted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rejection {
    /// It moved during the capture.
    Moved,
    /// The pose exists.
    Duplicate,
    /// No axis is vertical, and faces are wanted.
    BetweenFaces,
    /// Samples at the end of the range.
    Clipped,
    /// The unit is unknown, or changed.
    Units,
    /// The rows were interrupted.
    Gaps,
    /// The temperature is too far from that of the first pose.
    Temperature,
    /// The magnitude is far from gravity.
    Scale,
}

/// What is wanted next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Wanted {
    /// One of several faces.
    Face,
    /// A free pose.
    Free,
    /// Nothing: the result is good.
    None,
}

/// Why no rows arrive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Loss {
    /// The port is gone.
    Unplugged,
    /// The board sends nothing.
    Silent,
}

/// Why a session ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum EndReason {
    /// It was finished.
    Finished,
    /// It was interrupted, and can be resumed.
    Interrupted,
    /// The user ended it without a calibration; it can be resumed.
    Cancelled,
    /// There are no more rows.
    SourceEnded,
    /// It failed.
    Failed,
}

/// What the user wants.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "command", rename_all = "kebab-case")]
pub enum Command {
    /// Open this port; before the session.
    Port {
        /// One of those in the event `ports`.
        name: String,
    },
    /// Begin with a simulated sensor in place of a board; before the session.
    Simulate,
    /// Take the pose that is held now, even if it exists, lies between faces or is warmer.
    Capture,
    /// Undo the last pose.
    Undo,
    /// Record a face again.
    Redo {
        /// The face, as `+x`.
        face: String,
    },
    /// Calculate, save, end.
    Finish,
    /// End without a calibration; what was recorded stays.
    Cancel,
    /// Go on with the session that was saved.
    Resume,
    /// Local gravity: the value, or the latitude, at sea level.
    Gravity {
        /// m/s².
        value: Option<f64>,
        /// Degrees.
        latitude: Option<f64>,
    },
    /// Moves a simulated sensor; without anything else to the direction that is asked for.
    Hand {
        /// Lay it down with this face up.
        put: Option<String>,
        /// Hold it with this direction up.
        up: Option<[f64; 3]>,
        /// Push it.
        #[serde(default)]
        shake: bool,
    },
}

impl Command {
    /// A command that was typed: `port NAME`, `simulate`, `undo`, `redo +x`, `take`, `latitude 48.1`, `gravity 9.81`,
    /// `stop`, `cancel`; for a simulated sensor also `+x`, `0.6 0.6 0.5`, `shake`.
    ///
    /// # Errors
    ///
    /// `command-unknown` (usage) with those that exist.
    pub fn parse(text: &str) -> Result<Self> {
        let words: Vec<&str> = text.split_whitespace().collect();
        let number = |word: &str| word.replace(',', ".").parse::<f64>().ok();
        let gravity = |value, latitude| Command::Gravity { value, latitude };
        let hand = |put, up, shake| Command::Hand { put, up, shake };
        let command = || {
            Some(match words[..] {
                ["port", name] => Command::Port { name: name.into() },
                ["simulate"] => Command::Simulate,
                ["u" | "undo"] => Command::Undo,
                ["take" | "capture"] => Command::Capture,
                ["stop" | "finish" | "save" | "q"] => Command::Finish,
                ["cancel"] => Command::Cancel,
                ["r" | "redo", face] => Command::Redo { face: face.into() },
                ["gravity", value] => gravity(Some(number(value)?), None),
                ["latitude", value] => gravity(None, Some(number(value)?)),
                ["shake"] => hand(None, None, true),
                ["free"] => hand(None, None, false),
                [face] => hand(Some(face_of(face)?.name()), None, false),
                [x, y, z] => hand(None, Some([number(x)?, number(y)?, number(z)?]), false),
                _ => return None,
            })
        };
        command().ok_or_else(|| {
            let text = text.trim().to_owned();
            Problem::NoCommand { text }.error()
        })
    }
}

//! A simulated sensor in a hand that follows the events of a session.

use gravical_calibrate::calibration_file::{Calibration, Grade};
use gravical_calibrate::poses::face::Face;
use gravical_core::matrix3;
use gravical_fit::model::sphere;
use gravical_live::event::{Event, Message, Rejection, Wanted};
use gravical_live::{Command, LiveOptions, Session};
use gravical_sim::{InteractiveSensor, LineOptions, Reading, SensorOptions, SimulateOptions};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

/// Time of a turn, until the hand is off, s.
const TURN_S: f64 = 4.0;
/// … of which the sensor moves for this, s.
const CARRIED_S: f64 = 1.8;
/// A hold that is neither accepted nor rejected is given up, s.
const PATIENCE_S: f64 = 8.0;
/// Free poses until the user is content with what there is.
const MAX_FREE: u32 = 9;
/// A free pose is off what was asked for by this, standard deviation of each component.
const FREE_OFF: f64 = 0.12;
/// Decimals of a row.
const DECIMALS: usize = 4;
/// No session is longer, s.
const MAX_S: f64 = 600.0;

/// What goes wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Clumsiness {
    None,
    /// One capture in three is bumped.
    Bumps,
    /// One turn in three ends on a face that is not the one wanted.
    WrongSides,
    /// The part warms by 2.5 °C, and its bias drifts.
    Warming,
    /// A row in fifty is lost, and once 3 s of rows in a row.
    LostRows,
    /// Faces on a bad table: 4° of tilt.
    Tilted,
}

impl Clumsiness {
    pub const ALL: [Clumsiness; 6] = [
        Clumsiness::None,
        Clumsiness::Bumps,
        Clumsiness::WrongSides,
        Clumsiness::Warming,
        Clumsiness::LostRows,
        Clumsiness::Tilted,
    ];
}

/// The end of a session.
pub struct Ended {
    pub file: Option<Calibration>,
    pub messages: Vec<Message>,
    /// Time at which the grade became good, s.
    pub good_s: Option<f64>,
    /// The recording.
    pub text: String,
    pub sensor: InteractiveSensor,
}

/// A session of a sensor with this seed, by a hand that follows what is asked for.
pub struct Hand {
    rng: ChaCha8Rng,
    sensor: InteractiveSensor,
    session: Session,
    clumsiness: Clumsiness,
    rate_hz: f64,
    now_s: f64,
    text: String,
    messages: Vec<Message>,
}

impl Hand {
    pub fn new(seed: u64, clumsiness: Clumsiness) -> Self {
        Self::at_rate(seed, clumsiness, 100.0)
    }

    pub fn at_rate(seed: u64, clumsiness: Clumsiness, rate_hz: f64) -> Self {
        let [warms, tilts] = [Clumsiness::Warming, Clumsiness::Tilted].map(|c| c == clumsiness);
        let sensor = SensorOptions {
            temperature_rise_c: if warms { 2.5 } else { 0.3 },
            temperature_time_s: 60.0,
            ..SensorOptions::default()
        };
        let options = SimulateOptions {
            seed,
            rate_hz,
            tilt_sd_deg: if tilts { 4.0 } else { 1.0 },
            sensor,
            ..SimulateOptions::default()
        };
        let gravity = gravical_calibrate::gravity::Gravity::given(options.gravity_mps2).unwrap();
        let live = LiveOptions {
            gravity,
            ..LiveOptions::default()
        };
        let mut session = Session::new("recording.csv", live);
        let text = Reading::HEADER.to_owned();
        session.bytes(text.as_bytes()).unwrap();
        Hand {
            rng: ChaCha8Rng::seed_from_u64(seed),
            sensor: InteractiveSensor::new(&options).unwrap(),
            session,
            clumsiness,
            rate_hz,
            now_s: 0.0,
            text,
            messages: Vec::new(),
        }
    }

    /// Rows of `duration_s`; returns the events.
    pub fn pass(&mut self, duration_s: f64) -> Vec<Message> {
        let end_s = self.now_s + duration_s;
        let mut out = Vec::new();
        while self.now_s < end_s {
            let mut chunk = String::new();
            for _ in 0..(0.1 * self.rate_hz).ceil() as u32 {
                let reading = self.sensor.at(self.now_s);
                let lost = self.clumsiness == Clumsiness::LostRows && self.rng.random_bool(0.02);
                if !lost {
                    chunk += &reading.row((1e3 * self.now_s).round() as u64, DECIMALS);
                }
                self.now_s += 1.0 / self.rate_hz;
            }
            out.extend(self.session.bytes(chunk.as_bytes()).unwrap());
            if self.rate_hz < 100.0 {
                // As the program does with a board.
                out.extend(self.session.settle_format().unwrap_or_default());
            }
            self.text += &chunk;
        }
        self.messages.extend(out.clone());
        out
    }

    pub fn command(&mut self, command: &Command) -> Vec<Message> {
        let events = self.session.command(command);
        self.messages.extend(events.clone());
        events
    }

    pub fn lay(&mut self, face: Face) {
        self.sensor.lay(face);
    }

    pub fn hold(&mut self, up: [f64; 3]) {
        self.sensor.hold(up).unwrap();
    }

    /// A bump that moves it by a centimetre.
    pub fn bump(&mut self) {
        let line = LineOptions {
            distance_m: 0.01,
            move_time_s: 0.3,
            ..LineOptions::default()
        };
        self.sensor.push(&line).unwrap();
    }

    /// Turns it as it is asked for, and holds it until it is accepted or rejected.
    fn follow(&mut self, kind: Wanted, faces: &[String], up: Option<[f64; 3]>) {
        let wrong = self.clumsiness == Clumsiness::WrongSides && self.rng.random_bool(0.33);
        // It is read and thought first; the hand is off after about four seconds.
        self.pass(TURN_S - CARRIED_S);
        match (kind, up) {
            (Wanted::Face, _) => {
                let name = &faces[self.rng.random_range(0..faces.len())];
                let wanted = Face::all().into_iter().find(|f| f.name() == *name).unwrap();
                let any = Face::all()[self.rng.random_range(0..6)];
                self.lay(if wrong { any } else { wanted });
            }
            (_, up) => {
                let up = up.unwrap_or([0.6, 0.6, 0.6]);
                let off = |rng: &mut ChaCha8Rng| FREE_OFF * 2.0 * (rng.random::<f64>() - 0.5) * 1.7;
                let up = up.map(|c| c + off(&mut self.rng));
                self.hold(up);
            }
        }
        self.pass(CARRIED_S);
        if self.clumsiness == Clumsiness::Bumps && self.rng.random_bool(0.33) {
            let wait_s = 0.5 + 2.0 * self.rng.random::<f64>();
            self.pass(wait_s);
            self.bump();
        }
        let began_s = self.now_s;
        while self.now_s - began_s < PATIENCE_S {
            let events = self.pass(0.1);
            // After a bump it lies still, and is taken the next time.
            let over = |m: &Message| match &m.event {
                Event::PoseAccepted(_) => true,
                Event::PoseRejected { reason, .. } => *reason != Rejection::Moved,
                _ => false,
            };
            if events.iter().any(over) {
                return;
            }
        }
    }

    /// The whole session.
    pub fn run(mut self) -> Ended {
        let mut good_s = None;
        let mut lost_once = false;
        self.pass(4.0);
        while self.now_s < MAX_S {
            let wanted = self.messages.iter().rev().find_map(|m| match &m.event {
                Event::NextPose {
                    kind, faces, up, ..
                } => Some((*kind, faces.clone(), *up)),
                _ => None,
            });
            let free = self.session.poses().filter(|p| p.face.is_none()).count() as u32;
            let Some((kind, faces, up)) = wanted else {
                self.pass(0.5);
                continue;
            };
            if kind == Wanted::None {
                good_s = Some(self.now_s);
                break;
            }
            if free >= MAX_FREE {
                break;
            }
            if self.clumsiness == Clumsiness::LostRows && !lost_once && free == 1 {
                lost_once = true;
                self.now_s += 3.0;
            }
            self.follow(kind, &faces, up);
        }
        self.command(&Command::Finish);
        Ended {
            file: self.session.calibration().cloned(),
            messages: self.messages,
            good_s,
            text: self.text,
            sensor: self.sensor,
        }
    }
}

impl Ended {
    /// True bias and matrix of raw = M f + b, m/s², at the mean temperature of the poses.
    pub fn truth(&self) -> ([f64; 3], [[f64; 3]; 3]) {
        let truth = self.sensor.truth().accelerometer;
        let temperature = self.file.as_ref().and_then(|f| f.temperature_c);
        let warm = temperature.map_or(0.0, |t| t.mean - 25.0);
        let drift = truth.bias_drift_mps2_per_c;
        let bias = [0, 1, 2].map(|i| truth.bias_mps2[i] + warm * drift[i]);
        (bias, truth.matrix)
    }

    /// Error of ‖a‖ of the calibration, rms and worst of all directions, mg.
    pub fn norm_error_mg(&self) -> Option<[f64; 2]> {
        let (bias, matrix) = self.truth();
        let gravity = 9.80665;
        let calibration = self.file.as_ref()?.accelerometer_calibration();
        let (mut squares, mut worst_mg) = (0.0, 0.0_f64);
        for up in sphere(400) {
            let force = matrix3::mul_vec(&matrix, &(up * gravity).into());
            let raw = [0, 1, 2].map(|i| force[i] + bias[i]);
            let error_mg = 1000.0 * (matrix3::norm(&calibration.apply(raw)) / gravity - 1.0);
            squares += error_mg * error_mg;
            worst_mg = worst_mg.max(error_mg.abs());
        }
        Some([(squares / 400.0).sqrt(), worst_mg])
    }

    /// For each axis whether the true bias is within the 95 % interval.
    pub fn covered(&self) -> Option<[bool; 3]> {
        let section = &self.file.as_ref()?.accelerometer;
        let deviations = section.deviations()?;
        let (bias, _) = self.truth();
        let off = |i: usize| (section.bias[i] - bias[i]).abs() / deviations.bias[i];
        Some([0, 1, 2].map(|i| off(i) <= 1.96))
    }

    pub fn is_good(&self) -> bool {
        let grade = self.file.as_ref().map(|f| f.grade());
        grade == Some(Grade::Good)
    }

    pub fn count(&self, of: impl Fn(&Event) -> bool) -> usize {
        self.messages.iter().filter(|m| of(&m.event)).count()
    }
}

//! A recorder with a clock, a disk and a board that the test controls.

use crate::device::recorder::*;

pub const SETTINGS: &str = "# gravical mpu6050_logger 1.0, MPU6050, accelerometer +-2 g, gyroscope +-500 deg/s, low-pass 44 Hz, rate 100.00 Hz, format 0\n";
pub const HEADER: &str =
    "Timestamp (ms),aX (m/s^2),aY (m/s^2),aZ (m/s^2),Temp (C),gX (deg/s),gY (deg/s),gZ (deg/s)\n";

/// A recorder, a clock and a disk that can be full.
pub struct Desk {
    pub recorder: Recorder,
    pub now_s: f64,
    pub stamp: u64,
    pub sent: u64,
    pub file: String,
    pub rejects: String,
    pub events: Vec<Event>,
    pub commands: String,
    pub full: bool,
}

impl Desk {
    pub fn new(options: Options) -> Self {
        let mut desk = Desk {
            recorder: Recorder::new(options),
            now_s: 100.0,
            stamp: 130,
            sent: 0,
            file: String::new(),
            rejects: String::new(),
            events: Vec::new(),
            commands: String::new(),
            full: false,
        };
        desk.recorder.opened(desk.now_s, "/dev/ttyACM0", None);
        desk
    }

    pub fn started(options: Options) -> Self {
        let mut desk = Self::new(options);
        desk.say(SETTINGS);
        desk.say(HEADER);
        assert!(desk.recorder.is_started());
        desk
    }

    pub fn say(&mut self, text: &str) {
        self.recorder.bytes(self.now_s, text.as_bytes());
        self.act();
    }

    pub fn row(&mut self) -> String {
        let row = format!("{},0.01,-0.02,9.81,25.50,0.1,0.2,0.3\n", self.stamp);
        self.stamp = (self.stamp + 10) % (1 << 32);
        self.sent += 1;
        row
    }

    pub fn rows(&mut self, n: u32) {
        for _ in 0..n {
            let row = self.row();
            self.say(&row);
            self.pass(0.01);
        }
    }

    pub fn pass(&mut self, s: f64) {
        self.now_s += s;
        self.recorder.tick(self.now_s);
        self.act();
        self.disk();
        let held = match &self.recorder.state {
            State::Starting(start) => start.held.len() as u64,
            _ => 0,
        };
        assert!(
            self.recorder
                .counts
                .balances(self.recorder.queue.rows() + held)
        );
    }

    pub fn act(&mut self) {
        for action in self.recorder.take() {
            match action {
                Action::Report(event) => self.events.push(event),
                Action::Send(bytes) => self.commands.push_str(std::str::from_utf8(&bytes).unwrap()),
                Action::Sync => {}
            }
        }
    }

    pub fn disk(&mut self) {
        if let Some(batch) = self.recorder.batch() {
            if self.full {
                self.recorder.failed(self.now_s, "No space left on device");
            } else {
                self.file.push_str(std::str::from_utf8(&batch).unwrap());
                self.recorder.stored();
            }
        }
        if let Some(batch) = self.recorder.rejects() {
            self.rejects.push_str(&String::from_utf8_lossy(&batch));
            self.recorder.rejects_stored();
        }
    }

    pub fn end(&mut self) -> RowCounts {
        self.recorder.finish(self.now_s, End::User);
        self.disk();
        self.recorder.give_up();
        self.act();
        let counts = *self.recorder.counts();
        assert!(counts.balances(0), "{counts:?}");
        assert_eq!(self.file_rows() as u64, counts.stored);
        assert_eq!(self.rejects.lines().count() as u64, counts.rejected);
        counts
    }

    pub fn file_rows(&self) -> usize {
        let is_row = |l: &&str| l.starts_with(|c: char| c.is_ascii_digit());
        self.file.lines().filter(is_row).count()
    }

    pub fn gaps(&self) -> Vec<&str> {
        self.file
            .lines()
            .filter(|l| l.starts_with("# gap:"))
            .collect()
    }

    pub fn fatal(&mut self) -> &'static str {
        self.fatal_code().unwrap()
    }

    pub fn fatal_code(&mut self) -> Option<&'static str> {
        self.recorder.take_fatal().map(|error| error.code())
    }
}

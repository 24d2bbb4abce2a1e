//! A pseudo-terminal that behaves like the firmware.

use std::fs::File;
use std::io::{Read as _, Write as _};
use std::os::fd::OwnedFd;
use std::path::{Path, PathBuf};

use rustix::fs::{Mode, OFlags, fcntl_getfl, fcntl_setfl, open};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

use crate::logger::{Logger, until};

pub const SETTINGS: &str = "# gravical mpu6050_logger 1.0, MPU6050, accelerometer +-2 g, gyroscope +-500 deg/s, low-pass 44 Hz, rate 100.00 Hz, format 0\n";
pub const HEADER: &str =
    "Timestamp (ms),aX (m/s^2),aY (m/s^2),aZ (m/s^2),Temp (C),gX (deg/s),gY (deg/s),gZ (deg/s)\n";

/// Both ends of a pseudo-terminal, and the name of the second.
pub fn pair(raw: bool) -> (File, OwnedFd, PathBuf) {
    let ours = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).unwrap();
    grantpt(&ours).unwrap();
    unlockpt(&ours).unwrap();
    let name = ptsname(&ours, Vec::new()).unwrap();
    let path = PathBuf::from(name.to_string_lossy().into_owned());
    let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC;
    let theirs = open(&path, flags, Mode::empty()).unwrap();
    if raw {
        let mut settings = tcgetattr(&theirs).unwrap();
        settings.make_raw();
        tcsetattr(&theirs, OptionalActions::Now, &settings).unwrap();
    }
    let flags = fcntl_getfl(&ours).unwrap();
    fcntl_setfl(&ours, flags | OFlags::NONBLOCK).unwrap();
    (File::from(ours), theirs, path)
}

/// A board behind a link that remains while its terminals are opened and closed.
pub struct Board {
    link: PathBuf,
    cable: Option<(File, OwnedFd)>,
    /// The next stamp of the board's clock, ms.
    pub stamp: u64,
    /// Rows that were sent, or would have been.
    pub sent: u64,
}

impl Board {
    pub fn new(folder: &Path) -> Self {
        let mut board = Board {
            link: folder.join("ttyACM0"),
            cable: None,
            stamp: 130,
            sent: 0,
        };
        board.plug_in();
        board
    }

    pub fn port(&self) -> String {
        self.link.display().to_string()
    }

    /// `gravical log` at its port, in the folder of the board.
    pub fn log(&self, options: &str) -> Logger {
        let line = format!("log {options} --port {}", self.port());
        Logger::start(self.link.parent().unwrap(), &line)
    }

    pub fn plug_in(&mut self) {
        let (ours, theirs, path) = pair(true);
        let _ = std::fs::remove_file(&self.link);
        std::os::unix::fs::symlink(path, &self.link).unwrap();
        self.cable = Some((ours, theirs));
    }

    pub fn unplug(&mut self) {
        std::fs::remove_file(&self.link).unwrap();
        self.cable = None;
    }

    pub fn send(&mut self, bytes: &[u8]) {
        assert!(self.has_sent(bytes), "nobody reads");
    }

    /// False, with a part of it sent, if nobody reads.
    fn has_sent(&mut self, mut bytes: &[u8]) -> bool {
        let (ours, _) = self.cable.as_mut().unwrap();
        for _ in 0..5000 {
            match ours.write(bytes) {
                Ok(n) => bytes = &bytes[n..],
                Err(_) => std::thread::sleep(std::time::Duration::from_millis(1)),
            }
            if bytes.is_empty() {
                return true;
            }
        }
        false
    }

    pub fn say(&mut self, text: &str) {
        self.send(text.as_bytes());
    }

    pub fn greet(&mut self) {
        self.say(SETTINGS);
        self.say(HEADER);
    }

    fn row(&mut self) -> String {
        let noise = (self.sent * 7919 % 64) as f64 * 1e-4;
        let [x, y, z] = [noise, 0.01 - noise, 9.81 + noise];
        let [t, u, v, w] = [4, 5, 7, 3].map(|of| self.sent % of);
        let stamp = self.stamp;
        let row = format!("{stamp},{x:.4},{y:.4},{z:.4},25.5{t},0.1{u},-0.2{v},0.3{w}\n");
        self.stamp = (self.stamp + 10) % (1 << 32);
        self.sent += 1;
        row
    }

    pub fn rows(&mut self, n: u32) {
        for _ in 0..n {
            let row = self.row();
            self.say(&row);
        }
    }

    /// The same, passed on at once.
    pub fn many_rows(&mut self, n: u32) {
        let rows: String = (0..n).map(|_| self.row()).collect();
        self.say(&rows);
    }

    /// A row, or a part of it if nobody reads: then false.
    pub fn try_row(&mut self) -> bool {
        let row = self.row();
        self.has_sent(row.as_bytes())
    }

    /// A row of which only these bytes arrive.
    pub fn hurt(&mut self, bytes: &[u8]) {
        self.row();
        self.send(bytes);
    }

    /// After a long silence rows would be missing: one more row at the very end.
    pub fn one_more(&mut self) {
        self.rows(1);
        std::thread::sleep(std::time::Duration::from_millis(100));
    }

    /// Rows that never arrive.
    pub fn lose(&mut self, n: u32) {
        for _ in 0..n {
            self.row();
        }
    }

    /// A row without its first digit.
    pub fn rest_of_a_row(&mut self) {
        let row = self.row();
        self.send(&row.as_bytes()[1..]);
    }

    /// The board restarts.
    pub fn reset(&mut self) {
        self.stamp = 130;
        self.greet();
    }

    pub fn wait_for_command(&mut self, wanted: &str) {
        let (ours, _) = self.cable.as_mut().unwrap();
        let mut received = String::new();
        until(|| {
            let mut bytes = [0; 64];
            let n = ours.read(&mut bytes).unwrap_or(0);
            received.push_str(&String::from_utf8_lossy(&bytes[..n]));
            received.contains(wanted)
        });
    }
}

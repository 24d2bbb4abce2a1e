//! A board that takes commands and sends frames, at baud rates that must match.

use gravical::recording::frame::{Frame, SampleFrame, encode_frame};

use super::desk::{Desk, HEADER};
use crate::device::recorder::*;

/// The capacity of the line is not modelled: bytes arrive in the millisecond in which
/// they are sent.
pub struct Uno {
    pub desk: Desk,
    pub format: u8,
    pub range_g: u32,
    pub rate_hz: u32,
    /// The settings after a reset.
    pub constant_format: u8,
    /// Its clock when it has started, µs.
    pub boot_us: u64,
    pub stamp_us: u64,
    pub sequence: u8,
    /// Frames since the last reset.
    pub sent: u64,
    /// It ignores commands.
    pub deaf: bool,
    /// Time at which its sensor is set up, s.
    up_s: f64,
    greeted: bool,
    next_s: f64,
    garble: u8,
    read_commands: usize,
}

impl Uno {
    pub fn new(options: Options, constant_format: u8) -> Self {
        let mut uno = Uno {
            desk: Desk::new(options),
            format: constant_format,
            range_g: 2,
            rate_hz: 100,
            constant_format,
            boot_us: 1_600_000,
            stamp_us: 0,
            sequence: 0,
            sent: 0,
            deaf: false,
            up_s: 0.0,
            greeted: false,
            next_s: 0.0,
            garble: 1,
            read_commands: 0,
        };
        uno.reset();
        uno
    }

    pub fn recording(options: Options) -> Self {
        Self::recording_from(options, 1_600_000)
    }

    pub fn recording_from(options: Options, boot_us: u64) -> Self {
        let mut uno = Self::new(options, 0);
        uno.boot_us = boot_us;
        uno.reset();
        uno.run(4.0);
        assert!(uno.desk.recorder.is_started(), "{:?}", uno.desk.events);
        uno
    }

    /// The reset button: 1.5 s of boot loader, then its constants.
    pub fn reset(&mut self) {
        self.format = self.constant_format;
        (self.range_g, self.rate_hz) = (2, 100);
        (self.stamp_us, self.sequence, self.sent) = (self.boot_us, 0, 0);
        self.up_s = self.desk.now_s + 1.5;
        self.greeted = false;
    }

    fn baud(&self) -> u32 {
        if self.format == 2 { 250_000 } else { 115_200 }
    }

    pub fn settings(&self) -> String {
        let rate = (1000.0 / f64::from(1000 / self.rate_hz) * 100.0).floor() / 100.0;
        format!(
            "# gravical mpu6050_logger 1.0, MPU6050, accelerometer +-{} g, gyroscope +-500 deg/s, low-pass 44 Hz, rate {rate:.2} Hz, format {}",
            self.range_g, self.format
        )
    }

    /// Sends bytes; they are garbage if the port has another baud rate.
    pub fn send(&mut self, bytes: &[u8]) {
        let port = self.desk.bauds.last().copied().unwrap_or(115_200);
        let bytes: Vec<u8> = bytes
            .iter()
            .map(|byte| {
                self.garble = self.garble.wrapping_mul(5).wrapping_add(113);
                if port == self.baud() {
                    *byte
                } else {
                    byte ^ self.garble | 0x80
                }
            })
            .collect();
        self.desk.recorder.bytes(self.desk.now_s, &bytes);
        self.desk.act();
    }

    pub fn say(&mut self, text: &str) {
        if self.format == 2 {
            self.send(&encode_frame(&Frame::Text(text.to_owned())));
        } else {
            self.send(format!("{text}\n").as_bytes());
        }
    }

    /// Sends the next row; the clock advances.
    pub fn row(&mut self) -> Vec<u8> {
        let bytes = match self.format {
            2 => encode_frame(&Frame::Sample(SampleFrame {
                sequence: self.sequence,
                time_us: self.stamp_us as u32,
                accel: [10, -20, 16384],
                temperature: -3920,
                gyro: [1, 2, 3],
            })),
            _ => format!(
                "{},0.01,-0.02,9.81,25.50,0.1,0.2,0.3\n",
                self.stamp_us / 1000
            )
            .into_bytes(),
        };
        self.sequence = self.sequence.wrapping_add(1);
        self.stamp_us += u64::from(1_000_000 / self.rate_hz);
        self.sent += 1;
        bytes
    }

    pub fn rows(&mut self, n: u32) {
        for _ in 0..n {
            let row = self.row();
            self.send(&row);
            self.desk.pass(1.0 / f64::from(self.rate_hz));
        }
    }

    pub fn lose(&mut self, n: u32) {
        for _ in 0..n {
            self.row();
        }
    }

    /// Sends rows as time passes, and answers commands.
    pub fn run(&mut self, s: f64) {
        let end_s = self.desk.now_s + s;
        while self.desk.now_s < end_s {
            self.listen();
            let now_s = self.desk.now_s;
            if now_s >= self.up_s {
                if !std::mem::replace(&mut self.greeted, true) {
                    self.next_s = now_s;
                    self.say(&self.settings());
                    if self.format < 2 {
                        self.say(HEADER.trim());
                    }
                }
                while self.next_s <= now_s {
                    self.next_s += 1.0 / f64::from(self.rate_hz);
                    let row = self.row();
                    self.send(&row);
                }
            }
            self.desk.pass(0.005);
        }
    }

    fn listen(&mut self) {
        let port = self.desk.bauds.last().copied();
        let commands = self.desk.commands.split_off(self.read_commands);
        self.desk.commands.push_str(&commands);
        self.read_commands = self.desk.commands.len();
        // A command was sent before its change of the baud rate.
        let understood = port.unwrap_or(115_200) == self.baud() || commands.contains('f');
        if self.deaf || !understood || self.desk.now_s < self.up_s {
            return;
        }
        for command in commands.lines() {
            let number = command[1..].parse().unwrap_or(0);
            match command.as_bytes()[0] {
                b'a' => self.range_g = number,
                b'r' => self.rate_hz = number,
                b'f' => self.format = number as u8,
                b'?' => {
                    self.say(&self.settings());
                    continue;
                }
                _ => {}
            }
            self.up_s = self.desk.now_s + 0.15;
            self.greeted = false;
        }
        let silent_us = ((self.up_s - self.desk.now_s).max(0.0) * 1e6) as u64;
        self.stamp_us += silent_us;
    }
}

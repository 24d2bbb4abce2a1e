//! The board in its binary format, which it sends after a command, and which is garbage at
//! another baud rate.

use gravical::recording::frame::{Frame, SampleFrame, encode_frame};

use crate::board::{Board, HEADER, SETTINGS};
use crate::logger::until;

pub struct FastBoard {
    pub board: Board,
    binary: bool,
    /// Its clock, µs.
    pub stamp_us: u64,
    sequence: u8,
    /// Frames of samples, sent or not.
    pub sent: u64,
    garble: u8,
}

impl FastBoard {
    pub fn new(board: Board) -> Self {
        FastBoard {
            board,
            binary: false,
            stamp_us: 300_000,
            sequence: 0,
            sent: 0,
            garble: 1,
        }
    }

    /// As another program left it.
    pub fn left_in_binary(board: Board) -> Self {
        FastBoard {
            binary: true,
            ..Self::new(board)
        }
    }

    fn send(&mut self, bytes: &[u8]) {
        let own = if self.binary { 250_000 } else { 115_200 };
        if self.board.baud() == own {
            self.board.send(bytes);
            return;
        }
        let garbage: Vec<u8> = bytes
            .iter()
            .map(|byte| {
                self.garble = self.garble.wrapping_mul(5).wrapping_add(113);
                byte ^ self.garble
            })
            .collect();
        self.board.send(&garbage);
    }

    fn settings(&self) -> String {
        if self.binary {
            SETTINGS
                .trim()
                .replace("rate 100.00", "rate 500.00")
                .replace("format 0", "format 2")
        } else {
            SETTINGS.to_owned()
        }
    }

    pub fn greet(&mut self) {
        let settings = self.settings();
        if self.binary {
            self.send(&encode_frame(&Frame::Text(settings)));
        } else {
            self.send(format!("{settings}{HEADER}").as_bytes());
        }
    }

    /// Rows of text until the command for frames arrives, then frames.
    pub fn obey(&mut self) {
        until(|| {
            let row = format!(
                "{},0.01,-0.02,9.81,25.50,0.1,0.2,0.3\n",
                self.stamp_us / 1000
            );
            self.stamp_us += 10_000;
            self.send(row.as_bytes());
            self.board.has_received("f2\n")
        });
        self.binary = true;
        // The board is silent while it sets its sensor up.
        until(|| self.board.baud() == 250_000);
        self.stamp_us += 130_000;
        self.greet();
    }

    pub fn frame(&mut self) -> Vec<u8> {
        let noise = i16::try_from(self.sent * 7919 % 64).unwrap();
        let bytes = encode_frame(&Frame::Sample(SampleFrame {
            sequence: self.sequence,
            time_us: self.stamp_us as u32,
            accel: [noise, 100 - noise, 16384 + noise],
            temperature: -3920 + noise / 16,
            gyro: [noise % 5, 100 - noise % 7, noise % 3],
        }));
        self.sequence = self.sequence.wrapping_add(1);
        self.stamp_us += 2000;
        self.sent += 1;
        bytes
    }

    pub fn rows(&mut self, n: u32) {
        for _ in 0..n {
            let frame = self.frame();
            self.send(&frame);
        }
    }

    /// A frame of which one bit is wrong.
    pub fn hurt(&mut self, at: usize, bit: u32) {
        let mut frame = self.frame();
        let at = at % frame.len();
        frame[at] ^= 1 << (bit % 8);
        self.send(&frame);
    }

    /// Frames that never arrive.
    pub fn lose(&mut self, n: u32) {
        for _ in 0..n {
            self.frame();
        }
    }

    pub fn say(&mut self, text: &str) {
        self.send(&encode_frame(&Frame::Text(text.to_owned())));
    }

    /// The reset button: its constants, another clock.
    pub fn reset(&mut self) {
        (self.binary, self.stamp_us, self.sequence) = (false, 300_000, 0);
        self.greet();
    }
}

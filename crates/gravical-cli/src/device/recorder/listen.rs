//! How the board speaks: as lines, or as frames at a rate of their own. Where nothing
//! that makes sense comes in one of them, the other is tried: a board may have been left
//! in its binary format, and one that starts anew is back in its first format.

use super::{Action, Recorder, State};
use crate::device::event::Event;
use crate::device::frames::{self, Sequence};
use crate::device::line::Reason;
use crate::device::stamps::Stamps;
use crate::device::wire::Coding;

/// Without anything that makes sense for so long, frames are given up, s. A board whose
/// sensor does not answer says so once a second.
const NO_FRAME_S: f64 = 2.0;
/// The same for lines of a board that is known to send frames, s: the boot loader takes
/// up to two seconds.
const NO_LINE_S: f64 = 3.0;
/// Bytes that come all the time and are no line for so long, s …
const GARBAGE_S: f64 = 1.0;
/// … so many of them …
const GARBAGE_BYTES: usize = 200;
/// … and one in so many no character of a text: another rate. A sketch of somebody else
/// may well say in plain text what it does before it sends rows.
const ODD_ONE_IN: usize = 5;
/// They come at least so often, s: the slowest board sends four frames a second.
const OFTEN_S: f64 = 0.3;
/// A board that was told to speak otherwise is up again after so long, s.
const UP_S: f64 = 0.6;
/// Silence of a board that changes its rate, s: what came before it was no frame, and
/// has no zero at its end.
const CHANGES_S: f64 = 0.05;
/// Lines that may have been said at another rate, kept until that is known.
const NOISE: usize = 2000;

/// Silence before the first byte: a board that starts up, and no rest of a line, s.
const START_UP_S: f64 = 0.3;

/// What was heard since the port has its rate.
#[derive(Debug, Clone, Default)]
pub struct Ear {
    /// Something that makes sense.
    pub good: bool,
    /// The board was asked how it is set.
    pub asked: bool,
    /// The rate is being changed.
    target: Option<Coding>,
    /// From the opening to the first byte, s.
    silence_s: Option<f64>,
    /// When something last made sense, or else the rate was set, s.
    since_s: f64,
    /// Bytes since then, and how many of them are in no text.
    bytes: usize,
    odd: usize,
    noise: Vec<(Vec<u8>, Reason)>,
    /// Lines beyond those.
    more_noise: u64,
}

impl Ear {
    /// The first line began when it was listened already.
    pub fn heard_its_start(&self) -> bool {
        self.silence_s.is_some_and(|s| s >= START_UP_S)
    }
}

impl Recorder {
    /// A port that was just opened is at the rate of text.
    pub(super) fn listen_from(&mut self, now_s: f64) {
        self.wire.switch(Coding::Text);
        self.ear = Ear {
            since_s: now_s,
            noise: std::mem::take(&mut self.ear.noise),
            more_noise: self.ear.more_noise,
            ..Ear::default()
        };
    }

    /// The port has the rate of [`Action::Baud`] now; what came at the one before was
    /// handed over.
    pub fn baud_is_set(&mut self, now_s: f64) {
        let Some(coding) = self.ear.target.take() else {
            return;
        };
        self.listen_from(now_s);
        self.wire.switch(coding);
        self.start.next_s = now_s + UP_S;
        if self.state == State::Starting {
            self.account.before_start += self.start.forget_held();
            self.start.columns = None;
        }
    }

    /// Has the port set to the rate that belongs to `coding`, where it is another one.
    pub(super) fn speak(&mut self, coding: Coding) {
        if coding == self.wire.coding() || self.ear.target.is_some() {
            return;
        }
        self.ear.target = Some(coding);
        let baud = match coding {
            Coding::Text => self.options.baud,
            Coding::Frames => frames::BAUD,
        };
        self.actions.push(Action::Baud(baud));
        self.tell(Event::Speed { baud });
    }

    pub(super) fn heard(&mut self, now_s: f64, bytes: &[u8]) {
        let since_s = self.ear.since_s;
        self.ear.silence_s.get_or_insert(now_s - since_s);
        self.ear.bytes += bytes.len();
        let odd = |b: &&u8| !(b.is_ascii_graphic() || b.is_ascii_whitespace());
        self.ear.odd += bytes.iter().filter(odd).count();
        let changed = !self.ear.good && self.wire.coding() == Coding::Frames;
        if changed && now_s - self.last_bytes_s >= CHANGES_S {
            self.wire.cut();
        }
    }

    /// Something makes sense: the rate is the right one.
    pub(super) fn makes_sense(&mut self, now_s: f64) {
        (self.ear.since_s, self.ear.bytes, self.ear.odd) = (now_s, 0, 0);
        if !std::mem::replace(&mut self.ear.good, true) {
            match self.wire.coding() {
                Coding::Text => self.noise_is_rejected(),
                // Frames at the rate of text.
                Coding::Frames => {
                    self.ear.noise.clear();
                    self.ear.more_noise = 0;
                }
            }
        }
        if self.is_started() && self.wire.coding() != self.start.coding {
            self.board_is_anew(now_s);
        }
    }

    /// The board speaks otherwise than it did: it was reset.
    fn board_is_anew(&mut self, now_s: f64) {
        self.reset(now_s);
        self.stamps = Stamps::default();
        self.sequence = Sequence::default();
        self.wire.clock_anew();
        if self.state == State::Recording {
            self.state = State::Restoring;
            self.start.tries = 0;
            // Most boards say by themselves how they are set.
            self.start.next_s = now_s + UP_S;
        }
    }

    /// The clock started anew, or the columns are others, and the board's own line was
    /// not heard: whether it is still set as it was is not known.
    pub(super) fn ask_again(&mut self, now_s: f64) {
        self.state = State::Restoring;
        self.start.tries = 0;
        self.ask(now_s);
    }

    /// Asks the board how it is set.
    pub(super) fn ask(&mut self, now_s: f64) {
        self.ear.asked = true;
        self.start.next_s = now_s + super::start::ASK_AGAIN_S;
        self.actions.push(Action::Send(b"?\n".to_vec()));
    }

    /// Bytes that are no line or no frame.
    pub(super) fn bad(&mut self, bytes: Vec<u8>, reason: Reason) {
        let text = self.wire.coding() == Coding::Text;
        if text {
            self.start.rejected(&bytes);
        }
        let elsewhere = self.is_started() && self.wire.coding() != self.start.coding;
        let known = self.ear.good || (text && self.is_started());
        if elsewhere {
            // It will be heard at the other rate.
        } else if known {
            self.reject(bytes, reason);
        } else if text && self.ear.noise.len() < NOISE {
            // Whoever begins to listen to frames in the middle waits for a zero.
            self.ear.noise.push((bytes, reason));
        } else if text {
            self.ear.more_noise += 1;
        }
    }

    /// Those lines were at the right rate, or nobody will ever know.
    pub(super) fn noise_is_rejected(&mut self) {
        for (bytes, reason) in std::mem::take(&mut self.ear.noise) {
            self.reject(bytes, reason);
        }
        let more = std::mem::take(&mut self.ear.more_noise);
        self.account.rejected += more;
        self.account.rejected_unstored += more;
    }

    /// Where nothing makes sense, the other rate is tried.
    pub(super) fn listen_elsewhere(&mut self, now_s: f64) {
        if self.failed || self.ended.is_some() {
            return;
        }
        let since_s = now_s - self.ear.since_s;
        let garbage = since_s >= GARBAGE_S
            && self.ear.bytes >= GARBAGE_BYTES
            && self.ear.odd * ODD_ONE_IN >= self.ear.bytes
            && now_s - self.last_bytes_s < OFTEN_S;
        let frames_expected = self.is_started() && self.start.coding == Coding::Frames;
        let over = match self.wire.coding() {
            Coding::Frames => since_s >= NO_FRAME_S,
            Coding::Text if frames_expected => garbage || since_s >= NO_LINE_S,
            // A sketch of somebody else has no frames.
            Coding::Text => garbage && (!self.is_started() || self.start.settings.is_some()),
        };
        if over {
            self.speak(self.wire.coding().other());
        }
    }
}

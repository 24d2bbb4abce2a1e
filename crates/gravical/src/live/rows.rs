//! The recording of a session: all rows to calibrate with, the last ones to find poses in.

use std::collections::VecDeque;
use std::ops::Range;

use gravical_recording::Sample;

use crate::Result;
use crate::recording::Follow;
use crate::recording::{ReadOptions, Recording};

/// Rows of this time are at hand, s: twice the longest capture.
const RECENT_S: f64 = 120.0;

/// Rows of the session.
pub(super) struct SessionRows {
    pub reading: Follow,
    /// From the row before to one without a time, s.
    step_s: f64,
    /// Time of the last row that was read, s.
    last_s: f64,
    recent: VecDeque<Sample>,
}

impl SessionRows {
    /// Of the recording `name`.
    pub fn new(name: &str, options: &ReadOptions) -> Self {
        let rate_hz = options.rate_hz.unwrap_or(Recording::ASSUMED_RATE_HZ);
        SessionRows {
            reading: Follow::new(name, options.clone(), usize::MAX),
            step_s: 1.0 / rate_hz,
            last_s: -1.0 / rate_hz,
            recent: VecDeque::new(),
        }
    }

    /// Reads the next bytes.
    ///
    /// # Errors
    ///
    /// Those of reading.
    pub fn read(&mut self, bytes: &[u8]) -> Result<Vec<Sample>> {
        let samples = self.reading.push(bytes)?;
        Ok(self.timed(samples))
    }

    /// Detects the format from the rows that are there, because there are no more for now.
    ///
    /// # Errors
    ///
    /// Those of reading.
    pub fn settle(&mut self) -> Result<Vec<Sample>> {
        let samples = self.reading.settle(1)?;
        Ok(self.timed(samples))
    }

    fn timed(&mut self, mut samples: Vec<Sample>) -> Vec<Sample> {
        for sample in &mut samples {
            sample.time_s = if sample.time_s.is_nan() {
                self.last_s + self.step_s
            } else {
                // The last digits depend on what arrives at once.
                (sample.time_s * 1e9).round() / 1e9
            };
            self.last_s = sample.time_s;
        }
        samples
    }

    /// Adds a row to the recent ones.
    pub fn push(&mut self, sample: Sample) {
        self.recent.push_back(sample);
        let old = |s: &Sample| sample.time_s - s.time_s > RECENT_S;
        while self.recent.front().is_some_and(old) {
            self.recent.pop_front();
        }
    }

    /// The recent rows.
    pub fn recent(&self) -> impl DoubleEndedIterator<Item = &Sample> {
        self.recent.iter()
    }

    /// The recent rows among `rows`.
    pub fn within(&self, rows: &Range<usize>) -> Vec<Sample> {
        let all = self.recent.iter().filter(|s| rows.contains(&s.row));
        all.copied().collect()
    }

    /// The recent rows of these lines.
    pub fn at_lines(&self, [first, last]: [u32; 2]) -> Vec<Sample> {
        let all = self.recent.iter();
        let all = all.filter(|s| (first..=last).contains(&s.line));
        all.copied().collect()
    }

    /// The rows up to the last one that was added, judged as a file: what arrived with it does not
    /// matter.
    ///
    /// # Errors
    ///
    /// Those of reading.
    pub fn recording(&self) -> Option<Result<Recording>> {
        self.reading.recording(self.recent.back()?.line)
    }
}

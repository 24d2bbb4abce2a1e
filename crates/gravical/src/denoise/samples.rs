//! Consecutive samples of a stretch.

use std::ops::Range;

/// Consecutive samples of a stretch in several channels.
#[derive(Debug, Clone, Default)]
pub(super) struct Samples {
    pub time_s: Vec<f64>,
    /// Number of uneven steps in the stretch up to each sample.
    pub uneven: Vec<usize>,
    pub channels: Vec<Vec<f64>>,
}

impl Samples {
    /// Empty, for this number of channels.
    pub fn new(channels: usize) -> Self {
        Samples {
            channels: vec![Vec::new(); channels],
            ..Samples::default()
        }
    }

    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// Adds samples.
    pub fn append(&mut self, mut more: Samples) {
        if self.len() == 0 {
            *self = more;
            return;
        }
        self.time_s.append(&mut more.time_s);
        self.uneven.append(&mut more.uneven);
        for (own, more) in self.channels.iter_mut().zip(&mut more.channels) {
            own.append(more);
        }
    }

    /// Samples at the times of these `rows`, without values.
    pub fn times(&self, rows: Range<usize>) -> Samples {
        Samples {
            time_s: self.time_s[rows.clone()].to_vec(),
            uneven: self.uneven[rows].to_vec(),
            channels: vec![Vec::new(); self.channels.len()],
        }
    }

    /// Removes the first `count` samples.
    pub fn remove_first(&mut self, count: usize) {
        self.time_s.drain(..count);
        self.uneven.drain(..count);
        for channel in &mut self.channels {
            channel.drain(..count.min(channel.len()));
        }
    }
}

/// Keeps the items that are marked.
pub(super) fn keep<T>(items: &mut Vec<T>, marked: &[bool]) {
    let mut marked = marked.iter();
    items.retain(|_| marked.next().is_some_and(|marked| *marked));
}

//! Sums for the overlapping Allan variance, sample by sample, in memory that does not grow.
//!
//! With phases θ_k, the sums of the samples before the k-th, and an averaging time of m samples
//!
//! ```text
//! σ²(m) = 1/(2 m² n) Σ (θ_{k+2m} − 2 θ_{k+m} + θ_k)²
//! ```
//!
//! over n places k (W. J. Riley, NIST Special Publication 1065, 2008, equation 11). Taking every k
//! needs the last 2m phases. Every (m/64)th differs by less than 0.8 % where the standard deviation
//! is 35 %, far less elsewhere, and needs 256 phases for each octave: the phases of level l are
//! every 2^l-th, and m is 64 to 127 of them, on level 0 also less.

/// Second differences span at least this many phases from level 1 on.
const SPAN: usize = 64;
/// Phases that are processed together.
const BATCH: usize = 2048;
/// Longest averaging time, samples: 2⁴⁰ samples take 35 years at 1 kHz.
const LONGEST: usize = 1
    << (if usize::BITS > 40 {
        40
    } else {
        usize::BITS - 1
    });

/// Averaging times that are computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Spacing {
    /// 1, 2, 4, 8 … samples. The default.
    #[default]
    Octave,
    /// Four in each octave.
    Dense,
    /// 1, 2, 5, 10 … samples, as near to it as the stride allows.
    Decade,
}

impl Spacing {
    /// Averaging times in samples, in order, below `end`. The octaves are always among them: the
    /// fit uses them.
    #[must_use]
    pub fn factors(self, end: usize) -> Vec<usize> {
        let octaves = (0..LONGEST.ilog2()).map(|octave| 1_usize << octave);
        let mut all: Vec<usize> = match self {
            Spacing::Octave => octaves.collect(),
            Spacing::Dense => octaves
                .flat_map(|m| {
                    (0..4).map(move |k| (m as f64 * 2_f64.powf(0.25 * f64::from(k))) as usize)
                })
                .collect(),
            Spacing::Decade => (0..12)
                .filter_map(|decade| 10_usize.checked_pow(decade))
                .flat_map(|decade| [1, 2, 5].map(|k| decade.saturating_mul(k)))
                .chain(octaves)
                .collect(),
        };
        all.retain(|m| *m < end.min(LONGEST));
        all.sort_unstable();
        all.dedup();
        all
    }
}

/// Sums for one averaging time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AllanSums {
    /// Averaging time, samples.
    pub m: usize,
    /// Distance between the second differences, samples.
    pub stride: usize,
    /// Number of second differences.
    pub terms: u64,
    /// Sum of their squares, in the unit of the samples squared.
    pub squares: f64,
}

impl AllanSums {
    /// Allan variance, in the unit of the samples squared.
    #[must_use]
    pub fn variance(&self) -> f64 {
        let m = self.m as f64;
        self.squares / (2.0 * m * m * self.terms as f64)
    }
}

/// Number and mean length of segments that are about equally long.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lengths {
    /// Mean number of samples.
    pub samples: f64,
    /// Number of segments.
    pub count: f64,
}

/// Accumulates the sums of one channel.
///
/// # Example
///
/// ```
/// use gravical::noise::{Allan, Spacing};
///
/// let mut allan = Allan::new(Spacing::Octave, false);
/// allan.push(&[1.0, 2.0, 1.0, 2.0, 1.0]);
/// let (sums, _) = allan.finish();
/// assert_eq!(sums[0].variance(), 0.5);
/// assert_eq!(sums[1].variance(), 0.0);
/// ```
#[derive(Debug, Clone)]
pub struct Allan {
    spacing: Spacing,
    /// Every second difference: phases are kept up to the end of a segment.
    full: bool,
    levels: Vec<Level>,
    /// Subtracted from the samples, so that the phases stay small.
    reference: f64,
    phase: f64,
    /// Samples of the segment.
    samples: u64,
    /// Of the segments so far, by length in quarters of an octave.
    lengths: Vec<Lengths>,
}

/// Phases at one stride.
#[derive(Debug, Clone, Default)]
struct Level {
    /// Averaging times in strides, with terms and squares.
    sums: Vec<(usize, u64, f64)>,
    phases: Vec<f64>,
    /// Number of phases that are processed.
    done: usize,
    /// The next phase does not belong to the next level.
    skips: bool,
}

impl Level {
    fn new(spacing: Spacing, level: usize) -> Self {
        let least = if level == 0 { 1 } else { SPAN << level };
        let mut strides: Vec<usize> = spacing
            .factors((2 * SPAN) << level)
            .into_iter()
            .filter(|m| *m >= least)
            .map(|m| m >> level)
            .collect();
        strides.dedup();
        Level {
            sums: strides.into_iter().map(|m| (m, 0, 0.0)).collect(),
            ..Level::default()
        }
    }

    /// Adds the second differences that end at phases which are not processed yet.
    fn process(&mut self) {
        for (m, terms, squares) in &mut self.sums {
            let from = self.done.max(2 * *m);
            if from < self.phases.len() {
                *terms += (self.phases.len() - from) as u64;
                *squares += sum_of_squares(&self.phases, *m, from);
            }
        }
    }

    /// Passes every second new phase to the next level, and forgets what is not needed any more.
    fn advance(&mut self, next: &mut Level) {
        for phase in &self.phases[self.done..] {
            if !self.skips {
                next.phases.push(*phase);
            }
            self.skips = !self.skips;
        }
        let kept = self.phases.len().min(4 * SPAN);
        self.phases.drain(..self.phases.len() - kept);
        self.done = kept;
    }
}

/// Σ (θ_k − 2 θ_{k−m} + θ_{k−2m})² over k from `from` to the end.
fn sum_of_squares(phases: &[f64], m: usize, from: usize) -> f64 {
    // Independent sums, so that they are computed side by side.
    const LANES: usize = 8;
    let end = phases.len();
    let first = phases[from - 2 * m..end - 2 * m].chunks_exact(LANES);
    let middle = phases[from - m..end - m].chunks_exact(LANES);
    let last = phases[from..].chunks_exact(LANES);
    let second = |a: f64, b: f64, c: f64| {
        let d = c - 2.0 * b + a;
        d * d
    };
    let rest = first.remainder().iter().zip(middle.remainder());
    let mut sum: f64 = rest
        .zip(last.remainder())
        .map(|((a, b), c)| second(*a, *b, *c))
        .sum();
    let mut lanes = [0.0; LANES];
    for ((a, b), c) in first.zip(middle).zip(last) {
        for (i, lane) in lanes.iter_mut().enumerate() {
            *lane += second(a[i], b[i], c[i]);
        }
    }
    sum += lanes.iter().sum::<f64>();
    sum
}

/// The sums of samples in memory by every second difference, for these averaging times in samples;
/// those that do not fit are left out.
///
/// # Example
///
/// ```
/// use gravical::noise::overlapping;
///
/// let sums = overlapping(&[1.0, 2.0, 1.0, 2.0, 1.0], &[1, 2, 3]);
/// let variances: Vec<f64> = sums.iter().map(|s| s.variance()).collect();
/// assert_eq!(variances, [0.5, 0.0]);
/// ```
#[must_use]
pub fn overlapping(samples: &[f64], m: &[usize]) -> Vec<AllanSums> {
    let reference = samples.first().copied().unwrap_or(0.0);
    let mut phases = Vec::with_capacity(samples.len() + 1);
    let mut phase = 0.0;
    phases.push(phase);
    for value in samples {
        phase += value - reference;
        phases.push(phase);
    }
    let fits = |m: &&usize| (1..=samples.len() / 2).contains(*m);
    m.iter()
        .filter(fits)
        .map(|&m| AllanSums {
            m,
            stride: 1,
            terms: (phases.len() - 2 * m) as u64,
            squares: sum_of_squares(&phases, m, 2 * m),
        })
        .collect()
}

impl Allan {
    /// Without samples. With `full` every second difference is taken: memory then grows by eight
    /// bytes for each sample of a segment.
    #[must_use]
    pub fn new(spacing: Spacing, full: bool) -> Self {
        Allan {
            spacing,
            full,
            levels: vec![Level::new(spacing, 0)],
            reference: 0.0,
            phase: 0.0,
            samples: 0,
            lengths: Vec::new(),
        }
    }

    /// Adds samples, which have to be finite.
    pub fn push(&mut self, values: &[f64]) {
        if self.samples == 0
            && let Some(first) = values.first()
        {
            self.reference = *first;
            self.phase = 0.0;
            self.levels[0].phases.push(0.0);
        }
        self.samples += values.len() as u64;
        for part in values.chunks(BATCH) {
            let level = &mut self.levels[0];
            for value in part {
                self.phase += value - self.reference;
                level.phases.push(self.phase);
            }
            if !self.full && level.phases.len() >= BATCH {
                self.process(0, false);
            }
        }
    }

    /// Processes a level, and those above it if they have enough phases or `all`: one without new
    /// phases may have some above it.
    fn process(&mut self, at: usize, all: bool) {
        if at + 1 == self.levels.len() {
            self.levels.push(Level::new(self.spacing, at + 1));
        }
        if let [level, next, above @ ..] = &mut self.levels[at..] {
            level.process();
            level.advance(next);
            let new = next.phases.len() - next.done;
            let more = !above.is_empty() || new > 0 && next.phases.len() > 1;
            if next.phases.len() >= BATCH || all && more {
                self.process(at + 1, all);
            }
        }
    }

    /// Ends a segment: the next sample does not continue the last one.
    pub fn split(&mut self) {
        if self.samples == 0 {
            return;
        }
        self.count_segment();
        if self.full {
            let level = &mut self.levels[0];
            let factors = self.spacing.factors(level.phases.len().div_ceil(2));
            for m in factors {
                if !level.sums.iter().any(|(of, ..)| *of == m) {
                    level.sums.push((m, 0, 0.0));
                }
            }
            level.process();
        } else {
            self.process(0, true);
        }
        for level in &mut self.levels {
            level.phases.clear();
            level.done = 0;
            level.skips = false;
        }
        self.samples = 0;
    }

    /// Number of segments that have ended.
    #[must_use]
    pub fn segments(&self) -> u64 {
        self.lengths.iter().map(|l| l.count as u64).sum()
    }

    fn count_segment(&mut self) {
        let samples = self.samples as f64;
        let class = |n: f64| (4.0 * n.log2()).round();
        let alike = |l: &&mut Lengths| class(l.samples) == class(samples);
        match self.lengths.iter_mut().find(alike) {
            Some(lengths) => {
                lengths.count += 1.0;
                lengths.samples += (samples - lengths.samples) / lengths.count;
            }
            None => self.lengths.push(Lengths {
                samples,
                count: 1.0,
            }),
        }
    }

    /// The sums for every averaging time that fits, in order, and the lengths of the segments.
    #[must_use]
    pub fn finish(mut self) -> (Vec<AllanSums>, Vec<Lengths>) {
        self.split();
        let mut all: Vec<AllanSums> = Vec::new();
        for (number, level) in self.levels.iter().enumerate() {
            all.extend(level.sums.iter().map(|(m, terms, squares)| AllanSums {
                m: m << number,
                stride: 1 << number,
                terms: *terms,
                squares: *squares,
            }));
        }
        all.retain(|sums| sums.terms > 0);
        all.sort_by_key(|sums| sums.m);
        (all, self.lengths)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(n: usize) -> Vec<f64> {
        let value = |k: usize| ((k * 7919) % 10007) as f64 / 100.0 - (k as f64 / 700.0).sin();
        (0..n).map(value).collect()
    }

    /// By the definition, over every `stride`-th place.
    fn plain(x: &[f64], m: usize, stride: usize) -> (u64, f64) {
        let mut phases = vec![0.0];
        for value in x {
            phases.push(phases[phases.len() - 1] + value);
        }
        let places = (0..phases.len() - 2 * m).step_by(stride);
        let squares = places.map(|k| (phases[k + 2 * m] - 2.0 * phases[k + m] + phases[k]).powi(2));
        squares.fold((0, 0.0), |(n, sum), square| (n + 1, sum + square))
    }

    #[test]
    fn segments_are_pooled_by_their_terms() {
        let x = wave(9000);
        let cuts = [0, 1, 700, 5000, 5001, 9000];
        let mut allan = Allan::new(Spacing::Octave, false);
        for part in cuts.windows(2) {
            allan.push(&x[part[0]..part[1]]);
            allan.split();
        }
        let (sums, lengths) = allan.finish();
        assert_eq!(lengths.iter().map(|l| l.count).sum::<f64>(), 5.0);
        for s in sums {
            let parts = cuts.windows(2).filter(|w| w[1] - w[0] + 1 > 2 * s.m);
            let (terms, squares) = parts
                .map(|w| plain(&x[w[0]..w[1]], s.m, s.stride))
                .fold((0, 0.0), |(n, sum), (m, more)| (n + m, sum + more));
            assert_eq!(s.terms, terms);
            assert!((s.squares / squares - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn memory_stays_flat() {
        let mut allan = Allan::new(Spacing::Octave, false);
        let part = wave(5000);
        for _ in 0..400 {
            allan.push(&part);
        }
        let held: usize = allan.levels.iter().map(|l| l.phases.capacity()).sum();
        assert!(held < 4 * BATCH * allan.levels.len(), "{held}");
    }
}

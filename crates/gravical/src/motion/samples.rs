//! What is integrated: calibrated channels with their stamps, without the rows
//! that hold no sample.

use std::ops::Range;

use super::nominal::Nominal;

/// Specific force and angular rate at rising times, in the axes of the case.
///
/// Rows without a complete sample are left out; the stamps then step over them.
/// All columns have the same length.
#[derive(Debug, Clone, Default)]
pub struct Samples {
    /// Time of each sample, s from the first row of the recording; never falls.
    pub t_s: Vec<f64>,
    /// Specific force, calibrated, m/s².
    pub force_mps2: [Vec<f64>; 3],
    /// Angular rate, calibrated, its bias at rest still in it, rad/s.
    pub rate_rad_s: Option<[Vec<f64>; 3]>,
    /// Samples that do not follow their predecessor: before them the recording
    /// has a break, or a gap too long to integrate across.
    pub breaks: Vec<usize>,
    /// Steps that the values come in, m/s² along x, y, z and rad/s about them; 0
    /// where nothing tells.
    pub resolution: [f64; 6],
    /// Samples at which the gyroscope stands at the end of its range, in order.
    pub clipped: Vec<usize>,
}

impl Samples {
    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.t_s.len()
    }

    /// True without any sample.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.t_s.is_empty()
    }

    /// The first of them, `count` at most.
    #[must_use]
    pub fn first(&self, count: usize) -> Samples {
        let count = count.min(self.len());
        let three = |channels: &[Vec<f64>; 3]| channels.each_ref().map(|c| c[..count].to_vec());
        Samples {
            t_s: self.t_s[..count].to_vec(),
            force_mps2: three(&self.force_mps2),
            rate_rad_s: self.rate_rad_s.as_ref().map(three),
            breaks: self.breaks.iter().copied().filter(|b| *b < count).collect(),
            resolution: self.resolution,
            clipped: self
                .clipped
                .iter()
                .copied()
                .filter(|i| *i < count)
                .collect(),
        }
    }

    /// Specific force of a sample, m/s².
    #[must_use]
    #[inline]
    pub fn force_at(&self, i: usize) -> [f64; 3] {
        [
            self.force_mps2[0][i],
            self.force_mps2[1][i],
            self.force_mps2[2][i],
        ]
    }

    /// Angular rate of a sample, rad/s; zero without a gyroscope.
    #[must_use]
    #[inline]
    pub fn rate_at(&self, i: usize) -> [f64; 3] {
        match &self.rate_rad_s {
            Some(rate) => [rate[0][i], rate[1][i], rate[2][i]],
            None => [0.0; 3],
        }
    }

    /// Sample ranges between the breaks, none of them empty.
    #[must_use]
    pub fn pieces(&self) -> Vec<Range<usize>> {
        crate::recording::between(&self.breaks, self.len())
    }

    /// Median step between samples that follow each other, s; NaN without any.
    #[must_use]
    pub fn median_step_s(&self) -> f64 {
        let mut steps: Vec<f64> = self
            .t_s
            .windows(2)
            .map(|w| w[1] - w[0])
            .filter(|step| *step > 0.0)
            .collect();
        crate::stats::median(&mut steps).unwrap_or(f64::NAN)
    }
}

/// Samples as they are integrated: calibrated, or by nominal scales alone.
#[derive(Debug, Clone, Copy)]
pub(super) struct View<'a> {
    /// The samples, calibrated; their times and breaks.
    pub samples: &'a Samples,
    /// What is read in place of them.
    nominal: Option<&'a Nominal>,
}

impl<'a> View<'a> {
    /// As calibrated.
    pub fn calibrated(samples: &'a Samples) -> Self {
        View {
            samples,
            nominal: None,
        }
    }

    /// By nominal scales alone.
    pub fn nominal(samples: &'a Samples, nominal: &'a Nominal) -> Self {
        View {
            samples,
            nominal: Some(nominal),
        }
    }

    /// Times, s.
    #[inline]
    pub fn t_s(&self) -> &'a [f64] {
        &self.samples.t_s
    }

    /// There is a gyroscope.
    pub fn has_gyro(&self) -> bool {
        self.samples.rate_rad_s.is_some()
    }

    /// Specific force of a sample, m/s².
    #[inline]
    pub fn force_at(&self, i: usize) -> [f64; 3] {
        match self.nominal {
            None => self.samples.force_at(i),
            Some(nominal) => nominal.force(i, self.samples.force_at(i)),
        }
    }

    /// Angular rate of a sample, rad/s; zero without a gyroscope.
    #[inline]
    pub fn rate_at(&self, i: usize) -> [f64; 3] {
        match self.nominal {
            None => self.samples.rate_at(i),
            Some(nominal) => nominal.rate(i, self.samples.force_at(i), self.samples.rate_at(i)),
        }
    }

    /// Mean specific force over samples, m/s².
    pub fn mean_force(&self, rows: Range<usize>) -> [f64; 3] {
        mean(rows, |i| self.force_at(i))
    }

    /// Mean angular rate over samples, rad/s.
    pub fn mean_rate(&self, rows: Range<usize>) -> [f64; 3] {
        mean(rows, |i| self.rate_at(i))
    }
}

fn mean(rows: Range<usize>, value: impl Fn(usize) -> [f64; 3]) -> [f64; 3] {
    let n = rows.len() as f64;
    let sum = rows.map(value).fold([0.0; 3], |sum: [f64; 3], v| {
        [sum[0] + v[0], sum[1] + v[1], sum[2] + v[2]]
    });
    sum.map(|s| s / n)
}

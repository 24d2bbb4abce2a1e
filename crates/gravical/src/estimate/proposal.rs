//! The free poses that would improve a calibration most.

use crate::estimate::reliability::Reliability;
use crate::predicted;

/// A session, as far as it decides which pose comes next.
#[derive(Debug, Clone)]
pub struct Proposals {
    /// M⁻¹ of the calibration.
    pub matrix: [[f64; 3]; 3],
    /// Covariance of M and b.
    pub covariance: [[f64; 12]; 12],
    /// What an undetected error of one pose does; `None` if a method does not give it.
    pub reliability: Option<Reliability>,
    /// Directions of the poses so far.
    pub recorded: Vec<[f64; 3]>,
    /// Standard deviation of the length of a reading, m/s².
    pub noise: f64,
    /// Local gravity, m/s².
    pub gravity: f64,
    /// Twice a standard uncertainty of ‖a‖ up to this is good, m/s².
    pub good_mps2: f64,
}

/// A pose that is proposed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Proposal {
    /// Direction of the specific force.
    pub direction: [f64; 3],
    /// Predicted error of ‖a‖ once it is read, too, m/s².
    pub norm_error_mps2: f64,
    /// Effect of an undetected error of one pose then, m/s²; infinite if nothing limits it.
    pub undetected_mps2: f64,
}

impl Iterator for Proposals {
    type Item = Proposal;

    /// The direction in which ‖a‖ is known least; once that is good, the one that tests the other
    /// poses best. The session then contains it.
    fn next(&mut self) -> Option<Proposal> {
        let (matrix, gravity) = (&self.matrix, self.gravity);
        let (weakest, sd) = predicted::weakest(matrix, &self.covariance, gravity);
        let tests = 2.0 * sd <= self.good_mps2 && self.undetected() > self.good_mps2;
        let direction = self
            .reliability
            .as_ref()
            .filter(|_| tests)
            .and_then(|r| r.best_test(matrix, &self.recorded, self.noise, gravity))
            .unwrap_or(weakest);
        let h = predicted::sensitivity(matrix, direction, gravity);
        predicted::read_along(&mut self.covariance, &h, self.noise);
        let norm_error_mps2 = predicted::norm_error(matrix, &self.covariance, gravity)?;
        self.recorded.push(direction);
        self.reliability = self
            .reliability
            .as_ref()
            .map(|r| r.with_pose(matrix, direction, self.noise, gravity));
        Some(Proposal {
            direction,
            norm_error_mps2,
            undetected_mps2: self.undetected(),
        })
    }
}

impl Proposals {
    fn undetected(&self) -> f64 {
        let reliability = self.reliability.as_ref();
        reliability
            .and_then(|r| r.undetected(&self.matrix, self.gravity))
            .map_or(f64::INFINITY, |u| u.effect_mps2)
    }
}

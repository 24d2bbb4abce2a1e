//! How good a fit is: the numbers that decide, and the grade by them.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::fit::Fit;
use crate::trust::{Budget, GOOD_MPS2, LeftOut, NextPose, Undetected, WorstDirection};

/// Free poses that are proposed.
const PROPOSED: usize = 3;
/// Claimed error of ‖a‖, and effect of an error of one pose that nothing shows, up to which a result is
/// fair: 20 mg in m/s².
pub const FAIR_MPS2: f64 = 4.0 * GOOD_MPS2;
/// Predicted error (2σ over the sphere) beyond which a result that nothing verifies is poor: 50 mg in
/// m/s². Six faces placed by hand stay below.
pub const UNVERIFIED_MPS2: f64 = 10.0 * GOOD_MPS2;
/// A pose that is left out contradicts the others beyond so many of its own standard deviations.
pub const CONTRADICTION: f64 = 3.0;

/// What a person decides by, in m/s².
#[derive(Debug, Clone, PartialEq)]
pub struct Trust {
    /// Predicted error of ‖a‖, root mean square over the sphere.
    pub predicted_mps2: f64,
    /// … where it is largest.
    pub worst: WorstDirection,
    /// Error of each pose by a fit without it.
    pub left_out: Vec<Option<LeftOut>>,
    /// The error of one pose that does most harm unseen; none without poses.
    pub undetected: Option<Undetected>,
    /// Free poses that would improve the result most.
    pub next: Vec<NextPose>,
    /// Where the uncertainty comes from.
    pub budget: Option<Budget>,
}

/// Grade of a calibration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Grade {
    /// The error of ‖a‖ is at most 5 mg (95 %) in every direction, and an error of one pose that changes it
    /// by more would have been detected.
    Good,
    /// The same with 20 mg.
    Fair,
    /// An error of one pose would not have been detected.
    NotVerifiable,
    /// Anything else: the reasons of the verdict name it.
    Poor,
}

impl fmt::Display for Grade {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Grade::Good => "good",
            Grade::Fair => "fair",
            Grade::NotVerifiable => "not verifiable",
            Grade::Poor => "poor",
        })
    }
}

impl Fit {
    /// All of it.
    #[must_use]
    pub fn trust(&self) -> Trust {
        Trust {
            predicted_mps2: self.predicted_mps2(),
            worst: self.weakest(),
            left_out: self.left_out(),
            undetected: self.undetected(),
            next: self.next(PROPOSED),
            budget: self.budget(),
        }
    }
}

impl Trust {
    /// Root mean square of the errors of poses left out, and their number; none if no pose can be.
    #[must_use]
    pub fn left_out_rms(&self) -> Option<(f64, usize)> {
        let errors = self.left_out.iter().flatten();
        let count = errors.clone().count();
        let squares: f64 = errors.map(|e| e.error_mps2.powi(2)).sum();
        (count > 0).then(|| ((squares / count as f64).sqrt(), count))
    }

    /// The pose that the others contradict most, when they do: its number and its error over its
    /// standard deviation.
    #[must_use]
    pub fn contradiction(&self) -> Option<(usize, f64)> {
        let each = self.left_out.iter().enumerate();
        each.filter_map(|(k, left_out)| {
            let left_out = (*left_out)?;
            Some((k, left_out.error_mps2.abs() / left_out.sd_mps2))
        })
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .filter(|(_, z)| *z > CONTRADICTION)
    }

    /// The grade by these numbers; what is wrong with the session itself comes on top.
    #[must_use]
    pub fn grade(&self) -> Grade {
        let claimed = self.worst.error_mps2;
        let hidden = self.undetected.map_or(f64::INFINITY, |u| u.effect_mps2);
        if self.contradiction().is_some() {
            return Grade::Poor;
        }
        if self.left_out_rms().is_some() && hidden <= FAIR_MPS2 {
            return match claimed.max(hidden) {
                most if most <= GOOD_MPS2 => Grade::Good,
                most if most <= FAIR_MPS2 => Grade::Fair,
                _ => Grade::Poor,
            };
        }
        if 2.0 * self.predicted_mps2 <= UNVERIFIED_MPS2 {
            Grade::NotVerifiable
        } else {
            Grade::Poor
        }
    }
}

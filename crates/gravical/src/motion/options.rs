//! How motion is computed.

use super::intervals::check_intervals;
use crate::calibration_file::NoiseSection;
use crate::denoise::FilterSpec;
use crate::gravity::Gravity;
use crate::poses::face::AxisMap;
use crate::recording::Meter;
use crate::{Error, Result};

/// Highest angular rate of a walking foot in stance, rad/s.
const STANCE_RATE_RAD_S: f64 = 1.0;

/// How gravity is taken off the specific force.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GravityRemoval {
    /// The attitude is followed with the gyroscope, and levelled at every rest; without a
    /// gyroscope it stays about that of the rests.
    Strapdown,
    /// The same without the gyroscope, even if there is one.
    ConstantTilt,
    /// The mean of the first 500 rows is subtracted, nothing is rotated; the frame is the sensor's
    /// own. There is no zero-velocity update and no band.
    InitialMean,
}

/// How motion is computed.
#[derive(Debug, Clone)]
pub struct MotionOptions {
    /// How gravity is taken off. Default: strapdown.
    pub gravity_removal: GravityRemoval,
    /// Filters that the accelerometer runs through before gravity is taken off, in this order; rests
    /// are found without them. Each has to keep a constant. Default: none, since none of them makes
    /// the drift less.
    pub smooth: Vec<FilterSpec>,
    /// Whether velocity is zero at rests. Without it the first rest alone levels, and nothing corrects
    /// the drift after it. Default true.
    pub zero_velocity: bool,
    /// Rests given by hand, s; then none are searched. Default none; each has to end after it starts,
    /// the last may end at infinity.
    pub rests_s: Option<Vec<(f64, f64)>>,
    /// Use the past only, as if the samples came one by one. Default false.
    pub causal: bool,
    /// Highest angular rate of a walking foot in stance, rad/s; without one stances are not looked
    /// for. Default 1; range 0.01 to 5.
    pub stance_rate_rad_s: Option<f64>,
    /// Velocity of what is taken for the first rest, m/s, in the frame of the result: of a sensor that
    /// moves evenly at the start. Only without zero velocity. Default 0.
    pub v0_mps: Option<[f64; 3]>,
    /// Position at the start, m. Default 0.
    pub p0_m: [f64; 3],
    /// Noise of the sensor, for the bands; its N is used in place of what the rests show, where it is
    /// known of all axes. Default: by the rests.
    pub noise: Option<NoiseSection>,
    /// Local gravity, for judging the magnitude at rest. Default: that of the calibration, else
    /// standard.
    pub gravity: Option<Gravity>,
    /// Give the bands. Default true.
    pub bands: bool,
    /// How the board sits in its case. Default: as the case.
    pub axes: AxisMap,
    /// Ends the computation when it is [stopped](Meter::stop), with `io`. Default none.
    pub meter: Option<Meter>,
}

impl Default for MotionOptions {
    fn default() -> Self {
        MotionOptions {
            gravity_removal: GravityRemoval::Strapdown,
            smooth: Vec::new(),
            zero_velocity: true,
            rests_s: None,
            causal: false,
            stance_rate_rad_s: Some(STANCE_RATE_RAD_S),
            v0_mps: None,
            p0_m: [0.0; 3],
            noise: None,
            gravity: None,
            bands: true,
            axes: AxisMap::default(),
            meter: None,
        }
    }
}

impl MotionOptions {
    /// The procedure of the student report: Savitzky–Golay of window 5 and order 2, mean of the first
    /// 500 rows off, trapezoid; no attitude, no zero-velocity update.
    #[must_use]
    pub fn report() -> Self {
        MotionOptions {
            smooth: vec![FilterSpec::SavitzkyGolay {
                window: 5,
                order: 2,
                derivative: 0,
            }],
            ..Self::default()
        }
        .with_removal(GravityRemoval::InitialMean)
    }

    /// With gravity taken off in another way; zero velocity goes with it.
    #[must_use]
    pub fn with_removal(mut self, removal: GravityRemoval) -> Self {
        self.gravity_removal = removal;
        self.zero_velocity = removal != GravityRemoval::InitialMean;
        self
    }

    /// Checks ranges.
    ///
    /// # Errors
    ///
    /// `option-range` (usage); `rests-syntax` (usage) for a rest that is no number or ends before it
    /// starts.
    pub fn validate(&self) -> Result<()> {
        let wrong = |option, what: String| Err(Error::range(option, what));
        if self.gravity_removal == GravityRemoval::InitialMean {
            for (option, given) in [
                ("zero_velocity", self.zero_velocity),
                ("rests_s", self.rests_s.is_some()),
                ("causal", self.causal),
                ("v0_mps", self.v0_mps.is_some()),
                ("noise", self.noise.is_some()),
            ] {
                if given {
                    let what = "the mean of the first rows is subtracted, and nothing else corrects the drift";
                    return Err(Error::range(option, what.to_owned())
                        .with_hint("remove it, or subtract gravity by strapdown"));
                }
            }
        }
        for filter in &self.smooth {
            filter.validate()?;
            if !filter.keeps_constants() {
                return wrong(
                    "smooth",
                    format!("{filter} does not keep constants: its output is no acceleration"),
                );
            }
        }
        if self.causal && !self.smooth.is_empty() {
            let what = "filters use what comes later";
            return Err(Error::range("smooth", what.to_owned())
                .with_hint("remove the filters, or --causal"));
        }
        check_intervals(self.rests_s.as_deref().unwrap_or_default())?;
        if let Some(rate) = self.stance_rate_rad_s
            && !(0.01..=5.0).contains(&rate)
        {
            return wrong(
                "stance_rate_rad_s",
                format!("{rate} is not possible; 0.01 to 5 is"),
            );
        }
        for (option, vector) in [
            ("v0_mps", self.v0_mps.unwrap_or_default()),
            ("p0_m", self.p0_m),
        ] {
            if !vector.iter().all(|v| v.is_finite()) {
                return wrong(option, "three finite numbers are needed".to_owned());
            }
        }
        Ok(())
    }
}

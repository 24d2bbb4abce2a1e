//! How motion is computed.

use super::stance::STANCE_RATE_RAD_S;
use super::still::check_intervals;
use crate::calibration_file::NoiseSection;
use crate::denoise::FilterSpec;
use crate::gravity::Gravity;
use crate::recording::Meter;
use crate::segment::face::AxisMap;
use crate::{Error, Result};

/// How gravity is taken off the specific force.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GravityRemoval {
    /// The attitude is followed with the gyroscope from the tilt at rest, and
    /// corrected from both ends of each move; without a gyroscope the tilt goes
    /// from that of one rest to that of the next.
    Strapdown,
    /// The tilt stays what it was at the rest before the move.
    ConstantTilt,
    /// The mean of the first rows is subtracted, nothing is rotated; the frame is
    /// the sensor's own.
    InitialMean,
}

/// How motion is computed.
#[derive(Debug, Clone)]
pub struct MotionOptions {
    /// How gravity is taken off. Default: strapdown.
    pub gravity_removal: GravityRemoval,
    /// Rows at the start that [`GravityRemoval::InitialMean`] takes the mean of.
    /// Default 500; at least 2.
    pub initial_rows: usize,
    /// Filters that the accelerometer runs through before gravity is taken off, in
    /// this order; rests are found without them. Each has to keep a constant.
    /// Default: none, since none of them makes the drift less.
    pub smooth: Vec<FilterSpec>,
    /// Whether velocity is zero at rests. Default true.
    pub zero_velocity: bool,
    /// Rests given by hand, s; then none are searched. Default none; each has to end after it
    /// starts, the last may end at infinity.
    pub rests_s: Option<Vec<(f64, f64)>>,
    /// Angular rate that a walking foot in stance stays under, rad/s; without one stances are not
    /// looked for. Default 0.6; range 0.01 to 5.
    pub stance_rate_rad_s: Option<f64>,
    /// Velocity at the start, m/s, in the frame of the result; used where
    /// nothing rests, and without zero velocity. Default: it starts at rest, or its
    /// velocity follows from the first rest.
    pub v0_mps: Option<[f64; 3]>,
    /// Position at the start, m. Default 0.
    pub p0_m: [f64; 3],
    /// Noise of the sensor, for the bands; its N is used in place of what the rests show, where it
    /// is known of all axes. Default: by the rests.
    pub noise: Option<NoiseSection>,
    /// Local gravity, for judging the magnitude at rest. Default: that of the
    /// calibration, else standard.
    pub gravity: Option<Gravity>,
    /// Standard uncertainty of the recorder's clock, relative. Default 0.001: a
    /// ceramic resonator is off by up to 0.005, a crystal by 0.00005. Range 0 to
    /// 0.1.
    pub clock_error: f64,
    /// Without a gyroscope: how far the sensor tilts during a move, standard
    /// deviation in degrees. Default 0.5; range 0 to 45.
    pub tilt_change_deg: f64,
    /// Compute the bands. Default true.
    pub bands: bool,
    /// Keep what only figures want: velocity and position of the uncalibrated run
    /// sample by sample, and the drift of a recording at rest. Default false.
    pub keep_uncalibrated: bool,
    /// How the board sits in its case. Default: as the case.
    pub axes: AxisMap,
    /// Ends the computation when it is [stopped](Meter::stop), with `io`. Default none.
    pub meter: Option<Meter>,
}

impl Default for MotionOptions {
    fn default() -> Self {
        MotionOptions {
            gravity_removal: GravityRemoval::Strapdown,
            initial_rows: 500,
            smooth: Vec::new(),
            zero_velocity: true,
            rests_s: None,
            stance_rate_rad_s: Some(STANCE_RATE_RAD_S),
            v0_mps: None,
            p0_m: [0.0; 3],
            noise: None,
            gravity: None,
            clock_error: 1e-3,
            tilt_change_deg: 0.5,
            bands: true,
            keep_uncalibrated: false,
            axes: AxisMap::default(),
            meter: None,
        }
    }
}

impl MotionOptions {
    /// The procedure of the student report: Savitzky–Golay of window 5 and order
    /// 2, mean of the first 500 rows off, no attitude, no zero-velocity correction.
    #[must_use]
    pub fn report() -> Self {
        MotionOptions {
            gravity_removal: GravityRemoval::InitialMean,
            smooth: vec![FilterSpec::SavitzkyGolay {
                window: 5,
                order: 2,
                derivative: 0,
            }],
            zero_velocity: false,
            ..Self::default()
        }
    }

    /// The rows that the mean is over are all that is asked for a rest: nothing after
    /// them depends on another.
    #[must_use]
    pub fn rests_at_start(&self) -> bool {
        self.gravity_removal == GravityRemoval::InitialMean
            && !self.zero_velocity
            && self.rests_s.is_none()
    }

    /// Checks ranges.
    ///
    /// # Errors
    ///
    /// `option-range` (usage); `rests-syntax` (usage) for a rest that is no number or ends before
    /// it starts.
    pub fn validate(&self) -> Result<()> {
        let wrong = |option, what: String| Err(Error::range(option, what));
        if self.initial_rows < 2 {
            return wrong(
                "initial_rows",
                format!(
                    "{} is too few; a mean needs 2 rows at least",
                    self.initial_rows
                ),
            );
        }
        if !(0.0..=0.1).contains(&self.clock_error) {
            return wrong(
                "clock_error",
                format!("{} is not possible; 0 to 0.1 is", self.clock_error),
            );
        }
        if !(0.0..=45.0).contains(&self.tilt_change_deg) {
            return wrong(
                "tilt_change_deg",
                format!("{}° is not possible; 0 to 45° is", self.tilt_change_deg),
            );
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
        check_intervals(self.rests_s.as_deref().unwrap_or_default())?;
        if let Some(rate) = self.stance_rate_rad_s
            && !(0.01..=5.0).contains(&rate)
        {
            return wrong(
                "stance_rate_rad_s",
                format!("{rate} is not possible; 0.01 to 5 is"),
            );
        }
        let start = self.v0_mps.unwrap_or_default();
        if !start.iter().chain(&self.p0_m).all(|v| v.is_finite()) {
            let option = if self.p0_m.iter().all(|v| v.is_finite()) {
                "v0_mps"
            } else {
                "p0_m"
            };
            return wrong(option, "three finite numbers are needed".to_owned());
        }
        Ok(())
    }
}

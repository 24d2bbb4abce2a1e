//! Calibrated samples, and what is known of the sensor that made them.

use std::ops::Range;

use gravical_signal::{Channels, pieces, resolution, sampling_period};

use crate::odd::{Bridged, frozen};

/// No MEMS sensor reads more, m/s² and rad/s: a row beyond it is no measurement.
const MAX_FORCE_MPS2: f64 = 1e4;
const MAX_RATE_RAD_S: f64 = 1e3;
/// Times beyond it, s, lose the microsecond in an f64.
const MAX_TIME_S: f64 = 4e9;
/// Values that the resolution is taken from: enough that most neighbouring ones occur.
const RESOLUTION_VALUES: usize = 200_000;

/// Calibrated samples of an IMU, m/s² and rad/s, sensor axes.
#[derive(Debug, Clone)]
pub struct Samples {
    pub(crate) time_s: Vec<f64>,
    pub(crate) force: Vec<[f64; 3]>,
    /// Empty without a gyroscope.
    pub(crate) rate: Vec<[f64; 3]>,
    pub(crate) period_s: f64,
    pub(crate) pieces: Vec<Range<usize>>,
    resolution: [f64; 6],
    /// In the order of their ends.
    pub(crate) bridged: Vec<Bridged>,
    rows: Vec<usize>,
    frozen: Vec<Range<usize>>,
}

impl Samples {
    /// Takes rows of times (s), specific force (m/s²) and angular rate (rad/s; empty without a
    /// gyroscope); the shortest of them counts. `bridged` holds rows whose values were replaced
    /// ([`crate::bridge_odd`]).
    ///
    /// Rows that are no measurement are left out: values that are not finite or beyond any sensor, times
    /// that do not increase, and all channels repeating exactly for longer than noise allows (a hang).
    /// Where that leaves a hole there is a gap.
    #[must_use]
    pub fn new(
        time_s: &[f64],
        force_mps2: &[[f64; 3]],
        rate_rad_s: &[[f64; 3]],
        bridged: Vec<Bridged>,
    ) -> Samples {
        let has_gyro = !rate_rad_s.is_empty();
        let count = time_s.len().min(force_mps2.len());
        let count = if has_gyro {
            count.min(rate_rad_s.len())
        } else {
            count
        };
        let frozen = frozen(&time_s[..count], force_mps2, rate_rad_s);
        let mut samples = Samples {
            time_s: Vec::with_capacity(count),
            force: Vec::with_capacity(count),
            rate: Vec::with_capacity(if has_gyro { count } else { 0 }),
            period_s: 0.0,
            pieces: Vec::new(),
            resolution: [0.0; 6],
            bridged: Vec::new(),
            rows: Vec::new(),
            frozen,
        };
        let mut hangs = samples.frozen.clone().into_iter().peekable();
        for i in 0..count {
            while hangs.next_if(|h| h.end <= i).is_some() {}
            let hung = hangs.peek().is_some_and(|h| h.contains(&i));
            let later = samples.time_s.last().is_none_or(|last| *last < time_s[i]);
            let rate = rate_rad_s.get(i).copied().unwrap_or_default();
            let possible = time_s[i].abs() < MAX_TIME_S
                && force_mps2[i].iter().all(|v| v.abs() < MAX_FORCE_MPS2)
                && rate.iter().all(|v| v.abs() < MAX_RATE_RAD_S);
            if hung || !later || !possible {
                continue;
            }
            samples.time_s.push(time_s[i]);
            samples.force.push(force_mps2[i]);
            samples.rows.push(i);
            if has_gyro {
                samples.rate.push(rate);
            }
        }
        samples.period_s = sampling_period(&samples.time_s);
        samples.pieces = pieces(&samples.time_s, samples.period_s);
        samples.resolution = samples.resolutions();
        samples.bridged = bridged
            .into_iter()
            .filter_map(|b| samples.kept(b))
            .collect();
        samples.bridged.sort_by_key(|b| b.rows.end);
        samples
    }

    fn resolutions(&self) -> [f64; 6] {
        std::array::from_fn(|c| {
            let column = if c < 3 { &self.force } else { &self.rate };
            resolution(column.iter().take(RESOLUTION_VALUES).map(|v| v[c % 3]))
        })
    }

    /// What was bridged, in samples; none if no row of it was kept.
    fn kept(&self, bridged: Bridged) -> Option<Bridged> {
        let at = |row: usize| self.rows.partition_point(|r| *r < row);
        let rows = at(bridged.rows.start)..at(bridged.rows.end);
        (!rows.is_empty()).then_some(Bridged { rows, ..bridged })
    }

    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// True without samples.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }

    /// Their times, s.
    #[must_use]
    pub fn time_s(&self) -> &[f64] {
        &self.time_s
    }

    /// Rows in which all channels repeated: a sensor, or its bus, that hung.
    #[must_use]
    pub fn frozen_rows(&self) -> &[Range<usize>] {
        &self.frozen
    }

    /// The same for the detector of rests.
    #[must_use]
    pub fn channels(&self) -> Channels<'_> {
        Channels {
            time_s: &self.time_s,
            force_mps2: &self.force,
            rate_rad_s: &self.rate,
            period_s: self.period_s,
            pieces: &self.pieces,
            resolution: self.resolution,
        }
    }

    pub(crate) fn has_gyro(&self) -> bool {
        !self.rate.is_empty()
    }

    /// Samples in `seconds`.
    pub(crate) fn count_in(&self, seconds: f64) -> usize {
        (seconds / self.period_s.max(f64::MIN_POSITIVE)) as usize
    }

    /// The first sample that is `seconds` or more after sample `from`.
    pub(crate) fn after_s(&self, from: usize, seconds: f64) -> usize {
        let until_s = self.time_s[from] + seconds;
        self.time_s.partition_point(|t| *t < until_s)
    }

    /// Seconds from the first to the last sample of a span.
    pub(crate) fn duration_s(&self, span: &Range<usize>) -> f64 {
        if span.is_empty() {
            return 0.0;
        }
        self.time_s[span.end - 1] - self.time_s[span.start]
    }
}

/// One independent direction of the accelerometer's uncertainty, one standard deviation long:
/// δf = matrix · f + offset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForceDirection {
    /// Scale and cross-axis sensitivity, row-major.
    pub matrix: [[f64; 3]; 3],
    /// Bias, m/s².
    pub offset: [f64; 3],
}

/// How far the calibration may be off.
#[derive(Debug, Clone, PartialEq)]
pub struct CalibrationUncertainty {
    /// Of the accelerometer; the first twelve count.
    pub force: Vec<ForceDirection>,
    /// Of the gyroscope likewise, δω = matrix · ω; the first nine count.
    pub rate: Vec<[[f64; 3]; 3]>,
    /// Standard deviation of a bias of the accelerometer beyond `force`, m/s².
    pub force_bias_sd_mps2: f64,
    /// Standard deviation of the magnitude at the first rest against gravity, m/s²: that of gravity, and what
    /// the calibration leaves of the magnitude.
    pub gravity_sd_mps2: f64,
}

impl CalibrationUncertainty {
    /// Independent errors of single elements: relative scales and cross-axis terms of both sensors, and a
    /// bias of the accelerometer.
    #[must_use]
    pub fn independent(force_sd: f64, rate_sd: f64, bias_sd_mps2: f64) -> CalibrationUncertainty {
        let element = |k: usize, sd: f64| {
            let mut matrix = [[0.0; 3]; 3];
            matrix[k / 3][k % 3] = sd;
            matrix
        };
        let mut force: Vec<ForceDirection> = (0..9)
            .map(|k| ForceDirection {
                matrix: element(k, force_sd),
                offset: [0.0; 3],
            })
            .collect();
        force.extend((0..3).map(|axis| {
            let mut offset = [0.0; 3];
            offset[axis] = bias_sd_mps2;
            ForceDirection {
                matrix: [[0.0; 3]; 3],
                offset,
            }
        }));
        CalibrationUncertainty {
            force,
            rate: (0..9).map(|k| element(k, rate_sd)).collect(),
            force_bias_sd_mps2: 1e-3,
            gravity_sd_mps2: 0.05,
        }
    }
}

/// How motion is estimated.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionOptions {
    /// How far the calibration may be off.
    pub calibration: CalibrationUncertainty,
    /// Tilt that a move without a gyroscope may have, rad.
    pub tilt_sd_rad: f64,
    /// Relative error of the clock.
    pub clock_sd: f64,
    /// Highest angular rate of a foot in stance, rad/s; 0: no stances.
    pub max_stance_rate_rad_s: f64,
    /// Rests that are known, s; none: they are looked for.
    pub rests_s: Option<Vec<(f64, f64)>>,
    /// Use the past only. The bands inside a move are those after its end: a second into the rest that closes
    /// it, the noise of the whole move is known.
    pub causal: bool,
}

impl MotionOptions {
    /// Nothing is negative or no number.
    pub(crate) fn are_possible(&self) -> bool {
        let known = &self.calibration;
        let sizes = [
            self.tilt_sd_rad,
            self.clock_sd,
            self.max_stance_rate_rad_s,
            known.force_bias_sd_mps2,
            known.gravity_sd_mps2,
        ];
        let force = known.force.iter();
        let force = force.flat_map(|d| d.matrix.as_flattened().iter().chain(&d.offset));
        let rate = known.rate.iter().flat_map(|m| m.as_flattened());
        sizes.iter().all(|v| v.is_finite() && *v >= 0.0) && force.chain(rate).all(|v| v.is_finite())
    }
}

impl Default for MotionOptions {
    /// A calibrated accelerometer (0.02 %, 2 mm/s²) and a gyroscope by its data sheet (3 %, 2 % cross-axis).
    fn default() -> Self {
        MotionOptions {
            calibration: CalibrationUncertainty::independent(2e-4, 0.02, 2e-3),
            tilt_sd_rad: 0.5_f64.to_radians(),
            clock_sd: 1e-3,
            max_stance_rate_rad_s: 1.0,
            rests_s: None,
            causal: false,
        }
    }
}

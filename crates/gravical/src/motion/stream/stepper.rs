//! Motion of samples that arrive one by one.

use crate::apply::drift::Drift;
use crate::apply::sensor::Sensor;
use crate::recording::row::{ACCEL, GYRO, SLOTS, TEMPERATURE};
use crate::recording::rows::{Row, Text};
use crate::recording::{Finding, Recording};
use crate::{Error, Result};

use super::sink::Pipeline;
use super::{Begin, Calibrated, MotionOptions};
use crate::motion::MotionSample;

/// Readings of one sample, in the units of the recording that the stepper began with.
#[derive(Debug, Clone, Copy)]
pub struct Readings {
    /// Time, s, from any origin; `None` if samples are evenly spaced at the rate of that recording.
    pub t_s: Option<f64>,
    /// Specific force; NaN for a value that is missing: the sample is then left out.
    pub accel: [f64; 3],
    /// Angular rate; not used if that recording has no gyroscope.
    pub gyro: [f64; 3],
    /// Temperature, °C, or NaN.
    pub temperature_c: f64,
}

/// Velocity and position of samples that arrive one by one: what
/// [`motion_stream`](super::motion_stream) computes of a file, with its numbers.
///
/// # Example
///
/// ```
/// use gravical::motion::{MotionOptions, MotionStepper, Readings};
/// use gravical::recording::{ReadOptions, Recording, SampleColumns};
///
/// // Four seconds at rest tell units and noise.
/// let noise = |i: usize, k: usize| ((i * 7919 + k * 104_729) % 101) as f64 * 1e-4 - 5e-3;
/// let time: Vec<f64> = (0..400).map(|i| 0.01 * i as f64).collect();
/// let axis = |k: usize, g: f64| (0..400).map(|i| g + noise(i, k)).collect::<Vec<f64>>();
/// let (x, y, z) = (axis(0, 0.0), axis(1, 0.0), axis(2, 9.81));
/// let samples = SampleColumns { time: Some(&time), accel: [&x, &y, &z], ..Default::default() };
/// let first = Recording::from_samples("first", &samples, &ReadOptions::default())?;
/// let mut stepper = MotionStepper::new(&first, None, &MotionOptions::default())?;
/// // They are samples like all others; then it is pushed along x.
/// for i in 0..500 {
///     let push = if i >= 400 { 1.0 } else { 0.0 };
///     let row = i % 400;
///     stepper.update(&Readings {
///         t_s: Some(0.01 * i as f64),
///         accel: [x[row] + push, y[row], z[row]],
///         gyro: [f64::NAN; 3],
///         temperature_c: f64::NAN,
///     });
/// }
/// assert!((stepper.now().velocity_mps[0] - 1.0).abs() < 0.05);
/// # Ok::<(), gravical::Error>(())
/// ```
pub struct MotionStepper {
    sensor: Sensor,
    pipeline: Pipeline,
    findings: Vec<Finding>,
    count: u64,
    last: MotionSample,
}

impl MotionStepper {
    /// Begins with what `first` tells: its units, its rate, and the noise at a rest in it. Its
    /// samples are not taken: pass them to [`update`](Self::update), if they are part of the motion.
    ///
    /// # Errors
    ///
    /// Those of [`motion_stream`](super::motion_stream) for its first rows; `excerpt` (usage).
    pub fn new(
        first: &Recording,
        calibration: Option<Calibrated<'_>>,
        options: &MotionOptions,
    ) -> Result<Self> {
        options.validate()?;
        first.refuse_excerpt("read it as a whole")?;
        if first.rows() == 0 {
            return Err(Error::input("no-rows", "there are no rows"));
        }
        let stamped = first.time_s.is_some();
        let begin = Begin::of(first.clone(), calibration, options)?;
        let mut findings = begin.findings.clone();
        let drift = calibration.and_then(|c| Drift::of_recording(c.file, first, &mut Vec::new()));
        let pipeline = begin.pipeline(stamped, options, false, &mut findings)?;
        let sensor = Sensor::of(begin.accel, begin.gyro, options.axes).with_drift(drift);
        Ok(MotionStepper {
            sensor,
            pipeline,
            findings,
            count: 0,
            last: unknown(),
        })
    }

    /// Takes the next sample; false if it is left out because a value is missing or its time falls
    /// behind.
    pub fn update(&mut self, readings: &Readings) -> bool {
        let mut values = [f64::NAN; SLOTS];
        values[ACCEL..ACCEL + 3].copy_from_slice(&readings.accel);
        values[GYRO..GYRO + 3].copy_from_slice(&readings.gyro);
        values[TEMPERATURE] = readings.temperature_c;
        self.count += 1;
        let taken = self.pipeline.samples;
        let calibrated = self.sensor.calibrate(&values, self.count);
        let row = Row {
            line: self.count,
            text: Text::default(),
            values: &values,
            before: &[],
            t_s: readings.t_s.unwrap_or(f64::NAN),
            restarted: false,
        };
        self.pipeline.row(&row, calibrated, &mut Vec::new());
        if self.pipeline.samples == taken {
            return false;
        }
        let motion = &self.pipeline.motion;
        self.last = MotionSample {
            t_s: self.pipeline.last_s,
            force_mps2: motion.force_mps2(),
            still: self.pipeline.knows_rests && self.pipeline.rests(),
            attitude: motion.attitude(),
            acceleration_mps2: motion.acceleration_mps2(),
            velocity_mps: motion.velocity_mps(),
            position_m: motion.position_m(),
            ..unknown()
        };
        true
    }

    /// Something is missing before the next sample: what follows is not known before the next rest,
    /// and the position not any more.
    pub fn interrupt(&mut self) {
        self.pipeline.parted = true;
    }

    /// The last sample that was taken; NaN before the first. `raw_mps2` and the uncertainties are
    /// NaN: a band looks back from the far end.
    #[must_use]
    pub fn now(&self) -> &MotionSample {
        &self.last
    }

    /// Samples passed so far.
    #[must_use]
    pub fn samples(&self) -> u64 {
        self.count
    }

    /// What is odd about the recording that it began with.
    #[must_use]
    pub fn findings(&self) -> &[Finding] {
        &self.findings
    }
}

fn unknown() -> MotionSample {
    let none = [f64::NAN; 3];
    MotionSample {
        t_s: f64::NAN,
        raw_mps2: none,
        force_mps2: none,
        still: false,
        attitude: [f64::NAN; 4],
        acceleration_mps2: none,
        velocity_mps: none,
        position_m: none,
        sigma_velocity_mps: none,
        sigma_position_m: none,
    }
}

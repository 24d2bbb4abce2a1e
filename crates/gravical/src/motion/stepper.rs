//! Motion of samples that arrive one by one.

use gravical_motion::{SampleState, Stepper};

use super::estimate::engine_options;
use super::options::{GravityRemoval, MotionOptions};
use super::prepare::{Scales, SensorRows, scales};
use super::track::MotionSample;
use super::{Calibrated, Work};
use crate::recording::{Finding, Recording};
use crate::{Error, Result};

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

/// Velocity and position of samples that arrive one by one: the forward pass of
/// [`motion`](super::motion) with [`causal`](MotionOptions::causal), with its bands. What is no
/// measurement is not bridged, and gravity at the rests is not held against the calibration: both need
/// what comes later.
///
/// # Example
///
/// ```
/// use gravical::motion::{MotionOptions, MotionStepper, Readings};
/// use gravical::recording::{ReadOptions, Recording, TableColumn};
///
/// // Four seconds at rest tell units and noise.
/// let noise = |i: usize, k: usize| ((i * 7919 + k * 104_729) % 101) as f64 * 1e-4 - 5e-3;
/// let time: Vec<f64> = (0..400).map(|i| 0.01 * i as f64).collect();
/// let axis = |k: usize, g: f64| (0..400).map(|i| g + noise(i, k)).collect::<Vec<f64>>();
/// let (x, y, z) = (axis(0, 0.0), axis(1, 0.0), axis(2, 9.81));
/// let names = ["t", "ax", "ay", "az"].map(str::to_owned);
/// let columns = [&time, &x, &y, &z].map(|column| TableColumn::Numbers(column));
/// let first = Recording::from_table("first", &names, &columns, &ReadOptions::default())?;
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
/// assert!((stepper.now().state.velocity_mps[0] - 1.0).abs() < 0.05);
/// # Ok::<(), gravical::Error>(())
/// ```
pub struct MotionStepper {
    engine: Stepper,
    scales: Scales,
    /// The last temperature that came, °C; before one came the first one of the recording that it began with.
    held_c: f64,
    step_s: f64,
    p0_m: [f64; 3],
    findings: Vec<Finding>,
    count: u64,
    last: MotionSample,
}

impl MotionStepper {
    /// Begins with what `first` tells: its units and its rate. Its samples are not taken: pass them to
    /// [`update`](Self::update), if they are part of the motion.
    ///
    /// # Errors
    ///
    /// Those of [`motion`](super::motion); `option-range` (usage) for what needs the whole recording: rests
    /// that are given, no updates at rests, a noise file, the initial mean, filters.
    pub fn new(
        first: &Recording,
        calibration: Option<Calibrated<'_>>,
        options: &MotionOptions,
    ) -> Result<Self> {
        let options = &MotionOptions {
            causal: true,
            ..options.clone()
        };
        options.validate()?;
        if options.gravity_removal == GravityRemoval::InitialMean {
            let what = "a mean of rows is known after them only".to_owned();
            return Err(Error::range("gravity_removal", what));
        }
        if options.noise.is_some() {
            let what = "the noise is learned from the first rest".to_owned();
            return Err(Error::range("noise", what));
        }
        let file = calibration.map(|c| c.file);
        let mut findings = first.findings.clone();
        let scales = scales(first, file, options, &mut findings)?;
        let rows = SensorRows::new(first, &scales, &mut findings)?;
        let samples = rows.samples(&scales.calibrated)?;
        let work = Work {
            recording: first,
            file,
            options,
            scales: &scales,
            rests: None,
        };
        let calibration = work.calibration(&samples, work.directions(&samples));
        let engine = engine_options(options, calibration);
        let channels = samples.channels();
        let unknown = [f64::NAN; 3];
        let mut temperatures = first.temperature_c.iter().flatten();
        let first_c = temperatures.find(|t| t.is_finite());
        Ok(MotionStepper {
            engine: Stepper::new(&engine, channels.period_s, channels.resolution),
            held_c: first_c.copied().unwrap_or(f64::NAN),
            step_s: channels.period_s,
            scales,
            p0_m: options.p0_m,
            findings,
            count: 0,
            last: MotionSample {
                t_s: f64::NAN,
                raw_mps2: unknown,
                force_mps2: unknown,
                state: SampleState::UNKNOWN,
            },
        })
    }

    /// Takes the next sample; false if it is left out because a value is missing or beyond any sensor, or its
    /// time is not later.
    pub fn update(&mut self, readings: &Readings) -> bool {
        let t_s = readings.t_s.unwrap_or(self.count as f64 * self.step_s);
        self.count += 1;
        if readings.temperature_c.is_finite() {
            self.held_c = readings.temperature_c;
        }
        let (accel, gyro) = (readings.accel, readings.gyro);
        let (force, rate) = self.scales.calibrated.apply(accel, gyro, self.held_c);
        let Some(mut state) = self.engine.push(t_s, force, rate) else {
            return false;
        };
        for (position, start) in state.position_m.iter_mut().zip(self.p0_m) {
            *position += start;
        }
        self.last = MotionSample {
            t_s,
            raw_mps2: self.scales.nominal.apply(accel, gyro, f64::NAN).0,
            force_mps2: force,
            state,
        };
        true
    }

    /// Something is missing before the next sample.
    pub fn interrupt(&mut self) {
        self.engine.interrupt();
    }

    /// The last sample that was taken; NaN before the first, and what is not known before the first rest.
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

//! From a recording to samples: units, drift with temperature, values that are no measurement,
//! calibration, time.

use std::ops::Range;
use std::path::Path;

use gravical_core::calibration::{Calibration, GyroscopeCalibration};
use gravical_core::matrix3;
use gravical_motion::{Bridged, Samples, Sensor, bridge_odd, hung_rows};

use super::options::{GravityRemoval, MotionOptions};
use crate::calibration_file::{CalibrationFile, TemperatureModel};
use crate::denoise::{FilterSpec, smooth};
use crate::poses::face::AxisMap;
use crate::poses::gyro_unit::{Claims, Evidence, decide, mismatch};
use crate::poses::rests::find_rests;
use crate::poses::turns::motions;
use crate::recording::{Finding, FindingKind, Recording};
use crate::{Error, Result};
use gravical_recording::full_scale::FULL_SCALES_DEG_S;

/// Full scales of accelerometers, g.
const FULL_SCALES_G: [f64; 5] = [2.0, 4.0, 8.0, 16.0, 32.0];
/// Ends of the range of 16-bit counts.
const COUNTS: f64 = 32767.0;
/// Lower spikes may be motion: five times the noise of a hand at rest, m/s² and rad/s.
const MIN_SPIKE: [f64; 2] = [5.0, 5.0];

/// Channels of the file in the axes of the board, what is no measurement bridged, and what makes SI of
/// them.
pub(super) struct SensorRows<'a> {
    t_s: Vec<f64>,
    force: Vec<[f64; 3]>,
    rate: Vec<[f64; 3]>,
    bridged: Vec<Bridged>,
    /// Rows in which the sensor hung.
    pub hung: Vec<Range<usize>>,
    recording: &'a Recording,
    drift: Option<Drift<'a>>,
    scales: &'a Scales,
    axes: AxisMap,
}

/// Drift with temperature, as far as the calibration has a model of it.
struct Drift<'a> {
    model: &'a TemperatureModel,
    /// Temperature of each row, °C: the last one holds until the next comes.
    held_c: Vec<f64>,
}

impl<'a> SensorRows<'a> {
    /// The readings of `recording`; what is odd is added to `findings`.
    ///
    /// # Errors
    ///
    /// `rate-unknown` without time stamps and rate.
    pub fn new(
        recording: &'a Recording,
        file: Option<&'a CalibrationFile>,
        options: &MotionOptions,
        scales: &'a Scales,
        findings: &mut Vec<Finding>,
    ) -> Result<Self> {
        let t_s = times(recording)?;
        let rows = |channels: &[Vec<f64>; 3]| -> Vec<[f64; 3]> {
            (0..t_s.len())
                .map(|i| channels.each_ref().map(|c| c[i]))
                .collect()
        };
        let mut force = rows(&recording.accel);
        let gyro = recording.gyro.as_ref().filter(|_| scales.gyro.is_some());
        let mut rate = gyro.map(rows).unwrap_or_default();
        let hung = hung_rows(&t_s, &force, &rate);
        let mut bridged = Vec::new();
        let per_unit = [scales.by_scale.matrix[0][0], scales.rate_per_unit()];
        let full_scales: [Vec<f64>; 2] = [
            FULL_SCALES_G.iter().map(|g| g * 9.80665).collect(),
            FULL_SCALES_DEG_S.iter().map(|r| r.to_radians()).collect(),
        ];
        let sensors = [
            (Sensor::Accelerometer, &mut force),
            (Sensor::Gyroscope, &mut rate),
        ];
        for (k, (sensor, values)) in sensors.into_iter().enumerate() {
            let ranges = full_scales[k].iter().map(|end| end / per_unit[k]);
            let ranges: Vec<f64> = ranges.chain([COUNTS]).collect();
            let found = bridge_odd(&t_s, values, sensor, &ranges, MIN_SPIKE[k] / per_unit[k]);
            bridged.extend(found.into_iter().map(|b| Bridged {
                axis: options.axes.case_axis(b.axis),
                sd: b.sd * per_unit[k],
                ..b
            }));
        }
        // Calibrations take the numbers of the file.
        let offset = recording.zero_offset;
        force.iter_mut().flatten().for_each(|v| *v += offset);
        for row in hung.iter().cloned().flatten() {
            force[row] = [f64::NAN; 3];
        }
        Ok(SensorRows {
            drift: Drift::new(recording, file, findings),
            t_s,
            force,
            rate,
            bridged,
            hung,
            recording,
            scales,
            axes: options.axes,
        })
    }

    /// The same with the accelerometer filtered, after what is no measurement was bridged; and what the
    /// filters say.
    ///
    /// # Errors
    ///
    /// Those of the filters.
    pub fn smoothed(mut self, filters: &[FilterSpec]) -> Result<(Self, Vec<Finding>)> {
        let mut recording = self.recording.clone();
        for (c, column) in recording.accel.iter_mut().enumerate() {
            let rows = column.iter_mut().zip(&self.force);
            rows.for_each(|(v, force)| *v = force[c]);
        }
        let (filtered, findings) = smooth(recording, filters)?;
        for (row, force) in self.force.iter_mut().enumerate() {
            *force = filtered.accel_at(row);
        }
        Ok((self, findings))
    }

    /// Samples by the calibration.
    ///
    /// # Errors
    ///
    /// `no-samples` with fewer than two.
    pub fn calibrated(&self) -> Result<Samples> {
        let values = (self.force.clone(), self.rate.clone());
        let (accel, gyro) = (&self.scales.accel, self.scales.gyro.as_ref());
        self.samples(values, accel, gyro, self.drift.as_ref())
    }

    /// Samples by the nominal scales alone. The readings are not held beside them: a recording of hours fills
    /// memory with every copy of its columns.
    ///
    /// # Errors
    ///
    /// Those of [`calibrated`](Self::calibrated).
    pub fn by_scale(mut self) -> Result<Samples> {
        let values = (
            std::mem::take(&mut self.force),
            std::mem::take(&mut self.rate),
        );
        let (accel, gyro) = (&self.scales.by_scale, self.scales.by_gyro_scale.as_ref());
        self.samples(values, accel, gyro, None)
    }

    fn samples(
        &self,
        (mut force, mut rate): (Vec<[f64; 3]>, Vec<[f64; 3]>),
        accel: &Calibration<f64>,
        gyro: Option<&GyroscopeCalibration<f64>>,
        drift: Option<&Drift<'_>>,
    ) -> Result<Samples> {
        let at_reference = |row: usize, first: usize, raw: [f64; 3]| match drift {
            Some(d) => {
                std::array::from_fn(|c| d.model.at_reference(first + c, d.held_c[row], raw[c]))
            }
            None => raw,
        };
        for (row, force) in force.iter_mut().enumerate() {
            *force = accel.apply(at_reference(row, 0, *force));
        }
        let rate_axes = self.axes.of_rates();
        match gyro {
            Some(gyro) => {
                for (row, rate) in rate.iter_mut().enumerate() {
                    let own = gyro.apply(at_reference(row, 3, *rate), force[row]);
                    *rate = rate_axes.to_case(own);
                }
            }
            None => rate.clear(),
        }
        force.iter_mut().for_each(|f| *f = self.axes.to_case(*f));
        let samples = Samples::new(&self.t_s, &force, &rate, self.bridged.clone(), self.steps())
            .with_breaks(&self.recording.breaks);
        if samples.len() < 2 {
            return Err(Error::input(
                "no-samples",
                format!(
                    "{} of {} rows hold a complete sample; two at least are needed",
                    samples.len(),
                    self.t_s.len(),
                ),
            )
            .at(Path::new(&self.recording.name), None)
            .with_hint("`gravical inspect` shows what is in it"));
        }
        Ok(samples)
    }

    /// Steps that the values come in, m/s² and rad/s, in the axes of the case.
    fn steps(&self) -> [f64; 6] {
        let mut steps = [0.0; 6];
        let force = self.recording.accel_resolution();
        let rate = self.recording.gyro_resolution();
        for axis in 0..3 {
            let case = self.axes.case_axis(axis);
            steps[case] = force[axis] * self.scales.by_scale.matrix[0][0];
            if self.scales.gyro.is_some() {
                steps[3 + case] = rate[axis] * self.scales.rate_per_unit();
            }
        }
        steps
    }
}

/// Seconds of each row: the stamps, else rows over the rate.
fn times(recording: &Recording) -> Result<Vec<f64>> {
    if let Some(t) = &recording.time_s {
        return Ok(t.clone());
    }
    let Some(rate) = recording.timing.rate_hz() else {
        return Err(Error::input(
            "rate-unknown",
            "there are no usable time stamps, and no rate is stated",
        )
        .at(Path::new(&recording.name), None)
        .with_hint(
            "give the sampling rate with --rate HZ, or --time-unit where there are stamps",
        ));
    };
    Ok((0..recording.rows()).map(|i| i as f64 / rate).collect())
}

impl<'a> Drift<'a> {
    /// None where the calibration has no model, or the recording no temperature.
    fn new(
        recording: &Recording,
        file: Option<&'a CalibrationFile>,
        findings: &mut Vec<Finding>,
    ) -> Option<Self> {
        let model = file?.drift_model()?;
        let mut held_c = recording.temperature_c.clone().unwrap_or_default();
        let Some(mut now) = held_c.iter().copied().find(|t| t.is_finite()) else {
            let what = if held_c.is_empty() {
                "recording has no temperatures"
            } else {
                "recording's temperatures are empty"
            };
            findings.push(Finding::new(
                FindingKind::TemperatureNotApplied,
                format!(
                    "the {what}, so the calibration's drift with temperature is not taken off: {}",
                    crate::temperature::cost_text(model)
                ),
            ));
            return None;
        };
        for t in &mut held_c {
            if t.is_finite() {
                now = *t;
            }
            *t = now;
        }
        Some(Drift { model, held_c })
    }
}

/// What turns the file's numbers into SI.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scales {
    /// The accelerometer, as calibrated.
    pub accel: Calibration<f64>,
    /// The gyroscope, as calibrated; none where it is not used.
    pub gyro: Option<GyroscopeCalibration<f64>>,
    /// The gyroscope's own calibration is applied.
    pub gyro_calibrated: bool,
    /// The accelerometer by its nominal scale alone.
    pub by_scale: Calibration<f64>,
    /// The gyroscope likewise.
    pub by_gyro_scale: Option<GyroscopeCalibration<f64>>,
}

impl Scales {
    /// rad/s of one unit of the file; 0 without a gyroscope.
    pub fn rate_per_unit(&self) -> f64 {
        self.by_gyro_scale.map_or(0.0, |g| g.matrix[0][0])
    }
}

/// Units and calibrations, judged by the samples.
pub(super) fn scales(
    recording: &Recording,
    file: Option<&CalibrationFile>,
    options: &MotionOptions,
    findings: &mut Vec<Finding>,
) -> Result<Scales> {
    let coarse = find_rests(recording);

    // The accelerometer by its nominal scale.
    let nominal = recording.accel_scale.nominal();
    if let Some(file) = file {
        judge_unit(recording, file, &coarse, options, findings)?;
        findings.extend(file.poor_finding());
    }
    let nominal = match (nominal, file) {
        (Some(n), _) => n,
        // Of unknown counts the calibration knows the scale.
        (None, Some(file)) => file.accelerometer.mean_scale(),
        (None, None) => {
            return Err(Error::input(
                "unit-unknown",
                "the unit of the accelerometer is unknown, so there is no velocity in m/s",
            )
            .at(Path::new(&recording.name), None)
            .with_hint("say it with --accel-unit, and --accel-range for counts; or give a calibration with -c"));
        }
    };
    let by_scale = Calibration {
        matrix: matrix3::diagonal([1.0 / nominal; 3]),
        bias: [0.0; 3],
    };

    // The gyroscope.
    let scale = match &recording.gyro {
        // Nothing is turned: it has no part in the result.
        _ if options.gravity_removal != GravityRemoval::Strapdown => None,
        None => None,
        Some(gyro) if is_dead(gyro) => {
            findings.push(Finding::new(
                FindingKind::DeadGyro,
                "the gyroscope never changes; motion is computed without it",
            ));
            None
        }
        Some(_) => {
            let section = file.and_then(|f| f.gyroscope.as_ref());
            let evidence = Evidence::of(recording, &coarse, &motions(recording, &coarse));
            Claims::of(recording, section).map(|claims| decide(claims, &evidence, findings))
        }
    };
    let gyro_nominal = scale.and_then(|s| s.nominal());
    if scale.is_some() && gyro_nominal.is_none() {
        findings.push(Finding::new(
            FindingKind::GyroNotUsed,
            "the unit of the gyroscope is unknown, so it is not used: the tilt between rests is not measured; say it with --gyro-unit, and --gyro-range for counts",
        ));
    }
    let by_gyro_scale = gyro_nominal.map(|n| GyroscopeCalibration {
        matrix: matrix3::diagonal([1.0 / n; 3]),
        bias: [0.0; 3],
        g_sensitivity: [[0.0; 3]; 3],
    });
    let gyro_file = file
        .filter(|_| gyro_nominal.is_some())
        .and_then(|f| Some((f.gyroscope.as_ref()?, f.gyroscope_calibration()?)));
    let gyro_calibration = gyro_file.and_then(|(section, calibration)| {
        let differs = scale.and_then(|scale| mismatch(section, &scale));
        if let Some(why) = &differs {
            findings.push(Finding::new(
                FindingKind::UnitMismatch,
                format!("{why}; it is used uncalibrated"),
            ));
        }
        differs.is_none().then_some(calibration)
    });

    let by_scale = shifted(by_scale, -recording.zero_offset);
    Ok(Scales {
        accel: file.map_or(by_scale, CalibrationFile::accelerometer_calibration),
        gyro: gyro_calibration.or(by_gyro_scale),
        gyro_calibrated: gyro_calibration.is_some(),
        by_scale,
        by_gyro_scale,
    })
}

/// A calibration whose input has `by` added: the recording's columns have their
/// zero offset subtracted already, a calibration file takes the file's numbers.
fn shifted(mut calibration: Calibration<f64>, by: f64) -> Calibration<f64> {
    calibration.bias = calibration.bias.map(|b| b - by);
    calibration
}

fn is_dead(gyro: &[Vec<f64>; 3]) -> bool {
    gyro.iter().all(|channel| {
        let mut some = channel.iter().filter(|v| v.is_finite());
        let first = some.next();
        some.all(|v| Some(v) == first)
    })
}

/// Holds the unit against the calibration, by the magnitude of the stills.
fn judge_unit(
    recording: &Recording,
    file: &CalibrationFile,
    coarse: &[Range<usize>],
    options: &MotionOptions,
    findings: &mut Vec<Finding>,
) -> Result<()> {
    let apply = file.accelerometer_calibration();
    let whole = 0..recording.rows();
    let spans = if coarse.is_empty() {
        std::slice::from_ref(&whole)
    } else {
        coarse
    };
    let mut norms: Vec<f64> = spans
        .iter()
        .map(|rows| {
            let (mean, _) = crate::stats::moments(&recording.accel, rows.clone());
            matrix3::norm(&apply.apply(mean.map(|m| m + recording.zero_offset)))
        })
        .filter(|n| n.is_finite())
        .collect();
    if norms.is_empty() {
        return Ok(());
    }
    let gravity = options.gravity.map_or(file.gravity_mps2, |g| g.value_mps2);
    crate::calibration_file::judge_unit(file, recording, &mut norms, gravity, findings)
}

//! From a recording to samples: units, drift with temperature, calibration, time.

use std::path::Path;

use gravical_core::calibration::{Calibration, GyroscopeCalibration};

use super::Calibrated;
use super::options::MotionOptions;
use super::samples::Samples;
use super::scales::{Scales, scales};
use crate::calibration_file::CalibrationFile;
use crate::recording::{Finding, FindingKind, LineSpans, Recording};
use crate::segment::face::AxisMap;
use crate::{Error, Result};

/// A step that is longer than so many usual ones, and than [`GAP_S`], is a gap:
/// what happened in it is not known.
const GAP_STEPS: f64 = 5.0;

/// The shortest gap, s.
const GAP_S: f64 = 0.1;

/// Samples, and what they were made with.
pub(super) struct Prepared {
    /// As calibrated.
    pub samples: Samples,
    /// What is odd.
    pub findings: Vec<Finding>,
    /// From the file's numbers to SI.
    pub scales: Scales,
    /// Lines of rows that hold no sample.
    pub left_out: LineSpans,
}

/// Reads columns into samples.
pub(super) fn prepare(
    recording: &Recording,
    calibration: Option<Calibrated<'_>>,
    options: &MotionOptions,
) -> Result<Prepared> {
    let mut findings = Vec::new();
    let file = calibration.map(|c| c.file);
    let scales = scales(recording, file, options, &mut findings)?;
    let mut left_out = LineSpans::default();
    let told = (&mut left_out, &mut findings);
    let samples = with_scales(recording, file, options, &scales, told)?;
    Ok(Prepared {
        samples,
        findings,
        scales,
        left_out,
    })
}

/// The same for a recording whose scales are known; what is left out, and odd, is added.
pub(super) fn with_scales(
    recording: &Recording,
    file: Option<&CalibrationFile>,
    options: &MotionOptions,
    scales: &Scales,
    (left_out, findings): (&mut LineSpans, &mut Vec<Finding>),
) -> Result<Samples> {
    let times = times(recording)?;
    let drift_free = file.and_then(|f| without_drift(recording, f, findings));
    let source = Source {
        recording,
        times: &times,
        offset: recording.zero_offset,
        axes: &options.axes,
        channels: drift_free.as_ref(),
    };
    let samples = source.samples(&scales.accel, scales.gyro, left_out);
    if samples.len() < 2 {
        return Err(Error::input(
            "no-samples",
            format!(
                "{} of {} rows hold a complete sample; two at least are needed",
                samples.len(),
                recording.rows()
            ),
        )
        .at(Path::new(&recording.name), None)
        .with_hint("`gravical inspect` shows what is in it"));
    }
    Ok(samples)
}

/// Seconds of each row: the stamps, else rows over the rate.
pub(super) fn times(recording: &Recording) -> Result<Vec<f64>> {
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

/// Columns with the drift with temperature taken off, where the calibration has
/// a model and the recording a temperature.
fn without_drift(
    recording: &Recording,
    file: &CalibrationFile,
    findings: &mut Vec<Finding>,
) -> Option<Drifting> {
    let model = crate::check::accepted_model(file)?;
    let Some(temperature) = &recording.temperature_c else {
        findings.push(Finding::new(
            FindingKind::TemperatureNotApplied,
            format!(
                "the recording has no temperatures, so the calibration's drift with temperature is not taken off: {}",
                crate::temperature::cost_text(model)
            ),
        ));
        return None;
    };
    // The last temperature holds until the next comes.
    let first = temperature.iter().copied().find(|t| t.is_finite());
    let Some(mut now) = first else {
        findings.push(Finding::new(
            FindingKind::TemperatureNotApplied,
            format!(
                "the recording's temperatures are empty, so the calibration's drift with temperature is not taken off: {}",
                crate::temperature::cost_text(model)
            ),
        ));
        return None;
    };
    let held: Vec<f64> = temperature
        .iter()
        .map(|t| {
            if t.is_finite() {
                now = *t;
            }
            now
        })
        .collect();
    let corrected = |channel: usize, values: &[f64], offset: f64| -> Vec<f64> {
        values
            .iter()
            .zip(&held)
            .map(|(v, t)| crate::check::at_reference(model, channel, *t, v + offset) - offset)
            .collect()
    };
    let accel = std::array::from_fn(|i| corrected(i, &recording.accel[i], recording.zero_offset));
    let gyro = recording
        .gyro
        .as_ref()
        .map(|g| std::array::from_fn(|i| corrected(3 + i, &g[i], 0.0)));
    Some(Drifting { accel, gyro })
}

struct Drifting {
    accel: [Vec<f64>; 3],
    gyro: Option<[Vec<f64>; 3]>,
}

/// What samples are made from.
#[derive(Clone, Copy)]
struct Source<'a> {
    recording: &'a Recording,
    times: &'a [f64],
    offset: f64,
    axes: &'a AxisMap,
    channels: Option<&'a Drifting>,
}

impl Source<'_> {
    /// Steps of the calibrated values: an axis that is mixed of three has the root of
    /// the sum of their squares, which keeps the variance of rounding.
    fn resolution(
        &self,
        accel: &Calibration<f64>,
        gyro: Option<GyroscopeCalibration<f64>>,
    ) -> [f64; 6] {
        let mixed = |matrix: [[f64; 3]; 3], step: [f64; 3]| {
            let board = matrix.map(|row| {
                let squares = row.iter().zip(step).map(|(m, q)| (m * q).powi(2));
                squares.sum::<f64>().sqrt()
            });
            self.axes.to_case(board).map(f64::abs)
        };
        let [a, b, c] = mixed(accel.matrix, self.recording.accel_resolution());
        let [d, e, f] = gyro.map_or([0.0; 3], |g| {
            mixed(g.matrix, self.recording.gyro_resolution())
        });
        [a, b, c, d, e, f]
    }

    /// Samples in SI. Rows that are incomplete, or whose stamp falls behind, are
    /// noted in `left_out`.
    fn samples(
        &self,
        accel: &Calibration<f64>,
        gyro: Option<GyroscopeCalibration<f64>>,
        left_out: &mut LineSpans,
    ) -> Samples {
        let recording = self.recording;
        let rows = recording.rows();
        let force = self.channels.map_or(&recording.accel, |c| &c.accel);
        let rate = match self.channels {
            Some(c) => c.gyro.as_ref(),
            None => recording.gyro.as_ref(),
        };
        let gyro = gyro.zip(rate);
        let mut out = Samples {
            rate_rad_s: gyro.map(|_| std::array::from_fn(|_| Vec::with_capacity(rows))),
            resolution: self.resolution(accel, gyro.map(|(g, _)| g)),
            ..Samples::default()
        };
        let gap = gap_s(self.times);
        let rate_axes = self.axes.of_rates();
        let mut breaks = recording.breaks.iter().copied().peekable();
        let mut pending = false;
        let mut last = f64::NEG_INFINITY;
        for row in 0..rows {
            while breaks.next_if(|b| *b <= row).is_some() {
                pending = true;
            }
            let raw = [force[0][row], force[1][row], force[2][row]].map(|v| v + self.offset);
            let f = accel.apply(raw);
            let w = gyro.map(|(g, rate)| g.apply([rate[0][row], rate[1][row], rate[2][row]], f));
            let t = self.times[row];
            let complete = f.iter().chain(w.iter().flatten()).all(|v| v.is_finite())
                && t.is_finite()
                && t >= last;
            if !complete {
                left_out.push(recording.line(row));
                continue;
            }
            if (pending || t - last > gap) && !out.t_s.is_empty() {
                out.breaks.push(out.t_s.len());
            }
            (pending, last) = (false, t);
            out.t_s.push(t);
            out.row.push(row);
            let f = self.axes.to_case(f);
            (0..3).for_each(|i| out.force_mps2[i].push(f[i]));
            if let (Some(columns), Some(w)) = (&mut out.rate_rad_s, w) {
                let w = rate_axes.to_case(w);
                (0..3).for_each(|i| columns[i].push(w[i]));
            }
        }
        out
    }
}

/// A recording by nominal scales alone, row by row.
#[derive(Debug, Clone, Copy)]
pub(super) struct Nominal<'a> {
    recording: &'a Recording,
    accel: Calibration<f64>,
    gyro: Option<GyroscopeCalibration<f64>>,
    axes: AxisMap,
}

impl<'a> Nominal<'a> {
    /// The rows of `recording`.
    pub fn new(recording: &'a Recording, scales: &Scales, axes: AxisMap) -> Self {
        Nominal {
            recording,
            accel: scales.by_scale,
            gyro: scales.by_gyro_scale,
            axes,
        }
    }

    /// Specific force of a row, m/s².
    #[inline]
    pub fn force_at(&self, row: usize) -> [f64; 3] {
        let raw = self.recording.accel_at(row);
        let offset = self.recording.zero_offset;
        self.axes.to_case(self.accel.apply(raw.map(|v| v + offset)))
    }

    /// Angular rate of a row, rad/s; zero without a gyroscope.
    #[inline]
    pub fn rate_at(&self, row: usize) -> [f64; 3] {
        let read = self.gyro.as_ref().zip(self.recording.gyro.as_ref());
        read.map_or([0.0; 3], |(scale, gyro)| {
            // A nominal scale knows nothing of specific force.
            let rate = scale.apply([gyro[0][row], gyro[1][row], gyro[2][row]], [0.0; 3]);
            self.axes.of_rates().to_case(rate)
        })
    }
}

/// The shortest gap between stamps, s.
pub(super) fn gap_s(times: &[f64]) -> f64 {
    let mut steps: Vec<f64> = times
        .windows(2)
        .map(|w| w[1] - w[0])
        .filter(|step| *step > 0.0)
        .collect();
    let median = crate::stats::median(&mut steps).unwrap_or(f64::INFINITY);
    (GAP_STEPS * median).max(GAP_S)
}

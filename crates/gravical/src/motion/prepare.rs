//! From a recording to samples: units, drift with temperature, calibration, time.

use std::path::Path;

use gravical_core::calibration::{Calibration, GyroscopeCalibration};
use gravical_core::matrix3;

use super::Calibrated;
use super::gyro_unit::by_noise;
use super::options::{GravityRemoval, MotionOptions};
use super::samples::Samples;
use crate::calibration_file::CalibrationFile;
use crate::recording::{Finding, GyroUnit, LineSpans, Recording};
use crate::segment::face::AxisMap;
use crate::segment::still::{StillOptions, find_stills};
use crate::segment::turns::{decide_gyro_unit, motions};
use crate::{Error, Result};

/// A step that is longer than so many usual ones, and than [`GAP_S`], is a gap:
/// what happened in it is not known.
const GAP_STEPS: f64 = 5.0;

/// The shortest gap, s.
const GAP_S: f64 = 0.1;

/// Samples with and without the calibration.
pub(super) struct Prepared {
    /// As calibrated.
    pub samples: Samples,
    /// By nominal scales alone; none where that is the same.
    pub nominal: Option<Samples>,
    /// What is odd.
    pub findings: Vec<Finding>,
    /// From the file's numbers to SI.
    pub scales: Scales,
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
    /// By nominal scales alone.
    by_scale: Calibration<f64>,
    by_gyro_scale: Option<GyroscopeCalibration<f64>>,
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
    // Smoothed ones take the place of these.
    let with_nominal = file.is_some() && options.smooth.is_empty();
    let (samples, nominal) = with_scales(
        recording,
        file,
        options,
        &scales,
        with_nominal,
        &mut findings,
    )?;
    Ok(Prepared {
        samples,
        nominal,
        findings,
        scales,
    })
}

/// The same for a recording whose scales are known: samples as calibrated and,
/// where asked for, by nominal scales alone.
pub(super) fn with_scales(
    recording: &Recording,
    file: Option<&CalibrationFile>,
    options: &MotionOptions,
    scales: &Scales,
    with_nominal: bool,
    findings: &mut Vec<Finding>,
) -> Result<(Samples, Option<Samples>)> {
    let times = times(recording)?;
    let drift_free = file.and_then(|f| without_drift(recording, f, findings));
    let source = Source {
        recording,
        times: &times,
        offset: recording.zero_offset,
        axes: &options.axes,
        channels: drift_free.as_ref(),
    };
    let mut lines = LineSpans::default();
    let samples = source.samples(&scales.accel, scales.gyro, Some(&mut lines));
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
    if !lines.is_empty() {
        findings.push(
            Finding::note(
                "rows-left-out",
                "rows without a complete sample, or whose stamp does not advance; the steps go over them",
            )
            .at_lines(&lines),
        );
    }
    let nominal = with_nominal.then(|| {
        let plain = Source {
            channels: None,
            ..source
        };
        plain.samples(&scales.by_scale, scales.by_gyro_scale, None)
    });
    Ok((samples, nominal))
}

/// Units and calibrations, judged by the samples.
fn scales(
    recording: &Recording,
    file: Option<&CalibrationFile>,
    options: &MotionOptions,
    findings: &mut Vec<Finding>,
) -> Result<Scales> {
    let coarse = find_stills(recording, &StillOptions::short_rests()).spans;

    // The accelerometer by its nominal scale.
    let nominal = recording.accel_scale.nominal();
    if let Some(file) = file {
        judge_unit(recording, file, &coarse, options, findings)?;
        if file.verdict.grade == crate::calibration_file::Grade::Poor {
            findings.push(Finding::warning(
                "poor-calibration",
                format!(
                    "the calibration's own verdict is poor: {}",
                    file.verdict.reasons.join("; ")
                ),
            ));
        }
    }
    if recording.is_calibrated() && file.is_some() {
        findings.push(Finding::warning(
            "already-calibrated",
            "its columns are named as this program names calibrated ones: calibrating twice corrects twice",
        ));
    }
    let nominal = match (nominal, file) {
        (Some(n), _) => n,
        // Of unknown counts the calibration knows the scale.
        (None, Some(file)) => file.accelerometer.scale.iter().sum::<f64>() / 3.0,
        (None, None) => {
            return Err(Error::input(
                "unit-unknown",
                "the unit of the accelerometer cannot be told, so there is no velocity in m/s",
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
        // Nothing is turned, and no rest ends a move: it has no part in the result.
        _ if options.gravity_removal == GravityRemoval::StillMean && !options.zero_velocity => None,
        None => None,
        Some(gyro) if is_dead(gyro) => {
            findings.push(Finding::warning(
                "dead-gyro",
                "the gyroscope never changes; motion is computed without it",
            ));
            None
        }
        Some(_) => decide_gyro_unit(recording, &motions(recording, &coarse), findings)
            .map(|scale| by_noise(recording, &coarse, scale, findings)),
    };
    let gyro_nominal = scale.and_then(|s| s.nominal());
    if scale.is_some() && gyro_nominal.is_none() {
        findings.push(Finding::warning(
            "gyro-not-used",
            "the unit of the gyroscope cannot be told, so it is not used: the tilt between rests is not measured; say it with --gyro-unit, and --gyro-range for counts",
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
        let unit = scale.map_or(GyroUnit::Unknown, |s| s.unit);
        let differs = section.input_unit != GyroUnit::Unknown && section.input_unit != unit;
        if differs {
            findings.push(Finding::warning(
                "unit-mismatch",
                format!(
                    "the gyroscope is in {}, its calibration is for {}; it is used uncalibrated",
                    unit.name(),
                    section.input_unit.name()
                ),
            ));
        }
        (!differs).then_some(calibration)
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
    coarse: &[std::ops::Range<usize>],
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
            let (mean, _) = crate::segment::still::moments(&recording.accel, rows.clone());
            matrix3::norm(&apply.apply(mean.map(|m| m + recording.zero_offset)))
        })
        .filter(|n| n.is_finite())
        .collect();
    if norms.is_empty() {
        return Ok(());
    }
    let gravity = options.gravity.map_or(file.gravity_mps2, |g| g.value_mps2);
    let from = findings.len();
    crate::check::judge_unit(file, recording, &mut norms, gravity, findings)?;
    // A file is named once, at the end.
    findings[from..].iter_mut().for_each(|f| f.file = None);
    Ok(())
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
        findings.push(Finding::warning(
            "temperature-not-applied",
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
        findings.push(Finding::warning(
            "temperature-not-applied",
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
    /// Samples in SI. Rows that are incomplete, or whose stamp falls behind, are
    /// noted in `left_out`.
    fn samples(
        &self,
        accel: &Calibration<f64>,
        gyro: Option<GyroscopeCalibration<f64>>,
        mut left_out: Option<&mut LineSpans>,
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
            ..Samples::default()
        };
        let gap = gap_s(self.times);
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
                if let Some(lines) = &mut left_out {
                    lines.push(recording.line(row));
                }
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
                let w = self.axes.to_case(w);
                (0..3).for_each(|i| columns[i].push(w[i]));
            }
        }
        out
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

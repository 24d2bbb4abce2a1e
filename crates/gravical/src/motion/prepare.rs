//! From a recording to samples: units, drift with temperature, calibration, time.

use std::path::Path;

use gravical_core::matrix3;

use super::Calibrated;
use super::nominal::{Drift, Nominal};
use super::options::MotionOptions;
use super::samples::Samples;
use super::scales::{Scales, scales};
use crate::calibration_file::CalibrationFile;
use crate::recording::range_end::range_end;
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
    /// How they read by nominal scales alone; none where that is the same.
    pub nominal: Option<Nominal>,
    /// What is odd.
    pub findings: Vec<Finding>,
    /// From the file's numbers to SI.
    pub scales: Scales,
    /// Lines of rows that hold no sample.
    pub left_out: LineSpans,
}

/// Makes the columns of `recording` samples: they are taken, and what was said of them
/// stays.
pub(super) fn prepare(
    recording: &mut Recording,
    calibration: Option<Calibrated<'_>>,
    options: &MotionOptions,
) -> Result<Prepared> {
    let mut findings = Vec::new();
    let file = calibration.map(|c| c.file);
    let scales = scales(recording, file, options, &mut findings)?;
    let mut left_out = LineSpans::default();
    let reports = (&mut left_out, &mut findings);
    let (samples, nominal) = with_scales(recording, file, options, &scales, reports)?;
    Ok(Prepared {
        samples,
        nominal,
        findings,
        scales,
        left_out,
    })
}

/// The same for a recording whose scales are known; what is left out, and odd, is added.
pub(super) fn with_scales(
    recording: &mut Recording,
    file: Option<&CalibrationFile>,
    options: &MotionOptions,
    scales: &Scales,
    (left_out, findings): (&mut LineSpans, &mut Vec<Finding>),
) -> Result<(Samples, Option<Nominal>)> {
    let rows = recording.rows();
    let t_s = times(recording)?;
    recording.time_s = None;
    let drift = file.and_then(|f| Drift::new(recording, f, findings));
    let mut nominal = Nominal {
        accel: scales.accel.invert(),
        by_scale: scales.by_scale,
        gyro: scales.gyro,
        gyro_back: scales.gyro.and_then(|g| matrix3::inverse(&g.matrix)),
        by_gyro_scale: scales.by_gyro_scale,
        axes: options.axes,
        drift,
    };
    let samples = samples(recording, t_s, scales, &mut nominal, left_out);
    if samples.len() < 2 {
        return Err(Error::input(
            "no-samples",
            format!(
                "{} of {rows} rows hold a complete sample; two at least are needed",
                samples.len(),
            ),
        )
        .at(Path::new(&recording.name), None)
        .with_hint("`gravical inspect` shows what is in it"));
    }
    Ok((samples, file.map(|_| nominal)))
}

/// Seconds of each row: the stamps, which are taken, else rows over the rate.
pub(super) fn times(recording: &mut Recording) -> Result<Vec<f64>> {
    if let Some(t) = recording.time_s.take() {
        return Ok(t);
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

impl Drift {
    /// Takes the temperatures; none where the calibration has no model, or the recording
    /// no temperature.
    fn new(
        recording: &mut Recording,
        file: &CalibrationFile,
        findings: &mut Vec<Finding>,
    ) -> Option<Self> {
        let model = file.drift_model()?;
        let mut held_c = recording.temperature_c.take().unwrap_or_default();
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
        Some(Drift {
            model: model.clone(),
            held_c,
        })
    }
}

/// Samples in SI, in the place of the columns of `recording`. Rows that are incomplete, or
/// whose stamp falls behind, are noted in `left_out`.
fn samples(
    recording: &mut Recording,
    mut t_s: Vec<f64>,
    scales: &Scales,
    nominal: &mut Nominal,
    left_out: &mut LineSpans,
) -> Samples {
    let resolution = resolution(recording, scales, &nominal.axes);
    let ends = recording.gyro.as_ref().map_or([None; 3], |gyro| {
        gyro.each_ref()
            .map(|channel| range_end(channel, recording.gyro_scale))
    });
    let mut clipped = Vec::new();
    let mut force = std::mem::take(&mut recording.accel);
    let rate = recording.gyro.as_mut().map(std::mem::take);
    let mut gyro = scales.gyro.zip(rate);
    let gap = gap_s(&t_s);
    let (axes, rate_axes) = (nominal.axes, nominal.axes.of_rates());
    let mut breaks_before = recording.breaks.iter().copied().peekable();
    let mut breaks = Vec::new();
    let mut pending = false;
    let mut last = f64::NEG_INFINITY;
    let mut count = 0;
    for row in 0..t_s.len() {
        while breaks_before.next_if(|b| *b <= row).is_some() {
            pending = true;
        }
        let drift = &nominal.drift;
        let at_reference = |channel: usize, raw: f64| match drift {
            Some(d) => d.model.at_reference(channel, d.held_c[row], raw),
            None => raw,
        };
        let raw = std::array::from_fn(|c| at_reference(c, force[c][row] + recording.zero_offset));
        let f = scales.accel.apply(raw);
        let at_end = gyro.as_ref().is_some_and(|(_, rate)| {
            (0..3).any(|c| {
                ends[c].is_some_and(|[low, high]| !(low < rate[c][row] && rate[c][row] < high))
            })
        });
        let w = gyro.as_ref().map(|(g, rate)| {
            let raw = std::array::from_fn(|c| at_reference(3 + c, rate[c][row]));
            g.apply(raw, f)
        });
        let t = t_s[row];
        let complete =
            f.iter().chain(w.iter().flatten()).all(|v| v.is_finite()) && t.is_finite() && t >= last;
        if !complete {
            left_out.push(recording.line(row));
            continue;
        }
        if (pending || t - last > gap) && count > 0 {
            breaks.push(count);
        }
        (pending, last) = (false, t);
        if at_end {
            clipped.push(count);
        }
        t_s[count] = t;
        if let Some(drift) = &mut nominal.drift {
            drift.held_c[count] = drift.held_c[row];
        }
        let f = axes.to_case(f);
        (0..3).for_each(|c| force[c][count] = f[c]);
        if let (Some((_, rate)), Some(w)) = (&mut gyro, w) {
            let w = rate_axes.to_case(w);
            (0..3).for_each(|c| rate[c][count] = w[c]);
        }
        count += 1;
    }
    t_s.truncate(count);
    force.iter_mut().for_each(|c| c.truncate(count));
    let mut rate = gyro.map(|(_, rate)| rate);
    rate.iter_mut().flatten().for_each(|c| c.truncate(count));
    Samples {
        t_s,
        force_mps2: force,
        rate_rad_s: rate,
        breaks,
        resolution,
        clipped,
    }
}

/// Steps of the calibrated values: an axis that is mixed of three has the root of
/// the sum of their squares, which keeps the variance of rounding.
fn resolution(recording: &Recording, scales: &Scales, axes: &AxisMap) -> [f64; 6] {
    let mixed = |matrix: [[f64; 3]; 3], step: [f64; 3]| {
        let board = matrix.map(|row| {
            let squares = row.iter().zip(step).map(|(m, q)| (m * q).powi(2));
            squares.sum::<f64>().sqrt()
        });
        axes.to_case(board).map(f64::abs)
    };
    let [a, b, c] = mixed(scales.accel.matrix, recording.accel_resolution());
    let gyro = scales.gyro.filter(|_| recording.gyro.is_some());
    let [d, e, f] = gyro.map_or([0.0; 3], |g| mixed(g.matrix, recording.gyro_resolution()));
    [a, b, c, d, e, f]
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

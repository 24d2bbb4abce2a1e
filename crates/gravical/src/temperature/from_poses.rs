//! Temperature model of the accelerometer from the poses of a session, by the joint fit.

use crate::calibrate::{Estimate, MANY_POSES};
use crate::calibration_file::{
    CHANNELS, ChannelDrift, DriftVerdict, InputFile, ReferenceSource, TemperatureModel,
};
use crate::numfmt::milli_g;
use crate::recording::Recording;
use crate::segment::{Placement, Segmentation};
use crate::stats::standard_deviation;

use super::attach::{bring_to_reference, summary_finding};
use super::{LEAST_SPAN_C, study_if_any};

/// True where the poses are enough, and at temperatures far enough apart, to fit the drift of the
/// accelerometer with its other parameters: intervals in which the temperature changes while the
/// sensor lies still, which [`study`](super::study) needs, are then not needed.
#[must_use]
pub fn enough_poses(placements: &[Placement]) -> bool {
    let [low, high] = range_c(placements);
    let known = placements.iter().all(|p| p.temperature_c.is_some());
    known && placements.len() >= MANY_POSES && high - low > LEAST_SPAN_C
}

fn temperatures(placements: &[Placement]) -> impl Iterator<Item = f64> {
    placements.iter().filter_map(|p| p.temperature_c)
}

fn range_c(placements: &[Placement]) -> [f64; 2] {
    let outer = [f64::INFINITY, f64::NEG_INFINITY];
    temperatures(placements).fold(outer, |[l, h], t| [l.min(t), h.max(t)])
}

/// The drift of the accelerometer as the `estimate` of the session found it, and that of the
/// gyroscope from its static intervals. The means of the poses are converted to the temperature at
/// which bias and matrix are valid. None where the estimate tested no drift.
#[must_use]
pub(crate) fn from_poses(
    recordings: &[Recording],
    estimate: &Estimate,
    segmentation: &mut Segmentation,
) -> Option<TemperatureModel> {
    let test = estimate.drift_test()?;
    let poses = range_c(&segmentation.placements);
    let some: Vec<f64> = temperatures(&segmentation.placements).collect();
    let fitted = estimate.fit().and_then(gravical_fit::Fit::drift);
    let reference_c = some.iter().sum::<f64>() / some.len() as f64;
    let unit = recordings
        .first()
        .map_or("unknown", |r| r.accel_scale.unit.name());
    let (verdict, ending) = match fitted {
        Some(_) => (DriftVerdict::Corrected, ""),
        None => (DriftVerdict::NotCorrected, ": not by more than chance"),
    };
    let reason = format!(
        "fitted with the poses; with a drift the mean error of ‖a‖ at poses left out, an eighth of the session at a time, goes from {:.2} to {:.2} mg{ending}",
        milli_g(test.without_mps2),
        milli_g(test.with_mps2),
    );
    let channel = |axis: usize| ChannelDrift {
        channel: CHANNELS[axis].to_owned(),
        input_unit: unit.to_owned(),
        verdict,
        reason: reason.clone(),
        order: 1,
        r2_cooling_to_warming: None,
        r2_warming_to_cooling: None,
        slope: fitted.map(|d| d.per_c[axis]),
        slope_cooling: None,
        slope_warming: None,
        hysteresis: None,
        drift_rms: fitted.map_or(0.0, |d| d.per_c[axis].abs() * standard_deviation(&some)),
        residual_rms: None,
        coefficients: fitted.map_or_else(Vec::new, |d| vec![d.per_c[axis]]),
        scale_coefficients: Vec::new(),
        scale_observed: false,
    };
    let mut model = TemperatureModel {
        reference_c,
        reference_source: ReferenceSource::Session,
        range_c: poses,
        poses: some.len() as u32,
        sweeps: Vec::new(),
        channels: Vec::new(),
        inputs: InputFile::of(recordings),
    };
    if let Some(study) = study_if_any(recordings) {
        let study = study.about(reference_c);
        model.sweeps = study.sweeps;
        model.channels = study.channels.into_iter().skip(3).collect();
        if model.any_corrected() {
            model.range_c = study.range_c;
        }
    }
    model.channels.splice(0..0, (0..3).map(channel));
    segmentation
        .findings
        .push(summary_finding(&model, !segmentation.turns.is_empty()));
    let zero_offset = recordings.first().map_or(0.0, |r| r.zero_offset);
    for placement in &mut segmentation.placements {
        bring_to_reference(placement, &model, zero_offset);
    }
    Some(model)
}

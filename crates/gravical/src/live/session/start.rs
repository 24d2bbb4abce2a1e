//! The first seconds: columns and clock, then noise at rest and units.

use std::ops::Range;

use gravical_core::matrix3::norm;

use crate::Result;
use crate::calibration_file::GravitySource;
use crate::live::event::{Event, Rejection, WarningKind};
use crate::live::judge::{Fault, Means, Units, scatter};
use crate::live::stillness::{MAX_NOISE_AT_REST, Stillness, StillnessDetector};
use crate::live::words;
use crate::numfmt::count;
use crate::recording::Recording;
use crate::recording::units::{AccelUnit, GyroScale};
use gravical_recording::Sample;

use super::{Hold, HoldStage, Phase, Session};

/// A hold is looked back upon for this time before its capture, s.
const RUN_S: f64 = 40.0;
/// The columns and the clock are reported after this time, s.
const IDENTIFY_S: f64 = 1.0;

impl Session {
    pub(super) fn identify(&mut self, sample: &Sample) -> Result<()> {
        let untimed = sample.row as f64 >= IDENTIFY_S * Recording::ASSUMED_RATE_HZ;
        if sample.time_s < IDENTIFY_S && !untimed {
            return Ok(());
        }
        let Some(recording) = self.rows.recording().transpose()? else {
            return Ok(());
        };
        let rate_hz = recording.timing.rate_hz();
        self.rate_hz = rate_hz.unwrap_or(self.rate_hz);
        // A second is too short to say anything of the samples.
        let findings = recording.findings.into_iter();
        let notes = findings.filter(|f| !f.kind.is_of_samples());
        let notes: Vec<String> = notes.map(|f| f.message).collect();
        let unit = recording.accel_scale.unit;
        let rate = rate_hz.map_or("rate unknown".to_owned(), |r| format!("{r:.1} Hz"));
        let columns = count(recording.column_names.len(), "column");
        let gyro = recording.gyro_scale.map_or("no", |_| "with");
        let first = format!("{rate}, {columns}, {unit}, {gyro} gyroscope");
        let text = words::sentences(std::iter::once(&*first).chain(notes.iter().map(|n| &**n)));
        let event = Event::Identified {
            rate_hz,
            unit,
            gyro_unit: recording.gyro_scale.map(|g| g.unit),
        };
        self.emit(event, text);
        self.phase = Phase::Floor(StillnessDetector::new(
            self.rate_hz,
            recording.resolution,
            RUN_S + self.options.settle_s + self.options.capture_s,
        ));
        self.progress_s = self.now_s;
        let earlier: Vec<Sample> = self.rows.recent().copied().collect();
        earlier.iter().for_each(|s| self.detect(s));
        Ok(())
    }

    /// True once the noise at rest and the unit are known.
    pub(super) fn floor(&mut self, run: &Range<usize>, state: &Stillness) -> bool {
        let wanted_s = self.options.settle_s + self.options.floor_s;
        if (run.len() as f64) < wanted_s * self.rate_hz {
            return false;
        }
        let samples = self.rows.within(run);
        let means = Means::of(&samples);
        let norm = norm(&means.accel);
        if state.noise > MAX_NOISE_AT_REST * norm || self.hold.as_ref().is_some_and(Hold::is_over) {
            return false;
        }
        let Some(Ok(recording)) = self.rows.recording() else {
            return false;
        };
        let scale = recording.accel_scale;
        let gravity = self.options.gravity.value_mps2;
        // Counts of an unknown range are scaled by gravity itself.
        let counts = scale.unit == AccelUnit::Counts && scale.lsb_per_g.is_none();
        let Some(nominal) = scale.nominal().or(counts.then_some(norm / gravity)) else {
            if let Some(hold) = &mut self.hold {
                hold.stage = HoldStage::Refused;
                let fault = Fault::new(
                    Rejection::Units,
                    format!("‖a‖ at rest is {norm:.4}: gravity in no unit"),
                    "raw values are needed, with gravity; or give the unit with --accel-unit",
                );
                self.reject(fault);
            }
            return false;
        };
        let gyro_nominal = recording.gyro_scale.as_ref().and_then(GyroScale::nominal);
        let units = Units {
            zero_offset: recording.zero_offset,
            nominal,
            scale,
            gyro_nominal,
        };
        self.phase = match std::mem::replace(&mut self.phase, Phase::Identify) {
            Phase::Floor(detector) => Phase::Poses(detector, units),
            other => other,
        };
        let [x, y, z] = scatter(&samples).map(|v| self.mg(v));
        let limit_mg = self.mg(state.max_scatter[0]);
        let text = format!(
            "Noise at rest {x:.1}, {y:.1}, {z:.1} mg; above {limit_mg:.0} mg it counts as moving."
        );
        let event = Event::Floor {
            noise_mg: [x, y, z],
            limit_mg,
        };
        self.emit(event, text);
        if self.options.gravity.source == GravitySource::Standard {
            self.warn(
                WarningKind::Gravity,
                "local gravity is not known, so the scale is uncertain by 0.15 % (1σ): give the latitude, or the value",
            );
        }
        self.progress_s = self.now_s;
        self.ask();
        true
    }
}

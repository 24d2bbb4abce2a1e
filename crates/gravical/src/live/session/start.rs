//! The first seconds: columns and clock, then noise at rest and units.

use std::ops::Range;

use gravical_core::matrix3::norm;

use crate::calibration_file::GravitySource;
use crate::live::event::{Event, Rejection, State, WarningKind};
use crate::live::judge::{Fault, Means, Units, scatter};
use crate::recording::Recording;
use crate::recording::growing::Sample;
use crate::recording::units::{AccelUnit, GyroScale};
use crate::stills::{LiveState, LiveStills, MOST_NOISE_AT_REST};

use super::Session;

/// The columns and the clock are reported after this time, s.
const IDENTIFY_S: f64 = 1.0;

impl Session {
    pub(super) fn identify(&mut self, sample: &Sample) {
        let untimed = sample.row as f64 >= IDENTIFY_S * Recording::ASSUMED_RATE_HZ;
        if sample.t_s < IDENTIFY_S && !untimed {
            return;
        }
        let Some(summary) = self.reader.summary() else {
            return;
        };
        let (facts, timing) = (summary.facts, &summary.timing);
        self.rate_hz = timing.rate_hz().unwrap_or(self.rate_hz);
        let found = summary.found;
        let mut notes = [found.channels, found.clock, found.unit].concat();
        notes.extend(found.cells);
        self.emit(Event::Identified {
            rate_hz: timing.rate_hz(),
            jitter_ms: timing.jitter_s.map(|s| 1e3 * s),
            columns: self.reader.column_names(),
            unit: facts.accel.unit,
            counts_per_g: facts.accel.lsb_per_g,
            gyro_unit: facts.gyro.map(|g| g.unit),
            has_temperature: sample.temperature_c().is_finite(),
            notes: notes.into_iter().map(|f| f.message).collect(),
        });
        self.detector = Some(LiveStills::new(self.rate_hz));
        self.state = State::Floor;
        self.progress_s = self.now_s;
        let earlier: Vec<Sample> = self.rows.recent().copied().collect();
        earlier.iter().for_each(|s| self.detect(s));
    }

    /// True once the noise at rest and the unit are known.
    pub(super) fn floor(&mut self, run: &Range<usize>, state: &LiveState) -> bool {
        let wanted_s = self.options.settle_s + self.options.floor_s;
        if (run.len() as f64) < wanted_s * self.rate_hz {
            return false;
        }
        let samples = self.rows.within(run);
        let means = Means::of(&samples);
        let norm = norm(&means.accel);
        let Some(summary) = self
            .reader
            .summary()
            .filter(|_| state.noise <= MOST_NOISE_AT_REST * norm)
        else {
            return false;
        };
        let scale = summary.facts.accel;
        let gravity = self.options.gravity.value_mps2;
        // Counts of an unknown range are scaled by gravity itself.
        let counts = scale.unit == AccelUnit::Counts && scale.lsb_per_g.is_none();
        let Some(nominal) = scale.nominal().or(counts.then_some(norm / gravity)) else {
            if let Some(hold) = self.hold.as_mut().filter(|hold| !hold.over) {
                hold.over = true;
                let fault = Fault::new(
                    Rejection::Units,
                    format!("‖a‖ at rest is {norm:.4}: gravity in no unit"),
                    "raw values are needed, with gravity; or give the unit with --accel-unit",
                );
                self.reject(fault, run);
            }
            return false;
        };
        let gyro_nominal = summary.facts.gyro.as_ref().and_then(GyroScale::nominal);
        self.units = Some(Units {
            nominal,
            scale,
            gyro_nominal,
        });
        let steps = self.reader.resolution();
        let accel = scatter(&samples, Sample::accel);
        let gyro = scatter(&samples, Sample::gyro).map(f64::to_degrees);
        self.emit(Event::Floor {
            noise_mg: accel.map(|v| self.mg(v)),
            gyro_noise_deg_s: gyro_nominal
                .filter(|_| gyro.iter().all(|v| v.is_finite()))
                .map(|nominal| gyro.map(|v| v / nominal)),
            step_mg: [0, 1, 2].map(|i| self.mg(steps[i])),
            limit_mg: self.mg(state.most_scatter),
        });
        if self.options.gravity.source == GravitySource::Standard {
            self.warn(
                WarningKind::Gravity,
                "local gravity is not known, so the scale is uncertain by 0.15 % (1σ): give the latitude, or the value",
            );
        }
        self.state = State::Wait;
        self.progress_s = self.now_s;
        self.ask();
        true
    }
}

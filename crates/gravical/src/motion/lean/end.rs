//! What the pass comes to, as [`motion`](crate::motion::motion) would say it.

use super::sink::{Pass, Time};
use super::{Begin, way::Track};
use crate::apply::finish::{Done, Told};
use crate::motion::anchors::{Anchors, Side, Walk};
use crate::motion::assumed::{directions, force_at_rest, local_gravity, size_at_rest, still_mean};
use crate::motion::bands::LegNoise;
use crate::motion::path::Setup;
use crate::motion::plan::Stretch;
use crate::motion::result::{
    Ends, FinalState, MotionResult, Move, NoiseAtRest, Rates, Span, Uncalibrated,
};
use crate::motion::{Calibrated, MotionOptions, words};
use crate::recording::timing::{Claims, Timing, untimed};
use crate::recording::{Finding, ReadOptions, decide_accel};

impl Begin {
    /// The result; none where it asks for more than one pass has kept.
    pub(super) fn result(
        &self,
        mut done: Done<Pass>,
        read: &ReadOptions,
        calibration: Option<Calibrated<'_>>,
        options: &MotionOptions,
    ) -> Option<MotionResult> {
        done.sink.finish();
        let told = std::mem::take(&mut done.told);
        let (timing, mut findings) = self.of_recording(&done, told, read)?;
        let state = &done.sink.state;
        let way = &state.way;
        let track = way.calibrated.as_ref()?;
        // With less than two samples before the first break there is no leg.
        if way.samples < 2 || way.whole.is_some_and(|(last, _)| last == 0) {
            return None;
        }
        findings.extend(
            self.prepared
                .iter()
                .filter(|f| f.kind != "rows-left-out")
                .cloned(),
        );
        findings.extend(words::rows_left_out(&state.left_out));
        let rate_hz = timing.rate_hz();
        let time_s = self.head.time_s.as_deref();
        findings.extend(state.running.finish(rate_hz, time_s, timing.duration_s)?);

        // The first samples stand for all: a setup of them alone.
        let file = calibration.map(|c| c.file);
        let rests = &self.rests.spans;
        let (accel, gyro) = (self.rests.accel.as_ref(), self.rests.gyro.as_ref());
        let walk = Walk::of(accel, gyro, &way.weights);
        let size = size_at_rest(&way.head, rests, walk);
        let directions = directions(file, false, &way.head, size, options, &mut findings);
        let setup = Setup {
            samples: &way.head,
            stances: &[],
            walk,
            directions: &directions,
            removal: options.gravity_removal,
            mean: Some(still_mean(&way.head, options.still_rows, walk)),
            wobble: options.wobble_deg.to_radians(),
            clock_error: options.clock_error,
            v0: options.v0_mps.unwrap_or_default(),
            p0: options.p0_m,
            bands: options.bands,
        };
        findings.extend(words::start_velocity(options, !rests.is_empty()));
        let last = way.whole.map_or(way.samples - 1, |(last, _)| last);
        let lost = way.whole.is_some();
        let mut plan = vec![Stretch::Leg {
            from: 0,
            to: last,
            ends: Ends::FromRest,
            before: Some(0),
            after: None,
        }];
        let after = options
            .bands
            .then(|| setup.after_mean(&noise_of(&setup, track), track.tau_s(), &track.way()));
        let mut moves = vec![Move {
            start_s: way.first_s,
            end_s: way.whole.map_or(way.last_s, |(_, t_s)| t_s),
            ends: Ends::FromRest,
            displacement_m: Some(track.way()),
            sigma_m: after.as_ref().map(|a| a.sigma_move_m),
            uncalibrated_m: way.uncalibrated.as_ref().map(Track::way),
            peak_speed_mps: Some(track.peak_mps),
            path_m: Some(track.path_m),
            velocity_error_mps: None,
            missing_tilt_deg: None,
            usable: true,
            reason: None,
        }];
        if let Some((_, t_s)) = way.whole {
            moves.push(Move::lost(t_s, way.last_s, way.longest_gap_s));
            plan.push(Stretch::Lost {
                from: last,
                to: way.samples - 1,
                gap_s: way.longest_gap_s,
            });
        }
        findings.extend(words::circumstances(&setup, rests, &plan, &moves, options));
        let at_rest = force_at_rest(&way.head, rests, walk);
        let gravity = local_gravity(file, options);
        findings.extend(words::size(
            file.is_some(),
            at_rest,
            &gravity,
            &setup,
            &moves,
        ));
        for finding in &mut findings {
            finding.file.get_or_insert_with(|| self.head.name.clone());
        }
        findings.sort_by_key(|f| std::cmp::Reverse(f.severity));

        let place = |track: &Track| {
            let way = track.way();
            std::array::from_fn(|i| options.p0_m[i] + way[i])
        };
        let known = |v: [f64; 3]| (!lost && v.iter().all(|x| x.is_finite())).then_some(v);
        let after = after.filter(|_| !lost);
        let rows = done.ledger.rows;
        Some(MotionResult {
            input: self.head.name.clone(),
            calibration: calibration.map(|c| c.name.to_owned()),
            procedure: words::procedure(options, false),
            rate_hz: Rates {
                nominal: timing.nominal_rate_hz,
                r#true: timing.mean_rate_hz.or(timing.median_rate_hz),
            },
            duration_s: way.last_s - way.first_s,
            rows,
            rows_left_out: rows - way.samples as u64,
            frame: words::frame(options, rests.is_empty()),
            still: Span::of(&way.head.t_s, rests),
            noise: NoiseAtRest::of(&self.rests),
            moves,
            r#final: FinalState {
                position_m: (!lost).then(|| place(track)),
                sigma_m: after.as_ref().map(|a| a.sigma_m),
                velocity_mps: known(track.velocity()),
            },
            uncalibrated: way.uncalibrated.as_ref().map(|track| Uncalibrated {
                position_m: (!lost).then(|| place(track)),
                velocity_mps: known(track.velocity()),
            }),
            static_drift: None,
            budget_m: after.map(|a| a.budget),
            truth: None,
            findings,
        })
    }

    /// What [`read`](crate::recording::read) would say of stamps, cells and values, in
    /// its order.
    fn of_recording(
        &self,
        done: &Done<Pass>,
        told: Told,
        read: &ReadOptions,
    ) -> Option<(Timing, Vec<Finding>)> {
        let state = &done.sink.state;
        let rows = done.ledger.rows;
        // Of values that are held, as those of one sensor are where they are few, only the
        // recording as a whole knows how far.
        let few_rates = state.empty.gyro.iter().sum::<usize>() * 5 > rows as usize;
        let held = few_rates || state.empty.is_sparse(rows as usize);
        if state.beyond || told.given_up || held {
            return None;
        }
        let mut findings = self.read.clone();
        findings.extend(told.reading);
        let [low, high] = state.temperature_span_c;
        let claims = Claims {
            temperature_span_c: (high - low).max(0.0),
            ..self.claims
        };
        let (timing, of_stamps) = match &state.time {
            Time::Stamps { follower, steps } => steps.finish(&claims, follower.stamps())?,
            Time::Rows { .. } => {
                let timed = untimed(rows as usize, &claims, Vec::new());
                (timed.timing, timed.findings)
            }
        };
        findings.extend(of_stamps);
        let empty = state.empty.finding(rows as usize);
        let repeats_are_ours = empty.is_some();
        findings.extend(empty);
        let quiet = state.quiet.finish().map(|q| (q.norm, q.integers));
        let scale = decide_accel(quiet, false, self.accel_claim, read, &mut findings);
        if scale != self.head.accel_scale {
            return None;
        }
        let values = told.values.into_iter();
        findings.extend(values.filter(|f| !(repeats_are_ours && f.kind == "repeated-rows")));
        Some((timing, findings))
    }
}

/// Noise of the only leg, of which the setup knows the beginning.
fn noise_of(setup: &Setup<'_>, track: &Track) -> LegNoise {
    let rows = std::iter::once(0..setup.samples.len()).collect::<Vec<_>>();
    let start = Anchors::new(setup.samples, setup.walk).at(&rows, 0, Side::Last);
    let far = setup.samples.len() - 1;
    let leg = setup.leg(0, far, start, None, [1.0, 0.0, 0.0, 0.0]);
    LegNoise {
        total: track.tau_s(),
        ..setup.noise(&leg)
    }
}

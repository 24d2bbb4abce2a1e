//! From acceleration to velocity and position, with an error band.
//!
//! # Overview
//!
//! 1. `prepare`: units, drift with temperature, calibration, time → [`samples`].
//! 2. [`still`]: where the sensor rested, from the recording's own noise; `gate`:
//!    at constant speed it only seems so.
//! 3. `plan`: the legs between the rests, and what a gap has lost.
//! 4. `leg`: attitude from both ends, gravity off, trapezoid, velocity zero at
//!    rests. `path`: leg after leg.
//! 5. `bands`, `parameters`: what noise and the calibration's uncertainty make of
//!    it.
//!
//! # Example
//!
//! ```
//! use gravical::motion::{MotionOptions, motion};
//! use gravical::recording::{ReadOptions, read};
//! use gravical::simulate::{LineOptions, Scenario, SimulateOptions, simulate, write};
//!
//! let folder = tempfile::tempdir()?;
//! let options = SimulateOptions::new(Scenario::Line(LineOptions::default()));
//! write(&simulate(&options)?, folder.path(), false)?;
//!
//! let recording = read(&folder.path().join("line.csv"), &ReadOptions::default())?;
//! let result = motion(&recording, None, &MotionOptions::default())?.result;
//! let moved = result.moves[0].displacement_m.unwrap_or_default();
//! assert!((moved[1] - 0.7).abs() < 0.1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod anchors;
mod assumed;
mod bands;
mod drift;
mod gate;
mod leg;
mod opening;
mod options;
mod parameters;
mod path;
mod plan;
mod prepare;
mod result;
pub mod samples;
mod scales;
mod smoother;
pub mod stance;
pub mod still;
mod stream;
mod table;
pub mod truth;
mod walk;
mod words;

use std::ops::Range;

use crate::Result;
use crate::calibration_file::CalibrationFile;
use crate::denoise::smooth;
use crate::recording::{Finding, Recording};

use anchors::Walk;
use assumed::{force_at_rest, local_gravity, size_at_rest, still_mean};
use path::Setup;
use prepare::{Prepared, prepare, with_scales};

pub use options::{GravityRemoval, MotionOptions};
pub use result::*;
pub use stream::{Streamed, motion_stream};
pub use table::write_table;

/// Motion of a recording: the result, and the table behind it.
#[derive(Debug, Clone)]
pub struct Motion {
    /// What is said.
    pub result: MotionResult,
    /// Sample by sample.
    pub track: Track,
}

/// A calibration and the name it was given by.
#[derive(Debug, Clone, Copy)]
pub struct Calibrated<'a> {
    /// The file's content.
    pub file: &'a CalibrationFile,
    /// Its name, for messages.
    pub name: &'a str,
}

/// Velocity and position of `recording`.
///
/// # Errors
///
/// Input errors: `unit-mismatch` (a calibration for another unit, range or
/// sensor), `unit-unknown`, `rate-unknown`, `no-samples`. Usage: `option-range`.
/// What only costs accuracy is a finding: no gyroscope, no rest, a gap in a move.
pub fn motion(
    recording: &Recording,
    calibration: Option<Calibrated<'_>>,
    options: &MotionOptions,
) -> Result<Motion> {
    options.validate()?;
    let Prepared {
        samples,
        nominal,
        findings,
        scales,
        left_out,
    } = prepare(recording, calibration, options)?;
    let mut findings: Vec<Finding> = recording.findings.iter().cloned().chain(findings).collect();
    findings.extend(words::rows_left_out(&left_out));

    // Where does it rest, and which of the quiet stretches is a rest?
    options.rests.validate_for(&samples)?;
    let by_mean = options.gravity_removal == GravityRemoval::StillMean;
    let found = opening::rests(&samples, options);
    let file = calibration.map(|c| c.file);
    let (samples, nominal) = if options.smooth.is_empty() {
        (samples, nominal)
    } else {
        drop((samples, nominal));
        let (smooth, told) = smooth(recording.clone(), &options.smooth, options.edge)?;
        findings.extend(told);
        let told = (&mut Default::default(), &mut Vec::new());
        with_scales(&smooth, file, options, &scales, file.is_some(), told)?
    };
    let walk = Walk::new(found.accel.as_ref(), found.gyro.as_ref(), &samples);
    let mut rests = found.spans.clone();
    let size = size_at_rest(&samples, &rests, walk);
    let directions = assumed::directions(
        file,
        scales.gyro_calibrated,
        &samples,
        size,
        options,
        &mut findings,
    );
    let mut setup = Setup {
        samples: &samples,
        stances: &[],
        walk,
        directions: &directions,
        removal: options.gravity_removal,
        mean: None,
        wobble: options.wobble_deg.to_radians(),
        clock_error: options.clock_error,
        v0: options.v0_mps.unwrap_or_default(),
        p0: options.p0_m,
        // Without a rest nothing tells the noise, nor how far the tilt is off.
        bands: options.bands && (by_mean || !rests.is_empty()),
    };
    if by_mean {
        setup.mean = Some(still_mean(&samples, options.still_rows, walk));
    }
    if options.zero_velocity && options.rests.given_s.is_none() {
        rests = gated(&setup, rests, &mut findings);
    }
    // The first that was quiet may be no rest: then gravity is another one's.
    let again = if file.is_none() && rests.first() != found.spans.first() {
        let size = size_at_rest(&samples, &rests, walk);
        let calibrated = scales.gyro_calibrated;
        assumed::directions(None, calibrated, &samples, size, options, &mut findings)
    } else {
        Vec::new()
    };
    if !again.is_empty() {
        setup.directions = &again;
    }
    findings.extend(words::slow(&found, &walk, &samples, options));
    findings.extend(words::start_velocity(options, !rests.is_empty()));
    if options.zero_velocity && !rests.is_empty() {
        // After a rest the velocity is zero, whatever it was at the start.
        setup.v0 = [0.0; 3];
    }

    let stances = if options.zero_velocity {
        walk::stances(&setup, &mut rests, options)
    } else {
        Vec::new()
    };
    setup.stances = &stances;

    // Leg after leg.
    let mut legs_from = rests.clone();
    let plan = if by_mean && !options.zero_velocity {
        let rows = options.still_rows.min(samples.len());
        legs_from = std::iter::once(0..rows).collect();
        plan::whole(&samples)
    } else if !options.zero_velocity
        && options.v0_mps.is_some()
        && options.rests.given_s.is_none()
        && !rests.is_empty()
    {
        // What moves from the start is no rest; it levels all the same.
        plan::whole(&samples)
    } else {
        plan::plan(&samples, &rests, options.zero_velocity)
    };
    let mut path = setup.follow(&plan, &legs_from);
    let at_rest_only =
        path.moves.is_empty() || (rests.len() == 1 && rests[0].len() == samples.len());
    // Where the start alone can be a rest, the end itself is the drift.
    let at_rest_only = at_rest_only && !rests.is_empty() && !options.rests_at_start();
    let mut drift_track = (at_rest_only && options.keep_uncalibrated)
        .then(|| drift::static_track(&setup))
        .flatten();
    let mut plain_track = None;
    let uncalibrated = nominal.as_ref().map(|nominal| {
        let mut plain = Setup {
            samples: nominal,
            directions: &[],
            bands: false,
            ..setup
        };
        if setup.mean.is_some() {
            plain.mean = Some(still_mean(nominal, options.still_rows, walk));
        }
        if let Some(track) = &mut drift_track {
            let plain = drift::static_track(&plain);
            track.uncalibrated_m = plain.map_or_else(Vec::new, |p| p.position_m);
        }
        let other = plain.follow(&plan, &legs_from);
        let end = other.end;
        // One plan, hence the same moves.
        for (own, other) in path.moves.iter_mut().zip(&other.moves) {
            own.uncalibrated_m = other.displacement_m;
        }
        plain_track = options.keep_uncalibrated.then_some(UncalibratedTrack {
            velocity_mps: other.velocity,
            position_m: other.position,
        });
        Uncalibrated {
            position_m: end.and_then(|e| e.position_m),
            velocity_mps: end.and_then(|e| e.velocity_mps),
        }
    });

    findings.extend(words::circumstances(
        &setup,
        &rests,
        &plan,
        &path.moves,
        options,
    ));
    let static_drift = at_rest_only.then(|| drift::static_drift(&setup)).flatten();
    findings.extend(words::size(
        file.is_some(),
        force_at_rest(&samples, &rests, walk),
        &local_gravity(file, options),
        &setup,
        &path.moves,
    ));
    for finding in &mut findings {
        finding.file.get_or_insert_with(|| recording.name.clone());
    }
    findings.sort_by_key(|f| std::cmp::Reverse(f.severity));

    let t = &samples.t_s;
    let result = MotionResult {
        input: recording.name.clone(),
        calibration: calibration.map(|c| c.name.to_owned()),
        procedure: words::procedure(options, samples.rate_rad_s.is_some()),
        rate_hz: Rates {
            nominal: recording.timing.nominal_rate_hz,
            r#true: recording
                .timing
                .mean_rate_hz
                .or(recording.timing.median_rate_hz),
        },
        duration_s: t[t.len() - 1] - t[0],
        rows: recording.rows() as u64,
        rows_left_out: (recording.rows() - samples.len()) as u64,
        frame: words::frame(options, rests.is_empty()),
        still: Span::of(t, &rests),
        noise: NoiseAtRest::of(&found),
        moves: path.moves,
        r#final: path.end.unwrap_or(FinalState {
            position_m: None,
            sigma_m: None,
            velocity_mps: None,
        }),
        uncalibrated,
        static_drift,
        budget_m: path.budget,
        truth: None,
        findings,
    };
    let mut still = vec![false; samples.len()];
    for span in rests.iter().chain(&stances) {
        still[span.clone()].fill(true);
    }
    let raw = nominal.map_or_else(|| samples.force_mps2.clone(), |n| n.force_mps2);
    let track = Track {
        raw_mps2: raw,
        still,
        attitude: path.attitude,
        acceleration_mps2: path.acceleration,
        velocity_mps: path.velocity,
        position_m: path.position,
        sigma_velocity_mps: path.sigma_velocity,
        sigma_position_m: path.sigma_position,
        row: samples.row,
        t_s: samples.t_s,
        breaks: samples.breaks,
        force_mps2: samples.force_mps2,
        uncalibrated: plain_track,
        reference: None,
        static_drift: drift_track,
    };
    Ok(Motion { result, track })
}

/// The candidates that are rests, piece by piece.
fn gated(
    setup: &Setup<'_>,
    candidates: Vec<Range<usize>>,
    findings: &mut Vec<Finding>,
) -> Vec<Range<usize>> {
    let mut rests = Vec::new();
    for piece in setup.samples.pieces() {
        let own: Vec<Range<usize>> = candidates
            .iter()
            .filter(|c| piece.contains(&c.start))
            .cloned()
            .collect();
        let judged = gate::judge(setup.samples, &own, setup.directions, setup);
        findings.extend(words::gate(setup.samples, &judged));
        rests.extend(judged.into_iter().filter(|j| j.rest).map(|j| j.span));
    }
    rests
}

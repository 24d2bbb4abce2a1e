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
mod closure;
mod course;
mod drift;
mod gate;
mod hidden;
mod leg;
mod misfit;
mod nominal;
mod opening;
mod options;
mod parameters;
mod path;
mod plan;
mod prepare;
mod result;
#[doc(hidden)]
pub mod samples;
mod scales;
mod setup;
mod smoother;
#[doc(hidden)]
pub mod stance;
#[doc(hidden)]
pub mod still;
mod stream;
mod table;
pub mod truth;
mod unfollowed;
mod verdict;
mod walk;
mod words;

use std::ops::Range;
use std::path::Path;

use gravical_core::matrix3::norm;

use crate::calibration_file::CalibrationFile;
use crate::denoise::smooth;
use crate::recording::{Finding, Recording};
use crate::{Error, Result};

use anchors::RandomWalk;
use assumed::{Applied, force_at_rest, initial_mean, local_gravity};
use hidden::Hidden;
use path::Known;
use prepare::{Prepared, prepare, with_scales};
use samples::View;
use setup::Setup;
use still::{Noise, check_inside};

pub use hidden::VisibleMove;
pub use misfit::GravityMisfit;
pub use options::{GravityRemoval, MotionOptions};
pub use result::*;
pub use still::Intervals;
pub use stream::{MotionStepper, Readings, Streamed, motion_stream};
pub use table::{Table, write_table};

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

/// Velocity and position of `recording`, with all its samples in memory: for figures,
/// and for a comparison with a reference. [`motion_into`] keeps none.
///
/// # Errors
///
/// Those of [`motion_into`].
pub fn motion(
    recording: &Recording,
    calibration: Option<Calibrated<'_>>,
    options: &MotionOptions,
) -> Result<Motion> {
    let mut track = Track::default();
    let mut recording = recording.clone();
    let (result, more) = compute(&mut recording, calibration, options, Some(&mut track))?;
    (track.uncalibrated, track.static_drift) = more;
    Ok(Motion { result, track })
}

/// Velocity and position of `recording`; its samples go to `sink`, where there is one, and
/// are not kept. The columns of the recording are taken, so that they are not held twice;
/// what was said of them stays.
///
/// # Errors
///
/// Input errors: `unit-mismatch` (a calibration for another unit, range or
/// sensor), `unit-unknown`, `rate-unknown`, `no-samples`. Usage: `option-range`.
/// What only costs accuracy is a finding: no gyroscope, no rest, a gap in a move.
pub fn motion_into(
    recording: &mut Recording,
    calibration: Option<Calibrated<'_>>,
    options: &MotionOptions,
    sink: Option<&mut dyn MotionSink>,
) -> Result<MotionResult> {
    Ok(compute(recording, calibration, options, sink)?.0)
}

/// What a figure shows beside the samples.
type ForFigures = (Option<UncalibratedTrack>, Option<DriftTrack>);

fn compute(
    recording: &mut Recording,
    calibration: Option<Calibrated<'_>>,
    options: &MotionOptions,
    sink: Option<&mut dyn MotionSink>,
) -> Result<(MotionResult, ForFigures)> {
    options.validate()?;
    let rows = recording.rows();
    // Filters see all rows, also those that hold no sample.
    let unfiltered = (!options.smooth.is_empty()).then(|| recording.clone());
    let Prepared {
        mut samples,
        mut nominal,
        findings,
        scales,
        left_out,
    } = prepare(recording, calibration, options)?;
    let mut findings: Vec<Finding> = recording.findings.iter().cloned().chain(findings).collect();
    findings.extend(words::rows_left_out(&left_out));

    // Where does it rest, and which of the quiet stretches is a rest?
    check_inside(&samples, options.rests_s.as_deref().unwrap_or_default())?;
    let by_mean = options.gravity_removal == GravityRemoval::InitialMean;
    let found = opening::rests(&samples, options);
    let file = calibration.map(|c| c.file);
    if let Some(recording) = unfiltered {
        let clipped = std::mem::take(&mut samples.clipped);
        drop(samples);
        let (mut smooth, smoothing) = smooth(recording, &options.smooth)?;
        findings.extend(smoothing);
        let ignored = (&mut Default::default(), &mut Vec::new());
        (samples, nominal) = with_scales(&mut smooth, file, options, &scales, ignored)?;
        samples.clipped = clipped;
    }
    let view = View::calibrated(&samples);
    let walk = RandomWalk::new(found.accel.as_ref(), found.gyro.as_ref(), &samples);
    let (walk, noise_used) = walk.with_noise(options);
    findings.extend(noise_used.map(|finding| finding.in_file(&recording.name)));
    let mut rests = found.spans.clone();
    let applied = Applied {
        file,
        scales: &scales,
        samples: &samples,
        nominal: nominal.as_ref(),
        walk,
    };
    let directions = assumed::directions(&applied, &rests, options);
    let setup = Setup {
        view,
        stances: &[],
        walk,
        rides: &[],
        directions: &directions,
        removal: options.gravity_removal,
        mean: by_mean.then(|| initial_mean(view, options.initial_rows, walk)),
        wobble: options.tilt_change_deg.to_radians(),
        clock_error: options.clock_error,
        v0: options.v0_mps.unwrap_or_default(),
        p0: options.p0_m,
        hidden: Hidden::new(&walk, &samples, &rests),
        // Without a rest nothing tells the noise, nor how far the tilt is off.
        bands: options.bands && (by_mean || !rests.is_empty()),
        meter: options.meter.as_ref(),
    };
    let go_on = || match setup.is_stopped() {
        true => Err(Error::io(
            Path::new(&recording.name),
            std::io::Error::other("its motion was stopped"),
        )),
        false => Ok(()),
    };
    go_on()?;
    let mut rides = Vec::new();
    if options.zero_velocity && options.rests_s.is_none() {
        (rests, rides) = gated(&setup, &rests, found.accel.as_ref(), &mut findings);
        go_on()?;
    }
    // The first that was quiet may be no rest: then gravity is another one's.
    let mut directions = if rests.first() == found.spans.first() {
        directions.clone()
    } else {
        assumed::directions(&applied, &rests, options)
    };
    let doubts = assumed::doubts(&applied, &rests, &directions, recording, options);
    directions.extend(doubts.directions);
    findings.extend(doubts.findings);
    let mut setup = Setup {
        directions: &directions,
        rides: &rides,
        ..setup
    };
    findings.extend(words::slow(&found, options));
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
    let unfounded = words::unfounded(&samples, &rests, options);
    setup.bands &= unfounded.is_none();
    setup.hidden = Hidden::new(&walk, &samples, &rests);

    // Leg after leg.
    let mut legs_from = rests.clone();
    let mut plan = if by_mean && !options.zero_velocity {
        let rows = options.initial_rows.min(samples.len());
        legs_from = std::iter::once(0..rows).collect();
        plan::whole(&samples)
    } else if !options.zero_velocity
        && options.v0_mps.is_some()
        && options.rests_s.is_none()
        && !rests.is_empty()
    {
        // What moves from the start is no rest; it levels all the same.
        plan::whole(&samples)
    } else {
        plan::plan(&samples, &rests, options.zero_velocity)
    };
    if setup.removal().follows() {
        unfollowed::without_unfollowed(&samples, &mut plan);
    }
    let mut path = match sink {
        Some(sink) => {
            let raw = nominal
                .as_ref()
                .map_or(view, |nominal| View::nominal(&samples, nominal));
            let mut still = Inside::new(rests.iter().chain(&stances));
            sink.begin(&samples.t_s, &samples.breaks, setup.bands);
            let mut give = |i: usize, known: &Known| {
                sink.sample(&MotionSample {
                    t_s: samples.t_s[i],
                    raw_mps2: raw.force_at(i),
                    force_mps2: samples.force_at(i),
                    still: still.contains(i),
                    attitude: known.attitude,
                    acceleration_mps2: known.acceleration,
                    velocity_mps: known.velocity,
                    position_m: known.position,
                    sigma_velocity_mps: known.sigma_velocity,
                    sigma_position_m: known.sigma_position,
                });
            };
            setup.follow(&plan, &legs_from, Some(&mut give))
        }
        None => setup.follow(&plan, &legs_from, None),
    };
    go_on()?;
    if let Some(reason) = &unfounded {
        for one in path.moves.iter_mut().filter(|m| m.usable) {
            (one.usable, one.reason) = (false, Some(reason.clone()));
        }
    }
    let visible_moves = match rests.is_empty() {
        true => Vec::new(),
        false => setup.hidden.table(),
    };
    let no_move = path.moves.is_empty();
    findings.extend(words::hidden(
        &setup.hidden,
        &visible_moves,
        no_move,
        options,
    ));
    let at_rest_only =
        path.moves.is_empty() || (rests.len() == 1 && rests[0].len() == samples.len());
    // Where the start alone can be a rest, the end itself is the drift.
    let at_rest_only = at_rest_only && !rests.is_empty() && !options.rests_at_start();
    let drift = at_rest_only.then(|| drift::static_drift(&setup)).flatten();
    let (static_drift, mut drift_track) = drift.unzip();
    let mut plain_track = None;
    let uncalibrated = nominal.as_ref().map(|nominal| {
        let view = View::nominal(&samples, nominal);
        let plain = Setup {
            view,
            directions: &[],
            bands: false,
            mean: setup
                .mean
                .map(|_| initial_mean(view, options.initial_rows, walk)),
            ..setup
        };
        if let Some(track) = &mut drift_track {
            let plain = drift::static_drift(&plain);
            track.uncalibrated_m = plain.map_or_else(Vec::new, |(_, p)| p.position_m);
        }
        // One plan, hence the same moves.
        let other = if options.keep_uncalibrated {
            let mut track = UncalibratedTrack {
                velocity_mps: Vec::with_capacity(samples.len()),
                position_m: Vec::with_capacity(samples.len()),
            };
            let mut keep = |_: usize, known: &Known| {
                track.velocity_mps.push(known.velocity);
                track.position_m.push(known.position);
            };
            let other = plain.follow(&plan, &legs_from, Some(&mut keep));
            plain_track = Some(track);
            other
        } else {
            plain.follow(&plan, &legs_from, None)
        };
        for (own, other) in path.moves.iter_mut().zip(&other.moves) {
            own.uncalibrated_m = other.displacement_m;
        }
        Uncalibrated {
            position_m: other.end.position_m,
            velocity_mps: other.end.velocity_mps,
        }
    });
    go_on()?;

    findings.extend(words::circumstances(
        &setup,
        &rests,
        &plan,
        &path.moves,
        options,
    ));
    if file.is_none()
        && let Some(force) = force_at_rest(&samples, &rests, walk)
    {
        let gravity = local_gravity(file, options);
        findings.extend(words::size(force, &gravity, &path.moves));
    }
    for finding in &mut findings {
        finding.file.get_or_insert_with(|| recording.name.clone());
    }
    findings.sort_by_key(|f| std::cmp::Reverse(f.severity));

    let t = &samples.t_s;
    let result = MotionResult {
        input: recording.name.clone(),
        calibration: calibration.map(|c| c.name.to_owned()),
        verdict: MotionVerdict::of(&path.moves, &path.end, doubts.misfit),
        procedure: words::procedure(options, samples.rate_rad_s.is_some()),
        rate_hz: Rates {
            nominal: recording.timing.nominal_rate_hz,
            r#true: recording
                .timing
                .mean_rate_hz
                .or(recording.timing.median_rate_hz),
        },
        duration_s: t[t.len() - 1] - t[0],
        rows: rows as u64,
        rows_left_out: (rows - samples.len()) as u64,
        frame: words::frame(options, rests.is_empty()),
        rests: Span::of(t, &rests),
        noise: NoiseAtRest::of(&found),
        visible_moves,
        gravity_misfit: doubts.misfit,
        moves: path.moves,
        r#final: path.end,
        uncalibrated,
        static_drift,
        budget_m: path.budget,
        truth: None,
        findings,
    };
    let drift_track = drift_track.filter(|_| options.keep_uncalibrated);
    Ok((result, (plain_track, drift_track)))
}

/// Which samples, asked for in order, lie in one of some spans.
struct Inside {
    spans: std::iter::Peekable<std::vec::IntoIter<Range<usize>>>,
}

impl Inside {
    fn new<'a>(spans: impl Iterator<Item = &'a Range<usize>>) -> Self {
        let mut spans: Vec<Range<usize>> = spans.cloned().collect();
        spans.sort_by_key(|s| s.start);
        Inside {
            spans: spans.into_iter().peekable(),
        }
    }

    fn contains(&mut self, i: usize) -> bool {
        while self.spans.next_if(|s| s.end <= i).is_some() {}
        self.spans.peek().is_some_and(|s| s.contains(&i))
    }
}

/// Rows that are quiet while the sensor moves, and how fast, m/s.
type Ride = (Range<usize>, f64);

/// The candidates that are rests, piece by piece, and those that are quiet at a speed.
fn gated(
    setup: &Setup<'_>,
    candidates: &[Range<usize>],
    noise: Option<&Noise>,
    findings: &mut Vec<Finding>,
) -> (Vec<Range<usize>>, Vec<Ride>) {
    let (mut rests, mut rides) = (Vec::new(), Vec::new());
    let mut from = 0;
    for piece in setup.view.samples.pieces() {
        let own = candidates[from..].partition_point(|c| c.start < piece.end);
        let judged = gate::judge(setup, &candidates[from..from + own], noise);
        from += own;
        findings.extend(words::gate(setup.view.samples, &judged));
        for one in judged {
            match one.rest {
                true => rests.push(one.span),
                false => rides.push((one.span, norm(&one.velocity))),
            }
        }
    }
    (rests, rides)
}

//! A motion sample by sample: one by one, as columns, and as a table.

use std::io::{self, Write};
use std::ops::Range;

use gravical_motion::SampleState;
use gravical_recording::write::write_fixed;

use super::estimate::Estimate;
use super::{Motion, MotionResult};

/// Names of the columns that are always there.
const COLUMNS: &str = "t_s,raw_ax_mps2,raw_ay_mps2,raw_az_mps2,\
    ax_mps2,ay_mps2,az_mps2,still,qw,qx,qy,qz,\
    lin_ax_mps2,lin_ay_mps2,lin_az_mps2,vx_mps,vy_mps,vz_mps,px_m,py_m,pz_m";

/// Names of those that come with bands.
const BANDS: &str = "sigma_vx_mps,sigma_vy_mps,sigma_vz_mps,sigma_px_m,sigma_py_m,sigma_pz_m";

/// Decimals of accelerations, velocities and positions: 1 µm is below any
/// uncertainty there is.
const DECIMALS: u32 = 6;

/// Decimals of the attitude. Whoever turns gravity with it makes an error of
/// g · 1e-8, 5 µm in 10 s.
const ATTITUDE_DECIMALS: u32 = 8;

/// How much text is gathered before it is written.
const CHUNK: usize = 1 << 18;

/// One sample of a motion. What is not known is NaN.
#[derive(Debug, Clone, Copy)]
pub struct MotionSample {
    /// Time, s.
    pub t_s: f64,
    /// Specific force by the nominal scale alone, m/s².
    pub raw_mps2: [f64; 3],
    /// Specific force, calibrated (and smoothed, where asked for), m/s².
    pub force_mps2: [f64; 3],
    /// Attitude, acceleration, velocity and position with their standard deviations, in the frame of the result.
    pub state: SampleState,
}

/// What figures and comparisons show, sample by sample; all columns are equally long. Where a
/// value is not known it is NaN.
#[derive(Debug, Clone, Default)]
pub struct Track {
    /// Time, s.
    pub t_s: Vec<f64>,
    /// Samples before which others are missing, or the recording is parted.
    pub breaks: Vec<usize>,
    /// Specific force by the nominal scale alone, m/s².
    pub raw_mps2: [Vec<f64>; 3],
    /// Specific force, calibrated (and smoothed, where asked for), m/s².
    pub force_mps2: [Vec<f64>; 3],
    /// Acceleration in the frame, gravity taken off, m/s².
    pub acceleration_mps2: Vec<[f64; 3]>,
    /// Velocity, m/s.
    pub velocity_mps: Vec<[f64; 3]>,
    /// Position, m.
    pub position_m: Vec<[f64; 3]>,
    /// Standard uncertainty of the velocity, m/s; empty without bands.
    pub sigma_velocity_mps: Vec<[f64; 3]>,
    /// Standard uncertainty of the position, m; empty without bands.
    pub sigma_position_m: Vec<[f64; 3]>,
    /// The same without the calibration; none without one.
    pub uncalibrated: Option<UncalibratedTrack>,
}

/// A reference on the clock and in the frame of the result, where both are known.
#[derive(Debug, Clone, Default)]
pub struct ReferenceTrack {
    /// Time, s.
    pub t_s: Vec<f64>,
    /// Position, m; it starts where the result is at that time.
    pub position_m: Vec<[f64; 3]>,
}

/// Velocity and position without the calibration, sample by sample; as long as the
/// columns of [`Track`].
#[derive(Debug, Clone, Default)]
pub struct UncalibratedTrack {
    /// Velocity, m/s.
    pub velocity_mps: Vec<[f64; 3]>,
    /// Position, m.
    pub position_m: Vec<[f64; 3]>,
}

impl Track {
    /// All samples of a motion.
    pub(super) fn new(motion: &Motion) -> Self {
        let pieces = motion.own.samples.pieces().iter();
        let mut track = Track {
            breaks: pieces.skip(1).map(|p| p.start).collect(),
            uncalibrated: motion.uncalibrated.as_ref().map(|plain| {
                let mut track = UncalibratedTrack::default();
                for state in known(plain, &motion.result) {
                    track.velocity_mps.push(state.velocity_mps);
                    track.position_m.push(state.position_m);
                }
                track
            }),
            ..Track::default()
        };
        for sample in motion.samples() {
            track.t_s.push(sample.t_s);
            for c in 0..3 {
                track.raw_mps2[c].push(sample.raw_mps2[c]);
                track.force_mps2[c].push(sample.force_mps2[c]);
            }
            let state = sample.state;
            track.acceleration_mps2.push(state.acceleration_mps2);
            track.velocity_mps.push(state.velocity_mps);
            track.position_m.push(state.position_m);
            if motion.bands {
                track.sigma_velocity_mps.push(state.velocity_sd_mps);
                track.sigma_position_m.push(state.position_sd_m);
            }
        }
        track
    }
}

/// The samples of a motion, in order.
pub(super) fn samples(motion: &Motion) -> impl Iterator<Item = MotionSample> {
    let own = &motion.own.samples;
    let raw = motion
        .uncalibrated
        .as_ref()
        .map_or(own, |plain| &plain.samples);
    known(&motion.own, &motion.result)
        .enumerate()
        .map(move |(i, state)| MotionSample {
            t_s: own.time_s()[i],
            raw_mps2: raw.force_mps2()[i],
            force_mps2: own.force_mps2()[i],
            state,
        })
}

/// The states of an estimate: in a move that is not usable only that it moves is known, and from there on no
/// position.
fn known<'a>(
    estimate: &'a Estimate,
    result: &MotionResult,
) -> impl Iterator<Item = SampleState> + 'a {
    let time_s = estimate.samples.time_s();
    let at = |t_s: f64| time_s.partition_point(|t| *t < t_s);
    let unusable: Vec<Range<usize>> = (result.moves.iter())
        .filter(|m| m.unusable.is_some())
        .map(|m| {
            // At its ends it may rest.
            let (from, to) = (at(m.start_s), at(m.end_s));
            let first = from + usize::from(from > 0);
            first..to + usize::from(to + 1 == time_s.len())
        })
        .collect();
    let mut next = 0;
    estimate.states().enumerate().map(move |(i, mut state)| {
        while unusable.get(next).is_some_and(|span| span.end <= i) {
            next += 1;
        }
        if unusable.get(next).is_some_and(|span| span.contains(&i)) {
            state = SampleState {
                at_rest: false,
                ..SampleState::UNKNOWN
            };
        }
        if unusable.first().is_some_and(|span| span.start <= i) {
            state.position_m = [f64::NAN; 3];
            state.position_sd_m = [f64::NAN; 3];
        }
        state
    })
}

/// Names of the columns of the table of a motion.
pub fn table_columns(motion: &Motion) -> impl Iterator<Item = &'static str> {
    let bands = motion.bands.then_some(BANDS).into_iter();
    COLUMNS
        .split(',')
        .chain(bands.flat_map(|names| names.split(',')))
}

/// Writes the table of a motion: CSV with a header, one row a sample, every column with its unit in its name.
///
/// `t_s`; `raw_ax_mps2` … specific force by the nominal scale alone; `ax_mps2` … calibrated; `still` 0 or 1;
/// `qw`, `qx`, `qy`, `qz` attitude, sensor → frame (Hamilton); `lin_ax_mps2` … acceleration in the frame
/// without gravity; `vx_mps` …, `px_m` …; with bands `sigma_vx_mps` …, `sigma_px_m` …. What is not known is an
/// empty field.
///
/// Time has 3, 6 or 9 decimals, the fewest that keep the recording's stamps; the attitude has 8, all
/// others have 6.
///
/// # Errors
///
/// What `out` says.
pub fn write_table(motion: &Motion, out: &mut dyn Write) -> io::Result<()> {
    let time_decimals = time_decimals(motion.own.samples.time_s());
    let mut text = Vec::with_capacity(CHUNK + 1024);
    text.extend(table_columns(motion).collect::<Vec<_>>().join(",").bytes());
    text.push(b'\n');
    for sample in motion.samples() {
        row(&mut text, &sample, time_decimals, motion.bands);
        if text.len() >= CHUNK {
            out.write_all(&text)?;
            text.clear();
        }
    }
    out.write_all(&text)?;
    out.flush()
}

#[inline]
fn row(text: &mut Vec<u8>, sample: &MotionSample, time_decimals: u32, bands: bool) {
    write_fixed(text, sample.t_s, time_decimals);
    put(text, &sample.raw_mps2, DECIMALS);
    put(text, &sample.force_mps2, DECIMALS);
    let state = &sample.state;
    text.extend_from_slice(if state.at_rest { b",1" } else { b",0" });
    put(text, &state.attitude, ATTITUDE_DECIMALS);
    put(text, &state.acceleration_mps2, DECIMALS);
    put(text, &state.velocity_mps, DECIMALS);
    put(text, &state.position_m, DECIMALS);
    if bands {
        put(text, &state.velocity_sd_mps, DECIMALS);
        put(text, &state.position_sd_m, DECIMALS);
    }
    text.push(b'\n');
}

#[inline]
fn put(text: &mut Vec<u8>, values: &[f64], decimals: u32) {
    for value in values {
        text.push(b',');
        write_fixed(text, *value, decimals);
    }
}

/// The fewest of 3, 6 and 9 decimals that keep every stamp to a nanosecond:
/// stamps in ms have three, those of 1024 Hz more than six.
fn time_decimals(t_s: &[f64]) -> u32 {
    for (decimals, power) in [(3, 1e3), (6, 1e6)] {
        let kept = |t: &f64| {
            let scaled = t * power;
            (scaled - scaled.round()).abs() <= 1e-9 * power
        };
        if t_s.iter().filter(|t| t.is_finite()).all(kept) {
            return decimals;
        }
    }
    9
}

//! A motion sample by sample: one by one, and as a table.

use std::io::{self, BufWriter, Write};
use std::ops::Range;

use gravical_motion::SampleState;
use gravical_recording::write::write_fixed;

use super::Motion;
use super::estimate::Estimate;

/// Names of the columns that are always there.
const COLUMNS: &str = "t_s,raw_ax_mps2,raw_ay_mps2,raw_az_mps2,\
    ax_mps2,ay_mps2,az_mps2,still,qw,qx,qy,qz,\
    lin_ax_mps2,lin_ay_mps2,lin_az_mps2,vx_mps,vy_mps,vz_mps,px_m,py_m,pz_m";

/// Where `still` is among them, before the attitude.
const STILL: usize = 7;

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
    /// Specific force, calibrated, m/s².
    pub force_mps2: [f64; 3],
    /// Attitude, acceleration, velocity and position, in the frame of the result, with their standard
    /// deviations where there are bands.
    pub state: SampleState,
}

impl MotionSample {
    /// In the order of the columns of the table.
    pub fn numbers(&self) -> impl Iterator<Item = f64> + use<> {
        let (s, [rx, ry, rz], [fx, fy, fz]) = (self.state, self.raw_mps2, self.force_mps2);
        let ([qw, qx, qy, qz], still) = (s.attitude, f64::from(s.at_rest));
        let first = [self.t_s, rx, ry, rz, fx, fy, fz, still, qw, qx, qy, qz];
        let vectors = [
            s.acceleration_mps2,
            s.velocity_mps,
            s.position_m,
            s.velocity_sd_mps,
            s.position_sd_m,
        ];
        first.into_iter().chain(vectors.into_iter().flatten())
    }
}

impl Motion {
    /// The samples, in order: computed as they are asked for.
    pub fn samples(&self) -> impl Iterator<Item = MotionSample> {
        let own = &self.own.samples;
        let plain = self.uncalibrated.as_ref();
        let raw = plain.map_or(own, |plain| &plain.samples);
        let states = self.states(&self.own).enumerate();
        states.map(move |(i, state)| MotionSample {
            t_s: own.time_s[i],
            raw_mps2: raw.force_mps2[i],
            force_mps2: own.force_mps2[i],
            state,
        })
    }

    /// The state at each sample without the calibration; none without one.
    pub fn uncalibrated_states(&self) -> Option<impl Iterator<Item = SampleState>> {
        self.uncalibrated.as_ref().map(|plain| self.states(plain))
    }

    /// The states of an estimate of these rows: in a move that is not usable only that it moves is known, and from
    /// there on no position.
    fn states<'a>(&self, estimate: &'a Estimate) -> impl Iterator<Item = SampleState> + use<'a> {
        let last = self.own.samples.len() - 1;
        let moves = self.own.motion.moves.iter().zip(&self.result.moves);
        let unusable = moves.filter(|(_, m)| m.unusable.is_some());
        // At its ends it may rest, but for those of the recording.
        let unusable = unusable.map(|(m, _)| {
            let Range { start, end } = m.samples;
            start + usize::from(start > 0)..end + usize::from(end == last)
        });
        let unusable: Vec<Range<usize>> = unusable.collect();
        let mut next = 0;
        let states = estimate.motion.states(&estimate.samples).enumerate();
        states.map(move |(i, mut state)| {
            next += usize::from(unusable.get(next).is_some_and(|m| m.end <= i));
            if unusable.get(next).is_some_and(|m| m.contains(&i)) {
                state = SampleState::UNKNOWN;
            }
            if unusable.first().is_some_and(|m| m.start <= i) {
                (state.position_m, state.position_sd_m) = ([f64::NAN; 3], [f64::NAN; 3]);
            }
            state
        })
    }

    /// Samples before which others are missing, or the recording is parted.
    pub fn breaks(&self) -> impl Iterator<Item = usize> {
        let pieces = &self.own.samples.pieces;
        pieces.iter().skip(1).map(|p| p.start)
    }
}

/// Names of the columns of the table of a motion.
#[doc(hidden)]
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
/// The attitude has 8 decimals, all others have 6.
///
/// # Errors
///
/// What `out` says.
pub fn write_table(motion: &Motion, out: &mut dyn Write) -> io::Result<()> {
    let names: Vec<&str> = table_columns(motion).collect();
    let mut decimals = vec![DECIMALS; names.len()];
    decimals[STILL] = 0;
    decimals[STILL + 1..][..4].fill(ATTITUDE_DECIMALS);
    let mut out = BufWriter::with_capacity(CHUNK, out);
    writeln!(out, "{}", names.join(","))?;
    let mut row = Vec::new();
    for sample in motion.samples() {
        row.clear();
        for (value, decimals) in sample.numbers().zip(&decimals) {
            write_fixed(&mut row, value, *decimals);
            row.push(b',');
        }
        row.pop();
        row.push(b'\n');
        out.write_all(&row)?;
    }
    out.flush()
}

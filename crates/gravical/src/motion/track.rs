//! A motion sample by sample: one by one, and as tables.

use std::io::{self, BufWriter, Write};
use std::ops::Range;

use gravical_motion::SampleState;
use gravical_recording::write::write_fixed;
use nalgebra::{Quaternion, UnitQuaternion};

use super::Motion;
use super::estimate::Estimate;

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
    /// Roll, pitch and yaw, degrees: R = R_z(yaw) R_y(pitch) R_x(roll); NaN where they are not known.
    pub fn roll_pitch_yaw_deg(&self) -> [f64; 3] {
        let [w, x, y, z] = self.state.attitude;
        if !w.is_finite() {
            return [f64::NAN; 3];
        }
        let attitude = UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z));
        let (roll, pitch, yaw) = attitude.euler_angles();
        [roll, pitch, yaw].map(f64::to_degrees)
    }

    /// Standard deviations of tilt, the angle between the true and the estimated vertical (its rms, so that twice that
    /// holds at least 95 %), and heading, the rotation about the vertical, degrees; NaN where they are not known.
    pub fn attitude_sd_deg(&self) -> [f64; 2] {
        let [x, y, z] = self.state.attitude_sd_rad;
        [x.hypot(y), z].map(f64::to_degrees)
    }
}

impl Motion {
    /// How many samples there are.
    pub fn rows(&self) -> usize {
        self.own.samples.len()
    }

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
    /// there on neither position nor heading.
    fn states<'a>(&self, estimate: &'a Estimate) -> impl Iterator<Item = SampleState> + use<'a> {
        let (last, has_gyro) = (self.own.samples.len() - 1, self.own.samples.has_gyro());
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
            let is_lost = unusable.first().is_some_and(|m| m.start <= i);
            if is_lost {
                (state.position_m, state.position_sd_m) = ([f64::NAN; 3], [f64::NAN; 3]);
            }
            // A rest levels; nothing tells where it headed.
            if is_lost || !has_gyro {
                state.attitude_sd_rad[2] = f64::NAN;
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

/// Columns that belong together: names, decimals, values.
#[derive(Debug)]
struct Columns {
    names: &'static str,
    decimals: u32,
    values: fn(&MotionSample, &mut Vec<f64>),
}

/// Columns with so many decimals.
const fn columns(
    names: &'static str,
    decimals: u32,
    values: fn(&MotionSample, &mut Vec<f64>),
) -> Columns {
    Columns {
        names,
        decimals,
        values,
    }
}

// 1 µm is below any uncertainty there is. Whoever turns gravity with an attitude of eight decimals makes an error of
// g · 1e-8, 5 µm in 10 s.
static TIME: Columns = columns("t_s", 6, |s, out| out.push(s.t_s));
static RAW: Columns = columns("raw_ax_mps2,raw_ay_mps2,raw_az_mps2", 6, |s, out| {
    out.extend(s.raw_mps2)
});
static FORCE: Columns = columns("ax_mps2,ay_mps2,az_mps2", 6, |s, out| {
    out.extend(s.force_mps2)
});
static STILL: Columns = columns("still", 0, |s, out| out.push(f64::from(s.state.at_rest)));
static ATTITUDE: Columns = columns("qw,qx,qy,qz", 8, |s, out| out.extend(s.state.attitude));
static EULER: Columns = columns("roll_deg,pitch_deg,yaw_deg", 6, |s, out| {
    out.extend(s.roll_pitch_yaw_deg())
});
static LINEAR: Columns = columns("lin_ax_mps2,lin_ay_mps2,lin_az_mps2", 6, |s, out| {
    out.extend(s.state.acceleration_mps2)
});
static VELOCITY: Columns = columns("vx_mps,vy_mps,vz_mps", 6, |s, out| {
    out.extend(s.state.velocity_mps)
});
static POSITION: Columns = columns("px_m,py_m,pz_m", 6, |s, out| out.extend(s.state.position_m));
static VELOCITY_SD: Columns = columns("sigma_vx_mps,sigma_vy_mps,sigma_vz_mps", 6, |s, out| {
    out.extend(s.state.velocity_sd_mps)
});
static POSITION_SD: Columns = columns("sigma_px_m,sigma_py_m,sigma_pz_m", 6, |s, out| {
    out.extend(s.state.position_sd_m)
});
static ATTITUDE_SD: Columns = columns("sigma_tilt_deg,sigma_heading_deg", 6, |s, out| {
    out.extend(s.attitude_sd_deg())
});

/// A table of the samples of a motion: a header, one row a sample, every column with its unit in its name.
#[derive(Debug)]
pub struct MotionTable<'a> {
    motion: &'a Motion,
    columns: Vec<&'static Columns>,
}

impl Motion {
    /// The table of a motion.
    ///
    /// `t_s`; `raw_ax_mps2` … specific force by the nominal scale alone; `ax_mps2` … calibrated; `still` 0 or 1;
    /// `qw`, `qx`, `qy`, `qz` attitude, sensor → frame (Hamilton); `lin_ax_mps2` … acceleration in the frame without
    /// gravity; `vx_mps` …, `px_m` …; with bands `sigma_vx_mps` …, `sigma_px_m` …, `sigma_tilt_deg`,
    /// `sigma_heading_deg`.
    pub fn table(&self) -> MotionTable<'_> {
        let mut columns = vec![
            &TIME, &RAW, &FORCE, &STILL, &ATTITUDE, &LINEAR, &VELOCITY, &POSITION,
        ];
        if self.bands {
            columns.extend([&VELOCITY_SD, &POSITION_SD, &ATTITUDE_SD]);
        }
        MotionTable {
            motion: self,
            columns,
        }
    }

    /// The table of its orientation: `t_s`, `still`, the attitude as above and as `roll_deg`, `pitch_deg`, `yaw_deg`,
    /// `sigma_tilt_deg`, `sigma_heading_deg`; with `acceleration` also `lin_ax_mps2` ….
    pub fn orientation_table(&self, acceleration: bool) -> MotionTable<'_> {
        let mut columns = vec![&TIME, &STILL, &ATTITUDE, &EULER, &ATTITUDE_SD];
        columns.extend(acceleration.then_some(&LINEAR));
        MotionTable {
            motion: self,
            columns,
        }
    }
}

impl MotionTable<'_> {
    /// Names of the columns.
    pub fn names(&self) -> Vec<&'static str> {
        let names = self.columns.iter().map(|c| c.names);
        names.flat_map(|names| names.split(',')).collect()
    }

    /// All values, row by row.
    pub fn values(&self) -> Vec<f64> {
        let mut out = Vec::with_capacity(self.motion.rows() * self.names().len());
        for sample in self.motion.samples() {
            self.columns
                .iter()
                .for_each(|c| (c.values)(&sample, &mut out));
        }
        out
    }

    /// Writes it as CSV. What is not known is an empty field.
    ///
    /// # Errors
    ///
    /// What `out` says.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let mut out = BufWriter::with_capacity(CHUNK, out);
        writeln!(out, "{}", self.names().join(","))?;
        let (mut row, mut values) = (Vec::new(), Vec::new());
        for sample in self.motion.samples() {
            row.clear();
            for columns in &self.columns {
                values.clear();
                (columns.values)(&sample, &mut values);
                for value in &values {
                    write_fixed(&mut row, *value, columns.decimals);
                    row.push(b',');
                }
            }
            row.pop();
            row.push(b'\n');
            out.write_all(&row)?;
        }
        out.flush()
    }
}

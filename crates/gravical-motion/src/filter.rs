//! The error-state Kalman filter, forwards.

use std::ops::Range;

use nalgebra::{Matrix3, Matrix3x2, Rotation3, SMatrix, SVector, Vector3};

use crate::noise::{Density, wander};
use crate::state::{
    ACTING, ATTITUDE, Covariance, EARLIER_VELOCITY, ErrorState, FORCE_BIAS, FORCE_PARAMETERS,
    GRAVITY, MOVING, NineRows, Nominal, POSITION, RATE_BIAS, RATE_PARAMETERS, STANCE_SPEED, STATES,
    VELOCITY, by_element, level, set_rows,
};
use crate::transition::{Model, Transition, turn};

/// Random walks of the biases, m/s²/√s and rad/s/√s: bias instability of a cheap sensor over a minute.
const FORCE_BIAS_WALK: f64 = 2e-4;
const RATE_BIAS_WALK: f64 = 5e-6;
/// That of a gyroscope that is moved: its load and temperature change, by 0.01 °/s in a minute. The chain of rests has
/// its own.
const MOVED_RATE_BIAS_WALK: f64 = 2e-5;
/// What is known before the first rest: speed (a car), tilt after a levelling in motion, bias of a
/// gyroscope by its data sheet.
const INITIAL_SPEED_MPS: f64 = 30.0;
const INITIAL_TILT_RAD: f64 = 0.3;
const INITIAL_RATE_BIAS_RAD_S: f64 = 0.02;
/// What the bias of an accelerometer drifts by within hours after a calibration, m/s²: 0.1 mg.
const INITIAL_FORCE_BIAS_MPS2: f64 = 1e-3;
/// Standard deviation of what a velocity gains between two levellings in motion, m/s, before it is known how much it
/// does: a car. With 6 m/s its acceleration is fitted by the parameters of the sensors, and the heading leaves its band.
pub(crate) const GAINED_SPEED_MPS: f64 = 20.0;
/// Interval at which a move without stances is levelled, s: a tilt of 2° adds 3.4 m/s to the velocity within it.
pub(crate) const LEVELLED_S: f64 = 10.0;
/// A foot in stance creeps, m/s (Skog et al. 2010, doi 10.1109/TBME.2010.2060723, use 0.01 to 0.1).
const STANCE_SPEED_MPS: f64 = 0.02;
/// Besides a sensor on the instep rises, and goes on, as the foot rolls, at each step alike, m/s: two real walks
/// that came back to their height end as if by 12 and 18 mm/s up.
const COMMON_STANCE_SPEED_MPS: f64 = 0.02;
/// A foot that moved less since the stance before, m, stands more than it walks.
const STEP_M: f64 = 0.3;
/// A rate of the gyroscope is measured to rounding of the computation at best, (rad/s)².
const MIN_RATE_VARIANCE: f64 = 1e-12;
/// Fraction of the second order of tilt and force that counts at a rest: all of it makes bands
/// after turns by 57° a quarter wider than none, and a real bout close to 1.2 m in place of 1.1 m.
const SECOND_ORDER: f64 = 0.2;
/// A tilt that is off acts on the velocity until the next levelling, at most so long, s.
const MAX_TILTED_S: f64 = 3.0;

/// What a rest, a stance or a motion says: innovation y = H x + noise, and its covariance S. Rows: velocity,
/// specific force (world), rate.
#[derive(Clone)]
pub(crate) struct Innovation {
    pub h: NineRows,
    pub y: SVector<f64, 9>,
    pub s: SMatrix<f64, 9, 9>,
}

/// State of the motion at a sample with the covariance of its first nine states to all.
#[derive(Debug, Clone)]
pub(crate) struct Node {
    pub sample: usize,
    pub nominal: Nominal,
    pub rows: NineRows,
}

/// What the forward pass did, for the smoother.
pub(crate) enum Record {
    /// A node whose smoothed state is wanted.
    Node(Box<Node>),
    /// Position and covariance where a move starts, and where it ends.
    StartMove(Vector3<f64>, Box<Covariance>),
    EndMove(Vector3<f64>, Box<Covariance>),
    Propagate(Box<Transition>),
    /// The velocity is zero from here on.
    ZeroVelocity,
    /// The velocity here is the earlier one from here on.
    CloneVelocity,
    Update(Box<Update>),
}

/// A Kalman update.
pub(crate) struct Update {
    pub h: NineRows,
    pub innovation: SVector<f64, 9>,
    /// Inverse of the covariance of the innovation.
    pub information: SMatrix<f64, 9, 9>,
    pub gain: SMatrix<f64, STATES, 9>,
}

/// Keeps the records of a forward pass, if they are wanted.
#[derive(Default)]
pub(crate) struct Recorder {
    is_on: bool,
    pub records: Vec<Record>,
}

impl Recorder {
    pub fn new(is_on: bool) -> Recorder {
        Recorder {
            is_on,
            records: Vec::new(),
        }
    }

    pub fn push(&mut self, record: impl FnOnce() -> Record) {
        if self.is_on {
            self.records.push(record());
        }
    }
}

/// The filter.
#[derive(Clone)]
pub(crate) struct Filter<'a> {
    pub model: Model<'a>,
    /// The sample that it is at.
    pub at: usize,
    pub nominal: Nominal,
    pub covariance: Covariance,
    /// Since the last rest: its time, s, the angle turned, rad, and the highest speed, m/s.
    pub rest_s: f64,
    pub turned_rad: f64,
    pub top_mps: f64,
    /// Standard deviation of what the velocity gains between two levellings in this move, and the most that it gained
    /// in one axis, m/s.
    gained_sd_mps: f64,
    pub gained_mps: f64,
    /// Random walk of the bias of the gyroscope, rad/s/√s.
    rate_bias_walk: f64,
}

impl<'a> Filter<'a> {
    /// At sample `at`, with the attitude of `rest`, from which the gyroscope leads back to there. Position
    /// is zero, velocity unknown.
    pub fn new(model: Model<'a>, at: usize, rest: &Range<usize>) -> Self {
        let samples = model.samples;
        let mean = samples.mean(rest);
        let force = Vector3::from_column_slice(&mean[..3]);
        let rate_bias = Vector3::from_column_slice(&mean[3..]);
        let mut attitude = level(&force);
        if samples.has_gyro() {
            for i in (at..rest.start).rev() {
                let rates = [i, i + 1].map(|i| Vector3::from(samples.rate_rad_s[i]) - rate_bias);
                let h = samples.time_s[i + 1] - samples.time_s[i];
                attitude *= Rotation3::new(-turn(&rates, h, samples.period_s)).into_inner();
            }
        }
        let mut sd = ErrorState::repeat(1.0);
        let mut set =
            |at: usize, value: [f64; 3]| sd.fixed_rows_mut::<3>(at).copy_from_slice(&value);
        set(POSITION, [0.0; 3]);
        set(VELOCITY, [INITIAL_SPEED_MPS; 3]);
        // The heading is that of the start by definition.
        set(ATTITUDE, [INITIAL_TILT_RAD, INITIAL_TILT_RAD, 0.0]);
        set(FORCE_BIAS, [INITIAL_FORCE_BIAS_MPS2; 3]);
        set(RATE_BIAS, [INITIAL_RATE_BIAS_RAD_S; 3]);
        sd.fixed_rows_mut::<2>(STANCE_SPEED)
            .fill(COMMON_STANCE_SPEED_MPS);
        sd[GRAVITY] = model.options.calibration.gravity_sd_mps2;
        if !samples.has_gyro() {
            sd.fixed_rows_mut::<3>(RATE_BIAS).fill(0.0);
            sd.fixed_rows_mut::<9>(RATE_PARAMETERS).fill(0.0);
        }
        Filter {
            model,
            at,
            nominal: Nominal {
                attitude,
                rate_bias,
                gravity: force.norm(),
                ..Nominal::default()
            },
            covariance: Covariance::from_diagonal(&sd.map(|s| s * s)),
            rest_s: samples.time_s[at],
            turned_rad: 0.0,
            top_mps: 0.0,
            gained_sd_mps: GAINED_SPEED_MPS,
            gained_mps: 0.0,
            rate_bias_walk: RATE_BIAS_WALK,
        }
    }

    /// From here on it moves, until the velocity is zero.
    pub fn start_move(&mut self, gained_sd_mps: f64) {
        (self.gained_sd_mps, self.gained_mps) = (gained_sd_mps, 0.0);
        self.rate_bias_walk = MOVED_RATE_BIAS_WALK;
    }

    /// From here on three states may be others by this variance.
    pub fn inflate_covariance(&mut self, first: usize, variance: f64) {
        (first..first + 3).for_each(|c| self.covariance[(c, c)] += variance);
    }

    /// Integrates to a sample in nodes of so many samples.
    pub fn propagate(
        &mut self,
        to: usize,
        node: usize,
        added_noise: &Density,
        recorder: &mut Recorder,
    ) {
        while self.at < to {
            let end = (self.at + node.max(1)).min(to);
            recorder.push(|| Record::Node(Box::new(self.node())));
            let step = self
                .model
                .step(&mut self.nominal, self.at..end, added_noise);
            self.turned_rad += step.turned_rad;
            self.top_mps = self.top_mps.max(self.nominal.velocity.norm());
            self.at = end;

            // P ← F P Fᵀ + Q: after its first nine rows F is the identity.
            let rows = step.f * self.covariance.fixed_rows::<ACTING>(0);
            let square = rows.fixed_columns::<ACTING>(0) * step.f.transpose() + step.q;
            let p = &mut self.covariance;
            p.fixed_rows_mut::<MOVING>(0).copy_from(&rows);
            p.fixed_columns_mut::<MOVING>(0)
                .copy_from(&rows.transpose());
            p.fixed_view_mut::<MOVING, MOVING>(0, 0).copy_from(&square);
            self.walk(step.seconds);
            recorder.push(|| Record::Propagate(Box::new(step)));
        }
    }

    /// The same, levelled on the way by what a motion says.
    pub fn propagate_levelled(
        &mut self,
        to: usize,
        node: usize,
        added_noise: &Density,
        recorder: &mut Recorder,
    ) {
        loop {
            let next = self.model.samples.after_s(self.at, LEVELLED_S);
            if next >= to {
                break;
            }
            self.clone_velocity(recorder);
            self.propagate(next, node, added_noise, recorder);
            let innovation = self.motion_innovation();
            let gained = innovation.y.fixed_rows::<3>(0).amax();
            self.gained_mps = self.gained_mps.max(gained);
            self.update(&innovation, recorder);
        }
        self.propagate(to, node, added_noise, recorder);
    }

    /// Random walks of the biases.
    fn walk(&mut self, seconds: f64) {
        self.inflate_covariance(FORCE_BIAS, FORCE_BIAS_WALK.powi(2) * seconds);
        if self.model.samples.has_gyro() {
            self.inflate_covariance(RATE_BIAS, self.rate_bias_walk.powi(2) * seconds);
        }
    }

    /// Rests until a sample.
    pub fn apply_zero_velocity(&mut self, to: usize, recorder: &mut Recorder) {
        let (to, time_s) = (to.max(self.at), &self.model.samples.time_s);
        let seconds = time_s[to] - time_s[self.at];
        recorder.push(|| Record::Node(Box::new(self.node())));
        recorder.push(|| Record::ZeroVelocity);
        self.covariance.fixed_rows_mut::<3>(VELOCITY).fill(0.0);
        self.covariance.fixed_columns_mut::<3>(VELOCITY).fill(0.0);
        self.nominal.velocity = Vector3::zeros();
        self.rate_bias_walk = RATE_BIAS_WALK;
        self.walk(seconds);
        self.at = to;
        self.rest_s = time_s[to];
        self.turned_rad = 0.0;
        self.top_mps = 0.0;
    }

    /// Goes through a quiet span at its velocity, for the chain of rests: what force and rate of it say is taken over.
    /// The position is not kept.
    pub fn coast(&mut self, span: &Range<usize>, mut said: Innovation) {
        said.h.fixed_rows_mut::<3>(0).fill(0.0);
        said.y.fixed_rows_mut::<3>(0).fill(0.0);
        said.s.fixed_rows_mut::<3>(0).fill(0.0);
        said.s.fixed_columns_mut::<3>(0).fill(0.0);
        (0..3).for_each(|c| said.s[(c, c)] = 1.0);
        self.update(&said, &mut Recorder::default());
        let time_s = &self.model.samples.time_s;
        let seconds = time_s[span.end - 1] - time_s[self.at];
        self.walk(seconds);
        self.at = span.end - 1;
    }

    pub fn node(&self) -> Node {
        Node {
            sample: self.at,
            nominal: self.nominal.clone(),
            rows: self.covariance.fixed_rows::<MOVING>(0).into_owned(),
        }
    }

    /// Mean square of the rate of a span, (rad/s)².
    pub fn mean_square_rate(&self, span: Range<usize>) -> f64 {
        let rates = self.model.samples.rate_rad_s.get(span).unwrap_or_default();
        let correction = self.nominal.correction(self.model.directions);
        let squares = rates.iter().map(|r| correction.rate(r).norm_squared());
        squares.sum::<f64>() / rates.len().max(1) as f64
    }

    /// That of a speed, S without what the covariance adds; its other rows say nothing.
    fn velocity_innovation(&self, speed_sd_mps: f64) -> Innovation {
        let mut innovation = Innovation {
            h: NineRows::zeros(),
            y: SVector::zeros(),
            s: SMatrix::identity(),
        };
        for c in 0..3 {
            innovation.h[(c, VELOCITY + c)] = 1.0;
            innovation.y[c] = -self.nominal.velocity[c];
            innovation.s[(c, c)] = speed_sd_mps.powi(2);
        }
        innovation
    }

    /// What a stance says after a step from `start`, m: the sensor has the velocity of every stance.
    pub fn stance_innovation(&self, start: &Vector3<f64>) -> Innovation {
        let mut innovation = self.velocity_innovation(STANCE_SPEED_MPS);
        let step = (self.nominal.position - start).cap_magnitude(STEP_M) / STEP_M;
        let up = Vector3::z() * step.norm();
        let common = Matrix3x2::from_columns(&[up, step - Vector3::z() * step.z]);
        set_rows(&mut innovation.h, (0, STANCE_SPEED), &-common);
        let mut y = innovation.y.fixed_rows_mut::<3>(0);
        y += common * self.nominal.stance_speed;
        innovation.s += innovation.h * self.covariance * innovation.h.transpose();
        innovation
    }

    /// From here on the velocity here is the earlier one.
    pub fn clone_velocity(&mut self, recorder: &mut Recorder) {
        self.nominal.earlier_velocity = self.nominal.velocity;
        let p = &mut self.covariance;
        let rows = p.fixed_rows::<3>(VELOCITY).into_owned();
        p.fixed_rows_mut::<3>(EARLIER_VELOCITY).copy_from(&rows);
        let columns = p.fixed_columns::<3>(VELOCITY).into_owned();
        p.fixed_columns_mut::<3>(EARLIER_VELOCITY)
            .copy_from(&columns);
        recorder.push(|| Record::CloneVelocity);
    }

    /// What a motion says: the velocity is near the earlier one, so most of the mean specific force since is gravity
    /// (after the low-pass filter of Laidig and Seel 2023, doi 10.1016/j.inffus.2022.10.027). Neither velocity
    /// nor position is pulled to a value.
    ///
    /// What their difference exceeds its variance by counts as motion. In a vehicle that circles, or speeds up for
    /// minutes, the tilt goes to that of the mean force, as far as the gyroscope may be off.
    pub fn motion_innovation(&self) -> Innovation {
        let mut m = self.velocity_innovation(self.gained_sd_mps);
        let mut by_earlier = m.h.fixed_view_mut::<3, 3>(0, EARLIER_VELOCITY);
        by_earlier.fill_diagonal(-1.0);
        let covariance = m.h * self.covariance * m.h.transpose();
        for c in 0..3 {
            m.y[c] += self.nominal.earlier_velocity[c];
            m.s[(c, c)] += (m.y[c].powi(2) - covariance[(c, c)]).max(0.0);
        }
        m.s += covariance;
        m
    }

    /// Zero velocity, specific force and angular rate of a span at rest; its speed has this standard
    /// deviation, m/s.
    pub fn rest(&mut self, span: &Range<usize>, speed_sd_mps: f64, recorder: &mut Recorder) {
        self.update(&self.rest_innovation(span, speed_sd_mps), recorder);
    }

    /// What a rest says.
    pub fn rest_innovation(&self, rest: &Range<usize>, speed_sd_mps: f64) -> Innovation {
        let (model, samples) = (self.model, self.model.samples);
        let seconds = samples.duration_s(rest).max(samples.period_s);
        let mean = samples.mean(rest);
        let reading = [mean[0], mean[1], mean[2]];
        let attitude = self.nominal.attitude;
        let force = attitude * self.nominal.correction(model.directions).force(&reading);
        let mut m = self.velocity_innovation(speed_sd_mps);
        let reading = Vector3::from(reading);

        set_rows(&mut m.h, (3, ATTITUDE), &-force.cross_matrix());
        set_rows(&mut m.h, (3, FORCE_BIAS), &-attitude);
        m.h[(5, GRAVITY)] = -1.0;
        let directions = &model.directions.force;
        let by_matrix = by_element(&attitude, &reading) * directions.fixed_rows::<9>(0);
        let by_parameters = by_matrix + attitude * directions.fixed_rows::<3>(9);
        set_rows(&mut m.h, (3, FORCE_PARAMETERS), &by_parameters);
        let innovation = Vector3::new(0.0, 0.0, self.nominal.gravity) - force;
        m.y.fixed_rows_mut::<3>(3).copy_from(&innovation);
        let walked = FORCE_BIAS_WALK.powi(2) * seconds / 3.0;
        let white = Matrix3::from_diagonal(&(model.noise.rest.force / seconds));
        let wander = wander(samples, rest);
        let white =
            attitude * white * attitude.transpose() + Matrix3::identity() * (walked + wander[0]);
        set_rows(&mut m.s, (3, 3), &white);

        let second_order = self.second_order(&m.h);
        let tilted_s = (samples.time_s[self.at] - self.rest_s).clamp(0.0, MAX_TILTED_S);
        for c in 0..3 {
            m.s[(3 + c, 3 + c)] += second_order;
            m.s[(c, c)] += second_order * tilted_s.powi(2);
        }
        for c in 0..3 {
            m.s[(6 + c, 6 + c)] = MIN_RATE_VARIANCE
                + model.noise.rounding[c]
                + wander[1]
                + model.noise.rest.rate[c] / seconds
                + RATE_BIAS_WALK.powi(2) * seconds / 3.0;
            if samples.has_gyro() {
                m.h[(6 + c, RATE_BIAS + c)] = 1.0;
                m.y[6 + c] = mean[3 + c] - self.nominal.rate_bias[c];
            }
        }
        m.s += m.h * self.covariance * m.h.transpose();
        m
    }

    /// Variance of the force that a linear measurement leaves out: tilt squared, and tilt times the error
    /// of the force. Without turning since the last rest there is none.
    fn second_order(&self, h: &NineRows) -> f64 {
        let covariance = &self.covariance;
        let by_force = h.fixed_view::<3, 12>(3, FORCE_PARAMETERS);
        let parameters = covariance.fixed_view::<12, 12>(FORCE_PARAMETERS, FORCE_PARAMETERS);
        let bias: f64 = (FORCE_BIAS..FORCE_BIAS + 3)
            .map(|c| covariance[(c, c)])
            .sum();
        let force = (by_force * parameters * by_force.transpose()).trace() + bias;
        let tilt = covariance[(ATTITUDE, ATTITUDE)] + covariance[(ATTITUDE + 1, ATTITUDE + 1)];
        let turned = self.turned_rad.min(1.0).powi(2);
        SECOND_ORDER * turned * tilt * (0.5 * tilt * self.nominal.gravity.powi(2) + force)
    }

    /// Takes over what is said.
    pub fn update(&mut self, m: &Innovation, recorder: &mut Recorder) {
        let p_ht = self.covariance * m.h.transpose();
        // Not positive where samples are absurd: then nothing is learned.
        let Some(cholesky) = m.s.cholesky() else {
            return;
        };
        let information = cholesky.inverse();
        let gain = p_ht * information;
        // Joseph's form, multiplied out.
        let one = gain * p_ht.transpose();
        let covariance = self.covariance - one - one.transpose() + gain * m.s * gain.transpose();
        self.covariance = (covariance + covariance.transpose()) * 0.5;
        self.nominal.correct(&(gain * m.y));
        recorder.push(|| {
            Record::Update(Box::new(Update {
                h: m.h,
                innovation: m.y,
                information,
                gain,
            }))
        });
    }
}

//! The state: what the errors of the filter are of.
//!
//! Error state x = true − nominal (Solà 2017, arXiv 1711.02508, section 5, with the attitude error in the
//! world frame): position, velocity, attitude φ (R_true = exp(φ×) R), bias of the accelerometer, bias of
//! the gyroscope, gravity, the parameters of the calibration in units of their standard deviations, the velocity
//! some seconds before, and what all stances of a foot have of a velocity.

use nalgebra::{Matrix3, Rotation3, SMatrix, SVector, Vector2, Vector3};

use crate::options::Directions;

pub(crate) const STATES: usize = 42;
pub(crate) const POSITION: usize = 0;
pub(crate) const VELOCITY: usize = 3;
pub(crate) const ATTITUDE: usize = 6;
/// States before it change with the motion, the others only by their random walks; the earlier velocity is cloned.
pub(crate) const MOVING: usize = 9;
pub(crate) const FORCE_BIAS: usize = 9;
pub(crate) const RATE_BIAS: usize = 12;
pub(crate) const GRAVITY: usize = 15;
pub(crate) const RATE_PARAMETERS: usize = 16;
pub(crate) const FORCE_PARAMETERS: usize = 25;
const PARAMETERS: usize = ACTING - RATE_PARAMETERS;
/// States before it act on the motion.
pub(crate) const ACTING: usize = 37;
pub(crate) const EARLIER_VELOCITY: usize = 37;
/// Velocity that every stance of a foot has, up and along its step.
pub(crate) const STANCE_SPEED: usize = 40;

pub(crate) type Covariance = SMatrix<f64, STATES, STATES>;
pub(crate) type ErrorState = SVector<f64, STATES>;
/// Nine rows over all states.
pub(crate) type NineRows = SMatrix<f64, MOVING, STATES>;
/// Nine rows over those that act on the motion.
pub(crate) type Derivatives = SMatrix<f64, MOVING, ACTING>;

/// Writes three rows of a matrix from an element on.
pub(crate) fn set_rows<const C: usize, const W: usize>(
    matrix: &mut SMatrix<f64, MOVING, C>,
    (row, column): (usize, usize),
    block: &SMatrix<f64, 3, W>,
) {
    matrix.fixed_view_mut::<3, W>(row, column).copy_from(block);
}

/// The nominal state.
#[derive(Debug, Clone, Default)]
pub(crate) struct Nominal {
    /// Sensor → world, world z up.
    pub attitude: Matrix3<f64>,
    pub velocity: Vector3<f64>,
    pub position: Vector3<f64>,
    pub force_bias: Vector3<f64>,
    pub rate_bias: Vector3<f64>,
    pub gravity: f64,
    /// Parameters of the calibration, of the gyroscope first, in standard deviations.
    pub parameters: SVector<f64, PARAMETERS>,
    pub earlier_velocity: Vector3<f64>,
    /// m/s, up and along the step.
    pub stance_speed: Vector2<f64>,
}

impl Nominal {
    /// Takes the estimated error over.
    pub fn correct(&mut self, x: &ErrorState) {
        let part = |i: usize| x.fixed_rows::<3>(i).into_owned();
        self.position += part(POSITION);
        self.velocity += part(VELOCITY);
        self.force_bias += part(FORCE_BIAS);
        self.rate_bias += part(RATE_BIAS);
        self.earlier_velocity += part(EARLIER_VELOCITY);
        self.stance_speed += x.fixed_rows::<2>(STANCE_SPEED);
        self.gravity += x[GRAVITY];
        self.attitude = Rotation3::new(part(ATTITUDE)).into_inner() * self.attitude;
        self.parameters += x.fixed_rows::<PARAMETERS>(RATE_PARAMETERS);
    }

    /// The correction of the readings that the nominal parameters are.
    pub fn correction(&self, directions: &Directions) -> Correction {
        let rate = directions.rate * self.parameters.fixed_rows::<9>(0);
        let force = directions.force * self.parameters.fixed_rows::<12>(9);
        let matrix = |m: &[f64]| Matrix3::identity() + Matrix3::from_row_slice(&m[..9]);
        let offset = force.fixed_rows::<3>(9) - self.force_bias;
        let rate = matrix(rate.as_slice());
        Correction {
            force: (matrix(force.as_slice()), offset),
            rate: (rate, -(rate * self.rate_bias)),
        }
    }
}

/// What each element of M, row by row, makes of R M x.
pub(crate) fn by_element(r: &Matrix3<f64>, x: &Vector3<f64>) -> SMatrix<f64, 3, 9> {
    SMatrix::from_fn(|i, k| r[(i, k / 3)] * x[k % 3])
}

/// Corrected = matrix · reading + offset.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Correction {
    pub force: (Matrix3<f64>, Vector3<f64>),
    pub rate: (Matrix3<f64>, Vector3<f64>),
}

impl Correction {
    pub fn force(&self, reading: &[f64; 3]) -> Vector3<f64> {
        self.force.0 * Vector3::from(*reading) + self.force.1
    }

    pub fn rate(&self, reading: &[f64; 3]) -> Vector3<f64> {
        self.rate.0 * Vector3::from(*reading) + self.rate.1
    }
}

/// Attitude that levels a specific force: its direction is up, the heading that of the sensor's x-axis
/// (y, where x stands upright).
pub(crate) fn level(force: &Vector3<f64>) -> Matrix3<f64> {
    let Some(up) = force.try_normalize(f64::MIN_POSITIVE) else {
        return Matrix3::identity();
    };
    let forward = if up.x.abs() < 0.999 {
        Vector3::x()
    } else {
        Vector3::y()
    };
    let x = (forward - up * up.dot(&forward)).normalize();
    Matrix3::from_rows(&[x.transpose(), up.cross(&x).transpose(), up.transpose()])
}

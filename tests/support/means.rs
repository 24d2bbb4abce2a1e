//! Means of poses drawn directly, as a session would measure them, without its rows.
//!
//! For planning a session (which poses, how many, how accurate?) and for comparing an estimator
//! with the truth over hundreds of parts, in seconds instead of the hours that complete
//! recordings would take.

use std::f64::consts::PI;

use gravical_core::matrix3;
use nalgebra::{Rotation3, Unit, Vector3};
use rand::{Rng, RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use gravical::fit::model::sphere;
use gravical::poses::face::Face;
use gravical::simulate::spread_directions;

/// Distribution of the parts and poses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeansOptions {
    /// Gravity, m/s².
    pub gravity_mps2: f64,
    /// Standard deviation of a scale, relative.
    pub scale_sd: f64,
    /// Standard deviation of every off-diagonal element of R, rad.
    pub misalignment_sd_rad: f64,
    /// Biases are uniformly distributed over ± this, m/s².
    pub bias_limit_mps2: f64,
    /// Standard deviation of each component of a mean, m/s².
    pub noise_mps2: f64,
    /// Standard deviation of each of the two components of the tilt of a pose, rad.
    pub tilt_sd_rad: f64,
    /// … and of the tilt of the table, which all poses share, rad.
    pub table_sd_rad: f64,
    /// Angle by which the board is rotated in its case, about a random axis, rad.
    pub board_turn_rad: f64,
}

impl Default for MeansOptions {
    /// A cheap part on a level table: scale 2 %, misalignment 1°, bias ±0.5 m/s², standard
    /// deviation of means 1.24 mm/s² (10 s at 44 Hz of bandwidth), tilts of 1°.
    fn default() -> Self {
        MeansOptions {
            gravity_mps2: 9.80665,
            scale_sd: 0.02,
            misalignment_sd_rad: 1_f64.to_radians(),
            bias_limit_mps2: 0.5,
            noise_mps2: 1.24e-3,
            tilt_sd_rad: 1_f64.to_radians(),
            table_sd_rad: 0.0,
            board_turn_rad: 0.0,
        }
    }
}

/// A planned pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Planned {
    /// On a face, in the arbitrary orientation in which the case is put down, and rotated by
    /// `turned_rad` about the vertical, which matters on a table that is not level.
    Face {
        /// The face.
        face: Face,
        /// Rotation about the vertical.
        turned_rad: f64,
    },
    /// Exactly this direction of specific force, axes of the case.
    Free([f64; 3]),
}

impl Planned {
    /// Direction of the specific force, axes of the case.
    pub fn direction(&self) -> [f64; 3] {
        match self {
            Planned::Face { face, .. } => face.direction(),
            Planned::Free(direction) => *direction,
        }
    }

    /// The six faces once, +x −x +y −y +z −z.
    pub fn six_faces() -> Vec<Planned> {
        Self::faces_turned(0.0)
    }

    /// The six faces once, all rotated about the vertical by the same angle.
    pub fn faces_turned(turned_rad: f64) -> Vec<Planned> {
        Face::all()
            .map(|face| Planned::Face { face, turned_rad })
            .to_vec()
    }

    /// `count` directions of a Fibonacci lattice, evenly spread over the sphere, independent of
    /// the faces.
    pub fn lattice(count: usize) -> Vec<Planned> {
        sphere(count).map(|n| Planned::Free(n.into())).collect()
    }

    /// `count` directions far from the faces and from each other (each the farthest of 400 from
    /// all before, with a random error of 5° of the hand).
    pub fn spread(count: usize, seed: u64) -> Vec<Planned> {
        let directions = spread_directions(count, seed);
        directions.into_iter().map(Planned::Free).collect()
    }
}

/// Measurement of a pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeanReading {
    /// Mean, m/s².
    pub mean: [f64; 3],
    /// The planned face.
    pub face: Option<Face>,
    /// True direction of specific force, axes of the case.
    pub direction: [f64; 3],
}

/// A virtual part with known parameters, in its case.
#[derive(Debug, Clone)]
pub struct Part {
    model: [[f64; 3]; 3],
    bias: [f64; 3],
    /// Tilt of the table in the frame of the case, for each face.
    table: [[f64; 2]; 6],
    options: MeansOptions,
    tilts: ChaCha8Rng,
    noise: ChaCha8Rng,
    frees: ChaCha8Rng,
}

impl Part {
    /// Part number `index` of `seed`. Each part has its own random streams, so that it does not
    /// depend on the other parts, and separate streams for parameters, tilts, noise and free
    /// directions.
    pub fn draw(options: &MeansOptions, seed: u64, index: usize) -> Self {
        let mut rng = stream(seed, 1, index);
        let mut model = [[0.0; 3]; 3];
        for (i, row) in model.iter_mut().enumerate() {
            let scale = 1.0 + options.scale_sd * normal(&mut rng);
            for (j, element) in row.iter_mut().enumerate() {
                let off = options.misalignment_sd_rad * normal(&mut rng);
                *element = scale * if i == j { 1.0 } else { off };
            }
        }
        let bias = three(|| options.bias_limit_mps2 * uniform(&mut rng)).into();
        let mut board = stream(seed, 8, index);
        let axis = Unit::new_normalize(three(|| normal(&mut board)));
        let turn = Rotation3::from_axis_angle(&axis, options.board_turn_rad);
        let turn = std::array::from_fn(|i| std::array::from_fn(|j| turn[(i, j)]));
        let mut tilts = stream(seed, 2, index);
        let [p, q] = [0, 1].map(|_| options.table_sd_rad * normal(&mut tilts));
        let table = [0; 6].map(|_| turned([p, q], PI * uniform(&mut tilts)));
        Part {
            model: matrix3::mul(&model, &turn),
            bias,
            table,
            options: *options,
            tilts,
            noise: stream(seed, 5, index),
            frees: stream(seed, 4, index),
        }
    }

    /// M of u = M a + b, dimensionless.
    pub fn model(&self) -> [[f64; 3]; 3] {
        self.model
    }

    /// b, m/s².
    pub fn bias_mps2(&self) -> [f64; 3] {
        self.bias
    }

    /// Gravity, m/s².
    pub fn gravity_mps2(&self) -> f64 {
        self.options.gravity_mps2
    }

    /// A uniformly distributed direction.
    pub fn random_direction(&mut self) -> [f64; 3] {
        three(|| normal(&mut self.frees)).normalize().into()
    }

    /// `count` uniformly distributed directions as poses.
    pub fn random_poses(&mut self, count: usize) -> Vec<Planned> {
        (0..count)
            .map(|_| Planned::Free(self.random_direction()))
            .collect()
    }

    /// Measures poses, each with its own tilt and noise.
    pub fn place(&mut self, planned: &[Planned]) -> Vec<MeanReading> {
        planned.iter().map(|p| self.place_one(p)).collect()
    }

    fn place_one(&mut self, planned: &Planned) -> MeanReading {
        let (direction, face) = match *planned {
            Planned::Face { face, turned_rad } => (self.tilted(face, turned_rad), Some(face)),
            Planned::Free(direction) => (direction, None),
        };
        let exact = self.read(direction);
        MeanReading {
            mean: exact.map(|u| u + self.options.noise_mps2 * normal(&mut self.noise)),
            face,
            direction,
        }
    }

    /// The direction with the tilt of the pose and of the table.
    fn tilted(&mut self, face: Face, turned_rad: f64) -> [f64; 3] {
        let nominal = Vector3::from(face.direction());
        let (first, second) = tangents(nominal);
        let own = [0, 1].map(|_| self.options.tilt_sd_rad * normal(&mut self.tilts));
        let table = turned(self.table[face.index()], turned_rad);
        let delta = first * (own[0] + table[0]) + second * (own[1] + table[1]);
        let angle = delta.norm();
        if angle == 0.0 {
            return nominal.into();
        }
        (nominal * angle.cos() + delta * (angle.sin() / angle)).into()
    }

    /// Reading without noise, m/s².
    pub fn read(&self, direction: [f64; 3]) -> [f64; 3] {
        let g = self.options.gravity_mps2;
        let force = matrix3::mul_vec(&self.model, &direction);
        std::array::from_fn(|i| g * force[i] + self.bias[i])
    }
}

/// The stream of random numbers of one purpose, as the simulator has it.
fn stream(seed: u64, purpose: u64, index: usize) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(((index as u64) << 8) | purpose);
    rng
}

fn normal(rng: &mut impl Rng) -> f64 {
    rng.sample(StandardNormal)
}

fn uniform(rng: &mut impl Rng) -> f64 {
    2.0 * rng.random::<f64>() - 1.0
}

fn three(mut draw: impl FnMut() -> f64) -> Vector3<f64> {
    let x = draw();
    let y = draw();
    Vector3::new(x, y, draw())
}

/// Two unit vectors that form a right-handed frame with `direction`.
fn tangents(direction: Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
    let first = direction.cross(&Vector3::ith(direction.iamin(), 1.0));
    let first = first.normalize();
    (first, direction.cross(&first))
}

fn turned([p, q]: [f64; 2], angle_rad: f64) -> [f64; 2] {
    let (sine, cosine) = angle_rad.sin_cos();
    [cosine * p - sine * q, sine * p + cosine * q]
}

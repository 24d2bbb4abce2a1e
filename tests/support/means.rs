//! Means of poses drawn directly, as a session would measure them, without its rows.

use gravical_core::matrix3;
use nalgebra::Vector3;
use rand::{Rng, RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use gravical::poses::face::Face;
use gravical::simulate::spread_directions;

const GRAVITY_MPS2: f64 = 9.80665;
/// Standard deviation of a scale, relative.
const SCALE_SD: f64 = 0.02;
/// Standard deviation of the off-diagonal elements of R, and of the two components of the tilt of a
/// pose, rad.
const ANGLE_SD_RAD: f64 = std::f64::consts::PI / 180.0;
/// Biases are uniformly distributed over ± this, m/s².
const BIAS_LIMIT_MPS2: f64 = 0.5;
/// Standard deviation of each component of a mean of 10 s at 44 Hz of bandwidth, m/s².
pub const NOISE_MPS2: f64 = 1.24e-3;

/// A planned pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Planned {
    /// On a face, tilted at random.
    Face(Face),
    /// Exactly this direction of specific force, axes of the case.
    Free([f64; 3]),
}

impl Planned {
    /// The six faces once, +x −x +y −y +z −z.
    pub fn six_faces() -> Vec<Planned> {
        Face::all().map(Planned::Face).to_vec()
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
    /// True direction of specific force, axes of the case.
    pub direction: [f64; 3],
}

/// A virtual part with known parameters, in its case: a cheap one.
#[derive(Debug, Clone)]
pub struct Part {
    model: [[f64; 3]; 3],
    bias: [f64; 3],
    noise_mps2: f64,
    tilts: ChaCha8Rng,
    noise: ChaCha8Rng,
    frees: ChaCha8Rng,
}

impl Part {
    /// Part number `index` of `seed`, whose means have this noise. Each part has its own random
    /// streams, so that it does not depend on the other parts, and separate streams for parameters,
    /// tilts, noise and free directions.
    pub fn draw(noise_mps2: f64, seed: u64, index: usize) -> Self {
        let mut rng = stream(seed, 1, index);
        let mut model = [[0.0; 3]; 3];
        for (i, row) in model.iter_mut().enumerate() {
            let scale = 1.0 + SCALE_SD * normal(&mut rng);
            for (j, element) in row.iter_mut().enumerate() {
                let off = ANGLE_SD_RAD * normal(&mut rng);
                *element = scale * if i == j { 1.0 } else { off };
            }
        }
        let bias = three(|| BIAS_LIMIT_MPS2 * uniform(&mut rng)).into();
        let mut tilts = stream(seed, 2, index);
        // What a table that is not level would take: published figures are of the tilts after it.
        for _ in 0..2 {
            normal(&mut tilts);
        }
        for _ in 0..6 {
            uniform(&mut tilts);
        }
        Part {
            model,
            bias,
            noise_mps2,
            tilts,
            noise: stream(seed, 5, index),
            frees: stream(seed, 4, index),
        }
    }

    /// `count` uniformly distributed directions as poses.
    pub fn random_poses(&mut self, count: usize) -> Vec<Planned> {
        let mut direction = || -> [f64; 3] { three(|| normal(&mut self.frees)).normalize().into() };
        (0..count).map(|_| Planned::Free(direction())).collect()
    }

    /// Measures poses, each with its own tilt and noise.
    pub fn place(&mut self, planned: &[Planned]) -> Vec<MeanReading> {
        planned.iter().map(|p| self.place_one(p)).collect()
    }

    fn place_one(&mut self, planned: &Planned) -> MeanReading {
        let direction = match *planned {
            Planned::Face(face) => self.tilted(face),
            Planned::Free(direction) => direction,
        };
        let exact = self.read(direction);
        MeanReading {
            mean: exact.map(|u| u + self.noise_mps2 * normal(&mut self.noise)),
            direction,
        }
    }

    fn tilted(&mut self, face: Face) -> [f64; 3] {
        let nominal = Vector3::from(face.direction());
        let (first, second) = tangents(nominal);
        let [p, q] = [0, 1].map(|_| ANGLE_SD_RAD * normal(&mut self.tilts));
        let delta = first * p + second * q;
        let angle = delta.norm();
        (nominal * angle.cos() + delta * (angle.sin() / angle)).into()
    }

    /// Reading without noise, m/s².
    pub fn read(&self, direction: [f64; 3]) -> [f64; 3] {
        let force = matrix3::mul_vec(&self.model, &direction);
        std::array::from_fn(|i| GRAVITY_MPS2 * force[i] + self.bias[i])
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

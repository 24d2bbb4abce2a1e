//! Parts, placements and estimators, many at a time.

use crate::means::{Errors, MeanReading, MeansOptions, Part, Planned, Scores};
use gravical::core::unit::STANDARD_GRAVITY_MPS2;
use gravical::estimate::joint::{Elements, JointFit, JointOptions, JointPose, Role, joint};
use gravical::estimate::proposal::Proposals;
use gravical_core::six_position::{SixPositionMeans, ferraris_accelerometer};

use crate::each::each;

/// M and b.
pub type Parameters = ([[f64; 3]; 3], [f64; 3]);

/// What is done to each part.
#[derive(Debug, Clone, Copy)]
pub struct Session {
    /// Parts and placements.
    pub means: MeansOptions,
    /// The placements.
    pub plan: Plan,
    /// σ_tilt is given to the fit.
    pub tilt_given: bool,
    /// Faces are given as faces.
    pub roles_told: bool,
}

/// Which placements.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Plan {
    /// So many poses spread over the sphere, none of them a face.
    Poses(usize),
    /// Each face so many times, each with a tilt of its own.
    Faces(usize),
    /// Six faces and so many poses far from each other.
    Spread(usize),
    /// Six faces and so many of a Fibonacci lattice.
    Lattice(usize),
    /// Six faces and so many at random.
    Random(usize),
    /// Six faces, and so many where the fit of these says that they help most.
    Proposed(usize),
    /// Every face twice, turned by this between, degrees.
    Twice(f64),
}

/// One part's result.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// How far it is off.
    pub errors: Errors,
    /// … in its own standard deviations.
    pub scores: Option<Scores>,
    /// The joint fit, if it is one.
    pub fit: Option<JointFit>,
}

/// Errors and scores of a fit.
pub fn outcome(part: &mut Part, fit: JointFit) -> Option<Outcome> {
    Some(Outcome {
        errors: part.errors(&fit.model, &fit.bias)?,
        scores: part.scores(&fit),
        fit: Some(fit),
    })
}

impl Session {
    pub fn options(&self) -> JointOptions {
        JointOptions {
            gravity: self.means.gravity_mps2,
            nominal: Some(1.0),
            prior: true,
            tilt: self.tilt_given.then_some(self.means.tilt_sd_rad),
            ..JointOptions::default()
        }
    }

    /// The placements of one part.
    pub fn place(&self, part: &mut Part, index: usize) -> Vec<MeanReading> {
        let mut planned = match self.plan {
            Plan::Poses(count) => Planned::lattice(count),
            Plan::Faces(times) => (0..times).flat_map(|_| Planned::six_faces()).collect(),
            _ => Planned::six_faces(),
        };
        match self.plan {
            Plan::Faces(_) | Plan::Poses(_) | Plan::Proposed(_) => {}
            Plan::Spread(count) => planned.extend(Planned::spread(count, index as u64)),
            Plan::Lattice(count) => planned.extend(Planned::lattice(count)),
            Plan::Random(count) => planned.extend(part.random_poses(count)),
            Plan::Twice(turned) => planned.extend(Planned::faces_turned(turned.to_radians())),
        }
        let mut means = part.place(&planned);
        if let Plan::Proposed(count) = self.plan
            && let Ok(fit) = joint(&self.poses(&means), &self.options())
            && let Some(matrix) = gravical_core::matrix3::inverse(&fit.model)
        {
            let noise = self.means.noise_mps2;
            let g = self.means.gravity_mps2;
            let proposals = Proposals {
                matrix,
                covariance: fit.covariance,
                reliability: fit.reliability.clone(),
                recorded: planned.iter().map(Planned::direction).collect(),
                noise,
                gravity: g,
                good_mps2: 5e-3 * STANDARD_GRAVITY_MPS2,
            };
            let next: Vec<Planned> = proposals
                .take(count)
                .map(|p| Planned::Free(p.direction))
                .collect();
            means.extend(part.place(&next));
        }
        means
    }

    pub fn poses(&self, means: &[MeanReading]) -> Vec<JointPose> {
        let given = self.roles_told;
        means
            .iter()
            .map(|m| JointPose {
                mean: m.mean,
                standard_error: [self.means.noise_mps2; 3],
                role: match m.face {
                    Some(face) if given => Role::Face(face),
                    None if given => Role::Free,
                    _ => Role::Open,
                },
                temperature_c: None,
            })
            .collect()
    }

    /// The joint fit of `count` parts.
    pub fn joint(&self, seed: u64, count: usize) -> Vec<Option<Outcome>> {
        each(count, |index| {
            let mut part = Part::draw(&self.means, seed, index);
            let means = self.place(&mut part, index);
            let fit = joint(&self.poses(&means), &self.options()).ok()?;
            outcome(&mut part, fit)
        })
    }

    /// Another estimator.
    pub fn by(
        &self,
        seed: u64,
        count: usize,
        estimator: impl Fn(&[MeanReading], &MeansOptions) -> Option<Parameters> + Sync,
    ) -> Vec<Option<Outcome>> {
        each(count, |index| {
            let mut part = Part::draw(&self.means, seed, index);
            let means = self.place(&mut part, index);
            let (model, bias) = estimator(&means, &self.means)?;
            Some(Outcome {
                errors: part.errors(&model, &bias)?,
                scores: None,
                fit: None,
            })
        })
    }
}

/// Least squares with the faces taken as exact.
pub fn linear(means: &[MeanReading], options: &MeansOptions) -> Option<Parameters> {
    assuming(means, options, Elements::All)
}

/// By the length of gravity, six parameters.
pub fn magnitude6(means: &[MeanReading], options: &MeansOptions) -> Option<Parameters> {
    assuming(means, options, Elements::Diagonal)
}

/// … and nine.
pub fn magnitude9(means: &[MeanReading], options: &MeansOptions) -> Option<Parameters> {
    assuming(means, options, Elements::Triangular)
}

fn assuming(
    means: &[MeanReading],
    options: &MeansOptions,
    elements: Elements,
) -> Option<Parameters> {
    let role = |m: &MeanReading| match m.face {
        Some(face) if elements == Elements::All => Role::Face(face),
        _ => Role::Free,
    };
    let poses: Vec<JointPose> = means
        .iter()
        .map(|m| JointPose {
            mean: m.mean,
            standard_error: [options.noise_mps2; 3],
            role: role(m),
            temperature_c: None,
        })
        .collect();
    let assumed = JointOptions {
        gravity: options.gravity_mps2,
        nominal: Some(1.0),
        prior: false,
        tilt: Some(0.0),
        elements: Some(elements),
        find_bad: false,
        ..JointOptions::default()
    };
    let found = joint(&poses, &assumed).ok()?;
    Some((found.model, found.bias))
}

/// Ferraris' method: repeats of a face are averaged.
pub fn ferraris(means: &[MeanReading], options: &MeansOptions) -> Option<Parameters> {
    let side = |up: bool, axis: usize| {
        let (mut sum, mut count) = ([0.0; 3], 0.0);
        for m in means {
            if m.face.is_some_and(|f| f.axis == axis && f.up == up) {
                sum = std::array::from_fn(|i| sum[i] + m.mean[i]);
                count += 1.0;
            }
        }
        sum.map(|s| s / count)
    };
    let six = SixPositionMeans {
        plus: std::array::from_fn(|axis| side(true, axis)),
        minus: std::array::from_fn(|axis| side(false, axis)),
    };
    let found = ferraris_accelerometer(&six, options.gravity_mps2).ok()?;
    Some((found.model(), found.bias))
}

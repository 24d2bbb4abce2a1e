//! How far a fit can be trusted: the numbers that decide, and the grade by them.

use std::fmt;

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::fit::Fit;
use crate::model::{
    BIAS, Covariance, DIRECTIONS, Parameters, bias, inverse, matrix, median, nonlinear_error,
    sensitivity, sphere,
};
use crate::rows::{Hyperparameters, PoseState, Row, force};
use crate::search::{Explained, MAX_SESSION, USUAL_CHI2, USUAL_FREEDOM};
use crate::sensor::{Sensor, WorstDirection};

/// A pose and all within this angle of it are left out together, rad.
const NEIGHBOUR: f64 = 25.0 * std::f64::consts::PI / 180.0;
/// So many poses are left out at most, evenly chosen.
const MAX_LEFT_OUT: usize = 64;
/// Error of ‖a‖ (95 %) up to which a result is good: 5 mg in m/s².
pub const GOOD_MPS2: f64 = 5e-3 * gravical_core::unit::STANDARD_GRAVITY_MPS2;

/// Free poses that are proposed.
const PROPOSED: usize = 3;
/// Claimed error of ‖a‖, and effect of an error of one pose that nothing shows, up to which a result is
/// fair: 20 mg in m/s².
pub const FAIR_MPS2: f64 = 4.0 * GOOD_MPS2;
/// Predicted error (2σ over the sphere) beyond which a result that nothing verifies is poor: 50 mg in
/// m/s². Six faces placed by hand stay below.
pub const UNVERIFIED_MPS2: f64 = 10.0 * GOOD_MPS2;
/// A pose that is left out contradicts the others beyond so many of its own standard deviations.
pub const CONTRADICTION: f64 = 3.0;

/// What a person decides by, in m/s².
#[derive(Debug, Clone, PartialEq)]
pub struct Trust {
    /// Predicted error of ‖a‖, root mean square over the sphere.
    pub predicted_mps2: f64,
    /// … where it is largest.
    pub worst: WorstDirection,
    /// What explains that poses contradict each other, where it is not noise; the worst error holds whichever it is.
    pub explanations: Vec<Explained>,
    /// Error of each pose by a fit without it.
    pub left_out: Vec<Option<LeftOut>>,
    /// The error of one pose that does most harm unseen; none without poses.
    pub undetected: Option<Undetected>,
    /// Free poses that would improve the result most.
    pub next: Vec<NextPose>,
    /// Where the uncertainty comes from.
    pub budget: Option<Budget>,
}

/// Grade of a calibration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Grade {
    /// The error of ‖a‖ is at most 5 mg (95 %) in every direction, and an error of one pose that changes it
    /// by more would have been detected.
    Good,
    /// The same with 20 mg.
    Fair,
    /// An error of one pose would not have been detected.
    NotVerifiable,
    /// Anything else: the reasons of the verdict name it.
    Poor,
}

impl fmt::Display for Grade {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Grade::Good => "good",
            Grade::Fair => "fair",
            Grade::NotVerifiable => "not-verifiable",
            Grade::Poor => "poor",
        })
    }
}

/// ‖a‖ − g of a pose that the fit did not use.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeftOut {
    /// The error, m/s².
    pub error_mps2: f64,
    /// Its expected standard deviation: covariance of the fit without it, and noise of its mean.
    pub sd_mps2: f64,
}

/// The error of one pose that has the largest effect without being detected.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Undetected {
    /// Number of the pose, from 0.
    pub pose: usize,
    /// Smallest error of its mean, along gravity, that the test against the other poses detects with a
    /// probability of 90 %, m/s²; infinite, and not in a file, if they do not test it.
    pub reading_mps2: f64,
    /// Effect of this error on ‖a‖ in the worst direction, m/s².
    pub effect_mps2: f64,
    /// That direction, unit vector of specific force.
    pub direction: [f64; 3],
}

/// A free pose that would improve the result, and what is predicted after it is recorded.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct NextPose {
    /// Unit vector of specific force: the calibrated reading in this pose, over gravity.
    pub direction: [f64; 3],
    /// Predicted error of ‖a‖ over all directions with this pose, m/s².
    pub predicted_mps2: f64,
    /// Error of ‖a‖ in the worst direction with this pose (95 %), m/s².
    #[serde(default)]
    pub worst_mps2: Option<f64>,
    /// Undetected error of ‖a‖ in the worst direction with this pose, m/s²; none without redundancy.
    pub undetected_effect_mps2: Option<f64>,
}

/// Uncertainty of ‖a‖ over the sphere by source, m/s².
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Budget {
    /// Noise of the means.
    pub noise: f64,
    /// What the model misses of the readings.
    pub model_error: f64,
    /// The nonlinearity that the poses show.
    pub nonlinearity: f64,
    /// Tilts of the faces.
    pub tilt: f64,
    /// Data sheet and the usual nonlinearity, where the poses determine less.
    pub data_sheet: f64,
}

/// The session as far as it decides what the next pose brings.
#[derive(Clone)]
struct State {
    covariance: Covariance,
    /// The same without nonlinearity: what one pose tests of another.
    linear_covariance: Covariance,
    /// Of each pose that counts: its number as given, derivatives of the whitened response to an error of 1 m/s²
    /// along gravity, and its square.
    tests: Vec<(usize, Parameters, f64)>,
    freedom: f64,
}

impl Fit {
    /// All of it; `order` has the numbers of the poses in the order of time: without it the bias is not taken to move.
    pub fn trust(&self, order: Option<&[usize]>) -> Trust {
        let explanations = self.explanations(order);
        let mut worst = self.weakest();
        if let Some(rival) = rival(&explanations) {
            if rival.difference_mps2 > worst.error_mps2 {
                worst.direction = rival.direction;
            }
            worst.error_mps2 += rival.difference_mps2;
        }
        let left_out = self.left_out();
        // Without a pose that can be left out the data sheet alone would show an error.
        let is_tested = left_out.iter().any(Option::is_some);
        Trust {
            predicted_mps2: self.working_sensor.predicted_mps2(),
            worst,
            explanations,
            left_out,
            undetected: self.undetected().filter(|_| is_tested),
            next: self.next(PROPOSED),
            budget: self.budget(),
        }
    }

    /// What explains the session, where noise alone does not.
    fn explanations(&self, order: Option<&[usize]>) -> Vec<Explained> {
        let noise = self.quality.chi2_per_freedom.unwrap_or(0.0);
        let is_many = self.search.poses.len() > MAX_SESSION;
        let is_bad = self.search.poses.iter().any(|pose| pose.bad.is_some());
        // Each costs a search, which converges slowly where no model fits.
        let is_nonsense = self.quality.model_error_mps2 > MAX_EXPLAINED_MPS2;
        if is_many || is_nonsense || (noise < PLAIN_CHI2 && !is_bad) {
            return Vec::new();
        }
        self.search.explanations(&self.linear.x, order)
    }

    /// The sensor with another covariance, working units.
    fn sensor_with(&self, covariance: Covariance) -> Sensor {
        Sensor {
            covariance,
            ..self.working_sensor.clone()
        }
    }

    /// The direction in which the error claimed of ‖a‖ is largest.
    pub fn weakest(&self) -> WorstDirection {
        self.working_sensor
            .weakest(self.working_sensor.coverage_factor())
    }

    /// ‖a‖ − g of each pose by a fit without it and all within 25° of it; none where the others do not
    /// determine the parameters without the data sheet.
    pub fn left_out(&self) -> Vec<Option<LeftOut>> {
        let poses = &self.search.poses;
        let directions = self.directions();
        let stride = poses.len().div_ceil(MAX_LEFT_OUT).max(1);
        let mut each = vec![None; poses.len()];
        for k in (0..poses.len()).step_by(stride) {
            each[k] = self.leave_out(k, &directions);
        }
        self.search.place_of.iter().map(|&k| each[k]).collect()
    }

    fn leave_out(&self, k: usize, directions: &[Vector3<f64>]) -> Option<LeftOut> {
        let (linear, held) = (&self.linear, &self.search.held);
        let near = NEIGHBOUR.cos();
        let others = |i: usize| linear.rows[i].counts && directions[i].dot(&directions[k]) < near;
        if !linear.rows[k].counts || (0..directions.len()).filter(|i| others(*i)).count() < 6 {
            return None;
        }
        let normal = linear.normal(held, others)?;
        let mut without_sheet = *held;
        without_sheet.prior = false;
        let bare = linear.solve(&normal, &without_sheet)?;
        let mut sensor = self.sensor_with(bare.covariance);
        // An error of gravity is one of all poses alike.
        sensor.gravity.sd_mps2 = 0.0;
        let claims = sensor.claims(sphere(DIRECTIONS));
        if claims.iter().any(|c| c.sd_mps2 > MAX_UNDETERMINED_MPS2) {
            return None;
        }
        let rest = linear.solve(&normal, held)?;
        let pose = &self.search.poses[k];
        let x = linear.x + linear.solve(&normal, &self.search.estimating())?.step;
        let inverse = matrix(&x).try_inverse()?;
        let force = inverse * (pose.mean - bias(&x, pose.warmer_c));
        let n = force.normalize();
        let gravity = held.gravity;
        let h = sensitivity(&inverse, &n, gravity);
        let noise: f64 = (0..3).map(|i| (h[BIAS + i] * pose.sd[i]).powi(2)).sum();
        let variance = (rest.covariance * h).dot(&h) + held.model_error.powi(2) + noise;
        Some(LeftOut {
            error_mps2: force.norm() - gravity,
            sd_mps2: variance.sqrt().hypot(gravity * nonlinear_error(&x, &n)),
        })
    }

    fn state(&self) -> Option<State> {
        let held = &self.search.held;
        let without = Hyperparameters {
            nonlinearity_sd: 0.0,
            ..*held
        };
        let linear = &self.linear;
        let solution = linear.solve_poses(&without, |_| true)?;
        let test = |(k, row): (usize, &Row)| {
            let pose = self.search.place_of.iter().position(|place| *place == k)?;
            let whitener = row.whitener(held)?;
            // An error along gravity changes the length and no angle.
            let change = whitener.column(0).into_owned();
            let influence = (whitener * row.jacobian).tr_mul(&change);
            Some((pose, influence, change.norm_squared()))
        };
        let rows = linear.rows.iter().enumerate();
        let rows = rows.filter(|(_, row)| row.counts);
        Some(State {
            covariance: self.working_sensor.covariance,
            linear_covariance: solution.covariance,
            tests: rows.filter_map(test).collect(),
            freedom: linear.lengths(held, &solution, |_| true).freedom,
        })
    }

    /// The error of one pose that does most harm to ‖a‖ in any direction and is not shown by the others
    /// with 90 %: Baarda's external reliability (A testing procedure for use in geodetic networks, 1968)
    /// for an error of a mean along gravity. The residual is held against Student's t, 5 % over all poses,
    /// with the scale of the others and of what is usual.
    pub fn undetected(&self) -> Option<Undetected> {
        self.undetected_by(&self.state()?)
    }

    fn undetected_by(&self, state: &State) -> Option<Undetected> {
        let along = self.sensitivities();
        let freedom = (state.freedom - 1.0).max(0.0) + USUAL_FREEDOM;
        let level = 1.0 - 0.025 / state.tests.len() as f64;
        let limit = StudentsT::new(0.0, 1.0, freedom).ok()?.inverse_cdf(level);
        let scale = ((state.freedom - 1.0).max(0.0) + USUAL_CHI2 * USUAL_FREEDOM) / freedom;
        let shown = (limit + POWER_90) * scale.sqrt();
        let each = state.tests.iter().filter_map(|(pose, influence, weight)| {
            let moved = state.linear_covariance * influence;
            let redundancy = weight - influence.dot(&moved);
            // Below this share of the error the difference is rounding.
            let reading_mps2 = if redundancy > 1e-9 * weight {
                shown / redundancy.sqrt()
            } else {
                f64::INFINITY
            };
            let gain = along.iter().map(|(n, h)| (n, h.dot(&moved).abs()));
            let (direction, gain) = gain.max_by(|a, b| a.1.total_cmp(&b.1))?;
            Some(Undetected {
                pose: *pose,
                reading_mps2,
                effect_mps2: gain * reading_mps2,
                direction: (*direction).into(),
            })
        });
        each.max_by(|a, b| a.effect_mps2.total_cmp(&b.effect_mps2))
    }

    /// The session with one free pose more along n: nothing moves, the covariance shrinks.
    fn with_pose(&self, state: &State, n: &Vector3<f64>, sd: f64) -> State {
        let h = sensitivity(&inverse(&self.linear.x), n, self.search.held.gravity);
        let mut more = state.clone();
        let variance = sd * sd;
        for covariance in [&mut more.covariance, &mut more.linear_covariance] {
            let moved = *covariance * h;
            *covariance -= moved * moved.transpose() / (h.dot(&moved) + variance);
        }
        more.freedom += 1.0 - (more.linear_covariance * h).dot(&h) / variance;
        let number = self.search.place_of.len() + state.tests.len();
        more.tests.push((number, -h / variance, 1.0 / variance));
        more
    }

    /// Free poses that improve the result most, each after those before it: the direction in which ‖a‖
    /// is known least, and once that is good, the one after which an undetected error does least.
    pub fn next(&self, count: usize) -> Vec<NextPose> {
        let Some(mut state) = self.state() else {
            return Vec::new();
        };
        let mut directions = self.directions();
        let sd = self.usual_sd_mps2();
        let mut proposed = Vec::new();
        let weakest = |sensor: &Sensor| sensor.weakest(sensor.coverage_factor());
        let mut worst = weakest(&self.sensor_with(state.covariance));
        for _ in 0..count {
            let mut direction = Vector3::from(worst.direction);
            let hidden = |state: &State| {
                self.undetected_by(state)
                    .map_or(f64::INFINITY, |u| u.effect_mps2)
            };
            if worst.error_mps2 <= GOOD_MPS2 && hidden(&state) > GOOD_MPS2 {
                let is_new = |n: &Vector3<f64>| directions.iter().all(|d| d.angle(n) > APART);
                let each = sphere(100).filter(is_new);
                let each = each.map(|n| (n, hidden(&self.with_pose(&state, &n, sd))));
                let best = each.min_by(|a, b| a.1.total_cmp(&b.1));
                direction = best.filter(|b| b.1.is_finite()).map_or(direction, |b| b.0);
            }
            state = self.with_pose(&state, &direction, sd);
            directions.push(direction);
            let sensor = self.sensor_with(state.covariance);
            worst = weakest(&sensor);
            proposed.push(NextPose {
                direction: direction.into(),
                predicted_mps2: sensor.predicted_mps2(),
                worst_mps2: Some(worst.error_mps2),
                undetected_effect_mps2: Some(hidden(&state)).filter(|u| u.is_finite()),
            });
        }
        proposed
    }

    /// Directions over the sphere, with the sensitivity of ‖a‖ along each.
    fn sensitivities(&self) -> Vec<(Vector3<f64>, Parameters)> {
        let inverse = inverse(&self.linear.x);
        let gravity = self.search.held.gravity;
        let each = sphere(DIRECTIONS).map(|n| (n, sensitivity(&inverse, &n, gravity)));
        each.collect()
    }

    fn directions(&self) -> Vec<Vector3<f64>> {
        let of = |p: &PoseState| force(&self.linear.x, p).unwrap_or_default().normalize();
        self.search.poses.iter().map(of).collect()
    }

    /// Standard deviation of the length of one more mean, m/s².
    fn usual_sd_mps2(&self) -> f64 {
        let errors = self.search.poses.iter().flat_map(|pose| pose.sd.iter());
        median(errors.copied().collect()).hypot(self.search.held.model_error)
    }

    /// The uncertainty of ‖a‖ by source: of each row the part of its covariance by every source is
    /// propagated.
    pub fn budget(&self) -> Option<Budget> {
        let covariance = self.working_sensor.covariance;
        let held = &self.search.held;
        let mut sums = [Covariance::zeros(); 3];
        for row in self.linear.rows.iter().filter(|row| row.counts) {
            let whitener = row.whitener(held)?;
            let gain = covariance * (whitener * row.jacobian).transpose() * whitener;
            for (sum, part) in sums.iter_mut().zip(row.parts(held)) {
                *sum += gain * part * gain.transpose();
            }
        }
        let rest = covariance - sums[0] - sums[1] - sums[2];
        let along = self.sensitivities();
        let rms = |squares: f64| (squares / DIRECTIONS as f64).sqrt();
        let of = |c: &Covariance| rms(along.iter().map(|(_, h)| (c * h).dot(h).max(0.0)).sum());
        let nonlinearity = along
            .iter()
            .map(|(n, _)| (held.gravity * nonlinear_error(&self.linear.x, n)).powi(2));
        Some(Budget {
            noise: of(&sums[0]),
            model_error: of(&sums[1]).hypot(held.model_error),
            tilt: of(&sums[2]),
            data_sheet: of(&rest),
            nonlinearity: rms(nonlinearity.sum()),
        })
    }
}

/// Poses that miss the model by more than this (rms), m/s², no single cause explains: one pose in seven that is
/// off by 50 mg, or a bias that moved by 20 mg.
const MAX_EXPLAINED_MPS2: f64 = 0.2;
/// χ² per degree of freedom, by noise alone, below which a session needs no explanation.
const PLAIN_CHI2: f64 = 1.5;
/// Normal quantile of a power of 90 %.
const POWER_90: f64 = 1.281_551_565_544_6;
/// A proposed pose has to be so far from all others, rad: what a guided session calls another.
const APART: f64 = 33.0 * std::f64::consts::PI / 180.0;
/// σ(‖a‖) of a session without one pose and without the data sheet, m/s², above which the others do not
/// determine what that pose should read.
const MAX_UNDETERMINED_MPS2: f64 = 0.5;

/// The explanation whose result differs most from the one that is given.
pub fn rival(explanations: &[Explained]) -> Option<&Explained> {
    let by_size = |a: &&Explained, b: &&Explained| a.difference_mps2.total_cmp(&b.difference_mps2);
    explanations.iter().max_by(by_size)
}

/// Root mean square of the errors of poses left out; none if no pose can be.
pub(crate) fn left_out_rms(left_out: &[Option<LeftOut>]) -> Option<f64> {
    let errors = left_out.iter().flatten();
    let count = errors.clone().count();
    let squares: f64 = errors.map(|e| e.error_mps2.powi(2)).sum();
    (count > 0).then(|| (squares / count as f64).sqrt())
}

impl Trust {
    /// Root mean square of the errors of poses left out; none if no pose can be.
    pub fn left_out_rms(&self) -> Option<f64> {
        left_out_rms(&self.left_out)
    }

    /// The grade by these numbers; what is wrong with the session itself comes on top.
    pub fn grade(&self) -> Grade {
        let contradicts = |l: &LeftOut| l.error_mps2.abs() > CONTRADICTION * l.sd_mps2;
        grade(
            self.predicted_mps2,
            Some(self.worst.error_mps2),
            self.undetected.map(|u| u.effect_mps2),
            self.left_out.iter().flatten().any(contradicts) || is_open(&self.explanations),
        )
    }
}

/// True where explanations that cannot be ruled out differ by more than a fair result may be off.
pub fn is_open(explanations: &[Explained]) -> bool {
    rival(explanations).is_some_and(|rival| rival.difference_mps2 > FAIR_MPS2)
}

/// The grade of a result whose error of ‖a‖ is predicted over all directions (σ) and in the worst one (95 %), in m/s²,
/// of which one pose may hide an error by so much (none: nothing tests it), and which a pose contradicts or not.
pub fn grade(
    predicted_mps2: f64,
    worst_mps2: Option<f64>,
    undetected_mps2: Option<f64>,
    is_contradicted: bool,
) -> Grade {
    let most = [worst_mps2, undetected_mps2].map(|error| error.unwrap_or(f64::INFINITY));
    let is_tested = most[1] <= FAIR_MPS2;
    match most[0].max(most[1]) {
        _ if is_contradicted => Grade::Poor,
        most if is_tested && most <= GOOD_MPS2 => Grade::Good,
        most if is_tested && most <= FAIR_MPS2 => Grade::Fair,
        _ if !is_tested && 2.0 * predicted_mps2 <= UNVERIFIED_MPS2 => Grade::NotVerifiable,
        _ => Grade::Poor,
    }
}

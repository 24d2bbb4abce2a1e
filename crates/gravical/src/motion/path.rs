//! Leg after leg: attitude, velocity, position and what they may be off by.

use std::ops::Range;

use gravical_core::matrix3::{mul, norm, sub, transpose};
use gravical_core::strapdown::{level, matrix, rotate};

use super::anchors::{Anchors, Side, Walk};
use super::bands::{LegNoise, Variances};
use super::gate::Departure;
use super::leg::{Anchor, Gains, Leg, Ran, Removal};
use super::options::GravityRemoval;
use super::parameters::{Direction, Kind};
use super::plan::Stretch;
use super::result::{Ends, FinalState, Move, PositionBudget};
use super::samples::Samples;

/// Step of the parameters for their effect, in standard deviations.
const STEP: f64 = 1e-3;

/// What everything rests on.
#[derive(Clone, Copy)]
pub(super) struct Setup<'a> {
    pub samples: &'a Samples,
    pub walk: Walk,
    pub directions: &'a [Direction],
    pub removal: GravityRemoval,
    /// The mean that is subtracted under [`GravityRemoval::StillMean`], and the
    /// seconds it is over.
    pub mean: Option<([f64; 3], f64)>,
    /// Standard deviation of the tilt during a move without gyroscope, rad.
    pub wobble: f64,
    pub clock_error: f64,
    pub v0: [f64; 3],
    pub p0: [f64; 3],
    pub bands: bool,
}

/// The way, sample by sample; NaN where it is not known.
#[derive(Debug, Default)]
pub(super) struct Path {
    pub attitude: Vec<[f64; 4]>,
    pub acceleration: Vec<[f64; 3]>,
    pub velocity: Vec<[f64; 3]>,
    pub position: Vec<[f64; 3]>,
    pub sigma_velocity: Vec<[f64; 3]>,
    pub sigma_position: Vec<[f64; 3]>,
    pub moves: Vec<Move>,
    pub end: Option<FinalState>,
    pub budget: Option<PositionBudget>,
}

/// Where the sensor is after the legs so far, and how far that may be off.
struct State {
    attitude: [f64; 4],
    position: [f64; 3],
    /// False after a move that cannot be known.
    known: bool,
    noise: [f64; 3],
    tilt: [f64; 3],
    /// By direction: what one standard deviation of it has moved the position.
    offsets: Vec<[f64; 3]>,
    yaw: Yaw,
}

/// Errors of yaw: each that a leg adds turns all that comes after it about the
/// place where it arose.
#[derive(Clone, Copy, Default)]
struct Yaw {
    variance: f64,
    first: [f64; 2],
    second: [f64; 2],
}

impl Yaw {
    fn add(&mut self, variance: f64, at: &[f64; 3]) {
        self.variance += variance;
        for i in 0..2 {
            self.first[i] += variance * at[i];
            self.second[i] += variance * at[i] * at[i];
        }
    }

    /// Σ σ² (p − p_k)², x by the distance in y and the other way round.
    fn at(&self, p: &[f64; 3]) -> [f64; 3] {
        let off = |i: usize| {
            (self.variance * p[i] * p[i] - 2.0 * self.first[i] * p[i] + self.second[i]).max(0.0)
        };
        [off(1), off(0), 0.0]
    }
}

impl<'a> Setup<'a> {
    fn has_gyro(&self) -> bool {
        self.samples.rate_rad_s.is_some()
    }

    fn removal(&self) -> Removal {
        match (self.removal, self.mean) {
            (GravityRemoval::StillMean, Some((mean, _))) => Removal::Mean(mean),
            (GravityRemoval::Strapdown, _) if self.has_gyro() => Removal::Strapdown,
            (GravityRemoval::Strapdown, _) => Removal::Tilt,
            _ => Removal::ConstantTilt,
        }
    }

    /// The leg from `near` to `far` with what its rests say.
    pub(super) fn leg(
        &self,
        near: usize,
        far: usize,
        start: Anchor,
        end: Option<Anchor>,
        attitude: [f64; 4],
    ) -> Leg<'a> {
        let mut leg = Leg {
            samples: self.samples,
            near,
            far,
            start,
            end,
            attitude,
            removal: self.removal(),
            gains: Gains::default(),
            v0: [0.0; 3],
        };
        leg.gains = self.gains(&leg);
        leg
    }

    /// How far to believe the second rest: by what the gyroscope may have missed
    /// against what the levelling may be off.
    fn gains(&self, leg: &Leg<'_>) -> Gains {
        let Some(end) = leg.end else {
            return Gains::default();
        };
        if !matches!(leg.removal, Removal::Strapdown | Removal::Tilt) {
            return Gains::default();
        }
        let t = leg.seconds();
        let g = norm(&leg.start.force);
        let turned = angle(&leg.start.force, &end.force);
        let scale: f64 = self
            .directions
            .iter()
            .map(|d| norm(&d.rate(&[1.0; 3])).powi(2))
            .sum::<f64>()
            / 3.0;
        let drifted = if leg.removal.follows() {
            self.walk.gyro * t
                + 0.25 * (leg.start.bias_variance + end.bias_variance) * t * t
                + scale * turned * turned
        } else {
            self.wobble.powi(2) + turned * turned
        };
        let shown = self.rests_differ(leg, &end, g);
        let tilt = drifted / (drifted + shown.level + shown.parameters_tilt);
        let magnitude = shown.parameters_size / (shown.parameters_size + shown.size);
        Gains {
            tilt: if tilt.is_finite() { tilt } else { 0.0 },
            magnitude: if magnitude.is_finite() {
                magnitude
            } else {
                0.0
            },
        }
    }

    /// Variances of the differences between two rests: in tilt (rad², each
    /// component) and in size (m²/s⁴), by noise and by the parameters.
    fn rests_differ(&self, leg: &Leg<'_>, end: &Anchor, g: f64) -> Differences {
        let n = self.walk.accel.iter().sum::<f64>() / 3.0;
        let noise = n * (1.0 / leg.start.seconds + 1.0 / end.seconds);
        let (near, far) = (level(leg.start.force, 0.0), level(end.force, 0.0));
        // Without yaw between them the second is turned like the first.
        let (mut tilt, mut size) = (0.0, 0.0);
        for d in self.directions {
            let a = rotate(&near, &d.force(&leg.start.force));
            let b = rotate(&far, &d.force(&end.force));
            let off = sub(&b, &a);
            tilt += (off[0] * off[0] + off[1] * off[1]) / (2.0 * g * g);
            size += off[2] * off[2];
        }
        Differences {
            level: noise / (g * g),
            size: noise,
            parameters_tilt: tilt,
            parameters_size: size,
        }
    }

    /// Noise of a leg for the closed forms.
    pub(super) fn noise(
        &self,
        leg: &Leg<'_>,
        anchors: &Anchors<'_>,
        rests: &[Range<usize>],
        ends: (Option<usize>, Option<usize>),
    ) -> LegNoise {
        let r = matrix(&leg.levelled(&leg.start.force));
        // R diag(N²) Rᵀ, its diagonal.
        let spread = mul(
            &mul(&r, &gravical_core::matrix3::diagonal(self.walk.accel)),
            &transpose(&r),
        );
        let g = norm(&leg.start.force);
        let t = leg.seconds();
        let mean_n = self.walk.accel.iter().sum::<f64>() / 3.0;
        let apart = leg.end.map(|end| self.rests_differ(leg, &end, g));
        let follows = leg.removal.follows();
        let wobble = self.wobble.powi(2);
        let same_bias = match ends {
            (Some(a), Some(b)) => anchors.share_bias(rests, a, b),
            _ => true,
        };
        LegNoise {
            accel: [spread[0][0], spread[1][1], spread[2][2]],
            gyro: match (follows, leg.end) {
                (true, _) => self.walk.gyro,
                // A tilt that comes and goes between the rests.
                (false, Some(_)) if t > 0.0 => 4.0 * wobble / t,
                _ => 0.0,
            },
            bias_near: if follows {
                leg.start.bias_variance
            } else {
                0.0
            },
            bias_far: leg
                .end
                .filter(|_| follows && !same_bias)
                .map(|e| e.bias_variance),
            levelling: apart.as_ref().map_or(0.0, |d| d.level),
            level_near: mean_n / leg.start.seconds / (g * g),
            wobble: if follows { 0.0 } else { wobble },
            magnitude: apart.map_or(0.0, |d| leg.gains.magnitude.powi(2) * d.size),
            tilt_gain: leg.gains.tilt,
            gravity: g,
            total: t,
            rest: match (leg.removal, self.mean) {
                (Removal::Mean(_), Some((_, seconds))) => seconds,
                _ => leg.start.seconds,
            },
        }
    }

    /// Follows `plan` from beginning to end.
    pub fn follow(&self, plan: &[Stretch], rests: &[Range<usize>]) -> Path {
        let n = self.samples.len();
        let mut path = Path {
            attitude: vec![[f64::NAN; 4]; n],
            acceleration: vec![[f64::NAN; 3]; n],
            velocity: vec![[f64::NAN; 3]; n],
            position: vec![[f64::NAN; 3]; n],
            sigma_velocity: if self.bands {
                vec![[f64::NAN; 3]; n]
            } else {
                Vec::new()
            },
            sigma_position: if self.bands {
                vec![[f64::NAN; 3]; n]
            } else {
                Vec::new()
            },
            ..Path::default()
        };
        let anchors = Anchors::new(self.samples, self.walk);
        let mut state = State {
            attitude: match rests.first() {
                Some(_) => level(anchors.at(rests, 0, Side::First).force, 0.0),
                None => level(anchors.over(0..n).force, 0.0),
            },
            position: self.p0,
            known: true,
            noise: [0.0; 3],
            tilt: [0.0; 3],
            offsets: vec![[0.0; 3]; self.directions.len()],
            yaw: Yaw::default(),
        };
        if matches!(self.removal(), Removal::Mean(_)) {
            state.attitude = [1.0, 0.0, 0.0, 0.0];
        }
        let mut scratch = (Ran::default(), Ran::default());
        let mut last_velocity = Some([0.0; 3]);
        for stretch in plan {
            match stretch {
                Stretch::Rest(k) => {
                    let anchor = anchors.at(rests, *k, Side::First);
                    let leg = self.leg(
                        rests[*k].start,
                        rests[*k].start,
                        anchor,
                        None,
                        state.attitude,
                    );
                    state.attitude = leg.levelled(&anchor.force);
                    self.rest(&rests[*k], &state, &mut path);
                    last_velocity = Some([0.0; 3]);
                }
                Stretch::Leg {
                    from,
                    to,
                    ends,
                    before,
                    after,
                } => {
                    let (near, far, start, end) = match ends {
                        Ends::RestToRest => (*from, *to, *before, *after),
                        Ends::FromRest | Ends::Free => (*from, *to, *before, None),
                        // From the rest back to the beginning.
                        Ends::ToRest => (*to, *from, *after, None),
                    };
                    let anchor = |k: Option<usize>, side| k.map(|k| anchors.at(rests, k, side));
                    let side = if *ends == Ends::ToRest {
                        Side::First
                    } else {
                        Side::Last
                    };
                    let start_anchor = anchor(start, side)
                        .unwrap_or_else(|| anchors.over(near.min(far)..near.max(far) + 1));
                    let mut leg = self.leg(
                        near,
                        far,
                        start_anchor,
                        anchor(end, Side::First),
                        state.attitude,
                    );
                    if matches!(ends, Ends::Free | Ends::FromRest) {
                        leg.v0 = self.v0;
                    }
                    let noise = self.noise(&leg, &anchors, rests, (start, end));
                    let moved = self.fly(&leg, *ends, &noise, &mut state, &mut path, &mut scratch);
                    last_velocity = path.velocity.get(*to).copied();
                    path.moves.push(moved);
                }
                Stretch::Lost { from, to, gap_s } => {
                    path.moves.push(self.lost(*from, *to, *gap_s));
                    // Before the first rest nothing is counted yet.
                    state.known &= *from == 0;
                    last_velocity = None;
                }
                Stretch::QuietGap { .. } => {}
            }
        }
        let known = state.known;
        path.end = Some(FinalState {
            position_m: known.then_some(state.position),
            sigma_m: (known && self.bands)
                .then(|| path.sigma_position.last().copied())
                .flatten(),
            velocity_mps: last_velocity.filter(|v| v.iter().all(|v| v.is_finite())),
        });
        path.budget = (known && self.bands).then(|| self.budget(&state));
        path
    }

    fn lost(&self, from: usize, to: usize, gap_s: f64) -> Move {
        Move {
            start_s: self.samples.t_s[from],
            end_s: self.samples.t_s[to],
            ends: Ends::Free,
            displacement_m: None,
            sigma_m: None,
            peak_speed_mps: None,
            path_m: None,
            velocity_error_mps: None,
            missing_tilt_deg: None,
            usable: false,
            reason: Some(format!(
                "{gap_s:.2} s are missing in it: how far it went then is not known"
            )),
        }
    }

    fn rest(&self, span: &Range<usize>, state: &State, path: &mut Path) {
        let sigma = self.bands.then(|| self.sigma(state, &state.position));
        let g = rotate(&state.attitude, &[0.0; 3]);
        for i in span.clone() {
            path.attitude[i] = state.attitude;
            path.acceleration[i] = g;
            path.velocity[i] = [0.0; 3];
            if state.known {
                path.position[i] = state.position;
            }
            if let Some(sigma) = sigma {
                path.sigma_velocity[i] = [0.0; 3];
                if state.known {
                    path.sigma_position[i] = sigma;
                }
            }
        }
    }

    /// Standard uncertainty of the position after the legs so far.
    fn sigma(&self, state: &State, position: &[f64; 3]) -> [f64; 3] {
        let yaw = state.yaw.at(position);
        std::array::from_fn(|i| {
            let parameters: f64 = state.offsets.iter().map(|o| o[i] * o[i]).sum();
            let clock = (2.0 * self.clock_error * (position[i] - self.p0[i])).powi(2);
            (state.noise[i] + state.tilt[i] + parameters + clock + yaw[i]).sqrt()
        })
    }

    fn budget(&self, state: &State) -> PositionBudget {
        let root = |v: [f64; 3]| v.iter().sum::<f64>().sqrt();
        let of = |kind: Kind| -> f64 {
            self.directions
                .iter()
                .zip(&state.offsets)
                .filter(|(d, _)| d.kind == kind)
                .map(|(_, o)| o.iter().map(|v| v * v).sum::<f64>())
                .sum::<f64>()
        };
        let yaw = state.yaw.at(&state.position);
        PositionBudget {
            noise: root(state.noise),
            bias: of(Kind::Bias).sqrt(),
            scale: of(Kind::Scale).sqrt(),
            clock: 2.0 * self.clock_error * norm(&sub(&state.position, &self.p0)),
            tilt: (state.tilt.iter().chain(&yaw).sum::<f64>() + of(Kind::Gyro)).sqrt(),
        }
    }

    /// Runs one leg, writes its samples, and takes the state to its end.
    fn fly(
        &self,
        leg: &Leg<'_>,
        ends: Ends,
        noise: &LegNoise,
        state: &mut State,
        path: &mut Path,
        scratch: &mut (Ran, Ran),
    ) -> Move {
        let (ran, changed) = scratch;
        leg.run(&Direction::NONE, true, ran);
        let count = ran.tau.len();
        let last = count - 1;
        // Of a leg that ran backwards the far end is the start.
        let backwards = ends == Ends::ToRest;
        let zero = if backwards {
            ran.position[last]
        } else {
            [0.0; 3]
        };
        let way = if backwards {
            ran.position[last].map(|v| -v)
        } else {
            ran.position[last]
        };
        let origin = state.position;
        let order = |k: usize| {
            if backwards {
                leg.near - k
            } else {
                leg.near + k
            }
        };
        for k in 0..count {
            let i = order(k);
            path.attitude[i] = ran.attitude[k];
            path.acceleration[i] = ran.acceleration[k];
            path.velocity[i] = ran.velocity[k];
            if state.known {
                path.position[i] =
                    std::array::from_fn(|a| origin[a] + ran.position[k][a] - zero[a]);
            }
        }
        let mut displacement_sigma = None;
        if self.bands {
            let mut variance_v = vec![[0.0; 3]; count];
            let mut variance_p = vec![[0.0; 3]; count];
            let mut own = [0.0; 3];
            for (direction, offset) in self.directions.iter().zip(&mut state.offsets) {
                leg.run(&direction.times(STEP), false, changed);
                let off = |k: usize, i: usize| (changed.position[k][i] - ran.position[k][i]) / STEP;
                let far: [f64; 3] = std::array::from_fn(|i| off(last, i));
                for k in 0..count {
                    for i in 0..3 {
                        let base = if backwards { -far[i] } else { 0.0 };
                        let p = offset[i] + off(k, i) + base;
                        let v = (changed.velocity[k][i] - ran.velocity[k][i]) / STEP;
                        variance_p[k][i] += p * p;
                        variance_v[k][i] += v * v;
                    }
                }
                for i in 0..3 {
                    own[i] += far[i] * far[i];
                    offset[i] += if backwards { -far[i] } else { far[i] };
                }
            }
            let mut end = Variances::default();
            for k in 0..count {
                let tau = ran.tau[k].abs();
                let (v, p) = self.variances(leg, ends, noise, tau);
                let rotation = self.rotation(noise, tau, &ran.position[k], &zero);
                let i = order(k);
                let here: [f64; 3] =
                    std::array::from_fn(|a| origin[a] + ran.position[k][a] - zero[a]);
                let yaw = state.yaw.at(&here);
                for a in 0..3 {
                    let clock = 2.0 * self.clock_error * (here[a] - self.p0[a]);
                    let total = state.noise[a]
                        + state.tilt[a]
                        + p.noise[a]
                        + p.tilt[a]
                        + rotation[a]
                        + variance_p[k][a]
                        + yaw[a]
                        + clock * clock;
                    if state.known {
                        path.sigma_position[i][a] = total.sqrt();
                    }
                    let clock = self.clock_error * ran.velocity[k][a];
                    path.sigma_velocity[i][a] =
                        (v.noise[a] + v.tilt[a] + variance_v[k][a] + clock * clock).sqrt();
                }
                if k == if backwards { 0 } else { last } {
                    end = p;
                    (0..3).for_each(|a| end.tilt[a] += rotation[a]);
                }
            }
            displacement_sigma = Some(std::array::from_fn(|a| {
                let clock = 2.0 * self.clock_error * way[a];
                (end.noise[a] + end.tilt[a] + own[a] + clock * clock).sqrt()
            }));
            for a in 0..3 {
                state.noise[a] += end.noise[a];
                state.tilt[a] += end.tilt[a];
            }
        }
        let place: [f64; 3] = std::array::from_fn(|a| origin[a] + way[a]);
        if noise.gyro > 0.0 || noise.bias_near > 0.0 {
            let yaw = noise.gyro * noise.total + noise.bias_near * noise.total.powi(2);
            state.yaw.add(yaw, &place);
        }
        state.position = place;
        if !backwards {
            state.attitude = ran.last;
        }
        let speeds = ran.velocity.iter().map(norm);
        let path_m: f64 = ran
            .velocity
            .windows(2)
            .zip(ran.tau.windows(2))
            .map(|(v, t)| 0.5 * (norm(&v[0]) + norm(&v[1])) * (t[1] - t[0]).abs())
            .sum();
        Move {
            start_s: self.samples.t_s[leg.near.min(leg.far)],
            end_s: self.samples.t_s[leg.near.max(leg.far)],
            ends,
            displacement_m: Some(way),
            sigma_m: displacement_sigma,
            peak_speed_mps: Some(speeds.fold(0.0, f64::max)),
            path_m: Some(path_m),
            velocity_error_mps: leg.end.map(|_| ran.left_over),
            missing_tilt_deg: leg.end.map(|_| norm(&ran.missing).to_degrees()),
            usable: true,
            reason: None,
        }
    }

    fn variances(
        &self,
        leg: &Leg<'_>,
        ends: Ends,
        noise: &LegNoise,
        tau: f64,
    ) -> (Variances, Variances) {
        match (leg.removal, ends) {
            (Removal::Mean(_), Ends::FromRest | Ends::Free) => noise.after_mean(tau),
            (_, Ends::RestToRest) => noise.between(tau),
            (_, Ends::ToRest) => (noise.open(tau).0, noise.way_open(tau)),
            (_, Ends::FromRest | Ends::Free) => noise.open(tau),
        }
    }

    /// What a tilt that the levelling missed turns up and down, and what the yaw
    /// of the leg itself turns sideways.
    fn rotation(&self, noise: &LegNoise, tau: f64, p: &[f64; 3], zero: &[f64; 3]) -> [f64; 3] {
        let p: [f64; 3] = std::array::from_fn(|i| p[i] - zero[i]);
        let level = noise.level_near;
        let yaw = (noise.gyro * tau + noise.bias_near * tau * tau) / 3.0;
        [
            level * p[2] * p[2] + yaw * p[1] * p[1],
            level * p[2] * p[2] + yaw * p[0] * p[0],
            level * (p[0] * p[0] + p[1] * p[1]),
        ]
    }
}

struct Differences {
    level: f64,
    size: f64,
    parameters_tilt: f64,
    parameters_size: f64,
}

impl Removal {
    fn follows(&self) -> bool {
        matches!(self, Removal::Strapdown)
    }
}

fn angle(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    crate::segment::face::angle_deg(*a, *b).to_radians()
}

impl Departure for Setup<'_> {
    fn leg(&self, rests: &[Range<usize>], k: usize) -> Leg<'_> {
        let anchors = Anchors::new(self.samples, self.walk);
        let start = anchors.at(rests, k, Side::Last);
        let near = rests[k].end - 1;
        Setup::leg(self, near, near, start, None, level(start.force, 0.0))
    }

    fn variance(&self, leg: &Leg<'_>, tau: f64) -> [f64; 3] {
        let anchors = Anchors::new(self.samples, self.walk);
        let noise = self.noise(leg, &anchors, &[], (None, None));
        let v = noise.open(tau).0;
        std::array::from_fn(|i| v.noise[i] + v.tilt[i])
    }
}

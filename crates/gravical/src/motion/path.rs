//! Leg after leg: attitude, velocity, position and what they may be off by.

use std::ops::Range;

use gravical_core::matrix3::{dot, mul, norm, sub, transpose};
use gravical_core::strapdown::{level, matrix, rotate};

use super::anchors::{Anchors, Side, Walk};
use super::bands::{LegNoise, Variances};
use super::gate::Departure;
use super::leg::{Anchor, Leg, Ran, Removal};
use super::options::GravityRemoval;
use super::parameters::{Direction, Kind};
use super::plan::Stretch;
use super::result::{Ends, FinalState, Move, PositionBudget};
use super::samples::Samples;
use super::smoother::{Noise, Smoother};

/// Step of the parameters for their effect, in standard deviations.
const STEP: f64 = 1e-3;

/// Errors of scale and alignment turn the attitude one way while the sensor turns
/// one way: so long, s.
const TURN_CORRELATION_S: f64 = 0.1;

/// … and of a sensor that turns to and fro this share of them stays, as a rate:
/// axes that are not square turn a wobble into a drift.
const RECTIFIED: f64 = 0.2;

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
        let removal = self.removal();
        let g = norm(&start.force);
        let total = self.samples.t_s[far] - self.samples.t_s[near];
        let differ = end.map_or_else(Differences::default, |end| {
            self.rests_differ(&start, &end, g)
        });
        Leg {
            samples: self.samples,
            near,
            far,
            start,
            end,
            attitude,
            removal,
            smoother: self.smoother((near, far), total.abs(), &start, end.as_ref(), &differ, g),
            magnitude_gain: match end {
                Some(_) if differ.parameters_size > 0.0 => {
                    differ.parameters_size / (differ.parameters_size + differ.size)
                }
                _ => 0.0,
            },
            v0: [0.0; 3],
        }
    }

    /// What the second rest says of the tilt along the leg.
    fn smoother(
        &self,
        (near, far): (usize, usize),
        total: f64,
        start: &Anchor,
        end: Option<&Anchor>,
        differ: &Differences,
        g: f64,
    ) -> Smoother {
        let removal = self.removal();
        let mean_n = self.walk.accel.iter().sum::<f64>() / 3.0;
        let level = mean_n / start.seconds / (g * g);
        let follows = removal.follows();
        let bias = match end {
            Some(end) if follows => 0.25 * (start.bias_variance + end.bias_variance),
            _ => 0.0,
        };
        let noise = Noise {
            bias,
            level,
            accel: mean_n,
            seen: match (end, removal) {
                (Some(end), Removal::Strapdown | Removal::Tilt) => mean_n / end.seconds / (g * g),
                _ => f64::INFINITY,
            },
        };
        let mut design = Noise {
            seen: noise.seen + differ.parameters_tilt,
            ..noise
        };
        if !follows {
            // A tilt that comes and goes between the rests.
            let q = if total > 0.0 {
                4.0 * self.wobble.powi(2) / total
            } else {
                0.0
            };
            return Smoother::new(total, g, design, noise, end.is_some(), |_, _| (q, q));
        }
        let turning =
            end.map(|end| Turning::new(self.samples, near.min(far)..near.max(far) + 1, start, end));
        let scale: f64 = self
            .directions
            .iter()
            .map(|d| norm(&d.rate(&[1.0; 3])).powi(2))
            .sum::<f64>()
            / 3.0;
        let all = turning.as_ref().map_or(0.0, |t| t.mean_square(0.0, total));
        design.bias += scale * all * RECTIFIED.powi(2);
        Smoother::new(total, g, design, noise, end.is_some(), |from, to| {
            let turned = turning.as_ref().map_or(0.0, |t| t.mean_square(from, to));
            (
                self.walk.gyro + scale * turned * TURN_CORRELATION_S,
                self.walk.gyro,
            )
        })
    }

    /// Variances of the differences between two rests: in tilt (rad², each
    /// component) and in size (m²/s⁴), by noise and by the parameters.
    fn rests_differ(&self, start: &Anchor, end: &Anchor, g: f64) -> Differences {
        let n = self.walk.accel.iter().sum::<f64>() / 3.0;
        let noise = n * (1.0 / start.seconds + 1.0 / end.seconds);
        let (near, far) = (level(start.force, 0.0), level(end.force, 0.0));
        // Without yaw between them the second is turned like the first.
        let (mut tilt, mut size) = (0.0, 0.0);
        for d in self.directions {
            let a = rotate(&near, &d.force(&start.force));
            let b = rotate(&far, &d.force(&end.force));
            let off = sub(&b, &a);
            tilt += (off[0] * off[0] + off[1] * off[1]) / (2.0 * g * g);
            size += off[2] * off[2];
        }
        Differences {
            size: noise,
            parameters_tilt: tilt,
            parameters_size: size,
        }
    }

    /// Noise of a leg for its bands.
    pub(super) fn noise(&self, leg: &Leg<'_>) -> LegNoise {
        let r = matrix(&leg.levelled(&leg.start.force));
        // The diagonal of R diag(N²) Rᵀ.
        let spread = mul(
            &mul(&r, &gravical_core::matrix3::diagonal(self.walk.accel)),
            &transpose(&r),
        );
        let g = norm(&leg.start.force);
        let mean_n = self.walk.accel.iter().sum::<f64>() / 3.0;
        let follows = leg.removal.follows();
        let only = |there: bool, value: f64| if there { value } else { 0.0 };
        LegNoise {
            accel: [spread[0][0], spread[1][1], spread[2][2]],
            gyro: only(follows, self.walk.gyro),
            bias: only(follows, leg.start.bias_variance),
            level_near: mean_n / leg.start.seconds / (g * g),
            wobble: only(!follows, self.wobble.powi(2)),
            magnitude: leg.end.map_or(0.0, |end| {
                leg.magnitude_gain.powi(2) * self.rests_differ(&leg.start, &end, g).size
            }),
            gravity: g,
            total: leg.seconds(),
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
                    let noise = self.noise(&leg);
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
        if noise.gyro > 0.0 || noise.bias > 0.0 {
            let yaw = noise.gyro * noise.total + noise.bias * noise.total.powi(2);
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
            (_, Ends::RestToRest) => noise.between(&leg.smoother, tau),
            (_, Ends::ToRest) => (noise.open(tau).0, noise.way_open(tau)),
            (_, Ends::FromRest | Ends::Free) => noise.open(tau),
        }
    }

    /// What a tilt that the levelling missed turns up and down, and what the yaw
    /// of the leg itself turns sideways.
    fn rotation(&self, noise: &LegNoise, tau: f64, p: &[f64; 3], zero: &[f64; 3]) -> [f64; 3] {
        let p: [f64; 3] = std::array::from_fn(|i| p[i] - zero[i]);
        let level = noise.level_near;
        let yaw = (noise.gyro * tau + noise.bias * tau * tau) / 3.0;
        [
            level * p[2] * p[2] + yaw * p[1] * p[1],
            level * p[2] * p[2] + yaw * p[0] * p[0],
            level * (p[0] * p[0] + p[1] * p[1]),
        ]
    }
}

#[derive(Default)]
struct Differences {
    size: f64,
    parameters_tilt: f64,
    parameters_size: f64,
}

impl Removal {
    fn follows(&self) -> bool {
        matches!(self, Removal::Strapdown)
    }
}

/// How fast the sensor turned, as running sums.
struct Turning<'a> {
    t_s: &'a [f64],
    /// ∫‖ω‖² dt up to each sample, rad²/s.
    sum: Vec<f64>,
}

impl<'a> Turning<'a> {
    fn new(samples: &'a Samples, rows: Range<usize>, start: &Anchor, end: &Anchor) -> Self {
        let bias: [f64; 3] = std::array::from_fn(|i| 0.5 * (start.bias[i] + end.bias[i]));
        let t_s = &samples.t_s[rows.clone()];
        let mut total = 0.0;
        let mut before = t_s.first().copied().unwrap_or(0.0);
        let sum = rows
            .map(|i| {
                let w = sub(&samples.rate_at(i), &bias);
                total += dot(&w, &w) * (samples.t_s[i] - before);
                before = samples.t_s[i];
                total
            })
            .collect();
        Turning { t_s, sum }
    }

    /// Mean of ‖ω‖² between two times since the start.
    fn mean_square(&self, from: f64, to: f64) -> f64 {
        let at = |tau: f64| {
            let i = self.t_s.partition_point(|t| t - self.t_s[0] < tau);
            self.sum.get(i).or(self.sum.last()).copied().unwrap_or(0.0)
        };
        if to > from {
            (at(to) - at(from)) / (to - from)
        } else {
            0.0
        }
    }
}

impl Departure for Setup<'_> {
    fn leg(&self, rests: &[Range<usize>], k: usize) -> Leg<'_> {
        let anchors = Anchors::new(self.samples, self.walk);
        let start = anchors.at(rests, k, Side::Last);
        let near = rests[k].end - 1;
        Setup::leg(self, near, near, start, None, level(start.force, 0.0))
    }

    fn variance(&self, leg: &Leg<'_>, tau: f64) -> [f64; 3] {
        let noise = self.noise(leg);
        let v = noise.open(tau).0;
        std::array::from_fn(|i| v.noise[i] + v.tilt[i])
    }
}

//! What a leg is made of: its anchors, the smoother between them, its noise.

use std::ops::Range;

use gravical_core::matrix3::{diagonal, dot, mul, norm, sub, transpose};
use gravical_core::strapdown::{level, matrix, rotate};

use super::super::anchors::{Anchors, Side, Walk};
use super::super::bands::LegNoise;
use super::super::gate::{Departure, Way};
use super::super::leg::{Anchor, Leg, Removal};
use super::super::options::GravityRemoval;
use super::super::parameters::Direction;
use super::super::samples::Samples;
use super::super::smoother::{Noise, Smoother};

/// Errors of scale and alignment turn the attitude one way while the sensor turns
/// one way: so long, s.
const TURN_CORRELATION_S: f64 = 0.1;

/// … and of a sensor that turns to and fro this share of them stays, as a rate:
/// axes that are not square turn a wobble into a drift.
const RECTIFIED: f64 = 0.2;

/// What everything rests on.
#[derive(Clone, Copy)]
pub(in crate::motion) struct Setup<'a> {
    pub samples: &'a Samples,
    /// Stances of a walk, in order.
    pub stances: &'a [Range<usize>],
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

impl<'a> Setup<'a> {
    fn has_gyro(&self) -> bool {
        self.samples.rate_rad_s.is_some()
    }

    pub(in crate::motion) fn removal(&self) -> Removal {
        match (self.removal, self.mean) {
            (GravityRemoval::StillMean, Some((mean, _))) => Removal::Mean(mean),
            (GravityRemoval::Strapdown, _) if self.has_gyro() => Removal::Strapdown,
            (GravityRemoval::Strapdown, _) => Removal::Tilt,
            _ => Removal::ConstantTilt,
        }
    }

    /// The leg from `near` to `far` with what its rests say.
    pub(in crate::motion) fn leg(
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
            stances: self
                .stances
                .iter()
                .filter(|s| near < s.start && s.end <= far)
                .map(|s| s.start - near..s.end - near)
                .collect(),
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
            return Smoother::new(total, g, design, noise, end.is_some(), |_, _| {
                // Where a mean is taken off, nothing is turned.
                match removal {
                    Removal::Mean(_) => (0.0, q),
                    _ => (q, q),
                }
            });
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
    pub(in crate::motion) fn noise(&self, leg: &Leg<'_>) -> LegNoise {
        let r = matrix(&leg.levelled(&leg.start.force));
        // The diagonal of R diag(N²) Rᵀ.
        let spread = mul(&mul(&r, &diagonal(self.walk.accel)), &transpose(&r));
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
    fn leg(&self, rests: &[Range<usize>], k: usize, way: Way) -> Leg<'_> {
        let anchors = Anchors::new(self.samples, self.walk);
        let (side, near) = match way {
            Way::Forwards => (Side::Last, rests[k].end - 1),
            Way::Backwards => (Side::First, rests[k].start),
        };
        let start = anchors.at(rests, k, side);
        Setup::leg(self, near, near, start, None, level(start.force, 0.0))
    }

    fn variance(&self, leg: &Leg<'_>, tau: f64) -> [f64; 3] {
        let noise = self.noise(leg);
        let v = noise.open(tau).0;
        std::array::from_fn(|i| v.noise[i] + v.tilt[i])
    }
}

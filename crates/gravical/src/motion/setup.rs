//! What a leg is made of: its anchors, the smoother between them, its noise.

use std::f64::consts::PI;
use std::ops::Range;

use gravical_core::matrix3::{diagonal, dot, mul, norm, sub, transpose};
use gravical_core::motion::OpenNoise;
use gravical_core::strapdown::{level, matrix, rotate};

use super::anchors::RandomWalk;
use super::bands::LegNoise;
use super::hidden::Hidden;
use super::leg::{Anchor, Closing, Leg, Removal};
use super::options::GravityRemoval;
use super::parameters::Direction;
use super::samples::View;
use super::smoother::{Noise, Smoother};
use super::unfollowed::missed_rad;
use crate::recording::Meter;

/// Errors of scale and alignment turn the attitude one way while the sensor turns
/// one way: so long, s.
const TURN_CORRELATION_S: f64 = 0.1;

/// … and of a sensor that turns to and fro this share of them stays, as a rate:
/// axes that are not square turn a wobble into a drift.
const RECTIFIED: f64 = 0.2;

/// What everything rests on.
#[derive(Clone, Copy)]
pub(super) struct Setup<'a> {
    pub view: View<'a>,
    /// Stances of a walk, in order.
    pub stances: &'a [Range<usize>],
    pub walk: RandomWalk,
    /// Stretches that are quiet at a speed, m/s.
    pub rides: &'a [(Range<usize>, f64)],
    pub directions: &'a [Direction],
    pub removal: GravityRemoval,
    /// The mean that is subtracted under [`GravityRemoval::InitialMean`], and the
    /// seconds it is over.
    pub mean: Option<([f64; 3], f64)>,
    /// Standard deviation of the tilt during a move without gyroscope, rad.
    pub wobble: f64,
    pub clock_error: f64,
    pub v0: [f64; 3],
    pub p0: [f64; 3],
    /// What moves without being seen.
    pub hidden: Hidden,
    pub bands: bool,
    /// Tells when nobody waits for the result any more.
    pub meter: Option<&'a Meter>,
}

impl<'a> Setup<'a> {
    /// Nobody waits any more: what is computed from here on is dropped.
    pub(super) fn is_stopped(&self) -> bool {
        self.meter.is_some_and(Meter::is_stopped)
    }

    pub(super) fn removal(&self) -> Removal {
        match (self.removal, self.mean) {
            (GravityRemoval::InitialMean, Some((mean, _))) => Removal::Mean(mean),
            (GravityRemoval::Strapdown, _) if self.view.has_gyro() => Removal::Strapdown,
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
        Leg {
            view: self.view,
            near,
            far,
            start,
            closing: end.map(|end| {
                let differ = self.rests_differ(&start, &end);
                let whole = differ.parameters_size + differ.size;
                Closing {
                    rest: end,
                    smoother: self.smoother((near, far), &start, &end, &differ),
                    magnitude_gain: if differ.parameters_size > 0.0 {
                        differ.parameters_size / whole
                    } else {
                        0.0
                    },
                }
            }),
            attitude,
            removal: self.removal(),
            stances: self.stances[self.stances.partition_point(|s| s.start <= near)..]
                .iter()
                .take_while(|s| s.end <= far)
                .map(|s| s.start - near..s.end - near)
                .collect(),
            v0: [0.0; 3],
        }
    }

    /// What the second rest says of the tilt along the leg.
    fn smoother(
        &self,
        (near, far): (usize, usize),
        start: &Anchor,
        end: &Anchor,
        differ: &Differences,
    ) -> Smoother {
        let removal = self.removal();
        let g = norm(&start.force);
        let mean_n = self.walk.accel_mean();
        let follows = removal.follows();
        let noise = Noise {
            bias: if follows {
                0.25 * (start.bias_variance + end.bias_variance)
            } else {
                0.0
            },
            level: mean_n / start.seconds / (g * g),
            accel: mean_n,
            seen: match removal {
                Removal::Strapdown | Removal::Tilt => mean_n / end.seconds / (g * g),
                _ => f64::INFINITY,
            },
        };
        let t_s = self.view.t_s();
        let total = (t_s[far] - t_s[near]).abs();
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
            return Smoother::new(total, g, design, noise, |_, _| {
                // Where a mean is taken off, nothing is turned.
                match removal {
                    Removal::Mean(_) => (0.0, q),
                    _ => (q, q),
                }
            });
        }
        let turning = Turning::new(self.view, near.min(far)..near.max(far) + 1, start, end);
        let scale: f64 = self
            .directions
            .iter()
            .map(|d| norm(&d.rate(&[1.0; 3])).powi(2))
            .sum::<f64>()
            / 3.0;
        design.bias += scale * turning.mean_square(0.0, total) * RECTIFIED.powi(2);
        let walk = self.gyro_density(near, far);
        Smoother::new(total, g, design, noise, |from, to| {
            let turned = turning.mean_square(from, to);
            (walk + scale * turned * TURN_CORRELATION_S, walk)
        })
    }

    /// Variances of the differences between two rests: in tilt (rad², each
    /// component) and in size (m²/s⁴), by noise and by the parameters.
    fn rests_differ(&self, start: &Anchor, end: &Anchor) -> Differences {
        let g = norm(&start.force);
        let noise = self.walk.accel_mean() * (1.0 / start.seconds + 1.0 / end.seconds);
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

    /// The greatest speed at which a leg with a rest at one end alone is quiet, m/s.
    fn ride(&self, leg: &Leg<'_>) -> f64 {
        let (from, to) = (leg.near.min(leg.far), leg.near.max(leg.far));
        let inside = |span: &Range<usize>| from <= span.start && span.end <= to + 1;
        self.rides
            .iter()
            .filter(|(span, _)| leg.closing.is_none() && inside(span))
            .fold(0.0, |most, (_, speed)| speed.max(most))
    }

    /// Density of the tilt's walk along a leg, rad²/s.
    fn gyro_density(&self, near: usize, far: usize) -> f64 {
        let t_s = self.view.t_s();
        let missed = missed_rad(self.view.samples, near.min(far)..near.max(far) + 1);
        self.tilt_density(missed, (t_s[far] - t_s[near]).abs())
    }

    /// Density of the tilt's walk over `seconds`, rad²/s: by the gyroscope's noise, and by the
    /// turn that it `missed` at the end of its range, rad, at an unknown moment. No tilt is off
    /// by more than half a turn. Zero without a gyroscope that is followed.
    pub(super) fn tilt_density(&self, missed: f64, seconds: f64) -> f64 {
        match (self.removal().follows(), seconds > 0.0) {
            (false, _) => 0.0,
            (true, false) => self.walk.gyro,
            (true, true) => self.walk.gyro + missed.min(PI).powi(2) / seconds,
        }
    }

    /// Noise of a leg for its bands.
    pub(super) fn noise(&self, leg: &Leg<'_>) -> LegNoise {
        let r = matrix(&leg.removal.levelled(&leg.attitude, &leg.start.force));
        // The diagonal of R diag(N²) Rᵀ.
        let spread = mul(&mul(&r, &diagonal(self.walk.accel)), &transpose(&r));
        let g = norm(&leg.start.force);
        let follows = leg.removal.follows();
        let only = |there: bool, value: f64| if there { value } else { 0.0 };
        LegNoise {
            accel: [spread[0][0], spread[1][1], spread[2][2]],
            open: OpenNoise {
                gyro: self.gyro_density(leg.near, leg.far),
                bias: only(follows, leg.start.bias_variance),
                tilt_change: only(!follows, self.wobble.powi(2)),
                gravity: g,
                rest_s: match (leg.removal, self.mean) {
                    (Removal::Mean(_), Some((_, seconds))) => seconds,
                    _ => leg.start.seconds,
                },
            },
            level_near: self.walk.accel_mean() / leg.start.seconds / (g * g),
            magnitude: leg.closing.as_ref().map_or(0.0, |closing| {
                let differ = self.rests_differ(&leg.start, &closing.rest);
                closing.magnitude_gain.powi(2) * differ.size
            }),
            ride: self.ride(leg).powi(2),
            total: leg.seconds(),
        }
    }
}

#[derive(Default)]
struct Differences {
    size: f64,
    parameters_tilt: f64,
    parameters_size: f64,
}

/// How fast the sensor turned, as running sums.
struct Turning<'a> {
    t_s: &'a [f64],
    /// ∫‖ω‖² dt up to each sample, rad²/s.
    sum: Vec<f64>,
}

impl<'a> Turning<'a> {
    fn new(view: View<'a>, rows: Range<usize>, start: &Anchor, end: &Anchor) -> Self {
        let bias: [f64; 3] = std::array::from_fn(|i| 0.5 * (start.bias[i] + end.bias[i]));
        let t_s = &view.t_s()[rows.clone()];
        let mut total = 0.0;
        let mut before = t_s.first().copied().unwrap_or(0.0);
        let sum = rows
            .map(|i| {
                let w = sub(&view.rate_at(i), &bias);
                total += dot(&w, &w) * (view.t_s()[i] - before);
                before = view.t_s()[i];
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

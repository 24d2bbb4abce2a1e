//! What lies between the rests: which legs there are, and what is lost.

use std::ops::Range;

use super::result::{Ends, Loss};
use super::samples::Samples;

/// A stretch of the recording, in order.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Stretch {
    /// The rest of that index.
    Rest(usize),
    /// A leg over samples `from` to `to`, both included; the rests at its ends.
    Leg {
        from: usize,
        to: usize,
        ends: Ends,
        before: Option<usize>,
        after: Option<usize>,
    },
    /// Samples between two rests of which something is missing.
    Lost { from: usize, to: usize, why: Loss },
    /// A gap while at rest: nothing moved. Zero where nothing tells how long it is.
    QuietGap { gap_s: f64 },
}

/// Two rests with a gap between them are one when gravity is the same to this,
/// relative: less than a degree of tilt.
const SAME_POSE: f64 = 0.015;

/// A gap between two rests in which something may have been moved away and back,
/// s.
const LONGEST_QUIET_GAP_S: f64 = 10.0;

/// Cuts a recording at its rests. Without `zero_velocity` one leg goes from the
/// first rest to the end.
pub(super) fn plan(samples: &Samples, rests: &[Range<usize>], zero_velocity: bool) -> Vec<Stretch> {
    let last = samples.len() - 1;
    let Some(first) = rests.first() else {
        return without_rest(samples);
    };
    let gaps = Gaps::new(samples);
    let mut out = Vec::new();
    if first.start > 0 {
        match gaps.within(0, first.start) {
            Some(gap_s) => out.push(Stretch::Lost {
                from: 0,
                to: first.start,
                why: Loss::Gap { seconds: gap_s },
            }),
            None => out.push(Stretch::Leg {
                from: 0,
                to: first.start,
                ends: Ends::ToRest,
                before: None,
                after: Some(0),
            }),
        }
    }
    for k in 0..rests.len() {
        out.push(Stretch::Rest(k));
        let from = rests[k].end - 1;
        let next = rests.get(k + 1).filter(|_| zero_velocity);
        let (to, ends, after) = match next {
            Some(next) => (next.start, Ends::RestToRest, Some(k + 1)),
            None if from < last => (last, Ends::FromRest, None),
            None => break,
        };
        match gaps.within(from, to) {
            None => out.push(Stretch::Leg {
                from,
                to,
                ends,
                before: Some(k),
                after,
            }),
            Some(gap_s)
                if to == from + 1
                    && gap_s <= LONGEST_QUIET_GAP_S
                    && next.is_some_and(|next| same_pose(samples, &rests[k], next)) =>
            {
                out.push(Stretch::QuietGap { gap_s });
            }
            Some(gap_s) => {
                // What comes before the gap can be had, open as it is.
                let whole = match next {
                    Some(_) => from,
                    None => samples.breaks[samples.breaks.partition_point(|b| *b <= from)] - 1,
                };
                if whole > from {
                    out.push(Stretch::Leg {
                        from,
                        to: whole,
                        ends: Ends::FromRest,
                        before: Some(k),
                        after: None,
                    });
                }
                out.push(Stretch::Lost {
                    from: whole,
                    to,
                    why: Loss::Gap { seconds: gap_s },
                });
            }
        }
        if next.is_none() {
            break;
        }
    }
    out
}

fn without_rest(samples: &Samples) -> Vec<Stretch> {
    let last = samples.len() - 1;
    let end = samples.breaks.first().map_or(last, |b| b - 1);
    let mut out = Vec::new();
    if end > 0 {
        out.push(Stretch::Leg {
            from: 0,
            to: end,
            ends: Ends::Free,
            before: None,
            after: None,
        });
    }
    if end < last {
        out.push(Stretch::Lost {
            from: end,
            to: last,
            why: Loss::Gap {
                seconds: Gaps::new(samples).within(end, last).unwrap_or(0.0),
            },
        });
    }
    out
}

/// One leg from the first sample on, up to the first gap: the procedure without
/// rests. The rest that it starts from is the first.
pub(super) fn whole(samples: &Samples) -> Vec<Stretch> {
    let mut out = without_rest(samples);
    if let Some(Stretch::Leg { ends, before, .. }) = out.first_mut() {
        (*ends, *before) = (Ends::FromRest, Some(0));
    }
    out
}

/// What is missing between two samples that do not follow each other, `seconds` apart, where
/// usual ones are `step_s` apart, s: zero where no stamp shows a gap.
pub(super) fn missing_s(seconds: f64, step_s: f64) -> f64 {
    if seconds <= 1.5 * step_s {
        0.0
    } else {
        seconds
    }
}

/// Breaks, and how much is missing at each.
struct Gaps<'a> {
    samples: &'a Samples,
    step_s: f64,
}

impl<'a> Gaps<'a> {
    fn new(samples: &'a Samples) -> Self {
        let step_s = match samples.breaks.is_empty() {
            true => f64::NAN,
            false => samples.median_step_s(),
        };
        Gaps { samples, step_s }
    }

    /// The longest gap at a break after `from` and up to `to`, s; none without a break.
    fn within(&self, from: usize, to: usize) -> Option<f64> {
        let Samples { t_s, breaks, .. } = self.samples;
        let start = breaks.partition_point(|b| *b <= from);
        let inside = breaks[start..].iter().take_while(|b| **b <= to);
        inside
            .map(|b| missing_s(t_s[*b] - t_s[b - 1], self.step_s))
            .reduce(f64::max)
    }
}

fn same_pose(samples: &Samples, a: &Range<usize>, b: &Range<usize>) -> bool {
    let mean = |rows: &Range<usize>| -> [f64; 3] {
        std::array::from_fn(|i| {
            samples.force_mps2[i][rows.clone()].iter().sum::<f64>() / rows.len() as f64
        })
    };
    let (a, b) = (mean(a), mean(b));
    let off = gravical_core::matrix3::norm(&gravical_core::matrix3::sub(&a, &b));
    off <= SAME_POSE * gravical_core::matrix3::norm(&a)
}

#[cfg(test)]
// One rest is a range in a list.
#[allow(clippy::single_range_in_vec_init)]
mod tests {
    use super::super::result::Move;
    use super::*;

    /// 1 Hz at rest, with a gap before each break.
    fn samples(n: usize, breaks: &[usize], gap_s: f64) -> Samples {
        let mut t = -1.0;
        let t_s = (0..n)
            .map(|i| {
                t += if breaks.contains(&i) { gap_s } else { 1.0 };
                t
            })
            .collect();
        Samples {
            t_s,
            force_mps2: [vec![0.0; n], vec![0.0; n], vec![9.8; n]],
            rate_rad_s: None,
            breaks: breaks.to_vec(),
            resolution: [0.0; 6],
            clipped: Vec::new(),
        }
    }

    fn leg(
        from: usize,
        to: usize,
        ends: Ends,
        before: Option<usize>,
        after: Option<usize>,
    ) -> Stretch {
        Stretch::Leg {
            from,
            to,
            ends,
            before,
            after,
        }
    }

    #[test]
    fn rests_part_the_legs() {
        let all = plan(&samples(100, &[], 1.0), &[10..20, 50..60], true);
        assert_eq!(
            all,
            [
                leg(0, 10, Ends::ToRest, None, Some(0)),
                Stretch::Rest(0),
                leg(19, 50, Ends::RestToRest, Some(0), Some(1)),
                Stretch::Rest(1),
                leg(59, 99, Ends::FromRest, Some(1), None),
            ]
        );
        let open = plan(&samples(100, &[], 1.0), &[0..20, 50..60], false);
        assert_eq!(
            open,
            [Stretch::Rest(0), leg(19, 99, Ends::FromRest, Some(0), None)]
        );
        assert_eq!(
            plan(&samples(9, &[], 1.0), &[], true),
            [leg(0, 8, Ends::Free, None, None)]
        );
        assert_eq!(
            plan(&samples(9, &[], 1.0), &[0..9], true),
            [Stretch::Rest(0)]
        );
    }

    #[test]
    fn a_gap_in_a_move_loses_it_and_nothing_else() {
        let rests = [0..20, 40..60, 80..100];
        let all = plan(&samples(100, &[30], 7.0), &rests, true);
        assert_eq!(
            all[1],
            Stretch::Lost {
                from: 19,
                to: 40,
                why: Loss::Gap { seconds: 7.0 }
            }
        );
        assert_eq!(all[3], leg(59, 80, Ends::RestToRest, Some(1), Some(2)));
        let unstamped = plan(&samples(100, &[30], 1.0), &rests, true);
        let Stretch::Lost { why, .. } = unstamped[1] else {
            panic!("{unstamped:?}");
        };
        let reason = Move::lost(0.2, 0.4, why).reason.unwrap();
        assert!(
            reason.starts_with("the recording is interrupted in it:"),
            "{reason}"
        );
    }

    #[test]
    fn a_gap_at_rest_loses_nothing_while_the_pose_stays() {
        let mut s = samples(40, &[20], 5.0);
        assert_eq!(
            plan(&s, &[0..20, 20..40], true)[1],
            Stretch::QuietGap { gap_s: 5.0 }
        );
        // Where no stamp tells how long it is, too.
        assert_eq!(
            plan(&samples(40, &[20], 1.0), &[0..20, 20..40], true)[1],
            Stretch::QuietGap { gap_s: 0.0 }
        );
        s.force_mps2[0][20..].fill(1.0);
        assert_eq!(
            plan(&s, &[0..20, 20..40], true)[1],
            Stretch::Lost {
                from: 19,
                to: 20,
                why: Loss::Gap { seconds: 5.0 }
            }
        );
    }
}

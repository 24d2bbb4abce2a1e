//! Rests of both directions become one list.

use std::ops::Range;

use super::run::Run;
use super::view::View;

/// What one direction saw of a motion, as samples; empty where the rest was
/// certain again at once.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Moving {
    from: usize,
    to: usize,
}

/// The rests of a piece: what is left when the motions are taken out that either
/// direction saw.
///
/// A run forwards knows to the sample where a rest ends, and only to a part of a
/// block where it begins; a run backwards the other way round. So a motion is
/// from the end forwards to the beginning backwards. A slow one may be noticed in
/// one direction only; what was no motion is joined again later.
pub(super) fn join(
    forwards: (&View<'_>, &[Run]),
    backwards: (&View<'_>, &[Run]),
) -> Vec<Range<usize>> {
    let whole = forwards.0.range(0..forwards.0.len());
    let ahead = moving(forwards, &whole);
    let back = moving(backwards, &whole);
    let mut motions = seen(&ahead, &back);
    motions.sort_by_key(|m| (m.from, m.to));
    let mut rests = Vec::new();
    let mut at = whole.start;
    for motion in motions {
        if motion.from > at {
            rests.push(at..motion.from);
        }
        at = at.max(motion.to);
    }
    if at < whole.end {
        rests.push(at..whole.end);
    }
    rests
}

/// What no run of one direction covers, in order.
fn moving(of: (&View<'_>, &[Run]), whole: &Range<usize>) -> Vec<Moving> {
    let (view, runs) = of;
    let mut rests: Vec<Range<usize>> = runs.iter().map(|r| view.range(r.seed..r.end)).collect();
    rests.sort_by_key(|r| r.start);
    let mut out = Vec::new();
    let mut at = whole.start;
    for (k, rest) in rests.iter().enumerate() {
        // Also where two rests touch: there was an alarm between them.
        if k > 0 || rest.start > at {
            out.push(Moving {
                from: at,
                to: rest.start.max(at),
            });
        }
        at = rest.end;
    }
    if at < whole.end {
        out.push(Moving {
            from: at,
            to: whole.end,
        });
    }
    out
}

fn seen(ahead: &[Moving], back: &[Moving]) -> Vec<Moving> {
    let mut out = Vec::new();
    let mut taken = vec![false; back.len()];
    let mut alone = Vec::new();
    let mut first = 0;
    for (i, f) in ahead.iter().enumerate() {
        while back.get(first).is_some_and(|b| b.to < f.from) {
            first += 1;
        }
        let mut met = false;
        for (j, b) in back.iter().enumerate().skip(first) {
            if b.from > f.to {
                break;
            }
            // The next motion forwards may go on in the same one backwards.
            let last = ahead.get(i + 1).is_none_or(|next| next.from > b.to);
            out.push(Moving {
                from: if met { b.from } else { f.from },
                to: if last { b.to } else { f.to },
            });
            taken[j] = true;
            met = true;
        }
        if !met {
            alone.push(*f);
        }
    }
    out.extend(alone);
    out.extend(
        back.iter()
            .zip(&taken)
            .filter(|(_, taken)| !**taken)
            .map(|(b, _)| *b),
    );
    out
}

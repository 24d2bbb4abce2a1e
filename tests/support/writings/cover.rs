//! Writings in which every two choices meet.

use std::collections::BTreeSet;

use super::{LEVELS, Writing};

/// Two choices: (list, place in it) each.
pub type Pair = [(usize, usize); 2];

/// Few writings that have every pair of choices between them that a possible writing has.
///
/// Greedy: each writing is the best of some dozens, drawn around a pair that is still
/// missing (D. M. Cohen et al., IEEE Trans. Software Eng. 23 (1997) 437).
pub fn pairs(candidates: usize, mut draw: impl FnMut(usize) -> usize) -> Vec<Writing> {
    let mut missing: BTreeSet<Pair> = BTreeSet::new();
    for a in 0..LEVELS.len() {
        for b in a + 1..LEVELS.len() {
            for i in 0..LEVELS[a] {
                missing.extend((0..LEVELS[b]).map(|j| [(a, i), (b, j)]));
            }
        }
    }
    let mut chosen = Vec::new();
    while let Some(&wanted) = missing.iter().next() {
        let mut best: Option<(usize, Writing)> = None;
        for _ in 0..candidates {
            let mut levels: Vec<usize> = LEVELS.iter().map(|n| draw(*n)).collect();
            for (choice, level) in wanted {
                levels[choice] = level;
            }
            let writing = Writing::of(&levels).possible();
            let has = pairs_of(&writing);
            if !has.contains(&wanted) {
                continue;
            }
            let new = has.iter().filter(|p| missing.contains(*p)).count();
            if best.as_ref().is_none_or(|(most, _)| new > *most) {
                best = Some((new, writing));
            }
        }
        match best {
            Some((_, writing)) => {
                for pair in pairs_of(&writing) {
                    missing.remove(&pair);
                }
                chosen.push(writing);
            }
            None => {
                missing.remove(&wanted);
            }
        }
    }
    chosen
}

fn pairs_of(writing: &Writing) -> Vec<Pair> {
    let levels = writing.levels();
    let mut out = Vec::new();
    for a in 0..levels.len() {
        for b in a + 1..levels.len() {
            out.push([(a, levels[a]), (b, levels[b])]);
        }
    }
    out
}

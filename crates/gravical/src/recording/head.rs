//! The first rows of a recording, from which its facts are determined.

use crate::Result;

use super::monitor::{Facts, RecordingClaims};
use super::row::{SLOTS, Values};
use super::rows::{Item, Rows, Source};

/// Largest number of passes over the head.
const MOST_PASSES: u32 = 3;

/// Usual number of lines of a head.
const USUAL_LINES: usize = 1 << 13;

/// The first lines of a recording.
#[derive(Debug, Clone)]
pub(crate) struct Head {
    claims: RecordingClaims,
    lines: Vec<(u64, Item, Values)>,
}

impl Head {
    /// Reads all lines of `source`, up to an error.
    pub fn read(mut source: impl Source, claims: &RecordingClaims) -> Self {
        let mut lines = Vec::with_capacity(USUAL_LINES);
        let mut values = [f64::NAN; SLOTS];
        while let Ok(Some(item)) = source.next(&mut values) {
            lines.push((source.number(), item, values));
        }
        Head {
            claims: claims.clone(),
            lines,
        }
    }

    /// Facts of the recording.
    pub fn facts(&self) -> Facts {
        determine_facts(|facts| self.rows(facts))
    }

    fn rows(&self, facts: Facts) -> Rows<HeadRows<'_>> {
        let source = HeadRows {
            lines: &self.lines,
            next: 0,
        };
        Rows::new(source, self.claims.clone(), facts)
    }
}

/// Facts of `rows`, determined repeatedly until they agree with those assumed. Errors of reading
/// end the rows.
pub(super) fn determine_facts<S: Source>(rows: impl Fn(Facts) -> Rows<S>) -> Facts {
    let mut facts = Facts::none();
    let mut passes = 0;
    // How to read stamps depends on the steps, and even spacing on how they are read.
    loop {
        let mut rows = rows(facts);
        while let Ok(Some(_)) = rows.next_row() {}
        let found = rows.monitor().finish().facts;
        passes += 1;
        if found.agrees(&facts) || passes == MOST_PASSES {
            return Facts {
                resolution: rows.monitor().resolution(),
                ..found
            };
        }
        facts = found;
    }
}

/// Source that repeats the stored lines.
struct HeadRows<'a> {
    lines: &'a [(u64, Item, Values)],
    next: usize,
}

impl Source for HeadRows<'_> {
    fn next(&mut self, values: &mut Values) -> Result<Option<Item>> {
        let Some((_, item, kept)) = self.lines.get(self.next) else {
            return Ok(None);
        };
        self.next += 1;
        *values = *kept;
        Ok(Some(*item))
    }

    fn number(&self) -> u64 {
        let last = self.next.checked_sub(1);
        last.and_then(|at| self.lines.get(at)).map_or(0, |l| l.0)
    }
}

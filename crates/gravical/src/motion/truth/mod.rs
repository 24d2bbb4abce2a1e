//! Motion against a reference: a track of the same motion that somebody else
//! measured, with a camera or on a rail.
//!
//! Both tracks start at 0 at their first common time. The reference is brought
//! onto the recording's clock by an offset (`offset`) and into the frame of the
//! result by a turn about the vertical; then errors stand beside the uncertainties
//! of their axes (`compare`).
//!
//! What is fitted is not judged any more: the offset hides a delay, the yaw the heading.

mod columns;
mod compare;
mod line;
mod offset;
mod read;
#[cfg(test)]
mod tests;

use super::{Motion, MotionResult, ReferenceTrack, Track};
use crate::Result;

pub use read::{Reference, read_reference};

/// Compares `motion` with `reference`: its result gets the comparison and what
/// is odd about it, and it the reference.
///
/// # Errors
///
/// `truth-overlap` (input) when the two have no time in common.
pub fn add_comparison(motion: &mut Motion, reference: &Reference) -> Result<()> {
    let track = motion.track();
    motion.reference = Some(add_to(&mut motion.result, &track, reference)?);
    Ok(())
}

fn add_to(
    result: &mut MotionResult,
    track: &Track,
    reference: &Reference,
) -> Result<ReferenceTrack> {
    let mut findings = reference.findings.clone();
    let (comparison, turned) = compare::compare(result, track, reference, &mut findings)?;
    for finding in &mut findings {
        finding.file.get_or_insert_with(|| reference.source.clone());
    }
    result.findings.extend(findings);
    result.truth = Some(comparison);
    Ok(turned)
}

//! Stills of a recording ([`crate::still`]), and what is taken where there are none.

use std::ops::Range;

use crate::recording::{Finding, FindingKind, Recording};
use crate::still::{self, Channels, moments};

pub use crate::still::{StillOptions, Stills, block_rows};

/// Finds the stills.
#[must_use]
pub fn find_stills(recording: &Recording, options: &StillOptions) -> Stills {
    let channels = Channels {
        accel: &recording.accel,
        gyro: recording.gyro.as_ref(),
        rate_hz: recording.working_rate_hz().0,
        segments: recording.segments(),
        resolution: recording.resolution,
    };
    still::find_stills(&channels, options)
}

/// What shakes by more than this share of gravity, rms, is no rest, however even
/// it is: a hand trembles by a hundredth, a running engine by less than a tenth.
pub(crate) const MOST_SHAKE: f64 = 0.1;
/// Calm parts of less than this share of a recording are scraps of motion.
const LEAST_CALM: f64 = 0.1;

/// The stills that do not shake.
pub(crate) fn find_calm(recording: &Recording, options: &StillOptions) -> Vec<Range<usize>> {
    let mut spans = find_stills(recording, options).spans;
    spans.retain(|rows| shake(recording, rows) < MOST_SHAKE);
    spans
}

/// The calmest parts of a recording without a still, each with a finding; none where
/// it moves throughout.
pub(crate) fn find_calmest(
    recording: &Recording,
    findings: &mut Vec<Finding>,
) -> Vec<Range<usize>> {
    let spans = find_calm(recording, &StillOptions::unsteady());
    let held: usize = spans.iter().map(|s| recording.length(s)).sum();
    if (held as f64) < LEAST_CALM * recording.rows_in_file() as f64 {
        return Vec::new();
    }
    let told = spans.iter().map(|rows| unsteady(recording, rows, "", ""));
    findings.extend(told);
    spans
}

/// Says that `rows` were taken although they shake: `of_what`, and how much less others do.
pub(super) fn unsteady(
    recording: &Recording,
    rows: &Range<usize>,
    of_what: &str,
    others: &str,
) -> Finding {
    let text = format!(
        "{of_what}never quite at rest; the quietest part, lines {} to {}, moves by {:.0} mg rms{others} and is used",
        recording.line(rows.start),
        recording.line(rows.end - 1),
        1000.0 * shake(recording, rows)
    );
    Finding::new(FindingKind::UnsteadyPose, text).in_file(&recording.name)
}

/// Standard deviation of the rows, the three axes together, over their mean
/// magnitude.
fn shake(recording: &Recording, rows: &Range<usize>) -> f64 {
    let (mean, variance) = moments(&recording.accel, rows.clone());
    variance.sqrt() / gravical_core::matrix3::norm(&mean)
}

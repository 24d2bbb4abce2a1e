//! Placements held against names, against each other and against the turns.

use std::ops::Range;

use crate::recording::resolution::floors;
use crate::recording::units::GyroScale;
use crate::recording::{Finding, Origin, Recording};

use super::face::{self, Claim, Face, angle_deg};
use super::{Placement, SegmentOptions, Turn, still, turns};

/// A turn by a known angle tells the unit of the gyroscope, whatever the header
/// says; a unit that was given or that turns of gravity have shown stays.
pub(super) fn settle_gyro_unit(
    recording: &Recording,
    turn: &Turn,
    placements: &[Placement],
    options: &SegmentOptions,
    scale: &mut Option<GyroScale>,
    findings: &mut Vec<Finding>,
) {
    let Some(claimed) = *scale else { return };
    let settled =
        matches!(claimed.origin, Origin::Given | Origin::Data) && claimed.nominal().is_some();
    if settled {
        return;
    }
    let shown = plain_integral(recording, &turn.rows, placements).and_then(|integral| {
        turns::unit_by_known_turn(integral, options.turn_angle_deg.to_radians())
    });
    match shown {
        Some(shown) => {
            if claimed.origin == Origin::Header && claimed.unit != shown.unit {
                findings.push(
                    Finding::warning(
                        "unit-mismatch",
                        format!(
                            "the header says {} for the gyroscope, but a turn by {}° comes out right in {}; taken so",
                            claimed.unit.name(),
                            options.turn_angle_deg,
                            shown.unit.name()
                        ),
                    )
                    .in_file(&recording.name),
                );
            }
            *scale = Some(shown);
        }
        None => findings.push(
            Finding::note(
                "gyro-unit-unverified",
                format!(
                    "the gyroscope is taken as {}; a turn by {}° comes out right in no unit",
                    claimed.unit.name(),
                    options.turn_angle_deg
                ),
            )
            .in_file(&recording.name),
        ),
    }
}

/// Holds that shake many times as much as the usual one of the session.
pub(super) fn check_steadiness(
    placements: &[Placement],
    recordings: &[Recording],
    findings: &mut Vec<Finding>,
) {
    let shake = |p: &Placement| -> f64 {
        let rows = p.rows.iter().map(|r| r.len()).sum::<usize>().max(1) as f64;
        let sum: f64 = p
            .rows
            .iter()
            .map(|r| r.len() as f64 * still::moments(&recordings[p.recording].accel, r.clone()).1)
            .filter(|v| v.is_finite())
            .sum();
        // Rounding shakes that much, whether it shows or not.
        (sum / rows)
            .max(floors(&recordings[p.recording].accel_resolution()))
            .sqrt()
    };
    let all: Vec<f64> = placements.iter().map(shake).collect();
    let Some(usual) = crate::stats::median(&mut all.clone()) else {
        return;
    };
    for (placement, own) in placements.iter().zip(&all) {
        if *own > UNSTEADY * usual && usual > 0.0 {
            findings.push(
                Finding::warning(
                    "unsteady-hold",
                    format!(
                        "{}: shakes {:.0} times as much as the usual placement of this session; was it moving?",
                        placement.label,
                        own / usual
                    ),
                )
                .in_file(&placement.source),
            );
        }
    }
}

/// Holds that shake so many times as much as the median one are worth a word.
const UNSTEADY: f64 = 6.0;

/// Holds names against data. The data win, with a warning, unless the user
/// believes the names.
pub(super) fn check_names(
    placements: &mut [Placement],
    options: &SegmentOptions,
    findings: &mut Vec<Finding>,
) {
    for placement in placements {
        let Some(Claim::Face(claimed)) = placement.claim else {
            if let (Some(Claim::Axis(axis)), Some(face)) = (placement.claim, placement.face)
                && axis != face.axis
            {
                findings.push(mismatch(
                    placement,
                    &format!("the {} axis", face::AXES[axis]),
                    face,
                ));
            }
            continue;
        };
        if options.faces_by_name {
            let reading = options.axes.to_case(placement.mean);
            placement.angle_deg = angle_deg(reading, claimed.direction());
            placement.face = Some(claimed);
        } else if let Some(face) = placement.face
            && face != claimed
        {
            findings.push(mismatch(placement, &claimed.name(), face));
        }
    }
}

/// `--rows` beyond what there is.
pub(super) fn check_rows(
    placements: &[Placement],
    options: &SegmentOptions,
    findings: &mut Vec<Finding>,
) {
    let Some(wanted) = options.rows else { return };
    for placement in placements {
        let there: usize = placement.rows.iter().map(|r| r.len()).sum();
        if there < wanted {
            findings.push(
                Finding::warning(
                    "few-rows",
                    format!(
                        "{}: {there} rows in place of the {wanted} that were asked for",
                        placement.label
                    ),
                )
                .in_file(&placement.source),
            );
        }
    }
}

fn mismatch(placement: &Placement, claimed: &str, face: Face) -> Finding {
    Finding::warning(
        "orientation-mismatch",
        format!(
            "\"{}\" claims {claimed}, but {} points up there; the data are believed",
            placement.label,
            face.name()
        ),
    )
    .in_file(&placement.source)
}

fn plain_integral(
    recording: &Recording,
    rows: &Range<usize>,
    placements: &[Placement],
) -> Option<[f64; 3]> {
    let gyro = recording.gyro.as_ref()?;
    let (mut sum, mut count) = ([0.0; 3], 0);
    for (s, n) in placements.iter().filter_map(|p| p.gyro_sum) {
        count += n;
        (0..3).for_each(|i| sum[i] += s[i]);
    }
    let bias = sum.map(|s| s / count.max(1) as f64);
    let mut integral = [0.0; 3];
    for row in rows.clone() {
        let period = turns::sample_period_s(recording, row)?;
        (0..3).for_each(|i| integral[i] += (gyro[i][row] - bias[i]) * period);
    }
    Some(integral)
}

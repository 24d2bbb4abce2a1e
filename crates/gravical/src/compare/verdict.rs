//! The judgement of a comparison and its reasons.

use super::PART_SIGNIFICANCE;
use super::findings::Independence;
use super::types::{Agreement, CompareVerdict, MagnitudeDifference, OrientationDifference};
use crate::uncertainty::ChiSquare;

/// Both parts together; `known`: the orientation of both frames in the case is known.
pub(super) fn verdict(
    magnitude: &MagnitudeDifference,
    orientation: Option<&OrientationDifference>,
    independence: Independence,
    known: bool,
) -> CompareVerdict {
    // Mirror images differ, whatever their uncertainty.
    let second = orientation.map_or(Agreement::Differ, |o| o.judgement);
    let both = [magnitude.judgement, second];
    let judgement = if both.contains(&Agreement::Differ) {
        Agreement::Differ
    } else if magnitude.judgement == Agreement::Undecided {
        Agreement::Undecided
    } else {
        // The rotation may be a convention; ‖a‖ does not depend on it.
        Agreement::Agree
    };
    let why = match independence {
        Independence::Same => "both files contain the same parameters",
        Independence::SharedRecordings => "both were made from the same recordings",
        Independence::Independent => "one of the files has no uncertainty",
    };
    let mut reasons = vec![part(
        ["bias, scale and misalignment", "agree", "differ"],
        magnitude.judgement,
        magnitude.test,
        why,
    )];
    if let Some(test) = magnitude.test_at_one_gravity {
        reasons.push(format!(
            "with one value of gravity for both calibrations: {} ({})",
            ChiSquare::probability(test.p_value),
            test.statistic()
        ));
    }
    reasons.push(match orientation {
        Some(o) => part(
            [
                "the orientation of the axes in the case",
                "agrees",
                "differs",
            ],
            o.judgement,
            o.test,
            if known {
                why
            } else {
                "one of the sessions has faces on less than two axes"
            },
        ),
        None => {
            "the orientation of the axes differs: one is the mirror image of the other".to_owned()
        }
    });
    CompareVerdict { judgement, reasons }
}

/// One part in a sentence; `words`: what is compared, and its two verbs.
fn part(words: [&str; 3], judgement: Agreement, test: Option<ChiSquare>, why: &str) -> String {
    let [what, agrees, differs] = words;
    let numbers = |limit: &str| {
        test.map_or(String::new(), |t| {
            let p = ChiSquare::probability(t.p_value);
            format!(": {p}, {limit} {PART_SIGNIFICANCE} ({})", t.statistic())
        })
    };
    match judgement {
        Agreement::Agree => {
            format!(
                "{what} {agrees} within the uncertainty{}",
                numbers("the limit is")
            )
        }
        Agreement::Differ => {
            format!(
                "{what} {differs} by more than the uncertainty{}",
                numbers("below")
            )
        }
        Agreement::Undecided => format!("{what}: cannot be decided, {why}"),
    }
}

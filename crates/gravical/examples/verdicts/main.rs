//! What verdicts are worth: simulated sessions whose truth is known, most of them
//! spoiled in one way, and how often each is called what. The tables of
//! `docs/accuracy.md` under "Verdicts".
//!
//! ```console
//! $ cargo run --release -p gravical --example verdicts -- 200
//! $ cargo run --release -p gravical --example verdicts -- 200 alarms
//! ```
//!
//! The number is that of sessions a line. `alarms` has two sessions of each part in
//! place of that: how often `compare` and `check` claim a difference where there is
//! none.

#[path = "../../../../tests/support/each.rs"]
mod each;
#[allow(dead_code, reason = "the tests have sessions of their own")]
mod session;

use gravical::calibration_file::Grade;
use gravical::check::{CheckOptions, check};
use gravical::compare::compare;

use each::each;
use session::{Disturbance, Judged, Plan, Session};

fn verdicts(count: usize) {
    println!(
        "| session | disturbed by | good | fair | not verifiable | poor | refused | good, but off by more than 5 mg | fair, but by more than 20 mg | largest error, mg | predicted (95 %), mg | undetected, mg |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |");
    for plan in Plan::ALL {
        for disturbance in Disturbance::ALL {
            let judged = each(count, |index| {
                let mut session = Session::of(plan, index as u64);
                session.judge(disturbance)
            });
            let of = |grade: Grade, more_mg: f64| {
                judged
                    .iter()
                    .flatten()
                    .filter(|j: &&Judged| j.grade == grade && j.worst_mg > more_mg)
                    .count()
            };
            let median = |key: fn(&Judged) -> f64| {
                let mut values: Vec<f64> = judged.iter().flatten().map(key).collect();
                values.sort_by(f64::total_cmp);
                values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
            };
            println!(
                "| {} | {} | {} | {} | {} | {} | {} | {} | {} | {:.1} | {:.1} | {:.1} |",
                plan.name(),
                disturbance.name(),
                of(Grade::Good, 0.0),
                of(Grade::Fair, 0.0),
                of(Grade::NotVerifiable, 0.0),
                of(Grade::Poor, 0.0),
                judged.iter().filter(|j| j.is_none()).count(),
                of(Grade::Good, 5.0),
                of(Grade::Fair, 20.0),
                median(|j| j.worst_mg),
                median(|j| j.predicted_mg),
                median(|j| j.undetected_mg),
            );
        }
    }
}

fn alarms(count: usize) {
    println!(
        "| session | `compare` differs | … in what changes ‖a‖ | … in the rotation | `check` does not fit |"
    );
    println!("| --- | --- | --- | --- | --- |");
    for plan in Plan::ALL {
        let pairs = each(count, |index| {
            let mut session = Session::of(plan, index as u64);
            let (first, _) = session.record(Disturbance::None);
            let (second, _) = session.record(Disturbance::None);
            let a = session::calibrated(&first)?;
            let b = session::calibrated(&second)?;
            let compared = compare(&a, &b, ["a.json", "b.json"]).ok()?;
            let checked = check(&a, "a.json", &second, &CheckOptions::default()).ok()?;
            let turned = compared.orientation.map(|o| o.judgement);
            Some([
                compared.verdict.judgement.is_change(),
                compared.magnitude.judgement.is_change(),
                turned.is_some_and(|judgement| judgement.is_change()),
                checked.verdict.judgement.is_change(),
            ])
        });
        let there: Vec<&[bool; 4]> = pairs.iter().flatten().collect();
        let share = |what: usize| {
            let claimed = there.iter().filter(|p| p[what]).count();
            format!("{:.1} %", 100.0 * claimed as f64 / there.len() as f64)
        };
        println!(
            "| {} | {} |",
            plan.name(),
            [0, 1, 2, 3].map(share).join(" | ")
        );
    }
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let count = words.first().and_then(|w| w.parse().ok()).unwrap_or(200);
    if words.get(1).is_some_and(|w| w == "alarms") {
        alarms(count);
    } else {
        verdicts(count);
    }
}

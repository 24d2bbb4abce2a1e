//! Numbers of many outcomes, and Markdown.

use crate::means::Scores;

use crate::runs::Outcome;

/// Thousandths of standard gravity in one m/s².
pub const MG: f64 = 1000.0 / 9.80665;

pub type Outcomes = Vec<Option<Outcome>>;

/// A Markdown table.
pub fn markdown(head: &[&str], rows: &[Vec<String>]) -> String {
    let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    let mut out = line(head.iter().map(|h| (*h).to_owned()).collect());
    out += &line(head.iter().map(|_| "---".to_owned()).collect());
    for row in rows {
        out += &line(row.clone());
    }
    out
}

/// Root mean square over the outcomes.
pub fn rms(outcomes: &Outcomes, of: impl Fn(&Outcome) -> f64) -> f64 {
    let n = outcomes.iter().flatten().count() as f64;
    let squares: f64 = outcomes.iter().flatten().map(|o| of(o).powi(2)).sum();
    (squares / n).sqrt()
}

/// Two digits that count, from 0.05 to 30.
fn digits(x: f64) -> String {
    if x >= 9.95 {
        format!("{x:.1}")
    } else {
        format!("{x:.2}")
    }
}

pub fn norm_mg(outcomes: &Outcomes) -> String {
    digits(rms(outcomes, |o| o.errors.norm_mps2) * MG)
}

pub fn direction_deg(outcomes: &Outcomes) -> String {
    digits(rms(outcomes, |o| o.errors.direction_rad).to_degrees())
}

/// ‖a‖ / bias / direction, mg / mg / degrees, and how many have no result.
pub fn errors(outcomes: &Outcomes) -> String {
    let missing = outcomes.iter().filter(|o| o.is_none()).count();
    let none = match missing {
        0 => String::new(),
        n => format!(" ({n} none)"),
    };
    format!(
        "{} / {} / {}{none}",
        norm_mg(outcomes),
        digits(rms(outcomes, |o| o.errors.bias_mps2) * MG),
        direction_deg(outcomes)
    )
}

/// Share of 95 % intervals that hold the truth: bias / scale / ‖a‖.
pub fn coverage(outcomes: &Outcomes) -> String {
    let share = |of: fn(&Scores) -> [(f64, f64); 3]| {
        let all: Vec<(f64, f64)> = outcomes
            .iter()
            .flatten()
            .filter_map(|o| o.scores.as_ref())
            .flat_map(of)
            .collect();
        let inside = all.iter().filter(|(z, k)| z.abs() <= *k).count();
        inside as f64 / all.len() as f64
    };
    format!(
        "{:.3} / {:.3} / {:.3}",
        share(|s| s.bias),
        share(|s| s.scale),
        share(|s| s.norm)
    )
}

/// Median and the 10th and 90th hundredth.
pub fn quantiles(mut values: Vec<f64>) -> [f64; 3] {
    values.sort_by(f64::total_cmp);
    let at = |q: f64| {
        let index = (q * values.len() as f64) as usize;
        values.get(index).copied().unwrap_or(f64::NAN)
    };
    [at(0.5), at(0.1), at(0.9)]
}

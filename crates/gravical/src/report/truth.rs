//! A comparison with a reference as text.

use crate::motion::truth::TruthAlign;
use crate::motion::{Comparison, MoveComparison};

use super::motion::{columns, decimals};
use super::text::{decimals_of, paragraph, short_name};

/// Moves that are listed one by one.
const LISTED: usize = 24;

pub(super) fn truth(c: &Comparison) -> String {
    let turned = match c.align {
        TruthAlign::None => "not turned".to_owned(),
        TruthAlign::Yaw => format!("turned by {:+.1}° about the vertical", c.rotation_deg[2]),
        TruthAlign::Rotation => {
            let [x, y, z] = c.rotation_deg;
            format!("turned by {:.1}°", (x * x + y * y + z * z).sqrt())
        }
    };
    let shifted = if c.time_offset_s == 0.0 {
        String::new()
    } else {
        format!(", its clock shifted by {:+.3} s", c.time_offset_s)
    };
    let mut out = String::from("\n");
    out.push_str(&paragraph(
        "",
        &format!(
            "Against {}: {} points from {:.2} to {:.2} s, {turned}{shifted}",
            short_name(&c.source),
            c.points,
            c.from_s,
            c.to_s
        ),
    ));
    let share = c.percent_of_path.map_or(String::new(), |p| {
        format!(
            " = {} % of its path of {} m",
            short(p, 2),
            short(c.path_m, 3)
        )
    });
    out.push_str(&paragraph(
        "  end error ",
        &format!(
            "{} m{share}; RMSE {} m",
            short(c.end_error_m, 2),
            short(c.rmse_m, 2)
        ),
    ));
    if c.moves.is_empty() {
        return out;
    }
    out.push_str(&format!(
        "\n  {:<21}{:>11}{:>11}{:>11}{:>10}\n",
        "errors of moves, m", "x", "y", "z", "RMSE"
    ));
    let shown = if c.moves.len() > LISTED {
        LISTED - 1
    } else {
        LISTED
    };
    for m in c.moves.iter().take(shown) {
        out.push_str(&one_move(m));
    }
    let rest = c.moves.len().saturating_sub(shown);
    if rest > 0 {
        out.push_str(&format!("  … and {rest} more; --json has all\n"));
    }
    out
}

fn one_move(m: &MoveComparison) -> String {
    let when = format!("{:.2}–{:.2} s", m.start_s, m.end_s);
    // The error itself is known better than its uncertainty tells.
    let largest = m
        .end_error_m
        .into_iter()
        .fold(0.0, |a: f64, v| a.max(v.abs()));
    let n = [decimals_of(largest, 2); 3];
    let mut out = format!(
        "  {when:<21}{}{:>9}\n",
        columns(m.end_error_m, n, ""),
        short(m.rmse_m, 2)
    );
    if let Some(s) = m.sigma_m {
        out.push_str(&format!(
            "  {:<21}{}\n",
            "",
            columns(s, decimals(Some(s), s), "± ")
        ));
    }
    out
}

fn short(value: f64, digits: i32) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    format!("{value:.*}", decimals_of(value, digits))
}

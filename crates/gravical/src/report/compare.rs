//! A comparison of two calibrations as text.

use gravical_core::unit::STANDARD_GRAVITY_MPS2;

use crate::compare::{Comparison, GyroscopeDifference, ParameterDifference, ParameterKind};

use super::text::{decimals_for, direction, findings_text, paragraph};

/// The whole report.
#[must_use]
pub fn comparison_text(c: &Comparison) -> String {
    let mut out = head(c);
    out.push_str(&parameters(&c.parameters));
    out.push_str(&norms(c));
    out.push_str(&orientation(c));
    if let Some(gyroscope) = &c.gyroscope {
        out.push_str(&gyroscopes(gyroscope));
    }
    if !c.findings.is_empty() {
        out.push_str("\nFindings\n");
        out.push_str(&findings_text(&c.findings, true));
    }
    out.push_str(&paragraph("\nVerdict: ", c.verdict.judgement.name()));
    for reason in &c.verdict.reasons {
        out.push_str(&paragraph("  - ", reason));
    }
    out
}

fn head(c: &Comparison) -> String {
    let mut out = String::new();
    for (i, letter) in ["A", "B"].into_iter().enumerate() {
        let temperature =
            c.temperature_c[i].map_or(String::new(), |t| format!(", {:.1} °C", t.mean));
        out.push_str(&paragraph(
            &format!("{letter}  "),
            &format!(
                "{}: g = {:.5} m/s²{temperature}",
                c.files[i], c.gravity_mps2[i]
            ),
        ));
    }
    out
}

fn parameters(list: &[ParameterDifference]) -> String {
    let mut out = format!(
        "\n  {:<16}{:>13}{:>13}{:>13}  {:<12}{:>8}\n",
        "", "A", "B", "B − A", "± 1σ", "z"
    );
    let mut kind = None;
    for p in list {
        if kind.is_some_and(|k| k != p.kind) {
            out.push('\n');
        }
        kind = Some(p.kind);
        // Three digits of what is judged, whether σ is known or not.
        let worth = p.sigma.filter(|s| *s > 0.0).unwrap_or(match p.kind {
            ParameterKind::Bias => 1e-3,
            _ => 1e-2,
        });
        let d = decimals_for(worth);
        let value = |v: Option<f64>| v.map_or(String::new(), |v| format!("{v:.d$}"));
        let unit = match p.unit.as_str() {
            "m/s^2" => "m/s²",
            "deg" => "°",
            other => other,
        };
        let row = format!(
            "  {:<16}{:>13}{:>13}{:>13}  {:<12}{:>8}",
            format!("{} {unit}", p.name.replace('_', " ")),
            value(p.a),
            value(p.b),
            format!("{:+.d$}", p.difference),
            p.sigma.map_or(String::new(), |s| format!("± {s:.d$}")),
            p.z.map_or(String::new(), |z| format!("{z:+.1}")),
        );
        out.push_str(row.trim_end());
        out.push('\n');
    }
    out
}

fn both(v: f64) -> String {
    format!(
        "{:.2} mm/s² ({:.2} mg)",
        1000.0 * v,
        1000.0 * v / STANDARD_GRAVITY_MPS2
    )
}

fn norms(c: &Comparison) -> String {
    let m = &c.magnitude;
    let predicted =
        |v: Option<f64>| v.map_or(String::new(), |v| format!(", {} predicted", both(v)));
    let mut out = String::from("\nLength of a at rest, B − A over all directions\n");
    out.push_str(&paragraph(
        "  RMS      ",
        &format!(
            "{}{}",
            both(m.norm_rms_mps2),
            predicted(m.predicted_rms_mps2)
        ),
    ));
    out.push_str(&paragraph(
        "  largest  ",
        &format!(
            "{}{}, at {}",
            both(m.norm_largest_mps2),
            predicted(m.predicted_at_largest_mps2),
            direction(m.largest_at)
        ),
    ));
    out
}

fn orientation(c: &Comparison) -> String {
    let Some(o) = &c.orientation else {
        return String::new();
    };
    let axis = o.axis.map(|v| format!("{v:+.2}")).join(", ");
    format!(
        "\nFrame of B against that of A: turned by {:.3}° about ({axis})\n",
        o.angle_deg
    )
}

fn gyroscopes(g: &GyroscopeDifference) -> String {
    let mut out = format!(
        "\n  {:<16}{:>13}{:>13}{:>13}  {}\n",
        "gyroscope", "A", "B", "B − A", "scale B/A"
    );
    for (i, axis) in ["x", "y", "z"].into_iter().enumerate() {
        let scale = g
            .scale_difference_percent
            .map_or(String::new(), |s| format!("{:+.3} %", s[i]));
        out.push_str(
            format!(
                "  {:<16}{:>13.4}{:>13.4}{:>13}  {scale}",
                format!("bias {axis} °/s"),
                g.bias_a_deg_s[i],
                g.bias_b_deg_s[i],
                format!("{:+.4}", g.bias_difference_deg_s[i])
            )
            .trim_end(),
        );
        out.push('\n');
    }
    out.push_str("  (shown, not judged: a gyroscope's bias moves with every start)\n");
    out
}

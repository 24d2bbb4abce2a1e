//! The gyroscope of a calibration as text.

use crate::calibration_file::GyroscopeSection;
use gravical_core::matrix3;

use super::text::{decimals_for, decimals_of, paragraph};

/// Parameters, and how well they fit.
pub(super) fn gyroscope(g: &GyroscopeSection) -> String {
    let unit = g.input_unit.name();
    if g.method == "bias" {
        return bias_only(g, unit);
    }
    let mut out = format!("\nGyroscope: raw = K R ω + b + S a, raw in {unit}\n");
    let sd = deviations(g);
    out.push_str(&format!(
        "\n  {:<4}{:>11} {:<10}{:>12} {:<10}  {}\n",
        "axis",
        "bias b",
        if sd.is_some() { "  ± 1σ" } else { "" },
        "K per rad/s",
        if sd.is_some() { "  ± 1σ" } else { "" },
        "R"
    ));
    for (i, axis) in ["x", "y", "z"].iter().enumerate() {
        let r: String = g.orientation[i]
            .iter()
            .map(|v| format!("{v:>9.5}"))
            .collect();
        let (bias, bias_sd) = with_deviation(g.bias[i], g.scale[i], sd.map(|(b, _)| b[i]));
        let (scale, scale_sd) = with_deviation(g.scale[i], g.scale[i], sd.map(|(_, k)| k[i]));
        out.push_str(&format!(
            "  {axis:<4}{bias:>11} {bias_sd:<10}{scale:>12} {scale_sd:<10}{r}\n"
        ));
    }
    if let (Some(residual), Some(motions)) = (g.residual_deg, g.motions) {
        let left_out = g.leave_one_out_deg.map_or_else(
            || "too few motions to leave one out".to_owned(),
            |d| format!("{d:.3}° when the motion takes no part"),
        );
        out.push('\n');
        out.push_str(&paragraph(
            "  ",
            &format!(
                "from {} motions between stills; turned by it, gravity is off by {residual:.3}° rms after a motion ({left_out}); its axes are those of the calibrated accelerometer",
                motions.used
            ),
        ));
    }
    out
}

fn bias_only(g: &GyroscopeSection, unit: &str) -> String {
    let sd = g.covariance.as_ref().and_then(|c| {
        let at = |i: usize| Some(c.values.get(i)?.get(i)?.sqrt());
        Some([at(0)?, at(1)?, at(2)?])
    });
    let biases: Vec<String> = (0..3)
        .map(|i| {
            let (bias, sd) = with_deviation(g.bias[i], g.scale[i], sd.map(|s| s[i]));
            format!("{bias} {sd}").trim_end().to_owned()
        })
        .collect();
    let text = format!(
        "bias {} {unit}; scale nominal, no turn shows it",
        biases.join(", ")
    );
    format!("\n{}", paragraph("Gyroscope: ", &text))
}

/// A value and its standard deviation with the digits that this leaves it.
fn with_deviation(value: f64, scale: f64, sd: Option<f64>) -> (String, String) {
    match sd {
        Some(sd) if sd > 0.0 && sd.is_finite() => {
            let d = decimals_for(sd);
            (format!("{value:.d$}"), format!("± {sd:.d$}"))
        }
        _ => {
            let d = decimals_of(scale, 6);
            (format!("{value:.d$}"), String::new())
        }
    }
}

/// Of bias and scale, by the covariance of M and b: the scale is the length of
/// a row of M.
pub(super) fn deviations(g: &GyroscopeSection) -> Option<([f64; 3], [f64; 3])> {
    let c = &g.covariance.as_ref()?.values;
    let at = |i: usize, j: usize| c.get(i).and_then(|row| row.get(j)).copied();
    let mut bias = [0.0; 3];
    let mut scale = [0.0; 3];
    for i in 0..3 {
        bias[i] = at(9 + i, 9 + i)?.sqrt();
        let row = g.orientation[i];
        let mut block = [[0.0; 3]; 3];
        for j in 0..3 {
            for k in 0..3 {
                block[j][k] = at(3 * i + j, 3 * i + k)?;
            }
        }
        scale[i] = matrix3::dot(&row, &matrix3::mul_vec(&block, &row)).sqrt();
    }
    Some((bias, scale))
}

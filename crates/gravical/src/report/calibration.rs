//! A calibration as text: parameters, errors, placements, findings, verdict.

use crate::calibration_file::{CalibrationFile, GravitySource, Position, PositionKind, TiltSource};

use super::text::{decimals_for, decimals_of, findings_text, paragraph, short_name};

/// The whole report.
#[must_use]
pub fn calibration_text(file: &CalibrationFile) -> String {
    let mut out = head(file);
    out.push_str(&parameters(file));
    out.push_str(&gyroscope(file));
    out.push_str(&placements(file));
    if !file.findings.is_empty() {
        out.push_str("\nFindings\n");
        out.push_str(&findings_text(&file.findings, file.inputs.len() > 1));
    }
    out.push_str(&verdict(file));
    out
}

fn head(file: &CalibrationFile) -> String {
    let a = &file.accelerometer;
    let faces = a
        .positions
        .iter()
        .filter(|p| p.kind == PositionKind::Face)
        .count();
    let inputs = match &file.inputs[..] {
        [one] => short_name(&one.path),
        several => format!("{} files", several.len()),
    };
    let gravity = match file.gravity_source {
        GravitySource::Given => "given",
        GravitySource::Latitude => "from latitude",
        GravitySource::Standard => "assumed",
    };
    let tilt = a.placement_tilt_deg.map_or(String::new(), |t| {
        let how = match t.source {
            TiltSource::Given => "given",
            TiltSource::Estimated => "estimated",
            TiltSource::Assumed => "assumed",
        };
        format!(", placement tilt {:.1}° ({how})", t.value)
    });
    let oblique = a.positions.len() - faces;
    let oblique = match oblique {
        0 => String::new(),
        1 => " and 1 oblique pose".to_owned(),
        n => format!(" and {n} oblique poses"),
    };
    format!(
        "{} of {inputs}: {faces} placements on six faces{oblique}\nraw in {}, g = {} m/s² ({gravity}){tilt}\n",
        method_name(&a.method),
        a.input_unit.name(),
        match file.gravity_source {
            GravitySource::Latitude => format!("{:.5}", file.gravity_mps2),
            GravitySource::Given | GravitySource::Standard => file.gravity_mps2.to_string(),
        },
    )
}

fn method_name(method: &str) -> String {
    match method {
        "ferraris" => "Ferraris calibration".to_owned(),
        other => format!("Calibration ({other})"),
    }
}

/// Standard deviations of bias and scale, by the covariance of M and b: the
/// scale is the length of a row of M.
fn deviations(file: &CalibrationFile) -> Option<([f64; 3], [f64; 3])> {
    let c = &file.accelerometer.covariance.as_ref()?.values;
    let r = &file.accelerometer.orientation;
    let at = |i: usize, j: usize| c.get(i).and_then(|row| row.get(j)).copied();
    let mut bias = [0.0; 3];
    let mut scale = [0.0; 3];
    for i in 0..3 {
        bias[i] = at(9 + i, 9 + i)?.sqrt();
        let mut variance = 0.0;
        for j in 0..3 {
            for k in 0..3 {
                variance += r[i][j] * r[i][k] * at(3 * i + j, 3 * i + k)?;
            }
        }
        scale[i] = variance.sqrt();
    }
    Some((bias, scale))
}

fn parameters(file: &CalibrationFile) -> String {
    let a = &file.accelerometer;
    let axes = ["x", "y", "z"];
    let sd = deviations(file);
    let mut out = format!(
        "\nAccelerometer: raw = K R a + b; calibrated = matrix · (raw − b)\n\n  {:<5}{:>13} {:<9}{:>13} {:<9}{:>10}\n",
        "axis", "bias b", "  ± 1σ", "scale K", "  ± 1σ", "deviation"
    );
    for i in 0..3 {
        let (bias_sd, scale_sd) = sd.map_or((f64::NAN, f64::NAN), |(b, k)| (b[i], k[i]));
        let bias_decimals = if sd.is_some() {
            decimals_for(bias_sd)
        } else {
            decimals_of(a.scale[i], 6)
        };
        let scale_decimals = if sd.is_some() {
            decimals_for(scale_sd)
        } else {
            decimals_of(a.scale[i], 7)
        };
        let plus_minus = |v: f64, d: usize| {
            if v.is_nan() {
                String::new()
            } else {
                format!("± {v:.d$}")
            }
        };
        let deviation = a
            .scale_deviation_percent
            .map_or_else(|| "unknown".to_owned(), |d| format!("{:+.2} %", d[i]));
        out.push_str(&format!(
            "  {:<5}{:>13} {:<9}{:>13} {:<9}{:>10}\n",
            axes[i],
            format!("{:.bias_decimals$}", a.bias[i]),
            plus_minus(bias_sd, bias_decimals),
            format!("{:.scale_decimals$}", a.scale[i]),
            plus_minus(scale_sd, scale_decimals),
            deviation
        ));
    }
    out.push_str(&format!(
        "\n  {:<34}{}\n",
        "R (rows of length one)", "matrix = R⁻¹ K⁻¹"
    ));
    let decimals = decimals_of(a.matrix[0][0], 6);
    for (r, m) in a.orientation.iter().zip(&a.matrix) {
        let row = |values: &[f64; 3], width: usize, d: usize| -> String {
            values.iter().map(|v| format!("{v:>width$.d$}")).collect()
        };
        let small = if decimals >= 6 && m.iter().all(|v| v.abs() < 0.1) {
            m.iter().map(|v| format!("{v:>14.6e}")).collect()
        } else {
            row(m, 11, decimals)
        };
        out.push_str(&format!("  {:<32}{small}\n", row(r, 10, 5)));
    }
    out
}

fn gyroscope(file: &CalibrationFile) -> String {
    let Some(g) = &file.gyroscope else {
        return String::new();
    };
    let mut out = format!(
        "\nGyroscope: raw = K R ω + b + S a, raw in {}\n\n  {:<5}{:>13}{:>15}   {:<30}\n",
        g.input_unit.name(),
        "axis",
        "bias b",
        "K per rad/s",
        "R"
    );
    for (i, axis) in ["x", "y", "z"].iter().enumerate() {
        let r: String = g.orientation[i]
            .iter()
            .map(|v| format!("{v:>10.5}"))
            .collect();
        out.push_str(&format!(
            "  {axis:<5}{:>13.5}{:>15.5}   {r}\n",
            g.bias[i], g.scale[i]
        ));
    }
    out
}

fn placements(file: &CalibrationFile) -> String {
    let a = &file.accelerometer;
    let mut out = String::new();
    if let Some(errors) = a.errors {
        out.push_str(&format!(
            "\nErrors over fitted faces, m/s²: RMS {:.5}, maximum {:.5}, mean norm {:.5}\n",
            errors.rms, errors.max, errors.mean_norm
        ));
    }
    if a.positions.is_empty() {
        return out;
    }
    out.push_str(&format!(
        "\n  {:<9}{:^27}  {:^24}{:>8}{:>10}\n",
        "position", "raw mean", "calibrated, m/s²", "|error|", "raw tilt"
    ));
    let largest = a
        .positions
        .iter()
        .flat_map(|p| p.raw)
        .fold(0.0_f64, |m, v| m.max(v.abs()));
    let decimals = decimals_of(largest, 5).min(4);
    for position in &a.positions {
        out.push_str(&placement(position, decimals));
    }
    out
}

fn placement(p: &Position, decimals: usize) -> String {
    let raw: String = p.raw.iter().map(|v| format!("{v:>9.decimals$}")).collect();
    let calibrated: String = p.calibrated.iter().map(|v| format!("{v:>8.3}")).collect();
    let tilt = p
        .tilt_deg
        .map_or_else(|| "–".to_owned(), |t| format!("{t:.1}°"));
    let label: String = p.label.chars().take(9).collect();
    format!(
        "  {label:<9}{raw}  {calibrated}{:>8.4}{tilt:>9}\n",
        p.error_norm
    )
}

fn verdict(file: &CalibrationFile) -> String {
    let mut out = format!("\nVerdict: {}\n", file.verdict.grade.name());
    for reason in &file.verdict.reasons {
        out.push_str(&paragraph("  - ", reason));
    }
    out
}

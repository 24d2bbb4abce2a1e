//! A calibration as text: parameters, errors, placements, findings, verdict.

use gravical_core::unit::STANDARD_GRAVITY_MPS2;

use crate::calibration_file::{
    CalibrationFile, GravitySource, InputFile, Position, PositionKind, TiltSource,
};

use super::gyroscope::gyroscope;
use super::temperature::{model_text, soak_text};
use super::text::{decimals_for, decimals_of, findings_text, paragraph, short_name};

/// The whole report.
#[must_use]
pub fn calibration_text(file: &CalibrationFile) -> String {
    if file.accelerometer.method == "thermal" {
        return soak_text(file) + &verdict(file);
    }
    let mut out = head(file);
    out.push_str(&parameters(file));
    out.push_str(&file.gyroscope.as_ref().map_or_else(String::new, gyroscope));
    out.push_str(&placements(file));
    out.push_str(&uncertainty(file));
    out.push_str(&model_text(file));
    if !file.findings.is_empty() {
        out.push_str("\nFindings\n");
        out.push_str(&findings_text(&file.findings, file.inputs.len() > 1));
    }
    out.push_str(&verdict(file));
    out
}

/// What was calibrated, and on what it rests: two lines.
pub(super) fn head(file: &CalibrationFile) -> String {
    let a = &file.accelerometer;
    let faces = a
        .positions
        .iter()
        .filter(|p| p.kind == PositionKind::Face)
        .count();
    let recordings: Vec<&InputFile> = file.recordings().collect();
    let inputs = match &recordings[..] {
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
    let mut different: Vec<&str> = a
        .positions
        .iter()
        .filter(|p| p.kind == PositionKind::Face)
        .map(|p| p.label.as_str())
        .collect();
    different.sort_unstable();
    different.dedup();
    let on = match different.len() {
        6 => "six faces".to_owned(),
        n => format!("{n} of six faces"),
    };
    let oblique = match a.positions.len() - faces {
        0 => String::new(),
        1 => " and 1 free pose".to_owned(),
        n => format!(" and {n} free poses"),
    };
    let placed = match faces {
        0 => format!("{} free poses", a.positions.len()),
        n => format!("{n} placements on {on}{oblique}"),
    };
    let what = format!("{} of {inputs}: {placed}", method_name(&a.method));
    let how = format!(
        "raw in {}, g = {} m/s² ({gravity}){tilt}",
        a.input_unit.name(),
        match file.gravity_source {
            GravitySource::Latitude => format!("{:.5}", file.gravity_mps2),
            GravitySource::Given | GravitySource::Standard => file.gravity_mps2.to_string(),
        },
    );
    paragraph("", &what) + &paragraph("", &how)
}

fn method_name(method: &str) -> String {
    match method {
        "ferraris" => "Ferraris calibration".to_owned(),
        "joint" => "Calibration".to_owned(),
        other => format!("Calibration ({other})"),
    }
}

fn parameters(file: &CalibrationFile) -> String {
    let a = &file.accelerometer;
    let axes = ["x", "y", "z"];
    let sd = a.deviations.map(|d| (d.bias, d.scale));
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

fn placements(file: &CalibrationFile) -> String {
    let a = &file.accelerometer;
    let mut out = String::new();
    let exact = a.method == "ferraris";
    if let Some(errors) = a.errors.filter(|_| exact) {
        out.push_str(&format!(
            "\nErrors over fitted faces, m/s²: RMS {:.5}, maximum {:.5}, mean norm {:.5}\n",
            errors.rms, errors.max, errors.mean_norm
        ));
    }
    if a.positions.is_empty() {
        return out;
    }
    out.push_str(&format!(
        "\n  {:<8}{:^24} {:^21}{:>7}{:>9}{:>8}\n",
        "position",
        "raw mean",
        "calibrated, m/s²",
        if exact { "|error|" } else { "|a|−g" },
        if exact { "raw tilt" } else { "left out" },
        if exact { "" } else { "tilt" },
    ));
    if !exact {
        out.push_str(&format!(
            "{:56}{:>7}{:>9}{:>8}\n",
            "", "mm/s²", "mm/s²", "°"
        ));
    }
    let largest = a
        .positions
        .iter()
        .flat_map(|p| p.raw)
        .fold(0.0_f64, |m, v| m.max(v.abs()));
    let decimals = decimals_of(largest, 5).min(4);
    for position in &a.positions {
        out.push_str(&placement(position, decimals, exact));
    }
    out
}

fn placement(p: &Position, decimals: usize, exact: bool) -> String {
    let raw: String = p.raw.iter().map(|v| format!("{v:>8.decimals$}")).collect();
    let calibrated: String = p.calibrated.iter().map(|v| format!("{v:>7.3}")).collect();
    let tilt = match (p.tilt_deg, p.tilt_sd_deg) {
        (Some(tilt), Some(sd)) => format!("{tilt:.1}±{sd:.1}"),
        (Some(tilt), None) => format!("{tilt:.1}°"),
        _ => "–".to_owned(),
    };
    let mm = |v: Option<f64>| v.map_or_else(|| "–".to_owned(), |v| format!("{:+.2}", 1000.0 * v));
    let label: String = p.label.chars().take(8).collect();
    let start = format!("  {label:<8}{raw} {calibrated}");
    if exact {
        return format!("{start}{:>7.4}{tilt:>9}\n", p.error_norm);
    }
    let left_out = if p.fitted {
        mm(p.left_out_error_mps2)
    } else {
        "not used".to_owned()
    };
    let own = mm(p.magnitude_error_mps2);
    format!("{start}{own:>7}{left_out:>9}{tilt:>8}\n")
}

/// What the uncertainty consists of, and the poses that would lower it.
fn uncertainty(file: &CalibrationFile) -> String {
    let a = &file.accelerometer;
    let mg = |v: f64| format!("{:.2}", 1000.0 * v / STANDARD_GRAVITY_MPS2);
    let mut out = String::new();
    if let Some(budget) = a.budget.as_ref().filter(|_| a.fit.is_some()) {
        out.push_str("\nUncertainty of the magnitude at rest, all directions, 1σ in mg\n\n");
        for part in &budget.contributions {
            let value = part.norm_mps2.map_or_else(|| "–".to_owned(), mg);
            let name = part.source.replace('-', " ");
            out.push_str(&paragraph(
                &format!("  {name:<16}{value:>7}  "),
                &part.basis,
            ));
        }
        out.push_str(&format!(
            "  {:<16}{:>7}  k = {}: ± {} mg\n",
            "combined",
            mg(budget.combined_mps2),
            budget.coverage_factor,
            mg(budget.expanded_mps2)
        ));
    }
    out
}

fn verdict(file: &CalibrationFile) -> String {
    let mut out = format!("\nVerdict: {}\n", file.verdict.grade.name());
    for reason in &file.verdict.reasons {
        out.push_str(&paragraph("  - ", reason));
    }
    out
}

//! Report of the gyroscope of a calibration.

use crate::document::{Block, Cell, Column, Row, Section, Table};
use gravical::calibration_file::{GyroMethod, GyroscopeSection};
use gravical::numfmt::{decimals_by, digits, fixed};

use super::matrices::{matrices, power_of_ten};

/// Parameters and residuals.
pub(super) fn gyroscope<'a>(g: &GyroscopeSection) -> Section<'a> {
    let raw = &g.input_unit.to_string();
    let how = match g.method {
        GyroMethod::Turns => "From three known turns and the rests (Ferraris).",
        GyroMethod::Motion => {
            "From the motions between poses: gravity rotated by the integrated rate must agree with the accelerometer at the next pose. The axes are those of the calibrated accelerometer."
        }
        GyroMethod::Bias => "Bias only, from the poses; the scale is nominal.",
    };
    let (bias_sd, scale_sd) = g.deviations().unzip();
    let scale_sd = scale_sd.flatten();
    let row = |i: usize| {
        let value = |v: f64, sd: Option<f64>| {
            let n = decimals_by(sd, g.scale[i]);
            // From the covariance; not a field of the JSON.
            let sd = sd.filter(|s| s.is_finite()).map(|s| fixed(s, n));
            Cell::number(fixed(v, n)).plus_minus(sd)
        };
        Row::from([
            Cell::text(["x", "y", "z"][i]),
            value(g.bias[i], bias_sd.map(|sd| sd[i])),
            value(g.scale[i], scale_sd.map(|sd| sd[i])),
        ])
    };
    let table = Table::new("Bias and scale, ± 1σ")
        .columns([
            Column::left("axis"),
            Column::number(format!("bias b, {raw}")),
            Column::number(format!("scale K, {raw} per rad/s")),
        ])
        .rows((0..3).map(row));
    let matrix = matrices(
        &g.orientation,
        &g.matrix,
        &format!("matrix, rad/s per {raw}"),
    );
    let section = Section::new("gyroscope", "Gyroscope")
        .with(Block::Equation(vec![
            "raw = K R ω + b + S a",
            "calibrated = matrix · (raw − b − S a)",
        ]))
        .with(Block::paragraph(how))
        .full(Block::paragraph(format!(
            "ω is angular rate in rad/s, counter-clockwise about each axis; raw values are in {raw}."
        )))
        .with(table);
    let mut section = if g.method == GyroMethod::Bias {
        section.full(matrix)
    } else {
        section.with(matrix)
    };
    if g.g_sensitivity.iter().flatten().any(|v| *v != 0.0) {
        // Known to a few per cent.
        let text = power_of_ten(&g.g_sensitivity, 2);
        let rows = ["x", "y", "z"].iter().zip(&g.g_sensitivity);
        let rows = rows.map(|(axis, row)| Row::axes(axis, Some(*row), |_, v| text(v)));
        let coupling = Table::new(format!("S, {raw} per m/s²"))
            .columns([Column::left("")])
            .columns(Column::axes(""))
            .rows(rows);
        section = section.full(coupling);
    }
    if let (Some(residual), Some(motions)) = (g.residual_deg, g.motions) {
        let left_out = g.leave_one_out_deg.map_or_else(
            || "too few motions for leave-one-out".to_owned(),
            |d| format!("leave-one-out {}°", digits(d, 2)),
        );
        section = section.with(Block::paragraph(format!(
            "{} motions between poses, {} not used. Residual direction of gravity after a motion: {}° rms ({left_out}).",
            motions.used,
            motions.left_out,
            digits(residual, 2)
        )));
    }
    section
}

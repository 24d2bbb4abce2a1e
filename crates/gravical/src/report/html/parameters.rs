//! Parameters of the accelerometer, and what to paste.

use maud::{Markup, html};

use super::cells::{
    cell, decimals_by, digits, fixed, heads, maybe, none, shown_unit, small, table, three,
};
use super::gallery::Gallery;
use crate::calibration_file::{CalibrationFile, GyroscopeSection};

const AXES: [&str; 3] = ["x", "y", "z"];

/// Table, matrices, equation, block to paste.
pub(super) fn accelerometer(file: &CalibrationFile, gallery: &mut Gallery<'_>) -> Markup {
    let a = &file.accelerometer;
    let unit = &shown_unit(a.input_unit.name());
    let sd = a.deviations;
    let body = html! {
        @for i in 0..3 {
            @let bias = decimals_by(sd.map(|d| d.bias[i]), a.scale[i]);
            @let scale = sd.map_or_else(|| decimals_by(None, a.scale[i]), |d| decimals_by(Some(d.scale[i]), a.scale[i]));
            tr {
                th scope="row" { (AXES[i]) }
                (cell(&format!("/accelerometer/bias/{i}"), a.bias[i], &fixed(a.bias[i], bias)))
                (maybe(&format!("/accelerometer/deviations/bias/{i}"), sd.map(|d| d.bias[i]), |v| format!("± {}", fixed(v, bias))))
                (cell(&format!("/accelerometer/scale/{i}"), a.scale[i], &fixed(a.scale[i], scale)))
                (maybe(&format!("/accelerometer/deviations/scale/{i}"), sd.map(|d| d.scale[i]), |v| format!("± {}", fixed(v, scale))))
                (maybe(&format!("/accelerometer/scale_deviation_percent/{i}"), a.scale_deviation_percent.map(|d| d[i]), |v| super::cells::signed(v, 2)))
            }
        }
    };
    let bias = format!("bias b, {unit}");
    let scale = format!("scale K, {unit} per m/s²");
    html! {
        p.equation { "raw = K R a + b" br; "calibrated = matrix · (raw − b)" }
        p {
            "a is specific force in m/s²: at rest an axis that points up reads +g. Raw values are in "
            (unit) ", as they stand in the file. R has rows of length one; matrix = R⁻¹ K⁻¹."
        }
        (table("Bias and scale, ± 1σ", &heads(&["axis", &bias, "1σ", &scale, "1σ", "off nominal, %"]), &body))
        div.pair {
            (matrix("R", "/accelerometer/orientation", &a.orientation))
            (matrix(&format!("matrix, m/s² per {unit}"), "/accelerometer/matrix", &a.matrix))
        }
        @if let Some(d) = sd {
            p {
                "Angles between the axes are known to "
                @for (i, name) in ["xy", "yz", "zx"].iter().enumerate() {
                    @if i > 0 { ", " }
                    (name) " ± " (super::cells::number(&format!("/accelerometer/deviations/axis_angle_deg/{i}"), d.axis_angle_deg[i], &digits(d.axis_angle_deg[i], 2))) "°"
                }
                ". "
                (super::cells::number("/accelerometer/deviations/coverage_factor_95", d.coverage_factor_95, &digits(d.coverage_factor_95, 3)))
                " of these standard deviations on either side make an interval of 95 %."
            }
        }
        h3 id="paste" { "To paste" }
        pre.paste role="region" aria-labelledby="paste" tabindex="0" { (paste(file)) }
        (gallery.show(&["parameters"]))
    }
}

/// A standard deviation without a field of its own.
fn sigma(sd: Option<f64>) -> Markup {
    match sd.filter(|v| v.is_finite()) {
        Some(v) => html! { td.n { "± " (small(v, 2)) } },
        None => none(1),
    }
}

/// Three by three.
pub(super) fn matrix(name: &str, key: &str, m: &[[f64; 3]; 3]) -> Markup {
    let largest = m.iter().flatten().fold(0.0_f64, |a, v| a.max(v.abs()));
    let text = |v: f64| {
        // One power of ten for all, where plain digits would be zeros.
        if v == 0.0 {
            "0".to_owned()
        } else if largest > 0.0 && largest < 0.1 {
            // What the coupling is known to is a few per cent.
            let precision = if key.ends_with("g_sensitivity") { 2 } else { 6 };
            format!("{v:.precision$e}").replace('-', "−")
        } else {
            fixed(v, 5)
        }
    };
    let body = html! {
        @for (i, row) in m.iter().enumerate() {
            tr { th scope="row" { (AXES[i]) } (three(&format!("{key}/{i}"), *row, |_, v| text(v))) }
        }
    };
    table(name, &heads(&["", "x", "y", "z"]), &body)
}

/// The formula with its numbers: C, Python and most others read it. Nine digits
/// give the same `f32` back.
fn paste(file: &CalibrationFile) -> String {
    let a = &file.accelerometer;
    let unit = &shown_unit(a.input_unit.name());
    let mut out = formula("a", "r", &a.matrix, &a.bias);
    out.push_str(&format!("\nrx, ry, rz: raw, {unit}; ax, ay, az: m/s^2\n"));
    if file.temperature_model.is_some() {
        out.push_str("its drift with temperature is not in it: gravical apply takes it off\n");
    }
    if file.gyroscope.as_ref().is_some_and(|g| !has_no_g_term(g)) {
        out.push_str("the gyroscope's formula has the acceleration in it and stands above\n");
    }
    if let Some(g) = file.gyroscope.as_ref().filter(|g| has_no_g_term(g)) {
        out.push('\n');
        out.push_str(&formula("w", "g", &g.matrix, &g.bias));
        let unit = &shown_unit(g.input_unit.name());
        out.push_str(&format!("\ngx, gy, gz: raw, {unit}; wx, wy, wz: rad/s\n"));
    }
    out
}

fn has_no_g_term(g: &GyroscopeSection) -> bool {
    g.g_sensitivity.iter().flatten().all(|v| *v == 0.0)
}

fn formula(out: &str, raw: &str, matrix: &[[f64; 3]; 3], bias: &[f64; 3]) -> String {
    let number = |v: f64| format!("{v:.8e}");
    let row = |axis: &str, m: &[f64; 3]| {
        let terms: Vec<String> = m
            .iter()
            .zip(AXES)
            .zip(bias)
            .map(|((m, from), b)| format!("{} * ({raw}{from} - ({}))", number(*m), number(*b)))
            .collect();
        format!("{out}{axis} = {};\n", terms.join("\n   + "))
    };
    AXES.iter()
        .zip(matrix)
        .map(|(axis, m)| row(axis, m))
        .collect()
}

/// Bias and scale of a gyroscope with what is known about them.
pub(super) fn gyroscope(g: &GyroscopeSection, sd: Option<([f64; 3], [f64; 3])>) -> Markup {
    let unit = &shown_unit(g.input_unit.name());
    let body = html! {
        @for i in 0..3 {
            @let bias = decimals_by(sd.map(|d| d.0[i]), g.scale[i]);
            @let scale = decimals_by(sd.map(|d| d.1[i]), g.scale[i]);
            tr {
                th scope="row" { (AXES[i]) }
                (cell(&format!("/gyroscope/bias/{i}"), g.bias[i], &fixed(g.bias[i], bias)))
                // By the covariance: no field of its own.
                (sigma(sd.map(|d| d.0[i])))
                (cell(&format!("/gyroscope/scale/{i}"), g.scale[i], &fixed(g.scale[i], scale)))
                (sigma(sd.map(|d| d.1[i])))
            }
        }
    };
    let heads = heads(&[
        "axis",
        &format!("bias b, {unit}"),
        "1σ",
        &format!("scale K, {unit} per rad/s"),
        "1σ",
    ]);
    table("Bias and scale, ± 1σ", &heads, &body)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_formula_has_all_its_digits() {
        let text = formula(
            "a",
            "r",
            &[[1.0 / 3.0, 0.0, -2e-7], [0.0; 3], [0.0; 3]],
            &[-0.5, 0.0, 12345.678],
        );
        let first = text.split(';').next().unwrap_or("");
        assert_eq!(
            first,
            "ax = 3.33333333e-1 * (rx - (-5.00000000e-1))\n   + 0.00000000e0 * (ry - (0.00000000e0))\n   + -2.00000000e-7 * (rz - (1.23456780e4))"
        );
    }
}

//! Report of a calibration.

use std::collections::BTreeSet;
use std::path::Path;

use crate::document::{
    self, Block, Cell, Column, Document, KeyFigure, Row, Section, Snippet, Table, Verdict,
};
use crate::figure::Figure;
use gravical::calibration_file::{
    CalibrationFile, Grade, GravitySource, GyroMethod, GyroscopeSection, InputFile, Method,
    PoseKind, PoseResult, Source,
};
use gravical::escape::path_word;
use gravical::export;
use gravical::numfmt::{
    count, decimals_for, decimals_of, digits, fixed, mg, milli_g, signed, words,
};
use gravical::poses::face::in_words;

use super::placements::{directions, placements};
use super::provenance::Provenance;
use super::temperature::drift;
use super::{named, short_name};

/// The document of a calibration, with its figures
/// ([`figure::calibration::figures`](crate::figure::calibration::figures)); `saved` is the path
/// of its file, if it was written.
pub fn calibration<'a>(
    file: &CalibrationFile,
    saved: Option<&Path>,
    figures: &'a [Figure],
) -> Document<'a> {
    let a = &file.accelerometer;
    let figure = |id, title, name| Section::new(id, title).figures(named(figures, &[name]));
    let mut document = Document {
        subject: subject(file),
        verdict: Some(verdict(file, saved)),
        ..Document::new(format!("Calibration{}", named_sensor(file)))
    }
    .with(parameters(file))
    .with(file.gyroscope.as_ref().map(gyroscope))
    .with(figure("magnitude", "Magnitude at rest", "norm"));
    if !a.poses.is_empty() {
        document = document
            .with(placements(file).figures(named(figures, &["residuals"])))
            .with(directions(file, named(figures, &["sphere", "tilt"])));
    }
    document
        .with(figure("captures", "Recorded poses", "captures"))
        .with(figure("noise", "Noise", "noise"))
        .with(temperature(file, named(figures, &["temperature"])))
        .with(method(file))
        .with_findings(&file.findings, file.inputs.len() > 1)
        .with_provenance(&Provenance {
            tool: &file.tool,
            command: file.command.as_deref(),
            created: &file.created,
            inputs: &file.inputs,
        })
}

/// " of board 3 (MPU6050)", or the file name.
fn named_sensor(file: &CalibrationFile) -> String {
    let recordings: Vec<&InputFile> = file.recordings().collect();
    match (&file.sensor.id, &file.sensor.model, &recordings[..]) {
        (Some(id), Some(model), _) => format!(" of {id} ({model})"),
        (Some(one), None, _) | (None, Some(one), _) => format!(" of {one}"),
        (None, None, [one]) => format!(" of {}", short_name(&one.path)),
        (None, None, _) => String::new(),
    }
}

/// Input, poses, unit, gravity and tilt in two lines.
fn subject(file: &CalibrationFile) -> Vec<String> {
    let a = &file.accelerometer;
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
    let tilt = a.pose_tilt_deg.map_or(String::new(), |t| {
        let how = words(&t.source);
        format!(", tilt of the face poses {:.1}° ({how})", t.value)
    });
    let on_faces = a.poses.iter().filter(|p| p.kind == PoseKind::Face);
    let labels: BTreeSet<&str> = on_faces.clone().map(|p| p.label.as_str()).collect();
    let faces = on_faces.count();
    let free = count(a.poses.len() - faces, "free pose");
    let on = match labels.len() {
        6 => "six faces".to_owned(),
        n => format!("{n} of six faces"),
    };
    let placed = match (faces, a.poses.len() - faces) {
        (0, _) => free,
        (_, 0) => format!("{faces} poses on {on}"),
        _ => format!("{faces} poses on {on} and {free}"),
    };
    let method = match a.method {
        Method::Ferraris => "Ferraris calibration",
        Method::Joint | Method::Unknown => "Calibration",
    };
    let g = match file.gravity_source {
        GravitySource::Latitude => format!("{:.5}", file.gravity_mps2),
        GravitySource::Given | GravitySource::Standard => file.gravity_mps2.to_string(),
    };
    let unit = a.input_unit;
    vec![
        format!("{method} of {inputs}: {placed}"),
        format!("raw in {unit}, g = {g} m/s² ({gravity}){tilt}"),
    ]
}

fn verdict(file: &CalibrationFile, saved: Option<&Path>) -> Verdict {
    let a = &file.accelerometer;
    let grade = match file.verdict.grade {
        Grade::Good => document::Grade::Good,
        Grade::Fair => document::Grade::Fair,
        Grade::Poor => document::Grade::Poor,
        Grade::NotVerifiable => document::Grade::Unknown,
    };
    let figures = [
        (
            a.worst_direction.map(|w| w.error_mps2),
            "error of ‖a‖ in the worst direction (95 %)",
        ),
        (
            a.predicted_norm_error_mps2,
            "predicted error of ‖a‖ (1σ, over all directions)",
        ),
        (a.leave_one_out_rms_mps2, "leave-one-out error of ‖a‖ (rms)"),
        (
            a.undetected.as_ref().map(|u| u.effect_mps2),
            "effect of an error of one pose that would not be detected",
        ),
    ];
    let figures = figures.into_iter();
    let figures = figures.filter_map(|(value, what)| Some(KeyFigure::new(mg(value?), "mg", what)));
    Verdict {
        conclusion: conclusion(file),
        figures: figures.collect(),
        next: next(file, saved),
        ..Verdict::new(
            grade,
            &file.verdict.grade.to_string(),
            &file.verdict.reasons,
        )
    }
}

/// The verdict in one sentence; none where the first reason says it.
fn conclusion(file: &CalibrationFile) -> Option<String> {
    let a = &file.accelerometer;
    let error = a.worst_direction.as_ref()?.error_mps2;
    let within = format!("within {} mg (95 %)", mg(error));
    let hidden = a.undetected.as_ref().map(|u| u.effect_mps2);
    match (file.verdict.grade, hidden.filter(|hidden| *hidden > error)) {
        (Grade::Fair, Some(hidden)) => Some(format!(
            "the magnitude at rest is {within} in every direction, unless one pose has an error that would not be detected: then up to {} mg",
            mg(hidden)
        )),
        (Grade::Good | Grade::Fair, _) => Some(format!(
            "the magnitude at rest is {within} in every direction"
        )),
        (Grade::NotVerifiable, _) => Some(format!(
            "predicted to be {within}, but these poses cannot confirm it"
        )),
        (Grade::Poor, _) => None,
    }
}

/// Next steps.
fn next(file: &CalibrationFile, saved: Option<&Path>) -> Vec<String> {
    let a = &file.accelerometer;
    let name = path_word(saved.unwrap_or(Path::new("cal.json")));
    let save = saved
        .is_none()
        .then(|| "Save the calibration: the same command with `-o cal.json`.".to_owned());
    let pose = a.proposed_poses().first().map(|p| {
        format!(
            "Record one more pose ({}) and calibrate with all recordings again.",
            in_words(p.direction)
        )
    });
    let apply = format!("Apply it: `gravical apply {name} RECORDING.csv -o calibrated.csv`");
    let check = format!(
        "Later, test with the sensor at rest whether it still fits: `gravical check {name} RECORDING.csv`"
    );
    match file.verdict.grade {
        Grade::Poor => vec!["Fix what is named above, then calibrate again.".to_owned()],
        Grade::NotVerifiable => pose.into_iter().chain(save).chain([apply]).collect(),
        Grade::Fair => pose.into_iter().chain(save).chain([apply, check]).collect(),
        Grade::Good => save.into_iter().chain([apply, check]).collect(),
    }
}

/// Table, matrices, equation, block to paste.
fn parameters<'a>(file: &CalibrationFile) -> Section<'a> {
    let a = &file.accelerometer;
    let raw = &a.input_unit.to_string();
    let sd = a.deviations;
    let row = |i: usize| {
        let off = a.scale_deviation_percent.map(|d| d[i]);
        Row::from([
            Cell::text(["x", "y", "z"][i]),
            // Without an uncertainty: the digits of the student report.
            estimate(a.bias[i], sd.map(|d| d.bias[i]), decimals_of(a.scale[i], 6)),
            estimate(
                a.scale[i],
                sd.map(|d| d.scale[i]),
                decimals_of(a.scale[i], 7),
            ),
            Cell::maybe(off, |v| signed(v, 2)),
        ])
    };
    let uncertain = if sd.is_some() { ", ± 1σ" } else { "" };
    let table = Table::new(format!("Bias and scale{uncertain}"))
        .columns([
            "axis",
            &format!("bias b, {raw}"),
            &format!("scale K, {raw} per m/s²"),
            "off nominal, %",
        ])
        .rows((0..3).map(row));
    let section = Section::new("parameters", "Accelerometer")
        .with(Block::Equation(vec![
            "raw = K R a + b",
            "calibrated = matrix · (raw − b)",
        ]))
        .full(Block::paragraph(format!(
            "a is specific force in m/s²: at rest an axis that points up reads +g. Raw values are in {raw}, as in the file. The rows of R have unit length; matrix = R⁻¹ K⁻¹."
        )))
        .with(table)
        .with(matrices(
            &a.orientation,
            &a.matrix,
            &format!("matrix, m/s² per {raw}"),
        ));
    let section = match sd {
        None => section,
        Some(d) => {
            let [xy, yz, zx] = d.axis_angle_deg.map(|v| digits(v, 2));
            section.full(Block::paragraph(format!(
                "Standard uncertainty of the angles between the axes: xy {xy}°, yz {yz}°, zx {zx}°. The 95 % interval is ± 1.96 standard uncertainties."
            )))
        }
    };
    section.full(Block::Snippets(
        export::snippets(file)
            .map(|(language, fence, code)| Snippet {
                language,
                fence,
                code,
            })
            .into(),
    ))
}

fn temperature<'a>(file: &CalibrationFile, figures: Vec<&'a Figure>) -> Section<'a> {
    let seen = match &file.temperature_c {
        Some(t) => format!(
            "Temperature of the poses: {} °C on average, from {} to {} °C.",
            fixed(t.mean, 1),
            fixed(t.min, 1),
            fixed(t.max, 1)
        ),
        None => "The recordings contain no temperature.".to_owned(),
    };
    let section = Section::new("temperature", "Temperature and time")
        .full(Block::Paragraph(seen))
        .figures(figures);
    let Some(model) = &file.temperature_model else {
        let unknown = "Drift with temperature was not measured.";
        return section.full(Block::paragraph(unknown));
    };
    let section = drift(section, model);
    if !model.any_corrected() {
        return section;
    }
    section.with(Block::paragraph(format!(
        "The drift is relative to {} °C, the mean of the poses. Outside the measured range the value at its limit is used.",
        fixed(model.reference_c, 1)
    )))
}

/// Method, assumptions, poses left out, uncertainty budget.
fn method<'a>(file: &CalibrationFile) -> Section<'a> {
    let section = Section::new("method", "Method and uncertainty")
        .full(Block::paragraph(how(file.accelerometer.method)))
        .full(Block::List(assumptions(file)));
    let rejected = rejected(file);
    let section = if rejected.rows.is_empty() {
        section.full(Block::paragraph("All poses were used in the fit."))
    } else {
        section.full(rejected)
    };
    match budget(file) {
        Some(table) => section.with(table),
        None => section,
    }
}

/// The method in words.
fn how(method: Method) -> &'static str {
    match method {
        Method::Joint => {
            "One fit of all poses: at a face pose the direction of gravity is known up to a tilt, whose size is estimated; at a free pose only the magnitude is used. Bias, scale, the angles between the axes and a nonlinear response are estimated with their covariance. The nonlinear response is shown and not corrected."
        }
        Method::Ferraris => {
            "Six faces in closed form (Ferraris, Grimaldi and Parvis 1995): the faces are assumed exact, so a tilted pose changes the parameters."
        }
        Method::Unknown => "The parameters are from another program; the method is unknown.",
    }
}

fn assumptions(file: &CalibrationFile) -> Vec<String> {
    let a = &file.accelerometer;
    let mut lines = vec![format!(
        "Local gravity is {} m/s²; an error of 0.1 % in it is an error of 0.1 % in the scale.",
        fixed(file.gravity_mps2, 5)
    )];
    if let Some(tilt) = a.pose_tilt_deg {
        lines.push(format!(
            "The tilt of a face pose has a standard deviation of {}° in each of two directions.",
            fixed(tilt.value, 1)
        ));
    }
    if let Some(fit) = a.fit {
        let prior = if fit.prior {
            "Data sheet limits of scale, cross-axis terms and bias are used as weak prior knowledge."
        } else {
            "No data sheet limits are used."
        };
        lines.push(prior.to_owned());
        if let Some(chi2) = fit.chi2_per_freedom {
            lines.push(format!(
                "χ² per degree of freedom ({} of them): {}.",
                digits(fit.freedom, 3),
                digits(chi2, 2)
            ));
        }
        if let Some(bends) = a.bends {
            let largest = bends.iter().fold(0.0_f64, |m, b| m.max(b.abs()));
            lines.push(format!(
                "Nonlinear response, largest of the six terms: {} % of g at 1 g, not corrected.",
                digits(100.0 * largest, 2)
            ));
        }
        if fit.model_error_mps2 > 0.0 {
            lines.push(format!(
                "Model misfit beyond noise: {} mm/s², included in the uncertainty.",
                digits(1e3 * fit.model_error_mps2, 2)
            ));
        }
        if !fit.oriented {
            lines.push("Too few faces determine the orientation in the case: the matrix is triangular by convention.".to_owned());
        }
    }
    if a.fit.is_none() {
        lines.push(format!(
            "Degrees of freedom of the magnitudes: {}.",
            a.degrees_of_freedom
        ));
    }
    lines
}

/// Poses that were not used, with the reason.
fn rejected(file: &CalibrationFile) -> Table {
    let a = &file.accelerometer;
    let row = |pose: &PoseResult| {
        let reason = match pose.magnitude_error_mps2 {
            _ if a.method == Method::Ferraris => {
                "it is on no face, and ferraris uses face poses only".to_owned()
            }
            Some(error) => format!(
                "reads {} mg off the magnitude that all others agree on",
                signed(milli_g(error), 1)
            ),
            None => "it contradicts the others".to_owned(),
        };
        // With its lines: several poses may have one label.
        Row::from([Cell::text(pose.called()), Cell::Text(reason)])
    };
    Table::new("Poses not used")
        .columns(["pose", "reason"])
        .rows(a.poses.iter().filter(|p| !p.fitted).map(row))
}

fn budget(file: &CalibrationFile) -> Option<Table> {
    let budget = file.accelerometer.budget.as_ref()?;
    // Digits according to the combined uncertainty.
    let n = decimals_of(milli_g(budget.combined_mps2), 2);
    let mg = |v: f64| fixed(milli_g(v), n);
    let parts = budget.contributions.iter();
    let parts = parts.map(|part| {
        Row::from([
            Cell::text(words(&part.source)),
            Cell::maybe(part.norm_mps2, mg),
            Cell::Text(basis(part.source, file)),
        ])
    });
    let sum = |name: &str, value: f64, how: String| {
        let value = Cell::number(mg(value));
        Row::from([Cell::text(name), value, Cell::Text(how)]).sum()
    };
    let squares = "root sum of squares".to_owned();
    let k = format!("k = {}", budget.coverage_factor);
    let table = Table::new("Uncertainty of the magnitude at rest, all directions, 1σ")
        .columns(["source", "mg", "from"])
        .rows(parts)
        .row(sum("combined", budget.combined_mps2, squares))
        .row(sum("expanded", budget.expanded_mps2, k));
    Some(table)
}

/// What the value of a source rests on.
fn basis(source: Source, file: &CalibrationFile) -> String {
    let tilt = || {
        file.accelerometer
            .pose_tilt_deg
            .map_or("no face poses".to_owned(), |t| {
                format!("σ of {:.2}° in each of two components", t.value)
            })
    };
    let text = match source {
        Source::Noise => "standard errors of the means",
        Source::Quantisation => "steps of the converter",
        Source::ModelError => "deviation of the poses from the model, beyond their noise",
        Source::Nonlinearity => "response that the poses show, not corrected",
        Source::PoseTilt => return tilt(),
        Source::DataSheet => {
            "scale ±3 %, cross-axis ±2 %, zero-g ±0.6 m/s², where the poses determine less"
        }
        Source::NoiseAndTilt => return format!("standard errors of the means; {}", tilt()),
        Source::LocalGravity => match file.gravity_source {
            GravitySource::Given => "taken as exact: it was given",
            GravitySource::Latitude => "anomalies of the field at that latitude",
            GravitySource::Standard => "9.80665 m/s² assumed; 9.780 to 9.832 at sea level",
        },
        Source::Temperature => match &file.temperature_c {
            None => "no temperature was recorded",
            Some(t) => return format!("{:.1} to {:.1} °C during the session", t.min, t.max),
        },
    };
    text.to_owned()
}

/// Parameters and residuals.
fn gyroscope<'a>(g: &GyroscopeSection) -> Section<'a> {
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
        let decimals = decimals_of(g.scale[i], 6);
        Row::from([
            Cell::text(["x", "y", "z"][i]),
            estimate(g.bias[i], bias_sd.map(|sd| sd[i]), decimals),
            estimate(g.scale[i], scale_sd.map(|sd| sd[i]), decimals),
        ])
    };
    let table = Table::new("Bias and scale, ± 1σ")
        .columns([
            "axis",
            &format!("bias b, {raw}"),
            &format!("scale K, {raw} per rad/s"),
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
            .columns([""])
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

/// A parameter with two digits of its uncertainty; without one with these decimals.
fn estimate(value: f64, sd: Option<f64>, decimals: usize) -> Cell {
    let n = sd.filter(|sd| *sd > 0.0).map_or(decimals, decimals_for);
    Cell::number(fixed(value, n)).plus_minus(sd, n)
}

/// R and the calibration matrix, side by side.
fn matrices(orientation: &[[f64; 3]; 3], matrix: &[[f64; 3]; 3], name: &str) -> Table {
    let text = power_of_ten(matrix, 6);
    let row = |i: usize| {
        let orientation = Cell::axes(Some(orientation[i]), |_, v| fixed(v, 5));
        let matrix = Cell::axes(Some(matrix[i]), |_, v| text(v));
        Row::named(["x", "y", "z"][i], orientation.into_iter().chain(matrix))
    };
    Table::new("")
        .columns([""])
        .columns(Column::axes("R"))
        .columns(Column::axes(name))
        .rows((0..3).map(row))
}

/// Formats the elements of a matrix, with powers of ten if all are small.
fn power_of_ten(matrix: &[[f64; 3]; 3], precision: usize) -> impl Fn(f64) -> String {
    let largest = matrix.iter().flatten().fold(0.0_f64, |a, v| a.max(v.abs()));
    move |v| match v {
        0.0 => "0".to_owned(),
        v if largest < 0.1 => format!("{v:.precision$e}"),
        v => fixed(v, decimals_of(largest, 6)),
    }
}

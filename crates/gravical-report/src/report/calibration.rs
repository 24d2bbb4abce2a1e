//! Report of a calibration.

use std::collections::BTreeSet;
use std::path::Path;

use gravical::calibration_file::{
    Calibration, Grade, GravitySource, GyroMethod, Gyroscope, InputFile, Method, Mounting,
    PoseKind, PoseResult,
};
use gravical::escape::path_word;
use gravical::export;
use gravical::numfmt::{
    COVERAGE, count, decimals_for, decimals_of, digits, fixed, mg, milli_g, signed, words,
};
use gravical::poses::face::CaseAxes;

use gravical::core::matrix3::{cross, dot, norm, sub, unit};

use super::{drift, gravity_source, largest, short_name};
use crate::document::{Block, Cell, Document, HOW, Section, Step, Table, Verdict};
use crate::figure::calibration::rms_before;
use crate::figure::{Figure, XYZ};

/// The document of a calibration, with its figures
/// ([`figure::calibration::figures`](crate::figure::calibration::figures)); `saved` is the path
/// of its file, if it was written.
pub fn calibration<'a>(
    file: &Calibration,
    saved: Option<&Path>,
    figures: &'a [Figure],
) -> Document<'a> {
    let placed = !file.poses.is_empty();
    let verdict = file.verdict();
    let grade = verdict.grade;
    // What proves the verdict; without a test, what would make one.
    let (first, second) = match grade {
        Grade::NotVerifiable => ("more-poses", "errors"),
        _ => ("errors", "more-poses"),
    };
    let is_drawn = figures.iter().any(|f| f.name == first);
    let (first, second) = if is_drawn {
        (first, second)
    } else {
        (second, first)
    };
    let figure = |name: &str, title, wide| Section::new(title).figures(figures, &[name]).wide(wide);
    let r = &file.reliability;
    let is_unsure = matches!(grade, Grade::Fair | Grade::NotVerifiable);
    let hidden = r.undetected.zip(r.worst_direction).filter(|_| is_unsure);
    let hidden = hidden
        .filter(|(u, worst)| u.effect_mps2 > worst.error_mps2)
        .map(|(u, _)| {
            let most = mg(u.effect_mps2);
            format!(
                "If one pose has an error that is not detected, the result may be off by {most} mg."
            )
        });
    // What speaks against it stands beside the number.
    let contrary = match grade {
        Grade::Poor => verdict.reasons.first().cloned(),
        // What was tested says so itself.
        Grade::NotVerifiable if r.left_out_rms_mps2.is_none() => {
            let untested =
                |reason: &&String| reason.contains("verif") || reason.contains("too few");
            verdict.reasons.iter().find(untested).cloned()
        }
        _ => None,
    };
    let half = if file.gyroscope.is_some() { 6 } else { 12 };
    Document {
        subject: subject(file),
        certificate: certificate(file),
        verdict: Some(Verdict {
            grade,
            word: grade.to_string(),
            headline: headline(file, grade),
            proof: proof(file)
                .into_iter()
                .chain(hidden)
                .chain(contrary)
                .collect(),
            numbers: numbers(file),
            reasons: verdict.reasons,
            next: next(file, grade, saved),
        }),
        ..Document::new(format!("Calibration{}", named_sensor(file)))
    }
    .with(figure(first, "Errors", 7))
    .with(accelerometer(file).wide(half))
    .with(file.gyroscope.as_ref().map(|g| gyroscope(g).wide(6)))
    .with(figure("sphere", "Directions", 5))
    .with(figure("recording", "Recording", 7))
    .with((grade != Grade::Good).then(|| figure(second, "More", 12)))
    .with(placed.then(|| poses(file)))
    .with(matrix_section(file))
    .with(code(file))
    .with(temperature(file))
    .with(method(file))
    .with_findings(&file.findings, file.inputs.len() > 1)
    .with_provenance(
        &file.tool,
        file.command.as_deref(),
        &file.created,
        &file.inputs,
    )
}

/// What was calibrated, when, and from what.
fn certificate(file: &Calibration) -> Vec<[String; 3]> {
    let sensor = &file.sensor;
    let (model, id) = (sensor.model.clone(), sensor.id.clone());
    let named = model
        .clone()
        .or(id.clone())
        .unwrap_or_else(|| "not named".to_owned());
    let recorded = file.recorded.as_ref().map(|r| r.time.minute());
    let temperature = file.temperature_c.as_ref();
    let degrees = temperature.map_or_else(
        || "not recorded".to_owned(),
        |t| format!("{:.1} °C", t.mean),
    );
    let range = temperature.map_or(String::new(), |t| format!("{:.1} to {:.1}", t.min, t.max));
    let faces = file
        .poses
        .iter()
        .filter(|p| p.kind == PoseKind::Face)
        .count();
    let free = file.poses.len() - faces;
    let recordings: Vec<&InputFile> = file.recordings().collect();
    let files = match &recordings[..] {
        [one] => short_name(&one.path),
        several => format!("{} files", several.len()),
    };
    let entry = |name: &str, value: String, remark: String| [name.to_owned(), value, remark];
    vec![
        entry(
            "Sensor",
            named,
            id.filter(|_| model.is_some()).unwrap_or_default(),
        ),
        entry(
            "Recorded",
            recorded.unwrap_or_else(|| "date unknown".to_owned()),
            String::new(),
        ),
        entry("Temperature", degrees, range),
        entry(
            "Gravity",
            format!("{:.5} m/s²", file.gravity_mps2),
            gravity_source(file.gravity_source).to_owned(),
        ),
        entry(
            "Poses",
            format!("{}, {free} free", count(faces, "face")),
            String::new(),
        ),
        entry("Recording", files, String::new()),
    ]
}

/// The one number: within what ‖a‖ holds in every direction. Of six faces that holds in 90 % of the sessions.
fn headline(file: &Calibration, grade: Grade) -> [String; 2] {
    let Some(worst) = file.reliability.worst_direction else {
        return ["The error is not known".to_owned(), String::new()];
    };
    let is_tested = file.reliability.left_out_rms_mps2.is_some();
    let share = if is_tested { "95 %" } else { "90 %, untested" };
    let what = match grade {
        Grade::Poor => "Known only to",
        Grade::NotVerifiable => "Perhaps within",
        Grade::Good | Grade::Fair => "Within",
    };
    let text = format!("{what} {} mg in every direction", mg(worst.error_mps2));
    [text, share.to_owned()]
}

/// What tests it: the poses that were left out in turn.
fn proof(file: &Calibration) -> Option<String> {
    let tested = file.poses.iter().filter(|p| p.left_out_sd_mps2.is_some());
    let tested =
        tested.filter_map(|p| Some((p, p.left_out_error_mps2?, COVERAGE * p.left_out_sd_mps2?)));
    let tested: Vec<_> = tested.collect();
    let (worst, error, within) = tested
        .iter()
        .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    let beyond = tested
        .iter()
        .filter(|(_, error, within)| error.abs() > *within)
        .count();
    let agree = match beyond {
        0 => "all agree within their bars".to_owned(),
        n => format!("{} of them agree within their bars", tested.len() - n),
    };
    let n = decimals_for(milli_g(*within));
    let [error, within] = [milli_g(error.abs()), milli_g(*within)].map(|v| fixed(v, n));
    Some(format!(
        "{} test it, each with a calibration that does not know it: {agree}; the largest error is {error} ± {within} mg ({}).",
        count(tested.len(), "pose"),
        worst.label
    ))
}

/// Before, left out, hidden.
fn numbers(file: &Calibration) -> Vec<[String; 2]> {
    let r = &file.reliability;
    let before = rms_before(file);
    let all = [
        (before, "before, rms of the poses"),
        (r.left_out_rms_mps2, "left out, rms"),
        (
            r.undetected.map(|u| u.effect_mps2),
            "one wrong pose could hide",
        ),
    ];
    let known = all
        .into_iter()
        .filter_map(|(value, what)| Some((value?, what)));
    known
        .map(|(value, what)| [format!("{} mg", mg(value)), what.to_owned()])
        .collect()
}

/// " of board 3 (MPU6050)", or the file name.
fn named_sensor(file: &Calibration) -> String {
    let recordings: Vec<&InputFile> = file.recordings().collect();
    match (&file.sensor.id, &file.sensor.model, &recordings[..]) {
        (Some(id), Some(model), _) => format!(" of {id} ({model})"),
        (Some(one), None, _) | (None, Some(one), _) => format!(" of {one}"),
        (None, None, [one]) => format!(" of {}", short_name(&one.path)),
        (None, None, _) => String::new(),
    }
}

/// Input, poses, unit, gravity and tilt in two lines.
fn subject(file: &Calibration) -> Vec<String> {
    let a = &file.accelerometer;
    let recordings: Vec<&InputFile> = file.recordings().collect();
    let inputs = match &recordings[..] {
        [one] => short_name(&one.path),
        several => format!("{} files", several.len()),
    };
    let method = match a.method {
        Method::Ferraris => "Ferraris calibration",
        Method::Joint | Method::Unknown => "Calibration",
    };
    let faces = file.poses.iter().filter(|p| p.kind == PoseKind::Face);
    let labels: BTreeSet<&str> = faces.clone().map(|p| p.label.as_str()).collect();
    let (faces, free) = (faces.clone().count(), file.poses.len() - faces.count());
    let on_faces = count(faces, "pose") + " on " + &count(labels.len(), "face");
    let poses = [(faces, on_faces), (free, count(free, "free pose"))];
    let poses: Vec<String> = poses.into_iter().filter(|p| p.0 > 0).map(|p| p.1).collect();
    let tilt = file.reliability.pose_tilt_deg.map_or(String::new(), |t| {
        let how = words(&t.source);
        format!(", tilt of the face poses {:.1}° ({how})", t.value)
    });
    let g = match file.gravity_source {
        GravitySource::Latitude => format!("{:.5}", file.gravity_mps2),
        GravitySource::Given | GravitySource::Standard => file.gravity_mps2.to_string(),
    };
    let (unit, source) = (a.input_unit, gravity_source(file.gravity_source));
    vec![
        format!("{method} of {inputs}: {}", poses.join(" and ")),
        format!("raw in {unit}, g = {g} m/s² ({source}){tilt}"),
    ]
}

/// Next steps.
fn next(file: &Calibration, grade: Grade, saved: Option<&Path>) -> Vec<Step> {
    if grade == Grade::Poor {
        return vec![Step::by_hand(
            "Fix what is named above, then calibrate again.",
        )];
    }
    let name = path_word(saved.unwrap_or(Path::new("cal.json")));
    let pose = file.reliability.proposed_poses().first();
    let pose = pose.filter(|_| grade != Grade::Good);
    let save = "Save the calibration: the same command with `-o cal.json`.";
    let apply = format!("{name} RECORDING.csv -o calibrated.csv");
    let check = format!("{name} RECORDING.csv");
    let later = "Later, test with the sensor at rest whether it still fits";
    let steps = [
        pose.map(|p| Step::Pose(p.direction)),
        saved.is_none().then(|| Step::by_hand(save)),
        Some(Step::run("Apply it", "apply", &apply)),
        (grade != Grade::NotVerifiable).then(|| Step::run(later, "check", &check)),
    ];
    steps.into_iter().flatten().collect()
}

/// Equation, table, matrices, block to paste.
fn accelerometer<'a>(file: &Calibration) -> Section<'a> {
    let a = &file.accelerometer;
    let raw = &a.input_unit.to_string();
    let sd = a.deviations();
    let bias = (a.bias, sd.map(|d| d.bias));
    let scale = (a.scale(), sd.map(|d| d.scale));
    Section::new("Accelerometer")
        .with(bias_and_scale(raw, "m/s²", bias, scale, a.scale_deviation_percent()))
        .with(Block::Equation("raw = K R a + b,  calibrated = matrix · (raw − b)"))
        .full(Block::Note(format!(
            "At rest an axis that points up reads +g. Raw values in {raw}; rows of R have length one, matrix = R⁻¹ K⁻¹."
        )))
        .with(file.mounting().map(|m| Block::Note(in_its_case(&m))))
}

/// R and the matrix of both sensors.
fn matrix_section<'a>(file: &Calibration) -> Section<'a> {
    let a = &file.accelerometer;
    let name = format!("matrix, m/s² per {}", a.input_unit);
    let own = matrices("Accelerometer", &a.orientation(), &a.matrix, &name);
    let gyro = file
        .gyroscope
        .as_ref()
        .filter(|g| g.method != GyroMethod::Bias);
    let gyro = gyro.map(|g| {
        let name = format!("matrix, rad/s per {}", g.input_unit);
        Block::Table(matrices("Gyroscope", &g.orientation(), &g.matrix, &name))
    });
    let section = Section::new("Matrices").with(own).with(gyro);
    section.folded("R and the calibration matrix")
}

/// The calibration as code.
fn code<'a>(file: &Calibration) -> Section<'a> {
    let code = export::snippets(file).map(|(name, code)| Block::Code(name, code));
    let section = code.into_iter().fold(Section::new("Code"), Section::full);
    section.folded("all give the same values")
}

/// By how much the sensor is turned in its case.
fn in_its_case(mounting: &Mounting) -> String {
    let part = |i: usize| {
        let (angle, sigma) = (mounting.rotation_deg[i], mounting.sigma_deg[i]);
        let n = decimals_for(COVERAGE * sigma);
        format!("{} ± {}°", signed(angle, n), fixed(COVERAGE * sigma, n))
    };
    let parts = [0, 1, 2].map(part).join(", ");
    format!("Turned in its case by {parts} about x, y, z.")
}

/// Equation, table, matrices, residuals.
fn gyroscope<'a>(g: &Gyroscope) -> Section<'a> {
    let raw = &g.input_unit.to_string();
    let how = match g.method {
        GyroMethod::Turns => "From a full turn about each axis and the six faces (Ferraris).",
        GyroMethod::Motion => {
            "From the motions between poses: gravity rotated by the integrated rate must agree with the accelerometer at the next pose. The axes are those of the calibrated accelerometer."
        }
        GyroMethod::Bias => "Bias only, from the poses; the scale is nominal.",
    };
    let (bias_sd, scale_sd) = g.deviations().unzip();
    let (bias, scale) = ((g.bias, bias_sd), (g.scale(), scale_sd.flatten()));
    Section::new("Gyroscope")
        .with(bias_and_scale(raw, "rad/s", bias, scale, None))
        .with(Block::Equation(
            "raw = K R ω + b + S a,  calibrated = matrix · (raw − b − S a)",
        ))
        .with(Block::Note(how.to_owned()))
        .with(motions(g).map(Block::Note))
}

/// How well the motions between poses are explained.
fn motions(g: &Gyroscope) -> Option<String> {
    let (residual, motions) = (digits(g.residual_deg?, 2), g.motions?);
    let left_out = g.left_out_deg.map_or_else(
        || "too few motions for leave-one-out".to_owned(),
        |d| format!("leave-one-out {}°", digits(d, 2)),
    );
    let (used, unused) = (motions.used, motions.left_out);
    Some(format!(
        "{used} motions between poses, {unused} not used. Residual direction of gravity after a motion: {residual}° rms ({left_out})."
    ))
}

/// Values along the axes, and their standard uncertainties.
type Estimates = ([f64; 3], Option<[f64; 3]>);

/// Bias and scale of a sensor with two digits of their uncertainties; without those with the digits
/// of the student report.
fn bias_and_scale(
    raw: &str,
    unit: &str,
    bias: Estimates,
    scale: Estimates,
    off_nominal: Option<[f64; 3]>,
) -> Table {
    let estimate = |(values, sd): Estimates, i: usize, decimals: usize| {
        let sd = sd.map(|sd| sd[i]);
        let within = sd.filter(|sd| *sd > 0.0).map(|sd| COVERAGE * sd);
        let n = within.map_or(decimals, decimals_for);
        Cell::number(fixed(values[i], n)).plus_minus(sd, n)
    };
    let (name, unit) = (format!("bias b, {raw}"), format!("{raw} per {unit}"));
    let table = Table::new("", ["axis", &name, &format!("scale K, {unit}")]);
    let table = table.columns(off_nominal.map(|_| "off nominal, %"));
    (0..3).fold(table, |table, i| {
        let cells = [
            estimate(bias, i, decimals_of(scale.0[i], 6)),
            estimate(scale, i, decimals_of(scale.0[i], 7)),
        ];
        let off = off_nominal.map(|off| Cell::number(signed(off[i], 2)));
        table.row(XYZ[i], cells.into_iter().chain(off))
    })
}

/// R and the calibration matrix, side by side.
fn matrices(
    sensor: &str,
    orientation: &[[f64; 3]; 3],
    matrix: &[[f64; 3]; 3],
    name: &str,
) -> Table {
    // With powers of ten if all are small.
    let largest = largest(matrix.as_flattened());
    let text = |v: f64| match v {
        0.0 => "0".to_owned(),
        v if largest < 0.1 => format!("{v:.6e}"),
        v => fixed(v, decimals_of(largest, 6)),
    };
    let table = Table::new(sensor, [""]).axes("R").axes(name);
    (0..3).fold(table, |table, i| {
        let orientation = Cell::axes(Some(orientation[i]), |v| fixed(v, 5));
        let matrix = Cell::axes(Some(matrix[i]), text);
        table.row(XYZ[i], orientation.into_iter().chain(matrix))
    })
}

/// Every pose before and after calibration.
fn poses<'a>(file: &Calibration) -> Section<'a> {
    let a = &file.accelerometer;
    // The closed form has only errors of the vectors.
    let exact = a.method == Method::Ferraris;
    let largest = largest(file.poses.iter().flat_map(|p| &p.raw));
    let decimals = decimals_of(largest, 5).min(4);
    let mg = |v: f64| signed(milli_g(v), 2);
    let mut table = Table::new("", ["pose"])
        .axes(&format!("raw mean, {}", a.input_unit))
        .axes("calibrated, m/s²")
        .columns(exact.then_some("error, m/s²"))
        .columns(["‖a‖ − g, mg", "left out, mg", "tilt, °"]);
    for p in &file.poses {
        let unused = if p.fitted { "" } else { " (not used)" };
        let mut cells = Cell::axes(Some(p.raw), |v| fixed(v, decimals)).to_vec();
        cells.extend(Cell::axes(Some(p.calibrated), |v| fixed(v, 3)));
        cells.extend(exact.then(|| Cell::number(fixed(p.error_norm(), 4))));
        cells.extend([
            Cell::maybe(p.magnitude_error_mps2, mg),
            Cell::maybe(p.left_out_error_mps2, mg),
            Cell::maybe(p.tilt_deg, |v| fixed(v, 1)).plus_minus(p.tilt_sd_deg, 1),
        ]);
        table = table.row(format!("{}{unused}", p.label), cells);
    }
    let error = if exact {
        "error: magnitude of calibrated − expected. "
    } else {
        ""
    };
    let apart = "Of the faces: along the axis is the sensor's error, off it how the board lay.";
    let fitted = "‖a‖ − g is what is left after the fit: no measure of accuracy.";
    let note = format!(
        "{error}left out: ‖a‖ − g if this pose and those within 25° of it are not used in the fit. tilt: angle off the face."
    );
    let forces = file.poses.iter().map(|p| sub(&p.raw, &a.bias));
    let case_axes = CaseAxes::of(forces).map(|axes| Block::Note(axes.advice("pose")));
    Section::new("Poses")
        .with(table)
        .with(case_axes)
        .with(Block::Note(fitted.to_owned()))
        .full(Block::Note(note))
        .with(before_and_after(file))
        .with(Block::Note(apart.to_owned()))
        .folded(format!(
            "{}: raw mean, calibrated, error left out",
            file.poses.len()
        ))
}

/// Errors of the fitted poses by the nominal scale, if that is known, and with the calibration. Those of the faces along
/// their axis, which is the sensor's error, and off it, which is how the board lay.
fn before_and_after(file: &Calibration) -> Table {
    let a = &file.accelerometer;
    let fitted: Vec<&PoseResult> = file.poses.iter().filter(|p| p.fitted).collect();
    let rms = |errors: &[f64]| {
        let squares: f64 = errors.iter().map(|e| e * e).sum();
        (squares / errors.len() as f64).sqrt()
    };
    let cells = |values: Vec<[f64; 3]>| {
        let lengths: Vec<f64> = values.iter().map(|v| norm(v) - file.gravity_mps2).collect();
        let faces = fitted.iter().zip(&values);
        let faces = faces.filter(|(p, _)| p.kind == PoseKind::Face);
        let parts = faces.map(|(p, v)| {
            let up = unit(&p.expected);
            let off = norm(&cross(&up, v)).atan2(dot(&up, v));
            [dot(&up, v) - file.gravity_mps2, off.to_degrees()]
        });
        let (along, off): (Vec<f64>, Vec<f64>) = parts.map(|[a, o]| (a, o)).unzip();
        let both = |errors: &[f64], text: fn(f64) -> String| {
            let values = [rms(errors), largest(errors)];
            values.map(|v| Cell::maybe(Some(v).filter(|v| v.is_finite()), text))
        };
        let mg = |v: f64| fixed(milli_g(v), 2);
        let lengths = Cell::number(mg(rms(&lengths)));
        [lengths]
            .into_iter()
            .chain(both(&along, mg))
            .chain(both(&off, |v| fixed(v, 2)))
    };
    let before: Option<Vec<[f64; 3]>> = fitted.iter().map(|p| a.nominally(p.raw)).collect();
    let after = fitted.iter().map(|p| p.calibrated).collect();
    let caption = "Errors of the fitted poses; before: by the nominal scale";
    let table = Table::new(caption, ["", "‖a‖ − g: rms, mg"])
        .group("along the axis", ["rms, mg", "largest"])
        .group("off the axis", ["rms, °", "largest"]);
    let rows = before.map(|values| ("before", values));
    let rows = rows.into_iter().chain([("after", after)]);
    rows.fold(table, |table, (name, values)| {
        table.row(name, cells(values))
    })
}

fn temperature<'a>(file: &Calibration) -> Section<'a> {
    let poses = file.temperature_c.as_ref().map(|t| {
        Block::Paragraph(format!(
            "Temperature of the poses: {:.1} °C on average, from {:.1} to {:.1} °C.",
            t.mean, t.min, t.max
        ))
    });
    let section = Section::new("Temperature")
        .full(poses)
        .folded("range, drift");
    let Some(model) = &file.drift else {
        return section;
    };
    let note = model.any_corrected().then(|| {
        let reference_c = model.reference_c;
        Block::Paragraph(format!(
            "The drift is relative to {reference_c:.1} °C, the mean of the poses. Outside the measured range the value at its limit is used."
        ))
    });
    drift(section, model).with(note)
}

/// Method and uncertainty budget.
fn method<'a>(file: &Calibration) -> Section<'a> {
    let a = &file.accelerometer;
    let fit = file.reliability.fit.as_ref();
    let agrees = fit.and_then(|fit| {
        let (freedom, chi2) = (digits(fit.freedom, 3), digits(fit.chi2_per_freedom?, 2));
        let name = "χ² per degree of freedom";
        Some(format!(" {name} ({freedom} of them): {chi2}."))
    });
    let how = match a.method {
        Method::Joint => {
            "One fit of all poses: at a face pose the direction of gravity is known up to a tilt, whose size is estimated; at a free pose only the magnitude is used. Bias, scale, the angles between the axes and a nonlinear response are estimated with their covariance. The nonlinear response is shown and not corrected."
        }
        Method::Ferraris => {
            "Six faces in closed form (Ferraris, Grimaldi and Parvis 1995): the faces are assumed exact, so a tilted pose changes the parameters."
        }
        Method::Unknown => "The parameters are from another program; the method is unknown.",
    };
    let text = how.to_owned() + &agrees.unwrap_or_default();
    Section::new(HOW)
        .full(Block::Paragraph(text))
        .with(budget(file).map(Block::Table))
        .folded("method and uncertainty")
}

fn budget(file: &Calibration) -> Option<Table> {
    let budget = file.reliability.budget.as_ref()?;
    // Digits according to the combined uncertainty.
    let n = decimals_of(milli_g(budget.combined_mps2()), 2);
    let mg = |v: f64| fixed(COVERAGE * milli_g(v), n);
    let caption = "Error of ‖a‖, mean over all directions";
    let mut table = Table::new(
        caption,
        ["source", "± 95 %, mg", "share of the variance, %"],
    );
    let all = budget.combined_mps2().powi(2);
    for part in &budget.contributions {
        let share = part.norm_mps2.map_or(0.0, |v| 100.0 * v * v / all);
        let cells = [Cell::maybe(part.norm_mps2, mg), Cell::Share(share)];
        table = table.row(words(&part.source), cells);
    }
    let combined = [Cell::number(mg(budget.combined_mps2())), Cell::text("")];
    Some(table.row("together (root sum of squares)", combined))
}

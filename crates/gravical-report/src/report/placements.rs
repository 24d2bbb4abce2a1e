//! Report of the poses of a calibration and of the best next ones.

use crate::document::{Block, Cell, Column, Row, Section, Table};
use gravical::calibration_file::{CalibrationFile, FitErrors, Method, PoseKind, PoseResult};
use gravical::core::matrix3::norm;
use gravical::numfmt::{decimals_of, fixed, mg, milli_g, signed};
use gravical::poses::face::in_words;

/// Every pose before and after calibration, and the error statistics.
pub(super) fn placements<'a>(file: &CalibrationFile) -> Section<'a> {
    let a = &file.accelerometer;
    // The closed form has only errors of the vectors.
    let exact = a.method == Method::Ferraris;
    let raw = a.poses.iter().flat_map(|p| p.raw);
    let largest = raw.fold(0.0_f64, |m, v| m.max(v.abs()));
    let decimals = decimals_of(largest, 5).min(4);
    let rows = a.poses.iter();
    let table = Table::new("")
        .columns(["pose"])
        .columns(Column::axes(&format!("raw mean, {}", a.input_unit)))
        .columns(Column::axes("calibrated, m/s²"))
        .columns(exact.then_some("error, m/s²"))
        .columns(["‖a‖ − g, mg", "left out, mg", "tilt, °"])
        .rows(rows.map(|p| row(p, decimals, exact)));
    let error = if exact {
        "error: magnitude of calibrated − expected. "
    } else {
        ""
    };
    let section = Section::new("poses", "Poses").with(table).full(Block::note(format!(
        "{error}left out: ‖a‖ − g if this pose and those within 25° of it are not used in the fit. tilt: angle off the face.",
    )));
    if !a.poses.iter().any(|p| p.fitted) {
        return section;
    }
    let note = "The parameters were fitted to these poses: the errors are no measure of accuracy. Those of the vectors contain the tilt of the faces.";
    section.with(errors(file)).with(Block::note(note))
}

/// Errors of the fitted poses by the nominal scale and with the calibration.
fn errors(file: &CalibrationFile) -> Table {
    let a = &file.accelerometer;
    let row = |name: &str, value: &dyn Fn(&PoseResult) -> Option<[f64; 3]>| {
        let values = a.poses.iter().map(|p| Some((p, value(p)?)));
        let values: Vec<(&PoseResult, [f64; 3])> = values.collect::<Option<_>>()?;
        let fitted: Vec<_> = values.iter().filter(|(p, _)| p.fitted).collect();
        let off = |v: &[f64; 3]| norm(v) - file.gravity_mps2;
        let squares: f64 = fitted.iter().map(|(_, v)| off(v).powi(2)).sum();
        let rms = (squares / fitted.len() as f64).sqrt();
        let faces = values.iter().filter(|(p, _)| p.kind == PoseKind::Face);
        let errors = faces.map(|(p, v)| std::array::from_fn(|i| v[i] - p.expected[i]));
        let e = FitErrors::of(&errors.collect::<Vec<_>>()).map(|e| [e.rms, e.max, e.mean_norm]);
        let cells = [Cell::text(name), Cell::number(fixed(milli_g(rms), 2))];
        let e = (0..3).map(|i| Cell::maybe(e.map(|e| e[i]), |v| fixed(v, 5)));
        Some(Row::from(cells.into_iter().chain(e)))
    };
    let before = row("before", &|p| a.nominally(p.raw));
    let after = row("after", &|p| Some(p.calibrated));
    let vectors = ["RMS", "maximum", "mean norm"];
    let by = if before.is_some() {
        ", before: by the nominal scale"
    } else {
        ""
    };
    Table::new(format!("Errors at the fitted poses{by}"))
        .columns(["", "‖a‖ − g: RMS, mg"])
        .columns(Column::group("vectors of the faces, m/s²", vectors))
        .rows(before.into_iter().chain(after))
}

fn row(p: &PoseResult, decimals: usize, exact: bool) -> Row {
    let mg = |v: f64| signed(milli_g(v), 2);
    let label = format!("{}{}", p.label, if p.fitted { "" } else { " (not used)" });
    let mut cells = vec![Cell::Text(label)];
    cells.extend(Cell::axes(Some(p.raw), |_, v| fixed(v, decimals)));
    cells.extend(Cell::axes(Some(p.calibrated), |_, v| fixed(v, 3)));
    cells.extend(exact.then(|| Cell::number(fixed(p.error_norm, 4))));
    cells.extend([
        Cell::maybe(p.magnitude_error_mps2, mg),
        Cell::maybe(p.left_out_error_mps2, mg),
        Cell::maybe(p.tilt_deg, |v| fixed(v, 1)).plus_minus(p.tilt_sd_deg, 1),
    ]);
    cells.into()
}

/// The best next poses.
pub(super) fn next_poses<'a>(file: &CalibrationFile) -> Section<'a> {
    let a = &file.accelerometer;
    let section = Section::new("directions", "Directions");
    if a.proposed_poses().is_empty() {
        return section.full(Block::paragraph(
            "No further pose is proposed: none would improve the result by more than a fifth.",
        ));
    }
    let row = |name: &str, pose: String, error: Option<f64>, undetected: Option<f64>| {
        let errors = [Cell::maybe(error, mg), Cell::maybe(undetected, mg)];
        Row::named(name, [Cell::Text(pose)].into_iter().chain(errors))
    };
    let now = a.undetected.as_ref().map(|u| u.effect_mps2);
    let poses = (1..).zip(a.proposed_poses()).map(|(i, next)| {
        let (pose, error) = (in_words(next.direction), next.predicted_norm_error_mps2);
        row(
            &format!("{i}"),
            pose,
            Some(error),
            next.undetected_effect_mps2,
        )
    });
    let columns = [
        "",
        "orientation",
        "uncertainty of ‖a‖, mg",
        "undetected, mg",
    ];
    let table = Table::new("Best next poses, recorded in this order, and what is left after each")
        .columns(columns)
        .row(row("", "now".to_owned(), a.predicted_norm_error_mps2, now))
        .rows(poses);
    section.full(table).full(Block::note(
        "undetected: what an error of one pose could change without being detected; – without limit.",
    ))
}

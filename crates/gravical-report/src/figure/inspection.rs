//! Figures of what is in a recording.

use gravical::inspect::Inspection;
use gravical::numfmt::unit;
use gravical::recording::Recording;

use super::drawing::Figure;
use super::panel::{Axis, Panel, Role, Series, XYZ};

/// The recording with its rests and defects, and the time from row to row.
pub fn inspection(inspection: &Inspection, recording: &Recording) -> Vec<Figure> {
    let period_s = 1.0 / recording.working_rate_hz();
    let by_rate = || (0..recording.rows()).map(|i| period_s * i as f64).collect();
    let t_s: Vec<f64> = recording.time_s.clone().unwrap_or_else(by_rate);
    let rests = inspection.static_intervals.iter();
    let rests = rests.filter_map(|s| Some([*t_s.get(s.start_row)?, *t_s.get(s.end_row - 1)?]));
    let rests = Series::shade("at rest", Role::Rest, &rests.collect::<Vec<_>>());
    let defects = recording
        .breaks
        .iter()
        .filter_map(|row| t_s.get(*row).copied());
    let defects = Series::ticks("parted or missing", Role::Bad, defects);
    let x = || Axis::over("time, s", "t = {} s", t_s.iter().copied(), 0.0);
    let panel = |name: &str, of: &[Vec<f64>; 3], in_unit: &str| {
        let line = |axis: usize| {
            let points = t_s.iter().copied().zip(of[axis].iter().copied());
            Series::line(
                XYZ[axis],
                Role::Axis(axis),
                points.map(<[f64; 2]>::from),
                &recording.breaks,
            )
        };
        let series = [rests.clone()]
            .into_iter()
            .chain([0, 1, 2].map(line))
            .chain([defects.clone()]);
        let y = Axis::over("", "", of.iter().flatten().copied(), 0.06);
        Panel {
            height_rem: 10.0,
            ..Panel::new(name, &unit(in_unit), [x(), y], series).linked("rec")
        }
    };
    let accel = panel(
        "Accelerometer",
        &recording.accel,
        recording.units.accel.unit.name(),
    );
    let gyro = recording.gyro.as_ref().map(|gyro| {
        let known = inspection.gyroscope.as_ref().map(|g| g.unit.name());
        panel("Gyroscope", gyro, known.unwrap_or("unknown"))
    });
    let panels = [accel].into_iter().chain(gyro);
    let recorded = Figure::new("recording", "Recording", "", panels);
    let steps = recording.time_s.is_some().then(|| {
        let steps = t_s.windows(2).map(|t| [t[1], 1e3 * (t[1] - t[0])]);
        let steps: Vec<[f64; 2]> = steps.collect();
        let y = Axis::over("", "", steps.iter().map(|s| s[1]).chain([0.0]), 0.06);
        let series = [Series::line("step", Role::Result, steps, &[])];
        let panel = Panel::new("Time from row to row", "ms", [x(), y], series);
        Figure::new(
            "steps",
            "Time from row to row",
            "",
            [panel.linked("rec").alone()],
        )
    });
    let has_rows = recording.rows() > 1;
    [Some(recorded), steps]
        .into_iter()
        .flatten()
        .filter(|_| has_rows)
        .collect()
}

//! Figures of a motion.

use std::f64::consts::PI;

use gravical::motion::{Motion, MotionSample, SampleState};

use super::panel::{Axis, Figure, Panel, Role, Series, XYZ};
use super::svg::extent;

/// All figures that a result allows. Where nothing moved there is the acceleration; what is not
/// known is left out.
pub fn figures(motion: &Motion) -> Vec<Figure> {
    let (result, is_calibrated) = (
        &motion.result,
        motion.result.computation.calibration.is_some(),
    );
    let samples: Vec<MotionSample> = motion.samples().collect();
    let uncalibrated = motion.uncalibrated_states();
    let uncalibrated = uncalibrated.map(Iterator::collect::<Vec<SampleState>>);
    let t_s: Vec<f64> = samples.iter().map(|s| s.t_s).collect();
    let breaks: Vec<usize> = motion.breaks().collect();
    let path = |name: &'static str, role: Role, values: Vec<[f64; 3]>| Path {
        name,
        role,
        t_s: &t_s,
        breaks: &breaks,
        values,
    };
    let name = if is_calibrated {
        "calibrated"
    } else {
        "without a calibration"
    };
    let of_samples = |name: &'static str, role: Role, vector: fn(&MotionSample) -> [f64; 3]| {
        path(name, role, samples.iter().map(vector).collect())
    };
    // Of the states: without the calibration, where there is one, and of the result.
    let of_states = |vector: fn(&SampleState) -> [f64; 3]| -> Vec<Path<'_>> {
        let plain = uncalibrated.iter().map(|states| {
            let values = states.iter().map(vector).collect();
            path("uncalibrated", Role::Raw, values)
        });
        let values = samples.iter().map(|s| vector(&s.state)).collect();
        plain.chain([path(name, Role::Result, values)]).collect()
    };
    let rests = result
        .computation
        .rests
        .iter()
        .map(|s| [s.start_s, s.end_s]);
    let rests = Series::intervals("at rest", &rests.collect::<Vec<_>>());

    let mut forces = vec![of_samples(name, Role::Result, |s| s.force_mps2)];
    if is_calibrated {
        forces.insert(0, of_samples("raw", Role::Raw, |s| s.raw_mps2));
    }
    let caption = "Specific force in sensor axes, including gravity. Rests are shaded.";
    let names = ["acceleration", "Acceleration", "m/s²"];
    let acceleration = over_time(&rests, names, caption, &forces, None);
    if result.moves.is_empty() {
        return acceleration.into_iter().collect();
    }

    let banded = |title: &str, unit: &str, paths: &[Path<'_>], sigma: &[[f64; 3]]| {
        let name = title.to_lowercase();
        let caption = format!(
            "{title} in the frame of the result. The band, where it is known, is twice the predicted standard uncertainty; it is cut off where it is much wider than the motion."
        );
        over_time(&rests, [&name, title, unit], &caption, paths, Some(sigma))
    };
    let positions = of_states(|s| s.position_m);
    let sigma: Vec<[f64; 3]> = samples.iter().map(|s| s.state.position_sd_m).collect();
    let speed_sigma: Vec<[f64; 3]> = samples.iter().map(|s| s.state.velocity_sd_mps).collect();
    let velocities = of_states(|s| s.velocity_mps);
    let accelerations = of_samples(name, Role::Result, |s| s.state.acceleration_mps2);
    let frame = &result.computation.frame;
    let caption = format!("Acceleration without gravity, in the frame of the result ({frame}).");
    let names = ["motion-acceleration", "Acceleration of the motion", "m/s²"];
    let all = [
        banded("Position", "m", &positions, &sigma),
        trajectory(&positions, &sigma),
        banded("Velocity", "m/s", &velocities, &speed_sigma),
        acceleration,
        over_time(&rests, names, &caption, &[accelerations], None),
    ];
    all.into_iter().flatten().collect()
}

/// First and last that is known.
fn ends(vectors: &[[f64; 3]]) -> Option<[[f64; 3]; 2]> {
    let is_known = |v: &&[f64; 3]| v.iter().all(|v| v.is_finite());
    let first = vectors.iter().find(is_known)?;
    Some([*first, *vectors.iter().rfind(is_known)?])
}

/// Vectors over time under one name.
struct Path<'a> {
    name: &'static str,
    role: Role,
    t_s: &'a [f64],
    /// Rows before which others are missing.
    breaks: &'a [usize],
    values: Vec<[f64; 3]>,
}

impl Path<'_> {
    /// A line through the places that `point` gives for time and vector.
    fn line(&self, point: impl Fn(f64, [f64; 3]) -> [f64; 2]) -> Series {
        let points = self.t_s.iter().zip(&self.values);
        let points = points.map(|(t, v)| <(f64, f64)>::from(point(*t, *v)));
        Series::line(self.name, self.role, points).thinned(self.breaks)
    }

    /// A band of twice the uncertainty about one axis.
    fn band(&self, sigma: &[[f64; 3]], axis: usize) -> Series {
        let ends = self.values.iter().zip(sigma);
        let ends = ends.map(|(v, s)| (v[axis] - 2.0 * s[axis], v[axis] + 2.0 * s[axis]));
        let (low, high) = ends.unzip();
        let band = Series::band("± 2σ", self.role, self.t_s.to_vec(), low, high);
        band.thinned(self.breaks)
    }
}

/// A figure of a panel over time for each axis, with the rests shaded and a band of twice the
/// uncertainty of the result, where that is given; none where it shows nothing.
fn over_time(
    rests: &Series,
    [name, title, unit]: [&str; 3],
    caption: &str,
    paths: &[Path<'_>],
    sigma: Option<&[[f64; 3]]>,
) -> Option<Figure> {
    let panels = [0, 1, 2].map(|axis| {
        let lines = paths.iter().map(|p| p.line(|t, v| [t, v[axis]]));
        let lines: Vec<Series> = lines.collect();
        let result = paths.iter().filter(|p| p.role == Role::Result);
        let bands = result.filter_map(|p| Some(p.band(sigma?, axis)));
        // In view is what the lines reach, and one and a half times as much on either side:
        // bands that dwarf them would leave nothing else to see.
        let (low, high) = extent(lines.iter().flat_map(|s| &s.y).copied());
        let room = 1.5 * (high - low);
        let is_cut = sigma.is_some() && room > 0.0;
        let y = Axis {
            within: is_cut.then_some([low - room, high + room]),
            ..Axis::new("", unit)
        };
        let series = [rests.clone()].into_iter().chain(bands).chain(lines);
        Panel::new(XYZ[axis], Axis::new("time", "s"), y, series)
    });
    let mut lines = panels.iter().flat_map(|p| &p.series[1..]);
    let is_known = lines.any(Series::has_values);
    is_known.then(|| Figure::new(name, title, caption, panels))
}

/// The path in space: from above, and from the side where it reaches further; `sigma` of each sample.
fn trajectory(paths: &[Path<'_>], sigma: &[[f64; 3]]) -> Option<Figure> {
    let own = paths.iter().find(|p| p.role == Role::Result)?;
    let ([start, end], sigma) = (ends(&own.values)?, ends(sigma));
    // The uncalibrated path does not decide what is in view.
    let spans = [0, 1, 2].map(|axis| {
        let shown = paths.iter().filter(|p| p.role != Role::Raw);
        let values = shown.flat_map(|p| &p.values).map(|v| v[axis]);
        extent(values.filter(|v| v.is_finite()))
    });
    let size = spans.map(|(low, high)| high - low);
    let room = 0.3 * size.into_iter().fold(0.0, f64::max);
    let side = if size[0] >= size[1] { [0, 2] } else { [1, 2] };
    let views = [("from above", [0, 1]), ("from the side", side)];
    let panels = views.map(|(title, plane)| {
        let flat = |v: [f64; 3]| plane.map(|axis| v[axis]);
        let [x, y] = plane.map(|axis: usize| Axis {
            within: (room > 0.0).then_some([spans[axis].0 - room, spans[axis].1 + room]),
            ..Axis::new(XYZ[axis], "m")
        });
        let area = sigma.map(|[_, sigma]| ellipse(flat(end), flat(sigma)));
        let lines = paths.iter().map(|p| p.line(|_, v| flat(v)));
        let spots = [("start", Role::Result, start), ("end", Role::Warning, end)];
        let spots =
            spots.map(|(name, role, v)| Series::points(name, role, [<(f64, f64)>::from(flat(v))]));
        let series = area.into_iter().chain(lines).chain(spots);
        Panel::new(title, x, y, series).equal()
    });
    let caption = "The path from above and from the side, equal scale on both axes. Circle: start, diamond: end, shaded: ± 1σ of the end. What reaches much further than the path is cut off.";
    Some(Figure::new("trajectory", "Trajectory", caption, panels).beside())
}

/// The area within one standard uncertainty of the end.
fn ellipse([x, y]: [f64; 2], [a, b]: [f64; 2]) -> Series {
    let turn = || (0..=72).map(|k| f64::sin_cos(PI * f64::from(k) / 72.0));
    let side = |b: f64| turn().map(|(sine, _)| y + b * sine).collect();
    let x = turn().map(|(_, cosine)| x - a * cosine).collect();
    Series::band("± 1σ at the end", Role::Result, x, side(-b), side(b))
}

//! The path in space, seen obliquely from above.

use super::{Motion, Path, ends, extents, is_known, longest, spot};
use crate::figure::panel::{Axis, Figure, Panel, Role, Series, XYZ};
use crate::figure::svg::{CIRCLE, DIAMOND, DOT, ticks};

/// Directions of x, y and z in the picture (a dimetric view).
const VIEW: [[f64; 2]; 3] = [[0.87, 0.38], [-0.87, 0.38], [0.0, 0.92]];

/// The uncalibrated path is shown up to this many times the size of the other.
const WITHIN: f64 = 3.0;

fn project(p: [f64; 3]) -> [f64; 2] {
    [0, 1].map(|k| (0..3).map(|i| p[i] * VIEW[i][k]).sum())
}

/// Position in space with time marked along the path.
pub(super) fn position_3d(motion: &Motion<'_>) -> Option<Figure> {
    let ground = Path {
        name: "on the ground",
        role: Role::Guide,
        ..motion.result(|s| s.state.position_m)
    };
    let size = longest(&extents(&ground.values)?);
    let mut paths = motion.positions();
    let near = |p: &Path<'_>| extents(&p.values).is_some_and(|e| longest(&e) <= WITHIN * size);
    paths.retain(|p| p.role != Role::Raw || near(p));
    let sides = sides(extents(paths.iter().flat_map(|p| &p.values))?)?;
    let mut series = frame(&sides);
    series.push(ground.line(|_, [x, y, _]| project([x, y, sides[2][0]])));
    series.extend(paths.iter().map(|p| p.line(|_, at| project(at))));
    series.push(time_marks(&ground, 0.03 * longest(&sides)));
    if let Some([start, end]) = ends(&ground.values) {
        series.push(spot("start", Role::Result, project(start), CIRCLE));
        series.push(spot("end", Role::Result, project(end), DIAMOND));
    }
    let [[x0, x1], [y0, y1], [z0, z1]] = sides;
    let room = 0.13 * longest(&sides);
    let x = [
        project([x0, y1, z0])[0] - room,
        project([x1, y0, z0])[0] + room,
    ];
    let y = [project([x0, y0, z0])[1] - room, project([x1, y1, z1])[1]];
    let aspect = ((y[1] - y[0]) / (x[1] - x[0])).clamp(0.5, 0.9);
    let mut panel = Panel::new("", Axis::hidden(x), Axis::hidden(y)).equal(aspect);
    panel.series = series;
    let caption =
        "The path in perspective from above, with its projection on the ground and time marks.";
    Some(Figure::new("position-3d", "Position in space", caption).with(panel))
}

/// A box around the path, no side shorter than a quarter of the longest; none for a path of no
/// length.
fn sides(around: [[f64; 2]; 3]) -> Option<[[f64; 2]; 3]> {
    let size = longest(&around);
    let widen = |[low, high]: [f64; 2]| {
        let lacking = (0.25 * size - (high - low)).max(0.0);
        [low - lacking / 2.0, high + lacking / 2.0]
    };
    (size > 0.0 && size.is_finite()).then(|| around.map(widen))
}

/// Floor and walls behind with lines at the ticks, which are numbered along the edges in front.
fn frame(sides: &[[f64; 2]; 3]) -> Vec<Series> {
    let [[x0, x1], [y0, y1], [z0, z1]] = *sides;
    let size = longest(sides);
    let line = |points: &[[f64; 3]]| {
        let (x, y) = points
            .iter()
            .map(|p| <(f64, f64)>::from(project(*p)))
            .unzip();
        Series::line("box", Role::Guide, x, y)
    };
    let mut series = vec![
        line(&[
            [x0, y0, z0],
            [x1, y0, z0],
            [x1, y1, z0],
            [x0, y1, z0],
            [x0, y0, z0],
        ]),
        line(&[
            [x1, y0, z0],
            [x1, y0, z1],
            [x1, y1, z1],
            [x0, y1, z1],
            [x0, y1, z0],
        ]),
        line(&[[x1, y1, z0], [x1, y1, z1]]),
    ];
    let (mut texts, mut labels) = (Vec::new(), Vec::new());
    let mut write = |at: [f64; 3], [right, up]: [f64; 2], label: String| {
        let [x, y] = project(at);
        texts.push((x + right * size, y + up * size));
        labels.push(label);
    };
    for (axis, [low, high]) in sides.iter().enumerate() {
        // One distance of ticks for all sides, as one unit is.
        let most = (5.0 * (high - low) / size).round().max(1.0) as usize;
        for (v, label) in ticks(*low, *high, most) {
            let (points, side) = match axis {
                0 => ([[v, y0, z0], [v, y1, z0], [v, y1, z1]], [0.045, -0.045]),
                1 => ([[x0, v, z0], [x1, v, z0], [x1, v, z1]], [-0.045, -0.045]),
                _ => ([[x0, y1, v], [x1, y1, v], [x1, y0, v]], [-0.054, 0.0]),
            };
            series.push(line(&points));
            write(points[0], side, label);
        }
    }
    let middle = |[low, high]: [f64; 2]| (low + high) / 2.0;
    let names = [
        ([middle(sides[0]), y0, z0], [0.11, -0.11]),
        ([x0, middle(sides[1]), z0], [-0.11, -0.11]),
        ([x0, y1, z1], [0.0, 0.055]),
    ];
    for ((at, side), (name, _)) in names.into_iter().zip(XYZ) {
        write(at, side, format!("{name}, m"));
    }
    let (x, y) = texts.into_iter().unzip();
    series.push(Series::points("axes", Role::Guide, x, y).labelled(labels));
    series
}

/// Dots at every tenth of the duration, where it has moved by `least` since the last one.
fn time_marks(path: &Path<'_>, least: f64) -> Series {
    let (t_s, position) = (path.t_s, &path.values);
    let (mut points, mut labels) = (Vec::new(), Vec::new());
    let mut last = ends(position).map(|[start, _]| start);
    let span = t_s.first().zip(t_s.last());
    for k in 1..10 {
        let Some((first, end)) = span else { break };
        let duration_s = end - first;
        let t = first + duration_s * f64::from(k) / 10.0;
        let row = t_s.partition_point(|s| *s < t);
        let Some(p) = position.get(row).filter(is_known) else {
            continue;
        };
        let moved = |l: [f64; 3]| (0..3).map(|i| (l[i] - p[i]).powi(2)).sum::<f64>().sqrt();
        if last.is_none_or(|l| moved(l) >= least) {
            points.push(<(f64, f64)>::from(project(*p)));
            // 3.25 s is 3.3 s, 120.4 s is 120 s.
            let decimals = usize::from(duration_s < 100.0) + usize::from(duration_s < 1.0);
            labels.push(format!("{t:.decimals$} s").replace('-', "−"));
            last = Some(*p);
        }
    }
    let (x, y) = points.into_iter().unzip();
    Series::points("time", Role::Result, x, y)
        .labelled(labels)
        .drawn_as(DOT)
}

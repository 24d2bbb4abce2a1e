//! The way in space, seen obliquely from above.

use crate::figure::svg::ticks::{label, ticks};
use crate::figure::thin::{self, Times};
use crate::figure::{Axis, Figure, Panel, Role, Series, Symbol};

use super::{AXES, Extent, Motion, ends, result_name, seconds, times};

/// Directions of x, y and z in the picture (a dimetric view).
const VIEW: [[f64; 2]; 3] = [[0.87, 0.38], [-0.87, 0.38], [0.0, 0.92]];

/// Sides of the box that are shorter than this share of the longest are widened.
const THIN: f64 = 0.25;

/// The uncalibrated way is shown up to this many times the size of the other.
const WITHIN: f64 = 3.0;

/// Marks of time along the way.
const MARKS: usize = 10;

fn project(p: &[f64; 3]) -> (f64, f64) {
    let along = |k: usize| (0..3).map(|i| p[i] * VIEW[i][k]).sum();
    (along(0), along(1))
}

/// Position in space with time marked along the way.
pub(super) fn position_3d(motion: &Motion<'_>) -> Option<Figure> {
    let track = &motion.track;
    let own = Extent::of(&track.position_m)?;
    let plain = track.uncalibrated.as_ref().map(|u| &u.position_m[..]);
    let plain = plain.filter(|p| {
        let size = Extent::of(*p).map_or(f64::INFINITY, |e| e.largest());
        size <= WITHIN * own.largest()
    });
    let reference = motion.reference;
    let others = [
        plain.and_then(Extent::of),
        reference.and_then(|r| Extent::of(&r.position_m)),
    ];
    let others = others.into_iter().flatten();
    let all = others.fold(own, |all, e| all.with(&e.low).with(&e.high));
    let frame = Frame::around(&all)?;
    let mut panel = frame.draw();
    let name = result_name(motion);
    let floor = frame.low[2];
    panel = panel.with(way("on the ground", Role::Guide, times(track), |i| {
        track.position_m.get(i).map(|p| [p[0], p[1], floor])
    }));
    if let Some(plain) = plain {
        let line = way("uncalibrated", Role::Raw, times(track), |i| {
            plain.get(i).copied()
        });
        panel = panel.with(line);
    }
    if let Some(r) = reference {
        let line = way("reference", Role::Reference, Times::from(&r.t_s), |i| {
            r.position_m.get(i).copied()
        });
        panel = panel.with(line);
    }
    let line = way(name, Role::Calibrated, times(track), |i| {
        track.position_m.get(i).copied()
    });
    panel = panel.with(line).with(marks(motion, &frame));
    if let Some((start, end)) = ends(&track.position_m) {
        let mark = |name: &str, p: &[f64; 3], symbol| {
            let (x, y) = project(p);
            Series::points(name, Role::Calibrated, vec![x], vec![y]).drawn_as(symbol)
        };
        panel = panel.with(mark("start", &start, Symbol::Circle)).with(mark(
            "end",
            &end,
            Symbol::Diamond,
        ));
    }
    let figure = Figure::new(
        "position-3d",
        "Position in space",
        "The path in perspective from above, with its projection on the ground and time marks.",
    );
    Some(figure.with(panel))
}

fn way(name: &str, role: Role, t: Times<'_>, at: impl Fn(usize) -> Option<[f64; 3]>) -> Series {
    thin::line(name, role, t, |i| {
        at(i).map_or((f64::NAN, f64::NAN), |p| project(&p))
    })
}

/// Dots at every tenth of the duration, where it has moved since the last one.
fn marks(motion: &Motion<'_>, frame: &Frame) -> Series {
    let track = &motion.track;
    let (mut x, mut y, mut labels) = (Vec::new(), Vec::new(), Vec::new());
    let span = track.t_s.first().zip(track.t_s.last());
    let mut last = ends(&track.position_m).map(|e| e.0);
    for k in 1..MARKS {
        let Some((first, end)) = span else { break };
        let t = first + (end - first) * k as f64 / MARKS as f64;
        let i = track.t_s.partition_point(|s| *s < t);
        let Some(p) = track
            .position_m
            .get(i)
            .filter(|p| p.iter().all(|v| v.is_finite()))
        else {
            continue;
        };
        let near = last.is_some_and(|l| {
            let moved = (0..3).map(|i| (l[i] - p[i]).powi(2)).sum::<f64>().sqrt();
            moved < 0.03 * frame.longest()
        });
        if !near {
            let at = project(p);
            x.push(at.0);
            y.push(at.1);
            labels.push(seconds(t, end - first));
            last = Some(*p);
        }
    }
    Series::points("time", Role::Calibrated, x, y)
        .labelled(labels)
        .drawn_as(Symbol::Dot)
}

/// The box around the way, its sides at ticks.
struct Frame {
    low: [f64; 3],
    high: [f64; 3],
    ticks: [(Vec<f64>, usize); 3],
}

impl Frame {
    /// None for a way of no length.
    fn around(extent: &Extent) -> Option<Self> {
        let longest = extent.largest();
        if !(longest > 0.0 && longest.is_finite()) {
            return None;
        }
        let mut frame = Frame {
            low: extent.low,
            high: extent.high,
            ticks: Default::default(),
        };
        for i in 0..3 {
            let lacking = THIN * longest - (extent.high[i] - extent.low[i]);
            if lacking > 0.0 {
                frame.low[i] -= lacking / 2.0;
                frame.high[i] += lacking / 2.0;
            }
            // One distance of ticks for all sides, as one unit is.
            let most = (5.0 * (frame.high[i] - frame.low[i]) / longest).round();
            let (values, decimals) = ticks(frame.low[i], frame.high[i], most.max(1.0) as usize);
            frame.ticks[i] = (values, decimals);
        }
        Some(frame)
    }

    fn longest(&self) -> f64 {
        (0..3)
            .map(|i| self.high[i] - self.low[i])
            .fold(0.0, f64::max)
    }

    fn draw(&self) -> Panel {
        let [l, h] = [self.low, self.high];
        let line = |points: &[[f64; 3]]| {
            let (x, y) = points.iter().map(project).unzip();
            Series::line("box", Role::Guide, x, y)
        };
        let mut all = vec![
            // The floor, then the walls behind.
            line(&[
                [l[0], l[1], l[2]],
                [h[0], l[1], l[2]],
                [h[0], h[1], l[2]],
                [l[0], h[1], l[2]],
                [l[0], l[1], l[2]],
            ]),
            line(&[
                [h[0], l[1], l[2]],
                [h[0], l[1], h[2]],
                [h[0], h[1], h[2]],
                [l[0], h[1], h[2]],
                [l[0], h[1], l[2]],
            ]),
            line(&[[h[0], h[1], l[2]], [h[0], h[1], h[2]]]),
        ];
        for &x in &self.ticks[0].0 {
            all.push(line(&[[x, l[1], l[2]], [x, h[1], l[2]], [x, h[1], h[2]]]));
        }
        for &y in &self.ticks[1].0 {
            all.push(line(&[[l[0], y, l[2]], [h[0], y, l[2]], [h[0], y, h[2]]]));
        }
        for &z in &self.ticks[2].0 {
            all.push(line(&[[l[0], h[1], z], [h[0], h[1], z], [h[0], l[1], z]]));
        }
        all.extend([self.names(), self.numbers()]);
        let (lowest, highest) = (project(&[l[0], l[1], l[2]]), project(&h));
        let (left, right) = (project(&[l[0], h[1], l[2]]), project(&[h[0], l[1], l[2]]));
        let room = 0.13 * self.longest();
        let x = [left.0 - room, right.0 + room];
        let y = [lowest.1 - room, highest.1];
        let aspect = (y[1] - y[0]) / (x[1] - x[0]);
        let panel = Panel::new(Axis::hidden().including(&x), Axis::hidden().including(&y))
            .equal(aspect.clamp(0.5, 0.9));
        all.into_iter().fold(panel, Panel::with)
    }

    /// Values of the ticks along the edges in front and on the left.
    fn numbers(&self) -> Series {
        let [l, h] = [self.low, self.high];
        let off = 0.045 * self.longest();
        let (mut x, mut y, mut labels) = (Vec::new(), Vec::new(), Vec::new());
        for (axis, (values, decimals)) in self.ticks.iter().enumerate() {
            for &v in values {
                let (p, side) = match axis {
                    0 => ([v, l[1], l[2]], [off, -off]),
                    1 => ([l[0], v, l[2]], [-off, -off]),
                    _ => ([l[0], h[1], v], [-1.2 * off, 0.0]),
                };
                let at = project(&p);
                x.push(at.0 + side[0]);
                y.push(at.1 + side[1]);
                labels.push(label(v, *decimals));
            }
        }
        Series::points("numbers", Role::Guide, x, y).labelled(labels)
    }

    fn names(&self) -> Series {
        let [l, h] = [self.low, self.high];
        let off = 0.11 * self.longest();
        let middle = |i: usize| (l[i] + h[i]) / 2.0;
        let places = [
            (project(&[middle(0), l[1], l[2]]), [off, -off]),
            (project(&[l[0], middle(1), l[2]]), [-off, -off]),
            (project(&[l[0], h[1], h[2]]), [0.0, 0.5 * off]),
        ];
        let x = places.iter().map(|(p, side)| p.0 + side[0]).collect();
        let y = places.iter().map(|(p, side)| p.1 + side[1]).collect();
        let labels = AXES.iter().map(|a| format!("{a}, m")).collect();
        Series::points("axes", Role::Guide, x, y).labelled(labels)
    }
}

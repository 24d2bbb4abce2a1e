//! The placements as directions on a sphere, in Lambert's equal-area projection
//! (J. H. Lambert 1772; Snyder, Map Projections, 1987, ch. 24).

use std::f64::consts::PI;

use crate::figure::{Axis, Figure, Panel, Role, Series, Symbol};
use gravical::calibration_file::{CalibrationFile, PoseResult};

use super::norm_of;

/// Points of a circle.
const FINE: usize = 96;

/// One half of the sphere, as seen from outside: +1 from +z, −1 from −z.
#[derive(Clone, Copy)]
struct Half(f64);

impl Half {
    /// Where a unit vector lies in the disc of radius 1; its rim is the equator.
    fn place(self, d: [f64; 3]) -> (f64, f64) {
        let k = 1.0 / (1.0 + (self.0 * d[2]).max(0.0)).sqrt();
        // From below x runs to the left where y runs up.
        (self.0 * d[0] * k, d[1] * k)
    }

    fn has(self, d: [f64; 3]) -> bool {
        (d[2] >= 0.0) == (self.0 > 0.0)
    }
}

/// Where the placements point, and where the next ones would help.
pub(super) fn sphere(file: &CalibrationFile) -> Option<Figure> {
    let poses = &file.accelerometer.poses;
    if poses.is_empty() {
        return None;
    }
    let next = !file.accelerometer.proposed_poses().is_empty();
    let caption = format!(
        "Direction of specific force (up, in sensor axes) at each pose: two hemispheres in equal-area projection, circles at 30° and 60°.{}",
        if next {
            " The best next pose is labelled next."
        } else {
            ""
        }
    );
    let figure = Figure::new("sphere", "Poses on the sphere", caption)
        .beside()
        .with(disc(file, Half(1.0), "seen from +z"))
        .with(disc(file, Half(-1.0), "seen from −z"));
    Some(figure)
}

fn disc(file: &CalibrationFile, half: Half, title: &str) -> Panel {
    let rim = [-1.14, 1.14];
    let mut panel = Panel::new(
        Axis::hidden().including(&rim),
        Axis::hidden().including(&rim),
    )
    .titled(title)
    .equal(1.0);
    for line in graticule(half) {
        panel = panel.with(line);
    }
    let sides = [
        ("+x", half.0, 0.0),
        ("−x", -half.0, 0.0),
        ("+y", 0.0, 1.0),
        ("−y", 0.0, -1.0),
    ];
    let a = &file.accelerometer;
    // Where a placement of that name lies at the rim, its own label will do.
    let named = |side: &&(&str, f64, f64)| {
        let own = a
            .poses
            .iter()
            .filter(|p| p.label.replace('-', "−") == side.0);
        own.map(|p| unit(p.calibrated)).any(|d| half.has(d))
    };
    let sides: Vec<_> = sides.iter().filter(|s| !named(s)).collect();
    let axes = Series::points(
        "axes",
        Role::Guide,
        sides.iter().map(|s| 1.1 * s.1).collect(),
        sides.iter().map(|s| 1.1 * s.2).collect(),
    );
    panel = panel.with(axes.labelled(sides.iter().map(|s| s.0.to_owned()).collect()));
    let of = |name: &str, role, chosen: &dyn Fn(&&PoseResult) -> bool| {
        let own = a.poses.iter().filter(chosen);
        let all: Vec<_> = own.map(|p| (unit(p.calibrated), p.label.clone())).collect();
        points(name, role, half, all)
    };
    let next = a.proposed_poses().iter().enumerate().map(|(i, pose)| {
        let label = match i {
            0 => "next".to_owned(),
            _ => format!("next but {i}"),
        };
        (pose.direction, label)
    });
    let next = points("would help", Role::Warning, half, next.collect());
    let series = [
        of("pose", Role::Calibrated, &|p| p.fitted),
        of("not in the fit", Role::Bad, &|p| !p.fitted),
        next.drawn_as(Symbol::Diamond),
    ];
    // An entry of the legend without a point in either disc would be a riddle.
    series
        .into_iter()
        .filter(|s| !s.x.is_empty())
        .fold(panel, Panel::with)
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    let norm = norm_of(v).max(f64::MIN_POSITIVE);
    v.map(|c| c / norm)
}

fn points(name: &str, role: Role, half: Half, all: Vec<([f64; 3], String)>) -> Series {
    let own = all.into_iter().filter(|(d, _)| half.has(*d));
    let (places, labels): (Vec<_>, Vec<_>) = own.map(|(d, l)| (half.place(d), l)).unzip();
    let (x, y) = places.into_iter().unzip();
    Series::points(name, role, x, y).labelled(labels)
}

/// The rim, circles at 30° and 60° from the pole, and a meridian each 30°.
fn graticule(half: Half) -> Vec<Series> {
    let line = |name: &str, points: Vec<[f64; 3]>| {
        let (x, y) = points.into_iter().map(|d| half.place(d)).unzip();
        Series::line(name, Role::Guide, x, y)
    };
    let circle = |off_deg: f64| -> Vec<[f64; 3]> {
        let (sine, cosine) = off_deg.to_radians().sin_cos();
        let turn = (0..=FINE).map(|i| 2.0 * PI * i as f64 / FINE as f64);
        turn.map(|a| [sine * a.cos(), sine * a.sin(), half.0 * cosine])
            .collect()
    };
    let meridians = (0..6).map(|k| {
        let (sine, cosine) = (f64::from(k) * PI / 6.0).sin_cos();
        let across = [-1.0, 0.0, 1.0];
        let ends = across.map(|s: f64| [s * cosine, s * sine, half.0 * (1.0 - s.abs())]);
        line("meridian", ends.to_vec())
    });
    let circles = [30.0, 60.0, 90.0].map(|off| line("graticule", circle(off)));
    circles.into_iter().chain(meridians).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_stay_as_they_are() {
        // A cap of angle θ has 1 − cos θ of the half's area: r² in a disc of 1.
        for off_deg in [10.0_f64, 45.0, 90.0] {
            let (sine, cosine) = off_deg.to_radians().sin_cos();
            let (x, y) = Half(1.0).place([sine, 0.0, cosine]);
            assert!((x * x + y * y - (1.0 - cosine)).abs() < 1e-12);
        }
        assert_eq!(Half(-1.0).place([0.6, 0.0, -0.8]).0, -0.6 / 1.8_f64.sqrt());
    }
}

//! Drawings in space: directions on a sphere, a path with its shadow, a board. The script turns them.

use std::f64::consts::TAU;

use maud::{Markup, PreEscaped, html};

use super::panel::{Role, Series, XYZ, extent, straightened};

/// What is drawn in space, projected from a view; the script projects it anew.
#[derive(Debug, Clone, PartialEq)]
pub struct Space {
    /// What stands behind the legend, such as the side of a square; empty for nothing.
    pub note: String,
    /// The legend.
    pub(super) keys: Vec<Series>,
    markup: String,
}

impl Space {
    pub(super) fn markup(&self) -> Markup {
        PreEscaped(self.markup.clone())
    }
}

/// Orthographic, from this azimuth and elevation in degrees.
#[derive(Clone, Copy)]
struct View {
    azimuth_deg: f64,
    elevation_deg: f64,
}

const SPHERE: View = View {
    azimuth_deg: 28.0,
    elevation_deg: 18.0,
};
const TRACK: View = View {
    azimuth_deg: -38.0,
    elevation_deg: 20.0,
};

impl View {
    /// Right, down, towards the eye.
    fn project(self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let (sa, ca) = self.azimuth_deg.to_radians().sin_cos();
        let (se, ce) = self.elevation_deg.to_radians().sin_cos();
        let depth = x * ca + y * sa;
        [y * ca - x * sa, depth * se - z * ce, depth * ce + z * se]
    }

    /// The view box that holds these points, with room for texts.
    fn around<'p>(self, points: impl Iterator<Item = &'p [f64; 3]> + Clone) -> String {
        let [[left, right], [top, bottom]] =
            [0, 1].map(|k| extent(points.clone().map(|p| self.project(*p)[k])));
        let (wide, high) = (right - left + 32.0, bottom - top + 24.0);
        format!("{:.0} {:.0} {wide:.0} {high:.0}", left - 16.0, top - 12.0)
    }

    fn path(self, class: &str, points: &[[f64; 3]], times: Option<String>) -> Markup {
        let places = points.iter().map(|p| self.project(*p));
        let places = places.map(|[x, y, _]| format!("{x:.1} {y:.1}"));
        let d = "M".to_owned() + &places.collect::<Vec<_>>().join("L");
        html! { path class=(class) data-p=(listed(points)) data-t=[times] d=(d) {} }
    }

    fn placed(self, class: &str, point: [f64; 3], content: &Markup) -> Markup {
        let [x, y, _] = self.project(point);
        let at = format!("translate({x:.1} {y:.1})");
        html! { g class=(class) data-p=(listed(&[point])) transform=(at) { (content) } }
    }

    fn arms(self, origin: [f64; 3], from: f64, to: f64) -> Markup {
        html! {
            @for (k, name) in XYZ.into_iter().enumerate() {
                @let along = |length: f64| std::array::from_fn(|i| origin[i] + if i == k { length } else { 0.0 });
                @let class = format!("arm {name}");
                (self.path(&class, &[along(from), along(to)], None))
                (self.placed("", along(to + 6.0), &html! { text class=(class) text-anchor="middle" dy=".35em" { (name) } }))
            }
        }
    }

    fn svg(self, class: &str, view_box: &str, label: &str, content: &Markup) -> String {
        let view = format!("{} {}", self.azimuth_deg, self.elevation_deg);
        let class = format!("solid {class}");
        let link = (class == "solid ").then_some("t");
        html! {
            svg class=(class.trim_end()) viewBox=(view_box) role="img" aria-label=(label) data-link=[link] data-view=(view) {
                (content)
            }
        }
        .into_string()
    }
}

fn listed(points: &[[f64; 3]]) -> String {
    let numbers = points.as_flattened().iter();
    let numbers = numbers.map(|v| format!("{}", (v * 10.0).round() / 10.0 + 0.0));
    numbers.collect::<Vec<_>>().join(" ")
}

/// A direction on the sphere.
pub(super) struct Direction {
    pub unit: [f64; 3],
    pub title: String,
    pub role: Role,
}

/// Directions on a sphere, by the names of their roles; those that warn are diamonds with their title.
pub(super) fn sphere(directions: &[Direction], names: &[(&str, Role)]) -> Space {
    const RADIUS: f64 = 70.0;
    let view = SPHERE;
    let ring = |f: fn(f64) -> [f64; 3]| {
        let points = (0..=48).map(|i| f(TAU * f64::from(i) / 48.0).map(|v| v * RADIUS));
        view.path("ring", &points.collect::<Vec<_>>(), None)
    };
    let dot = |d: &Direction| {
        let hidden = view.project(d.unit)[2] < -0.1;
        let class = format!(
            "dot {}{}",
            d.role.class(),
            if hidden { " back" } else { "" }
        );
        let proposed = d.role == Role::Warning;
        let content = html! {
            @if proposed {
                path d="M0-4.6 4.6 0 0 4.6-4.6 0z" {}
                text x="7" dy=".35em" { (d.title) }
            } @else {
                circle r="3.4" {}
            }
            title { (d.title) }
        };
        view.placed(&class, d.unit.map(|v| v * RADIUS), &content)
    };
    let content = html! {
        circle.ball r=(RADIUS) {}
        (ring(|t| [t.cos(), t.sin(), 0.0]))
        (ring(|t| [t.cos(), 0.0, t.sin()]))
        (ring(|t| [0.0, t.cos(), t.sin()]))
        (view.arms([0.0; 3], RADIUS, RADIUS + 13.0))
        @for d in directions { (dot(d)) }
    };
    let has = |role: Role| directions.iter().any(|d| d.role == role);
    let keys = names.iter().filter(|(_, role)| has(*role));
    Space {
        note: String::new(),
        keys: keys
            .map(|(name, role)| Series::points(name, *role, [[0.0, 0.0]]))
            .collect(),
        markup: view.svg(
            "sphere",
            "-100 -93 200 186",
            "Directions on a sphere",
            &content,
        ),
    }
}

/// A path in space with its shadow on a floor of squares; lengths in m. `plain`: the same without the calibration;
/// `end_95`: how well its end is known, none where that is the last place that is known.
pub(super) fn track(
    t_s: &[f64],
    path: &[[f64; 3]],
    plain: &[[f64; 3]],
    end_95: Option<[f64; 3]>,
) -> Option<Space> {
    let view = TRACK;
    let is_known = |p: &[f64; 3]| p.iter().all(|v| v.is_finite());
    let rows = t_s.iter().zip(path).skip_while(|(_, p)| !is_known(p));
    // What follows a gap is not joined to it.
    let rows = rows.take_while(|(_, p)| is_known(p));
    let rows: Vec<[f64; 4]> = rows.map(|(t, [x, y, z])| [*t, *x, *y, *z]).collect();
    let spans: [[f64; 2]; 3] = std::array::from_fn(|k| extent(rows.iter().map(|row| row[k + 1])));
    let size = spans.map(|[low, high]| high - low);
    let long = size.iter().map(|s| s * s).sum::<f64>().sqrt();
    if !(long > 0.0 && long.is_finite()) {
        return None;
    }
    let rows = thinned(&rows, long);
    let scale = 140.0 / long;
    let middle = spans.map(|[low, high]| 0.5 * (low + high));
    let to = |p: [f64; 3]| -> [f64; 3] { std::array::from_fn(|k| (p[k] - middle[k]) * scale) };
    let raw = size.into_iter().fold(1e-9, f64::max) / 5.0;
    let power = 10_f64.powf(raw.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|m| m * power);
    let step = steps.into_iter().find(|s| *s >= raw).unwrap_or(raw);
    let (cell, floor) = (step * scale, -size[2] * scale / 2.0 - 6.0);
    let half = [0, 1].map(|k| (size[k] * scale / cell / 2.0).ceil().max(1.0));
    let lines = |n: f64| (-n as i32..=n as i32).map(move |i| f64::from(i) * cell);
    let [nx, ny] = half.map(|n| n * cell);
    let points: Vec<[f64; 3]> = rows.iter().map(|[_, x, y, z]| to([*x, *y, *z])).collect();
    let shadow: Vec<[f64; 3]> = points.iter().map(|p| [p[0], p[1], floor]).collect();
    // What reaches far beyond the path is cut off.
    let plain = plain.iter().copied().filter(is_known).map(to);
    let plain = plain.take_while(|p| p.iter().all(|v| v.abs() < 110.0));
    let plain: Vec<[f64; 4]> = plain
        .enumerate()
        .map(|(i, [x, y, z])| [i as f64, x, y, z])
        .collect();
    let plain: Vec<[f64; 3]> = thinned(&plain, 140.0)
        .iter()
        .map(|[_, x, y, z]| [*x, *y, *z])
        .collect();
    let (first, last) = (t_s.first()?, t_s.last()?);
    let times = rows
        .iter()
        .map(|row| format!("{:.0}", 1e4 * (row[0] - first) / (last - first)));
    let (start, end) = (*points.first()?, *points.last()?);
    let bar = |k: usize| {
        let half = (end_95.unwrap_or_default()[k] * scale).min(70.0);
        [-half, half].map(|by| std::array::from_fn(|i| end[i] + if i == k { by } else { 0.0 }))
    };
    let dot = |class: &str, at, name: &str, x: i32| {
        let anchor = if x < 0 { "end" } else { "start" };
        let text =
            html! { circle r="3.2" {} text x=(x) dy=".35em" text-anchor=(anchor) { (name) } };
        view.placed(class, at, &text)
    };
    let barred = end_95.is_some();
    let last = if barred { "end" } else { "last known" };
    let corners = [
        [-nx, -ny, floor],
        [-nx, ny, floor],
        [nx, -ny, floor],
        [nx, ny, floor],
    ];
    let arm = [-nx, -ny, floor + cell + 6.0];
    let seen = points.iter().chain(&plain).chain(&corners).chain([&arm]);
    let content = html! {
        @for a in lines(half[0]) { (view.path("ring", &[[a, -ny, floor], [a, ny, floor]], None)) }
        @for a in lines(half[1]) { (view.path("ring", &[[-nx, a, floor], [nx, a, floor]], None)) }
        (view.arms([-nx, -ny, floor], 0.0, cell))
        (view.path("shadow", &shadow, None))
        @if plain.len() > 1 { (view.path("line raw", &plain, None)) }
        (view.path("line result", &points, Some(times.collect::<Vec<_>>().join(" "))))
        @if barred { @for k in 0..3 { (view.path("bars warn", &bar(k), None)) } }
        (dot("dot result hollow", start, "start", -5))
        (dot("dot result", end, last, 5))
        circle.now r="2.6" cx="9999" {}
    };
    let key = |name: &str, role| Series::line(name, role, [[0.0, 0.0]], &[]);
    let keys = [
        Some(key("path", Role::Result)),
        (plain.len() > 1).then(|| key("uncalibrated", Role::Raw)),
        barred.then(|| Series::in_rows("end ± 95 %", Role::Warning, [[0.0, 1.0]])),
    ];
    Some(Space {
        note: format!("squares of {step} m"),
        keys: keys.into_iter().flatten().collect(),
        markup: view.svg("", &view.around(seen), "Path in space", &content),
    })
}

/// The rows that a path of this length needs.
fn thinned(rows: &[[f64; 4]], long: f64) -> Vec<[f64; 4]> {
    const MOST: usize = 20_000;
    let step = rows.len().div_ceil(MOST).max(1);
    let last = rows.len().saturating_sub(1);
    let some: Vec<usize> = (0..rows.len())
        .filter(|i| i % step == 0 || *i == last)
        .collect();
    if some.is_empty() {
        return Vec::new();
    }
    let spans = [1.0, 2.0 * long, 2.0 * long, 2.0 * long];
    straightened(rows, &some, &spans)
        .into_iter()
        .map(|i| rows[i])
        .collect()
}

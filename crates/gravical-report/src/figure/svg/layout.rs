//! Where panels stand and what part of the axes they show.

use super::super::{Axis, Figure, Mark, Panel, Role, Scale, Series};
use super::ticks;

/// Width of a whole figure, and of a panel that stands beside others.
pub(super) const WIDTH: f64 = 760.0;
pub(super) const HALF: f64 = 372.0;
/// Size of text.
pub(super) const TEXT: f64 = 12.0;
/// Largest number that is drawn: the difference of two must not overflow.
const LARGEST: f64 = 1e300;

/// A rectangle of the drawing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rect {
    pub x: f64,
    pub y: f64,
    pub w: f64,
    pub h: f64,
}

/// What part of the axes a plot shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct View {
    pub x: [f64; 2],
    pub y: [f64; 2],
}

/// Units of the axes → dots of the plot, which y runs down in.
pub(super) struct Map {
    pub r: Rect,
    pub v: View,
}

impl Map {
    pub fn x(&self, x: f64) -> f64 {
        (x - self.v.x[0]) / (self.v.x[1] - self.v.x[0]) * self.r.w
    }

    pub fn y(&self, y: f64) -> f64 {
        self.r.h - (y - self.v.y[0]) / (self.v.y[1] - self.v.y[0]) * self.r.h
    }

    pub fn point(&self, x: f64, y: f64) -> Option<(f64, f64)> {
        let p = (self.x(x), self.y(y));
        (p.0.is_finite() && p.1.is_finite()).then_some(p)
    }
}

/// A panel with its place.
pub(super) struct Placed<'a> {
    pub panel: &'a Panel,
    pub plot: Rect,
    pub view: View,
    /// Its x axis carries labels.
    pub labelled: bool,
}

/// Width of a text, about: the mean of the usual fonts.
pub(super) fn width_of(text: &str) -> f64 {
    0.56 * TEXT * text.chars().count() as f64
}

/// Panels of one drawing, one below the other in `width` from `top` on, and the
/// height that this takes. With `titles` every panel leaves room for one, so that
/// panels that stand beside each other begin alike.
pub(super) fn place<'a>(
    panels: &[&'a Panel],
    width: f64,
    top: f64,
    titles: bool,
) -> (Vec<Placed<'a>>, f64) {
    let views = common_x(panels);
    let left = panels
        .iter()
        .zip(&views)
        .map(|(p, v)| left_margin(p, v))
        .fold(16.0, f64::max);
    // Half of the last tick's label may stand over the end.
    let right = if panels.iter().all(|p| matches!(p.x.scale, Scale::Hidden)) {
        16.0
    } else {
        22.0
    };
    let w = width - left - right;
    let mut y = top;
    let mut placed = Vec::new();
    for (i, (&panel, &view)) in panels.iter().zip(&views).enumerate() {
        if titles || !panel.title.is_empty() {
            y += 20.0;
        }
        let h = match panel.aspect {
            Some(aspect) => (w * aspect.clamp(0.1, 2.0)).round(),
            None if panels.len() > 1 => 130.0,
            None => 250.0,
        };
        let plot = Rect { x: left, y, w, h };
        let last = i + 1 == panels.len();
        y += h + if last { x_space(&panel.x, w) } else { 12.0 };
        let view = if panel.equal { equal(view, plot) } else { view };
        placed.push(Placed {
            panel,
            plot,
            view,
            labelled: last,
        });
    }
    (placed, y + 4.0)
}

/// Panels that stand over one x axis show the same part of it.
fn common_x(panels: &[&Panel]) -> Vec<View> {
    let mut views: Vec<View> = panels.iter().map(|p| view(p)).collect();
    if panels.len() > 1 {
        let from = views.iter().map(|v| v.x[0]).fold(f64::INFINITY, f64::min);
        let to = views
            .iter()
            .map(|v| v.x[1])
            .fold(f64::NEG_INFINITY, f64::max);
        for v in &mut views {
            v.x = [from, to];
        }
    }
    views
}

fn left_margin(panel: &Panel, view: &View) -> f64 {
    match &panel.y.scale {
        Scale::Hidden => 16.0,
        Scale::Names(names) => 34.0 + names.iter().map(|n| width_of(n)).fold(0.0, f64::max),
        Scale::Linear => {
            let (values, decimals) = ticks::ticks(view.y[0], view.y[1], 5);
            let widest = values
                .iter()
                .map(|v| width_of(&ticks::label(*v, decimals)))
                .fold(0.0, f64::max);
            34.0 + widest
        }
        Scale::Log => {
            let ticks = ticks::log_ticks(view.y[0], view.y[1], 5);
            let widths = ticks.iter().map(|(_, label)| width_of(label));
            34.0 + widths.fold(0.0, f64::max)
        }
    }
}

/// Names that are too long to stand side by side hang.
pub(super) fn names_hang(names: &[String], w: f64) -> bool {
    // Names of ticks are smaller than other text.
    let widest = 11.0 / TEXT * names.iter().map(|n| width_of(n)).fold(0.0, f64::max);
    widest + 6.0 > w / names.len().max(1) as f64
}

fn x_space(axis: &Axis, w: f64) -> f64 {
    match &axis.scale {
        Scale::Hidden => 8.0,
        Scale::Linear | Scale::Log => 38.0,
        Scale::Names(names) => {
            let label = if axis.text().is_empty() { 6.0 } else { 22.0 };
            if names_hang(names, w) {
                let longest = names.iter().map(|n| width_of(n)).fold(0.0, f64::max);
                14.0 + label + longest.min(160.0) * 0.8
            } else {
                18.0 + label
            }
        }
    }
}

/// What a panel has to show: all that is finite in its series.
fn view(panel: &Panel) -> View {
    let pad_x = match panel.x.scale {
        Scale::Names(_) => 0.0,
        _ if panel.equal => 0.06,
        _ if panel.series.iter().any(|s| matches!(s.mark, Mark::Points)) => 0.04,
        _ => 0.0,
    };
    let x = match &panel.x.scale {
        Scale::Names(names) => [-0.5, names.len().max(1) as f64 - 0.5],
        _ => {
            let spans = panel.stretches.iter().flat_map(|s| [s.from, s.to]);
            let series = panel.series.iter().flat_map(|s| s.x.iter().copied());
            range(
                series.chain(spans).chain(panel.x.include.iter().copied()),
                pad_x,
            )
        }
    };
    let y = match &panel.y.scale {
        Scale::Names(names) => [-0.5, names.len().max(1) as f64 - 0.5],
        _ => {
            let series = panel.series.iter().flat_map(|s| {
                let zero = matches!(s.mark, Mark::Columns).then_some(0.0);
                [&s.y, &s.low, &s.high]
                    .into_iter()
                    .flatten()
                    .copied()
                    .chain(zero)
            });
            range(series.chain(panel.y.include.iter().copied()), 0.06)
        }
    };
    let cut = |view: [f64; 2], within: Option<[f64; 2]>| match within {
        Some([low, high]) if low < high && low < view[1] && high > view[0] => {
            [view[0].max(low), view[1].min(high)]
        }
        _ => view,
    };
    View {
        x: cut(x, panel.x.within),
        y: cut(y, panel.y.within),
    }
}

/// From the smallest to the largest finite value, `pad` of the span wider.
fn range(values: impl Iterator<Item = f64>, pad: f64) -> [f64; 2] {
    let (mut from, mut to) = (f64::INFINITY, f64::NEG_INFINITY);
    for v in values.filter(|v| v.is_finite()) {
        let v = v.clamp(-LARGEST, LARGEST);
        from = from.min(v);
        to = to.max(v);
    }
    if from > to {
        return [0.0, 1.0];
    }
    // A constant stands in the middle; so does what differs by rounding only.
    if to - from <= 1e-12 * from.abs().max(to.abs()) {
        let half = if from == 0.0 { 1.0 } else { 0.05 * from.abs() };
        return [from - half, to + half];
    }
    let pad = pad * (to - from);
    [from - pad, to + pad]
}

/// Widened so that a unit is as long along y as along x.
fn equal(view: View, plot: Rect) -> View {
    let (w, h) = (view.x[1] - view.x[0], view.y[1] - view.y[0]);
    let unit = (w / plot.w).max(h / plot.h);
    let about = |v: [f64; 2], half: f64| {
        let middle = v[0] / 2.0 + v[1] / 2.0;
        [middle - half, middle + half]
    };
    View {
        x: about(view.x, unit * plot.w / 2.0),
        y: about(view.y, unit * plot.h / 2.0),
    }
}

/// Names in the legend, each once, with its series or stretch.
pub(super) enum Entry<'a> {
    /// With how many areas of its colour lie below it.
    Series(&'a Series, usize),
    Stretch(&'a str),
}

impl Entry<'_> {
    pub(super) fn name(&self) -> &str {
        match self {
            Entry::Series(s, _) => &s.name,
            Entry::Stretch(name) => name,
        }
    }
}

pub(super) fn legend(figure: &Figure) -> Vec<Entry<'_>> {
    let mut entries: Vec<Entry<'_>> = Vec::new();
    for panel in &figure.panels {
        let below = |own: &Series| {
            let before = panel.series.iter().take_while(|s| !std::ptr::eq(*s, own));
            let alike = |s: &&Series| s.mark == Mark::Band && s.role == own.role;
            before.filter(alike).count()
        };
        let series = panel.series.iter().filter(|s| s.role != Role::Guide);
        let stretches = panel.stretches.iter();
        let all = series
            .map(|s| Entry::Series(s, below(s)))
            .chain(stretches.map(|s| Entry::Stretch(&s.name)));
        for entry in all {
            if !entry.name().is_empty() && entries.iter().all(|e| e.name() != entry.name()) {
                entries.push(entry);
            }
        }
    }
    entries
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_of_odd_values() {
        assert_eq!(range([].into_iter(), 0.1), [0.0, 1.0]);
        assert_eq!(
            range([f64::NAN, f64::INFINITY].into_iter(), 0.1),
            [0.0, 1.0]
        );
        assert_eq!(range([3.0, 3.0].into_iter(), 0.1), [2.85, 3.15]);
        assert_eq!(range([0.0].into_iter(), 0.1), [-1.0, 1.0]);
        let wide = range([-f64::MAX, f64::MAX].into_iter(), 0.1);
        assert!((wide[1] - wide[0]).is_finite());
        assert_eq!(range([0.0, 10.0].into_iter(), 0.1), [-1.0, 11.0]);
    }

    #[test]
    fn equal_axes_only_widen() {
        let v = equal(
            View {
                x: [0.0, 1.0],
                y: [0.0, 10.0],
            },
            Rect {
                x: 0.0,
                y: 0.0,
                w: 200.0,
                h: 100.0,
            },
        );
        assert_eq!(
            v,
            View {
                x: [-9.5, 10.5],
                y: [0.0, 10.0]
            }
        );
    }
}

//! Where the labels of points stand so that none covers another.

use super::super::{Mark, Panel, Role, Scale};
use super::layout::{Map, Rect, View};

/// Labels of a panel that are placed at most; the others show on hovering.
const MOST: usize = 300;
/// Size of a label's text.
pub(super) const SIZE: f64 = 11.0;

/// A label relative to its point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Place {
    pub x: f64,
    pub y: f64,
    pub anchor: &'static str,
}

/// Within so many dots the same label is not written twice.
const REPEAT: f64 = 40.0;

/// A box in dots of the plot: left, top, right, bottom.
type Bounds = [f64; 4];

/// For every series, for every point: where its label stands; none where there is
/// no room.
pub(super) fn arrange(panel: &Panel, r: Rect, v: View) -> Vec<Vec<Option<Place>>> {
    let map = Map { r, v };
    let mut places: Vec<Vec<Option<Place>>> = panel
        .series
        .iter()
        .map(|s| vec![None; s.labels.len()])
        .collect();
    let labelled = |i: &usize| panel.series.get(*i).is_some_and(|s| !s.labels.is_empty());
    // Texts of the frame first, then what lies on top.
    let guide = |i: &usize| panel.series.get(*i).is_some_and(|s| s.role == Role::Guide);
    let all = || 0..panel.series.len();
    let order = all()
        .filter(guide)
        .chain(all().rev().filter(|i| !guide(i)))
        .filter(labelled);
    let symbols: Vec<Bounds> = symbols(panel, &map);
    let mut taken: Vec<(Bounds, &str)> = Vec::new();
    let mut tried = 0;
    for index in order {
        let (Some(s), Some(own)) = (panel.series.get(index), places.get_mut(index)) else {
            continue;
        };
        for (k, (label, place)) in s.labels.iter().zip(own).enumerate() {
            let point = s.x.get(k).zip(s.y.get(k));
            let Some((px, py)) = point.and_then(|(x, y)| map.point(*x, *y)) else {
                continue;
            };
            if label.is_empty() || tried >= MOST {
                continue;
            }
            tried += 1;
            let width = 0.56 * SIZE * label.chars().count() as f64;
            let is_guide = s.role == Role::Guide;
            let candidates: &[Place] = match panel.x.scale {
                _ if is_guide => &CENTRED,
                // Values stand in columns there.
                Scale::Names(_) => &UPRIGHT,
                _ => &AROUND,
            };
            // Repeats of one placement lie on top of each other: one name will do.
            let near = |b: &Bounds| (b[0] - px).abs() < REPEAT && (b[1] - py).abs() < REPEAT;
            if !is_guide && taken.iter().any(|(b, l)| *l == label.as_str() && near(b)) {
                continue;
            }
            let free = |b: &Bounds| {
                let within = b[0] >= 0.0 && b[2] <= r.w && b[1] >= 0.0 && b[3] <= r.h;
                let on_symbol = |o: &Bounds| overlap(b, o);
                within
                    && !taken.iter().any(|(o, _)| overlap(b, o))
                    && (is_guide || !symbols.iter().any(on_symbol))
            };
            let found = candidates
                .iter()
                .map(|c| (*c, bounds(c, px, py, width)))
                .find(|(_, b)| free(b));
            if let Some((c, b)) = found {
                taken.push((b, label.as_str()));
                *place = Some(c);
            }
        }
    }
    places
}

const fn at(x: f64, y: f64, anchor: &'static str) -> Place {
    Place { x, y, anchor }
}

const CENTRED: [Place; 3] = [
    at(0.0, 4.0, "middle"),
    at(0.0, 4.0, "start"),
    at(0.0, 4.0, "end"),
];

const UPRIGHT: [Place; 6] = [
    at(0.0, -9.0, "middle"),
    at(0.0, 17.0, "middle"),
    at(7.0, -7.0, "start"),
    at(-7.0, -7.0, "end"),
    at(7.0, 16.0, "start"),
    at(-7.0, 16.0, "end"),
];

const AROUND: [Place; 8] = [
    at(7.0, 4.0, "start"),
    at(-7.0, 4.0, "end"),
    at(0.0, -8.0, "middle"),
    at(0.0, 16.0, "middle"),
    at(6.0, -6.0, "start"),
    at(6.0, 14.0, "start"),
    at(-6.0, -6.0, "end"),
    at(-6.0, 14.0, "end"),
];

fn bounds(place: &Place, px: f64, py: f64, width: f64) -> Bounds {
    let left = px + place.x
        - match place.anchor {
            "middle" => width / 2.0,
            "end" => width,
            _ => 0.0,
        };
    let base = py + place.y;
    // With a space beside it.
    [left - 3.5, base - 9.0, left + width + 3.5, base + 2.5]
}

fn overlap(a: &Bounds, b: &Bounds) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

/// What the symbols cover: few points only, of many none is labelled anyway.
fn symbols(panel: &Panel, map: &Map) -> Vec<Bounds> {
    let points = panel
        .series
        .iter()
        .filter(|s| s.mark == Mark::Points && s.role != Role::Guide);
    points
        .flat_map(|s| s.x.iter().zip(&s.y))
        .filter_map(|(x, y)| map.point(*x, *y))
        .map(|(x, y)| [x - 3.5, y - 3.5, x + 3.5, y + 3.5])
        .take(4 * MOST)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::super::{Axis, Series};
    use super::*;

    const PLOT: Rect = Rect {
        x: 0.0,
        y: 0.0,
        w: 300.0,
        h: 200.0,
    };
    const VIEW: View = View {
        x: [0.0, 300.0],
        y: [0.0, 200.0],
    };

    fn points(x: &[f64], y: &[f64]) -> Panel {
        let labels = (0..x.len()).map(|i| format!("pose {i}")).collect();
        Panel::new(Axis::hidden(), Axis::hidden())
            .with(Series::points("p", Role::Calibrated, x.to_vec(), y.to_vec()).labelled(labels))
    }

    #[test]
    fn neighbours_give_way_and_a_crowd_is_silent() {
        let two = arrange(&points(&[100.0, 110.0], &[100.0, 100.0]), PLOT, VIEW);
        assert!(two[0].iter().all(Option::is_some));
        assert_ne!(two[0][0], two[0][1]);
        let crowd = arrange(&points(&[100.0; 60], &[100.0; 60]), PLOT, VIEW);
        let shown = crowd[0].iter().flatten().count();
        assert!((0..60).contains(&shown) && shown < 9, "{shown}");
    }

    #[test]
    fn at_the_rim_it_stays_inside() {
        let places = arrange(&points(&[298.0, f64::NAN], &[100.0, 1.0]), PLOT, VIEW);
        assert_eq!(places[0][0].map(|p| p.anchor), Some("end"));
        assert_eq!(places[0][1], None);
    }
}

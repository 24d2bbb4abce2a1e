//! The raw recordings with the windows that were used, and their noise.

use crate::figure::thin::{BUCKETS, LIMIT, Samples};
use crate::figure::{Axis, Figure, Panel, Role, Series};
use gravical::calibration_file::CalibrationFile;
use gravical::recording::Recording;

use super::{Scale, Session, places};

/// Share of all time that lies between two recordings.
const GAP: f64 = 0.015;

/// Windows whose poses are named.
const MAX_NAMED: usize = 12;

/// A recording on the common axis of time.
pub(super) struct Placed<'a> {
    pub recording: &'a Recording,
    partings: Vec<usize>,
    /// What is added to its time, s.
    pub shift_s: f64,
    /// Seconds from row to row where it has no stamps.
    step_s: f64,
    /// Points that it may have.
    share: f64,
}

impl Placed<'_> {
    /// Time of a row on the common axis, s.
    pub fn at(&self, row: usize) -> f64 {
        self.shift_s + own_time(self.recording, self.step_s, row)
    }

    pub fn line(&self, role: Role, name: &str, value: impl Fn(usize) -> f64) -> Series {
        let points = |all: usize| (self.share * all as f64).ceil().max(2.0) as usize;
        let samples = Samples {
            count: self.recording.rows(),
            breaks: &self.partings,
            time: |i| self.at(i),
            limit: points(LIMIT),
            buckets: points(BUCKETS),
        };
        samples.line(name, role, |i| (self.at(i), value(i)))
    }
}

fn own_time(recording: &Recording, step_s: f64, row: usize) -> f64 {
    match &recording.time_s {
        Some(t) => t.get(row).copied().unwrap_or(f64::NAN),
        None => step_s * row as f64,
    }
}

/// One after the other, with gaps.
pub(super) fn placed(recordings: &[Recording]) -> Vec<Placed<'_>> {
    let step = |r: &Recording| 1.0 / r.working_rate_hz().0;
    let spans = recordings.iter().map(|r| {
        let ends = (0..r.rows()).rev().map(|i| own_time(r, step(r), i));
        ends.take(1000)
            .find(|t| t.is_finite())
            .unwrap_or(0.0)
            .max(0.0)
    });
    let spans: Vec<f64> = spans.collect();
    let total: f64 = spans.iter().sum();
    let rows: usize = recordings.iter().map(Recording::rows).sum();
    let mut from = 0.0;
    let place = |(recording, span): (_, &f64)| {
        let recording: &Recording = recording;
        let placed = Placed {
            recording,
            partings: recording.breaks.clone(),
            shift_s: from,
            step_s: step(recording),
            share: recording.rows() as f64 / rows.max(1) as f64,
        };
        from += span + GAP * total;
        placed
    };
    recordings.iter().zip(&spans).map(place).collect()
}

/// Several recordings as one line with breaks between them.
pub(super) fn joined(lines: impl Iterator<Item = Series>) -> Option<Series> {
    lines.reduce(|mut all, next| {
        all.x.push(f64::NAN);
        all.y.push(f64::NAN);
        all.x.extend(next.x);
        all.y.extend(next.y);
        all.samples += next.samples;
        all
    })
}

/// Windows of the placements as (label, from, to), s.
fn windows(session: Session<'_>, placed: &[Placed<'_>]) -> Vec<(String, f64, f64)> {
    let mut all = Vec::new();
    for p in &session.segmentation.poses {
        let Some(own) = placed.get(p.recording) else {
            continue;
        };
        let label = p.face.map_or_else(|| p.label.clone(), |f| f.name());
        for rows in p.rows.iter().filter(|r| !r.is_empty()) {
            all.push((label.clone(), own.at(rows.start), own.at(rows.end - 1)));
        }
    }
    all.retain(|w| w.1.is_finite() && w.2.is_finite());
    all
}

pub(super) fn time_axis(recordings: &[Recording]) -> Axis {
    let label = match recordings {
        [_] => "time",
        _ => "time, one recording after the other",
    };
    Axis::new(label, "s")
}

/// Raw readings along each axis, with the windows.
pub(super) fn captures(session: Session<'_>, scale: &Scale) -> Option<Figure> {
    let placed = placed(session.recordings);
    if placed.iter().all(|p| p.recording.rows() == 0) {
        return None;
    }
    let (unit, factor) = scale.shown();
    let windows = windows(session, &placed);
    let mut figure = Figure::new(
        "captures",
        "Recorded poses",
        format!(
            "Raw recording, nominal scale. Shaded: {}.",
            match windows.len() {
                1 => "the pose whose mean was used".to_owned(),
                n => format!("the {n} poses whose means were used"),
            }
        ),
    );
    if scale.nominal.is_none() {
        figure.caption = figure.caption.replace(", nominal scale", "");
    }
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let value = |p: &Placed<'_>, i: usize| {
            let all = p.recording.accel.get(axis).and_then(|a| a.get(i));
            all.map_or(f64::NAN, |v| factor * v)
        };
        let lines = placed
            .iter()
            .map(|p| p.line(Role::Raw, "raw", |i| value(p, i)));
        let Some(line) = joined(lines) else {
            continue;
        };
        let mut panel = Panel::new(time_axis(session.recordings), Axis::new("", unit)).titled(name);
        for (_, from, to) in &windows {
            panel = panel.shaded("used", *from, *to);
        }
        if axis == 0 && windows.len() <= MAX_NAMED {
            panel = named(panel, &line, &windows);
        }
        figure = figure.with(panel.with(line));
    }
    (!figure.panels.is_empty()).then_some(figure)
}

/// With the windows' labels above the line.
fn named(panel: Panel, line: &Series, windows: &[(String, f64, f64)]) -> Panel {
    let known = || line.y.iter().copied().filter(|v| v.is_finite());
    let (low, high) = (
        known().fold(f64::INFINITY, f64::min),
        known().fold(f64::NEG_INFINITY, f64::max),
    );
    if low > high {
        return panel;
    }
    let above = high + 0.14 * (high - low).max(1e-6 * high.abs());
    let labels = windows.iter().map(|w| w.0.clone()).collect();
    let middle = windows.iter().map(|w| 0.5 * (w.1 + w.2)).collect();
    let texts = Series::points("pose", Role::Guide, middle, vec![above; windows.len()]);
    panel.with(texts.labelled(labels))
}

/// Standard deviation of the samples in each placement.
pub(super) fn noise(file: &CalibrationFile, session: Session<'_>, scale: &Scale) -> Option<Figure> {
    let placements = &session.segmentation.poses;
    let poses = &file.accelerometer.poses;
    let (unit, factor) = scale.shown();
    let (unit, factor) = match scale.nominal {
        Some(_) => ("mm/s²", 1e3 * factor),
        None => (unit, factor),
    };
    let mut names = Vec::new();
    let mut sigma: [Vec<f64>; 3] = Default::default();
    for (i, p) in placements.iter().enumerate() {
        let Some(recording) = session.recordings.get(p.recording) else {
            continue;
        };
        let own: [Option<f64>; 3] = std::array::from_fn(|axis| {
            let rows = p
                .rows
                .iter()
                .flat_map(|r| recording.accel[axis].get(r.clone()));
            deviation(rows.flatten().copied())
        });
        if own.iter().all(Option::is_none) {
            continue;
        }
        let label = poses.get(i).filter(|_| poses.len() == placements.len());
        names.push(label.map_or_else(|| p.label.clone(), |l| l.label.clone()));
        for (all, one) in sigma.iter_mut().zip(own) {
            all.push(factor * one.unwrap_or(f64::NAN));
        }
    }
    if names.is_empty() {
        return None;
    }
    let x = places(names.len());
    let mut panel = Panel::new(
        Axis::names("pose", names),
        Axis::new("noise, 1σ of a sample", unit),
    );
    let axes = [("x", Role::X), ("y", Role::Y), ("z", Role::Z)];
    for ((name, role), sigma) in axes.into_iter().zip(sigma) {
        panel = panel.with(Series::columns(name, role, x.clone(), sigma));
    }
    let figure = Figure::new(
        "noise",
        "Noise at rest",
        "Standard deviation of the samples of each pose. A high value indicates a disturbed pose, zero a frozen axis.",
    );
    Some(figure.with(panel))
}

/// Standard deviation of what is finite; none of fewer than three values.
fn deviation(values: impl Iterator<Item = f64>) -> Option<f64> {
    // Welford's recurrence: readings may have an offset far above their noise.
    let (mut n, mut mean, mut squares) = (0.0, 0.0, 0.0);
    for v in values.filter(|v| v.is_finite()) {
        n += 1.0;
        let off = v - mean;
        mean += off / n;
        squares += off * (v - mean);
    }
    (n > 2.0).then(|| f64::sqrt(squares / (n - 1.0)))
}

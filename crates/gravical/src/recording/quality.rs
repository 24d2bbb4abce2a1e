//! What is wrong with the samples themselves: frozen axes, clipping, rows that
//! repeat, cells that are empty.

use super::Recording;
use super::finding::{Finding, LineSpans};
use super::units::{AccelScale, AccelUnit, GyroScale, GyroUnit, LSB_PER_DEG_S};
use gravical_core::unit::STANDARD_GRAVITY_MPS2;

/// Rows an axis has to stay exactly the same, while the others move, to be
/// called frozen.
pub(crate) const FROZEN_ROWS: usize = 100;

/// Looks at all samples of a recording.
#[must_use]
pub fn inspect(recording: &Recording) -> Vec<Finding> {
    let mut findings = Vec::new();
    frozen(recording, &mut findings);
    clipped(recording, &mut findings);
    repeated_rows(recording, &mut findings);
    findings
}

/// Cells without a value, before anything is filled in.
#[must_use]
pub fn empty_cells(
    accel: &[Vec<f64>; 3],
    gyro: Option<&[Vec<f64>; 3]>,
    temperature_c: Option<&[f64]>,
) -> Option<Finding> {
    let sensor = |channels: &[Vec<f64>; 3]| {
        std::array::from_fn(|i| channels[i].iter().filter(|v| v.is_nan()).count())
    };
    let rows = accel[0].len();
    let incomplete = |i: &usize| accel.iter().any(|c| c[*i].is_nan());
    Empty {
        accel: sensor(accel),
        gyro: gyro.map_or([0; 3], sensor),
        temperature: temperature_c.map_or(0, |t| t.iter().filter(|v| v.is_nan()).count()),
        incomplete: (0..rows).filter(incomplete).count(),
    }
    .finding(rows)
}

/// Cells without a value, counted by channel.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Empty {
    /// Of ax, ay, az.
    pub accel: [usize; 3],
    /// Of gx, gy, gz.
    pub gyro: [usize; 3],
    /// Of the temperature.
    pub temperature: usize,
    /// Rows that lack a value of the accelerometer.
    pub incomplete: usize,
}

impl Empty {
    /// The last values of the accelerometer are held over so many empty cells of
    /// `rows` rows.
    pub fn is_sparse(&self, rows: usize) -> bool {
        self.incomplete * 5 > rows
    }

    /// What is said of them; none without any.
    pub fn finding(&self, rows: usize) -> Option<Finding> {
        let [ax, ay, az] = self.accel;
        let [gx, gy, gz] = self.gyro;
        let parts = [
            ("ax", ax),
            ("ay", ay),
            ("az", az),
            ("gx", gx),
            ("gy", gy),
            ("gz", gz),
            ("temperature", self.temperature),
        ];
        let total: usize = parts.iter().map(|p| p.1).sum();
        if total == 0 {
            return None;
        }
        let parts: Vec<String> = parts
            .iter()
            .filter(|(_, empty)| *empty > 0)
            .map(|(name, empty)| format!("{name} {empty}"))
            .collect();
        Some(
            Finding::warning(
                "empty-cells",
                format!(
                    "{total} empty cells ({}); {} of {rows} rows lack a value of the accelerometer{}",
                    parts.join(", "),
                    self.incomplete,
                    if self.is_sparse(rows) {
                        ": each channel is written when it arrives; the last value of the others is held"
                    } else {
                        "; they are left out of means"
                    }
                ),
            )
            .counting(total as u64),
        )
    }
}

fn frozen(recording: &Recording, findings: &mut Vec<Finding>) {
    frozen_axes(recording, "a", &recording.accel, findings);
    findings.extend(frozen_gyroscope(recording));
}

/// Axes of the gyroscope that stand still while others move.
#[must_use]
pub(super) fn frozen_gyroscope(recording: &Recording) -> Vec<Finding> {
    let mut findings = Vec::new();
    if let Some(gyro) = &recording.gyro {
        frozen_axes(recording, "g", gyro, &mut findings);
    }
    findings
}

fn frozen_axes(
    recording: &Recording,
    letter: &str,
    sensor: &[Vec<f64>; 3],
    findings: &mut Vec<Finding>,
) {
    let steps = match letter {
        "a" => recording.accel_resolution(),
        _ => recording.gyro_resolution(),
    };
    for axis in 0..3 {
        let mut spans = LineSpans::default();
        let (mut from, mut longest) = (0, 0);
        let rows = sensor[axis].len();
        for row in 1..=rows {
            let goes_on = row < rows && sensor[axis][row] == sensor[axis][from];
            if goes_on {
                continue;
            }
            let length = row - from;
            let whole = length == rows && rows >= 20;
            let are_alive = || {
                let mut others = [Beside::default(); 2];
                for (other, o) in others.iter_mut().zip([(axis + 1) % 3, (axis + 2) % 3]) {
                    let part = &sensor[o][from..row];
                    part.windows(2).for_each(|w| other.see(w[0], w[1]));
                }
                is_frozen(&others, steps[axis], length as f64)
            };
            if (length >= FROZEN_ROWS || whole) && are_alive() {
                longest = longest.max(length);
                for r in from..row {
                    spans.push(recording.line(r));
                }
            }
            from = row;
        }
        if !spans.is_empty() {
            let name = format!("{letter}{}", ["x", "y", "z"][axis]);
            findings.push(frozen_axis(&name, longest as u64, &spans));
        }
    }
}

/// What is said of an axis that is frozen.
pub(crate) fn frozen_axis(name: &str, longest: u64, spans: &LineSpans) -> Finding {
    Finding::warning(
        "frozen-axis",
        format!("{name} stands still to the last digit for {longest} rows while the others move"),
    )
    .at_lines(spans)
}

/// What another axis of the sensor does while one keeps its value.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Beside {
    squares: f64,
    /// Lowest and highest value so far, less the first one.
    first: Option<f64>,
    low: f64,
    high: f64,
}

impl Beside {
    /// A value and the one of the row before.
    #[inline]
    pub fn see(&mut self, before: f64, now: f64) {
        let step = now - before;
        // Empty cells say nothing.
        if step.is_nan() {
            return;
        }
        self.squares += step * step;
        let off = now - *self.first.get_or_insert(before);
        self.low = self.low.min(off);
        self.high = self.high.max(off);
    }
}

/// Steps from row to row, in resolutions and rms, that no live axis hides beside
/// another that makes them: two of noise.
const LIVELY: f64 = 2.0 * std::f64::consts::SQRT_2;
/// Resolutions over which both other axes have to go: a turn or a push about one axis
/// leaves another alone, nothing leaves it alone that moves both so far.
const FAR: f64 = 20.0;

/// Whether an axis that keeps one value for `rows` rows is dead: one of the other two
/// scatters by more than its resolution `step` hides, or both move far. An axis that
/// lies still is not: with coarse digits it never changes.
pub(crate) fn is_frozen(others: &[Beside; 2], step: f64, rows: f64) -> bool {
    let lively = others
        .iter()
        .any(|o| o.squares > 0.0 && o.squares >= (LIVELY * step).powi(2) * rows);
    lively || others.iter().all(|o| o.high - o.low > FAR * step)
}

/// Full scales in use, g.
const FULL_SCALES_G: [f64; 4] = [2.0, 4.0, 8.0, 16.0];

/// Full scales that gyroscopes are sold with, °/s; the ends of the 16-bit range at their
/// sensitivities come with [`LSB_PER_DEG_S`].
const FULL_SCALES_DEG_S: [f64; 6] = [125.0, 245.0, 250.0, 500.0, 1000.0, 2000.0];

/// Counts from here on are at the end of a 16-bit converter: some stop a few before it.
const LARGEST_COUNT: f64 = 32764.0;
/// … and none is beyond: larger values are of no such converter, which has no end then.
const END_OF_COUNTS: f64 = 32768.0;

/// True when `value` (in the unit of the file, offset taken off) is at the end
/// of the converter's range.
#[must_use]
pub fn is_clipped(value: f64, scale: &AccelScale) -> bool {
    FullScale::of_accel(scale).is_at_end(value.abs())
}

/// Where the range of a sensor ends, in the unit of the file.
#[derive(Debug, Clone)]
pub(crate) struct FullScale {
    /// Magnitudes from and to which a value is at the end.
    ends: Vec<[f64; 2]>,
    /// Counts, whose end is certain. In physical units a single value at a full scale
    /// is chance; the end of the range shows as repeats of one value.
    counts: bool,
}

impl FullScale {
    fn of_counts() -> Self {
        FullScale {
            ends: vec![[LARGEST_COUNT, END_OF_COUNTS]],
            counts: true,
        }
    }

    pub fn of_accel(scale: &AccelScale) -> Self {
        if scale.unit == AccelUnit::Counts {
            return Self::of_counts();
        }
        let per_g = scale.nominal().map(|n| n * STANDARD_GRAVITY_MPS2);
        let given = scale.lsb_per_g.map(|lsb| 32768.0 / lsb);
        let ranges = FULL_SCALES_G.into_iter().chain(given);
        FullScale {
            // Within two counts of it.
            ends: per_g
                .map(|per_g| ranges.map(move |g| g * per_g))
                .into_iter()
                .flatten()
                .map(|full| [full * (1.0 - 2.5 / 32768.0), full * 1.0005])
                .collect(),
            counts: false,
        }
    }

    /// Where nothing tells the unit, it is °/s or rad/s.
    pub fn of_gyro(scale: &GyroScale) -> Self {
        if scale.unit == GyroUnit::Counts {
            return Self::of_counts();
        }
        let given_deg_s = scale.lsb_per_deg_s.map(|lsb| 32768.0 / lsb);
        let full_deg_s: Vec<f64> = match given_deg_s {
            Some(given) => vec![given],
            None => LSB_PER_DEG_S
                .into_iter()
                .map(|lsb| 32767.0 / lsb)
                .chain(FULL_SCALES_DEG_S)
                .collect(),
        };
        let radian = std::f64::consts::PI / 180.0;
        let units: &[f64] = match scale.unit {
            GyroUnit::RadianPerSecond => &[radian],
            GyroUnit::DegreePerSecond => &[1.0],
            _ => &[1.0, radian],
        };
        let ends = full_deg_s
            .iter()
            .flat_map(|deg_s| units.iter().map(move |unit| deg_s * unit));
        FullScale {
            // Rounded sensitivities, and two decimals.
            ends: ends
                .map(|full| [full * 0.9985 - 0.005, full * 1.0015 + 0.005])
                .collect(),
            counts: false,
        }
    }

    /// No smaller magnitude is at the end.
    pub fn least(&self) -> f64 {
        self.ends
            .iter()
            .fold(f64::INFINITY, |least, e| least.min(e[0]))
    }

    fn is_at_end(&self, magnitude: f64) -> bool {
        self.ends
            .iter()
            .any(|[from, to]| magnitude >= *from && magnitude <= *to)
    }
}

/// Follows a channel up to the end of its range.
#[derive(Debug, Clone)]
pub(crate) struct Clipping {
    full: FullScale,
    lines: LineSpans,
    largest: f64,
    last: f64,
    repeats: u64,
}

impl Clipping {
    pub fn new(full: FullScale) -> Self {
        Clipping {
            full,
            lines: LineSpans::default(),
            largest: 0.0,
            last: f64::NAN,
            repeats: 0,
        }
    }

    /// A value of at least [`FullScale::least`], the offset taken off; smaller ones may
    /// be left out.
    pub fn see(&mut self, value: f64, line: u64) {
        let magnitude = value.abs();
        if magnitude > self.largest {
            // What is passed is not the end.
            if magnitude > 1.004 * self.largest && !self.full.counts {
                self.lines = LineSpans::default();
                self.repeats = 0;
            }
            self.largest = magnitude;
        }
        let near_largest = self.full.counts || magnitude > 0.996 * self.largest;
        if near_largest && self.full.is_at_end(magnitude) {
            self.repeats += u64::from(self.last == value);
            self.last = value;
            self.lines.push(line);
        }
    }

    /// What is said of it; none where nothing is clipped.
    pub fn finding(&self, channel: &str) -> Option<Finding> {
        let shown = match self.full.counts {
            true => self.largest <= END_OF_COUNTS,
            false => self.repeats >= 3,
        };
        (shown && !self.lines.is_empty()).then(|| {
            Finding::warning(
                "clipped",
                format!(
                    "{channel} reaches the end of its range in {} rows: the true value is larger; record at a wider range",
                    self.lines.count()
                ),
            )
            .at_lines(&self.lines)
        })
    }
}

/// Names of the channels.
pub(crate) const CHANNELS: [&str; 6] = ["ax", "ay", "az", "gx", "gy", "gz"];

fn clipped(recording: &Recording, findings: &mut Vec<Finding>) {
    let full = FullScale::of_accel(&recording.accel_scale);
    for (axis, values) in recording.accel.iter().enumerate() {
        findings.extend(clipping_of(recording, values, &full).finding(CHANNELS[axis]));
    }
    findings.extend(clipped_gyroscope(recording));
}

/// Axes of the gyroscope that reach the end of their range.
#[must_use]
pub(super) fn clipped_gyroscope(recording: &Recording) -> Vec<Finding> {
    let (Some(gyro), Some(scale)) = (&recording.gyro, &recording.gyro_scale) else {
        return Vec::new();
    };
    let full = FullScale::of_gyro(scale);
    let of = |(axis, values): (usize, &Vec<f64>)| {
        clipping_of(recording, values, &full).finding(CHANNELS[3 + axis])
    };
    gyro.iter().enumerate().filter_map(of).collect()
}

fn clipping_of(recording: &Recording, values: &[f64], full: &FullScale) -> Clipping {
    let least = full.least();
    let mut clipping = Clipping::new(full.clone());
    for (row, &value) in values.iter().enumerate() {
        if value.abs() >= least {
            clipping.see(value, recording.line(row));
        }
    }
    clipping
}

/// Rows at which a channel is clipped. In physical units a single value at a
/// full scale is chance; the end of the range shows as repeats of one value.
#[must_use]
pub fn clipped_rows(values: &[f64], scale: &AccelScale) -> Vec<usize> {
    let full = FullScale::of_accel(scale);
    let at_end: Vec<usize> = values
        .iter()
        .enumerate()
        .filter(|(_, v)| full.is_at_end(v.abs()))
        .map(|(i, _)| i)
        .collect();
    if scale.unit == AccelUnit::Counts {
        return at_end;
    }
    let repeats = at_end
        .windows(2)
        .filter(|w| values[w[0]] == values[w[1]])
        .count();
    if repeats >= 3 { at_end } else { Vec::new() }
}

/// Columns that were taken for an accelerometer by their numbers alone and do
/// not behave like one: gravity never leaves an accelerometer, so that its
/// magnitude at rest and in motion are alike.
pub(super) fn maybe_gyroscope(recording: &Recording) -> Option<Finding> {
    let (quiet, _) = super::quiet_norm(&recording.accel)?;
    let mut norms: Vec<f64> = (0..recording.rows())
        .map(|row| {
            recording
                .accel_at(row)
                .iter()
                .map(|v| v * v)
                .sum::<f64>()
                .sqrt()
        })
        .filter(|n| n.is_finite())
        .collect();
    let at = ((norms.len() * 49) / 50).min(norms.len().checked_sub(1)?);
    let (_, high, _) = norms.select_nth_unstable_by(at, f64::total_cmp);
    (*high > 4.0 * quiet).then(|| {
        Finding::warning(
            "not-an-accelerometer",
            format!("the magnitude is {quiet:.0} at rest and up to {high:.0} in motion: these columns look like a gyroscope"),
        )
    })
}

fn repeated_rows(recording: &Recording, findings: &mut Vec<Finding>) {
    // Where values are held until the next one comes, repeats are ours.
    if recording.findings.iter().any(|f| f.kind == "empty-cells") {
        return;
    }
    let channels: Vec<(&Vec<f64>, f64)> = recording
        .accel
        .iter()
        .chain(recording.gyro.iter().flatten())
        .zip(recording.resolution)
        .collect();
    let mut repeats = Repeats::default();
    for row in 1..recording.rows() {
        if channels.iter().all(|(c, _)| c[row] == c[row - 1]) {
            repeats.repeat(recording.line(row));
        } else if repeats.is_open() {
            repeats.end(
                channels
                    .iter()
                    .any(|(c, q)| is_jump(c[row - 1], c[row], *q)),
            );
        }
    }
    findings.extend(repeats.finding(recording.rows() as u64));
}

/// Steps of the resolution that a channel has to change by to show that a row before
/// was no new reading.
const JUMP: f64 = 2.5;

/// True where a channel changes by more than its last digit flips.
#[inline]
pub(crate) fn is_jump(before: f64, now: f64, step: f64) -> bool {
    (now - before).abs() > JUMP * step
}

/// Rows that repeat the row before in every channel. They are the same reading twice
/// where the next one is far off, all through the recording. Where the digits are
/// coarse rows repeat by nature: at rest, until the last digit flips or a motion begins.
#[derive(Debug, Clone, Default)]
pub(crate) struct Repeats {
    spans: LineSpans,
    /// First and last line of the rows that repeat now, and their number.
    open: Option<(u64, u64, u64)>,
    /// Runs of them that ended with a jump, and those that did not.
    jumped: u64,
    flipped: u64,
}

/// Rows for every run that ends with a jump, at most: a rest every four seconds at 25 Hz
/// is as rare.
const ROWS_OF_RUN: u64 = 100;

impl Repeats {
    /// A row, in that line, repeats the one before.
    #[inline]
    pub fn repeat(&mut self, line: u64) {
        match &mut self.open {
            Some((_, last, count)) => (*last, *count) = (line, *count + 1),
            None => self.open = Some((line, line, 1)),
        }
    }

    /// The last row repeated the one before it.
    #[inline]
    pub fn is_open(&self) -> bool {
        self.open.is_some()
    }

    /// A row does not repeat the one before, and may be far off.
    pub fn end(&mut self, jumps: bool) {
        let Some((first, last, count)) = self.open.take() else {
            return;
        };
        if jumps {
            self.spans.push_range(first, last, count);
            self.jumped += 1;
        } else {
            self.flipped += 1;
        }
    }

    /// What is said of them, after the last of `rows`.
    pub fn finding(mut self, rows: u64) -> Option<Finding> {
        // Nothing comes after the last ones: they are as most of the others.
        self.end(self.jumped > self.flipped);
        let count = self.spans.count();
        let often = self.jumped > self.flipped && self.jumped * ROWS_OF_RUN > rows;
        (often && count >= 10).then(|| {
            Finding::warning(
                "repeated-rows",
                format!(
                    "{count} rows ({:.0} %) repeat the row before in every channel: the sensor was read faster than it measures",
                    100.0 * count as f64 / rows.max(1) as f64
                ),
            )
            .at_lines(&self.spans)
        })
    }
}

//! What is wrong with the samples themselves: frozen axes, clipping, rows that
//! repeat, cells that are empty.

use super::Recording;
use super::finding::{Finding, LineSpans};
use super::units::{AccelScale, AccelUnit};

/// Rows an axis has to stay exactly the same, while another moves, to be
/// called frozen: a live sensor's noise flips its last digit sooner.
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
            let others_move = || {
                (0..3).filter(|o| *o != axis).any(|o| {
                    let part = &sensor[o][from..row];
                    part.windows(2).filter(|w| w[0] != w[1]).count() * 10 > length
                })
            };
            let whole = length == rows && rows >= 20;
            if (length >= FROZEN_ROWS || whole) && others_move() {
                longest = longest.max(length);
                for r in from..row {
                    spans.push(recording.line(r));
                }
            }
            from = row;
        }
        if !spans.is_empty() {
            findings.push(
                    Finding::warning(
                        "frozen-axis",
                        format!(
                            "{letter}{} stands still to the last digit for {longest} rows while the others change",
                            ["x", "y", "z"][axis]
                        ),
                    )
                    .at_lines(&spans),
                );
        }
    }
}

/// Full scales in use, g.
const FULL_SCALES_G: [f64; 4] = [2.0, 4.0, 8.0, 16.0];

/// True when `value` (in the unit of the file, offset taken off) is at the end
/// of the converter's range.
#[must_use]
pub fn is_clipped(value: f64, scale: &AccelScale) -> bool {
    let magnitude = value.abs();
    if scale.unit == AccelUnit::Counts {
        return magnitude >= 32767.0;
    }
    // In physical units the end of the range is one of a few values; within
    // two counts of it.
    match scale.nominal() {
        Some(nominal) => {
            let g = magnitude / nominal / gravical_core::unit::STANDARD_GRAVITY_MPS2;
            FULL_SCALES_G
                .iter()
                .any(|full| g <= full * 1.0005 && g >= full * (1.0 - 2.5 / 32768.0))
        }
        None => false,
    }
}

fn clipped(recording: &Recording, findings: &mut Vec<Finding>) {
    for axis in 0..3 {
        let mut spans = LineSpans::default();
        let values = &recording.accel[axis];
        for row in clipped_rows(values, &recording.accel_scale) {
            spans.push(recording.line(row));
        }
        if !spans.is_empty() {
            findings.push(
                Finding::warning(
                    "clipped",
                    format!(
                        "a{} reaches the end of its range in {} rows: the true value is larger; record at a wider range",
                        ["x", "y", "z"][axis],
                        spans.count()
                    ),
                )
                .at_lines(&spans),
            );
        }
    }
}

/// Rows at which a channel is clipped. In physical units a single value at a
/// full scale is chance; the end of the range shows as repeats of one value.
#[must_use]
pub fn clipped_rows(values: &[f64], scale: &AccelScale) -> Vec<usize> {
    let at_end: Vec<usize> = values
        .iter()
        .enumerate()
        .filter(|(_, v)| is_clipped(**v, scale))
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
    let rows = recording.rows();
    let mut spans = LineSpans::default();
    let channels: Vec<&Vec<f64>> = recording
        .accel
        .iter()
        .chain(recording.gyro.iter().flatten())
        .collect();
    for row in 1..rows {
        if channels.iter().all(|c| c[row] == c[row - 1]) {
            spans.push(recording.line(row));
        }
    }
    // Coarse digits repeat by chance now and then.
    let share = spans.count() as f64 / rows.max(1) as f64;
    if share > 0.01 && spans.count() >= 10 {
        findings.push(
            Finding::warning(
                "repeated-rows",
                format!(
                    "{} rows ({:.0} %) repeat the row before in every channel: the sensor was read faster than it measures",
                    spans.count(),
                    100.0 * share
                ),
            )
            .at_lines(&spans),
        );
    }
}

//! From columns of numbers to a recording: what the stamps, the units and the
//! samples say.

use crate::stats::median;

use super::finding::{Finding, LineSpans};
use super::layout::Layout;
use super::quiet::quiet_norm;
use super::read::Scanned;
use super::timing::{self, Claims, Parts};
use super::unit_choice::{decide_accel, looks_unsigned};
use super::units::{GyroScale, GyroUnit, Origin};
use super::{LineMap, ReadOptions, Recording, metadata, quality, resolution};

/// Fewer rows than these are a table of means, or one placement: no rate is needed.
const LEAST_ROWS: usize = 40;

/// Judges stamps, units and samples, and makes a recording of it all.
pub(super) fn assemble(scanned: Scanned, options: &ReadOptions, name: &str) -> Recording {
    let Scanned {
        columns,
        ledger,
        mut findings,
        dialect,
        layout,
        description,
        sha256,
    } = scanned;
    let [time, ax, ay, az, gx, gy, gz, temperature] = columns.slots;
    let mut accel = [ax, ay, az];
    let mut zeros = zero_rows(&accel, [&gx, &gy, &gz]);
    // Without gravity it reads zero at rest.
    if layout.accel_claim.without_gravity || 2 * zeros.len() > accel[0].len() {
        zeros.clear();
    }
    let line_map = columns.lines;
    let some = |v: Vec<f64>| (!v.is_empty()).then_some(v);

    let unsigned = options.zero_offset.is_none() && looks_unsigned(&accel);
    let zero_offset = options
        .zero_offset
        .unwrap_or(if unsigned { 32768.0 } else { 0.0 });
    if zero_offset != 0.0 {
        for value in accel.iter_mut().flatten() {
            *value -= zero_offset;
        }
        if unsigned {
            findings.push(Finding::note(
                "unsigned-counts",
                "unsigned 16-bit values around 32768: that is subtracted; the range is not known",
            ));
        }
    }
    let temperature_c = some(temperature).filter(|t| is_celsius(t, &mut findings));
    let span = temperature_c.as_deref().map_or(0.0, |t| {
        let (low, high) = t
            .iter()
            .filter(|v| v.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
                (l.min(*v), h.max(*v))
            });
        (high - low).max(0.0)
    });
    let claims = Claims {
        unit: options.time_unit.or(layout.time_claim),
        nominal_rate_hz: options
            .rate_hz
            .or_else(|| metadata::rate_hz(&dialect.metadata)),
        temperature_span_c: span,
    };
    let parts = Parts {
        breaks: &columns.breaks,
        gaps: &columns.gaps,
    };
    let timed = match some(time) {
        Some(raw) => timing::judge(raw, parts, &claims, |row| line_map.line(row)),
        None => timing::untimed(accel[0].len(), &claims, Vec::new()),
    };
    findings.extend(timed.findings);
    if timed.timing.rate_hz().is_none() && accel[0].len() >= LEAST_ROWS {
        findings.push(Finding::note(
            "rate-unknown",
            format!(
                "no time stamps and no --rate: stills are looked for as at {} Hz",
                Recording::ASSUMED_RATE_HZ
            ),
        ));
    }
    let mut breaks = columns.breaks;
    let deliberate = columns.deliberate;
    breaks.retain(|row| deliberate.contains(row) || !timed.bridged.contains(row));
    breaks.extend(timed.restarts);
    breaks.sort_unstable();
    breaks.dedup();

    let mut gyro = (!gx.is_empty()).then_some([gx, gy, gz]);
    findings.extend(quality::empty_cells(
        &accel,
        gyro.as_ref(),
        temperature_c.as_deref(),
    ));
    if is_sparse(&accel) {
        hold_last_values(&mut accel, f64::INFINITY);
    }
    if let Some(gyro) = gyro.as_mut().filter(|g| is_sparse(g)) {
        // An integral over what is held longer would be made up.
        hold_last_values(gyro, GYRO_HELD);
    }
    findings.extend(empty_zeros(&zeros, &mut accel, gyro.as_mut(), &line_map));
    let accel_scale = decide_accel(
        quiet_norm(&accel),
        unsigned,
        layout.accel_claim,
        options,
        &mut findings,
    );
    let gyro_scale = gyro.as_ref().map(|g| gyro_by_claim(g, &layout, options));
    let resolution = resolution::of_channels(&accel, gyro.as_ref());
    let mut recording = Recording {
        name: name.to_owned(),
        sha256,
        description,
        serial: metadata::serial(&dialect.metadata),
        column_names: dialect
            .header
            .as_ref()
            .map_or_else(Vec::new, |h| h.names.clone()),
        accel,
        gyro,
        gyro_file: None,
        temperature_c,
        time_s: timed.time_s,
        time_origin_s: timed.origin_s,
        labels: (!columns.labels.of_row.is_empty()).then_some(columns.labels),
        breaks,
        zero_offset,
        accel_scale,
        gyro_scale,
        resolution,
        timing: timed.timing,
        ledger,
        findings,
        line_map,
    };
    let samples = quality::inspect(&recording);
    recording.findings.extend(samples);
    if recording
        .findings
        .iter()
        .any(|f| f.kind == "columns-guessed")
    {
        recording
            .findings
            .extend(quality::maybe_gyroscope(&recording));
    }
    for finding in &mut recording.findings {
        finding.file = Some(name.to_owned());
    }
    recording
}

/// No sensor of this kind is colder or hotter, °C.
pub(crate) const POSSIBLE_C: std::ops::RangeInclusive<f64> = -60.0..=150.0;

/// Raw counts of a temperature are no °C.
pub(crate) fn is_celsius(temperature: &[f64], findings: &mut Vec<Finding>) -> bool {
    let mut some: Vec<f64> = temperature
        .iter()
        .copied()
        .filter(|t| t.is_finite())
        .collect();
    let Some(middle) = median(&mut some) else {
        return true;
    };
    let fits = POSSIBLE_C.contains(&middle);
    if !fits {
        findings.push(Finding::note(
            "temperature-unit",
            format!(
                "the temperature column is around {middle:.0}: no °C (raw counts?); it is not used"
            ),
        ));
    }
    fits
}

/// A recorder that writes each channel when it arrives leaves most cells
/// empty; there the last value of a channel holds until the next comes, over
/// `longest` times the rows that usually lie between two. Elsewhere ([`is_sparse`]) an
/// empty cell stays empty.
pub(crate) fn hold_last_values(channels: &mut [Vec<f64>; 3], longest: f64) {
    for channel in channels {
        let values = channel.iter().filter(|v| !v.is_nan()).count();
        let longest = longest * channel.len() as f64 / values.max(1) as f64;
        let (mut last, mut held) = (f64::NAN, 0.0);
        for value in channel {
            if !value.is_nan() {
                (last, held) = (*value, 0.0);
            } else if held < longest {
                *value = last;
                held += 1.0;
            }
        }
    }
}

/// With a gyroscope that reads something, so many rows of zeros in a row are no free fall.
const ZEROS_IN_A_ROW: usize = 5;

/// Rows in which the accelerometer reads zero on all axes, to the last digit: it was not
/// read. Beside a gyroscope that was, a single row may be chance.
fn zero_rows(accel: &[Vec<f64>; 3], gyro: [&Vec<f64>; 3]) -> Vec<usize> {
    let none = |channels: [&Vec<f64>; 3], row: usize| {
        channels
            .iter()
            .all(|c| c.get(row).is_none_or(|v| *v == 0.0))
    };
    let zero = |row: &usize| none(accel.each_ref(), *row);
    let rows = accel[0].len();
    let mut out = Vec::new();
    let mut row = 0;
    // Most recordings have no zero at all, or a few on one axis.
    while let Some(n) = accel[0][row..].iter().position(|v| *v == 0.0) {
        let from = row + n;
        let end = (from..rows).find(|r| !zero(r)).unwrap_or(rows);
        let enough = end - from >= ZEROS_IN_A_ROW;
        out.extend((from..end).filter(|r| enough || none(gyro, *r)));
        row = (end + 1).min(rows);
    }
    out
}

/// Makes empty what was not read.
fn empty_zeros(
    rows: &[usize],
    accel: &mut [Vec<f64>; 3],
    mut gyro: Option<&mut [Vec<f64>; 3]>,
    line_map: &LineMap,
) -> Option<Finding> {
    let mut lines = LineSpans::default();
    for &row in rows {
        lines.push(line_map.line(row));
        accel.iter_mut().for_each(|c| c[row] = f64::NAN);
        if let Some(gyro) = gyro.as_mut().filter(|g| g.iter().all(|c| c[row] == 0.0)) {
            gyro.iter_mut().for_each(|c| c[row] = f64::NAN);
        }
    }
    (!rows.is_empty()).then(|| {
        Finding::warning(
            "zero-rows",
            format!(
                "the accelerometer reads zero on all axes in {} rows: it was not read; taken as empty",
                rows.len()
            ),
        )
        .at_lines(&lines)
    })
}

/// Of the gyroscope no more is held, in usual distances of its values, than rows may be
/// lost.
const GYRO_HELD: f64 = 4.5;

/// More than a fifth of the rows lack a value.
pub(crate) fn is_sparse(channels: &[Vec<f64>; 3]) -> bool {
    let rows = channels[0].len();
    let incomplete = (0..rows)
        .filter(|&i| channels.iter().any(|c| c[i].is_nan()))
        .count();
    incomplete * 5 > rows
}

/// The gyroscope's unit before any turn has been looked at.
pub(crate) fn gyro_by_claim(
    gyro: &[Vec<f64>; 3],
    layout: &Layout,
    options: &ReadOptions,
) -> GyroScale {
    let lsb_per_deg_s = options
        .gyro_range_deg_s
        .map(|range| 32768.0 / range)
        .or(layout.gyro_lsb_per_deg_s);
    if let Some(unit) = options.gyro_unit {
        return GyroScale {
            unit,
            lsb_per_deg_s,
            origin: Origin::Given,
        };
    }
    if let Some(unit) = layout.gyro_claim {
        return GyroScale {
            unit,
            lsb_per_deg_s,
            origin: Origin::Header,
        };
    }
    let integers = gyro
        .iter()
        .all(|c| c.iter().all(|v| v.is_nan() || v.fract() == 0.0));
    let moves = gyro.iter().flatten().any(|v| v.abs() >= 1.0);
    GyroScale {
        unit: if integers && moves {
            GyroUnit::Counts
        } else {
            GyroUnit::Unknown
        },
        lsb_per_deg_s,
        origin: if integers && moves {
            Origin::Data
        } else {
            Origin::Assumed
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gyroscope_is_held_from_reading_to_reading_and_not_on() {
        let nan = f64::NAN;
        // Every other row, until it falls silent.
        let channel: Vec<f64> = (0..40)
            .map(|i| {
                if i % 2 == 0 && i < 20 {
                    f64::from(i)
                } else {
                    nan
                }
            })
            .collect();
        let mut channels = [channel.clone(), channel.clone(), channel];
        assert!(is_sparse(&channels));
        hold_last_values(&mut channels, GYRO_HELD);
        assert_eq!(channels[0][7], 6.0);
        assert_eq!(channels[0][36], 18.0);
        assert!(channels[2][37..].iter().all(|v| v.is_nan()), "{channels:?}");
    }
}

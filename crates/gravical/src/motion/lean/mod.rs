//! The mean of the first rows off, no zero velocity, and nothing asked for but the
//! end: one pass over the file, in flat memory.
//!
//! The result is that of [`motion`](super::motion), field by field. What the first
//! 256 KiB say of unit, clock and rest is held against the whole recording
//! afterwards, and a row that one pass cannot treat as the whole would ends it: then
//! there is no result, and the recording has to be read as a whole.

mod end;
mod sink;
#[cfg(test)]
mod tests;
mod way;

use std::path::Path;
use std::rc::Rc;

use gravical_core::calibration::Calibration;

use super::opening;
use super::prepare::{Prepared, gap_s, prepare, times};
use super::samples::Samples;
use super::still::Rests;
use super::stream::whole_lines;
use super::{Calibrated, MotionOptions, Streamed};
use crate::Result;
use crate::apply::sensor::Sensor;
use crate::apply::stream::Stream;
use crate::apply::watch::Watch;
use crate::denoise::Running;
use crate::recording::names::Quantity;
use crate::recording::open::{Input, open};
use crate::recording::timing::{Claims, Follower, Steps};
use crate::recording::{
    AccelClaim, Finding, ReadOptions, Recording, fits_unsigned, metadata, read_bytes,
};
use crate::segment::face::AxisMap;
use crate::stats::median;

use sink::{Gap, Pass, Scale, Time};
use way::Way;

/// Findings of the first rows after which one pass is not enough: clocks that were
/// not believed or were reset, and columns, units and temperatures that were judged
/// by all values.
const BEYOND: [&str; 11] = [
    "burst-time",
    "frozen-time",
    "time-unit-unknown",
    "restarted-time",
    "absent-time",
    "columns-guessed",
    "temperature-unit",
    "unsigned-counts",
    "zero-tail",
    "zero-rows",
    "truncated-file",
];

/// Rows of the first 256 KiB below which they are not enough to go by.
const LEAST_ROWS: usize = 2000;

/// How far the usual step may be off that of the first rows, relative.
const DOUBT: f64 = 0.02;

/// The result of [`motion`](super::motion) without its table, in one pass and a few
/// MiB, for a recording of any size.
///
/// None where that cannot be had: for options other than the mean of the first rows
/// without zero velocity, with at most one filter, one with a window; for a file that
/// cannot be read twice; and for a recording whose stamps, units or empty cells have
/// to be judged as a whole. [`recording::read`](crate::recording::read) and
/// [`motion`](super::motion) then say all there is to say, errors too.
///
/// # Errors
///
/// `option-range` (usage).
pub fn motion_end(
    path: &Path,
    read: &ReadOptions,
    calibration: Option<Calibrated<'_>>,
    options: &MotionOptions,
) -> Result<Option<Streamed>> {
    options.validate()?;
    read.validate()?;
    if !(fits(options) && !read.hash && path.is_file()) {
        return Ok(None);
    }
    let name = path.display().to_string();
    // What cannot be read here is told by who reads it as a whole.
    let input = open(path, false).ok();
    Ok(input.and_then(|input| end_of(input, &name, read, calibration, options)))
}

fn fits(options: &MotionOptions) -> bool {
    let starts_at_rest = options.v0_mps.is_none_or(|v| v == [0.0; 3]);
    options.rests_at_start() && options.smooth.len() <= 1 && (starts_at_rest || !options.bands)
}

fn end_of(
    mut input: Input,
    name: &str,
    read: &ReadOptions,
    calibration: Option<Calibrated<'_>>,
    options: &MotionOptions,
) -> Option<Streamed> {
    let reader = std::mem::replace(&mut input.reader, Box::new(std::io::empty()));
    let opened = crate::recording::prepare(reader, name, read).ok()?;
    let head = read_bytes(whole_lines(&opened.head, opened.whole), name, read).ok()?;
    let enough = opened.whole || head.rows() > options.still_rows.max(LEAST_ROWS);
    if !enough || is_beyond(&head, read) {
        return None;
    }
    let with_time = opened.layout.field(Quantity::Time).is_some();
    let (time, gap) = clock(&head, with_time)?;
    let running = Running::new(&head, &options.smooth, options.edge).ok()??;
    let prepared = prepare(&head, calibration, options).ok()?;
    let Prepared {
        samples,
        findings,
        scales,
        ..
    } = prepared;
    if !opened.whole && samples.len() <= options.still_rows {
        return None;
    }
    let rests = opening::rests(&samples, options);
    if may_differ(&rests, &samples) {
        return None;
    }
    let drift = calibration
        .and_then(|c| crate::check::accepted_model(c.file))
        .zip(head.temperature_c.as_ref())
        .map(|(model, t_c)| {
            // One that is known only later is another first one.
            let first = t_c.iter().copied().find(|t| t.is_finite())?;
            Some((Rc::new(model.clone()), first))
        });
    let drift = match drift {
        Some(None) => return None,
        drift => drift.flatten(),
    };
    let scale = Scale {
        accel: scales.accel,
        nominal: scales.by_scale,
        offset: head.zero_offset,
        axes: options.axes,
        drift,
    };
    let v0 = options.v0_mps.unwrap_or_default();
    let way = Way::new(options.still_rows, v0, calibration.is_some());
    let with_gyro = opened.layout.has_gyro();
    let with_temperature = head.temperature_c.is_some();
    let pass = Pass::new(
        (time, running, way),
        scale,
        gap,
        [with_gyro, with_temperature],
    );
    let begin = Begin {
        rests,
        prepared: findings,
        read: opened.findings,
        claims: Claims {
            unit: read.time_unit.or(opened.layout.time_claim),
            nominal_rate_hz: read
                .rate_hz
                .or_else(|| metadata::rate_hz(&opened.dialect.metadata)),
            temperature_span_c: 0.0,
        },
        accel_claim: opened.layout.accel_claim,
        head,
    };
    let usual_step = pass.usual_step();
    let stream = Stream::new(
        pass,
        Sensor::of(Calibration::identity(), None, AxisMap::default()),
        Watch::new(
            begin.head.accel_scale,
            begin.head.zero_offset,
            begin.head.resolution,
            begin.head.gyro_scale,
        ),
        None,
        usual_step,
        [false; 2],
        &opened.dialect,
        &opened.layout,
    );
    let mut nowhere = std::io::sink();
    let done = stream.run(opened.lines, &input, name, &mut nowhere).ok()?;
    let result = begin.result(done, read, calibration, options)?;
    let mut described = input.unpacked.clone();
    described.push(opened.dialect.description());
    Some(Streamed {
        result,
        head: Recording {
            description: described.join(", "),
            ..begin.head
        },
    })
}

/// What the first rows tell.
struct Begin {
    head: Recording,
    rests: Rests,
    /// What was said about the columns.
    read: Vec<Finding>,
    /// … about calibration and samples.
    prepared: Vec<Finding>,
    claims: Claims,
    accel_claim: AccelClaim,
}

/// Rounding counts in the noise at rest, and the whole recording may tell of finer
/// steps than its first rows do.
fn may_differ(rests: &Rests, samples: &Samples) -> bool {
    let [x, y, z, ..] = samples.resolution;
    rests.accel.is_some_and(|noise| {
        let coarse = |(sigma, step): (&f64, f64)| *sigma < 2.0 * step;
        noise.sigma.iter().zip([x, y, z]).any(coarse)
    })
}

/// The first rows already ask for the recording as a whole.
fn is_beyond(head: &Recording, read: &ReadOptions) -> bool {
    let rows = head.rows() as u64;
    head.findings.iter().any(|f| {
        let held = f.kind == "empty-cells" && 5 * f.count > rows;
        held || BEYOND.contains(&f.kind.as_str())
    }) || (read.zero_offset.is_none() && fits_unsigned(&head.accel))
}

/// The time of the rows, and when one is too long after the one before.
fn clock(head: &Recording, with_time: bool) -> Option<(Time, Gap)> {
    let gap = gap_s(&times(head).ok()?);
    let Some(time_s) = &head.time_s else {
        let rate_hz = head.timing.rate_hz().filter(|_| !with_time)?;
        // All steps are alike.
        let gap = Gap {
            longest_s: gap,
            margin_s: 0.0,
        };
        return Some((Time::Rows { rate_hz }, gap));
    };
    let mut rising: Vec<f64> = time_s
        .windows(2)
        .map(|w| w[1] - w[0])
        .filter(|step| *step > 0.0)
        .collect();
    let step_s = median(&mut rising)?;
    let per_s = head.timing.unit?.seconds();
    let usual = step_s / per_s;
    let time = Time::Stamps {
        follower: Box::new(Follower::new(usual, per_s)),
        steps: Steps::new(usual, per_s),
    };
    // The shortest gap is the same for all that are sampled fast enough.
    let depends = 5.0 * (1.0 + DOUBT) * step_s >= gap;
    let gap = Gap {
        longest_s: gap,
        margin_s: if depends { DOUBT * gap } else { 0.0 },
    };
    Some((time, gap))
}

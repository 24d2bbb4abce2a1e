//! What comes of a writing, held against what comes of the plain one.

use std::collections::HashMap;

use gravical::calibrate::{Calibrated, calibrate};
use gravical::calibration_file::{Calibration, Grade, Gyroscope, Source};
use gravical::finding::Advice;
use gravical::inspect::{Inspection, inspect};
use gravical::motion::{Motion, MotionOptions, motion};
use gravical::recording::source::Named;
use gravical::recording::{
    AccelUnit, Finding, GyroUnit, ReadOptions, Recording, TimeUnit, join_gyroscope, read_bytes,
};
use gravical_core::matrix3;
use gravical_signal::{BLOCK_S, block_len};

use super::form::session::{Session, session as session_of};
use super::form::write::{File, columns_option, write};
use super::form::{Clock, Decimals, Rate, Scene, Sensors, Values, Writing};
use crate::support::with_gravity;

const GRAVITY_MPS2: f64 = 9.80665;
/// Options that may be needed, in the order in which they are given.
const OPTIONS: [&str; 5] = ["columns", "accel_unit", "gyro_unit", "time_unit", "rate"];

/// The sessions of the simulator, and what their plain writings give.
#[derive(Default)]
pub struct Judge {
    sessions: HashMap<(Scene, Rate), Session>,
    plain: HashMap<Writing, Outcome>,
}

/// What a session gives.
struct Outcome {
    seen: Vec<Inspection>,
    /// Counts, or units, of one m/s².
    nominal: f64,
    result: Given,
    said: Said,
}

/// Everything that was said.
struct Said {
    text: String,
    options: Vec<Advice>,
}

enum Given {
    Calibration(Box<Calibrated>),
    Motion(Box<Motion>),
}

impl Judge {
    /// Reads a writing of a session of the simulator, follows the hints while it is not as it should
    /// be, and says what is wrong at last, if anything is.
    pub fn judge(&mut self, writing: &Writing) -> Option<String> {
        let (scene, rate) = (writing.scene, writing.rate);
        let session = self.sessions.entry((scene, rate));
        let session = session.or_insert_with(|| session_of(scene, rate));
        let mut plain = Writing::plain(scene, rate);
        if writing.sensors == Sensors::AccelerometerOnly {
            plain.sensors = Sensors::AccelerometerOnly;
        }
        let plain = self.plain.entry(plain).or_insert_with(|| {
            outcome(&plain, session, &[]).unwrap_or_else(|why| panic!("plain: {}", why.text))
        });
        let mut options: Vec<&'static str> = Vec::new();
        loop {
            let (complaints, said) = match outcome(writing, session, &options) {
                Ok(outcome) => {
                    let rate_hz = session.rate_hz;
                    (compare(writing, rate_hz, plain, &outcome), outcome.said)
                }
                Err(why) => (vec![why.text.clone()], why),
            };
            let is_advised = |option: &str| said.options.iter().any(|o| o.name == option);
            let mut left = OPTIONS.iter().filter(|o| !options.contains(o));
            match left.find(|o| is_advised(o)) {
                _ if complaints.is_empty() => return None,
                Some(option) => options.push(option),
                None => {
                    let complaints = complaints.join("\n  ");
                    return Some(format!("{writing:?}\n  with {options:?}\n  {complaints}"));
                }
            }
        }
    }
}

/// What the user says who knows the recording.
fn known(writing: &Writing, rate_hz: f64, options: &[&str]) -> ReadOptions {
    let mut out = ReadOptions::default();
    let counts = writing.values == Values::Counts;
    for option in options {
        match *option {
            "columns" => out.columns = Some(columns_option(writing).parse().unwrap()),
            "accel_unit" => {
                out.accel_unit = Some(match writing.values {
                    Values::GRad | Values::GDeg => AccelUnit::StandardGravity,
                    Values::MilliGDeg => AccelUnit::MilliGravity,
                    Values::Counts => AccelUnit::Counts,
                    _ => AccelUnit::MetrePerSecondSquared,
                });
                out.accel_range_g = counts.then(|| 32768.0 / writing.range.lsb_per_g());
            }
            "gyro_unit" => {
                use Values::{GRad, Mislabelled, Mps2Rad};
                out.gyro_unit = Some(match writing.values {
                    Values::Counts => GyroUnit::Counts,
                    Mps2Rad | GRad | Mislabelled => GyroUnit::RadianPerSecond,
                    _ => GyroUnit::DegreePerSecond,
                });
                out.gyro_range_deg_s = counts.then(|| 32768.0 / writing.range.lsb_per_deg_s());
            }
            "time_unit" => {
                out.time_unit = Some(match writing.clock {
                    Clock::Milliseconds | Clock::EpochMilliseconds => TimeUnit::Millisecond,
                    Clock::Microseconds => TimeUnit::Microsecond,
                    Clock::Minutes => TimeUnit::Minute,
                    Clock::Days => TimeUnit::Day,
                    Clock::EpochNanoseconds => TimeUnit::Nanosecond,
                    _ => TimeUnit::Second,
                });
            }
            "rate" => out.rate_hz = Some(rate_hz),
            other => panic!("{other}"),
        }
    }
    out
}

fn said(findings: &[Finding]) -> Said {
    let words = |f: &Finding| format!("{}: {}\n", f.kind, f.message);
    Said {
        text: findings.iter().map(words).collect(),
        options: findings.iter().flat_map(|f| f.options.clone()).collect(),
    }
}

fn outcome(writing: &Writing, session: &Session, options: &[&str]) -> Result<Outcome, Said> {
    let options = known(writing, session.rate_hz, options);
    let words = |e: gravical::Error| Said {
        text: format!("{e:?}"),
        options: e.options().to_vec(),
    };
    let mut recordings: Vec<Recording> = Vec::new();
    for written in write(writing, session) {
        let File { name, bytes } = &written.file;
        let mut recording = read_bytes(bytes, name, &options).map_err(words)?;
        if let Some(File { name, bytes }) = &written.gyro {
            join_gyroscope(&mut recording, Named::Bytes(name.as_ref(), bytes), &options)
                .map_err(words)?;
        }
        recordings.push(recording);
    }
    let axes = gravical::poses::face::AxisMap::default();
    let seen: Vec<Inspection> = recordings.iter().map(|r| inspect(r, &axes)).collect();
    let nominal = recordings[0].units.accel.nominal().unwrap_or(f64::NAN);
    let mut findings: Vec<Finding> = seen.iter().flat_map(|s| s.findings.clone()).collect();
    let result = match writing.scene {
        Scene::Line => motion(&recordings[0], None, &MotionOptions::default())
            .map(|m| Given::Motion(Box::new(m))),
        _ => calibrate(&recordings, &with_gravity(GRAVITY_MPS2))
            .map(|c| Given::Calibration(Box::new(c))),
    };
    let result = result.map_err(|e| {
        let (mut why, before) = (words(e), said(&findings));
        why.text += &format!("\n{}", before.text);
        why.options.extend(before.options);
        why
    })?;
    findings.extend(match &result {
        Given::Calibration(c) => c.calibration.findings.clone(),
        Given::Motion(m) => m.result.findings.clone(),
    });
    let said = said(&findings);
    Ok(Outcome {
        seen,
        nominal,
        result,
        said,
    })
}

/// One step of the rounding, m/s² and rad/s.
fn steps(writing: &Writing) -> [f64; 2] {
    let decimal = 0.1_f64.powi(writing.decimals.digits() as i32);
    let degree = 1.0_f64.to_radians();
    match writing.values {
        Values::Counts => [
            GRAVITY_MPS2 / writing.range.lsb_per_g(),
            degree / writing.range.lsb_per_deg_s(),
        ],
        Values::Mps2Rad | Values::Mislabelled => [decimal, decimal],
        Values::Mps2Deg => [decimal, decimal * degree],
        Values::GRad => [GRAVITY_MPS2 * decimal, decimal],
        Values::GDeg => [GRAVITY_MPS2 * decimal, decimal * degree],
        Values::MilliGDeg => [1e-3 * GRAVITY_MPS2 * decimal, decimal * degree],
    }
}

fn compare(writing: &Writing, rate_hz: f64, plain: &Outcome, own: &Outcome) -> Vec<String> {
    let mut wrong = stills(writing, rate_hz, plain, own);
    match (&plain.result, &own.result) {
        (Given::Calibration(p), Given::Calibration(o)) => {
            let sigma = p.segmentation.noise.sigma.iter().sum::<f64>() / 3.0;
            wrong.extend(calibrations(
                writing,
                sigma,
                own,
                &p.calibration,
                &o.calibration,
            ));
        }
        (Given::Motion(p), Given::Motion(o)) => wrong.extend(motions(writing, p, o)),
        _ => wrong.push("another kind of result".to_owned()),
    }
    if !wrong.is_empty() {
        wrong.extend(own.said.text.lines().map(|l| format!("  said {l}")));
    }
    wrong
}

/// The same stills, to two blocks of 0.2 s: they end where a block does, and the outermost block is left
/// out (docs/method.md). What the rounding hides of the beginning of a motion is no difference either.
fn stills(writing: &Writing, rate_hz: f64, plain: &Outcome, own: &Outcome) -> Vec<String> {
    let mut wrong = Vec::new();
    if plain.seen.len() != own.seen.len() {
        return vec![format!("{} recordings", own.seen.len())];
    }
    // A motion of the hand leaves one step of the rounding after some samples: at 1 m/s³
    // and 0.5 rad/s² to begin with.
    let [accel, gyro] = steps(writing);
    let hidden_s = if writing.has_gyro() {
        (gyro / 0.5).sqrt()
    } else {
        1.0
    };
    let hidden_s = hidden_s.min(accel / 1.0);
    let block = block_len(1.0 / rate_hz, BLOCK_S) as f64;
    let slack = 2.0 * block + 2.0 + hidden_s * rate_hz;
    // A placement that is never quite at rest is a static interval or not by the last digit, and its
    // longest quiet part is used in either case.
    let mut both = [plain, own].into_iter();
    let is_unsteady = both.any(|o| o.said.text.contains("unsteady-pose"));
    for (p, o) in plain.seen.iter().zip(&own.seen) {
        let counts = [&p.static_intervals, &o.static_intervals].map(Vec::len);
        if is_unsteady && matches!(counts, [0, 1] | [1, 0]) {
            continue;
        }
        if let Some(other) = other_number("static intervals", counts) {
            wrong.push(other);
            continue;
        }
        for (p, o) in p.static_intervals.iter().zip(&o.static_intervals) {
            let off = |a: usize, b: usize| a.abs_diff(b) as f64 > slack;
            if off(p.start_row, o.start_row) || off(p.end_row, o.end_row) {
                let [p, o] = [p, o].map(|s| s.start_row..s.end_row);
                wrong.push(format!("still {o:?} in place of {p:?} (slack {slack:.0})"));
            }
        }
    }
    wrong
}

fn other_number(what: &str, [plain, own]: [usize; 2]) -> Option<String> {
    (plain != own).then(|| format!("{own} {what} in place of {plain}"))
}

fn rank(grade: Grade) -> u8 {
    match grade {
        Grade::Good => 3,
        Grade::Fair => 2,
        Grade::NotVerifiable => 1,
        Grade::Poor => 0,
    }
}

/// `sigma_mps2` is the noise of a sample before it was rounded.
fn calibrations(
    writing: &Writing,
    sigma_mps2: f64,
    own: &Outcome,
    p: &Calibration,
    o: &Calibration,
) -> Vec<String> {
    let mut wrong = Vec::new();
    let [step, _] = steps(writing);
    let (ps, os) = (&p.accelerometer, &o.accelerometer);
    if let Some(other) = other_number("poses", [&p.poses, &o.poses].map(Vec::len)) {
        return vec![other];
    }
    // What rounding adds: its own part of the budget, what of it the noise averages, and
    // noise of the rows that a still has more or fewer (see `static_intervals`).
    let part = |source: Source| -> f64 {
        let budget = o.reliability.budget.iter().flat_map(|b| &b.contributions);
        let parts = budget.filter(|c| c.source == source);
        parts.filter_map(|c| c.norm_mps2).sum()
    };
    let averaged = (step / 12.0_f64.sqrt() / sigma_mps2).min(1.0);
    let rows = p.poses.iter().zip(&o.poses).map(|(p, o)| (p.rows, o.rows));
    let other_rows = rows.map(|(p, o)| p.abs_diff(o) as f64 / p.max(o) as f64);
    let other_rows = other_rows.fold(0.0, f64::max);
    let noise = part(Source::Noise) * averaged.max((2.0 * other_rows).sqrt());
    let allowed = 3.0 * part(Source::Quantisation).hypot(noise) + 2e-5;
    // The plain one is in m/s².
    let ratio = own.nominal;
    let m = matrix3::scale_rows(&ps.orientation(), &ps.scale());
    let (mut worst, mut squares, mut turned) = (0.0_f64, 0.0, 0.0_f64);
    let directions = directions();
    for n in &directions {
        let f = n.map(|v| GRAVITY_MPS2 * v);
        let reading = matrix3::mul_vec(&m, &f);
        let raw = std::array::from_fn(|i| ratio * (reading[i] + ps.bias[i]) - os.bias[i]);
        let a = matrix3::mul_vec(&os.matrix, &raw);
        let off = matrix3::norm(&a) - GRAVITY_MPS2;
        squares += off * off;
        worst = worst.max(off.abs());
        turned = turned.max(matrix3::norm(&matrix3::sub(&a, &f)));
    }
    let rms = (squares / directions.len() as f64).sqrt();
    if rms.is_nan() || rms > allowed {
        let [off, worst, most] = [rms, worst, allowed].map(|v| 1e3 * v);
        wrong.push(format!(
            "‖a‖ is {off:.3} mm/s² rms away from the plain calibration (at most {worst:.3}), rounding {most:.3}"
        ));
    }
    // Directions follow the faces, which lie as they lie.
    if turned > 3.0 * allowed + 0.05 * step {
        wrong.push(format!("turned by {:.3} mm/s² of gravity", 1e3 * turned));
    }
    let (was, is) = (rank(p.verdict().grade), rank(o.verdict().grade));
    let fine = step / 12.0_f64.sqrt() < 0.2 * sigma_mps2;
    if is > was || (fine && is < was) {
        let (was, is) = (p.verdict().grade, &o.verdict());
        wrong.push(format!("{is:?} in place of {was:?}"));
    }
    match (&p.gyroscope, &o.gyroscope) {
        (Some(p), Some(o)) => wrong.extend(gyroscopes(writing, p, o)),
        (None, None) => {}
        (Some(_), None) => wrong.push("no gyroscope".to_owned()),
        (None, Some(_)) => wrong.push("a gyroscope".to_owned()),
    }
    wrong
}

fn gyroscopes(writing: &Writing, p: &Gyroscope, o: &Gyroscope) -> Vec<String> {
    let mut wrong = Vec::new();
    let per_rad_s = match o.input_unit {
        GyroUnit::RadianPerSecond => 1.0,
        GyroUnit::DegreePerSecond => 1.0_f64.to_degrees(),
        GyroUnit::Counts => writing.range.lsb_per_deg_s() * 1.0_f64.to_degrees(),
        GyroUnit::Unknown => f64::NAN,
    };
    let (was, is) = (p.method, o.method);
    if was != is {
        return vec![format!("gyroscope by {is:?} in place of {was:?}")];
    }
    let [_, step] = steps(writing);
    for i in 0..3 {
        let bias = o.bias[i] / per_rad_s - p.bias[i];
        let covariance = p.covariance.as_ref();
        let sd = covariance.and_then(|c| Some(c.values.last()?.last()?.sqrt()));
        if bias.is_nan() || bias.abs() > 0.6 * step + 2.0 * sd.unwrap_or(0.0) + 2e-5 {
            wrong.push(format!("bias of g{i} off by {bias:.6} rad/s, step {step}"));
        }
        let scale = o.scale()[i] / per_rad_s / p.scale()[i] - 1.0;
        // Turns of a second or two at 1 rad/s and more; 0.1 % is a third of what they tell. Motions are
        // closed by the accelerometer: what its steps do to them, they say.
        let sd = o.deviations().and_then(|(_, scale)| scale);
        let sd = sd.map(|scale| scale[i] / o.scale()[i]);
        if scale.is_nan() || scale.abs() > 0.6 * step + 2.0 * sd.unwrap_or(0.0) + 1e-3 {
            wrong.push(format!("scale of g{i} off by {scale:.6}, step {step:.6}"));
        }
    }
    wrong
}

fn motions(writing: &Writing, p: &Motion, o: &Motion) -> Vec<String> {
    let mut wrong = Vec::new();
    let (p, o) = (&p.result, &o.result);
    // Steps of 0.01 hide a slow move among many samples, or part a rest: no defect of the writing.
    if writing.decimals == Decimals::Two && writing.rate.hz() >= 500.0 {
        return wrong;
    }
    if let Some(other) = other_number("moves", [&p.moves, &o.moves].map(Vec::len)) {
        return vec![other];
    }
    let noise = p.noise.map_or(0.0, |n| n.accel_n[0]);
    let sigma_mps2 = noise * writing.rate.hz().sqrt();
    let fine = steps(writing)[0] / 12.0_f64.sqrt() < 0.2 * sigma_mps2;
    for (p, o) in p.moves.iter().zip(&o.moves) {
        let (Some(was), Some(is), Some(s)) = (p.displacement_m, o.displacement_m, o.sigma_m) else {
            wrong.push("a move without a displacement".to_owned());
            continue;
        };
        for i in 0..3 {
            let off = (is[i] - was[i]).abs();
            // Rounding adds what noise does, at most, and says so.
            let most = if fine { 0.5 } else { 2.0 } * s[i];
            if off.is_nan() || off > most + 1e-4 {
                let [is, s, was] = [is, s, was].map(|v| v[i]);
                wrong.push(format!("{is:.4} ± {s:.4} m in place of {was:.4}"));
            }
        }
    }
    wrong
}

/// To the corners, edges and faces of a cube.
fn directions() -> Vec<[f64; 3]> {
    let corners = (0..27).map(|k| [k / 9 - 1, k / 3 % 3 - 1, k % 3 - 1].map(f64::from));
    let outer = corners.filter(|v| matrix3::norm(v) > 0.0);
    outer.map(|v| v.map(|c| c / matrix3::norm(&v))).collect()
}

//! The verbs of the program: each takes its options from the keywords, then it runs.

use std::path::{Path, PathBuf};
use std::slice::from_ref;
use std::sync::Arc;

use gravical::calibration_file::{Calibration, InputFile};
use gravical::motion::Motion;
use gravical::output::write_atomic;
use gravical::poses::SegmentOptions;
use gravical::recording::{Recording, read, read_samples, source};
use gravical::session::{SessionFiles, calibrate_files, read_session};
use gravical::simulate::{Scenario, SimulateOptions, simulate_to};
use gravical::targets::check_targets;
use gravical::{Error, Result, apply, calibrate, check, compare, denoise, inspect, motion, noise};
use gravical_report::document::Document;
use gravical_report::figure::{self, Figure};
use gravical_report::report;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use serde::Deserialize;

use crate::keywords::Keywords;
use crate::outcome::{Kind, Outcome, Table, json};
use crate::recording::{Inputs, Reading, owned};
use crate::task;

/// What a verb is given.
struct Call {
    /// Of the verb: those of reading are taken.
    keywords: Keywords,
    reading: Reading,
    /// With their names.
    calibrations: Vec<(Arc<Calibration>, String)>,
    /// A file to write, and whether it may be there.
    output: Option<(PathBuf, bool)>,
}

impl Call {
    /// The last calibration that is left.
    fn calibration(&mut self) -> Result<(Arc<Calibration>, String)> {
        let last = self.calibrations.pop();
        last.ok_or_else(|| Error::usage("usage", "there is no calibration"))
    }
}

/// A result whose figures and document are drawn when they are asked for.
fn plain<T: Send + Sync + 'static>(
    result: &Arc<T>,
    figures: impl Fn(&T) -> Vec<Figure> + Send + Sync + 'static,
    document: for<'a> fn(&T, &'a [Figure]) -> Document<'a>,
) -> Kind {
    let (one, other) = (result.clone(), result.clone());
    let draw = Box::new(move || figures(&other));
    Kind::Plain(Box::new(move |figures| document(&one, figures)), draw)
}

/// Runs a verb.
#[pyfunction]
pub fn run(
    py: Python<'_>,
    verb: &str,
    inputs: Inputs,
    calibrations: Vec<(Py<Outcome>, String)>,
    output: Option<(PathBuf, bool)>,
    mut keywords: Keywords,
) -> PyResult<Outcome> {
    let work: fn(Call) -> Result<Outcome> = match verb {
        "inspect" => inspect,
        "calibrate" => calibrate,
        "apply" => apply,
        "denoise" => denoise,
        "noise" => estimate_noise,
        "check" => check,
        "compare" => compare,
        "motion" => motion,
        "orient" => orient,
        _ => return Err(PyValueError::new_err(format!("there is no verb {verb:?}"))),
    };
    let named = |(outcome, name): (Py<Outcome>, String)| Ok((outcome.get().file()?, name));
    let calibrations: Result<Vec<_>> = calibrations.into_iter().map(named).collect();
    task::run(py, move |meter| {
        let reading = Reading::new(inputs, &mut keywords, meter)?;
        work(Call {
            keywords,
            reading,
            calibrations: calibrations?,
            output,
        })
    })
}

fn inspect(mut call: Call) -> Result<Outcome> {
    let options: SegmentOptions = call.keywords.last()?;
    let rows = call.reading.one(|path, how| read(path, how))?;
    let found = inspect::inspect(&rows, &options.axes);
    let inputs = InputFile::of(from_ref(&*rows));
    let found = Arc::new(found);
    let figures = move |found: &_| figure::inspection::inspection(found, &rows);
    let document = plain(&found, figures, report::inspection);
    Outcome::new(document, &*found, inputs)
}

fn calibrate(mut call: Call) -> Result<Outcome> {
    let (k, reading) = (&mut call.keywords, call.reading);
    let gravity = k.gravity()?;
    let mut options = calibrate::CalibrateOptions {
        segment: k.take()?,
        gravity: gravity.unwrap_or_default(),
        estimate: k.take()?,
        record: k.take()?,
        ..calibrate::CalibrateOptions::default()
    };
    options.validate()?;
    let files: SessionFiles = k.last()?;
    files.read_into(&mut options, &reading.options)?;
    let (recordings, done) = match &reading.inputs {
        Inputs::Paths(paths) => {
            let gyro = reading.gyro.as_deref();
            calibrate_files(paths, gyro, &reading.options, &options, gravity)?
        }
        Inputs::Recordings(all) => {
            let recordings = owned(all);
            let done = calibrate::calibrate(&recordings, &options)?;
            (recordings, done)
        }
    };
    let session = Box::new((recordings, done.segmentation));
    Outcome::calibration(done.calibration, Some(session))
}

fn apply(mut call: Call) -> Result<Outcome> {
    let options: apply::ApplyOptions = call.keywords.last()?;
    let (file, _) = call.calibration()?;
    let (summary, table) = match call.output {
        Some((path, force)) => {
            let summary = apply_to_file(&file, &call.reading, options, &path, force)?;
            (summary, None)
        }
        None if options.keep_raw => {
            let what = "keep_raw=: columns in memory stay as they are";
            return Err(Error::usage("usage", what).with_hint("it needs output="));
        }
        None => {
            let rows = call.reading.one(|path, how| read_samples(path, how))?;
            let done = apply::apply_recording(&file, &rows, &options)?;
            let table = Table::of_applied(&done, rows.time_s.as_deref());
            (done.summary, Some(table))
        }
    };
    let said = format!("{}: {} rows calibrated", summary.input, summary.rows);
    let mut document = Document::new(&said).with_findings(&summary.findings, false);
    document.subject.push(said);
    let mut outcome = Outcome::new(
        Kind::Plain(Box::new(move |_| document.clone()), Box::new(Vec::new)),
        &summary,
        Vec::new(),
    )?;
    outcome.table = table;
    Ok(outcome)
}

/// From one file to another, as the program does.
fn apply_to_file(
    file: &Calibration,
    reading: &Reading,
    mut options: apply::ApplyOptions,
    path: &Path,
    force: bool,
) -> Result<apply::ApplySummary> {
    let input = match &reading.inputs {
        Inputs::Paths(paths) if paths.len() == 1 => &paths[0],
        _ => {
            let what = "output=: it goes from one file to another";
            let hint = "give the path of the recording, or leave out output=";
            return Err(Error::usage("usage", what).with_hint(hint));
        }
    };
    options.gyro.clone_from(&reading.gyro);
    options.read = reading.options.clone();
    options.read.hash = false;
    let inputs: Vec<PathBuf> = [input].into_iter().chain(&options.gyro).cloned().collect();
    check_targets(&[path.to_owned()], &inputs, force)?;
    let source = source::open(input, &options.read)?;
    let name = input.display().to_string();
    write_atomic(path, force, |out| {
        apply::apply(file, source, &name, out, &options)
    })
}

fn denoise(mut call: Call) -> Result<Outcome> {
    let options: denoise::DenoiseOptions = call.keywords.last()?;
    options.validate()?;
    let raw = call.reading.one(|path, how| read_samples(path, how))?;
    let inputs = InputFile::of(from_ref(&*raw));
    let mut recording = Recording::clone(&raw);
    let summary = denoise::denoise(&mut recording, &options)?;
    let (summary, recording) = (Arc::new(summary), Arc::new(recording));
    let filtered = recording.clone();
    let figures = move |summary: &_| {
        let mut figures = figure::denoise::denoise(summary);
        figures.extend(figure::denoise::before_and_after(&raw, &filtered));
        figures
    };
    let kind = plain(&summary, figures, report::denoise);
    let mut outcome = Outcome::new(kind, &*summary, inputs)?;
    outcome.filtered = Some(recording);
    Ok(outcome)
}

fn estimate_noise(call: Call) -> Result<Outcome> {
    call.keywords.end()?;
    let rows = call.reading.one(|path, how| read_samples(path, how))?;
    let result = Arc::new(noise::noise_of(Arc::unwrap_or_clone(rows))?);
    let inputs = result.inputs.clone();
    Outcome::new(Kind::Noise(result.clone()), &*result, inputs)
}

fn check(mut call: Call) -> Result<Outcome> {
    let gravity = call.keywords.gravity()?;
    let options = check::CheckOptions {
        gravity,
        ..call.keywords.last()?
    };
    let (file, name) = call.calibration()?;
    let reading = call.reading;
    let (rows, left_out) = match &reading.inputs {
        Inputs::Paths(paths) => read_session(paths, reading.gyro.as_deref(), &reading.options)?,
        Inputs::Recordings(all) => (owned(all), Vec::new()),
    };
    let mut result = check::check(&file, &name, &rows, &options)?;
    result.findings.extend(left_out);
    let inputs = InputFile::of(&rows);
    let result = Arc::new(result);
    let kind = plain(&result, figure::check::check, report::check);
    Outcome::new(kind, &*result, inputs)
}

fn compare(mut call: Call) -> Result<Outcome> {
    call.keywords.end()?;
    let (second, second_name) = call.calibration()?;
    let (first, first_name) = call.calibration()?;
    let names = [first_name.as_str(), second_name.as_str()];
    let result = compare::compare(&first, &second, names)?;
    let result = Arc::new(result);
    let kind = plain(&result, figure::check::comparison, report::comparison);
    Outcome::new(kind, &*result, Vec::new())
}

fn motion(call: Call) -> Result<Outcome> {
    let (motion, rows, inputs) = compute_motion(call)?;
    let mut outcome = Outcome::new(Kind::Motion(motion.clone(), rows), &motion.result, inputs)?;
    outcome.table = Some(Table::new(&motion.table()));
    Ok(outcome)
}

/// Columns of an orientation.
#[derive(Default, Deserialize)]
#[serde(default)]
struct OrientationColumns {
    acceleration: bool,
}

fn orient(mut call: Call) -> Result<Outcome> {
    let OrientationColumns { acceleration } = call.keywords.take()?;
    let (motion, rows, inputs) = compute_motion(call)?;
    let result = Arc::new(motion.orientation()?);
    let table = Table::new(&motion.orientation_table(acceleration));
    let kind = Kind::Orientation(motion, result.clone(), rows, acceleration);
    let mut outcome = Outcome::new(kind, &*result, inputs)?;
    outcome.table = Some(table);
    Ok(outcome)
}

type Moved = (Arc<Motion>, Arc<Recording>, Vec<InputFile>);

fn compute_motion(mut call: Call) -> Result<Moved> {
    let options = motion::MotionOptions {
        gravity: call.keywords.gravity()?,
        meter: call.reading.options.meter.clone(),
        ..call.keywords.take()?
    };
    options.validate()?;
    call.keywords.end()?;
    let rows = call.reading.one(|path, how| read_samples(path, how))?;
    let calibration = call.calibrations.first();
    let calibrated = calibration.map(|(file, name)| (&**file, &**name));
    let motion = motion::motion(&rows, calibrated, &options)?;
    let inputs = InputFile::of(from_ref(&*rows));
    Ok((Arc::new(motion), rows, inputs))
}

/// Writes simulated recordings; the truth as JSON, and the paths, that of the truth last.
#[pyfunction]
pub fn simulate(
    py: Python<'_>,
    scenario: String,
    output: PathBuf,
    force: bool,
    mut keywords: Keywords,
) -> PyResult<(String, Vec<PathBuf>)> {
    task::run(py, move |_| {
        let k = &mut keywords;
        let scenario = match scenario.as_str() {
            "six-position" => Scenario::SixPosition(k.take()?),
            "poses" => Scenario::Poses(k.take()?),
            "static" => Scenario::Static(k.take()?),
            "line" => Scenario::Line(k.take()?),
            other => {
                let error = Error::usage("usage", format!("{other:?} is no scenario"));
                return Err(error.with_hint("one of six-position, poses, static, line"));
            }
        };
        let options = SimulateOptions {
            scenario,
            sensor: k.take()?,
            file: k.take()?,
            ..k.last()?
        };
        let (truth, paths) = simulate_to(&options, &output, force)?;
        Ok((json(&truth)?, paths))
    })
}

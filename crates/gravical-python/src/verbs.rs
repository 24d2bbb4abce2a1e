//! The verbs of the program: each takes its options from the keywords, then it runs.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::slice::from_ref;
use std::sync::Arc;

use gravical::apply::{ApplyOptions, apply_recording};
use gravical::calibrate::CalibrateOptions;
use gravical::calibration_file::{CalibrationFile, InputFile, NoiseSection};
use gravical::check::CheckOptions;
use gravical::denoise::{DenoiseOptions, denoise_file};
use gravical::inspect::InspectOptions;
use gravical::motion::truth::{add_comparison, read_reference};
use gravical::motion::{Calibrated, MotionOptions};
use gravical::noise::{noise, noise_of};
use gravical::output::write_atomic;
use gravical::recording::{Meter, ReadOptions, source};
use gravical::session::{Session, SessionFiles, calibrate_recordings, read_session};
use gravical::simulate::{Scenario, SimulateOptions, simulate_to};
use gravical::targets::check_targets;
use gravical::{Error, Result};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::keywords::Keywords;
use crate::outcome::{Kind, Outcome, Table};
use crate::recording::{Inputs, Reading, json};
use crate::task;

/// What a verb is given.
struct Call {
    /// Of the verb: those of reading are taken.
    keywords: Keywords,
    reading: Reading,
    /// With their names.
    calibrations: Vec<(Arc<CalibrationFile>, String)>,
    /// With its file, if it was read.
    noise: Option<(NoiseSection, Vec<InputFile>)>,
    output: Option<Output>,
    meter: Meter,
}

impl Call {
    /// The last calibration that is left.
    fn calibration(&mut self) -> Result<(Arc<CalibrationFile>, String)> {
        let last = self.calibrations.pop();
        last.ok_or_else(|| Error::usage("usage", "there is no calibration"))
    }
}

/// A file that is written, and whether it may be there.
#[derive(FromPyObject)]
pub struct Output(PathBuf, bool);

impl Output {
    /// From the one file that is read to this one.
    fn write<T>(
        &self,
        reading: &Reading,
        write: impl FnOnce(&Path, &mut dyn Write) -> Result<T>,
    ) -> Result<T> {
        let Output(path, force) = self;
        let Some([input]) = reading.paths() else {
            let what = "output=: it goes from one file to another";
            return Err(Error::usage("usage", what)
                .with_hint("give the path of the recording, or leave out output="));
        };
        let inputs: Vec<PathBuf> = std::iter::once(input)
            .chain(&reading.gyro)
            .cloned()
            .collect();
        check_targets(from_ref(path), &inputs, *force)?;
        write_atomic(path, *force, |out| write(input, out))
    }
}

/// Runs a verb.
#[pyfunction]
pub fn run(
    py: Python<'_>,
    verb: &str,
    inputs: Inputs,
    calibrations: Vec<(Py<Outcome>, String)>,
    noise: Option<Py<Outcome>>,
    output: Option<Output>,
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
        _ => return Err(PyValueError::new_err(format!("there is no verb {verb:?}"))),
    };
    let named = |(outcome, name): (Py<Outcome>, String)| Ok((outcome.get().file()?, name));
    let calibrations: Result<Vec<_>> = calibrations.into_iter().map(named).collect();
    let noise = noise.map(|outcome| outcome.get().noise()).transpose();
    let meter = Meter::default();
    task::run(py, &meter.clone(), move || {
        let reading = Reading::new(inputs, &mut keywords, &meter)?;
        work(Call {
            keywords,
            reading,
            calibrations: calibrations?,
            noise: noise?,
            output,
            meter,
        })
    })
}

fn inspect(mut call: Call) -> Result<Outcome> {
    let options: InspectOptions = call.keywords.last()?;
    let rows = call.reading.one()?;
    let found = gravical::inspect::inspect(&rows, &options.axes);
    let inputs = InputFile::of(from_ref(&*rows));
    Ok(Outcome::new(Kind::Inspection(Box::new(found)), inputs))
}

fn calibrate(mut call: Call) -> Result<Outcome> {
    let (k, reading) = (&mut call.keywords, call.reading);
    let gravity = k.gravity()?;
    let mut options = CalibrateOptions {
        segment: k.take()?,
        gravity: gravity.unwrap_or_default(),
        estimate: k.take()?,
        record: k.take()?,
        ..CalibrateOptions::default()
    };
    options.validate()?;
    let files: SessionFiles = k.last()?;
    files.read_into(&mut options, &reading.options)?;
    let mut done = match reading.paths() {
        Some(paths) => Session {
            inputs: paths,
            gyro: reading.gyro.as_deref(),
            read: &reading.options,
            options: &options,
            gravity,
        }
        .calibrate()?,
        None => calibrate_recordings(reading.owned()?, &options)?,
    };
    if let Some((noise, inputs)) = call.noise {
        done.file.noise = Some(noise);
        done.file.inputs.extend(inputs);
    }
    let file = done.file.clone();
    Ok(Outcome::calibration(file, Some(Box::new(done))))
}

fn apply(mut call: Call) -> Result<Outcome> {
    let mut options: ApplyOptions = call.keywords.last()?;
    let (file, _) = call.calibration()?;
    let reading = call.reading;
    let (summary, table) = if let Some(output) = call.output {
        options.gyro.clone_from(&reading.gyro);
        options.read = ReadOptions {
            hash: false,
            ..reading.options.clone()
        };
        let summary = output.write(&reading, |path, out| {
            let input = source::open(path, &options.read)?;
            let name = path.display().to_string();
            gravical::apply::apply(&file, input, &name, out, &options)
        })?;
        (summary, None)
    } else {
        if options.keep_raw {
            let what = "keep_raw=: columns in memory stay as they are";
            return Err(Error::usage("usage", what).with_hint("it needs output="));
        }
        let rows = reading.one()?;
        let done = apply_recording(&file, &rows, &options)?;
        let table = Table::of_applied(&done, rows.time_s.as_deref());
        (done.summary, Some(table))
    };
    let kind = Kind::Apply(Box::new(summary), table);
    Ok(Outcome::new(kind, Vec::new()))
}

fn denoise(mut call: Call) -> Result<Outcome> {
    let options: DenoiseOptions = call.keywords.last()?;
    options.validate()?;
    let reading = call.reading;
    let (summary, filtered, inputs) = if let Some(output) = call.output {
        if reading.gyro.is_some() {
            let what = "gyro=: one file is filtered at a time";
            return Err(Error::usage("usage", what).with_hint("leave out output= or gyro="));
        }
        let (summary, inputs) = output.write(&reading, |path, out| {
            denoise_file(path, &reading.options, &options, out)
        })?;
        (summary, None, inputs)
    } else {
        let rows = reading.one()?;
        let inputs = InputFile::of(from_ref(&*rows));
        let done = gravical::denoise::denoise(Arc::unwrap_or_clone(rows), &options)?;
        (done.summary, Some(Arc::new(done.recording)), inputs)
    };
    let kind = Kind::Denoise(Box::new(summary), filtered);
    Ok(Outcome::new(kind, inputs))
}

fn estimate_noise(call: Call) -> Result<Outcome> {
    call.keywords.end()?;
    let reading = call.reading;
    let result = match (reading.paths(), &reading.gyro) {
        (Some([path]), None) => noise(path, &reading.options)?,
        _ => noise_of(Arc::unwrap_or_clone(reading.one()?))?,
    };
    let inputs = result.inputs.clone();
    Ok(Outcome::new(Kind::Noise(Box::new(result)), inputs))
}

fn check(mut call: Call) -> Result<Outcome> {
    let gravity = call.keywords.gravity()?;
    let options = CheckOptions {
        gravity,
        ..call.keywords.last()?
    };
    let (file, name) = call.calibration()?;
    let reading = call.reading;
    let (rows, left_out) = match reading.paths() {
        Some(paths) => read_session(paths, reading.gyro.as_deref(), &reading.options)?,
        None => (reading.owned()?, Vec::new()),
    };
    let mut result = gravical::check::check(&file, &name, &rows, &options)?;
    result.findings.extend(left_out);
    let inputs = InputFile::of(&rows);
    Ok(Outcome::new(Kind::Check(Box::new(result)), inputs))
}

fn compare(mut call: Call) -> Result<Outcome> {
    call.keywords.end()?;
    let (second, second_name) = call.calibration()?;
    let (first, first_name) = call.calibration()?;
    let names = [first_name.as_str(), second_name.as_str()];
    let result = gravical::compare::compare(&first, &second, names)?;
    Ok(Outcome::new(Kind::Comparison(Box::new(result)), Vec::new()))
}

fn motion(mut call: Call) -> Result<Outcome> {
    let options = MotionOptions {
        gravity: call.keywords.gravity()?,
        meter: Some(call.meter),
        ..call.keywords.take()?
    };
    options.validate()?;
    let truth = call.keywords.path("truth")?;
    call.keywords.end()?;
    let rows = call.reading.one()?;
    let calibration = call.calibrations.first();
    let calibrated = calibration.map(|(file, name)| Calibrated { file, name });
    let mut motion = gravical::motion::motion(&rows, calibrated, &options)?;
    let mut inputs = InputFile::of(from_ref(&*rows));
    if let Some(path) = truth {
        let here = PathBuf::from(&rows.name);
        let reference = read_reference(&path, &rows, &here)?;
        add_comparison(&mut motion, &reference)?;
        inputs.push(reference.input());
    }
    let table = Table::of_motion(&motion);
    let kind = Kind::Motion(Box::new(motion), rows, table);
    Ok(Outcome::new(kind, inputs))
}

/// Writes simulated recordings; the truth as JSON, and the paths, that of the truth last.
#[pyfunction]
pub fn simulate(
    py: Python<'_>,
    scenario: String,
    output: PathBuf,
    force: bool,
    keywords: Keywords,
) -> PyResult<(String, Vec<PathBuf>)> {
    let mut k = keywords;
    let (truth, paths) = task::run(py, &Meter::default(), move || {
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
        simulate_to(&options, &output, force)
    })?;
    Ok((json(&truth)?, paths))
}

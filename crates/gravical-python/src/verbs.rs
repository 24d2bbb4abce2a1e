//! The verbs of the program: their options are taken from the keywords first, then they run.

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
use gravical::noise::{NoiseOptions, noise, noise_of};
use gravical::output::write_atomic;
use gravical::recording::{Meter, ReadOptions, source};
use gravical::session::{Session, SessionFiles, calibrate_recordings, read_session};
use gravical::simulate::{Scenario, SimulateOptions, simulate_to};
use gravical::targets::check_targets;
use gravical::{Error, Result};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::error::OrRaise;
use crate::keywords::Keywords;
use crate::outcome::{Kind, Outcome, Table};
use crate::recording::{Inputs, Reading, json};
use crate::task;

/// What a verb does once its options are known.
type Work = Box<dyn FnOnce(Call) -> Result<Outcome> + Send>;

/// What a verb is given beside its own options.
struct Call {
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
    keywords: Keywords,
) -> PyResult<Outcome> {
    let plan: fn(&mut Keywords) -> Result<Work> = match verb {
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
    let named = |(outcome, name): (Py<Outcome>, String)| {
        let file = outcome.get().file()?;
        Ok((file, name))
    };
    let calibrations: Result<_> = calibrations.into_iter().map(named).collect();
    let noise = noise.map(|outcome| outcome.get().noise()).transpose();
    let meter = Meter::default();
    let (work, reading) = keywords.read(py, |k| {
        let reading = Reading::new(inputs, k, &meter)?;
        Ok((plan(k)?, reading))
    })?;
    let call = Call {
        reading,
        calibrations: calibrations.or_raise(py)?,
        noise: noise.or_raise(py)?,
        output,
        meter: meter.clone(),
    };
    task::run(py, &meter, move || work(call))
}

fn inspect(k: &mut Keywords) -> Result<Work> {
    let options: InspectOptions = k.take()?;
    Ok(Box::new(move |call: Call| {
        let rows = call.reading.one()?;
        let found = gravical::inspect::inspect(&rows, &options.axes);
        let inputs = InputFile::of(from_ref(&*rows));
        Ok(Outcome::new(Kind::Inspection(Box::new(found)), inputs))
    }))
}

fn calibrate(k: &mut Keywords) -> Result<Work> {
    let gravity = k.gravity()?;
    let mut options = CalibrateOptions {
        segment: k.take()?,
        gravity: gravity.unwrap_or_default(),
        estimate: k.take()?,
        record: k.take()?,
        ..CalibrateOptions::default()
    };
    options.validate()?;
    let files: SessionFiles = k.take()?;
    Ok(Box::new(move |call: Call| {
        let reading = call.reading;
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
    }))
}

fn apply(k: &mut Keywords) -> Result<Work> {
    let mut options: ApplyOptions = k.take()?;
    Ok(Box::new(move |mut call: Call| {
        let (file, _) = call.calibration()?;
        let reading = call.reading;
        let Some(output) = call.output else {
            if options.keep_raw {
                let what = "keep_raw=: columns in memory stay as they are";
                return Err(Error::usage("usage", what).with_hint("it needs output="));
            }
            let rows = reading.one()?;
            let done = apply_recording(&file, &rows, &options)?;
            let table = Table::of_applied(&done, rows.time_s.as_deref());
            let kind = Kind::Apply(Box::new(done.summary), Some(table));
            return Ok(Outcome::new(kind, Vec::new()));
        };
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
        let kind = Kind::Apply(Box::new(summary), None);
        Ok(Outcome::new(kind, Vec::new()))
    }))
}

fn denoise(k: &mut Keywords) -> Result<Work> {
    let options: DenoiseOptions = k.take()?;
    options.validate()?;
    Ok(Box::new(move |call: Call| {
        let reading = call.reading;
        let Some(output) = call.output else {
            let rows = reading.one()?;
            let inputs = InputFile::of(from_ref(&*rows));
            let done = gravical::denoise::denoise(Arc::unwrap_or_clone(rows), &options)?;
            let filtered = Some(Arc::new(done.recording));
            let kind = Kind::Denoise(Box::new(done.summary), filtered);
            return Ok(Outcome::new(kind, inputs));
        };
        if reading.gyro.is_some() {
            let what = "gyro=: one file is filtered at a time";
            return Err(Error::usage("usage", what).with_hint("leave out output= or gyro="));
        }
        let (summary, inputs) = output.write(&reading, |path, out| {
            denoise_file(path, &reading.options, &options, out)
        })?;
        let kind = Kind::Denoise(Box::new(summary), None);
        Ok(Outcome::new(kind, inputs))
    }))
}

fn estimate_noise(k: &mut Keywords) -> Result<Work> {
    let options: NoiseOptions = k.take()?;
    Ok(Box::new(move |call: Call| {
        let reading = call.reading;
        let result = match (reading.paths(), &reading.gyro) {
            (Some([path]), None) => noise(path, &reading.options, &options)?,
            _ => {
                let rows = reading.one()?;
                noise_of(&rows, &options)?
            }
        };
        let inputs = result.inputs.clone();
        Ok(Outcome::new(Kind::Noise(Box::new(result)), inputs))
    }))
}

fn check(k: &mut Keywords) -> Result<Work> {
    let gravity = k.gravity()?;
    let options = CheckOptions {
        gravity,
        ..k.take()?
    };
    Ok(Box::new(move |mut call: Call| {
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
    }))
}

fn compare(_: &mut Keywords) -> Result<Work> {
    Ok(Box::new(|mut call: Call| {
        let (second, second_name) = call.calibration()?;
        let (first, first_name) = call.calibration()?;
        let names = [first_name.as_str(), second_name.as_str()];
        let result = gravical::compare::compare(&first, &second, names)?;
        Ok(Outcome::new(Kind::Comparison(Box::new(result)), Vec::new()))
    }))
}

/// The options of a motion that are keywords.
pub fn motion_options(k: &mut Keywords) -> Result<MotionOptions> {
    let gravity = k.gravity()?;
    let options = MotionOptions {
        gravity,
        ..k.take()?
    };
    options.validate()?;
    Ok(options)
}

fn motion(k: &mut Keywords) -> Result<Work> {
    let mut options = motion_options(k)?;
    let truth = k.path("truth")?;
    Ok(Box::new(move |call: Call| {
        let (noise, noise_files) = call.noise.unzip();
        options.noise = noise;
        options.meter = Some(call.meter);
        let rows = call.reading.one()?;
        let calibration = call.calibrations.first();
        let calibrated = calibration.map(|(file, name)| Calibrated { file, name });
        let mut motion = gravical::motion::motion(&rows, calibrated, &options)?;
        let mut inputs = InputFile::of(from_ref(&*rows));
        inputs.extend(noise_files.unwrap_or_default());
        if let Some(path) = truth {
            let here = PathBuf::from(&rows.name);
            let reference = read_reference(&path, &rows, &here)?;
            add_comparison(&mut motion, &reference)?;
            inputs.push(reference.input());
        }
        let table = Table::of_motion(&motion);
        let kind = Kind::Motion(Box::new(motion), rows, table);
        Ok(Outcome::new(kind, inputs))
    }))
}

/// Writes simulated recordings; the truth as JSON, and the paths, that of the truth last.
#[pyfunction]
pub fn simulate(
    py: Python<'_>,
    scenario: &str,
    output: PathBuf,
    force: bool,
    keywords: Keywords,
) -> PyResult<(String, Vec<PathBuf>)> {
    let options = keywords.read(py, |k| {
        let scenario = match scenario {
            "six-position" => Scenario::SixPosition(k.take()?),
            "poses" => Scenario::Poses(k.take()?),
            "static" => Scenario::Static(k.take()?),
            "line" => Scenario::Line(k.take()?),
            other => {
                let error = Error::usage("usage", format!("{other:?} is no scenario"));
                return Err(error.with_hint("one of six-position, poses, static, line"));
            }
        };
        Ok(SimulateOptions {
            scenario,
            sensor: k.take()?,
            file: k.take()?,
            ..k.take()?
        })
    })?;
    let run = move || simulate_to(&options, &output, force);
    let (truth, paths) = task::run(py, &Meter::default(), run)?;
    Ok((json(&truth)?, paths))
}

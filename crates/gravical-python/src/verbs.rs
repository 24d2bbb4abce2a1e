//! The verbs of the program.

use std::path::PathBuf;
use std::slice::from_ref;
use std::sync::Arc;

use gravical::apply::ApplyOptions;
use gravical::calibrate::{CalibrateOptions, RecordOptions};
use gravical::calibration_file::InputFile;
use gravical::check::CheckOptions;
use gravical::compare::compare as compare_two;
use gravical::denoise::DenoiseOptions;
use gravical::gravity::Gravity;
use gravical::inspect::InspectOptions;
use gravical::noise::NoiseOptions;
use gravical::output::write_atomic;
use gravical::recording::{Meter, ReadOptions, Recording as Rows, open};
use gravical::session::{Session, SessionFiles, calibrate_recordings, read_session};
use gravical::simulate::{Scenario, SimulateOptions, simulate_to};
use gravical::targets::check_targets;
use gravical::{Error, Result};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use crate::error::OrRaise;
use crate::keywords::Keywords;
use crate::outcome::{Kind, Noise, Outcome};
use crate::recording::{GyroFile, Recording, Source, json};
use crate::task;

/// From file to file needs a file.
fn path_of(py: Python<'_>, source: Source<'_>) -> PyResult<PathBuf> {
    match source {
        Source::Path(path) => Ok(path),
        _ => Err(Error::usage(
            "usage",
            "output=: it goes from file to file, and the recording is in memory",
        )
        .with_hint("give the path of the recording, or leave out output="))
        .or_raise(py),
    }
}

/// What is in a recording.
#[pyfunction]
pub fn inspect(py: Python<'_>, source: Source<'_>, keywords: Keywords) -> PyResult<Outcome> {
    let meter = Meter::default();
    let (rows, options) = source.open(py, keywords, &meter, Keywords::take::<InspectOptions>)?;
    task::run(py, &meter, move || {
        let found = Kind::Inspection(Box::new(gravical::inspect::inspect(&rows, &options.axes)));
        Ok(Outcome::new(found, InputFile::of(from_ref(&*rows))))
    })
}

/// The recordings of a session: the files, or what is in memory.
enum Inputs {
    Paths(Vec<PathBuf>),
    Rows(Vec<Rows>),
}

/// Files alone are read as a session; with anything else in between, each by itself.
fn inputs_of(
    py: Python<'_>,
    sources: Vec<Source<'_>>,
    read: &ReadOptions,
    meter: &Meter,
) -> PyResult<Inputs> {
    let paths = sources.iter().map(|source| match source {
        Source::Path(path) => Some(path.clone()),
        _ => None,
    });
    if let Some(paths) = paths.collect::<Option<Vec<_>>>() {
        return Ok(Inputs::Paths(paths));
    }
    let rows = sources.into_iter().map(|source| {
        let rows = source.read(py, read.clone(), None, meter)?;
        Ok(Arc::unwrap_or_clone(rows))
    });
    Ok(Inputs::Rows(rows.collect::<PyResult<_>>()?))
}

fn is_in_memory(sources: &[Source<'_>]) -> bool {
    sources.iter().all(|s| matches!(s, Source::Recording(_)))
}

/// The options of reading, unless all recordings are in memory.
fn reading(keywords: &mut Keywords, in_memory: bool, meter: &Meter) -> Result<ReadOptions> {
    if in_memory {
        Ok(ReadOptions::default())
    } else {
        keywords.reading(meter)
    }
}

/// Calibrates from files, a folder or recordings.
#[pyfunction]
pub fn calibrate(
    py: Python<'_>,
    sources: Vec<Source<'_>>,
    noise: Option<Noise<'_>>,
    keywords: Keywords,
) -> PyResult<Outcome> {
    let meter = Meter::default();
    let in_memory = is_in_memory(&sources);
    let (mut options, files, read, gravity) = keywords.read(py, |k| {
        let gravity: Option<Gravity> = k.gravity()?;
        let record: RecordOptions = k.take()?;
        let options = CalibrateOptions {
            segment: k.take()?,
            gravity: gravity.unwrap_or_default(),
            estimate: k.take()?,
            sensor: record.sensor(),
            recorded: record.recorded,
            ..CalibrateOptions::default()
        };
        options.validate()?;
        let files: SessionFiles = k.take()?;
        Ok((options, files, reading(k, in_memory, &meter)?, gravity))
    })?;
    let noise = noise.map(|noise| noise.read(py)).transpose()?;
    let inputs = inputs_of(py, sources, &read, &meter)?;
    let mut done = task::run(py, &meter, move || {
        files.read_into(&mut options, &read)?;
        match inputs {
            Inputs::Rows(rows) => {
                refuse_gyro(files.gyro.as_ref())?;
                calibrate_recordings(rows, &options)
            }
            Inputs::Paths(paths) => Session {
                inputs: &paths,
                gyro: files.gyro.as_deref(),
                read: &read,
                options: &options,
                gravity,
            }
            .calibrate(),
        }
    })?;
    if let Some((noise, input)) = noise {
        done.file.noise = Some(noise.section());
        done.file.inputs.extend(input);
    }
    Ok(Outcome::calibration(
        done.file.clone(),
        Some(Box::new(done)),
    ))
}

fn refuse_gyro(gyro: Option<&PathBuf>) -> Result<()> {
    match gyro {
        None => Ok(()),
        Some(_) => Err(Error::usage("usage", "gyro=: it joins two files")
            .with_hint("read both first: gravical.read(path, gyro=path)")),
    }
}

/// Calibrated channels of a recording; from file to file with `output`.
#[pyfunction]
pub fn apply(
    py: Python<'_>,
    calibration: &Bound<'_, Outcome>,
    source: Source<'_>,
    output: Option<PathBuf>,
    force: bool,
    keywords: Keywords,
) -> PyResult<Outcome> {
    let meter = Meter::default();
    let file = calibration.get().file()?;
    let Some(output) = output else {
        let (rows, options) = source.open(py, keywords, &meter, |k| {
            let options: ApplyOptions = k.take()?;
            if options.keep_raw {
                let what = "keep_raw=: columns in memory stay as they are";
                return Err(Error::usage("usage", what).with_hint("it needs output="));
            }
            Ok(options)
        })?;
        let shared = rows.clone();
        let done = task::run(py, &meter, move || {
            gravical::apply::apply_recording(&file, &rows, &options)
        })?;
        let channels = done
            .accel
            .into_iter()
            .chain(done.gyro.into_iter().flatten());
        let kept = Some((shared, channels.collect()));
        return Ok(Outcome::new(
            Kind::Apply(Box::new(done.summary), kept),
            Vec::new(),
        ));
    };
    let path = path_of(py, source)?;
    let mut options = keywords.read(py, |k| {
        let files: GyroFile = k.take()?;
        Ok(ApplyOptions {
            gyro: files.gyro,
            read: k.reading(&meter)?,
            ..k.take()?
        })
    })?;
    let summary = task::run(py, &meter, move || {
        let inputs: Vec<PathBuf> = std::iter::once(&path)
            .chain(&options.gyro)
            .cloned()
            .collect();
        check_targets(from_ref(&output), &inputs, force)?;
        options.read.hash = false;
        let name = path.display().to_string();
        let mut summary = None;
        write_atomic(&output, force, |out| {
            let input = open::open(&path, &options.read)?;
            summary = Some(gravical::apply::apply(&file, input, &name, out, &options)?);
            Ok(())
        })?;
        Ok(summary)
    })?;
    let summary = summary.ok_or_else(|| PyRuntimeError::new_err("nothing was written"))?;
    Ok(Outcome::new(
        Kind::Apply(Box::new(summary), None),
        Vec::new(),
    ))
}

/// A filtered recording; from file to file with `output`.
#[pyfunction]
pub fn denoise(
    py: Python<'_>,
    source: Source<'_>,
    output: Option<PathBuf>,
    force: bool,
    keywords: Keywords,
) -> PyResult<(Option<Recording>, Outcome)> {
    let meter = Meter::default();
    let own = |k: &mut Keywords| {
        let options: DenoiseOptions = k.take()?;
        options.validate()?;
        Ok(options)
    };
    let Some(output) = output else {
        let (rows, options) = source.open(py, keywords, &meter, own)?;
        return task::run(py, &meter, move || {
            let inputs = InputFile::of(from_ref(&*rows));
            let done = gravical::denoise::denoise(Arc::unwrap_or_clone(rows), &options)?;
            let outcome = Outcome::new(Kind::Denoise(Box::new(done.summary)), inputs);
            Ok((Some(Recording::of(Arc::new(done.recording))), outcome))
        });
    };
    let path = path_of(py, source)?;
    let (read, options) = keywords.read(py, |k| Ok((k.reading(&meter)?, own(k)?)))?;
    let done = task::run(py, &meter, move || {
        check_targets(from_ref(&output), from_ref(&path), force)?;
        let mut done = None;
        write_atomic(&output, force, |out| {
            done = Some(gravical::denoise::denoise_file(
                &path, &read, &options, out,
            )?);
            Ok(())
        })?;
        Ok(done)
    })?;
    let done = done.ok_or_else(|| PyRuntimeError::new_err("nothing was written"))?;
    Ok((None, Outcome::new(Kind::Denoise(Box::new(done.0)), done.1)))
}

/// The noise of a recording.
#[pyfunction]
pub fn noise(py: Python<'_>, source: Source<'_>, keywords: Keywords) -> PyResult<Outcome> {
    let meter = Meter::default();
    let result = match source {
        Source::Path(path) => {
            let (read, options) =
                keywords.read(py, |k| Ok((k.reading(&meter)?, k.take::<NoiseOptions>()?)))?;
            task::run(py, &meter, move || {
                gravical::noise::noise(&path, &read, &options)
            })?
        }
        source => {
            let (rows, options) =
                source.open(py, keywords, &meter, Keywords::take::<NoiseOptions>)?;
            task::run(py, &meter, move || {
                gravical::noise::noise_of(&rows, &options)
            })?
        }
    };
    let inputs = result.inputs.clone();
    Ok(Outcome::new(Kind::Noise(Box::new(result)), inputs))
}

/// Whether a calibration fits recordings.
#[pyfunction]
pub fn check(
    py: Python<'_>,
    calibration: &Bound<'_, Outcome>,
    name: String,
    sources: Vec<Source<'_>>,
    keywords: Keywords,
) -> PyResult<Outcome> {
    let meter = Meter::default();
    let in_memory = is_in_memory(&sources);
    let file = calibration.get().file()?;
    let (options, files, read) = keywords.read(py, |k| {
        let gravity = k.gravity()?;
        let options = CheckOptions {
            gravity,
            ..k.take()?
        };
        let files: GyroFile = k.take()?;
        Ok((options, files, reading(k, in_memory, &meter)?))
    })?;
    let inputs = inputs_of(py, sources, &read, &meter)?;
    task::run(py, &meter, move || {
        let (rows, left_out) = match inputs {
            Inputs::Paths(paths) => read_session(&paths, files.gyro.as_deref(), &read)?,
            Inputs::Rows(rows) => {
                refuse_gyro(files.gyro.as_ref())?;
                (rows, Vec::new())
            }
        };
        let mut result = gravical::check::check(&file, &name, &rows, &options)?;
        result.findings.extend(left_out);
        Ok(Outcome::new(
            Kind::Check(Box::new(result)),
            InputFile::of(&rows),
        ))
    })
}

/// Whether two calibrations differ.
#[pyfunction]
pub fn compare(
    py: Python<'_>,
    first: &Bound<'_, Outcome>,
    second: &Bound<'_, Outcome>,
    names: [String; 2],
) -> PyResult<Outcome> {
    let (a, b) = (first.get().file()?, second.get().file()?);
    let result = py.detach(|| compare_two(&a, &b, [&names[0], &names[1]]));
    let result = result.or_raise(py)?;
    Ok(Outcome::new(Kind::Comparison(Box::new(result)), Vec::new()))
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

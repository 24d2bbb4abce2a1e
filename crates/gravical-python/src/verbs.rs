//! The verbs of the program.

use std::path::PathBuf;
use std::slice::from_ref;
use std::sync::Arc;

use gravical::apply::{self, ApplySummary};
use gravical::calibration_file::{CalibrationFile, InputFile};
use gravical::check::{CheckOptions, check};
use gravical::compare::compare as compare_two;
use gravical::denoise;
use gravical::inspect::inspect;
use gravical::noise::{noise, noise_of};
use gravical::output::write_atomic;
use gravical::recording::{ReadOptions, Recording as Rows, join_gyroscope, open, read};
use gravical::session::read_session;
use gravical::simulate::{
    FileFormat, LineOptions, PosesOptions, Scenario, SimulateOptions, SixPositionOptions,
    SoakOptions, StaticOptions, simulate_to,
};
use gravical::targets::check_targets;
use gravical::{Error, Result};
use numpy::{IntoPyArray, PyArray1};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use crate::calibration::Calibration;
use crate::error::OrRaise;
use crate::options::Options;
use crate::outcome::{Kind, Outcome};
use crate::recording::{Recording, json};
use crate::task;

/// What is in a file.
#[pyfunction]
pub fn inspect_path(
    py: Python<'_>,
    path: PathBuf,
    gyro: Option<PathBuf>,
    options: Options<'_>,
) -> PyResult<Outcome> {
    let (read, meter) = options.read(true)?;
    let axes = options.axes()?;
    task::run(py, &meter, move || {
        let recording = match gyro {
            None => gravical::recording::read(&path, &read)?,
            Some(gyro) => {
                let mut recording =
                    gravical::recording::read(&path, &read.beside_gyroscope_file())?;
                join_gyroscope(&mut recording, &gyro, &read)?;
                recording
            }
        };
        let found = Kind::Inspection(Box::new(inspect(&recording, &axes)));
        Ok(Outcome::new(found, InputFile::of(&[recording])))
    })
}

/// What is in a recording.
#[pyfunction]
pub fn inspect_recording(
    py: Python<'_>,
    recording: &Bound<'_, Recording>,
    options: Options<'_>,
) -> PyResult<Outcome> {
    let axes = options.axes()?;
    let (_, meter) = options.read(false)?;
    let shared = recording.get().shared.clone();
    task::run(py, &meter, move || {
        let found = Kind::Inspection(Box::new(inspect(&shared, &axes)));
        Ok(Outcome::new(found, inputs_of(&shared)))
    })
}

fn inputs_of(recording: &Rows) -> Vec<InputFile> {
    InputFile::of(from_ref(recording))
}

/// Three columns.
type Columns<'py> = Vec<Bound<'py, PyArray1<f64>>>;

/// Calibrated columns of a recording in memory, and the summary as JSON.
#[pyfunction]
pub fn apply_recording<'py>(
    py: Python<'py>,
    calibration: &Bound<'py, Calibration>,
    recording: &Bound<'py, Recording>,
    options: Options<'py>,
) -> PyResult<(Columns<'py>, Option<Columns<'py>>, String)> {
    let (apply, meter) = options.apply()?;
    let file = calibration.get().file.clone();
    let shared = recording.get().shared.clone();
    let done = task::run(py, &meter, move || {
        apply::apply_recording(&file, &shared, &apply)
    })?;
    let arrays = |columns: [Vec<f64>; 3]| columns.into_iter().map(|c| c.into_pyarray(py)).collect();
    let summary = json(&done.summary)?;
    Ok((arrays(done.accel), done.gyro.map(arrays), summary))
}

/// From file to file; the summary as JSON.
#[pyfunction]
pub fn apply_file(
    py: Python<'_>,
    calibration: &Bound<'_, Calibration>,
    path: PathBuf,
    output: PathBuf,
    gyro: Option<PathBuf>,
    force: bool,
    options: Options<'_>,
) -> PyResult<String> {
    let (mut apply, meter) = options.apply()?;
    let file: Arc<CalibrationFile> = calibration.get().file.clone();
    let summary = task::run(py, &meter, move || {
        let inputs: Vec<PathBuf> = std::iter::once(&path).chain(&gyro).cloned().collect();
        check_targets(from_ref(&output), &inputs, force)?;
        let joined = gyro.as_deref().map(|gyro| -> Result<Rows> {
            let mut recording = read(&path, &apply.read.beside_gyroscope_file())?;
            join_gyroscope(&mut recording, gyro, &apply.read)?;
            Ok(recording)
        });
        let joined = joined.transpose()?;
        if joined.is_some() {
            apply.read = apply.read.beside_gyroscope_file();
        }
        let name = path.display().to_string();
        let mut summary: Option<ApplySummary> = None;
        write_atomic(&output, force, |out| {
            let input = open::open(&path, &apply.read)?;
            summary = Some(match &joined {
                Some(joined) => {
                    apply::apply_with_gyroscope(&file, input, &name, out, &apply, joined)?
                }
                None => apply::apply(&file, input, &name, out, &apply)?,
            });
            Ok(())
        })?;
        Ok(summary)
    })?;
    json(&summary)
}

/// A filtered recording.
#[pyfunction]
pub fn denoise_recording(
    py: Python<'_>,
    recording: &Bound<'_, Recording>,
    options: Options<'_>,
) -> PyResult<(Recording, Outcome)> {
    let denoise = options.denoise()?;
    let (_, meter) = options.read(false)?;
    let shared = recording.get().shared.clone();
    task::run(py, &meter, move || {
        let inputs = inputs_of(&shared);
        let done = denoise::denoise((*shared).clone(), &denoise)?;
        let outcome = Outcome::new(Kind::Denoise(Box::new(done.summary)), inputs);
        Ok((done.recording.into(), outcome))
    })
}

/// From file to file.
#[pyfunction]
pub fn denoise_file(
    py: Python<'_>,
    path: PathBuf,
    output: PathBuf,
    force: bool,
    options: Options<'_>,
) -> PyResult<Outcome> {
    let denoise = options.denoise()?;
    let (read, meter) = options.read(true)?;
    let done = task::run(py, &meter, move || {
        check_targets(from_ref(&output), from_ref(&path), force)?;
        let mut done = None;
        write_atomic(&output, force, |out| {
            done = Some(denoise::denoise_file(&path, &read, &denoise, out)?);
            Ok(())
        })?;
        Ok(done)
    })?;
    let done = done.ok_or_else(|| PyRuntimeError::new_err("nothing was written"))?;
    Ok(Outcome::new(
        Kind::Denoise(Box::new(done.summary)),
        done.inputs,
    ))
}

/// The noise of a file.
#[pyfunction]
pub fn noise_path(py: Python<'_>, path: PathBuf, options: Options<'_>) -> PyResult<Outcome> {
    let wanted = options.noise()?;
    let (read, meter) = options.read(true)?;
    let result = task::run(py, &meter, move || noise(&path, &read, &wanted))?;
    let inputs = result.inputs.clone();
    Ok(Outcome::new(Kind::Noise(Box::new(result)), inputs))
}

/// The noise of a recording.
#[pyfunction]
pub fn noise_recording(
    py: Python<'_>,
    recording: &Bound<'_, Recording>,
    options: Options<'_>,
) -> PyResult<Outcome> {
    let wanted = options.noise()?;
    let (_, meter) = options.read(false)?;
    let shared = recording.get().shared.clone();
    let result = task::run(py, &meter, move || noise_of(&shared, &wanted))?;
    let inputs = result.inputs.clone();
    Ok(Outcome::new(Kind::Noise(Box::new(result)), inputs))
}

fn check_options(options: &Options<'_>) -> PyResult<CheckOptions> {
    Ok(CheckOptions {
        gravity: options.gravity()?,
        axes: options.axes()?,
    })
}

/// Whether a calibration fits files.
#[pyfunction]
pub fn check_paths(
    py: Python<'_>,
    calibration: &Bound<'_, Calibration>,
    name: String,
    paths: Vec<PathBuf>,
    gyro: Option<PathBuf>,
    options: Options<'_>,
) -> PyResult<Outcome> {
    let wanted = check_options(&options)?;
    let (read, meter): (ReadOptions, _) = options.read(true)?;
    let file = calibration.get().file.clone();
    task::run(py, &meter, move || {
        let (recordings, left_out) = read_session(&paths, gyro.as_deref(), &read)?;
        let mut result = check(&file, &name, &recordings, &wanted)?;
        result.findings.extend(left_out);
        let inputs = InputFile::of(&recordings);
        Ok(Outcome::new(Kind::Check(Box::new(result)), inputs))
    })
}

/// Whether a calibration fits recordings in memory.
#[pyfunction]
pub fn check_recordings(
    py: Python<'_>,
    calibration: &Bound<'_, Calibration>,
    name: String,
    recordings: Vec<Bound<'_, Recording>>,
    options: Options<'_>,
) -> PyResult<Outcome> {
    let wanted = check_options(&options)?;
    let (_, meter) = options.read(false)?;
    let file = calibration.get().file.clone();
    let shared: Vec<Arc<Rows>> = recordings.iter().map(|r| r.get().shared.clone()).collect();
    task::run(py, &meter, move || {
        let result = match &shared[..] {
            [one] => check(&file, &name, from_ref(&**one), &wanted)?,
            several => {
                let rows: Vec<Rows> = several.iter().map(|r| (**r).clone()).collect();
                check(&file, &name, &rows, &wanted)?
            }
        };
        let inputs = shared.iter().flat_map(|r| inputs_of(r)).collect();
        Ok(Outcome::new(Kind::Check(Box::new(result)), inputs))
    })
}

/// Whether two calibrations differ.
#[pyfunction]
pub fn compare(
    py: Python<'_>,
    first: &Bound<'_, Calibration>,
    second: &Bound<'_, Calibration>,
    names: [String; 2],
) -> PyResult<Outcome> {
    let (a, b) = (first.get().file.clone(), second.get().file.clone());
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
    options: Options<'_>,
) -> PyResult<(String, Vec<PathBuf>)> {
    let simulated = simulate_options(py, scenario, &options)?;
    let meter = gravical::recording::Meter::default();
    let run = move || simulate_to(&simulated, &output, force);
    let (truth, paths) = task::run(py, &meter, run)?;
    Ok((json(&truth)?, paths))
}

/// The options of the program, by its names.
fn simulate_options(py: Python<'_>, scenario: &str, o: &Options<'_>) -> PyResult<SimulateOptions> {
    let number = |name: &str, of: &mut f64| -> PyResult<()> {
        if let Some(value) = o.number(name)? {
            *of = value;
        }
        Ok(())
    };
    let scenario = match scenario {
        "six-position" => {
            let mut s = SixPositionOptions {
                continuous: o.switch("continuous")?,
                ..SixPositionOptions::default()
            };
            number("hold", &mut s.hold_s)?;
            number("rest", &mut s.rest_s)?;
            number("turn_angle", &mut s.turn_angle_deg)?;
            Scenario::SixPosition(s)
        }
        "poses" => {
            let mut s = PosesOptions::default();
            number("hold", &mut s.hold_s)?;
            if let Some(free) = o.whole("free")? {
                s.free = free;
            }
            Scenario::Poses(s)
        }
        "static" => {
            let mut s = StaticOptions::default();
            number("duration", &mut s.duration_s)?;
            s.soak = o.pair("soak")?.map(|(high_c, low_c)| SoakOptions {
                high_c,
                low_c,
                hysteresis_c: 0.0,
                gyro_drift_deg_s_per_c: 0.0,
            });
            if let Some(soak) = &mut s.soak {
                number("gyro_drift", &mut soak.gyro_drift_deg_s_per_c)?;
            }
            Scenario::Static(s)
        }
        "line" => {
            let mut s = LineOptions::default();
            number("distance", &mut s.distance_m)?;
            number("move_time", &mut s.move_time_s)?;
            number("rest", &mut s.rest_s)?;
            Scenario::Line(s)
        }
        other => {
            let error = Error::usage("usage", format!("{other:?} is no scenario"));
            return Err(error.with_hint("one of six-position, poses, static, line")).or_raise(py);
        }
    };
    let mut s = SimulateOptions::new(scenario);
    if let Some(seed) = o.whole("seed")? {
        s.seed = seed;
    }
    number("gravity", &mut s.gravity_mps2)?;
    number("tilt", &mut s.tilt_sd_deg)?;
    number("rate", &mut s.rate_hz)?;
    number("jitter", &mut s.stamp_jitter_ms)?;
    number("drop", &mut s.dropped_fraction)?;
    s.file.format = match (o.switch("raw")?, o.switch("wrong_header")?) {
        (true, true) => {
            let error = Error::usage("usage", "raw= and wrong_header= exclude each other");
            return Err(error).or_raise(py);
        }
        (true, false) => FileFormat::Raw,
        (false, true) => FileFormat::WrongHeader,
        (false, false) => FileFormat::TrueHeader,
    };
    if let Some(decimals) = o.whole("decimals")? {
        s.file.decimals = decimals;
    }
    let part = &mut s.sensor;
    if let Some(range) = o.whole("range")? {
        part.accel_range_g = range;
    }
    number("scale_sd", &mut part.scale_sd_percent)?;
    number("temperature_rise", &mut part.temperature_rise_c)?;
    number("temperature_drift", &mut part.bias_drift_mg_per_c)?;
    if let Some(factor) = o.number("noise")? {
        s.sensor = s.sensor.with_noise_factor(factor);
    }
    Ok(s)
}

//! `gravical calibrate --each`: a calibration of each session.

use std::path::PathBuf;
use std::process::ExitCode;

use gravical::calibrate::CalibrateOptions;
use gravical::calibration_file::{CalibrationFile, Grade, InputFile};
use gravical::noise::{NoiseResult, read_noise};
use gravical::recording::ReadOptions;
use serde::{Deserialize, Serialize};

use super::{Args, compute, save};
use crate::cmd::words;
use crate::each::{self, Columns, EachArgs, Job, Kind, Outcome, Plan, Words, Work};

/// Runs the command for each of its sessions.
///
/// # Errors
///
/// What concerns all of them: options, `--noise`, `--sections`, targets.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    EachArgs::refuse_beside(&[
        ("--gyro", args.gyro.is_some()),
        ("--report", args.report.is_wanted()),
        ("--figures", args.figures.figures.is_some()),
        ("--store, --recorded", args.store.is_given()),
    ])?;
    let options = CalibrateOptions {
        // Of each session its own.
        command: None,
        ..args.options()?
    };
    options.validate()?;
    let read = ReadOptions {
        meter: None,
        ..args.recording.read_options(true)
    };
    read.validate()?;
    let noise = args.method.noise.as_deref().map(read_noise).transpose()?;
    let words = words()?;
    let files = args.method.sections.iter().chain(&args.method.thermal);
    let files = files.chain(&args.method.noise).map(PathBuf::as_path);
    let plan = Plan {
        each: &args.each,
        words: words.clone(),
        inputs: &args.inputs,
        kind: Kind::Sessions,
        output: args.output.as_deref(),
        ending: Some(|_| ".json".to_owned()),
        files: files.collect(),
        force: args.force,
        json: args.json,
        quiet: args.quiet,
        verbose: args.report.is_verbose(),
    };
    let job = Calibrations {
        args,
        options,
        read,
        noise,
        words,
    };
    each::run(&plan, &job)
}

struct Calibrations<'a> {
    args: &'a Args,
    options: CalibrateOptions,
    read: ReadOptions,
    noise: Option<(NoiseResult, InputFile)>,
    words: Words,
}

impl Job for Calibrations<'_> {
    type Values = Values;

    fn run(&self, work: &Work<'_>) -> anyhow::Result<Outcome<Values>> {
        let input = [work.path.to_owned()];
        let noise = self.noise.as_ref();
        let mut file = compute(self.args, &input, &self.read, &self.options, noise)?.file;
        file.command = Some(self.words.command(work.path, work.result));
        work.check_unchanged()?;
        if let Some(path) = work.result {
            save(path, work.force, &file)?;
        }
        Ok(Outcome {
            verdict: file.verdict.grade.name().to_owned(),
            is_poor: file.verdict.grade == Grade::Poor,
            reasons: file.verdict.reasons.clone(),
            values: Values::of(&file),
        })
    }
}

/// The parameters of a calibration with their standard deviations, in the units of the file.
#[derive(Debug, Default, Serialize, Deserialize)]
struct Values {
    sensor_id: Option<String>,
    input_unit: String,
    bias_x: f64,
    bias_y: f64,
    bias_z: f64,
    bias_x_sd: Option<f64>,
    bias_y_sd: Option<f64>,
    bias_z_sd: Option<f64>,
    scale_x: f64,
    scale_y: f64,
    scale_z: f64,
    scale_x_sd: Option<f64>,
    scale_y_sd: Option<f64>,
    scale_z_sd: Option<f64>,
    worst_direction_error_mps2: Option<f64>,
    predicted_norm_error_mps2: Option<f64>,
    leave_one_out_rms_mps2: Option<f64>,
    poses: usize,
    temperature_c: Option<f64>,
    gyro_unit: Option<String>,
    gyro_bias_x: Option<f64>,
    gyro_bias_y: Option<f64>,
    gyro_bias_z: Option<f64>,
    findings: String,
}

impl Columns for Values {
    const NAMES: &'static [&'static str] = &[
        "sensor_id",
        "input_unit",
        "bias_x",
        "bias_y",
        "bias_z",
        "bias_x_sd",
        "bias_y_sd",
        "bias_z_sd",
        "scale_x",
        "scale_y",
        "scale_z",
        "scale_x_sd",
        "scale_y_sd",
        "scale_z_sd",
        "worst_direction_error_mps2",
        "predicted_norm_error_mps2",
        "leave_one_out_rms_mps2",
        "poses",
        "temperature_c",
        "gyro_unit",
        "gyro_bias_x",
        "gyro_bias_y",
        "gyro_bias_z",
        "findings",
    ];
}

impl Values {
    fn of(file: &CalibrationFile) -> Self {
        let a = &file.accelerometer;
        let sd = |of: fn(&gravical::calibration_file::Deviations) -> [f64; 3], axis: usize| {
            a.deviations.as_ref().map(|d| of(d)[axis])
        };
        let gyro_bias = |axis: usize| file.gyroscope.as_ref().map(|g| g.bias[axis]);
        Values {
            sensor_id: file.sensor.id.clone(),
            input_unit: a.input_unit.name().to_owned(),
            bias_x: a.bias[0],
            bias_y: a.bias[1],
            bias_z: a.bias[2],
            bias_x_sd: sd(|d| d.bias, 0),
            bias_y_sd: sd(|d| d.bias, 1),
            bias_z_sd: sd(|d| d.bias, 2),
            scale_x: a.scale[0],
            scale_y: a.scale[1],
            scale_z: a.scale[2],
            scale_x_sd: sd(|d| d.scale, 0),
            scale_y_sd: sd(|d| d.scale, 1),
            scale_z_sd: sd(|d| d.scale, 2),
            worst_direction_error_mps2: a.worst_direction.as_ref().map(|w| w.error_mps2),
            predicted_norm_error_mps2: a.predicted_norm_error_mps2,
            leave_one_out_rms_mps2: a.leave_one_out_rms_mps2,
            poses: a.poses.len(),
            temperature_c: file.temperature_c.map(|t| t.mean),
            gyro_unit: file
                .gyroscope
                .as_ref()
                .map(|g| g.input_unit.name().to_owned()),
            gyro_bias_x: gyro_bias(0),
            gyro_bias_y: gyro_bias(1),
            gyro_bias_z: gyro_bias(2),
            findings: each::kinds(&file.findings),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_the_fields() {
        each::assert_columns(&Values::default());
    }
}

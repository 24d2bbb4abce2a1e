//! Writing of recordings and true values to files.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::options::FileFormat;
use super::part::temperature_counts;
use super::truth::Truth;
use super::{SimulatedFile, Simulation};
use crate::output::{check_target, make_folder, write_atomic};
use crate::{Error, Result};

/// The header of the student report's logger, verbatim. It is wrong: the values under it are in m/s² and
/// rad/s.
const WRONG_HEADER: &str = "Timestamp,aX (g),aY (g),aZ (g),Temp (C),gX (°/s),gY (°/s),gZ (°/s)";
const TRUE_HEADER: &str =
    "Timestamp (ms),aX (m/s^2),aY (m/s^2),aZ (m/s^2),Temp (C),gX (rad/s),gY (rad/s),gZ (rad/s)";
const RAW_HEADER: &str = "Timestamp (ms),ax,ay,az,temp,gx,gy,gz";

/// Writes every recording and `truth.json` into `dir`, which is created if necessary; returns the
/// paths, `truth.json` last.
///
/// All targets are checked before the first is written.
///
/// # Errors
///
/// `exists` (usage) if a target exists and `force` is false; otherwise errors of the file system,
/// with the path.
pub fn write(simulation: &Simulation, dir: &Path, force: bool) -> Result<Vec<PathBuf>> {
    let truth_path = dir.join("truth.json");
    let mut paths: Vec<_> = simulation.files.iter().map(|f| dir.join(&f.name)).collect();
    for path in paths.iter().chain([&truth_path]) {
        check_target(path, force)?;
    }
    make_folder(dir)?;
    for (file, path) in simulation.files.iter().zip(&paths) {
        write_atomic(path, force, |out| {
            let io = |e| Error::io(path, e);
            out.write_all(preamble(&simulation.truth, &file.name).as_bytes())
                .map_err(io)?;
            let mut text = String::with_capacity(96);
            for row in 0..file.t_s.len() {
                text.clear();
                // Writing into a String cannot fail.
                let _ = line(&mut text, file, row, &simulation.truth);
                out.write_all(text.as_bytes()).map_err(io)?;
            }
            Ok(())
        })?;
    }
    let json = serde_json::to_string_pretty(&simulation.truth)
        .map_err(|e| Error::io(&truth_path, e.into()))?;
    write_atomic(&truth_path, force, |out| {
        writeln!(out, "{json}").map_err(|e| Error::io(&truth_path, e))
    })?;
    paths.push(truth_path);
    Ok(paths)
}

/// Comment lines and header.
fn preamble(truth: &Truth, name: &str) -> String {
    let o = &truth.options;
    let s = &o.sensor;
    let low_pass = s
        .low_pass_hz
        .map_or("off".to_owned(), |f| format!("{f} Hz"));
    let header = match o.file.format {
        FileFormat::WrongHeader => WRONG_HEADER,
        FileFormat::TrueHeader => TRUE_HEADER,
        FileFormat::Raw => RAW_HEADER,
    };
    let tool = &truth.tool;
    let scenario = o.scenario.name();
    format!(
        "# simulated by {tool}, not measured: {scenario}, {name}; what was put in is in truth.json\n\
         # seed {}, rate {} Hz, range {} g and {} °/s, low-pass {low_pass}, noise {} m/s/√s and {} °/√s\n\
         # gravity {} m/s², placement tilt {}°, clock {} ppm, jitter {} ms, lost rows {}\n\
         {header}\n",
        o.seed,
        o.rate_hz,
        s.accel_range_g,
        s.gyro_range_deg_s,
        s.accel_noise_mps_rts,
        s.gyro_noise_deg_rts,
        o.gravity_mps2,
        o.tilt_sd_deg,
        o.clock_error_ppm,
        o.stamp_jitter_ms,
        o.dropped_fraction,
    )
}

fn line(text: &mut String, file: &SimulatedFile, row: usize, truth: &Truth) -> std::fmt::Result {
    let file_options = truth.options.file;
    write!(text, "{}", file.stamp_ms[row])?;
    let accel = file.accel_mps2.iter().map(|c| c[row]);
    let gyro = file.gyro_rad_s.iter().map(|c| c[row]);
    let temperature = file.temperature_c[row];
    if file_options.format == FileFormat::Raw {
        let accel_lsb = truth.accelerometer.lsb_mps2;
        let gyro_lsb = truth.gyroscope.lsb_rad_s;
        let counts = accel
            .map(|v| v / accel_lsb)
            .chain([temperature_counts(temperature)])
            .chain(gyro.map(|v| v / gyro_lsb));
        for value in counts {
            // The values are exact multiples of one count.
            write!(text, ",{}", value.round() as i16)?;
        }
    } else {
        let decimals = usize::from(file_options.decimals);
        for value in accel.chain([temperature]).chain(gyro) {
            write!(text, ",{value:.decimals$}")?;
        }
    }
    writeln!(text)
}

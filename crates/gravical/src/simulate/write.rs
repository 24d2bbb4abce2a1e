//! Writing of recordings and true values to files.

use std::path::{Path, PathBuf};

use super::options::{FileOptions, SimulateOptions};
use super::record::{Row, record};
use super::sensor::{
    ACCEL_NOISE_MPS_RTS, GYRO_NOISE_DEG_RTS, LOW_PASS_HZ, Reading, temperature_counts,
};
use super::truth::Truth;
use super::{MAX_WRITTEN, planned};
use crate::output::{check_target, make_folder, write_atomic, write_text};
use crate::{Error, Result};

/// The header of the student report's logger, verbatim. It is wrong: the values under it are in m/s² and
/// rad/s.
const WRONG_HEADER: &str = "Timestamp,aX (g),aY (g),aZ (g),Temp (C),gX (°/s),gY (°/s),gZ (°/s)";
const RAW_HEADER: &str = "Timestamp (ms),ax,ay,az,temp,gx,gy,gz";

/// Simulates into files, row by row: every recording and `truth.json` in `dir`, which is created if
/// necessary. Returns the truth and the paths, `truth.json` last.
///
/// All targets are checked before the first is written.
///
/// # Errors
///
/// `simulate-option` (usage) for an option out of its range and for more than 10⁹ rows; `exists` (usage) if a
/// target exists and `force` is false; otherwise errors of the file system, with the path.
pub fn simulate_to(
    options: &SimulateOptions,
    dir: &Path,
    force: bool,
) -> Result<(Truth, Vec<PathBuf>)> {
    let (mut truth, plans) = planned(options, MAX_WRITTEN)?;
    let names = plans.iter().map(|plan| plan.truth.name.as_str());
    let paths: Vec<PathBuf> = names
        .chain(["truth.json"])
        .map(|name| dir.join(name))
        .collect();
    for path in &paths {
        check_target(path, force)?;
    }
    make_folder(dir)?;
    let lsb = [truth.accelerometer.lsb_mps2, truth.gyroscope.lsb_rad_s];
    for (index, (plan, path)) in plans.iter().zip(&paths).enumerate() {
        write_atomic(path, force, |out| {
            let failed = |e| Error::io(path, e);
            let preamble = preamble(options, &plan.truth.name);
            out.write_all(preamble.as_bytes()).map_err(failed)?;
            let file = record(plan, options, index, |row| {
                let line = line(row, options.file, lsb);
                out.write_all(line.as_bytes()).map_err(failed)
            })?;
            truth.files.push(file);
            Ok(())
        })?;
    }
    let path = &paths[plans.len()];
    let json = serde_json::to_string_pretty(&truth).map_err(|e| Error::io(path, e.into()))?;
    write_text(path, force, &(json + "\n"))?;
    Ok((truth, paths))
}

/// Comment lines and header.
fn preamble(o: &SimulateOptions, name: &str) -> String {
    let s = &o.sensor;
    let header = match o.file {
        FileOptions { raw: true, .. } => RAW_HEADER,
        FileOptions {
            wrong_header: true, ..
        } => WRONG_HEADER,
        _ => Reading::HEADER.trim_end(),
    };
    let tool = crate::TOOL;
    let scenario = o.scenario.name();
    format!(
        "# simulated by {tool}, not measured: {scenario}, {name}; what was put in is in truth.json\n\
         # seed {}, rate {} Hz, range {} g and 250 °/s, low-pass {LOW_PASS_HZ} Hz, noise {} m/s/√s and {} °/√s\n\
         # gravity {} m/s², tilt of the poses {}°, jitter {} ms, lost rows {}\n\
         {header}\n",
        o.seed,
        o.rate_hz,
        s.accel_range_g,
        s.noise_factor * ACCEL_NOISE_MPS_RTS,
        s.noise_factor * GYRO_NOISE_DEG_RTS,
        o.gravity_mps2,
        o.tilt_sd_deg,
        o.stamp_jitter_ms,
        o.dropped_fraction,
    )
}

/// A row as text; `lsb`: m/s² and rad/s of one count.
fn line(row: &Row, file: FileOptions, lsb: [f64; 2]) -> String {
    let r = &row.reading;
    if !file.raw {
        return r.row(row.stamp_ms, usize::from(file.decimals));
    }
    let [ax, ay, az] = r.accel_mps2.map(|v| (v / lsb[0]).round() as i16);
    let [gx, gy, gz] = r.gyro_rad_s.map(|v| (v / lsb[1]).round() as i16);
    let (stamp_ms, t) = (row.stamp_ms, temperature_counts(r.temperature_c) as i16);
    format!("{stamp_ms},{ax},{ay},{az},{t},{gx},{gy},{gz}\n")
}

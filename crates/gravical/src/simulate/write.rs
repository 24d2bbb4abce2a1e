//! Writing of recordings and true values to files.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::options::{FileOptions, SimulateOptions};
use super::part::temperature_counts;
use super::record::record;
use super::sensor::{ACCEL_NOISE_MPS_RTS, GYRO_NOISE_DEG_RTS};
use super::truth::Truth;
use super::{BETWEEN_FILES_S, MOST_WRITTEN, file_truth, planned, truth_of};
use crate::output::{check_target, make_folder, write_atomic};
use crate::{Error, Result};

/// The header of the student report's logger, verbatim. It is wrong: the values under it are in m/s² and
/// rad/s.
const WRONG_HEADER: &str = "Timestamp,aX (g),aY (g),aZ (g),Temp (C),gX (°/s),gY (°/s),gZ (°/s)";
const TRUE_HEADER: &str =
    "Timestamp (ms),aX (m/s^2),aY (m/s^2),aZ (m/s^2),Temp (C),gX (rad/s),gY (rad/s),gZ (rad/s)";
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
    let (sensor, plans) = planned(options, MOST_WRITTEN)?;
    let names: Vec<&str> = plans.iter().map(|plan| plan.name.as_str()).collect();
    let mut paths = targets(&names, dir, force)?;
    let mut files = Vec::with_capacity(plans.len());
    let mut on_s = 0.0;
    let lsb = [sensor.accel_lsb, sensor.gyro_lsb];
    for (index, plan) in plans.into_iter().enumerate() {
        let path = &paths[index];
        let recorded = write_atomic(path, force, |out| {
            let mut lines = Lines::begin(path, options, &plan.name, lsb, out)?;
            record(&plan.path, &sensor, options, index, on_s, |row| {
                let r = &row.reading;
                lines.write(row.stamp_ms, r.accel, r.temperature_c, r.gyro)
            })
        })?;
        on_s += plan.path.duration_s() + BETWEEN_FILES_S;
        files.push(file_truth(plan, &recorded));
    }
    let truth = truth_of(&sensor, options, files);
    paths.push(write_truth(&truth, dir, force)?);
    Ok((truth, paths))
}

/// Paths of the recordings, after checking that all can be written.
fn targets(names: &[&str], dir: &Path, force: bool) -> Result<Vec<PathBuf>> {
    let paths: Vec<PathBuf> = names.iter().map(|name| dir.join(name)).collect();
    for path in paths.iter().chain([&dir.join(TRUTH)]) {
        check_target(path, force)?;
    }
    make_folder(dir)?;
    Ok(paths)
}

const TRUTH: &str = "truth.json";

fn write_truth(truth: &Truth, dir: &Path, force: bool) -> Result<PathBuf> {
    let path = dir.join(TRUTH);
    let json = serde_json::to_string_pretty(truth).map_err(|e| Error::io(&path, e.into()))?;
    write_atomic(&path, force, |out| {
        writeln!(out, "{json}").map_err(|e| Error::io(&path, e))
    })?;
    Ok(path)
}

/// Comment lines and header.
fn preamble(o: &SimulateOptions, name: &str) -> String {
    let s = &o.sensor;
    let low_pass = s
        .low_pass_hz
        .map_or("off".to_owned(), |f| format!("{f} Hz"));
    let header = match o.file {
        FileOptions { raw: true, .. } => RAW_HEADER,
        FileOptions {
            wrong_header: true, ..
        } => WRONG_HEADER,
        _ => TRUE_HEADER,
    };
    let tool = crate::TOOL;
    let scenario = o.scenario.name();
    format!(
        "# simulated by {tool}, not measured: {scenario}, {name}; what was put in is in truth.json\n\
         # seed {}, rate {} Hz, range {} g and {} °/s, low-pass {low_pass}, noise {} m/s/√s and {} °/√s\n\
         # gravity {} m/s², tilt of the poses {}°, jitter {} ms, lost rows {}\n\
         {header}\n",
        o.seed,
        o.rate_hz,
        s.accel_range_g,
        s.gyro_range_deg_s,
        s.noise_factor * ACCEL_NOISE_MPS_RTS,
        s.noise_factor * GYRO_NOISE_DEG_RTS,
        o.gravity_mps2,
        o.tilt_sd_deg,
        o.stamp_jitter_ms,
        o.dropped_fraction,
    )
}

/// Lines of a recording.
struct Lines<'a, W: ?Sized> {
    path: &'a Path,
    file: FileOptions,
    /// m/s² and rad/s of one count.
    lsb: [f64; 2],
    out: &'a mut W,
    text: String,
}

impl<'a, W: std::io::Write + ?Sized> Lines<'a, W> {
    /// Writes what is above the rows.
    fn begin(
        path: &'a Path,
        options: &SimulateOptions,
        name: &str,
        lsb: [f64; 2],
        out: &'a mut W,
    ) -> Result<Self> {
        out.write_all(preamble(options, name).as_bytes())
            .map_err(|e| Error::io(path, e))?;
        Ok(Lines {
            path,
            file: options.file,
            lsb,
            out,
            text: String::with_capacity(96),
        })
    }

    fn write(
        &mut self,
        stamp_ms: u64,
        accel: [f64; 3],
        temperature_c: f64,
        gyro: [f64; 3],
    ) -> Result<()> {
        self.text.clear();
        // Writing into a String cannot fail.
        let _ = self.line(stamp_ms, accel, temperature_c, gyro);
        self.out
            .write_all(self.text.as_bytes())
            .map_err(|e| Error::io(self.path, e))
    }

    fn line(
        &mut self,
        stamp_ms: u64,
        accel: [f64; 3],
        temperature_c: f64,
        gyro: [f64; 3],
    ) -> std::fmt::Result {
        let text = &mut self.text;
        write!(text, "{stamp_ms}")?;
        if self.file.raw {
            let [accel_lsb, gyro_lsb] = self.lsb;
            let counts = accel
                .map(|v| v / accel_lsb)
                .into_iter()
                .chain([temperature_counts(temperature_c)])
                .chain(gyro.map(|v| v / gyro_lsb));
            for value in counts {
                // The values are exact multiples of one count.
                write!(text, ",{}", value.round() as i16)?;
            }
        } else {
            let decimals = usize::from(self.file.decimals);
            for value in accel.into_iter().chain([temperature_c]).chain(gyro) {
                write!(text, ",{value:.decimals$}")?;
            }
        }
        writeln!(text)
    }
}

//! Reads every file of `$GRAVICAL_DATA` and `$GRAVICAL_DATA/../cases` with this crate and with a
//! program, and prints a line for each file: what both say, or how they differ.
//!
//! ```text
//! GRAVICAL_DATA=… cargo run --example compare -- target/debug/gravical
//! ```

use std::path::{Path, PathBuf};
use std::process::Command;

use gravical_recording::{AccelUnit, ReadOptions, Recording};
use serde_json::Value;

/// What both readers say of a file.
#[derive(PartialEq)]
struct Summary {
    rows: u64,
    columns: String,
    unit: String,
    gyro: bool,
    /// Ours, or median, mean and nominal rate; empty if it is unknown.
    rates_hz: Vec<f64>,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let program = std::env::args()
        .nth(1)
        .ok_or("name the program to compare with")?;
    let data = PathBuf::from(std::env::var_os("GRAVICAL_DATA").ok_or("GRAVICAL_DATA is not set")?);
    let mut files = Vec::new();
    collect(&data, &mut files)?;
    collect(&data.join("../cases"), &mut files)?;
    files.sort();
    let mut equal = 0;
    for file in &files {
        let new = Recording::open(file, &ReadOptions::default());
        let old = inspect(&program, file);
        let name = file.strip_prefix(&data).unwrap_or(file).display();
        let line = match (&new, &old) {
            (Err(_), Err(_)) => "equal: refused".to_owned(),
            (Err(e), Ok(_)) => format!("DIFFERS: new refuses: {e}"),
            (Ok(r), Err(e)) => format!("DIFFERS: old refuses: {e}; new {}", summary(r).line()),
            (Ok(r), Ok(old)) => summary(r).difference(old),
        };
        equal += usize::from(line.starts_with("equal"));
        println!("{name}: {line}");
        for note in new.iter().flat_map(|r| &r.notes) {
            println!("    {note}");
        }
    }
    println!("{equal} of {} equal", files.len());
    Ok(())
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) -> std::io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        let is_text = [".csv", ".txt", ".log", ".tsv", ".gz"]
            .iter()
            .any(|e| name.ends_with(e));
        if path.is_dir() {
            collect(&path, files)?;
        } else if is_text && !name.starts_with("LICENSE") && !name.starts_with("README") {
            files.push(path);
        }
    }
    Ok(())
}

fn summary(recording: &Recording) -> Summary {
    let scale = recording.accel_scale;
    let unit = match (scale.unit, scale.lsb_per_g) {
        (AccelUnit::Counts, Some(per_g)) => format!("counts/{per_g}"),
        (unit, _) => unit.name().to_owned(),
    };
    let channels = recording
        .accel
        .iter()
        .chain(recording.gyro.iter().flatten());
    let firsts = channels.map(|c| c.first().map_or("-".into(), |v| format!("{v:.4}")));
    Summary {
        rows: recording.rows() as u64,
        columns: firsts.collect::<Vec<_>>().join(" "),
        unit,
        gyro: recording.gyro.is_some(),
        rates_hz: recording.rate_hz().into_iter().collect(),
    }
}

/// What the program says; the error of a file that it refuses.
fn inspect(program: &str, file: &Path) -> Result<Summary, String> {
    let output = Command::new(program)
        .arg("inspect")
        .arg(file)
        .arg("--json")
        .output();
    let output = output.map_err(|e| e.to_string())?;
    let json: Value = serde_json::from_slice(&output.stdout).map_err(|e| e.to_string())?;
    let Some(recording) = json["recordings"].get(0) else {
        return Err(json["errors"][0]["message"]
            .as_str()
            .unwrap_or("no recording")
            .to_owned());
    };
    let accel = &recording["accelerometer"];
    let unit = match (accel["unit"].as_str(), accel["lsb_per_g"].as_f64()) {
        (Some("counts"), Some(per_g)) => format!("counts/{per_g}"),
        (unit, _) => unit.unwrap_or("unknown").to_owned(),
    };
    Ok(Summary {
        rows: recording["row_counts"]["rows"].as_u64().unwrap_or(0),
        columns: recording["columns"].to_string(),
        unit,
        gyro: !recording["gyroscope"].is_null(),
        rates_hz: ["median_rate_hz", "mean_rate_hz", "nominal_rate_hz"]
            .iter()
            .filter_map(|key| recording["timing"][key].as_f64())
            .collect(),
    })
}

impl Summary {
    fn line(&self) -> String {
        let Summary {
            rows,
            unit,
            gyro,
            rates_hz,
            ..
        } = self;
        format!("{rows} rows, {unit}, gyroscope {gyro}, {rates_hz:.2?} Hz")
    }

    fn difference(&self, old: &Summary) -> String {
        let rate_is_equal = match self.rates_hz.first() {
            Some(rate) => old
                .rates_hz
                .iter()
                .any(|old| (rate - old).abs() <= 0.01 * old),
            None => old.rates_hz.is_empty(),
        };
        let is_equal = self.rows == old.rows
            && self.unit == old.unit
            && self.gyro == old.gyro
            && rate_is_equal;
        if is_equal {
            format!("equal: {}", self.line())
        } else {
            let first = &self.columns;
            format!(
                "DIFFERS: old {} {}; new {} {first}",
                old.line(),
                old.columns,
                self.line()
            )
        }
    }
}

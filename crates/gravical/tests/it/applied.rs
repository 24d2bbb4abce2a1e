//! `apply` reads a file as `calibrate` does: real recordings and the cases of the reader.

use gravical::apply::{ApplyOptions, apply};
use gravical::calibration_file::Calibration;
use gravical::inspect::inspect;
use gravical::poses::face::AxisMap;
use gravical::recording::{AccelUnit, ReadOptions, Recording, read, source};

use crate::support::{data, files};

/// A calibration that only converts the unit of a recording to m/s².
fn nominal(recording: &Recording) -> Calibration {
    let scale = recording.units.accel.nominal().unwrap_or(1.0);
    let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let unit = match recording.units.accel.unit {
        AccelUnit::Counts => Some("a.u."),
        AccelUnit::Unknown => None,
        unit => Some(unit.name()),
    };
    let bias = [recording.units.zero_offset; 3];
    let file = serde_json::json!({
        "acc_unit": "m/s^2", "gyr_unit": "deg/s", "from_acc_unit": unit, "cal_type": "Ferraris",
        "K_a": identity.map(|row| row.map(|v| v * scale)), "b_a": bias, "R_a": identity,
        "K_g": identity, "b_g": [0, 0, 0], "R_g": identity, "K_ga": [[0, 0, 0], [0, 0, 0], [0, 0, 0]],
    });
    Calibration::parse(file.to_string().as_bytes()).unwrap()
}

/// Calibrated acceleration of the rows that have one.
fn calibrated(table: &[u8]) -> Vec<[f64; 3]> {
    let header_end = table.iter().position(|b| *b == b'\n').unwrap();
    let header = String::from_utf8_lossy(&table[..header_end]);
    let at = header.find("ax_mps2").unwrap();
    let mut behind = header.as_bytes()[at..].iter();
    let delimiter = *behind.find(|b| b",;\t|".contains(b)).unwrap();
    let mut reader = csv::ReaderBuilder::new();
    let reader = reader.delimiter(delimiter).flexible(true);
    let mut reader = reader.from_reader(table);
    let names = reader.byte_headers().unwrap().clone();
    let axes = ["ax_mps2", "ay_mps2", "az_mps2"]
        .map(|axis| names.iter().position(|n| n == axis.as_bytes()).unwrap());
    let mut rows = Vec::new();
    for record in reader.byte_records() {
        let record = record.unwrap();
        let cell = |c: usize| String::from_utf8_lossy(&record[c]).replace(',', ".");
        let cells = axes.map(|c| cell(c).parse::<f64>().ok());
        if let [Some(x), Some(y), Some(z)] = cells {
            rows.push([x, y, z]);
        }
    }
    rows
}

sampled! {
    apply_uses_the_reading_of_calibrate(4, 1);
}

/// Of one recording in `step`.
fn apply_uses_the_reading_of_calibrate(step: usize) {
    let Some(data) = data() else { return };
    let mut paths = Vec::new();
    files(&data, &mut paths);
    files(&data.join("../cases"), &mut paths);
    let (mut compared, mut readable) = (0, 0);
    for path in paths.into_iter().step_by(step) {
        let name = path.display().to_string();
        let recording = match read(&path, &ReadOptions::default()) {
            Ok(recording) => recording,
            Err(e) => {
                assert!(e.hint().is_some(), "{name}: {e}");
                continue;
            }
        };
        readable += 1;
        assert!(recording.rows() > 0, "{name}");
        let account = &recording.ledger;
        let balances = recording.is_averaged() || account.rows() == recording.rows();
        assert!(balances, "{name}: {}", account.sum());
        inspect(&recording, &AxisMap::default());
        let mut table = Vec::new();
        let input = source::open(&path, &ReadOptions::default()).unwrap();
        let options = ApplyOptions::default();
        let summary = match apply(&nominal(&recording), input, &name, &mut table, &options) {
            Ok(summary) => summary,
            Err(e) => {
                assert_eq!(e.code(), "unit-mismatch", "{name}: {e}");
                continue;
            }
        };
        let scale = recording.units.accel.nominal().unwrap_or(1.0);
        let is_whole = |row: &usize| recording.accel_at(*row).iter().all(|v| v.is_finite());
        let rows: Vec<usize> = (0..recording.rows()).filter(is_whole).collect();
        let table = calibrated(&table);
        assert_eq!(table.len(), rows.len(), "{name}");
        let measured = summary.rows - summary.rows_without_acceleration;
        assert_eq!(measured, rows.len() as u64, "{name}");
        for (values, row) in table.iter().zip(rows) {
            for (value, raw) in values.iter().zip(recording.accel_at(row)) {
                assert!((value - raw / scale).abs() < 1e-6, "{name}, row {row}");
            }
        }
        compared += 1;
    }
    assert!(
        compared > 70 / step && readable > 100 / step,
        "{compared} {readable}"
    );
}

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::Value;

use super::*;

/// The rows of a table by the names of their columns.
type Table = Vec<BTreeMap<String, String>>;

fn parse(table: &[u8]) -> Table {
    let mut reader = csv::Reader::from_reader(table);
    let rows: Result<Table, _> = reader.deserialize().collect();
    rows.unwrap()
}

fn run_with(
    csv: &str,
    calibration: Option<&CalibrationFile>,
    options: &SummariseOptions,
) -> Result<(WearableSummary, Table)> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("worn.csv");
    std::fs::write(&path, csv).unwrap();
    let mut table = Vec::new();
    let summary = summarise(&path, calibration, options, &mut table)?;
    Ok((summary, parse(&table)))
}

fn run(csv: &str, options: &SummariseOptions) -> (WearableSummary, Table) {
    run_with(csv, None, options).unwrap()
}

fn number(row: &BTreeMap<String, String>, column: &str) -> f64 {
    row[column].parse().unwrap_or(f64::NAN)
}

fn has(summary: &WearableSummary, kind: FindingKind) -> bool {
    summary.findings.iter().any(|f| f.kind == kind)
}

/// Rows at these times, s since 1970, of a sensor that hangs still but for a little noise.
fn at(times: impl Iterator<Item = f64>) -> String {
    let mut csv = "time_s,ax_g,ay_g,az_g\n".to_owned();
    for (i, t) in times.enumerate() {
        let noise = if i % 2 == 0 { 0.001 } else { -0.001 };
        csv += &format!("{t:.3},{:.4},0.6000,{:.4}\n", noise, 0.8 + noise);
    }
    csv
}

/// 2026-01-01T00:00:00Z.
const NEW_YEAR: f64 = 1_767_225_600.0;

fn zone(name: &str) -> Option<Zone> {
    Some(name.parse().unwrap())
}

#[test]
fn the_measures_are_those_of_numpy() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/reference/epochs");
    let expected = std::fs::read_to_string(folder.join("epochs.json")).unwrap();
    let expected: Vec<Value> = serde_json::from_str(&expected).unwrap();
    let mut table = Vec::new();
    let options = SummariseOptions::default();
    let summary = summarise(&folder.join("recording.csv"), None, &options, &mut table).unwrap();
    let table = parse(&table);
    assert_eq!(table.len(), expected.len());
    for (row, expected) in table.iter().zip(&expected) {
        assert_eq!(row["time"], expected["time"]);
        let compare = |column: &str, value: &Value, within: f64| {
            let (own, value) = (number(row, column), value.as_f64().unwrap());
            assert!((own - value).abs() <= within, "{column}: {own} {value}");
        };
        for (i, axis) in ["ax", "ay", "az", "norm"].iter().enumerate() {
            compare(&format!("{axis}_mean_g"), &expected["mean_g"][i], 0.6e-5);
            compare(&format!("{axis}_sd_mg"), &expected["sd_mg"][i], 0.6e-3);
        }
        for column in ["enmo_mg", "mad_mg", "angle_z_deg"] {
            compare(column, &expected[column], 0.6e-3);
        }
        compare("temperature_c", &expected["temperature_c"], 0.6e-2);
        compare("samples", &expected["samples"], 0.0);
        compare("missing", &expected["missing"], 0.0);
    }
    assert_eq!((summary.samples, summary.missing), (369, 6));
    assert!(has(&summary, FindingKind::EpochsUncalibrated));
}

#[test]
fn days_of_the_change_of_summer_time_have_23_and_25_hours() {
    let options = SummariseOptions {
        epoch_s: 60,
        time_zone: zone("Europe/Berlin"),
        ..SummariseOptions::default()
    };
    // Midnights in Berlin: 2026-03-28T23:00:00Z, 2026-10-24T22:00:00Z.
    for (midnight, hours, first, last) in [
        (
            1_774_738_800,
            23,
            "2026-03-29T00:00:00+01:00",
            "2026-03-29T23:59:00+02:00",
        ),
        (
            1_792_879_200,
            25,
            "2026-10-25T00:00:00+02:00",
            "2026-10-25T23:59:00+01:00",
        ),
    ] {
        let (summary, table) = run(
            &at((0..26 * 3600).map(|s| f64::from(midnight + s))),
            &options,
        );
        let day = &summary.days[0];
        assert_eq!(day.worn.epochs, hours * 60);
        let of_day = &table[..hours as usize * 60];
        assert_eq!(of_day[0]["time"], first);
        assert_eq!(of_day[of_day.len() - 1]["time"], last);
        assert_eq!(day.day, first[..10]);
        // Epochs stay equally long, and every clock time is there once.
        assert!(of_day.iter().all(|row| row["samples"] == "60"));
        let mut times: Vec<&str> = of_day.iter().map(|row| &row["time"][..]).collect();
        times.dedup();
        assert_eq!(times.len(), of_day.len());
        // It was not worn.
        assert_eq!(day.worn.nonwear_s, hours * 3600);
    }
}

#[test]
fn no_sample_is_lost_or_counted_twice() {
    // Every seventh row is lost; epochs of all lengths, from any moment on.
    for epoch_s in [1, 4, 5, 12, 20, 60] {
        let options = SummariseOptions {
            epoch_s,
            ..SummariseOptions::default()
        };
        let times = (0..6000).filter(|i| i % 7 != 3);
        let csv = at(times.map(|i| NEW_YEAR + 7.77 + f64::from(i) / 20.0));
        let (summary, table) = run(&csv, &options);
        let sum = |column| table.iter().map(|row| number(row, column)).sum::<f64>();
        assert_eq!(summary.samples + summary.missing, 6000, "{epoch_s}");
        assert_eq!(sum("samples"), summary.samples as f64);
        assert_eq!(sum("missing"), summary.missing as f64);
        assert_eq!(summary.rows, summary.samples);
        let full = u64::from(epoch_s) * 20;
        let inner = &table[1..table.len() - 1];
        for row in inner {
            assert_eq!(number(row, "samples") + number(row, "missing"), full as f64);
            assert!(number(row, "enmo_mg") >= 0.0 && number(row, "mad_mg") >= 0.0);
        }
    }
}

#[test]
fn a_gap_is_empty_rows_and_a_pause_misses_nothing() {
    let minutes = |from: i32, to: i32| (from * 600..to * 600).map(|i| f64::from(i) / 10.0);
    let both = minutes(0, 5).chain(minutes(8, 10)).map(|s| NEW_YEAR + s);
    let (summary, table) = run(&at(both), &SummariseOptions::default());
    assert_eq!((table.len(), summary.worn.epochs_empty), (120, 36));
    assert_eq!((summary.samples, summary.missing), (4200, 1800));
    let empty = &table[60];
    assert_eq!(empty["time"], "2026-01-01T00:05:00Z");
    assert!(empty["enmo_mg"].is_empty() && empty["nonwear"].is_empty());
    assert_eq!((&empty["samples"][..], &empty["missing"][..]), ("0", "50"));
    assert!(has(&summary, FindingKind::EpochsEmpty));
    // The same with blank lines: the recorder was stopped.
    let mut csv = at(minutes(0, 5).map(|s| NEW_YEAR + s));
    csv += "\n\n";
    csv += at(minutes(8, 10).map(|s| NEW_YEAR + s))
        .split_once('\n')
        .unwrap()
        .1;
    let (summary, table) = run(&csv, &SummariseOptions::default());
    assert_eq!((table.len(), summary.missing), (120, 0));
}

#[test]
fn the_table_follows_a_clock_that_is_set() {
    let half_hours = |starts: &[f64]| {
        let rows = |s: &f64| {
            let start = NEW_YEAR + s;
            (0..9000).map(move |i| start + f64::from(i) / 5.0)
        };
        at(starts.iter().flat_map(rows).collect::<Vec<_>>().into_iter())
    };
    // Back by an hour, as a clock in local time in autumn; ahead by a month.
    for second in [-1800.0, 30.0 * 86_400.0] {
        let (summary, table) = run(&half_hours(&[0.0, second]), &SummariseOptions::default());
        assert_eq!(table.len(), 720, "{second}");
        assert_eq!((summary.samples, summary.missing), (18_000, 0));
        assert!(has(&summary, FindingKind::EpochsJump));
        assert_eq!(table[359]["time"], "2026-01-01T00:29:55Z");
    }
    // A stamp that steps back by less than an epoch stays where it is.
    let jitter = (0..3000).map(|i| NEW_YEAR + f64::from(i) / 10.0 - f64::from(i % 50 / 49));
    let (summary, table) = run(&at(jitter), &SummariseOptions::default());
    assert_eq!((table.len(), summary.samples), (60, 3000));
    assert!(!has(&summary, FindingKind::EpochsJump));
}

#[test]
fn a_clock_without_dates_counts_from_the_first_sample() {
    let csv = at((0..1000).map(|i| 7.3 + f64::from(i) / 50.0));
    let (summary, table) = run(&csv, &SummariseOptions::default());
    let starts: Vec<&str> = table.iter().map(|row| &row["t_s"][..]).collect();
    assert_eq!(starts, ["0", "5", "10", "15"]);
    assert!(table.iter().all(|row| row["samples"] == "250"));
    assert_eq!(
        (summary.time_zone, &summary.days[0].day[..]),
        (None, "day 1")
    );
    let in_a_zone = SummariseOptions {
        time_zone: zone("Europe/Berlin"),
        ..SummariseOptions::default()
    };
    let error = run_with(&csv, None, &in_a_zone).unwrap_err();
    assert_eq!((error.code(), error.is_usage()), ("time-zone-unused", true));
    // Without stamps it needs a rate.
    let untimed: String = csv
        .lines()
        .map(|line| line.split_once(',').unwrap().1.to_owned() + "\n")
        .collect();
    let error = run_with(&untimed, None, &SummariseOptions::default()).unwrap_err();
    assert_eq!(error.code(), "rate-unknown");
    let mut options = SummariseOptions::default();
    options.read.rate_hz = Some(50.0);
    assert_eq!(run(&untimed, &options).1, table);
}

#[test]
fn a_start_above_the_header_gives_dates() {
    let rows = at((0..1000).map(|i| f64::from(i) / 50.0));
    let untimed: String = rows
        .lines()
        .map(|line| line.split_once(',').unwrap().1.to_owned() + "\n")
        .collect();
    let options = SummariseOptions {
        time_zone: zone("Europe/Berlin"),
        ..SummariseOptions::default()
    };
    let head = "Start Time 12:00:00\nStart Date 2026-01-01\nSampling rate: 50 Hz\n";
    for csv in [untimed, rows] {
        let (summary, table) = run(&format!("{head}{csv}"), &options);
        assert_eq!(table[0]["time"], "2026-01-01T13:00:00+01:00");
        assert_eq!((table.len(), &summary.days[0].day[..]), (4, "2026-01-01"));
    }
}

#[test]
fn stamps_of_whole_seconds_are_spread_evenly() {
    // 30 Hz, 20 min; the first minutes hold half a sample a second more.
    let seconds = (0..1200).flat_map(|s| {
        let rows = if s < 60 && s % 4 == 0 { 31 } else { 30 };
        std::iter::repeat_n(NEW_YEAR + f64::from(s), rows)
    });
    let (summary, table) = run(&at(seconds), &SummariseOptions::default());
    assert_eq!(summary.samples, 36_015);
    assert!((240..=241).contains(&table.len()), "{}", table.len());
    let inner = &table[1..table.len() - 2];
    assert!(
        inner
            .iter()
            .all(|r| (149.0..=151.0).contains(&number(r, "samples")))
    );
}

#[test]
fn a_calibration_takes_the_bias_out_of_enmo() {
    let calibration = CalibrationFile::parse(
        br#"{
            "acc_unit": "m/s^2", "gyr_unit": "deg/s", "from_acc_unit": "g", "cal_type": "Ferraris",
            "K_a": [[0.10197162, 0, 0], [0, 0.10197162, 0], [0, 0, 0.10197162]],
            "b_a": [0, 0, 0.02], "R_a": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
            "K_g": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "b_g": [0, 0, 0],
            "R_g": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "K_ga": [[0, 0, 0], [0, 0, 0], [0, 0, 0]]
        }"#,
    )
    .unwrap();
    let mut csv = "time_s,ax_g,ay_g,az_g\n".to_owned();
    for i in 0..1000 {
        csv += &format!(
            "{:.2},0.0000,0.0000,1.0200\n",
            NEW_YEAR + f64::from(i) / 50.0
        );
    }
    let options = SummariseOptions::default();
    let (biased, _) = run(&csv, &options);
    assert!((biased.worn.enmo_mg.unwrap() - 20.0).abs() < 1e-6);
    let (summary, table) = run_with(&csv, Some(&calibration), &options).unwrap();
    assert!(summary.worn.enmo_mg.unwrap() < 1e-3 && summary.calibrated);
    assert_eq!(table[0]["az_mean_g"], "1.00000");
    assert!(!has(&summary, FindingKind::EpochsUncalibrated));
    // Of another unit.
    let in_mps2 = csv.replace("1.0200", "10.0027").replace("_g", "_mps2");
    let error = run_with(&in_mps2, Some(&calibration), &options).unwrap_err();
    assert_eq!(error.code(), "unit-mismatch");
}

#[test]
fn epochs_are_parts_of_a_minute() {
    for epoch_s in [0, 7, 40, 61, 120] {
        let options = SummariseOptions {
            epoch_s,
            ..SummariseOptions::default()
        };
        assert_eq!(options.validate().unwrap_err().code(), "option-range");
    }
}

#[test]
fn stamps_that_are_no_times_do_not_end_it() {
    let mut csv = at((0..500).map(|i| NEW_YEAR + f64::from(i) / 10.0));
    for stamp in ["1e300", "-1e300", "", "nan", "9e15"] {
        csv += &format!("{stamp},0.0,0.6,0.8\n");
    }
    let (summary, table) = run(&csv, &SummariseOptions::default());
    assert_eq!(summary.samples + summary.missing, summary.rows);
    assert!(table.len() < 40);
}

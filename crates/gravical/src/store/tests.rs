//! Stores made by hand.

use std::path::Path;

use super::*;
use crate::calibrate::{CalibrateOptions, Method, calibrate};
use crate::calibration_file::{
    Grade, RecordingTime, RecordingTimeSource, TemperatureRange, to_imucal,
};
use crate::recording::{AccelScale, AccelUnit, Origin, ReadOptions, Recording, read_bytes};
use crate::utc::UtcTime;

fn recording(text: &str) -> Recording {
    read_bytes(text.as_bytes(), "means.csv", &ReadOptions::default()).unwrap()
}

/// A calibration in m/s² of `sensor` at `time`; `bias` tells them apart.
fn calibration(sensor: &str, time: &str, bias: f64) -> CalibrationFile {
    let csv = "label,ax,ay,az\n-x,-9.43,-0.27,0.92\n+x,10.20,-0.04,-0.10\n\
               -y,0.46,-9.99,0.39\n+y,0.29,9.73,0.49\n-z,-0.05,-0.08,-9.54\n+z,0.83,-0.18,10.42\n";
    let mut options = CalibrateOptions::default();
    options.estimate.method = Method::Ferraris;
    let mut file = calibrate(&[recording(csv)], &options).unwrap().file;
    file.sensor.id = Some(sensor.to_owned());
    file.accelerometer.bias[0] = bias;
    file.verdict.grade = Grade::Good;
    file.recorded = Some(RecordingTime {
        time: time.parse().unwrap(),
        source: RecordingTimeSource::TimeStamps,
    });
    file
}

fn store() -> (tempfile::TempDir, Store) {
    let folder = tempfile::tempdir().unwrap();
    let store = Store::create(&folder.path().join("cals")).unwrap();
    (folder, store)
}

/// A store of sensor "A", calibrated on these days; the bias is the number of each.
fn filled(days: &[&str]) -> (tempfile::TempDir, Store) {
    let (folder, store) = store();
    for (i, day) in days.iter().enumerate() {
        store.add(&calibration("A", day, i as f64)).unwrap();
    }
    (folder, store)
}

fn query(day: &str) -> Query {
    Query {
        sensor_id: Some("A".to_owned()),
        time: day.parse().unwrap(),
        time_source: QueryTimeSource::TimeStamps,
        ..Query::now()
    }
}

/// Number of the chosen calibration, or the message of the error.
fn chosen(store: &Store, query: &Query) -> std::result::Result<f64, String> {
    let stored = store.read().unwrap();
    let choice = stored.choose(query);
    choice
        .map(|(c, _)| c.file.accelerometer.bias[0])
        .map_err(|e| format!("{} {}", e.message(), e.hint().unwrap_or("")))
}

#[test]
fn a_calibration_is_filed_under_sensor_and_time() {
    let (_folder, store) = store();
    let file = calibration("left foot", "2026-03-09T10:15:00Z", 0.0);
    let added = store.add(&file).unwrap();
    let path = added.path.to_string_lossy().into_owned();
    assert!(path.contains("/left_foot-"), "{path}");
    assert!(path.contains("/2026-03-09T10-15-00Z-"), "{path}");
    assert_eq!(CalibrationFile::read(&added.path).unwrap(), file);
    let stored = store.read().unwrap();
    assert_eq!(stored.of("left foot").unwrap()[0].path, added.path);
    assert_eq!(stored.list().sensors[0].sensor_id, "left foot");
}

#[test]
fn the_same_twice_is_one_file_and_others_are_not() {
    let (_folder, store) = store();
    let file = calibration("A", "2026-03-09", 0.0);
    let first = store.add(&file).unwrap();
    // Another day, another command, the same content.
    let again = CalibrationFile {
        created: "2027-01-01T00:00:00Z".to_owned(),
        command: Some("gravical calibrate".to_owned()),
        ..file.clone()
    };
    let second = store.add(&again).unwrap();
    assert!(second.existed && !first.existed && second.path == first.path);
    // Another sensor with the same parameters, and the same second with others.
    assert!(
        !store
            .add(&calibration("B", "2026-03-09", 0.0))
            .unwrap()
            .existed
    );
    assert!(
        !store
            .add(&calibration("A", "2026-03-09", 1.0))
            .unwrap()
            .existed
    );
    assert_eq!(store.read().unwrap().calibrations.len(), 3);
}

#[test]
fn without_a_date_the_time_of_the_calibration_counts() {
    let (_folder, store) = store();
    let mut file = calibration("A", "2026-03-09", 0.0);
    file.recorded = None;
    file.created = "2026-05-01T00:00:00Z".to_owned();
    store.add(&file).unwrap();
    // Calibrated again, it is still the same session.
    file.created = "2026-06-01T00:00:00Z".to_owned();
    assert!(store.add(&file).unwrap().existed);
    let stored = store.read().unwrap();
    let one = &stored.calibrations[0];
    assert_eq!(one.time.to_string(), "2026-05-01T00:00:00Z");
    assert_eq!(one.time_source, StoredTimeSource::Calibration);
    file.created = "yesterday".to_owned();
    file.accelerometer.bias[0] = 1.0;
    assert_eq!(store.add(&file).unwrap_err().code(), "date-syntax");
    file.sensor.id = Some(" ".to_owned());
    assert_eq!(store.add(&file).unwrap_err().code(), "sensor-id-missing");
}

#[test]
fn many_at_once_lose_nothing() {
    let (_folder, store) = store();
    const THREADS: usize = 16;
    const EACH: usize = 12;
    let new: usize = std::thread::scope(|scope| {
        let add = |thread: usize| {
            let store = store.clone();
            scope.spawn(move || {
                let mut new = 0;
                for i in 0..EACH {
                    // All within one second; every fourth one is everybody's.
                    let own = if i % 4 == 0 {
                        i
                    } else {
                        1000 * (thread + 1) + i
                    };
                    let file = calibration("A", "2026-03-09", own as f64);
                    new += usize::from(!store.add(&file).unwrap().existed);
                    // Readers meanwhile see whole files only.
                    assert!(store.read().unwrap().left_out.is_empty());
                }
                new
            })
        };
        let threads: Vec<_> = (0..THREADS).map(add).collect();
        threads.into_iter().map(|t| t.join().unwrap()).sum()
    });
    let wanted = THREADS * EACH * 3 / 4 + EACH / 4;
    assert_eq!(store.read().unwrap().calibrations.len(), wanted);
    assert_eq!(new, wanted);
}

#[test]
fn the_last_one_before_is_taken_or_the_nearest() {
    let (_folder, store) = filled(&["2026-01-01", "2026-02-01", "2026-04-01"]);
    assert_eq!(chosen(&store, &query("2026-03-20")), Ok(1.0));
    assert_eq!(chosen(&store, &query("2026-04-01")), Ok(2.0));
    let nearest = Query {
        nearest: true,
        ..query("2026-03-20")
    };
    assert_eq!(chosen(&store, &nearest), Ok(2.0));
    let early = chosen(&store, &query("2025-12-31")).unwrap_err();
    assert!(
        early.contains("made 24.0 hours after the recording"),
        "{early}"
    );
    assert!(early.contains("--nearest"), "{early}");
    let stored = store.read().unwrap();
    let (_, choice) = stored.choose(&query("2026-03-20")).unwrap();
    assert_eq!((choice.age_days, choice.candidates), (47.0, 3));
    assert_eq!(choice.rejected.len(), 1);
    assert!(choice.reasons[0].contains("47.0 days before"), "{choice:?}");
}

#[test]
fn the_age_has_a_limit() {
    let (_folder, store) = filled(&["2026-01-01"]);
    let within = |days: f64| Query {
        max_age_days: Some(days),
        ..query("2026-04-11")
    };
    assert_eq!(chosen(&store, &within(100.0)), Ok(0.0));
    let old = chosen(&store, &within(90.0)).unwrap_err();
    assert!(
        old.contains("100.0 days before") && old.contains("90 days"),
        "{old}"
    );
    assert!(old.contains("--max-age"), "{old}");
    let wrong = store.read().unwrap();
    let error = wrong.choose(&within(f64::NAN)).unwrap_err();
    assert_eq!(
        (error.code(), error.option()),
        ("option-range", Some("max_age_days"))
    );
}

#[test]
fn options_that_admit_it_together_are_named() {
    let (_folder, store) = filled(&["2026-02-15"]);
    let early = Query {
        max_age_days: Some(10.0),
        ..query("2026-01-01")
    };
    let said = chosen(&store, &early).unwrap_err();
    assert_eq!(said.matches("45.0 days after").count(), 1, "{said}");
    assert!(said.contains("--nearest with --max-age 45 takes"), "{said}");
    let admitted = Query {
        nearest: true,
        max_age_days: Some(45.0),
        ..early
    };
    assert_eq!(chosen(&store, &admitted), Ok(0.0));
}

#[test]
fn of_two_calibrations_of_one_session_the_last_is_taken() {
    let (_folder, store) = filled(&["2026-01-01"]);
    let mut again = calibration("A", "2026-01-01", 7.0);
    again.created = "2099-01-01T00:00:00Z".to_owned();
    store.add(&again).unwrap();
    let stored = store.read().unwrap();
    let (best, choice) = stored.choose(&query("2026-01-02")).unwrap();
    assert_eq!(best.file.accelerometer.bias[0], 7.0);
    assert_eq!(
        choice.reasons.last().unwrap(),
        "1 more fits, too, and was computed earlier"
    );
}

#[test]
fn units_ranges_and_temperatures_have_to_fit() {
    let (_folder, store) = store();
    let mut in_counts = calibration("A", "2026-01-01", 0.0);
    in_counts.accelerometer.input_unit = AccelUnit::Counts;
    in_counts.accelerometer.scale = [1670.0, 1671.0, 1672.0]; // 16384 a g
    in_counts.temperature_c = Some(TemperatureRange {
        mean: 22.0,
        min: 21.0,
        max: 23.0,
    });
    store.add(&in_counts).unwrap();
    let scale = |unit, lsb_per_g| AccelScale {
        unit,
        lsb_per_g,
        origin: Origin::Data,
    };
    let with = |unit, lsb_per_g, temperature_c| Query {
        accelerometer: Some(scale(unit, lsb_per_g)),
        temperature_c,
        ..query("2026-02-01")
    };
    let counts = AccelUnit::Counts;
    assert_eq!(chosen(&store, &with(counts, Some(16384.0), None)), Ok(0.0));
    assert_eq!(chosen(&store, &with(counts, None, None)), Ok(0.0));
    assert_eq!(
        chosen(&store, &with(AccelUnit::Unknown, None, None)),
        Ok(0.0)
    );
    let unit = chosen(&store, &with(AccelUnit::StandardGravity, None, None)).unwrap_err();
    assert!(unit.contains("for counts, the recording is in g"), "{unit}");
    let range = chosen(&store, &with(counts, Some(8192.0), None)).unwrap_err();
    assert!(
        range.contains("16387 counts per g, the recording has 8192"),
        "{range}"
    );
    let at = |low, high| with(counts, Some(16384.0), Some([low, high]));
    assert_eq!(chosen(&store, &at(15.0, 33.0)), Ok(0.0));
    let cold = chosen(&store, &at(8.0, 20.0)).unwrap_err();
    assert!(cold.contains("21.0 to 23.0 °C"), "{cold}");
    assert!(
        cold.contains("13.0 °C outside, the limit is 10 °C"),
        "{cold}"
    );
    assert!(cold.contains("--max-temperature-difference"), "{cold}");
}

#[test]
fn a_poor_one_is_never_taken() {
    let (_folder, store) = filled(&["2026-01-01"]);
    let mut poor = calibration("A", "2026-02-01", 1.0);
    poor.verdict.grade = Grade::Poor;
    store.add(&poor).unwrap();
    assert_eq!(chosen(&store, &query("2026-03-01")), Ok(0.0));
}

#[test]
fn other_sensors_are_named() {
    let (_folder, store) = filled(&["2026-01-01"]);
    store
        .add(&calibration("left-foot", "2026-01-01", 0.0))
        .unwrap();
    let stored = store.read().unwrap();
    let other = Query {
        sensor_id: Some("Left-Foot".to_owned()),
        ..query("2026-02-01")
    };
    let error = stored.choose(&other).unwrap_err();
    assert_eq!(error.code(), "no-such-sensor");
    assert!(
        error.message().ends_with("it has \"left-foot\", \"A\""),
        "{error}"
    );
    let none = Query {
        sensor_id: None,
        ..query("2026-02-01")
    };
    let error = stored.choose(&none).unwrap_err();
    assert_eq!(error.code(), "sensor-id-missing");
    assert!(error.message().contains("\"A\", \"left-foot\""), "{error}");
    assert_eq!(
        Store::open(Path::new("/no/such")).unwrap_err().code(),
        "no-store"
    );
}

#[test]
fn folders_of_imucal_are_read() {
    let (folder, store) = filled(&["2020-01-01"]);
    let imucal = to_imucal(&calibration("x", "2020-01-01", 5.0)).unwrap();
    let own = folder.path().join("cals/A/Ferraris");
    std::fs::create_dir_all(&own).unwrap();
    // imucal writes ids in lower case into the name of the file.
    std::fs::write(own.join("a_2020-08-12_13-21.json"), &imucal).unwrap();
    std::fs::write(folder.path().join("cals/cc_2020-08-12_13-21.json"), &imucal).unwrap();
    std::fs::write(own.join("latest.json"), &imucal).unwrap();
    let stored = store.read().unwrap();
    assert_eq!(chosen(&store, &query("2020-09-01")), Ok(5.0));
    assert_eq!(stored.of("A").unwrap().len(), 2);
    assert_eq!(
        stored.of("cc").unwrap()[0].time_source,
        StoredTimeSource::FileName
    );
    assert_eq!(stored.left_out.len(), 1);
    assert!(
        stored.left_out[0]
            .reason
            .contains("SENSOR_2026-03-09_10-15.json")
    );
}

#[test]
fn what_is_no_calibration_is_left_out_with_its_reason() {
    let (folder, store) = filled(&["2026-01-01"]);
    let cals = folder.path().join("cals");
    std::fs::write(cals.join("A/notes.json"), "{\"a\": 1}").unwrap();
    std::fs::write(cals.join("A/half.json"), "{\"format\": ").unwrap();
    std::fs::write(cals.join("README.txt"), "ours").unwrap();
    let mut nameless = calibration("A", "2026-02-01", 7.0);
    nameless.sensor.id = None;
    nameless.write(&cals.join("nameless.json"), false).unwrap();
    // In a folder it belongs to the sensor of that.
    nameless
        .write(&cals.join("A/nameless.json"), false)
        .unwrap();
    let stored = store.read().unwrap();
    assert_eq!(stored.left_out.len(), 3, "{:?}", stored.left_out);
    assert_eq!(chosen(&store, &query("2026-03-01")), Ok(7.0));
}

#[test]
fn a_recording_gives_sensor_time_unit_and_temperature() {
    let text = "Serial Number: MOS2D12345678\nepoch (s),ax (g),ay (g),az (g),temp (°C)\n\
                1767225600.00,0.01,0.02,1.00,21.5\n1767225600.01,0.01,0.02,1.00,21.7\n\
                1767225600.02,0.01,0.02,1.00,21.6\n1767225600.03,0.01,0.02,1.00,21.6\n";
    let query = Query::of(&[recording(text)]).unwrap();
    assert_eq!(query.sensor_id.as_deref(), Some("MOS2D12345678"));
    assert_eq!(query.time.to_string(), "2026-01-01T00:00:00Z");
    assert_eq!(query.time_source, QueryTimeSource::TimeStamps);
    assert_eq!(
        query.accelerometer.unwrap().unit,
        AccelUnit::StandardGravity
    );
    assert_eq!(query.temperature_c, Some([21.5, 21.7]));
    let plain = Query::of(&[recording("t_ms,ax,ay,az\n0,0,0,9.8\n10,0,0,9.8\n")]).unwrap();
    assert_eq!(
        (plain.sensor_id, plain.time_source),
        (None, QueryTimeSource::Now)
    );
    assert!(plain.time >= "2020-01-01".parse::<UtcTime>().unwrap());
}

#[test]
fn a_history_has_the_times_as_names() {
    let (_folder, store) = filled(&["2026-01-01", "2026-02-01"]);
    let history = store.read().unwrap().history("A").unwrap();
    assert_eq!(history.history.entries[1].name, "2026-02-01");
    store
        .add(&calibration("A", "2026-02-01T08:00Z", 7.0))
        .unwrap();
    let history = store.read().unwrap().history("A").unwrap();
    assert_eq!(history.history.entries[2].name, "2026-02-01T08:00:00Z");
    assert_eq!(history.calibrations.len(), 3);
    // Six means have no covariance.
    assert_eq!(history.history.tested, 0);
}

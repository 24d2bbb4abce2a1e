//! Sessions of every shape: the same sensor, the same parameters.

use gravical::calibrate::{CalibrateOptions, calibrate};
use gravical::calibration_file::Grade;
use gravical::check::{CheckOptions, Judgement, check};
use gravical::inspect::inspect;
use gravical::poses::SegmentOptions;
use gravical::poses::face::AxisMap;
use gravical::poses::sections::parse_sections;
use gravical::recording::{ReadOptions, Recording, read_bytes};
use gravical::simulate::{Scenario, SimulateOptions, Simulation, SixPositionOptions, simulate};

use crate::support::*;

/// Bias and scale have to be those of `sensor`, to what the noise allows.
fn fits(session: &[Recording], options: &CalibrateOptions, sensor: &Sensor) {
    let file = calibrated(session, options).file;
    let a = &file.accelerometer;
    for i in 0..3 {
        close(a.bias[i], sensor.bias[i] * sensor.unit, 0.01 * sensor.unit);
        let norm = sensor.matrix[i].iter().map(|v| v * v).sum::<f64>().sqrt();
        close(a.scale[i], norm * sensor.unit, 0.001 * sensor.unit);
        for j in 0..3 {
            let model = a.scale[i] * a.orientation[i][j];
            close(
                model,
                sensor.matrix[i][j] * sensor.unit,
                0.002 * sensor.unit,
            );
        }
    }
    assert_eq!(file.verdict.grade, Grade::NotVerifiable);
}

fn named(name: &str, text: &str) -> Recording {
    read_bytes(text.as_bytes(), name, &ReadOptions::default()).unwrap()
}

#[test]
fn six_files_with_names_that_say_nothing() {
    let sensor = Sensor::default();
    let mut session = six_files(&sensor, 600);
    for (i, recording) in session.iter_mut().enumerate() {
        recording.name = format!("recording_0{i}.csv");
    }
    fits(&session, &given_gravity(), &sensor);
}

/// All six holds in one file, and where they are.
fn one_file(sensor: &Sensor, labels: Option<[&str; 6]>) -> (String, Vec<std::ops::Range<usize>>) {
    let mut text = "t_ms,ax,ay,az".to_owned();
    text += if labels.is_some() { ",part\n" } else { "\n" };
    let mut noise = Noise::new(9);
    let mut row = 0_usize;
    let mut holds = Vec::new();
    for (i, (_, up)) in FACES.iter().enumerate() {
        // The hand: two seconds of shaking.
        for _ in 0..200 {
            let shaken: Vec<String> = (0..3)
                .map(|k| format!("{:.4}", sensor.unit * (9.81 * up[k] + 3.0 * noise.normal())))
                .collect();
            text += &format!("{},{}", 10 * row, shaken.join(","));
            text += if labels.is_some() { ",move\n" } else { "\n" };
            row += 1;
        }
        let start = row;
        for values in sensor.hold(*up, 500, 50 + i as u64) {
            let values: Vec<String> = values.iter().map(|v| sensor.text(*v)).collect();
            text += &format!("{},{}", 10 * row, values.join(","));
            match labels {
                Some(labels) => text += &format!(",{}\n", labels[i]),
                None => text += "\n",
            }
            row += 1;
        }
        holds.push(start..row);
    }
    (text, holds)
}

const LABELS: [&str; 6] = ["x_p", "x_a", "y_p", "y_a", "z_p", "z_a"];

#[test]
fn one_continuous_recording() {
    let sensor = Sensor::default();
    let (text, holds) = one_file(&sensor, None);
    let session = [named("session.csv", &text)];
    fits(&session, &given_gravity(), &sensor);
    let result = calibrated(&session, &given_gravity());
    for (placement, hold) in result.segmentation.poses.iter().zip(holds) {
        let rows = &placement.rows[0];
        assert!(
            rows.start >= hold.start && rows.end <= hold.end,
            "{rows:?} in {hold:?}: no motion in a mean"
        );
        assert!(rows.len() > 400, "{rows:?} of {hold:?}");
    }
}

#[test]
fn one_file_with_a_label_column() {
    let sensor = Sensor::default();
    let (text, _) = one_file(&sensor, Some(LABELS));
    let session = [named("session.csv", &text)];
    fits(&session, &given_gravity(), &sensor);
    let file = calibrated(&session, &given_gravity()).file;
    assert!(file.accelerometer.poses.iter().all(|p| p.rows == 500));
    let left_out = file.findings.iter().find(|f| f.kind == "labels-left-out");
    assert_eq!(left_out.unwrap().count, 1200);
}

#[test]
fn the_first_rows_only_as_the_report_takes_them() {
    let sensor = Sensor::default();
    let session = six_files(&sensor, 600);
    let options = CalibrateOptions {
        segment: SegmentOptions {
            rows: Some(100),
            ..SegmentOptions::default()
        },
        ..given_gravity()
    };
    let file = calibrated(&session, &options).file;
    for (position, recording) in file.accelerometer.poses.iter().zip(&session) {
        assert_eq!(position.rows, 100);
        for i in 0..3 {
            close(position.raw[i], mean(&recording.accel[i][..100]), 1e-12);
        }
    }
}

#[test]
fn a_bump_in_a_hold_does_not_move_the_mean() {
    let sensor = Sensor::default();
    let mut session = six_files(&sensor, 731);
    for value in &mut session[0].accel[1][300..340] {
        *value += 4.0;
    }
    fits(&session, &given_gravity(), &sensor);
}

#[test]
fn a_file_named_after_a_face_is_one_placement_whatever_came_before() {
    let sensor = Sensor::default();
    let mut session = six_files(&sensor, 600);
    // Held on another side for 1.2 s, and put down twice on the one it is named after.
    let mut rows = Vec::new();
    let mut noise = Noise::new(3);
    rows.extend(sensor.hold(FACES[0].1, 120, 71));
    let mut shake = |rows: &mut Vec<[f64; 3]>| {
        rows.extend((0..150).map(|_| [(); 3].map(|()| 9.0 * noise.normal())));
    };
    shake(&mut rows);
    rows.extend(sensor.hold(FACES[5].1, 300, 72));
    shake(&mut rows);
    rows.extend(sensor.hold(FACES[5].1, 600, 73));
    let mut text = "t_ms,ax,ay,az\n".to_owned();
    for (i, row) in rows.iter().enumerate() {
        text += &format!("{},{:.4},{:.4},{:.4}\n", 10 * i, row[0], row[1], row[2]);
    }
    session[5] = named("z_axis_neg.csv", &text);
    fits(&session, &given_gravity(), &sensor);
    let file = calibrated(&session, &given_gravity()).file;
    assert_eq!(file.accelerometer.poses.len(), 6);
    let reported = file
        .findings
        .iter()
        .find(|f| f.kind == "motion-left-out")
        .unwrap();
    assert!(
        reported.message.contains("shorter static intervals"),
        "{}",
        reported.message
    );
}

#[test]
fn means_without_labels_are_placements_where_they_lie_far_apart() {
    let rows = [
        "-9.43,-0.27,0.92",
        "10.20,-0.04,-0.10",
        "0.46,-9.99,0.39",
        "0.29,9.73,0.49",
        "-0.05,-0.08,-9.54",
        "0.83,-0.18,10.42",
    ];
    let table = |rows: &[&str]| {
        [named(
            "means.csv",
            &format!("ax,ay,az\n{}\n", rows.join("\n")),
        )]
    };
    let labelled: Vec<String> = ["-x", "+x", "-y", "+y", "-z", "+z"]
        .iter()
        .zip(rows)
        .map(|(label, row)| format!("{label},{row}"))
        .collect();
    let labelled = [named(
        "means.csv",
        &format!("label,ax,ay,az\n{}\n", labelled.join("\n")),
    )];
    let result = calibrated(&table(&rows), &given_gravity());
    assert_eq!(result.segmentation.poses[3].label, "line 5");
    assert!(
        result
            .file
            .findings
            .iter()
            .any(|f| f.kind == "rows-as-poses")
    );
    let with_labels = calibrated(&labelled, &given_gravity());
    assert_eq!(
        result.file.accelerometer.bias,
        with_labels.file.accelerometer.bias
    );
    // Five directions are no calibration, and free fall is no mean.
    for rows in [&rows[..5], &[&rows[..5], &["0.1,0.1,0.1"]].concat()] {
        let error = calibrate(&table(rows), &given_gravity()).unwrap_err();
        assert_eq!(error.code(), "never-static");
        assert!(error.hint().unwrap().contains("table of means"), "{error}");
    }
}

/// A simulated session as one continuous recording: its rows as text, and what was
/// put in.
fn simulated() -> (Vec<String>, gravical::simulate::Truth) {
    let six = SixPositionOptions {
        hold_s: 5.0,
        continuous: true,
        ..SixPositionOptions::default()
    };
    let mut options = SimulateOptions::new(Scenario::SixPosition(six));
    options.seed = 11;
    options.gravity_mps2 = GRAVITY;
    let simulation = simulate(&options).unwrap();
    (rows_of(&simulation), simulation.truth)
}

/// The rows of a simulated session, t_ms,ax,ay,az,gx,gy,gz.
fn rows_of(simulation: &Simulation) -> Vec<String> {
    let file = &simulation.files[0];
    let rows = file.rows.iter().map(|row| {
        let r = &row.reading;
        let all = r.accel_mps2.iter().chain(&r.gyro_rad_s);
        let values: Vec<String> = all.map(|v| format!("{v:.5}")).collect();
        format!("{},{}", row.stamp_ms, values.join(","))
    });
    rows.collect()
}

#[test]
fn the_same_session_is_the_same_by_every_route() {
    let (rows, truth) = simulated();
    let file = |name: &str, rows: &[String]| {
        named(
            name,
            &format!("t_ms,ax,ay,az,gx,gy,gz\n{}\n", rows.join("\n")),
        )
    };
    let options = CalibrateOptions {
        gravity: gravical::gravity::Gravity::given(GRAVITY).unwrap(),
        ..CalibrateOptions::default()
    };
    let one = [file("session.csv", &rows)];
    let whole = calibrated(&one, &options);
    let spans: Vec<_> = whole
        .segmentation
        .poses
        .iter()
        .map(|p| p.rows[0].clone())
        .collect();
    let faces: Vec<String> = (whole.segmentation.poses.iter())
        .map(|p| p.face.unwrap().name())
        .collect();
    let turns = &whole.segmentation.turns;
    assert_eq!((spans.len() >= 9, turns.len()), (true, 3));

    // Every row called by its still or turn.
    let mut labels = vec!["hand".to_owned(); rows.len()];
    let mut sections = "label,start,end\n".to_owned();
    let turned = turns
        .iter()
        .map(|t| (format!("{}_rot", ["x", "y", "z"][t.axis]), &t.rows));
    let placed = faces.iter().cloned().zip(&spans);
    for (label, span) in placed.clone().chain(turned) {
        labels[span.clone()].fill(label.clone());
        sections += &format!("{label},{},{}\n", span.start, span.end);
    }
    let labelled: Vec<String> = rows
        .iter()
        .zip(&labels)
        .map(|(r, l)| format!("{r},{l}"))
        .collect();
    let labelled = format!("t_ms,ax,ay,az,gx,gy,gz,part\n{}\n", labelled.join("\n"));
    // The hand before and after belongs to the file of a placement, too.
    let alone = placed.enumerate().map(|(i, (face, span))| {
        let around = span.start.saturating_sub(150)..(span.end + 150).min(rows.len());
        file(&format!("{face}_{i}.csv"), &rows[around])
    });
    let middle = (spans[3].end + spans[4].start) / 2;
    let with_sections = CalibrateOptions {
        segment: SegmentOptions {
            sections: Some(parse_sections(sections.as_bytes()).unwrap()),
            ..SegmentOptions::default()
        },
        ..options.clone()
    };
    let routes = [
        ("labels", vec![named("labelled.csv", &labelled)], &options),
        ("sections", one.to_vec(), &with_sections),
        ("files", alone.collect(), &options),
        (
            "two",
            vec![
                file("a.csv", &rows[..middle]),
                file("b.csv", &rows[middle..]),
            ],
            &options,
        ),
    ];
    let parameters = |c: &gravical::calibrate::Calibrated| -> (Vec<f64>, Vec<f64>) {
        let a = &c.file.accelerometer;
        let model = (0..9).map(|i| a.scale[i / 3] * a.orientation[i / 3][i % 3]);
        let covariance = &a.covariance.as_ref().unwrap().values;
        let sd = (0..12).map(|i| covariance[i][i].sqrt());
        (model.chain(a.bias).collect(), sd.collect())
    };
    let (expected, sd) = parameters(&whole);
    let gyroscope = whole.file.gyroscope.as_ref().unwrap();
    assert_eq!(gyroscope.input_unit.name(), "rad/s");
    for (route, session, options) in routes {
        let result = calibrated(&session, options);
        let (found, _) = parameters(&result);
        for i in 0..12 {
            assert!(
                (found[i] - expected[i]).abs() < sd[i],
                "{route}: parameter {i} is {} and not {} ± {}",
                found[i],
                expected[i],
                sd[i]
            );
        }
        let mut own: Vec<_> = (result.segmentation.poses.iter())
            .map(|p| p.face.unwrap().name())
            .collect();
        own.sort();
        own.dedup();
        assert_eq!(own.len(), 6, "{route}");
        let section = result.file.gyroscope.as_ref().unwrap();
        assert_eq!(section.input_unit, gyroscope.input_unit, "{route}");
        for i in 0..3 {
            // Without motions in them, files give the bias alone.
            close(section.bias[i], truth.gyroscope.bias_rad_s[i], 2e-3);
            if route != "files" {
                close(section.scale[i] / gyroscope.scale[i], 1.0, 5e-3);
            }
        }
        let judged = check(&whole.file, "cal.json", &session, &CheckOptions::default()).unwrap();
        assert_ne!(judged.verdict.judgement, Judgement::DoesNotFit, "{route}");
        assert_eq!(judged.gyroscope.unwrap().input_unit, gyroscope.input_unit);
        for recording in &session {
            let seen = inspect(recording, &AxisMap::default());
            assert!(
                seen.static_intervals.iter().all(|s| s.face.is_some()),
                "{route}"
            );
            assert_eq!(
                seen.gyroscope.unwrap().unit,
                gyroscope.input_unit,
                "{route}"
            );
        }
    }
}

#[test]
fn an_even_turn_is_no_still_however_fast_the_sampling() {
    // In the middle of a full turn about the vertical the rate hardly changes from one
    // block to the next, and gravity not at all.
    for rate_hz in [100.0, 500.0, 1000.0] {
        let mut options = SimulateOptions::new(Scenario::SixPosition(SixPositionOptions {
            continuous: true,
            hold_s: 3.0,
            ..SixPositionOptions::default()
        }));
        options.rate_hz = rate_hz;
        let simulation = simulate(&options).unwrap();
        let rows = rows_of(&simulation).join("\n");
        let session = [named(
            "session.csv",
            &format!("t_ms,ax,ay,az,gx,gy,gz\n{rows}\n"),
        )];
        let result = calibrated(&session, &given_gravity());
        let turns = &result.segmentation.turns;
        assert_eq!(turns.len(), 3, "{rate_hz} Hz: {turns:?}");
        let gyroscope = result.file.gyroscope.as_ref().unwrap();
        let truth = simulation.truth.gyroscope.bias_rad_s;
        for (found, truth) in gyroscope.bias.iter().zip(truth) {
            // 1 °/s; the reaction to gravity is not known from so few stills.
            assert!(
                (found - truth).abs() < 0.017,
                "{rate_hz} Hz: {found} {truth}"
            );
        }
    }
}

#[test]
fn a_hold_full_of_spikes_is_no_hold_lost() {
    let sensor = Sensor::default();
    let mut text = String::from("t_s,ax,ay,az\n");
    let mut row = 0;
    for (k, face) in gravical::poses::face::Face::all().into_iter().enumerate() {
        let lines = sensor.file(face.direction(), 600, k as u64);
        for (i, line) in lines.lines().skip(1).enumerate() {
            let values: Vec<f64> = line.split(',').map(|v| v.parse().unwrap()).collect();
            let mut u = [values[1], values[2], values[3]];
            if i >= 500 {
                // Taken up by hand.
                u = u.map(|v| v + 4.0 * (0.9 * i as f64 + v).sin());
            } else if k == 3 && (7 * i) % 10 == 3 {
                u[0] += 9.8;
            }
            text += &format!(
                "{:.2},{:.4},{:.4},{:.4}\n",
                0.01 * f64::from(row),
                u[0],
                u[1],
                u[2]
            );
            row += 1;
        }
    }
    let file = calibrated(&[named("spikes.csv", &text)], &given_gravity()).file;
    assert_eq!(file.accelerometer.poses.len(), 6);
    assert!(
        file.findings
            .iter()
            .any(|f| f.kind.name() == "spikes-left-out")
    );
}

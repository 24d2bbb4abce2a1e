//! Sessions of every shape: the same sensor, the same parameters.

use std::collections::BTreeSet;

use gravical::calibrate::{CalibrateOptions, calibrate};
use gravical::calibration_file::Grade;
use gravical::check::{CheckOptions, Judgement, check};
use gravical::finding::Finding;
use gravical::inspect::inspect;
use gravical::poses::SegmentOptions;
use gravical::poses::face::AxisMap;
use gravical::poses::sections::parse_sections;
use gravical::recording::source::Named;
use gravical::recording::{ReadOptions, Recording, read_bytes};
use gravical::session::{read_named_session, read_session};
use gravical::simulate::{Scenario, SimulateOptions, SixPositionOptions, simulate};

use crate::support::*;

fn named(name: &str, text: &str) -> Recording {
    read_bytes(text.as_bytes(), name, &ReadOptions::default()).unwrap()
}

#[test]
fn a_file_named_after_a_face_is_one_placement_whatever_came_before() {
    let sensor = Sensor::default();
    let mut session = six_files(&sensor, 600);
    // Held on another side for 1.2 s, and put down twice on the one it is named after.
    let mut noise = Noise::new(3);
    let mut rows = Vec::new();
    for (face, count, seed) in [(0, 120, 71), (5, 300, 72), (5, 600, 73)] {
        let shaken = (0..150).map(|_| [(); 3].map(|()| 9.0 * noise.normal()));
        rows.extend(shaken);
        rows.extend(sensor.hold(FACES[face].1, count, seed));
    }
    let mut text = "t_ms,ax,ay,az\n".to_owned();
    for (i, [x, y, z]) in rows.into_iter().skip(150).enumerate() {
        text += &format!("{},{x:.4},{y:.4},{z:.4}\n", 10 * i);
    }
    session[5] = named("z_axis_neg.csv", &text);
    let file = calibrated(&session, &given_gravity()).calibration;
    let a = &file.accelerometer;
    for i in 0..3 {
        close(a.bias[i], sensor.bias[i], 0.01);
        let norm = sensor.matrix[i].iter().map(|v| v * v).sum::<f64>().sqrt();
        close(a.scale()[i], norm, 0.001);
        for j in 0..3 {
            close(
                a.scale()[i] * a.orientation()[i][j],
                sensor.matrix[i][j],
                0.002,
            );
        }
    }
    assert_eq!(file.verdict().grade, Grade::NotVerifiable);
    assert_eq!(file.poses.len(), 6);
}

#[test]
fn means_without_labels_are_placements_where_they_lie_far_apart() {
    let labelled = "label,ax,ay,az\n-x,-9.43,-0.27,0.92\n+x,10.20,-0.04,-0.10\n-y,0.46,-9.99,0.39\n\
                    +y,0.29,9.73,0.49\n-z,-0.05,-0.08,-9.54\n+z,0.83,-0.18,10.42\n";
    let rows = labelled.lines().map(|l| l.split_once(',').unwrap().1);
    let rows: Vec<String> = rows.map(|row| format!("{row}\n")).collect();
    let fitted = |text: &str| calibrated(&[named("means.csv", text)], &given_gravity());
    let result = fitted(&rows.concat());
    assert_eq!(result.segmentation.poses[3].label, "line 5");
    let mut kinds = result.calibration.findings.iter().map(|f| &*f.kind);
    assert!(kinds.any(|kind| kind == "rows-as-poses"));
    let bias = fitted(labelled).calibration.accelerometer.bias;
    assert_eq!(result.calibration.accelerometer.bias, bias);
    // Five directions are no calibration, and free fall is no mean.
    for more in ["", "0.1,0.1,0.1\n"] {
        let table = named("means.csv", &(rows[..6].concat() + more));
        let error = calibrate(&[table], &given_gravity()).unwrap_err();
        assert_eq!(error.code(), "never-static");
        assert!(error.hint().unwrap().contains("table of means"), "{error}");
    }
}

/// A simulated session as one continuous recording: its rows as text, t_ms,ax,ay,az,gx,gy,gz, and what was
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
    let file = &simulation.files[0];
    let rows = file.rows.iter().map(|row| {
        let r = &row.reading;
        let channels = r.accel_mps2.iter().chain(&r.gyro_rad_s);
        let values: Vec<String> = channels.map(|v| format!("{v:.5}")).collect();
        format!("{},{}", row.stamp_ms, values.join(","))
    });
    (rows.collect(), simulation.truth)
}

#[test]
fn the_same_session_is_the_same_by_every_route() {
    let (rows, truth) = simulated();
    let file = |name: &str, rows: &[String]| {
        let rows = rows.join("\n");
        named(name, &format!("t_ms,ax,ay,az,gx,gy,gz\n{rows}\n"))
    };
    let options = with_gravity(GRAVITY);
    let one = [file("session.csv", &rows)];
    let whole = calibrated(&one, &options);
    let poses = &whole.segmentation.poses;
    let spans: Vec<_> = poses.iter().map(|p| p.rows.clone()).collect();
    let faces: Vec<String> = poses.iter().map(|p| p.face.unwrap().name()).collect();
    assert!(spans.len() >= 9);

    // Every row called by its still.
    let mut labels = vec!["hand".to_owned(); rows.len()];
    let mut sections = "label,start,end\n".to_owned();
    let placed = faces.iter().cloned().zip(&spans);
    for (label, span) in placed.clone() {
        labels[span.clone()].fill(label.clone());
        sections += &format!("{label},{},{}\n", span.start, span.end);
    }
    let labelled = rows.iter().zip(&labels).map(|(r, l)| format!("{r},{l}\n"));
    let labelled = "t_ms,ax,ay,az,gx,gy,gz,part\n".to_owned() + &labelled.collect::<String>();
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
    let two = [("a.csv", &rows[..middle]), ("b.csv", &rows[middle..])];
    let two = two.map(|(name, rows)| file(name, rows));
    let routes = [
        ("labels", vec![named("labelled.csv", &labelled)], &options),
        ("sections", one.to_vec(), &with_sections),
        ("files", alone.collect(), &options),
        ("two", two.to_vec(), &options),
    ];
    let parameters = |c: &gravical::calibrate::Calibrated| -> (Vec<f64>, Vec<f64>) {
        let a = &c.calibration.accelerometer;
        let model = (0..9).map(|i| a.scale()[i / 3] * a.orientation()[i / 3][i % 3]);
        let covariance = &a.covariance.as_ref().unwrap().values;
        let sd = (0..12).map(|i| covariance[i][i].sqrt());
        (model.chain(a.bias).collect(), sd.collect())
    };
    let (expected, sd) = parameters(&whole);
    let gyroscope = whole.calibration.gyroscope.as_ref().unwrap();
    assert_eq!(gyroscope.input_unit.name(), "rad/s");
    for (route, session, options) in routes {
        let result = calibrated(&session, options);
        let (found, _) = parameters(&result);
        let mut kinds = result.calibration.findings.iter().map(|f| &*f.kind);
        assert!(route != "labels" || kinds.any(|k| k == "labels-left-out"));
        for ((found, expected), sd) in found.iter().zip(&expected).zip(&sd) {
            let off = (found - expected).abs();
            assert!(off < *sd, "{route}: {found} and not {expected} ± {sd}");
        }
        let own = result.segmentation.poses.iter();
        let own: BTreeSet<String> = own.map(|p| p.face.unwrap().name()).collect();
        assert_eq!(own.len(), 6, "{route}");
        let section = result.calibration.gyroscope.as_ref().unwrap();
        assert_eq!(section.input_unit, gyroscope.input_unit, "{route}");
        for i in 0..3 {
            // Without motions in them, files give the bias alone.
            close(section.bias[i], truth.gyroscope.bias_rad_s[i], 2e-3);
            if route != "files" {
                close(section.scale()[i] / gyroscope.scale()[i], 1.0, 5e-3);
            }
        }
        let judged = check(
            &whole.calibration,
            "cal.json",
            &session,
            &CheckOptions::default(),
        )
        .unwrap();
        assert_ne!(judged.verdict.judgement, Judgement::DoesNotFit, "{route}");
        for recording in &session {
            let seen = inspect(recording, &AxisMap::default());
            let mut intervals = seen.static_intervals.iter();
            assert!(intervals.all(|s| s.face.is_some()), "{route}");
            let unit = seen.gyroscope.unwrap().unit;
            assert_eq!(unit, gyroscope.input_unit, "{route}");
        }
    }
}

/// A folder in memory, as a page gets it: recordings, a licence, a result and a gyroscope of its own.
#[test]
fn a_folder_in_memory_is_the_folder_on_the_disk() {
    let row = |t: usize, v: [f64; 3]| format!("{},{:.4},{:.4},{:.4}\n", 10 * t, v[0], v[1], v[2]);
    let mut noise = Noise::new(7);
    let mut table = |names: &str, mean: [f64; 3]| {
        let rows = (0..400).map(|t| row(t, mean.map(|m| m + 0.02 * noise.normal())));
        format!("{names}\n{}", rows.collect::<String>())
    };
    let licence = "Permission is granted to whoever reads this text.\n".repeat(40);
    let files = [
        ("Gyroscope.csv", table("t_ms,gx,gy,gz", [0.0; 3])),
        ("LICENSE.txt", licence),
        (
            "applied.csv",
            table("t_ms,ax_mps2,ay_mps2,az_mps2", [0.0, 0.0, 9.8]),
        ),
        ("walk.csv", table("t_ms,ax,ay,az", [0.0, 0.0, 9.8])),
    ];
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in &files {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let paths = [folder.path().to_path_buf()];
    let (on_disk, said) = read_session(&paths, None, &ReadOptions::default()).unwrap();
    let named = files.iter();
    let named = named.map(|(name, text)| Named::Bytes(name.as_ref(), text.as_bytes()));
    let named: Vec<Named<'_>> = named.collect();
    let (in_memory, told) =
        read_named_session(&named, true, None, &ReadOptions::default()).unwrap();
    let kinds = |f: &[Finding]| f.iter().map(|f| f.kind.clone()).collect::<Vec<_>>();
    assert_eq!(
        kinds(&said),
        ["no-recording", "already-calibrated", "gyro-joined"]
    );
    assert_eq!(kinds(&told), kinds(&said));
    assert_eq!(in_memory.len(), 1);
    assert_eq!(
        (in_memory[0].rows(), &in_memory[0].accel),
        (400, &on_disk[0].accel)
    );
    assert_eq!(in_memory[0].gyro, on_disk[0].gyro);
    assert!(in_memory[0].gyro.is_some());
}

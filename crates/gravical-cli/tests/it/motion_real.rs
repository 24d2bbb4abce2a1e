//! `gravical motion` on real recordings.

use std::io::Read as _;

use crate::motion::motion;
use crate::support::*;

#[test]
fn a_walked_room_closes_beside_the_camera() {
    let Some(data) = data() else { return };
    let file = data.join("broad-translation/14_undisturbed_slow_translation_with_breaks_B.csv.gz");
    let folder = tempfile::tempdir().unwrap();
    let mut text = String::new();
    let packed = std::fs::File::open(&file).unwrap();
    flate2::read::GzDecoder::new(packed)
        .read_to_string(&mut text)
        .unwrap();
    // Rows with a position of the camera, which has gaps.
    let rows: Vec<Vec<f64>> = text
        .lines()
        .skip(1)
        .map(|l| {
            l.split(',')
                .map(|c| c.parse().unwrap_or(f64::NAN))
                .collect()
        })
        .collect();
    let seen = |t_s: f64| {
        let known = rows
            .iter()
            .filter(|row| row[7..10].iter().all(|v| v.is_finite()));
        let near = known.min_by(|a, b| (a[0] - t_s).abs().total_cmp(&(b[0] - t_s).abs()));
        near.unwrap()[7..10].to_vec()
    };
    let file = file.display();
    let result = motion(folder.path(), &format!("{file} --gyro-unit rad/s"), 4);
    assert_eq!(list(&result["moves"]).count(), 4);
    // The camera is level, and its frame is the sensor's at the start. Half a minute with turns by 700° in the first
    // move, of a sensor that nobody calibrated.
    for (m, most) in list(&result["moves"]).zip([1.5, 0.7, 0.4, 0.7]) {
        let [from, to] = ["start_s", "end_s"].map(|key| seen(number(&m[key])));
        let (moved, sigma) = (numbers(&m["displacement_m"]), numbers(&m["sigma_m"]));
        let error: Vec<f64> = (0..3).map(|k| moved[k] - (to[k] - from[k])).collect();
        let size = error.iter().map(|e| e * e).sum::<f64>().sqrt();
        assert!(size < most, "{m}: {error:?}");
        assert!(
            (0..3).all(|k| error[k].abs() < 2.0 * sigma[k]),
            "{m}: {error:?}"
        );
    }
}

#[test]
fn a_lift_goes_up_a_skyscraper() {
    let Some(data) = data() else { return };
    let folder = tempfile::tempdir().unwrap();
    let file = data.join("pabrod-elevator/skyscrapper_up.csv");
    let result = motion(folder.path(), &file.display().to_string(), 4);
    let rides = list(&result["moves"]).filter(|m| m["unusable"].is_null());
    let ride = rides.max_by_key(|m| (1e3 * number(&m["path_m"])) as i64);
    let ride = ride.unwrap();
    // Its owner has 74.3 m and about 4.0 m/s, from other rests; a bias or a scale
    // explains gravity at rest, and the band covers both.
    close(number(&ride["displacement_m"][2]), 74.3, 1.0);
    close(number(&ride["peak_speed_mps"]), 4.0, 0.12);
    let sigma = number(&ride["sigma_m"][2]);
    assert!((1.0..6.0).contains(&sigma), "{sigma}");
    let error = number(&ride["displacement_m"][2]) - 74.3;
    assert!(error.abs() < 2.0 * sigma, "{error} ± {sigma}");
    for kind in ["no-gyro", "gravity-off"] {
        finding(&result, kind);
    }
}

#[test]
#[ignore = "slow: all recordings"]
fn every_recording_ends_in_a_table_or_in_a_reason() {
    let Some(data) = data() else { return };
    let folder = tempfile::tempdir().unwrap();
    let mut tables = 0;
    for path in recordings(&data) {
        let name = path.display();
        let args = format!("motion {name} --rate 100 -o out.csv --force");
        let run = run_in(folder.path(), words(&args));
        assert!([0, 3, 4].contains(&run.code), "{name}: {}", run.err);
        if run.code == 3 {
            assert!(run.err.contains("try: "), "{name}: {}", run.err);
            continue;
        }
        // The first line names the files, whose paths may be long.
        let (_, reported) = run.err.split_once('\n').unwrap();
        narrow(reported);
        tables += 1;
        let table = read(folder.path(), "out.csv");
        let rows = table.lines().map(|line| line.split(',').collect());
        let rows: Vec<Vec<&str>> = rows.collect();
        assert!(rows.iter().all(|row| row.len() == rows[0].len()), "{name}");
        let times = rows[1..].iter().map(|row| row[0].parse::<f64>().unwrap());
        assert!(times.is_sorted(), "{name}");
        assert!(!table.contains("NaN") && !table.contains("inf"), "{name}");
    }
    assert!(tables >= 15, "{tables}");
}

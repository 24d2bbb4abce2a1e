//! `gravical convert`, and what every command makes of a `.cwa` file.

use crate::support::*;

/// A quarter of a second on the desk, and a row of the shelf behind a break.
fn csv() -> String {
    let labels = ["desk", "\"a \"\"b\"\", c\"", "desk"];
    let row = |i: usize| {
        let label = labels.get(i).unwrap_or(&"desk");
        format!(
            "2024-03-01 08:00:00,{i:02};0,0{}0;-0,25;1,0;3,3;25,5;{label}\n",
            i % 3 + 1
        )
    };
    let rows: String = (0..25).map(row).collect();
    format!(
        "Timestamp;aX (g);aY (g);aZ (g);battery;Temp (C);label\n{rows}\n\n\
         2024-03-01 08:00:09,00;0,030;-0,25;1,0;3,3;25,75;shelf\n"
    )
}

#[test]
fn a_table_in_si_or_in_g_with_breaks_and_labels() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    write(at, "in.csv", &csv());
    let run = ends(at, "convert in.csv -o - --quiet", 0);
    let begin = "time_s,ax_m_s2,ay_m_s2,az_m_s2,temperature_c,label\n\
        0.000000,0.0980665,-2.4516625,9.80665,25.5,desk\n\
        0.010000,0.196133,-2.4516625,9.80665,25.5,\"a \"\"b\"\", c\"\n\
        0.020000,0.2941995,-2.4516625,9.80665,25.5,desk\n";
    let end = "0.240000,0.0980665,-2.4516625,9.80665,25.5,desk\n\
        \n\
        9.000000,0.2941995,-2.4516625,9.80665,25.75,shelf\n";
    assert!(run.out.starts_with(begin), "{}", run.out);
    assert!(run.out.ends_with(end), "{}", run.out);
    // Packed, it reads as what it is.
    let summary = json(at, "convert in.csv -o out.csv.gz", 0);
    assert_eq!(summary["start_unix_s"], 1_709_280_000.0);
    let bytes = std::fs::read(at.join("out.csv.gz")).unwrap();
    assert_eq!(bytes[..2], [0x1f, 0x8b]);
    let read = ends(at, "convert out.csv.gz --quiet", 0);
    let (_, shelf) = end.split_once("\n\n").unwrap();
    assert!(read.out.ends_with(shelf), "{}", read.out);

    let run = ends(at, "convert in.csv --output-unit g --absolute-time", 0);
    let second = run.out.lines().nth(1).unwrap();
    // `date -u -d '2024-03-01 08:00' +%s`
    assert_eq!(second, "1709280000.000000,0.01,-0.25,1,25.5,desk");
    let rows = (0..100).map(|i| format!("{i},7,8,{}\n", 40 + i % 2));
    let text = format!("t_ms,ax,ay,az\n{}", rows.collect::<String>());
    write(at, "counts.csv", &text);
    for (options, code) in [("counts", "unit-unknown"), ("g --absolute-time", "no-date")] {
        let line = format!("convert counts.csv --accel-unit {options} -o out.csv --json");
        assert_eq!(run_in(at, words(&line)).json()["code"], code, "{line}");
        assert!(!at.join("out.csv").exists());
    }
}

#[test]
fn every_command_reads_a_cwa_file() {
    let Some(data) = data() else { return };
    let folder = tempfile::tempdir().unwrap();
    let path = data.join("skdh-axivity/ax6_sample.cwa");
    let cwa = path.to_str().unwrap();
    // Two minutes of wear cover no directions: that is said, not fitted.
    json(folder.path(), &format!("calibrate {cwa} -o none.json"), 3);
    let cal = r#"{"acc_unit": "m/s^2", "gyr_unit": "deg/s", "from_acc_unit": "g", "from_gyr_unit": "deg/s",
        "cal_type": "Ferraris", "K_a": [[0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]], "b_a": [0, 0, 0.02],
        "R_a": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "K_g": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "b_g": [0, 0, 0],
        "R_g": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "K_ga": [[0, 0, 0], [0, 0, 0], [0, 0, 0]]}"#;
    write(folder.path(), "cal.json", cal);
    let run = ends(folder.path(), &format!("apply cal.json {cwa} --quiet"), 0);
    let mut lines = run.out.lines();
    let header = "time_s,ax_mps2,ay_mps2,az_mps2,gx_deg_s,gy_deg_s,gz_deg_s,temperature_c";
    assert_eq!(lines.next(), Some(header));
    let cells = lines.next().unwrap().split(',');
    let first: Vec<f64> = cells.map(|c| c.parse().unwrap()).collect();
    // This calibration leaves the gyroscope alone: its text is copied.
    assert_eq!(first[4], -66.223_144_531_25);
    // −0.518555 g by the reference, divided by 0.1 g per m/s².
    close(first[1], -5.185_55, 1e-5);
    close(first[0], 1_572_339_786.3, 0.02);
    assert_eq!(lines.count() + 1, 259 * 40);
    for (verb, rest) in [
        ("denoise", "--filter savgol:5,2 -q"),
        ("motion", "-o m.csv"),
    ] {
        let line = format!("{verb} {cwa} {rest}");
        let run = run_in(folder.path(), words(&line));
        assert!([0, 4].contains(&run.code), "{line}: {}", run.err);
    }
}

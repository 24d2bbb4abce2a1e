//! Samples that are not even, or not there.

use super::*;

/// 100 Hz, gravity and a little of everything.
fn samples(count: u32) -> Vec<String> {
    let mut noise = Noise::new(4);
    let row = |i: u32| {
        let [x, y, z] = [0.0, 0.0, 9.81].map(|v| v + 0.03 * noise.normal());
        format!("{},{x:.4},{y:.4},{z:.4}", 10 * i)
    };
    (0..count).map(row).collect()
}

fn write_lines(folder: &Path, name: &str, lines: &[String]) {
    let text = format!("t_ms,ax,ay,az\n{}\n", lines.join("\n"));
    write(folder, name, &text);
}

#[test]
fn gaps_breaks_and_what_is_too_short() {
    let folder = tempfile::tempdir().unwrap();
    // A step from one level to another across the gap, as after a pause.
    let mut text = "t_ms,ax,ay,az\n".to_owned();
    for i in 0..300 {
        let (pause, level) = if i < 150 { (0, 0.0) } else { (300, 5.0) };
        text += &format!("{},{level},0.1,9.81\n", 10 * i + pause);
    }
    text += "3700,1,1,9.81\n3710,1,1,9.81\n\n\n3720,2,2,9.81\n";
    write(folder.path(), "gap.csv", &text);
    for filter in ["savgol:11,2", "butter:4,2Hz", "butter1:2,2Hz", "mean:9"] {
        let reported = summary(folder.path(), &format!("gap.csv --filter {filter}"));
        assert_eq!(reported["segments"], 4, "{filter}");
        assert_eq!(finding(&reported, "parted")["count"], 2, "{filter}");
        let rows = written(folder.path());
        let samples = rows.iter().skip(1).filter(|r| r.len() == 4);
        for (i, row) in samples.take(300).enumerate() {
            let want = if i < 150 { 0.0 } else { 5.0 };
            // Nothing of one side gets to the other.
            close(row[1].parse().unwrap(), want, 1e-6);
        }
        if filter != "butter1:2,2Hz" {
            assert_eq!(finding(&reported, "not-filtered")["count"], 9, "{filter}");
        }
        // Blank rows are still a break.
        assert_eq!(rows.iter().filter(|r| r.join("").is_empty()).count(), 1);
    }
}

#[test]
fn stamps_that_run_backwards_or_are_missing() {
    let folder = tempfile::tempdir().unwrap();
    let mut lines = samples(400);
    lines[200] = lines[200].replacen("2000,", "1900,", 1);
    lines[300] = lines[300].replacen("3000,", ",", 1);
    write_lines(folder.path(), "back.csv", &lines);
    let line = "back.csv --filter savgol:5,2 --filter butter:2,5Hz";
    let reported = summary(folder.path(), line);
    finding(&reported, "bad-stamps");
    finding(&reported, "parted");
    assert_eq!(finding(&reported, "absent-time")["count"], 1);
    assert_eq!(written(folder.path()).len(), 401);
}

#[test]
fn empty_cells_stay_empty_and_spoil_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let mut lines = samples(400);
    lines[100] = "1000,,0.1,9.8".to_owned();
    lines[250] = "2500,0.1,NaN,".to_owned();
    write_lines(folder.path(), "holes.csv", &lines);
    for filter in [
        "savgol:5,2",
        "butter:4,5Hz",
        "highpass1:2,0.5Hz",
        "hampel:7,3",
        "mean:5",
    ] {
        let reported = summary(folder.path(), &format!("holes.csv --filter {filter}"));
        assert_eq!(finding(&reported, "empty-cells")["count"], 2, "{filter}");
        let rows = written(folder.path());
        let empty: Vec<(usize, usize)> = (1..rows.len())
            .flat_map(|r| (1..4).map(move |c| (r, c)))
            .filter(|(r, c)| rows[*r][*c].is_empty())
            .collect();
        assert_eq!(empty, [(101, 1), (251, 2), (251, 3)], "{filter}");
    }
}

#[test]
fn lost_rows_are_bridged_and_uneven_stamps_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    // A slope in time, which interpolation keeps, sampled anyhow, and one with lost rows.
    let (mut anyhow, mut lost) = ("t,ax,ay,az\n".to_owned(), "t,ax,ay,az\n".to_owned());
    let value = |t: f64| 1.0 + 2.0 * t;
    for i in 0..300 {
        let t = 0.01 * f64::from(i) + 0.0037 * f64::from(i * 7 % 3 - 1);
        anyhow += &format!("{t:.6},{:.9},0.5,9.81\n", value(t));
        let t = 0.01 * f64::from(i);
        if i % 37 != 5 {
            lost += &format!("{t:.6},{:.9},0.5,9.81\n", value(t));
        }
    }
    write(folder.path(), "anyhow.csv", &anyhow);
    write(folder.path(), "lost.csv", &lost);
    for filter in ["savgol:7,2", "butter:2,5Hz"] {
        let line = format!("denoise anyhow.csv -o new.csv --filter {filter}");
        fails(folder.path(), &line, 3, "uneven-stamps");
    }
    for line in [
        "anyhow.csv --filter hampel:7,3",
        "anyhow.csv --filter savgol:7,2 --columns t=- --rate 100",
        "lost.csv --filter savgol:7,2",
    ] {
        assert_eq!(summary(folder.path(), line)["segments"], 1, "{line}");
    }
    let rows = written(folder.path());
    for row in &rows[1..] {
        close(
            row[1].parse().unwrap(),
            value(row[0].parse().unwrap()),
            3e-6,
        );
    }
}

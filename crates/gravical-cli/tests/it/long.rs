//! Rows after those by which a long recording is judged.

use std::path::Path;

use crate::support::*;

/// Rows by which a recording is judged.
const JUDGED: usize = 262_144;

/// A sensor at rest at 100 Hz; `write_row` adds a row by its number, stamp in ms and values.
fn write_rest(path: &Path, rows: usize, write_row: impl Fn(&mut String, usize, usize, &str)) {
    let mut text = "t_ms,ax,ay,az\n".to_owned();
    for row in 0..rows {
        let noise = |k: usize| ((row + k) * 7919 % 101) as f64 / 1000.0 - 0.05;
        let values = format!("{:.3},{:.3},{:.3}", noise(0), noise(40), 9.81 + noise(80));
        write_row(&mut text, row, 10 * row, &values);
    }
    std::fs::write(path, text).unwrap();
}

/// Numbers of the rows after blank lines.
fn breaks(path: &Path) -> Vec<usize> {
    let text = std::fs::read_to_string(path).unwrap();
    let blanks = text.lines().enumerate().filter(|(_, line)| line.is_empty());
    blanks
        .enumerate()
        .map(|(before, (at, _))| at - 1 - before)
        .collect()
}

#[test]
fn a_long_recording_breaks_in_its_later_rows_as_in_its_first() {
    let folder = tempfile::tempdir().unwrap();
    let rest = folder.path().join("rest.csv");
    let (blank, two_blanks, reset, gap) = (JUDGED + 100, JUDGED + 200, JUDGED + 300, JUDGED + 400);
    write_rest(&rest, JUDGED + 500, |text, row, ms, values| {
        // A single blank line is no break while the clock goes on.
        text.push_str(if row == blank { "\n" } else { "" });
        text.push_str(if row == two_blanks { "\n\n" } else { "" });
        let ms = if row >= reset { ms - 10 * reset } else { ms };
        let ms = if row >= gap { ms + 1000 } else { ms };
        *text += &format!("{ms},{values}\n");
    });
    let run = run_in(folder.path(), words("convert rest.csv -o si.csv --json"));
    assert_eq!(run.code, 0, "{}{}", run.out, run.err);
    assert_eq!(breaks(&folder.path().join("si.csv")), [two_blanks, reset]);
    let said = run.json()["findings"].to_string();
    assert!(
        said.contains("1 gap of more than four samples, the longest 1.010 s"),
        "{said}"
    );
    let run = run_in(
        folder.path(),
        words("denoise rest.csv --filter mean:5 -o smooth.csv"),
    );
    assert_eq!(run.code, 0, "{}{}", run.out, run.err);
    assert_eq!(
        breaks(&folder.path().join("smooth.csv")),
        [two_blanks, reset]
    );
}

#[test]
fn what_inspect_reads_denoise_filters() {
    let folder = tempfile::tempdir().unwrap();
    // Of two sensors in turn the first has no more rows.
    write_rest(
        &folder.path().join("two.csv"),
        JUDGED / 2 + 300,
        |text, row, ms, values| {
            if row < JUDGED / 2 {
                *text += &format!("{ms},{values},0\n");
            }
            *text += &format!("{ms},{values},1\n");
        },
    );
    let path = folder.path().join("two.csv");
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, text.replacen("az\n", "az,sensor\n", 1)).unwrap();
    let run = run_in(folder.path(), words("convert two.csv -o si.csv --json"));
    assert_eq!((run.code, run.error_code().as_str()), (4, "sensor-ended"));
    let run = run_in(folder.path(), words("inspect two.csv"));
    assert_eq!(run.code, 0, "{}{}", run.out, run.err);
    let run = run_in(
        folder.path(),
        words("denoise two.csv --filter mean:5 -o smooth.csv"),
    );
    assert_eq!(run.code, 0, "{}{}", run.out, run.err);
}

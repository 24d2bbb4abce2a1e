//! A recording that grows is read as the whole one.

use gravical_recording::{Follow, ReadOptions, Recording, Sample};

use crate::support::{is_near, read, six_faces};

/// Pushes a text in pieces of so many bytes.
fn follow(text: &str, piece: usize, max_rows: usize) -> (Vec<Sample>, Recording) {
    let mut follow = Follow::new("any.csv", ReadOptions::default(), max_rows);
    let pieces = text.as_bytes().chunks(piece);
    let samples = pieces.flat_map(|piece| follow.push(piece).unwrap());
    let samples = samples.collect();
    (samples, follow.recording(u32::MAX).unwrap().unwrap())
}

/// The same rows in other writings.
fn texts() -> Vec<String> {
    let rows = six_faces(7);
    let write = |head: &str, row: &dyn Fn(usize, [f64; 3], [f64; 3]) -> String| {
        let rows = rows.iter().enumerate();
        let lines = rows.map(|(k, r)| row(k, r.accel_g, r.gyro_deg_s));
        head.to_owned() + &lines.collect::<String>()
    };
    vec![
        write(
            "t_ms,ax_g,ay_g,az_g,gx,gy,gz\n",
            &|k, [x, y, z], [u, v, w]| {
                format!("{},{x:.4},{y:.4},{z:.4},{u:.2},{v:.2},{w:.2}\n", 40 * k)
            },
        ),
        // Pauses and a reset of the board.
        write("t_ms;ax_g;ay_g;az_g\r\n", &|k, [x, y, z], _| {
            let pause = if k % 50 == 0 { "\r\n\r\n\r\n" } else { "" };
            let line = format!("{};{x:.4};{y:.4};{z:.4}\r\n", 40 * (k % 200));
            pause.to_owned() + &line
        }),
        write("", &|_, a, g| {
            let [x, y, z] = a.map(|v| (16384.0 * v) as i32);
            let [u, v, w] = g.map(|v| (131.0 * v) as i32);
            format!("a/g:\t{x}\t{y}\t{z}\t{u}\t{v}\t{w}\n")
        }),
        // A row in three lines.
        write("", &|_, [x, y, z], [u, v, w]| {
            format!(
                "Acceleration X: {x:.3}, Y: {y:.3}, Z: {z:.3} g\nRotation X: {u:.2}, Y: {v:.2}, Z: {w:.2} deg/s\n\n"
            )
        }),
        // Lines below headings.
        write("", &|k, [x, y, z], [u, v, w]| {
            let vector = |name, [x, y, z]: [f64; 3]| {
                format!("{name}:\n  x: {x:.4}\n  y: {y:.4}\n  z: {z:.4}\n")
            };
            let (rate, accel) = (vector("rate", [u, v, w]), vector("acc", [x, y, z]));
            format!("head:\n  ms: {}\n  id: imu\n{rate}{accel}---\n", 40 * k)
        }),
    ]
}

#[test]
fn a_recording_that_grows_is_read_as_the_whole_one() {
    for text in texts() {
        let whole = read(&text, "any.csv");
        for piece in [1, 17, 1000, usize::MAX] {
            let (samples, recording) = follow(&text, piece, usize::MAX);
            let [own, of_whole] = [&recording, &whole].map(|r| format!("{r:?}"));
            assert!(own == of_whole, "{text:.80}");
            assert_eq!(samples.len(), whole.rows(), "{text:.80}");
            for (row, sample) in samples.iter().enumerate() {
                assert_eq!(sample.line, whole.lines[row]);
                assert_eq!(sample.accel, whole.accel.each_ref().map(|c| c[row]));
                let is_break = whole.breaks.contains(&row);
                assert_eq!(sample.is_break, is_break, "{text:.80}: {row}");
                let time_s = whole.time_s.as_ref().map_or(f64::NAN, |t| t[row]);
                let is_same = sample.time_s.is_nan() && time_s.is_nan();
                assert!(is_same || is_near(sample.time_s, time_s, 1e-6), "{row}");
            }
        }
    }
}

/// Rows of three lines of which only the first comes once the gyroscope has died.
#[test]
fn rows_go_on_where_their_last_lines_stay_away() {
    let line = |k: usize| match k % 2 {
        1 if k > 600 => String::new(),
        1 => "Rotation X: 0.1, Y: 0.2, Z: 0.1 deg/s\n".to_owned(),
        _ => format!(
            "Acceleration X: 0.01{}, Y: 0.02, Z: 1.00{} g\n",
            k % 7,
            k % 5
        ),
    };
    let text: String = (0..1200).map(line).collect();
    let (samples, _) = follow(&text, 1000, usize::MAX);
    // The last one may still get its other line.
    assert_eq!(samples.len(), 599);
}

#[test]
fn the_last_rows_are_held() {
    let (samples, recording) = follow(&texts()[0], 100, 50);
    assert_eq!(samples.len(), 300);
    assert!((50..=100).contains(&recording.rows()));
    let last = samples.last().unwrap();
    assert_eq!(recording.lines.last(), Some(&last.line));
}

#[test]
fn what_is_no_recording_is_refused() {
    let new = || Follow::new("any.csv", ReadOptions::default(), usize::MAX);
    for bytes in [&b"hello, world\n"[..], &[0; 4096]] {
        let mut follow = new();
        let refused = (0..10_000).find_map(|_| follow.push(bytes).err());
        assert_eq!(refused.unwrap().code(), "no-rows");
    }
    // Columns change while it runs.
    let mut follow = new();
    follow.push(texts()[1].as_bytes()).unwrap();
    let other = b"t_ms;ax_g;ay_g;temperature_c\n1;0.1;0.2;25\n";
    assert_eq!(follow.push(other).unwrap_err().code(), "header-differs");
    // A line without an end is no row yet.
    let mut follow = new();
    follow.push(b"0.1,0.2,9.8").unwrap();
    assert!(follow.settle().is_err());
}

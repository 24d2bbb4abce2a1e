//! Boards with other sketches than the project's: any separator, numbers with names, no time. What
//! they send is read by the other commands.

use std::fs;

use crate::board::Board;
use crate::recording;

const ROWS: u32 = 120;

/// Noise of the sample `i`, up to 0.03.
fn noise(i: u32, channel: u32) -> f64 {
    f64::from((i * 7919 + channel * 131) % 61) * 5e-4
}

/// The sample `i` of a sensor at rest with z up, m/s².
fn at_rest(i: u32) -> [f64; 3] {
    [noise(i, 1), noise(i, 2), 9.81 + noise(i, 3)]
}

/// A sketch: what it prints before its rows, the options that it needs, the row of a sample, what the
/// file has to contain, its unit and whether there is a gyroscope, and rows that are rejected.
struct Sketch {
    before: &'static str,
    options: &'static str,
    row: fn(u32, [f64; 3], f64) -> String,
    contains: &'static str,
    has_gyro: bool,
    rejected: Option<usize>,
}

const PLAIN: Sketch = Sketch {
    before: "",
    options: "",
    row: |_, [x, y, z], _| format!("{x:.3},{y:.3},{z:.3}\r\n"),
    contains: "\nt_host_ms,ax,ay,az\n",
    has_gyro: false,
    rejected: None,
};

const SKETCHES: &[Sketch] = &[
    PLAIN,
    // Columns that the user names.
    Sketch {
        before: "Sensor 1\n",
        options: "--columns gx,gy,gz,ax,ay,az",
        row: |_, [x, y, z], rate| format!("0.1,0.2,{rate:.3},{x:.3},{y:.3},{z:.3},20.1,-3.2,44\n"),
        contains: "\nt_host_ms,gx,gy,gz,ax,ay,az,c7,c8,c9\n",
        has_gyro: true,
        ..PLAIN
    },
    Sketch {
        before: "Adafruit MPU6050 test!\n",
        row: |i, [x, y, z], _| match i {
            50 => "I2C error\n".to_owned(),
            _ => format!("Acceleration X: {x:.2}, Y: {y:.2}, Z: {z:.2} m/s^2\n"),
        },
        contains: "\n# rejected: I2C error\n",
        ..PLAIN
    },
    // A row in two lines, and rows of JSON.
    Sketch {
        row: |_, [x, y, z], rate| {
            let gyro = format!("Gyro X: 0.01, Y: 0.02, Z: {rate:.3} rad/s\n");
            format!("Accel X: {x:.2}, Y: {y:.2}, Z: {z:.2} m/s^2\n{gyro}")
        },
        contains: " -> Gyro X: ",
        has_gyro: true,
        ..PLAIN
    },
    // Stamps of the board: with torn lines and names, and below a header.
    Sketch {
        row: |i, [x, y, z], _| match i {
            20 => format!("ms:{} ax:{x:.3}{y:.3} az:{z:.3}\n", 10 * i),
            30 => "ax:1 ay:2 az:3\n".to_owned(),
            _ => format!("ms:{} ax:{x:.3} ay:{y:.3} az:{z:.3}\n", 10 * i),
        },
        contains: "\nms:0 ax:",
        rejected: Some(2),
        ..PLAIN
    },
];

#[test]
fn boards_with_other_sketches_are_recorded() {
    std::thread::scope(|scope| {
        for sketch in SKETCHES {
            scope.spawn(move || is_recorded(sketch));
        }
    });
}

/// The file has this header and unit, and times: those of arrival where the board has none.
fn is_recorded(sketch: &Sketch) {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    let mut log = board.log(&format!("-o x.csv --rows {ROWS} --json {}", sketch.options));
    log.wait_for("opened");
    // The first line may lack its beginning.
    board.say(&format!("\n{}", sketch.before));
    for i in 0.. {
        board.say(&(sketch.row)(i, at_rest(i), noise(i, 4)));
        std::thread::sleep(std::time::Duration::from_millis(10));
        // On a busy machine rows could arrive all at once.
        if i % 30 == 10 && i < ROWS {
            board.say("# a message\n");
            log.wait_for("board");
        }
        log.look();
        if log.has_seen("ended") {
            break;
        }
    }
    let (code, ended) = log.ended();
    let path = folder.path().join("x.csv");
    let text = fs::read_to_string(&path).unwrap_or_default();
    assert_eq!((code, &ended["rows"]), (0, &ROWS.into()), "{ended}\n{text}");
    let recording = recording(&path);
    assert!(text.contains(sketch.contains), "{text}");
    assert_eq!(recording.rows(), ROWS as usize, "{text}");
    assert_eq!(recording.units.accel.unit.name(), "m/s^2", "{text}");
    assert_eq!(recording.gyro.is_some(), sketch.has_gyro, "{text}");
    let rejected = text.matches("\n# rejected: ").count();
    assert_eq!(ended["rejected"], rejected, "{text}");
    assert_eq!(rejected, sketch.rejected.unwrap_or(rejected), "{text}");
    let time_s = recording.time_s.as_ref().unwrap();
    let last_s = time_s[time_s.len() - 1];
    assert!((1.0..20.0).contains(&last_s), "{last_s} s\n{text}");
}

//! A board with the firmware that stands in this repository.
#![allow(dead_code)] // each test file takes its part

use std::cell::RefCell;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::rc::Rc;
use std::sync::OnceLock;

use gravical::simulate::{InteractiveSensor, SimulateOptions};
use virtual_board::sensor::{FaultKind, Mpu6050, Reading};
use virtual_board::uno::Uno;

/// `GRAVICAL_FIRMWARE`, else built here where there is a compiler for it.
pub fn firmware() -> Option<&'static Path> {
    static BUILT: OnceLock<Option<PathBuf>> = OnceLock::new();
    BUILT
        .get_or_init(|| {
            if let Some(given) = std::env::var_os("GRAVICAL_FIRMWARE") {
                return Some(given.into());
            }
            // One folder a test binary: they run side by side.
            let folder = Path::new(env!("CARGO_TARGET_TMPDIR"))
                .join(concat!("firmware-", env!("CARGO_CRATE_NAME")));
            build_with(&folder, None).map(|(elf, _)| elf)
        })
        .as_deref()
}

/// The sketch, built in `folder`, with a header of a calibration or without; its program, and the
/// line about its size. None, with a word, without a compiler.
pub fn build_with(folder: &Path, header: Option<&Path>) -> Option<(PathBuf, String)> {
    if Command::new("avr-gcc").arg("--version").output().is_err() {
        eprintln!("skipped: no avr-gcc");
        return None;
    }
    let done = build(folder, header);
    let error = String::from_utf8_lossy(&done.stderr);
    assert!(done.status.success(), "{error}");
    let said = String::from_utf8(done.stdout).unwrap();
    Some((folder.join("mpu6050_logger.elf"), said))
}

/// What the compiler says of a header that it has to refuse.
pub fn build_refused(folder: &Path, header: &Path) -> String {
    let done = build(folder, Some(header));
    assert!(!done.status.success());
    String::from_utf8(done.stderr).unwrap()
}

fn build(folder: &Path, header: Option<&Path>) -> std::process::Output {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut build = Command::new(root.join("firmware/build"));
    build.arg(folder).args(header).output().unwrap()
}

/// A board, and what its sensor was fed, sample by sample.
pub struct Board {
    pub uno: Uno,
    pub fed: Rc<RefCell<Vec<Reading>>>,
}

/// A board whose sensor is at rest, with these faults from and to so many seconds; none, with a word,
/// where there is no firmware.
pub fn board(faults: &[(FaultKind, Range<f64>)]) -> Option<Board> {
    let Some(elf) = firmware() else {
        eprintln!("skipped: neither GRAVICAL_FIRMWARE nor avr-gcc");
        return None;
    };
    let mut board = on(elf, at_rest());
    board.uno.sensor().faults = faults.to_vec();
    Some(board)
}

pub type Hands = Rc<RefCell<InteractiveSensor>>;

/// A simulated sensor with z up, to be moved by hand, and what it reads at a time in s.
pub fn in_hand(seed: u64) -> (Hands, impl FnMut(f64) -> Reading + 'static) {
    let mut options = SimulateOptions::default();
    (options.seed, options.tilt_sd_deg) = (seed, 1.0);
    // The counts are made by the model of the registers.
    options.sensor.quantise = false;
    let hands = Rc::new(RefCell::new(InteractiveSensor::new(&options).unwrap()));
    let sensor = Rc::clone(&hands);
    let reading = move |time_s: f64| {
        let reading = sensor.borrow_mut().at(time_s);
        Reading {
            accel_mps2: reading.accel_mps2,
            gyro_deg_s: reading.gyro_rad_s.map(f64::to_degrees),
            temperature_c: reading.temperature_c,
        }
    };
    (hands, reading)
}

/// A sensor with z up, with its noise.
pub fn at_rest() -> impl FnMut(f64) -> Reading + 'static {
    in_hand(5).1
}

/// The program `elf` with a sensor that feels `reading`, a function of the time in s.
pub fn on(elf: &Path, mut reading: impl FnMut(f64) -> Reading + 'static) -> Board {
    let fed = Rc::new(RefCell::new(Vec::new()));
    let log = Rc::clone(&fed);
    let source = move |time_s: f64| {
        let reading = reading(time_s);
        log.borrow_mut().push(reading);
        reading
    };
    let uno = Uno::new(elf, Mpu6050::new(source)).unwrap();
    Board { uno, fed }
}

impl Board {
    /// What is sent in so many seconds.
    pub fn text(&mut self, seconds: f64) -> String {
        self.uno.run(seconds);
        String::from_utf8(self.uno.take_sent()).unwrap()
    }

    /// Commands, and what is sent in so many seconds.
    pub fn say(&mut self, commands: &str, seconds: f64) -> String {
        self.uno.send(commands.as_bytes());
        self.text(seconds)
    }
}

/// Rate in Hz of the stamps of rows, and their standard deviation in µs about a straight line.
pub fn line(rows: &[Vec<f64>]) -> (f64, f64) {
    let stamps_us: Vec<f64> = rows.iter().map(|row| row[0] * 1e3).collect();
    let n = stamps_us.len() as f64;
    let mean_x = (n - 1.0) / 2.0;
    let mean_y = stamps_us.iter().sum::<f64>() / n;
    let (mut xy, mut xx) = (0.0, 0.0);
    for (i, y) in stamps_us.iter().enumerate() {
        xy += (i as f64 - mean_x) * (y - mean_y);
        xx += (i as f64 - mean_x).powi(2);
    }
    let slope = xy / xx;
    let off = |(i, y): (usize, &f64)| y - mean_y - slope * (i as f64 - mean_x);
    let rest = stamps_us.iter().enumerate().map(|row| off(row).powi(2));
    (1e6 / slope, (rest.sum::<f64>() / (n - 2.0)).sqrt())
}

/// The rows of whole lines.
pub fn rows(text: &str) -> Vec<Vec<f64>> {
    let end = text.rfind('\n').unwrap_or(0);
    text[..end]
        .lines()
        .filter(|l| l.starts_with(|c: char| c.is_ascii_digit()))
        .map(|l| l.split(',').map(|f| f.parse().unwrap()).collect())
        .collect()
}

/// Its lines with `#`.
pub fn notices(text: &str) -> Vec<&str> {
    text.lines().filter(|l| l.starts_with('#')).collect()
}

//! Cycles of the functions of an exported header, on the emulated Uno.

use std::path::{Path, PathBuf};
use std::process::Command;

use virtual_board::sensor::Reading;

use super::board::on;
use super::{LSB_PER_G, calibration, folder, header};

/// Cycles of the processor between two samples at 100 Hz.
const SLOT: f64 = 160_000.0;

const SOURCE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/calibration/cycles.c");

/// The program beside the header, compiled as the Arduino IDE does; none without a compiler.
fn compiled(folder: &Path) -> Option<PathBuf> {
    let elf = folder.join("cycles.elf");
    let flags = "-std=gnu11 -Wall -Wextra -Werror -I. -mmcu=atmega328p -Os -ffunction-sections \
                 -fdata-sections -Wl,--gc-sections -o cycles.elf";
    let mut compiler = Command::new("avr-gcc");
    compiler.args(flags.split_whitespace().chain([SOURCE, "-lm"]));
    let Ok(done) = compiler.current_dir(folder).output() else {
        eprintln!("skipped: no avr-gcc");
        return None;
    };
    let error = String::from_utf8_lossy(&done.stderr);
    assert!(done.status.success(), "{error}");
    Some(elf)
}

#[test]
fn what_a_calibration_costs_on_the_board() {
    let folder = folder("cycles");
    let header = header(&calibration(), Some(LSB_PER_G));
    std::fs::write(folder.join("cal.h"), header).unwrap();
    let Some(elf) = compiled(&folder) else {
        return;
    };
    let mut board = on(&elf, |_| Reading::default());
    let mut text = String::new();
    // Two minutes of the board at the most.
    while !text.ends_with('\u{4}') && board.uno.time_s() < 120.0 {
        text += &board.text(0.5);
    }
    let text = text.strip_suffix('\u{4}').expect("it did not end");
    let line = |l: &str| -> Vec<u32> { l.split(' ').map(|w| w.parse().unwrap()).collect() };
    let lines: Vec<Vec<u32>> = text.lines().map(line).collect();
    let clock = lines[0][0];
    assert_eq!(lines[0], [clock; 2]);
    let limits = [("accelerometer", 2.0), ("gyroscope", 4.0)];
    for ((name, most), line) in limits.iter().zip(&lines[1..]) {
        let [least, longest] = [line[0] - clock, line[1] - clock];
        let share = 100.0 * f64::from(longest) / SLOT;
        eprintln!("{name}: {least} to {longest} cycles, {share:.2} % of a slot of 100 Hz");
        assert!(share < *most, "{name}: {share}");
    }
}

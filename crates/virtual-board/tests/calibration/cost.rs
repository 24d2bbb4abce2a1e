//! Cycles, flash and RAM of the functions of an exported header, on the emulated Uno.

use std::path::{Path, PathBuf};
use std::process::Command;

use virtual_board::sensor::Reading;

use super::board::on;
use super::{calibration, folder, header};

/// Cycles of the processor between two samples at 100 Hz.
const SLOT: f64 = 160_000.0;

const SOURCE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/calibration/cycles.c");

/// Compiles the program beside the header; none where there is no such compiler.
fn compiled(folder: &Path, compiler: &str, name: &str, more: &[&str]) -> Option<PathBuf> {
    let to = folder.join(name);
    let strict = ["-std=gnu11", "-Wall", "-Wextra", "-Werror", "-I."];
    let done = Command::new(compiler)
        .args(strict)
        .args(more)
        .args([Path::new("-o"), &to, Path::new(SOURCE)])
        .current_dir(folder)
        .output();
    let Ok(done) = done else {
        eprintln!("skipped: no {compiler}");
        return None;
    };
    assert!(
        done.status.success(),
        "{}",
        String::from_utf8_lossy(&done.stderr)
    );
    Some(to)
}

/// As the Arduino IDE compiles.
fn for_avr(folder: &Path, name: &str, more: &[&str]) -> Option<PathBuf> {
    let flags = [
        "-mmcu=atmega328p",
        "-Os",
        "-ffunction-sections",
        "-fdata-sections",
    ];
    let flags = [&flags[..], &["-Wl,--gc-sections", "-lm"], more].concat();
    compiled(folder, "avr-gcc", name, &flags)
}

/// Lines of the program, up to the byte that ends them.
fn run(elf: &Path) -> Vec<Vec<u32>> {
    let mut board = on(elf, |_| Reading::default());
    let mut bytes = Vec::new();
    // Two minutes of the board at the most.
    while bytes.last() != Some(&4) && board.uno.time_s() < 120.0 {
        bytes.extend(board.run(0.5).iter().map(|s| s.byte));
    }
    assert_eq!(bytes.pop(), Some(4), "it did not end");
    let text = String::from_utf8(bytes).unwrap();
    let line = |l: &str| l.split_whitespace().map(|w| w.parse().unwrap()).collect();
    text.lines().map(line).collect()
}

/// Bytes of flash and of RAM.
fn size(elf: &Path) -> [i64; 2] {
    let done = Command::new("avr-size")
        .arg("-A")
        .arg(elf)
        .output()
        .unwrap();
    let text = String::from_utf8(done.stdout).unwrap();
    let of = |section: &str| -> i64 {
        let words = text
            .lines()
            .map(|l| l.split_whitespace().collect::<Vec<_>>());
        let mut found = words.filter(|w| w.first() == Some(&section));
        found.next().map_or(0, |w| w[1].parse().unwrap())
    };
    [of(".text") + of(".data"), of(".data") + of(".bss")]
}

#[test]
fn what_a_calibration_costs_on_the_board() {
    let folder = folder("cycles");
    std::fs::write(folder.join("cal.h"), header(&calibration())).unwrap();
    let Some(elf) = for_avr(&folder, "cycles.elf", &[]) else {
        return;
    };
    let lines = run(&elf);
    let names = ["accelerometer", "gyroscope"];
    let clock = lines[0][0];
    assert_eq!(lines[0], [clock; 2]);
    let mut most = Vec::new();
    for (name, line) in names.iter().zip(&lines[1..]) {
        let [least, longest] = [line[0] - clock, line[1] - clock];
        let share = 100.0 * f64::from(longest) / SLOT;
        eprintln!("{name}: {least} to {longest} cycles, {share:.2} % of a slot of 100 Hz");
        most.push(share);
    }
    assert!(most[0] < 2.0 && most[1] < 4.0, "{most:?}");

    let sizes: Vec<[i64; 2]> = (0..3)
        .map(|which| {
            let name = format!("which{which}.elf");
            size(&for_avr(&folder, &name, &[&format!("-DWHICH={which}")]).unwrap())
        })
        .collect();
    for (name, [flash, ram]) in ["accelerometer", "both"].iter().zip(&sizes[1..]) {
        let [flash, ram] = [flash - sizes[0][0], ram - sizes[0][1]];
        eprintln!("{name}: {flash} bytes of flash, {ram} of RAM, with the library's arithmetic");
        assert!(flash < 3000, "{name}: {flash}");
        // Results and tables.
        assert!(ram <= 24 + 132, "{name}: {ram}");
    }
}

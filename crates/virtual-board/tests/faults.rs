//! What the firmware does when something goes wrong.
#![allow(clippy::unwrap_used)] // helpers of a test may panic as it does

mod board;

use board::{board, notices, rows};
use virtual_board::sensor::FaultKind::{Dip, Hang, Identity, NoAnswer, StuckBus};

/// How many lines begin so.
fn count(said: &[&str], start: &str) -> usize {
    said.iter().filter(|l| l.starts_with(start)).count()
}

/// Rows in each second of the text's own time.
fn seconds(text: &str) -> Vec<usize> {
    let mut counts = vec![0; 64];
    for row in rows(text) {
        counts[(row[0] / 1e3) as usize] += 1;
    }
    counts
}

#[test]
fn a_sensor_that_comes_and_goes() {
    let Some(mut board) = board(&[(NoAnswer, 2.0..4.0)]) else {
        return;
    };
    let text = board.text(7.0);
    let said = notices(&text);
    let missing = count(&said, "# no answer from a sensor");
    assert!((2..=3).contains(&missing), "once a second: {said:?}");
    assert_eq!(count(&said, "# gravical"), 2);
    let restart = "# overruns 0, i2c errors 1, restarts 1";
    assert!(said.contains(&restart), "{said:?}");
    let rows = seconds(&text);
    assert!(rows[1] >= 99 && rows[2] + rows[3] < 5, "{rows:?}");
    assert!(rows[4] > 60 && rows[5] >= 99, "{rows:?}");
}

#[test]
fn no_sensor_at_all_and_another_one() {
    let Some(mut board) = board(&[(NoAnswer, 0.0..2.2), (Identity(0x33), 2.2..5.0)]) else {
        return;
    };
    let text = board.text(7.0);
    let said = notices(&text);
    let other = "# who-am-i 0x33: not an MPU6050 (0x68), nor a relative that is known";
    for start in ["# no answer", other] {
        assert!((2..=4).contains(&count(&said, start)), "{said:?}");
    }
    assert_eq!(count(&said, "# gravical"), 1);
    let rows = seconds(&text);
    assert!(rows[..5] == [0; 5] && rows[6] >= 99, "{rows:?}");
}

/// The emulated chip is an MPU6050 in all but its name: only the conversion of the
/// temperature shows.
#[test]
fn relatives_of_the_mpu6050_are_used_with_a_note() {
    let celsius = |id: u8| -> Option<(f64, String)> {
        let text = board(&[(Identity(id), 0.0..90.0)])?.text(2.0);
        let row = text.lines().filter(|l| l.split(',').count() == 8).nth(5);
        let cell = row.unwrap().split(',').nth(4).unwrap().parse();
        Some((cell.unwrap(), text))
    };
    let Some((plain, _)) = celsius(0x68) else {
        return;
    };
    let of_clone = (plain - 36.53) * 340.0 / 333.87 + 21.0;
    for (id, note, name, wanted) in [
        (0x70, "0x70: MPU-6500 or a clone;", "MPU6500", of_clone),
        (
            0x98,
            "0x98: not an MPU6050 (0x68), used as one",
            "MPU6050",
            plain,
        ),
    ] {
        let (found, text) = celsius(id).unwrap();
        let note = format!("# who-am-i {note}");
        let settings = format!(", {name}, accelerometer");
        assert!(text.contains(&note) && text.contains(&settings), "{text}");
        assert!((found - wanted).abs() < 0.2, "{found} {wanted}");
    }
}

#[test]
fn a_stuck_bus_and_a_dip_of_the_supply() {
    let Some(mut board) = board(&[(StuckBus, 2.0..3.0), (Dip, 5.0..6.0)]) else {
        return;
    };
    let text = board.text(8.0);
    let said = notices(&text);
    let rows = seconds(&text);
    assert!(said.iter().any(|l| l.ends_with("restarts 2")), "{said:?}");
    assert_eq!(count(&said, "# gravical"), 3);
    assert!(rows[1] >= 99 && rows[2] < 5 && rows[4] >= 99, "{rows:?}");
    assert!(rows[5] > 60 && rows[6] >= 99, "{rows:?}");
    assert_eq!(board.uno.resets(), 0);
}

#[test]
fn the_watchdog_ends_a_hang() {
    let Some(mut board) = board(&[(Hang, 2.0..3.0)]) else {
        return;
    };
    let text = board.text(7.0);
    let said = text.matches("restarted by the watchdog").count();
    assert_eq!((board.uno.resets(), said), (1, 1), "{text}");
    let after = &text[text.find("# restarted").unwrap()..];
    assert!(rows(after).len() > 200, "{}", rows(after).len());
}

#[test]
fn time_goes_on_after_microseconds_wrap() {
    let Some(mut board) = board(&[]) else {
        return;
    };
    let mut symbols = std::process::Command::new("avr-nm");
    let Ok(symbols) = symbols.arg(board::firmware().unwrap()).output() else {
        eprintln!("skipped: no avr-nm");
        return;
    };
    let symbols = String::from_utf8(symbols.stdout).unwrap();
    let mut lines = symbols.lines();
    let line = lines.find(|l| l.ends_with(" timer0_overflow_count"));
    let address = u16::from_str_radix(&line.unwrap()[4..8], 16).unwrap();
    board.text(0.05);
    // 1024 us each: 2 s before 2^32 us.
    let overflows: u32 = (1 << 22) - 2000;
    assert!(board.uno.poke(address, &overflows.to_le_bytes()));
    let rows = rows(&board.text(5.0));
    assert!(rows[0][0] > 4_292_000.0 && rows[rows.len() - 1][0] > 4_297_000.0);
    for pair in rows.windows(2) {
        let step_ms = pair[1][0] - pair[0][0];
        assert!((9.0..=11.0).contains(&step_ms), "{pair:?}");
    }
}

mod desk;
mod ends;
mod resets;

use super::queue::MOST_ROWS;
use super::*;
use crate::device::board::Wanted;
use desk::{Desk, HEADER, SETTINGS};

#[test]
fn pauses_leave_three_blank_rows_and_no_gap() {
    let mut desk = Desk::started(Options::default());
    desk.recorder.toggle_pause(desk.now_s);
    desk.rows(5);
    desk.recorder.toggle_pause(desk.now_s);
    desk.rows(10);
    desk.recorder.toggle_pause(desk.now_s);
    desk.rows(200);
    desk.recorder.toggle_pause(desk.now_s);
    desk.rows(10);
    let counts = desk.end();
    assert_eq!((counts.stored, counts.paused, counts.gaps), (20, 205, 0));
    // There are none before the first row.
    assert_eq!(desk.file.matches("\n\n\n\n").count(), 1);
    assert!(desk.file.contains(&format!("{HEADER}180,")));
    assert!(desk.recorder.elapsed_s(desk.now_s) < 0.3);
    assert!(desk.events.contains(&Event::Paused) && desk.events.contains(&Event::Resumed));
}

/// The head is first, the gap is where rows are missing, and no gap is dropped even if
/// the board sends many messages.
#[test]
fn a_disk_that_is_full_from_the_start() {
    let mut desk = Desk::new(Options::default());
    desk.full = true;
    desk.say(&format!("{SETTINGS}{HEADER}"));
    for _ in 0..600 {
        desk.say("# overruns 1, i2c errors 0, restarts 0\n");
        desk.rows(1);
    }
    desk.stamp += 1000;
    desk.rows(MOST_ROWS as u32);
    desk.recorder.toggle_pause(desk.now_s);
    desk.rows(1);
    desk.recorder.toggle_pause(desk.now_s);
    desk.rows(10);
    desk.full = false;
    desk.rows(10);
    let counts = desk.end();
    assert_eq!((counts.unstored, counts.missing), (610, 100));
    assert!(desk.file.starts_with(SETTINGS));
    let gaps = desk.gaps();
    assert!(gaps[0].contains("lost on the way from the board: 100 rows"));
    assert!(gaps[1].contains("the disk was full: 610 rows"), "{gaps:?}");
    assert_eq!((gaps.len(), desk.file.matches("\n\n\n\n").count()), (2, 1));
    let (_, after) = desk.file.split_once("disk was full").unwrap();
    assert!(after.split('\n').nth(1).unwrap().starts_with("7230,"));
}

#[test]
fn a_disk_that_stays_full_loses_counted_rows() {
    let mut desk = Desk::started(Options::default());
    desk.full = true;
    desk.rows(20);
    let counts = {
        desk.recorder.finish(desk.now_s, End::User);
        desk.disk();
        desk.recorder.give_up();
        *desk.recorder.counts()
    };
    assert!(counts.balances(0));
    assert_eq!((counts.stored, counts.unstored), (0, 20));
}

#[test]
fn boards_without_rows_are_an_error() {
    let mut desk = Desk::new(Options::default());
    for _ in 0..100 {
        desk.pass(0.1);
    }
    assert_eq!(desk.fatal(), "board-silent");
    let mut desk = Desk::new(Options::default());
    for _ in 0..100 {
        desk.say("\u{7f}~\u{3}\n");
        desk.pass(0.1);
    }
    let error = desk.recorder.take_fatal().unwrap();
    assert_eq!(error.code(), "no-samples-from-board");
    // Bytes of another baud rate are not stored.
    let lines: u32 = error
        .to_string()
        .split(' ')
        .nth(3)
        .unwrap()
        .parse()
        .unwrap();
    assert!(
        (80..90).contains(&lines) && desk.rejects.is_empty(),
        "{error}"
    );
    // The board reports the cause; or it is slow; or it stops again.
    let mut desk = Desk::new(Options::default());
    for _ in 0..10 {
        desk.say("# no answer from a sensor\n");
        desk.pass(1.0);
    }
    let error = desk.recorder.take_fatal().unwrap();
    assert_eq!(error.code(), "no-samples-from-board");
    assert!(
        error.to_string().contains("no answer from a sensor"),
        "{error}"
    );
    let mut desk = Desk::new(Options::default());
    for _ in 0..7 {
        desk.pass(2.0);
        desk.stamp += 1990;
        let row = desk.row();
        desk.say(&row);
    }
    assert_eq!(desk.fatal_code(), None);
    let counts = desk.end();
    assert_eq!((counts.stored, counts.rejected), (6, 1));
    let mut desk = Desk::new(Options::default());
    desk.say("\n");
    desk.rows(3);
    desk.pass(9.0);
    let error = desk.recorder.take_fatal().unwrap();
    assert!(error.to_string().contains("only 3 rows"), "{error}");
    // A sketch that prints words.
    let mut desk = Desk::new(Options::default());
    desk.say("\nFailed to find MPU6050 chip\n");
    for _ in 0..100 {
        desk.pass(0.1);
    }
    let error = desk.recorder.take_fatal().unwrap();
    assert!(error.to_string().contains("Failed to find"), "{error}");
    // Plain text is not sent at another baud rate.
    let mut desk = Desk::new(Options::default());
    for _ in 0..60 {
        desk.say("Calibrating the sensor, keep it still ...\n");
        desk.pass(0.1);
    }
    desk.say(HEADER);
    desk.rows(4);
    assert_eq!(desk.end().stored, 4);
    let mut desk = Desk::new(Options {
        wait: true,
        ..Options::default()
    });
    for _ in 0..1000 {
        desk.pass(0.1);
    }
    assert!(desk.recorder.take_fatal().is_none());
    desk.say(&format!("{SETTINGS}{HEADER}"));
    desk.rows(4);
    assert_eq!(desk.end().stored, 4);
}

#[test]
fn boards_that_refuse_settings_are_an_error() {
    let wanted = Wanted {
        low_pass_hz: Some(21),
        ..Wanted::default()
    };
    for reports in [true, false] {
        let mut desk = Desk::new(Options {
            wanted,
            ..Options::default()
        });
        if reports {
            desk.say(&format!("{SETTINGS}{HEADER}"));
        }
        desk.rows(1200);
        assert_eq!(desk.fatal(), "settings-refused");
        assert!(
            desk.commands.matches("d21\n").count() >= 4,
            "{}",
            desk.commands
        );
        assert_eq!(desk.end().stored, 0);
    }
}

#[test]
fn other_columns_in_the_middle_are_an_error() {
    let mut desk = Desk::new(Options::default());
    desk.say(HEADER);
    desk.rows(5);
    // Rows of these columns in the same write.
    let (one, two) = (desk.row(), desk.row());
    desk.say(&format!("t,ax,ay,az,T,gx,gy,gz\n{one}{two}"));
    assert_eq!(desk.fatal(), "columns-changed");
    desk.rows(3);
    let counts = desk.end();
    assert_eq!((counts.stored, counts.after_end), (5, 5));
}

#[test]
fn an_unplugged_end_is_a_gap_and_silence_is_reported() {
    let mut desk = Desk::started(Options::default());
    desk.rows(20);
    for _ in 0..5 {
        desk.pass(1.0);
    }
    let reported = desk
        .events
        .iter()
        .filter(|e| matches!(e, Event::Silent { .. }));
    assert_eq!(reported.count(), 1);
    desk.recorder.lost(desk.now_s, "gone");
    desk.pass(3.0);
    desk.end();
    assert_eq!(
        desk.gaps(),
        ["# gap: unplugged: no row arrived until the end, 8.0 s"]
    );
}

//! Boards that restart during the recording, or have another sketch.

use super::desk::{Desk, HEADER, SETTINGS};
use crate::device::board::Wanted;
use crate::device::recorder::*;

/// The settings are in the line of an incomplete row, or not received: no row of other
/// settings is in the file.
#[test]
fn a_reset_in_the_middle_of_a_row_is_set_again() {
    let eight = SETTINGS.replace("+-2 g", "+-8 g");
    for received in [true, false] {
        let mut desk = Desk::new(Options {
            wanted: Wanted {
                accel_range_g: Some(8),
                ..Wanted::default()
            },
            ..Options::default()
        });
        desk.say(&format!("{eight}{HEADER}"));
        desk.stamp = 5000;
        desk.rows(40);
        desk.say("5400,0.1,0.2,9.8");
        desk.say(&if received {
            format!("{SETTINGS}{HEADER}")
        } else {
            format!("#gra\n{HEADER}")
        });
        desk.stamp = 130;
        desk.rows(10);
        if !received {
            assert_eq!(desk.commands, "?\n");
            desk.say(&format!("{SETTINGS}{HEADER}"));
        }
        assert!(desk.commands.contains("a8\n"), "{}", desk.commands);
        desk.rows(10);
        desk.say(&format!("{eight}{HEADER}"));
        desk.rows(10);
        let counts = desk.end();
        assert_eq!((counts.stored, counts.other_settings), (50, 20));
        assert_eq!(counts.rejected, 1);
        assert!(
            desk.gaps()[0].starts_with("# gap: the board was reset: 20 rows are missing, or more")
        );
    }
}

/// A board that does not answer has another sketch.
#[test]
fn another_header_without_an_answer_is_an_error() {
    let mut desk = Desk::started(Options::default());
    desk.rows(9);
    desk.say("t,ax,ay,az,T,gx,gy,gz\n");
    desk.rows(900);
    assert_eq!(desk.fatal(), "columns-changed");
    let counts = desk.end();
    assert_eq!((counts.stored, counts.received), (9, 909));
}

#[test]
fn garbage_without_end_is_counted() {
    let mut desk = Desk::started(Options::default());
    desk.rows(9);
    desk.recorder.lost(desk.now_s, "gone");
    desk.recorder.opened(desk.now_s, "/dev/ttyACM1", None);
    for _ in 0..5000 {
        desk.say("1,2,3\n");
    }
    assert_eq!(desk.recorder.counts().rejected, 5000);
    desk.rows(9);
    let counts = desk.end();
    assert_eq!((counts.stored, counts.rejected_unstored), (18, 0));
    // Before the start likewise, once it is known to be text.
    let mut desk = Desk::new(Options::default());
    for _ in 0..5000 {
        desk.say("1,2\n");
    }
    desk.say(&format!("{SETTINGS}{HEADER}"));
    let counts = *desk.recorder.counts();
    assert_eq!((counts.rejected, counts.rejected_unstored), (5000, 0));
}

/// The messages before the start are limited, and the settings are kept.
#[test]
fn many_messages_before_the_start() {
    let mut desk = Desk::new(Options::default());
    for i in 0..100 {
        desk.say("# no answer from a sensor\n");
        desk.say(&format!("# attempt {i}\n"));
    }
    desk.say(&format!("{SETTINGS}{HEADER}"));
    desk.rows(3);
    desk.end();
    assert!(desk.file.contains(&format!(
        "# attempt 99\n{SETTINGS}# rate: 100.00 Hz\n{HEADER}130,"
    )));
    assert_eq!(desk.file.matches("# no answer").count(), 1);
    assert_eq!(desk.file.matches("# attempt").count(), 19);
}

/// Rows with other steps while the board has other settings do not change the usual step.
#[test]
fn a_slow_board_that_was_fast_for_a_while() {
    let slow = SETTINGS.replace("100.00", "20.00");
    let mut desk = Desk::new(Options {
        wanted: Wanted {
            rate_hz: Some(20),
            ..Wanted::default()
        },
        ..Options::default()
    });
    desk.say(&format!("{slow}{HEADER}"));
    let slowly = |desk: &mut Desk| {
        for _ in 0..30 {
            desk.rows(1);
            desk.stamp += 40;
        }
    };
    slowly(&mut desk);
    desk.stamp = 130;
    desk.say(&format!("{SETTINGS}{HEADER}"));
    desk.rows(40);
    desk.say(&format!("{slow}{HEADER}"));
    slowly(&mut desk);
    let counts = desk.end();
    assert_eq!((counts.stored, counts.missing), (60, 0));
    assert_eq!(desk.gaps().len(), 1, "{:?}", desk.gaps());
}

#[test]
fn a_board_that_resets_is_set_as_before() {
    let wanted = Wanted {
        accel_range_g: Some(4),
        ..Wanted::default()
    };
    let four = SETTINGS.replace("+-2 g", "+-4 g");
    let mut desk = Desk::new(Options {
        wanted,
        ..Options::default()
    });
    desk.say(SETTINGS);
    desk.say(HEADER);
    desk.rows(3);
    assert!(!desk.recorder.is_started());
    assert_eq!(desk.commands, "a4\n");
    desk.say(&format!("{four}{HEADER}"));
    desk.rows(40);
    desk.stamp = 130;
    desk.say(&format!("{SETTINGS}{HEADER}"));
    assert_eq!(desk.commands, "a4\na4\ng500\nd44\nr100\nf0\n");
    desk.rows(7);
    desk.say(&format!("{four}{HEADER}"));
    desk.rows(40);
    let counts = desk.end();
    assert_eq!(
        (counts.stored, counts.before_start, counts.other_settings),
        (80, 3, 7)
    );
    let at = |what: &str| desk.file.find(what).unwrap();
    assert_eq!(
        desk.gaps(),
        [
            "# gap: the board was reset: 7 rows are missing, or more, 0.1 s, the clock of the board restarts"
        ]
    );
    assert!(at("# gap:") < desk.file.rfind(&four).unwrap());
    assert_eq!(desk.file.matches(HEADER).count(), 1);
}

#[test]
fn a_sensor_that_is_set_up_again() {
    let mut desk = Desk::started(Options::default());
    desk.rows(40);
    desk.say("# no answer from a sensor at 0x68 or 0x69: check SDA (A4), SCL (A5), power\n");
    for _ in 0..110 {
        desk.row();
    }
    desk.pass(1.1);
    desk.say(&format!("{SETTINGS}{HEADER}"));
    desk.rows(5);
    let counts = desk.end();
    assert_eq!((counts.stored, counts.missing), (45, 110));
    assert_eq!(
        desk.gaps(),
        ["# gap: the sensor was set up again: 110 rows are missing, 1.1 s"]
    );
}

#[test]
fn a_reset_without_messages_and_a_wrap() {
    let mut desk = Desk::started(Options::default());
    desk.stamp = (1 << 32) - 300;
    desk.rows(60);
    assert!(desk.gaps().is_empty() && desk.stamp == 300);
    desk.stamp = 20;
    desk.rows(5);
    // The board is asked for its settings.
    assert_eq!(desk.commands, "?\n");
    desk.say(&format!("{SETTINGS}{HEADER}"));
    desk.rows(5);
    let counts = desk.end();
    assert_eq!((counts.stored, counts.other_settings), (65, 5));
    assert_eq!(
        desk.gaps(),
        [
            "# gap: the board was reset: 5 rows are missing, or more, 0.1 s, the clock of the board restarts"
        ]
    );
}

//! Silence, pauses and the end: which rows are missing.

use super::desk::{Desk, HEADER, SETTINGS};
use crate::device::recorder::*;

#[test]
fn a_sensor_that_is_silent_until_the_end() {
    for duration_s in [None, Some(3.0)] {
        let mut desk = Desk::started(Options {
            duration_s,
            ..Options::default()
        });
        desk.rows(50);
        for _ in 0..30 {
            desk.say("# no answer from a sensor\n");
            desk.pass(0.1);
        }
        assert_eq!(desk.recorder.ended().is_some(), duration_s.is_some());
        let counts = desk.end();
        assert_eq!((counts.gaps, counts.incomplete), (1, 1));
        assert!(desk.recorder.ended_in_gap());
        assert_eq!(
            desk.gaps(),
            ["# gap: the board sent no rows: no row arrived until the end, 3.0 s"]
        );
    }
    // A slow board, a pause, and a complete recording.
    let mut slow = Desk::started(Options::default());
    for _ in 0..5 {
        slow.rows(1);
        slow.pass(2.0);
    }
    let mut paused = Desk::started(Options::default());
    paused.rows(50);
    paused.recorder.toggle_pause(paused.now_s);
    paused.pass(60.0);
    let mut resumed = Desk::started(Options::default());
    resumed.rows(50);
    resumed.recorder.toggle_pause(resumed.now_s);
    resumed.pass(60.0);
    resumed.recorder.toggle_pause(resumed.now_s);
    resumed.pass(0.5);
    let mut done = Desk::started(Options {
        rows: Some(50),
        ..Options::default()
    });
    done.rows(50);
    done.pass(60.0);
    for (i, mut desk) in [slow, paused, resumed, done].into_iter().enumerate() {
        assert_eq!(
            (desk.end().gaps, desk.recorder.ended_in_gap()),
            (0, false),
            "{i}"
        );
    }
}

/// Rows that are lost in a pause are not missing.
#[test]
fn unplugged_in_a_pause() {
    let mut desk = Desk::started(Options::default());
    desk.rows(50);
    desk.recorder.toggle_pause(desk.now_s);
    desk.rows(10);
    let unplug = |desk: &mut Desk, s: f64| {
        desk.recorder.lost(desk.now_s, "gone");
        for _ in 0..(100.0 * s) as u32 {
            desk.row();
        }
        desk.pass(s);
        desk.recorder.opened(desk.now_s, "/dev/ttyACM1", None);
        desk.say("\n");
    };
    unplug(&mut desk, 2.0);
    desk.rows(10);
    desk.recorder.toggle_pause(desk.now_s);
    desk.rows(10);
    assert!(desk.gaps().is_empty(), "{:?}", desk.gaps());
    assert_eq!(desk.recorder.counts().missing, 0);
    // Half of the time is before the pause.
    desk.recorder.lost(desk.now_s, "gone");
    for _ in 0..200 {
        desk.row();
    }
    desk.pass(1.0);
    desk.recorder.toggle_pause(desk.now_s);
    desk.pass(1.0);
    desk.recorder.opened(desk.now_s, "/dev/ttyACM1", None);
    desk.say("\n");
    desk.rows(10);
    desk.recorder.toggle_pause(desk.now_s);
    desk.rows(10);
    let counts = desk.end();
    assert!((95..=105).contains(&counts.missing), "{counts:?}");
    assert_eq!((counts.gaps, counts.incomplete), (1, 1));
    // Unplugged in a pause without end.
    let mut desk = Desk::started(Options::default());
    desk.rows(50);
    desk.recorder.toggle_pause(desk.now_s);
    desk.recorder.lost(desk.now_s, "gone");
    desk.pass(9.0);
    assert_eq!(desk.end().gaps, 0);
}

#[test]
fn gaps_of_unknown_size_are_incomplete() {
    let mut desk = Desk::started(Options::default());
    desk.stamp = 5000;
    desk.rows(50);
    desk.recorder.lost(desk.now_s, "gone");
    desk.pass(2.0);
    desk.recorder.opened(desk.now_s, "/dev/ttyACM1", None);
    desk.stamp = 130;
    desk.say(&format!("{SETTINGS}{HEADER}"));
    desk.rows(9);
    let counts = desk.end();
    assert_eq!((counts.in_gaps(), counts.incomplete), (0, 1));
    // Plugged in again without a missing row, and a recording that is continued.
    let mut desk = Desk::started(Options {
        continues: Some(HEADER.trim().into()),
        ..Options::default()
    });
    desk.rows(50);
    desk.recorder.lost(desk.now_s, "gone");
    desk.pass(2.0);
    desk.recorder.opened(desk.now_s, "/dev/ttyACM1", None);
    desk.say("\n");
    desk.rows(9);
    let counts = desk.end();
    assert_eq!((counts.gaps, counts.incomplete), (2, 0));
}

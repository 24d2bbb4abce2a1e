//! The binary format: how a board is set to it and leaves it, and the counts of its rows.

use super::uno::Uno;
use crate::device::board::Wanted;
use crate::device::frames::COLUMNS;
use crate::device::recorder::*;

fn fast() -> Options {
    Options {
        wanted: Wanted {
            rate_hz: Some(500),
            format: Some(2),
            ..Wanted::default()
        },
        ..Options::default()
    }
}

#[test]
fn the_board_is_set_to_frames_and_they_become_rows() {
    let mut uno = Uno::recording(fast());
    assert_eq!(uno.desk.commands, "r500\nf2\n");
    assert_eq!(uno.desk.bauds, [250_000]);
    uno.run(1.0);
    let sent = uno.sent;
    let counts = uno.desk.end();
    assert_eq!(counts.rejected, 0, "{}", uno.desk.rejects);
    assert_eq!((counts.gaps, counts.lost, counts.fragments), (0, 0, 0));
    // Rows of text arrived before; one while the baud rate was changed.
    assert!(sent - counts.stored - counts.before_start <= 1);
    assert!(counts.stored > 900);
    let head: Vec<&str> = uno.desk.file.lines().take(4).collect();
    assert_eq!(head[0], uno.settings());
    assert_eq!(head[1..3], ["# rate: 500.00 Hz", COLUMNS]);
    assert!(
        head[3].ends_with(",10,-20,16384,-3920,1,2,3"),
        "{}",
        head[3]
    );
}

#[test]
fn a_board_that_was_left_in_binary_or_begins_so() {
    for wanted in [Wanted::default(), fast().wanted] {
        let mut uno = Uno::new(
            Options {
                wanted,
                ..Options::default()
            },
            2,
        );
        uno.run(6.0);
        assert!(uno.desk.recorder.is_started(), "{:?}", uno.desk.events);
        assert_eq!(uno.desk.bauds, [250_000]);
        let counts = uno.desk.end();
        assert!(counts.stored > 100);
        // Bytes received at the wrong rate are not counted.
        assert_eq!((counts.rejected, counts.gaps), (0, 0));
        assert!(uno.desk.file.contains(COLUMNS));
    }
    // Set back to text.
    let mut uno = Uno::new(
        Options {
            wanted: Wanted {
                format: Some(0),
                ..Wanted::default()
            },
            ..Options::default()
        },
        2,
    );
    uno.run(6.0);
    assert_eq!(uno.desk.bauds, [250_000, 115_200]);
    assert!(uno.desk.file.contains("aX (m/s^2)"), "{}", uno.desk.file);
    assert!(uno.desk.end().stored > 100);
}

#[test]
fn a_reset_in_the_middle_is_a_named_gap() {
    let mut options = fast();
    options.wanted.accel_range_g = Some(4);
    for constant_format in [0, 2] {
        let mut uno = Uno::recording(options.clone());
        uno.constant_format = constant_format;
        uno.run(1.0);
        let before = uno.desk.bauds.len();
        uno.reset();
        uno.run(8.0);
        assert!(uno.desk.bauds.len() > before || constant_format == 2);
        assert_eq!((uno.format, uno.range_g, uno.rate_hz), (2, 4, 500));
        let counts = uno.desk.end();
        assert_eq!(counts.gaps, 1, "{:?}", uno.desk.gaps());
        let gap = uno.desk.gaps()[0];
        assert!(
            gap.starts_with("# gap: the board was reset: ")
                && gap.ends_with(", the clock of the board restarts"),
            "{gap}"
        );
        // There is no row of another range or unit.
        let (_, after) = uno.desk.file.split_once("# gap:").unwrap();
        let rows: Vec<&str> = after
            .lines()
            .filter(|l| l.starts_with(|c: char| c.is_ascii_digit()))
            .collect();
        assert!(rows.len() > 500, "{}", rows.len());
        assert!(
            rows.iter()
                .all(|row| row.ends_with(",10,-20,16384,-3920,1,2,3"))
        );
        assert!(after.contains("+-4 g") && after.contains("format 2"));
    }
}

#[test]
fn unplugged_and_plugged_in_again() {
    for resets in [true, false] {
        let mut uno = Uno::recording(fast());
        uno.run(1.0);
        // Rows of text while the baud rate was changed.
        let unnoticed = uno.sent - known(uno.desk.recorder.counts());
        uno.desk.recorder.lost(uno.desk.now_s, "Input/output error");
        uno.desk.pass(2.0);
        uno.lose(1000);
        if resets {
            uno.reset();
        }
        // A port is opened at the baud rate of text.
        uno.desk.bauds.push(115_200);
        let now_s = uno.desk.now_s;
        uno.desk.recorder.opened(now_s, "/dev/ttyACM1", None);
        uno.run(6.0);
        let sent = uno.sent;
        let counts = uno.desk.end();
        let gaps = uno.desk.gaps();
        assert_eq!(gaps.len(), 1, "{gaps:?}");
        assert!(gaps[0].starts_with("# gap: unplugged: "), "{gaps:?}");
        assert_eq!(gaps[0].contains("restarts"), resets, "{gaps:?}");
        if !resets {
            assert_eq!(known(&counts) + unnoticed, sent, "{counts:?}");
        }
        assert!(counts.stored > 900);
    }
}

/// Rows that the board sent, by the counts of the logger.
fn known(counts: &RowCounts) -> u64 {
    counts.received + counts.missing + counts.lost + counts.rejected - counts.fragments
}

#[test]
fn flipped_bits_and_lost_frames_are_accounted_for() {
    // The stamps wrap meanwhile.
    let mut uno = Uno::recording_from(fast(), (1 << 32) - 5_000_000);
    let unnoticed = uno.sent - known(uno.desk.recorder.counts());
    assert!(unnoticed < 3);
    let mut hurt = 0;
    for round in 0_usize..400 {
        uno.rows(7);
        let mut row = uno.row();
        let at = round % row.len();
        row[at] ^= 1 << (round % 8);
        hurt += 1;
        uno.send(&row);
        if round % 3 == 0 {
            uno.rows(5);
            uno.lose(round as u32 % 8);
        }
    }
    uno.rows(300);
    uno.lose(700);
    uno.say("# overruns 1, i2c errors 0, restarts 0");
    uno.rows(20);
    let counts = uno.desk.end();
    assert_eq!(known(&counts) + unnoticed, uno.sent, "{counts:?}");
    assert_eq!(counts.received, counts.stored + counts.before_start);
    assert!(counts.rejected > 300 && counts.rejected <= 2 * hurt);
    assert!(counts.fragments > 0 && counts.fragments < 40, "{counts:?}");
    assert!(counts.missing >= 700 && counts.lost > 100);
    let gaps = uno.desk.gaps();
    assert!(
        gaps.last()
            .unwrap()
            .starts_with("# gap: rows were lost on the way from the board: 700 rows"),
        "{gaps:?}"
    );
    // Bytes as hexadecimal digits, and the reason.
    let line = uno.desk.rejects.lines().next().unwrap();
    let (bytes, why) = line.split_once("  # ").unwrap();
    assert!(bytes.bytes().all(|b| b.is_ascii_hexdigit()), "{line}");
    assert!(
        why.contains("checksum") || why.contains("stuffed"),
        "{line}"
    );
}

#[test]
fn the_stamp_continues_after_its_wrap() {
    let mut uno = Uno::recording_from(fast(), (1 << 32) - 4_000_000);
    uno.rows(1000);
    let counts = uno.desk.end();
    let stamp = |row: &str| row.split(',').next().unwrap().parse::<u64>().unwrap();
    let rows = uno.desk.file.lines().skip(3).map(stamp);
    let rows: Vec<u64> = rows.collect();
    assert!(rows.windows(2).all(|pair| pair[1] - pair[0] == 2000));
    assert!(rows[0] < 1 << 32 && *rows.last().unwrap() > 1 << 32);
    assert_eq!((counts.gaps, counts.lost), (0, 0));
}

#[test]
fn samples_that_the_board_missed_are_not_lost_rows() {
    let mut uno = Uno::recording(fast());
    uno.run(0.5);
    uno.stamp_us += 20_000;
    uno.run(0.2);
    let counts = uno.desk.end();
    assert_eq!((counts.missing, counts.lost), (10, 0));
    assert!(
        uno.desk.gaps()[0].starts_with("# gap: the board missed samples: 10 rows"),
        "{:?}",
        uno.desk.gaps()
    );
}

#[test]
fn a_board_that_refuses_frames() {
    let mut uno = Uno::new(fast(), 0);
    uno.deaf = true;
    for _ in 0..400 {
        uno.run(0.05);
        if let Some(error) = uno.desk.recorder.take_fatal() {
            assert_eq!(error.code(), "settings-refused");
            assert_eq!(uno.desk.end().stored, 0);
            return;
        }
    }
    panic!("{:?}", uno.desk.events);
}

#[test]
fn frames_are_continued_only_with_frames() {
    let mut options = fast();
    options.continues = Some(b"Timestamp (ms),ax,ay,az,temp,gx,gy,gz".to_vec());
    let mut uno = Uno::new(options, 0);
    uno.run(5.0);
    assert_eq!(uno.desk.fatal(), "columns-changed");
    let mut options = fast();
    options.continues = Some(COLUMNS.into());
    let mut uno = Uno::recording(options);
    uno.run(0.2);
    uno.desk.end();
    assert_eq!(uno.desk.file.matches(COLUMNS).count(), 0);
    assert_eq!(uno.desk.gaps().len(), 1);
}

#[test]
fn pauses_and_a_number_of_rows() {
    let mut options = fast();
    options.rows = Some(2000);
    let mut uno = Uno::recording(options);
    uno.desk.recorder.toggle_pause(uno.desk.now_s);
    uno.run(0.5);
    uno.lose(3);
    uno.run(0.5);
    uno.desk.recorder.toggle_pause(uno.desk.now_s);
    uno.run(2.0);
    let counts = uno.desk.end();
    assert_eq!(counts.stored, 2000);
    assert!(counts.paused >= 450 && counts.after_end > 0, "{counts:?}");
    assert_eq!((counts.lost, counts.gaps), (3, 0));
}

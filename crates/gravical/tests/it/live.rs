//! Guided calibration: sessions of simulated sensors, moved by hands that follow what is asked
//! for or do something wrong; replay of real recordings.

use gravical::calibrate::{CalibrateOptions, calibrate};
use gravical::calibration_file::Grade;
use gravical::live::event::{
    Command, Event, Loss, Message, Rejection, Tile, Undone, Wanted, Welcome,
};
use gravical::live::{LiveOptions, Session};
use gravical::poses::face::{Face, angle_deg};
use gravical::poses::sections::Section;
use gravical::poses::{SegmentOptions, segment};
use gravical::recording::{ReadOptions, open, read_bytes};

use super::hand::{Clumsiness, Hand};
use super::support::data;

fn face(name: &str) -> Face {
    Face::all().into_iter().find(|f| f.name() == name).unwrap()
}

fn rejections(events: &[Message]) -> Vec<Rejection> {
    let reason = |m: &Message| match &m.event {
        Event::PoseRejected { reason, .. } => Some(*reason),
        _ => None,
    };
    events.iter().filter_map(reason).collect()
}

fn accepted(events: &[Message]) -> Vec<String> {
    let name = |m: &Message| match &m.event {
        Event::PoseAccepted(p) => Some(p.face.clone().unwrap_or_else(|| "free".to_owned())),
        _ => None,
    };
    events.iter().filter_map(name).collect()
}

/// A hand at rest on +z, which is accepted.
fn begun() -> Hand {
    let mut hand = Hand::new(3, Clumsiness::None);
    let events = hand.pass(5.0);
    assert_eq!(accepted(&events), ["+z"]);
    hand
}

#[test]
fn the_first_seconds_identify_the_board_and_its_noise() {
    let mut hand = Hand::new(1, Clumsiness::None);
    let events = hand.pass(5.0);
    let kinds: Vec<&Event> = events
        .iter()
        .map(|m| &m.event)
        .filter(|e| !e.is_status())
        .collect();
    let [
        Event::Identified { rate_hz, unit, .. },
        Event::Floor {
            noise_mg, limit_mg, ..
        },
        Event::NextPose {
            kind: Wanted::Face,
            faces,
            ..
        },
        Event::PoseCandidate,
        Event::PoseAccepted(pose),
        Event::NextPose { faces: left, .. },
    ] = kinds[..]
    else {
        panic!("{kinds:#?}")
    };
    assert!((rate_hz.unwrap() - 100.0).abs() < 0.1 && unit.name() == "m/s^2");
    assert!(
        noise_mg.iter().all(|n| (1.0..6.0).contains(n)),
        "{noise_mg:?}"
    );
    assert!((10.0..40.0).contains(limit_mg), "{limit_mg}");
    assert_eq!((faces.len(), left.len(), pose.lines), (6, 5, [52, 301]));
    assert!(events.iter().filter(|m| m.event.is_status()).count() >= 39);
}

#[test]
fn hands_that_follow_reach_a_good_result_that_the_same_rows_confirm() {
    reach_a_good_result(0..2);
}

#[test]
#[ignore = "slow: twelve more sessions"]
fn hands_of_any_clumsiness_reach_a_good_result() {
    reach_a_good_result(2..14);
}

fn reach_a_good_result(sessions: std::ops::Range<u64>) {
    let hands = (0..).zip(Clumsiness::ALL.into_iter().cycle());
    for (seed, clumsiness) in hands
        .filter(|hand| sessions.contains(&hand.0))
        .take(sessions.clone().count())
    {
        let ended = Hand::new(seed, clumsiness).run();
        let file = ended.file.as_ref().expect("a calibration");
        assert_eq!(
            file.verdict.grade,
            Grade::Good,
            "{clumsiness:?}: {:?}",
            file.verdict
        );
        let scale = |r: &Rejection| matches!(r, Rejection::Scale | Rejection::Units);
        assert!(
            !rejections(&ended.messages).iter().any(scale),
            "{clumsiness:?}"
        );
        let [rms, worst] = ended.norm_error_mg().unwrap();
        assert!(rms < 1.5 && worst < 5.0, "{clumsiness:?}: {rms} {worst}");
        assert!(
            ended.good_s.unwrap() < 180.0,
            "{clumsiness:?}: {:?}",
            ended.good_s
        );
        assert!(ended.count(|e| matches!(e, Event::Verdict { r#final: true, .. })) == 1);
        for message in ended
            .messages
            .iter()
            .filter(|m| !m.event.is_status())
            .chain(&ended.messages[60..61])
        {
            let value = serde_json::to_value(message).unwrap();
            let back: Message = serde_json::from_value(value).unwrap();
            assert_eq!(back, *message);
        }
        let recording = gravical::recording::read_bytes(
            ended.text.as_bytes(),
            "recording.csv",
            &ReadOptions::default(),
        )
        .unwrap();
        let poses = ended.messages.iter().filter_map(|m| match &m.event {
            Event::PoseAccepted(p) => Some(p),
            _ => None,
        });
        let sections = poses.map(|p| Section {
            label: format!("pose {}", p.pose),
            rows: recording.rows_at(p.lines),
        });
        let options = CalibrateOptions {
            segment: SegmentOptions {
                sections: Some(sections.collect()),
                ..SegmentOptions::default()
            },
            gravity: gravical::gravity::Gravity::given(9.80665).unwrap(),
            ..CalibrateOptions::default()
        };
        let whole = calibrate(&[recording], &options).unwrap().file;
        assert_eq!(whole.accelerometer, file.accelerometer, "{clumsiness:?}");
        assert_eq!(whole.gyroscope, file.gyroscope, "{clumsiness:?}");
        assert_eq!(whole.verdict, file.verdict, "{clumsiness:?}");
    }
}

#[test]
fn the_order_in_which_bytes_arrive_does_not_matter() {
    let ended = Hand::new(5, Clumsiness::LostRows).run();
    let replay = |at_once: usize| -> Vec<Message> {
        let gravity = gravical::gravity::Gravity::given(9.80665).unwrap();
        let options = LiveOptions {
            gravity,
            ..LiveOptions::default()
        };
        let mut session = Session::new("recording.csv", options);
        let pieces = ended.text.as_bytes().chunks(at_once);
        let mut events: Vec<Message> = pieces.flat_map(|p| session.bytes(p).unwrap()).collect();
        events.extend(session.command(&Command::Finish));
        events
    };
    let (one, other) = (replay(7), replay(4096));
    assert!(one == other);
    let names = accepted(&ended.messages);
    assert_eq!(accepted(&one), names);
}

#[test]
fn a_bump_in_a_capture_rejects_it_and_the_next_try_counts() {
    let mut hand = begun();
    hand.lay(face("+x"));
    hand.pass(4.0);
    hand.bump();
    let events = hand.pass(1.5);
    assert_eq!(rejections(&events), [Rejection::Moved], "{events:#?}");
    let (_, text) = rejection(&events);
    assert!(
        text.contains("mg, limit") && text.contains(" mg. Lay it down"),
        "{text}"
    );
    let events = hand.pass(5.0);
    assert_eq!(accepted(&events), ["+x"]);
}

#[test]
fn a_face_twice_is_a_duplicate_once_it_was_away() {
    let mut hand = begun();
    // A bump where it lies is not worth a word.
    hand.bump();
    assert_eq!(rejections(&hand.pass(6.0)), []);
    hand.lay(face("+y"));
    assert_eq!(accepted(&hand.pass(7.0)), ["+y"]);
    hand.lay(face("+z"));
    let events = hand.pass(7.0);
    assert_eq!(rejections(&events), [Rejection::Duplicate]);
    let status = events.iter().rev().find_map(|m| match &m.event {
        Event::Status(s) => Some(s),
        _ => None,
    });
    let status = status.unwrap();
    assert_eq!(
        (status.welcome, status.tiles["+y"]),
        (Welcome::Duplicate, Tile::Done)
    );
    assert_eq!(status.tiles["-x"], Tile::ToDo);
    // Taken all the same.
    hand.command(&Command::Capture);
    assert_eq!(accepted(&hand.pass(4.5)), ["+z"]);
}

#[test]
fn between_faces_is_rejected_with_the_angle_and_welcome_when_asked_for() {
    let mut hand = begun();
    hand.hold([1.0, 1.0, 0.0]);
    let events = hand.pass(6.0);
    assert_eq!(rejections(&events), [Rejection::BetweenFaces]);
    let (_, text) = rejection(&events);
    assert!(
        text.contains("two faces: 4") && text.contains('°'),
        "{text}"
    );
    hand.command(&Command::Capture);
    assert_eq!(accepted(&hand.pass(4.5)), ["free"]);
}

#[test]
fn undo_and_redo() {
    let mut hand = begun();
    hand.lay(face("-x"));
    assert_eq!(accepted(&hand.pass(7.0)), ["-x"]);
    let events = hand.command(&Command::Redo {
        face: "+z".to_owned(),
    });
    assert!(matches!(
        &events[0].event,
        Event::PoseUndone {
            pose: 1,
            why: Undone::Redo,
            ..
        }
    ));
    // The other one is up.
    hand.lay(face("-z"));
    assert_eq!(accepted(&hand.pass(7.0)), ["-z"]);
    hand.lay(face("+x"));
    hand.pass(7.0);
    hand.lay(face("-z"));
    assert_eq!(rejections(&hand.pass(7.0)), [Rejection::Sign]);
    let events = hand.command(&Command::Undo);
    assert!(
        matches!(&events[0].event, Event::PoseUndone { face: Some(f), why: Undone::Undo, .. } if f == "+x")
    );
    let Event::NextPose { faces, .. } = &events[1].event else {
        panic!("{events:?}")
    };
    assert_eq!(faces, &["+x", "+y", "-y", "+z"]);
    // Numbers are never used again.
    hand.lay(face("+y"));
    let events = hand.pass(7.0);
    let number = events.iter().find_map(|m| match &m.event {
        Event::PoseAccepted(p) => Some(p.pose),
        _ => None,
    });
    assert_eq!(number, Some(5));
}

/// Noise of so many sizes of `step`, the same for the same row and axis.
fn noise(row: u32, axis: u32, step: f64) -> f64 {
    f64::from((row * 7919 + axis * 131) % 61) * step
}

/// Rows at 100 Hz: time, reading and noise of two decimals of a milli-g.
fn rows(from: u32, count: u32, at: [f64; 3]) -> String {
    let row = |i: u32| {
        let [x, y, z] = [0, 1, 2].map(|k| at[k as usize] + noise(i, k, 1e-3));
        format!("{},{x:.3},{y:.3},{z:.3}\n", 10 * i)
    };
    (from..from + count).map(row).collect()
}

#[test]
fn a_board_that_calibrates_is_refused_with_what_to_do() {
    let mut session = Session::new("recording.csv", LiveOptions::default());
    let board = "# gravical mpu6050_logger 1.1, MPU6050, accelerometer +-2 g, gyroscope +-500 deg/s, low-pass 44 Hz, rate 100.00 Hz, format 3, calibrated 2026-01-01T00:00:00Z";
    let rows: String = (0..300)
        .map(|i| format!("{},0.1,0.2,9.8{}\n", 10 * i, i % 7))
        .collect();
    let text = format!("{board}\nt_ms,ax_mps2,ay_mps2,az_mps2\n{rows}");
    let error = session.bytes(text.as_bytes()).unwrap_err();
    assert_eq!(error.code(), "already-calibrated");
    assert!(error.hint().unwrap().contains("gravical live --format si"));
}

/// A session of rows at 100 Hz, without their time.
fn session_of_rows(columns: &str, rows: impl Iterator<Item = String>) -> (Session, Vec<Message>) {
    let mut session = Session::new("recording.csv", LiveOptions::default());
    let mut text = format!("t_ms,{columns}\n");
    for (i, row) in rows.enumerate() {
        text += &format!("{},{row}\n", 10 * i);
    }
    let events = session.bytes(text.as_bytes()).unwrap();
    (session, events)
}

/// A session that rests on +z for 5 s, turns for a second, and then gives `second` for 5 s: a row
/// of the number since the turn and the reading's noise. `first` is the row on +z.
fn second_hold(
    columns: &str,
    first: impl Fn([f64; 3]) -> String,
    second: impl Fn(u32, [f64; 3]) -> String,
) -> (Session, Vec<Message>) {
    let rows = (0..1100).map(|i| {
        let [x, y, z] = [0, 1, 2].map(|k| noise(i, k, 1e-3));
        let swing = f64::from(i % 9) - 4.0;
        match i {
            0..500 => first([x, y, 9.8 + z]),
            500..600 => first([swing, 5.0 - swing, 5.0 + swing]),
            _ => second(i - 600, [x, y, z]),
        }
    });
    session_of_rows(columns, rows)
}

/// The only rejection: its reason and its words.
fn rejection(events: &[Message]) -> (Rejection, String) {
    let mut all = events.iter().filter_map(|m| match &m.event {
        Event::PoseRejected { reason, .. } => Some((*reason, m.text.clone())),
        _ => None,
    });
    let first = all.next().expect("a rejection");
    assert!(all.next().is_none(), "{events:#?}");
    first
}

fn text([x, y, z]: [f64; 3]) -> String {
    format!("{x:.3},{y:.3},{z:.3}")
}

/// Rests of so many rows at each reading, and a second of motion after each.
fn session_of(parts: &[(u32, [f64; 3])]) -> (Session, Vec<Message>) {
    let mut session = Session::new("recording.csv", LiveOptions::default());
    let mut text = "t_ms,ax,ay,az\n".to_owned();
    let mut at = 0;
    for (count, reading) in parts {
        text += &rows(at, *count, *reading);
        at += count;
        // On the way to the next one.
        for i in 0..100 {
            let swing = f64::from(i % 9) - 4.0;
            text += &rows(at, 1, [swing, 5.0 - swing, 5.0 + swing]);
            at += 1;
        }
    }
    let events = session.bytes(text.as_bytes()).unwrap();
    (session, events)
}

#[test]
fn another_unit_or_scale_is_named() {
    let up = |v: f64| [0.1, 0.2, v];
    let (_, events) = session_of(&[(500, up(9.8)), (500, [0.1, 0.2, -24.0])]);
    assert_eq!(rejections(&events), [Rejection::Units]);
    let (_, events) = session_of(&[(500, up(9.8)), (500, up(-14.5))]);
    assert_eq!(rejections(&events), [Rejection::Scale]);
    // The sketch sends y in place of x: on +y both show gravity, on +x none does. The directions
    // are between faces, which is not what is wrong.
    let parts = [
        (500, [0.2, 0.2, 9.8]),
        (500, [9.8, 9.8, 0.1]),
        (500, [0.2, 0.2, 0.1]),
    ];
    let (_, events) = session_of(&parts);
    assert_eq!(rejections(&events), [Rejection::Scale, Rejection::Units]);
    assert_eq!(accepted(&events), ["+z"]);
}

#[test]
fn an_axis_that_keeps_its_value_is_frozen() {
    let frozen = |[x, _, z]: [f64; 3]| format!("{x:.3},0.213,{z:.3}");
    let on_x = |_, [x, y, z]: [f64; 3]| frozen([9.8 + x, y, z]);
    let (_, events) = second_hold("ax,ay,az", frozen, on_x);
    let (reason, message) = rejection(&events);
    assert_eq!(reason, Rejection::Frozen);
    assert!(message.starts_with("ay keeps one value"), "{message}");
    // A coarse sensor without noise repeats the values of all axes.
    let coarse = |[x, y, z]: [f64; 3]| format!("{x:.1},{y:.1},{z:.1}");
    let on_x = |_, _: [f64; 3]| coarse([9.8, 0.0, 0.0]);
    let first = |[x, y, z]: [f64; 3]| match (9.5..10.0).contains(&z) {
        true => coarse([0.0, 0.0, 9.8]),
        false => coarse([x, y, z]),
    };
    let (_, events) = second_hold("ax,ay,az", first, on_x);
    assert_eq!(accepted(&events), ["+z", "+x"]);
}

#[test]
fn a_value_at_the_end_of_the_range_is_clipped() {
    // 16384 counts are 1 g.
    let counts = |a: [f64; 3]| {
        let [x, y, z] = a.map(|v| (16384.0 / 9.80665 * v).round().clamp(-32768.0, 32767.0));
        format!("{x},{y},{z}")
    };
    let on_x = |_, [x, y, z]: [f64; 3]| counts([25.0 + x, y, z]);
    let (_, events) = second_hold("ax,ay,az", counts, on_x);
    let (reason, message) = rejection(&events);
    assert_eq!(reason, Rejection::Clipped);
    assert!(message.starts_with("ax is at the end"), "{message}");
}

#[test]
fn a_drift_within_a_capture_is_named() {
    // At 2.5 mg each second the noise hides what 2.5 s change; at 6 mg/s it does not.
    let drifting = |mg_s: f64| {
        move |i: u32, [x, y, z]: [f64; 3]| {
            let tilt = 9.80665e-3 * mg_s * 0.01 * f64::from(i);
            text([9.8 + x, y + tilt, z])
        }
    };
    let (_, events) = second_hold("ax,ay,az", text, drifting(2.5));
    assert_eq!(accepted(&events), ["+z", "+x"]);
    let (_, events) = second_hold("ax,ay,az", text, drifting(6.0));
    assert_eq!(accepted(&events), ["+z"]);
    assert!(rejections(&events).iter().all(|r| *r == Rejection::Moved));
    assert!(!rejections(&events).is_empty());
}

#[test]
fn a_steady_turn_about_the_vertical_is_no_pose() {
    // A turntable: gravity stays where it is, and only the gyroscope shows the turn.
    let row = |rate_deg_s: f64, a: [f64; 3]| {
        let n = a.map(|v| (1e6 * v).fract() * 0.1);
        format!(
            "{},{:.3},{:.3},{:.3}",
            text(a),
            rate_deg_s + n[0],
            n[1],
            n[2]
        )
    };
    let columns = "ax_m/s^2,ay_m/s^2,az_m/s^2,gx_dps,gy_dps,gz_dps";
    let turning = |rate_deg_s: f64| {
        let second = move |_, [x, y, z]: [f64; 3]| row(rate_deg_s, [9.8 + x, y, z]);
        second_hold(columns, |a| row(0.5, a), second).1
    };
    let events = turning(6.0);
    assert_eq!(accepted(&events), ["+z"]);
    let (reason, message) = rejection(&events);
    assert_eq!(reason, Rejection::Moved);
    assert!(message.starts_with("It turns steadily"), "{message}");
    assert_eq!(accepted(&turning(4.0)), ["+z", "+x"]);
}

#[test]
fn a_warmer_sensor_is_refused_unless_it_is_wanted() {
    let row = |temperature_c: f64, a: [f64; 3]| format!("{},{temperature_c}", text(a));
    let second = |_, [x, y, z]: [f64; 3]| row(29.5, [9.8 + x, y, z]);
    let columns = "ax,ay,az,temperature";
    let (mut session, events) = second_hold(columns, |a| row(25.0, a), second);
    assert_eq!(accepted(&events), ["+z"]);
    let (reason, message) = rejection(&events);
    assert_eq!(reason, Rejection::Temperature);
    assert!(message.contains("4.5 °C warmer"), "{message}");
    session.command(&Command::Capture);
    let more = (1100..1600).map(|i| {
        let [x, y, z] = [0, 1, 2].map(|k| noise(i, k, 1e-3));
        format!("{},{}\n", 10 * i, row(29.5, [9.8 + x, y, z]))
    });
    let events = session.bytes(more.collect::<String>().as_bytes()).unwrap();
    assert_eq!(accepted(&events), ["+x"]);
}

#[test]
fn a_still_sensor_of_no_known_unit_is_told_so() {
    let (_, events) = session_of(&[(600, [0.1, 0.2, 3.3])]);
    assert_eq!(rejections(&events), [Rejection::Units]);
    assert!(
        !events
            .iter()
            .any(|m| matches!(m.event, Event::Floor { .. }))
    );
}

#[test]
fn what_moves_is_told_which_test_fails() {
    let (mut session, _) = session_of(&[(500, [0.1, 0.2, 9.8])]);
    let shaken = |i: u32| rows(600 + i, 1, [f64::from(i % 9) - 4.0, 5.0, 5.0]);
    let text: String = (0..800).map(shaken).collect();
    let events = session.bytes(text.as_bytes()).unwrap();
    let hints: Vec<(f64, Option<String>)> = events
        .iter()
        .filter_map(|m| match &m.event {
            Event::Status(s) => Some((m.t_s, s.hint.clone())),
            _ => None,
        })
        .collect();
    let first = hints.iter().find(|(_, hint)| hint.is_some()).unwrap();
    // Five seconds after it began to move.
    assert!((9.5..11.5).contains(&first.0), "{first:?}");
    let last = hints.last().unwrap().1.as_ref().unwrap();
    assert!(
        last.starts_with("Still moving: ") && last.contains(" mg, limit "),
        "{last}"
    );
}

#[test]
fn rows_that_stop_lose_the_capture_and_nothing_else() {
    let mut hand = begun();
    hand.lay(face("+x"));
    hand.pass(4.0);
    let events = hand.lost(Loss::Unplugged);
    assert_eq!(rejections(&events), [Rejection::Gaps]);
    let last = events.last().unwrap();
    assert!(matches!(last.event, Event::Lost { poses: 1, .. }));
    assert_eq!(last.text, "Unplugged. 1 pose is safe. Plug it back in.");
    assert!(hand.lost(Loss::Unplugged).is_empty(), "said once");
    let events = hand.resumed();
    assert!(matches!(events[0].event, Event::Resumed { poses: 1, .. }));
    assert_eq!(accepted(&hand.pass(6.0)), ["+x"]);
}

#[test]
fn a_restored_session_goes_on_with_its_poses() {
    let ended = Hand::new(8, Clumsiness::None).run();
    let poses: Vec<_> = ended
        .messages
        .iter()
        .filter_map(|m| match &m.event {
            Event::PoseAccepted(p) => Some(p.clone()),
            _ => None,
        })
        .collect();
    let options = LiveOptions {
        gravity: gravical::gravity::Gravity::given(9.80665).unwrap(),
        ..LiveOptions::default()
    };
    // Without the third: it was undone.
    let mut kept = poses.clone();
    kept.remove(2);
    let mut session = Session::restore("recording.csv", options, kept.clone(), poses.len() as u32);
    let before = session.bytes(ended.text.as_bytes()).unwrap();
    assert_eq!(accepted(&before).len(), kept.len());
    assert!(
        !before
            .iter()
            .any(|m| matches!(m.event, Event::Fit(_) | Event::PoseRejected { .. }))
    );
    let events = session.resumed();
    assert!(matches!(events[0].event, Event::Resumed { .. }));
    assert!(events.iter().any(|m| matches!(m.event, Event::Fit(_))));
    assert_eq!(session.poses().count(), kept.len());
}

#[test]
fn commands_are_typed() {
    let hand = |put: Option<&str>, up, shake| Command::Hand {
        put: put.map(str::to_owned),
        up,
        shake,
    };
    for (text, command) in [
        (" undo ", Command::Undo),
        (
            "redo -y",
            Command::Redo {
                face: "-y".to_owned(),
            },
        ),
        ("take", Command::Capture),
        (
            "port /dev/ttyACM0",
            Command::Port {
                name: "/dev/ttyACM0".to_owned(),
            },
        ),
        ("stop", Command::Finish),
        ("−x", hand(Some("-x"), None, false)),
        ("0.6 0,6 .5", hand(None, Some([0.6, 0.6, 0.5]), false)),
        ("free", hand(None, None, false)),
        ("shake", hand(None, None, true)),
    ] {
        assert_eq!(Command::parse(text).unwrap(), command, "{text}");
    }
    let gravity = Command::parse("latitude 48.1").unwrap();
    let json = serde_json::to_value(&gravity).unwrap();
    assert_eq!(json["command"], "gravity");
    assert_eq!(json["latitude"], 48.1);
    for wrong in ["", "redo", "+w", "gravity much", "1 2"] {
        assert_eq!(
            Command::parse(wrong).unwrap_err().code(),
            "command-unknown",
            "{wrong}"
        );
    }
}

/// Replays a real recording; every steady hold counts.
fn replayed(path: &std::path::Path, capture_s: f64, floor_s: f64) -> (Session, Vec<Message>) {
    let options = LiveOptions {
        any_pose: true,
        capture_s,
        floor_s,
        settle_s: 0.2,
        ..LiveOptions::default()
    };
    let mut session = Session::new("recording", options);
    let mut reader = open::open(path, &ReadOptions::default()).unwrap().reader;
    let mut bytes = Vec::new();
    reader.read_to_end(&mut bytes).unwrap();
    let mut events = session.bytes(&bytes).unwrap();
    events.extend(session.command(&Command::Finish));
    (session, events)
}

#[test]
#[ignore = "slow: long recordings"]
fn poses_of_real_recordings_are_those_that_calibrate_finds() {
    // Holds of 1 s suffice to calibrate; a guided capture takes what is set here.
    let Some(folder) = data() else { return };
    for (file, capture_s) in REAL {
        let path = folder.join(file);
        let (session, _) = replayed(&path, capture_s, capture_s);
        let live: Vec<[f64; 3]> = session.poses().map(|p| p.mean).collect();
        let recording = gravical::recording::read(&path, &ReadOptions::default()).unwrap();
        let done = calibrate(&[recording], &CalibrateOptions::default()).unwrap();
        let found: Vec<[f64; 3]> = done.segmentation.poses.iter().map(|p| p.mean).collect();
        let near = |up: &[f64; 3]| found.iter().any(|f| angle_deg(*f, *up) < 3.0);
        let both = live.iter().filter(|up| near(up)).count();
        println!(
            "{file}: live {}, calibrate {}, near {both}",
            live.len(),
            found.len()
        );
        assert_eq!(
            both,
            live.len(),
            "{file}: a pose that calibrate does not find"
        );
        assert!(
            live.len() * 10 >= found.len() * 8,
            "{file}: {} of {}",
            live.len(),
            found.len()
        );
        let (a, b) = (session.calibration().unwrap(), &done.file);
        let sd =
            |f: &gravical::calibration_file::CalibrationFile| f.accelerometer.deviations.unwrap();
        for i in 0..3 {
            let off = (a.accelerometer.bias[i] - b.accelerometer.bias[i]).abs();
            let allowed = 3.0 * sd(a).bias[i].hypot(sd(b).bias[i]);
            assert!(
                off <= allowed,
                "{file}: bias {i} differs by {off}, allowed {allowed}"
            );
        }
    }
}

#[test]
fn the_poses_of_airbrakes_are_those_that_calibrate_finds() {
    // Six files at 1 kHz, each a rest of 0.7 to 2.3 s that ends when it is lifted: z on a table, x
    // and y held by hand.
    let Some(folder) = data() else { return };
    let folder = folder.join("airbrakes-sixmoves");
    let names = ["zminus", "zplus", "xminus", "xplus", "yminus", "yplus"];
    let texts =
        names.map(|name| std::fs::read_to_string(folder.join(format!("{name}.csv"))).unwrap());
    let guided = |text: &str| {
        let options = LiveOptions {
            any_pose: true,
            floor_s: 0.4,
            settle_s: 0.1,
            capture_s: 0.4,
            ..LiveOptions::default()
        };
        let mut session = Session::new("airbrakes", options);
        let events = session.bytes(text.as_bytes()).unwrap();
        let poses: Vec<[f64; 3]> = session.poses().map(|p| p.mean).collect();
        (accepted(&events), poses, rejections(&events))
    };
    let found = |text: &str| {
        let recording = read_bytes(text.as_bytes(), "airbrakes", &ReadOptions::default()).unwrap();
        let segmentation = segment(&[recording], &SegmentOptions::default());
        segmentation.map(|s| s.poses).unwrap_or_default()
    };
    let faces = ["-z", "+z", "-x", "+x", "-y", "+y"];
    for ((name, face), text) in names.iter().zip(faces).zip(&texts) {
        let (accepted, poses, rejected) = guided(text);
        println!("{name}: accepted {accepted:?}, rejected {rejected:?}");
        let found = found(text);
        // A hand drifts by more than a guided capture allows: then it is rejected, or no rest
        // begins; or the rest is taken in two parts. Never is it another face.
        let by_hand = !name.starts_with('z');
        assert!(found.len() == 1 || by_hand && found.is_empty(), "{name}");
        let is_named = |faces: &[String]| faces.iter().all(|f| f == face);
        assert!(is_named(&accepted), "{name}: {accepted:?}");
        assert!(
            by_hand || (accepted.len() == 1 && rejected.is_empty()),
            "{name}"
        );
        assert!(
            rejected.iter().all(|r| *r == Rejection::Moved),
            "{name}: {rejected:?}"
        );
        for (pose, found) in poses.iter().zip(found.iter().cycle()) {
            let angle = angle_deg(*pose, found.mean);
            assert!(angle < 1.0, "{name}: {angle}°");
        }
    }
    // In the order of their time stamps they are one recording, with gaps. Its noise at rest is
    // that of the table, and a hand moves ten times as much: neither takes x and y for rests.
    let mut whole = texts[0].clone();
    for text in &texts[1..] {
        whole += &text[text.find('\n').unwrap() + 1..];
    }
    let (faces, poses, _) = guided(&whole);
    assert_eq!(faces, ["-z", "+z"]);
    let found = found(&whole);
    assert_eq!(found.len(), poses.len());
    for (pose, found) in poses.iter().zip(&found) {
        assert!(angle_deg(*pose, found.mean) < 0.5);
    }
}

/// Continuous recordings with still poses, and the capture that fits their holds, s.
const REAL: [(&str, f64); 4] = [
    ("imu_tk-xsens/xsens_acc.txt.gz", 1.0),
    ("mikoff-mpu9150/imu0.log", 1.0),
    ("tomisuarez-mpu6050/calibration.csv", 1.0),
    ("imucal-ferraris/example_ferraris_session.csv", 1.0),
];

//! Guided calibration: sessions of simulated sensors, moved by hands that follow what is asked
//! for or do something wrong; replay of real recordings.

use gravical_calibrate::calibrate::{CalibrateOptions, calibrate};
use gravical_calibrate::calibration_file::Grade;
use gravical_calibrate::poses::SegmentOptions;
use gravical_calibrate::poses::face::{Face, angle_deg};
use gravical_calibrate::poses::sections::Section;
use gravical_calibrate::recording::{ReadOptions, read, read_bytes, source};
use gravical_live::event::{Command, Event, Message, Rejection, Tile};
use gravical_live::{LiveOptions, Session};

use super::hand::{Clumsiness, Hand};
use super::support::{data, with_gravity};

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
fn hands_that_follow_reach_a_good_result_that_the_same_rows_confirm() {
    reach_a_good_result(0..2);
}

#[test]
#[ignore = "slow: twelve more sessions"]
fn hands_of_any_clumsiness_reach_a_good_result() {
    reach_a_good_result(2..14);
}

fn reach_a_good_result(sessions: std::ops::Range<u64>) {
    for seed in sessions {
        let clumsiness = Clumsiness::ALL[seed as usize % Clumsiness::ALL.len()];
        let ended = Hand::new(seed, clumsiness).run();
        let file = ended.file.as_ref().expect("a calibration");
        let verdict = &file.verdict();
        assert_eq!(verdict.grade, Grade::Good, "{clumsiness:?}: {verdict:?}");
        let rejected = rejections(&ended.messages);
        let is_wrong = |r: &Rejection| matches!(r, Rejection::Scale | Rejection::Units);
        assert!(!rejected.iter().any(is_wrong), "{clumsiness:?}");
        let [rms, worst] = ended.norm_error_mg().unwrap();
        assert!(rms < 1.5 && worst < 5.0, "{clumsiness:?}: {rms} {worst}");
        assert!(ended.good_s.unwrap() < 180.0, "{clumsiness:?}");
        assert!(ended.count(|e| matches!(e, Event::Verdict { r#final: true, .. })) == 1);
        let all = ended.messages.iter();
        let messages = all.filter(|m| !matches!(m.event, Event::Status(_)));
        for message in messages.chain(&ended.messages[60..61]) {
            let value = serde_json::to_value(message).unwrap();
            let back: Message = serde_json::from_value(value).unwrap();
            assert_eq!(back, *message);
        }
        let text = ended.text.as_bytes();
        let recording = read_bytes(text, "recording.csv", &ReadOptions::default()).unwrap();
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
            ..with_gravity(9.80665)
        };
        let whole = calibrate(&[recording], &options).unwrap().calibration;
        assert_eq!(whole.accelerometer, file.accelerometer, "{clumsiness:?}");
        assert_eq!(whole.gyroscope, file.gyroscope, "{clumsiness:?}");
        assert_eq!(whole.verdict(), file.verdict(), "{clumsiness:?}");
    }
}

/// Holds are judged by time: a slow board is guided as fast as any other.
#[test]
fn a_board_with_five_rows_a_second_is_guided() {
    let ended = Hand::at_rate(1, Clumsiness::None, 5.0).run();
    assert_eq!(rejections(&ended.messages), []);
    let poses = accepted(&ended.messages);
    assert_eq!(poses.iter().filter(|pose| *pose != "free").count(), 6);
    let [rms, worst] = ended.norm_error_mg().unwrap();
    assert!(rms < 1.5 && worst < 5.0, "{rms} {worst}");
}

#[test]
fn a_bump_a_repeat_and_a_lean_are_rejected_and_can_be_taken() {
    let mut hand = begun();
    // A bump where it lies is not worth a word.
    hand.bump();
    assert_eq!(rejections(&hand.pass(6.0)), []);
    hand.lay(face("+x"));
    hand.pass(4.0);
    hand.bump();
    let events = hand.pass(1.5);
    assert_eq!(rejections(&events), [Rejection::Moved], "{events:#?}");
    assert_eq!(accepted(&hand.pass(5.0)), ["+x"]);
    hand.lay(face("+z"));
    let events = hand.pass(7.0);
    assert_eq!(rejections(&events), [Rejection::Duplicate]);
    let status = events.iter().rev().find_map(|m| match &m.event {
        Event::Status(s) => Some(s),
        _ => None,
    });
    let tiles = &status.unwrap().tiles;
    assert_eq!((tiles["+x"], tiles["-x"]), (Tile::Done, Tile::ToDo));
    // Taken all the same.
    hand.command(&Command::Capture);
    assert_eq!(accepted(&hand.pass(4.5)), ["+z"]);
    hand.hold([1.0, 1.0, 0.0]);
    let events = hand.pass(6.0);
    let (reason, text) = rejection(&events);
    assert_eq!(reason, Rejection::BetweenFaces);
    assert!(text.contains("two faces: 4"), "{text}");
    hand.command(&Command::Capture);
    assert_eq!(accepted(&hand.pass(4.5)), ["free"]);
}

#[test]
fn undo_and_redo() {
    let mut hand = begun();
    let put = |hand: &mut Hand, name: &str| {
        hand.lay(face(name));
        hand.pass(7.0)
    };
    assert_eq!(accepted(&put(&mut hand, "-x")), ["-x"]);
    let events = hand.command(&Command::Redo { face: "+z".into() });
    assert!(matches!(events[0].event, Event::PoseUndone { pose: 1, .. }));
    // The other one is up.
    assert_eq!(accepted(&put(&mut hand, "-z")), ["-z"]);
    put(&mut hand, "+x");
    assert_eq!(rejections(&put(&mut hand, "-z")), [Rejection::Duplicate]);
    let events = hand.command(&Command::Undo);
    assert!(matches!(&events[0].event, Event::PoseUndone { face: Some(f), .. } if f == "+x"));
    let Event::NextPose { faces, .. } = &events[1].event else {
        panic!("{events:?}")
    };
    assert_eq!(faces, &["+x", "+y", "-y", "+z"]);
    // Numbers are never used again.
    let events = put(&mut hand, "+y");
    let is_fifth = |m: &Message| matches!(&m.event, Event::PoseAccepted(p) if p.pose == 5);
    assert!(events.iter().any(is_fifth), "{events:?}");
}

/// Noise of so many sizes of `step`, the same for the same row and axis.
fn noise(row: u32, axis: u32, step: f64) -> f64 {
    f64::from((row * 7919 + axis * 131) % 61) * step
}

/// A session of `write` that rests on +z for 5 s, turns for a second, and then rests with `up` along x for 5 s,
/// where y drifts.
fn second_hold(
    columns: &str,
    write: &dyn Fn(bool, [f64; 3]) -> String,
    up: f64,
    drift_mg_s: f64,
) -> (Session, Vec<Message>) {
    let mut session = Session::new("recording.csv", LiveOptions::default());
    let mut text = format!("t_ms,{columns}\n");
    for i in 0..1100 {
        let [x, y, z] = [0, 1, 2].map(|k| noise(i, k, 1e-3));
        let swing = f64::from(i % 9) - 4.0;
        let row = match i {
            0..500 => write(false, [x, y, 9.8 + z]),
            500..600 => write(false, [swing, 5.0 - swing, 5.0 + swing]),
            _ => {
                let drift = 9.80665e-3 * drift_mg_s * 0.01 * f64::from(i - 600);
                write(true, [up + x, y + drift, z])
            }
        };
        text += &format!("{},{row}\n", 10 * i);
    }
    let events = session.bytes(text.as_bytes()).unwrap();
    (session, events)
}

/// The only rejection: its reason and its words.
fn rejection(events: &[Message]) -> (Rejection, String) {
    let [reason] = rejections(events)[..] else {
        panic!("{events:#?}")
    };
    let is_it = |m: &&Message| matches!(m.event, Event::PoseRejected { .. });
    (reason, events.iter().find(is_it).unwrap().text.clone())
}

fn text([x, y, z]: [f64; 3]) -> String {
    format!("{x:.3},{y:.3},{z:.3}")
}

/// Rests of 6 s at each reading, and a second of motion after each.
fn session_of(readings: &[[f64; 3]]) -> Vec<Message> {
    let mut session = Session::new("recording.csv", LiveOptions::default());
    let mut text = "t_ms,ax,ay,az\n".to_owned();
    for i in 0..700 * readings.len() as u32 {
        let swing = f64::from((i % 700 + 3) % 9) - 4.0;
        let reading = match i % 700 {
            0..600 => readings[i as usize / 700],
            _ => [swing, 5.0 - swing, 5.0 + swing],
        };
        let [x, y, z] = [0, 1, 2].map(|k| reading[k as usize] + noise(i, k, 1e-3));
        text += &format!("{},{x:.3},{y:.3},{z:.3}\n", 10 * i);
    }
    session.bytes(text.as_bytes()).unwrap()
}

#[test]
fn another_unit_or_scale_is_named() {
    let still = [0.1, 0.2, 9.8];
    for (readings, rejected) in [
        (&[still, [0.1, 0.2, -24.0]][..], &[Rejection::Units][..]),
        (&[still, [0.1, 0.2, -14.5]], &[Rejection::Scale]),
        // The sketch sends y in place of x: on +y both show gravity, on +x none does. The directions
        // are between faces, which is not what is wrong.
        (
            &[[0.2, 0.2, 9.8], [9.8, 9.8, 0.1], [0.2, 0.2, 0.1]],
            &[Rejection::Scale, Rejection::Units],
        ),
        // A sensor at rest whose unit gravity does not show has no floor either.
        (&[[0.1, 0.2, 3.3]], &[Rejection::Units]),
    ] {
        let events = session_of(readings);
        assert_eq!(rejections(&events), rejected);
        let is_known = readings[0][2] > 9.0;
        assert_eq!(accepted(&events).len(), usize::from(is_known));
        assert_eq!(events.iter().any(|m| m.event == Event::Floor), is_known);
    }
}

#[test]
fn readings_that_a_capture_cannot_use_are_named() {
    type Write<'a> = &'a dyn Fn(bool, [f64; 3]) -> String;
    let frozen: Write<'_> = &|_, [x, _, z]| format!("{x:.3},0.213,{z:.3}");
    // Without noise, the values of all axes repeat.
    let coarse: Write<'_> = &|_, [x, y, z]| match (x > 9.5, z > 9.5) {
        (true, _) => "9.8,0.0,0.0".to_owned(),
        (_, true) => "0.0,0.0,9.8".to_owned(),
        _ => format!("{x:.1},{y:.1},{z:.1}"),
    };
    let counts: Write<'_> = &|_, a| {
        let [x, y, z] = a.map(|v| (16384.0 / 9.80665 * v).round().clamp(-32768.0, 32767.0));
        format!("{x},{y},{z}")
    };
    let plain: Write<'_> = &|_, a| text(a);
    // A turntable: gravity stays where it is, and only the gyroscope shows the turn.
    let turning = |rate_deg_s: f64, a: [f64; 3]| {
        let [x, y, z] = a.map(|v| (1e6 * v).fract() * 0.1);
        format!("{},{:.3},{y:.3},{z:.3}", text(a), rate_deg_s + x)
    };
    let slow: Write<'_> = &|second, a| turning(if second { 4.0 } else { 0.5 }, a);
    let fast: Write<'_> = &|second, a| turning(if second { 6.0 } else { 0.5 }, a);
    let accel = "ax,ay,az";
    let six = "ax_m/s^2,ay_m/s^2,az_m/s^2,gx_dps,gy_dps,gz_dps";
    // As a gyroscope in °/s whose header says rad/s.
    let restless: Write<'_> =
        &|_, a| format!("{},{}", text(a), text(a.map(|v| (1e2 * v + 0.05).fract())));
    let radians = "ax_m/s^2,ay_m/s^2,az_m/s^2,gx_rad_s,gy_rad_s,gz_rad_s";
    // At 2.5 mg each second the noise hides what 2.5 s change.
    for (columns, write, drift_mg_s) in [
        (accel, coarse, 0.0),
        (accel, plain, 2.5),
        (six, slow, 0.0),
        (radians, restless, 0.0),
    ] {
        let (_, events) = second_hold(columns, write, 9.8, drift_mg_s);
        assert_eq!(accepted(&events), ["+z", "+x"]);
    }
    let (_, events) = second_hold(accel, frozen, 9.8, 0.0);
    let is_named = |m: &Message| m.text.starts_with("ay keeps exactly one value");
    assert_eq!(events.iter().filter(|m| is_named(m)).count(), 1);
    for (columns, write, up, reason, words) in [
        (accel, counts, 25.0, Rejection::Clipped, "ax is at the end"),
        (six, fast, 9.8, Rejection::Moved, "It turns steadily"),
    ] {
        let (_, events) = second_hold(columns, write, up, 0.0);
        let (found, message) = rejection(&events);
        assert_eq!(found, reason);
        assert!(message.starts_with(words), "{message}");
    }
    // A drift is rejected as often as it is tried.
    let (_, events) = second_hold(accel, plain, 9.8, 6.0);
    assert_eq!(accepted(&events), ["+z"]);
    let rejected = rejections(&events);
    assert!(!rejected.is_empty() && rejected.iter().all(|r| *r == Rejection::Moved));
}

#[test]
fn a_warmer_sensor_is_refused_unless_it_is_wanted() {
    let write = |second, a| format!("{},{}", text(a), if second { 29.5 } else { 25.0 });
    let (mut session, events) = second_hold("ax,ay,az,temperature", &write, 9.8, 0.0);
    assert_eq!(accepted(&events), ["+z"]);
    let (reason, message) = rejection(&events);
    assert_eq!(reason, Rejection::Temperature);
    assert!(message.contains("4.5 °C warmer"), "{message}");
    session.command(&Command::Capture);
    let more = (1100..1600).map(|i| {
        let [x, y, z] = [0, 1, 2].map(|k| noise(i, k, 1e-3));
        format!("{},{}\n", 10 * i, write(true, [9.8 + x, y, z]))
    });
    let events = session.bytes(more.collect::<String>().as_bytes()).unwrap();
    assert_eq!(accepted(&events), ["+x"]);
}

#[test]
fn commands_are_typed() {
    for (text, json) in [
        (" undo ", r#"{"command":"undo"}"#),
        ("redo -y", r#"{"command":"redo","face":"-y"}"#),
        ("port COM3", r#"{"command":"port","name":"COM3"}"#),
        ("−x", r#"{"command":"hand","put":"-x"}"#),
        ("0.6 0,6 .5", r#"{"command":"hand","up":[0.6,0.6,0.5]}"#),
        ("latitude 48.1", r#"{"command":"gravity","latitude":48.1}"#),
    ] {
        let command: Command = serde_json::from_str(json).unwrap();
        assert_eq!(Command::parse(text).unwrap(), command, "{text}");
    }
    for wrong in ["", "redo", "+w", "gravity much", "1 2"] {
        assert!(Command::parse(wrong).is_err(), "{wrong}");
    }
}

#[test]
#[ignore = "slow: long recordings"]
fn poses_of_real_recordings_are_those_that_calibrate_finds() {
    let Some(folder) = data() else { return };
    for file in [
        "imu_tk-xsens/xsens_acc.txt.gz",
        "mikoff-mpu9150/imu0.log",
        "tomisuarez-mpu6050/calibration.csv",
        "imucal-ferraris/example_ferraris_session.csv",
    ] {
        let path = folder.join(file);
        // Holds of 1 s suffice to calibrate; every one counts.
        let options = LiveOptions {
            any_pose: true,
            capture_s: 1.0,
            floor_s: 1.0,
            settle_s: 0.2,
            ..LiveOptions::default()
        };
        let mut session = Session::new("recording", options);
        let mut bytes = Vec::new();
        let mut input = source::open(&path, &ReadOptions::default()).unwrap();
        input.reader.read_to_end(&mut bytes).unwrap();
        session.bytes(&bytes).unwrap();
        session.command(&Command::Finish);
        let live: Vec<[f64; 3]> = session.poses().map(|p| p.mean).collect();
        let recording = read(&path, &ReadOptions::default()).unwrap();
        let done = calibrate(&[recording], &CalibrateOptions::default()).unwrap();
        let found: Vec<[f64; 3]> = done.segmentation.poses.iter().map(|p| p.mean).collect();
        let near = |up: &[f64; 3]| found.iter().any(|f| angle_deg(*f, *up) < 3.0);
        let both = live.iter().filter(|up| near(up)).count();
        let (live, found) = (live.len(), found.len());
        assert_eq!(both, live, "{file}: a pose that calibrate does not find");
        assert!(live * 10 >= found * 8, "{file}: {live} of {found}");
        let [a, b] = [session.calibration().unwrap(), &done.calibration].map(|f| &f.accelerometer);
        let [sd_a, sd_b] = [a, b].map(|section| section.deviations().unwrap().bias);
        for i in 0..3 {
            let off = (a.bias[i] - b.bias[i]).abs() / sd_a[i].hypot(sd_b[i]);
            assert!(off <= 3.0, "{file}: bias {i}, {off} σ");
        }
    }
}

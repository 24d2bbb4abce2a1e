//! A board that is fast, slow or noisy, a loose cable, a suspended program; the file cannot be written,
//! the terminal is closed, a reader stops reading: what was received is somewhere, and that is said.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use rustix::process::Signal;
use serde_json::{Value, json};

use crate::board::Board;
use crate::logger::{Logger, Terminal, program, run, signal, until};
use crate::recording;

fn rows_of(path: &Path) -> usize {
    let text = fs::read_to_string(path).unwrap_or_default();
    let digits = |line: &&str| line.starts_with(|c: char| c.is_ascii_digit());
    text.lines().filter(digits).count()
}

#[test]
fn a_file_that_is_deleted_or_replaced_is_rescued_and_one_that_is_cut_is_not() {
    for why in ["deleted", "replaced", "cut"] {
        let folder = tempfile::tempdir().unwrap();
        let mut board = Board::new(folder.path());
        let path = folder.path().join("x.csv");
        let mut log = board.log("-o x.csv --json");
        board.greet();
        board.rows(140);
        log.wait_for_rows(140);
        match why {
            "deleted" => fs::remove_file(&path).unwrap(),
            "cut" => fs::write(&path, "").unwrap(),
            _ => {
                fs::write(folder.path().join("y.csv"), "other").unwrap();
                fs::rename(folder.path().join("y.csv"), &path).unwrap();
            }
        }
        // It is said without another row.
        let error = log.refused(1, "io");
        let message = error["message"].as_str().unwrap();
        assert!(message.contains(why), "{message}");
        if why != "cut" {
            assert!(message.contains("x.rescued.csv"), "{message}");
            let rescued = recording(&folder.path().join("x.rescued.csv"));
            assert_eq!(rescued.rows() as u64, board.sent);
        }
        if why == "deleted" {
            // The recording may be beside it: a folder that is calibrated leaves it out, and says so.
            let (code, error) = run(folder.path(), "calibrate . --json");
            let message = error["message"].as_str().unwrap();
            let says = "x.rescued.csv: what `gravical log` rescued";
            assert!(code == 3 && message.contains(says), "{message}");
        }
    }
}

#[test]
fn on_a_full_disk_whole_lines_stay_and_the_error_says_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    let mut full = Command::new("sh");
    // Without the signal a file of more than 8 kB is an error of the write.
    let line = format!(
        "trap '' XFSZ; ulimit -f 16; exec {} log -o x.csv --json --port {}",
        env!("CARGO_BIN_EXE_gravical"),
        board.port()
    );
    full.args(["-c", &line]).current_dir(folder.path());
    let mut log = Logger::start_with(full);
    board.greet();
    for _ in 0..400 {
        if !board.try_row() {
            break;
        }
    }
    let error = log.refused(1, "io");
    let message = error["message"].as_str().unwrap();
    let hint = error["hint"].as_str().unwrap();
    assert!(
        message.starts_with("x.csv: ") && hint.contains("--append"),
        "{error}"
    );
    let path = folder.path().join("x.csv");
    assert!(fs::read_to_string(&path).unwrap().ends_with('\n'));
    let rows = recording(&path).rows();
    assert!(rows > 50, "{rows}");
    board.plug_in();
    let mut log = board.log("-o x.csv --append --rows 50 --json");
    board.say("\n");
    board.rows(50);
    assert_eq!(log.ended().0, 0);
    assert_eq!(recording(&path).rows(), rows + 50);
}

/// All that the terminal takes is in the file, or named.
fn accounts_for_all(folder: &Path, board: &Board, log: &mut Logger) -> Value {
    let (code, ended) = log.ended();
    let count = |key: &str| ended[key].as_u64().unwrap();
    let accounted = count("rows") + count("missing") + count("rejected");
    assert_eq!(accounted, board.sent, "{ended}");
    let is_whole = count("missing") == 0;
    assert_eq!(code, if is_whole { 0 } else { 130 }, "{ended}");
    assert_eq!(rows_of(&folder.join("x.csv")) as u64, count("rows"));
    ended
}

#[test]
fn a_board_that_sends_as_fast_as_it_can_is_recorded_whole_or_in_named_gaps() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    let mut log = board.log("-o x.csv --json");
    board.greet();
    let start = Instant::now();
    while start.elapsed() < Duration::from_secs(1) {
        board.many_rows(1000);
    }
    log.signal(Signal::INT);
    accounts_for_all(folder.path(), &board, &mut log);
}

/// 5000 rows a second, for so long, while all cores are busy.
fn is_recorded_at_5_khz(seconds: u64) {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    let mut log = board.log("-o x.csv --json");
    board.greet();
    let (over, is_over) = (Arc::new(AtomicBool::new(false)), AtomicBool::load);
    for _ in 0..4 {
        let over = Arc::clone(&over);
        std::thread::spawn(move || while !is_over(&over, Ordering::Relaxed) {});
    }
    let start = Instant::now();
    for piece in 0..100 * seconds {
        board.many_rows(50);
        let due = Duration::from_millis(10 * (piece + 1));
        std::thread::sleep(due.saturating_sub(start.elapsed()));
    }
    log.signal(Signal::INT);
    let ended = accounts_for_all(folder.path(), &board, &mut log);
    over.store(true, Ordering::Relaxed);
    assert_eq!(ended["rows"], 5000 * seconds);
}

#[test]
fn five_thousand_rows_a_second_are_recorded_on_a_busy_machine() {
    is_recorded_at_5_khz(2);
}

#[test]
#[ignore = "slow: 20 s"]
fn five_thousand_rows_a_second_are_recorded_for_20_s() {
    is_recorded_at_5_khz(20);
}

fn survives_reconnects(times: u64) {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    let mut log = board.log("-o x.csv --json");
    board.greet();
    board.rows(150);
    log.wait_for_rows(150);
    for n in 1..=times {
        board.unplug();
        log.wait_for("lost");
        board.lose(10);
        board.plug_in();
        log.wait_for("opened");
        // The first line may lack its beginning.
        board.say("\n");
        board.rows(20);
        // What a cable holds when it is pulled is lost.
        until(|| rows_of(&folder.path().join("x.csv")) as u64 == 150 + 20 * n);
    }
    log.signal(Signal::INT);
    let ended = accounts_for_all(folder.path(), &board, &mut log);
    assert_eq!(ended["gaps"], times);
}

#[test]
fn a_loose_cable_is_a_named_gap_each_time() {
    survives_reconnects(3);
}

#[test]
#[ignore = "slow: 50 reconnects"]
fn fifty_reconnects() {
    survives_reconnects(50);
}

#[test]
fn noise_is_rejected_and_never_a_header() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    let mut log = board.log("-o x.csv --json");
    log.wait_for("opened");
    let mut random = 1_u64;
    let mut sent = 0;
    board.say("\n");
    for burst in 0..5 {
        // A board whose columns blanks separate, as blanks are in most noise.
        for i in 0..120 {
            let noise = f64::from(i * 7919 % 61) * 5e-4;
            board.say(&format!(
                "{noise:.3} {:.3} {:.3}\n",
                0.1 - noise,
                9.8 + noise
            ));
            sent += 1;
        }
        if burst < 4 {
            // It begins as a header, which no row fits.
            let mut noise = b"x y z\nax ay az gx gy gz\nt ax ay az\n".to_vec();
            noise.extend((0..3000).map(|_| {
                random = random
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1);
                (random >> 56) as u8
            }));
            noise.push(b'\n');
            board.send(&noise);
        }
    }
    log.wait_for_rows(sent);
    log.signal(Signal::INT);
    let (_, ended) = log.ended();
    assert!(ended["rows"].as_u64().unwrap() >= sent, "{ended}");
    let path = folder.path().join("x.csv");
    let text = fs::read_to_string(&path).unwrap();
    assert!(text.contains("\n# rejected: ax ay az gx gy gz\n"), "{text}");
    assert_eq!(
        recording(&path).rows() as u64,
        ended["rows"].as_u64().unwrap()
    );
}

#[test]
fn a_suspended_program_goes_on_with_what_has_arrived() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    let mut log = board.log("-o x.csv --json");
    board.greet();
    board.rows(150);
    log.wait_for_rows(150);
    log.signal(Signal::STOP);
    board.rows(50);
    std::thread::sleep(Duration::from_secs(4));
    log.signal(Signal::CONT);
    board.rows(50);
    log.signal(Signal::INT);
    let ended = accounts_for_all(folder.path(), &board, &mut log);
    assert_eq!((&ended["gaps"], &ended["rows"]), (&json!(0), &json!(250)));
    assert!(!log.has_seen("silent"));
}

#[test]
fn a_slow_board_is_told_what_to_change() {
    let folders = [(); 2].map(|()| tempfile::tempdir().unwrap());
    let mut boards = folders.each_ref().map(|folder| Board::new(folder.path()));
    let line = format!("live --port {} --folder s --events -", boards[1].port());
    let mut live = Logger::start(folders[1].path(), &line);
    let mut log = boards[0].log("-o x.csv --json");
    log.wait_for("opened");
    live.wait_for("connecting");
    for i in 0..16 {
        let [a, b] = [i * 7 % 5, i * 3 % 4];
        for board in &mut boards {
            board.say(&format!(
                "Acceleration X: 0.1{a}, Y: 0.2{b}, Z: 9.8{a} m/s^2\r\n"
            ));
            board.say(&format!(
                "Rotation X: 0.0{b}, Y: 0.01, Z: 0.0{a} rad/s\r\n\r\n"
            ));
        }
        std::thread::sleep(Duration::from_millis(440));
    }
    for told in [&mut log, &mut live] {
        let warning = told.wait_for("warning");
        let text = warning["text"].as_str().unwrap();
        let is_said = text.contains("board sends 2.") && text.contains("delay(10)");
        assert!(is_said, "{text}");
        told.signal(Signal::INT);
    }
    let (code, ended) = log.ended();
    assert_eq!((code, &ended["rows"]), (0, &json!(16)), "{ended}");
    assert_eq!(live.gone(), Some(130));
}

#[test]
fn closing_the_terminal_ends_the_recording_cleanly() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    let mut terminal = Terminal::new();
    // With a controlling terminal, whose end sends SIGHUP.
    // It counts whether or not the tests themselves outlive their terminal.
    let mut command = Command::new("env");
    let line = format!("log x --json --port {}", board.port());
    let program = [
        "--default-signal=HUP",
        "setsid",
        "--ctty",
        env!("CARGO_BIN_EXE_gravical"),
    ];
    command.args(program.into_iter().chain(line.split(' ')));
    command.current_dir(folder.path());
    let mut log = Logger::start_in(command, &terminal);
    board.greet();
    board.rows(140);
    log.wait_for_rows(140);
    terminal.wait_for(" 140 rows");
    board.one_more();
    drop(terminal);
    assert_eq!(log.ended().0, 0);
    assert_eq!(rows_of(&folder.path().join("x_axis.csv")), 141);
}

#[test]
fn a_reader_who_stops_reading_stops_nothing() {
    let folder = tempfile::tempdir().unwrap();
    // More than a pipe of 64 KiB holds, so that a writer blocks.
    let chatter = format!("# {}\n", "x".repeat(300)).repeat(300);
    for (name, json) in [("x", " --json"), ("y", "")] {
        let mut board = Board::new(folder.path());
        let line = format!("log {name}{json} --port {}", board.port());
        let mut silent = program(folder.path(), &line);
        silent.stdin(Stdio::null()).stdout(Stdio::piped());
        let mut silent = silent.stderr(Stdio::piped()).spawn().unwrap();
        let path = folder.path().join(format!("{name}_axis.csv"));
        board.greet();
        board.rows(150);
        until(|| rows_of(&path) == 150);
        board.say(&chatter);
        board.rows(100);
        until(|| rows_of(&path) == 250);
        signal(&silent, Signal::INT);
        until(|| silent.try_wait().unwrap().is_some());
        assert_eq!(silent.wait().unwrap().code(), Some(0));
        let text = fs::read_to_string(path).unwrap();
        assert_eq!(text.lines().filter(|l| l.starts_with("# xxx")).count(), 300);
    }
}

#[test]
fn the_recording_ends_while_bytes_arrive() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    let mut log = board.log("x --json");
    board.greet();
    let (over, ended) = std::sync::mpsc::channel::<()>();
    let sending = std::thread::spawn(move || {
        while ended.try_recv().is_err() {
            board.try_row();
        }
    });
    log.wait_for_rows(500);
    log.signal(Signal::INT);
    let code = log.gone();
    over.send(()).unwrap();
    sending.join().unwrap();
    assert_eq!(code, Some(0));
    let (_, ended) = log.ended();
    let rows = rows_of(&folder.path().join("x_axis.csv"));
    assert_eq!(ended["rows"], rows);
}

#[test]
fn one_program_writes_to_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    let mut log = board.log("x --append --json");
    log.wait_for("opened");
    // Refused before a port is opened, which would reset the other board.
    let other = "log x --append --json --port /dev/null";
    let error = Logger::start(folder.path(), other).refused(2, "in-use");
    assert!(error["hint"].is_string());
    board.greet();
    board.rows(130);
    log.wait_for_rows(130);
    board.one_more();
    log.signal(Signal::INT);
    assert_eq!(log.ended().0, 0);
    assert_eq!(rows_of(&folder.path().join("x_axis.csv")), 131);
}

/// What is no recording is not continued, and stays as it is.
#[test]
fn another_file_is_not_continued() {
    let folder = tempfile::tempdir().unwrap();
    let board = Board::new(folder.path());
    let path = folder.path().join("x_axis.csv");
    let text = "words\nmore words\nhalf a li";
    fs::write(&path, text).unwrap();
    board.log("x --append --json").refused(3, "no-rows");
    assert_eq!(fs::read_to_string(path).unwrap(), text);
}

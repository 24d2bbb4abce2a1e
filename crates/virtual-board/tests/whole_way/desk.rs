//! Somebody with a board on the desk: hands, a keyboard, and the program.

use std::fs::File;
use std::io::{BufRead as _, BufReader, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::OnceLock;
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use rustix::fs::{Mode, OFlags, open};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use serde_json::Value;

/// What takes longer has failed.
const PATIENCE: Duration = Duration::from_secs(60);

/// The program: `GRAVICAL_BIN`, else built now, because nothing of this crate depends on
/// it.
fn program() -> &'static Path {
    static BUILT: OnceLock<PathBuf> = OnceLock::new();
    BUILT.get_or_init(|| {
        if let Some(given) = std::env::var_os("GRAVICAL_BIN") {
            return given.into();
        }
        let built = Command::new(env!("CARGO"))
            .args(["build", "--locked", "--package", "gravical-cli"])
            .args(["--message-format", "json-render-diagnostics"])
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .stderr(Stdio::inherit())
            .output()
            .unwrap();
        assert!(built.status.success());
        let messages = String::from_utf8(built.stdout).unwrap();
        let path = messages
            .lines()
            .filter_map(|line| serde_json::from_str::<Value>(line).ok())
            .filter(|message| message["target"]["name"] == "gravical")
            .find_map(|message| message["executable"].as_str().map(PathBuf::from));
        path.expect("no program was built")
    })
}

/// Runs the program to its end; what it prints.
pub fn gravical(folder: &Path, words: &[&str]) -> String {
    let done = Command::new(program())
        .args(words)
        .current_dir(folder)
        .output()
        .unwrap();
    let err = String::from_utf8_lossy(&done.stderr);
    assert!(done.status.success(), "{words:?}: {err}");
    String::from_utf8(done.stdout).unwrap()
}

/// Lines of a stream, read in a thread.
fn lines(stream: impl std::io::Read + Send + 'static) -> Receiver<String> {
    let (sender, lines) = channel();
    std::thread::spawn(move || {
        for line in BufReader::new(stream).lines().map_while(Result::ok) {
            if sender.send(line).is_err() {
                break;
            }
        }
    });
    lines
}

/// A board on a desk.
pub struct Desk {
    board: Child,
    hands: ChildStdin,
    says: Receiver<String>,
    port: String,
    folder: PathBuf,
}

impl Desk {
    /// Starts the board in `folder`.
    pub fn new(folder: &Path, firmware: &Path, arguments: &[&str]) -> Self {
        let mut board = Command::new(env!("CARGO_BIN_EXE_virtual-board"))
            .arg("--firmware")
            .arg(firmware)
            .args(arguments)
            .current_dir(folder)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let port = lines(board.stdout.take().unwrap())
            .recv_timeout(PATIENCE)
            .unwrap();
        Desk {
            hands: board.stdin.take().unwrap(),
            says: lines(board.stderr.take().unwrap()),
            board,
            port,
            folder: folder.to_owned(),
        }
    }

    /// Types what hands do; gives the seconds until it rests.
    pub fn begin(&mut self, command: &str) -> f64 {
        writeln!(self.hands, "{command}").unwrap();
        let begins = format!("{command}: rests in ");
        loop {
            let line = self.says.recv_timeout(PATIENCE).unwrap();
            if let Some(rest) = line.strip_prefix(&begins) {
                return rest.strip_suffix(" s").unwrap().parse().unwrap();
            }
        }
    }

    /// The same, and waits until it rests, and a moment more.
    pub fn lay(&mut self, command: &str) {
        let rests_s = self.begin(command);
        std::thread::sleep(Duration::from_secs_f64(rests_s + 1.0));
    }

    /// Starts `gravical log`, with a keyboard.
    pub fn log(&self, words: &str) -> Logger {
        Logger::start(&self.folder, words, &self.port)
    }
}

impl Drop for Desk {
    fn drop(&mut self) {
        let _ = self.board.kill();
        let _ = self.board.wait();
    }
}

/// `gravical log` with somebody at its keyboard.
pub struct Logger {
    child: Child,
    keyboard: File,
    events: Receiver<String>,
}

impl Logger {
    fn start(folder: &Path, words: &str, port: &str) -> Self {
        let keyboard =
            openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).unwrap();
        let keyboard = File::from(keyboard);
        grantpt(&keyboard).unwrap();
        unlockpt(&keyboard).unwrap();
        let name = ptsname(&keyboard, Vec::new()).unwrap();
        let terminal = open(
            name.to_str().unwrap(),
            OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC,
            Mode::empty(),
        )
        .unwrap();
        let mut child = Command::new(program())
            .arg("log")
            .args(words.split_whitespace())
            .args(["--json", "--port", port])
            .current_dir(folder)
            .env("TERM", "xterm")
            .stdin(Stdio::from(terminal.try_clone().unwrap()))
            .stdout(Stdio::piped())
            .stderr(Stdio::from(terminal))
            .spawn()
            .unwrap();
        // What stands on the screen has to be taken from there.
        let mut screen = keyboard.try_clone().unwrap();
        std::thread::spawn(move || std::io::copy(&mut screen, &mut std::io::stderr()));
        Logger {
            events: lines(child.stdout.take().unwrap()),
            child,
            keyboard,
        }
    }

    pub fn press(&mut self, key: &str) {
        self.keyboard.write_all(key.as_bytes()).unwrap();
    }

    pub fn wait_for(&mut self, kind: &str) -> Value {
        self.wait(kind, |event| event["type"] == kind)
    }

    /// So many rows are in the file.
    pub fn wait_for_rows(&mut self, rows: u64) {
        self.wait("rows", |event| {
            event["rows"].as_u64().is_some_and(|n| n >= rows)
        });
    }

    /// As somebody does who watches the status line: it moves, and then lies still for
    /// two looks.
    pub fn wait_until_moved(&mut self) {
        self.wait("a movement", |event| event["still"] == false);
        let mut looks = 0;
        self.wait("rest", |event| {
            if !event["still"].is_null() {
                looks = if event["still"] == true { looks + 1 } else { 0 };
            }
            looks >= 2
        });
    }

    /// It ends well, and at most the end of a line is rejected, as the port may be opened in the
    /// middle of one; its summary.
    pub fn ended(&mut self) -> Value {
        let summary = self.wait_for("ended");
        assert!(self.child.wait().unwrap().success());
        let rejected = &summary["rejected"];
        assert!(*rejected == 0 || *rejected == 1, "{summary}");
        summary
    }

    fn wait(&mut self, what: &str, mut is: impl FnMut(&Value) -> bool) -> Value {
        let start = Instant::now();
        let mut seen = Vec::new();
        loop {
            let left = PATIENCE.saturating_sub(start.elapsed());
            let Ok(line) = self.events.recv_timeout(left) else {
                panic!("waited for {what}; came: {seen:#?}");
            };
            let event: Value = serde_json::from_str(&line).unwrap();
            if is(&event) {
                return event;
            }
            seen.push(line);
        }
    }
}

impl Drop for Logger {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

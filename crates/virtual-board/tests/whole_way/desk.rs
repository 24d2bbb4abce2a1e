//! Somebody with a board on the desk: hands, and the program.

use std::io::{BufRead as _, BufReader, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use serde_json::Value;

/// What takes longer has failed.
const PATIENCE: Duration = Duration::from_secs(60);

/// The program: `GRAVICAL_BIN`, else built now, because nothing of this crate depends on
/// it.
fn program() -> Command {
    if let Some(given) = std::env::var_os("GRAVICAL_BIN") {
        return Command::new(given);
    }
    let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/../gravical-cli/Cargo.toml");
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["run", "--quiet", "--locked", "--manifest-path"]);
    cargo.args([manifest, "--"]);
    cargo
}

/// Runs the program to its end; what it prints.
pub fn gravical(folder: &Path, words: &[&str]) -> String {
    let done = program()
        .args(words)
        .current_dir(folder)
        .stdin(Stdio::null())
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

    /// Types what hands do, and waits until it rests, and a moment more.
    pub fn lay(&mut self, command: &str) {
        writeln!(self.hands, "{command}").unwrap();
        let begins = format!("{command}: rests in ");
        let rests_s: f64 = loop {
            let line = self.says.recv_timeout(PATIENCE).unwrap();
            if let Some(rest) = line.strip_prefix(&begins) {
                break rest.strip_suffix(" s").unwrap().parse().unwrap();
            }
        };
        std::thread::sleep(Duration::from_secs_f64(rests_s + 1.0));
    }

    /// Records so many rows. At most the end of a line is rejected, as the port may be opened in the
    /// middle of one.
    pub fn log(&self, name: &str, rows: u64) {
        let rows_option = rows.to_string();
        let words = [
            "log",
            "-o",
            name,
            "--rows",
            &rows_option,
            "--json",
            "--port",
            &self.port,
        ];
        let events = gravical(&self.folder, &words);
        let mut events = events
            .lines()
            .map(|l| serde_json::from_str::<Value>(l).unwrap());
        let ended = events.find(|e| e["type"] == "ended").unwrap();
        assert_eq!(
            (&ended["rows"], &ended["gaps"]),
            (&rows.into(), &0.into()),
            "{ended}"
        );
        let rejected = ended["rejected"].as_u64().unwrap();
        assert!(rejected <= 1, "{ended}");
    }
}

impl Drop for Desk {
    fn drop(&mut self) {
        let _ = self.board.kill();
        let _ = self.board.wait();
    }
}

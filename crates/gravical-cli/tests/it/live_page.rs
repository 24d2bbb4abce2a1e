//! The page of a guided calibration: who may ask, commands, tabs, a session from the first to the
//! last request.

use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::{Ipv4Addr, TcpStream};
use std::path::Path;
use std::process::{Child, ChildStderr, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::support::{program, words};

/// No wait is longer.
const PATIENCE: Duration = Duration::from_secs(120);

/// A program that serves a page.
struct Served {
    child: Child,
    port: u16,
    token: String,
    /// Its pipe stays open.
    _err: BufReader<ChildStderr>,
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

struct Answer {
    status: u16,
    head: String,
    body: String,
}

impl Answer {
    fn read(mut stream: TcpStream) -> Self {
        // One that is turned away may be reset before it is read.
        let mut bytes = Vec::new();
        let _ = stream.read_to_end(&mut bytes);
        let text = String::from_utf8(bytes).unwrap();
        let (head, body) = text.split_once("\r\n\r\n").unwrap_or((&text, ""));
        let status = head.split(' ').nth(1).and_then(|s| s.parse().ok());
        Answer {
            status: status.unwrap_or(0),
            head: head.to_lowercase(),
            body: body.to_owned(),
        }
    }
}

/// Events of a tab.
struct Tab(BufReader<TcpStream>);

impl Tab {
    /// The next event; none when the stream has ended.
    fn next(&mut self) -> Option<Value> {
        loop {
            let mut line = String::new();
            if self.0.read_line(&mut line).unwrap() == 0 {
                return None;
            }
            if let Some(data) = line.strip_prefix("data: ") {
                return Some(serde_json::from_str(data).unwrap());
            }
        }
    }

    fn until(&mut self, is_it: impl Fn(&Value) -> bool) -> Value {
        let began = Instant::now();
        loop {
            assert!(began.elapsed() < PATIENCE, "the event never came");
            let event = self.next().expect("the stream ended");
            if is_it(&event) {
                return event;
            }
        }
    }

    fn until_type(&mut self, kind: &str) -> Value {
        self.until(|e| e["type"] == kind)
    }
}

impl Served {
    fn start(folder: &Path, options: &str) -> Self {
        Served::start_with(folder, &format!("live --simulate --seed 4 {options}"))
    }

    fn start_with(folder: &Path, command: &str) -> Self {
        let mut child = Command::new(program())
            .args(words(command))
            .current_dir(folder)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut err = BufReader::new(child.stderr.take().unwrap());
        let mut first = String::new();
        err.read_line(&mut first).unwrap();
        let address = first.trim().strip_prefix("http://127.0.0.1:");
        let (port, token) = address
            .and_then(|a| a.split_once("/?token="))
            .expect(&first);
        Served {
            port: port.parse().unwrap(),
            token: token.to_owned(),
            child,
            _err: err,
        }
    }

    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect((Ipv4Addr::LOCALHOST, self.port)).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream
    }

    /// Sends a request as it stands here; HTTP 1.0, so that the answer ends with the connection.
    fn send(&self, method: &str, target: &str, headers: &[String], body: &[u8]) -> TcpStream {
        let mut stream = self.connect();
        let mut head = format!("{method} {target} HTTP/1.0\r\n");
        for header in headers {
            head += &format!("{header}\r\n");
        }
        if !body.is_empty() {
            head += &format!("Content-Length: {}\r\n", body.len());
        }
        // Who is refused may find the connection closed before all is sent.
        let _ = stream.write_all(format!("{head}\r\n").as_bytes());
        let _ = stream.write_all(body);
        stream
    }

    fn ask(&self, method: &str, target: &str, headers: &[String], body: &[u8]) -> Answer {
        Answer::read(self.send(method, target, headers, body))
    }

    fn target(&self, path: &str) -> String {
        format!("{path}?token={}", self.token)
    }

    fn host(&self) -> String {
        format!("Host: 127.0.0.1:{}", self.port)
    }

    fn origin(&self) -> String {
        format!("Origin: http://127.0.0.1:{}", self.port)
    }

    fn get(&self, path: &str) -> Answer {
        self.ask("GET", &self.target(path), &[self.host()], b"")
    }

    fn post(&self, body: &[u8]) -> Answer {
        let headers = [self.host(), self.origin()];
        self.ask("POST", &self.target("/command"), &headers, body)
    }

    fn command(&self, command: &Value) {
        let answer = self.post(command.to_string().as_bytes());
        assert_eq!(answer.status, 204, "{}", answer.body);
    }

    fn tab(&self) -> Tab {
        Tab(BufReader::new(self.send(
            "GET",
            &self.target("/events"),
            &[self.host()],
            b"",
        )))
    }

    fn end(mut self) -> i32 {
        let began = Instant::now();
        loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                return status.code().unwrap();
            }
            assert!(began.elapsed() < PATIENCE, "it does not end");
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

#[test]
fn only_the_page_itself_is_answered() {
    let folder = tempfile::tempdir().unwrap();
    let served = Served::start(folder.path(), "--no-open --folder s");
    let (port, token) = (served.port, &served.token);
    let ours = || vec![served.host()];
    let host = |name: &str| vec![format!("Host: {name}")];
    let with = |origin: &str| vec![served.host(), format!("Origin: {origin}")];
    let page = served.target("/");
    let other_token = format!("/?token={}", "0".repeat(token.len()));
    let cases = [
        ("the page", "GET", page.as_str(), ours(), 200),
        (
            "by name",
            "GET",
            &page,
            host(&format!("localhost:{port}")),
            200,
        ),
        ("no token", "GET", "/", ours(), 403),
        ("another token", "GET", &other_token, ours(), 403),
        ("half a token", "GET", &page[..page.len() - 1], ours(), 403),
        ("no host", "GET", &page, Vec::new(), 403),
        ("no port", "GET", &page, host("127.0.0.1"), 403),
        ("another port", "GET", &page, host("127.0.0.1:1"), 403),
        ("another host", "GET", &page, host("example.org"), 403),
        (
            "a rebound name",
            "GET",
            &page,
            host(&format!("127.0.0.1.example.org:{port}")),
            403,
        ),
        (
            "a name before",
            "GET",
            &page,
            host(&format!("example.org@127.0.0.1:{port}")),
            403,
        ),
        (
            "two hosts",
            "GET",
            &page,
            vec![served.host(), "Host: example.org".to_owned()],
            403,
        ),
        (
            "another page reads",
            "GET",
            &page,
            with("http://example.org"),
            403,
        ),
        ("no page reads", "GET", &page, with("null"), 403),
        (
            "another program of this computer",
            "GET",
            &page,
            with("http://127.0.0.1:1"),
            403,
        ),
        (
            "TLS",
            "GET",
            &page,
            with(&format!("https://127.0.0.1:{port}")),
            403,
        ),
        (
            "a file that is not there",
            "GET",
            &served.target("/main.rs"),
            ours(),
            404,
        ),
        (
            "a file outside",
            "GET",
            &served.target("/..%2f..%2fCargo.toml"),
            ours(),
            404,
        ),
        (
            "a folder outside",
            "GET",
            &served.target("/../../Cargo.toml"),
            ours(),
            404,
        ),
        (
            "no report yet",
            "GET",
            &served.target("/report"),
            ours(),
            404,
        ),
        (
            "a command without its page",
            "POST",
            &served.target("/command"),
            ours(),
            403,
        ),
        (
            "another page commands",
            "POST",
            &served.target("/command"),
            with("http://example.org"),
            403,
        ),
        (
            "a command by reading",
            "GET",
            &served.target("/command"),
            ours(),
            405,
        ),
        ("another method", "DELETE", &page, ours(), 403),
    ];
    let undo = br#"{"command":"undo"}"#;
    for (name, method, target, headers, status) in cases {
        let body: &[u8] = if method == "POST" { undo } else { b"" };
        let answer = served.ask(method, target, &headers, body);
        assert_eq!(answer.status, status, "{name}: {}", answer.body);
        for header in [
            "content-security-policy: default-src 'none'",
            "cross-origin-resource-policy: same-origin",
            "cache-control: no-store",
            "x-content-type-options: nosniff",
        ] {
            assert!(answer.head.contains(header), "{name}: {}", answer.head);
        }
        assert!(!answer.head.contains("access-control"), "{}", answer.head);
        if status != 200 {
            assert!(!answer.body.contains(token.as_str()), "{name}");
        }
    }
    // Every file that the page names is there, and all together are small.
    let html = served.get("/").body;
    let files: Vec<&str> = html
        .split('"')
        .filter_map(|w| w.strip_suffix(&format!("?token={token}")))
        .collect();
    assert!(files.len() > 5, "{html}");
    let sizes = files.iter().map(|file| {
        let answer = served.get(&format!("/{file}"));
        assert_eq!(answer.status, 200, "{file}");
        answer.body.len()
    });
    assert!(html.len() + sizes.sum::<usize>() < 150_000);
    assert!(!html.contains("{token}"));
}

#[test]
fn a_command_that_is_none_is_refused_and_the_session_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let served = Served::start(folder.path(), "--no-open --folder s");
    let mut tab = served.tab();
    tab.until_type("session");
    let long = format!(r#"{{"command":"redo","face":"{}"}}"#, "x".repeat(5000));
    let deep = "[".repeat(4000);
    for (body, status) in [
        ("", 400),
        ("undo", 400),
        ("{\"command\":", 400),
        ("{\"command\":\"rm\"}", 400),
        ("{\"command\":\"redo\"}", 400),
        ("{\"command\":\"hand\",\"up\":[1,2]}", 400),
        ("\u{0}\u{1}", 400),
        (deep.as_str(), 400),
        (long.as_str(), 413),
    ] {
        let answer = served.post(body.as_bytes());
        let start = &body[..body.len().min(40)];
        assert_eq!(answer.status, status, "{start}: {}", answer.body);
        let refusal: Value = serde_json::from_str(&answer.body).expect(start);
        assert!(refusal["error"].is_string(), "{start}");
    }
    assert_eq!(served.post(b"\xff\xfe{}").status, 400);
    // A head that is too long, and one that is none.
    let long = vec![served.host(), format!("X-Long: {}", "x".repeat(100_000))];
    let answer = served.ask("GET", &served.target("/"), &long, b"");
    assert!([0, 400, 431].contains(&answer.status), "{}", answer.head);
    let mut stream = served.connect();
    stream
        .write_all(b"\x16\x03\x01\x02\x00\x01\x00\r\n\r\n")
        .unwrap();
    assert_ne!(Answer::read(stream).status, 200);
    // What cannot be done now is said by an event.
    served.command(&json!({"command": "redo", "face": "up"}));
    let refused = tab.until(|e| e["type"] == "warning" && e["kind"] == "refused");
    assert!(refused["text"].is_string());
    served.command(&json!({"command": "hand", "up": [0, 0, 0]}));
    tab.until(|e| e["type"] == "warning" && e["kind"] == "refused");
    tab.until_type("status");
}

#[test]
#[ignore = "slow: waits for them"]
fn a_thousand_connections_stop_neither_the_session_nor_its_tab() {
    let folder = tempfile::tempdir().unwrap();
    let served = Served::start(folder.path(), "--no-open --folder s");
    let mut tab = served.tab();
    tab.until_type("session");
    for _ in 0..4 {
        // Some send nothing, some half a request.
        let held: Vec<TcpStream> = (0..250)
            .map(|i| {
                let mut stream = served.connect();
                if i % 2 == 0 {
                    let _ = stream.write_all(b"POST /command HTTP/1.1\r\nHost: 127");
                }
                stream
            })
            .collect();
        let before = tab.until_type("status")["t_s"].as_f64().unwrap();
        tab.until(|e| e["type"] == "status" && e["t_s"].as_f64().unwrap() > before + 0.3);
        // Who has the token gets in.
        assert_eq!(served.get("/").status, 200);
        drop(held);
    }
    // Without an end they are closed all the same.
    let mut silent = served.connect();
    assert_eq!(silent.read(&mut [0; 16]).unwrap_or(0), 0);
}

#[test]
fn four_tabs_get_the_session_from_its_beginning() {
    let folder = tempfile::tempdir().unwrap();
    let served = Served::start(folder.path(), "--no-open --folder s --speed 5");
    let mut first = served.tab();
    assert_eq!(first.next().unwrap()["type"], "session");
    first.until_type("floor");
    let mut others: Vec<Tab> = (0..3).map(|_| served.tab()).collect();
    for other in &mut others {
        let kinds: Vec<_> = (0..3)
            .map(|_| other.next().unwrap()["type"].take())
            .collect();
        assert_eq!(kinds, ["session", "identified", "floor"]);
    }
    // A browser would have no connection left for commands: the fifth gets a message, and its stream
    // ends, so that it asks again.
    let mut fifth = served.tab();
    assert_eq!(fifth.next().unwrap()["type"], "full");
    assert_eq!(fifth.next(), None);
    drop(first);
    others[0].until_type("status");
}

#[test]
fn the_port_is_chosen_on_the_page_and_only_ports_can_be() {
    let folder = tempfile::tempdir().unwrap();
    let port = folder.path().join("ttyNone");
    let command = format!("live --no-open --folder s --port {}", port.display());
    let served = Served::start_with(folder.path(), &command);
    let mut tab = served.tab();
    let asked = tab.until_type("ports");
    assert_eq!(asked["tried"], port.to_str().unwrap());
    let message = asked["text"].as_str().unwrap();
    assert!(message.contains("no such port"), "{message}");
    assert!(asked["ports"].is_array());
    // Commands are checked as those of a session, and a file is no port.
    let named = json!({"command": "port", "name": "/etc/hostname"});
    let other_page = [served.host(), "Origin: http://example.org".to_owned()];
    let body = named.to_string().into_bytes();
    let refused = served.ask("POST", &served.target("/command"), &other_page, &body);
    assert_eq!(refused.status, 403);
    assert_eq!(served.post(br#"{"command":"port"}"#).status, 400);
    for command in [named, json!({"command": "undo"})] {
        served.command(&command);
        tab.until(|e| e["type"] == "warning" && e["kind"] == "refused");
    }
    // Tried again: still absent, and no folder was made.
    let again = json!({"command": "port", "name": port.to_str().unwrap()});
    served.command(&again);
    assert_eq!(tab.until_type("ports")["tried"], port.to_str().unwrap());
    assert!(!folder.path().join("s").exists());
    // It appears, and is no serial port: the cause is another one.
    std::fs::write(&port, "").unwrap();
    let other = tab.until(|e| e["type"] == "ports" && e["text"] != message);
    assert_eq!(other["tried"], port.to_str().unwrap());
    let kill = ["-s", "INT", &served.child.id().to_string()];
    assert!(Command::new("kill").args(kill).status().unwrap().success());
    assert_eq!(tab.until_type("end")["reason"], "interrupted");
    assert_eq!(served.end(), 130);
    // Without a page it is an error at once.
    let plain = Command::new(program())
        .args(words("live --plain --folder s --port none/ttyNone"))
        .current_dir(folder.path())
        .stdin(Stdio::null())
        .output()
        .unwrap();
    assert_eq!(plain.status.code(), Some(5));
}

#[test]
fn a_session_is_guided_by_the_page_alone() {
    let folder = tempfile::tempdir().unwrap();
    let served = Served::start(
        folder.path(),
        "--no-open --folder s --speed 10 --gravity 9.80665",
    );
    let mut tab = served.tab();
    tab.until_type("pose_accepted");
    for face in ["+x", "-x", "+y", "-y", "-z"] {
        served.command(&json!({"command": "hand", "put": face}));
        let pose = tab.until_type("pose_accepted");
        assert_eq!(pose["face"], face);
    }
    served.command(&json!({"command": "undo"}));
    assert_eq!(tab.until_type("pose_undone")["face"], "-z");
    served.command(&json!({"command": "hand", "put": "-z"}));
    tab.until_type("pose_accepted");
    // Without a direction it is held as it is asked for.
    tab.until(|e| e["type"] == "next_pose" && e["kind"] == "free");
    served.command(&json!({"command": "hand"}));
    assert_eq!(tab.until_type("pose_accepted")["face"], Value::Null);
    served.command(&json!({"command": "finish"}));
    let saved = tab.until_type("saved");
    assert_eq!(saved["report"], "s/calibration.html");
    let report = served.get("/report");
    assert_eq!(report.status, 200);
    let file = std::fs::read_to_string(folder.path().join("s/calibration.html")).unwrap();
    assert_eq!(report.body, file);
    assert!(
        report
            .head
            .contains("content-security-policy: frame-ancestors 'self'")
    );
    tab.until_type("truth");
    assert_eq!(tab.until_type("end")["reason"], "finished");
    // It stays while the tab is open: the report is still there.
    std::thread::sleep(Duration::from_millis(300));
    assert_eq!(served.get("/report").status, 200);
    drop(tab);
    assert_eq!(served.end(), 0);
}

#[test]
fn an_interrupted_session_says_so_on_the_page() {
    let folder = tempfile::tempdir().unwrap();
    let served = Served::start(folder.path(), "--no-open --folder s");
    let mut tab = served.tab();
    tab.until_type("session");
    let kill = ["-s", "INT", &served.child.id().to_string()];
    assert!(Command::new("kill").args(kill).status().unwrap().success());
    let end = tab.until_type("end");
    assert_eq!(end["reason"], "interrupted");
    assert_eq!(end["resume"], "gravical live --resume s");
    assert_eq!(served.end(), 130);
}

//! The page of a guided calibration: who may ask, and commands that are none. Sessions that a page guides
//! are in `tests/browser`.

use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::{Ipv4Addr, TcpStream};
use std::path::Path;
use std::process::{Child, ChildStderr, Command, Stdio};
use std::time::Duration;

use serde_json::Value;

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

/// What is answered.
struct Answer {
    status: u16,
    head: String,
    body: String,
}

impl Served {
    fn start(folder: &Path) -> Self {
        let mut child = Command::new(program())
            .args(words("live --simulate --seed 4 --no-open --folder s"))
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

    /// Sends a head and a body as they stand here.
    fn send(&self, head: &str, body: &[u8]) -> Answer {
        let mut stream = self.connect();
        // Who is refused may find the connection closed before all is sent, or it is reset before the
        // answer is read.
        let _ = stream.write_all(&[head.as_bytes(), b"\r\n\r\n", body].concat());
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

    /// A request; HTTP 1.0, so that the answer ends with the connection.
    fn ask(&self, method: &str, target: &str, headers: &str, body: &[u8]) -> Answer {
        let mut head = format!("{method} {target} HTTP/1.0");
        for header in headers.split("; ").filter(|header| !header.is_empty()) {
            head += &format!("\r\n{header}");
        }
        if !body.is_empty() {
            head += &format!("\r\nContent-Length: {}", body.len());
        }
        self.send(&head, body)
    }

    fn host(&self) -> String {
        format!("Host: 127.0.0.1:{}", self.port)
    }

    fn get(&self, path: &str) -> Answer {
        let target = format!("{path}?token={}", self.token);
        self.ask("GET", &target, &self.host(), b"")
    }

    fn post(&self, body: &[u8]) -> Answer {
        let target = format!("/command?token={}", self.token);
        let headers = format!("{}; Origin: http://127.0.0.1:{}", self.host(), self.port);
        self.ask("POST", &target, &headers, body)
    }
}

/// Requests: name, method, target, headers, and the status of the answer.
const REQUESTS: &str = "\
the page | GET | /?{token} | {host} | 200
by name | GET | /?{token} | Host: localhost:{port} | 200
no token | GET | / | {host} | 403
another token | GET | /?{zeros} | {host} | 403
half a token | GET | /?{half} | {host} | 403
no host | GET | /?{token} |  | 403
no port | GET | /?{token} | Host: 127.0.0.1 | 403
another port | GET | /?{token} | Host: 127.0.0.1:1 | 403
another host | GET | /?{token} | Host: example.org | 403
a rebound name | GET | /?{token} | Host: 127.0.0.1.example.org:{port} | 403
a name before | GET | /?{token} | Host: example.org@127.0.0.1:{port} | 403
two hosts | GET | /?{token} | {host}; Host: example.org | 403
another page reads | GET | /?{token} | {host}; Origin: http://example.org | 403
no page reads | GET | /?{token} | {host}; Origin: null | 403
another program of this computer | GET | /?{token} | {host}; Origin: http://127.0.0.1:1 | 403
TLS | GET | /?{token} | {host}; Origin: https://127.0.0.1:{port} | 403
a file that is not there | GET | /main.rs?{token} | {host} | 404
a file outside | GET | /..%2f..%2fCargo.toml?{token} | {host} | 404
a folder outside | GET | /../../Cargo.toml?{token} | {host} | 404
no report yet | GET | /report?{token} | {host} | 404
a command without its page | POST | /command?{token} | {host} | 403
another page commands | POST | /command?{token} | {host}; Origin: http://example.org | 403
a command by reading | GET | /command?{token} | {host} | 405
another method | DELETE | /?{token} | {host} | 403";

#[test]
fn only_the_page_itself_is_answered() {
    let folder = tempfile::tempdir().unwrap();
    let served = Served::start(folder.path());
    let token = &served.token;
    let requests = REQUESTS
        .replace("{token}", &format!("token={token}"))
        .replace("{zeros}", &format!("token={}", "0".repeat(token.len())))
        .replace("{half}", &format!("token={}", &token[..token.len() - 1]))
        .replace("{host}", &served.host())
        .replace("{port}", &served.port.to_string());
    let undo = br#"{"command":"undo"}"#;
    for row in requests.lines() {
        let [name, method, target, headers, status] = row.split(" | ").collect::<Vec<_>>()[..]
        else {
            panic!("{row}")
        };
        let body: &[u8] = if method == "POST" { undo } else { b"" };
        let answer = served.ask(method, target, headers, body);
        assert_eq!(answer.status.to_string(), status, "{name}: {}", answer.body);
        for header in [
            "content-security-policy: default-src 'none'",
            "cross-origin-resource-policy: same-origin",
            "cache-control: no-store",
            "x-content-type-options: nosniff",
        ] {
            assert!(answer.head.contains(header), "{name}: {}", answer.head);
        }
        assert!(!answer.head.contains("access-control"), "{}", answer.head);
        if status != "200" {
            assert!(!answer.body.contains(token.as_str()), "{name}");
        }
    }
    // Every file that the page names is there, and all together are small.
    let html = served.get("/").body;
    let files: Vec<&str> = html
        .split('"')
        .filter_map(|w| w.strip_suffix(&format!("?token={token}")))
        .collect();
    assert_eq!(files.len(), 2, "{html}");
    let sizes = files.iter().map(|file| {
        let answer = served.get(&format!("/{file}"));
        assert_eq!(answer.status, 200, "{file}");
        answer.body.len()
    });
    assert!(html.len() + sizes.sum::<usize>() < 150_000);
    assert!(!html.contains("{token}"));
}

#[test]
fn a_command_that_is_none_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let served = Served::start(folder.path());
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
    assert_eq!(served.post(br#"{"command":"undo"}"#).status, 204);
    // A head that is none.
    assert_ne!(served.send("\x16\x03\x01\x02\0\x01\0", b"").status, 200);
}

#[test]
fn held_connections_do_not_stop_the_page() {
    let folder = tempfile::tempdir().unwrap();
    let served = Served::start(folder.path());
    // More than there are places: some send nothing, some half a request.
    let mut held: Vec<TcpStream> = (0..200).map(|_| served.connect()).collect();
    for stream in held.iter_mut().step_by(2) {
        let _ = stream.write_all(b"POST /command HTTP/1.1\r\nHost: 127");
    }
    assert_eq!(served.get("/").status, 200);
    assert_eq!(held[1].read(&mut [0; 16]).unwrap_or(0), 0);
}

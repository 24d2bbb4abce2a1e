//! The page: served to the browser of this computer, and to nobody else.

mod open;

use std::convert::Infallible;
use std::net::{Ipv4Addr, TcpListener};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender};
use std::time::{Duration, Instant};

use futures_util::stream::{Stream, unfold};
use gravical::live::event::{Command, EndReason};
use gravical::live::{Event, Message, sentence};
use gravical::{Error, Result};
use gravical_report::style;
use http_body_util::combinators::UnsyncBoxBody;
use http_body_util::{BodyExt as _, Full, Limited, StreamBody};
use hyper::body::{Bytes, Frame, Incoming};
use hyper::header::HeaderValue;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper::{Method, StatusCode};
use hyper_util::rt::{TokioIo, TokioTimer};
use tempfile::NamedTempFile;
use tokio::sync::{Semaphore, watch};

use crate::text::say;

/// Connections at a time: the session needs files, too.
const CONNECTIONS: usize = 128;
/// A connection has to send its request within this time; it is closed with the answer.
const REQUEST_TIME: Duration = Duration::from_secs(2);
/// The end of the session waits for a tab that is loaded again for this long.
const LOADED_AGAIN: Duration = Duration::from_secs(3);
/// The last event reaches the tabs within this time, or not at all.
const LAST_WORD: Duration = Duration::from_millis(500);
/// A tab that was disconnected connects again after this time.
const RETRY: Duration = Duration::from_millis(500);
/// Time between two signs of life.
const ALIVE: Duration = Duration::from_secs(1);
/// Step of waiting.
const STEP: Duration = Duration::from_millis(50);
/// Longest command, bytes.
const COMMAND_BYTES: usize = 1 << 12;

/// Of every answer.
const HEADERS: [(&str, &str); 4] = [
    ("cache-control", "no-store"),
    ("referrer-policy", "no-referrer"),
    ("x-content-type-options", "nosniff"),
    ("cross-origin-resource-policy", "same-origin"),
];
const POLICY_HEADER: &str = "content-security-policy";
/// Of everything but the report, which has its own in its text.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; \
    connect-src 'self'; img-src 'self' data:; frame-src 'self'; base-uri 'none'; \
    form-action 'none'; frame-ancestors 'none'";
/// The page shows the report in a frame.
const REPORT_POLICY: &str = "frame-ancestors 'self'";

const CSS: &str = "text/css; charset=utf-8";
const HTML: &str = "text/html; charset=utf-8";
const JS: &str = "text/javascript; charset=utf-8";
const EVENTS: &str = "text/event-stream";
const JSON: &str = "application/json";
const TEXT: &str = "text/plain; charset=utf-8";

const REFUSAL: &str = "This answers its own page only: use the address that gravical live printed.";

/// The page; the drawing of the board and its token are put in when it is sent.
const PAGE: &str = include_str!("page/page.html");
/// Below what it shares with reports.
const STYLE: &str = include_str!("page/page.css");
const SCRIPT: &str = concat!(
    "\"use strict\";\n",
    include_str!("page/dom.js"),
    include_str!("page/board.js"),
    include_str!("page/session.js"),
    include_str!("page/markup.js"),
    include_str!("page/sound.js"),
    include_str!("page/http.js"),
    include_str!("page/page.js"),
);

/// Sent to a tab that has no other event: the program is alive.
const SIGN_OF_LIFE: &str = "event: alive\ndata: yes\n\n";

type Request = hyper::Request<Incoming>;
type Response = hyper::Response<UnsyncBoxBody<Bytes, Infallible>>;

/// All events, for each tab to read at its own pace.
#[derive(Default)]
struct EventLog {
    /// All events but the status.
    past: Vec<String>,
    /// The latest status.
    status: Option<String>,
    /// How many there were.
    statuses: usize,
    /// The file of the calibration report.
    report: Option<String>,
    /// The last event is among them.
    has_ended: bool,
    /// A tab has listened.
    had_tab: bool,
    /// There will be no more events.
    is_closed: bool,
}

/// What the session and the requests have in common.
struct Server {
    log: watch::Sender<EventLog>,
    clicked: SyncSender<Command>,
    token: String,
    /// Names of this server in a request: address and port.
    hosts: [String; 2],
}

/// The page of a session.
pub struct Page {
    server: Arc<Server>,
    /// To be opened in the browser with the first event.
    url: Option<String>,
    /// The file that leads the browser to it, kept as long as the page.
    redirect: Option<NamedTempFile>,
}

impl Page {
    /// Serves it, and prints its address. Without `port` a free one is taken. The first event opens it in
    /// the browser of this computer, not over ssh, if it `opens`.
    ///
    /// # Errors
    ///
    /// `http-port` (usage) if the port is not free; those of the system.
    pub fn serve(port: Option<u16>, opens: bool, clicked: SyncSender<Command>) -> Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port.unwrap_or(0)));
        let bound = listener.and_then(|listener| {
            listener.set_nonblocking(true)?;
            let port = listener.local_addr()?.port();
            Ok((listener, port))
        });
        let (listener, port) = bound.map_err(|error| {
            let port = port.map_or(String::new(), |p| format!(" at port {p}"));
            let what = format!("the page cannot be served{port}: {error}");
            let hint = "--http-port with another number, or --plain for the terminal";
            Error::usage("http-port", what).with_hint(hint)
        })?;
        // 128 random bits.
        let mut bits = [0; 16];
        getrandom::fill(&mut bits).map_err(|e| system(std::io::Error::other(e)))?;
        let token: String = bits.iter().map(|b| format!("{b:02x}")).collect();
        let url = format!("http://127.0.0.1:{port}/?token={token}");
        let server = Arc::new(Server {
            log: watch::Sender::default(),
            clicked,
            token,
            hosts: ["127.0.0.1", "localhost"].map(|name| format!("{name}:{port}")),
        });
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .map_err(system)?;
        let served = serve(listener, Arc::clone(&server));
        std::thread::spawn(move || runtime.block_on(served));
        say(&url);
        let tunnel = open::tunnel(port);
        if let Some(line) = &tunnel {
            say(&format!(
                "Over ssh: run `{line}` on your own computer, and open this address there."
            ));
        }
        Ok(Page {
            server,
            url: Some(url).filter(|_| opens && tunnel.is_none()),
            redirect: None,
        })
    }

    /// Shows an event in all tabs.
    pub fn show(&mut self, message: &Message) {
        if let Some(url) = self.url.take() {
            self.redirect = open::open(&url);
        }
        self.say(message);
    }

    fn say(&self, message: &Message) {
        let text = message.to_json();
        self.server.log.send_modify(|log| {
            match &message.event {
                Event::Session { .. } => log.status = None,
                Event::Saved { report, .. } => log.report.clone_from(report),
                Event::End { .. } => log.has_ended = true,
                _ => {}
            }
            if matches!(message.event, Event::Status(_)) {
                log.status = Some(text);
                log.statuses += 1;
            } else {
                log.past.push(text);
            }
        });
    }

    /// Says on the page why there will be no more events, and waits until it is there.
    pub fn fail(&self, why: &str) {
        let has_ended = self.server.log.borrow().has_ended;
        if !has_ended {
            let event = Event::End {
                reason: EndReason::Failed,
                poses: 0,
                resume: None,
            };
            self.say(&Message::new(0.0, event, why));
        }
        self.last_word();
    }

    /// Waits until the tabs have the last event, and disconnects them.
    fn last_word(&self) {
        let began = Instant::now();
        self.server.log.send_modify(|log| log.is_closed = true);
        while self.tabs() > 0 && began.elapsed() < LAST_WORD {
            std::thread::sleep(STEP);
        }
        // From the stream to the browser.
        std::thread::sleep(STEP);
    }

    /// Tabs that listen.
    fn tabs(&self) -> usize {
        self.server.log.receiver_count()
    }

    /// Waits until the last tab is closed, or the user ends it; true if the session is to go on.
    pub fn stay(&self, clicked: &Receiver<Command>, interrupted: &AtomicBool) -> bool {
        let is_on = || !interrupted.load(Ordering::SeqCst);
        let had_tab = self.server.log.borrow().had_tab;
        if had_tab && is_on() {
            say("The page with the report stays until its tab is closed, or Ctrl-C.");
            let mut read = Instant::now();
            while read.elapsed() < LOADED_AGAIN && is_on() {
                if self.tabs() > 0 {
                    read = Instant::now();
                }
                if clicked.recv_timeout(STEP) == Ok(Command::Resume) {
                    self.server.log.send_modify(|log| log.has_ended = false);
                    return true;
                }
            }
        }
        self.last_word();
        false
    }
}

fn system(error: std::io::Error) -> Error {
    Error::device("page", format!("the page cannot be served: {error}"))
        .with_hint("--plain guides in the terminal")
}

/// Answers until the program ends.
async fn serve(listener: TcpListener, server: Arc<Server>) {
    let Ok(listener) = tokio::net::TcpListener::from_std(listener) else {
        return;
    };
    let free = Arc::new(Semaphore::new(CONNECTIONS));
    loop {
        let place = Arc::clone(&free).acquire_owned().await;
        let Ok((stream, _)) = listener.accept().await else {
            // No more files, for example: connections that end give some back.
            tokio::time::sleep(STEP).await;
            continue;
        };
        // An event is sent at once.
        let _ = stream.set_nodelay(true);
        let server = Arc::clone(&server);
        let answers = service_fn(move |request| {
            let server = Arc::clone(&server);
            async move { Ok::<_, Infallible>(server.answer(request).await) }
        });
        let connection = http1::Builder::new()
            .timer(TokioTimer::new())
            .header_read_timeout(REQUEST_TIME)
            .keep_alive(false)
            .serve_connection(TokioIo::new(stream), answers);
        tokio::spawn(async move {
            // A connection that breaks off is no fault of the session.
            let _ = connection.await;
            drop(place);
        });
    }
}

impl Server {
    /// Answers what is from our own page.
    async fn answer(&self, request: Request) -> Response {
        let is_post = request.method() == Method::POST;
        let is_ours = self.is_ours(&request);
        let path = request.uri().path().trim_start_matches('/').to_owned();
        let mut response = match path.as_str() {
            _ if !is_ours => text(StatusCode::FORBIDDEN, TEXT, REFUSAL),
            "" => text(StatusCode::OK, HTML, page(&self.token)),
            "events" => answer(
                StatusCode::OK,
                EVENTS,
                StreamBody::new(self.join()).boxed_unsync(),
            ),
            "command" if is_post => self.command(request.into_body()).await,
            "command" => text(StatusCode::METHOD_NOT_ALLOWED, TEXT, ""),
            "report" => self.report(),
            "page.css" => text(
                StatusCode::OK,
                CSS,
                [style::SHARED, style::BOARD, STYLE].concat(),
            ),
            "page.js" => text(StatusCode::OK, JS, SCRIPT),
            _ => text(StatusCode::NOT_FOUND, TEXT, ""),
        };
        let headers = response.headers_mut();
        for (name, value) in HEADERS {
            headers.insert(name, HeaderValue::from_static(value));
        }
        headers
            .entry(POLICY_HEADER)
            .or_insert(HeaderValue::from_static(POLICY));
        response
    }

    /// Whether a request is from our own page. A page of another site, under whatever name it reaches this
    /// address, knows no token, and its browser names it in `Host` or `Origin`.
    fn is_ours(&self, request: &Request) -> bool {
        let values = |name: &'static str| -> Vec<&str> {
            let all = request.headers().get_all(name).iter();
            all.map(|v| v.to_str().unwrap_or_default()).collect()
        };
        let is_our_host = |host: &str| self.hosts.iter().any(|h| h == host);
        let has_origin = match values("origin")[..] {
            [] => request.method() == Method::GET,
            [origin] => origin.strip_prefix("http://").is_some_and(is_our_host),
            _ => false,
        };
        let query = request.uri().query().unwrap_or_default();
        let given = query.split('&').find_map(|q| q.strip_prefix("token="));
        has_origin
            && matches!(values("host")[..], [host] if is_our_host(host))
            && given.is_some_and(|given| same(given.as_bytes(), self.token.as_bytes()))
    }

    /// The events for a new tab, from the beginning, a line each: all that are new at once, and the status.
    fn join(&self) -> impl Stream<Item = Result<Frame<Bytes>, Infallible>> + use<> {
        let tab = (self.log.subscribe(), [0; 2], false);
        self.log.send_modify(|log| log.had_tab = true);
        unfold(tab, |(mut log, read, is_closed)| async move {
            if is_closed {
                return None;
            }
            let Ok(changed) = tokio::time::timeout(ALIVE, log.changed()).await else {
                let sign = Frame::data(Bytes::from_static(SIGN_OF_LIFE.as_bytes()));
                return Some((Ok(sign), (log, read, is_closed)));
            };
            changed.ok()?;
            let now = log.borrow_and_update();
            let mut lines: Vec<&str> = now.past[read[0]..].iter().map(String::as_str).collect();
            let is_new = now.statuses > read[1];
            lines.extend(now.status.as_deref().filter(|_| is_new));
            let data: String = lines.iter().map(|line| format!("data: {line}\n")).collect();
            let event = format!("retry: {}\n{data}\n", RETRY.as_millis());
            let (read, is_closed) = ([now.past.len(), now.statuses], now.is_closed);
            drop(now);
            Some((Ok(Frame::data(event.into())), (log, read, is_closed)))
        })
    }

    async fn command(&self, body: Incoming) -> Response {
        let refused = |status, why: &str| {
            let body = serde_json::json!({ "error": sentence(why) }).to_string();
            text(status, JSON, body)
        };
        let read = Limited::new(body, COMMAND_BYTES).collect();
        let bytes = match tokio::time::timeout(REQUEST_TIME, read).await {
            Ok(Ok(read)) => read.to_bytes(),
            Ok(Err(_)) => return refused(StatusCode::PAYLOAD_TOO_LARGE, "the command is too long"),
            Err(_) => {
                let why = "the command is sent too slowly";
                return refused(StatusCode::REQUEST_TIMEOUT, why);
            }
        };
        match serde_json::from_slice(&bytes).map(|command| self.clicked.try_send(command)) {
            Ok(Ok(())) => text(StatusCode::NO_CONTENT, TEXT, ""),
            Ok(Err(_)) => {
                let why = "the session is busy, or has ended";
                refused(StatusCode::SERVICE_UNAVAILABLE, why)
            }
            Err(error) => {
                let why = format!("this is no command: {error}");
                refused(StatusCode::BAD_REQUEST, &why)
            }
        }
    }

    fn report(&self) -> Response {
        let report = self.log.borrow().report.clone();
        let Some(html) = report.and_then(|path| std::fs::read_to_string(path).ok()) else {
            let why = "The report is written when the calibration is saved.";
            return text(StatusCode::NOT_FOUND, TEXT, why);
        };
        let mut response = text(StatusCode::OK, HTML, html);
        let policy = HeaderValue::from_static(REPORT_POLICY);
        response.headers_mut().insert(POLICY_HEADER, policy);
        response
    }
}

fn page(token: &str) -> String {
    PAGE.replace("{sheet}", style::SHEET)
        .replace("{scene}", style::SCENE)
        .replace("{token}", token)
}

/// Equal, in a time that does not depend on where they differ.
fn same(a: &[u8], b: &[u8]) -> bool {
    a.len() == b.len() && a.iter().zip(b).fold(0, |d, (x, y)| d | (x ^ y)) == 0
}

fn text(status: StatusCode, kind: &'static str, text: impl Into<Bytes>) -> Response {
    answer(status, kind, Full::new(text.into()).boxed_unsync())
}

fn answer(
    status: StatusCode,
    kind: &'static str,
    body: UnsyncBoxBody<Bytes, Infallible>,
) -> Response {
    let mut response = Response::new(body);
    *response.status_mut() = status;
    response
        .headers_mut()
        .insert("content-type", HeaderValue::from_static(kind));
    response
}

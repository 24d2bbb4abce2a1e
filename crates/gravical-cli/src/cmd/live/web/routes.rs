//! What the page asks for, and who may ask.

use std::sync::Arc;
use std::sync::mpsc::SyncSender;
use std::time::Duration;

use axum::Router;
use axum::body::{Body, to_bytes};
use axum::extract::{Path, Request, State};
use axum::http::header::{
    CACHE_CONTROL, CONTENT_SECURITY_POLICY, CONTENT_TYPE, HOST, HeaderValue, ORIGIN,
    REFERRER_POLICY, X_CONTENT_TYPE_OPTIONS,
};
use axum::http::{HeaderMap, HeaderName, Method, StatusCode};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::sse::{KeepAlive, Sse};
use axum::response::{IntoResponse as _, Response};
use axum::routing::{get, post};
use gravical::live::{Command, sentence};

use super::hub::Hub;
use crate::cmd::live::console::Entry;

/// Longest command, bytes.
const COMMAND_BYTES: usize = 1 << 12;

/// Of everything but the report, which has its own in its text.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; \
    connect-src 'self'; img-src 'self' data:; frame-src 'self'; base-uri 'none'; \
    form-action 'none'; frame-ancestors 'none'";
/// The page shows the report in a frame.
const REPORT_POLICY: &str = "frame-ancestors 'self'";

const CSS: &str = "text/css; charset=utf-8";
const HTML: &str = "text/html; charset=utf-8";
const JS: &str = "text/javascript; charset=utf-8";
const JSON: &str = "application/json";
const TEXT: &str = "text/plain; charset=utf-8";

/// The page; its token is put in when it is sent.
const PAGE: &str = include_str!("../page/page.html");

/// The files that the page is made of.
const FILES: [(&str, &str, &str); 6] = [
    ("page.css", CSS, include_str!("../page/page.css")),
    ("board.js", JS, include_str!("../page/board.js")),
    ("session.js", JS, include_str!("../page/session.js")),
    ("markup.js", JS, include_str!("../page/markup.js")),
    ("sound.js", JS, include_str!("../page/sound.js")),
    ("page.js", JS, include_str!("../page/page.js")),
];

/// What requests need.
#[derive(Clone)]
pub struct Served {
    hub: Arc<Hub>,
    commands: SyncSender<Entry>,
    token: Arc<str>,
    /// Names of this server in a request: address and port.
    hosts: Arc<[String]>,
}

/// All routes, behind the guard.
pub fn routes(served: Served) -> Router {
    Router::new()
        .route("/", get(page))
        .route("/events", get(events))
        .route("/command", post(command))
        .route("/report", get(report))
        .route("/{file}", get(file))
        .fallback(async || StatusCode::NOT_FOUND)
        .layer(from_fn_with_state(served.clone(), guard))
        .with_state(served)
}

/// Refuses what is not from our own page. A page of another site, under whatever name it reaches
/// this address, knows no token, and its browser names it in `Host` or `Origin`.
async fn guard(State(served): State<Served>, request: Request, next: Next) -> Response {
    let mut response = match served.refusal(&request) {
        Some(why) => text(StatusCode::FORBIDDEN, TEXT, why),
        None => next.run(request).await,
    };
    let headers = response.headers_mut();
    for (name, value) in [
        (CACHE_CONTROL, "no-store"),
        (REFERRER_POLICY, "no-referrer"),
        (X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (
            HeaderName::from_static("cross-origin-resource-policy"),
            "same-origin",
        ),
    ] {
        headers.insert(name, HeaderValue::from_static(value));
    }
    headers
        .entry(CONTENT_SECURITY_POLICY)
        .or_insert(HeaderValue::from_static(POLICY));
    response
}

impl Served {
    pub fn new(hub: Arc<Hub>, commands: SyncSender<Entry>, token: String, port: u16) -> Self {
        let names = ["127.0.0.1", "localhost"];
        let mut hosts = names.map(|name| format!("{name}:{port}")).to_vec();
        if port == 80 {
            hosts.extend(names.map(str::to_owned));
        }
        Served {
            hub,
            commands,
            token: token.into(),
            hosts: hosts.into(),
        }
    }

    /// Why a request is refused, if it is.
    fn refusal(&self, request: &Request) -> Option<&'static str> {
        let headers = request.headers();
        let is_ours = |host: &str| self.hosts.iter().any(|h| h == host);
        if !one(headers, &HOST).is_ok_and(|host| host.is_some_and(is_ours)) {
            return Some("This is not the address that gravical live serves.");
        }
        let origin = one(headers, &ORIGIN).map(|o| o.map(|o| o.strip_prefix("http://")));
        match origin {
            Ok(Some(Some(host))) if is_ours(host) => {}
            Ok(None) if request.method() == Method::GET => {}
            _ => return Some("Requests of other pages are refused."),
        }
        let query = request.uri().query().unwrap_or_default();
        let given = query.split('&').find_map(|q| q.strip_prefix("token="));
        match given {
            Some(given) if same(given.as_bytes(), self.token.as_bytes()) => None,
            _ => Some(
                "The token is missing or not of this session: use the address that gravical live printed.",
            ),
        }
    }
}

/// The only value of a header; an error if there are several, or it is no text.
fn one<'a>(headers: &'a HeaderMap, name: &HeaderName) -> Result<Option<&'a str>, ()> {
    let mut all = headers.get_all(name).iter();
    let first = all.next();
    if all.next().is_some() {
        return Err(());
    }
    first.map(|v| v.to_str().map_err(|_| ())).transpose()
}

/// Equal, in a time that does not depend on where they differ.
fn same(a: &[u8], b: &[u8]) -> bool {
    a.len() == b.len() && a.iter().zip(b).fold(0, |d, (x, y)| d | (x ^ y)) == 0
}

fn text(status: StatusCode, kind: &'static str, text: impl Into<Body>) -> Response {
    (status, [(CONTENT_TYPE, kind)], text.into()).into_response()
}

fn refused(status: StatusCode, why: &str) -> Response {
    let body = serde_json::json!({ "error": sentence(why) }).to_string();
    text(status, JSON, body)
}

async fn page(State(served): State<Served>) -> Response {
    text(StatusCode::OK, HTML, PAGE.replace("{token}", &served.token))
}

async fn file(Path(name): Path<String>) -> Response {
    match FILES.iter().find(|(file, _, _)| *file == name) {
        Some((_, kind, content)) => text(StatusCode::OK, kind, *content),
        None => StatusCode::NOT_FOUND.into_response(),
    }
}

async fn events(State(served): State<Served>) -> Response {
    Sse::new(served.hub.join())
        .keep_alive(KeepAlive::new().interval(Duration::from_secs(5)))
        .into_response()
}

async fn command(State(served): State<Served>, body: Body) -> Response {
    let Ok(bytes) = to_bytes(body, COMMAND_BYTES).await else {
        return refused(StatusCode::PAYLOAD_TOO_LARGE, "the command is too long");
    };
    let entry = match serde_json::from_slice::<Command>(&bytes) {
        Ok(command) => Entry {
            command: Ok(command),
            is_clicked: true,
        },
        Err(error) => {
            let why = format!("this is no command: {error}");
            return refused(StatusCode::BAD_REQUEST, &why);
        }
    };
    match served.commands.try_send(entry) {
        Ok(()) => StatusCode::NO_CONTENT.into_response(),
        Err(_) => refused(
            StatusCode::SERVICE_UNAVAILABLE,
            "the session is busy, or has ended",
        ),
    }
}

async fn report(State(served): State<Served>) -> Response {
    let report = served.hub.0.borrow().report.clone();
    let Some(html) = report.and_then(|path| std::fs::read_to_string(path).ok()) else {
        return text(
            StatusCode::NOT_FOUND,
            TEXT,
            "The report is written when the calibration is saved.",
        );
    };
    let policy = [(CONTENT_SECURITY_POLICY, REPORT_POLICY)];
    (policy, text(StatusCode::OK, HTML, html)).into_response()
}

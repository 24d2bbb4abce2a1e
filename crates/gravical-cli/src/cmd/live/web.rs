//! The page: served to the browser of this computer, and to nobody else.

mod hub;
mod open;
mod routes;

use std::net::{Ipv4Addr, TcpListener};
use std::sync::mpsc::SyncSender;
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use axum::{Extension, Router};
use gravical::live::event::{Command, EndReason};
use gravical::live::{Event, Message, sentences};
use gravical::{Error, Result};
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::task::AbortHandle;

use super::console::{Console, Entry, Renderer};
use crate::text::say;

use hub::Hub;
use routes::{Known, Served, routes};

/// Connections at a time. For one more the oldest goes that has not shown the token; without such, the
/// new one.
const CONNECTIONS: usize = 128;
/// A connection has to send its request within this time.
const REQUEST_TIME: Duration = Duration::from_secs(5);
/// Longest head of a request, bytes.
const HEAD_BYTES: usize = 1 << 14;
/// The end of the session waits for a tab that is loaded again for this long.
const LOADED_AGAIN: Duration = Duration::from_secs(3);
/// The last event reaches the tabs within this time, or not at all.
const LAST_WORD: Duration = Duration::from_millis(500);
/// Step of waiting.
const STEP: Duration = Duration::from_millis(50);

/// The page of a session.
pub struct Page {
    hub: Arc<Hub>,
    url: String,
    port: u16,
    /// The file that leads the browser to it, kept as long as the page.
    redirect: OnceLock<Option<open::Redirect>>,
}

impl Page {
    /// Serves it, and prints its address. Without `port` a free one is taken.
    ///
    /// # Errors
    ///
    /// `http-port` (usage) if the port is not free; those of the system.
    pub fn serve(port: Option<u16>, commands: SyncSender<Entry>) -> Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port.unwrap_or(0)));
        let bound = listener.and_then(|listener| {
            listener.set_nonblocking(true)?;
            let port = listener.local_addr()?.port();
            Ok((listener, port))
        });
        let (listener, port) = bound.map_err(|error| {
            let port = port.map_or(String::new(), |p| format!(" at port {p}"));
            Error::usage(
                "http-port",
                format!("the page cannot be served{port}: {error}"),
            )
            .with_hint("--http-port with another number, or --plain for the terminal")
        })?;
        let token = token()?;
        let url = format!("http://127.0.0.1:{port}/?token={token}");
        let names = ["127.0.0.1", "localhost"];
        let mut hosts: Vec<String> = names.map(|name| format!("{name}:{port}")).to_vec();
        if port == 80 {
            hosts.extend(names.map(str::to_owned));
        }
        let hub = Arc::new(Hub::default());
        let app = routes(Served {
            hub: Arc::clone(&hub),
            commands,
            token: token.into(),
            hosts: hosts.into(),
        });
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .map_err(system)?;
        std::thread::spawn(move || runtime.block_on(answer(listener, app)));
        say(&url);
        if let Some(line) = open::tunnel(port) {
            say(&format!(
                "Over ssh: run `{line}` on your own computer, and open this address there."
            ));
        }
        Ok(Page {
            hub,
            url,
            port,
            redirect: OnceLock::new(),
        })
    }

    /// Opens it in the browser of this computer, once; not over ssh.
    pub fn open(&self) {
        self.redirect.get_or_init(|| match open::tunnel(self.port) {
            None => open::open(&self.url),
            Some(_) => None,
        });
    }

    /// What shows events on it.
    pub fn renderer(&self) -> Box<dyn Renderer> {
        Box::new(Arc::clone(&self.hub))
    }

    /// Says on the page why there will be no more events, and waits until it is there.
    pub fn fail(&self, why: &str) {
        if !self.hub.has_ended() {
            let event = Event::End {
                reason: EndReason::Failed,
                poses: 0,
                resume: None,
            };
            let message = Message::new(0.0, event, sentences([why]));
            let _ = Arc::clone(&self.hub).show(&message);
        }
        self.last_word();
    }

    /// Waits until the tabs have the last event, and disconnects them.
    pub fn last_word(&self) {
        let began = Instant::now();
        while !self.hub.is_read() && began.elapsed() < LAST_WORD {
            std::thread::sleep(STEP);
        }
        self.hub.close();
        // From the queue to the browser.
        std::thread::sleep(STEP);
    }

    /// Waits until the last tab is closed; true if the session is to go on.
    pub fn stay(&self, console: &Console) -> bool {
        if self.hub.is_left_for(LOADED_AGAIN) {
            return false;
        }
        say("The page with the report stays until its tab is closed, or Ctrl-C.");
        while !self.hub.is_left_for(LOADED_AGAIN) && !console.is_interrupted() {
            if let Ok(Entry::Clicked(Command::Resume)) = console.entries.recv_timeout(STEP) {
                return true;
            }
        }
        self.last_word();
        false
    }
}

/// 128 random bits.
fn token() -> Result<String> {
    let mut bytes = [0; 16];
    getrandom::fill(&mut bytes).map_err(|e| system(std::io::Error::other(e)))?;
    Ok(bytes.iter().map(|b| format!("{b:02x}")).collect())
}

fn system(error: std::io::Error) -> Error {
    Error::device("page", format!("the page cannot be served: {error}"))
        .with_hint("--plain guides in the terminal")
}

/// Answers until the program ends.
async fn answer(listener: TcpListener, app: Router) {
    let Ok(listener) = tokio::net::TcpListener::from_std(listener) else {
        return;
    };
    let mut open: Vec<(AbortHandle, Known)> = Vec::new();
    loop {
        let Ok((stream, _)) = listener.accept().await else {
            // No more files, for example: connections that end give some back.
            tokio::time::sleep(STEP).await;
            continue;
        };
        open.retain(|(task, _)| !task.is_finished());
        if open.len() >= CONNECTIONS {
            let Some(stranger) = open.iter().position(|(_, known)| !known.is()) else {
                continue;
            };
            open.remove(stranger).0.abort();
        }
        // An event is sent at once.
        let _ = stream.set_nodelay(true);
        let known = Known::default();
        let service = TowerToHyperService::new(app.clone().layer(Extension(known.clone())));
        let task = tokio::spawn(async move {
            // A connection that breaks off is no fault of the session.
            let _ = http1::Builder::new()
                .timer(TokioTimer::new())
                .header_read_timeout(REQUEST_TIME)
                .max_buf_size(HEAD_BYTES)
                // A browser has six for a host: those of files are not kept for later.
                .keep_alive(false)
                .serve_connection(TokioIo::new(stream), service)
                .await;
        });
        open.push((task.abort_handle(), known));
    }
}

//! The page: served to the browser of this computer, and to nobody else.

mod hub;
mod open;
mod routes;

use std::net::{Ipv4Addr, TcpListener};
use std::sync::Arc;
use std::sync::mpsc::SyncSender;
use std::time::{Duration, Instant};

use axum::Router;
use gravical::live::event::{Command, EndReason};
use gravical::live::{Event, Message};
use gravical::{Error, Result};
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tempfile::NamedTempFile;
use tokio::sync::Semaphore;

use super::console::{Console, Entry, Renderer};
use crate::text::say;

use hub::Hub;
use routes::{Served, routes};

/// Connections at a time: the session needs files, too.
const CONNECTIONS: usize = 128;
/// A connection has to send its request within this time; it is closed with the answer.
const REQUEST_TIME: Duration = Duration::from_secs(2);
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
    /// The command of the tunnel, over ssh.
    tunnel: Option<String>,
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
            let what = format!("the page cannot be served{port}: {error}");
            let hint = "--http-port with another number, or --plain for the terminal";
            Error::usage("http-port", what).with_hint(hint)
        })?;
        let token = token()?;
        let url = format!("http://127.0.0.1:{port}/?token={token}");
        let hub = Arc::new(Hub::default());
        let app = routes(Served::new(Arc::clone(&hub), commands, token, port));
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .map_err(system)?;
        std::thread::spawn(move || runtime.block_on(answer(listener, app)));
        say(&url);
        let tunnel = open::tunnel(port);
        if let Some(line) = &tunnel {
            say(&format!(
                "Over ssh: run `{line}` on your own computer, and open this address there."
            ));
        }
        Ok(Page { hub, url, tunnel })
    }

    /// What shows events on it. The first one opens it in the browser of this computer, not over ssh,
    /// if it `opens`.
    pub fn renderer(&self, opens: bool) -> Box<dyn Renderer> {
        Box::new(PageEvents {
            hub: Arc::clone(&self.hub),
            url: Some(self.url.clone()).filter(|_| opens && self.tunnel.is_none()),
            redirect: None,
        })
    }

    /// Says on the page why there will be no more events, and waits until it is there.
    pub fn fail(&self, why: &str) {
        if !self.hub.0.borrow().has_ended {
            let event = Event::End {
                reason: EndReason::Failed,
                poses: 0,
                resume: None,
            };
            self.hub.say(&Message::new(0.0, event, why));
        }
        self.last_word();
    }

    /// Waits until the tabs have the last event, and disconnects them.
    fn last_word(&self) {
        let began = Instant::now();
        self.hub.close();
        while self.hub.tabs() > 0 && began.elapsed() < LAST_WORD {
            std::thread::sleep(STEP);
        }
        // From the stream to the browser.
        std::thread::sleep(STEP);
    }

    /// Waits until the last tab is closed, or the user ends it; true if the session is to go on.
    pub fn stay(&self, console: &Console) -> bool {
        if self.hub.0.borrow().had_tab && !console.is_interrupted() {
            say("The page with the report stays until its tab is closed, or Ctrl-C.");
            let mut read = Instant::now();
            while read.elapsed() < LOADED_AGAIN && !console.is_interrupted() {
                if self.hub.tabs() > 0 {
                    read = Instant::now();
                }
                let entry = console.entries.recv_timeout(STEP);
                if entry.is_ok_and(|entry| entry.command == Ok(Command::Resume)) {
                    self.hub.0.send_modify(|said| said.has_ended = false);
                    return true;
                }
            }
        }
        self.last_word();
        false
    }
}

/// Shows events on the page.
struct PageEvents {
    hub: Arc<Hub>,
    /// To be opened.
    url: Option<String>,
    /// The file that leads the browser to it, kept as long as the page.
    redirect: Option<NamedTempFile>,
}

impl Renderer for PageEvents {
    fn show(&mut self, message: &Message) -> Result<()> {
        if let Some(url) = self.url.take() {
            self.redirect = open::open(&url);
        }
        self.hub.say(message);
        Ok(())
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
        let connection = http1::Builder::new()
            .timer(TokioTimer::new())
            .header_read_timeout(REQUEST_TIME)
            .keep_alive(false)
            .serve_connection(TokioIo::new(stream), TowerToHyperService::new(app.clone()));
        tokio::spawn(async move {
            // A connection that breaks off is no fault of the session.
            let _ = connection.await;
            drop(place);
        });
    }
}

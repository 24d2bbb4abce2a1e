//! The port to record from.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use super::Args;
use super::reporter::Reporter;
use crate::device::event::Event;
use crate::device::ports::{Port, Target, list, the_board};

/// Time between two searches for a port, s.
pub const LOOK_FOR_S: f64 = 0.3;

/// The port to record from; none when the user ended the waiting.
pub fn target(
    args: &Args,
    ports: &[Port],
    reporter: &mut Reporter,
    interrupted: &AtomicBool,
) -> gravical::Result<Option<Target>> {
    if let Some(name) = &args.board.port {
        return Ok(Some(Target::new(name, ports)));
    }
    let mut found = the_board(ports);
    let mut reported = false;
    while args.board.wait && found.as_ref().is_err_and(|e| e.code() == "no-port") {
        if !std::mem::replace(&mut reported, true) {
            reporter.report(&Event::Waiting {
                text: "a board to be plugged in".to_owned(),
            });
        }
        if interrupted.load(Ordering::SeqCst) {
            return Ok(None);
        }
        std::thread::sleep(Duration::from_secs_f64(LOOK_FOR_S));
        let ports = list().unwrap_or_default();
        found = the_board(&ports);
        if let Ok(port) = &found {
            return Ok(Some(Target::new(&port.name, &ports)));
        }
    }
    found.map(|port| Some(Target::new(&port.name, ports)))
}

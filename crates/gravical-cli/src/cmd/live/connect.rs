//! The way to a board when it is not clear which port it is, or the port cannot be opened: the
//! user chooses, on the page or in the terminal.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::Receiver;
use std::time::Duration;

use gravical::Error;
use gravical::live::event::{Command, EndReason, PortInfo, WarningKind};
use gravical::live::{EVENTS_VERSION, Event, Message};

use super::driver::{Entry, Renderer};
use crate::device::ports::{Port, list, the_board};
use crate::device::trouble::holders;

/// Time between two looks at the ports.
const LOOK: Duration = Duration::from_millis(300);
/// What the user wants is asked for so many times between two looks.
const ASKED: u32 = 6;

/// True where another port, or the same a moment later, may be the remedy.
pub fn can_choose(error: &Error) -> bool {
    let codes = [
        "no-port",
        "several-ports",
        "no-such-port",
        "port-busy",
        "port-failed",
        "port-permission",
    ];
    codes.contains(&error.code())
}

/// What it needs to ask.
pub struct Asking<'a> {
    pub renderers: &'a mut Vec<Box<dyn Renderer>>,
    pub entries: &'a Receiver<Entry>,
    pub interrupted: &'a AtomicBool,
}

impl Asking<'_> {
    /// The port that the user chooses after `error`; none after Ctrl-C. `tried`: the one that
    /// could not be opened. What is waited for and plugged in is taken without a question.
    pub fn port(&mut self, error: &Error, tried: Option<&str>) -> Option<String> {
        let mut shown = None;
        while !self.interrupted.load(Ordering::SeqCst) {
            let ports = list().unwrap_or_default();
            if let Some(name) = arrived(error, tried, &ports) {
                return Some(name);
            }
            let infos: Vec<PortInfo> = ports.into_iter().map(described).collect();
            if shown.as_ref() != Some(&infos) {
                self.show(Event::Ports {
                    ports: infos.clone(),
                    tried: tried.map(str::to_owned),
                    message: error.message().to_owned(),
                    remedy: Some(remedy(error)),
                });
                shown = Some(infos);
            }
            let known = shown.as_deref().unwrap_or_default();
            for _ in 0..ASKED {
                if let Some(name) = self.chosen(known, tried) {
                    return Some(name);
                }
                std::thread::sleep(LOOK / ASKED);
            }
        }
        self.show(Event::End {
            reason: EndReason::Interrupted,
            poses: 0,
            resume: None,
            message: "interrupted before a port was open".to_owned(),
        });
        None
    }

    /// What the user chose since the last call. Only ports of this computer can be chosen, or
    /// the one that was given when the program was started.
    fn chosen(&mut self, ports: &[PortInfo], tried: Option<&str>) -> Option<String> {
        while let Ok(entry) = self.entries.try_recv() {
            let command = match entry {
                Entry::Typed(Ok(command)) => command,
                Entry::Typed(Err(text)) => {
                    self.renderers.iter_mut().for_each(|r| r.answer(&text));
                    continue;
                }
                #[cfg(feature = "live")]
                Entry::Clicked(command) => command,
            };
            let message = match command {
                Command::Port { name }
                    if tried == Some(name.as_str()) || ports.iter().any(|p| p.name == name) =>
                {
                    return Some(name);
                }
                Command::Port { name } => format!("{name} is no port of this computer"),
                _ => "no port is open yet: choose one first".to_owned(),
            };
            self.show(Event::Warning {
                kind: WarningKind::Refused,
                message,
            });
        }
        None
    }

    fn show(&mut self, event: Event) {
        let message = Message {
            v: EVENTS_VERSION,
            t_s: 0.0,
            event,
        };
        self.renderers.iter_mut().for_each(|r| r.show(&message));
    }
}

/// The port that was waited for, if it is there now.
fn arrived(error: &Error, tried: Option<&str>, ports: &[Port]) -> Option<String> {
    match (error.code(), tried) {
        ("no-port", _) => the_board(ports).ok().map(|port| port.name),
        ("no-such-port", Some(name)) => {
            let is_there = ports.iter().any(|p| p.name == name) || Path::new(name).exists();
            is_there.then(|| name.to_owned())
        }
        _ => None,
    }
}

/// The remedy where the port is chosen while the program runs.
fn remedy(error: &Error) -> String {
    match error.code() {
        "no-port" => {
            "plug it in: it is opened when it is there. Some USB cables only charge; any other port can be chosen"
                .to_owned()
        }
        "no-such-port" => {
            "plug it in: it is opened when it is there; or choose another one".to_owned()
        }
        "several-ports" => "choose the one of your board".to_owned(),
        _ => error.hint().unwrap_or("choose another one").to_owned(),
    }
}

fn described(port: Port) -> PortInfo {
    PortInfo {
        open_in: holders(&port.name),
        usb: port
            .usb
            .as_ref()
            .map(|usb| format!("{:04x}:{:04x}", usb.vid, usb.pid)),
        serial: port.usb.and_then(|usb| usb.serial),
        name: port.name,
        device: port.device,
        board: port.board,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::ports::Usb;
    use std::sync::mpsc::sync_channel;

    fn board(name: &str) -> Port {
        Port {
            name: name.to_owned(),
            device: Some("Arduino Uno".to_owned()),
            usb: Some(Usb {
                vid: 0x2341,
                pid: 0x43,
                serial: None,
            }),
            board: true,
        }
    }

    #[test]
    fn what_was_waited_for_is_taken() {
        let none = Error::device("no-port", "");
        assert_eq!(arrived(&none, None, &[]), None);
        let one = [board("/dev/none1")];
        assert_eq!(arrived(&none, None, &one).as_deref(), Some("/dev/none1"));
        // Two at once are a question.
        let two = [board("/dev/none1"), board("/dev/none2")];
        assert_eq!(arrived(&none, None, &two), None);
        let missing = Error::device("no-such-port", "");
        let is = |name, ports: &[Port]| arrived(&missing, Some(name), ports);
        assert_eq!(is("/dev/none2", &one), None);
        assert_eq!(is("/dev/none2", &two).as_deref(), Some("/dev/none2"));
        // One that is busy is not tried again and again.
        let busy = Error::device("port-busy", "");
        assert_eq!(arrived(&busy, Some("/dev/none1"), &one), None);
    }

    struct Seen(std::sync::mpsc::Sender<Event>);

    impl Renderer for Seen {
        fn show(&mut self, message: &Message) {
            let _ = self.0.send(message.event.clone());
        }
    }

    #[test]
    fn only_ports_that_are_there_can_be_chosen() {
        let (sender, entries) = sync_channel(8);
        let (to, seen) = std::sync::mpsc::channel();
        let mut renderers: Vec<Box<dyn Renderer>> = vec![Box::new(Seen(to))];
        let mut asking = Asking {
            renderers: &mut renderers,
            entries: &entries,
            interrupted: &AtomicBool::new(false),
        };
        let known = [described(board("/dev/none1"))];
        assert_eq!(known[0].usb.as_deref(), Some("2341:0043"));
        let mut ask = |name: &str, tried| {
            let name = name.to_owned();
            sender
                .send(Entry::Typed(Ok(Command::Port { name })))
                .unwrap();
            asking.chosen(&known, tried)
        };
        assert_eq!(ask("/dev/none1", None).as_deref(), Some("/dev/none1"));
        assert_eq!(
            ask("/dev/none7", Some("/dev/none7")).as_deref(),
            Some("/dev/none7")
        );
        for name in ["/etc/passwd", "", "/dev/none", "/dev/none1\n"] {
            assert_eq!(ask(name, None), None, "{name:?}");
            let Ok(Event::Warning { kind, .. }) = seen.try_recv() else {
                panic!("{name:?} was not refused")
            };
            assert_eq!(kind, WarningKind::Refused);
        }
        sender.send(Entry::Typed(Ok(Command::Undo))).unwrap();
        assert_eq!(asking.chosen(&known, None), None);
        assert!(matches!(seen.try_recv(), Ok(Event::Warning { .. })));
    }
}

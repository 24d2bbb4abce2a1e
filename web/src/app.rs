//! One call: what is asked for, done, and answered.

use gravical::Result;
use gravical::finding::Advice;
use gravical::utc::UtcTime;
use serde_json::json;

use crate::live::Live;
use crate::message::{Message, answer};
use crate::verbs;

/// What lives between two calls.
#[derive(Default)]
pub struct App {
    live: Option<Live>,
}

impl App {
    /// Does what a message asks for; an error is an answer, too.
    pub fn call(&mut self, bytes: &[u8]) -> Vec<u8> {
        let asked = Message::parse(bytes);
        if let Some(now) = asked.number("utc_s") {
            UtcTime::tell(now);
        }
        match self.done(&asked) {
            Ok(answer) => answer,
            Err(e) => {
                // Options are data, too: the page offers what helps.
                let options = e.options().iter();
                let options = options.map(|o| json!({ "name": o.name, "value": o.value }));
                let in_words = |o: &Advice| match &*o.value {
                    "" => format!("“{}”", o.name.replace('_', " ")),
                    value => format!("“{}: {value}”", o.name.replace('_', " ")),
                };
                let error = json!({
                    "code": e.code(), "message": e.worded(in_words), "hint": e.worded_hint(in_words),
                    "options": options.collect::<Vec<_>>(),
                });
                answer(json!({ "error": error }), &[])
            }
        }
    }
    fn done(&mut self, asked: &Message<'_>) -> Result<Vec<u8>> {
        match (asked.verb(), &mut self.live) {
            ("open", _) => {
                let (live, answer) = Live::open(asked)?;
                self.live = Some(live);
                Ok(answer)
            }
            ("tick" | "bytes" | "overflow" | "command" | "opened" | "lost", Some(live)) => {
                live.call(asked)
            }
            _ => verbs::run(asked).map(|(head, files)| answer(head, &files)),
        }
    }
}

//! gravical in the browser.
//!
//! One function of JavaScript, `call`: a JSON object and files in, a JSON object and files out ([`message`]). [`verbs`]
//! are the commands of the program on files in memory. Nothing here has a clock or does I/O: the page tells the time,
//! and keeps what is written.

mod abi;
mod message;
mod verbs;

use gravical::finding::Advice;
use gravical::utc::UtcTime;
use serde_json::json;

use message::{Message, answer};

/// What lives between two calls.
#[derive(Default)]
pub struct App {}

impl App {
    /// Does what a message asks for; an error is an answer, too.
    pub fn call(&mut self, bytes: &[u8]) -> Vec<u8> {
        let asked = Message::parse(bytes);
        if let Some(now) = asked.number("utc_s") {
            UtcTime::tell(now);
        }
        match verbs::run(&asked) {
            Ok((head, files)) => answer(head, &files),
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
}

//! gravical in the browser.
//!
//! One function of JavaScript, `call`: a JSON object and files in, a JSON object and files out (`message`). `verbs` are the
//! commands of the program on files in memory, `live` is a guided session. Nothing here has a clock or does I/O: the page
//! tells the time, and keeps what is written.

mod abi;
mod app;
mod live;
mod message;
mod verbs;

pub use app::App;

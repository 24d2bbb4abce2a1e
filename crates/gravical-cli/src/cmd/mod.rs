//! One file a verb: `Args` and `run`.

pub mod apply;
pub mod calibrate;
pub mod check;
pub mod compare;
pub mod completions;
pub mod demo;
pub mod denoise;
pub mod export;
pub mod inspect;
pub mod log;
pub mod man;
pub mod motion;
pub mod ports;
pub mod simulate;

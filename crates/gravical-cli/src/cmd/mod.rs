//! One file per command, with its `Args` and `run`.

pub mod apply;
pub mod calibrate;
pub mod check;
pub mod compare;
pub mod completions;
pub mod convert;
pub mod demo;
pub mod denoise;
pub mod export;
pub mod inspect;
pub mod live;
pub mod log;
pub mod motion;
pub mod noise;
pub mod orient;
pub mod ports;
pub mod simulate;

use std::process::ExitCode;

use crate::{Verb, program};

impl Verb {
    /// Runs the command.
    ///
    /// # Errors
    ///
    /// Those of the command.
    pub fn run(&self) -> anyhow::Result<ExitCode> {
        match self {
            Verb::Inspect(args) => inspect::run(args),
            Verb::Calibrate(args) => calibrate::run(args),
            Verb::Apply(args) => apply::run(args),
            Verb::Convert(args) => convert::run(args),
            Verb::Denoise(args) => denoise::run(args),
            Verb::Motion(args) => motion::run(args),
            Verb::Orient(args) => orient::run(args),
            Verb::Noise(args) => noise::run(args),
            Verb::Demo(args) => demo::run(args),
            Verb::Check(args) => check::run(args),
            Verb::Compare(args) => compare::run(args),
            Verb::Export(args) => export::run(args),
            Verb::Live(args) => live::run(args),
            Verb::Log(args) => log::run(args),
            Verb::Ports(args) => ports::run(args),
            Verb::Simulate(args) => simulate::run(args),
            Verb::Completions(args) => completions::run(args, program()),
        }
    }
}

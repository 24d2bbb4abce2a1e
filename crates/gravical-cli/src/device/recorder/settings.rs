//! The settings of the board: asked for, sent, and restored after a reset.

use gravical::Error;

use super::messages::columns_changed;
use super::run::Run;
use super::start::Setup;
use super::{Action, Recorder, State};
use crate::device::board::{Settings, Wanted};
use crate::device::event::Event;
use crate::device::gap::Cause;

impl Recorder {
    fn goal(&self) -> Wanted {
        self.state.run().map_or(self.options.wanted, Run::goal)
    }

    /// The board reported its settings.
    pub(super) fn settings_are(&mut self, now_s: f64, settings: Settings) {
        let met = self.goal().is_met_by(&settings);
        if let Some(run) = self.state.run_mut() {
            run.sent_settings = true;
            run.is_set(&settings);
        }
        match &mut self.state {
            State::Starting(start) if met => start.setup.settled(),
            State::Restoring(..) if met => self.state.change(State::Storing),
            State::Storing(run) if !met => {
                run.open_gap(now_s, Cause::Settings);
                self.restore(Setup::default());
            }
            _ => {}
        }
        if !met && self.state.setup_mut().is_some_and(|setup| setup.tries == 0) {
            self.command(now_s);
        }
    }

    /// Rows are not stored until the board is set as before.
    pub(super) fn restore(&mut self, setup: Setup) {
        self.state.change(|run| State::Restoring(run, setup));
    }

    /// Asks the board for its settings.
    pub(super) fn ask(&mut self, now_s: f64) {
        if let Some(setup) = self.state.setup_mut() {
            setup.ask(now_s);
            self.actions.push(Action::Send(b"?\n".to_vec()));
        }
    }

    /// Sends the settings that are wanted.
    fn command(&mut self, now_s: f64) {
        let goal = self.goal();
        if let Some(setup) = self.state.setup_mut() {
            setup.command(now_s);
        }
        let commands = goal.commands();
        let text = String::from_utf8_lossy(&commands).trim().replace('\n', " ");
        self.report(Event::Commands { text });
        self.actions.push(Action::Send(commands));
    }

    /// Asks or sets the board until it is as wanted, or gives up.
    pub(super) fn set_up(&mut self, now_s: f64) {
        let starting = matches!(self.state, State::Starting(_));
        // It has other settings than wanted; it has sent nothing valid.
        let (mut unmet, mut silent) = (true, false);
        if let State::Starting(start) = &self.state {
            let wanted = &self.options.wanted;
            unmet = !(start.settings())
                .map_or(wanted.is_empty(), |settings| wanted.is_met_by(settings));
            silent = start.settings().is_none() && start.held.is_empty();
            if !unmet || silent {
                self.start_without_header(now_s);
            }
        }
        // At a wrong baud rate the board does not understand commands either.
        let unsure = !self.wire.understood;
        let Some(setup) = self.state.setup_mut().filter(|setup| setup.is_due(now_s)) else {
            return;
        };
        if unmet && setup.is_refused(now_s, !starting) {
            let error = match setup.other_header.take() {
                Some(columns) => columns_changed(&columns),
                None => settings_refused(self.settings().is_some()),
            };
            self.fail(error);
        } else if unmet && !silent && !unsure {
            self.command(now_s);
        } else {
            self.ask(now_s);
        }
    }
}

fn settings_refused(reports: bool) -> Error {
    Error::device(
        "settings-refused",
        if reports {
            "the board does not take the settings: it reports others after the commands"
        } else {
            "the board does not report its settings: it is not known whether it took them"
        },
    )
    .with_hint("upload firmware/mpu6050_logger to the board, or leave the settings out")
}

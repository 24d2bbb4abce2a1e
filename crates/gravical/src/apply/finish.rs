//! After the last line: what was held back, what is odd, what is no recording.

use std::io::Write;
use std::path::Path;

use super::drift::TemperatureOutcome;
use super::judge::all_zero_error;
use super::stream::{Sink, Stream};
use crate::recording::open::Input;
use crate::recording::timing::Treatment;
use crate::recording::{Aside, Finding, Ledger, cut_off, text_findings};
use crate::{Error, Result};

/// What is left when the last line is written.
pub(crate) struct Done<S> {
    pub sink: S,
    pub ledger: Ledger,
    pub temperature: Option<TemperatureOutcome>,
    pub without_acceleration: u64,
    pub told: Told,
}

/// What is odd.
#[derive(Default)]
pub(crate) struct Told {
    /// About the lines.
    pub reading: Vec<Finding>,
    /// About stamps, empty cells and rows that were held back.
    pub cells: Vec<Finding>,
    /// About the values.
    pub values: Vec<Finding>,
    /// Rows of zeros at the end were too many to be held back.
    pub given_up: bool,
}

impl Told {
    /// All of it, in order.
    pub fn all(self) -> impl Iterator<Item = Finding> {
        let parts = [self.reading, self.cells, self.values];
        parts.into_iter().flatten()
    }
}

impl<S: Sink> Stream<'_, S> {
    /// Books what was held back, and says what is odd.
    ///
    /// # Errors
    ///
    /// As [`Stream::run`].
    pub(super) fn finish(
        mut self,
        input: &Input,
        name: &str,
        out: &mut dyn Write,
    ) -> Result<Done<S>> {
        self.settle_parts(f64::NAN);
        let mut told = Told {
            given_up: !self.tail.given_up.is_empty(),
            ..Told::default()
        };
        if input.is_cut_off() {
            told.reading.push(cut_off(self.ledger.rows));
        }
        self.refuse_unusable(name)?;
        // A single row of zeros can be a measurement.
        if self.tail.rows.len() < 2 {
            self.release();
        } else {
            let lines = self.tail.rows.iter().map(|(line, _)| *line);
            self.ledger.move_rows_aside(Aside::ZeroTail, lines);
            self.sink.rewind();
        }
        self.hand_on(out)?;
        out.flush().map_err(|e| Error::io(Path::new("output"), e))?;

        told.reading.extend(self.ledger.findings());
        told.reading.extend(text_findings(
            &self.nul_lines,
            &self.foreign_lines,
            &input.unpacked,
        ));
        self.tell_of_cells(&mut told.cells);
        self.watch.finish(&mut told.values);
        Ok(Done {
            sink: self.sink,
            temperature: self
                .sensor
                .drift
                .as_ref()
                .map(|d| d.finish(&mut told.values)),
            ledger: self.ledger,
            without_acceleration: self.empty[0].count(),
            told,
        })
    }

    fn tell_of_cells(&self, findings: &mut Vec<Finding>) {
        if !self.tail.given_up.is_empty() {
            findings.push(
                Finding::warning(
                    "zero-tail",
                    format!(
                        "all channels are zero in the last {} rows: too many to hold back, so they were written as data",
                        self.tail.given_up.count()
                    ),
                )
                .at_lines(&self.tail.given_up),
            );
        }
        if let Some(stamps) = &self.stamps {
            stamps.report(Treatment::Kept, findings);
        }
        for (spans, name) in self.empty.iter().zip(["accelerometer", "gyroscope"]) {
            if !spans.is_empty() {
                findings.push(
                    Finding::warning(
                        "empty-cells",
                        format!(
                            "{} rows lack a value of the {name}; its calibrated cells are empty there",
                            spans.count()
                        ),
                    )
                    .at_lines(spans),
                );
            }
        }
        for (held, name) in self.held.iter().zip(["accelerometer", "gyroscope"]) {
            if *held {
                findings.push(Finding::warning(
                    "empty-cells",
                    format!(
                        "each channel of the {name} is written when it arrives; the last value of the others is held"
                    ),
                ));
            }
        }
    }

    fn refuse_unusable(&self, name: &str) -> Result<()> {
        let rows = self.ledger.rows;
        if rows == 0 {
            let message = format!("no row could be read: {}", self.ledger.sum());
            return Err(Error::input("no-rows", message).at(Path::new(name), None));
        }
        if self.empty[0].count() == rows {
            return Err(Error::input(
                "no-values",
                format!("none of the {rows} rows has all three values of the accelerometer"),
            )
            .at(Path::new(name), None)
            .with_hint(
                "look at the columns with `gravical inspect`, or choose others with --columns",
            ));
        }
        if !self.any_movement {
            return Err(all_zero_error(rows, name));
        }
        Ok(())
    }
}

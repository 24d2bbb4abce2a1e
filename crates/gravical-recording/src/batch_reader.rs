//! A recording of any size: judged by its first rows, read batch by batch.

use std::collections::VecDeque;
use std::path::Path;

use crate::bytes::Input;
use crate::error::Result;
use crate::finding::Finding;
use crate::foreign::in_file;
use crate::later::Later;
use crate::options::ReadOptions;
use crate::read::{Batches, note_input, open_batches};
use crate::readings::Readings;
use crate::recording::Recording;
use crate::text::{Batch, CopiedText, Format};

/// Rows of a recording, with the text of the columns that are copied.
pub struct Rows {
    /// Text of the columns that are copied
    pub text: CopiedText,
    /// Line of each row, from 1
    pub lines: Vec<u32>,
    /// Channels, times and breaks as they are read
    pub readings: Readings,
    /// Stamps as they are written, if one column holds them, of a recording that is judged by its
    /// head
    pub stamps: Option<Vec<f64>>,
}

/// A recording that is read batch by batch.
pub struct BatchReader {
    /// What the first rows are judged to be; its channels go with the first rows.
    pub recording: Recording,
    /// How its lines become rows
    pub format: Format,
    /// The only column of time stamps, unless the recording is judged as a whole.
    stamps: Option<usize>,
    /// Rows by which it was judged; those that are measurements are the rows of the recording.
    held: VecDeque<Rows>,
    /// Their channels, once the first rows are taken.
    head: Option<Readings>,
    batches: Batches,
    later: Later,
    input: Input,
}

impl BatchReader {
    /// Batches by which a recording is judged: 262,144 rows.
    pub const HEAD: usize = 16;
    /// The recording is judged, and held, as a whole: its channels may be changed before the first
    /// rows are taken.
    pub const WHOLE: usize = usize::MAX;

    /// Opens a recording and judges its first batches, [`HEAD`](Self::HEAD) or
    /// [`WHOLE`](Self::WHOLE). `copied` says which columns keep their text; `name` is used in
    /// messages.
    ///
    /// # Errors
    ///
    /// As [`read_samples`](crate::read_samples).
    pub fn open(
        mut input: Input,
        name: &str,
        options: &ReadOptions,
        judged: usize,
        copied: impl FnOnce(&Format) -> Vec<(usize, usize)>,
    ) -> Result<Self> {
        let (format, mut batches) = open_batches(&mut input, name, options, copied)?;
        let here = Path::new(name);
        let (mut head, mut held) = (Batch::new(format.columns.len()), VecDeque::new());
        let stamps = format.only_clock().filter(|_| judged == Self::HEAD);
        while held.len() < judged
            && let Some(batch) = batches.next()
        {
            let mut batch = batch.map_err(|e| in_file(e, here))?;
            held.push_back(Rows {
                text: std::mem::take(&mut batch.text),
                lines: batch.lines.clone(),
                readings: Readings::default(),
                stamps: stamps.map(|c| batch.columns[c].clone()),
            });
            head.append(batch);
            head.check_size().map_err(|e| in_file(e, here))?;
        }
        let (recording, later) = Later::judge(&format, head).map_err(|e| in_file(e, here))?;
        Ok(BatchReader {
            recording: recording.with_name(name),
            format,
            stamps,
            held,
            head: None,
            batches,
            later,
            input,
        })
    }

    /// The next rows; `None` after the last.
    ///
    /// # Errors
    ///
    /// Errors of reading; rows that contradict those before them, with their line.
    pub fn next_rows(&mut self) -> Result<Option<Rows>> {
        if let Some(mut rows) = self.held.pop_front() {
            let recording = &mut self.recording;
            let head = self.head.get_or_insert_with(|| recording.take_readings());
            rows.readings = head.in_lines(&recording.lines, &rows.lines);
            if self.held.is_empty() {
                self.head = None;
            }
            return Ok(Some(rows));
        }
        let Some(batch) = self.batches.next() else {
            return Ok(None);
        };
        let here = Path::new(&self.recording.name);
        let mut batch = batch.map_err(|e| in_file(e, here))?;
        let readings = self.later.read(&mut batch);
        let readings = readings.map_err(|e| e.in_file(here))?;
        Ok(Some(Rows {
            stamps: self.stamps.map(|c| std::mem::take(&mut batch.columns[c])),
            text: batch.text,
            lines: batch.lines,
            readings,
        }))
    }

    /// The recording with the account of all lines, and what was found beside the first rows; to be
    /// called after the last row. `only_measured`: rows that are no measurements are set aside.
    pub fn finish(mut self, only_measured: bool) -> (Recording, Vec<Finding>) {
        let (later_ledger, later_findings) = self.later.finish();
        let ledger = &mut self.recording.ledger;
        ledger.append(later_ledger);
        if !only_measured {
            ledger.reasons.retain(|reason, _| !reason.is_of_row());
        }
        let cut_off = note_input(&mut self.recording, &self.input);
        let findings = cut_off.into_iter().chain(later_findings).collect();
        (self.recording, findings)
    }
}

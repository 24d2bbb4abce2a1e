//! What the rows of the recording show: while it grows, and of the file at the end, as `inspect`.

use std::collections::HashSet;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

use gravical::Result;
use gravical::inspect::{Inspection, inspect};
use gravical::poses::face::AxisMap;
use gravical::recording::following::Following;
use gravical::recording::{AccelScale, Finding, ReadOptions, Severity, read};

use super::reporter::Reporter;

/// Time after which it is said that the file is being read.
const PATIENCE: Duration = Duration::from_secs(1);
/// Time between two looks at the flag of the user.
const LOOK: Duration = Duration::from_millis(20);

/// The last rows are judged: so many of them at least.
const ROWS: usize = 10_000;

/// The rows that were written, read by the ordinary reader.
pub struct Content {
    /// None once it turned out that the rows are not those of an accelerometer.
    rows: Option<Following>,
    accel_scale: Option<AccelScale>,
    /// Findings that were returned: their kinds, and their messages without numbers.
    said: HashSet<String>,
}

impl Content {
    /// Of a file with this name, which begins with `head` if it is continued.
    pub fn new(name: &str, head: &[u8]) -> Self {
        let mut content = Content {
            rows: Some(Following::new(name, &ReadOptions::default(), ROWS)),
            accel_scale: None,
            said: HashSet::new(),
        };
        content.observe(head);
        content
    }

    /// Reads the next bytes of the file.
    pub fn observe(&mut self, bytes: &[u8]) {
        if let Some(rows) = &mut self.rows
            && rows.push(bytes).is_err()
        {
            // The end of the recording gives the error of the file.
            self.rows = None;
        }
    }

    /// The unit of the accelerometer, once it is known.
    pub fn accel_scale(&self) -> Option<AccelScale> {
        self.accel_scale
    }

    /// Judges the last rows and returns what may spoil the samples, and was not returned before.
    pub fn new_findings(&mut self) -> Vec<Finding> {
        let judged = self.rows.as_ref().and_then(|rows| rows.recording(u32::MAX));
        let Some(Ok(recording)) = judged else {
            return Vec::new();
        };
        self.accel_scale = Some(recording.accel_scale);
        let mut findings = recording.findings;
        findings.retain(|finding| {
            if finding.severity != Severity::Warning || !finding.kind.is_of_samples() {
                return false;
            }
            let words = finding.message.replace(|c: char| c.is_ascii_digit(), "");
            self.said.insert(format!("{} {words}", finding.kind.name()))
        });
        findings
    }
}

/// What `gravical inspect` says of the file; none if the user does not want to wait for it: a long
/// file takes a while.
///
/// # Errors
///
/// Those of reading.
pub fn inspected(
    path: &Path,
    reporter: &mut Reporter,
    interrupted: &AtomicBool,
) -> Result<Option<Inspection>> {
    let (sender, result) = channel();
    let file = path.to_owned();
    thread::spawn(move || {
        let recording = read(&file, &ReadOptions::default());
        // Without a receiver nobody waits.
        let _ = sender.send(recording.map(|recording| inspect(&recording, &AxisMap::default())));
    });
    let begun = Instant::now();
    let mut is_said = false;
    loop {
        match result.recv_timeout(LOOK) {
            Ok(inspection) => return inspection.map(Some),
            Err(RecvTimeoutError::Timeout) if !interrupted.load(Ordering::SeqCst) => {}
            Err(_) => return Ok(None),
        }
        if begun.elapsed() >= PATIENCE && !std::mem::replace(&mut is_said, true) {
            reporter.progress("all rows are safe; reading them for the summary (Ctrl-C skips it)");
        }
    }
}

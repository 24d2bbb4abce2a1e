//! A recording as another table: `apply` and `denoise` read it alike and write it alike.

use std::io::Write;
use std::num::NonZero;
use std::path::Path;
use std::sync::mpsc::sync_channel;
use std::thread;

use gravical_recording::write::{Table, Writer};
use gravical_recording::{Piece, Stream};

use crate::recording::Recording;
use crate::{Error, Result};

/// Pieces that are read ahead of those that are written.
const READ_AHEAD: usize = 2;

/// Writes the rows of `stream` as `table`, whose columns of values `columns` makes of each piece; the
/// next pieces are read meanwhile. Returns the recording and the number of rows.
///
/// # Errors
///
/// Those of reading and of writing.
pub(crate) fn write_rows(
    mut stream: Stream,
    out: &mut dyn Write,
    table: Table,
    mut columns: impl FnMut(&mut Piece) -> Vec<Vec<f64>>,
) -> Result<(Recording, usize)> {
    let output = |e| Error::io(Path::new("output"), e);
    let mut writer = Writer::new(out, table);
    let mut written = 0;
    let mut write = |piece: Result<Piece>| {
        let mut piece = piece?;
        let values = columns(&mut piece);
        let values: Vec<&[f64]> = values.iter().map(Vec::as_slice).collect();
        let rows = 0..piece.lines.len();
        written += rows.len();
        writer
            .write_rows(rows, &piece.text, &values, &piece.breaks)
            .map_err(output)
    };
    // A browser has no threads.
    if thread::available_parallelism().map_or(1, NonZero::get) == 1 {
        while let Some(piece) = stream.next_piece().transpose() {
            write(piece)?;
        }
    } else {
        let (send, pieces) = sync_channel(READ_AHEAD);
        let (back, done) = thread::scope(|scope| {
            let reading = scope.spawn(move || {
                // Nobody receives any longer once writing has failed.
                while let Some(piece) = stream.next_piece().transpose() {
                    let is_last = piece.is_err();
                    if send.send(piece).is_err() || is_last {
                        break;
                    }
                }
                stream
            });
            let done = pieces.into_iter().try_for_each(&mut write);
            let stream = reading.join();
            (
                stream.unwrap_or_else(|e| std::panic::resume_unwind(e)),
                done,
            )
        });
        done?;
        stream = back;
    }
    writer.finish().map_err(output)?;
    Ok((stream.finish(), written))
}

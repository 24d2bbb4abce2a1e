//! Temporary: speed of the writer.
use std::io::{Cursor, Read};
use std::path::PathBuf;

use gravical_recording::write::{NewColumn, Table, Writer};
use gravical_recording::{Later, bytes, sniff};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mode = std::env::args().nth(2).unwrap_or_default();
    let path = PathBuf::from(std::env::args().nth(1).ok_or("name a file")?);
    let mut text = bytes::open(&path)?;
    let mut head = Vec::new();
    text.by_ref().take(65_536).read_to_end(&mut head)?;
    let end = head.iter().rposition(|b| *b == b'\n').unwrap_or(0);
    let format = sniff(std::str::from_utf8(&head[..end])?, "")?;
    let gyro = format.gyro.ok_or("no gyroscope")?;
    let columns: Vec<NewColumn> = format
        .accel
        .iter()
        .chain(&gyro)
        .map(|c| NewColumn {
            name: format!("new_{c}"),
            replaces: Some(*c),
        })
        .collect();
    let table = Table::with_new(&format, &columns, 6, false);
    let mut batches = format.batches(Cursor::new(head).chain(text));
    if mode != "parse" {
        batches = batches.with_text(table.copied());
    }
    let mut writer = Writer::new(
        std::fs::File::create("/work/wa-base/bench/rewritten.csv")?,
        table,
    );
    let mut later: Option<Later> = None;
    let mut rows = 0;
    for batch in batches {
        let mut batch = batch?;
        rows += batch.rows();
        if mode == "parse" || mode == "text" {
            continue;
        }
        let later = match &mut later {
            Some(l) => l,
            None => {
                let text = std::mem::take(&mut batch.text);
                let judged = Later::judge(&format, batch.clone())?;
                batch.text = text;
                later.insert(judged.1)
            }
        };
        let channels = later.read(&mut batch).map_err(|c| c.what.to_string())?;
        if mode == "read" {
            continue;
        }
        let g = channels.gyro.as_ref().ok_or("no")?;
        let values: Vec<&[f64]> = channels.accel.iter().chain(g).map(Vec::as_slice).collect();
        writer.write_rows(0..batch.rows(), &batch.text, &values, &[])?;
    }
    writer.finish()?;
    println!("{rows}");
    Ok(())
}

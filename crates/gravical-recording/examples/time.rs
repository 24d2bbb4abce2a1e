//! Prints the time that reading a file takes, by batches and with all that is judged.
//!
//! ```text
//! cargo run --release --example time -- FILE
//! ```

use std::io::{Cursor, Read};
use std::path::PathBuf;
use std::time::Instant;

use gravical_recording::{Recording, bytes, sniff};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = PathBuf::from(std::env::args().nth(1).ok_or("name a file")?);
    let start = Instant::now();
    let mut text = bytes::open(&path)?;
    let mut head = Vec::new();
    text.by_ref().take(65_536).read_to_end(&mut head)?;
    let end = head.iter().rposition(|b| *b == b'\n').unwrap_or(0);
    let format = sniff(
        std::str::from_utf8(&head[..end])?,
        "",
        &gravical_recording::ReadOptions::default(),
    )?;
    let mut rows = 0;
    for batch in format.batches(Cursor::new(head).chain(text)) {
        rows += batch?.rows();
    }
    let ns_per_row = |start: Instant| start.elapsed().as_nanos() as f64 / rows as f64;
    println!("batches: {rows} rows, {:.0} ns per row", ns_per_row(start));
    let start = Instant::now();
    let recording = Recording::open(&path, &gravical_recording::ReadOptions::default())?;
    println!(
        "recording: {} rows, {:.0} ns per row",
        recording.rows(),
        ns_per_row(start)
    );
    Ok(())
}

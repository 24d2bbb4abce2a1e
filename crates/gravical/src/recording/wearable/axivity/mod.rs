//! Recordings of Axivity AX3 and AX6 (`.cwa`); [`block`] decodes.

mod block;

use std::io::{self, Read};

use super::Opened;
use super::order::{self, Event, Order, Place, fill};
use crate::recording::ledger::Aside;

use block::{BLOCK, Block, Defect, HEADER, Header};

/// Bytes that tell a `.cwa` file from others.
pub(super) const MAGIC: usize = HEADER + 2;

/// True if a file that begins with `head` is a `.cwa` file.
pub(super) fn is_one(head: &[u8]) -> bool {
    Header::parse(head).is_some()
}

/// What the first bytes of a `.cwa` file tell; `None` if it is none.
pub(super) fn open(head: &[u8]) -> Option<Opened> {
    let header = Header::parse(head)?;
    // The blocks say what was measured, the header what was wanted.
    let first = first_block(&head[HEADER..]);
    let with_gyro = match &first {
        Some(block) => block.has_gyro(),
        None => header.gyro_range_deg_s.is_some(),
    };
    let rate_hz = first.as_ref().map_or(header.rate_hz, |b| b.rate_hz);
    Some(Opened::new(
        describe(&header, rate_hz, with_gyro),
        &header.device.to_string(),
        rate_hz,
        with_gyro,
        true,
    ))
}

/// The first block of these that can be used.
fn first_block(mut bytes: &[u8]) -> Option<Block> {
    while let Some((block, rest)) = bytes.split_first_chunk() {
        if let Ok(block) = Block::parse(block) {
            return Some(block);
        }
        bytes = rest;
    }
    None
}

fn describe(header: &Header, rate_hz: f64, with_gyro: bool) -> String {
    let mut parts = vec![
        format!("Axivity {}", header.model),
        format!("session {}", header.session),
        format!("nominal {rate_hz} Hz"),
        format!("±{} g", header.range_g),
    ];
    if let Some(range) = header.gyro_range_deg_s.filter(|_| with_gyro) {
        parts.push(format!("±{range} °/s"));
    }
    parts.join(", ")
}

/// The blocks of a file.
#[derive(Debug)]
pub(super) struct Blocks<R> {
    reader: R,
    /// Blocks read.
    read: u64,
    pub order: Order,
}

impl<R: Read> Blocks<R> {
    /// `reader` is at the start of the file.
    ///
    /// # Errors
    ///
    /// Errors of reading.
    pub fn new(mut reader: R) -> io::Result<Self> {
        reader.read_exact(&mut [0; HEADER])?;
        Ok(Blocks {
            reader,
            read: 0,
            order: Order::default(),
        })
    }

    /// The next block, after a gap if there is one before it; `None` at the end of the file, and
    /// with `cut` before a block that is not whole.
    ///
    /// # Errors
    ///
    /// Errors of reading.
    pub fn next(&mut self, cut: bool) -> io::Result<Option<(Option<Event>, Event)>> {
        let mut bytes = [0; BLOCK];
        let length = fill(&mut self.reader, &mut bytes)?;
        if length == 0 || cut && length < BLOCK {
            return Ok(None);
        }
        let place = Place {
            number: self.read + 1,
            byte: self.bytes(),
        };
        self.read += 1;
        let parsed = match length {
            BLOCK => Block::parse(&bytes),
            _ => Err(Defect::Truncated),
        };
        Ok(Some(match parsed {
            Ok(block) => self.order.place(place, block.into()),
            Err(defect) => {
                let reason = match defect {
                    Defect::Erased => Aside::ErasedBlock,
                    _ => Aside::CorruptBlock,
                };
                (None, self.order.skip(place, reason, defect.text()))
            }
        }))
    }

    /// Bytes of the file up to the end of the last block.
    pub fn bytes(&self) -> u64 {
        HEADER as u64 + self.read * BLOCK as u64
    }
}

impl From<Block> for order::Block {
    fn from(block: Block) -> Self {
        order::Block {
            session: block.session,
            sequence: block.sequence,
            stamp_s: block.stamp_s,
            stamp_sample: block.stamp_sample,
            rate_hz: block.rate_hz,
            temperature_c: block.temperature_c,
            samples: block.samples(),
        }
    }
}

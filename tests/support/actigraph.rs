//! Writes `.gt3x` files of simulated ActiGraph devices, independently of the reader.

use std::io::Write as _;

/// How samples are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coding {
    /// 12 bits, y before x: kind 0.
    Packed,
    /// 16 bits: kind 26.
    Plain,
}

/// A record with its checksum.
pub fn record(kind: u8, stamp: u32, payload: &[u8]) -> Vec<u8> {
    let mut bytes = vec![0x1e, kind];
    bytes.extend(stamp.to_le_bytes());
    bytes.extend((payload.len() as u16).to_le_bytes());
    bytes.extend(payload);
    let sum = bytes.iter().fold(0, |sum, byte| sum ^ byte);
    bytes.push(!sum);
    bytes
}

/// A second of samples, x, y and z in counts.
pub fn activity(coding: Coding, stamp: u32, samples: &[[i16; 3]]) -> Vec<u8> {
    match coding {
        Coding::Plain => {
            let numbers = samples.iter().flatten();
            let payload: Vec<u8> = numbers.flat_map(|n| n.to_le_bytes()).collect();
            record(26, stamp, &payload)
        }
        Coding::Packed => {
            let ordered = samples.iter().flat_map(|[x, y, z]| [y, x, z]);
            let mut nibbles: Vec<u8> = ordered
                .flat_map(|n| [8, 4, 0].map(|down| ((n >> down) & 15) as u8))
                .collect();
            if nibbles.len() % 2 == 1 {
                nibbles.push(0);
            }
            let payload: Vec<u8> = nibbles.chunks(2).map(|n| n[0] << 4 | n[1]).collect();
            record(0, stamp, &payload)
        }
    }
}

/// The settings with the scale of the accelerometer, a power of two.
pub fn parameters(stamp: u32, counts_per_g: f64) -> Vec<u8> {
    // A fraction of one half, times two to this power.
    let exponent = counts_per_g.log2() as u32 + 1;
    let mut payload = Vec::new();
    for (key, value) in [
        // Board revision, scale, rate.
        ([0, 0, 8, 0], 3),
        ([0, 0, 55, 0], exponent << 24 | 0x40_0000),
        ([1, 0, 10, 0], 30_u32),
    ] {
        payload.extend(key);
        payload.extend(value.to_le_bytes());
    }
    record(21, stamp, &payload)
}

/// `info.txt` of a device.
pub fn info(serial: &str, rate_hz: u32, more: &str) -> String {
    format!(
        "Serial Number: {serial}\r\nDevice Type: wGT3XBT\r\nFirmware: 1.9.2\r\nBattery Voltage: 4.18\r\n\
         Sample Rate: {rate_hz}\r\nStart Date: 638448768000000000\r\nStop Date: 0\r\n\
         Last Sample Time: 638448769000000000\r\nTimeZone: 01:00:00\r\nDownload Date: 638448800000000000\r\n\
         Board Revision: 8\r\nUnexpected Resets: 0\r\nAcceleration Max: 8.0\r\nAcceleration Min: -8.0\r\n\
         Subject Name: a subject\r\n{more}"
    )
}

/// An archive of these members.
pub fn archive(members: &[(&str, &[u8])]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut archive = rawzip::ZipArchiveWriter::new(&mut bytes);
    for (name, content) in members {
        let method = rawzip::CompressionMethod::DEFLATE;
        let file = archive.new_file(name).compression_method(method);
        let (mut entry, config) = file.start().unwrap();
        let packed = flate2::write::DeflateEncoder::new(&mut entry, flate2::Compression::fast());
        let mut writer = config.wrap(packed);
        writer.write_all(content).unwrap();
        let (packed, descriptor) = writer.finish().unwrap();
        packed.finish().unwrap();
        entry.finish(descriptor).unwrap();
    }
    archive.finish().unwrap();
    bytes
}

//! Blocks of a `.cwa` file: 1024 bytes of header, then 512 bytes each of samples with one stamp.
//!
//! All numbers are little endian. The maker's description of the format is the Technical
//! Documentation of the AX devices, <https://github.com/openmovementproject/openmovement>.

use std::ops::RangeInclusive;

use crate::date::civil_day_s;
use crate::text::Reason;

/// Length of the header, bytes.
pub(super) const HEADER_BYTES: usize = 1024;
/// Length of a block of samples, bytes.
pub(super) const BLOCK_BYTES: usize = 512;

/// Where the samples of a block are.
const DATA: std::ops::Range<usize> = 30..510;
/// Bytes of a sample: three times 10 bits and an exponent.
const PACKED: usize = 4;
/// Bytes of a number that is not packed.
const NUMBER: usize = 2;
/// Sampling rates that the code of a rate can name, Hz.
const RATES_HZ: RangeInclusive<f64> = 6.25..=3200.0;

pub(super) fn u16_at(bytes: &[u8], at: usize) -> u16 {
    u16::from_le_bytes([bytes[at], bytes[at + 1]])
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from(u16_at(bytes, at)) | u32::from(u16_at(bytes, at + 2)) << 16
}

/// The sampling rate, Hz, and the range of the accelerometer, g, by their common code.
fn rate_and_range(code: u8) -> (f64, u32) {
    let rate_hz = 3200.0 / f64::from(1_u32 << (15 - (code & 15)));
    (rate_hz, 16 >> (code >> 6))
}

/// The header of a file.
pub(super) struct Header(pub [u8; HEADER_BYTES]);

impl Header {
    /// The number printed on the device; 0 if unknown.
    pub fn device(&self) -> u32 {
        let high = match u16_at(&self.0, 11) {
            u16::MAX => 0,
            high => u32::from(high) << 16,
        };
        high | u32::from(u16_at(&self.0, 5))
    }

    /// Nominal sampling rate, Hz.
    pub fn rate_hz(&self) -> f64 {
        rate_and_range(self.0[36]).0
    }

    /// Range of the gyroscope, °/s; `None` if it is off.
    pub fn gyro_range_deg_s(&self) -> Option<u32> {
        match self.0[35] & 15 {
            0 | 15 => None,
            n => Some(8000 >> n),
        }
    }

    /// Device, number of the recording, and settings in words.
    pub fn describe(&self, rate_hz: f64, has_gyro: bool) -> String {
        let model = if self.0[4] == 0x64 { "AX6" } else { "AX3" };
        let session = u32_at(&self.0, 7);
        let (_, range_g) = rate_and_range(self.0[36]);
        let text =
            format!("Axivity {model}, session {session}, nominal {rate_hz} Hz, ±{range_g} g");
        match self.gyro_range_deg_s().filter(|_| has_gyro) {
            Some(range) => format!("{text}, ±{range} °/s"),
            None => text,
        }
    }
}

/// Why a block cannot be used, also in words.
pub(super) type Defect = (Reason, &'static str);

/// A block of samples.
#[derive(Debug, Clone)]
pub(super) struct Block {
    pub session: u32,
    pub sequence: u32,
    /// The time stamp, s since 1970 on the clock of the device.
    pub stamp_s: f64,
    /// The sample, from that at the start of the block, to which the stamp belongs; it may lie
    /// outside of the block.
    pub stamp_sample: i64,
    /// Temperature of the device, °C.
    pub temperature_c: f64,
    /// Nominal sampling rate, Hz.
    pub rate_hz: f64,
    /// Number of samples, at least one.
    pub samples: usize,
    /// Numbers of 16 bits of a sample: 3 of the accelerometer, behind 3 of the gyroscope if there are
    /// 6. 0 if it is packed: three numbers of 10 bits, and their common exponent in the two highest.
    numbers: usize,
    /// g per count.
    accel_g: f64,
    /// °/s per count.
    gyro_deg_s: f64,
    data: [u8; DATA.end - DATA.start],
}

impl Block {
    /// # Errors
    ///
    /// Why the block cannot be used.
    pub fn parse(bytes: &[u8; BLOCK_BYTES]) -> Result<Self, Defect> {
        if bytes.iter().all(|b| *b == 0xff) || bytes.iter().all(|b| *b == 0) {
            return Err((Reason::ErasedBlock, "never written"));
        }
        if &bytes[..2] != b"AX" || usize::from(u16_at(bytes, 2)) != BLOCK_BYTES - 4 {
            return Err((Reason::CorruptBlock, "not a block of samples"));
        }
        let words = (0..BLOCK_BYTES).step_by(2).map(|at| u16_at(bytes, at));
        if words.fold(0, u16::wrapping_add) != 0 {
            return Err((Reason::CorruptBlock, "wrong checksum"));
        }
        let (rate_hz, _) = rate_and_range(bytes[24]);
        let unknown = (Reason::CorruptBlock, "unknown coding");
        let (numbers, sample_bytes) = match bytes[25] {
            0x30 => (0, PACKED),
            0x32 => (3, 3 * NUMBER),
            0x62 => (6, 6 * NUMBER),
            _ => return Err(unknown),
        };
        let samples = usize::from(u16_at(bytes, 28));
        if !(1..=DATA.len() / sample_bytes).contains(&samples) || !RATES_HZ.contains(&rate_hz) {
            return Err(unknown);
        }
        // With the top bit, the other bits are a fraction of the second; without it, the number
        // of the device.
        let bits = u16_at(bytes, 4);
        let fraction = if bits & 0x8000 == 0 { 0 } else { bits << 1 };
        let stamp_sample = u16_at(bytes, 26).cast_signed();
        // The index was written for a whole second; the samples in the fraction come on top.
        let in_fraction = (f64::from(fraction) * rate_hz) as i64 >> 16;
        let scales = u16_at(bytes, 18);
        let gyro_range_deg_s = f64::from(8000_u32 >> (scales >> 10 & 7));
        let mut data = [0; DATA.end - DATA.start];
        data.copy_from_slice(&bytes[DATA]);
        let date_s = date_s(u32_at(bytes, 14));
        let no_date = (Reason::CorruptBlock, "time stamp without a date");
        Ok(Block {
            session: u32_at(bytes, 6),
            sequence: u32_at(bytes, 10),
            stamp_s: date_s.ok_or(no_date)? + f64::from(fraction) / 65536.0,
            stamp_sample: i64::from(stamp_sample) + in_fraction,
            temperature_c: temperature_c(u16_at(bytes, 20) & 1023),
            rate_hz,
            samples,
            numbers,
            accel_g: 1.0 / f64::from(256_u32 << (scales >> 13)),
            gyro_deg_s: gyro_range_deg_s / 32768.0,
            data,
        })
    }

    /// True if the samples have angular rates.
    pub fn has_gyro(&self) -> bool {
        self.numbers == 6
    }

    /// Adds the samples to columns of specific force, g, and, where there are six, of angular rate,
    /// °/s; NaN without a gyroscope.
    pub fn append_to(&self, columns: &mut [Vec<f64>]) {
        let (accel_columns, gyro_columns) = columns.split_at_mut(3);
        for i in 0..self.samples {
            let (accel, gyro) = match self.numbers {
                0 => (unpack(u32_at(&self.data, PACKED * i)), None),
                6 => (self.three(6 * i + 3), Some(self.three(6 * i))),
                numbers => (self.three(numbers * i), None),
            };
            for (column, count) in accel_columns.iter_mut().zip(accel) {
                column.push(f64::from(count) * self.accel_g);
            }
            for (axis, column) in gyro_columns.iter_mut().enumerate() {
                column.push(gyro.map_or(f64::NAN, |g| f64::from(g[axis]) * self.gyro_deg_s));
            }
        }
    }

    #[inline]
    fn three(&self, first: usize) -> [i32; 3] {
        let number = |i| u16_at(&self.data, NUMBER * (first + i)).cast_signed();
        [0, 1, 2].map(|i| i32::from(number(i)))
    }
}

/// Three numbers of 10 bits with their exponent in the two highest bits.
#[inline]
fn unpack(word: u32) -> [i32; 3] {
    let exponent = word >> 30;
    // To the top, so that the shift back extends the sign.
    [22, 12, 2].map(|up| (word << up).cast_signed() >> 22 << exponent)
}

/// Temperature of the device by the maker's formula for its sensor (MCP9700, 10 mV per °C and 500 mV
/// at 0 °C, a converter of 10 bits over 3 V).
fn temperature_c(raw: u16) -> f64 {
    f64::from(raw) * 75.0 / 256.0 - 50.0
}

/// A packed date, s since 1970; `None` if there is no such date.
fn date_s(packed: u32) -> Option<f64> {
    let part = |from: u32, bits: u32| i64::from(packed >> from & ((1 << bits) - 1));
    let midnight_s = civil_day_s(2000 + part(26, 6), part(22, 4), part(17, 5))?;
    let second = 3600 * part(12, 5) + 60 * part(6, 6) + part(0, 6);
    Some(midnight_s + second as f64)
}

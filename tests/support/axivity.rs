//! Writes `.cwa` files of simulated Axivity devices, independently of the reader.

use jiff::Timestamp;
use jiff::tz::TimeZone;

/// How samples are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coding {
    /// 10 bits and a common exponent: AX3.
    Packed,
    /// 16 bits: AX3, or AX6 with the gyroscope off.
    Plain,
    /// Gyroscope and accelerometer, 16 bits: AX6.
    WithGyro,
}

impl Coding {
    /// Samples in a full block.
    pub fn samples(self) -> usize {
        match self {
            Coding::Packed => 120,
            Coding::Plain => 80,
            Coding::WithGyro => 40,
        }
    }

    fn code(self) -> u8 {
        match self {
            Coding::Packed => 0x30,
            Coding::Plain => 0x32,
            Coding::WithGyro => 0x62,
        }
    }
}

/// Counts of one sample: specific force, angular rate.
pub type Counts = [i16; 6];

/// A device that records.
#[derive(Debug, Clone)]
pub struct Device {
    pub coding: Coding,
    pub serial: u32,
    pub session: u32,
    /// 3200 / 2^(15 − code) Hz.
    pub rate_code: u8,
    /// Rate of the sensor, Hz; not quite the nominal one.
    pub true_rate_hz: f64,
    /// When the first sample is measured, s since 1970.
    pub start_s: f64,
    /// The scale of the accelerometer is 256 << this, counts per g.
    pub accel_scale: u16,
    /// Number of the next block.
    pub sequence: u32,
    /// Samples so far, those of lost blocks included.
    pub samples: u64,
}

impl Device {
    /// A device at 100 Hz and ±8 g that records from 2024-03-01 08:00.
    pub fn new(coding: Coding) -> Self {
        Device {
            coding,
            serial: 6_011_802,
            session: 17,
            rate_code: 0x4a,
            true_rate_hz: 98.4,
            start_s: 1_709_280_000.25,
            accel_scale: match coding {
                Coding::WithGyro => 3,
                Coding::Packed | Coding::Plain => 0,
            },
            sequence: 0,
            samples: 0,
        }
    }

    /// g per count.
    pub fn accel_g(&self) -> f64 {
        1.0 / f64::from(256_u32 << self.accel_scale)
    }

    /// Smallest step of the accelerometer, counts.
    pub fn accel_step(&self) -> f64 {
        match self.coding {
            Coding::Packed => f64::from(1_u32 << exponent(self.rate_code)),
            Coding::Plain | Coding::WithGyro => 1.0,
        }
    }

    /// °/s per count, at a range of 2000 °/s.
    pub fn gyro_deg_s(&self) -> f64 {
        2000.0 / 32768.0
    }

    /// When sample `k` is measured, s since 1970.
    pub fn time_s(&self, k: u64) -> f64 {
        self.start_s + k as f64 / self.true_rate_hz
    }

    /// The header of the file.
    pub fn header(&self) -> Vec<u8> {
        let mut bytes = vec![0xff; 1024];
        let gyro = self.coding == Coding::WithGyro;
        bytes[..4].copy_from_slice(b"MD\xfc\x03");
        bytes[4] = if gyro { 0x64 } else { 0 };
        bytes[5..7].copy_from_slice(&(self.serial as u16).to_le_bytes());
        bytes[7..11].copy_from_slice(&self.session.to_le_bytes());
        bytes[11..13].copy_from_slice(&((self.serial >> 16) as u16).to_le_bytes());
        bytes[35] = if gyro { 2 } else { 0 };
        bytes[36] = self.rate_code;
        bytes[64..512].fill(b' ');
        bytes
    }

    /// The next block: `samples` with the temperature as read by the converter. The device
    /// stamps the first sample after the block.
    pub fn block(&mut self, samples: &[Counts], temperature: u16) -> [u8; 512] {
        let stamped = samples.len();
        // Stamps have 2⁻¹⁵ s.
        let ticks = (self.time_s(self.samples + stamped as u64) * 32768.0).round() as i64;
        let fraction = ((ticks & 0x7fff) as u16) << 1;
        let nominal_hz = 3200.0 / f64::from(1_u32 << (15 - (self.rate_code & 15)));
        let in_fraction = (u64::from(fraction) * nominal_hz as u64) >> 16;
        let mut bytes = [0; 512];
        let mut at = 0;
        let mut put = |part: &[u8]| {
            bytes[at..at + part.len()].copy_from_slice(part);
            at += part.len();
        };
        put(b"AX");
        put(&508_u16.to_le_bytes());
        put(&(0x8000 | fraction >> 1).to_le_bytes());
        put(&self.session.to_le_bytes());
        put(&self.sequence.to_le_bytes());
        put(&pack_date(ticks >> 15).to_le_bytes());
        // Light, and a range of 2000 °/s.
        put(&(self.accel_scale << 13 | 2 << 10 | 300).to_le_bytes());
        put(&temperature.to_le_bytes());
        // No events; the battery.
        put(&[0, 200, self.rate_code, self.coding.code()]);
        put(&((stamped as i64 - in_fraction as i64) as i16).to_le_bytes());
        put(&(samples.len() as u16).to_le_bytes());
        for [ax, ay, az, gx, gy, gz] in samples {
            match self.coding {
                Coding::Packed => {
                    let exponent = exponent(self.rate_code);
                    put(&pack([*ax, *ay, *az], exponent).to_le_bytes());
                }
                Coding::Plain => [ax, ay, az].iter().for_each(|n| put(&n.to_le_bytes())),
                Coding::WithGyro => {
                    let all = [gx, gy, gz, ax, ay, az];
                    all.iter().for_each(|n| put(&n.to_le_bytes()));
                }
            }
        }
        seal(&mut bytes);
        self.sequence += 1;
        self.samples += samples.len() as u64;
        bytes
    }
}

/// Sets the checksum: the sum of all words is zero.
pub fn seal(block: &mut [u8; 512]) {
    let word = |i: usize| u16::from_le_bytes([block[2 * i], block[2 * i + 1]]);
    let sum = (0..255).map(word).fold(0, u16::wrapping_add);
    block[510..].copy_from_slice(&sum.wrapping_neg().to_le_bytes());
}

/// Three counts of 10 bits with their exponent.
fn pack(counts: [i16; 3], exponent: u32) -> u32 {
    let part = |c: i16| u32::from((c >> exponent).clamp(-512, 511) as u16 & 0x3ff);
    exponent << 30 | part(counts[2]) << 20 | part(counts[1]) << 10 | part(counts[0])
}

/// The exponent of packed samples: 10 bits cover the range, which is 16 g >> this code.
fn exponent(rate_code: u8) -> u32 {
    3 - u32::from(rate_code >> 6)
}

/// A date as six numbers of 6, 4, 5, 5, 6 and 6 bits.
fn pack_date(since_1970_s: i64) -> u32 {
    let date = Timestamp::from_second(since_1970_s)
        .unwrap()
        .to_zoned(TimeZone::UTC)
        .datetime();
    let parts = [
        (date.year() as u32 - 2000, 26),
        (date.month() as u32, 22),
        (date.day() as u32, 17),
        (date.hour() as u32, 12),
        (date.minute() as u32, 6),
        (date.second() as u32, 0),
    ];
    parts.iter().fold(0, |all, (part, up)| all | part << up)
}

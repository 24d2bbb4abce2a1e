//! The MPU6050 as its registers show it. Pure Rust, without the emulator.
//!
//! The bus talks to it byte by byte ([`Mpu6050::start`], [`write`], [`read`],
//! [`stop`]) and says what time it is; the readings come from a [`Source`].
//!
//! In the model: the identity, sleep at power-up and after a reset, the reset
//! itself (no answer for 10 ms), ranges and their clipping, the rate divider
//! with the low-pass on (1 kHz) and off (8 kHz), data-ready in `INT_STATUS` and
//! what clears it, the offset registers, and a clock of its own. What is read
//! between a start and a stop is the sample of the start (section 3 of the data
//! sheet: the registers that are read are renewed while the bus is idle); the
//! status is the present one, which is the worse case for a program that reads
//! both in one transfer.
//!
//! Not in the model: what the low-pass does to the signal (readings are taken as
//! they come), the 1 kHz limit of the accelerometer, start-up of the gyroscope,
//! the FIFO, self-test, motion interrupts, single axes in standby, cycling.
//!
//! [`write`]: Mpu6050::write
//! [`read`]: Mpu6050::read
//! [`stop`]: Mpu6050::stop

mod faults;
mod hands;
pub(crate) mod registers;
mod source;
#[cfg(test)]
mod tests;

pub use faults::{Fault, FaultKind, Faults};
pub use hands::{COMMANDS, Command, Hands};
pub use source::{Reading, Rows, Source};

use gravical_core::unit::{
    MPU6050_ACCELEROMETER_LSB_PER_G, MPU6050_GYROSCOPE_LSB_PER_DEG_S, STANDARD_GRAVITY_MPS2,
};
use registers::{
    ACCEL_CONFIG, ACCEL_XOUT_H, CONFIG, COUNT, DATA_READY, DEVICE_RESET, FIFO_R_W, GYRO_CONFIG,
    IDENTITY, INT_ENABLE, INT_PIN_CFG, INT_RD_CLEAR, INT_STATUS, PWR_MGMT_1, SLEEP, SMPLRT_DIV,
    WHO_AM_I, XA_OFFS_H, XG_OFFS_H, read_only,
};

/// Seconds that the part is busy with a reset and answers nothing. The data sheet
/// promises only that it is over after 100 ms.
const RESET_S: f64 = 0.01;

/// Accelerometer offsets that the factory wrote, in units of 1/2048 g. Any part
/// has others; software must keep them when it writes its own.
const FACTORY_OFFSETS: [i16; 3] = [-1234, 567, 1290];

/// Acceleration, temperature, angular rate.
const SAMPLE_BYTES: usize = 14;

/// Counts of the thermometer: 340 LSB/°C and
/// 36.53 °C (register map, section 4.18).
const TEMPERATURE_LSB_PER_C: f64 = 340.0;
const TEMPERATURE_AT_ZERO_C: f64 = 36.53;

/// How a part differs from the data sheet.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorOptions {
    /// 7-bit address: 0x68, or 0x69 with AD0 high. Default 0x68.
    pub address: u8,
    /// How much faster its clock runs than the board's, parts per million.
    /// Default 0; the data sheet allows ±10 000 with the gyroscope's clock.
    pub clock_error_ppm: f64,
    /// What goes wrong. Default nothing.
    pub faults: Faults,
}

impl Default for SensorOptions {
    fn default() -> Self {
        Self {
            address: 0x68,
            clock_error_ppm: 0.0,
            faults: Faults::default(),
        }
    }
}

/// One MPU6050.
pub struct Mpu6050 {
    options: SensorOptions,
    source: Box<dyn Source>,
    registers: [u8; COUNT],
    /// When readings and faults begin to count, s.
    origin_s: f64,
    now_s: f64,
    /// When the next sample is due; infinite asleep.
    next_s: f64,
    /// Until when it is busy with a reset.
    busy_until_s: f64,
    /// The register that the next byte is for; none before it was sent.
    pointer: Option<u8>,
    selected: bool,
    /// Between a start and a stop; the sample as it was at the start.
    bus_busy: bool,
    shadow: [u8; SAMPLE_BYTES],
    held: [i16; 3],
    /// Samples since it was made.
    samples: u64,
    /// Samples that were overwritten before the status was read.
    unread: u64,
}

impl Mpu6050 {
    /// A part that has just got its supply: asleep.
    pub fn new(source: impl Source + 'static, options: SensorOptions) -> Self {
        let mut sensor = Self {
            options,
            source: Box::new(source),
            registers: [0; COUNT],
            origin_s: 0.0,
            now_s: 0.0,
            next_s: f64::INFINITY,
            busy_until_s: 0.0,
            pointer: None,
            selected: false,
            bus_busy: false,
            shadow: [0; SAMPLE_BYTES],
            held: [0; 3],
            samples: 0,
            unread: 0,
        };
        sensor.power_up();
        sensor
    }

    /// Samples measured so far, and how many of them nobody fetched.
    #[must_use]
    pub fn samples(&self) -> (u64, u64) {
        (self.samples, self.unread)
    }

    /// Seconds between two samples on the board's clock.
    #[must_use]
    pub fn period_s(&self) -> f64 {
        let base_hz = match self.registers[CONFIG as usize] & 7 {
            0 | 7 => 8000.0,
            _ => 1000.0,
        };
        let divider = f64::from(self.registers[SMPLRT_DIV as usize]) + 1.0;
        divider / base_hz / (1.0 + self.options.clock_error_ppm * 1e-6)
    }

    /// Readings and faults start again from their beginning; the part stays as
    /// it is.
    pub fn restart(&mut self, now_s: f64) {
        self.advance(now_s);
        self.origin_s = now_s;
    }

    /// Seconds since the start of readings and faults.
    #[must_use]
    pub fn elapsed_s(&self) -> f64 {
        self.now_s - self.origin_s
    }

    /// The register that the next byte belongs to.
    #[must_use]
    pub fn pointer(&self) -> Option<u8> {
        self.pointer
    }

    /// The faults.
    #[must_use]
    pub fn faults(&self) -> &Faults {
        &self.options.faults
    }

    /// Lets time go on to `now_s` on the board's clock.
    pub fn advance(&mut self, now_s: f64) {
        let from_s = self.elapsed_s();
        self.now_s = now_s;
        let to_s = self.elapsed_s();
        if self.options.faults.begins(FaultKind::Dip, from_s, to_s) {
            self.power_up();
        }
        if self.next_s > now_s {
            return;
        }
        let period_s = self.period_s();
        // Of those that nobody looked at only the last is worth computing.
        let skipped = ((now_s - self.next_s) / period_s).floor();
        let sample_s = self.next_s + skipped * period_s;
        self.samples += skipped as u64;
        self.unread += skipped as u64;
        self.measure(sample_s);
        self.next_s = sample_s + period_s;
    }

    /// A start condition with an address; true when the part answers.
    pub fn start(&mut self, now_s: f64, address: u8, read: bool) -> bool {
        self.advance(now_s);
        if !self.bus_busy {
            self.bus_busy = true;
            let from = ACCEL_XOUT_H as usize;
            self.shadow
                .copy_from_slice(&self.registers[from..from + SAMPLE_BYTES]);
        }
        let silent = self
            .options
            .faults
            .now(self.elapsed_s(), |kind| {
                (kind == FaultKind::NoAnswer).then_some(())
            })
            .is_some();
        self.selected = address == self.options.address && !silent && now_s >= self.busy_until_s;
        if self.selected && !read {
            self.pointer = None;
        }
        self.selected
    }

    /// A byte to the part: the register first, then its values. True when taken.
    pub fn write(&mut self, byte: u8) -> bool {
        if !self.selected {
            return false;
        }
        match self.pointer {
            None => self.pointer = Some(byte & 0x7f),
            Some(register) => {
                self.set(register, byte);
                self.step();
            }
        }
        true
    }

    /// A byte from the part.
    pub fn read(&mut self) -> u8 {
        if !self.selected {
            return 0xff;
        }
        let register = self.pointer.unwrap_or(0);
        let in_sample = usize::from(register).checked_sub(ACCEL_XOUT_H as usize);
        let mut value = in_sample
            .and_then(|at| self.shadow.get(at).copied())
            .unwrap_or(self.registers[register as usize]);
        if register == WHO_AM_I {
            let other = self
                .options
                .faults
                .now(self.elapsed_s(), |kind| match kind {
                    FaultKind::Identity(id) => Some(id),
                    _ => None,
                });
            value = other.unwrap_or(value);
        }
        let any = self.registers[INT_PIN_CFG as usize] & INT_RD_CLEAR != 0;
        if register == INT_STATUS || any {
            self.registers[INT_STATUS as usize] = 0;
        }
        self.step();
        value
    }

    /// A stop condition.
    pub fn stop(&mut self) {
        self.selected = false;
        self.bus_busy = false;
    }

    /// On to the next register, but not from the FIFO.
    fn step(&mut self) {
        self.pointer = self.pointer.map(|at| match at {
            FIFO_R_W => at,
            _ => (at + 1) & 0x7f,
        });
    }

    fn power_up(&mut self) {
        self.registers = [0; COUNT];
        self.registers[PWR_MGMT_1 as usize] = SLEEP;
        self.registers[WHO_AM_I as usize] = IDENTITY;
        for (axis, offset) in FACTORY_OFFSETS.iter().enumerate() {
            self.put(XA_OFFS_H, axis, *offset);
        }
        self.next_s = f64::INFINITY;
    }

    fn set(&mut self, register: u8, value: u8) {
        if read_only(register) {
            return;
        }
        if register == PWR_MGMT_1 && value & DEVICE_RESET != 0 {
            self.power_up();
            self.busy_until_s = self.now_s + RESET_S;
            return;
        }
        self.registers[register as usize] = value;
        if matches!(register, PWR_MGMT_1 | SMPLRT_DIV | CONFIG) {
            let asleep = self.registers[PWR_MGMT_1 as usize] & SLEEP != 0;
            self.next_s = if asleep {
                f64::INFINITY
            } else {
                self.now_s + self.period_s()
            };
        }
    }

    /// One sample into its registers.
    fn measure(&mut self, time_s: f64) {
        let elapsed_s = time_s - self.origin_s;
        let reading = self.source.at(elapsed_s.max(0.0));
        let (_, lsb_per_g) = MPU6050_ACCELEROMETER_LSB_PER_G[self.range(ACCEL_CONFIG)];
        let (_, lsb_per_deg_s) = MPU6050_GYROSCOPE_LSB_PER_DEG_S[self.range(GYRO_CONFIG)];
        let frozen = self.options.faults.now(elapsed_s, |kind| match kind {
            FaultKind::Frozen(axis) => Some(axis),
            _ => None,
        });
        for axis in 0..3 {
            // The lowest bit is reserved; the others are ours less the factory's.
            let own = self.get(XA_OFFS_H, axis) & !1;
            let offset_g = f64::from(own - (FACTORY_OFFSETS[axis] & !1)) / 2048.0;
            let accel_g = reading.accel_mps2[axis] / STANDARD_GRAVITY_MPS2 + offset_g;
            if frozen != Some(axis) {
                self.held[axis] = counts(accel_g * lsb_per_g);
            }
            self.put(ACCEL_XOUT_H, axis, self.held[axis]);
            // In units of the ±1000 °/s range.
            let offset_deg_s = f64::from(self.get(XG_OFFS_H, axis)) / 32.8;
            let rate_deg_s = reading.gyro_deg_s[axis] + offset_deg_s;
            self.put(ACCEL_XOUT_H, 4 + axis, counts(rate_deg_s * lsb_per_deg_s));
        }
        let above_c = reading.temperature_c - TEMPERATURE_AT_ZERO_C;
        self.put(ACCEL_XOUT_H, 3, counts(above_c * TEMPERATURE_LSB_PER_C));
        self.samples += 1;
        if self.registers[INT_STATUS as usize] & DATA_READY != 0 {
            self.unread += 1;
        }
        self.registers[INT_STATUS as usize] |= self.registers[INT_ENABLE as usize] & DATA_READY;
    }

    /// Number of the range in a configuration register.
    fn range(&self, register: u8) -> usize {
        usize::from(self.registers[register as usize] >> 3 & 3)
    }

    /// The `index`th big-endian word from `register` on.
    fn get(&self, register: u8, index: usize) -> i16 {
        let at = register as usize + 2 * index;
        i16::from_be_bytes([self.registers[at], self.registers[at + 1]])
    }

    fn put(&mut self, register: u8, index: usize, value: i16) {
        let at = register as usize + 2 * index;
        self.registers[at..at + 2].copy_from_slice(&value.to_be_bytes());
    }
}

/// To the nearest count, at the end of the range the last one.
fn counts(value: f64) -> i16 {
    value
        .round()
        .clamp(f64::from(i16::MIN), f64::from(i16::MAX)) as i16
}

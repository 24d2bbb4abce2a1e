//! The MPU6050 as its registers show it (MPU-6000/MPU-6050 Register Map and Descriptions, revision
//! 4.2), at the address 0x68. Pure Rust, without the emulator.
//!
//! The bus talks to it byte by byte ([`Mpu6050::start`], [`write`], [`read`],
//! [`stop`]) and says what time it is; the readings are a function of time.
//!
//! In the model: the identity, sleep at power-up and after a reset, the reset
//! itself (no answer for 10 ms), ranges and their clipping, the rate divider
//! with the low-pass on (1 kHz) and off (8 kHz), data-ready in `INT_STATUS`, which
//! reading it clears, and a clock of its own. What is read
//! between a start and a stop is the sample of the start (section 3 of the data
//! sheet: the registers that are read are renewed while the bus is idle); the
//! status is the present one, which is the worse case for a program that reads
//! both in one transfer.
//!
//! Not in the model: what the low-pass does to the signal (readings are taken as
//! they come), the 1 kHz limit of the accelerometer, start-up of the gyroscope,
//! the offset registers, the FIFO, self-test, interrupts, single axes in standby, cycling.
//!
//! [`write`]: Mpu6050::write
//! [`read`]: Mpu6050::read
//! [`stop`]: Mpu6050::stop

use std::ops::Range;

use gravical_core::unit::{
    MPU6050_ACCELEROMETER_LSB_PER_G, MPU6050_GYROSCOPE_LSB_PER_DEG_S, STANDARD_GRAVITY_MPS2,
};

/// Its address on the bus, and what `WHO_AM_I` reads.
const ADDRESS: u8 = 0x68;
const SMPLRT_DIV: u8 = 0x19;
const CONFIG: u8 = 0x1a;
const GYRO_CONFIG: u8 = 0x1b;
const ACCEL_CONFIG: u8 = 0x1c;
const INT_ENABLE: u8 = 0x38;
const INT_STATUS: u8 = 0x3a;
const ACCEL_XOUT_H: u8 = 0x3b;
const PWR_MGMT_1: u8 = 0x6b;
const WHO_AM_I: u8 = 0x75;
/// `PWR_MGMT_1`: sleep, and a reset of every register.
const SLEEP: u8 = 0x40;
const DEVICE_RESET: u8 = 0x80;
/// `INT_STATUS` and `INT_ENABLE`: data ready.
const DATA_READY: u8 = 0x01;

/// Number of registers.
const COUNT: usize = 128;
/// Acceleration, temperature, angular rate.
const SAMPLE_BYTES: usize = 14;

/// Seconds that the part is busy with a reset and answers nothing. The data sheet
/// promises only that it is over after 100 ms.
const RESET_S: f64 = 0.01;

/// Counts of the thermometer: 340 LSB/°C and
/// 36.53 °C (register map, section 4.18).
const TEMPERATURE_LSB_PER_C: f64 = 340.0;
const TEMPERATURE_AT_ZERO_C: f64 = 36.53;

/// What a perfect part would read at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Specific force along x, y, z, m/s².
    pub accel_mps2: [f64; 3],
    /// Angular rate about x, y, z, °/s.
    pub gyro_deg_s: [f64; 3],
    /// Temperature, °C.
    pub temperature_c: f64,
}

impl Default for Reading {
    /// Flat on the table at 25 °C.
    fn default() -> Self {
        Self {
            accel_mps2: [0.0, 0.0, STANDARD_GRAVITY_MPS2],
            gyro_deg_s: [0.0; 3],
            temperature_c: 25.0,
        }
    }
}

/// One thing that can go wrong with the sensor or the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FaultKind {
    /// The sensor does not answer: a wire is off.
    NoAnswer,
    /// The data line is held low: no transfer ends.
    StuckBus,
    /// `WHO_AM_I` reads this.
    Identity(u8),
    /// The sensor's supply dips at the start: all registers as after power-up,
    /// asleep.
    Dip,
    /// The program stops going on, until it is reset.
    Hang,
}

/// One MPU6050.
pub struct Mpu6050 {
    /// What goes wrong, and when, s after the start. The end of a dip has no meaning.
    pub faults: Vec<(FaultKind, Range<f64>)>,
    /// How much faster its clock runs than the board's, parts per million;
    /// the data sheet allows ±10 000 with the gyroscope's clock.
    pub clock_error_ppm: f64,
    source: Box<dyn FnMut(f64) -> Reading>,
    registers: [u8; COUNT],
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
    /// Samples since it was made.
    samples: u64,
    /// Samples that were overwritten before the status was read.
    unread: u64,
}

impl Mpu6050 {
    /// A part that has just got its supply: asleep. `source` gives its reading a time in s after
    /// the start.
    pub fn new(source: impl FnMut(f64) -> Reading + 'static) -> Self {
        let mut sensor = Self {
            faults: Vec::new(),
            clock_error_ppm: 0.0,
            source: Box::new(source),
            registers: [0; COUNT],
            now_s: 0.0,
            next_s: f64::INFINITY,
            busy_until_s: 0.0,
            pointer: None,
            selected: false,
            bus_busy: false,
            shadow: [0; SAMPLE_BYTES],
            samples: 0,
            unread: 0,
        };
        sensor.power_up();
        sensor
    }

    /// Samples measured so far, and how many of them nobody fetched.
    pub fn samples(&self) -> (u64, u64) {
        (self.samples, self.unread)
    }

    /// Seconds between two samples on the board's clock.
    fn period_s(&self) -> f64 {
        let base_hz = match self.registers[CONFIG as usize] & 7 {
            0 | 7 => 8000.0,
            _ => 1000.0,
        };
        let divider = f64::from(self.registers[SMPLRT_DIV as usize]) + 1.0;
        divider / base_hz / (1.0 + self.clock_error_ppm * 1e-6)
    }

    /// The faults that last now.
    fn faults_now(&self) -> impl Iterator<Item = FaultKind> {
        let now = self
            .faults
            .iter()
            .filter(|(_, span)| span.contains(&self.now_s));
        now.map(|(kind, _)| *kind)
    }

    /// Whether `kind` lasts now.
    pub fn has(&self, kind: FaultKind) -> bool {
        self.faults_now().any(|k| k == kind)
    }

    /// Lets time go on to `now_s` on the board's clock.
    pub fn advance(&mut self, now_s: f64) {
        let from_s = std::mem::replace(&mut self.now_s, now_s);
        let is_new = |span: &Range<f64>| from_s < span.start && span.start <= now_s;
        let mut faults = self.faults.iter();
        if faults.any(|(kind, span)| *kind == FaultKind::Dip && is_new(span)) {
            self.power_up();
        }
        while self.next_s <= now_s {
            self.measure(self.next_s);
            self.next_s += self.period_s();
        }
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
        let silent = self.has(FaultKind::NoAnswer) || now_s < self.busy_until_s;
        self.selected = address == ADDRESS && !silent;
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
                self.pointer = Some((register + 1) & 0x7f);
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
        self.pointer = Some((register + 1) & 0x7f);
        if register == WHO_AM_I {
            let other = self.faults_now().find_map(|kind| match kind {
                FaultKind::Identity(id) => Some(id),
                _ => None,
            });
            return other.unwrap_or(ADDRESS);
        }
        if register == INT_STATUS {
            return std::mem::take(&mut self.registers[INT_STATUS as usize]);
        }
        let in_sample = usize::from(register).checked_sub(ACCEL_XOUT_H as usize);
        in_sample
            .and_then(|at| self.shadow.get(at).copied())
            .unwrap_or(self.registers[register as usize])
    }

    /// A stop condition.
    pub fn stop(&mut self) {
        self.selected = false;
        self.bus_busy = false;
    }

    fn power_up(&mut self) {
        self.registers = [0; COUNT];
        self.registers[PWR_MGMT_1 as usize] = SLEEP;
        self.next_s = f64::INFINITY;
    }

    fn set(&mut self, register: u8, value: u8) {
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
        let reading = (self.source)(time_s);
        let (_, lsb_per_g) = MPU6050_ACCELEROMETER_LSB_PER_G[self.range(ACCEL_CONFIG)];
        let (_, lsb_per_deg_s) = MPU6050_GYROSCOPE_LSB_PER_DEG_S[self.range(GYRO_CONFIG)];
        for axis in 0..3 {
            let accel_g = reading.accel_mps2[axis] / STANDARD_GRAVITY_MPS2;
            self.put(axis, counts(accel_g * lsb_per_g));
            self.put(4 + axis, counts(reading.gyro_deg_s[axis] * lsb_per_deg_s));
        }
        let above_c = reading.temperature_c - TEMPERATURE_AT_ZERO_C;
        self.put(3, counts(above_c * TEMPERATURE_LSB_PER_C));
        self.samples += 1;
        let enabled = self.registers[INT_ENABLE as usize] & DATA_READY;
        let status = &mut self.registers[INT_STATUS as usize];
        self.unread += u64::from(*status & DATA_READY);
        *status |= enabled;
    }

    /// Number of the range in a configuration register.
    fn range(&self, register: u8) -> usize {
        usize::from(self.registers[register as usize] >> 3 & 3)
    }

    /// A word of the sample, the high byte first.
    fn put(&mut self, index: usize, value: i16) {
        let at = ACCEL_XOUT_H as usize + 2 * index;
        self.registers[at..at + 2].copy_from_slice(&value.to_be_bytes());
    }
}

/// To the nearest count, at the end of the range the last one.
fn counts(value: f64) -> i16 {
    value
        .round()
        .clamp(f64::from(i16::MIN), f64::from(i16::MAX)) as i16
}

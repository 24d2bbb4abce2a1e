//! What simavr calls when the board sends a byte or uses its I²C bus.

use std::ffi::c_void;

use simavr_ffi as ffi;

use super::FREQUENCY_HZ;
use crate::sensor::Mpu6050;
use crate::sensor::registers::{DATA_READY, GYRO_ZOUT_L, INT_STATUS};

/// Addresses of the ATmega328P's registers in data space (data sheet, section 36).
const TWBR: usize = 0xb8;
const TWSR: usize = 0xb9;
const UCSR0A: usize = 0xc0;
const UBRR0L: usize = 0xc4;
const UBRR0H: usize = 0xc5;
const U2X0: u8 = 0x02;

/// A byte that the board sent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sent {
    /// The byte.
    pub byte: u8,
    /// When it began, s since power-up.
    pub time_s: f64,
    /// Its bits a second.
    pub baud: f64,
}

/// What went over the I²C bus.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Bus {
    /// Start conditions.
    pub starts: u64,
    /// Bursts that were read to their end.
    pub bursts: u64,
    /// Cycles from a data-ready that was seen to the next look for one: what a
    /// sample costs. The rest is waiting.
    pub busy_cycles: u64,
}

/// What the callbacks see.
pub(super) struct Shared {
    pub(super) avr: *mut ffi::avr_t,
    pub(super) uart: *mut ffi::avr_uart_t,
    pub(super) twi_input: *mut ffi::avr_irq_t,
    pub(super) sensor: Mpu6050,
    /// Cycles before the last reset.
    pub(super) past: u64,
    pub(super) sent: Vec<Sent>,
    pub(super) bus: Bus,
    pub(super) ready_cycle: Option<u64>,
    pub(super) burst_done: bool,
}

/// Cycles a bit of the UART (data sheet, table 24-1).
///
/// # Safety
///
/// `avr` has to be valid.
pub(super) unsafe fn cycles_per_bit(avr: *mut ffi::avr_t) -> u64 {
    // SAFETY: the registers of an ATmega328P lie within its data.
    unsafe {
        let data = (*avr).data;
        let divider = u64::from(*data.add(UBRR0L)) | (u64::from(*data.add(UBRR0H)) & 0x0f) << 8;
        let samples = if *data.add(UCSR0A) & U2X0 != 0 { 8 } else { 16 };
        (divider + 1) * samples
    }
}

/// The board sends a byte. simavr asks for its duration right after this.
pub(super) unsafe extern "C" fn on_uart(_: *mut ffi::avr_irq_t, value: u32, param: *mut c_void) {
    // SAFETY: `param` is the `Shared` of the board that is running, which nobody
    // else borrows meanwhile.
    unsafe {
        let shared = &mut *param.cast::<Shared>();
        let per_bit = cycles_per_bit(shared.avr);
        (*shared.uart).cycles_per_byte = 10 * per_bit;
        shared.sent.push(Sent {
            byte: value as u8,
            time_s: (shared.past + (*shared.avr).cycle) as f64 / FREQUENCY_HZ,
            baud: FREQUENCY_HZ / per_bit as f64,
        });
    }
}

/// Something on the I²C bus (`avr_twi_msg_t` of avr_twi.h: message, address and
/// data in the upper three bytes).
pub(super) unsafe extern "C" fn on_twi(_: *mut ffi::avr_irq_t, value: u32, param: *mut c_void) {
    let [_, message, address, data] = value.to_le_bytes();
    let message = u32::from(message);
    let reply = |message: u32, data: u8| u32::from_le_bytes([0, message as u8, address, data]);
    // SAFETY: `param` as in `on_uart`. Raising the input of the unit comes back to
    // simavr only.
    unsafe {
        let shared = &mut *param.cast::<Shared>();
        let cycle = shared.past + (*shared.avr).cycle;
        if message & ffi::TWI_COND_START != 0 {
            shared.bus.starts += 1;
            let reads = address & 1 != 0;
            if !reads {
                shared.look(cycle);
                let data = (*shared.avr).data;
                let prescale = 2 * (u64::from(*data.add(TWSR)) & 3);
                (*shared.avr).cycle += 10 * (16 + ((2 * u64::from(*data.add(TWBR))) << prescale));
            }
            let now_s = (shared.past + (*shared.avr).cycle) as f64 / FREQUENCY_HZ;
            if shared.sensor.start(now_s, address >> 1, reads) {
                ffi::avr_raise_irq(shared.twi_input, reply(ffi::TWI_COND_ACK, 1));
            }
        } else if message & ffi::TWI_COND_STOP != 0 {
            shared.sensor.stop();
        } else if message & ffi::TWI_COND_WRITE != 0 {
            if shared.sensor.write(data) {
                ffi::avr_raise_irq(shared.twi_input, reply(ffi::TWI_COND_ACK, 1));
            }
        } else if message & ffi::TWI_COND_READ != 0 {
            let register = shared.sensor.pointer();
            let byte = shared.sensor.read();
            match register {
                Some(INT_STATUS) if byte & DATA_READY != 0 => shared.ready_cycle = Some(cycle),
                Some(GYRO_ZOUT_L) => shared.burst_done = true,
                _ => {}
            }
            ffi::avr_raise_irq(shared.twi_input, reply(ffi::TWI_COND_READ, byte));
        }
    }
}

impl Shared {
    /// A new look at the sensor: the sample before it is dealt with.
    fn look(&mut self, cycle: u64) {
        if self.burst_done
            && let Some(ready) = self.ready_cycle.take()
        {
            self.bus.busy_cycles += cycle - ready;
            self.bus.bursts += 1;
        }
        self.burst_done = false;
    }
}

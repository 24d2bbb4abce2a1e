//! What simavr calls when the board sends a byte or uses its I²C bus.

use std::ffi::c_void;

use simavr_ffi as ffi;

use super::FREQUENCY_HZ;
use crate::sensor::Mpu6050;

/// Addresses of the ATmega328P's registers in data space (data sheet, section 36).
const TWBR: usize = 0xb8;
const TWSR: usize = 0xb9;
const UCSR0A: usize = 0xc0;
const UBRR0L: usize = 0xc4;
const UBRR0H: usize = 0xc5;
const U2X0: u8 = 0x02;

/// What the callbacks see.
pub(super) struct Shared {
    pub(super) avr: *mut ffi::avr_t,
    pub(super) uart: *mut ffi::avr_uart_t,
    pub(super) twi_input: *mut ffi::avr_irq_t,
    pub(super) sensor: Mpu6050,
    /// Cycles before the last reset.
    pub(super) past: u64,
    /// What the board sent.
    pub(super) sent: Vec<u8>,
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
        (*shared.uart).cycles_per_byte = 10 * cycles_per_bit(shared.avr);
        shared.sent.push(value as u8);
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
        if message & ffi::TWI_COND_START != 0 {
            let reads = address & 1 != 0;
            if !reads {
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
            let byte = shared.sensor.read();
            ffi::avr_raise_irq(shared.twi_input, reply(ffi::TWI_COND_READ, byte));
        }
    }
}

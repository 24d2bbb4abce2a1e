//! The Arduino Uno: an ATmega328P at 16 MHz by simavr, its I²C bus on a
//! [`Mpu6050`], its UART on two queues.
//!
//! Three things are not as simavr has them, because figures are measured here:
//! a byte on the UART takes 10 bits, not 11; the address that starts a write
//! takes its ten clocks on the bus, not none; and a reset of the processor does
//! not turn back time.

// The only unsafe code of this crate: simavr is a C library. Everything it is
// given a pointer to belongs to one `Uno` and is freed with it; the callbacks run
// on the thread that calls `avr_run`, and only in that call.
#![allow(unsafe_code)]

use std::collections::VecDeque;
use std::ffi::{CString, c_void};
use std::os::unix::ffi::OsStrExt as _;
use std::path::Path;

use simavr_ffi as ffi;

use crate::sensor::{FaultKind, Mpu6050, Reading};

/// Clock of the Uno, Hz.
const FREQUENCY_HZ: f64 = 16e6;

/// Addresses of registers in data space (data sheet, section 36).
const MCUSR: usize = 0x54;
const TWBR: usize = 0xb8;
const TWSR: usize = 0xb9;
const UCSR0A: usize = 0xc0;
const UBRR0L: usize = 0xc4;
const UBRR0H: usize = 0xc5;
const U2X0: u8 = 0x02;
/// A bit of MCUSR.
const EXTERNAL_RESET: u8 = 0x02;
/// Number of the interrupt of the I²C unit, from 0.
const TWI_VECTOR: u8 = 24;
/// `rjmp .-2`: a loop that never ends.
const HANG: [u8; 2] = [0xff, 0xcf];

/// Cycles between two looks at what comes from outside: a tenth of a byte.
const SLICE: u64 = 160;

/// An Arduino Uno with a sensor on its bus.
pub struct Uno {
    avr: *mut ffi::avr_t,
    shared: *mut Shared,
    uart_input: *mut ffi::avr_irq_t,
    twi_vector: *mut ffi::avr_int_vector_t,
    incoming: VecDeque<u8>,
    next_byte: u64,
    /// Where the program hangs in the flash, and the instruction that was there.
    hung: Option<(*mut [u8; 2], [u8; 2])>,
    resets: u32,
    /// It has a bootloader, which reads why it was reset.
    boots: bool,
}

unsafe extern "C" fn silent(
    _: *mut ffi::avr_t,
    _: std::ffi::c_int,
    _: *const std::ffi::c_char,
    _: *mut ffi::__va_list_tag,
) {
}

impl Uno {
    /// A board with `firmware` (an ELF file) in its flash, just powered up.
    ///
    /// # Errors
    ///
    /// Why the file cannot be loaded.
    pub fn new(firmware: &Path, sensor: Mpu6050) -> Result<Self, String> {
        let cannot = |why: &str| format!("{}: {why}", firmware.display());
        let path = CString::new(firmware.as_os_str().as_bytes())
            .map_err(|_| cannot("a zero in the name"))?;
        // SAFETY: the strings outlive the calls; the firmware is a plain C struct
        // that all zeros are valid for (null pointers, empty arrays) and that
        // `elf_read_firmware` fills; `avr` is checked before it is used.
        unsafe {
            ffi::avr_global_logger_set(Some(silent));
            let mut code: ffi::elf_firmware_t = std::mem::zeroed();
            if ffi::elf_read_firmware(path.as_ptr(), &raw mut code) != 0 {
                return Err(cannot("no ELF file of an AVR; firmware/build makes it"));
            }
            let avr = ffi::avr_make_mcu_by_name(c"atmega328p".as_ptr());
            if avr.is_null() || ffi::avr_init(avr) != 0 {
                return Err(cannot("this simavr has no ATmega328P"));
            }
            ffi::avr_load_firmware(avr, &raw mut code);
            (*avr).frequency = FREQUENCY_HZ as u32;
            (*avr).run_cycle_limit = SLICE;
            Self::wire(avr, sensor).ok_or_else(|| cannot("this simavr lacks a peripheral"))
        }
    }

    /// Connects the bus and the UART.
    ///
    /// # Safety
    ///
    /// `avr` has to come from `avr_make_mcu_by_name` and be initialised.
    unsafe fn wire(avr: *mut ffi::avr_t, sensor: Mpu6050) -> Option<Self> {
        // SAFETY: `avr` is valid by contract. An io module of the kind `uart` is
        // the first field of an `avr_uart_t` (avr_uart.h), `vector_count` entries
        // of the vector table are valid. `shared` is freed after `avr_terminate`.
        unsafe {
            let mut uart: *mut ffi::avr_uart_t = std::ptr::null_mut();
            let mut io = (*avr).io_port;
            while !io.is_null() {
                if !(*io).kind.is_null() && std::ffi::CStr::from_ptr((*io).kind) == c"uart" {
                    uart = io.cast();
                }
                io = (*io).next;
            }
            let count = usize::from((*avr).interrupts.vector_count);
            let twi_vector = (*avr)
                .interrupts
                .vector
                .iter()
                .take(count)
                .copied()
                .find(|v| (**v).vector == TWI_VECTOR)?;
            let irqs = [
                (b"uar0", ffi::UART_IRQ_INPUT),
                (b"uar0", ffi::UART_IRQ_OUTPUT),
                (b"twi\0", ffi::TWI_IRQ_INPUT),
                (b"twi\0", ffi::TWI_IRQ_OUTPUT),
            ];
            // The name as `AVR_IOCTL_DEF` of sim_io.h.
            let irqs = irqs.map(|(name, index)| {
                ffi::avr_io_getirq(avr, u32::from_be_bytes(*name), index as i32)
            });
            if uart.is_null() || irqs.iter().any(|irq| irq.is_null()) {
                return None;
            }
            let [uart_input, uart_output, twi_input, twi_output] = irqs;
            // Neither printed here nor slowed down while it polls.
            (*uart).flags = 0;
            let shared = Box::into_raw(Box::new(Shared {
                avr,
                uart,
                twi_input,
                sensor,
                past: 0,
                sent: Vec::new(),
            }));
            ffi::avr_irq_register_notify(uart_output, Some(on_uart), shared.cast());
            ffi::avr_irq_register_notify(twi_output, Some(on_twi), shared.cast());
            Some(Self {
                avr,
                shared,
                uart_input,
                twi_vector,
                incoming: VecDeque::new(),
                next_byte: 0,
                hung: None,
                resets: 0,
                boots: false,
            })
        }
    }

    /// A board whose reset button was pressed, with a bootloader (an ELF file) at this address and nothing else
    /// in its flash.
    ///
    /// # Errors
    ///
    /// Why the file cannot be loaded.
    pub fn with_bootloader(file: &Path, address: u16) -> Result<Self, String> {
        let mut board = Self::new(file, Mpu6050::new(|_| Reading::default()))?;
        board.boots = true;
        // SAFETY: `avr` is valid as long as `self`; the register lies within its data.
        unsafe {
            (*board.avr).reset_pc = u32::from(address);
            (*board.avr).pc = u32::from(address);
            *(*board.avr).data.add(MCUSR) = EXTERNAL_RESET;
        }
        Ok(board)
    }

    /// Seconds since power-up, whatever resets there were.
    pub fn time_s(&self) -> f64 {
        self.cycles() as f64 / FREQUENCY_HZ
    }

    /// The sensor.
    pub fn sensor(&mut self) -> &mut Mpu6050 {
        // SAFETY: `shared` is valid as long as `self`, and no callback runs now.
        unsafe { &mut (*self.shared).sensor }
    }

    /// What the board sent since the last call.
    pub fn take_sent(&mut self) -> Vec<u8> {
        // SAFETY: as in `sensor`.
        unsafe { std::mem::take(&mut (*self.shared).sent) }
    }

    /// Resets since power-up, those of the watchdog too.
    pub fn resets(&self) -> u32 {
        self.resets
    }

    /// Bytes to the board, one after the other at its own rate.
    pub fn send(&mut self, bytes: &[u8]) {
        self.incoming.extend(bytes);
    }

    /// Writes to the memory of the program, so that a test need not wait for what
    /// takes an hour; false when it does not lie within the memory.
    pub fn poke(&mut self, address: u16, bytes: &[u8]) -> bool {
        // SAFETY: `avr` is valid as long as `self`, its data go up to `ramend`.
        unsafe {
            let end = usize::from(address) + bytes.len();
            if end > usize::from((*self.avr).ramend) + 1 {
                return false;
            }
            let to = (*self.avr).data.add(usize::from(address));
            to.copy_from_nonoverlapping(bytes.as_ptr(), bytes.len());
        }
        true
    }

    /// Runs the processor for so many seconds of its own time.
    pub fn run(&mut self, seconds: f64) {
        let end = self.cycles() + (seconds * FREQUENCY_HZ) as u64;
        while self.cycles() < end {
            self.outside();
            // SAFETY: `avr` is valid as long as `self`; the callbacks use
            // `shared` only, which nobody borrows now.
            unsafe {
                let before = (*self.avr).cycle;
                let stop = before + SLICE;
                while (*self.avr).cycle < stop {
                    let last = (*self.avr).cycle;
                    let state = ffi::avr_run(self.avr);
                    if (*self.avr).cycle < last {
                        (*self.shared).past += last;
                        self.after_reset();
                        break;
                    }
                    if state == ffi::cpu_Crashed as i32 || state == ffi::cpu_Done as i32 {
                        // As if it hung: only a reset helps.
                        (*self.avr).cycle = stop;
                    }
                }
            }
        }
    }

    fn cycles(&self) -> u64 {
        // SAFETY: both are valid as long as `self`.
        unsafe { (*self.shared).past + (*self.avr).cycle }
    }

    /// What a reset leaves for us to put right.
    fn after_reset(&mut self) {
        self.resets += 1;
        // SAFETY: `avr` is valid as long as `self`; `at` was within its flash.
        unsafe {
            (*self.avr).run_cycle_limit = SLICE;
            // The bootloader of the Uno clears it before the sketch starts.
            if !self.boots {
                *(*self.avr).data.add(MCUSR) = 0;
            }
            if let Some((at, instruction)) = self.hung.take() {
                *at = instruction;
            }
        }
    }

    /// Faults and the bytes that come in.
    fn outside(&mut self) {
        let now = self.cycles();
        let sensor = self.sensor();
        sensor.advance(now as f64 / FREQUENCY_HZ);
        let stuck = sensor.has(FaultKind::StuckBus);
        let hangs = sensor.has(FaultKind::Hang);
        // SAFETY: all pointers are valid as long as `self`; an instruction at `pc`
        // lies within the flash, which has room for a word behind its end.
        unsafe {
            let vector = self.twi_vector;
            if stuck && (*vector).pending() == 0 {
                // simavr raises no interrupt without a number: nothing ends.
                (*vector).vector = 0;
            } else if !stuck {
                (*vector).vector = TWI_VECTOR;
            }
            let in_program = (*self.avr).sreg[7] != 0 && (*self.avr).interrupts.running_ptr == 0;
            if hangs && in_program && self.hung.is_none() {
                let at = (*self.avr).flash.add((*self.avr).pc as usize);
                let at = at.cast::<[u8; 2]>();
                self.hung = Some((at, std::mem::replace(&mut *at, HANG)));
            }
            let per_byte = 10 * cycles_per_bit(self.avr);
            (*(*self.shared).uart).cycles_per_byte = per_byte;
            if now >= self.next_byte
                && let Some(byte) = self.incoming.pop_front()
            {
                ffi::avr_raise_irq(self.uart_input, u32::from(byte));
                self.next_byte = now + per_byte;
            }
        }
    }
}

impl Drop for Uno {
    fn drop(&mut self) {
        // SAFETY: after `avr_terminate` no callback runs any more. simavr has no
        // call that frees the processor itself: its few kilobytes stay.
        unsafe {
            ffi::avr_terminate(self.avr);
            drop(Box::from_raw(self.shared));
        }
    }
}

/// What the callbacks see.
struct Shared {
    avr: *mut ffi::avr_t,
    uart: *mut ffi::avr_uart_t,
    twi_input: *mut ffi::avr_irq_t,
    sensor: Mpu6050,
    /// Cycles before the last reset.
    past: u64,
    /// What the board sent.
    sent: Vec<u8>,
}

/// Cycles a bit of the UART (data sheet, table 24-1).
///
/// # Safety
///
/// `avr` has to be valid.
unsafe fn cycles_per_bit(avr: *mut ffi::avr_t) -> u64 {
    // SAFETY: the registers of an ATmega328P lie within its data.
    unsafe {
        let data = (*avr).data;
        let divider = u64::from(*data.add(UBRR0L)) | (u64::from(*data.add(UBRR0H)) & 0x0f) << 8;
        let samples = if *data.add(UCSR0A) & U2X0 != 0 { 8 } else { 16 };
        (divider + 1) * samples
    }
}

/// The board sends a byte. simavr asks for its duration right after this.
unsafe extern "C" fn on_uart(_: *mut ffi::avr_irq_t, value: u32, param: *mut c_void) {
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
unsafe extern "C" fn on_twi(_: *mut ffi::avr_irq_t, value: u32, param: *mut c_void) {
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

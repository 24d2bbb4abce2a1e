//! Addresses and bits of the registers that the model knows (MPU-6000/MPU-6050
//! Register Map and Descriptions, revision 4.2).

pub const XA_OFFS_H: u8 = 0x06;
pub const XG_OFFS_H: u8 = 0x13;
pub const SMPLRT_DIV: u8 = 0x19;
pub const CONFIG: u8 = 0x1a;
pub const GYRO_CONFIG: u8 = 0x1b;
pub const ACCEL_CONFIG: u8 = 0x1c;
pub const INT_PIN_CFG: u8 = 0x37;
pub const INT_ENABLE: u8 = 0x38;
pub const INT_STATUS: u8 = 0x3a;
pub const ACCEL_XOUT_H: u8 = 0x3b;
#[cfg(feature = "emulator")]
pub const GYRO_ZOUT_L: u8 = 0x48;
pub const PWR_MGMT_1: u8 = 0x6b;
pub const FIFO_R_W: u8 = 0x74;
pub const WHO_AM_I: u8 = 0x75;

/// Number of registers.
pub const COUNT: usize = 128;

/// What `WHO_AM_I` reads: the upper six bits of the address 0x68.
pub const IDENTITY: u8 = 0x68;
/// `PWR_MGMT_1`: sleep, and a reset of every register.
pub const SLEEP: u8 = 0x40;
pub const DEVICE_RESET: u8 = 0x80;
/// `INT_STATUS` and `INT_ENABLE`: data ready.
pub const DATA_READY: u8 = 0x01;
/// `INT_PIN_CFG`: any read clears the interrupt status.
pub const INT_RD_CLEAR: u8 = 0x10;

/// Registers that a write does not change.
pub fn read_only(register: u8) -> bool {
    matches!(register, INT_STATUS..=0x60 | WHO_AM_I..)
}

//! A virtual board: an Arduino Uno with an MPU6050 that runs the real firmware.
//!
//! Development only: the firmware is tested on it.
//!
//! - [`sensor`]: the registers of the MPU6050, fed by a function of time.
//! - [`uno`]: the processor by [simavr](https://github.com/buserror/simavr).
//!
//! simavr is under the GNU General Public License, version 3. A program that links
//! it is, too: this crate is not published, is no default member of the workspace,
//! and nothing that ships depends on it.

pub mod sensor;
pub mod uno;

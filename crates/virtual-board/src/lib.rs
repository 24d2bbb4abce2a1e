//! A virtual board: an Arduino Uno with an MPU6050 that runs the real firmware.
//!
//! Development only. The firmware is tested on it, and people
//! without a board can try it and the logger.
//!
//! - [`sensor`]: the registers of the MPU6050, fed by a recording or by hands.
//! - [`uno`]: the processor by [simavr](https://github.com/buserror/simavr).
//! - [`port`]: a pseudo-terminal that is opened like the port of a board.
//!
//! simavr is under the GNU General Public License, version 3. A program that links
//! it is, too: this crate is not published, is no default member of the workspace,
//! and nothing that ships depends on it.

pub mod port;
pub mod sensor;
pub mod uno;

//! Writes a `.cwa` file of a simulated device that is worn:
//!
//!     cargo run --release --example wear -- FILE [HOURS] [packed|plain|gyro] [SECONDS [SEED]]
//!
//! SECONDS is the longest rest, 1800. A week at 100 Hz, as in CONTRIBUTING.md: `wear week.cwa 168`; the file of
//! docs/wearables.md: `wear examples/simulated-wear/wrist.cwa 0.05 packed 30`. The errors of the sensor
//! stand in tests/support/wear.rs.

use std::fs::File;
use std::io::{BufWriter, Write as _};

#[path = "../../../../tests/support/axivity.rs"]
#[allow(
    dead_code,
    clippy::unwrap_used,
    reason = "support of tests, which use more of it"
)]
mod cwa;
#[path = "../../../../tests/support/wear.rs"]
#[allow(dead_code, reason = "the tests use more of it")]
mod wear;

use cwa::{Coding, Device};
use wear::Wear;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let path = arguments.first().ok_or("the file to write is missing")?;
    let hours: f64 = arguments.get(1).map_or(Ok(1.0), |text| text.parse())?;
    let coding = match arguments.get(2).map(String::as_str) {
        None | Some("packed") => Coding::Packed,
        Some("plain") => Coding::Plain,
        Some("gyro") => Coding::WithGyro,
        Some(other) => return Err(format!("{other} is not packed, plain or gyro").into()),
    };
    let mut device = Device {
        true_rate_hz: 100.0,
        ..Device::new(coding)
    };
    let longest_s: f64 = arguments.get(3).map_or(Ok(1800.0), |text| text.parse())?;
    let seed: u64 = arguments.get(4).map_or(Ok(1), |text| text.parse())?;
    let mut wear = Wear::new(&device, 5.0_f64.min(0.5 * longest_s)..longest_s, seed);
    let mut out = BufWriter::new(File::create_new(path)?);
    out.write_all(&device.header())?;
    while device.samples as f64 / device.true_rate_hz < hours * 3600.0 {
        out.write_all(&wear.block(&mut device))?;
    }
    out.flush()?;
    Ok(())
}

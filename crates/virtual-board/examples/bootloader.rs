//! An Uno that was just reset, with a bootloader (an ELF file) and nothing else in its flash; its serial port is standard
//! input and output.
//!
//!     cargo run -p virtual-board --example bootloader -- ATmegaBOOT.elf

use std::io::{Read as _, Write as _};
use std::path::Path;
use std::sync::mpsc::{TryRecvError, channel};
use std::time::{Duration, Instant};

use virtual_board::uno::Uno;

/// Where the 2048 bytes of the older bootloader lie.
const ADDRESS: u16 = 0x7800;
/// The board is as fast as the clock, by steps of this time, s.
const STEP_S: f64 = 1e-3;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = std::env::args().nth(1).ok_or("a bootloader is missing")?;
    let mut board = Uno::with_bootloader(Path::new(&file), ADDRESS)?;
    let (to_board, received) = channel();
    std::thread::spawn(move || {
        let mut bytes = [0; 256];
        let mut input = std::io::stdin().lock();
        while let Ok(n @ 1..) = input.read(&mut bytes) {
            if to_board.send(bytes[..n].to_vec()).is_err() {
                break;
            }
        }
    });
    let started = Instant::now();
    let mut output = std::io::stdout().lock();
    loop {
        match received.try_recv() {
            Ok(bytes) => board.send(&bytes),
            Err(TryRecvError::Empty) => {}
            Err(TryRecvError::Disconnected) => return Ok(()),
        }
        board.run(STEP_S);
        output.write_all(&board.take_sent())?;
        output.flush()?;
        let ahead_s = board.time_s() - started.elapsed().as_secs_f64();
        std::thread::sleep(Duration::from_secs_f64(ahead_s.max(0.0)));
    }
}

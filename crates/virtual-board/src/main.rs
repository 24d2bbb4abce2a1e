//! A board for people without one: an emulated Arduino Uno with an MPU6050, on a
//! pseudo-terminal that any program opens like a serial port.

use std::io::{BufRead as _, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use clap::Parser;
use gravical::recording::{ReadOptions, read};
use gravical::{Error, Result};
use virtual_board::port::Port;
use virtual_board::sensor::{COMMANDS, Hands, Mpu6050, recorded};
use virtual_board::uno::Uno;

/// An emulated Arduino Uno with an MPU6050 that runs the real firmware.
///
/// Prints the port to open. Opening it resets the board, as with a real one.
/// Ends with Ctrl-C.
#[derive(Debug, Parser)]
#[command(version)]
struct Args {
    /// What the sensor feels: a recording, over and over
    #[arg(long, value_name = "FILE", required_unless_present = "hands")]
    recording: Option<PathBuf>,
    /// The sensor lies where you type that it lies, a line each: +x, -z, push; unplug, plug
    #[arg(long, conflicts_with = "recording")]
    hands: bool,
    /// How far your placements are off, ° (sd of each of two components)
    #[arg(long, value_name = "DEG", default_value_t = 1.0, requires = "hands")]
    tilt: f64,
    /// Write what the sensor in your hands is in truth
    #[arg(long, value_name = "FILE", requires = "hands")]
    truth: Option<PathBuf>,
    /// Which sensor is in your hands
    #[arg(long, default_value_t = 1, requires = "hands")]
    seed: u64,
    /// The program of the board [default: $GRAVICAL_FIRMWARE, else built now]
    #[arg(long, value_name = "ELF")]
    firmware: Option<PathBuf>,
    /// Symbolic link to the port
    #[arg(long, value_name = "PATH")]
    link: Option<PathBuf>,
    /// What goes wrong, seconds after the opening: no-answer@5-8,stuck-bus@12-13,
    /// who-am-i=0x70@30-33,dip@40,hang@50
    #[arg(long, value_name = "SPEC", default_value = "")]
    faults: String,
}

/// Seconds of the board between two looks at the port.
const STEP_S: f64 = 0.001;
/// Seconds that the boot loader takes after the opening.
const BOOTLOADER_S: f64 = 1.0;

fn main() -> ExitCode {
    match run(&Args::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            print_error(&error);
            ExitCode::from(2)
        }
    }
}

fn print_error(error: &Error) {
    eprintln!("error: {error}");
    if let Some(hint) = error.hint() {
        eprintln!("hint: {hint}");
    }
}

fn run(args: &Args) -> Result<()> {
    let hands = args.hands.then(|| take_in_hand(args)).transpose()?;
    let mut sensor = match (&hands, &args.recording) {
        (None, Some(file)) => Mpu6050::new(recorded(&read(file, &ReadOptions::default())?)?),
        (Some(hands), _) => {
            let hands = hands.clone();
            Mpu6050::new(move |time_s| hands.at(time_s))
        }
        (None, None) => return Err(Error::usage("usage", "--recording or --hands")),
    };
    sensor.faults = args.faults.parse()?;
    let firmware = match (&args.firmware, std::env::var_os("GRAVICAL_FIRMWARE")) {
        (Some(file), _) => file.clone(),
        (None, Some(file)) => file.into(),
        (None, None) => build_firmware()?,
    };
    let mut uno = Uno::new(&firmware, sensor)?;
    let mut port = Some(open_port(args)?);
    match &hands {
        Some(hands) => {
            eprintln!("The sensor lies with z up. Type what happens to it ({COMMANDS}).");
            let typed = read_lines();
            serve(&mut uno, &mut port, |port| {
                for line in typed.try_iter() {
                    if let Err(error) = act(args, hands, port, line.trim()) {
                        print_error(&error);
                    }
                }
            });
        }
        None => {
            eprintln!("The recording starts again after its end. Ctrl-C ends.");
            serve(&mut uno, &mut port, |_| ());
        }
    }
    Ok(())
}

/// A new port; prints what to open.
fn open_port(args: &Args) -> Result<Port> {
    let port = Port::new(args.link.as_deref())?;
    println!("{}", port.path().display());
    // The reader of a pipe waits for this line.
    let _ = std::io::stdout().flush();
    Ok(port)
}

/// A sensor in somebody's hands.
fn take_in_hand(args: &Args) -> Result<Hands> {
    let hands = Hands::new(args.seed, args.tilt)?;
    if let Some(file) = &args.truth {
        let text =
            serde_json::to_string_pretty(&hands.truth()).map_err(|e| Error::io(file, e.into()))?;
        std::fs::write(file, text + "\n").map_err(|e| Error::io(file, e))?;
    }
    Ok(hands)
}

/// Lines from standard input, read in a thread of their own: the board does not wait.
fn read_lines() -> Receiver<String> {
    let (sender, lines) = channel();
    std::thread::spawn(move || {
        // What is no UTF-8 is no command, and is answered as one that is not known.
        for line in std::io::stdin().lock().split(b'\n') {
            let Ok(line) = line else { break };
            let line = String::from_utf8_lossy(&line).into_owned();
            if sender.send(line).is_err() {
                break;
            }
        }
    });
    lines
}

/// Does what was typed.
fn act(args: &Args, hands: &Hands, port: &mut Option<Port>, line: &str) -> Result<()> {
    match line {
        "" => {}
        // Whoever has the port open loses it.
        "unplug" => *port = None,
        "plug" if port.is_none() => *port = Some(open_port(args)?),
        _ => eprintln!("{line}: rests in {:.1} s", hands.act(line)?),
    }
    Ok(())
}

/// Runs the board beside the clock on the wall; `look` is called between two steps of it.
/// Without a port nobody hears it.
fn serve(uno: &mut Uno, port: &mut Option<Port>, look: impl Fn(&mut Option<Port>)) {
    let (mut wall, mut board_s) = (Instant::now(), uno.time_s());
    loop {
        if port.as_mut().is_some_and(Port::opened) {
            uno.reset(BOOTLOADER_S);
            let now_s = uno.time_s();
            uno.sensor().restart(now_s);
            eprintln!("opened: reset");
        }
        look(port);
        let ahead_s = uno.time_s() - board_s - wall.elapsed().as_secs_f64();
        let received = port.as_mut().map(Port::receive).unwrap_or_default();
        // Far ahead it is in the boot loader, which swallows what comes.
        if ahead_s < 5.0 * STEP_S {
            uno.send(&received);
        }
        if ahead_s > 0.0 {
            std::thread::sleep(Duration::from_secs_f64(ahead_s.min(0.002)));
            continue;
        }
        // What is more than a tenth of a second late is not made up for.
        if ahead_s < -0.1 {
            (wall, board_s) = (Instant::now(), uno.time_s());
        }
        uno.run(STEP_S);
        let sent = uno.take_sent();
        if let Some(port) = port {
            port.send(&sent);
        }
    }
}

/// Builds the firmware as firmware/build does, below target.
fn build_firmware() -> Result<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let folder = root.join("target/firmware");
    let script = root.join("firmware/build");
    let done = Command::new(&script)
        .arg(&folder)
        .output()
        .map_err(|e| Error::io(&script, e))?;
    if !done.status.success() {
        return Err(Error::input(
            "firmware",
            format!(
                "the firmware cannot be built: {}",
                String::from_utf8_lossy(&done.stderr).trim()
            ),
        )
        .with_hint("sudo apt install arduino-core-avr, or --firmware ELF"));
    }
    Ok(folder.join("mpu6050_logger.elf"))
}

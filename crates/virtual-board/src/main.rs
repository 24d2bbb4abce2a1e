//! A board for people without one: an emulated Arduino Uno with an MPU6050, on a
//! pseudo-terminal that any program opens like a serial port.

use std::io::{BufRead as _, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use clap::Parser;
use gravical::simulate::{Scenario, SimulateOptions, StaticOptions};
use gravical::{Error, Result};
use virtual_board::port::Port;
use virtual_board::sensor::{
    COMMANDS, Command as HandsDo, Faults, Hands, Mpu6050, Rows, SensorOptions,
};
use virtual_board::uno::Uno;

/// An emulated Arduino Uno with an MPU6050 that runs the real firmware.
///
/// Prints the port to open. Opening it resets the board, as with a real one.
/// Ends with Ctrl-C.
#[derive(Debug, Parser)]
#[command(version)]
struct Args {
    /// What the sensor feels: a recording, over and over
    #[arg(long, value_name = "FILE", conflicts_with = "simulate")]
    recording: Option<PathBuf>,
    /// What the sensor feels: static, line or poses, over and over
    #[arg(long, value_name = "SCENARIO", default_value = "poses")]
    simulate: String,
    /// The sensor lies where you type that it lies, a line each: +x, -z, push; unplug, plug
    #[arg(long, conflicts_with_all = ["recording", "simulate"])]
    hands: bool,
    /// How far your placements are off, ° (sd of each of two components)
    #[arg(long, value_name = "DEG", default_value_t = 1.0, requires = "hands")]
    tilt: f64,
    /// Write what the sensor in your hands is in truth
    #[arg(long, value_name = "FILE", requires = "hands")]
    truth: Option<PathBuf>,
    /// Seed of the simulation
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// The program of the board [default: $GRAVICAL_FIRMWARE, else built now]
    #[arg(long, value_name = "ELF")]
    firmware: Option<PathBuf>,
    /// Symbolic link to the port
    #[arg(long, value_name = "PATH")]
    link: Option<PathBuf>,
    /// Times real time, or max: as fast as it goes while the port is open
    #[arg(long, default_value = "1")]
    speed: String,
    /// What goes wrong, seconds after the opening: no-answer@5-8,stuck-bus@12-13,
    /// frozen-x@20-25,who-am-i=0x70@30-33,dip@40,hang@50
    #[arg(long, value_name = "SPEC", default_value = "")]
    faults: String,
    /// How much faster the sensor's clock runs than the board's, ppm
    #[arg(
        long,
        value_name = "PPM",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    clock_error: f64,
    /// Seconds that the boot loader takes after the opening
    #[arg(long, value_name = "SECONDS", default_value_t = 1.0)]
    bootloader: f64,
    /// End after so many seconds of the board's time
    #[arg(long, value_name = "SECONDS")]
    duration: Option<f64>,
}

/// Seconds of the board between two looks at the port.
const STEP_S: f64 = 0.001;

fn main() -> ExitCode {
    match run(&Args::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            if let Some(hint) = error.hint() {
                eprintln!("hint: {hint}");
            }
            ExitCode::from(2)
        }
    }
}

fn run(args: &Args) -> Result<()> {
    let speed = speed(&args.speed)?;
    let faults: Faults = args.faults.parse()?;
    if !args.clock_error.is_finite() || args.clock_error.abs() > 1e5 {
        return Err(Error::usage(
            "usage",
            "--clock-error: -100000 to 100000 ppm",
        ));
    }
    if !(0.0..=60.0).contains(&args.bootloader) {
        return Err(Error::usage("usage", "--bootloader: 0 to 60 s"));
    }
    if args.duration.is_some_and(|s| s.is_nan() || s <= 0.0) {
        return Err(Error::usage("usage", "--duration: more than 0 s"));
    }
    let options = SensorOptions {
        clock_error_ppm: args.clock_error,
        faults,
        ..SensorOptions::default()
    };
    let hands = args.hands.then(|| in_hand(args)).transpose()?;
    let (sensor, says) = match &hands {
        Some(hands) => (
            Mpu6050::new(hands.clone(), options),
            format!("The sensor lies with z up. Type what happens to it ({COMMANDS})."),
        ),
        None => {
            let rows = match &args.recording {
                Some(file) => Rows::from_file(file)?,
                None => Rows::simulated(&args.simulate, args.seed)?,
            };
            let length_s = rows.duration_s();
            let says = format!("The motion lasts {length_s:.1} s and begins again.");
            (Mpu6050::new(rows, options), says)
        }
    };
    let firmware = match (&args.firmware, std::env::var_os("GRAVICAL_FIRMWARE")) {
        (Some(file), _) => file.clone(),
        (None, Some(file)) => file.into(),
        (None, None) => built()?,
    };
    let mut uno = Uno::new(&firmware, sensor)?;
    let mut port = Some(Port::new(args.link.as_deref())?);
    announce(&port);
    eprintln!("{says} Ctrl-C ends.");
    let typed = hands.is_some().then(typed);
    serve(args, &mut uno, &mut port, speed, |port| {
        let Some((hands, typed)) = hands.as_ref().zip(typed.as_ref()) else {
            return;
        };
        for line in typed.try_iter() {
            match line.trim() {
                // Whoever has the port open loses it.
                "unplug" => *port = None,
                "plug" if port.is_none() => match Port::new(args.link.as_deref()) {
                    Ok(new) => {
                        *port = Some(new);
                        announce(port);
                    }
                    Err(error) => eprintln!("{error}"),
                },
                _ => act(hands, &line),
            }
        }
    });
    Ok(())
}

/// Prints the port to open.
fn announce(port: &Option<Port>) {
    if let Some(port) = port {
        println!("{}", port.path().display());
        // The reader of a pipe waits for this line.
        let _ = std::io::stdout().flush();
    }
}

/// A sensor in somebody's hands.
fn in_hand(args: &Args) -> Result<Hands> {
    let hands = Hands::new(&SimulateOptions {
        seed: args.seed,
        tilt_sd_deg: args.tilt,
        ..SimulateOptions::new(Scenario::Static(StaticOptions::default()))
    })?;
    if let Some(file) = &args.truth {
        let text =
            serde_json::to_string_pretty(&hands.truth()).map_err(|e| Error::io(file, e.into()))?;
        std::fs::write(file, text + "\n").map_err(|e| Error::io(file, e))?;
    }
    Ok(hands)
}

/// Lines from standard input, read in a thread of their own: the board does not wait.
fn typed() -> Receiver<String> {
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

/// Does what was typed, or says why not.
fn act(hands: &Hands, line: &str) {
    if line.trim().is_empty() {
        return;
    }
    let done = line.parse::<HandsDo>().and_then(|c| hands.act(c));
    match done {
        Ok(duration_s) => eprintln!("{}: rests in {duration_s:.1} s", line.trim()),
        Err(error) => eprintln!("{error}\n{}", error.hint().unwrap_or_default()),
    }
}

/// Runs the board; `look` is called between two steps of it. Without a port nobody hears it.
fn serve(
    args: &Args,
    uno: &mut Uno,
    port: &mut Option<Port>,
    speed: Option<f64>,
    look: impl Fn(&mut Option<Port>),
) {
    let mut pace = Pace::new(uno.time_s());
    while args.duration.is_none_or(|end_s| uno.time_s() < end_s) {
        if port.as_mut().is_some_and(Port::opened) {
            uno.reset(args.bootloader);
            let now_s = uno.time_s();
            uno.sensor().restart(now_s);
            eprintln!("opened: reset");
        }
        look(port);
        let is_open = port.as_ref().is_some_and(Port::is_open);
        let early_s = pace.early_s(uno.time_s(), speed, is_open);
        let received = port.as_mut().map(Port::receive).unwrap_or_default();
        if early_s > 0.0 {
            // Far ahead it is in the boot loader, which swallows what comes.
            if early_s < 5.0 * STEP_S {
                uno.send(&received);
            }
            std::thread::sleep(Duration::from_secs_f64(early_s.min(0.002)));
            continue;
        }
        uno.send(&received);
        uno.run(STEP_S);
        let sent = uno.take_sent();
        let Some(port) = port else { continue };
        let bytes: Vec<u8> = sent.iter().map(|sent| sent.byte).collect();
        // Only a board in real time may lose what is not read.
        port.send(&bytes, if speed.is_none() { 1.0 } else { 0.0 });
    }
}

/// Keeps the board's time beside the clock on the wall.
struct Pace {
    wall: Instant,
    board_s: f64,
}

impl Pace {
    fn new(board_s: f64) -> Self {
        Self {
            wall: Instant::now(),
            board_s,
        }
    }

    /// Seconds that the board is ahead. After more than a tenth of a second behind
    /// it is not made up for.
    fn early_s(&mut self, board_s: f64, speed: Option<f64>, is_open: bool) -> f64 {
        let speed = match speed {
            Some(times) => times,
            None if is_open => {
                *self = Self::new(board_s);
                return 0.0;
            }
            None => 1.0,
        };
        let early_s = (board_s - self.board_s) / speed - self.wall.elapsed().as_secs_f64();
        if early_s < -0.1 {
            *self = Self::new(board_s);
        }
        early_s
    }
}

fn speed(text: &str) -> Result<Option<f64>> {
    if text == "max" {
        return Ok(None);
    }
    match text.parse::<f64>() {
        Ok(times) if (0.001..=1000.0).contains(&times) => Ok(Some(times)),
        _ => Err(Error::usage(
            "usage",
            format!("--speed {text}: a number from 0.001 to 1000, or max"),
        )),
    }
}

/// Builds the firmware as firmware/build does, below target.
fn built() -> Result<PathBuf> {
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

//! `gravical denoise`: a recording, filtered, and what that did to its noise.

use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::ValueEnum;
use gravical::calibration_file::InputFile;
use gravical::denoise::{Channels, DenoiseOptions, Denoised, Edge, FilterSpec, denoise, write};
use gravical::output::one_line;
use gravical::recording::{ReadOptions, Recording, open, read, read_bytes};
use gravical::report;
use gravical::segment::face::AxisMap;
use gravical::{Error, Result};

use crate::options::RecordingArgs;
use crate::report::{ReportArgs, with_origin};
use crate::table::TableArgs;
use crate::text;

/// Filter a recording, and say what the filter does to its noise
///
/// Columns keep their names, units and order; only the filtered channels have new values. The table
/// goes to a file with -o, to a pipe without; the summary to stderr. Smoothing makes plots readable; it
/// does not reduce the drift of velocity or position.
#[derive(Debug, clap::Args)]
#[command(after_help = FILTERS)]
pub struct Args {
    /// Recording, plain or gzip; - is standard input
    #[arg(value_name = "INPUT")]
    input: PathBuf,
    #[command(flatten)]
    pub output: TableArgs,
    #[command(flatten)]
    report: ReportArgs,
    /// A filter, see below; several run in the order in which they are given
    #[arg(short, long = "filter", value_name = "FILTER")]
    filters: Vec<FilterSpec>,
    /// What stands beyond the ends, for savgol and mean
    #[arg(long, value_enum, value_name = "EDGE", default_value = "interp")]
    edge: EdgeArg,
    /// Which channels are filtered
    #[arg(long, value_enum, value_name = "CHANNELS", default_value = "all")]
    channels: ChannelsArg,
    #[command(flatten)]
    recording: RecordingArgs,
}

const FILTERS: &str = "\
Filters:
  savgol:WINDOW,ORDER         Savitzky-Golay: a polynomial over WINDOW samples
  savgol:WINDOW,ORDER,DERIV   its derivative, per s
  butter:ORDER,CUTOFFHz       Butterworth low-pass, forwards and backwards: no delay
  butter:ORDER,LOW-HIGHHz     band-pass
  highpass:ORDER,CUTOFFHz     high-pass
  butter1:… and highpass1:…   the same in one pass, as on a microcontroller: delayed
  hampel:WINDOW,SIGMAS        outliers are replaced by the median of their window
  mean:WINDOW                 moving average

Butterworth filters are down by 3 dB at the cutoff, two passes both together.";

/// [`Edge`] as an option.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum EdgeArg {
    /// The polynomial of the last full window
    Interp,
    /// The last sample, repeated
    Nearest,
    /// The samples mirrored about the last one
    Mirror,
    /// Zeros
    Constant,
}

/// [`Channels`] as an option.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum ChannelsArg {
    /// The accelerometer's
    Accel,
    /// The gyroscope's
    Gyro,
    /// All
    All,
}

/// Filters, writes, tells.
///
/// # Errors
///
/// A filter that cannot be had, a recording or file that cannot be read, a file that
/// is there already, or what the disk says.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let options = options_of(args);
    options.validate()?;
    if args.recording.axes.0 != AxisMap::default() {
        return Err(Error::usage(
            "axes-unused",
            "denoise filters each axis by itself and turns none",
        )
        .with_hint("leave --axes out; `gravical apply --axes` writes the axes of the case")
        .into());
    }
    args.output.check(&args.report, &[&args.input])?;
    let read_options = args.recording.read_options(args.report.is_wanted());
    let source = Source::new(&args.input)?;
    let recording = source.read(&read_options)?;
    let inputs = InputFile::of(std::slice::from_ref(&recording));
    let mut done = denoise(recording, &options)?;
    done.summary.columns = args
        .output
        .write(|out| source.write(&done, &read_options, out))?;
    let document = with_origin(report::denoise(&done.summary), &inputs);
    args.report.write(args.output.force, &document)?;
    if args.output.json {
        text::print_json(&done.summary)?;
    }
    if !args.output.quiet {
        let done = format!(
            "{}: {} rows filtered",
            one_line(&done.summary.input),
            done.summary.rows
        );
        args.output.tell(&done, &document);
        args.report.say();
    }
    Ok(ExitCode::SUCCESS)
}

fn options_of(args: &Args) -> DenoiseOptions {
    DenoiseOptions {
        filters: args.filters.clone(),
        edge: match args.edge {
            EdgeArg::Interp => Edge::Interp,
            EdgeArg::Nearest => Edge::Nearest,
            EdgeArg::Mirror => Edge::Mirror,
            EdgeArg::Constant => Edge::Constant,
        },
        channels: match args.channels {
            ChannelsArg::Accel => Channels::Accel,
            ChannelsArg::Gyro => Channels::Gyro,
            ChannelsArg::All => Channels::All,
        },
        ..DenoiseOptions::default()
    }
}

/// The recording, to be read twice: once for its values, once for the text of its
/// other columns. What can be read only once is kept in memory.
struct Source<'a> {
    path: &'a Path,
    bytes: Option<Vec<u8>>,
}

impl<'a> Source<'a> {
    fn new(path: &'a Path) -> Result<Self> {
        if path.is_file() || (path != Path::new("-") && !path.exists()) {
            return Ok(Source { path, bytes: None });
        }
        let mut bytes = Vec::new();
        let mut reader: Box<dyn Read> = match path.to_str() {
            Some("-") => Box::new(io::stdin().lock()),
            // A folder is refused as by every verb.
            _ => open::open(path, &ReadOptions::default())?.reader,
        };
        reader
            .read_to_end(&mut bytes)
            .map_err(|e| Error::io(path, e))?;
        Ok(Source {
            path,
            bytes: Some(bytes),
        })
    }

    fn read(&self, options: &ReadOptions) -> Result<Recording> {
        match &self.bytes {
            None => read(self.path, options),
            Some(bytes) => read_bytes(bytes, &self.path.display().to_string(), options),
        }
    }

    fn write(
        &self,
        done: &Denoised,
        options: &ReadOptions,
        out: &mut dyn Write,
    ) -> Result<Vec<String>> {
        let input = match &self.bytes {
            None => open::open(self.path, options)?,
            Some(bytes) => {
                let reader = Box::new(io::Cursor::new(bytes.clone()));
                open::from_reader(reader, false).map_err(|e| Error::io(self.path, e))?
            }
        };
        write(done, input, options, out)
    }
}

//! `gravical denoise`: a filtered recording, and the effect on its noise.

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

/// Filter a recording and report the effect on its noise
///
/// Columns keep their names, units and order; only the values of the filtered channels change. The
/// table goes to -o or a pipe, the summary to stderr. Smoothing makes plots readable; it does not
/// reduce the drift of velocity or position.
#[derive(Debug, clap::Args)]
#[command(after_help = FILTERS)]
pub struct Args {
    /// Recording, plain or .gz; - reads standard input
    #[arg(value_name = "INPUT")]
    input: PathBuf,
    #[command(flatten)]
    pub output: TableArgs,
    #[command(flatten)]
    report: ReportArgs,
    /// Filter, see below; repeatable, applied in this order
    #[arg(short, long = "filter", value_name = "FILTER")]
    filters: Vec<FilterSpec>,
    /// How the ends are padded, for savgol and mean
    #[arg(long, value_enum, value_name = "EDGE", default_value = "interp")]
    edge: EdgeArg,
    /// Channels to filter
    #[arg(long, value_enum, value_name = "CHANNELS", default_value = "all")]
    channels: ChannelsArg,
    #[command(flatten)]
    recording: RecordingArgs,
}

const FILTERS: &str = "\
Filters:
  savgol:WINDOW,ORDER         Savitzky-Golay polynomial over WINDOW samples
  savgol:WINDOW,ORDER,DERIV   its derivative, per s
  butter:ORDER,CUTOFFHz       Butterworth low-pass, forward and backward (zero phase)
  butter:ORDER,LOW-HIGHHz     band-pass
  highpass:ORDER,CUTOFFHz     high-pass
  butter1:…, highpass1:…      one pass, causal, as on a microcontroller
  hampel:WINDOW,SIGMAS        outliers replaced by the median of their window
  mean:WINDOW                 moving average
Butterworth filters are 3 dB down at the cutoff, the two passes together.

Example: gravical denoise walk.csv --filter hampel:7,3 --filter butter:4,5Hz -o smooth.csv
How a recording is read (units, columns, rate): options in `gravical denoise --help`.";

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
    /// Accelerometer only
    Accel,
    /// Gyroscope only
    Gyro,
    /// Both
    All,
}

/// Runs the command.
///
/// # Errors
///
/// A filter that does not exist or does not fit the rate, a file that cannot be read, an existing
/// output file, I/O errors.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let options = options_of(args);
    options.validate()?;
    if args.recording.axes.0 != AxisMap::default() {
        return Err(Error::usage(
            "axes-unused",
            "denoise filters each axis separately and does not rotate them",
        )
        .with_hint("remove --axes; `gravical apply --axes` writes the axes of the case")
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
        args.output
            .print_summary(&done, &document, args.report.detail());
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

/// A recording that is read twice: for its values, and for the text of its other columns.
/// Input that can be read only once is kept in memory.
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
            // Refuses a folder.
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

//! Options of the board that is recorded.

use gravical::live::recorder::WantedSettings;
use gravical::recording::ColumnsSpec;

/// The board, and how it is set.
#[derive(Clone, Default, clap::Args)]
#[command(next_help_heading = "Board")]
pub struct BoardArgs {
    /// Serial port [default: the only board plugged in]
    #[arg(long, value_name = "PORT")]
    pub port: Option<String>,
    /// Wait until a board is plugged in and sends data
    #[arg(long)]
    pub wait: bool,
    /// Baud rate
    #[arg(long, value_name = "BAUD", default_value_t = 115_200, value_parser = clap::value_parser!(u32).range(300..=4_000_000))]
    pub baud: u32,
    /// t,ax,ay,az,-,gx,gy,gz in order, or t=ms,ax=… by name
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
    pub columns: Option<ColumnsSpec>,
    #[command(flatten)]
    pub wanted: WantedSettings,
}

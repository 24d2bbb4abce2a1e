//! Why a recording cannot be read.

use std::fmt;
use std::io;

/// Why a recording cannot be read.
#[derive(Debug)]
pub struct Error(Kind);

#[derive(Debug)]
pub(crate) enum Kind {
    Io(io::Error),
    NoTable,
    ColumnsUnknown,
    NoAccelerometer,
    EpochsOfCounts,
    TooLarge(usize),
}

impl Error {
    /// The file cannot be opened or read.
    #[must_use]
    pub fn is_io(&self) -> bool {
        matches!(self.0, Kind::Io(_))
    }

    /// The file holds no rows of numbers.
    #[must_use]
    pub fn is_no_table(&self) -> bool {
        matches!(self.0, Kind::NoTable)
    }

    /// The columns must be named.
    #[must_use]
    pub fn is_columns(&self) -> bool {
        matches!(self.0, Kind::ColumnsUnknown | Kind::NoAccelerometer)
    }

    /// The file holds activity counts, not acceleration.
    #[must_use]
    pub fn is_epochs_of_counts(&self) -> bool {
        matches!(self.0, Kind::EpochsOfCounts)
    }

    /// The columns do not fit into the memory that a recording may take.
    #[must_use]
    pub fn is_too_large(&self) -> bool {
        matches!(self.0, Kind::TooLarge(_))
    }

    /// Whether the numbers may be wrapped in words.
    pub(crate) fn may_be_words(&self) -> bool {
        self.is_columns() || self.is_no_table()
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match &self.0 {
            Kind::Io(e) => return e.fmt(f),
            Kind::NoTable => "no table of samples",
            Kind::ColumnsUnknown => "names and numbers do not show what the columns hold",
            Kind::NoAccelerometer => "no three columns are named as an accelerometer",
            Kind::EpochsOfCounts => "the file holds activity counts per epoch, not acceleration",
            Kind::TooLarge(bytes) => {
                let mib = bytes >> 20;
                return write!(f, "the columns take more than {mib} MiB: cut the file");
            }
        })
    }
}

impl std::error::Error for Error {}

impl From<Kind> for Error {
    fn from(kind: Kind) -> Self {
        Error(kind)
    }
}

impl From<io::Error> for Error {
    fn from(e: io::Error) -> Self {
        Error(Kind::Io(e))
    }
}

//! Which column is which channel: by `--columns`, by the names of the header,
//! or, without a header, by what the numbers look like.

mod content;
mod gyroscope;
mod header;
mod spec;
#[cfg(test)]
mod tests;

use crate::Result;

use super::board;
use super::dialect::Dialect;
use super::finding::Finding;
use super::names::{ColumnName, Quantity};
use super::row::{ACCEL, GYRO, RowScanner, TEMPERATURE, TIME};
use super::timing::TimeUnit;
use super::unit_choice::AccelClaim;
use super::units::{AccelUnit, GyroUnit};

use content::by_content;
pub(crate) use gyroscope::find_gyroscope;
use header::by_names;
pub use spec::ColumnsSpec;
use spec::by_spec;

/// Columns that were chosen, with what their names claim.
#[derive(Debug, Clone)]
pub struct Layout {
    /// Quantity and field (from 0) of each channel that is read.
    pub fields: Vec<(Quantity, usize)>,
    /// What header and board claim of the accelerometer.
    pub accel_claim: AccelClaim,
    /// Unit that the gyroscope's header claims, or the board.
    pub gyro_claim: Option<GyroUnit>,
    /// Counts per °/s that the board claims.
    pub gyro_lsb_per_deg_s: Option<f64>,
    /// Temperatures are counts of an MPU6050, as the board says.
    pub temperature_counts: bool,
    /// The temperature's header claims a unit.
    temperature_claimed: bool,
    /// Unit that the time's header claims.
    pub time_claim: Option<TimeUnit>,
}

impl Layout {
    /// Field of a channel, from 0.
    #[must_use]
    pub fn field(&self, quantity: Quantity) -> Option<usize> {
        self.fields
            .iter()
            .find(|(q, _)| *q == quantity)
            .map(|(_, f)| *f)
    }

    /// True when all three axes of the gyroscope are there.
    #[must_use]
    pub fn has_gyro(&self) -> bool {
        (0..3).all(|i| self.field(Quantity::Gyro(i)).is_some())
    }

    /// A scanner that reads these columns.
    #[must_use]
    pub fn scanner(&self, dialect: &Dialect) -> RowScanner {
        let mut scanner = RowScanner::new(dialect.delimiter, dialect.decimal_comma, dialect.fields);
        for &(quantity, field) in &self.fields {
            match quantity {
                Quantity::Time => scanner.assign(field, TIME),
                Quantity::Accel(i) => scanner.assign(field, ACCEL + i),
                Quantity::Gyro(i) => scanner.assign(field, GYRO + i),
                Quantity::Temperature => scanner.assign(field, TEMPERATURE),
                Quantity::Label => scanner.assign_label(field),
                Quantity::Index => {}
            }
        }
        if self.temperature_counts {
            scanner.convert_temperature();
        }
        scanner
    }

    /// Takes from the board's own line what no header says: that values are counts, and
    /// of which range.
    pub(super) fn claim_of_board(&mut self, metadata: &[(String, String)]) {
        let Some(board) = board::of_counts(metadata) else {
            return;
        };
        if self.accel_claim.unit.is_none() {
            self.accel_claim = AccelClaim {
                unit: Some(AccelUnit::Counts),
                lsb_per_g: Some(board.lsb_per_g()),
            };
        }
        if self.gyro_claim.is_none() {
            self.gyro_claim = Some(GyroUnit::Counts);
            self.gyro_lsb_per_deg_s = board.lsb_per_deg_s();
        }
        self.temperature_counts = !self.temperature_claimed;
    }
}

/// Finds the columns.
///
/// # Errors
///
/// `no-accelerometer` or `columns-unknown` (input) when they cannot be found,
/// with the names that are there; `columns-missing` (usage) when `--columns`
/// names one that is not.
pub fn find(
    dialect: &Dialect,
    spec: Option<&ColumnsSpec>,
    findings: &mut Vec<Finding>,
) -> Result<Layout> {
    match (spec, &dialect.header) {
        (Some(spec), _) => by_spec(dialect, spec),
        (None, Some(header)) => by_names(&header.names, findings),
        (None, None) => by_content(dialect, findings),
    }
}

fn with_claims(fields: Vec<(Quantity, usize)>, claims: &[(Quantity, ColumnName)]) -> Layout {
    let unit = |of: Quantity| {
        claims
            .iter()
            .find(|(q, _)| *q == of)
            .and_then(|(_, c)| c.unit.as_deref())
    };
    Layout {
        accel_claim: AccelClaim {
            unit: unit(Quantity::Accel(0)).and_then(AccelUnit::parse),
            lsb_per_g: None,
        },
        gyro_lsb_per_deg_s: None,
        temperature_counts: false,
        temperature_claimed: unit(Quantity::Temperature).is_some(),
        gyro_claim: unit(Quantity::Gyro(0)).and_then(GyroUnit::parse),
        time_claim: unit(Quantity::Time).and_then(TimeUnit::parse),
        fields,
    }
}

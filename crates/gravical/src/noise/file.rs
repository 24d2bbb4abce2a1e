//! The file of a result: its JSON.

use std::path::Path;

use super::NoiseResult;
use crate::calibration_file::{InputFile, InputRole};
use crate::{Error, Result};

/// Value of `format`.
pub const NOISE_FORMAT: &str = "gravical-noise/1";

#[cfg(feature = "schema")]
impl NoiseResult {
    /// JSON schema of the file.
    #[must_use]
    pub fn schema() -> serde_json::Value {
        schemars::schema_for!(NoiseResult).to_value()
    }
}

/// Reads the result that `gravical noise` wrote.
///
/// # Errors
///
/// `not-noise` for any other file; errors of the file system.
pub fn read_noise(path: &Path) -> Result<(NoiseResult, InputFile)> {
    InputFile::read(path, InputRole::Noise, parse)
}

fn parse(bytes: &[u8]) -> Result<NoiseResult> {
    let hint = "--noise takes the file of `gravical noise REST.csv -o noise.json`";
    let result: NoiseResult = serde_json::from_slice(bytes).map_err(|e| {
        Error::input("not-noise", format!("no result of `gravical noise`: {e}")).with_hint(hint)
    })?;
    if result.format != NOISE_FORMAT {
        return Err(Error::input(
            "not-noise",
            format!("the format is {:?}, not {NOISE_FORMAT}", result.format),
        )
        .with_hint(hint));
    }
    let numbers = result.channels.iter().flat_map(|c| [c.n, c.b, c.k]);
    if numbers
        .flatten()
        .any(|e| !(e.value.is_finite() && e.value > 0.0))
    {
        return Err(
            Error::input("not-noise", "a parameter is not a positive number").with_hint(hint),
        );
    }
    Ok(result)
}

//! Input files of a result.

use std::borrow::Cow;
use std::io::Read as _;

use gravical_judge::numfmt::words;
use gravical_recording::hash::sha256;
use serde::{Deserialize, Serialize};

use crate::problem::Problem;
use crate::recording::Recording;
use crate::{Error, Result};
use gravical_recording::source::Named;

/// Largest size of a calibration or a list, which are read at once.
const MAX_BYTES: u64 = 16 << 20;

/// An input file of a result.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct InputFile {
    /// Path as given.
    pub path: String,
    /// SHA-256 of the file, hexadecimal; null for standard input and imports.
    pub sha256: Option<String>,
    /// Role of the file.
    #[serde(default)]
    pub role: InputRole,
}

/// Role of an input file.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum InputRole {
    /// Samples of the session, or of the motion.
    #[default]
    Recording,
    /// The gyroscope of the recording before it.
    Gyroscope,
    /// The poses in the recording.
    Sections,
    /// Temperature drift.
    Soak,
    /// Parameters of the sensor.
    Calibration,
    /// Noise of the sensor, by `gravical noise`.
    Noise,
    /// A role of a later version.
    #[serde(other)]
    Other,
}

impl InputFile {
    /// The files of recordings, each followed by the file of its gyroscope.
    pub fn of(recordings: &[Recording]) -> Vec<Self> {
        let file = |name: &str, sha256: &Option<String>, role| InputFile {
            path: name.to_owned(),
            sha256: sha256.clone(),
            role,
        };
        let files = recordings.iter().flat_map(|r| {
            let recording = file(&r.name, &r.sha256, InputRole::Recording);
            let gyro = r.gyro_file.as_ref();
            let gyro = gyro.map(|g| file(&g.name, &g.sha256, InputRole::Gyroscope));
            std::iter::once(recording).chain(gyro)
        });
        files.collect()
    }

    /// Reads a file, on the disk or in memory, at once and parses it with `parse`. The result and the SHA-256 are of the
    /// same bytes, even if the file changes.
    ///
    /// # Errors
    ///
    /// `too-large` (input) for more than 16 MiB; errors of the file system and of `parse`, with
    /// the file.
    pub fn read<'a, T>(
        file: impl Into<Named<'a>>,
        role: InputRole,
        parse: impl FnOnce(&[u8]) -> Result<T>,
    ) -> Result<(T, Self)> {
        let (path, bytes) = match file.into() {
            Named::Bytes(name, bytes) => (name, Cow::Borrowed(bytes)),
            Named::Path(path) => {
                let mut bytes = Vec::new();
                std::fs::File::open(path)
                    .and_then(|file| file.take(MAX_BYTES + 1).read_to_end(&mut bytes))
                    .map_err(|e| Error::io(path, e))?;
                (path, Cow::Owned(bytes))
            }
        };
        if bytes.len() as u64 > MAX_BYTES {
            let (role, most_bytes) = (words(&role), MAX_BYTES);
            return Err(Problem::TooLarge { role, most_bytes }
                .error()
                .at(path, None));
        }
        let parsed = parse(&bytes).map_err(|e| e.in_file(path))?;
        let input = InputFile {
            path: path.display().to_string(),
            sha256: Some(sha256(&bytes)),
            role,
        };
        Ok((parsed, input))
    }
}

//! What a file shows beside its numbers, for scripts and readers: K, R, standard deviations, the verdict. It is not read
//! back.

use gravical_fit::Deviations;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::{AccelerometerSection, CalibrationFile, GyroscopeSection, Verdict};

impl Serialize for CalibrationFile {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        fn numbers<S: Serializer>(file: &&CalibrationFile, to: S) -> Result<S::Ok, S::Error> {
            CalibrationFile::serialize(file, to)
        }
        #[derive(Serialize)]
        struct WithVerdict<'a> {
            #[serde(flatten, serialize_with = "numbers")]
            file: &'a CalibrationFile,
            verdict: Verdict,
        }
        let with_verdict = WithVerdict {
            file: self,
            verdict: self.verdict(),
        };
        with_verdict.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for CalibrationFile {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        CalibrationFile::deserialize(deserializer)
    }
}

/// A section with K and R of raw = K R a + b.
#[derive(Serialize)]
struct Readable<'a, T> {
    #[serde(flatten)]
    section: &'a T,
    /// Input unit per m/s² or rad/s.
    scale: [f64; 3],
    orientation: [[f64; 3]; 3],
    #[serde(skip_serializing_if = "Option::is_none")]
    deviations: Option<Deviations>,
}

pub(super) fn accelerometer<S: Serializer>(
    section: &AccelerometerSection,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    let readable = Readable {
        scale: section.scale(),
        orientation: section.orientation(),
        deviations: section.deviations(),
        section,
    };
    readable.serialize(serializer)
}

pub(super) fn gyroscope<S: Serializer>(
    section: &Option<GyroscopeSection>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    let readable = section.as_ref().map(|section| Readable {
        scale: section.scale(),
        orientation: section.orientation(),
        deviations: None,
        section,
    });
    readable.serialize(serializer)
}

//! What a file shows beside its numbers, for scripts and readers: K, R, standard deviations, the verdict. It is not read
//! back.

use gravical_fit::Deviations;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::types::{AccelerometerSection, CalibrationFile, GyroscopeSection, Verdict};

/// Writes a type with what follows from it, and reads it without.
macro_rules! readable {
    ($type:ty, $($name:ident: $field:ty = $value:expr),*) => {
        impl Serialize for $type {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                fn numbers<S: Serializer>(of: &&$type, serializer: S) -> Result<S::Ok, S::Error> {
                    <$type>::serialize(of, serializer)
                }
                #[derive(Serialize)]
                struct Readable<'a> {
                    #[serde(flatten, serialize_with = "numbers")]
                    of: &'a $type,
                    $($name: $field,)*
                }
                let readable = Readable {
                    of: self,
                    $($name: $value(self),)*
                };
                readable.serialize(serializer)
            }
        }

        impl<'de> Deserialize<'de> for $type {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                <$type>::deserialize(deserializer)
            }
        }
    };
}

readable!(CalibrationFile, verdict: Verdict = CalibrationFile::verdict);
readable!(
    AccelerometerSection,
    scale: [f64; 3] = AccelerometerSection::scale,
    orientation: [[f64; 3]; 3] = AccelerometerSection::orientation,
    deviations: Option<Deviations> = AccelerometerSection::deviations
);
readable!(
    GyroscopeSection,
    scale: [f64; 3] = GyroscopeSection::scale,
    orientation: [[f64; 3]; 3] = GyroscopeSection::orientation
);

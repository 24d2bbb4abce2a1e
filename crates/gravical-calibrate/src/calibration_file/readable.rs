//! What a file shows beside its numbers, for scripts and readers: K, R, standard deviations, the verdict. It is not read
//! back.

use gravical_fit::{Deviations, Mounting};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::types::{Accelerometer, Budget, Calibration, Gyroscope, PoseResult, Verdict};
use crate::recording::{AccelUnit, GyroUnit};

/// Writes a type with what some of its methods return, and reads it without.
macro_rules! readable {
    ($type:ty, $($method:ident: $returned:ty),*) => {
        impl Serialize for $type {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                fn fields<S: Serializer>(stored: &&$type, to: S) -> Result<S::Ok, S::Error> {
                    <$type>::serialize(stored, to)
                }
                #[derive(Serialize)]
                struct Readable<'a> {
                    #[serde(flatten, serialize_with = "fields")]
                    stored: &'a $type,
                    $($method: $returned,)*
                }
                let readable = Readable {
                    stored: self,
                    $($method: self.$method(),)*
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

readable!(Calibration, verdict: Verdict, mounting: Option<Mounting>);
readable!(Accelerometer, output_unit: AccelUnit, scale: [f64; 3], orientation: [[f64; 3]; 3],
    scale_deviation_percent: Option<[f64; 3]>, deviations: Option<Deviations>);
readable!(Gyroscope, output_unit: GyroUnit, scale: [f64; 3], orientation: [[f64; 3]; 3]);
readable!(PoseResult, error: [f64; 3], error_norm: f64);
readable!(Budget, combined_mps2: f64, coverage_factor: f64, expanded_mps2: f64);

//! Local gravity: given, computed from the location, or assumed.

use gravical_core::unit::{STANDARD_GRAVITY_MPS2, local_gravity_mps2};

use serde::{Deserialize, Serialize};

use crate::calibration_file::GravitySource;
use crate::finding::{Case, Finding};
use crate::{Error, Result};

/// Local gravity and its source.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Gravity {
    /// m/s².
    #[serde(rename = "gravity_mps2")]
    pub value_mps2: f64,
    /// Source of the value.
    #[serde(rename = "gravity_source")]
    pub source: GravitySource,
}

impl Default for Gravity {
    fn default() -> Self {
        Gravity {
            value_mps2: STANDARD_GRAVITY_MPS2,
            source: GravitySource::Standard,
        }
    }
}

/// What the user says about local gravity.
#[derive(Debug, Clone, Copy, Default, Deserialize)]
#[serde(default)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct GravityOptions {
    /// In m/s² [default: of the file, or 9.80665 ± 0.15 %]
    #[serde(rename = "gravity")]
    #[cfg_attr(
        feature = "clap",
        arg(long = "gravity", value_name = "MPS2", conflicts_with = "latitude_deg")
    )]
    gravity_mps2: Option<f64>,
    /// Latitude in degrees, to compute gravity
    #[serde(rename = "latitude")]
    #[cfg_attr(
        feature = "clap",
        arg(long = "latitude", value_name = "DEG", allow_negative_numbers = true)
    )]
    latitude_deg: Option<f64>,
    /// Height above sea level in m, beside the latitude
    #[serde(rename = "altitude")]
    #[cfg_attr(
        feature = "clap",
        arg(
            long = "altitude",
            value_name = "M",
            requires = "latitude_deg",
            allow_negative_numbers = true
        )
    )]
    height_m: Option<f64>,
}

impl GravityOptions {
    /// Gravity as given; none without an option.
    ///
    /// # Errors
    ///
    /// `option-range` (usage) for values that do not occur on Earth, and for options that do not go
    /// together.
    pub fn given(&self) -> Result<Option<Gravity>> {
        match (self.gravity_mps2, self.latitude_deg, self.height_m) {
            (Some(_), Some(_), _) => Err(Error::range(
                "latitude",
                "give gravity as a value or by the latitude, not both",
            )),
            (Some(g), None, None) => Gravity::given(g).map(Some),
            (None, Some(latitude), height) => {
                Gravity::at(latitude, height.unwrap_or_default()).map(Some)
            }
            (_, None, Some(_)) => Err(Error::range(
                "altitude",
                "gravity is computed from the latitude, which is missing",
            )),
            (None, None, None) => Ok(None),
        }
    }
}

/// Standard uncertainty of gravity at an unknown location: 9.780 to 9.832 m/s² at sea level,
/// uniformly distributed.
const UNKNOWN_PLACE_MPS2: f64 = 0.015;
/// … and from latitude and height: anomalies of the field.
const ANOMALY_MPS2: f64 = 0.0005;

impl Gravity {
    /// Standard uncertainty, m/s²; a given value is assumed to be exact.
    pub fn uncertainty_mps2(&self) -> f64 {
        match self.source {
            GravitySource::Given => 0.0,
            GravitySource::Latitude => ANOMALY_MPS2,
            GravitySource::Standard => UNKNOWN_PLACE_MPS2,
        }
    }

    /// As the estimators take it.
    pub(crate) fn for_fit(&self) -> gravical_fit::Gravity {
        gravical_fit::Gravity {
            value_mps2: self.value_mps2,
            sd_mps2: self.uncertainty_mps2(),
        }
    }

    /// A given value, m/s².
    ///
    /// # Errors
    ///
    /// `option-range` (usage) outside 9.7 to 9.9, which occurs nowhere on Earth.
    pub fn given(value_mps2: f64) -> Result<Self> {
        if !(9.7..=9.9).contains(&value_mps2) {
            let what = format!("{value_mps2} m/s² is not possible; on Earth it is 9.76 to 9.84");
            return Err(Error::range("gravity", what).with_hint(
                "the sensor's own reading at rest is not gravity; give the latitude if gravity is unknown",
            ));
        }
        Ok(Gravity {
            value_mps2,
            source: GravitySource::Given,
        })
    }

    /// From latitude in degrees and height in m (WGS 84).
    ///
    /// # Errors
    ///
    /// `option-range` (usage) for a latitude beyond ±90° or a height beyond
    /// −500 to 9000 m.
    pub fn at(latitude_deg: f64, height_m: f64) -> Result<Self> {
        if !(-90.0..=90.0).contains(&latitude_deg) {
            let what = format!("{latitude_deg}° is not possible; −90 to 90° is");
            return Err(Error::range("latitude", what)
                .with_hint("the latitude of the place, north positive, for example 48.1"));
        }
        if !(-500.0..=9000.0).contains(&height_m) {
            let what = format!("{height_m} m is not possible; −500 to 9000 m is");
            return Err(Error::range("altitude", what)
                .with_hint("the height above sea level; 100 m more are 0.03 mm/s² less gravity"));
        }
        Ok(Gravity {
            value_mps2: local_gravity_mps2(latitude_deg, height_m),
            source: GravitySource::Latitude,
        })
    }

    /// Finding about the uncertainty of an assumed value.
    pub fn finding(&self) -> Option<Finding> {
        (self.source == GravitySource::Standard).then(|| {
            let assumed = Case::GravityAssumed.finding();
            let assumed = assumed.advise("latitude", "").advise("altitude", "");
            assumed.advise("gravity", "")
        })
    }
}

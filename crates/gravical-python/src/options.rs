//! Options of the program as keyword arguments: a dictionary without those that are `None`.

use std::path::PathBuf;
use std::str::FromStr;

use gravical::apply::{ApplyOptions, OutputUnit};
use gravical::calibrate::{CalibrateOptions, EstimateOptions, Method};
use gravical::calibration_file::SensorInfo;
use gravical::denoise::{Channels, DenoiseOptions, FilterSpec};
use gravical::export::ExportOptions;
use gravical::gravity::Gravity;
use gravical::motion::{GravityRemoval, Intervals, MotionOptions};
use gravical::noise::{NoiseOptions, PARTS, Part, Spacing};
use gravical::poses::SegmentOptions;
use gravical::poses::face::AxisMap;
use gravical::poses::sections::read_sections;
use gravical::recording::{
    AccelUnit, GyroUnit, Meter, ReadOptions, Recording, TimeUnit, parse_columns,
};
use gravical::{Error, Result};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyDictMethods};

use crate::error::OrRaise;

/// Keyword arguments with the names of the program's options.
pub struct Options<'py> {
    given: Bound<'py, PyDict>,
}

impl<'py> FromPyObject<'_, 'py> for Options<'py> {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        Ok(Options {
            given: object.cast::<PyDict>()?.to_owned(),
        })
    }
}

/// What a value should have been.
fn wrong(name: &str, value: &str, expected: &str) -> Error {
    Error::usage("usage", format!("{name}=: {value} is not {expected}"))
}

impl<'py> Options<'py> {
    fn py(&self) -> Python<'py> {
        self.given.py()
    }

    /// The value of an option, if it is given.
    fn get<T: for<'a> FromPyObject<'a, 'py>>(
        &self,
        name: &str,
        expected: &str,
    ) -> PyResult<Option<T>> {
        let Some(value) = self.given.get_item(name)? else {
            return Ok(None);
        };
        match value.extract::<T>() {
            Ok(value) => Ok(Some(value)),
            Err(_) => {
                let shown = value.repr().map_or("?".to_owned(), |r| r.to_string());
                let shown: String = shown.chars().take(80).collect();
                Err(wrong(name, &shown, expected)).or_raise(self.py())
            }
        }
    }

    /// A number.
    pub fn number(&self, name: &str) -> PyResult<Option<f64>> {
        self.get(name, "a number")
    }

    fn count(&self, name: &str) -> PyResult<Option<usize>> {
        self.get(name, "a whole number from 0")
    }

    /// A switch; false if it is not given.
    pub fn switch(&self, name: &str) -> PyResult<bool> {
        Ok(self.get(name, "True or False")?.unwrap_or(false))
    }

    /// A text.
    pub fn text(&self, name: &str) -> PyResult<Option<String>> {
        self.get(name, "a text")
    }

    fn texts(&self, name: &str) -> PyResult<Vec<String>> {
        Ok(self.get(name, "a list of texts")?.unwrap_or_default())
    }

    /// A path.
    pub fn path(&self, name: &str) -> PyResult<Option<PathBuf>> {
        self.get(name, "a path")
    }

    fn vector(&self, name: &str) -> PyResult<Option<[f64; 3]>> {
        self.get(name, "three numbers such as (0, 0, 0)")
    }

    /// A text that the library reads.
    fn parsed<T: FromStr<Err = Error>>(&self, name: &str) -> PyResult<Option<T>> {
        self.parsed_by(name, T::from_str)
    }

    fn parsed_by<T>(&self, name: &str, parse: fn(&str) -> Result<T, Error>) -> PyResult<Option<T>> {
        let text = self.text(name)?;
        let parsed = text.map(|text| {
            let parsed = parse(&text);
            parsed.map_err(|e| {
                let error = Error::usage(e.code(), format!("{name}=: {}", e.message()));
                match e.hint() {
                    Some(hint) => error.with_hint(hint),
                    None => error,
                }
            })
        });
        parsed.transpose().or_raise(self.py())
    }

    /// One of several words.
    fn word<T: Copy>(&self, name: &str, words: &[(&str, T)]) -> PyResult<Option<T>> {
        let Some(text) = self.text(name)? else {
            return Ok(None);
        };
        let found = words.iter().find(|(word, _)| *word == text);
        let expected = || {
            let names: Vec<&str> = words.iter().map(|(word, _)| *word).collect();
            wrong(
                name,
                &format!("{text:?}"),
                &format!("one of {}", names.join(", ")),
            )
        };
        found
            .map(|(_, value)| Some(*value))
            .ok_or_else(expected)
            .or_raise(self.py())
    }

    /// How a recording is read; with the meter that stops it.
    pub fn read(&self, hash: bool) -> PyResult<(ReadOptions, Meter)> {
        let meter = Meter::default();
        let accel = [
            ("m/s^2", AccelUnit::MetrePerSecondSquared),
            ("m/s2", AccelUnit::MetrePerSecondSquared),
            ("mps2", AccelUnit::MetrePerSecondSquared),
            ("g", AccelUnit::StandardGravity),
            ("mg", AccelUnit::MilliGravity),
            ("counts", AccelUnit::Counts),
        ];
        let gyro = [
            ("rad/s", GyroUnit::RadianPerSecond),
            ("deg/s", GyroUnit::DegreePerSecond),
            ("dps", GyroUnit::DegreePerSecond),
            ("counts", GyroUnit::Counts),
        ];
        let time = [
            ("s", TimeUnit::Second),
            ("ms", TimeUnit::Millisecond),
            ("us", TimeUnit::Microsecond),
            ("ns", TimeUnit::Nanosecond),
        ];
        let options = ReadOptions {
            accel_unit: self.word("accel_unit", &accel)?,
            accel_range_g: self.number("accel_range")?,
            gyro_unit: self.word("gyro_unit", &gyro)?,
            gyro_range_deg_s: self.number("gyro_range")?,
            columns: self.parsed_by("columns", parse_columns)?,
            sensor: self.text("sensor")?,
            rate_hz: self.number("rate")?,
            time_unit: self.word("time_unit", &time)?,
            zero_offset: self.number("zero_offset")?,
            hash,
            meter: Some(meter.clone()),
        };
        options.validate().or_raise(self.py())?;
        Ok((options, meter))
    }

    /// How the board sits in its case.
    pub fn axes(&self) -> PyResult<AxisMap> {
        Ok(self.parsed("axes")?.unwrap_or_default())
    }

    /// Gravity, if it is given.
    pub fn gravity(&self) -> PyResult<Option<Gravity>> {
        let (gravity, latitude) = (self.number("gravity")?, self.number("latitude")?);
        let altitude = self.number("altitude")?;
        let given = match (gravity, latitude, altitude) {
            (Some(_), Some(_), _) => Err(Error::usage(
                "usage",
                "gravity= and latitude= both say what gravity is",
            )
            .with_hint("give one of the two")),
            (Some(g), None, None) => Gravity::given(g).map(Some),
            (None, Some(latitude), altitude) => {
                Gravity::at(latitude, altitude.unwrap_or(0.0)).map(Some)
            }
            (_, None, Some(_)) => Err(Error::usage(
                "usage",
                "altitude= needs latitude=, from which gravity is computed",
            )),
            (None, None, None) => Ok(None),
        };
        given.or_raise(self.py())
    }

    /// How to calibrate.
    pub fn calibrate(&self) -> PyResult<CalibrateOptions> {
        let py = self.py();
        let method = self.word(
            "method",
            &[("joint", Method::Joint), ("ferraris", Method::Ferraris)],
        )?;
        let sections = self.path("sections")?;
        let sections = sections.as_deref().map(read_sections);
        let (sections, list) = sections.transpose().or_raise(py)?.unzip();
        let defaults = SegmentOptions::default();
        let options = CalibrateOptions {
            segment: SegmentOptions {
                rows: self.count("rows")?,
                sections,
                axes: self.axes()?,
                faces_by_name: self
                    .word("faces_from", &[("data", false), ("names", true)])?
                    .unwrap_or(false),
                turn_angle_deg: self
                    .number("turn_angle")?
                    .unwrap_or(defaults.turn_angle_deg),
            },
            gravity: self.gravity()?.unwrap_or_default(),
            estimate: EstimateOptions {
                method: method.unwrap_or_default(),
                pose_tilt_deg: self.number("pose_tilt")?,
                prior: self
                    .word("prior", &[("data-sheet", true), ("off", false)])?
                    .unwrap_or(true),
                free: self.texts("free_pose")?,
                face: self.texts("face_pose")?,
            },
            sensor: SensorInfo {
                id: self.text("sensor_id")?,
                model: self.text("sensor_model")?,
            },
            recorded: self.parsed("recorded")?,
            command: None,
            other_inputs: list.into_iter().collect(),
            thermal: self.thermal()?,
        };
        options.validate().or_raise(py)?;
        Ok(options)
    }

    /// Soak recordings: in memory, or read for what they tell of the temperature.
    fn thermal(&self) -> PyResult<Vec<Recording>> {
        let paths: Vec<PathBuf> = self.get("thermal", "a list of paths")?.unwrap_or_default();
        let (read, meter) = self.read(true)?;
        if paths.is_empty() {
            return Ok(Vec::new());
        }
        crate::task::run(self.py(), &meter, move || {
            let all = paths
                .iter()
                .map(|path| gravical::recording::read(path, &read));
            all.collect::<Result<_>>()
        })
    }

    /// How to apply.
    pub fn apply(&self) -> PyResult<(ApplyOptions, Meter)> {
        let (read, meter) = self.read(false)?;
        let units = [
            ("m/s^2", OutputUnit::MetrePerSecondSquared),
            ("m/s2", OutputUnit::MetrePerSecondSquared),
            ("mps2", OutputUnit::MetrePerSecondSquared),
            ("g", OutputUnit::StandardGravity),
        ];
        let options = ApplyOptions {
            read,
            keep_raw: self.switch("keep_raw")?,
            axes: self.axes()?,
            output_unit: self.word("output_unit", &units)?.unwrap_or_default(),
        };
        Ok((options, meter))
    }

    fn filters(&self, name: &str) -> PyResult<Option<Vec<FilterSpec>>> {
        let Some(texts) = self.get::<Vec<String>>(name, "a list of filters")? else {
            return Ok(None);
        };
        let filters = texts.iter().filter(|t| *t != "none").map(|t| t.parse());
        filters.collect::<Result<_>>().map(Some).or_raise(self.py())
    }

    /// Filters, and how ends are padded.
    pub fn filter_chain(&self) -> PyResult<Vec<FilterSpec>> {
        let filters = self.filters("filter")?.unwrap_or_default();
        Ok(filters)
    }

    /// How to filter.
    pub fn denoise(&self) -> PyResult<DenoiseOptions> {
        let channels = [
            ("accel", Channels::Accel),
            ("gyro", Channels::Gyro),
            ("all", Channels::All),
        ];
        let options = DenoiseOptions {
            filters: self.filters("filter")?.unwrap_or_default(),
            channels: self.word("channels", &channels)?.unwrap_or_default(),
        };
        options.validate().or_raise(self.py())?;
        Ok(options)
    }

    /// How to compute motion; the noise of the sensor and the meter are added by the caller.
    pub fn motion(&self) -> PyResult<MotionOptions> {
        let preset = self
            .word("procedure", &[("default", false), ("report", true)])?
            .unwrap_or(false);
        let preset = match preset {
            true => MotionOptions::report(),
            false => MotionOptions::default(),
        };
        let removals = [
            ("strapdown", GravityRemoval::Strapdown),
            ("constant-tilt", GravityRemoval::ConstantTilt),
            ("initial-mean", GravityRemoval::InitialMean),
        ];
        let switch = |name: &str| self.get::<bool>(name, "True or False");
        let preset = match self.word("gravity_removal", &removals)? {
            Some(removal) => preset.with_removal(removal),
            None => preset,
        };
        let rests: Option<Intervals> = self.parsed("rests")?;
        let options = MotionOptions {
            gravity_removal: preset.gravity_removal,
            causal: self.switch("causal")?,
            smooth: self.filters("smooth")?.unwrap_or(preset.smooth),
            zero_velocity: switch("zero_velocity")?.unwrap_or(preset.zero_velocity),
            rests_s: rests.map(|i| i.0),
            // False is 0.
            stance_rate_rad_s: match self.number("stances")? {
                Some(0.0) => None,
                rate => rate.or(preset.stance_rate_rad_s),
            },
            v0_mps: self.vector("v0")?,
            p0_m: self.vector("p0")?.unwrap_or(preset.p0_m),
            noise: None,
            gravity: self.gravity()?,
            bands: !self.switch("no_bands")?,
            axes: self.axes()?,
            meter: None,
        };
        options.validate().or_raise(self.py())?;
        Ok(options)
    }

    /// How noise is analysed.
    pub fn noise(&self) -> PyResult<NoiseOptions> {
        let spacings = [
            ("octave", Spacing::Octave),
            ("dense", Spacing::Dense),
            ("decade", Spacing::Decade),
        ];
        Ok(NoiseOptions {
            spacing: self.word("spacing", &spacings)?.unwrap_or_default(),
            part: self.part()?,
        })
    }

    fn part(&self) -> PyResult<Option<&'static Part>> {
        let Some(name) = self.text("part")? else {
            return Ok(None);
        };
        let names: Vec<&str> = PARTS.iter().map(|part| part.name).collect();
        let known = format!("one of {}", names.join(", "));
        let part = Part::of_name(&name).ok_or_else(|| wrong("part", &format!("{name:?}"), &known));
        part.map(Some).or_raise(self.py())
    }

    /// Options of an export.
    pub fn export(&self) -> PyResult<ExportOptions> {
        Ok(ExportOptions {
            name: self.text("name")?,
            device_id: self.get("device_id", "a whole number from 0 to 4294967295")?,
            rotation: self.parsed("rotation")?,
            counts_per_g: self.number("counts_per_g")?,
            counts_per_deg_s: self.number("counts_per_deg_s")?,
            upper_limit: self.switch("upper_limit")?,
        })
    }

    /// Whole numbers that fit the type.
    pub fn whole<T: for<'a> FromPyObject<'a, 'py>>(&self, name: &str) -> PyResult<Option<T>> {
        self.get(name, "a whole number in its range")
    }

    /// Two numbers.
    pub fn pair(&self, name: &str) -> PyResult<Option<(f64, f64)>> {
        self.get(name, "two numbers")
    }
}

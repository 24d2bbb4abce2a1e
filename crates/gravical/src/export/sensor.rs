//! One sensor as templates name it, and the values that all templates share.

use gravical_core::matrix3::{mul, mul_vec, row_norms, scale_rows, transpose};
use gravical_core::unit::{RADIANS_PER_DEGREE, STANDARD_GRAVITY_MPS2};

use super::template::Values;
use crate::Result;
use crate::calibration_file::Calibration;
use crate::problem::Problem;
use crate::recording::units::{AccelUnit, GyroUnit};

/// Row-major.
pub(super) type Matrix = [[f64; 3]; 3];

/// A sketch whose counts differ by this much has another range: ranges differ by two.
const SAME_RANGE: f64 = 0.2;

/// `calibrated = matrix · (raw − bias − g_sensitivity · acceleration)`.
pub(super) struct Sensor {
    /// m/s² or rad/s per unit of the raw values.
    pub matrix: Matrix,
    /// Unit of the raw values.
    pub bias: [f64; 3],
    /// Unit of the raw values per m/s².
    pub g_sensitivity: Matrix,
    /// Unit of the raw values, in words.
    pub unit: String,
    /// The raw values are counts of 16 bits.
    pub is_counts: bool,
    /// What unsigned counts read at zero.
    pub zero_offset: f64,
    /// Raw units per g or per °/s, where known.
    pub per_unit: Option<f64>,
    /// That g or °/s: its name, and its size in m/s² or rad/s.
    pub unit_name: &'static str,
    pub unit_size: f64,
    /// What names of the sensor's values begin with.
    pub key: &'static str,
}

impl Sensor {
    pub fn accelerometer(file: &Calibration) -> Self {
        let a = &file.accelerometer;
        Sensor {
            matrix: a.matrix,
            bias: a.bias,
            g_sensitivity: [[0.0; 3]; 3],
            unit: a.input_unit.name().to_owned(),
            is_counts: a.input_unit == AccelUnit::Counts,
            zero_offset: a.zero_offset(),
            per_unit: a.nominal_per_mps2().map(|n| n * STANDARD_GRAVITY_MPS2),
            unit_name: "g",
            unit_size: STANDARD_GRAVITY_MPS2,
            key: "accel",
        }
    }

    pub fn gyroscope(file: &Calibration) -> Option<Self> {
        let g = file.gyroscope.as_ref()?;
        Some(Sensor {
            matrix: g.matrix,
            bias: g.bias,
            g_sensitivity: g.g_sensitivity,
            unit: g.input_unit.name().to_owned(),
            is_counts: g.input_unit == GyroUnit::Counts,
            zero_offset: g.zero_offset(),
            per_unit: match g.input_unit {
                GyroUnit::RadianPerSecond => Some(RADIANS_PER_DEGREE),
                GyroUnit::DegreePerSecond => Some(1.0),
                // The file does not give that of counts.
                GyroUnit::Counts | GyroUnit::Unknown => None,
            },
            unit_name: "deg/s",
            unit_size: RADIANS_PER_DEGREE,
            key: "gyro",
        })
    }

    /// For raw values that are `factor` times smaller.
    fn rescale(&mut self, factor: f64) {
        self.matrix = self.matrix.map(|row| row.map(|v| v * factor));
        self.g_sensitivity = self.g_sensitivity.map(|row| row.map(|v| v / factor));
        self.bias = self.bias.map(|b| b / factor);
    }

    /// For raw values that are less by the offset of unsigned counts.
    fn subtract_zero_offset(&mut self) {
        self.bias = self.bias.map(|b| b - self.zero_offset);
        self.zero_offset = 0.0;
    }

    /// For raw values in m/s² or rad/s by the nominal scale.
    ///
    /// # Errors
    ///
    /// `export-unit` (input) if that is unknown.
    pub fn take_nominal(&mut self) -> Result<()> {
        let per_unit = self.per_unit.ok_or_else(|| {
            let unit = self.unit.clone();
            let error = Problem::NoNominalScale { unit }.error();
            error.advise("accel_range", "")
        })?;
        self.subtract_zero_offset();
        self.rescale(per_unit / self.unit_size);
        Ok(())
    }

    /// For a sketch: signed counts, `wanted` per g or °/s, or the raw values of the recordings. Says
    /// whether they are counts.
    ///
    /// # Errors
    ///
    /// `export-unit` (input) if the calibration's own scale is clearly another.
    pub fn take_sketch(&mut self, wanted: Option<f64>) -> Result<bool> {
        let zero_offset = self.zero_offset;
        self.subtract_zero_offset();
        if let Some(wanted) = wanted {
            self.take_counts(wanted)?;
        }
        if let Some(per_unit) = self.per_unit.filter(|_| self.is_counts) {
            self.unit = format!("counts, {} per {}", round_counts(per_unit), self.unit_name);
        }
        if zero_offset != 0.0 && wanted.is_none() {
            // Unsigned counts do not fit into 16 bits with a sign.
            self.unit += &format!(", less {zero_offset}");
        }
        Ok(self.is_counts)
    }

    fn take_counts(&mut self, wanted: f64) -> Result<()> {
        if let Some(per_unit) = self.per_unit {
            self.rescale(per_unit / wanted);
        } else {
            // The recording did not say what a count is. A sensor is off by a few percent.
            let mean_norm = row_norms(&self.matrix).iter().sum::<f64>() / 3.0;
            let own = self.unit_size / mean_norm;
            if (own / wanted - 1.0).abs() > SAME_RANGE {
                let unit = self.unit_name;
                let option = format!("counts_per_{}", unit.replace('/', "_"));
                let other = Problem::OtherScale { own, unit, wanted };
                return Err(other.error().advise(option, ""));
            }
        }
        self.is_counts = true;
        self.per_unit = Some(wanted);
        Ok(())
    }

    /// Acceleration changes what the gyroscope reads.
    pub fn is_coupled(&self) -> bool {
        self.g_sensitivity.iter().flatten().any(|v| *v != 0.0)
    }

    /// The matrix as misalignment · sensitivity, in g or °/s: columns of length one, and their lengths.
    fn split_sensitivity(&self) -> (Matrix, [f64; 3]) {
        let columns = transpose(&self.matrix);
        let lengths = row_norms(&columns);
        let misalignment = transpose(&scale_rows(&columns, &lengths.map(f64::recip)));
        (misalignment, lengths.map(|length| length / self.unit_size))
    }

    /// −matrix · bias: the fourth column of `matrix · raw + column`.
    fn column(&self) -> [f64; 3] {
        mul_vec(&self.matrix, &self.bias).map(|v| -v)
    }
}

/// A number of counts without the rounding of a division.
fn round_counts(counts: f64) -> f64 {
    (counts * 1000.0).round() / 1000.0
}

/// What all templates may name. Accelerometer: `S` the matrix, `o` the bias, `p` = S·o, `c` = −S·o.
/// Gyroscope: `G` the matrix, `b` the bias, `d` = −G·b, `K` the g-sensitivity, `L` = −G·K. Of both, for results in g
/// and °/s: `Ma`, `Mg` the misalignment, `sa`, `sg` the sensitivity.
pub(super) fn set_values(values: &mut Values, accel: &Sensor, gyro: Option<&Sensor>) {
    set_types(values, accel);
    values.matrix("S", &accel.matrix);
    values.vector("o", &accel.bias);
    values.vector("p", &mul_vec(&accel.matrix, &accel.bias));
    values.vector("c", &accel.column());
    let (misalignment, sensitivity) = accel.split_sensitivity();
    values.matrix("Ma", &misalignment);
    values.vector("sa", &sensitivity);
    if let Some(gyro) = gyro {
        values.text(
            if gyro.is_coupled() {
                "coupled"
            } else {
                "uncoupled"
            },
            "1",
        );
        set_types(values, gyro);
        values.matrix("G", &gyro.matrix);
        values.vector("b", &gyro.bias);
        values.vector("d", &gyro.column());
        let (misalignment, sensitivity) = gyro.split_sensitivity();
        values.matrix("Mg", &misalignment);
        values.vector("sg", &sensitivity);
        values.matrix("K", &gyro.g_sensitivity);
        let coupling = mul(&gyro.matrix, &gyro.g_sensitivity);
        values.matrix("L", &coupling.map(|row| row.map(|v| -v)));
    }
}

/// The unit of the raw values, and their type in C and in Rust.
fn set_types(values: &mut Values, sensor: &Sensor) {
    let name = sensor.key;
    let (c, rust) = match (sensor.is_counts, sensor.zero_offset == 0.0) {
        (true, true) => ("int16_t", "i16"),
        (true, false) => ("uint16_t", "u16"),
        (false, _) => ("float", "f32"),
    };
    values.text(name, "1");
    values.text(&format!("{name}_unit"), sensor.unit.as_str());
    values.text(&format!("{name}_c"), c);
    values.text(&format!("{name}_rust"), rust);
    if sensor.is_counts {
        values.text(&format!("{name}_counts"), "1");
        values.text("counts", "1");
        if let Some(counts) = sensor.per_unit {
            let key = format!("{name}_counts_per_unit");
            values.text(&key, format!("{:?}", round_counts(counts)));
        }
    }
}

//! The offset registers of an MPU6050, as code for a sketch.
//!
//! The hardware adds the registers to every reading. Their unit is 1/2048 g on most parts, but
//! sources disagree and clones differ. The code therefore measures before and after, and takes
//! the registers back where the shift is not what was asked for.

use gravical_core::unit::STANDARD_GRAVITY_MPS2;

use super::diagonal::fit;
use super::header::{about, c_comment, without_gyroscope};
use super::{Export, Target, nominal};
use crate::calibration_file::CalibrationFile;
use crate::{Error, Result};

/// Steps per g: two units of 1/2048 g, since the lowest bit of each register has another meaning.
const STEPS_PER_G: f64 = 1024.0;

/// The registers hold ±16 g.
const MOST_STEPS: f64 = 16.0 * STEPS_PER_G;

/// Code for a sketch.
///
/// # Errors
///
/// `export-unit`, `export-target` (input).
pub(super) fn mpu6050(file: &CalibrationFile, name: &str) -> Result<Export> {
    let full = nominal::accelerometer(file)?;
    let rest = fit(&full, Some([1.0; 3]))?;
    let mut notes = vec![rest.loss.says("scales and cross-axis terms")];
    notes.push("The registers are lost without power: call the function at every start, with the board at rest, before the sensor is set up.".to_owned());
    notes.extend(without_gyroscope(
        file,
        "measure its bias at rest when the sketch starts",
    ));
    let steps = full
        .bias
        .map(|b| (b / STANDARD_GRAVITY_MPS2 * STEPS_PER_G).round());
    if steps.iter().any(|s| s.abs() > MOST_STEPS) {
        return Err(Error::input(
            "export-target",
            "the bias is beyond the ±16 g of the offset registers",
        )
        .with_hint("look whether the calibration is of an MPU6050"));
    }
    let [x, y, z] = steps.map(|s| format!("{s:.0}"));
    let guard = format!("GRAVICAL_{}_MPU6050_H", name.to_uppercase());
    let head = c_comment(&about(file, Target::Mpu6050, &notes));
    let code = SKETCH.replace("NAME", name);
    Ok(Export {
        text: format!(
            "{head}#ifndef {guard}\n#define {guard}\n\n#include <Arduino.h>\n#include <Wire.h>\n\n/* The bias in steps of 1/1024 g. */\nstatic const int16_t {name}_bias_steps[3] = {{{x}, {y}, {z}}};\n{code}\n#endif\n"
        ),
        notes,
    })
}

/// The part that is the same for every sensor.
const SKETCH: &str = r#"
static bool NAME_read(uint8_t address, uint8_t reg, uint8_t *bytes, uint8_t count)
{
    Wire.beginTransmission(address);
    Wire.write(reg);
    if (Wire.endTransmission(false) != 0) return false;
    if (Wire.requestFrom(address, count) != count) return false;
    for (uint8_t i = 0; i < count; i++) bytes[i] = (uint8_t)Wire.read();
    return true;
}

static bool NAME_write(uint8_t address, uint8_t reg, const uint8_t *bytes, uint8_t count)
{
    Wire.beginTransmission(address);
    Wire.write(reg);
    for (uint8_t i = 0; i < count; i++) Wire.write(bytes[i]);
    return Wire.endTransmission() == 0;
}

/* Mean of 200 samples, in g. */
static bool NAME_mean(uint8_t address, float mean[3])
{
    int32_t sum[3] = {0, 0, 0};
    for (uint8_t n = 0; n < 200; n++) {
        uint8_t b[6];
        if (!NAME_read(address, 0x3B, b, 6)) return false;
        for (uint8_t i = 0; i < 3; i++) {
            sum[i] += (int16_t)((uint16_t)b[2 * i] << 8 | b[2 * i + 1]);
        }
        delay(3);
    }
    for (uint8_t i = 0; i < 3; i++) mean[i] = (float)sum[i] / 200.0f / 16384.0f;
    return true;
}

/*
 * Subtracts the bias in the offset registers. The board must lie still for two seconds.
 * Resets the sensor first, so that registers written before do not add up: set range, rate and
 * filter afterwards. Returns false, with the reason on `log`, if the sensor does not answer, is no
 * MPU6050, or does not shift by what was asked; the registers are then as they were.
 */
static bool NAME_write_offsets(Print &log, uint8_t address = 0x68)
{
    uint8_t byte = 0, factory[6], wanted[6];
    float before[3], after[3];
    if (!NAME_read(address, 0x75, &byte, 1)) {
        log.println(F("offsets: the sensor does not answer; check wiring and address"));
        return false;
    }
    if (byte != 0x68) {
        log.println(F("offsets: WHO_AM_I is not 0x68: no MPU6050, its registers are elsewhere"));
        return false;
    }
    const uint8_t reset = 0x80, wake = 0x01;
    bool ok = NAME_write(address, 0x6B, &reset, 1);
    delay(100);
    ok = ok && NAME_write(address, 0x6B, &wake, 1);
    delay(100);
    ok = ok && NAME_mean(address, before) && NAME_read(address, 0x06, factory, 6);
    if (!ok) {
        log.println(F("offsets: the sensor stopped answering"));
        return false;
    }
    for (uint8_t i = 0; i < 3; i++) {
        const int16_t value = (int16_t)((uint16_t)factory[2 * i] << 8 | factory[2 * i + 1]);
        /* Steps of two leave the lowest bit, which belongs to the temperature, as it is. */
        const int32_t shifted = (int32_t)value - 2 * (int32_t)NAME_bias_steps[i];
        if (shifted < -32768 || shifted > 32767) {
            log.println(F("offsets: beyond the range of the register"));
            return false;
        }
        wanted[2 * i] = (uint8_t)((uint16_t)shifted >> 8);
        wanted[2 * i + 1] = (uint8_t)((uint16_t)shifted & 0xFF);
    }
    ok = NAME_write(address, 0x06, wanted, 6);
    delay(50);
    ok = ok && NAME_mean(address, after);
    for (uint8_t i = 0; ok && i < 3; i++) {
        const float asked = (float)-NAME_bias_steps[i] / 1024.0f;
        const float shift = after[i] - before[i];
        /* A quarter of a shift is far more than a resting board moves by, from 30 mg on. */
        const float tolerance = fabs(asked) < 0.03f ? 0.0075f : 0.25f * fabs(asked);
        if (fabs(shift - asked) <= tolerance) continue;
        log.print(F("offsets: axis "));
        log.print((int)i);
        log.print(F(" shifted by "));
        log.print(shift, 4);
        log.print(F(" g, asked for "));
        log.print(asked, 4);
        log.println(F(" g: half or double means another unit of the registers, else it moved"));
        ok = false;
    }
    if (!ok) {
        NAME_write(address, 0x06, factory, 6);
        log.println(F("offsets: not written, the registers are as before"));
    }
    return ok;
}
"#;

//! The sketch for the offset registers, run against a simulated MPU6050.

use super::*;

/// What the sketch uses of the Arduino core.
const ARDUINO: &str = "#pragma once\n#include <cmath>\n#include <cstdint>\n#include <cstdio>\nusing std::fabs;\n#define F(text) text\ninline void delay(unsigned long) {}\nstruct Print {\n void print(const char *t) { std::printf(\"# %s\\n\", t); }\n void print(int) {}\n void print(double, int) {}\n void println(const char *t) { std::printf(\"# %s\\n\", t); }\n};\n";

/// A sensor at rest with z up: it adds its offset registers, of `per_g` units, to what it measures.
const WIRE: &str = "#pragma once\n#include <cmath>\n#include <cstdint>\nstruct Sensor {\n uint8_t reg[256] = {0};\n double force[3], per_g;\n int at = 0, n = 0; uint8_t factory[6];\n void reset() { for (int i = 0; i < 6; i++) reg[6 + i] = factory[i]; }\n int16_t offset(int i) const { return (int16_t)(reg[6 + 2 * i] << 8 | reg[7 + 2 * i]); }\n int16_t was(int i) const { return (int16_t)(factory[2 * i] << 8 | factory[2 * i + 1]); }\n double reads(int i) const { return force[i] + ((offset(i) & ~1) - (was(i) & ~1)) / per_g; }\n uint8_t get() {\n  if (at >= 0x3B && at < 0x41) { int i = (at - 0x3B) / 2; int16_t v = (int16_t)std::lround(reads(i) * 16384); int b = (at - 0x3B) % 2; at++; return b ? v & 0xFF : (v >> 8) & 0xFF; }\n  return reg[at++];\n }\n void put(uint8_t v) { if (n++ == 0) { at = v; return; } if (at == 0x6B && (v & 0x80)) reset(); else reg[at] = v; at++; }\n};\nextern Sensor sensor;\nstruct Bus {\n void beginTransmission(uint8_t) { sensor.n = 0; }\n void write(uint8_t v) { sensor.put(v); }\n uint8_t endTransmission(bool = true) { return 0; }\n uint8_t requestFrom(uint8_t, uint8_t n) { return n; }\n int read() { return sensor.get(); }\n};\nextern Bus Wire;\n";

/// Arguments: forces in g, units per g of the registers, WHO_AM_I. Calls twice, as after a reset of
/// the board alone. Prints success, readings, and whether the lowest bits are as they were.
const MAIN: &str = "#include \"cal.h\"\n#include <cstdlib>\nSensor sensor; Bus Wire;\nint main(int, char **v) {\n for (int i = 0; i < 3; i++) sensor.force[i] = std::atof(v[1 + i]);\n sensor.per_g = std::atof(v[4]);\n sensor.reg[0x75] = (uint8_t)std::atoi(v[5]);\n const uint8_t f[6] = {0xFC, 0x31, 0x02, 0x80, 0x05, 0x77};\n for (int i = 0; i < 6; i++) sensor.factory[i] = f[i];\n sensor.reset();\n Print log;\n bool ok = gravical_write_offsets(log); ok = gravical_write_offsets(log) && ok;\n bool bits = true;\n for (int i = 0; i < 3; i++) bits = bits && ((sensor.offset(i) ^ sensor.was(i)) & 1) == 0;\n std::printf(\"%d %d %.9g %.9g %.9g\\n\", ok, bits, sensor.reads(0), sensor.reads(1), sensor.reads(2));\n}\n";

#[test]
fn the_registers_take_the_bias_away_or_are_left_alone() {
    let file = in_counts();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    save(path, "cal.h", &written(&file, "mpu6050").text);
    save(path, "Arduino.h", ARDUINO);
    save(path, "Wire.h", WIRE);
    save(path, "main.cpp", MAIN);
    let args = "-std=c++11 -Wall -Wextra -Werror -I. -o main main.cpp";
    let args: Vec<&str> = args.split(' ').collect();
    if output("g++", &args, path, "").is_none() {
        return;
    }
    let bias = file.accelerometer.bias.map(|b| b / 16384.0);
    let program = path.join("main");
    let run = |per_g: &str, who: &str| {
        let [x, y, z] = [bias[0], bias[1], 1.0 + bias[2]].map(|v| v.to_string());
        let args = [&*x, &*y, &*z, per_g, who];
        let out = output(program.to_str().unwrap(), &args, path, "").unwrap();
        let last = out.lines().last().unwrap().split(' ');
        let last: Vec<f64> = last.map(|w| w.parse().unwrap()).collect();
        (last, out)
    };
    let (read, out) = run("2048", "104");
    assert_eq!(read[..2], [1.0, 1.0], "{out}");
    for (value, wanted) in read[2..].iter().zip([0.0, 0.0, 1.0]) {
        // Half a step of 1/1024 g.
        close(*value, wanted, 0.5 / 1024.0 + 1e-9);
    }
    // Registers of another unit, another part: nothing is changed.
    for (per_g, who, why) in [
        ("1024", "104", "half or double"),
        ("4096", "104", "half or double"),
        ("2048", "112", "no MPU6050"),
    ] {
        let (read, out) = run(per_g, who);
        assert_eq!(read[..2], [0.0, 1.0], "{out}");
        assert!(out.contains(why), "{out}");
        for (value, wanted) in read[2..].iter().zip([bias[0], bias[1], 1.0 + bias[2]]) {
            close(*value, wanted, 1e-7);
        }
    }
}

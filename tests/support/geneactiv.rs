//! Writes `.bin` files of simulated GENEActiv devices, independently of the reader.

use std::fmt::Write as _;

use jiff::Timestamp;

/// A device that records.
#[derive(Debug, Clone)]
pub struct Device {
    pub serial: &'static str,
    pub rate_hz: f64,
    /// Of x, y and z.
    pub gain: [i32; 3],
    pub offset: [i32; 3],
    /// When the first sample is measured, s since 1970; whole milliseconds.
    pub start_s: f64,
}

impl Device {
    /// A device at 100 Hz that records from 2024-03-01 08:00.
    pub fn new() -> Self {
        Device {
            serial: "011073",
            rate_hz: 100.0,
            gain: [25_344, 25_870, 25_470],
            offset: [1104, 454, -1433],
            start_s: 1_709_280_000.5,
        }
    }

    /// The value of these counts, g: what is measured for a gain of 1 and an offset.
    pub fn in_g(&self, counts: [i16; 3]) -> [f64; 3] {
        let axis = |i: usize| {
            let hundredths = i32::from(counts[i]) * 100 - self.offset[i];
            f64::from(hundredths) / f64::from(self.gain[i])
        };
        [axis(0), axis(1), axis(2)]
    }

    /// The header, for so many pages.
    pub fn header(&self, pages: usize) -> String {
        let ([gx, gy, gz], [ox, oy, oz]) = (self.gain, self.offset);
        let lines = [
            "Device Identity".to_owned(),
            format!("Device Unique Serial Code:{}", self.serial),
            "Device Type:GENEActiv           ".to_owned(),
            "Device Model:1.1                 ".to_owned(),
            "Device Firmware Version:Ver 5.01 date 20Jul14".to_owned(),
            "Calibration Date:2013-05-06 14:20:30:462".to_owned(),
            String::new(),
            "Device Capabilities".to_owned(),
            "Accelerometer Range:-8 to 8             ".to_owned(),
            "Accelerometer Resolution:0.0039              ".to_owned(),
            "Accelerometer Units:g                   ".to_owned(),
            String::new(),
            "Configuration Info".to_owned(),
            format!("Measurement Frequency:{} Hz", self.rate_hz),
            "Start Time:0000-00-00 00:00:00:000".to_owned(),
            "Time Zone:GMT +01:00".to_owned(),
            String::new(),
            "Subject Info".to_owned(),
            "Device Location Code:left wrist".to_owned(),
            "Subject Notes:".to_owned(),
            String::new(),
            "Calibration Data".to_owned(),
            format!("x gain:{gx}\r\nx offset:{ox}"),
            format!("y gain:{gy}\r\ny offset:{oy}"),
            format!("z gain:{gz}\r\nz offset:{oz}"),
            "Volts:300\r\nLux:800".to_owned(),
            String::new(),
            "Memory Status".to_owned(),
            format!("Number of Pages:{pages}\r\n\r\n"),
        ];
        lines.join("\r\n")
    }

    /// Page `number` from 0, `first` samples after the start.
    pub fn page(&self, number: u32, first: u64, celsius: f64, samples: &[[i16; 3]]) -> String {
        let stamp_s = self.start_s + first as f64 / self.rate_hz;
        let time = Timestamp::from_millisecond((stamp_s * 1000.0).round() as i64).unwrap();
        let mut page = format!(
            "Recorded Data\r\nDevice Unique Serial Code:{}\r\nSequence Number:{number}\r\n\
             Page Time:{}\r\nUnassigned:\r\nTemperature:{celsius:.1}\r\nBattery voltage:4.1194\r\n\
             Device Status:Recording\r\nMeasurement Frequency:{:.1}\r\n",
            self.serial,
            time.strftime("%Y-%m-%d %H:%M:%S:%3f"),
            self.rate_hz,
        );
        for (i, counts) in samples.iter().enumerate() {
            for count in counts {
                write!(page, "{:03X}", count & 0xfff).unwrap();
            }
            // Light, and now and then the button.
            write!(page, "{:03X}", i % 1024 * 4 + 2 * (i % 50 / 49)).unwrap();
        }
        page + "\r\n"
    }
}

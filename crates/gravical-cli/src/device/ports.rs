//! Serial ports, and which of them is the board.

use gravical::{Error, Result};
use serde::Serialize;
use serialport::{SerialPortInfo, SerialPortType};

/// Vendors of boards and of their USB bridges (usb.ids), with their usual names.
const BOARDS: [(u16, &str); 12] = [
    (0x2341, "Arduino"),
    (0x2a03, "Arduino"),
    (0x1a86, "CH340 bridge, as on many Uno and Nano clones"),
    (0x0403, "FTDI bridge"),
    (0x10c4, "CP210x bridge"),
    (0x067b, "PL2303 bridge"),
    (0x239a, "Adafruit"),
    (0x1b4f, "SparkFun"),
    (0x16c0, "Teensy"),
    (0x2e8a, "Raspberry Pi Pico"),
    (0x303a, "Espressif"),
    (0x0483, "STMicroelectronics"),
];

/// The identity of a USB device, by which it is recognised again.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Usb {
    /// Vendor.
    pub vid: u16,
    /// Product.
    pub pid: u16,
    /// Serial number, where it has one.
    pub serial: Option<String>,
}

/// One port.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Port {
    /// Name to open.
    pub name: String,
    /// The device behind it, for messages.
    pub device: Option<String>,
    /// The USB device behind it.
    pub usb: Option<Usb>,
    /// A board, by its vendor.
    pub board: bool,
}

/// All ports of this computer, boards first.
///
/// # Errors
///
/// `port-list` (device) with what the system says.
pub fn list() -> Result<Vec<Port>> {
    let found = serialport::available_ports()
        .map_err(|e| Error::device("port-list", format!("the ports cannot be listed: {e}")))?;
    let mut ports: Vec<Port> = found.into_iter().map(described).collect();
    // macOS lists every port twice; tty.* waits for a carrier signal that boards lack.
    let called: Vec<String> = ports.iter().map(|p| p.name.clone()).collect();
    ports.retain(|p| {
        p.name
            .strip_prefix("/dev/tty.")
            .is_none_or(|rest| !called.contains(&format!("/dev/cu.{rest}")))
    });
    ports.sort_by(|a, b| (!a.board, &a.name).cmp(&(!b.board, &b.name)));
    Ok(ports)
}

fn described(info: SerialPortInfo) -> Port {
    let name = info.port_name;
    let usb = match info.port_type {
        SerialPortType::UsbPort(usb) => usb,
        other => {
            let is_bluetooth = other == SerialPortType::BluetoothPort;
            return Port {
                name,
                device: is_bluetooth.then(|| "Bluetooth".to_owned()),
                usb: None,
                board: false,
            };
        }
    };
    let vendor = BOARDS.iter().find(|(vid, _)| *vid == usb.vid);
    let vendor = vendor.map(|(_, name)| (*name).to_owned());
    let words: Vec<String> = usb.manufacturer.into_iter().chain(usb.product).collect();
    let words = Some(words.join(" ")).filter(|words| !words.is_empty());
    Port {
        name,
        board: vendor.is_some(),
        device: words.or(vendor),
        usb: Some(Usb {
            vid: usb.vid,
            pid: usb.pid,
            serial: usb.serial_number,
        }),
    }
}

/// The port of the board, if there is exactly one.
///
/// # Errors
///
/// `no-port`, `several-ports` (device).
pub fn the_board(ports: &[Port]) -> Result<Port> {
    let boards: Vec<&Port> = ports.iter().filter(|p| p.board).collect();
    let usb: Vec<&Port> = ports.iter().filter(|p| p.usb.is_some()).collect();
    match (boards.as_slice(), usb.as_slice()) {
        ([one], _) | ([], [one]) => Ok((*one).clone()),
        ([], []) => Err(Error::device("no-port", "no board is plugged in: there is no USB serial port")
            .with_hint("plug it in (some USB cables only charge), or wait for it with --wait; --port selects any other port")),
        (several, others) => {
            let names: Vec<&str> = if several.is_empty() { others } else { several }
                .iter()
                .map(|p| p.name.as_str())
                .collect();
            Err(Error::device(
                "several-ports",
                format!("more than one port may be the board: {}", names.join(", ")),
            )
            .with_hint("choose one with --port; gravical ports lists the device behind each"))
        }
    }
}

/// The port that is recorded from, to be found again after it was unplugged.
#[derive(Debug, Clone)]
pub struct Target {
    /// Its name, as given or found.
    pub name: String,
    usb: Option<Usb>,
}

impl Target {
    /// The port called `name`, or a link to it.
    pub fn new(name: &str, ports: &[Port]) -> Self {
        Target {
            name: name.to_owned(),
            usb: port_called(name, ports).and_then(|p| p.usb.clone()),
        }
    }

    /// The device behind it.
    pub fn device(&self, ports: &[Port]) -> Option<String> {
        port_called(&self.name, ports)?.device.clone()
    }

    /// Its name now, which may have changed; none while it is unplugged.
    pub fn find(&self, ports: &[Port]) -> Option<String> {
        let Some(usb) = &self.usb else {
            return std::path::Path::new(&self.name)
                .exists()
                .then(|| self.name.clone());
        };
        if port_called(&self.name, ports).is_some_and(|p| p.usb.as_ref() == Some(usb)) {
            return Some(self.name.clone());
        }
        let same: Vec<&Port> = ports
            .iter()
            .filter(|p| p.usb.as_ref() == Some(usb))
            .collect();
        match same.as_slice() {
            // Without a serial number two equal boards cannot be distinguished.
            [one] => Some(one.name.clone()),
            _ => None,
        }
    }
}

fn port_called<'a>(name: &str, ports: &'a [Port]) -> Option<&'a Port> {
    let real = std::fs::canonicalize(name).ok();
    ports.iter().find(|p| {
        p.name == name
            || real
                .as_deref()
                .is_some_and(|r| r == std::path::Path::new(&p.name))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn port(name: &str, vid: u16, serial: Option<&str>) -> Port {
        described(SerialPortInfo {
            port_name: name.to_owned(),
            port_type: SerialPortType::UsbPort(serialport::UsbPortInfo {
                vid,
                pid: 0x43,
                serial_number: serial.map(str::to_owned),
                manufacturer: None,
                product: None,
            }),
        })
    }

    #[test]
    fn the_only_board_is_chosen() {
        let plain = Port {
            name: "/dev/ttyS0".to_owned(),
            device: None,
            usb: None,
            board: false,
        };
        let uno = port("/dev/ttyACM0", 0x2341, Some("A1"));
        let modem = port("/dev/ttyACM1", 0x1199, None);
        assert!(uno.board && !modem.board);
        assert_eq!(
            the_board(std::slice::from_ref(&plain)).unwrap_err().code(),
            "no-port"
        );
        assert_eq!(the_board(&[plain.clone(), modem.clone()]).unwrap(), modem);
        assert_eq!(the_board(&[modem.clone(), uno.clone()]).unwrap(), uno);
        let two = [uno.clone(), port("/dev/ttyUSB0", 0x1a86, None)];
        let error = the_board(&two).unwrap_err();
        assert_eq!(error.code(), "several-ports");
        assert!(error.to_string().contains("/dev/ttyUSB0"), "{error}");
    }

    #[test]
    fn a_board_is_recognised_under_another_name() {
        let before = [port("/dev/ttyACM0", 0x2341, Some("A1"))];
        let target = Target::new("/dev/ttyACM0", &before);
        assert_eq!(target.find(&before).as_deref(), Some("/dev/ttyACM0"));
        assert_eq!(target.find(&[]), None);
        let after = [
            port("/dev/ttyACM0", 0x2341, Some("B2")),
            port("/dev/ttyACM1", 0x2341, Some("A1")),
        ];
        assert_eq!(target.find(&after).as_deref(), Some("/dev/ttyACM1"));
        assert_eq!(target.find(&after[..1]), None);
    }
}

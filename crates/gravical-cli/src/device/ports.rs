//! Serial ports, and which of them is the board.

use std::path::Path;

use gravical::live::event::PortInfo;
use gravical::{Error, Result};
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

/// All ports of this computer, boards first.
///
/// # Errors
///
/// `port-list` (device) with what the system says.
pub fn list() -> Result<Vec<PortInfo>> {
    let found = serialport::available_ports()
        .map_err(|e| Error::device("port-list", format!("the ports cannot be listed: {e}")))?;
    let mut ports: Vec<PortInfo> = found.into_iter().map(described).collect();
    // macOS lists every port twice; tty.* waits for a carrier signal that boards lack.
    ports.retain(|p| !p.name.starts_with("/dev/tty.") || !cfg!(target_os = "macos"));
    ports.sort_by(|a, b| (!a.board, &a.name).cmp(&(!b.board, &b.name)));
    Ok(ports)
}

fn described(info: SerialPortInfo) -> PortInfo {
    let mut port = PortInfo {
        name: info.port_name,
        ..PortInfo::default()
    };
    match info.port_type {
        SerialPortType::UsbPort(usb) => {
            let vendor = BOARDS.iter().find(|(vid, _)| *vid == usb.vid);
            let words: Vec<String> = usb.manufacturer.into_iter().chain(usb.product).collect();
            let words = Some(words.join(" ")).filter(|words| !words.is_empty());
            port.board = vendor.is_some();
            port.device = words.or(vendor.map(|(_, name)| (*name).to_owned()));
            port.usb = Some(format!("{:04x}:{:04x}", usb.vid, usb.pid));
            port.serial = usb.serial_number;
        }
        SerialPortType::BluetoothPort => port.device = Some("Bluetooth".to_owned()),
        _ => {}
    }
    port
}

/// A port and what it is: `/dev/ttyACM0  2341:0043  Arduino Uno  [95437]`.
pub fn line(port: &PortInfo) -> String {
    let name = Some(port.name.clone());
    let serial = port.serial.as_ref().map(|s| format!("[{s}]"));
    let parts = [name, port.usb.clone(), port.device.clone(), serial];
    parts.into_iter().flatten().collect::<Vec<_>>().join("  ")
}

/// The port of the board, if there is exactly one.
///
/// # Errors
///
/// `no-port`, `several-ports` (device).
pub fn the_board(ports: &[PortInfo]) -> Result<PortInfo> {
    let mut candidates: Vec<&PortInfo> = ports.iter().filter(|port| port.board).collect();
    if candidates.is_empty() {
        candidates = ports.iter().filter(|port| port.usb.is_some()).collect();
    }
    match candidates.as_slice() {
        [] => Err(
            Error::device("no-port", "no board is plugged in: there is no USB serial port")
                .with_hint("plug it in (some USB cables only charge), or wait for it with --wait; --port selects any other port"),
        ),
        [one] => Ok((*one).clone()),
        several => {
            let names: Vec<&str> = several.iter().map(|p| p.name.as_str()).collect();
            let text = format!("more than one port may be the board: {}", names.join(", "));
            Err(Error::device("several-ports", text)
                .with_hint("choose one with --port; gravical ports lists the device behind each"))
        }
    }
}

/// The port called `name`, or to which that is a link, under this name; of one that is no USB port
/// only the name.
pub fn named(name: &str, ports: &[PortInfo]) -> PortInfo {
    let is_it = |port: &&PortInfo| port.usb.is_some() && matches_name(port, name);
    let mut port = ports.iter().find(is_it).cloned().unwrap_or_default();
    name.clone_into(&mut port.name);
    port
}

fn matches_name(port: &PortInfo, name: &str) -> bool {
    port.name == name || std::fs::canonicalize(name).is_ok_and(|real| real == Path::new(&port.name))
}

/// Whether the computer has a port of this name.
pub fn is_present(name: &str, ports: &[PortInfo]) -> bool {
    ports.iter().any(|port| port.name == name) || Path::new(name).exists()
}

/// The name now of a [`named`] port, which may have changed; none while it is unplugged.
pub fn find_again(port: &PortInfo, ports: &[PortInfo]) -> Option<String> {
    if port.usb.is_none() {
        return is_present(&port.name, ports).then(|| port.name.clone());
    }
    let is_same = |p: &&PortInfo| (&p.usb, &p.serial) == (&port.usb, &port.serial);
    let same: Vec<&PortInfo> = ports.iter().filter(is_same).collect();
    match same.as_slice() {
        // A link keeps its name.
        _ if same.iter().any(|p| matches_name(p, &port.name)) => Some(port.name.clone()),
        [one] => Some(one.name.clone()),
        // Without a serial number two equal boards cannot be distinguished.
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn port(name: &str, vid: u16, serial: Option<&str>) -> PortInfo {
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
        let plain = described(SerialPortInfo {
            port_name: "/dev/ttyS0".to_owned(),
            port_type: SerialPortType::Unknown,
        });
        let uno = port("/dev/ttyACM0", 0x2341, Some("A1"));
        let modem = port("/dev/ttyACM1", 0x1199, None);
        assert!(uno.board && !modem.board);
        assert_eq!(
            the_board(std::slice::from_ref(&plain)).unwrap_err().code(),
            "no-port"
        );
        assert_eq!(the_board(&[plain.clone(), modem.clone()]).unwrap(), modem);
        assert_eq!(the_board(&[modem.clone(), uno.clone()]).unwrap(), uno);
        // A session of the browser names its board otherwise.
        let names = ["/dev/ttyACM0", "Arduino (2341:0043)"];
        let present = names.map(|name| is_present(name, std::slice::from_ref(&uno)));
        assert_eq!(present, [true, false]);
        let two = [uno.clone(), port("/dev/ttyUSB0", 0x1a86, None)];
        let error = the_board(&two).unwrap_err();
        assert_eq!(error.code(), "several-ports");
        assert!(error.to_string().contains("/dev/ttyUSB0"), "{error}");
    }

    #[test]
    fn a_board_is_recognised_under_another_name() {
        let before = [port("/dev/ttyACM0", 0x2341, Some("A1"))];
        let target = named("/dev/ttyACM0", &before);
        let found = |ports: &[PortInfo]| find_again(&target, ports);
        assert_eq!(found(&before).as_deref(), Some("/dev/ttyACM0"));
        assert_eq!(found(&[]), None);
        let after = [
            port("/dev/ttyACM0", 0x2341, Some("B2")),
            port("/dev/ttyACM1", 0x2341, Some("A1")),
        ];
        assert_eq!(found(&after).as_deref(), Some("/dev/ttyACM1"));
        assert_eq!(found(&after[..1]), None);
        // And back.
        let back = find_again(&named("/dev/ttyACM1", &after), &before);
        assert_eq!(back.as_deref(), Some("/dev/ttyACM0"));
        assert_eq!(line(&after[0]), "/dev/ttyACM0  2341:0043  Arduino  [B2]");
    }
}

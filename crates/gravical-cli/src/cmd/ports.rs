//! `gravical ports`: serial ports and likely boards.

use std::process::ExitCode;

use crate::device::ports::{Port, list};
use crate::device::trouble::holders;
use crate::text;

/// List serial ports and mark likely boards
#[derive(clap::Args)]
pub struct Args {
    /// Print JSON: {"ports": […]}
    #[arg(long)]
    pub json: bool,
}

/// Runs the command.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let ports = list()?;
    if args.json {
        let described: Vec<serde_json::Value> = ports
            .iter()
            .map(|port| {
                let mut value = serde_json::to_value(port)?;
                if let Some(object) = value.as_object_mut() {
                    object.insert("open_in".to_owned(), holders(&port.name).into());
                }
                Ok(value)
            })
            .collect::<serde_json::Result<_>>()?;
        text::print_json(&serde_json::json!({ "ports": described }))?;
    } else {
        text::print(&table(&ports))?;
    }
    Ok(ExitCode::SUCCESS)
}

fn table(ports: &[Port]) -> String {
    if ports.is_empty() {
        return "No serial ports. Some USB cables only charge; try another cable.\n".to_owned();
    }
    let width = ports.iter().map(|p| p.name.chars().count()).max();
    let width = width.unwrap_or(0);
    let mut out = String::new();
    for port in ports {
        let ids = port.usb.as_ref().map_or_else(
            || "-".to_owned(),
            |usb| format!("{:04x}:{:04x}", usb.vid, usb.pid),
        );
        let mut line = format!(
            "{:width$}  {ids:9}  {}",
            port.name,
            port.device.as_deref().unwrap_or("-")
        );
        if let Some(serial) = port.usb.as_ref().and_then(|usb| usb.serial.as_deref()) {
            line.push_str(&format!("  [{serial}]"));
        }
        out.push_str(line.trim_end());
        for holder in holders(&port.name) {
            out.push_str(&format!("\n{:width$}  open in {holder}", ""));
        }
        out.push('\n');
    }
    if !ports.iter().any(|p| p.board) {
        out.push_str("None of them has the USB vendor of a known board.\n");
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::ports::Usb;

    #[test]
    fn aligned() {
        let port = |name: &str, device: Option<&str>, usb| Port {
            name: name.to_owned(),
            device: device.map(str::to_owned),
            usb,
            board: false,
        };
        let usb = Usb {
            vid: 0x2341,
            pid: 0x43,
            serial: Some("95437".to_owned()),
        };
        let text = table(&[
            port("/dev/none-such0", Some("Arduino Uno"), Some(usb)),
            port("/dev/none1", None, None),
        ]);
        assert_eq!(
            text,
            "/dev/none-such0  2341:0043  Arduino Uno  [95437]\n\
             /dev/none1       -          -\n\
             None of them has the USB vendor of a known board.\n"
        );
        assert!(table(&[]).starts_with("No serial ports."));
    }
}

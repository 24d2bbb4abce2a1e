//! The way of the user to the page: the browser, or a tunnel.

use std::env;
use std::io::{self, IsTerminal as _};
use std::process::{Command, Stdio};

/// Opens the address in the browser of the user, if there is one; says nothing if there is none:
/// the address is printed.
pub fn open(url: &str) {
    if !io::stderr().is_terminal() {
        return;
    }
    let Some((program, arguments)) = opener() else {
        return;
    };
    let spawned = Command::new(program)
        .args(arguments)
        .arg(url)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn();
    if let Ok(mut child) = spawned {
        std::thread::spawn(move || child.wait());
    }
}

/// The program that opens addresses, and its first arguments.
fn opener() -> Option<(&'static str, &'static [&'static str])> {
    if cfg!(target_os = "macos") {
        return Some(("open", &[]));
    }
    if cfg!(windows) {
        return Some(("rundll32", &["url.dll,FileProtocolHandler"]));
    }
    let has_screen = ["DISPLAY", "WAYLAND_DISPLAY"].map(env::var_os);
    has_screen
        .iter()
        .any(Option::is_some)
        .then_some(("xdg-open", &[]))
}

/// The tunnel that a user over ssh needs; none without ssh.
pub fn tunnel(port: u16) -> Option<String> {
    let connection = env::var("SSH_CONNECTION").ok()?;
    let user = ["USER", "LOGNAME"]
        .into_iter()
        .find_map(|v| env::var(v).ok());
    tunnel_of(&connection, user.as_deref(), port)
}

/// `connection`: address and port of the client, then of this computer.
fn tunnel_of(connection: &str, user: Option<&str>, port: u16) -> Option<String> {
    let mut words = connection.split_whitespace().skip(2);
    let (address, ssh_port) = (words.next()?, words.next()?);
    let user = user.map_or(String::new(), |u| format!("{u}@"));
    let other = match ssh_port {
        "22" => String::new(),
        other => format!(" -p {other}"),
    };
    Some(format!(
        "ssh{other} -L {port}:127.0.0.1:{port} {user}{address}"
    ))
}

#[cfg(test)]
mod tests {
    use super::tunnel_of;

    #[test]
    fn a_tunnel_leads_to_the_same_port() {
        let line = |connection| tunnel_of(connection, Some("ada"), 8123);
        assert_eq!(
            line("10.0.0.2 51000 10.0.0.7 22").as_deref(),
            Some("ssh -L 8123:127.0.0.1:8123 ada@10.0.0.7")
        );
        assert_eq!(
            line("fe80::1 51000 fe80::2 2222").as_deref(),
            Some("ssh -p 2222 -L 8123:127.0.0.1:8123 ada@fe80::2")
        );
        assert_eq!(line("broken"), None);
    }
}

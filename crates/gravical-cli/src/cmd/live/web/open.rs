//! How the user gets to the page: the browser, or a tunnel.

use std::env;
use std::io::{self, IsTerminal as _, Write as _};
use std::path::Path;
use std::process::{Command, Stdio};

use tempfile::NamedTempFile;

/// A file in `folder` that leads a browser to the page, readable by this user only. It is removed when it
/// is dropped.
fn redirect(folder: &Path, url: &str) -> io::Result<NamedTempFile> {
    let mut name = tempfile::Builder::new();
    let mut file = name
        .prefix("gravical-live-")
        .suffix(".html")
        .tempfile_in(folder)?;
    writeln!(
        file,
        "<!doctype html><meta charset=\"utf-8\"><title>gravical live</title>\
         <meta http-equiv=\"refresh\" content=\"0;url={url}\"><a href=\"{url}\">gravical live</a>"
    )?;
    Ok(file)
}

/// Opens the address in the browser of the user, if there is one; says nothing if there is none:
/// the address is printed.
///
/// On Linux and macOS every user of the computer sees the arguments of all programs, so that the
/// token must not be one: the browser gets a file that only this user can read, and that leads to
/// the page. It is in the home directory, because browsers in a sandbox see no other place; where
/// it cannot be written, the address remains to be copied.
pub fn open(url: &str) -> Option<NamedTempFile> {
    if !io::stderr().is_terminal() {
        return None;
    }
    let (program, arguments) = opener()?;
    let redirect = redirect(&env::home_dir()?, url).ok()?;
    let spawned = Command::new(program)
        .args(arguments)
        .arg(redirect.path())
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn();
    if let Ok(mut child) = spawned {
        std::thread::spawn(move || child.wait());
    }
    Some(redirect)
}

/// The program that opens addresses, and its first arguments.
fn opener() -> Option<(&'static str, &'static [&'static str])> {
    if cfg!(target_os = "macos") {
        return Some(("open", &[]));
    }
    if cfg!(windows) {
        return Some(("rundll32", &["url.dll,FileProtocolHandler"]));
    }
    let mut screens = ["DISPLAY", "WAYLAND_DISPLAY"].into_iter();
    let has_screen = screens.any(|name| env::var_os(name).is_some());
    has_screen.then_some(("xdg-open", &[]))
}

/// The tunnel that a user over ssh needs, to this computer as it was reached; none without ssh.
pub fn tunnel(port: u16) -> Option<String> {
    // Address and port of the client, then of this computer.
    let connection = env::var("SSH_CONNECTION").ok()?;
    let address = connection.split_whitespace().nth(2)?;
    Some(format!("ssh -L {port}:127.0.0.1:{port} {address}"))
}

#[cfg(test)]
mod tests {
    #[test]
    #[cfg(unix)]
    fn only_this_user_can_read_the_way_to_the_page() {
        use std::os::unix::fs::MetadataExt as _;
        let folder = tempfile::tempdir().unwrap();
        let url = "http://127.0.0.1:1/?token=0123";
        let file = super::redirect(folder.path(), url).unwrap();
        let path = file.path().to_owned();
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.contains(&format!("url={url}\"")));
        assert_eq!(file.as_file().metadata().unwrap().mode() & 0o777, 0o600);
        drop(file);
        assert!(!path.exists());
    }
}

//! `--png`, in a build that has it: `cargo test --features gravical-cli/png --test png`.

#![allow(clippy::unwrap_used)] // helpers of a test may panic as it does

use std::fs;
use std::path::Path;
use std::process::Command;

fn run(folder: &Path, line: &str) -> String {
    let done = Command::new(env!("CARGO_BIN_EXE_gravical"))
        .args(line.split_whitespace())
        .current_dir(folder)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&done.stderr).into_owned();
    assert!(done.status.success(), "{line}\n{said}");
    said
}

/// Width and height, from the first chunk of a PNG.
fn size(bytes: &[u8]) -> [f64; 2] {
    assert_eq!(&bytes[..16], b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR");
    let number = |at: usize| u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap());
    [number(16), number(20)].map(f64::from)
}

/// The same of a drawing, from its `viewBox`.
fn drawn(svg: &str) -> [f64; 2] {
    let view = svg.split("viewBox=\"").nth(1).unwrap();
    let view: Vec<f64> = view
        .split('"')
        .next()
        .unwrap()
        .split_whitespace()
        .map(|v| v.parse().unwrap())
        .collect();
    [view[2], view[3]]
}

#[test]
fn every_figure_is_a_picture_too() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    run(path, "demo here --json");
    for (line, least) in [
        (
            "calibrate here/poses/poses.csv --figures cal --png --json",
            8,
        ),
        (
            "motion here/line/line.csv -c here/calibration.json --figures mot --png --json",
            7,
        ),
    ] {
        run(path, line);
        let plots = path.join(&line[line.find("--figures ").unwrap() + 10..][..3]);
        let mut seen = 0;
        for entry in fs::read_dir(&plots).unwrap() {
            let svg = entry.unwrap().path();
            if svg.extension().is_none_or(|e| e != "svg") {
                continue;
            }
            let bytes = fs::read(svg.with_extension("png")).unwrap();
            let [width, height] = drawn(&fs::read_to_string(&svg).unwrap());
            let [w, h] = size(&bytes);
            assert!((w - 2.0 * width).abs() <= 1.0, "{}: {w}", svg.display());
            assert!((h - 2.0 * height).abs() <= 1.0, "{}: {h}", svg.display());
            // An empty page packs to less.
            assert!(bytes.len() > 10_000, "{}: {}", svg.display(), bytes.len());
            assert!(bytes.ends_with(b"IEND\xaeB`\x82"));
            seen += 1;
        }
        assert!(seen >= least, "{seen} in {}", plots.display());
    }
    // Pictures that are not asked for any more would show the earlier run.
    let said = run(
        path,
        "motion here/line/line.csv -c here/calibration.json --figures mot --force --json",
    );
    assert!(said.contains("removed from mot") && said.contains("velocity.png"));
    assert!(!path.join("mot/velocity.png").exists() && path.join("mot/velocity.svg").exists());
}

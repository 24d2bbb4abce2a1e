//! What people see in a terminal: 80 columns, and colour only where it is seen.

use std::path::Path;

use crate::every_recording::files;
use crate::support::*;

/// Lines wider than 80 columns that no path made so. Errors are wrapped in a
/// terminal only.
fn too_wide(text: &str, path: &Path) -> Vec<String> {
    let name = path.display().to_string();
    text.lines()
        .filter(|l| l.chars().count() > 80 && !l.contains(&name))
        .filter(|l| !l.starts_with("error: ") && !l.starts_with("  try: "))
        .map(str::to_owned)
        .collect()
}

#[test]
fn eighty_columns_whatever_the_recording() {
    let mut paths = files(Path::new(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../examples"
    )));
    paths.extend(data().iter().flat_map(|d| files(d)));
    assert!(paths.len() >= 7);
    for path in &paths {
        for verb in ["inspect", "calibrate", "motion"] {
            let run = run([verb.as_ref(), path.as_os_str()]);
            // `motion` prints its table on stdout.
            let out = if verb == "motion" { "" } else { &run.out };
            for text in [out, &run.err] {
                assert!(
                    !text.contains('\u{1b}'),
                    "{verb} {}: colour in a pipe",
                    path.display()
                );
                let wide = too_wide(text, path);
                assert!(wide.is_empty(), "{verb} {}: {wide:#?}", path.display());
            }
        }
    }
}

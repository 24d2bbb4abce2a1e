use super::*;
use crate::figure::{Axis, Figure, Panel, Role, Series};
use gravical::calibration_file::Grade;

fn figures() -> [Figure; 1] {
    let line = Series::line("a", Role::Raw, [[0.0, 0.0], [1.0, 1.0]], &[]);
    let axes = ["t, s", ""].map(|name| Axis::new(name, "", [0.0, 1.0]));
    let panel = Panel::new("y", "m", axes, [line]);
    [Figure::new("norm", "A figure", "What it shows.", [panel])]
}

/// One of everything, with a name that is markup in each of the formats.
fn document(figures: &[Figure]) -> Document<'_> {
    let bias = Cell::number("-0.2246").plus_minus(Some(0.0012), 4);
    let table = Table::new("Bias, ± 95 %", ["axis", "b, m/s²"])
        .axes("mean")
        .row(
            "<x>|*",
            [bias]
                .into_iter()
                .chain(Cell::axes(None, |_| String::new())),
        );
    let remark = Remark {
        warning: true,
        kind: "gap".to_owned(),
        text: "3 rows are missing [lines 3-5]".to_owned(),
    };
    let reasons = ["x", "y"].map(|row| (row.to_owned(), "unknown".to_owned()));
    Document {
        subject: vec!["of <x>|*".to_owned()],
        verdict: Some(Verdict {
            grade: Grade::Good,
            word: "good".to_owned(),
            headline: ["Within 1 mg", "95 %"].map(str::to_owned),
            proof: Vec::new(),
            numbers: vec![["-1 mg".to_owned(), "before".to_owned()]],
            reasons: vec!["It fits.".to_owned()],
            next: vec![Step::run("Go on", "apply", "cal.json")],
        }),
        ..Document::new("Report of <x>")
    }
    .with(
        Section::new("Bias")
            .with(Block::Equation("a = b\nc = d"))
            .with(table)
            .reasons(reasons)
            .full(Block::Code("C", "a = b < c;\n".to_owned()))
            .figures(figures, &["norm", "absent"]),
    )
    .with(Section::new("Left out"))
    .with(
        Section::new("Findings")
            .fact("time", "1 s".to_owned())
            .with(Block::Findings(vec![remark])),
    )
}

#[test]
fn text() {
    let figures = figures();
    assert_eq!(
        document(&figures).to_text(Detail::Summary),
        "\
of <x>|*
good: Within 1 mg (95 %)

Bias
  a = b
  c = d

  Bias, ± 95 %
                            mean
  axis            b, m/s²  x  y  z
  <x>|*  -0.2246 ± 0.0024  –  –  –
  x, y: unknown

Findings
  time  1 s

  ! gap: 3 rows are missing [lines 3-5]

Verdict: good
  - It fits.

Next: Go on: `gravical apply cal.json`
"
    );
    let full = document(&figures).to_text(Detail::Full);
    assert!(full.contains("  C\n    a = b < c;\n"), "{full}");
}

#[test]
fn html() {
    let figures = figures();
    let page = document(&figures).to_html();
    assert!(page.starts_with("<!DOCTYPE html>") && page.ends_with("</html>"));
    let body = page.split("<main").nth(1).unwrap();
    for part in [
        "<p class=\"mark pill\">good</p><h2 id=\"verdict\">Within 1\u{a0}mg <small>95 %</small></h2><p>It fits.</p>",
        "<b>−1 mg</b><span>before</span>",
        "<li>Go on<div class=\"command\"><code>gravical apply cal.json</code></div></li>",
        "<h3>Bias, ± 95 %</h3>",
        "<thead><tr><td colspan=\"2\"></td><th scope=\"colgroup\" colspan=\"3\">mean</th></tr><tr><th scope=\"col\">axis</th><th class=\"n\" scope=\"col\">b, m/s²</th>",
        "<tr><th scope=\"row\">&lt;x&gt;|*</th><td class=\"n\">−0.2246 <small>± 0.0024</small></td><td class=\"n\">–</td>",
        "a = b &lt; c;\n</pre>",
        "<figure id=\"norm\"",
        "3 rows are missing [lines 3-5] <code>gap</code>",
    ] {
        assert!(body.contains(part), "{part} in\n{body}");
    }
    assert!(!page.contains("<x>") && !page.contains("Left out"));
    // Nothing comes from elsewhere; SVG's own name is an address that nobody fetches.
    for word in ["https://", "@import", "url(", " src="] {
        assert!(!page.contains(word), "{word}");
    }
    let addresses = page.matches("http://").count();
    assert_eq!(addresses, page.matches("http://www.w3.org/").count());
}

#[test]
fn long_tables_are_cut_and_say_so() {
    let table = Table::new("", ["name"]);
    let table = (0..1000).fold(table, |table, i| table.row(format!("row {i}"), []));
    let document = Document::new("").with(Section::new("A").with(table));
    let text = document.to_text(Detail::Summary);
    assert_eq!(text.lines().count(), 3 + 23 + 1, "{text}");
    assert!(text.ends_with("  row 22\n  … and 977 more; --json has all\n"));
    for full in [document.to_text(Detail::Full), document.to_html()] {
        assert!(full.contains("row 199") && !full.contains("row 200"));
        assert!(full.contains("… and 800 more"));
    }
}

#[test]
fn findings_that_files_share_are_listed_once() {
    use gravical::recording::Finding;
    let finding = |file: &str, n: u32| -> Finding {
        let json = serde_json::json!({
            "kind": "gap", "severity": "warning", "message": format!("{n} gaps"), "file": file,
        });
        serde_json::from_value(json).unwrap()
    };
    let all = Remark::all(&[finding("a/x.csv", 1), finding("a/y.csv", 2)], true);
    let text: String = all.iter().map(Remark::to_text).collect();
    assert_eq!(text, "  ! gap: 1 gaps [x.csv; also in 1 other file]\n");
}

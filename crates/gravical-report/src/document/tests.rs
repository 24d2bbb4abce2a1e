use super::*;
use crate::figure::{Axis, Figure, Panel, Role, Series};

fn figure() -> Figure {
    let line = Series::line("a", Role::Raw, vec![0.0, 1.0], vec![0.0, 1.0]);
    let panel = Panel::new("", Axis::new("t", "s"), Axis::new("y", "m")).with(line);
    Figure::new("norm", "A figure", "What it shows.").with(panel)
}

fn remark() -> Remark {
    Remark {
        warning: true,
        kind: "gap".to_owned(),
        text: "3 rows are missing".to_owned(),
        place: "lines 3-5".to_owned(),
    }
}

/// One of everything, with a name that is markup in each of the formats.
fn document(figure: &Figure) -> Document<'_> {
    let table = Table::new("Bias, ± 1σ")
        .columns(["axis", "b, m/s²"])
        .columns(Column::axes("mean"))
        .row([
            Cell::text("<x>|*"),
            Cell::number("-0.2246").plus_minus(Some(0.0012), 4),
            Cell::number("–"),
            Cell::number("–"),
            Cell::number("–"),
        ]);
    let code = Snippet {
        language: "C",
        fence: "c",
        code: "a = b < c;\n".to_owned(),
    };
    Document {
        subject: vec!["of <x>|*".to_owned()],
        stamp: "today".to_owned(),
        verdict: Some(Verdict {
            next: vec!["Go on.".to_owned()],
            conclusion: Some("It holds.".to_owned()),
            ..Verdict::new(Grade::Good, "good", &["It fits.".to_owned()])
        }),
        ..Document::new("Report of <x>")
    }
    .with(
        Section::new("bias", "Bias")
            .with(Block::Equation(vec!["a = b", "c = d"]))
            .with(table)
            .with(Block::note("b: bias."))
            .full(Block::Snippets(vec![code]))
            .figures([figure]),
    )
    .with(Section::new("empty", "Left out"))
    .with(
        Section::new("findings", "Findings")
            .with(Block::Facts(vec![("time".to_owned(), "1 s".to_owned())]))
            .with(Block::Findings(vec![remark()])),
    )
}

#[test]
fn text() {
    let figure = figure();
    assert_eq!(
        document(&figure).to_text(Detail::Summary),
        "\
of <x>|*
good: It holds.

Bias
  a = b
  c = d

  Bias, ± 1σ
                            mean
  axis            b, m/s²  x  y  z
  <x>|*  -0.2246 ± 0.0012  –  –  –
  b: bias.

Findings
  time  1 s

  ! gap: 3 rows are missing [lines 3-5]

Verdict: good
  - It fits.

Next: Go on.
"
    );
    let full = document(&figure).to_text(Detail::Full);
    assert!(full.contains("  C\n    a = b < c;\n"), "{full}");
    assert!(full.ends_with("  - It fits.\n\nNext: Go on.\n"), "{full}");
}

#[test]
fn markdown() {
    let figure = figure();
    let text = document(&figure).to_markdown(Some("x y_figures"));
    assert_eq!(
        text,
        r"# Report of \<x\>

of \<x\>\|\*

today

## Verdict

**good**: It holds.

- It fits.

Next:

- Go on.

## Bias

```
a = b
c = d
```

Bias, ± 1σ:

| axis | b, m/s² | mean: x | mean: y | mean: z |
| :-- | --: | --: | --: | --: |
| \<x\>\|\* | −0.2246 ± 0.0012 | – | – | – |

b: bias.

C:

```c
a = b < c;
```

![A figure](<x y_figures/norm.svg>)

What it shows.

## Findings

- time: 1 s

- **gap** (warning): 3 rows are missing \[lines 3-5\]
"
    );
}

#[test]
fn html() {
    let figure = figure();
    let page = document(&figure).to_html();
    assert!(page.starts_with("<!DOCTYPE html>") && page.ends_with("</html>"));
    let body = page.split("<main").nth(1).unwrap();
    for part in [
        "<p class=\"badge good\"><span class=\"sign\" aria-hidden=\"true\">✓</span> <strong>good</strong></p>",
        "<p class=\"conclusion\">It holds.</p>",
        "<p class=\"equation\">a = b<br>c = d</p>",
        "<caption>Bias, ± 1σ</caption><thead><tr><th scope=\"col\" rowspan=\"2\">axis</th><th class=\"n\" scope=\"col\" rowspan=\"2\">b, m/s²</th><th scope=\"colgroup\" colspan=\"3\">mean</th></tr><tr><th class=\"n\" scope=\"col\" rowspan=\"1\">x</th>",
        "<tr><th scope=\"row\">&lt;x&gt;|*</th><td class=\"n\">−0.2246 <span class=\"sd\">± 0.0012</span></td><td class=\"n\">–</td>",
        "<details open><summary>C</summary>",
        "a = b &lt; c;\n</pre>",
        "<figure id=\"figure-norm\"",
        "<div><dt>time</dt><dd>1 s</dd></div>",
        "<code>gap</code> 3 rows are missing<span class=\"where\"> [lines 3-5]</span>",
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
    let row = |i: usize| Row::from([Cell::text(format!("row {i}"))]);
    let table = Table::new("").columns(["name"]).rows((0..1000).map(row));
    let document = Document::new("").with(Section::new("a", "A").with(table));
    let text = document.to_text(Detail::Summary);
    assert_eq!(text.lines().count(), 3 + 23 + 1, "{text}");
    assert!(text.ends_with("  row 22\n  … and 977 more; --json has all\n"));
    for full in [
        document.to_text(Detail::Full),
        document.to_html(),
        document.to_markdown(None),
    ] {
        assert!(full.contains("row 199") && !full.contains("row 200"));
        assert!(full.contains("… and 800 more"));
    }
}

#[test]
fn a_drawing_that_does_not_fit_is_named() {
    let x: Vec<f64> = (0..40_000).map(f64::from).collect();
    let y: Vec<f64> = x.iter().map(|v| (v * 0.7).sin()).collect();
    let line = Series::line("a", Role::Raw, x, y);
    let panel = Panel::new("", Axis::new("t", "s"), Axis::new("y", "m")).with(line);
    let figures: Vec<Figure> = (0..20)
        .map(|i| Figure::new(&format!("f{i}"), "F", "").with(panel.clone()))
        .collect();
    let page = Document::new("")
        .with(Section::new("a", "A").figures(&figures))
        .to_html();
    assert!(page.len() < 5_000_000, "{} bytes", page.len());
    assert!(page.contains("would make the page too large"));
}

#[test]
fn no_line_is_wider_than_a_terminal() {
    let number = || Cell::number("-1234.56").plus_minus(Some(1e-2), 2);
    let table = |text: &str| {
        let mut cells = vec![Cell::text(text)];
        cells.extend((0..5).map(|_| number()));
        cells.push(Cell::text("some more words ".repeat(9)));
        Table::new("Wide")
            .columns(["name"])
            .columns((0..5).map(|i| Column::from(&*format!("column {i}, m/s²"))))
            .columns(["sentences"])
            .row(Row::from(cells).noted("a reason ".repeat(20)))
    };
    let paragraph = Block::paragraph("word ".repeat(60));
    let section = Section::new("a", "A").with(paragraph).with(table("x"));
    let text = Document::new("").with(section).to_text(Detail::Full);
    assert!(text.lines().all(|l| l.chars().count() <= 80), "{text}");
    assert_eq!(text.matches("± 0.01").count(), 5);
}

#[test]
fn findings_that_files_share_are_listed_once() {
    use gravical::recording::{Finding, FindingKind};
    let finding =
        |file: &str, n: u32| Finding::new(FindingKind::Gap, format!("{n} gaps")).in_file(file);
    let all = [finding("a/x.csv", 1), finding("a/y.csv", 2)];
    let text: String = Remark::all(&all, true)
        .iter()
        .map(Remark::to_text)
        .collect();
    assert_eq!(text, "  ! gap: 1 gaps [x.csv; also in 1 other file]\n");
    // Long lists stay quick.
    let many = vec![Finding::new(FindingKind::Gap, "x".repeat(300)); 10_000];
    assert_eq!(Remark::all(&many, true).len(), 10_000);
}

#[test]
fn markdown_says_what_is_written() {
    for (text, escaped) in [
        ("- a", "\\- a"),
        ("-0.1", "-0.1"),
        ("1. a", "1\\. a"),
        ("1.5 m", "1.5 m"),
        ("--force", "\\-\\-force"),
        ("give `--gravity`: 1.5 mg", "give `--gravity`: 1.5 mg"),
        ("a -- b", "a -\\- b"),
        ("a_b <i> `c<_` $d$", "a\\_b \\<i\\> `c<_` \\$d\\$"),
        ("`a|b` `", "a\\|b \\`"),
    ] {
        let document = Document::new("").with(Section::new("a", "A").with(Block::paragraph(text)));
        assert!(
            document
                .to_markdown(None)
                .ends_with(&format!("\n\n{escaped}\n")),
            "{text}"
        );
    }
}

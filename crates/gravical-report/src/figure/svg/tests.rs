use super::super::{Axis, Figure, Panel, Role, Series};
use super::*;

fn example() -> Figure {
    let time = || Axis::new("time", "s");
    let t: Vec<f64> = (0..100).map(|i| f64::from(i) * 0.1).collect();
    let sine: Vec<f64> = t.iter().map(|t| t.sin()).collect();
    let low = sine.iter().map(|v| v - 0.2).collect();
    let high = sine.iter().map(|v| v + 0.2).collect();
    let panel = Panel::new(time(), Axis::new("x", "m/s²"))
        .titled("x")
        .shaded("at rest", 0.0, 2.0)
        .with(Series::band("± 1σ", Role::Calibrated, t.clone(), low, high))
        .with(Series::line(
            "raw",
            Role::Raw,
            t.clone(),
            sine.iter().map(|v| v + 0.3).collect(),
        ))
        .with(Series::line("calibrated", Role::Calibrated, t, sine));
    let names = vec!["+x".to_owned(), "<&\u{1}>".to_owned()];
    let second = Panel::new(Axis::names("placement", names), Axis::new("‖a‖", "m/s²"))
        .with(
            Series::points("raw", Role::Raw, vec![0.0, 1.0], vec![9.8, 9.9])
                .plus_minus(&[0.1, f64::NAN]),
        )
        .with(Series::rule("gravity", Role::Reference, 9.81));
    Figure::new("example", "An <example>", "It shows & tells.")
        .with(panel)
        .beside()
        .with(second)
}

#[test]
fn well_formed_whatever_the_names() {
    let alone = standalone(&example());
    assert!(!alone.contains('\u{1}'));
    assert!(alone.contains("An &lt;example&gt;") && alone.contains("data-name=\"at rest\""));
    for drawing in inline(&example()) {
        assert!(drawing.starts_with("<svg"));
    }
    assert_eq!(inline(&example()).len(), 2);
}

#[test]
fn nothing_to_draw_is_said() {
    let nan = vec![f64::NAN; 3];
    let panel = Panel::new(Axis::new("t", "s"), Axis::new("y", "")).with(Series::line(
        "a",
        Role::Raw,
        vec![0.0, 1.0, 2.0],
        nan,
    ));
    let text = standalone(&Figure::new("e", "E", "").with(panel));
    assert!(text.contains("no values") && !text.contains("NaN"));
    let none = standalone(&Figure::new("e", "E", ""));
    assert!(none.contains("</svg>"));
}

#[test]
fn huge_and_constant_values_stay_finite() {
    for values in [
        vec![1e308, -1e308],
        vec![0.0, 0.0],
        vec![f64::INFINITY, 1.0],
    ] {
        let panel = Panel::new(Axis::new("t", "s"), Axis::new("y", "")).with(Series::line(
            "a",
            Role::Raw,
            vec![0.0, 1.0],
            values,
        ));
        let text = standalone(&Figure::new("e", "E", "").with(panel.equal(1.0)));
        assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
    }
}

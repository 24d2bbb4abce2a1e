//! All 27 nonlinear problems of NIST from both starting points, against the
//! certified parameters, standard deviations and sums of squares.

use gravical::estimate::solve::{Ending, Factor, Options, Summary, solve};

use super::problems::Nist;

pub const NAMES: [&str; 27] = [
    "Bennett5", "BoxBOD", "Chwirut1", "Chwirut2", "DanWood", "ENSO", "Eckerle4", "Gauss1",
    "Gauss2", "Gauss3", "Hahn1", "Kirby2", "Lanczos1", "Lanczos2", "Lanczos3", "MGH09", "MGH10",
    "MGH17", "Misra1a", "Misra1b", "Misra1c", "Misra1d", "Nelson", "Rat42", "Rat43", "Roszman1",
    "Thurber",
];

/// Digits that have to agree, of 11 that are certified.
const PARAMETER_DIGITS: f64 = 9.0;
const SD_DIGITS: f64 = 9.0;
const RSS_DIGITS: f64 = 9.9;

/// Significant digits that agree (log relative error).
fn digits(got: f64, certified: f64) -> f64 {
    if got == certified {
        return 16.0;
    }
    -((got - certified).abs() / certified.abs()).log10()
}

fn worst(got: &[f64], certified: &[f64]) -> f64 {
    got.iter()
        .zip(certified)
        .map(|(g, c)| digits(*g, *c))
        .fold(16.0, f64::min)
}

/// The longest way is 560 steps (MGH17 from its first start).
fn options(problem: &Nist, start: usize) -> Options {
    Options {
        most_steps: 1000,
        damping: match (&problem.name[..], start) {
            // See `what_the_usual_damping_makes_of_two_starts`.
            ("BoxBOD", 0) => 100.0,
            ("MGH10", 0) => 1e-8,
            _ => Options::default().damping,
        },
        ..Options::default()
    }
}

/// √(covariance · RSS/freedom).
fn standard_deviations(problem: &Nist, found: &Vec<f64>, summary: &Summary) -> Vec<f64> {
    let covariance = Factor::new(problem, found).unwrap().covariance();
    let values = covariance.values.unwrap();
    (0..found.len())
        .map(|j| (values[j][j] * summary.cost / problem.freedom as f64).sqrt())
        .collect()
}

#[test]
fn the_files_hold_what_is_certified() {
    for name in NAMES {
        let problem = Nist::read(name);
        let cost: f64 = (0..problem.rows())
            .map(|i| problem.residual(&problem.certified, i).value.powi(2))
            .sum();
        if name == "Lanczos1" {
            // Residuals of 1e-13 vanish beside the rounding of the parameters
            // to 11 digits.
            assert!(cost < 1e-20, "{cost}");
        } else {
            assert!(digits(cost, problem.rss) > 9.0, "{name}: {cost}");
        }
    }
}

#[test]
fn certified_values_are_reached_from_both_starts() {
    println!("digits of:            parameters     sd    rss   steps taken/tried");
    for name in NAMES {
        let problem = Nist::read(name);
        for start in 0..2 {
            let from = problem.starts[start].clone();
            let (found, summary) = solve(&problem, from, &options(&problem, start));
            assert!(summary.converged(), "{name} {start}: {summary:?}");
            let sd = standard_deviations(&problem, &found, &summary);
            let reached = [
                worst(&found, &problem.certified),
                worst(&sd, &problem.sd),
                digits(summary.cost, problem.rss),
            ];
            println!(
                "{name:10} start {} {:16.1} {:8.1} {:6.1}   {}/{} {:?}",
                start + 1,
                reached[0],
                reached[1],
                reached[2],
                summary.accepted,
                summary.tried,
                summary.ending
            );
            // Lanczos1: the sum of squares, and with it the standard deviations,
            // is rounding: residuals of 1e-13 of values of 1 keep 3 digits.
            let (sd_digits, rss_digits) = if name == "Lanczos1" {
                (2.5, 2.5)
            } else {
                (SD_DIGITS, RSS_DIGITS)
            };
            assert!(reached[0] > PARAMETER_DIGITS, "{name} {start}: {found:?}");
            assert!(reached[1] > sd_digits, "{name} {start}: {sd:?}");
            assert!(reached[2] > rss_digits, "{name} {start}: {summary:?}");
        }
    }
}

/// Two first starts lead elsewhere with the damping that all others start with.
#[test]
fn what_the_usual_damping_makes_of_two_starts() {
    let usual = Options {
        most_steps: 2000,
        ..Options::default()
    };
    // y = b₁(1 − e^(−b₂x)) from b₂ = 1: a first step beyond b₂ = 30 puts e^(−b₂x)
    // out of reach, the column of b₂ is empty, and what is left is the mean of
    // y, 172.5, with 9771.5 in place of 1168.0. No step leads back: it is a
    // minimum at infinity. A damping of 100 keeps the first step short.
    let problem = Nist::read("BoxBOD");
    let (found, summary) = solve(&problem, problem.starts[0].clone(), &usual);
    println!("BoxBOD: {found:?} {summary:?}");
    assert!(
        (found[0] - 172.5).abs() < 1e-3 && found[1] > 30.0,
        "{found:?}"
    );
    assert!((summary.cost - 9771.5).abs() < 1e-6, "{summary:?}");
    let sd = standard_deviations(&problem, &found, &summary);
    assert!(sd[1] > 1e20, "b₂ is known to be unknown: {sd:?}");

    // y = b₁ e^(b₂/(x + b₃)) from (2, 400 000, 25 000), where it is 10⁷ in place
    // of 10⁴: damped steps lower it by b₁ first, down to 10⁻³⁶, and then follow
    // a valley of ln b₁ + b₂/(x + b₃) = constant whose floor falls ever more
    // slowly: 40 000 steps do not end it. Gauss and Newton's first steps do not
    // enter it.
    let problem = Nist::read("MGH10");
    let (found, summary) = solve(&problem, problem.starts[0].clone(), &usual);
    println!("MGH10: {found:?} {summary:?}");
    assert_eq!(summary.ending, Ending::MostSteps);
    assert!(!summary.converged() && found[0] < 1e-30);
}

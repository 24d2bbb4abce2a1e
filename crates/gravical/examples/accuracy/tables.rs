//! The tables of docs/accuracy.md.

use crate::means::{MeanReading, MeansOptions, Part};
use gravical::estimate::joint::joint;

use crate::each::each;
use crate::runs::{Plan, Session, ferraris, linear, magnitude6, magnitude9, outcome};
use crate::table::{MG, Outcomes, coverage, direction_deg, errors, markdown, norm_mg, quantiles};

const TILTS_DEG: [f64; 4] = [0.1, 1.0, 2.0, 3.0];

/// How many parts, and which.
#[derive(Debug, Clone, Copy)]
pub struct Runs {
    pub count: usize,
    pub seed: u64,
}

fn session(plan: Plan, tilt_deg: f64) -> Session {
    Session {
        means: MeansOptions {
            tilt_sd_rad: tilt_deg.to_radians(),
            ..MeansOptions::default()
        },
        plan,
        tilt_given: true,
        roles_told: true,
    }
}

fn row(name: &str, cells: impl IntoIterator<Item = String>) -> Vec<String> {
    std::iter::once(name.to_owned()).chain(cells).collect()
}

/// Every estimator on every kind of session.
pub fn estimators(runs: Runs) -> String {
    let by = |plan, tilt, f: fn(&[MeanReading], &MeansOptions) -> _| {
        errors(&session(plan, tilt).by(runs.seed, runs.count, f))
    };
    let nothing = |_: &[MeanReading], _: &MeansOptions| {
        Some((
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            [0.0; 3],
        ))
    };
    let mut rows = vec![
        row("none", [by(Plan::Faces(1), 1.0, nothing)]),
        row(
            "`ferraris`, 6 faces",
            TILTS_DEG.map(|t| by(Plan::Faces(1), t, ferraris)),
        ),
        row(
            "`linear12`, 6 faces",
            TILTS_DEG.map(|t| by(Plan::Faces(1), t, linear)),
        ),
        row(
            "`magnitude6`, 6 faces",
            TILTS_DEG.map(|t| by(Plan::Faces(1), t, magnitude6)),
        ),
        row(
            "`magnitude9`, 12 poses",
            [by(Plan::Poses(12), 1.0, magnitude9)],
        ),
    ];
    rows[4].resize(5, String::new());
    rows[0].resize(5, String::new());
    for (name, plan) in [
        ("`joint`, 6 faces", Plan::Faces(1)),
        ("`joint`, 6 faces + 3 random", Plan::Random(3)),
        ("`joint`, 6 faces + 3 proposed", Plan::Proposed(3)),
        ("`joint`, 6 faces + 6 random", Plan::Random(6)),
        ("`joint`, 6 faces + 6 of a lattice", Plan::Lattice(6)),
        ("`joint`, 6 faces + 6 spread", Plan::Spread(6)),
        ("`joint`, 6 faces + 18 random", Plan::Random(18)),
        ("`joint`, 6 faces + 18 of a lattice", Plan::Lattice(18)),
        ("`joint`, 6 faces + 18 spread", Plan::Spread(18)),
        ("`joint`, each face 4 times", Plan::Faces(4)),
    ] {
        rows.push(row(
            name,
            TILTS_DEG.map(|t| errors(&session(plan, t).joint(runs.seed, runs.count))),
        ));
    }
    markdown(&["estimator", "tilt 0.1°", "1°", "2°", "3°"], &rows)
}

/// How often intervals hold the truth.
pub fn intervals(runs: Runs) -> String {
    let mut rows = Vec::new();
    for (name, plan) in [
        ("6 faces", Plan::Faces(1)),
        ("6 faces + 3 proposed", Plan::Proposed(3)),
        ("6 faces + 6 random", Plan::Random(6)),
        ("6 faces + 12 random", Plan::Random(12)),
        ("each face 4 times", Plan::Faces(4)),
    ] {
        for given in [true, false] {
            rows.push(row(
                &format!("{name}, tilt {}", if given { "given" } else { "estimated" }),
                TILTS_DEG.map(|t| {
                    let session = Session {
                        tilt_given: given,
                        ..session(plan, t)
                    };
                    coverage(&session.joint(runs.seed, runs.count))
                }),
            ));
        }
    }
    markdown(&["session", "tilt 0.1°", "1°", "2°", "3°"], &rows)
}

/// The tilt that is estimated.
pub fn tilts(runs: Runs) -> String {
    let mut rows = Vec::new();
    for (name, plan) in [
        ("6 faces", Plan::Faces(1)),
        ("6 faces + 12 random", Plan::Random(12)),
    ] {
        rows.push(row(
            name,
            TILTS_DEG.map(|t| {
                let session = Session {
                    tilt_given: false,
                    ..session(plan, t)
                };
                let found = session.joint(runs.seed, runs.count);
                let tilts = found.iter().flatten().filter_map(|o| o.fit.as_ref());
                let [median, low, high] = quantiles(tilts.map(|f| f.tilt.to_degrees()).collect());
                format!("{median:.2} ({low:.2} to {high:.2})")
            }),
        ));
    }
    markdown(&["session", "0.1°", "1°", "2°", "3°"], &rows)
}

/// A table that is not level.
pub fn table_not_level(runs: Runs) -> String {
    let mut rows = Vec::new();
    for (name, plan) in [
        ("each face once", Plan::Faces(1)),
        ("each face twice, the same way", Plan::Twice(0.0)),
        (
            "each face twice, turned by 180° between",
            Plan::Twice(180.0),
        ),
    ] {
        let mut session = session(plan, 0.2);
        session.means.table_sd_rad = 2_f64.to_radians();
        session.tilt_given = false;
        let fitted = session.joint(runs.seed, runs.count);
        let shared = fitted.iter().flatten().filter_map(|o| o.fit.as_ref());
        let shared = shared.filter(|f| f.shared_tilts).count();
        rows.push(row(
            name,
            [
                norm_mg(&session.by(runs.seed, runs.count, ferraris)),
                norm_mg(&fitted),
                format!("{shared} of {}", runs.count),
            ],
        ));
    }
    markdown(
        &[
            "session",
            "`ferraris`",
            "`joint`",
            "`joint` took repeats as lying the same way",
        ],
        &rows,
    )
}

/// A board that sits turned, and placements of which nothing is said.
pub fn roles(runs: Runs) -> String {
    let mut rows = Vec::new();
    for (name, turn_deg, given) in [
        ("board straight, faces named", 0.0, true),
        ("board straight, nothing named", 0.0, false),
        ("board turned by 3°, faces named", 3.0_f64, true),
        ("board turned by 3°, nothing named", 3.0, false),
    ] {
        let mut session = session(Plan::Random(12), 1.0);
        session.means.board_turn_rad = turn_deg.to_radians();
        session.tilt_given = false;
        session.roles_told = given;
        let found = session.joint(runs.seed, runs.count);
        rows.push(row(name, [errors(&found), coverage(&found)]));
    }
    markdown(
        &[
            "session",
            "‖a‖ / bias / direction",
            "coverage, bias / scale / ‖a‖",
        ],
        &rows,
    )
}

/// One mean that is off.
pub fn bad_pose(runs: Runs) -> String {
    let mut rows = Vec::new();
    for (name, plan) in [
        ("6 faces + 6 spread", Plan::Spread(6)),
        ("6 faces + 12 spread", Plan::Spread(12)),
    ] {
        let session = Session {
            tilt_given: false,
            roles_told: false,
            ..session(plan, 1.0)
        };
        for offset in [0.0, 0.02, 0.05, 0.2] {
            rows.push(one_off(runs, name, &session, offset));
        }
    }
    markdown(
        &[
            "session",
            "off by, m/s²",
            "left out",
            "good ones left out",
            "error of ‖a‖, median (90 %), mg",
            "direction, °",
        ],
        &rows,
    )
}

/// A row of that table: one mean of each session moved by `offset` in a
/// direction that is drawn.
fn one_off(runs: Runs, name: &str, session: &Session, offset: f64) -> Vec<String> {
    let found = each(runs.count, |index| {
        let mut part = Part::draw(&session.means, runs.seed, index);
        let mut means = session.place(&mut part, index);
        let victim = index % means.len();
        let along = part.random_direction();
        for i in 0..3 {
            means[victim].mean[i] += offset * along[i];
        }
        let fit = joint(&session.poses(&means), &session.options()).ok()?;
        let bad: Vec<usize> = (0..means.len())
            .filter(|&k| fit.poses[k].bad.is_some())
            .collect();
        let right = bad.contains(&victim);
        Some((
            outcome(&mut part, fit)?,
            right,
            bad.len() - usize::from(right),
        ))
    });
    let right = found.iter().flatten().filter(|f| f.1).count();
    let wrong: usize = found.iter().flatten().map(|f| f.2).sum();
    let norms = found.iter().flatten().map(|f| f.0.errors.norm_mps2 * MG);
    let [median, _, high] = quantiles(norms.collect());
    let outcomes: Outcomes = found.into_iter().map(|f| f.map(|f| f.0)).collect();
    row(
        name,
        [
            offset.to_string(),
            if offset > 0.0 {
                format!("{right} of {}", runs.count)
            } else {
                String::new()
            },
            wrong.to_string(),
            format!("{median:.2} ({high:.2})"),
            direction_deg(&outcomes),
        ],
    )
}

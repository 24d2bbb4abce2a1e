//! Do two calibrations of one sensor differ where it did not change, and where it did?

use gravical_fit::later::{Tilts, compare};
use gravical_fit::{Face, Fit, Pose, fit};

use crate::sessions::{MG, Plan, Session, V};

/// Level of each of two tests.
const LEVEL: f64 = 0.005;

sampled! {
    two_sessions_seldom_differ(60, 300);
    changes_of_six_faces_are_found(20, 80);
}

fn fitted(session: &mut Session, plans: &[Plan]) -> Fit {
    let mut directions = Vec::new();
    for plan in plans {
        directions.extend(session.directions(*plan));
    }
    let pose = |n: &V| session.pose(n, V::zeros());
    let poses: Vec<Pose> = directions.iter().map(pose).collect();
    fit(&poses, &session.options).unwrap()
}

fn tilts(fit: &Fit) -> Tilts {
    let poses = fit.poses();
    let faces = poses.iter().filter_map(|p| p.face);
    Tilts {
        faces: faces.map(Face::direction).collect(),
        sd_rad: fit.tilt(),
        freedom: fit.quality.tilt_degrees_of_freedom,
    }
}

fn differ(pair: [&Fit; 2]) -> bool {
    let [a, b] = pair.map(|fit| fit.sensor(1.0));
    let [of_a, of_b] = pair.map(tilts);
    let found = compare([(&a, &of_a), (&b, &of_b)]).unwrap();
    let is_oriented = pair.iter().all(|fit| fit.quality.oriented);
    let turn = found.turn.filter(|_| is_oriented);
    let tests = [Some(found.magnitude.test), turn.map(|t| t.test)];
    tests.iter().flatten().any(|test| test.p_value < LEVEL)
}

/// With tilts of 1° that nobody told: six faces, six faces and free poses, free poses, and one after the other.
fn two_sessions_seldom_differ(pairs: usize) {
    let six = [Plan::Proposed(0)].as_slice();
    let more = [Plan::Proposed(0), Plan::Free(6)].as_slice();
    let free = [Plan::Free(18)].as_slice();
    for (first, second) in [
        (six, six),
        (more, more),
        (free, free),
        (six, more),
        (six, free),
    ] {
        let wrong = (0..pairs as u64).filter(|seed| {
            let mut session = Session::new(50_000 + seed);
            let first = fitted(&mut session, first);
            differ([&first, &fitted(&mut session, second)])
        });
        let wrong = wrong.count();
        println!("{first:?}, {second:?}: {wrong} of {pairs}");
        assert!(
            50 * wrong <= pairs.max(100),
            "{first:?} {second:?}: {wrong}"
        );
    }
}

/// A bias by 10 mg, a scale by 0.3 %.
fn changes_of_six_faces_are_found(pairs: usize) {
    for (bias, scale) in [(10.0 * MG, 1.0), (0.0, 1.003)] {
        let found = (0..pairs).filter(|seed| {
            let mut session = Session::new(60_000 + *seed as u64);
            let first = fitted(&mut session, &[Plan::Proposed(0)]);
            let axis = seed % 3;
            session.sensor.b[axis] += bias;
            session.sensor.m.row_mut(axis).scale_mut(scale);
            differ([&first, &fitted(&mut session, &[Plan::Proposed(0)])])
        });
        assert_eq!(found.count(), pairs, "{bias} {scale}");
    }
}

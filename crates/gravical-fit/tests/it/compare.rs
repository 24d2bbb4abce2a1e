//! Do two calibrations of one sensor differ where it did not change, and where it did?

use gravical_fit::consistency::{Placements, compare};
use gravical_fit::{Fit, Pose, fit};

use nalgebra::Matrix3;

use crate::sessions::{MG, Plan, Session, V};

/// Level of each of two tests.
const LEVEL: f64 = 0.005;

sampled! {
    two_sessions_seldom_differ(60, 300);
    changes_of_six_faces_are_found(20, 80);
}

type Fitted = (Fit, Vec<Pose>);

fn fitted(session: &mut Session, plans: &[Plan]) -> Fitted {
    let mut directions = Vec::new();
    for plan in plans {
        directions.extend(session.directions(*plan));
    }
    let pose = |n: &V| session.pose(n, V::zeros());
    let poses: Vec<Pose> = directions.iter().map(pose).collect();
    (fit(&poses, &session.options).unwrap(), poses)
}

fn placements((fit, poses): &Fitted) -> Placements {
    let model = fit.model();
    let inverse = Matrix3::from_fn(|r, c| model[r][c]).try_inverse().unwrap();
    let force = |pose: &Pose| (inverse * (V::from(pose.mean) - V::from(fit.bias()))).into();
    let faces = poses
        .iter()
        .zip(fit.poses())
        .filter(|(_, p)| p.face.is_some());
    Placements {
        forces: faces.map(|(pose, _)| force(pose)).collect(),
        tilt_rad: fit.tilt(),
        freedom: fit.quality.tilt_degrees_of_freedom,
    }
}

fn differ(pair: [&Fitted; 2]) -> bool {
    let [a, b] = pair.map(|(fit, _)| fit.sensor(1.0));
    let [of_a, of_b] = pair.map(placements);
    let found = compare([(&a, &of_a), (&b, &of_b)]).unwrap();
    let is_oriented = pair.iter().all(|(fit, _)| fit.quality.oriented);
    let turn = found.turn.filter(|_| is_oriented);
    let tests = [Some(found.magnitude.test), turn.map(|t| t.test)];
    tests.iter().flatten().any(|test| test.p_value < LEVEL)
}

/// With tilts that nobody told: six faces, six faces and free poses, free poses, and one after the other.
fn two_sessions_seldom_differ(pairs: usize) {
    let six = [Plan::Proposed(0)].as_slice();
    let more = [Plan::Proposed(0), Plan::Free(6)].as_slice();
    let free = [Plan::Free(18)].as_slice();
    for (tilt_deg, first, second) in [
        (1_f64, six, six),
        (2.0, six, six),
        (1.0, more, more),
        (1.0, free, free),
        (2.0, six, more),
        (2.0, six, free),
    ] {
        let wrong = (0..pairs as u64).filter(|seed| {
            let mut session = Session::new(50_000 + seed);
            session.tilt = tilt_deg.to_radians();
            let first = fitted(&mut session, first);
            differ([&first, &fitted(&mut session, second)])
        });
        let wrong = wrong.count();
        println!("{tilt_deg}° {first:?}, {second:?}: {wrong} of {pairs}");
        assert!(
            50 * wrong <= pairs.max(100),
            "{tilt_deg}° {first:?} {second:?}: {wrong}"
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

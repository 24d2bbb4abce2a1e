//! Conversion of a scenario to paths and their events.

use nalgebra::Vector3;

use super::builder::{Builder, Plan};
use super::options::SimulateOptions;
use super::path::Law;
use super::poses::{Draws, Z_UP, spread_directions};
use super::scenario_options::{
    LINE_OFFSET_M, LineOptions, PosesOptions, Scenario, SixPositionOptions, StaticOptions, TURN_S,
};
use super::truth::PoseKind;
use crate::poses::face::Face;

/// The recordings of `options.scenario`.
pub(super) fn plan(options: &SimulateOptions) -> Vec<Plan> {
    let mut draws = Draws::new(options.seed, options.tilt_sd_deg);
    match &options.scenario {
        Scenario::SixPosition(o) if o.continuous => vec![session(options, o, &mut draws)],
        Scenario::SixPosition(o) => six_files(options, o, &mut draws),
        Scenario::Poses(o) => vec![poses(options, o, &mut draws)],
        Scenario::Static(o) => vec![still(options, o, &mut draws)],
        Scenario::Line(o) => vec![line(options, o, &mut draws)],
    }
}

fn six_files(options: &SimulateOptions, o: &SixPositionOptions, draws: &mut Draws) -> Vec<Plan> {
    let mut plans = Vec::with_capacity(6);
    for face in Face::all() {
        let (nominal, up) = draws.face_pose(face);
        let mut build = Builder::new(options, up);
        build.hold(&face.name(), PoseKind::Face, Some(nominal), o.hold_s);
        let letter = ["x", "y", "z"][face.axis];
        let sign = if face.up { "pos" } else { "neg" };
        plans.push(build.finish(format!("{letter}_axis_{sign}.csv")));
    }
    plans
}

fn session(options: &SimulateOptions, o: &SixPositionOptions, draws: &mut Draws) -> Plan {
    let mut build = faces(options, o.hold_s, draws);
    for (axis, label) in ["x", "y", "z"].into_iter().enumerate() {
        let (nominal, up) = draws.face_pose(Face { axis, up: true });
        build.move_to(up);
        build.rest(nominal, o.rest_s);
        build.turn(label, up, o.turn_angle_deg, TURN_S);
        build.rest(nominal, o.rest_s);
    }
    build.finish("session.csv".to_owned())
}

fn poses(options: &SimulateOptions, o: &PosesOptions, draws: &mut Draws) -> Plan {
    let mut build = faces(options, o.hold_s, draws);
    for (i, up) in spread_directions(o.free as usize, options.seed)
        .into_iter()
        .enumerate()
    {
        build.move_to(up.into());
        build.hold(&format!("free{}", i + 1), PoseKind::Free, None, o.hold_s);
    }
    build.finish("poses.csv".to_owned())
}

/// The six faces one after the other, moved by hand.
fn faces(options: &SimulateOptions, hold_s: f64, draws: &mut Draws) -> Builder {
    let placed = Face::all().map(|face| {
        let (nominal, up) = draws.face_pose(face);
        (nominal, up, face.name())
    });
    let mut build = Builder::new(options, placed[0].1);
    for (nominal, up, label) in placed {
        if !build.path.pieces.is_empty() {
            build.move_to(up);
        }
        build.hold(&label, PoseKind::Face, Some(nominal), hold_s);
    }
    build
}

fn still(options: &SimulateOptions, o: &StaticOptions, draws: &mut Draws) -> Plan {
    let (nominal, up) = draws.face_pose(Z_UP);
    let mut build = Builder::new(options, up);
    build.hold("+z", PoseKind::Face, Some(nominal), o.duration_s);
    build.finish("static.csv".to_owned())
}

fn line(options: &SimulateOptions, o: &LineOptions, draws: &mut Draws) -> Plan {
    let (nominal, up) = draws.face_pose(Z_UP);
    let mut build = Builder::new(options, up);
    build.rest(nominal, o.rest_s);
    let displacement = Vector3::new(LINE_OFFSET_M, o.distance_m, 0.0);
    // About x, so that gravity has a component in the direction of travel.
    let wobble = Vector3::x() * o.tilt_change_deg.to_radians();
    build.go(wobble, Law::Sine, displacement, o.move_time_s);
    build.rest(nominal, o.rest_s);
    build.finish("line.csv".to_owned())
}

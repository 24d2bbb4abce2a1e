//! The joint fit, and the methods that assume what it finds out.

use gravical_core::calibration::Calibration;
use gravical_core::matrix3;

use crate::calibration_file::{FitQuality, PoseTilt};
use crate::estimate::ferraris;
use crate::estimate::joint::{
    Elements, JointFit, JointOptions, JointPose, Role, joint, test_drift,
};
use crate::estimate::pose_noise::PoseNoise;
use crate::recording::{Finding, FindingKind};
use crate::segment::Placement;
use crate::segment::face::{AxisMap, Claim, Face};
use crate::{Error, Result};

use super::{
    Estimate, EstimateOptions, MAGNITUDE_PARAMETERS, Method, Session, Use, distinct, undetermined,
};

/// The placements as the joint fit wants them, and what is known beside them.
pub(super) fn joint_problem(
    session: &Session<'_>,
    options: &EstimateOptions,
    noise: &PoseNoise,
    nominal: Option<f64>,
) -> (Vec<JointPose>, JointOptions) {
    let placements = &session.segmentation.placements;
    let poses: Vec<JointPose> = placements
        .iter()
        .enumerate()
        .map(|(k, p)| JointPose {
            mean: p.mean,
            standard_error: noise.noise[k],
            role: role(p, options, session.axes),
            temperature_c: p.temperature_c,
        })
        .collect();
    let start = session
        .faces_by_name
        .then(|| start_by_names(&poses, nominal, session.gravity));
    let joint_options = JointOptions {
        gravity: session.gravity,
        nominal,
        prior: options.prior,
        tilt: options.pose_tilt_deg.map(f64::to_radians),
        quantisation: noise.quantisation,
        start,
        elements: None,
        find_bad: true,
        drift: false,
    };
    (poses, joint_options)
}

/// A pose that nobody names is no face for a method that takes faces as exact when it lies
/// further off, degrees (bias included).
const MOST_OFF_DEG: f64 = 12.0;

/// The face that a pose is taken for by a method that takes faces as exact: what it is named,
/// unless another side is up; else the nearest, where that is near.
fn exact_face(placement: &Placement) -> Option<Face> {
    match placement.claim {
        Some(Claim::Face(named)) if placement.face.is_none_or(|f| f == named) => Some(named),
        _ => placement
            .face
            .filter(|_| placement.angle_deg <= MOST_OFF_DEG),
    }
}

/// Puts the assumptions of a method in place of what the joint fit finds out; a pose without a
/// role is not fitted.
fn assume(
    method: Method,
    (mut poses, mut options): (Vec<JointPose>, JointOptions),
    session: &Session<'_>,
) -> Result<(Vec<Option<JointPose>>, JointOptions)> {
    if method == Method::Joint {
        return Ok((poses.into_iter().map(Some).collect(), options));
    }
    (options.prior, options.find_bad) = (false, false);
    options.elements = Some(match method {
        Method::Magnitude6 => Elements::Diagonal,
        Method::Magnitude9 => Elements::Triangular,
        _ => Elements::All,
    });
    if method != Method::Linear12 {
        poses.iter_mut().for_each(|p| p.role = Role::Free);
        return Ok((poses.into_iter().map(Some).collect(), options));
    }
    options.tilt = Some(0.0);
    let on_face = |(mut pose, placement): (JointPose, &Placement)| {
        pose.role = Role::Face(session.axes.face_to_board(exact_face(placement)?));
        Some(pose)
    };
    let placements = &session.segmentation.placements;
    let poses: Vec<_> = poses.into_iter().zip(placements).map(on_face).collect();
    if poses.iter().all(Option::is_none) {
        return Err(Error::input("missing-face", "no pose lies on a face")
            .with_hint("linear12 needs faces; leave --method out for poses of any kind"));
    }
    Ok((poses, options))
}

pub(super) fn by_joint(
    session: &Session<'_>,
    options: &EstimateOptions,
    noise: PoseNoise,
    nominal: Option<f64>,
) -> Result<Estimate> {
    let placements = &session.segmentation.placements;
    check_names(placements, options)?;
    let faces = ferraris::sort_into_faces(placements, session.recordings).ok();
    let method = options.method;
    let exact = method == Method::Linear12;
    if session.faces_by_name
        && (exact || method == Method::Joint)
        && let Some(faces) = &faces
    {
        // Names that contradict each other, or --axes, are refused in the words
        // of the closed form.
        ferraris::accelerometer(faces, session.gravity, Some(session.axes))?;
    }
    let problem = joint_problem(session, options, &noise, nominal);
    let (roles, mut joint_options) = assume(method, problem, session)?;
    let (of, poses): (Vec<usize>, Vec<JointPose>) = (0..)
        .zip(&roles)
        .filter_map(|(k, p)| Some((k, (*p)?)))
        .unzip();
    let drift = (session.drift && method == Method::Joint)
        .then(|| test_drift(&poses, &joint_options).ok())
        .flatten();
    joint_options.drift = drift.is_some_and(|test| test.helps);
    let fit = joint(&poses, &joint_options)
        .map_err(|e| undetermined::explain(e, &of, method, session))?;
    let turned = matrix3::scale_rows(&fit.model, &matrix3::row_norms(&fit.model).map(|k| 1.0 / k));
    let hand = matrix3::det(&turned);
    if hand <= 0.0 {
        return Err(Error::input(
            "left-handed",
            format!("the faces as named make a left-handed sensor (det R = {hand:.3}): two poses are swapped"),
        )
        .with_hint("leave --faces-from names out, and the faces are taken from the data"));
    }
    let axes = session.axes;
    // u = M_board a_board + b, and a_board = P a_case.
    let columns = |rows: &[[f64; 3]; 3]| rows.map(|row| axes.to_case(row));
    let model = columns(&fit.model);
    let matrix = matrix3::inverse(&model).ok_or_else(|| {
        Error::input("singular", "the fitted model has no inverse")
            .with_hint("`gravical inspect` shows what each pose reads")
    })?;
    let mut fit = fit;
    for (_, part) in &mut fit.sources {
        axes.columns_to_case(part);
    }
    let mut covariance = fit.covariance;
    axes.columns_to_case(&mut covariance);
    if let Some(reliability) = &mut fit.reliability {
        axes.columns_to_case(&mut reliability.covariance);
        for test in &mut reliability.tests {
            test.pose = of[test.pose];
            for row in 0..3 {
                let of = &mut test.influence[3 * row..3 * row + 3];
                of.copy_from_slice(&axes.to_case([of[0], of[1], of[2]]));
            }
        }
    }
    let mut uses = vec![Use::default(); placements.len()];
    for (&k, pose) in of.iter().zip(&fit.poses) {
        uses[k] = Use {
            face: pose.face.map(|f| axes.face_to_case(f)),
            fitted: pose.bad.is_none(),
            tilt_deg: match exact {
                true => Some((placements[k].angle_deg, None)),
                false => pose
                    .tilt
                    .map(|(tilt, sd)| (tilt.to_degrees(), Some(sd.to_degrees()))),
            },
            direction: Some(axes.to_case(pose.direction)),
            left_out_error: pose.left_out_error,
            left_out_sd: pose.left_out_sd,
            bad: pose.bad,
        };
    }
    let fitted: Vec<[f64; 3]> = fit
        .poses
        .iter()
        .filter(|p| p.bad.is_none())
        .map(|p| p.direction)
        .collect();
    let has_faces = fit.poses.iter().any(|p| p.face.is_some());
    let left_over = match method {
        Method::Joint => (distinct(&fitted) as u32).saturating_sub(MAGNITUDE_PARAMETERS),
        Method::Linear12 => (poses.len() as u32).saturating_sub(6),
        _ => fit.freedom as u32,
    };
    let faces_exact = || {
        Finding::new(
            FindingKind::FacesExact,
            "linear12 takes every face as exactly level: a tilt of 1° costs about 10 mg, and it is not in the uncertainty. Without a precise fixture, leave --method out",
        )
    };
    Ok(Estimate {
        drift,
        method,
        model,
        bias: fit.bias,
        calibration: Calibration {
            matrix,
            bias: fit.bias,
        },
        covariance: Some(covariance),
        uses,
        tilt: (has_faces && !exact).then_some(PoseTilt {
            value: fit.tilt.to_degrees(),
            source: fit.tilt_from,
        }),
        degrees_of_freedom: left_over,
        faces,
        face_angle_rms_deg: None,
        quality: Some(quality(
            &fit,
            &model,
            joint_options.prior && nominal.is_some(),
        )),
        joint: Some(fit),
        noise,
        findings: exact.then(faces_exact).into_iter().collect(),
    })
}

fn quality(fit: &JointFit, model: &[[f64; 3]; 3], prior: bool) -> FitQuality {
    FitQuality {
        chi2_per_freedom: fit.chi2_per_freedom,
        freedom: fit.freedom,
        model_error_mps2: fit.model_error / matrix3::row_norms(model)[0],
        condition: Some(fit.condition).filter(|c| c.is_finite()),
        oriented: fit.oriented,
        shared_tilts: fit.shared_tilts,
        tilt_degrees_of_freedom: fit.gamma,
        prior,
    }
}

/// True when `name` is the label of a placement, its face (`+x`: all poses on it), or its file.
fn is_called(placement: &Placement, name: &str) -> bool {
    let stem = crate::recording::open::stem(&placement.source);
    let file = std::path::Path::new(&placement.source).file_name();
    placement.label == name
        || placement.face.is_some_and(|face| face.name() == name)
        || stem == name
        || placement.source == name
        || file.is_some_and(|file| file == name)
}

fn role(placement: &Placement, options: &EstimateOptions, axes: &AxisMap) -> Role {
    let board = |face: Face| axes.face_to_board(face);
    if options.free.iter().any(|n| is_called(placement, n)) {
        return Role::Free;
    }
    if options.face.iter().any(|n| is_called(placement, n)) {
        return placement.face.map_or(Role::Open, |f| Role::Face(board(f)));
    }
    match (placement.claim, placement.face) {
        // Names were believed, or held against the data, when it was cut.
        (Some(Claim::Face(_) | Claim::Axis(_)), Some(face)) => Role::Named(board(face)),
        _ => Role::Open,
    }
}

fn check_names(placements: &[Placement], options: &EstimateOptions) -> Result<()> {
    for (option, names) in [("free", &options.free), ("face", &options.face)] {
        for name in names {
            let Some(placement) = placements.iter().find(|p| is_called(p, name)) else {
                let known: Vec<String> = placements.iter().map(called).collect();
                let what = format!("there is no pose {name}");
                return Err(Error::usage("no-such-pose", what)
                    .of_option(option)
                    .with_hint(format!("give one of: {}", known.join(", "))));
            };
            if option == "face" && placement.face.is_none() {
                let what = format!(
                    "{name} is {:.0}° from the nearest axis; beyond 25° it is no face pose",
                    placement.angle_deg
                );
                return Err(Error::usage("no-such-pose", what)
                    .of_option(option)
                    .with_hint("leave it to the fit, which treats it as a free pose"));
            }
        }
    }
    Ok(())
}

/// The label, and the face where it is another word.
fn called(placement: &Placement) -> String {
    match placement.face {
        Some(face) if face.name() != placement.label => {
            format!("{} ({})", placement.label, face.name())
        }
        _ => placement.label.clone(),
    }
}

/// M to start with when names say how the board sits: each column from its two
/// faces, the nominal scale where one is missing.
fn start_by_names(poses: &[JointPose], nominal: Option<f64>, gravity: f64) -> [[f64; 3]; 3] {
    let mean = |face: Face| {
        let some: Vec<[f64; 3]> = poses
            .iter()
            .filter(|p| matches!(p.role, Role::Named(f) | Role::Face(f) if f == face))
            .map(|p| p.mean)
            .collect();
        (!some.is_empty()).then(|| {
            let sum = some
                .iter()
                .fold([0.0; 3], |s, m| std::array::from_fn(|i| s[i] + m[i]));
            sum.map(|s| s / some.len() as f64)
        })
    };
    let mut model = matrix3::diagonal([nominal.unwrap_or(1.0); 3]);
    for axis in 0..3 {
        let sides = [true, false].map(|up| mean(Face { axis, up }));
        if let [Some(up), Some(down)] = sides {
            for row in 0..3 {
                model[row][axis] = (up[row] - down[row]) / (2.0 * gravity);
            }
        }
    }
    model
}

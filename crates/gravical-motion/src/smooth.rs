//! The smoother, backwards.
//!
//! Bryson and Frazier's form (Bierman 1973, doi 10.1016/0005-1098(73)90006-5): the adjoint λ and its
//! information Λ go back through the records of the filter, and at a node with covariance P the smoothed
//! error is P λ with covariance P − P Λ P. Unlike the form of Rauch, Tung and Striebel it inverts no P,
//! and only nodes that are wanted cost more than a product with F.

use nalgebra::{Matrix3, SMatrix, Vector3};

use crate::filter::{Node, Record, Update};
use crate::result::{Budget, CLOCK_SD, Move, PathNode, deviation};
use crate::state::{
    ACTING, Covariance, Derivatives, EARLIER_VELOCITY, ErrorState, GRAVITY, MOVING, POSITION,
    STATES, VELOCITY,
};
use crate::transition::Transition;

/// Gravity and the parameters of the calibration.
const CONSTANTS: usize = ACTING - GRAVITY;

type Position = SMatrix<f64, 3, STATES>;

/// A move whose end was passed.
struct OpenMove {
    /// Position at the end, and its covariance to the state there.
    end: (Vector3<f64>, Position),
    /// How an error of the state here acts on the position at the end.
    sensitivity: SMatrix<f64, STATES, 3>,
    /// Variance of it by the noise of the gyroscope.
    by_rate: Matrix3<f64>,
}

/// Where the smoother is.
pub(crate) struct Smoother {
    adjoint: ErrorState,
    information: Covariance,
    open: Option<OpenMove>,
    /// Standard deviation of gravity before the first rest, m/s².
    gravity_sd: f64,
}

impl Smoother {
    /// At the end of the recording, where nothing follows.
    pub fn new(gravity_sd: f64) -> Smoother {
        Smoother {
            adjoint: ErrorState::zeros(),
            information: Covariance::zeros(),
            open: None,
            gravity_sd,
        }
    }

    /// Goes back through records; nodes are added to `path`, the last first. They hold at most one move.
    pub fn back(
        &mut self,
        records: &[Record],
        path: &mut Vec<PathNode>,
        mut one: Option<&mut Move>,
    ) {
        for record in records.iter().rev() {
            match record {
                Record::Node(node) => path.push(self.smoothed(node)),
                Record::Propagate(transition) => self.propagate(transition),
                Record::ZeroVelocity => {
                    self.adjoint.fixed_rows_mut::<3>(VELOCITY).fill(0.0);
                    self.information.fixed_rows_mut::<3>(VELOCITY).fill(0.0);
                    self.information.fixed_columns_mut::<3>(VELOCITY).fill(0.0);
                }
                Record::CloneVelocity => self.clone_velocity(),
                Record::Update(update) => self.update(update),
                Record::EndMove(position, covariance) => self.end_move(position, covariance),
                Record::StartMove(position, covariance) => {
                    if let Some(one) = one.take() {
                        self.start_move(position, covariance, one);
                    }
                }
            }
        }
    }

    fn smoothed(&self, node: &Node) -> PathNode {
        let error = node.rows * self.adjoint;
        let covariance = node.rows.fixed_columns::<MOVING>(0)
            - node.rows * self.information * node.rows.transpose();
        PathNode::new(node, &error, &covariance)
    }

    fn propagate(&mut self, transition: &Transition) {
        let f = &transition.f;
        if let Some(open) = &mut self.open {
            let moving = open.sensitivity.fixed_rows::<MOVING>(0).into_owned();
            open.by_rate += moving.transpose() * transition.q_rate * moving;
            open.sensitivity = transposed_times(f, &open.sensitivity);
        }
        self.adjoint = transposed_times(f, &self.adjoint);
        let half = transposed_times(f, &self.information);
        self.information = transposed_times(f, &half.transpose());
    }

    fn clone_velocity(&mut self) {
        if let Some(open) = &mut self.open {
            add_earlier(&mut open.sensitivity);
        }
        add_earlier(&mut self.adjoint);
        add_earlier(&mut self.information);
        self.information.transpose_mut();
        add_earlier(&mut self.information);
    }

    fn update(&mut self, update: &Update) {
        let (h, gain, information) = (&update.h, &update.gain, &update.information);
        if let Some(open) = &mut self.open {
            let back = gain.transpose() * open.sensitivity;
            open.sensitivity -= h.transpose() * back;
        }
        let back = information * update.innovation - gain.transpose() * self.adjoint;
        self.adjoint += h.transpose() * back;
        // (I − KH)ᵀ Λ (I − KH) + Hᵀ S⁻¹ H, multiplied out.
        let gained = gain.transpose() * self.information;
        let one = h.transpose() * gained;
        let middle = information + gained * gain;
        let next = self.information - one - one.transpose() + h.transpose() * middle * h;
        self.information = (next + next.transpose()) * 0.5;
    }

    fn end_move(&mut self, position: &Vector3<f64>, covariance: &Covariance) {
        let p: Position = covariance.fixed_rows::<3>(POSITION).into_owned();
        let mut sensitivity = -(self.information * p.transpose());
        let mut by_position = sensitivity.fixed_view_mut::<3, 3>(POSITION, 0);
        by_position += Matrix3::identity();
        self.open = Some(OpenMove {
            end: self.position(position, covariance),
            sensitivity,
            by_rate: Matrix3::zeros(),
        });
    }

    fn start_move(&mut self, position: &Vector3<f64>, covariance: &Covariance, one: &mut Move) {
        let Some(open) = self.open.take() else { return };
        let (start, at_start) = self.position(position, covariance);
        let (end, at_end) = open.end;
        let p: Position = covariance.fixed_rows::<3>(POSITION).into_owned();
        let block = |rows: &Position| rows.fixed_columns::<3>(POSITION).into_owned();
        let cross = p * open.sensitivity;
        let displacement = end - start;
        let mut total = block(&at_end) + block(&at_start) - cross - cross.transpose();
        for c in 0..3 {
            total[(c, c)] += (2.0 * CLOCK_SD * displacement[c]).powi(2);
        }
        // An error of a constant, one standard deviation σ before the recording, acts on the estimate by
        // its covariance after it over σ.
        let mut constants = (at_end - at_start)
            .fixed_columns::<CONSTANTS>(GRAVITY)
            .into_owned();
        let mut gravity = constants.column_mut(0);
        gravity /= self.gravity_sd.max(f64::MIN_POSITIVE);
        let along = displacement.try_normalize(0.0).unwrap_or_default();
        one.displacement_m = displacement.into();
        one.along_sd_m = deviation((along.transpose() * total * along)[0]);
        one.sd_m = total.diagonal().map(deviation).into();
        one.budget = Budget::new([total, constants * constants.transpose(), open.by_rate]);
    }

    /// Smoothed position and its covariance to the whole smoothed state.
    fn position(&self, at: &Vector3<f64>, covariance: &Covariance) -> (Vector3<f64>, Position) {
        let p: Position = covariance.fixed_rows::<3>(POSITION).into_owned();
        (at + p * self.adjoint, p - p * self.information * covariance)
    }
}

/// Fᵀ x where only the first nine rows of F are not those of the identity.
fn transposed_times<const C: usize>(
    f: &Derivatives,
    x: &SMatrix<f64, STATES, C>,
) -> SMatrix<f64, STATES, C> {
    let mut out = *x;
    out.fixed_rows_mut::<MOVING>(0).fill(0.0);
    let mut acting = out.fixed_rows_mut::<ACTING>(0);
    acting += f.transpose() * x.fixed_rows::<MOVING>(0);
    out
}

/// Aᵀ x where A replaces the earlier velocity by the velocity.
fn add_earlier<const C: usize>(x: &mut SMatrix<f64, STATES, C>) {
    let earlier = x.fixed_rows::<3>(EARLIER_VELOCITY).into_owned();
    let mut velocity = x.fixed_rows_mut::<3>(VELOCITY);
    velocity += earlier;
    x.fixed_rows_mut::<3>(EARLIER_VELOCITY).fill(0.0);
}

//! The motion as samples come.
//!
//! A rest that has lasted for a second closes the move before it: the filter goes through the move again
//! with what is then known of it, as the whole run does.

use std::ops::Range;

use gravical_signal::{RestDetector, RestEvent};
use nalgebra::Vector3;

use crate::chain::contradicts;
use crate::filter::{Filter, Record, Recorder};
use crate::moves::{Leg, close, closing, level_before_move, rectified, take_displacement};
use crate::noise::{Noise, Roughness};
use crate::options::MotionOptions;
use crate::result::{Motion, PathNode, array, ends};
use crate::samples::Samples;
use crate::stance::{Stance, StanceDetector, steps};
use crate::states::SampleState;
use crate::transition::Model;

/// The noise is that of the first seconds of the first rest, s.
const LEARNED_S: f64 = 3.0;
/// A rest that the velocity contradicts is believed after so long, s: what is wrong then is the velocity. That
/// it ended after 3 s may take two more to see.
const BELIEVED_S: f64 = 4.0;
/// The move has the roughness of its last seconds, s.
const RECENT_S: f64 = 2.0;
/// Nodes, s: what turns less than a swing within it.
const NODE_S: f64 = 0.04;

/// The motion of samples as they come: after each the state by what is past.
///
/// Numbers are those of a causal run ([`MotionOptions::causal`]), which is this, sample by sample. A rest is
/// one after a second, the first one after three; until then, and before the first rest, the state is that of
/// the move, or not known. Each sample takes 60 bytes. A rest costs as much as the move before it, and so does
/// each that is withdrawn; the other work is bounded for each sample on average.
///
/// # Example
///
/// ```
/// use gravical_motion::{MotionOptions, Stepper};
///
/// // 100 Hz, written in steps of 0.01 m/s², without a gyroscope, on a table.
/// let mut stepper = Stepper::new(&MotionOptions::default(), 0.01, [0.01, 0.01, 0.01, 0.0, 0.0, 0.0]);
/// let dither = |i: usize| [0.0, 0.01, 0.02, 0.01, 0.0, -0.01, 0.01][i % 7];
/// let mut push = |i: usize| stepper.push(i as f64 * 0.01, [dither(i), dither(i + 3), 9.81 + dither(i + 1)], None);
/// assert!((0..100).filter_map(&mut push).all(|state| state.position_m[0].is_nan()));
/// let state = (100..400).filter_map(push).last();
/// assert!(state.is_some_and(|s| s.at_rest && s.velocity_mps == [0.0; 3]));
/// ```
#[derive(Debug, Clone)]
pub struct Stepper {
    context: Context,
    /// True if something is missing before the next sample.
    interrupted: bool,
    source: RestDetector,
    /// Where a span begins that may be a rest.
    candidate: Option<usize>,
    stances: Option<StanceDetector>,
    /// Those of this move.
    stances_here: Vec<Stance>,
    progress: Progress,
    /// Before the last rest began, while that may be withdrawn.
    undo: Option<Box<Progress>>,
    /// What a whole run is to have.
    motion: Option<Motion>,
}

/// What the filter knows besides its state.
#[derive(Debug, Clone)]
struct Context {
    samples: Samples,
    options: MotionOptions,
    /// Once there was a rest.
    noise: Option<Noise>,
}

impl Context {
    fn model(&self) -> Option<Model<'_>> {
        Some(Model {
            samples: &self.samples,
            options: &self.options,
            noise: self.noise.as_ref()?,
        })
    }
}

/// What a rest changes.
#[derive(Debug, Clone)]
struct Progress {
    /// Where the last rest begins or was left.
    filter: Option<Filter>,
    phase: Phase,
    /// The last step of the last walk.
    last_step: Option<usize>,
}

#[derive(Debug, Clone)]
enum Phase {
    /// Before the first rest.
    Unknown,
    /// From the first second on, which ends before sample `closed`.
    Rest {
        closed: usize,
        /// The rest and the move before it.
        found: Box<Motion>,
    },
    Move(Box<Live>),
}

/// A move that goes on.
#[derive(Debug, Clone)]
struct Live {
    /// Up to what is known for good: the last stance, or where a rest was looked for.
    trail: Track,
    /// Up to the last whole node.
    ahead: Track,
}

/// A filter that goes on through a move.
#[derive(Debug, Clone)]
struct Track {
    filter: Filter,
    /// First sample of the move.
    start: usize,
    /// Σ ω² and the number of samples in it, and by how much it has widened the bias.
    squares: f64,
    count: usize,
    inflated: f64,
}

impl Track {
    fn new(mut filter: Filter) -> Track {
        filter.start_move(&mut Recorder::off());
        Track {
            start: filter.at,
            filter,
            squares: 0.0,
            count: 0,
            inflated: 0.0,
        }
    }

    /// Goes on to a sample, from node to node.
    fn advance(&mut self, model: &Model<'_>, to: usize) {
        let node = node_len(model.samples);
        let recent = model.samples.count_in(RECENT_S);
        while self.filter.at < to {
            let span = self.filter.at..to.min(self.filter.at + node);
            let mean_square = self.filter.mean_square_rate(model, span.clone());
            self.squares += mean_square * span.len() as f64;
            self.count += span.len();
            let rate_sd = model.options.calibration.rate_sd();
            let variance = rectified(self.squares / self.count as f64, rate_sd);
            if variance > self.inflated {
                self.filter.inflate_rate_bias(variance - self.inflated);
                self.inflated = variance;
            }
            let since = self.start.max(span.end.saturating_sub(recent));
            let excess = model.noise.excess(since, span.end);
            let off = &mut Recorder::off();
            self.filter.propagate(model, span.end, node, &excess, off);
        }
    }
}

impl Stepper {
    /// Before the first sample. Samples come every `period_s` and are written in steps of `resolution`, m/s²
    /// and rad/s, 0 where they are unknown. If an option is negative or no number, no sample is taken.
    #[must_use]
    pub fn new(options: &MotionOptions, period_s: f64, resolution: [f64; 6]) -> Stepper {
        Stepper {
            source: RestDetector::new(period_s, resolution),
            context: Context {
                samples: Samples::empty(period_s, resolution),
                options: options.clone(),
                noise: None,
            },
            interrupted: false,
            candidate: None,
            stances: None,
            stances_here: Vec::new(),
            progress: Progress {
                filter: None,
                phase: Phase::Unknown,
                last_step: None,
            },
            undo: None,
            motion: None,
        }
    }

    /// Takes a sample: time, s, specific force, m/s², and angular rate, rad/s. With or without a gyroscope,
    /// all samples are like the first.
    ///
    /// The state is that at the sample, NaN before the first rest was found. Returns `None` for a sample that is
    /// no measurement, which changes nothing: values that are not finite or beyond any sensor, and a time that is
    /// not later.
    pub fn push(
        &mut self,
        time_s: f64,
        force: [f64; 3],
        rate: Option<[f64; 3]>,
    ) -> Option<SampleState> {
        if !self.context.options.are_possible() || !self.add(time_s, force, rate) {
            return None;
        }
        self.update();
        Some(self.state_here().unwrap_or(SampleState::UNKNOWN))
    }

    /// Something is missing before the next sample, whatever its time says.
    pub fn interrupt(&mut self) {
        self.interrupted = true;
    }

    /// A causal run of whole samples.
    pub(crate) fn drive(samples: &Samples, options: &MotionOptions) -> Motion {
        let mut stepper = Stepper::new(options, samples.period_s, samples.channels().resolution);
        stepper.motion = Some(Motion::default());
        stepper.context.samples.bridged.clone_from(&samples.bridged);
        for i in 0..samples.len() {
            if options.is_stopped() {
                break;
            }
            stepper.interrupted = samples.breaks.binary_search(&i).is_ok();
            let rate = samples.rate.get(i).copied();
            stepper.add(samples.time_s[i], samples.force[i], rate);
            stepper.update();
        }
        stepper.finish()
    }

    /// True if it is a sample.
    fn add(&mut self, time_s: f64, force: [f64; 3], rate: Option<[f64; 3]>) -> bool {
        let samples = &mut self.context.samples;
        let added = samples.push(time_s, force, rate, self.interrupted);
        if added {
            self.interrupted = false;
        }
        added
    }

    fn update(&mut self) {
        while let Some(event) = self.source.update(&self.context.samples.channels()) {
            self.take(event);
        }
        self.believe(self.context.samples.len(), false);
        self.go_on();
    }

    fn take(&mut self, event: RestEvent) {
        let count = self.context.samples.len();
        match event {
            RestEvent::Begin(start) => {
                let rest = start.min(count - 1)..count;
                self.candidate = Some(rest.start);
                if self.context.noise.is_some() && self.agrees(&rest) {
                    self.candidate = None;
                    self.begin_rest(rest);
                }
            }
            RestEvent::Withdraw => self.withdraw(),
            RestEvent::End(end) => {
                self.believe(end, true);
                self.candidate = None;
                self.end_rest(end);
            }
        }
    }

    /// Takes a candidate for a rest, the first one or one that the velocity contradicts, if it has lasted long
    /// enough before sample `end`; it may be over.
    fn believe(&mut self, end: usize, over: bool) {
        let least_s = match self.context.noise {
            None if over => 0.0,
            None => LEARNED_S,
            Some(_) => BELIEVED_S,
        };
        let samples = &self.context.samples;
        let lasts =
            |start: &mut usize| *start < end && samples.duration_s(&(*start..end)) >= least_s;
        if let Some(start) = self.candidate.take_if(lasts) {
            self.begin_rest(start..end);
        }
    }

    /// What began is no rest.
    fn withdraw(&mut self) {
        let undo = self.undo.take();
        if self.candidate.take().is_some() {
            return;
        }
        let Some(undo) = undo else { return };
        self.progress = *undo;
        if matches!(self.progress.phase, Phase::Unknown) {
            // Another rest will be the first.
            (self.context.noise, self.stances) = (None, None);
            self.stances_here.clear();
        }
    }

    /// True if the velocity does not contradict that a rest begins.
    fn agrees(&mut self, rest: &Range<usize>) -> bool {
        let (Phase::Move(live), Some(model)) = (&mut self.progress.phase, self.context.model())
        else {
            return true;
        };
        live.trail.advance(&model, rest.start);
        !contradicts(&model, &live.trail.filter, &closing(&model, rest))
    }

    /// The noise of the first rest, and what it says of the samples before it.
    fn learn(&mut self, rest: &Range<usize>) {
        let samples = &self.context.samples;
        let learned = rest.start..rest.end.min(samples.after_s(rest.start, LEARNED_S));
        let given = self.context.options.noise.as_ref();
        let mut noise = Noise::new(samples, &[learned], given, Roughness::default());
        let quiet = rest.start..samples.len();
        noise.rough.extend(samples, std::slice::from_ref(&quiet));
        self.context.noise = Some(noise);
        let max_rate_rad_s = self.context.options.max_stance_rate_rad_s;
        self.stances = Some(StanceDetector::new(samples, rest, max_rate_rad_s));
        self.find_stances();
    }

    /// Adds the stances that came; true if there is one.
    fn find_stances(&mut self) -> bool {
        let detector = self.stances.as_mut();
        let found = detector.map_or_else(Vec::new, |d| d.update(&self.context.samples));
        self.stances_here.extend_from_slice(&found);
        !found.is_empty()
    }

    /// Those of a walk from sample `from` to `end`.
    fn steps(&self, from: usize, end: usize) -> &[Stance] {
        let size = self.stances.as_ref().map_or(0, |s| s.size);
        let last_step = self.progress.last_step;
        steps(&self.stances_here, size, (from, end), last_step)
    }

    fn begin_rest(&mut self, rest: Range<usize>) {
        let is_first = self.context.noise.is_none();
        if is_first {
            self.learn(&rest);
        }
        let Some(model) = self.context.model() else {
            return;
        };
        let filter = self.progress.filter.clone();
        let mut filter = filter.unwrap_or_else(|| Filter::new(&model, 0, &rest));
        let mut last_step = self.progress.last_step;
        let mut recorder = Recorder {
            is_on: self.motion.is_some(),
            ..Recorder::default()
        };
        let first_second = closing(&model, &rest);
        let mut found = Box::new(Motion::default());
        if rest.start > filter.at {
            let steps = self.steps(if is_first { 0 } else { filter.at + 1 }, rest.start);
            found.stances = steps.iter().map(|s| s.sample).collect();
            last_step = steps.last().map(|s| s.swing).or(last_step);
            let leg = Leg {
                end: rest.start,
                ends: ends(!is_first, true),
                rest: (!is_first).then(|| first_second.clone()),
                stances: &found.stances,
            };
            let (_, one) = leg.run(&model, &mut filter, &mut recorder);
            found.moves.push(one);
        }
        let at = filter.at;
        let closed = first_second.end.max(at + 1);
        close(&model, &mut filter, &(at..closed), &mut recorder);
        for one in &mut found.moves {
            take_displacement(&filter, one);
        }
        filter.halt(&model, at, &mut recorder);
        found.rests.push(rest);
        found.path.extend(nodes(&recorder));
        let progress = Progress {
            filter: Some(filter),
            phase: Phase::Rest { closed, found },
            last_step,
        };
        let before = std::mem::replace(&mut self.progress, progress);
        self.undo = Some(Box::new(before));
    }

    fn end_rest(&mut self, end: usize) {
        self.undo = None;
        let (
            Progress {
                filter: Some(filter),
                phase: Phase::Rest { closed, found },
                ..
            },
            Some(model),
        ) = (&mut self.progress, self.context.model())
        else {
            return;
        };
        let (end, off) = (end.max(filter.at + 1), &mut Recorder::off());
        filter.halt(&model, end - 1, off);
        found.path.push(PathNode::forward(&filter.node()));
        level_before_move(&model, filter, end.min(*closed), off);
        let trail = Track::new(filter.clone());
        if let Some(motion) = &mut self.motion {
            motion.append(found, end);
        }
        if let Some(noise) = &mut self.context.noise {
            noise.rough.restart(filter.at);
        }
        self.progress.phase = Phase::Move(Box::new(Live {
            ahead: trail.clone(),
            trail,
        }));
        self.stances_here.retain(|s| s.sample >= end);
    }

    /// Goes on with a move to the last whole node.
    fn go_on(&mut self) {
        let found = self.find_stances();
        let last = self.context.samples.len() - 1;
        let Phase::Move(live) = &self.progress.phase else {
            return;
        };
        if let Some(noise) = &mut self.context.noise {
            noise.rough.extend(&self.context.samples, &[]);
        }
        let mut stances = Vec::new();
        if found {
            let end = self.candidate.unwrap_or(usize::MAX);
            let steps = self.steps(live.trail.start + 1, end).iter();
            stances.extend(
                steps
                    .map(|s| s.sample)
                    .filter(|i| *i > live.trail.filter.at),
            );
        }
        let (Phase::Move(live), Some(model)) = (&mut self.progress.phase, self.context.model())
        else {
            return;
        };
        for stance in &stances {
            live.trail.advance(&model, *stance);
            live.trail.filter.stance(&mut Recorder::off());
        }
        if !stances.is_empty() {
            live.ahead = live.trail.clone();
        }
        let (at, node) = (live.ahead.filter.at, node_len(&self.context.samples));
        let to = at + (last - at) / node * node;
        live.ahead.advance(&model, to);
    }

    /// The filter of a move at the last sample.
    fn filter_here(&self, live: &Live) -> Option<Filter> {
        let mut track = live.ahead.clone();
        let last = self.context.samples.len() - 1;
        track.advance(&self.context.model()?, last);
        Some(track.filter)
    }

    /// The state at the last sample.
    fn state_here(&self) -> Option<SampleState> {
        let filter = match &self.progress.phase {
            Phase::Move(live) => self.filter_here(live)?,
            Phase::Unknown | Phase::Rest { .. } => self.progress.filter.clone()?,
        };
        let correction = filter.nominal.correction(&self.context.options.calibration);
        let force = correction.force(self.context.samples.force.last()?);
        let gravity = Vector3::new(0.0, 0.0, filter.nominal.gravity);
        let node = PathNode::forward(&filter.node()).with_clock();
        Some(SampleState {
            at_rest: matches!(self.progress.phase, Phase::Rest { .. }),
            attitude: node.attitude,
            acceleration_mps2: array(&(filter.nominal.attitude * force - gravity)),
            velocity_mps: node.velocity_mps,
            velocity_sd_mps: node.velocity_sd_mps,
            position_m: node.position_m,
            position_sd_m: node.position_sd_m,
        })
    }

    /// The motion where no sample follows.
    fn finish(mut self) -> Motion {
        if self.context.samples.is_empty() {
            return Motion::default();
        }
        while let Some(event) = self.source.finish(&self.context.samples.channels()) {
            self.take(event);
        }
        self.believe(self.context.samples.len(), true);
        self.go_on();
        let last = self.context.samples.len() - 1;
        let mut motion = self.motion.take().unwrap_or_default();
        let (filter, steps) = match &self.progress.phase {
            Phase::Unknown => (None, &[][..]),
            Phase::Rest { .. } => (self.progress.filter.clone(), &[][..]),
            Phase::Move(live) => {
                let steps = self.steps(live.trail.start + 1, usize::MAX);
                (self.filter_here(live), steps)
            }
        };
        let stances: Vec<usize> = steps.iter().map(|s| s.sample).collect();
        let (Some(mut filter), Some(model)) = (filter, self.context.model()) else {
            return motion;
        };
        match (&mut self.progress.phase, &mut self.progress.filter) {
            (Phase::Rest { found, .. }, _) => {
                filter.halt(&model, last, &mut Recorder::off());
                motion.append(found, last + 1);
            }
            (Phase::Move(live), Some(from)) if live.trail.start < last => {
                let leg = Leg {
                    end: last,
                    ends: ends(true, false),
                    rest: None,
                    stances: &stances,
                };
                let mut recorder = Recorder::on();
                let (_, mut one) = leg.run(&model, from, &mut recorder);
                take_displacement(&filter, &mut one);
                motion.moves.push(one);
                motion.stances.extend(stances);
                motion.path.extend(nodes(&recorder));
            }
            _ => {}
        }
        motion.path.push(PathNode::forward(&filter.node()));
        motion.path = motion.path.into_iter().map(PathNode::with_clock).collect();
        motion.noise = Some(model.noise.of_rests());
        motion
    }
}

/// The nodes of a pass as the filter knew them.
fn nodes(recorder: &Recorder) -> impl Iterator<Item = PathNode> {
    recorder.records.iter().filter_map(|record| match record {
        Record::Node(node) => Some(PathNode::forward(node)),
        _ => None,
    })
}

fn node_len(samples: &Samples) -> usize {
    samples.count_in(NODE_S).max(1)
}

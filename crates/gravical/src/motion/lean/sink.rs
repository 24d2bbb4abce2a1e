//! The rows of a recording as they come: what is judged of them, filtered, made
//! samples of, and integrated.

use std::rc::Rc;

use gravical_core::calibration::Calibration;

use super::way::Way;
use crate::apply::stream::{Row, Sink};
use crate::calibration_file::TemperatureModel;
use crate::denoise::Running;
use crate::recording::quality::Empty;
use crate::recording::row::{ACCEL, GYRO, TEMPERATURE, TIME};
use crate::recording::timing::{Clock, Follower, Parting, Steps};
use crate::recording::{Aside, LineSpans, POSSIBLE_C, QuietBlocks};
use crate::segment::face::AxisMap;

/// Where the time of a row comes from.
#[derive(Clone)]
pub(super) enum Time {
    /// Its stamp.
    Stamps {
        follower: Box<Follower>,
        steps: Steps,
    },
    /// Its number; the rate, Hz.
    Rows { rate_hz: f64 },
}

/// From the file's numbers to m/s².
#[derive(Clone)]
pub(super) struct Scale {
    pub accel: Calibration<f64>,
    /// By the nominal scale alone.
    pub nominal: Calibration<f64>,
    /// Subtracted from the file's numbers for whoever judges the unit.
    pub offset: f64,
    pub axes: AxisMap,
    /// Drift with temperature, and the temperature known last, °C.
    pub drift: Option<(Rc<TemperatureModel>, f64)>,
}

/// How far apart samples may be.
#[derive(Clone, Copy)]
pub(super) struct Gap {
    /// A longer step is a gap, s.
    pub longest_s: f64,
    /// What a step has to be away from that, s: so little is known of it.
    pub margin_s: f64,
}

/// What goes on from row to row.
#[derive(Clone)]
pub(super) struct State {
    pub time: Time,
    pub running: Running,
    pub quiet: QuietBlocks,
    pub empty: Empty,
    pub temperature_span_c: [f64; 2],
    /// Something came that asks for the recording as a whole.
    pub beyond: bool,
    pub way: Way,
    pub left_out: LineSpans,
    rows: u64,
    /// A break before the next sample.
    parted: bool,
    /// Time of the last sample, s.
    last_s: f64,
}

/// All of it as a sink.
pub(super) struct Pass {
    pub state: State,
    marked: Option<Box<State>>,
    scale: Scale,
    gap: Gap,
    with_gyro: bool,
    with_temperature: bool,
}

impl Pass {
    pub fn new(
        (time, running, way): (Time, Running, Way),
        scale: Scale,
        gap: Gap,
        [with_gyro, with_temperature]: [bool; 2],
    ) -> Self {
        Pass {
            state: State {
                time,
                running,
                quiet: QuietBlocks::default(),
                empty: Empty::default(),
                temperature_span_c: [f64::INFINITY, f64::NEG_INFINITY],
                beyond: false,
                way,
                left_out: LineSpans::default(),
                rows: 0,
                parted: false,
                last_s: f64::NEG_INFINITY,
            },
            marked: None,
            scale,
            gap,
            with_gyro,
            with_temperature,
        }
    }

    /// Usual step of the raw stamps; none without them.
    pub fn usual_step(&self) -> Option<f64> {
        match &self.state.time {
            Time::Stamps { follower, .. } => Some(follower.usual_step()),
            Time::Rows { .. } => None,
        }
    }

    /// The rows that still wait, after the last.
    pub fn finish(&mut self) {
        self.integrate(true);
        self.state.way.begin();
    }

    /// Rows whose filter is through become samples.
    #[inline(never)]
    fn integrate(&mut self, last: bool) {
        let State {
            running,
            way,
            left_out,
            parted,
            last_s,
            beyond,
            ..
        } = &mut self.state;
        let (rows, [x, y, z], new) = running.go(last);
        let mut breaks = rows.breaks.iter().copied().peekable();
        while breaks.next_if(|b| *b < new.start).is_some() {}
        let drift = &mut self.scale.drift;
        let offset = self.scale.offset;
        for row in new {
            while breaks.next_if(|b| *b <= row).is_some() {
                *parted = true;
            }
            let raw = [x[row] + offset, y[row] + offset, z[row] + offset];
            let t = rows.t_s[row];
            let steady = match drift {
                None => raw,
                Some((model, now)) => {
                    let t_c = rows.temperature_c[row];
                    if t_c.is_finite() {
                        *now = t_c;
                    }
                    let at = |i: usize| crate::check::at_reference(model, i, *now, raw[i]);
                    std::array::from_fn(at)
                }
            };
            let force = self.scale.accel.apply(steady);
            let step = t - *last_s;
            // Also false where something is missing.
            if !(step >= 0.0 && (force[0] + force[1] + force[2]).is_finite()) {
                left_out.push(rows.line[row]);
                continue;
            }
            let gap = step > self.gap.longest_s && way.samples > 0;
            *beyond |= (step - self.gap.longest_s).abs() < self.gap.margin_s;
            let is_parted = (*parted || gap) && way.samples > 0;
            (*parted, *last_s) = (false, t);
            let axes = &self.scale.axes;
            let nominal = axes.to_case(self.scale.nominal.apply(raw));
            way.see(t, &axes.to_case(force), &nominal, is_parted);
        }
        running.settle();
        *beyond |= running.is_stuck();
    }

    #[cold]
    fn note_empty(empty: &mut Empty, row: &Row<'_>, with_gyro: bool) {
        let values = row.values;
        let missing = |slot: usize| usize::from(values[slot].is_nan());
        for i in 0..3 {
            empty.accel[i] += missing(ACCEL + i);
            empty.gyro[i] += if with_gyro { missing(GYRO + i) } else { 0 };
        }
        empty.incomplete += usize::from((0..3).any(|i| values[ACCEL + i].is_nan()));
    }
}

impl Sink for Pass {
    const SPANS: bool = false;

    fn header(&self) -> Vec<u8> {
        Vec::new()
    }

    #[inline]
    fn row(&mut self, row: &Row<'_>, _: &mut Vec<u8>) {
        let state = &mut self.state;
        let values = row.values;
        let t_s = match &mut state.time {
            Time::Stamps { follower, steps } => {
                let stamp = values[TIME];
                let (clock, t_s) = follower.see(stamp, || row.number);
                state.beyond |= matches!(clock, Clock::Restarted | Clock::Absent);
                steps.see(stamp, clock, t_s);
                t_s
            }
            Time::Rows { rate_hz } => state.rows as f64 / *rate_hz,
        };
        state.rows += 1;
        // Rows of zeros are judged with their neighbours.
        state.beyond |= values[ACCEL..ACCEL + 3] == [0.0; 3];
        let offset = self.scale.offset;
        let accel = [
            values[ACCEL] - offset,
            values[ACCEL + 1] - offset,
            values[ACCEL + 2] - offset,
        ];
        let mut sum = accel[0] + accel[1] + accel[2];
        if self.with_gyro {
            sum += values[GYRO] + values[GYRO + 1] + values[GYRO + 2];
        }
        if sum.is_nan() {
            Self::note_empty(&mut state.empty, row, self.with_gyro);
        }
        let t_c = values[TEMPERATURE];
        if self.with_temperature {
            if t_c.is_nan() {
                state.empty.temperature += 1;
            } else {
                state.beyond |= !POSSIBLE_C.contains(&t_c);
                let [low, high] = state.temperature_span_c;
                state.temperature_span_c = [low.min(t_c), high.max(t_c)];
            }
        }
        state.quiet.push(accel);
        state.running.push(t_s, accel, t_c, row.number);
        if state.running.is_full() {
            // Nothing more will come of it.
            if state.beyond {
                state.running.forget_all();
            } else {
                self.integrate(false);
            }
        }
    }

    fn part(&mut self, reason: Aside, _: &mut Vec<u8>) {
        if let (Some(how), Time::Stamps { follower, .. }) =
            (Parting::by(reason), &mut self.state.time)
        {
            follower.part(how);
        }
        if self.state.rows > 0 {
            self.state.running.part();
        }
    }

    fn mark(&mut self) {
        self.marked = Some(Box::new(self.state.clone()));
    }

    fn rewind(&mut self) {
        if let Some(marked) = self.marked.take() {
            self.state = *marked;
        }
    }

    fn keep(&mut self) {
        self.marked = None;
    }
}

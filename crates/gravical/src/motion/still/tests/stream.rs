//! The detector of the microcontroller against the runs forwards of the batch.

use gravical_core::still::{Detector, Event, Learner, RestNoise};

use super::*;

/// Seed and end of every rest that the detector saw.
fn stream<const N: usize>(
    samples: &Samples,
    plan: Plan,
    noise: RestNoise<f64>,
) -> Vec<(usize, Option<usize>)> {
    let mut detector: Detector<f64, N> = Detector::new(plan, noise).unwrap();
    let mut out: Vec<(usize, Option<usize>)> = Vec::new();
    for i in 0..samples.len() {
        match detector.update(samples.force_at(i), Some(samples.rate_at(i))) {
            Some(Event::Began { since }) => out.push((since, None)),
            Some(Event::Ended { .. }) => out.last_mut().unwrap().1 = Some(i),
            None => {}
        }
    }
    out
}

#[test]
fn both_raise_the_alarm_at_the_same_samples() {
    let (mut alarms, mut onsets) = (0, Vec::new());
    for seed in 0..40 {
        let simulation = line(seed, if seed % 2 == 0 { 2.0 } else { 4.0 }, |_| {});
        let samples = samples_of(&simulation);
        let plan = plan(&samples).unwrap();
        let noise = RestNoise::new([0.035; 3], 1.2, Some(([9.3e-4; 3], 1.2)));
        let whole = 0..samples.len();
        let levels = levels::Levels {
            left: [0.0; 6],
            rests: vec![levels::Coarse {
                span: whole.clone(),
                noise,
                held: false,
            }],
            wander: 1.0,
        };
        let view = view::View::new(&samples, &whole, false);
        let batch = run::runs(&view, &plan, &levels);
        let expected: Vec<_> = batch.iter().map(|r| (r.seed, r.alarm)).collect();
        assert_eq!(
            stream::<128>(&samples, plan, noise),
            expected,
            "seed {seed}"
        );
        alarms += expected.iter().filter(|e| e.1.is_some()).count();

        let mut detector: Detector<f64, 101> = Detector::new(plan, noise).unwrap();
        let mut first = None;
        for i in 0..samples.len() {
            let event = detector.update(samples.force_at(i), Some(samples.rate_at(i)));
            if let (None, Some(Event::Ended { onset })) = (first, event) {
                first = Some(onset);
            }
        }
        // It looks back over 1 s where the batch looks over 3.
        onsets.push(first.unwrap().abs_diff(batch[0].end));
    }
    assert!(alarms >= 40, "{alarms}");
    onsets.sort_unstable();
    assert!(onsets[30] == 0 && onsets[39] < 15, "{onsets:?}");
}

#[test]
fn in_single_precision_it_sees_the_same_moves() {
    for seed in 0..40 {
        let samples = samples_of(&line(seed, 2.0, |_| {}));
        let plan = plan(&samples).unwrap();
        let mut learner = Learner::<f32>::new(plan, true);
        let single = |v: [f64; 3]| v.map(|v| v as f32);
        for i in 0..400 {
            learner.update(
                single(samples.force_at(i)),
                Some(single(samples.rate_at(i))),
            );
        }
        let noise = learner.noise().unwrap();
        let mut detector: Detector<f32, 101> = Detector::new(plan, noise).unwrap();
        let (mut began, mut ended) = (Vec::new(), Vec::new());
        for i in 0..samples.len() {
            match detector.update(
                single(samples.force_at(i)),
                Some(single(samples.rate_at(i))),
            ) {
                Some(Event::Began { since }) => began.push(since),
                Some(Event::Ended { onset }) => ended.push(onset),
                None => {}
            }
        }
        assert_eq!(began[0], 0);
        assert!((480..=502).contains(&ended[0]), "seed {seed}: {ended:?}");
        assert!(
            (670..=730).contains(began.last().unwrap()),
            "seed {seed}: {began:?}"
        );
        assert!(detector.is_still());
    }
}

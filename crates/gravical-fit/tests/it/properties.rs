//! What must not matter to the fit, and what must not break it.

use gravical_fit::{Hint, Options, Pose, fit};
use proptest::prelude::*;

use crate::sessions::G;

fn options(nominal: f64) -> Options {
    Options {
        gravity: G,
        nominal: Some(nominal),
        ..Options::default()
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn whatever_is_read_is_refused_or_answered(
        numbers in prop::collection::vec(
            prop_oneof![
                8 => -20.0..20.0_f64,
                1 => Just(0.0),
                1 => -1e12..1e12_f64,
                1 => Just(9.80665),
                1 => Just(f64::MAX),
                1 => Just(f64::NAN),
            ],
            0..60,
        ),
        noise in prop_oneof![Just(0.0), Just(1e-300), 1e-6..1.0_f64, Just(1e300)],
        prior in any::<bool>(),
    ) {
        let poses: Vec<Pose> = numbers
            .chunks_exact(3)
            .map(|m| Pose {
                mean: [m[0], m[1], m[2]],
                sd: [noise; 3],
                temperature_c: None,
                hint: Hint::Open,
            })
            .collect();
        if let Ok(found) = fit(&poses, &Options { prior, ..options(1.0) }) {
            prop_assert!(found.model().iter().flatten().all(|v| v.is_finite()));
            prop_assert!(found.bias().iter().all(|v| v.is_finite()));
            prop_assert!(found.covariance().iter().flatten().all(|v| v.is_finite()));
            let _ = found.trust(None).grade();
        }
    }
}

use super::*;
use crate::model::{BIAS, DRIFT, sensitivity};
use nalgebra::Rotation3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

const G: f64 = 9.80665;
const NOISE: f64 = 0.001;

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    rng.sample(StandardNormal)
}

fn truth() -> Parameters {
    let mut x = Parameters::zeros();
    let m = [1.02, 0.01, -0.02, 0.0, 0.97, 0.03, -0.01, 0.02, 1.01];
    x.fixed_rows_mut::<9>(0).copy_from_slice(&m);
    x.fixed_rows_mut::<3>(BIAS)
        .copy_from_slice(&[0.3, -0.2, 0.1]);
    x
}

/// M and b by the fit of lengths to `directions`, linear about the truth, and what orients it;
/// the true sensor reads `nonlinearity` that the fit knows to `sd_of_nonlinearity` only.
fn fitted(
    rng: &mut ChaCha8Rng,
    directions: usize,
    sd_of_nonlinearity: f64,
    nonlinearity: &Parameters,
) -> Sensor {
    let x = truth();
    let inverse = matrix(&x).try_inverse().unwrap();
    let mut information = Covariance::zeros();
    let mut pulled = Parameters::zeros();
    for n in sphere(directions) {
        // −hᵀd = error of the length: noise, and the nonlinearity that is 0 in x.
        let h = sensitivity(&inverse, &n, G);
        let length = NOISE * normal(rng) + h.dot(nonlinearity);
        information += h * h.transpose() / NOISE.powi(2);
        pulled += h * length / NOISE.powi(2);
    }
    // The frame and the nonlinearity by another source; the drift, and nonlinearity without one, are held.
    let mut held = Vec::new();
    for i in 0..PARAMETERS {
        let sd = match i {
            0..BIAS => 2e-4,
            BIAS..DRIFT => 1.0,
            DRIFT..NONLINEARITY => 0.0,
            _ => sd_of_nonlinearity,
        };
        if sd == 0.0 {
            information.row_mut(i).fill(0.0);
            information.column_mut(i).fill(0.0);
            information[(i, i)] = 1.0;
            pulled[i] = 0.0;
            held.push(i);
            continue;
        }
        information[(i, i)] += 1.0 / (sd * sd);
        pulled[i] += if i < BIAS { normal(rng) / sd } else { 0.0 };
    }
    let mut covariance = information.try_inverse().unwrap();
    let estimate = covariance * pulled;
    held.into_iter().for_each(|i| covariance[(i, i)] = 0.0);
    Sensor {
        parameters: x + estimate,
        covariance,
        gravity: Gravity {
            value_mps2: G,
            sd_mps2: 0.0,
        },
        model_error_mps2: 0.0,
    }
}

fn stills(rng: &mut ChaCha8Rng, count: usize, x: &Parameters) -> Vec<StaticMean> {
    let mut noise = || Vector3::from_fn(|_, _| NOISE * normal(rng));
    let still = |n: Vector3<f64>| StaticMean {
        mean: (matrix(x) * n * (G * (1.0 + nonlinear_error(x, &n))) + bias(x, 0.0) + noise())
            .into(),
        sd: [NOISE; 3],
        sd_of_length_mps2: 0.0,
    };
    sphere(count).map(still).collect()
}

fn compared(a: &Sensor, b: &Sensor) -> Option<Compare> {
    let none = Placements::default();
    compare([(a, &none), (b, &none)])
}

fn share_below(values: &[f64], level: f64) -> f64 {
    values.iter().filter(|p| **p < level).count() as f64 / values.len() as f64
}

/// χ², its rank and its probability.
fn tested(d: &DVector<f64>, c: &DMatrix<f64>) -> Test {
    let (chi2, rank, _) = chi_square(d, c);
    Test::new(chi2, rank, f64::INFINITY)
}

#[test]
fn chi_square_of_any_rank() {
    let d = DVector::from_vec(vec![2.0, 3.0]);
    let c = DMatrix::from_diagonal(&DVector::from_vec(vec![4.0, 9.0]));
    let test = tested(&d, &c);
    assert!((test.chi2 - 2.0).abs() < 1e-12 && test.degrees_of_freedom == 2);
    // Two degrees of freedom: e^(−χ²/2).
    assert!((test.p_value - (-1.0_f64).exp()).abs() < 1e-9);
    // Variance only along (1, 1)/√2.
    let test = tested(
        &DVector::from_vec(vec![1.0, 0.0]),
        &DMatrix::repeat(2, 2, 1.0),
    );
    assert!((test.chi2 - 0.25).abs() < 1e-12 && test.degrees_of_freedom == 1);
    // Tables: 1 %, 5 %, 1 %.
    for (chi2, rank, p) in [(6.635, 1, 0.01), (16.919, 9, 0.05), (26.217, 12, 0.01)] {
        assert!((Test::new(chi2, rank, f64::INFINITY).p_value - p).abs() < 1e-5);
    }
}

#[test]
fn nothing_to_test_is_no_panic() {
    let two = DVector::repeat(2, 1.0);
    for (d, c) in [
        (DVector::zeros(0), DMatrix::zeros(0, 0)),
        (two.clone(), DMatrix::zeros(2, 2)),
        (two.clone(), DMatrix::identity(3, 3)),
        (two.clone(), DMatrix::repeat(2, 2, f64::NAN)),
        (two.clone(), -DMatrix::<f64>::identity(2, 2)),
        (two * f64::INFINITY, DMatrix::identity(2, 2)),
    ] {
        let test = tested(&d, &c);
        assert_eq!((test.degrees_of_freedom, test.p_value), (0, 1.0));
    }
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let good = fitted(&mut rng, 12, 0.0, &Parameters::zeros());
    let some = stills(&mut rng, 3, &truth());
    assert!(check(&good, None, &[], |_| true).is_none());
    let [mut singular, mut a, mut b, mut c] = [(); 4].map(|()| good.clone());
    singular.parameters = Parameters::zeros();
    (a.parameters[0], b.parameters[10], c.parameters[20]) = (f64::NAN, f64::NAN, f64::NAN);
    for bad in [singular, a, b, c] {
        assert!(check(&bad, None, &some, |_| true).is_none() && compared(&good, &bad).is_none());
    }
}

/// A nonlinearity of 0.2 % that the fit knows to 0.2 %, seen by few poses: shared, it makes no difference
/// between two calibrations, and the second one of more poses none either; nor one that fits no nonlinearity,
/// which many poses average out of M and b.
#[test]
fn bends_are_shared() {
    for (first, second, sd) in [(12, 12, 0.002), (12, 30, 0.002), (12, 200, 0.0)] {
        let mut p = Vec::new();
        for seed in 0..100 {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let mut nonlinearity = Parameters::zeros();
            (NONLINEARITY..21).for_each(|i| nonlinearity[i] = 0.002 * normal(&mut rng));
            let a = fitted(&mut rng, first, 0.002, &nonlinearity);
            let b = fitted(&mut rng, second, sd, &nonlinearity);
            p.push(compared(&a, &b).unwrap().magnitude.test.p_value);
        }
        let share = share_below(&p, 0.05);
        assert!((0.005..=0.09).contains(&share), "{first} {second}: {share}");
    }
}

/// Of a turn that two tilts of each face tell, of which σ was estimated from so many tilts: F in place of χ².
#[test]
fn estimated_tilts_are_tested_by_f() {
    let tilt_rad = 0.01;
    let faces = Face::all().map(Face::direction).to_vec();
    // Of a turn about each axis four tilts tell.
    let variance = tilt_rad * tilt_rad / 4.0;
    let mut sensor = fitted(
        &mut ChaCha8Rng::seed_from_u64(1),
        12,
        0.0,
        &Parameters::zeros(),
    );
    sensor.parameters = Parameters::zeros();
    (0..3).for_each(|i| sensor.parameters[4 * i] = 1.0);
    sensor.covariance = Covariance::zeros();
    for axis in 0..3 {
        let (i, k) = ((axis + 1) % 3, (axis + 2) % 3);
        let turn = Parameters::from_fn(|p, _| match p {
            p if p == 3 * i + k => -1.0,
            p if p == 3 * k + i => 1.0,
            _ => 0.0,
        });
        sensor.covariance += turn * turn.transpose() * variance;
    }
    let exact = Sensor {
        covariance: Covariance::zeros(),
        ..sensor.clone()
    };
    // F of 3 and 10 degrees of freedom: 6.552 at 1 %.
    let by = (6.552 * variance).sqrt();
    let mut turned = exact;
    let q = Rotation3::new(Vector3::repeat(by));
    (0..9).for_each(|i| turned.parameters[i] = q.matrix()[(i / 3, i % 3)]);
    let placements = Placements {
        forces: faces,
        tilt_rad,
        freedom: 10.0 - PRIOR_FREEDOM,
    };
    let found = compare([(&sensor, &placements), (&turned, &Placements::default())]).unwrap();
    let p = found.turn.unwrap().test.p_value;
    assert!((p / 0.01 - 1.0).abs() < 0.02, "{p}");
}

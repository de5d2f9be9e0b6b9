//! `khalil_kleinfinger`: the product of what it returns is what it was given.

use std::f64::consts::{FRAC_PI_2, PI};

use elastogeo::description::khalil_kleinfinger::{Isometry, khalil_kleinfinger};
use elastogeo::description::robot::Constants;
use nalgebra::{Matrix4, Rotation3, Translation3, Vector3};
use proptest::prelude::*;

fn rotation(axis: Vector3<f64>, angle: f64) -> Matrix4<f64> {
    Matrix4::from_scaled_axis(axis * angle)
}

/// From the definition.
fn product(c: &Constants) -> Matrix4<f64> {
    let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
    let shift = |v: Vector3<f64>| Matrix4::new_translation(&v);
    rotation(y, c.beta)
        * rotation(z, c.gamma)
        * shift(z * c.b)
        * rotation(x, c.alpha)
        * shift(x * c.d)
        * rotation(z, c.theta)
        * shift(z * c.r)
}

fn assert_exact(t: &Isometry) -> Constants {
    let constants = khalil_kleinfinger(t);
    let wanted = t.to_homogeneous();
    let scale = 1.0 + t.translation.vector.norm();
    let mut off = product(&constants) - wanted;
    for row in 0..3 {
        off[(row, 3)] /= scale;
    }
    assert!(off.amax() < 1e-12, "{constants:?} is {:e} off for {t}", off.amax());
    assert!((constants.isometry().to_homogeneous() - product(&constants)).amax() < 1e-14 * scale * 20.0);
    assert!(constants.gamma > -FRAC_PI_2 && constants.gamma <= FRAC_PI_2, "{constants:?}");
    // No constant is out of proportion to what it describes.
    for length in [constants.b, constants.d, constants.r] {
        assert!(length.abs() < 41.0 * scale, "{constants:?}");
    }
    constants
}

fn angle() -> impl Strategy<Value = f64> {
    prop_oneof![
        3 => -PI..PI,
        3 => (-4_i32..=4).prop_map(|k| f64::from(k) * FRAC_PI_2),
        1 => (-12_i32..=12).prop_map(|k| f64::from(k) * PI / 12.0),
        2 => ((-4_i32..=4), -14.0..-1.0_f64, any::<bool>())
            .prop_map(|(k, e, up)| f64::from(k) * FRAC_PI_2 + 10_f64.powf(e) * if up { 1.0 } else { -1.0 }),
    ]
}

fn length() -> impl Strategy<Value = f64> {
    prop_oneof![
        3 => -2.0..2.0_f64,
        3 => Just(0.0),
        1 => -1e6..1e6_f64,
        1 => (-16.0..-3.0_f64).prop_map(|e| 10_f64.powf(e)),
    ]
}

prop_compose! {
    fn displacement()(r in angle(), p in angle(), y in angle(), x in length(), v in length(), z in length()) -> Isometry {
        Isometry::from_parts(Translation3::new(x, v, z), Rotation3::from_euler_angles(r, p, y))
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn the_product_is_the_displacement(t in displacement()) {
        assert_exact(&t);
    }

    #[test]
    fn a_table_without_gamma_and_b_comes_back(alpha in angle(), d in 1e-3..2.0_f64, theta in angle(), r in -2.0..2.0_f64) {
        let given = Constants { alpha, d, theta, r, ..Constants::default() };
        let found = assert_exact(&given.isometry());
        prop_assert!(found.b.abs() < 1e-12 && (found.gamma * d).abs() < 2e-12 && found.beta.abs() < 1e-10, "{found:?}");
        prop_assert!((found.d - d).abs() < 1e-12, "{found:?}");
    }
}

#[test]
fn clean_displacements_have_clean_constants() {
    for k in 0..4 {
        for l in 0..4 {
            for offset in [0.0, 0.35, -1.25] {
                let [alpha, theta] = [k, l].map(|quarter| f64::from(quarter - 1) * FRAC_PI_2);
                let given = Constants { alpha, d: offset, theta, r: 0.75, ..Constants::default() };
                assert_eq!(assert_exact(&given.isometry()), given);
            }
        }
    }
    let thirty = Constants { alpha: 30_f64.to_radians(), theta: -FRAC_PI_2, ..Constants::default() };
    assert_eq!(assert_exact(&thirty.isometry()), thirty);
}

#[test]
fn nearly_parallel_axes_keep_their_normal_at_hand() {
    // An axis 1 m off along x, tilted about y: its common normal with z is 1 / tilt away.
    for tilt in [1e-11, 1e-8, 1e-6, 3.7e-6, 1e-4, 0.01, 0.03] {
        for p in
            [Vector3::new(1.0, 0.0, 0.2), Vector3::new(0.6, 0.8, 0.0), Vector3::new(0.0, 1.0, 0.5), Vector3::zeros()]
        {
            for (x, y) in [(tilt, 0.0), (0.0, tilt), (tilt, -tilt)] {
                for over in [0.0, PI] {
                    let turn = Rotation3::from_euler_angles(x + over, y, 0.3);
                    let constants = assert_exact(&Isometry::from_parts(p.into(), turn));
                    for length in [constants.b, constants.d, constants.r] {
                        assert!(length.abs() < 1.2, "{constants:?}");
                    }
                }
            }
        }
    }
}

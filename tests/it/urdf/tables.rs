//! A bundled URDF gives exactly the printed table, and the poses of an independent implementation.

use std::f64::consts::FRAC_PI_2;

use elastogeo::description::raw::JointKind;
use elastogeo::description::urdf::import;
use nalgebra::{Matrix3, Matrix4};

use super::forward::{Values, assert_same, of_description};

const KR270: &str = include_str!("../../../robots/kuka-kr270.urdf");

#[test]
fn kr270_has_the_constants_of_its_table() {
    let (robot, diagnostics) = import("kuka-kr270.urdf", KR270).unwrap();
    assert_eq!(diagnostics, []);
    // alpha, d, theta, r; limits in degrees; mass, centre of mass.
    let table = [
        ("1", "0", [0.0, 0.0, 0.0, 0.75], Some([-185.0, 185.0]), (480.0, [0.1, 0.0, -0.25])),
        ("2", "1", [-FRAC_PI_2, 0.35, 0.0, 0.0], Some([-146.0, 0.0]), (220.0, [0.52, 0.0, 0.0])),
        ("3", "2", [0.0, 1.25, -FRAC_PI_2, 0.0], Some([-119.0, 155.0]), (230.0, [-0.02, 0.2, 0.0])),
        ("4", "3", [-FRAC_PI_2, -0.055, 0.0, 1.1], Some([-350.0, 350.0]), (60.0, [0.0, 0.0, -0.25])),
        ("5", "4", [FRAC_PI_2, 0.0, 0.0, 0.0], Some([-125.0, 125.0]), (50.0, [0.0; 3])),
        ("6", "5", [-FRAC_PI_2, 0.0, 0.0, 0.0], Some([-350.0, 350.0]), (20.0, [0.0, 0.0, 0.18])),
        ("E", "6", [0.0, 0.0, 0.0, 0.23], None, (30.0, [0.0, 0.0, 0.15])),
    ];
    assert_eq!(robot.frames.len(), table.len());
    for ((found, frame), (name, antecedent, constants, limits, (mass, com))) in robot.frames.iter().zip(table) {
        assert_eq!((found.as_str(), frame.antecedent.as_deref()), (name, Some(antecedent)));
        let [alpha, d, theta, r] = [frame.alpha, frame.d, frame.theta, frame.r].map(|constant| constant.unwrap_or(0.0));
        assert_eq!([alpha, d, theta, r], constants, "{name}");
        assert_eq!([frame.beta, frame.gamma, frame.b, frame.offset, frame.direction], [None; 5]);
        let limits = limits.map(|limits: [f64; 2]| limits.map(f64::to_radians));
        assert_eq!(frame.limits, limits, "{name}");
        let (kind, variable) =
            if name == "E" { (JointKind::Fixed, None) } else { (JointKind::Revolute, Some(name.to_owned())) };
        assert_eq!((frame.joint, &frame.variable), (Some(kind), &variable));
        assert_eq!(robot.bodies[name].mass, Some(mass));
        assert_eq!(robot.bodies[name].com.unwrap_or_default(), com, "{name}");
    }
    assert_eq!(robot.tool.frame.as_deref(), Some("E"));
    assert_eq!((robot.tool.at, robot.tool.rotation), (None, None));
}

/// Joint values in degrees and pose, x forward and z up at zero; section `kr270_fk` (`T_plus`) of the golden values, which
/// come from an independent implementation of the chain Tz Rz Tx Ry Tx Ry Tx Tz Rx Ry Rx Tx.
#[allow(clippy::approx_constant, clippy::excessive_precision)]
const GOLDEN: [([f64; 6], [f64; 16]); 4] = [
    ([0.0; 6], [1.0, 0.0, 0.0, 2.93, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.695, 0.0, 0.0, 0.0, 1.0]),
    (
        [30.0, -60.0, 80.0, 20.0, -45.0, 10.0],
        [
            0.8931769474094309,
            -0.40769193411364857,
            -0.18979522511128463,
            1.9286920187783767,
            0.23641767338698375,
            0.7847052823851562,
            -0.5730133536900495,
            1.0493014523697999,
            0.3825462381551494,
            0.4669313725329502,
            0.7972662472586176,
            1.492612137704772,
            0.0,
            0.0,
            0.0,
            1.0,
        ],
    ),
    (
        [-45.0, -25.2, 60.0, -90.0, 30.0, 120.0],
        [
            0.14929575067360815,
            0.983532373435766,
            -0.10185700385644816,
            1.698095719518408,
            -0.8564025318601555,
            0.0771277983440554,
            -0.5105154318393462,
            -1.8607302791913138,
            -0.49425244789916745,
            0.16344838061726827,
            0.8538144673283964,
            0.49559792048430384,
            0.0,
            0.0,
            0.0,
            1.0,
        ],
    ),
    (
        [-120.0, -56.9, 20.0, 150.0, -80.0, 75.0],
        [
            -0.7519059158675848,
            0.1088481297873387,
            0.6502227144026322,
            -1.145590204647924,
            -0.31753149578205897,
            0.8045494866810696,
            -0.5018703743673615,
            -1.7577146559106251,
            -0.5777640027465684,
            -0.583825494581237,
            -0.5703828091792716,
            2.28074226678552,
            0.0,
            0.0,
            0.0,
            1.0,
        ],
    ),
];

#[test]
fn kr270_reaches_the_golden_poses() {
    let (robot, _) = import("kuka-kr270.urdf", KR270).unwrap();
    // Frame E has x up and z forward.
    let axes = Matrix3::new(0.0, 0.0, 1.0, 0.0, -1.0, 0.0, 1.0, 0.0, 0.0).to_homogeneous();
    for (degrees, pose) in GOLDEN {
        let values: Values = (1..=6).map(|k| k.to_string()).zip(degrees.map(f64::to_radians)).collect();
        assert_same(KR270, &robot, &values, 1e-12);
        let reached = of_description(&robot, &values)["E"].to_homogeneous() * axes;
        let off = (reached - Matrix4::from_row_slice(&pose)).amax();
        assert!(off < 1e-12, "{off:e} at {degrees:?}");
    }
}

//! Identification of 33 parameters of the KR-270 from 1000 positions, with own weight and without, on one thread, compared with
//! the same least squares written with nalgebra's dynamic matrices and a central-difference Jacobian. Prints milliseconds
//! and the ratio.

use std::time::Instant;

use elastogeo::description::campaign::Campaign;
use elastogeo::estimation::{Settings, calibrate};
use elastogeo::files::load_robot;
use elastogeo::kinematics::Geometry;
use elastogeo::model::Model;
use elastogeo::observation::POSITION;
use elastogeo::parameter::Slot;
use elastogeo::prediction::{Linearised, Predictor};
use elastogeo::simulation::{Plan, draw_configurations, draw_errors, generator, simulate};
use nalgebra::{DMatrix, DVector, Vector3};

fn main() {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().expect("the first pool");
    let loaded = load_robot("kuka-kr270").expect("a bundled robot");
    compared("own weight bends it", &loaded.model);
    let mut rigid = loaded.model;
    rigid.structure.gravity = Vector3::zeros();
    compared("no own weight", &rigid);
}

fn compared(case: &str, model: &Model) {
    let mut random = generator(33);
    let values = draw_errors(model, 0.3, 0.0, &mut random);
    let geometry = Geometry::nominal(model).expect("assembled");
    let configurations = draw_configurations(&geometry, 1000, 0.8, &mut random).expect("drawn");
    let markers = (0..1000).map(|k| Some(k % 3)).collect::<Vec<_>>();
    let plan = Plan {
        wrenches: Vec::new(),
        conditions: false,
        configurations,
        markers: vec![Some(0), Some(1), Some(2)],
        repeats: 1,
        observes: POSITION,
        sigma: 5e-5,
        sigma_orientation: 0.0,
        estimate: [true, true],
    };
    // One marker a configuration, in turns.
    let campaign = simulate(model, &values, &plan, &mut random).expect("simulated");
    let campaign = campaign.select(|_, reading| reading.marker == markers[reading.pose]);
    let held_out = vec![false; campaign.readings.len()];
    let run = || calibrate(model, &campaign, &held_out, &Settings::default(), &mut |_| {}).expect("calibrated");
    let found = run();
    let kept: Vec<Slot> = found.identifiability.kept.iter().map(|&column| found.slots[column]).collect();
    let mut times: Vec<f64> = (0..7).map(|_| timed(run).1).collect();
    times.sort_by(f64::total_cmp);
    let (naive, naive_time) = timed(|| naive(model, &campaign, &kept));
    for (&slot, value) in kept.iter().zip(&naive) {
        assert!((found.values[slot] - value).abs() < 1e-7, "{} differs", model.registry[slot].name);
    }
    println!(
        "identify/{} positions/{} parameters, {case}: {:.1} ms here (median of 7; the whole of `calibrate`), {:.1} ms naive, ratio {:.0}",
        campaign.readings.len(),
        kept.len(),
        times[3] * 1e3,
        naive_time * 1e3,
        naive_time / times[3]
    );
}

fn timed<T>(run: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let result = run();
    (result, start.elapsed().as_secs_f64())
}

/// Gauss-Newton from the nominal values: a central-difference Jacobian and a dense QR in every iteration.
fn naive(model: &Model, campaign: &Campaign, kept: &[Slot]) -> Vec<f64> {
    let predictor = Predictor::new(model, campaign, Vec::new()).expect("predictable");
    let residual = |values: &[f64]| {
        let mut found = Linearised::default();
        predictor.linearise(values, false, &mut found).expect("placed");
        DVector::from_vec(found.residual)
    };
    let (mut values, h) = (model.registry.nominal(), 1e-6);
    for _ in 0..30 {
        let r = residual(&values);
        let mut jacobian = DMatrix::zeros(r.len(), kept.len());
        for (k, &slot) in kept.iter().enumerate() {
            let at = |change: f64| {
                let mut changed = values.clone();
                changed[slot] += change;
                residual(&changed)
            };
            jacobian.set_column(k, &((at(h) - at(-h)) / (2.0 * h)));
        }
        let qr = jacobian.qr();
        let step = qr.r().solve_upper_triangular(&(qr.q().transpose() * r)).expect("regular");
        kept.iter().zip(step.iter()).for_each(|(&slot, step)| values[slot] -= step);
        if step.amax() < 1e-10 {
            break;
        }
    }
    kept.iter().map(|&slot| values[slot]).collect()
}

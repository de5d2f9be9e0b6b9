//! Withheld effects: a dozen sealed campaigns, modest floors.

use elastogeo::blind::{Drawn, Kind, draw, examine, score, seal};
use elastogeo::files::load_robot_leaving_out;
use elastogeo::simulation::generator;
use rayon::prelude::*;

#[test]
fn withheld_effects_are_found_and_nulls_left_alone() {
    let robot = load_robot_leaving_out("kuka-kr270", &["compensator"]).expect("a bundled robot");
    let kinds = [Kind::Single, Kind::Single, Kind::Null, Kind::Pair];
    let all: Vec<_> = (0..12_usize)
        .into_par_iter()
        .map(|k| {
            let mut random = generator(5_000 + k as u64);
            let (deflection, poses) = if k % 3 == 1 { (true, 20) } else { (false, 45) };
            let Drawn { campaign, fresh, truth } =
                draw(&robot.model, "kuka-kr270", "sealed", kinds[k % 4], deflection, poses, &mut random)
                    .expect("a campaign");
            assert!((1.0..12.0).contains(&truth.gap), "{truth:?}");
            examine(&robot.model, &campaign, &fresh, 1).expect("a diagnosis").open(truth)
        })
        .collect();
    let found = score(&all);
    let class = |name: &str| found.classes.get(name).map_or((0, 0), |class| (class.count, class.right));
    let ((singles, hits), (nulls, silent)) = (class("single"), class("null"));
    assert_eq!((singles, nulls), (6, 3));
    assert!(hits >= 3, "{hits} of {singles}: {all:#?}");
    assert!(silent >= 2, "{silent} of {nulls}: {all:#?}");
}

#[test]
fn a_seal_is_the_sha_256_of_the_truth() {
    assert_eq!(seal("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

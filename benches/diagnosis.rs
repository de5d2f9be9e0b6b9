//! Diagnosis of 135 readings over the whole catalogue, with cross-validation and 1000 bootstraps, on two threads, compared
//! with the naive competition: every (effect, site, nonlinear parameter) calibrated anew on every fold. That one is timed on
//! every 20th hypothesis and scaled to all.

use std::time::Instant;

use elastogeo::description::campaign::Campaign;
use elastogeo::description::raw::RawEffect;
use elastogeo::diagnosis::{Diagnosis, Settings, diagnose};
use elastogeo::effects::EffectEntry;
use elastogeo::estimation::{self, calibrate};
use elastogeo::files::load_robot;
use elastogeo::kinematics::Geometry;
use elastogeo::model::{Model, nuisance};
use elastogeo::observation::POSITION;
use elastogeo::parameter::Slot;
use elastogeo::prediction::survey;
use elastogeo::simulation::{Plan, draw_configurations, draw_errors, generator, simulate};

const FOLDS: usize = 10;
const EVERY: usize = 20;

fn main() {
    rayon::ThreadPoolBuilder::new().num_threads(2).build_global().expect("the first pool");
    divan::main();
    if std::env::args().any(|argument| argument == "--test" || argument == "--list") {
        return;
    }
    let (model, campaign) = made();
    let mut times: Vec<f64> = (0..5).map(|_| timed(|| diagnosed(&model, &campaign)).1).collect();
    times.sort_by(f64::total_cmp);
    let found = diagnosed(&model, &campaign);
    let cause = found.causes.first().map(|cause| format!("{} at {}", cause.effect, cause.site));
    assert_eq!(cause.as_deref(), Some("transmission-error at joint:2"));
    let all = hypotheses(&model, &campaign);
    let chosen: Vec<_> = all.iter().step_by(EVERY).collect();
    let ((), sample) = timed(|| chosen.iter().for_each(|one| refitted(&model, &campaign, one)));
    let naive = sample * all.len() as f64 / chosen.len() as f64;
    println!(
        "\ndiagnosis/{} readings, {} hypotheses: {:.2} s here (median of 5; target 0.5), {naive:.0} s naive ({} of {} forms in {sample:.1} s, scaled), ratio {:.0}",
        campaign.readings.len(),
        found.hypotheses,
        times[2],
        chosen.len(),
        all.len(),
        naive / times[2]
    );
}

#[divan::bench(sample_count = 5, sample_size = 1)]
fn whole_catalogue(bencher: divan::Bencher) {
    let (model, campaign) = made();
    bencher.bench_local(|| diagnosed(&model, &campaign));
}

fn timed<T>(run: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let result = run();
    (result, start.elapsed().as_secs_f64())
}

/// KR-270 with geometry errors and a transmission error of joint 2: 45 configurations, 3 markers, base and markers unknown.
fn made() -> (Model, Campaign) {
    let model = load_robot("kuka-kr270").expect("a bundled robot").model;
    let mut random = generator(5);
    let mut values = draw_errors(&model, 0.3, 0.0, &mut random);
    let geometry = Geometry::new(&model, &values).expect("assembled");
    let configurations = draw_configurations(&geometry, 45, 0.8, &mut random).expect("drawn");
    let mut with = model.clone();
    let parameters = [("cos", 2e-4), ("sin", 1e-4), ("order", 2.0)];
    let parameters = parameters.map(|(name, value)| (name.to_string(), value.into())).into_iter().collect();
    let raw = RawEffect {
        effect: Some("transmission-error".into()),
        site: Some("joint:2".into()),
        parameters,
        ..RawEffect::default()
    };
    with.switch_on(model.resolve_effect(&raw).expect("an effect of this robot"));
    values = with.completed(&values);
    let plan = Plan {
        wrenches: Vec::new(),
        conditions: true,
        configurations,
        markers: vec![Some(0), Some(1), Some(2)],
        repeats: 1,
        observes: POSITION,
        sigma: 5e-5,
        sigma_orientation: 0.0,
        estimate: [true, true],
    };
    let campaign = simulate(&with, &values, &plan, &mut random).expect("simulated");
    (model, campaign)
}

fn diagnosed(model: &Model, campaign: &Campaign) -> Diagnosis {
    let held_out = vec![false; campaign.readings.len()];
    diagnose(model, campaign, &held_out, &Settings::new(campaign, 1), &mut |_| {}).expect("diagnosed")
}

/// Every candidate of every effect at every site that is not calibrated anyway.
fn hypotheses(model: &Model, campaign: &Campaign) -> Vec<EffectEntry> {
    let geometry = Geometry::nominal(model).expect("assembled");
    let offered = survey(&geometry, campaign).expect("placed");
    let mut all = Vec::new();
    for effect in model.catalogue.iter().filter(|e| !campaign.calibrate.iter().any(|name| name == e.name())) {
        for site in effect.sites(model) {
            for nonlinear in effect.candidates(model, &site, &offered) {
                let parameters = effect.parameters(model, &site, &nonlinear);
                if !parameters.is_empty() {
                    let amounts = parameters.into_iter().map(|parameter| (parameter.symbol, 0.0)).collect();
                    all.push(EffectEntry { effect: effect.clone(), site: site.clone(), nonlinear, amounts });
                }
            }
        }
    }
    all
}

/// One hypothesis fitted with everything else, fold by fold.
fn refitted(model: &Model, campaign: &Campaign, entry: &EffectEntry) {
    let mut with = model.clone();
    let mut slots: Vec<Slot> = nuisance(model, campaign, &campaign.calibrate);
    let constants = entry.effect.constants(model, &entry.site, &entry.nonlinear);
    if constants.is_empty() {
        with.switch_on(entry.clone());
        slots.extend(with.effects.last().expect("switched on").slots.iter().flatten());
    } else {
        slots.extend(constants);
    }
    slots.sort_unstable();
    slots.dedup();
    let asked = estimation::Settings { only: Some(slots), ..estimation::Settings::default() };
    for fold in 0..FOLDS {
        let held_out: Vec<bool> = campaign.readings.iter().map(|reading| reading.pose % FOLDS == fold).collect();
        // A hypothesis that cannot be fitted costs the time of finding out.
        let _ = std::hint::black_box(calibrate(&with, campaign, &held_out, &asked, &mut |_| {}));
    }
}

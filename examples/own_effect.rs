//! An effect of a program's own, in addition to the standard catalogue: a hose package that turns joint 5 as joints 4 and 6 wind it up.
//!
//! `cargo run --example own_effect`

use std::sync::Arc;

use elastogeo::diagnosis::{Diagnosis, Settings, diagnose};
use elastogeo::effects::{Catalogue, Change, Changes, Effect, EffectParameter, Nonlinear, Site, SiteKind};
use elastogeo::files::Reader;
use elastogeo::kinematics::Geometry;
use elastogeo::model::Model;
use elastogeo::simulation::{Plan, draw_configurations, draw_errors, generator, simulate};

pub struct HosePull;

impl Effect for HosePull {
    fn name(&self) -> &'static str {
        "hose-pull"
    }

    fn sits_at(&self) -> SiteKind {
        SiteKind::Joint
    }

    fn signature(&self) -> &'static str {
        "an angle of one joint that grows with the square of how far the hose is wound up"
    }

    fn remedy(&self) -> &'static str {
        "lengthen the hose package"
    }

    /// It can only sit at joint 5.
    fn sites(&self, model: &Model) -> Vec<Site> {
        model.sites(self.sits_at()).into_iter().filter(|site| site.name == "joint:5").collect()
    }

    fn parameters(&self, _model: &Model, _site: &Site, _nonlinear: &Nonlinear) -> Vec<EffectParameter> {
        vec![EffectParameter::new("pull", "1/rad", 1e-4)]
    }

    /// What one unit of the parameter changes in a reading: joint 5 stands elsewhere.
    fn changes(&self, _model: &Model, site: &Site, _nonlinear: &Nonlinear) -> Changes {
        let Some(variable) = site.coordinate else { return Arc::new(|_, _| {}) };
        Arc::new(move |context, out| {
            let wound = context.q[3] + context.q[5];
            out.push((0, Change::Joint(variable, wound * wound)));
        })
    }
}

/// A UR5 with a hose of this pull (rad of joint 5 for each rad squared), measured at 60 configurations with 0.03 mm of
/// noise: diagnosed with the standard catalogue, and with the effect added to it.
pub fn diagnosed(pull: f64) -> [Diagnosis; 2] {
    let standard = Catalogue::standard();
    let extended = standard.clone().with(HosePull);
    let [standard, extended] = [standard, extended]
        .map(|catalogue| Reader::new(catalogue).robot("universal-ur5").expect("a bundled robot").model);
    let model = &standard;
    let mut random = generator(5);
    let values = draw_errors(model, 0.5, 0.0, &mut random);
    let geometry = Geometry::new(model, &values).expect("assembled");
    let commanded = draw_configurations(&geometry, 60, 0.25, &mut random).expect("drawn");
    // The robot goes where the hose lets it go; the file says what was commanded.
    let reached = commanded.iter().cloned().map(|mut q| {
        q[4] += pull * (q[3] + q[5]).powi(2);
        q
    });
    let plan = Plan {
        conditions: false,
        configurations: reached.collect(),
        markers: vec![None],
        repeats: 1,
        wrenches: Vec::new(),
        observes: elastogeo::observation::POSITION,
        sigma: 3e-5,
        sigma_orientation: 0.0,
        estimate: [true, true],
    };
    let mut campaign = simulate(model, &values, &plan, &mut random).expect("simulated");
    campaign.joints = commanded.concat();

    let held_out = vec![false; campaign.readings.len()];
    let settings = Settings::new(&campaign, 1);
    [&standard, &extended]
        .map(|model| diagnose(model, &campaign, &held_out, &settings, &mut |_| {}).expect("diagnosed"))
}

#[allow(dead_code)] // the tests take this file in
fn main() {
    for found in diagnosed(3e-4) {
        println!("{:?}: {:.4} mm before, {:.4} mm after", found.verdict, 1e3 * found.gap.rms, 1e3 * found.rms_after);
        for cause in &found.causes {
            println!("  {} at {}: {:?}", cause.effect, cause.site, cause.parameters);
        }
    }
}

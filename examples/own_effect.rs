//! An effect of one's own beside the catalogue: a hose package that turns joint 5 as joints 4 and 6 wind it up.
//!
//! `cargo run --example own_effect`

use elastogeo::diagnosis::{Diagnosis, Settings, diagnose};
use elastogeo::effects::{Change, Effect, EffectParameter, Form, Moment, Site, SiteKind};
use elastogeo::files::load_robot;
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
        elastogeo::effects::sites_of(model, self.sits_at()).into_iter().filter(|site| site.name == "joint:5").collect()
    }

    fn parameters(&self, _model: &Model, _site: &Site, _form: &Form) -> Vec<EffectParameter> {
        vec![EffectParameter { symbol: "pull".into(), unit: "1/rad", scale: 1e-4, is_positive: false }]
    }

    /// What one unit of the parameter changes in a reading: joint 5 stands elsewhere.
    fn changes(&self, site: &Site, _form: &Form, moment: &Moment, out: &mut Vec<(usize, Change)>) {
        let wound = moment.q[3] + moment.q[5];
        out.push((0, Change::Joint(site.variable, wound * wound)));
    }
}

/// A UR5 with a hose of this pull (rad of joint 5 for each rad squared), measured at 60 configurations with 0.03 mm of
/// noise: diagnosed by the catalogue alone, and with the effect beside it.
pub fn diagnosed(pull: f64) -> [Diagnosis; 2] {
    let model = &load_robot("universal-ur5").expect("bundled").model;
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
        observes: elastogeo::description::campaign::Observes::Position,
        sigma: 3e-5,
        sigma_orientation: 0.0,
        estimate: [true, true],
    };
    let mut campaign = simulate(model, &values, &plan, &mut random).expect("simulated");
    campaign.joints = commanded.concat();

    let aside = vec![false; campaign.readings.len()];
    let alone = Settings::new(&campaign, 1);
    let mut beside = alone.clone();
    beside.effects.push(&HosePull);
    [alone, beside].map(|settings| diagnose(model, &campaign, &aside, &settings, &mut |_| {}).expect("diagnosed"))
}

#[allow(dead_code)] // the tests take this file in
fn main() {
    let model = load_robot("universal-ur5").expect("bundled").model;
    for found in diagnosed(3e-4) {
        let result = elastogeo::results::Diagnosis::new(&model, "UR5 with a hose package", &found, 0.0);
        println!("{}", elastogeo::render::diagnosis::diagnosis(&result, Default::default()));
    }
}

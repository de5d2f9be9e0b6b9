//! Rotations are registered however far they are from the description: of a sensor on its body, of base and tool.

use elastogeo::description::campaign::InSession;
use elastogeo::estimation::{RegistrationSettings, registered};
use elastogeo::files::load_robot;
use elastogeo::kinematics::Geometry;
use elastogeo::observation::{AXIS, ORIENTATION, POSE};
use elastogeo::simulation::{Plan, draw_configurations, generator, measure, unmeasured};
use nalgebra::{Rotation3, Vector3};

use crate::support::{number, printed_json};

/// Rotation vectors of 100 to 175 degrees about axes of no frame.
const TURNS: [[f64; 3]; 4] = [[100.0, -20.0, 10.0], [-80.0, 80.0, 90.0], [3.0, -40.0, 165.0], [-120.0, -70.0, 60.0]];

#[test]
fn mounts_of_inclinometers_are_found_however_they_are_turned() {
    for [x, y, z] in TURNS {
        let folder = tempfile::tempdir().expect("a folder");
        let at = folder.path();
        let campaign = |mount: &str| {
            format!(
                "robot: universal-ur5\nunits: {{length: mm, angle: deg}}\ninstrument: {{orientation: 0.003}}\n\
                 observes: inclination\nmeasurements:\n- {{file: measurements.csv, body: \"5\", mount: {mount}}}\n"
            )
        };
        std::fs::write(at.join("c.yaml"), campaign(&format!("[{x}, {y}, {z}]"))).expect("written");
        printed_json(at, &["simulate", "c.yaml", "--poses", "30", "--errors", "0", "--into", "m"]);
        std::fs::write(at.join("m/campaign.yaml"), campaign("unknown")).expect("written");
        let found = printed_json(at, &["register", "m"]);
        let of = |axis: &str| {
            let mut all = found["parameters"].as_array().expect("a list").iter();
            let own = all.find(|own| own["name"].as_str().is_some_and(|name| name.ends_with(&format!("@5.{axis}"))));
            number(&own.unwrap_or_else(|| panic!("{}", found["parameters"]))["value"]).to_radians()
        };
        let [found, truth] = [[of("rx"), of("ry"), of("rz")], [x, y, z].map(f64::to_radians)]
            .map(|turn| Rotation3::new(Vector3::from(turn)));
        assert!(found.angle_to(&truth).to_degrees() < 0.01, "{}", found.angle_to(&truth).to_degrees());
    }
}

/// Orientations, axes and poses of a tool, base and tool far turned: what is left is the noise.
#[test]
fn base_and_tool_are_found_however_they_are_turned() {
    let robot = load_robot("universal-ur5").expect("bundled");
    let model = &robot.model;
    let geometry = Geometry::nominal(model).expect("assembled");
    let noise = 5e-5;
    let mut worst = 0.0_f64;
    for (k, (base, tool)) in TURNS.iter().flat_map(|base| TURNS.map(|tool| (base, tool))).enumerate() {
        let seed = k as u64;
        for observes in [ORIENTATION, AXIS, POSE] {
            let plan = Plan {
                configurations: draw_configurations(&geometry, 30, 0.7, &mut generator(seed)).expect("drawn"),
                markers: vec![None],
                repeats: 1,
                wrenches: Vec::new(),
                conditions: false,
                observes,
                sigma: 3e-5,
                sigma_orientation: noise,
                estimate: [true, true],
            };
            let campaign = unmeasured(model, &plan);
            let model = &model.arranged(&campaign);
            let mut truth = model.registry.nominal();
            for (slot, turn) in
                [(model.base_slot(InSession::default()) + 3, *base), (model.tool_slot(InSession::default()) + 3, tool)]
            {
                (0..3).for_each(|axis| truth[slot + axis] = turn[axis].to_radians());
            }
            let sigmas = [3e-5, noise];
            let campaign = measure(model, &truth, campaign, sigmas, &mut generator(seed)).expect("measured");
            let found = registered(model, &campaign, &model.registry.nominal(), &RegistrationSettings::default());
            let (_, residual) = found.expect("registered");
            let angles = |row: usize| row % observes.rows() >= observes.length_rows();
            let own: Vec<f64> = (0..residual.len()).filter(|&row| angles(row)).map(|row| residual[row]).collect();
            let left = (own.iter().map(|value| value * value).sum::<f64>() / own.len() as f64).sqrt();
            assert!(left < 1.3 * noise, "{}: {left} rad, base {base:?}, tool {tool:?}", observes.name());
            worst = worst.max(left);
        }
    }
    assert!(worst > 0.5 * noise);
}

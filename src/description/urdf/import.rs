//! From a URDF to a robot description.

use std::ops::Range;

use indexmap::IndexMap;
use nalgebra::{Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};
use urdf_rs::JointType;

use super::khalil_kleinfinger::{
    Isometry, about_x, about_y, about_z, clean, clean_angle, khalil_kleinfinger, screw_z, shift_to_normal,
};
use super::locate::{self, Survey};
use super::outline;
use super::source::{Diagnostics, Source};
use super::tree::{Tree, tree};
use crate::description::raw::{JointKind, RawBody, RawFrame, RawRobot, RawTool};
use crate::description::robot::Constants;
use crate::diagnostic::Diagnostic;

/// An angle of roll, pitch or yaw of at most twelve decimals that is this near to a multiple of 90 degrees is taken to be
/// that: pi/2 is often written with eleven decimals (5e-12).
const QUARTER: f64 = 6e-12;

/// Leaf links or joints taken for the tool when there are several leaves, the likeliest first.
const TOOLS: [&str; 9] =
    ["tcp", "tool0", "tool", "tool_center_point", "tool_link", "ee_link", "end_effector", "ee", "flange"];

/// Reads a URDF: `text` is its text, `file` the name shown in diagnostics.
///
/// The description is in SI units. Each joint becomes a frame of its name, each link's mass a body of that frame. A
/// mimicking joint becomes a coupling, its offset going into the frame's theta or r; every other moving joint gets a
/// variable of its own name, counted as the URDF does, with its limits. The tool is the only
/// link that carries nothing, or the one named like a tool. Inertia tensors, shapes, transmissions and the mass of the
/// base, which does not move, are not read.
///
/// With the description come warnings.
///
/// # Errors
///
/// Every fault of the file, each with its place, and the warnings too: malformed XML, xacro that has not been run, missing
/// or malformed attributes, unknown or repeated names, links that do not form one tree, joints of an unsupported type,
/// circles of mimicking joints, a file of more than 20 MB.
pub fn import(file: &str, text: &str) -> Result<(RawRobot, Vec<Diagnostic>), Vec<Diagnostic>> {
    let source = Source::new(file, text.strip_prefix('\u{feff}').unwrap_or(text));
    outline::outline(&source).map_err(|diagnostic| vec![*diagnostic])?;
    let document = outline::parse(&source).map_err(|diagnostic| vec![*diagnostic])?;
    let mut diagnostics = Diagnostics::default();
    let survey = locate::survey(&source, &document, &mut diagnostics);
    let hangs = if survey.links.is_empty() && diagnostics.has_error() {
        None
    } else {
        tree(&source, &survey, &mut diagnostics)
    };
    let Some(tree) = hangs.filter(|_| !diagnostics.has_error()) else { return Err(diagnostics.finish()) };
    let read = urdf_rs::read_from_string(&blanked(source.text(), &survey.blank)).map_err(|error| error.to_string());
    let whole =
        |read: &urdf_rs::Robot| read.links.len() == survey.links.len() && read.joints.len() == survey.joints.len();
    match read {
        Ok(model) if whole(&model) => {
            let mut robot =
                Builder { source: &source, survey: &survey, tree: &tree, model: &model, diagnostics }.robot();
            robot.0.robot = (!survey.name.is_empty()).then(|| survey.name.to_owned());
            Ok((robot.0, robot.1.finish()))
        }
        other => {
            let why = other.err().unwrap_or_else(|| "links or joints are lost".to_owned());
            diagnostics
                .push(Diagnostic::error(format!("the file cannot be read as URDF: {why}")).at(source.place(0..0)));
            Err(diagnostics.finish())
        }
    }
}

/// The text with blanks for elements that are not read, so that they cannot stop the model reader.
fn blanked(text: &str, ranges: &[Range<usize>]) -> String {
    let mut ranges = ranges.to_vec();
    ranges.sort_by_key(|range| range.start);
    let (mut kept, mut at) = (String::with_capacity(text.len()), 0);
    for range in ranges {
        kept.push_str(text.get(at..range.start).unwrap_or(""));
        kept.push(' ');
        at = at.max(range.end);
    }
    kept.push_str(text.get(at..).unwrap_or(""));
    kept
}

struct Builder<'s> {
    source: &'s Source<'s>,
    survey: &'s Survey<'s>,
    tree: &'s Tree,
    model: &'s urdf_rs::Robot,
    diagnostics: Diagnostics,
}

// Positions come from the survey of the same file; `import` has checked that the model has as many links and joints.
impl<'s> Builder<'s> {
    fn robot(mut self) -> (RawRobot, Diagnostics) {
        let mut robot = RawRobot::default();
        // Per link: the frame it moves with, and that frame's pose in the link.
        let mut carriers = vec![("0", Isometry::identity()); self.survey.links.len()];
        let mut open = vec![self.tree.root];
        while let Some(link) = open.pop() {
            for &joint in &self.tree.leaving[link] {
                let child = self.tree.carries[joint];
                let (antecedent, parent) = carriers[link];
                let own = self.own_frame(joint);
                let constants = khalil_kleinfinger(&(parent.inverse() * self.placed(joint) * own));
                self.warn_of_tilt(joint, antecedent, &constants);
                robot.frames.insert(self.name(joint).to_owned(), self.frame(joint, antecedent, constants));
                carriers[child] = (self.name(joint), own);
                robot.couplings.extend(self.coupling(joint));
                self.body(child, self.name(joint), &own, &mut robot.bodies);
            }
            open.extend(self.tree.leaving[link].iter().rev().map(|&joint| self.tree.carries[joint]));
        }
        robot.tool = self.tool(&carriers);
        (robot, self.diagnostics)
    }

    fn name(&self, joint: usize) -> &'s str {
        self.survey.joints[joint].name.as_ref().map_or("", |name| name.text)
    }

    fn fixed(&self, joint: usize) -> bool {
        self.model.joints[joint].joint_type == JointType::Fixed
    }

    /// The child link's pose in the parent link at joint value zero.
    fn placed(&self, joint: usize) -> Isometry {
        let origin = &self.model.joints[joint].origin;
        let [roll, pitch, yaw] = if self.survey.kept { origin.rpy.0 } else { origin.rpy.0.map(quarter) };
        let [x, y, z] = origin.xyz.0;
        Isometry::from_parts(Translation3::new(x, y, z), about_z(yaw) * about_y(pitch) * about_x(roll))
    }

    /// Sense of the joint about or along z of its frame: +1, but where the link frame is kept and z is against the axis.
    fn direction(&self, joint: usize) -> f64 {
        let [x, y, z] = self.model.joints[joint].axis.xyz.0;
        if self.survey.kept && !self.fixed(joint) && x == 0.0 && y == 0.0 && z < 0.0 { -1.0 } else { 1.0 }
    }

    /// A frame in the child link with z along the joint's axis: the link's own frame turned the shortest way.
    fn axis_frame(&self, joint: usize) -> Isometry {
        let axis = self.model.joints[joint].axis.xyz.0.map(|coordinate| coordinate * self.direction(joint));
        let turn = if self.fixed(joint) { Rotation3::identity() } else { towards(axis) };
        Isometry::from_parts(Translation3::identity(), turn)
    }

    /// The frame of a joint in its child link: the link's frame for a fixed joint, else on the joint's axis, where the
    /// common normal with the first moving joint that follows meets it (unless the file asks to keep its link frames).
    fn own_frame(&self, joint: usize) -> Isometry {
        let frame = self.axis_frame(joint);
        if self.fixed(joint) || self.survey.kept {
            return frame;
        }
        let leaving = &self.tree.leaving[self.tree.carries[joint]];
        let Some(&next) = leaving.iter().find(|&&next| !self.fixed(next)) else { return frame };
        let (turn, slide) = shift_to_normal(&(frame.inverse() * self.placed(next) * self.axis_frame(next)));
        frame * screw_z(turn, slide)
    }

    fn frame(&self, joint: usize, antecedent: &str, constants: Constants) -> RawFrame {
        let Constants { beta, gamma, b, alpha, d, mut theta, mut r } = constants;
        let model = &self.model.joints[joint];
        let kind = match model.joint_type {
            JointType::Fixed => JointKind::Fixed,
            JointType::Prismatic => JointKind::Prismatic,
            _ => JointKind::Revolute,
        };
        let (direction, (_, offset)) = (self.direction(joint), self.follows(joint));
        let offset = direction * offset;
        match kind {
            JointKind::Prismatic => r = clean(r + offset, 1.0 + r.abs()),
            _ => theta = if offset == 0.0 { theta } else { clean_angle(theta + offset) },
        }
        let limited =
            self.survey.joints[joint].limited && matches!(model.joint_type, JointType::Revolute | JointType::Prismatic);
        let mut bounds = [model.limit.lower, model.limit.upper];
        if self.tree.mimics[joint].is_some() {
            // Without a variable of its own, they bound what is added to theta or r.
            let [lower, upper] = bounds.map(|bound| direction * bound - offset);
            bounds = [lower.min(upper), lower.max(upper)];
        }
        let some = |value: f64| (value != 0.0).then_some(value);
        RawFrame {
            antecedent: Some(antecedent.to_owned()),
            joint: Some(kind),
            variable: (kind != JointKind::Fixed && self.tree.mimics[joint].is_none())
                .then(|| self.name(joint).to_owned()),
            direction: (direction < 0.0).then_some(direction),
            beta: some(beta),
            gamma: some(gamma),
            b: some(b),
            alpha: some(alpha),
            d: some(d),
            theta: some(theta),
            r: some(r),
            limits: (limited && bounds.iter().all(|bound| bound.is_finite())).then_some(bounds),
            ..RawFrame::default()
        }
    }

    /// How a joint follows the joint at the end of its chain of mimics: factor and offset.
    fn follows(&self, joint: usize) -> (f64, f64) {
        let (mut factor, mut offset, mut at) = (1.0, 0.0, joint);
        while let Some(master) = self.tree.mimics[at] {
            let mimic = self.model.joints[at].mimic.as_ref();
            offset += factor * mimic.and_then(|mimic| mimic.offset).unwrap_or(0.0);
            factor *= mimic.and_then(|mimic| mimic.multiplier).unwrap_or(1.0);
            at = master;
        }
        (factor, offset)
    }

    fn coupling(&self, joint: usize) -> Option<String> {
        let mut master = self.tree.mimics[joint]?;
        while let Some(next) = self.tree.mimics[master] {
            master = next;
        }
        let factor = self.follows(joint).0 * self.direction(joint) * self.direction(master);
        Some(format!("{} = {factor} * {}", self.name(joint), self.name(master)))
    }

    fn body(&self, link: usize, frame: &str, own: &Isometry, bodies: &mut IndexMap<String, RawBody>) {
        let inertial = &self.model.links[link].inertial;
        if inertial.mass.value == 0.0 {
            return;
        }
        let [x, y, z] = inertial.origin.xyz.0;
        let centre = own.inverse() * nalgebra::Point3::new(x, y, z);
        let scale = 1.0 + centre.coords.norm() + own.translation.vector.norm();
        let com = [centre.x, centre.y, centre.z].map(|coordinate| clean(coordinate, scale));
        let com = (com != [0.0; 3]).then_some(com);
        bodies.insert(frame.to_owned(), RawBody { mass: Some(inertial.mass.value), com });
    }

    fn warn_of_tilt(&mut self, joint: usize, antecedent: &str, constants: &Constants) {
        let Some(name) = self.survey.joints[joint].name.as_ref() else { return };
        if constants.beta == 0.0 || self.fixed(joint) {
            return;
        }
        let z = constants.isometry().rotation.matrix().column(2).into_owned();
        let tilt = z.x.hypot(z.y).asin();
        let message = format!("the axis of `{}` is {tilt:.1e} rad from parallel to that of `{antecedent}`", name.text);
        let diagnostic = Diagnostic::warning(message).at(self.source.place(name.at.clone()));
        self.diagnostics.push(
            diagnostic
                .remedy("kept as written, with `beta`; if they are parallel, write pi in full (3.141592653589793)"),
        );
    }

    fn tool(&mut self, carriers: &[(&str, Isometry)]) -> RawTool {
        let moved = self.moved();
        let leaves = |moved: &dyn Fn(usize) -> bool| -> Vec<usize> {
            let arrivals = self.tree.carries.iter().enumerate();
            arrivals
                .filter(|&(joint, &link)| self.tree.leaving[link].is_empty() && moved(joint))
                .map(|(joint, _)| joint)
                .collect()
        };
        let mut ends = leaves(&|joint| moved[joint]);
        if ends.is_empty() {
            ends = leaves(&|_| true);
        }
        let chosen = match ends.as_slice() {
            &[only] => only,
            several => {
                let link = |joint: usize| {
                    self.survey.links[self.tree.carries[joint]].name.as_ref().map_or("", |name| name.text)
                };
                let called = |joint: usize, tool: &str| {
                    link(joint).eq_ignore_ascii_case(tool) || self.name(joint).eq_ignore_ascii_case(tool)
                };
                let chosen = TOOLS.iter().find_map(|tool| several.iter().copied().find(|&joint| called(joint, tool)));
                let shown: Vec<String> =
                    several.iter().take(12).map(|&joint| format!("`{}`", self.name(joint))).collect();
                let more = if several.len() > 12 { ", ..." } else { "" };
                let message = format!("several links carry nothing; their frames are {}{more}", shown.join(", "));
                let diagnostic = Diagnostic::warning(message).remedy(match chosen {
                    Some(joint) => format!("`{}` is taken for the tool", self.name(joint)),
                    None => "say which is the tool: `tool: {frame: ...}`".to_owned(),
                });
                self.diagnostics.push(diagnostic);
                let Some(chosen) = chosen else { return RawTool::default() };
                chosen
            }
        };
        let (frame, own) = &carriers[self.tree.carries[chosen]];
        let back = own.inverse();
        let at = back.translation.vector.map(|length| clean(length, 1.0 + own.translation.vector.norm()));
        let rotation = UnitQuaternion::from_rotation_matrix(&back.rotation).scaled_axis().map(clean_angle);
        let some = |vector: Vector3<f64>| (vector != Vector3::zeros()).then_some([vector.x, vector.y, vector.z]);
        RawTool { frame: Some((*frame).to_owned()), at: some(at), rotation: some(rotation) }
    }

    /// Per joint: whether what it carries can move.
    fn moved(&self) -> Vec<bool> {
        let mut moved = vec![false; self.survey.joints.len()];
        let mut open = vec![(self.tree.root, false)];
        while let Some((link, moving)) = open.pop() {
            for &joint in &self.tree.leaving[link] {
                moved[joint] = moving || !self.fixed(joint);
                open.push((self.tree.carries[joint], moved[joint]));
            }
        }
        moved
    }
}

/// The multiple of 90 degrees that was meant.
fn quarter(angle: f64) -> f64 {
    let exact = (angle / std::f64::consts::FRAC_PI_2).round() * std::f64::consts::FRAC_PI_2;
    let short = (angle * 1e12).round() / 1e12 == angle;
    if short && exact != 0.0 && (angle - exact).abs() <= QUARTER { exact } else { angle }
}

/// The shortest rotation of z to this direction, which is not zero.
fn towards(direction: [f64; 3]) -> Rotation3<f64> {
    let axis = Vector3::from(direction).normalize();
    if axis.z < -0.5 {
        // By half a turn about x first: the shortest rotation is ill-defined near -z.
        return about_x(std::f64::consts::PI) * towards([axis.x, -axis.y, -axis.z]);
    }
    // Rodrigues' formula about z x axis.
    let (x, y, z) = (axis.x, axis.y, axis.z);
    let share = 1.0 / (1.0 + z);
    let matrix =
        Matrix3::new(1.0 - x * x * share, -x * y * share, x, -x * y * share, 1.0 - y * y * share, y, -x, -y, z);
    Rotation3::from_matrix_unchecked(matrix)
}

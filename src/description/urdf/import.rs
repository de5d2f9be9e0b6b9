//! From a URDF to a robot description.

use indexmap::IndexMap;
use nalgebra::{Point3, UnitQuaternion, Vector3};

use super::chain::{Chain, Request, chain};
use super::elements::{Kind, Survey, survey};
use super::motion::{Isometry, moved, placed, towards};
use super::source::Source;
use super::tree::{Tree, tree};
use crate::description::columns::OWNERS;
use crate::description::khalil_kleinfinger::{clean, clean_angle, khalil_kleinfinger, screw_z, shift_to_normal};
use crate::description::raw::{JointKind, RawBody, RawFrame, RawRobot, RawTool, RawUrdf};
use crate::description::robot::Constants;
use crate::description::units::Units;
use crate::diagnostic::Diagnostic;

/// Leaf links or joints taken for the tool when there are several leaves, the likeliest first.
const TOOLS: [&str; 9] =
    ["tcp", "tool0", "tool", "tool_center_point", "tool_link", "ee_link", "end_effector", "ee", "flange"];

/// What a URDF gives.
#[derive(Debug, Clone)]
pub struct Imported {
    /// The description, in SI units.
    pub robot: RawRobot,
    /// A fixed frame for each link, where the file has the link's frame, SI; not for those that bear a joint's name.
    pub link_frames: IndexMap<String, RawFrame>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// Reads a whole URDF: `text` is its text, `file` the name shown in diagnostics.
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
    let (keys, units) = (RawUrdf::default(), Units::default());
    let Imported { robot, diagnostics, .. } =
        import_chain(file, text, &Request { keys: &keys, units, weighed: &[], locate: &|_| None })?;
    Ok((robot, diagnostics))
}

/// Reads of a URDF the chain between two links; without `from` and `to` as [`import`] does.
///
/// With `to`, only joints that move become frames, and the tool is the frame of that link. Joints off the chain are held
/// at what `fixed` says, or at zero (the nearest limit where zero is outside); what they carry weighs on the frame it is
/// attached to. Joints that follow one of the chain move with it. Gravity is that of the file's base link.
///
/// # Errors
///
/// As [`import`], and every fault of the request.
pub fn import_chain(file: &str, text: &str, request: &Request) -> Result<Imported, Vec<Diagnostic>> {
    built(file, text, request, |builder, _| builder.links()).map(|(robot, link_frames, diagnostics)| Imported {
        robot,
        link_frames,
        diagnostics,
    })
}

/// A description of the file, and what is made of its builder.
pub(super) fn built<T>(
    file: &str,
    text: &str,
    request: &Request,
    make: impl FnOnce(&Builder, &RawRobot) -> T,
) -> Result<(RawRobot, T, Vec<Diagnostic>), Vec<Diagnostic>> {
    let mut source = Source::new(file, text);
    let Some(document) = source.parse() else { return Err(source.finish()) };
    let survey = survey(&mut source, &document);
    let nothing = survey.links.is_empty() && source.count() > 0;
    let tree = if nothing { None } else { tree(&mut source, &survey) };
    let chain = tree.as_ref().and_then(|tree| chain(&mut source, &survey, tree, request));
    let (Some(tree), Some(chain)) = (&tree, chain) else { return Err(source.finish()) };
    let carriers = vec![None; survey.links.len()];
    let faults = source.count();
    let mut builder = Builder {
        source: &mut source,
        survey: &survey,
        tree,
        chain,
        carriers,
        tool_joint: None,
        weighed: request.weighed,
    };
    let robot = builder.robot();
    let made = make(&builder, &robot);
    if source.count() > faults {
        return Err(source.finish());
    }
    Ok((robot, made, source.finish()))
}

/// Makes the description; holds which frame carries each link.
pub(super) struct Builder<'b, 'a> {
    source: &'b mut Source<'a>,
    pub(super) survey: &'b Survey<'a>,
    pub(super) tree: &'b Tree,
    pub(super) chain: Chain,
    /// Per link of the part that is read: the frame it moves with, and that frame's pose in the link.
    pub(super) carriers: Vec<Option<(&'a str, Isometry)>>,
    /// The joint that carries the tool's link.
    pub(super) tool_joint: Option<usize>,
    weighed: &'b [&'b str],
}

// Positions are those of the survey.
impl<'a> Builder<'_, 'a> {
    fn robot(&mut self) -> RawRobot {
        let name = self.survey.name;
        let robot = (!name.is_empty()).then(|| name.to_owned());
        let mut robot = RawRobot { robot, gravity: self.chain.gravity, ..RawRobot::default() };
        self.carriers[self.chain.root] = Some(("0", Isometry::identity()));
        let mut open = vec![self.chain.root];
        while let Some(link) = open.pop() {
            for &joint in &self.tree.leaving[link] {
                let (child, name) = (self.tree.carries[joint], self.survey.joint(joint));
                let Some((antecedent, parent)) = self.carriers[link] else { continue };
                self.carriers[child] = Some(if let Some(value) = self.chain.held[joint] {
                    (antecedent, self.displaced(joint, value).inverse() * parent)
                } else {
                    let own = self.own_frame(joint);
                    let constants = khalil_kleinfinger(&(parent.inverse() * self.displaced(joint, 0.0) * own));
                    self.refuse_owner(joint);
                    self.warn_of_tilt(joint, antecedent, &constants);
                    robot.frames.insert(name.to_owned(), self.frame(joint, antecedent, constants));
                    robot.couplings.extend(self.coupling(joint));
                    (name, own)
                });
                self.weigh(child, &mut robot.bodies);
            }
            open.extend(self.tree.leaving[link].iter().rev().map(|&joint| self.tree.carries[joint]));
        }
        robot.tool = self.tool();
        robot
    }

    /// A fixed frame for each link that is read; one whose name a joint has that becomes a frame itself is not it.
    fn links(&self) -> IndexMap<String, RawFrame> {
        let links = self.carriers.iter().enumerate();
        let links = links.filter_map(|(link, carrier)| Some((self.survey.link(link), carrier.as_ref()?)));
        let links = links.filter(|(link, _)| *link != "0");
        links
            .map(|(link, (frame, pose))| (link.to_owned(), fixed(frame, khalil_kleinfinger(&pose.inverse()))))
            .collect()
    }

    fn fixed(&self, joint: usize) -> bool {
        self.survey.joints[joint].kind == Kind::Fixed
    }

    /// The child link's pose in the parent link.
    pub(super) fn displaced(&self, joint: usize, value: f64) -> Isometry {
        let joint = &self.survey.joints[joint];
        let placed = placed(joint, self.survey.kept);
        if value == 0.0 { placed } else { placed * moved(joint, value) }
    }

    /// Sense of the joint about or along z of its frame: +1, but where the link frame is kept and z is against the axis.
    pub(super) fn direction(&self, joint: usize) -> f64 {
        let [x, y, z] = self.survey.joints[joint].axis;
        if self.survey.kept && !self.fixed(joint) && x == 0.0 && y == 0.0 && z < 0.0 { -1.0 } else { 1.0 }
    }

    /// A frame in the child link with z along the joint's axis: the link's own frame turned the shortest way.
    fn axis_frame(&self, joint: usize) -> Isometry {
        if self.fixed(joint) {
            return Isometry::identity();
        }
        let axis = self.survey.joints[joint].axis.map(|coordinate| coordinate * self.direction(joint));
        Isometry::from_parts(Vector3::zeros().into(), towards(axis))
    }

    /// The frame of a joint in its child link: the link's frame for a fixed joint, else on the joint's axis, where the
    /// common normal with the first moving joint that follows meets it (unless the file asks to keep its link frames).
    fn own_frame(&self, joint: usize) -> Isometry {
        let frame = self.axis_frame(joint);
        if self.fixed(joint) || self.survey.kept {
            return frame;
        }
        let (mut link, mut reached) = (self.tree.carries[joint], frame.inverse());
        // Through joints that are held.
        loop {
            let leaving = self.tree.leaving[link].iter().copied();
            let mut leaving = leaving.filter(|&next| self.chain.within[next]);
            let held = |next: usize| self.chain.held[next];
            if let Some(next) = leaving.clone().find(|&next| !self.fixed(next) && held(next).is_none()) {
                let (turn, slide) = shift_to_normal(&(reached * self.displaced(next, 0.0) * self.axis_frame(next)));
                return frame * screw_z(turn, slide);
            }
            let Some((next, value)) = leaving.find_map(|next| Some((next, held(next)?))) else { return frame };
            reached *= self.displaced(next, value);
            link = self.tree.carries[next];
        }
    }

    fn frame(&self, joint: usize, antecedent: &str, constants: Constants) -> RawFrame {
        let Constants { mut theta, mut r, .. } = constants;
        let kind = match self.survey.joints[joint].kind {
            Kind::Fixed => JointKind::Fixed,
            Kind::Prismatic => JointKind::Prismatic,
            Kind::Revolute | Kind::Continuous => JointKind::Revolute,
        };
        let (direction, offset) = (self.direction(joint), self.direction(joint) * self.follows(joint).1);
        match kind {
            JointKind::Prismatic => r = clean(r + offset, 1.0 + r.abs()),
            _ => theta = if offset == 0.0 { theta } else { clean_angle(theta + offset) },
        }
        let follows = self.tree.mimics[joint].is_some();
        let mut bounds = self.survey.joints[joint].limits;
        if follows {
            // Without a variable of its own, they bound what is added to theta or r.
            bounds = bounds.map(|bounds| bounds.map(|bound| direction * bound - offset));
            bounds = bounds.map(|[a, b]| [a.min(b), a.max(b)]);
        }
        RawFrame {
            joint: Some(kind),
            variable: (kind != JointKind::Fixed && !follows).then(|| self.survey.joint(joint).to_owned()),
            direction: (direction < 0.0).then_some(direction),
            limits: bounds,
            ..fixed(antecedent, Constants { theta, r, ..constants })
        }
    }

    /// How a joint follows the joint at the end of its chain of mimics: factor and offset.
    pub(super) fn follows(&self, joint: usize) -> (f64, f64) {
        let (mut factor, mut offset, mut at) = (1.0, 0.0, joint);
        while let (Some(master), Some(mimic)) = (self.tree.mimics[at], &self.survey.joints[at].mimic) {
            offset += factor * mimic.offset;
            factor *= mimic.multiplier;
            at = master;
        }
        (factor, offset)
    }

    /// The joint at the end of its chain of mimics.
    pub(super) fn master(&self, joint: usize) -> usize {
        std::iter::successors(Some(joint), |&at| self.tree.mimics[at]).last().unwrap_or(joint)
    }

    fn coupling(&self, joint: usize) -> Option<String> {
        self.tree.mimics[joint]?;
        let master = self.master(joint);
        let factor = self.follows(joint).0 * self.direction(joint) * self.direction(master);
        Some(format!("{} = {factor} * {}", self.survey.joint(joint), self.survey.joint(master)))
    }

    /// Mass of a link and its centre in the axes of the frame that carries it.
    pub(super) fn weight(&self, link: usize) -> Option<(f64, Vector3<f64>)> {
        let (_, pose) = self.carriers[link].as_ref()?;
        let centre = pose.inverse() * Point3::from(self.survey.links[link].com);
        Some((self.survey.links[link].mass, centre.coords))
    }

    /// Adds the mass of a link to the body of the frame that carries it.
    fn weigh(&self, link: usize, bodies: &mut IndexMap<String, RawBody>) {
        let (Some((frame, pose)), Some((mass, centre))) = (self.carriers[link], self.weight(link)) else { return };
        if mass == 0.0 || frame == "0" || self.weighed.contains(&self.survey.link(link)) {
            return;
        }
        let body = bodies.entry(frame.to_owned()).or_default();
        let before = body.mass.unwrap_or(0.0);
        let total = before + mass;
        let com = (Vector3::from(body.com.unwrap_or_default()) * before + centre * mass) / total;
        let com = if before == 0.0 { centre } else { com };
        let scale = 1.0 + centre.norm() + pose.translation.vector.norm();
        let com = [com.x, com.y, com.z].map(|coordinate| clean(coordinate, scale));
        *body = RawBody { mass: Some(total), com: (com != [0.0; 3]).then_some(com) };
    }

    fn warn_of_tilt(&mut self, joint: usize, antecedent: &str, constants: &Constants) {
        let Some(name) = self.survey.joints[joint].name.as_ref() else { return };
        if constants.beta == 0.0 || self.fixed(joint) {
            return;
        }
        let z = constants.isometry().rotation.matrix().column(2).into_owned();
        let tilt = z.x.hypot(z.y).asin();
        let message = format!("the axis of `{}` is {tilt:.1e} rad from parallel to that of `{antecedent}`", name.text);
        let remedy = "kept as written, with `beta`; if they are parallel, write pi in full (3.141592653589793)";
        self.source.warn(name.at.clone(), message, remedy);
    }

    fn tool(&mut self) -> RawTool {
        let link = match self.chain.end {
            Some(end) => Some(end),
            None => self.likeliest_tool().map(|joint| self.tree.carries[joint]),
        };
        let Some((link, (frame, own))) = link.and_then(|link| Some((link, self.carriers[link]?))) else {
            return RawTool::default();
        };
        self.tool_joint = self.tree.above[link].map(|(joint, _)| joint);
        let back = own.inverse();
        let at = back.translation.vector.map(|length| clean(length, 1.0 + own.translation.vector.norm()));
        let rotation = UnitQuaternion::from_rotation_matrix(&back.rotation).scaled_axis().map(clean_angle);
        let some = |vector: Vector3<f64>| (vector != Vector3::zeros()).then_some([vector.x, vector.y, vector.z]);
        RawTool { frame: Some(frame.to_owned()), at: some(at), rotation: some(rotation) }
    }

    /// The joint that carries the only end, or the end that is called a tool.
    fn likeliest_tool(&mut self) -> Option<usize> {
        let joints = self.tree.carries.iter().enumerate();
        let ends = joints.filter(|&(_, &link)| self.carriers[link].is_some() && self.tree.leaving[link].is_empty());
        let ends: Vec<usize> = ends.map(|(joint, _)| joint).collect();
        let moving = ends.iter().copied().filter(|&joint| self.moves(joint)).collect::<Vec<_>>();
        let ends = if moving.is_empty() { ends } else { moving };
        if let &[only] = ends.as_slice() {
            return Some(only);
        }
        // A link that is called a tool is one even where something hangs on it.
        let called = |joint: usize| self.called_tool(joint);
        let chosen = ends.iter().copied().filter(|&joint| called(joint).is_some()).min_by_key(|&joint| called(joint));
        let others = (0..self.survey.joints.len()).filter(|&joint| self.carriers[self.tree.carries[joint]].is_some());
        let chosen =
            chosen.or_else(|| others.filter(|&joint| called(joint).is_some()).min_by_key(|&joint| called(joint)));
        let shown: Vec<String> = ends.iter().take(12).map(|&joint| format!("`{}`", self.survey.joint(joint))).collect();
        let more = if ends.len() > 12 { ", ..." } else { "" };
        let message = format!("several links carry nothing; their frames are {}{more}", shown.join(", "));
        let remedy = match chosen {
            Some(joint) => format!("`{}` is taken for the tool", self.survey.joint(joint)),
            None => {
                "say which is the tool: `tool: {frame: ...}`, or the chain: `urdf: {file: .., to: LINK}`".to_owned()
            }
        };
        self.source.doubt(|_| Diagnostic::warning(message).remedy(remedy));
        chosen
    }

    /// An error where a frame would bear the name of what is no element.
    fn refuse_owner(&mut self, joint: usize) {
        let Some(name) = self.survey.joints[joint].name.as_ref().filter(|name| OWNERS.contains(&name.text)) else {
            return;
        };
        let message = format!("`{}` cannot be the name of a frame: parameters of the {0} have it", name.text);
        let remedy = match self.fixed(joint) {
            true => "rename the joint; or read the joints that move alone, by `urdf: {file: .., from: LINK, to: LINK}`",
            false => "rename the joint",
        };
        self.source.error(name.at.clone(), message, remedy);
    }

    /// How likely the link that a joint carries is the tool by its name or the joint's: the less the likelier.
    pub(super) fn called_tool(&self, joint: usize) -> Option<usize> {
        let names = [self.survey.link(self.tree.carries[joint]), self.survey.joint(joint)];
        TOOLS.iter().position(|tool| names.iter().any(|name| name.eq_ignore_ascii_case(tool)))
    }

    /// Whether what a joint carries moves with a frame that can move.
    fn moves(&self, joint: usize) -> bool {
        let mut at = Some(joint);
        while let Some(joint) = at {
            if !self.fixed(joint) && self.chain.held[joint].is_none() {
                return true;
            }
            let (_, parent) = self.tree.above[self.tree.carries[joint]].unwrap_or_default();
            at = self.tree.above[parent].map(|(joint, _)| joint).filter(|_| parent != self.chain.root);
        }
        false
    }
}

/// A fixed frame of these constants; those that are zero are not written.
fn fixed(antecedent: &str, Constants { beta, gamma, b, alpha, d, theta, r }: Constants) -> RawFrame {
    let some = |value: f64| (value != 0.0).then_some(value);
    RawFrame {
        antecedent: Some(antecedent.to_owned()),
        joint: Some(JointKind::Fixed),
        beta: some(beta),
        gamma: some(gamma),
        b: some(b),
        alpha: some(alpha),
        d: some(d),
        theta: some(theta),
        r: some(r),
        ..RawFrame::default()
    }
}

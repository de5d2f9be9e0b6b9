//! Which part of a URDF is the robot: the chain from link to link, and at what values all other joints are held.

use nalgebra::Vector3;

use super::elements::{Joint, Kind, Survey};
use super::motion::{Isometry, moved, placed};
use super::source::Source;
use super::tree::Tree;
use crate::description::raw::RawUrdf;
use crate::description::units::Units;
use crate::diagnostic::{Diagnostic, Locate, nearest};

/// What is asked of a URDF: the keys of `urdf:` in a description, where they stand, and the units of `fixed`.
pub struct Request<'r> {
    /// The keys.
    pub keys: &'r RawUrdf,
    /// Units of the values of `fixed`.
    pub units: Units,
    /// Links whose mass the description gives itself.
    pub weighed: &'r [&'r str],
    /// Where each path of the description stands.
    pub locate: Locate<'r>,
}

/// The part of the tree that is the robot.
pub(super) struct Chain {
    /// The link that is frame 0.
    pub(super) root: usize,
    /// The link that carries the tool, where one is asked for.
    pub(super) end: Option<usize>,
    /// Per joint: the value at which it is held; `None` where it becomes a frame.
    pub(super) held: Vec<Option<f64>>,
    /// Per joint: whether it lies between `from` and `to`, or, where no `to` is given, anywhere beyond `from`.
    pub(super) within: Vec<bool>,
    /// Gravity in the axes of the base, where these are not those of the file's own base link.
    pub(super) gravity: Option<[f64; 3]>,
}

/// The chain that is asked for. `None` after an error.
pub(super) fn chain(source: &mut Source, survey: &Survey, tree: &Tree, request: &Request) -> Option<Chain> {
    let finder = Finder { survey, tree, request };
    let (from, to) = (&request.keys.from, &request.keys.to);
    let root = from.as_deref().map_or(Some(tree.root), |name| finder.link(name, "from", source));
    let end = to.as_deref().map_or(Some(None), |name| finder.link(name, "to", source).map(Some));
    let fixed = finder.fixed(source);
    let (root, end) = (root?, end?);
    let carried =
        |joint: usize| root == tree.root || finder.upwards(tree.carries[joint]).skip(1).any(|link| link == root);
    let mut within: Vec<bool> = (0..survey.joints.len()).map(|joint| end.is_none() && carried(joint)).collect();
    if let Some(end) = end {
        for joint in finder.between(root, end, source)? {
            within[joint] = true;
        }
    }
    let mut chain = Chain { root, end, held: fixed, within, gravity: None };
    let held: Vec<Option<f64>> = (0..survey.joints.len()).map(|joint| finder.held(joint, &chain)).collect();
    chain.held = held;
    let moves = |joint: usize| chain.held[joint].is_none() && survey.joints[joint].kind != Kind::Fixed;
    if end.is_some() && !(0..survey.joints.len()).any(|joint| chain.within[joint] && moves(joint)) {
        let (from, to) = (survey.link(root), survey.link(chain.end?));
        let diagnostic = Diagnostic::error(format!("no joint moves between the links `{from}` and `{to}`"));
        let remedy = "let `from` and `to` be the two ends of the arm, and no joint of it be held by `fixed`";
        source.report(|_| diagnostic.at((request.locate)(&["urdf", "to"])).remedy(remedy));
    }
    let mut pose = Isometry::identity();
    let mut at = root;
    while let Some((joint, parent)) = tree.above[at] {
        let value = chain.held[joint].unwrap_or(0.0);
        pose = placed(&survey.joints[joint], survey.kept) * moved(&survey.joints[joint], value) * pose;
        at = parent;
    }
    let down = pose.rotation.inverse() * Vector3::new(0.0, 0.0, -9.81);
    chain.gravity = (down.xy().norm() > 1e-9 || down.z > 0.0).then_some(down.into());
    (source.count() == 0).then_some(chain)
}

struct Finder<'f> {
    survey: &'f Survey<'f>,
    tree: &'f Tree,
    request: &'f Request<'f>,
}

impl Finder<'_> {
    fn link(&self, name: &str, key: &str, source: &mut Source) -> Option<usize> {
        let found = (0..self.survey.links.len()).find(|&link| self.survey.link(link) == name);
        if found.is_none() {
            let place = (self.request.locate)(&["urdf", key]);
            let links = || (0..self.survey.links.len()).map(|link| self.survey.link(link));
            let joint = (0..self.survey.joints.len()).find(|&joint| self.survey.joint(joint) == name);
            source.report(|_| {
                let diagnostic = Diagnostic::error(format!("`{key}: {name}`: the URDF has no link `{name}`")).at(place);
                match joint.filter(|_| nearest(name, links()).is_none()) {
                    Some(joint) => {
                        let link = self.survey.link(self.tree.carries[joint]);
                        diagnostic.remedy(format!("`{name}` is a joint; the link that it carries is `{link}`"))
                    }
                    None => diagnostic.suggest(name, links()),
                }
            });
        }
        found
    }

    /// The links from this one up to the base of the file.
    fn upwards(&self, link: usize) -> impl Iterator<Item = usize> {
        std::iter::successors(Some(link), |&link| self.tree.above[link].map(|(_, parent)| parent))
    }

    /// The joints from `from` to `to`, which it must carry.
    fn between(&self, from: usize, to: usize, source: &mut Source) -> Option<Vec<usize>> {
        if self.upwards(to).any(|link| link == from) {
            let links = self.upwards(to).take_while(|&link| link != from);
            return Some(links.filter_map(|link| self.tree.above[link]).map(|(joint, _)| joint).collect());
        }
        let (first, last) = (self.survey.link(from), self.survey.link(to));
        let remedy = if self.upwards(from).any(|link| link == to) {
            format!("it is the other way round: write `from: {last}, to: {first}`")
        } else {
            let common = self.upwards(from).find(|&link| self.upwards(to).any(|other| other == link));
            let common = common.map_or("", |link| self.survey.link(link));
            format!(
                "the link that carries both is `{common}`: begin there with `from: {common}`, or with a later link of the arm"
            )
        };
        let message = format!("the link `{first}` does not carry the link `{last}`");
        source.report(|_| Diagnostic::error(message).at((self.request.locate)(&["urdf", "from"])).remedy(remedy));
        None
    }

    /// The values asked for, SI, by joint.
    fn fixed(&self, source: &mut Source) -> Vec<Option<f64>> {
        let mut values = vec![None; self.survey.joints.len()];
        for (name, &value) in &self.request.keys.fixed {
            let place = (self.request.locate)(&["urdf", "fixed", name]);
            let Some(index) = (0..values.len()).find(|&joint| self.survey.joint(joint) == name) else {
                let moving = self.survey.joints.iter().filter(|joint| joint.kind != Kind::Fixed);
                let names = moving.filter_map(|joint| joint.name.as_ref()).map(|name| name.text);
                let diagnostic = Diagnostic::error(format!("`fixed`: the URDF has no joint `{name}`")).at(place);
                source.report(|_| diagnostic.suggest(name, names));
                continue;
            };
            let joint = &self.survey.joints[index];
            let prismatic = joint.kind == Kind::Prismatic;
            let unit = if prismatic { self.request.units.length.factor() } else { self.request.units.angle.factor() };
            let si = value * unit;
            let fault = match (joint.kind, self.tree.mimics[index], joint.limits) {
                (Kind::Fixed, ..) => {
                    Some((format!("the joint `{name}` cannot move anyway"), "leave it out".to_owned()))
                }
                (_, Some(master), _) => {
                    let master = self.survey.joint(master);
                    Some((format!("the joint `{name}` follows `{master}`"), format!("give the value of `{master}`")))
                }
                _ if !si.is_finite() => {
                    Some((format!("`{value}` where a finite number is needed"), "give one".to_owned()))
                }
                (.., Some([lower, upper])) if si < lower - 1e-9 || si > upper + 1e-9 => {
                    let (lower, upper) = (lower / unit, upper / unit);
                    let message = format!("`fixed`: `{name}: {value}` is outside the joint's limits");
                    Some((message, format!("in the units of this file they are {lower} to {upper}")))
                }
                _ => None,
            };
            match fault {
                Some((message, remedy)) => source.report(|_| Diagnostic::error(message).at(place).remedy(remedy)),
                None => values[index] = Some(si),
            }
        }
        values
    }

    /// The value at which a joint is held; `chain.held` holds those asked for. A joint that follows another does so when
    /// that moves, on the chain or off it, and is held with it.
    fn held(&self, joint: usize, chain: &Chain) -> Option<f64> {
        let (mut factor, mut offset, mut at) = (1.0, 0.0, joint);
        while let (Some(master), Some(mimic)) = (self.tree.mimics[at], &self.survey.joints[at].mimic) {
            offset += factor * mimic.offset;
            factor *= mimic.multiplier;
            at = master;
        }
        let master = &self.survey.joints[at];
        if master.kind == Kind::Fixed {
            // Of a chain only what moves becomes a frame.
            return chain.end.map(|_| 0.0);
        }
        match chain.held[at] {
            Some(value) => Some(factor * value + offset),
            None if chain.within[at] => None,
            None => Some(factor * resting(master) + offset),
        }
    }
}

/// Zero, or the limit nearest to it.
fn resting(joint: &Joint) -> f64 {
    joint.limits.map_or(0.0, |[lower, upper]| 0.0_f64.clamp(lower, upper.max(lower)))
}

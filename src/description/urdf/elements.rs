//! The elements of a URDF that say what moves and what weighs, each value with its place, every fault reported.

use std::collections::BTreeMap;
use std::ops::Range;

use roxmltree::{Attribute, Document, Node};

use super::source::{Source, tag};
use crate::diagnostic::{Diagnostic, nearest};

/// Element by which `export` says that the link frames are the frames of a description (z along the joint's axis or
/// against it), so that every frame is put back where it was. Other readers of URDF pass over it.
pub(super) const KEPT: &str = "elastogeo";
/// Its attribute and the value it has.
pub(super) const KEPT_FRAMES: (&str, &str) = ("frames", "links");

/// A name in the file.
#[derive(Debug, Clone)]
pub(super) struct Name<'a> {
    pub(super) text: &'a str,
    pub(super) at: Range<usize>,
}

/// A `<link>`.
pub(super) struct Link<'a> {
    pub(super) name: Option<Name<'a>>,
    /// Mass and, in the link's frame, its centre.
    pub(super) mass: f64,
    pub(super) com: [f64; 3],
    pub(super) node: Node<'a, 'a>,
}

/// What a joint lets move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Revolute,
    Continuous,
    Prismatic,
    Fixed,
}

/// A `<joint>`; `None` where the file is at fault, about which a diagnostic has been made.
pub(super) struct Joint<'a> {
    pub(super) name: Option<Name<'a>>,
    pub(super) kind: Kind,
    pub(super) parent: Option<Name<'a>>,
    pub(super) child: Option<Name<'a>>,
    pub(super) xyz: [f64; 3],
    pub(super) rpy: [f64; 3],
    /// Not zero where the joint moves.
    pub(super) axis: [f64; 3],
    /// Those given for a joint that can have some.
    pub(super) limits: Option<[f64; 2]>,
    pub(super) mimic: Option<Mimic<'a>>,
    pub(super) node: Node<'a, 'a>,
}

/// This joint's value is `multiplier` times that of `joint`, and `offset`.
pub(super) struct Mimic<'a> {
    pub(super) joint: Name<'a>,
    pub(super) multiplier: f64,
    pub(super) offset: f64,
}

/// What the file declares, in its order.
#[derive(Default)]
pub(super) struct Survey<'a> {
    pub(super) name: &'a str,
    pub(super) links: Vec<Link<'a>>,
    pub(super) joints: Vec<Joint<'a>>,
    /// Whether the link frames are to be kept: see [`KEPT`].
    pub(super) kept: bool,
}

impl<'a> Survey<'a> {
    pub(super) fn link(&self, link: usize) -> &'a str {
        self.links[link].name.as_ref().map_or("", |name| name.text)
    }

    pub(super) fn joint(&self, joint: usize) -> &'a str {
        self.joints[joint].name.as_ref().map_or("", |name| name.text)
    }
}

/// Reads every element that matters and reports what is wrong with it.
pub(super) fn survey<'a>(source: &mut Source<'a>, document: &'a Document<'a>) -> Survey<'a> {
    let mut survey = Survey::default();
    let root = document.root_element();
    if root.tag_name().name() != "robot" {
        let message = format!("the outermost element is `{}`; a URDF's is `robot`", root.tag_name().name());
        source.error(tag(root), message, "give the file of a URDF; a robot of another kind is described in YAML");
        return survey;
    }
    if let Some(at) = unexpanded(document) {
        source.xacro(at);
        return survey;
    }
    survey.name = root.attribute("name").unwrap_or_default();
    let mut reader = Reader { source, ignored: BTreeMap::new() };
    for node in root.children().filter(Node::is_element) {
        match node.tag_name().name() {
            "link" => survey.links.push(reader.link(node)),
            "joint" => survey.joints.push(reader.joint(node)),
            KEPT => survey.kept = node.attribute(KEPT_FRAMES.0) == Some(KEPT_FRAMES.1),
            "material" => {}
            _ => reader.ignore(node),
        }
    }
    let Reader { source, ignored } = reader;
    if let Some((_, first)) = ignored.values().min_by_key(|(_, first)| first.start) {
        let list: Vec<String> = ignored.iter().map(|(name, (count, _))| format!("`{name}` ({count})")).collect();
        source.warn(first.clone(), format!("elements that are not read: {}", list.join(", ")), "");
    }
    survey
}

/// Elements of xacro, whatever its namespace is called; what other languages have too, such as `include`, is known by its prefix.
const XACRO: [&str; 2] = ["macro", "property"];

/// Where xacro has not done its work.
fn unexpanded(document: &Document) -> Option<Range<usize>> {
    document.descendants().filter(Node::is_element).find_map(|node| {
        let is_of_xacro = |space: &str| {
            let is_so_called = |name: &str| name.contains("xacro");
            is_so_called(space)
                || node.lookup_prefix(space).is_some_and(is_so_called)
                || XACRO.contains(&node.tag_name().name())
        };
        if node.tag_name().namespace().is_some_and(is_of_xacro) {
            return Some(tag(node));
        }
        let stuck = |attribute: &Attribute| attribute.value().contains("${") || attribute.value().contains("$(");
        node.attributes().find(stuck).map(|attribute| attribute.range_value())
    })
}

struct Reader<'s, 'a> {
    source: &'s mut Source<'a>,
    /// How often an element that is not read occurs, and where first.
    ignored: BTreeMap<&'a str, (usize, Range<usize>)>,
}

impl<'a> Reader<'_, 'a> {
    fn link(&mut self, node: Node<'a, 'a>) -> Link<'a> {
        let mut link = Link { name: self.name(node, "name"), mass: 0.0, com: [0.0; 3], node };
        for child in self.children(node, &["inertial"], &["visual", "collision"]) {
            if child.tag_name().name() == "inertial" {
                (link.mass, link.com) = self.inertial(child);
            }
        }
        link
    }

    fn inertial(&mut self, node: Node<'a, 'a>) -> (f64, [f64; 3]) {
        let (mut mass, mut com, mut inertia) = (None, [0.0; 3], false);
        for child in self.children(node, &["origin", "mass", "inertia"], &[]) {
            match child.tag_name().name() {
                "origin" => com = self.origin(child).0,
                "mass" => {
                    let [value] = self.numbers(child, "value", None);
                    if value < 0.0 {
                        self.at_value(
                            child,
                            "value",
                            format!("the mass {value} is negative"),
                            "give the mass in kg, 0 or more",
                        );
                    }
                    mass = Some(value);
                }
                _ => {
                    inertia = true;
                    for entry in ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"] {
                        self.numbers::<1>(child, entry, None);
                    }
                }
            }
        }
        for (name, _) in [("<mass>", mass.is_some()), ("<inertia>", inertia)].iter().filter(|(_, found)| !found) {
            self.missing(node, name);
        }
        (mass.unwrap_or(0.0), com)
    }

    fn joint(&mut self, node: Node<'a, 'a>) -> Joint<'a> {
        let (name, kind) = (self.name(node, "name"), self.kind(node));
        let mut joint = Joint {
            name,
            kind: kind.unwrap_or(Kind::Revolute),
            parent: None,
            child: None,
            xyz: [0.0; 3],
            rpy: [0.0; 3],
            axis: [1.0, 0.0, 0.0],
            limits: None,
            mimic: None,
            node,
        };
        let unread = ["calibration", "dynamics", "safety_controller"];
        let mut given = Vec::new();
        for child in self.children(node, &["origin", "parent", "child", "axis", "limit", "mimic"], &unread) {
            let element = child.tag_name().name();
            given.push(element);
            match element {
                "origin" => (joint.xyz, joint.rpy) = self.origin(child),
                "parent" => joint.parent = self.name(child, "link"),
                "child" => joint.child = self.name(child, "link"),
                "axis" => joint.axis = self.axis(child, kind.is_some_and(|kind| kind != Kind::Fixed)),
                "limit" => joint.limits = self.limit(child, kind),
                "mimic" => joint.mimic = self.mimic(child, kind == Some(Kind::Fixed)),
                _ => {}
            }
        }
        for element in ["parent", "child"].iter().filter(|element| !given.contains(element)) {
            self.missing(node, &format!("<{element}>"));
        }
        if matches!(kind, Some(Kind::Revolute | Kind::Prismatic)) && !given.contains(&"limit") {
            let message = format!("the joint `{}` has no <limit>", joint.name.as_ref().map_or("", |name| name.text));
            self.source.warn(tag(node), message, "it is taken to have no limits");
        }
        joint
    }

    fn kind(&mut self, node: Node<'a, 'a>) -> Option<Kind> {
        let kinds = [
            ("revolute", Kind::Revolute),
            ("continuous", Kind::Continuous),
            ("prismatic", Kind::Prismatic),
            ("fixed", Kind::Fixed),
        ];
        let Name { text, at } = self.name(node, "type")?;
        let found = kinds.iter().find(|(name, _)| *name == text).map(|(_, kind)| *kind);
        if found.is_none() && matches!(text, "floating" | "planar" | "spherical") {
            let remedy = "supported: `revolute`, `continuous`, `prismatic`, `fixed`";
            self.source.error(at, format!("joints of type `{text}` are not supported"), remedy);
        } else if found.is_none() {
            self.source.report(|source| {
                let diagnostic = Diagnostic::error(format!("unknown type of joint `{text}`")).at(source.place(at));
                diagnostic.suggest(text, kinds.map(|(name, _)| name))
            });
        }
        found
    }

    /// `xyz` and `rpy`.
    fn origin(&mut self, node: Node<'a, 'a>) -> ([f64; 3], [f64; 3]) {
        self.attributes(node, &["xyz", "rpy", "quat_xyzw"]);
        if node.has_attribute("quat_xyzw") {
            let message = "an orientation given as `quat_xyzw` is not read".to_owned();
            self.at_value(node, "quat_xyzw", message, "give it as `rpy`: roll, pitch and yaw in radians");
        }
        (self.numbers(node, "xyz", Some([0.0; 3])), self.numbers(node, "rpy", Some([0.0; 3])))
    }

    fn axis(&mut self, node: Node<'a, 'a>, moving: bool) -> [f64; 3] {
        self.attributes(node, &["xyz"]);
        let before = self.source.count();
        let axis = self.numbers(node, "xyz", None);
        let [x, y, z] = axis;
        let length = x.hypot(y).hypot(z);
        if !moving || self.source.count() > before {
            return [1.0, 0.0, 0.0];
        }
        if !(1e-100..1e100).contains(&length) {
            let message =
                if length == 0.0 { "the axis is zero".into() } else { format!("the axis is {length:e} long") };
            self.at_value(node, "xyz", message, "give a unit vector, such as `0 0 1`");
        } else if let Some(given) = node.attribute_node("xyz").filter(|_| (length - 1.0).abs() > 1e-4) {
            let message = format!("the axis is {length} long, not of unit length");
            self.source.warn(given.range_value(), message, "its direction is taken");
        }
        axis
    }

    fn limit(&mut self, node: Node<'a, 'a>, kind: Option<Kind>) -> Option<[f64; 2]> {
        self.attributes(node, &["lower", "upper", "effort", "velocity", "acceleration", "deceleration", "jerk"]);
        let before = self.source.count();
        let [lower] = self.numbers(node, "lower", Some([0.0]));
        let [upper] = self.numbers(node, "upper", Some([0.0]));
        let sound = self.source.count() == before;
        for rate in ["effort", "acceleration", "deceleration", "jerk"] {
            self.numbers(node, rate, Some([0.0]));
        }
        self.numbers::<1>(node, "velocity", None);
        if !matches!(kind, Some(Kind::Revolute | Kind::Prismatic)) {
            return None;
        }
        if !node.has_attribute("lower") && !node.has_attribute("upper") {
            let remedy = "the joint is taken to have no limits";
            self.source.warn(tag(node), "neither `lower` nor `upper` is given", remedy);
            return None;
        }
        if sound && lower > upper {
            let message = format!("the lower limit {lower} is above the upper limit {upper}");
            let given = if node.has_attribute("lower") { "lower" } else { "upper" };
            self.at_value(node, given, message, "a limit that is not given counts as 0");
        }
        Some([lower, upper])
    }

    fn mimic(&mut self, node: Node<'a, 'a>, fixed: bool) -> Option<Mimic<'a>> {
        self.attributes(node, &["joint", "multiplier", "offset"]);
        let [multiplier] = self.numbers(node, "multiplier", Some([1.0]));
        let [offset] = self.numbers(node, "offset", Some([0.0]));
        let joint = self.name(node, "joint")?;
        if fixed {
            self.source.warn(
                tag(node),
                "a fixed joint cannot mimic another; this is not read",
                "make its type `revolute` or `prismatic`, or remove `<mimic>`",
            );
            return None;
        }
        Some(Mimic { joint, multiplier, offset })
    }

    /// The child elements that are known, `once` or any number of times; the others and repeated ones are reported.
    fn children(&mut self, node: Node<'a, 'a>, once: &[&str], often: &[&str]) -> Vec<Node<'a, 'a>> {
        let (mut kept, mut single): (Vec<Node<'a, 'a>>, Vec<Node<'a, 'a>>) = (Vec::new(), Vec::new());
        for child in node.children().filter(Node::is_element) {
            let name = child.tag_name().name();
            if once.contains(&name) {
                if let Some(first) = single.iter().find(|other| other.tag_name().name() == name) {
                    self.source.report(|source| {
                        let diagnostic = Diagnostic::error(format!("`{name}` is given twice"));
                        let first = Some(source.place(tag(*first)));
                        diagnostic.at(source.place(tag(child))).related(first, "given first here")
                    });
                    continue;
                }
                single.push(child);
            } else if !often.contains(&name) {
                match nearest(name, once.iter().chain(often).copied()) {
                    Some(near) => {
                        let message = format!("`{name}` is not an element of `{}`", node.tag_name().name());
                        self.source.error(tag(child), message, format!("did you mean `{near}`?"));
                    }
                    None => self.ignore(child),
                }
                continue;
            }
            kept.push(child);
        }
        kept
    }

    fn ignore(&mut self, node: Node<'a, 'a>) {
        self.ignored.entry(node.tag_name().name()).or_insert_with(|| (0, tag(node))).0 += 1;
    }

    /// Reports attributes that are not known: a misspelt `xyz` would silently count as zero.
    fn attributes(&mut self, node: Node<'a, 'a>, known: &[&str]) {
        for attribute in node.attributes().filter(|attribute| !known.contains(&attribute.name())) {
            let message = format!("`{}` is not an attribute of `{}`", attribute.name(), node.tag_name().name());
            self.source.doubt(|source| {
                let diagnostic = Diagnostic::warning(message).at(source.place(attribute.range_qname()));
                diagnostic.suggest(attribute.name(), known.iter().copied())
            });
        }
    }

    fn name(&mut self, node: Node<'a, 'a>, attribute: &str) -> Option<Name<'a>> {
        let Some(found) = node.attribute_node(attribute) else {
            self.missing(node, attribute);
            return None;
        };
        if found.value().trim().is_empty() {
            self.source.error(found.range(), format!("`{attribute}` is empty"), "give it a name");
            return None;
        }
        Some(Name { text: found.value(), at: found.range_value() })
    }

    fn missing(&mut self, node: Node<'a, 'a>, what: &str) {
        let remedy = match what.starts_with('<') {
            true => format!("add `{what}` inside it"),
            false => format!("add `{what}=\"..\"` to it"),
        };
        self.source.error(tag(node), format!("the element `{}` lacks `{what}`", node.tag_name().name()), &remedy);
    }

    /// An error about the value of an attribute that is there.
    fn at_value(&mut self, node: Node<'a, 'a>, attribute: &str, message: String, remedy: &str) {
        let at = node.attribute_node(attribute).map_or_else(|| tag(node), |found| found.range_value());
        self.source.error(at, message, remedy);
    }

    /// The numbers of an attribute; `absent` where it is not there, an error without that. Zeros after an error.
    fn numbers<const N: usize>(&mut self, node: Node<'a, 'a>, attribute: &str, absent: Option<[f64; N]>) -> [f64; N] {
        let Some(found) = node.attribute_node(attribute) else {
            return absent.unwrap_or_else(|| {
                self.missing(node, attribute);
                [0.0; N]
            });
        };
        let (value, range) = (found.value(), found.range_value());
        let plain = self.source.xml().get(range.clone()) == Some(value);
        let mut list = Vec::new();
        for token in value.split_whitespace() {
            let message = match token.parse::<f64>() {
                Ok(number) if number.is_finite() => {
                    list.push(number);
                    continue;
                }
                Ok(_) => format!("`{token}` is not a finite number"),
                Err(_) => format!("`{token}` is not a number"),
            };
            let start = range.start + (token.as_ptr() as usize - value.as_ptr() as usize);
            let at = if plain { start..start + token.len() } else { range };
            let comma = "numbers have a decimal point and are separated by blanks";
            let remedy = if token.contains(',') { comma } else { "write a number, such as `0.25` or `1e-3`" };
            self.source.error(at, message, remedy);
            return [0.0; N];
        }
        let count = list.len();
        list.try_into().unwrap_or_else(|_| {
            let wanted = if N == 1 { "one number".to_owned() } else { format!("{N} numbers") };
            let remedy = format!("write {attribute}=\"{}\", say", [if N == 1 { "1" } else { "0" }; N].join(" "));
            self.source.error(range, format!("`{attribute}` must hold {wanted}, it holds {count}"), &remedy);
            [0.0; N]
        })
    }
}

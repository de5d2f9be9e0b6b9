//! Every fault of the elements that are read, each with its place, which the model reader cannot give.

use std::collections::BTreeMap;
use std::ops::Range;

use roxmltree::{Attribute, Document, Node};

use super::source::{Diagnostics, Source};
use crate::diagnostic::{Diagnostic, Place};

/// Element by which `export` says that the link frames are the frames of a description (z along the joint's axis or
/// against it), so that `import` puts every frame back where it was. Other readers of URDF pass over it.
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
}

/// A `<joint>`; `None` where the file is at fault, about which a diagnostic has been made.
pub(super) struct Joint<'a> {
    pub(super) name: Option<Name<'a>>,
    pub(super) parent: Option<Name<'a>>,
    pub(super) child: Option<Name<'a>>,
    /// The joint it mimics.
    pub(super) mimic: Option<Name<'a>>,
    pub(super) fixed: bool,
    /// Whether at least one of `lower` and `upper` is given.
    pub(super) limited: bool,
}

/// What the file declares, in its order.
#[derive(Default)]
pub(super) struct Survey<'a> {
    pub(super) name: &'a str,
    pub(super) links: Vec<Link<'a>>,
    pub(super) joints: Vec<Joint<'a>>,
    /// Whether the link frames are to be kept: see [`KEPT`].
    pub(super) kept: bool,
    /// Bytes of elements that are not read, to be blanked before the model reader sees the file.
    pub(super) blank: Vec<Range<usize>>,
}

pub(super) fn xacro(place: Place) -> Diagnostic {
    Diagnostic::error("this is a xacro file, not yet a URDF")
        .at(place)
        .remedy("run xacro first: `xacro robot.xacro > robot.urdf`")
}

/// Reads every element that matters and diagnostics on what is wrong with it.
pub(super) fn survey<'a>(source: &Source<'a>, document: &'a Document<'a>, diagnostics: &mut Diagnostics) -> Survey<'a> {
    let mut survey = Survey::default();
    let root = document.root_element();
    if root.tag_name().name() != "robot" {
        let message = format!("the outermost element is `{}`; a URDF's is `robot`", root.tag_name().name());
        diagnostics.push(Diagnostic::error(message).at(source.tag(root.range().start)));
        return survey;
    }
    if let Some(place) = unexpanded(source, document) {
        diagnostics.push(xacro(place));
        return survey;
    }
    survey.name = root.attribute("name").unwrap_or_default();
    let mut reader = Reader { source, diagnostics, ignored: BTreeMap::new() };
    for node in root.children() {
        match node.tag_name().name() {
            _ if !node.is_element() => {}
            "link" => survey.links.push(reader.link(node, &mut survey.blank)),
            "joint" => survey.joints.push(reader.joint(node, &mut survey.blank)),
            other => {
                if other == KEPT {
                    survey.kept = node.attribute(KEPT_FRAMES.0) == Some(KEPT_FRAMES.1);
                } else if other != "material" {
                    reader.ignore(node);
                }
                survey.blank.push(node.range());
            }
        }
    }
    if let Some((_, first)) = reader.ignored.values().min_by_key(|(_, first)| *first).copied() {
        let list: Vec<String> = reader.ignored.iter().map(|(name, (count, _))| format!("`{name}` ({count})")).collect();
        let message = format!("elements that are not read: {}", list.join(", "));
        diagnostics.push(Diagnostic::warning(message).at(source.tag(first)));
    }
    survey
}

/// Where xacro has not done its work.
fn unexpanded(source: &Source, document: &Document) -> Option<Place> {
    document.descendants().filter(Node::is_element).find_map(|node| {
        if node.tag_name().namespace().is_some_and(|space| space.contains("xacro")) {
            return Some(source.tag(node.range().start));
        }
        let stuck = |attribute: &Attribute| attribute.value().contains("${") || attribute.value().contains("$(");
        node.attributes().find(stuck).map(|attribute| source.place(attribute.range_value()))
    })
}

struct Reader<'s, 'r, 'a> {
    source: &'s Source<'a>,
    diagnostics: &'r mut Diagnostics,
    /// How often an element that is not read occurs, and where first.
    ignored: BTreeMap<&'a str, (usize, usize)>,
}

impl<'a> Reader<'_, '_, 'a> {
    fn link(&mut self, node: Node<'a, 'a>, blank: &mut Vec<Range<usize>>) -> Link<'a> {
        let name = self.name(node, "name");
        let known = ["inertial", "visual", "collision"];
        for child in self.children(node, &known, &["inertial"], blank) {
            match child.tag_name().name() {
                "inertial" => self.inertial(child),
                _ => blank.push(child.range()),
            }
        }
        Link { name }
    }

    fn inertial(&mut self, node: Node<'a, 'a>) {
        let known = ["origin", "mass", "inertia"];
        let mut found = [false; 3];
        for child in self.children(node, &known, &known, &mut Vec::new()) {
            match child.tag_name().name() {
                "origin" => self.origin(child),
                "mass" => {
                    found[1] = true;
                    if let Some(&[mass]) = self.numbers(child, "value", 1, true).as_deref()
                        && mass < 0.0
                    {
                        let place = self.value_place(child, "value");
                        self.diagnostics.push(Diagnostic::error(format!("the mass {mass} is negative")).at(place));
                    }
                }
                _ => {
                    found[2] = true;
                    for entry in ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"] {
                        self.numbers(child, entry, 1, true);
                    }
                }
            }
        }
        for (name, _) in known.iter().zip(found).skip(1).filter(|(_, found)| !found) {
            self.missing(node, &format!("<{name}>"));
        }
    }

    fn joint(&mut self, node: Node<'a, 'a>, blank: &mut Vec<Range<usize>>) -> Joint<'a> {
        let name = self.name(node, "name");
        let kind = self.kind(node);
        let mut joint =
            Joint { name, parent: None, child: None, mimic: None, fixed: kind == Some("fixed"), limited: false };
        let moving = matches!(kind, Some("revolute" | "continuous" | "prismatic"));
        let unread = ["calibration", "dynamics", "safety_controller"];
        let read = ["origin", "parent", "child", "axis", "limit", "mimic"];
        let known: Vec<&str> = read.into_iter().chain(unread).collect();
        let (mut has_parent, mut has_child, mut has_limit) = (false, false, false);
        for child in self.children(node, &known, &read, blank) {
            match child.tag_name().name() {
                "origin" => self.origin(child),
                "parent" => (joint.parent, has_parent) = (self.name(child, "link"), true),
                "child" => (joint.child, has_child) = (self.name(child, "link"), true),
                "axis" => self.axis(child, moving),
                "limit" => (joint.limited, has_limit) = (self.limit(child, kind), true),
                "mimic" => joint.mimic = self.mimic(child, joint.fixed),
                _ => blank.push(child.range()),
            }
        }
        for (name, found) in [("<parent>", has_parent), ("<child>", has_child)] {
            if !found {
                self.missing(node, name);
            }
        }
        if matches!(kind, Some("revolute" | "prismatic")) && !has_limit {
            let place = self.source.tag(node.range().start);
            let message = format!("the joint `{}` has no <limit>", joint.name.as_ref().map_or("", |name| name.text));
            self.diagnostics.push(Diagnostic::warning(message).at(place).remedy("it is taken to have no limits"));
        }
        joint
    }

    fn kind(&mut self, node: Node<'a, 'a>) -> Option<&'a str> {
        let kinds = ["revolute", "continuous", "prismatic", "fixed"];
        let name = self.name(node, "type")?;
        if kinds.contains(&name.text) {
            return Some(name.text);
        }
        let place = self.source.place(name.at);
        let diagnostic = if matches!(name.text, "floating" | "planar" | "spherical") {
            Diagnostic::error(format!("joints of type `{}` are not supported", name.text))
                .remedy("supported: `revolute`, `continuous`, `prismatic`, `fixed`")
        } else {
            Diagnostic::error(format!("unknown type of joint `{}`", name.text)).suggest(name.text, kinds)
        };
        self.diagnostics.push(diagnostic.at(place));
        None
    }

    fn origin(&mut self, node: Node<'a, 'a>) {
        self.attributes(node, &["xyz", "rpy", "quat_xyzw"]);
        self.numbers(node, "xyz", 3, false);
        self.numbers(node, "rpy", 3, false);
        if let Some(place) = self.value_place(node, "quat_xyzw") {
            let diagnostic = Diagnostic::error("an orientation given as `quat_xyzw` is not read").at(place);
            self.diagnostics.push(diagnostic.remedy("give it as `rpy`: roll, pitch and yaw in radians"));
        }
    }

    fn axis(&mut self, node: Node<'a, 'a>, moving: bool) {
        self.attributes(node, &["xyz"]);
        let Some(&[x, y, z]) = self.numbers(node, "xyz", 3, true).as_deref() else { return };
        let length = x.hypot(y).hypot(z);
        let place = self.value_place(node, "xyz");
        if !moving {
            return;
        }
        if !(1e-100..1e100).contains(&length) {
            let message =
                if length == 0.0 { "the axis is zero".to_owned() } else { format!("the axis is {length:e} long") };
            self.diagnostics.push(Diagnostic::error(message).at(place).remedy("give a unit vector, such as `0 0 1`"));
        } else if (length - 1.0).abs() > 1e-4 {
            let message = format!("the axis is {length} long, not of unit length");
            self.diagnostics.push(Diagnostic::warning(message).at(place).remedy("its direction is taken"));
        }
    }

    /// Whether it limits anything.
    fn limit(&mut self, node: Node<'a, 'a>, kind: Option<&str>) -> bool {
        self.attributes(node, &["lower", "upper", "effort", "velocity", "acceleration", "deceleration", "jerk"]);
        let lower = self.numbers(node, "lower", 1, false);
        let upper = self.numbers(node, "upper", 1, false);
        for rate in ["effort", "acceleration", "deceleration", "jerk"] {
            self.numbers(node, rate, 1, false);
        }
        self.numbers(node, "velocity", 1, true);
        let limited = node.has_attribute("lower") || node.has_attribute("upper");
        if !matches!(kind, Some("revolute" | "prismatic")) {
            return limited;
        }
        let bound = |given: Option<Vec<f64>>| given.map_or(Some(0.0), |list| list.first().copied());
        if !limited {
            let diagnostic =
                Diagnostic::warning("neither `lower` nor `upper` is given").at(self.source.tag(node.range().start));
            self.diagnostics.push(diagnostic.remedy("the joint is taken to have no limits"));
        } else if let (Some(lower), Some(upper)) = (bound(lower), bound(upper))
            && lower > upper
        {
            let place = self.value_place(node, if node.has_attribute("lower") { "lower" } else { "upper" });
            let message = format!("the lower limit {lower} is above the upper limit {upper}");
            self.diagnostics.push(Diagnostic::error(message).at(place).remedy("a limit that is not given counts as 0"));
        }
        limited
    }

    fn mimic(&mut self, node: Node<'a, 'a>, fixed: bool) -> Option<Name<'a>> {
        self.attributes(node, &["joint", "multiplier", "offset"]);
        self.numbers(node, "multiplier", 1, false);
        self.numbers(node, "offset", 1, false);
        let name = self.name(node, "joint")?;
        if fixed {
            let place = self.source.tag(node.range().start);
            self.diagnostics
                .push(Diagnostic::warning("a fixed joint cannot mimic another; this is not read").at(place));
            return None;
        }
        Some(name)
    }

    /// The child elements that are known, after diagnostics on the others and on repeated ones. What is not known is blanked.
    fn children(
        &mut self,
        node: Node<'a, 'a>,
        known: &[&str],
        once: &[&str],
        blank: &mut Vec<Range<usize>>,
    ) -> Vec<Node<'a, 'a>> {
        let (mut kept, mut single): (Vec<Node<'a, 'a>>, Vec<Node<'a, 'a>>) = (Vec::new(), Vec::new());
        for child in node.children().filter(Node::is_element) {
            let name = child.tag_name().name();
            if !known.contains(&name) {
                match crate::diagnostic::nearest(name, known.iter().copied()) {
                    Some(near) => {
                        let message = format!("`{name}` is not an element of `{}`", node.tag_name().name());
                        let diagnostic = Diagnostic::error(message).at(self.source.tag(child.range().start));
                        self.diagnostics.push(diagnostic.remedy(format!("did you mean `{near}`?")));
                    }
                    None => self.ignore(child),
                }
                blank.push(child.range());
                continue;
            }
            if once.contains(&name) {
                if let Some(first) = single.iter().find(|other| other.tag_name().name() == name) {
                    let first = self.source.tag(first.range().start);
                    let diagnostic = Diagnostic::error(format!("`{name}` is given twice"));
                    let diagnostic = diagnostic.at(self.source.tag(child.range().start));
                    self.diagnostics.push(diagnostic.related(Some(first), "given first here"));
                    continue;
                }
                single.push(child);
            }
            kept.push(child);
        }
        kept
    }

    fn ignore(&mut self, node: Node<'a, 'a>) {
        let entry = self.ignored.entry(node.tag_name().name()).or_insert((0, node.range().start));
        entry.0 += 1;
    }

    /// Diagnostics on attributes that are not known: a misspelt `xyz` would silently count as zero.
    fn attributes(&mut self, node: Node<'a, 'a>, known: &[&str]) {
        for attribute in node.attributes().filter(|attribute| !known.contains(&attribute.name())) {
            let message = format!("`{}` is not an attribute of `{}`", attribute.name(), node.tag_name().name());
            let diagnostic = Diagnostic::warning(message).at(self.source.place(attribute.range_qname()));
            self.diagnostics.push(diagnostic.suggest(attribute.name(), known.iter().copied()));
        }
    }

    fn name(&mut self, node: Node<'a, 'a>, attribute: &str) -> Option<Name<'a>> {
        let Some(found) = node.attribute_node(attribute) else {
            self.missing(node, attribute);
            return None;
        };
        if found.value().trim().is_empty() {
            let diagnostic = Diagnostic::error(format!("`{attribute}` is empty")).at(self.source.place(found.range()));
            self.diagnostics.push(diagnostic);
            return None;
        }
        Some(Name { text: found.value(), at: found.range_value() })
    }

    fn missing(&mut self, node: Node<'a, 'a>, what: &str) {
        let message = format!("the element `{}` lacks `{what}`", node.tag_name().name());
        self.diagnostics.push(Diagnostic::error(message).at(self.source.tag(node.range().start)));
    }

    fn value_place(&self, node: Node<'a, 'a>, attribute: &str) -> Option<Place> {
        Some(self.source.place(node.attribute_node(attribute)?.range_value()))
    }

    /// The numbers of an attribute. `None` when it is absent, an empty list when it is at fault.
    fn numbers(&mut self, node: Node<'a, 'a>, attribute: &str, count: usize, needed: bool) -> Option<Vec<f64>> {
        let Some(found) = node.attribute_node(attribute) else {
            if needed {
                self.missing(node, attribute);
            }
            return None;
        };
        let (value, range) = (found.value(), found.range_value());
        let plain = self.source.text().get(range.clone()) == Some(value);
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
            let place = self.source.place(if plain { start..start + token.len() } else { range.clone() });
            let comma = token.contains(',').then_some("numbers have a decimal point and are separated by blanks");
            let diagnostic = Diagnostic { remedy: comma.map(str::to_owned), ..Diagnostic::error(message).at(place) };
            self.diagnostics.push(diagnostic);
            return Some(Vec::new());
        }
        if list.len() != count {
            let wanted = if count == 1 { "one number".to_owned() } else { format!("{count} numbers") };
            let message = format!("`{attribute}` must hold {wanted}, it holds {}", list.len());
            self.diagnostics.push(Diagnostic::error(message).at(self.source.place(range)));
            return Some(Vec::new());
        }
        Some(list)
    }
}

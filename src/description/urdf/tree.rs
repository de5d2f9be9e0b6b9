//! How the links and joints of a URDF hang together, and what is wrong with it.

use std::collections::HashMap;

use super::elements::{Kind, Name, Survey};
use super::source::Source;
use crate::diagnostic::Diagnostic;

/// Most links of a file, and most joints.
const MOST: usize = 10_001;

/// The tree, by positions in the survey.
pub(super) struct Tree {
    /// The link that is the base.
    pub(super) root: usize,
    /// Joints that leave each link, in the order of the file.
    pub(super) leaving: Vec<Vec<usize>>,
    /// The joint that carries each link, and the link that the joint hangs on.
    pub(super) above: Vec<Option<(usize, usize)>>,
    /// The link that each joint carries.
    pub(super) carries: Vec<usize>,
    /// The joint that each joint mimics.
    pub(super) mimics: Vec<Option<usize>>,
}

/// Checks names and connections. `None` when there is an error, about which diagnostics have been made.
pub(super) fn tree(source: &mut Source, survey: &Survey) -> Option<Tree> {
    let (link_count, joint_count) = (survey.links.len(), survey.joints.len());
    if link_count.max(joint_count) > MOST {
        let message =
            format!("the file holds {link_count} links and {joint_count} joints; at most {MOST} of each are read");
        source.report(|_| Diagnostic::error(message));
        return None;
    }
    if link_count == 0 {
        source.report(|_| Diagnostic::error("the file holds no link"));
    } else if joint_count == 0 {
        source.report(|_| Diagnostic::error("the file holds no joint").remedy("a robot needs at least one joint"));
    }
    let links = unique("link", survey.links.iter().map(|link| link.name.as_ref()), source);
    let joints = unique("joint", survey.joints.iter().map(|joint| joint.name.as_ref()), source);
    for name in survey.joints.iter().filter_map(|joint| joint.name.as_ref()).filter(|name| name.text == "0") {
        source.error(name.at.clone(), "a joint is named `0`, which is the name of the base frame", "rename the joint");
    }
    let mimics = mimics(&joints, source, survey);
    let mut tree = Tree {
        root: 0,
        leaving: vec![Vec::new(); link_count],
        above: vec![None; link_count],
        carries: Vec::with_capacity(joint_count),
        mimics,
    };
    // With a name missing or given twice, links seem to be lost that are not.
    let named = links.len() == link_count && joints.len() == joint_count;
    let mut whole = tree.connect(&links, source, survey) && named;
    let above: Vec<Option<usize>> = tree.above.iter().map(|above| above.map(|(_, parent)| parent)).collect();
    for ring in rings(&above) {
        whole = false;
        // The joint that closes the circle is the last of them in the file.
        let joint = ring.iter().filter_map(|&link| tree.above[link]).map(|(joint, _)| joint).max();
        let closing = joint.and_then(|joint| survey.joints[joint].child.as_ref()).map_or(0..0, |name| name.at.clone());
        let around: Vec<usize> = ring.iter().copied().chain(ring.first().copied()).collect();
        let message = format!("links carry one another in a circle: {}", list(&around, survey));
        source.error(closing, message, "a URDF is a tree; declare closed loops in the description that starts from it");
    }
    if whole {
        tree.root = root(&above, source, survey)?;
    }
    (source.count() == 0).then_some(tree)
}

impl Tree {
    /// Hangs the links on one another; whether every joint has found its place.
    fn connect(&mut self, links: &HashMap<&str, usize>, source: &mut Source, survey: &Survey) -> bool {
        let known = || survey.links.iter().filter_map(|link| link.name.as_ref()).map(|name| name.text);
        let nameless = known().count() < survey.links.len();
        let find = |name: &Option<Name>, role: &str, source: &mut Source| {
            let name = name.as_ref()?;
            let found = links.get(name.text).copied();
            if found.is_none() && !nameless {
                source.report(|source| {
                    let diagnostic = Diagnostic::error(format!("unknown {role} link `{}`", name.text));
                    diagnostic.at(source.place(name.at.clone())).suggest(name.text, known())
                });
            }
            found
        };
        let (mut whole, mut twice) = (true, Vec::new());
        for (index, joint) in survey.joints.iter().enumerate() {
            let (parent, child) = (find(&joint.parent, "parent", source), find(&joint.child, "child", source));
            let (Some(parent), Some(child)) = (parent, child) else {
                whole = false;
                continue;
            };
            match self.above[child] {
                Some((first, _)) => twice.push((child, first, index)),
                None => self.above[child] = Some((index, parent)),
            }
            self.leaving[parent].push(index);
            self.carries.push(child);
        }
        for (child, first, second) in twice {
            whole = false;
            source.report(|source| {
                let place = |joint: usize| Some(source.place(survey.joints[joint].child.as_ref()?.at.clone()));
                let diagnostic = Diagnostic::error(format!("the link `{}` has two parents", survey.link(child)));
                let diagnostic = diagnostic.at(place(second)).related(place(first), "carried first here");
                diagnostic.remedy("a URDF is a tree; declare closed loops in the description that starts from it")
            });
        }
        whole
    }
}

/// Positions by name, after diagnostics on names given twice.
fn unique<'n>(
    what: &str,
    names: impl Iterator<Item = Option<&'n Name<'n>>>,
    source: &mut Source,
) -> HashMap<&'n str, usize> {
    let mut first: HashMap<&str, (usize, &Name)> = HashMap::new();
    for (index, name) in names.enumerate() {
        let Some(name) = name else { continue };
        if let Some((_, before)) = first.get(name.text) {
            source.report(|source| {
                let diagnostic = Diagnostic::error(format!("two {what}s are named `{}`", name.text));
                let before = Some(source.place(before.at.clone()));
                diagnostic.at(source.place(name.at.clone())).related(before, "named first here")
            });
        } else {
            first.insert(name.text, (index, name));
        }
    }
    first.into_iter().map(|(name, (index, _))| (name, index)).collect()
}

/// The circles that one meets when going from each position to the next one, downwards.
fn rings(next: &[Option<usize>]) -> Vec<Vec<usize>> {
    let (mut seen, mut found) = (vec![0; next.len()], Vec::new());
    for start in 0..next.len() {
        let mut at = start;
        // Onwards until the end, or a position seen in this walk (a circle) or in an earlier one.
        let last = loop {
            if seen[at] != 0 {
                break (seen[at] == start + 1).then_some(at);
            }
            seen[at] = start + 1;
            match next[at] {
                Some(following) => at = following,
                None => break None,
            }
        };
        if let Some(last) = last {
            let mut ring: Vec<usize> =
                std::iter::successors(next[last], |&at| next[at].filter(|_| at != last)).collect();
            ring.reverse();
            found.push(ring);
        }
    }
    found
}

/// `a, b, ..., z` in words of at most seven links.
fn list(links: &[usize], survey: &Survey) -> String {
    let shown: Vec<String> = links.iter().map(|&link| format!("`{}`", survey.link(link))).collect();
    match shown.as_slice() {
        [first, second, third, .., last] if shown.len() > 7 => format!("{first}, {second}, {third}, ..., {last}"),
        _ => shown.join(", "),
    }
}

/// The only link that nothing carries.
fn root(above: &[Option<usize>], source: &mut Source, survey: &Survey) -> Option<usize> {
    let roots: Vec<usize> = (0..above.len()).filter(|&link| above[link].is_none()).collect();
    let (&first, others) = roots.split_first()?;
    if let Some(&second) = others.first() {
        source.report(|source| {
            let place = |link: usize| Some(source.place(survey.links[link].name.as_ref()?.at.clone()));
            let message = format!("{} links hang on no joint: {}", roots.len(), list(&roots, survey));
            let diagnostic = Diagnostic::error(message).at(place(second)).related(place(first), "the first of them");
            diagnostic.remedy("only the base may: make the others the child of a joint")
        });
    }
    Some(first)
}

/// Which joint each joint mimics, after diagnostics on unknown ones and circles.
fn mimics(joints: &HashMap<&str, usize>, source: &mut Source, survey: &Survey) -> Vec<Option<usize>> {
    let mut masters = vec![None; survey.joints.len()];
    for (index, joint) in survey.joints.iter().enumerate() {
        let Some(mimic) = joint.mimic.as_ref().map(|mimic| &mimic.joint) else { continue };
        for name in [Some(mimic), joint.name.as_ref()].into_iter().flatten() {
            if name.text.contains(|c: char| c.is_whitespace() || "=*+".contains(c)) {
                let message = format!("the name `{}` cannot stand in a coupling of joints", name.text);
                source.error(name.at.clone(), message, "rename it without blanks, `=`, `*` and `+`");
            }
        }
        match joints.get(mimic.text).copied() {
            Some(master) if survey.joints[master].kind != Kind::Fixed => masters[index] = Some(master),
            Some(_) => {
                source.error(
                    mimic.at.clone(),
                    format!("the joint `{}` is fixed and cannot be mimicked", mimic.text),
                    "mimic a joint that moves, or remove `<mimic>`",
                );
            }
            None => source.report(|source| {
                let near = survey.joints.iter().filter(|joint| joint.kind != Kind::Fixed);
                let near = near.filter_map(|joint| joint.name.as_ref()).map(|name| name.text);
                let diagnostic = Diagnostic::error(format!("unknown joint `{}` to mimic", mimic.text));
                diagnostic.at(source.place(mimic.at.clone())).suggest(mimic.text, near)
            }),
        }
    }
    for mimic in rings(&masters).iter().filter_map(|ring| survey.joints[*ring.first()?].mimic.as_ref()) {
        let message = format!("joints mimic one another in a circle, by way of `{}`", mimic.joint.text);
        source.error(mimic.joint.at.clone(), message, "one of them must move by itself");
    }
    masters
}

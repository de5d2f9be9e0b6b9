//! How the links and joints of a URDF hang together, and what is wrong with it.

use std::collections::HashMap;

use super::locate::{Joint, Name, Survey};
use super::source::{Diagnostics, Source};
use crate::diagnostic::Diagnostic;

/// Most links of a file, and most joints: the model reader takes a time that grows with their square (2 s at this limit).
const MOST: usize = 10_001;

/// The tree, by positions in the survey.
pub(super) struct Tree {
    /// The link that is the base.
    pub(super) root: usize,
    /// Joints that leave each link, in the order of the file.
    pub(super) leaving: Vec<Vec<usize>>,
    /// The link that each joint carries.
    pub(super) carries: Vec<usize>,
    /// The joint that each joint mimics.
    pub(super) mimics: Vec<Option<usize>>,
}

/// Checks names and connections. `None` when there is an error, about which diagnostics have been made.
pub(super) fn tree(source: &Source, survey: &Survey, diagnostics: &mut Diagnostics) -> Option<Tree> {
    let (links, joints) = (survey.links.len(), survey.joints.len());
    if links.max(joints) > MOST {
        let message = format!("the file holds {links} links and {joints} joints; at most {MOST} of each are read");
        diagnostics.push(Diagnostic::error(message));
        return None;
    }
    if survey.links.is_empty() {
        diagnostics.push(Diagnostic::error("the file holds no link"));
    } else if survey.joints.is_empty() {
        diagnostics.push(Diagnostic::error("the file holds no joint").remedy("a robot needs at least one joint"));
    }
    let links = unique("link", survey.links.iter().map(|link| link.name.as_ref()), source, diagnostics);
    let joints = unique("joint", survey.joints.iter().map(|joint| joint.name.as_ref()), source, diagnostics);
    for name in survey.joints.iter().filter_map(|joint| joint.name.as_ref()).filter(|name| name.text == "0") {
        let diagnostic = Diagnostic::error("a joint is named `0`, which is the name of the base frame");
        diagnostics.push(diagnostic.at(source.place(name.at.clone())).remedy("rename the joint"));
    }
    let mimics = mimics(&joints, source, survey, diagnostics);

    let known = || survey.links.iter().filter_map(|link| link.name.as_ref()).map(|name| name.text);
    let nameless = known().count() < survey.links.len();
    let mut find = |name: &Option<Name>, role: &str| {
        let name = name.as_ref()?;
        let found = links.get(name.text).copied();
        if found.is_none() && !nameless && !diagnostics.full() {
            let diagnostic = Diagnostic::error(format!("unknown {role} link `{}`", name.text));
            diagnostics.push(diagnostic.at(source.place(name.at.clone())).suggest(name.text, known()));
        }
        found
    };
    let mut leaving = vec![Vec::new(); survey.links.len()];
    let mut carries = Vec::with_capacity(survey.joints.len());
    let mut above: Vec<Option<(usize, usize)>> = vec![None; survey.links.len()];
    // With a name missing or given twice, links seem to be lost that are not.
    let mut whole = links.len() == survey.links.len() && joints.len() == survey.joints.len();
    let mut twice = Vec::new();
    for (index, joint) in survey.joints.iter().enumerate() {
        let (Some(parent), Some(child)) = (find(&joint.parent, "parent"), find(&joint.child, "child")) else {
            whole = false;
            continue;
        };
        // In bounds: both are positions in `survey.links`.
        match above[child] {
            Some((first, _)) => twice.push((child, first, index)),
            None => above[child] = Some((index, parent)),
        }
        leaving[parent].push(index);
        carries.push(child);
    }
    for (child, first, second) in twice {
        whole = false;
        let place = |joint: usize| Some(source.place(survey.joints.get(joint)?.child.as_ref()?.at.clone()));
        let name = survey.links.get(child).and_then(|link| link.name.as_ref()).map_or("", |name| name.text);
        let diagnostic = Diagnostic::error(format!("the link `{name}` has two parents")).at(place(second));
        let diagnostic = diagnostic.related(place(first), "carried first here");
        diagnostics
            .push(diagnostic.remedy("a URDF is a tree; declare closed loops in the description that starts from it"));
    }
    whole &= !cycles(&above, source, survey, diagnostics);
    let root = if whole { root(&above, source, survey, diagnostics) } else { None };
    (!diagnostics.has_error()).then_some(Tree { root: root?, leaving, carries, mimics })
}

/// Positions by name, after diagnostics on names given twice.
fn unique<'n>(
    what: &str,
    names: impl Iterator<Item = Option<&'n Name<'n>>>,
    source: &Source,
    diagnostics: &mut Diagnostics,
) -> HashMap<&'n str, usize> {
    let mut positions = HashMap::new();
    let mut first: HashMap<&str, &Name> = HashMap::new();
    for (index, name) in names.enumerate() {
        let Some(name) = name else { continue };
        if let Some(&before) = first.get(name.text) {
            let diagnostic =
                Diagnostic::error(format!("two {what}s are named `{}`", name.text)).at(source.place(name.at.clone()));
            diagnostics.push(diagnostic.related(Some(source.place(before.at.clone())), "named first here"));
            continue;
        }
        first.insert(name.text, name);
        positions.insert(name.text, index);
    }
    positions
}

/// Diagnostics on links that carry one another in a circle; whether there are any.
fn cycles(above: &[Option<(usize, usize)>], source: &Source, survey: &Survey, diagnostics: &mut Diagnostics) -> bool {
    let mut seen = vec![0_usize; above.len()];
    let mut found = false;
    for start in 0..above.len() {
        let walk = start + 1;
        let mut link = start;
        // Upwards until the base, or a link seen in this walk (a circle) or in an earlier one.
        while seen[link] == 0 {
            seen[link] = walk;
            match above[link] {
                Some((_, parent)) => link = parent,
                None => break,
            }
        }
        if seen[link] != walk {
            continue;
        }
        if above[link].is_none() {
            continue;
        }
        found = true;
        let mut ring = vec![link];
        while let Some((_, parent)) = ring.last().and_then(|&last| above[last]) {
            ring.push(parent);
            if parent == link {
                break;
            }
        }
        ring.reverse();
        // The joint that closes the circle is the last of them in the file.
        let joint = ring.iter().filter_map(|&link| above[link]).map(|(joint, _)| joint).max();
        let joint = joint.and_then(|joint| survey.joints.get(joint));
        let place = joint.and_then(|joint| joint.child.as_ref()).map(|name| source.place(name.at.clone()));
        let name =
            |link: &usize| survey.links.get(*link).and_then(|link| link.name.as_ref()).map_or("", |name| name.text);
        let diagnostic =
            Diagnostic::error(format!("links carry one another in a circle: {}", chain(&ring, name))).at(place);
        diagnostics
            .push(diagnostic.remedy("a URDF is a tree; declare closed loops in the description that starts from it"));
    }
    found
}

/// `a, b, ..., z` in words of at most seven links.
fn chain<'n>(ring: &[usize], name: impl Fn(&usize) -> &'n str) -> String {
    let shown: Vec<String> = ring.iter().map(|link| format!("`{}`", name(link))).collect();
    match shown.as_slice() {
        [first, second, third, .., last] if shown.len() > 7 => format!("{first}, {second}, {third}, ..., {last}"),
        _ => shown.join(", "),
    }
}

/// The only link that nothing carries.
fn root(
    above: &[Option<(usize, usize)>],
    source: &Source,
    survey: &Survey,
    diagnostics: &mut Diagnostics,
) -> Option<usize> {
    let roots: Vec<usize> = (0..above.len()).filter(|&link| above[link].is_none()).collect();
    let place = |link: usize| Some(source.place(survey.links.get(link)?.name.as_ref()?.at.clone()));
    let (&first, others) = roots.split_first()?;
    if let Some(&second) = others.first() {
        let name =
            |link: &usize| survey.links.get(*link).and_then(|link| link.name.as_ref()).map_or("", |name| name.text);
        let diagnostic = Diagnostic::error(format!("{} links hang on no joint: {}", roots.len(), chain(&roots, name)));
        let diagnostic = diagnostic.at(place(second)).related(place(first), "the first of them");
        diagnostics.push(diagnostic.remedy("only the base may: make the others the child of a joint"));
        return None;
    }
    Some(first)
}

/// Which joint each joint mimics, after diagnostics on unknown ones and circles.
fn mimics(
    joints: &HashMap<&str, usize>,
    source: &Source,
    survey: &Survey,
    diagnostics: &mut Diagnostics,
) -> Vec<Option<usize>> {
    let moving = |joint: &Joint| !joint.fixed;
    let mut masters = vec![None; survey.joints.len()];
    for (index, joint) in survey.joints.iter().enumerate() {
        let Some(mimic) = &joint.mimic else { continue };
        for name in [Some(mimic), joint.name.as_ref()].into_iter().flatten() {
            if name.text.contains(|c: char| c.is_whitespace() || "=*+".contains(c)) {
                let message = format!("the name `{}` cannot stand in a coupling of joints", name.text);
                let diagnostic = Diagnostic::error(message).at(source.place(name.at.clone()));
                diagnostics.push(diagnostic.remedy("rename it without blanks, `=`, `*` and `+`"));
            }
        }
        match joints.get(mimic.text).copied() {
            Some(master) if survey.joints.get(master).is_some_and(moving) => masters[index] = Some(master),
            Some(_) => {
                let message = format!("the joint `{}` is fixed and cannot be mimicked", mimic.text);
                diagnostics.push(Diagnostic::error(message).at(source.place(mimic.at.clone())));
            }
            None if diagnostics.full() => {}
            None => {
                let near = survey.joints.iter().filter(|joint| moving(joint)).filter_map(|joint| joint.name.as_ref());
                let diagnostic = Diagnostic::error(format!("unknown joint `{}` to mimic", mimic.text));
                diagnostics.push(
                    diagnostic.at(source.place(mimic.at.clone())).suggest(mimic.text, near.map(|name| name.text)),
                );
            }
        }
    }
    let mut seen = vec![0_usize; masters.len()];
    for start in 0..masters.len() {
        let mut joint = start;
        while seen[joint] == 0 {
            seen[joint] = start + 1;
            match masters[joint] {
                Some(master) => joint = master,
                None => break,
            }
        }
        if seen[joint] == start + 1
            && masters[joint].is_some()
            && let Some(mimic) = survey.joints.get(joint).and_then(|joint| joint.mimic.as_ref())
        {
            let message = format!("joints mimic one another in a circle, by way of `{}`", mimic.text);
            let diagnostic = Diagnostic::error(message).at(source.place(mimic.at.clone()));
            diagnostics.push(diagnostic.remedy("one of them must move by itself"));
        }
    }
    masters
}

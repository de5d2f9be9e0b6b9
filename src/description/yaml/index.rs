//! Where everything stands in a YAML text, without knowing what it means.
//!
//! The text is walked once, event by event and without recursion, so that no nesting can exhaust the stack.

use super::syntax::{DEEPEST, syntax};
use crate::diagnostic::{Code, Diagnostic, Place};
use serde_yaml::granit_parser::{Event, Parser, Span, StructureStyle, options};
use std::collections::HashMap;
use std::ops::Range;

/// Most values in one text, aliases counted with everything they repeat.
pub(super) const MOST_VALUES: usize = 1_000_000;

/// What a node of the text is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Scalar,
    Alias(usize),
    Sequence,
    Mapping,
}

/// One value of the text, with the key it stands under.
#[derive(Debug, Clone)]
pub(super) struct Node {
    pub parent: Option<usize>,
    /// Key of a mapping entry, or index in a sequence.
    pub name: String,
    /// Where the key stands; `None` for the root and for elements of a sequence.
    pub key: Option<Range<usize>>,
    pub value: Range<usize>,
    pub kind: Kind,
    /// Whether the entry stands within braces or brackets, where commas separate.
    pub flow: bool,
    /// Number of values, aliases expanded.
    weight: usize,
    closed: bool,
}

impl Node {
    /// From the start of the key to the end of the value.
    pub fn extent(&self) -> Range<usize> {
        self.key.as_ref().map_or(self.value.start, |key| key.start)..self.value.end
    }
}

/// Every value of a text and its path.
#[derive(Debug, Clone, Default)]
pub(super) struct Index {
    pub nodes: Vec<Node>,
    children: HashMap<(usize, String), usize>,
}

/// A collection that is still open.
struct Open {
    node: usize,
    kind: Kind,
    flow: bool,
    /// A mapping's key whose value is awaited; its text is absent when the key is itself a collection.
    key: Option<(Option<String>, Range<usize>)>,
    elements: usize,
    /// Whether the collection is itself a key of the mapping around it.
    is_key: bool,
}

impl Index {
    /// Walks the text.
    ///
    /// Returns the index and every duplicate key (with the number of its node); or, when the text is not YAML, is empty or is
    /// out of bounds, the one diagnostic that says so.
    pub fn of(file: &str, text: &str) -> Result<(Self, Vec<(usize, Diagnostic)>), Diagnostic> {
        let mut walk = Walk {
            file,
            text,
            index: Self::default(),
            open: Vec::new(),
            anchors: HashMap::new(),
            documents: 0,
            duplicates: Vec::new(),
        };
        let limits =
            options! { flow_nesting_limit: 2 * DEEPEST, block_nesting_limit: 2 * DEEPEST, emit_comments: false };
        for event in Parser::new_from_str_with_options(text, limits) {
            match event {
                Ok((event, span)) => walk.take(&event, &span)?,
                Err(error) => return Err(syntax(file, text, &error)),
            }
        }
        let empty = match walk.index.nodes.first() {
            None => true,
            Some(root) => root.kind == Kind::Scalar && matches!(text.get(root.value.clone()), Some("" | "~" | "null")),
        };
        if empty {
            let diagnostic =
                Diagnostic::error("the file is empty").code(Code::Empty).at(Place::in_text(file, text, 0..0));
            return Err(diagnostic.remedy("write `key: value` pairs"));
        }
        Ok((walk.index, walk.duplicates))
    }

    /// The node at exactly `path`, seen through aliases and merge keys.
    pub fn find(&self, path: &[&str]) -> Option<usize> {
        let (node, rest) = self.nearest(path)?;
        rest.is_empty().then_some(node)
    }

    /// The deepest node on `path`, and the segments that lead to nothing.
    pub fn nearest<'a, 'b>(&self, path: &'a [&'b str]) -> Option<(usize, &'a [&'b str])> {
        let mut at = (!self.nodes.is_empty()).then_some(0)?;
        let mut rest = path;
        while let Some((segment, after)) = rest.split_first() {
            match self.child(at, segment, DEEPEST) {
                Some(child) => (at, rest) = (child, after),
                None => break,
            }
        }
        Some((at, rest))
    }

    /// The child under a name; `fuel` bounds chains of aliases and merges.
    fn child(&self, node: usize, name: &str, fuel: usize) -> Option<usize> {
        let fuel = fuel.checked_sub(1)?;
        if let Some(&child) = self.children.get(&(node, name.to_owned())) {
            return Some(child);
        }
        if let Kind::Alias(target) = self.nodes.get(node)?.kind {
            return self.child(target, name, fuel);
        }
        let merged = *self.children.get(&(node, "<<".to_owned()))?;
        self.child(merged, name, fuel).or_else(|| {
            (0..fuel)
                .map_while(|i| self.children.get(&(merged, i.to_string())))
                .find_map(|&m| self.child(m, name, fuel))
        })
    }

    /// The path of a node, as in `frames.3.alpha`.
    pub fn path(&self, node: usize) -> String {
        let mut names = Vec::new();
        let mut at = self.nodes.get(node);
        while let Some(node) = at {
            if node.parent.is_some() {
                names.push(node.name.as_str());
            }
            at = node.parent.and_then(|parent| self.nodes.get(parent));
        }
        names.reverse();
        names.join(".")
    }
}

struct Walk<'t> {
    file: &'t str,
    text: &'t str,
    index: Index,
    open: Vec<Open>,
    anchors: HashMap<usize, usize>,
    documents: usize,
    duplicates: Vec<(usize, Diagnostic)>,
}

impl Walk<'_> {
    fn take(&mut self, event: &Event<'_>, span: &Span) -> Result<(), Diagnostic> {
        let at = span.byte_range().unwrap_or(0..0);
        match event {
            Event::DocumentStart(..) => {
                self.documents += 1;
                if self.documents > 1 {
                    let diagnostic =
                        self.diagnostic("a second document starts here; a file holds one", at.start..at.start + 3);
                    return Err(diagnostic.remedy("remove the `---` line, or put what follows in a file of its own"));
                }
            }
            Event::Scalar(value, _, anchor, _) => {
                let end = span.tag_span().and_then(|tag| tag.byte_range()).map_or(at.end, |tag| tag.end.max(at.end));
                let written = self.text.get(at.clone()).unwrap_or_default();
                let end = end.min(at.start + written.trim_end_matches(['\n', '\r', ' ']).len()).max(at.start);
                self.leaf(Kind::Scalar, value.to_string(), at.start..end, *anchor)?;
            }
            Event::Alias(anchor) => {
                let target = self.anchors.get(anchor).copied();
                let Some((target, node)) = target.and_then(|target| Some((target, self.index.nodes.get(target)?)))
                else {
                    return Err(self.diagnostic("this alias repeats an anchor that is not defined above it", at));
                };
                if !node.closed {
                    let first = self.place(node.extent());
                    let diagnostic = self.diagnostic("this alias refers to the value that contains it", at);
                    return Err(diagnostic.related(Some(first), "the value that would contain itself"));
                }
                let text = self.text.get(node.value.clone()).unwrap_or_default().to_owned();
                self.leaf(Kind::Alias(target), text, at, 0)?;
            }
            Event::SequenceStart(style, anchor, _) => self.enter(Kind::Sequence, *style, at, *anchor)?,
            Event::MappingStart(style, anchor, _) => self.enter(Kind::Mapping, *style, at, *anchor)?,
            Event::SequenceEnd | Event::MappingEnd => self.leave(&at),
            _ => {}
        }
        Ok(())
    }

    fn leaf(&mut self, kind: Kind, text: String, at: Range<usize>, anchor: usize) -> Result<(), Diagnostic> {
        if let Some(open) = self.open.last_mut()
            && open.kind == Kind::Mapping
            && open.key.is_none()
        {
            open.key = Some((Some(text), at.clone()));
            if anchor > 0 {
                // A key may be anchored and repeated elsewhere: keep a node for it that no path leads to.
                let node = self.push(kind, at, false)?;
                self.close(node, anchor);
            }
            return Ok(());
        }
        let node = self.add(kind, at)?;
        self.close(node, anchor);
        Ok(())
    }

    fn enter(&mut self, kind: Kind, style: StructureStyle, at: Range<usize>, anchor: usize) -> Result<(), Diagnostic> {
        if self.open.len() >= DEEPEST {
            return Err(self.diagnostic(&format!("nested more than {DEEPEST} levels deep"), at));
        }
        let is_key = self.open.last().is_some_and(|open| open.kind == Kind::Mapping && open.key.is_none());
        let node = if is_key { self.push(kind, at, false)? } else { self.add(kind, at)? };
        if anchor > 0 {
            self.anchors.insert(anchor, node);
        }
        let flow = style == StructureStyle::Flow;
        self.open.push(Open { node, kind, flow, key: None, elements: 0, is_key });
        Ok(())
    }

    fn leave(&mut self, at: &Range<usize>) {
        let Some(open) = self.open.pop() else { return };
        if open.flow
            && let Some(node) = self.index.nodes.get_mut(open.node)
        {
            node.value.end = at.end.max(node.value.end);
        }
        self.close(open.node, 0);
        if open.is_key
            && let Some(node) = self.index.nodes.get(open.node)
            && let Some(around) = self.open.last_mut()
        {
            around.key = Some((None, node.value.clone()));
        }
    }

    /// Adds a value under the key or index that awaits it.
    fn add(&mut self, kind: Kind, at: Range<usize>) -> Result<usize, Diagnostic> {
        let Some(open) = self.open.last_mut() else { return self.push(kind, at, false) };
        let (parent, flow) = (open.node, open.flow);
        let (name, key) = match open.kind {
            Kind::Mapping => open.key.take().map_or((None, None), |(name, key)| (name, Some(key))),
            _ => {
                open.elements += 1;
                (Some((open.elements - 1).to_string()), None)
            }
        };
        let mut at = at;
        if let Some(key) = &key
            && at.start <= key.end
        {
            // A value that is not written starts at its key: the extent takes in the colon.
            let after = self.text.get(key.end..).unwrap_or_default();
            let blanks = after.len() - after.trim_start_matches([' ', '\t', '\n', '\r']).len();
            let colon = usize::from(after.get(blanks..).is_some_and(|rest| rest.starts_with(':')));
            at.end = at.end.max(key.end + if colon > 0 { blanks + 1 } else { 0 });
        }
        let node = self.push(kind, at, flow)?;
        if let Some(value) = self.index.nodes.get_mut(node) {
            value.parent = Some(parent);
            value.key.clone_from(&key);
            value.name = name.clone().unwrap_or_else(|| "?".to_owned());
        }
        if let Some(name) = name {
            let first = self.index.children.get(&(parent, name.clone())).copied();
            match (first, key) {
                (Some(first), Some(key)) => {
                    let first = self.index.nodes.get(first).and_then(|node| node.key.clone());
                    let diagnostic = self.diagnostic(&format!("`{name}` is given twice"), key);
                    let diagnostic = diagnostic.related(first.map(|first| self.place(first)), "first given here");
                    self.duplicates.push((node, diagnostic.remedy("keep one of the two")));
                }
                _ => {
                    self.index.children.insert((parent, name), node);
                }
            }
        }
        Ok(node)
    }

    fn push(&mut self, kind: Kind, value: Range<usize>, flow: bool) -> Result<usize, Diagnostic> {
        let nodes = &mut self.index.nodes;
        let weight = match kind {
            Kind::Alias(target) => nodes.get(target).map_or(1, |target| target.weight),
            _ => 1,
        };
        let at = value.clone();
        nodes.push(Node { parent: None, name: String::new(), key: None, value, kind, flow, weight, closed: false });
        if nodes.len() > MOST_VALUES {
            return Err(self.diagnostic(&format!("more than {MOST_VALUES} values in one file"), at));
        }
        Ok(nodes.len() - 1)
    }

    /// Ends a node: the collection around it grows by its extent and weight.
    fn close(&mut self, node: usize, anchor: usize) {
        if anchor > 0 {
            self.anchors.insert(anchor, node);
        }
        let Some(value) = self.index.nodes.get_mut(node) else { return };
        value.closed = true;
        let (end, weight, parent) = (value.value.end, value.weight, value.parent);
        if let Some(parent) = parent.and_then(|parent| self.index.nodes.get_mut(parent)) {
            parent.value.end = parent.value.end.max(end);
            parent.weight = parent.weight.saturating_add(weight);
        }
    }

    fn place(&self, at: Range<usize>) -> Place {
        Place::in_text(self.file, self.text, at)
    }

    fn diagnostic(&self, message: &str, at: Range<usize>) -> Diagnostic {
        Diagnostic::error(message).at(self.place(at))
    }
}

impl Index {
    /// The first alias through which the text grows beyond all measure.
    pub fn bomb(&self) -> Option<usize> {
        if self.nodes.first()?.weight <= MOST_VALUES {
            return None;
        }
        let heavy = |node: &Node| matches!(node.kind, Kind::Alias(_)) && node.weight > MOST_VALUES / 100;
        self.nodes.iter().position(heavy).or(Some(0))
    }
}

//! Which file imports from which, read from the syntax tree: `use` and paths of code, re-exports followed to the file that
//! defines the name. A `mod.rs` that only re-exports a child does not depend on it. A call of a method depends on the file that
//! defines it, where one file of the crate alone has an inherent method of that name.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use syn::visit::Visit;

/// Methods of this crate whose names types of the standard library, or of other crates, have as well.
const STANDARD: &[&str] = &["copied", "is_empty", "map", "random", "render"];

/// The files of a crate, each with its module path (`["diagnosis", "verdict"]`) and what it imports.
pub struct Imports {
    modules: BTreeMap<Vec<String>, Module>,
}

#[derive(Default)]
struct Module {
    /// Name of the file below `src`.
    file: String,
    /// Names that `use` brings in, and the path behind each.
    uses: BTreeMap<String, Vec<String>>,
    /// Modules of which all names are brought in.
    globs: Vec<Vec<String>>,
    /// Paths that are more than re-exports of what lies below this module.
    paths: Vec<Vec<String>>,
    /// Names of the inherent methods that it defines.
    methods: BTreeSet<String>,
    /// Names of methods that traits of this file, or their implementations, define.
    of_traits: BTreeSet<String>,
    /// Names of the methods that are called.
    calls: BTreeSet<String>,
}

impl Imports {
    /// Reads all files below `root`.
    pub fn of(root: &Path) -> Self {
        let mut files = Vec::new();
        sources(root, &mut files);
        let modules = files.iter().map(|file| read(root, file)).collect();
        Self { modules }
    }

    /// For each file, the files from which it takes names.
    pub fn edges(&self) -> BTreeMap<&str, BTreeSet<&str>> {
        let mut edges: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
        let homes = self.homes_of_methods();
        for (own, module) in &self.modules {
            let found = edges.entry(&module.file).or_default();
            let defining = module.calls.iter().filter_map(|name| homes.get(name.as_str()));
            found.extend(defining.filter(|home| **home != module.file && folder_of(home) == folder_of(&module.file)));
            for path in &module.paths {
                if let Some(other) = self.resolve(own, path, 0).and_then(|path| self.modules.get(&path))
                    && other.file != module.file
                {
                    found.insert(&other.file);
                }
            }
        }
        edges
    }

    /// Files of methods whose name only one file defines, and no trait.
    fn homes_of_methods(&self) -> BTreeMap<&str, &str> {
        let mut homes: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
        for module in self.modules.values() {
            for name in &module.methods {
                homes.entry(name).or_default().push(&module.file);
            }
        }
        let is_of_trait = |name: &str| self.modules.values().any(|module| module.of_traits.contains(name));
        let alone = homes
            .into_iter()
            .filter(|(name, files)| files.len() == 1 && !is_of_trait(name) && !STANDARD.contains(name));
        alone.map(|(name, files)| (name, files[0])).collect()
    }

    /// The module that defines what `path`, written in `own`, names.
    fn resolve(&self, own: &[String], path: &[String], depth: usize) -> Option<Vec<String>> {
        if depth > 20 {
            return None;
        }
        let (mut at, mut rest) = match path.first()?.as_str() {
            "crate" => (Vec::new(), &path[1..]),
            "self" => (own.to_vec(), &path[1..]),
            "super" => (own[..own.len().checked_sub(1)?].to_vec(), &path[1..]),
            first if self.child(own, first).is_some() => (own.to_vec(), path),
            _ => return None,
        };
        while rest.first().is_some_and(|name| name == "super") {
            at.pop()?;
            rest = &rest[1..];
        }
        while let Some(name) = rest.first() {
            if let Some(child) = self.child(&at, name) {
                at = child;
                rest = &rest[1..];
                continue;
            }
            let module = self.modules.get(&at)?;
            if let Some(behind) = module.uses.get(name) {
                let further: Vec<String> = behind.iter().chain(&rest[1..]).cloned().collect();
                return self.resolve(&at, &further, depth + 1).or(Some(at));
            }
            let inside = module.globs.iter().find_map(|glob| {
                let folder = self.resolve(&at, glob, depth + 1)?;
                (self.child(&folder, name).is_some() || self.modules.get(&folder)?.uses.contains_key(name))
                    .then_some(folder)
            });
            match inside {
                Some(folder) => at = folder,
                None => return Some(at),
            }
        }
        Some(at)
    }

    fn child(&self, of: &[String], name: &str) -> Option<Vec<String>> {
        let child: Vec<String> = of.iter().cloned().chain([name.to_string()]).collect();
        self.modules.contains_key(&child).then_some(child)
    }
}

/// Groups of files that import from each other, directly or through others.
pub fn circles<'f>(edges: &BTreeMap<&'f str, BTreeSet<&'f str>>) -> Vec<Vec<&'f str>> {
    let reached = |from: &'f str| {
        let (mut seen, mut open) = (BTreeSet::new(), vec![from]);
        while let Some(file) = open.pop() {
            for next in edges.get(file).into_iter().flatten() {
                if seen.insert(*next) {
                    open.push(next);
                }
            }
        }
        seen
    };
    let reach: BTreeMap<&str, BTreeSet<&str>> = edges.keys().map(|file| (*file, reached(file))).collect();
    let mut circles: BTreeSet<Vec<&str>> = BTreeSet::new();
    for (file, all) in &reach {
        if all.contains(file) {
            circles.insert(all.iter().filter(|other| reach[*other].contains(file)).copied().collect());
        }
    }
    circles.into_iter().collect()
}

/// The top folder of a file; what lies in others is known by imports alone.
fn folder_of(file: &str) -> &str {
    file.split('/').next().unwrap_or(file)
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

fn read(root: &Path, file: &Path) -> (Vec<String>, Module) {
    let relative = file.strip_prefix(root).expect("inside").to_string_lossy().replace('\\', "/");
    let mut path: Vec<String> = relative.trim_end_matches(".rs").split('/').map(String::from).collect();
    if path.last().is_some_and(|last| last == "mod") || relative == "lib.rs" {
        path.pop();
    }
    let text = std::fs::read_to_string(file).expect("a file");
    let tree = syn::parse_file(&text).unwrap_or_else(|error| panic!("{relative}: {error}"));
    let mut reader = Reader { children: BTreeSet::new(), module: Module::empty(relative) };
    for item in &tree.items {
        if let syn::Item::Mod(item) = item {
            reader.children.insert(item.ident.to_string());
        }
    }
    reader.visit_file(&tree);
    (path, reader.module)
}

impl Module {
    fn empty(file: String) -> Self {
        Self { file, ..Self::default() }
    }
}

struct Reader {
    children: BTreeSet<String>,
    module: Module,
}

impl Reader {
    fn tree(&mut self, tree: &syn::UseTree, before: &[String], is_re_export: bool) {
        let with = |name: &syn::Ident| before.iter().cloned().chain([name.to_string()]).collect::<Vec<_>>();
        match tree {
            syn::UseTree::Path(path) => self.tree(&path.tree, &with(&path.ident), is_re_export),
            syn::UseTree::Group(group) => group.items.iter().for_each(|tree| self.tree(tree, before, is_re_export)),
            syn::UseTree::Glob(_) => {
                self.module.globs.push(before.to_vec());
                self.add(before.to_vec(), is_re_export);
            }
            syn::UseTree::Name(name) if name.ident == "self" => {
                if let Some(last) = before.last() {
                    self.module.uses.insert(last.clone(), before.to_vec());
                }
                self.add(before.to_vec(), is_re_export);
            }
            syn::UseTree::Name(name) => {
                self.module.uses.insert(name.ident.to_string(), with(&name.ident));
                self.add(with(&name.ident), is_re_export);
            }
            syn::UseTree::Rename(name) => {
                self.module.uses.insert(name.rename.to_string(), with(&name.ident));
                self.add(with(&name.ident), is_re_export);
            }
        }
    }

    fn add(&mut self, path: Vec<String>, is_re_export: bool) {
        let own = path.first().map(|first| if first == "self" { path.get(1) } else { Some(first) });
        let is_below = own.flatten().is_some_and(|first| self.children.contains(first));
        if !(is_re_export && is_below) {
            self.module.paths.push(path);
        }
    }
}

fn is_test(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        attribute.path().is_ident("cfg")
            && attribute.parse_args::<syn::Path>().is_ok_and(|condition| condition.is_ident("test"))
    })
}

impl<'a> Visit<'a> for Reader {
    fn visit_item_mod(&mut self, item: &'a syn::ItemMod) {
        if !is_test(&item.attrs) {
            syn::visit::visit_item_mod(self, item);
        }
    }

    fn visit_item_use(&mut self, item: &'a syn::ItemUse) {
        let is_re_export = !matches!(item.vis, syn::Visibility::Inherited);
        self.tree(&item.tree, &[], is_re_export);
    }

    fn visit_item_impl(&mut self, item: &'a syn::ItemImpl) {
        let names = item.items.iter().filter_map(|item| match item {
            syn::ImplItem::Fn(function) => Some(function.sig.ident.to_string()),
            _ => None,
        });
        if item.trait_.is_some() {
            self.module.of_traits.extend(names);
        } else {
            self.module.methods.extend(names);
        }
        syn::visit::visit_item_impl(self, item);
    }

    fn visit_item_trait(&mut self, item: &'a syn::ItemTrait) {
        self.module.of_traits.extend(item.items.iter().filter_map(|item| match item {
            syn::TraitItem::Fn(function) => Some(function.sig.ident.to_string()),
            _ => None,
        }));
        syn::visit::visit_item_trait(self, item);
    }

    fn visit_expr_method_call(&mut self, call: &'a syn::ExprMethodCall) {
        self.module.calls.insert(call.method.to_string());
        syn::visit::visit_expr_method_call(self, call);
    }

    fn visit_path(&mut self, path: &'a syn::Path) {
        let names: Vec<String> = path.segments.iter().map(|segment| segment.ident.to_string()).collect();
        if let [first, name] = &names[..]
            && first == "Self"
        {
            self.module.calls.insert(name.clone());
        }
        if names.len() > 1 {
            self.module.paths.push(names);
        }
        syn::visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, item: &'a syn::Macro) {
        // Arguments of macros such as `format!` are expressions; what is not is left out.
        let parser = syn::punctuated::Punctuated::<syn::Expr, syn::Token![,]>::parse_terminated;
        if let Ok(arguments) = item.parse_body_with(parser) {
            // The tree lives only here: names are copied.
            let mut inner = Reader { children: self.children.clone(), module: Module::empty(String::new()) };
            arguments.iter().for_each(|argument| inner.visit_expr(argument));
            self.module.paths.append(&mut inner.module.paths);
            self.module.calls.append(&mut inner.module.calls);
        }
    }
}

//! Files: the job's file, what it uses, and stdlib, each parsed once.
//!
//! In: a [`FileProvider`] and the path of the job's file. Out: [`Loaded`], the modules with the job's file first, and
//! what was wrong with the files themselves. Files that use each other in a circle are refused here, so that later
//! passes meet no circle of files.

use super::library::{self, LibraryFile};
use super::similar::nearest;
use super::types::listed;
use crate::diagnostics::{Diagnostic, Severity, codes};
use crate::source::{FileError, FileId, FileProvider, Sources, Span};
use crate::syntax;
use crate::syntax::ast::{Ast, Expr, ExprKind, ItemKind, Name, Type as TypeSyntax, TypeKind, UsePath};
use std::collections::BTreeMap;

/// Largest source file in bytes: a hundred times the largest job we can imagine; beyond it somebody named a data file.
pub const LARGEST_FILE: u64 = 4 << 20;

/// Most files that one job may use: a guard against generated chains, far above any shop's library.
pub const MOST_FILES: usize = 256;

/// A module: an index into [`Loaded::modules`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct ModuleId(pub usize);

/// One file, parsed.
#[derive(Debug)]
pub struct Module {
    pub file: FileId,
    /// As the file provider knows it; `<std>/…` for stdlib.
    pub path: String,
    /// For a file of stdlib that needs `use`, its words joined by dots.
    pub library: Option<&'static LibraryFile>,
    pub ast: Ast,
    /// Places of syntax errors: names and fields may be missing near them without fault of the writer.
    pub broken: Vec<Span>,
    pub uses: Vec<Use>,
}

/// What a `use` brings.
#[derive(Debug)]
pub struct Use {
    /// The name that it brings.
    pub name: Name,
    /// `None` if the file cannot be used; that has been said, and the name is not to be called unknown.
    pub module: Option<ModuleId>,
    /// Whether the name means the module itself (`use "cell.polish"`) or the item of that name in it (`use std.…`).
    pub whole: bool,
}

/// The value that `--set` gives to a parameter.
#[derive(Debug)]
pub enum SetValue {
    /// Parsed; the file is a virtual one named after the option.
    Expression(Expr),
    /// Taken as it is, for a parameter of type `Text`, `File` or `Date`.
    Bare(String, Span),
}

/// Everything that was read.
#[derive(Debug, Default)]
pub struct Loaded {
    pub sources: Sources,
    /// The job's file first, then the others as they were met, then stdlib's core.
    pub modules: Vec<Module>,
    pub sets: BTreeMap<String, SetValue>,
    pub diagnostics: Vec<Diagnostic>,
}

/// Reads the file at `path`, everything it uses and stdlib, and parses the values of `--set`.
pub fn load(files: &dyn FileProvider, path: &str, sets: &[(String, String)]) -> Loaded {
    let mut loader = Loader { files, out: Loaded::default(), known: BTreeMap::new(), chain: Vec::new() };
    match read_text(files, path) {
        Ok(text) => {
            // The job's file may be called `./a.polish` here and `a.polish` by a file that uses it.
            if let Ok(whole) = files.resolve("", path) {
                loader.known.insert(whole, ModuleId(0));
            }
            loader.file(path, text, None);
            loader.set_params(sets);
            loader.project_file();
        }
        Err(unusable) => loader.out.diagnostics.push(*unusable),
    }
    for file in library::FILES.iter().filter(|file| file.core) {
        loader.file(file.path, file.text.to_string(), Some(file));
    }
    loader.out
}

/// stdlib alone with all its modules, for documentation and tests.
pub fn load_library() -> Loaded {
    let files = crate::source::MemoryFiles::default();
    let mut loader = Loader { files: &files, out: Loaded::default(), known: BTreeMap::new(), chain: Vec::new() };
    for file in library::FILES {
        loader.file(file.path, file.text.to_string(), Some(file));
    }
    loader.out
}

/// Why a file cannot be used, in words that end a sentence beginning with the file's name.
pub(super) enum Unusable {
    File(FileError),
    /// The first line that is not.
    NotUtf8(usize),
}

impl Unusable {
    pub(super) fn code(&self) -> crate::diagnostics::Code {
        match self {
            Unusable::File(FileError::Outside) => codes::E0205,
            _ => codes::E0204,
        }
    }

    pub(super) fn words(&self) -> String {
        match self {
            Unusable::File(FileError::NotFound) => "does not exist".into(),
            Unusable::File(FileError::Outside) => "lies outside the project".into(),
            Unusable::File(FileError::TooLarge { size, limit }) => {
                format!("is too large: {size} bytes, at most {limit} are read")
            }
            Unusable::File(FileError::Other(why)) => format!("cannot be read: {why}"),
            Unusable::NotUtf8(line) => format!("is no UTF-8 text: line {line} holds something else, save it as UTF-8"),
        }
    }
}

/// The text of the file at `path`, or why it cannot be used.
pub fn read_text(files: &dyn FileProvider, path: &str) -> Result<String, Box<Diagnostic>> {
    let say = |why: Unusable| Diagnostic::placeless(why.code(), format!("the file `{path}` {}", why.words()));
    read(files, path).map_err(|why| Box::new(say(why)))
}

fn read(files: &dyn FileProvider, path: &str) -> Result<String, Unusable> {
    let bytes = files.read(path, LARGEST_FILE).map_err(Unusable::File)?;
    String::from_utf8(bytes).map_err(|e| {
        let good = &e.as_bytes()[..e.utf8_error().valid_up_to()];
        Unusable::NotUtf8(1 + good.iter().filter(|byte| **byte == b'\n').count())
    })
}

struct Loader<'a> {
    files: &'a dyn FileProvider,
    out: Loaded,
    known: BTreeMap<String, ModuleId>,
    /// The files being read, each because the one before uses it.
    chain: Vec<ModuleId>,
}

impl Loader<'_> {
    fn file(&mut self, path: &str, text: String, library: Option<&'static LibraryFile>) -> ModuleId {
        let file = self.out.sources.add(path, text.as_str());
        let (ast, mistakes) = syntax::parse(file, &text);
        let errors = mistakes.iter().filter(|mistake| mistake.severity == Severity::Error);
        let broken: Vec<Span> = errors.filter_map(|d| d.primary.as_ref()).map(|label| label.span).collect();
        self.out.diagnostics.extend(mistakes);
        let id = ModuleId(self.out.modules.len());
        self.known.insert(path.to_string(), id);
        let uses: Vec<UsePath> = ast
            .items
            .iter()
            .filter_map(|item| if let ItemKind::Use(u) = &item.kind { Some(u.clone()) } else { None })
            .collect();
        self.out.modules.push(Module { file, path: path.to_string(), library, ast, broken, uses: Vec::new() });
        self.chain.push(id);
        for used in uses {
            match used {
                UsePath::Module(words) => {
                    let found = self.use_library(&words);
                    self.out.modules[id.0].uses.extend(found);
                }
                UsePath::File { path, span } => {
                    let found = self.use_file(id, &path, span);
                    self.out.modules[id.0].uses.extend(found);
                }
            }
        }
        self.chain.pop();
        id
    }

    /// What a `use` of stdlib brings. Of a name that does not exist, the names that it most likely meant, so that nobody
    /// calls them unknown where they are used.
    fn use_library(&mut self, words: &[Name]) -> Vec<Use> {
        let (Some(first), Some(last)) = (words.first(), words.last().cloned()) else { return Vec::new() };
        let span = first.span.to(last.span);
        let written = words.iter().map(|word| word.text.as_str()).collect::<Vec<_>>().join(".");
        let module = written.strip_prefix("std.").unwrap_or_default();
        let usable = || library::FILES.iter().filter(|file| !file.core);
        if let Some(file) = library::FILES.iter().find(|file| file.module == module) {
            if file.core {
                self.out.diagnostics.push(
                    Diagnostic::error(
                        codes::E0203,
                        span,
                        format!("`{written}` is visible everywhere and cannot be used"),
                    )
                    .help("delete this line"),
                );
                return Vec::new();
            }
            let known = self.known.get(file.path).copied();
            let module = known.unwrap_or_else(|| self.file(file.path, file.text.to_string(), Some(file)));
            return vec![Use { name: last, module: Some(module), whole: false }];
        }
        let failed = |text: &str| Use { name: Name { text: text.into(), span }, module: None, whole: false };
        let mut brought = vec![failed(&last.text)];
        let mut diagnostic = Diagnostic::error(codes::E0203, span, format!("there is no module `{written}`"));
        let names: Vec<String> = usable().map(|file| format!("std.{}", file.module)).collect();
        let near = nearest(&written, names.iter().map(String::as_str)).or_else(|| {
            // `std.irc5`, `irc5`: the last word alone says which one is meant.
            let mut same = names.iter().filter(|name| name.rsplit('.').next() == Some(last.text.as_str()));
            let only = same.next().filter(|_| same.next().is_none());
            only.map(String::as_str)
        });
        if let Some(near) = near {
            brought.extend(near.rsplit('.').next().filter(|word| *word != last.text).map(failed));
            diagnostic = diagnostic.help(format!("did you mean `{near}`?")).suggest(span, near);
        } else if let ([file, suffix], "polish") = (words, last.text.as_str()) {
            brought.push(failed(&file.text));
            diagnostic = diagnostic
                .help(format!("a file is used by its name in quotes: `\"{}.{}\"`", file.text, suffix.text))
                .suggest(span, format!("\"{}.{}\"", file.text, suffix.text));
        } else if first.text != "std" {
            diagnostic = diagnostic.help("a module's name begins with `std`; a file is used by its name in quotes");
        }
        self.out.diagnostics.push(diagnostic.note(format!("modules: {}", listed(names.iter().map(String::as_str)))));
        brought
    }

    fn use_file(&mut self, from: ModuleId, said: &str, span: Span) -> Option<Use> {
        let stem = said.rsplit('/').next().unwrap_or(said);
        let stem = stem.strip_suffix(".polish").unwrap_or_default();
        let plain = stem.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_');
        if !plain || !stem.starts_with(|c: char| c.is_ascii_lowercase()) {
            let diagnostic = Diagnostic::error(
                codes::E0204,
                span,
                format!("`{said}` cannot be used: its name does not make a name in the language"),
            );
            let last = said.rsplit('/').next().unwrap_or(said);
            self.out.diagnostics.push(match said.ends_with(".polish") || last.is_empty() {
                false if !last.contains('.') => {
                    let mended = format!("\"{said}.polish\"");
                    diagnostic.help(format!("write the whole name of the file: `{mended}`")).suggest(span, mended)
                }
                false if said.starts_with("std.") => {
                    diagnostic.help(format!("a module of stdlib has no quotes: `use {said}`")).suggest(span, said)
                }
                _ => diagnostic
                    .help("name the file in small letters, digits and `_`, ending in `.polish`: `cell.polish`"),
            });
            // A file whose ending is misspelt would have brought its name.
            let text = said.rsplit('/').next().and_then(|last| last.split('.').next()).unwrap_or_default().to_string();
            return (!text.is_empty()).then_some(Use { name: Name { text, span }, module: None, whole: true });
        }
        let name = Name { text: stem.to_string(), span };
        let resolved = self.files.resolve(&self.out.modules[from.0].path, said).map_err(Unusable::File);
        let text = resolved.and_then(|path| {
            if let Some(module) = self.known.get(&path) {
                return Ok((path, Err(*module)));
            }
            read(self.files, &path).map(|text| (path, Ok(text)))
        });
        match text {
            Ok((_, Err(module))) => {
                if let Some(start) = self.chain.iter().position(|link| *link == module) {
                    self.report_circle(start, span);
                    return Some(Use { name, module: None, whole: true });
                }
                Some(Use { name, module: Some(module), whole: true })
            }
            Ok((path, Ok(text))) => {
                if self.out.modules.len() >= MOST_FILES {
                    let message = format!("this job uses more than {MOST_FILES} files");
                    if !self.out.diagnostics.iter().any(|d| d.message == message) {
                        self.out.diagnostics.push(Diagnostic::error(codes::E0204, span, message));
                    }
                    return Some(Use { name, module: None, whole: true });
                }
                Some(Use { name, module: Some(self.file(&path, text, None)), whole: true })
            }
            Err(why) => {
                let mut diagnostic = Diagnostic::error(why.code(), span, format!("the file `{said}` {}", why.words()));
                diagnostic = match &why {
                    Unusable::File(FileError::Outside) => diagnostic
                        .note("a project is the nearest folder upward with a `polish.toml`, else the job's own folder")
                        .help("move the file into the project"),
                    _ => diagnostic.note(format!("it is looked for beside `{}`", self.out.modules[from.0].path)),
                };
                self.out.diagnostics.push(diagnostic);
                Some(Use { name, module: None, whole: true })
            }
        }
    }

    /// `polish.toml` marks a folder and says nothing else: what stands in it would be believed and do nothing.
    fn project_file(&mut self) {
        let Some(path) = self.files.project_file() else { return };
        let text = match read(self.files, &path) {
            Ok(text) => text,
            Err(why) => {
                let message = format!("the project file `{path}` {}", why.words());
                self.out.diagnostics.push(Diagnostic::placeless(codes::E0220, message));
                return;
            }
        };
        let mut at = 0;
        for line in text.split_inclusive('\n') {
            let said = line.split('#').next().unwrap_or_default().trim();
            if !said.is_empty() {
                let start = at + line.len() - line.trim_start().len();
                let file = self.out.sources.add(path.as_str(), text.as_str());
                let key = said.split('=').next().unwrap_or(said).trim();
                let message = format!("`{key}` is no setting: the project file only marks the project's folder");
                self.out.diagnostics.push(
                    Diagnostic::error(codes::E0220, Span::new(file, start, start + said.len()), message)
                        .help("delete the line; what a job needs is said in the job"),
                );
                return;
            }
            at += line.len();
        }
    }

    fn report_circle(&mut self, start: usize, span: Span) {
        let names: Vec<&str> = self.chain[start..].iter().map(|id| self.out.modules[id.0].path.as_str()).collect();
        let diagnostic = match names.as_slice() {
            [one] => {
                Diagnostic::error(codes::E0209, span, format!("the file `{one}` uses itself")).help("delete this line")
            }
            [first, rest @ ..] => {
                let way = rest.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", which uses ");
                let message = format!("the file `{first}` uses itself: it uses {way}, which uses `{first}`");
                Diagnostic::error(codes::E0209, span, message).help("move what both need into a third file")
            }
            [] => return,
        };
        self.out.diagnostics.push(diagnostic);
    }

    /// Parses each `--set`. Only parameters of the job's own file can be set.
    fn set_params(&mut self, sets: &[(String, String)]) {
        let mut params: BTreeMap<String, bool> = BTreeMap::new();
        for item in &self.out.modules[0].ast.items {
            if let ItemKind::Param { name, ty, .. } = &item.kind {
                params.insert(name.text.clone(), takes_bare_text(ty));
            }
        }
        for (name, value) in sets {
            let Some(bare) = params.get(name) else {
                // A syntax error may have swallowed the parameter.
                if !self.out.modules[0].broken.is_empty() {
                    continue;
                }
                let mut diagnostic =
                    Diagnostic::placeless(codes::E0214, format!("`--set {name}`: the job has no `param {name}`"));
                if let Some(near) = nearest(name, params.keys().map(String::as_str)) {
                    diagnostic = diagnostic.help(format!("did you mean `{near}`?"));
                }
                self.out.diagnostics.push(match params.len() {
                    0 => diagnostic.note("it has no parameters at all"),
                    _ => diagnostic.note(format!("its parameters: {}", listed(params.keys().map(String::as_str)))),
                });
                continue;
            };
            if self.out.sets.contains_key(name) {
                let message = format!("`--set {name}` is given twice");
                self.out.diagnostics.push(Diagnostic::placeless(codes::E0214, message).help("give it once"));
                continue;
            }
            let head = "language 1\nlet value = ";
            let quoted = value.len() >= 2 && value.starts_with('"') && value.ends_with('"');
            if *bare && !quoted {
                let file = self.out.sources.add(format!("--set {name}"), value.as_str());
                let span = Span::new(file, 0, value.len());
                self.out.sets.insert(name.clone(), SetValue::Bare(value.clone(), span));
                continue;
            }
            let text = format!("{head}{value}");
            let file = self.out.sources.add(format!("--set {name}"), text.as_str());
            let (ast, mistakes) = syntax::parse(file, &text);
            let one = match ast.items.as_slice() {
                [item] => match &item.kind {
                    ItemKind::Let { value, .. } if mistakes.is_empty() => Some(value.clone()),
                    _ => None,
                },
                _ => None,
            };
            match one {
                // A file in quotes is as much relative to the working directory as one without.
                Some(Expr { kind: ExprKind::Text(text), span }) if *bare => {
                    self.out.sets.insert(name.clone(), SetValue::Bare(text, span));
                }
                Some(expression) => {
                    self.out.sets.insert(name.clone(), SetValue::Expression(expression));
                }
                None => {
                    let message = format!("`--set {name}`: `{value}` is not a value");
                    let span = Span::new(file, head.len(), text.len());
                    let mut diagnostic = Diagnostic::error(codes::E0214, span, message);
                    diagnostic.notes.extend(mistakes.into_iter().map(|mistake| mistake.message));
                    self.out.diagnostics.push(diagnostic.help("write it as in the job: `--set pitch=0.4mm`"));
                    // The parameter counts as given, so that nothing more is said about it.
                    let failed = Expr { span, kind: ExprKind::Missing };
                    self.out.sets.insert(name.clone(), SetValue::Expression(failed));
                }
            }
        }
    }
}

fn takes_bare_text(ty: &TypeSyntax) -> bool {
    match &ty.kind {
        TypeKind::Named(name) => matches!(name.as_str(), "Text" | "File" | "Date"),
        TypeKind::Optional(inner) => takes_bare_text(inner),
        _ => false,
    }
}

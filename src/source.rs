//! Source files: where text comes from and how a place in it is named.
//!
//! In: a [`FileProvider`] (the disk in the command line, a map in tests). Out: [`Sources`], the files read so far,
//! each with a [`FileId`], so that a [`Span`] is three small numbers. stdlib files are virtual, named `<std>/…`.

use std::collections::BTreeMap;

/// A file of this compilation: an index into [`Sources`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FileId(pub u32);

/// A half-open byte range `start..end` of one file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Span {
    pub file: FileId,
    pub start: u32,
    pub end: u32,
}

impl Span {
    /// The span from byte `start` to byte `end` of `file`.
    pub fn new(file: FileId, start: usize, end: usize) -> Span {
        Span { file, start: start as u32, end: end as u32 }
    }

    /// The smallest span that holds both; `other` must lie in the same file.
    pub fn to(self, other: Span) -> Span {
        Span { file: self.file, start: self.start.min(other.start), end: self.end.max(other.end) }
    }
}

/// Why a file could not be had. The words are the diagnostics'.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FileError {
    /// There is no such file.
    NotFound,
    /// It is there but larger than the stated limit in bytes.
    TooLarge { size: u64, limit: u64 },
    /// It lies outside the project.
    Outside,
    /// Anything else that the system said.
    Other(String),
}

/// The world of files, as far as the compiler may see it. Paths are `/`-separated and resolved by the caller.
pub trait FileProvider: Send + Sync {
    /// The whole content of the file at `path`, at most `limit` bytes.
    fn read(&self, path: &str, limit: u64) -> Result<Vec<u8>, FileError>;

    /// `path` as said in the file `from`, made whole: relative to the folder of `from`, checked to lie inside the
    /// project (`Outside` if not), with `.` and `..` and links resolved. An empty `from` means the working directory:
    /// the path was typed by a person (`--set map=…`), so any place is allowed.
    fn resolve(&self, from: &str, path: &str) -> Result<String, FileError>;

    /// The names of what stands in the folder at `path`, in order; `NotFound` if there is no such folder, as for a provider
    /// that knows no folders.
    fn list(&self, path: &str) -> Result<Vec<String>, FileError> {
        let _ = path;
        Err(FileError::NotFound)
    }

    /// The `polish.toml` that marks the project's folder, if there is one.
    fn project_file(&self) -> Option<String> {
        None
    }
}

/// Files in memory, for tests and for use as a library. Keys are whole paths.
#[derive(Clone, Debug, Default)]
pub struct MemoryFiles(pub BTreeMap<String, Vec<u8>>);

impl FileProvider for MemoryFiles {
    fn read(&self, path: &str, limit: u64) -> Result<Vec<u8>, FileError> {
        let bytes = self.0.get(path).ok_or(FileError::NotFound)?;
        let size = bytes.len() as u64;
        if size > limit {
            return Err(FileError::TooLarge { size, limit });
        }
        Ok(bytes.clone())
    }

    fn resolve(&self, from: &str, path: &str) -> Result<String, FileError> {
        normalise(from, path).ok_or(FileError::Outside)
    }

    fn list(&self, path: &str) -> Result<Vec<String>, FileError> {
        let inside = |key: &String| Some(key.strip_prefix(path)?.strip_prefix('/')?.split('/').next()?.to_string());
        let mut names: Vec<String> = self.0.keys().filter_map(inside).collect();
        names.dedup();
        if names.is_empty() { Err(FileError::NotFound) } else { Ok(names) }
    }
}

/// `path` taken relative to the folder of the file `from`, with `.` and `..` worked out; `None` if it climbs above the
/// root of the in-memory tree.
pub fn normalise(from: &str, path: &str) -> Option<String> {
    if path.starts_with('/') {
        return None;
    }
    let mut parts: Vec<&str> = from.split('/').collect();
    parts.pop();
    for part in path.split('/') {
        match part {
            "" | "." => {}
            ".." => {
                parts.pop()?;
            }
            word => parts.push(word),
        }
    }
    Some(parts.join("/"))
}

/// The text files of one compilation, in the order they were read.
#[derive(Clone, Debug, Default)]
pub struct Sources {
    files: Vec<(String, String)>,
}

impl Sources {
    /// Adds a file and says which it is.
    pub fn add(&mut self, name: impl Into<String>, text: impl Into<String>) -> FileId {
        let id = FileId(self.files.len() as u32);
        self.files.push((name.into(), text.into()));
        id
    }

    /// The file's name as shown to people.
    pub fn name(&self, id: FileId) -> &str {
        &self.files[id.0 as usize].0
    }

    /// The file's text.
    pub fn text(&self, id: FileId) -> &str {
        &self.files[id.0 as usize].1
    }

    /// The file of that name, if it was added.
    pub fn find(&self, name: &str) -> Option<FileId> {
        self.files.iter().position(|(n, _)| n == name).map(|i| FileId(i as u32))
    }

    /// The text under `span`.
    pub fn slice(&self, span: Span) -> &str {
        &self.text(span.file)[span.start as usize..span.end as usize]
    }

    /// All files, in order.
    pub fn iter(&self) -> impl Iterator<Item = (FileId, &str, &str)> {
        self.files.iter().enumerate().map(|(i, (n, t))| (FileId(i as u32), n.as_str(), t.as_str()))
    }

    /// One-based line and column (in characters) of byte `at`.
    pub fn line_column(&self, id: FileId, at: usize) -> (usize, usize) {
        let text = self.text(id);
        let before = &text[..at.min(text.len())];
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
    }
}

//! The disk as a [`FileProvider`]: the only place that opens files for reading.
//!
//! Paths inside a job are relative to the file that says them and must lie inside the project: the nearest folder
//! upward from the job with a `polish.toml`, else the job's own folder. A path said on the command line (`from` empty)
//! is relative to the working directory and always allowed.
#![allow(clippy::disallowed_methods, reason = "cli is where the disk is")]

use super::output::words;
use crate::source::{FileError, FileProvider};
use std::io::Read;
use std::path::{Component, Path, PathBuf};

/// Marks the folder of a project.
const PROJECT_FILE: &str = "polish.toml";

/// The disk, seen from one job.
pub struct Disk {
    root: PathBuf,
    here: PathBuf,
    allow_outside: bool,
}

impl Disk {
    /// For the job file at `job`. A job that does not exist gives a provider whose reads fail with `NotFound`.
    pub fn new(job: &Path, allow_outside: bool) -> Disk {
        let here = std::env::current_dir().and_then(|d| d.canonicalize()).unwrap_or_else(|_| PathBuf::from("."));
        let job = job.canonicalize().unwrap_or_else(|_| lexical(&here.join(job)));
        let folder = job.parent().map_or_else(|| here.clone(), Path::to_path_buf);
        let root = folder.ancestors().find(|f| f.join(PROJECT_FILE).is_file()).unwrap_or(&folder).to_path_buf();
        Disk { root, here, allow_outside }
    }

    /// The path as people see it: relative to the working directory where it lies inside.
    fn shown(&self, path: &Path) -> String {
        path.strip_prefix(&self.here).unwrap_or(path).to_string_lossy().into_owned()
    }
}

impl FileProvider for Disk {
    fn read(&self, path: &str, limit: u64) -> Result<Vec<u8>, FileError> {
        let path = self.here.join(path);
        let say = |e: std::io::Error| match e.kind() {
            std::io::ErrorKind::NotFound => FileError::NotFound,
            _ => FileError::Other(words(&e)),
        };
        let meta = std::fs::metadata(&path).map_err(say)?;
        if meta.is_dir() {
            return Err(FileError::Other("it is a folder".into()));
        }
        if meta.len() > limit {
            return Err(FileError::TooLarge { size: meta.len(), limit });
        }
        // Pipes and devices have no length of their own: the reader itself is bounded as well.
        let mut bytes = Vec::with_capacity(meta.len() as usize);
        let file = std::fs::File::open(&path).map_err(say)?;
        file.take(limit + 1).read_to_end(&mut bytes).map_err(say)?;
        if bytes.len() as u64 > limit {
            return Err(FileError::TooLarge { size: bytes.len() as u64, limit });
        }
        Ok(bytes)
    }

    fn resolve(&self, from: &str, path: &str) -> Result<String, FileError> {
        if path.contains('\0') {
            return Err(FileError::Other("the path holds a zero byte".into()));
        }
        let base = if from.is_empty() {
            self.here.clone()
        } else {
            self.here.join(from).parent().map_or_else(|| self.here.clone(), Path::to_path_buf)
        };
        let whole = lexical(&base.join(path));
        let whole = whole.canonicalize().unwrap_or(whole);
        if !from.is_empty() && !self.allow_outside && !whole.starts_with(&self.root) {
            return Err(FileError::Outside);
        }
        Ok(self.shown(&whole))
    }

    fn list(&self, path: &str) -> Result<Vec<String>, FileError> {
        let say = |e: std::io::Error| match e.kind() {
            std::io::ErrorKind::NotFound => FileError::NotFound,
            _ => FileError::Other(words(&e)),
        };
        let entries = std::fs::read_dir(self.here.join(path)).map_err(say)?;
        let name = |entry: std::io::Result<std::fs::DirEntry>| {
            entry.map(|entry| entry.file_name().to_string_lossy().into_owned()).map_err(say)
        };
        let mut names = entries.map(name).collect::<Result<Vec<String>, FileError>>()?;
        names.sort();
        Ok(names)
    }

    fn project_file(&self) -> Option<String> {
        let path = self.root.join(PROJECT_FILE);
        path.is_file().then(|| self.shown(&path))
    }
}

/// `.` and `..` worked out without asking the disk, for files that do not exist.
fn lexical(path: &Path) -> PathBuf {
    let mut out = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir => {
                out.pop();
            }
            part => out.push(part),
        }
    }
    out
}

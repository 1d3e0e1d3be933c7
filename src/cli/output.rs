//! Writing: all files of a build, or none.
//!
//! In: names and bytes. Out: the files in the folder, each moved into place only after every one of them was written
//! whole beside it. A build that fails on the way leaves the folder as it was.
#![allow(clippy::disallowed_methods, reason = "cli is where the disk is")]

use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// The moves that a build makes on a file system; a test can make any of them fail.
pub trait Folder {
    fn create(&mut self, folder: &Path) -> io::Result<()>;
    fn write(&mut self, path: &Path, bytes: &[u8]) -> io::Result<()>;
    fn rename(&mut self, from: &Path, to: &Path) -> io::Result<()>;
    fn remove(&mut self, path: &Path) -> io::Result<()>;
    fn exists(&self, path: &Path) -> bool;
}

/// The real one.
pub struct RealFolder;

impl Folder for RealFolder {
    fn create(&mut self, folder: &Path) -> io::Result<()> {
        std::fs::create_dir_all(folder)
    }
    fn write(&mut self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        let mut file = std::fs::File::create(path)?;
        file.write_all(bytes)?;
        // A full disk may only say so when the bytes are really put down.
        file.sync_all()
    }
    fn rename(&mut self, from: &Path, to: &Path) -> io::Result<()> {
        // Somebody's folder is not moved out of the way.
        if from.is_dir() {
            return Err(io::Error::new(io::ErrorKind::IsADirectory, "a folder stands in its place"));
        }
        std::fs::rename(from, to)
    }
    fn remove(&mut self, path: &Path) -> io::Result<()> {
        std::fs::remove_file(path)
    }
    fn exists(&self, path: &Path) -> bool {
        path.exists()
    }
}

/// What the system says, without its own numbering: `not a directory`.
pub fn words(error: &io::Error) -> String {
    let text = error.to_string();
    let text = text.split(" (os error").next().unwrap_or(&text);
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_lowercase().chain(letters).collect())
}

/// Puts `files` into `folder`, and takes away `stale` (files of an earlier build that this one does not make).
/// On any error nothing of the new build stays and everything of the old one is where it was.
pub fn write_all(
    disk: &mut dyn Folder,
    folder: &Path,
    files: &[(String, Vec<u8>)],
    stale: &[String],
) -> Result<(), String> {
    let say = |path: &Path, e: io::Error| format!("`{}` could not be written: {}", path.display(), words(&e));
    disk.create(folder).map_err(|e| say(folder, e))?;
    let new = |name: &str| folder.join(format!("{name}.new"));
    let old = |name: &str| folder.join(format!("{name}.old"));
    for (i, (name, bytes)) in files.iter().enumerate() {
        if let Err(e) = disk.write(&new(name), bytes) {
            for (name, _) in &files[..=i] {
                disk.remove(&new(name)).ok();
            }
            return Err(say(&folder.join(name), e));
        }
    }
    let mut undo: Vec<(PathBuf, PathBuf)> = Vec::new();
    let result = swap(disk, folder, files, stale, &new, &old, &mut undo);
    match result {
        Ok(()) => {
            for name in files.iter().map(|(name, _)| name).chain(stale) {
                if disk.exists(&old(name)) {
                    disk.remove(&old(name)).ok();
                }
            }
            Ok(())
        }
        Err((path, e)) => {
            for (from, to) in undo.iter().rev() {
                disk.rename(to, from).ok();
            }
            for (name, _) in files {
                disk.remove(&new(name)).ok();
            }
            Err(say(&path, e))
        }
    }
}

fn swap(
    disk: &mut dyn Folder,
    folder: &Path,
    files: &[(String, Vec<u8>)],
    stale: &[String],
    new: &dyn Fn(&str) -> PathBuf,
    old: &dyn Fn(&str) -> PathBuf,
    undo: &mut Vec<(PathBuf, PathBuf)>,
) -> Result<(), (PathBuf, io::Error)> {
    let mut step = |disk: &mut dyn Folder, from: PathBuf, to: PathBuf| match disk.rename(&from, &to) {
        Ok(()) => {
            undo.push((from, to));
            Ok(())
        }
        Err(e) => Err((from, e)),
    };
    for name in files.iter().map(|(name, _)| name).chain(stale) {
        let place = folder.join(name);
        if disk.exists(&place) {
            step(disk, place, old(name))?;
        }
    }
    for (name, _) in files {
        step(disk, new(name), folder.join(name))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    /// A folder in memory whose n-th move fails.
    #[derive(Default)]
    struct Failing {
        files: BTreeMap<PathBuf, Vec<u8>>,
        moves: usize,
        fails_at: usize,
    }

    impl Failing {
        fn count(&mut self) -> io::Result<()> {
            self.moves += 1;
            if self.moves == self.fails_at {
                return Err(io::Error::new(io::ErrorKind::StorageFull, "no space left on device"));
            }
            Ok(())
        }
    }

    impl Folder for Failing {
        fn create(&mut self, _: &Path) -> io::Result<()> {
            self.count()
        }
        fn write(&mut self, path: &Path, bytes: &[u8]) -> io::Result<()> {
            let result = self.count();
            // A full disk leaves half a file behind.
            let kept = if result.is_ok() { bytes } else { &bytes[..bytes.len() / 2] };
            self.files.insert(path.to_path_buf(), kept.to_vec());
            result
        }
        fn rename(&mut self, from: &Path, to: &Path) -> io::Result<()> {
            self.count()?;
            let bytes = self.files.remove(from).ok_or(io::ErrorKind::NotFound)?;
            self.files.insert(to.to_path_buf(), bytes);
            Ok(())
        }
        fn remove(&mut self, path: &Path) -> io::Result<()> {
            self.files.remove(path);
            Ok(())
        }
        fn exists(&self, path: &Path) -> bool {
            self.files.contains_key(path)
        }
    }

    #[test]
    fn a_failure_at_any_move_leaves_the_old_build_whole() {
        let before: BTreeMap<PathBuf, Vec<u8>> =
            [("d/a.mod", "old a"), ("d/b.mod", "old b"), ("d/gone.mod", "old"), ("d/notes.txt", "the user's own")]
                .map(|(p, t)| (PathBuf::from(p), t.as_bytes().to_vec()))
                .into();
        let files = [("a.mod".to_string(), b"new a".to_vec()), ("b.mod".to_string(), b"new b".to_vec())];
        let stale = ["gone.mod".to_string()];
        let mut succeeded = false;
        for fails_at in 1..20 {
            let mut disk = Failing { files: before.clone(), moves: 0, fails_at };
            match write_all(&mut disk, Path::new("d"), &files, &stale) {
                Err(message) => {
                    assert!(message.contains("no space left"), "{message}");
                    assert_eq!(disk.files, before, "failing at move {fails_at}");
                }
                Ok(()) => {
                    succeeded = true;
                    assert_eq!(disk.files[Path::new("d/a.mod")], b"new a");
                    assert!(!disk.files.contains_key(Path::new("d/gone.mod")));
                    assert_eq!(disk.files[Path::new("d/notes.txt")], b"the user's own");
                    assert_eq!(disk.files.len(), 3);
                }
            }
        }
        assert!(succeeded, "the last rounds have fewer than {} moves and must succeed", 19);
    }
}

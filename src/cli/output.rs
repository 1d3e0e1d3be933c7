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
    /// Takes an empty folder away; one that holds something stays.
    fn remove_folder(&mut self, folder: &Path) -> io::Result<()>;
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
    fn remove_folder(&mut self, folder: &Path) -> io::Result<()> {
        std::fs::remove_dir(folder)
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

/// What one job writes.
pub struct Output {
    pub folder: PathBuf,
    /// Names inside the folder, and bytes.
    pub files: Vec<(String, Vec<u8>)>,
    /// Files of an earlier build that this one does not make.
    pub stale: Vec<String>,
}

impl Output {
    fn new_place(&self, name: &str) -> PathBuf {
        self.folder.join(format!("{name}.new"))
    }

    fn old_place(&self, name: &str) -> PathBuf {
        self.folder.join(format!("{name}.old"))
    }
}

/// Puts the files of all `outputs` into their folders and takes their stale ones away. On any error nothing of the new
/// build stays and everything of the old one is where it was.
pub fn write_all(disk: &mut dyn Folder, outputs: &[Output]) -> Result<(), String> {
    let mut undo = Undo::default();
    match put(disk, outputs, &mut undo) {
        Ok(()) => {
            for output in outputs {
                for name in output.files.iter().map(|(name, _)| name).chain(&output.stale) {
                    if disk.exists(&output.old_place(name)) {
                        disk.remove(&output.old_place(name)).ok();
                    }
                }
            }
            Ok(())
        }
        Err((path, e)) => {
            undo.all(disk);
            Err(format!("`{}` could not be written: {}", path.display(), words(&e)))
        }
    }
}

/// What was done so far, to be taken back.
#[derive(Default)]
struct Undo {
    folders: Vec<PathBuf>,
    written: Vec<PathBuf>,
    renamed: Vec<(PathBuf, PathBuf)>,
}

impl Undo {
    fn all(&self, disk: &mut dyn Folder) {
        for (from, to) in self.renamed.iter().rev() {
            disk.rename(to, from).ok();
        }
        for path in &self.written {
            disk.remove(path).ok();
        }
        for folder in self.folders.iter().rev() {
            disk.remove_folder(folder).ok();
        }
    }

    fn rename(&mut self, disk: &mut dyn Folder, from: PathBuf, to: PathBuf) -> Result<(), (PathBuf, io::Error)> {
        match disk.rename(&from, &to) {
            Ok(()) => {
                self.renamed.push((from, to));
                Ok(())
            }
            Err(e) => Err((from, e)),
        }
    }
}

fn put(disk: &mut dyn Folder, outputs: &[Output], undo: &mut Undo) -> Result<(), (PathBuf, io::Error)> {
    for output in outputs {
        if !disk.exists(&output.folder) {
            undo.folders.push(output.folder.clone());
        }
        disk.create(&output.folder).map_err(|e| (output.folder.clone(), e))?;
        for (name, bytes) in &output.files {
            // Noted before it is written: a full disk leaves half a file.
            undo.written.push(output.new_place(name));
            disk.write(&output.new_place(name), bytes).map_err(|e| (output.folder.join(name), e))?;
        }
    }
    for output in outputs {
        for name in output.files.iter().map(|(name, _)| name).chain(&output.stale) {
            let place = output.folder.join(name);
            if disk.exists(&place) {
                undo.rename(disk, place, output.old_place(name))?;
            }
        }
        for (name, _) in &output.files {
            undo.rename(disk, output.new_place(name), output.folder.join(name))?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::{BTreeMap, BTreeSet};

    /// A disk in memory whose n-th move fails.
    #[derive(Default)]
    struct Failing {
        files: BTreeMap<PathBuf, Vec<u8>>,
        folders: BTreeSet<PathBuf>,
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
        fn create(&mut self, folder: &Path) -> io::Result<()> {
            self.count()?;
            self.folders.insert(folder.to_path_buf());
            Ok(())
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
        fn remove_folder(&mut self, folder: &Path) -> io::Result<()> {
            assert!(!self.files.keys().any(|file| file.starts_with(folder)), "a folder with files is not empty");
            self.folders.remove(folder);
            Ok(())
        }
        fn exists(&self, path: &Path) -> bool {
            self.files.contains_key(path) || self.folders.contains(path)
        }
    }

    #[test]
    fn a_failure_at_any_move_leaves_the_old_build_whole() {
        let before: BTreeMap<PathBuf, Vec<u8>> =
            [("d/a.mod", "old a"), ("d/b.mod", "old b"), ("d/gone.mod", "old"), ("d/notes.txt", "the user's own")]
                .map(|(p, t)| (PathBuf::from(p), t.as_bytes().to_vec()))
                .into();
        let folders = BTreeSet::from([PathBuf::from("d")]);
        // Two jobs of one file: the folder of the second is new.
        let outputs = [
            Output {
                folder: "d".into(),
                files: vec![("a.mod".to_string(), b"new a".to_vec()), ("b.mod".to_string(), b"new b".to_vec())],
                stale: vec!["gone.mod".to_string()],
            },
            Output { folder: "e".into(), files: vec![("c.mod".to_string(), b"new c".to_vec())], stale: Vec::new() },
        ];
        let mut succeeded = false;
        for fails_at in 1..20 {
            let mut disk = Failing { files: before.clone(), folders: folders.clone(), moves: 0, fails_at };
            match write_all(&mut disk, &outputs) {
                Err(message) => {
                    assert!(message.contains("no space left"), "{message}");
                    assert_eq!(disk.files, before, "failing at move {fails_at}");
                    assert_eq!(disk.folders, folders, "failing at move {fails_at}");
                }
                Ok(()) => {
                    succeeded = true;
                    assert_eq!(disk.files[Path::new("d/a.mod")], b"new a");
                    assert!(!disk.files.contains_key(Path::new("d/gone.mod")));
                    assert_eq!(disk.files[Path::new("d/notes.txt")], b"the user's own");
                    assert_eq!(disk.files[Path::new("e/c.mod")], b"new c");
                    assert_eq!(disk.files.len(), 4);
                }
            }
        }
        assert!(succeeded, "the last rounds have fewer than {} moves and must succeed", 19);
    }
}

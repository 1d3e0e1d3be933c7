//! The files of a job as its passes read them.
//!
//! In: a [`FileProvider`]. Out: the same, which knows the hash of every file that was read: what a result names as its inputs is what
//! the plan was made from, not what stands on the disk when the plan is done.

use crate::source::{FileError, FileProvider};
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

pub(super) struct Hashed<'a> {
    files: &'a dyn FileProvider,
    read: Mutex<BTreeMap<String, blake3::Hash>>,
}

impl<'a> Hashed<'a> {
    pub fn new(files: &'a dyn FileProvider) -> Hashed<'a> {
        Hashed { files, read: Mutex::default() }
    }

    /// The hash of a file, if it was read.
    pub fn hash(&self, path: &str) -> Option<blake3::Hash> {
        self.read.lock().unwrap_or_else(PoisonError::into_inner).get(path).copied()
    }
}

impl FileProvider for Hashed<'_> {
    fn read(&self, path: &str, limit: u64) -> Result<Vec<u8>, FileError> {
        let bytes = self.files.read(path, limit)?;
        let hash = blake3::hash(&bytes);
        let mut read = self.read.lock().unwrap_or_else(PoisonError::into_inner);
        match read.insert(path.to_string(), hash) {
            Some(earlier) if earlier != hash => Err(FileError::Other("it changed while the job was planned".into())),
            _ => Ok(bytes),
        }
    }

    fn resolve(&self, from: &str, path: &str) -> Result<String, FileError> {
        self.files.resolve(from, path)
    }

    fn list(&self, path: &str) -> Result<Vec<String>, FileError> {
        self.files.list(path)
    }

    fn project_file(&self) -> Option<String> {
        self.files.project_file()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU8, Ordering};

    /// Another content at every read.
    struct Growing(AtomicU8);

    impl FileProvider for Growing {
        fn read(&self, _: &str, _: u64) -> Result<Vec<u8>, FileError> {
            Ok(vec![self.0.fetch_add(1, Ordering::Relaxed)])
        }

        fn resolve(&self, _: &str, path: &str) -> Result<String, FileError> {
            Ok(path.into())
        }
    }

    #[test]
    fn a_file_that_changes_while_it_is_read_is_refused() {
        let growing = Growing(AtomicU8::new(7));
        let files = Hashed::new(&growing);
        assert_eq!(files.hash("map"), None);
        assert_eq!(files.read("map", 10).ok(), Some(vec![7]));
        assert_eq!(files.hash("map"), Some(blake3::hash(&[7])));
        assert!(matches!(files.read("map", 10), Err(FileError::Other(_))));
    }
}

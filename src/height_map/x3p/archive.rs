//! The archive: parts of a ZIP file, each unpacked up to a size that was known before.

use crate::diagnostics::Problem;
use crate::height_map::refusals::{container, sizes};
use std::io::{Cursor, Read};
use zip::ZipArchive;
use zip::result::ZipError;

/// Most bytes of the description. Without heights it has two thousand; as text a height takes some forty, and whoever has
/// more than a million stores them as bytes.
pub(super) const MOST_DESCRIPTION: u64 = 1 << 26;

/// How often the mark of an archive's end may stand in it. By chance it stands once in four thousand million bytes;
/// a file full of them makes a reader look behind each.
const MOST_ENDS: usize = 8;

pub(super) struct Archive<'a> {
    archive: ZipArchive<Cursor<&'a [u8]>>,
    name: &'a str,
}

impl<'a> Archive<'a> {
    /// E0518 for what is no archive, or one that could keep its reader busy.
    pub fn open(bytes: &'a [u8], name: &'a str) -> Result<Archive<'a>, Problem> {
        let ends: Vec<usize> = ends(bytes).take(MOST_ENDS + 1).collect();
        if ends.is_empty() {
            return Err(sizes(name, "is cut short: the list at the end of a ZIP archive is missing"));
        }
        // The tables of large archives (ZIP64) may claim as many parts as the file has bytes.
        let large = ends.iter().any(|end| end.checked_sub(20).is_some_and(|at| bytes[at..].starts_with(b"PK\x06\x07")));
        if large || ends.len() > MOST_ENDS {
            return Err(container(name, "is a ZIP archive of a kind that no instrument writes"));
        }
        match ZipArchive::new(Cursor::new(bytes)) {
            Ok(archive) => Ok(Archive { archive, name }),
            Err(_) => Err(container(name, "is a damaged ZIP archive")),
        }
    }

    /// The bytes of a part, if there is one of that name. E0518 for one that has more than `most` bytes, or cannot be
    /// unpacked.
    pub fn part(&mut self, part: &str, most: u64) -> Result<Option<Vec<u8>>, Problem> {
        let name = self.name;
        let damaged = || container(name, format!("holds a part `{part}` that cannot be unpacked"));
        let file = match self.archive.by_name(part) {
            Ok(file) => file,
            Err(ZipError::FileNotFound) => return Ok(None),
            Err(_) => return Err(damaged()),
        };
        // What the archive says of the size may be a lie: it only saves the work.
        let mut bytes = Vec::with_capacity(file.size().min(most).min(1 << 20) as usize);
        file.take(most + 1).read_to_end(&mut bytes).map_err(|_| damaged())?;
        if bytes.len() as u64 > most {
            let message = format!("holds a part `{part}` that unpacks to more than the {most} bytes it may have");
            return Err(container(name, message));
        }
        Ok(Some(bytes))
    }
}

/// Where the marks of an archive's end stand.
fn ends(bytes: &[u8]) -> impl Iterator<Item = usize> + '_ {
    bytes.windows(4).enumerate().filter(|(_, mark)| *mark == b"PK\x05\x06").map(|(at, _)| at)
}

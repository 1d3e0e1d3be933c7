//! HDF5: the little of it that files of interferometers need, each part proved before it is used.
//!
//! The container is read by the crate `hdf5-reader`, in memory alone: links to other files are not followed, and what may
//! be read at once is bounded. Its errors speak of the container's inside, so they become one sentence here.
//!
//! Source: *HDF5 File Format Specification*, version 3.0.

use super::element::{Element, Kind};
use super::refusals::{container, no_map, sizes, unread};
use super::{MOST_PIXELS, RawMap, datx, four_sight, proved_pixels, text};
use crate::diagnostics::Problem;
use hdf5_reader::{Attribute, ByteOrder, Dataset, Datatype, Hdf5File, OpenOptions};

const MAGIC: &[u8] = b"\x89HDF\r\n\x1A\n";

/// Most bytes of what stands about one object of the container: a hundred times what Zygo writes.
const MOST_HEADER: usize = 1 << 22;

/// Whether the bytes begin as a file of HDF5 does.
pub fn is_hdf5(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// Reads the map of a file of HDF5. Fields are `file`; errors as of [`content`](super::content).
pub fn read(bytes: &[u8], name: &str) -> Result<RawMap, Problem> {
    let file = File::open(bytes, name)?;
    if datx::is_datx(&file) {
        datx::read(&file, name)
    } else if four_sight::is_four_sight(&file) {
        four_sight::read(&file, name)
    } else {
        let message = "is an HDF5 file without heights where Zygo (`/Data/Surface`) or 4D (`/measurement0/genraw/data`) keeps them";
        Err(unread(name, message, "save the measured surface itself, or an array as `.npy`"))
    }
}

/// A file of HDF5 in memory.
pub(super) struct File<'a> {
    file: Hdf5File,
    name: &'a str,
}

impl<'a> File<'a> {
    /// E0503 for a file that is shorter than it says, E0518 for one that is no HDF5 inside.
    pub fn open(bytes: &[u8], name: &'a str) -> Result<File<'a>, Problem> {
        if let Some(end) = end_of_file(bytes)
            && end > bytes.len() as u64
        {
            let message = format!("is cut short: it has {} bytes and should have {end}", bytes.len());
            return Err(sizes(name, message));
        }
        let options = OpenOptions::default()
            .with_chunk_cache_bytes(0)
            .with_max_object_header_bytes(MOST_HEADER)
            .with_max_chunk_bytes(8 * MOST_PIXELS as usize)
            .with_max_read_bytes(8 * MOST_PIXELS as usize);
        match Hdf5File::from_bytes_with_options(bytes, options) {
            Ok(file) => Ok(File { file, name }),
            Err(_) => Err(damaged(name)),
        }
    }

    /// Whether there is a group at `path`.
    pub fn has_group(&self, path: &str) -> bool {
        self.file.group(path).is_ok()
    }

    /// An attribute of the group at `path`, if both are there.
    pub fn group_attribute(&self, path: &str, attribute: &str) -> Option<Attribute> {
        self.file.group(path).ok()?.attribute(attribute).ok()
    }

    /// All attributes of the groups in the group at `path`, as far as they can be read.
    pub fn attributes_below(&self, path: &str) -> Vec<Attribute> {
        let groups = self.file.group(path).and_then(|group| group.groups()).unwrap_or_default();
        groups.iter().filter_map(|group| group.attributes().ok()).flatten().collect()
    }

    /// The data set at `path`, if there is one.
    pub fn dataset(&self, path: &str) -> Option<Dataset> {
        self.file.dataset(path).ok()
    }

    /// The data sets of the group at `path`. E0518 if there is no group, or its list is damaged.
    pub fn datasets(&self, path: &str) -> Result<Vec<Dataset>, Problem> {
        self.file.group(path).and_then(|group| group.datasets()).map_err(|_| damaged(self.name))
    }

    /// Columns, rows and numbers of a two-dimensional array. E0505 for any other, E0501 for too many pixels, E0518 for
    /// one that cannot be read.
    pub fn picture(&self, dataset: &Dataset) -> Result<(usize, usize, Vec<f64>), Problem> {
        let &[rows, columns] = dataset.shape() else {
            return Err(no_map(self.name, format!("holds heights of {} dimensions; a map has two", dataset.ndim())));
        };
        let pixels = proved_pixels(columns, rows, self.name)?;
        let Some(element) = element(dataset.dtype()) else {
            return Err(no_map(self.name, "holds heights that are no real numbers of 1 to 8 bytes"));
        };
        let (columns, rows) = (columns as usize, rows as usize);
        let values = if dataset.chunks().is_some() {
            self.chunked(dataset, columns, rows, element)?
        } else {
            let bytes = dataset.read_raw_bytes().map_err(|_| damaged(self.name))?;
            if bytes.len() != pixels * element.size {
                return Err(damaged(self.name));
            }
            element.decode_all(&bytes)
        };
        // What was never written reads as zeros.
        if values.iter().all(|value| *value == 0.0) {
            return Err(container(self.name, "holds nothing but zeros: its heights were never written"));
        }
        Ok((columns, rows, values))
    }

    /// An array that is stored in pieces. Each must be there once: the container would take zeros for those that are not.
    fn chunked(&self, dataset: &Dataset, columns: usize, rows: usize, element: Element) -> Result<Vec<f64>, Problem> {
        let broken = || damaged(self.name);
        let mut values = vec![0.0; columns * rows];
        let mut seen = vec![false; columns * rows];
        let mut pixels = 0;
        for chunk in dataset.iter_chunks().map_err(|_| broken())? {
            let chunk = chunk.map_err(|_| broken())?;
            let (&[first_row, first_column], &[height, width]) = (chunk.offsets(), chunk.shape()) else {
                return Err(broken());
            };
            let [first_row, first_column, height, width] =
                [first_row, first_column, height, width].map(|side| usize::try_from(side).unwrap_or(usize::MAX));
            if first_row >= rows || first_column >= columns || width == 0 {
                return Err(broken());
            }
            let (height, inside) = (height.min(rows - first_row), width.min(columns - first_column));
            for (row, line) in chunk.bytes().chunks_exact(width.saturating_mul(element.size)).take(height).enumerate() {
                let at = (first_row + row) * columns + first_column;
                let places = values[at..at + inside].iter_mut().zip(&mut seen[at..at + inside]);
                for ((value, seen), bytes) in places.zip(line.chunks_exact(element.size)) {
                    // Pieces that lie over each other would hide that others are missing, and keep their reader busy.
                    if std::mem::replace(seen, true) {
                        return Err(broken());
                    }
                    *value = element.decode(bytes);
                    pixels += 1;
                }
            }
        }
        if pixels < values.len() {
            let message = format!("is cut short: {pixels} of its {} heights are stored", values.len());
            return Err(sizes(self.name, message));
        }
        Ok(values)
    }
}

/// Where the file ends by its superblock of version 0 or 1 with addresses of eight bytes; for others the container's own
/// checks must do.
fn end_of_file(bytes: &[u8]) -> Option<u64> {
    let (version, addresses) = (*bytes.get(8)?, *bytes.get(13)?);
    let at = match version {
        0 => 40,
        1 => 44,
        _ => return None,
    };
    let field: [u8; 8] = bytes.get(at..at + 8)?.try_into().ok()?;
    (addresses == 8).then(|| u64::from_le_bytes(field))
}

fn damaged(name: &str) -> Problem {
    container(name, "is a damaged HDF5 file: what its header points at is not there, or not what it should be")
}

fn element(datatype: &Datatype) -> Option<Element> {
    let (kind, size, order) = match datatype {
        Datatype::FloatingPoint { size: size @ (4 | 8), byte_order } => (Kind::Float, *size, *byte_order),
        Datatype::FixedPoint { size: size @ 1..=8, signed, byte_order } => {
            (if *signed { Kind::Signed } else { Kind::Unsigned }, *size, *byte_order)
        }
        _ => return None,
    };
    Some(Element { kind, size: usize::from(size), big_endian: order == ByteOrder::BigEndian })
}

/// The number of an attribute that holds one, or a list of which it is the first.
pub(super) fn number(attribute: &Attribute) -> Option<f64> {
    let element = element(&attribute.datatype)?;
    attribute.raw_data.get(..element.size).map(|bytes| element.decode(bytes))
}

/// The text of an attribute that holds one.
pub(super) fn words(attribute: &Attribute) -> Option<String> {
    let strings = attribute.read_strings().ok();
    strings
        .and_then(|all| all.into_iter().next())
        .or_else(|| attribute.read_string().ok())
        .map(|text| text::shown(&text))
}

/// The bytes of one field of an attribute that is a record, and their type.
pub(super) fn field<'a>(attribute: &'a Attribute, name: &str) -> Option<(&'a Datatype, &'a [u8])> {
    let Datatype::Compound { fields, .. } = &attribute.datatype else { return None };
    let field = fields.iter().find(|field| field.name == name)?;
    Some((&field.datatype, attribute.raw_data.get(field.byte_offset as usize..)?))
}

/// A list of variable length in a data set's attribute: its numbers.
pub(super) fn list(dataset: &Dataset, (datatype, bytes): (&Datatype, &[u8])) -> Option<Vec<f64>> {
    let Datatype::VarLen { base, .. } = datatype else { return None };
    let element = element(base)?;
    let reference = bytes.get(..dataset.vlen_reference_size())?;
    let found = dataset.resolve_vlen_reference_bytes(reference, element.size).ok()?;
    Some(element.decode_all(&found))
}

/// A text of variable length in a data set's attribute.
pub(super) fn long_text(dataset: &Dataset, (_, bytes): (&Datatype, &[u8])) -> Option<String> {
    let reference = bytes.get(..dataset.vlen_reference_size())?;
    let found = dataset.resolve_vlen_reference_bytes(reference, 1).ok()?;
    Some(text::shown(String::from_utf8_lossy(&found).trim_end_matches('\0')))
}

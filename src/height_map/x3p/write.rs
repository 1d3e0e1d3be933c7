//! Writing X3P.

use super::MAIN;
use md5::{Digest, Md5};
use std::fmt::Write as _;
use std::io::{Cursor, Write as _};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

const DATA: &str = "bindata/data.bin";
const SUM: &str = "md5checksum.hex";

fn hexadecimal(bytes: &[u8]) -> String {
    Md5::digest(bytes).iter().fold(String::new(), |mut text, byte| {
        // Writing to a text cannot fail.
        let _ = write!(text, "{byte:02X}");
        text
    })
}

/// Writes heights in metres, row-major from the upper left of the picture, NaN where invalid; `pixel` is the pitch along
/// rows and along columns, metres. Every height is kept to its last bit. Nothing is compressed and no time is written, so
/// that the same map gives the same bytes everywhere. `None` if `heights` does not fill the rows, a height is infinite, a
/// pitch is not positive, or there are more pixels than are read.
pub fn write(columns: usize, heights: &[f64], pixel: [f64; 2]) -> Option<Vec<u8>> {
    if columns == 0 || heights.is_empty() || !heights.len().is_multiple_of(columns) {
        return None;
    }
    if heights.len() as u64 > crate::height_map::MOST_PIXELS
        || heights.iter().any(|height| height.is_infinite())
        || !pixel.iter().all(|side| *side > 0.0 && side.is_finite())
    {
        return None;
    }
    let data: Vec<u8> = heights.iter().flat_map(|height| height.to_le_bytes()).collect();
    let main = description(columns, heights.len() / columns, pixel, &hexadecimal(&data));
    let sum = format!("{} *{MAIN}\n", hexadecimal(main.as_bytes()).to_lowercase());
    let mut archive = ZipWriter::new(Cursor::new(Vec::with_capacity(data.len() + 4096)));
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    for (part, bytes) in [(MAIN, main.as_bytes()), (DATA, &data), (SUM, sum.as_bytes())] {
        archive.start_file(part, options).ok()?;
        archive.write_all(bytes).ok()?;
    }
    Some(archive.finish().ok()?.into_inner())
}

/// `main.xml`. Without its second record, which may be left out: it would say when and by what the part was measured.
fn description(columns: usize, rows: usize, [x, y]: [f64; 2], sum: &str) -> String {
    format!(
        r#"<?xml version="1.0" encoding="UTF-8" standalone="no"?>
<p:ISO5436_2 xmlns:p="http://www.opengps.eu/2008/ISO5436_2" xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:schemaLocation="http://www.opengps.eu/2008/ISO5436_2 http://www.opengps.eu/2008/ISO5436_2/ISO5436_2.xsd">
  <Record1>
    <Revision>ISO5436 - 2000</Revision>
    <FeatureType>SUR</FeatureType>
    <Axes>
      <CX><AxisType>I</AxisType><DataType>D</DataType><Increment>{x:e}</Increment><Offset>0</Offset></CX>
      <CY><AxisType>I</AxisType><DataType>D</DataType><Increment>{y:e}</Increment><Offset>0</Offset></CY>
      <CZ><AxisType>A</AxisType><DataType>D</DataType><Increment>1</Increment><Offset>0</Offset></CZ>
    </Axes>
  </Record1>
  <Record3>
    <MatrixDimension><SizeX>{columns}</SizeX><SizeY>{rows}</SizeY><SizeZ>1</SizeZ></MatrixDimension>
    <DataLink>
      <PointDataLink>{DATA}</PointDataLink>
      <MD5ChecksumPointData>{sum}</MD5ChecksumPointData>
    </DataLink>
  </Record3>
  <Record4><ChecksumFile>{SUM}</ChecksumFile></Record4>
</p:ISO5436_2>
"#
    )
}

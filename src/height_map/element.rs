//! Elements: how one number lies in the bytes of a binary file.

/// A number of a binary file: what it is, how many bytes it has, which comes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Element {
    pub kind: Kind,
    /// 1 to 8.
    pub size: usize,
    pub big_endian: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// IEEE 754, of 4 or 8 bytes.
    Float,
    /// Two's complement.
    Signed,
    Unsigned,
}

impl Element {
    /// The number in exactly `size` bytes. Whole numbers beyond 2^53 are rounded to the nearest that a float holds.
    pub fn decode(&self, bytes: &[u8]) -> f64 {
        let mut bits: u64 = 0;
        for i in 0..bytes.len() {
            let byte = if self.big_endian { bytes[i] } else { bytes[bytes.len() - 1 - i] };
            bits = bits << 8 | u64::from(byte);
        }
        let unused = 64 - 8 * self.size as u32;
        match (self.kind, self.size) {
            (Kind::Float, 4) => f64::from(f32::from_bits(bits as u32)),
            (Kind::Float, _) => f64::from_bits(bits),
            (Kind::Signed, _) => ((bits << unused) as i64 >> unused) as f64,
            (Kind::Unsigned, _) => bits as f64,
        }
    }

    /// All numbers of `bytes`, whose length is a multiple of `size`.
    pub fn decode_all(&self, bytes: &[u8]) -> Vec<f64> {
        bytes.chunks_exact(self.size).map(|one| self.decode(one)).collect()
    }
}

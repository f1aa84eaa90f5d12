//! A PNG file's chunks (W3C PNG, 5.2): length, type, data, check sum over type and data.

use crc::{CRC_32_ISO_HDLC, Crc};

const CHECK: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// What a PNG file begins with.
const SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";

/// A chunk without its length and check sum.
#[derive(Clone, Copy, Debug)]
struct Chunk<'a> {
    kind: [u8; 4],
    data: &'a [u8],
}

/// A file's chunks. What is cut off at its end is left out.
#[derive(Clone, Debug)]
pub(super) struct Chunks<'a>(Vec<Chunk<'a>>);

impl<'a> Chunks<'a> {
    /// `None` if it does not begin as a PNG file does.
    pub(super) fn of(file: &'a [u8]) -> Option<Self> {
        let mut left = file.strip_prefix(SIGNATURE)?;
        let mut chunks = Vec::new();
        while let Some((length, rest)) = left.split_first_chunk::<4>()
            && let Some((kind, rest)) = rest.split_first_chunk::<4>()
        {
            let length = usize::try_from(u32::from_be_bytes(*length)).unwrap_or(usize::MAX);
            let Some((data, rest)) = rest.split_at_checked(length) else {
                // A length that is wrong is the most likely of all changes: the rest is the chunk.
                chunks.push(Chunk { kind: *kind, data: rest.split_last_chunk::<4>().map_or(rest, |(data, _)| data) });
                break;
            };
            chunks.push(Chunk { kind: *kind, data });
            left = rest.get(4..).unwrap_or_default();
        }
        Some(Self(chunks))
    }

    /// Width and height as the header has them.
    pub(super) fn size(&self) -> Option<[u32; 2]> {
        let header = self.0.first().filter(|chunk| chunk.kind == *b"IHDR")?.data;
        let (width, rest) = header.split_first_chunk::<4>()?;
        let (height, _) = rest.split_first_chunk::<4>()?;
        Some([*width, *height].map(u32::from_be_bytes))
    }

    /// The file with right lengths and check sums.
    pub(super) fn write(&self) -> Vec<u8> {
        file(self.0.iter().copied())
    }

    /// The same with the pixels' data in chunks of up to 7 bytes.
    pub(super) fn parted(&self) -> Vec<u8> {
        let parts = self.0.iter().flat_map(|chunk| {
            let size = if chunk.kind == *b"IDAT" && !chunk.data.is_empty() { 7 } else { usize::MAX };
            let whole = chunk.data.is_empty().then_some(*chunk);
            chunk.data.chunks(size).map(|data| Chunk { data, ..*chunk }).chain(whole)
        });
        file(parts)
    }

    /// The same with the pixels' data in one chunk.
    pub(super) fn joined(&self) -> Vec<u8> {
        let of_pixels = |chunk: &&Chunk<'_>| chunk.kind == *b"IDAT";
        let data: Vec<u8> = self.0.iter().filter(of_pixels).flat_map(|chunk| chunk.data).copied().collect();
        let first = self.0.iter().position(|chunk| chunk.kind == *b"IDAT");
        let chunks = self.0.iter().enumerate().filter_map(|(i, chunk)| {
            let whole = Chunk { data: &data, ..*chunk };
            if chunk.kind == *b"IDAT" { (Some(i) == first).then_some(whole) } else { Some(*chunk) }
        });
        file(chunks)
    }

    /// The same with a remark behind its header.
    pub(super) fn remarked(&self) -> Vec<u8> {
        let remark = Chunk { kind: *b"tEXt", data: b"Comment\0two scan lines" };
        let (header, rest) = self.0.split_at(self.0.len().min(1));
        file(header.iter().copied().chain([remark]).chain(rest.iter().copied()))
    }
}

fn file<'a>(chunks: impl Iterator<Item = Chunk<'a>>) -> Vec<u8> {
    let mut file = SIGNATURE.to_vec();
    for Chunk { kind, data } in chunks {
        let length = u32::try_from(data.len()).expect("inputs are short");
        file.extend(length.to_be_bytes());
        file.extend(kind);
        file.extend(data);
        let mut digest = CHECK.digest();
        digest.update(&kind);
        digest.update(data);
        file.extend(digest.finalize().to_be_bytes());
    }
    file
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An image that this project's readers are tested with; its check sums are its own.
    const FILE: &[u8] = include_bytes!("../../../tests/data/renders/000.png");

    #[test]
    fn a_file_is_its_chunks() {
        let chunks = Chunks::of(FILE).unwrap();
        assert_eq!(chunks.size(), Some([480, 8]));
        assert!(chunks.write() == FILE);
    }

    #[test]
    fn check_sums_are_repaired_and_lengths_cut() {
        let mut broken = FILE.to_vec();
        let last = broken.len() - 1;
        // Of IEND, and of the header.
        broken[last] ^= 1;
        broken[30] ^= 0x40;
        assert!(Chunks::of(&broken).unwrap().write() == FILE);
        let cut = Chunks::of(&FILE[..600]).unwrap().write();
        assert!(Chunks::of(&cut).unwrap().write() == cut && cut.len() <= 604);
        assert!(Chunks::of(b"P5").is_none());
    }

    #[test]
    fn layouts_differ_and_hold_the_same() {
        let chunks = Chunks::of(FILE).unwrap();
        let pixels = |file: &[u8]| -> Vec<u8> {
            let chunks = Chunks::of(file).unwrap();
            chunks.0.iter().filter(|chunk| chunk.kind == *b"IDAT").flat_map(|chunk| chunk.data).copied().collect()
        };
        for other in [chunks.parted(), chunks.joined(), chunks.remarked()] {
            assert_eq!(pixels(&other), pixels(FILE));
        }
        assert!(chunks.parted().len() > FILE.len() && chunks.remarked().len() > FILE.len());
    }
}

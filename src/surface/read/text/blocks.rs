//! Blocks of whole lines of a long text, which several threads can read in parallel.
//!
//! Where a block ends depends on the text alone, not on the chunks in which it arrives, so that sums over blocks are
//! reproducible to the bit. The caller chooses the threads.

use super::super::fault::Fault;
use super::super::lines::{LONGEST_LINE, line_end};
use super::{Layout, read_block};
use crate::surface::Sink;

/// A block ends with the line that passes this size: a thread's work of a few tenths of a millisecond.
const SIZE: usize = 1 << 17;

/// Consecutive lines of a file with points in text, which can be read independently of the others.
#[derive(Debug)]
pub struct TextBlock {
    lines: Vec<u8>,
    layout: Layout,
}

/// The result of reading a block, which the caller passes to
/// [`Reader::record_block`](crate::surface::read::Reader::record_block).
#[derive(Debug)]
#[must_use = "the reader needs it to count lines and points and to report faults"]
pub struct BlockOutcome {
    pub(super) lines: u64,
    pub(super) points: u64,
    /// The first fault, its line counted from the block's start.
    pub(super) result: Result<(), Fault>,
}

impl TextBlock {
    pub(super) fn new(lines: Vec<u8>, layout: Layout) -> Self {
        Self { lines, layout }
    }

    /// Passes the points of these lines to `sink`, up to the first fault.
    pub fn read<S: Sink>(self, sink: &mut S) -> BlockOutcome {
        read_block(&self.lines, self.layout, sink)
    }
}

/// Splits a text into blocks.
#[derive(Debug, Default)]
pub(super) struct BlockSplitter {
    begun: Vec<u8>,
}

impl BlockSplitter {
    /// Moves bytes from `chunk` into the current block, and returns the block when it is complete.
    pub(super) fn next(&mut self, chunk: &mut &[u8]) -> Option<Vec<u8>> {
        if self.begun.is_empty() {
            self.begun.reserve_exact(SIZE + LONGEST_LINE);
        }
        self.take(chunk, SIZE.saturating_sub(self.begun.len()).min(chunk.len()));
        if chunk.is_empty() {
            return None;
        }
        // A CR at the end of the block may be the first half of a CR LF.
        if self.begun.len() == SIZE || self.begun.last() != Some(&b'\r') {
            let end = line_end(chunk);
            self.take(chunk, end.map_or(chunk.len(), |end| end + 1));
            if end.is_none() {
                // The reader of the block refuses a line that is too long.
                return (self.begun.len() > SIZE + LONGEST_LINE).then(|| std::mem::take(&mut self.begun));
            }
        }
        if self.begun.last() == Some(&b'\r') {
            self.take(chunk, usize::from(*chunk.first()? == b'\n'));
        }
        Some(std::mem::take(&mut self.begun))
    }

    /// The last, incomplete block.
    pub(super) fn rest(self) -> Vec<u8> {
        self.begun
    }

    fn take(&mut self, chunk: &mut &[u8], length: usize) {
        let (part, rest) = chunk.split_at(length);
        self.begun.extend_from_slice(part);
        *chunk = rest;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::read::{FormatHint, Reader, Summary};
    use proptest::prelude::*;

    #[derive(Debug, Default, PartialEq)]
    struct Points(Vec<[f64; 3]>);

    impl Sink for Points {
        fn point(&mut self, point: [f64; 3]) {
            self.0.push(point);
        }

        fn facet(&mut self, _: [[f64; 3]; 3]) {}
    }

    /// Reads a text in blocks, from chunks of `size` bytes.
    fn read_in_blocks(text: &[u8], size: usize) -> (Points, Result<Summary, Fault>) {
        let (mut reader, mut points) = (Reader::new(FormatHint::default()), Points::default());
        for chunk in text.chunks(size) {
            let mut blocks = Vec::new();
            let mut pushed = reader.push_in_blocks(chunk, &mut points, &mut blocks);
            for block in blocks {
                let read = block.read(&mut points);
                pushed = pushed.and(reader.record_block(read));
            }
            if let Err(fault) = pushed {
                return (points, Err(fault));
            }
        }
        let finished = reader.finish(&mut points);
        (points, finished)
    }

    fn read_at_once(text: &[u8]) -> (Points, Result<Summary, Fault>) {
        let (mut reader, mut points) = (Reader::new(FormatHint::default()), Points::default());
        let result = reader.push(text, &mut points).and_then(|()| reader.finish(&mut points));
        (points, result)
    }

    /// All blocks of a text that arrives in chunks of `size` bytes, the incomplete one last.
    fn blocks(text: &[u8], size: usize) -> Vec<Vec<u8>> {
        let (mut splitter, mut blocks) = (BlockSplitter::default(), Vec::new());
        for mut chunk in text.chunks(size) {
            while !chunk.is_empty() {
                blocks.extend(splitter.next(&mut chunk));
            }
        }
        blocks.push(splitter.rest());
        blocks
    }

    fn text(ends: &[&str], lines: usize) -> Vec<u8> {
        (0..lines).flat_map(|line| format!("{line},{},{line}{}", line * line, ends[line % ends.len()]).into_bytes()).collect()
    }

    #[test]
    fn a_block_ends_with_the_line_that_passes_its_size() {
        for ends in [&["\n"][..], &["\r\n"], &["\r"], &["\r", "\n\n", "\r\n"]] {
            let text = text(ends, 40_000);
            let blocks = blocks(&text, 10_000);
            assert!(blocks.len() > 3);
            assert_eq!(blocks.concat(), text);
            for (block, next) in blocks.iter().zip(&blocks[1..]) {
                assert!(block.len() > SIZE && line_end(&block[SIZE..block.len() - 2]).is_none());
                assert!(block.ends_with(b"\n") || (block.ends_with(b"\r") && next.first() != Some(&b'\n')));
            }
        }
    }

    #[test]
    fn an_endless_line_does_not_accumulate() {
        let blocks = blocks(&vec![b'1'; 10 * SIZE], 1000);
        assert!(blocks.len() > 5 && blocks.iter().all(|block| block.len() <= SIZE + LONGEST_LINE + 1000));
    }

    #[test]
    fn reading_in_blocks_gives_the_same_points_and_faults() {
        let whole = |ends: &[&str]| [b"# a scan\r\nx;y;z\r\n".as_slice(), &text(ends, 30_000)].concat();
        let clean = String::from_utf8(text(&["\n", "\r", "\r\n"], 30_000)).unwrap().replace(',', ".5;");
        let late_mark = format!("{}1.5;2;3\n{clean}", "1;2;3\r".repeat(40_000));
        let broken = clean.replacen("29000.5;", "29000.5 ", 1);
        let other_mark = clean.replacen("28123.5;", "28123,5;", 1);
        let endless = clean.clone() + &"1".repeat(2 * LONGEST_LINE);
        let faulty: [(Vec<u8>, bool); 6] = [
            (clean.into_bytes(), false),
            (late_mark.into_bytes(), false),
            (broken.into_bytes(), true),
            (other_mark.into_bytes(), true),
            (endless.into_bytes(), true),
            (whole(&["\n"]), false),
        ];
        for (text, is_faulty) in faulty {
            let expected = read_at_once(&text);
            assert_eq!(expected.1.is_err(), is_faulty, "{:?}", expected.1);
            for size in [997, 65_536, 1 << 20] {
                let found = read_in_blocks(&text, size);
                assert!(found.1 == expected.1, "{:?} is not {:?}", found.1, expected.1);
                assert!(is_faulty || found.0 == expected.0);
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(16))]
        #[test]
        fn blocks_do_not_depend_on_the_chunks(size in 1_usize..200_000) {
            let text = text(&["\n", "\r\n", "\r"], 30_000);
            prop_assert_eq!(blocks(&text, size), blocks(&text, text.len()));
        }
    }
}

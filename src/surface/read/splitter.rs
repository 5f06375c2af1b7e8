//! Divides a text into blocks of whole lines, which several threads can read in parallel.
//!
//! The ends of blocks depend only on the text, not on the chunks in which it arrives, so that sums over blocks are
//! reproducible to the bit.

use super::lines::{LONGEST_LINE, line_end, trimmed};

/// The default size of blocks, in bytes: a thread's work of a few tenths of a millisecond.
pub(super) const BLOCK: usize = 1 << 17;

/// Divides a text into blocks.
#[derive(Debug)]
pub(super) struct BlockSplitter {
    /// The size of a block in bytes: a block ends with the line that exceeds it.
    size: usize,
    /// Whether a block may end after this line.
    may_end: fn(&[u8]) -> bool,
    begun: Vec<u8>,
    /// The start of the last line in `begun`; only meaningful once `begun` has the size of a block.
    line: usize,
}

impl BlockSplitter {
    /// A splitter whose blocks end only after lines for which `may_end` returns true.
    pub(super) fn new(size: usize, may_end: fn(&[u8]) -> bool) -> Self {
        Self { size, may_end, begun: Vec::new(), line: 0 }
    }

    /// Moves bytes from `chunk` into the current block, and returns the block when it is complete.
    pub(super) fn next(&mut self, chunk: &mut &[u8]) -> Option<Vec<u8>> {
        if self.begun.is_empty() {
            self.begun.reserve_exact(self.size + LONGEST_LINE);
        }
        if self.begun.len() < self.size {
            self.take(chunk, (self.size - self.begun.len()).min(chunk.len()));
            if self.begun.len() == self.size {
                self.line = memchr::memrchr2(b'\n', b'\r', &self.begun).map_or(0, |end| end + 1);
            }
        }
        while let Some(&next) = chunk.first() {
            if self.is_complete(next) {
                self.line = 0;
                return Some(std::mem::take(&mut self.begun));
            }
            let end = line_end(chunk);
            self.take(chunk, end.map_or(chunk.len(), |end| end + 1));
        }
        None
    }

    /// Whether the block ends before the byte `next`.
    fn is_complete(&mut self, next: u8) -> bool {
        if self.begun.len() <= self.size {
            return false;
        }
        let is_line_end = match self.begun.last() {
            Some(b'\n') => true,
            Some(b'\r') => next != b'\n',
            _ => false,
        };
        if !is_line_end {
            // The reader of the block refuses a line that is too long.
            return self.begun.len() - self.line > LONGEST_LINE + 2;
        }
        let mut line = &self.begun[self.line..];
        while let [rest @ .., b'\n' | b'\r'] = line {
            line = rest;
        }
        if (self.may_end)(line) || self.begun.len() > self.size + LONGEST_LINE {
            return true;
        }
        self.line = self.begun.len();
        false
    }

    /// The last, incomplete block.
    pub(super) fn rest(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.begun)
    }

    fn take(&mut self, chunk: &mut &[u8], length: usize) {
        let (part, rest) = chunk.split_at(length);
        self.begun.extend_from_slice(part);
        *chunk = rest;
    }
}

/// A block may end after any line.
pub(super) fn any_line(_: &[u8]) -> bool {
    true
}

/// Whether the last word of a line is `word`, in either case.
pub(super) fn ends_with_word(line: &[u8], word: &[u8]) -> bool {
    let line = trimmed(line);
    line.len().checked_sub(word.len()).is_some_and(|start| line[start..].eq_ignore_ascii_case(word))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// All blocks of a text that arrives in chunks of `size` bytes, the incomplete one last.
    fn blocks(text: &[u8], size: usize) -> Vec<Vec<u8>> {
        let (mut splitter, mut blocks) = (BlockSplitter::new(BLOCK, any_line), Vec::new());
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
                assert!(block.len() > BLOCK && line_end(&block[BLOCK..]).is_none_or(|end| BLOCK + end + 2 >= block.len()));
                assert!(block.ends_with(b"\n") || (block.ends_with(b"\r") && next.first() != Some(&b'\n')));
            }
        }
    }

    #[test]
    fn a_block_ends_only_after_a_line_after_which_it_may() {
        let mut splitter = BlockSplitter::new(10, |line| ends_with_word(line, b"end"));
        let mut chunk = b"one\ntwo\nthree\nfour\n  the END \r\nfive\n".as_slice();
        assert_eq!(splitter.next(&mut chunk).unwrap(), b"one\ntwo\nthree\nfour\n  the END \r\n");
        assert_eq!((splitter.next(&mut chunk), splitter.rest()), (None, b"five\n".to_vec()));
    }

    #[test]
    fn an_endless_line_does_not_accumulate() {
        let blocks = blocks(&vec![b'1'; 10 * BLOCK], 1000);
        assert!(blocks.len() > 5 && blocks.iter().all(|block| block.len() <= BLOCK + LONGEST_LINE + 2000));
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

//! The Z-order curve (Morton's), which fills the plane: neighbours along it are neighbours in the plane.

/// The place along the curve of a cell with these coordinates under 2^16.
pub(crate) fn z_order([x, y]: [u32; 2]) -> u32 {
    interleaved(x) | interleaved(y) << 1
}

/// The 16 low bits with a zero bit after each.
fn interleaved(bits: u32) -> u32 {
    let mut x = bits & 0xffff;
    for (shift, mask) in [(8, 0x00ff_00ff), (4, 0x0f0f_0f0f), (2, 0x3333_3333), (1, 0x5555_5555)] {
        x = (x | x << shift) & mask;
    }
    x
}

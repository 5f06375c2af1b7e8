//! A wavy slope as nodes in rows and as triangles, for tests that send one surface in several forms.

/// The number of rows of nodes.
pub(crate) const ROWS: usize = 13;
/// The number of nodes in a row.
pub(crate) const COLUMNS: usize = 17;

/// The nodes row after row, with distances `apart` along X and Y, and waves of this height and frequency. They are in
/// single precision, which all formats can represent.
pub(crate) fn nodes(apart: [f32; 2], [height, frequency]: [f32; 2]) -> Vec<[f32; 3]> {
    let at = |row: u8, column: u8| {
        let (x, y) = (f32::from(column) * apart[0], f32::from(row) * apart[1]);
        [x, y, 0.5 * y + height * (frequency * x).sin()]
    };
    let (rows, columns) = (u8::try_from(ROWS).unwrap(), u8::try_from(COLUMNS).unwrap());
    (0..rows).flat_map(|row| (0..columns).map(move |column| at(row, column))).collect()
}

/// Two triangles for each quad, counter-clockwise seen from above. The diagonal is from the first corner to the last,
/// as in a grid.
pub(crate) fn triangles() -> Vec<[usize; 3]> {
    let number = |row: usize, column: usize| row * COLUMNS + column;
    let quads = (1..ROWS).flat_map(|row| (1..COLUMNS).map(move |column| (row, column)));
    let divided = quads.flat_map(|(row, column)| {
        let [a, b, c, d] = [number(row - 1, column - 1), number(row - 1, column), number(row, column), number(row, column - 1)];
        [[a, b, c], [a, c, d]]
    });
    divided.collect()
}

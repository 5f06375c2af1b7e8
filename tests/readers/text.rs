//! The readers of points in text and of ASCII PCD.

use super::*;
use scallopd::file_fault::FilePlace;
use scallopd::surface::Unit;

const TWO: [[f64; 3]; 2] = [[1.5, -2.0, 3.25], [4.0, 5.5, -6.0]];

#[test]
fn every_separator_is_found() {
    for file in [
        "1.5,-2,3.25\n4,5.5,-6\n",
        "1.5, -2 , 3.25\n 4 ,5.5,\t-6\n",
        "1.5;-2;3.25\n4;5.5;-6\n",
        "1.5 ; -2 ; 3.25\n4; 5.5; -6\n",
        "1.5\t-2\t3.25\n4\t5.5\t-6\n",
        " 1.5 -2\t 3.25 \n4  5.5  -6",
        "1.5 \t-2\t3.25\n4\t 5.5\t-6 ",
        "1.50e0,-0.2E1,325d-2\n4.,+5.5,-6D0\n",
    ] {
        assert_eq!(points(file), TWO, "{file:?}");
    }
}

#[test]
fn decimal_commas_are_read_where_the_comma_does_not_separate() {
    for file in ["1,5;-2;3,25\n4;5,5;-6\n", "1,5\t-2\t3,25\n4\t5,5\t-6\n", "1,5 -2 3,25\n4 5,5 -6\n", "1,5 ; -2,0; 3,25\n4,0;5,5;-6,0\n"] {
        assert_eq!(points(file), TWO, "{file:?}");
    }
    // The first mark is not in the first line.
    assert_eq!(points("1;2;3\n4;5;6,5\n"), [[1.0, 2.0, 3.0], [4.0, 5.0, 6.5]]);
}

#[test]
fn one_file_has_one_decimal_mark() {
    assert_eq!(refusal("1.5;2;3\n4;5,5;6\n"), "line 2: expected a number with a decimal point, as before, found \"5,5\"");
    assert_eq!(refusal("1,5;2;3\n4;5.5;6\n"), "line 2: expected a number with a decimal comma, as before, found \"5.5\"");
    assert_eq!(refusal("1.234,5;2;3\n"), "line 1: expected three numbers, or a header that names x, y and z, found \"1.234,5;2;3\"");
}

#[test]
fn the_first_line_fixes_the_separator() {
    assert_eq!(refusal("1,2,3\n4;5;6\n"), "line 2: expected a number, found \"4;5;6\"");
    assert_eq!(refusal("1\t2\t3\n4 5 6\n"), "line 2: expected a number, found \"4 5 6\"");
}

#[test]
fn headers_name_columns_in_any_order_and_case() {
    for file in [
        "x,y,z\n1.5,-2,3.25\n4,5.5,-6\n",
        "Z;X;Y\n3,25;1,5;-2\n-6;4;5,5\n",
        "\"X [mm]\";\"Y [mm]\";\"Z [mm]\"\n1,5;-2;3,25\n4;5,5;-6\n",
        "id\tname\tX\tY\tZ\n1\t\"a\t\"\"b\"\"\"\t1.5\t-2\t3.25\n2\tb c\t4\t5.5\t-6\n",
        "X [mm] Y [mm] Z [mm]\n1.5 -2 3.25\n4 5.5 -6\n",
        "nx,ny,nz,pos_z,pos_y,pos_x\n0,0,1,3.25,-2,1.5\n0,0,1,-6,5.5,4\n",
        "x, y, z, normal_x, normal_y, normal_z\n1.5,-2,3.25,0,0,1\n4,5.5,-6,0,0,1\n",
        "x(µm) y(µm) z(µm)\n1.5 -2 3.25\n4 5.5 -6\n",
        "# saved by us\n\n// again\nx\ty\tz\n\n1.5\t-2\t3.25\n# in between\n4\t5.5\t-6\n",
    ] {
        assert_eq!(points(file), TWO, "{file:?}");
    }
}

#[test]
fn line_ends_and_byte_order_marks_of_all_systems_are_read() {
    for file in [
        "\u{feff}1.5,-2,3.25\r\n4,5.5,-6\r\n",
        "1.5,-2,3.25\r4,5.5,-6",
        "\n\n1.5,-2,3.25\n\r\n4,5.5,-6\n\n",
        "\u{feff}X,Y,Z\r\n1.5,-2,3.25\r\n4,5.5,-6",
    ] {
        assert_eq!(points(file), TWO, "{file:?}");
    }
}

#[test]
fn numbers_may_stand_in_quotation_marks() {
    assert_eq!(points("\"1.5\",\"-2\",\"3.25\"\n4,5.5,\"-6\"\n"), TWO);
    assert_eq!(points("\"1,5\";\"-2\";\"3,25\"\n4;5,5;-6\n"), TWO);
}

#[test]
fn a_decimal_comma_in_quotation_marks_is_read_beside_the_separator() {
    for file in [
        "\"1,5\",\"-2,0\",\"3,25\"\n\"4\",\"5,5\",\"-6\"\n",
        "\"1,5\",-2,\"3,25\"\n4,\"5,5\",-6\n",
        "x,y,z,note\n\"1,5\",-2,\"3,25\",\"a, b\"\n4,\"5,5\",-6,\n",
        "\"x\",\"y\",\"z\"\r\n\"1,50\",\"-2,00\",\"3,25\"\r\n\"4,00\",\"5,50\",\"-6,00\"\r\n",
    ] {
        assert_eq!(points(file), TWO, "{file:?}");
    }
    assert_eq!(points("0,\"0,000\",\"1,234\"\n"), [[0.0, 0.0, 1.234]]);
    assert_eq!(refusal("\"1,5\",2,3\n4,5.5,6\n"), "line 2: expected a number with a decimal comma, as before, found \"5.5\"");
    assert_eq!(refusal("1.5,2,3\n\"4,5\",5,6\n"), "line 2: expected a number, found \"\\\"4,5\\\"\"");
    assert_eq!(read("\"1,234.5\",2,3\n").unwrap_err().kind(), FileFaultKind::Malformed);
    // The first number with a decimal mark determines the mark; this number has none.
    let thousands = read("x,y,z\n\"10,500\",\"2,250\",\"3,125\"\n").unwrap_err();
    assert_eq!(thousands.kind(), FileFaultKind::Ambiguous);
    assert_eq!(
        thousands.to_string(),
        "line 2: expected a decimal point, or a semicolon between columns, found \"10,500\": either a decimal comma, or a comma between thousands"
    );
}

#[test]
fn further_columns_are_counted() {
    let (recorder, summary) = read("1.5 -2 3.25 255 0 0\n4 5.5 -6 a short note\n").unwrap();
    assert_eq!(recorder.points, TWO);
    assert_eq!(
        summary,
        ReadSummary { format: Format::Text, points: 2, facets: 0, unit: None, notes: Notes { further_columns: 3, ..Notes::default() } }
    );
    assert_eq!(read("1,2,3").unwrap().1.notes, Notes::default());
}

#[test]
fn one_point_is_read() {
    assert_eq!(points("1 2 3"), [[1.0, 2.0, 3.0]]);
}

#[test]
fn lines_other_than_three_numbers_are_refused_with_their_number() {
    for (file, sentence) in [
        ("1,2\n", "line 1: expected three numbers, found two"),
        ("6400\n", "line 2: expected three numbers, found the end of the file"),
        ("6400\n7\n", "line 2: expected three numbers, found one"),
        ("x,y,z\n\n1,2,3\n\n1,2\n", "line 5: expected three numbers between commas, found two"),
        ("1;2;3\n4;5\n", "line 2: expected three numbers between semicolons, found two"),
        ("1 2 3\n4\n", "line 2: expected three numbers between blanks, found one"),
        ("1,2,3\n1,,3\n", "line 2: expected a number, found nothing"),
        ("1,2,3\n1,2,\n", "line 2: expected a number, found nothing"),
        ("1\t2\t3\n1\t\t3\n", "line 2: expected a number, found nothing"),
        ("1,2,3\n1,2x,3\n", "line 2: expected a number, found \"2x\""),
        ("1,2,3\nx,y,z\n", "line 2: expected a number, found \"x\""),
        ("a,x,y,z\n7,1,2\n", "line 2: expected 4 columns, as the header names, found 3"),
        ("x,y,w\n1,2,3\n", "line 1: expected three numbers, or a header that names x, y and z, found \"x,y,w\""),
        ("x,y,z\nx,y,z\n", "line 2: expected three numbers, found \"x,y,z\""),
        ("hello\n", "line 1: expected three numbers, or a header that names x, y and z, found \"hello\""),
        ("x y z\n", "line 2: expected three numbers, found the end of the file"),
        ("# nothing", "line 1: expected three numbers, found the end of the file"),
        ("\n", "line 2: expected three numbers, found the end of the file"),
    ] {
        assert_eq!(refusal(file), sentence, "{file:?}");
    }
}

#[test]
fn numbers_out_of_range_are_refused() {
    for (file, found) in [
        ("1,2,nan\n", "\"nan\""),
        ("1 2 3\n4 -Infinity 6\n", "\"-Infinity\""),
        ("1;2;3\n4;1e400;6\n", "\"1e400\""),
        ("1\t2\t3\n4\t1.1e12\t6\n", "\"1.1e12\""),
    ] {
        let fault = read(file).unwrap_err();
        assert_eq!(fault.kind(), FileFaultKind::OutOfRange);
        assert_eq!((fault.expected(), fault.found()), ("a finite coordinate of at most 1e12 in magnitude", found), "{file:?}");
    }
    assert_eq!(points("1e12 -1e12 0"), [[1e12, -1e12, 0.0]]);
}

#[test]
fn text_in_utf_16_is_read() {
    let text = "\u{feff}X;Y;Z\r\n1,5;-2;3,25\r\n4;5,5;-6\r\n";
    for unit in [u16::to_le_bytes, u16::to_be_bytes] {
        let file: Vec<u8> = text.encode_utf16().flat_map(unit).collect();
        assert_eq!(points(&file), TWO);
        assert_eq!(read_in_pieces(&file, 1, FormatHint::default()).0.points, TWO);
    }
    let stl: Vec<u8> = "\u{feff}solid a\n".encode_utf16().chain(std::iter::repeat_n(0x20, 1 << 17)).flat_map(u16::to_le_bytes).collect();
    assert_eq!(read(stl).unwrap_err().kind(), FileFaultKind::TooLarge);
    // A header may be in Latin-1.
    let (recorder, summary) = read(b"X [\xb5m];Y [\xb5m];Z [\xb5m]\n1;2;3\n").unwrap();
    assert_eq!((recorder.points, summary.unit), (vec![[1.0, 2.0, 3.0]], Some(Unit::Micrometre)));
}

#[test]
fn comments_and_counts_that_programs_write_are_read() {
    for file in [
        "sep=;\nx;y;z\n1,5;-2;3,25\n4;5,5;-6\n",
        "SEP=,\r\n1.5,-2,3.25\r\n4,5.5,-6\r\n",
        "2\n1.5 -2 3.25 100 0 0 0\n4 5.5 -6 90 1 2 3\n",
        "//X Y Z\n2\n1.5 -2 3.25\n4 5.5 -6\n",
        "# y x z\n-2 1.5 3.25\n5.5 4 -6\n",
        "# z, y, x, i\n3.25,-2,1.5,7\n-6,5.5,4,8\n",
        "# the x, y and z of a scan\n1.5 -2 3.25\n4 5.5 -6\n",
        "x,y,z\nmm,mm,mm\n1.5,-2,3.25\n4,5.5,-6\n",
        "x;y;z;\n1.5;-2;3.25;\n4;5.5;-6;\n",
        "\"Points:0\",\"Points:1\",\"Points:2\",\"Normals:0\"\n1.5,-2,3.25,0\n4,5.5,-6,0\n",
        "Normals_0,Points_2,Points_1,Points_0\n0,3.25,-2,1.5\n0,-6,5.5,4\n",
        "1.5\u{a0}-2\u{a0}3.25\n4\u{a0}5.5\u{a0}-6\n",
        "1.5;\u{a0}-2;3.25\n4;5.5\u{a0};-6\u{202f}\n",
        "X\u{a0}[mm];Y;Z\n1.5;-2;3.25\n4;5.5;-6\n",
        "1.5,-2,3.25\n4,5.5,-6\n\x1a",
        "1.5,-2,3.25\r\n4,5.5,-6\r\n\0\0\0",
        "1.5,-2,3.25\n4,5.5,-6\x1a",
    ] {
        assert_eq!(points(file), TWO, "{file:?}");
    }
}

#[test]
fn the_unit_of_a_header_reaches_the_summary() {
    for (file, unit) in [
        ("x,y,z\n1,2,3\n", None),
        ("X [in],Y [in],Z [in]\n1,2,3\n", Some(Unit::Inch)),
        ("x_m;y_m;z_m\n1;2;3\n", Some(Unit::Metre)),
        ("X [mm] Y [mm] Z [mm]\n1 2 3\n", Some(Unit::Millimetre)),
        ("pos_x_ft,pos_y_ft,pos_z_ft\n1,2,3\n", Some(Unit::Foot)),
        ("x(\u{b5}m)\ty(\u{b5}m)\tz(\u{3bc}m)\n1\t2\t3\n", Some(Unit::Micrometre)),
        ("x,y,z\n[cm],[cm],[cm]\n1,2,3\n", Some(Unit::Centimetre)),
        ("# x[in] y[in] z[in]\n1 2 3\n", Some(Unit::Inch)),
        ("x in,y in,z in\n1,2,3\n", Some(Unit::Inch)),
        ("x [mm],y,z\n1,2,3\n", Some(Unit::Millimetre)),
    ] {
        assert_eq!(read(file).unwrap().1.unit, unit, "{file:?}");
    }
}

#[test]
fn ambiguous_text_is_refused_with_both_readings() {
    for (file, sentence) in [
        (
            "1,5,2,5,3,5\n4,0,5,5,6,5\n",
            "line 1: expected a semicolon, tab or blank between numbers with decimal commas, or a decimal point, found \"1,5,2,5,3,5\": either 6 columns between commas, or three numbers with decimal commas",
        ),
        (
            "1,5, 2,5, 3,5\n4,0, 5,5, 6,5\n",
            "line 1: expected a semicolon, tab or blank between numbers with decimal commas, or a decimal point, found \"1,5, 2,5, 3,5\": either 6 columns between commas, or three numbers with decimal commas",
        ),
        (
            "1,5,2,3\n4,5,5,6,5\n",
            "line 2: expected 4 columns, as the first line has, found 5 fields; either 5 columns between commas, or three numbers with decimal commas",
        ),
        (
            "x,y,z\n1,5,2,5,3,5\n",
            "line 2: expected 3 columns, as the header names, found 6 fields; either 6 columns between commas, or three numbers with decimal commas",
        ),
        (
            "x,y,z\n1,2,3\n1,5,2,5,3,5\n",
            "line 3: expected 3 columns, as the header names, found 6 fields; either 6 columns between commas, or three numbers with decimal commas",
        ),
        ("pos_x,dir_x,y,z\n1,2,3,4\n", "line 1: expected one column that is x, found \"pos_x\" and \"dir_x\", which both could be"),
        ("x,y,z,x,y,z\n1,2,3,4,5,6\n", "line 1: expected one column that is x, found \"x\" and \"x\", which both could be"),
        ("x [mm],y [mm],z [um]\n1,2,3\n", "line 1: expected one unit for x, y and z, found different ones"),
        (
            "x,y,z [um]\n1,2,3\n",
            "line 1: expected one unit for x, y and z, found a unit for only some of them: the others may be in it or in mm",
        ),
        ("x [in],y [in],z [in]\nmm,mm,mm\n1,2,3\n", "line 2: expected the unit that the header names, found \"mm,mm,mm\""),
        (
            "6400\n1 2 3\n",
            "line 1: expected 6400 points, as this line counts them, found 1 lines of data; either points are missing or too many, or the line is no count",
        ),
        (
            "1 2\u{a0}345 3 4\n",
            "line 1: expected one kind of space between numbers, found ordinary and no-break spaces; either all separate numbers, or the no-break ones separate thousands",
        ),
    ] {
        assert_eq!(refusal(file), sentence, "{file:?}");
    }
    let wide = "0.5 ".repeat(13) + "\n";
    let fault = read(wide.repeat(5)).unwrap_err();
    assert_eq!((fault.kind(), fault.expected()), (FileFaultKind::Ambiguous, "at most 12 numbers in a line without a header"));
    // A decimal point, sign or blank where a fraction cannot have one resolves the ambiguity.
    for file in ["1,2,3,255,0,0\n1.5,2,3,255,0,0\n", "1,-2,3,4,5,6\n1,2,3,4,5,6\n", "1, 2, 3, 4, 5, 6\n", "1,2,3,4\n5,6,7,8\n"] {
        assert!(read(file).is_ok(), "{file:?}");
    }
    assert_eq!(
        refusal("x [km],y [km],z [km]\n1,2,3\n"),
        "line 1: expected coordinates in micrometres, mm, cm, m, inches or feet, found \"km\""
    );
}

/// A table with blanks between its columns.
fn table(rows: u32, columns: u32, cell: impl Fn(f64, f64) -> String) -> String {
    let row = |row: u32| (0..columns).map(|column| cell(f64::from(row), f64::from(column))).collect::<Vec<_>>().join(" ") + "\n";
    (0..rows).map(row).collect()
}

#[test]
fn a_matrix_of_heights_is_refused_whatever_its_size() {
    let bumpy = |row: f64, column: f64| format!("{:.3}", 20.0 * (row / 5.0).sin() + 10.0 * (column / 3.0).cos());
    for (rows, columns) in [(3, 4), (4, 4), (30, 4), (30, 7), (7, 12), (200, 5), (2000, 8), (30_000, 6)] {
        let heights = table(rows, columns, bumpy);
        let fault = read(&heights).unwrap_err();
        assert_eq!((fault.kind(), fault.place()), (FileFaultKind::Ambiguous, &FilePlace::Line(1)), "{rows} x {columns}");
        assert_eq!(fault.expected(), "a header that names x, y and z");
        let readings = "either a matrix of heights, or points and their properties; send heights as points x, y, z";
        assert_eq!(fault.found(), format!("{rows} lines of {columns} numbers: {readings}"));
        assert_eq!(read(heights.replace(' ', ";").replace('.', ",")).unwrap_err(), fault);
        // A header resolves the ambiguity.
        let names = ["x", "y", "z", "a", "b", "c", "d", "e", "f", "g", "h", "i"][..columns as usize].join(" ");
        assert_eq!(points_beside_others(&format!("{names}\n{heights}")), rows as usize);
        assert_eq!(points_beside_others(&format!("# {names}\n{heights}")), rows as usize);
    }
    let inclined = |row: f64, column: f64| format!("{:.2}", 0.2 * row + 5.0 * column);
    assert_eq!(read(table(10, 6, inclined)).unwrap_err().kind(), FileFaultKind::Ambiguous);
    assert_eq!(read(table(10, 6, |row, column| (row * column).to_string())).unwrap_err().kind(), FileFaultKind::Ambiguous);
    // The most columns of a point. A line with more is refused immediately.
    assert_eq!(read(table(3, 13, bumpy)).unwrap_err().expected(), "at most 12 numbers in a line without a header");
}

#[test]
fn three_columns_of_nearly_equal_numbers_can_be_a_matrix_of_heights() {
    let bumpy = |row: f64, column: f64| format!("{:.3}", 8.0 * (row / 5.0).sin() + 2.0 * (column / 3.0).cos());
    for rows in [8, 30, 150] {
        let heights = table(rows, 3, bumpy);
        let fault = read(&heights).unwrap_err();
        assert_eq!((fault.kind(), fault.place()), (FileFaultKind::Ambiguous, &FilePlace::Line(1)), "{rows}");
        let readings = "either a matrix of heights, or points along x = y = z; send heights as points x, y, z";
        assert_eq!(fault.found(), format!("{rows} lines of three nearly equal numbers: {readings}"));
        assert_eq!(points_beside_others(&format!("x y z\n{heights}")), rows as usize);
    }
    // A matrix of three columns is shorter.
    assert_eq!(points_beside_others(&table(151, 3, bumpy)), 151);
}

#[test]
fn three_columns_are_points_where_the_numbers_of_a_line_differ() {
    // An equal offset of all coordinates must not change the result.
    let grid = |rows: u8, columns: u8, offset: f64, step: f64| {
        let line = |x: f64, y: f64| format!("{:.3} {:.3} {:.3}\n", x + offset, y + offset, offset + 0.5 * x + (y / 3.0).sin());
        let places = (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column)));
        places.map(|(row, column)| line(step * f64::from(column), step * f64::from(row))).collect::<String>()
    };
    for (file, points) in [
        // Points around the origin, far from it in all three coordinates, close together, and along a level diagonal.
        (grid(5, 6, -2.5, 1.0), 30),
        (grid(10, 10, 0.0, 0.01), 100),
        (grid(9, 9, 1e4, 2.0), 81),
        (table(20, 1, |row, _| format!("{row}.5 {row} 3.25\n{row} {row}.5 3.5")), 40),
        // The cap of a sphere, whose columns have similar ranges; three points; and a level plane.
        ("1 2 9.7\n-3 4 8.6\n6 -7 3.9\n-5 -5 7.1\n2 8 5.7\n7 1 7.1\n".to_owned(), 6),
        ("0 0 0\n1 0 0\n0 1 0\n".to_owned(), 3),
        ("1 1 1\n1 2 1\n2 1 1\n2 2 1\n".to_owned(), 4),
    ] {
        assert_eq!(points_beside_others(&file), points, "{file}");
    }
}

/// The number of points in a file with further columns.
fn points_beside_others(file: &str) -> usize {
    read(file).unwrap().0.points.len()
}

#[test]
fn points_with_properties_need_no_header_where_these_show_what_they_are() {
    let at = |row: f64| format!("{:.3} {:.3} {:.3}", row % 60.0, (row / 60.0).floor() + 0.5, 6.0 * (row / 9.0).sin());
    for properties in ["10 20 30", "0 0.6 0.8", "0 0.6 0.8 255 255 255 255", "-1.5 0 0 1"] {
        let file = table(5, 1, |row, _| format!("{} {properties}", at(row)));
        assert_eq!(points_beside_others(&file), 5, "{properties}");
    }
    let intensities = table(5, 1, |row, _| format!("{} {}", at(row), 40.0 + 3.0 * row));
    assert_eq!(points_beside_others(&intensities), 5);
    // A long table whose columns have very different ranges is not a matrix, for any further columns.
    let measured = |row: f64, _| format!("{} {:.3}", at(row), 0.01 * (row / 7.0).cos());
    assert_eq!(points_beside_others(&table(3000, 1, measured)), 3000);
    assert_eq!(read(table(30, 1, measured)).unwrap_err().kind(), FileFaultKind::Ambiguous);
    // A line with a word is not a row of a matrix.
    assert_eq!(points_beside_others("1.5 2 3 4\n2.5 3 4 good\n3.5 5 4 6\n"), 3);
}

#[test]
fn a_first_column_that_counts_up_needs_a_header() {
    for file in [
        "1,0.5,0,7.25\n2,1.5,0,7.5\n3,2.5,1,7.75\n".to_owned(),
        "0 1 2 3 0 0.6 0.8\n10 1 3 4 0 0.6 0.8\n20 2 2 5 0 0.6 0.8\n".to_owned(),
        table(20_000, 1, |row, _| format!("{row} {:.2} {:.2} {:.2}", row % 70.0, row / 70.0, (row / 50.0).sin())),
    ] {
        let fault = read(&file).unwrap_err();
        assert_eq!((fault.kind(), fault.expected()), (FileFaultKind::Ambiguous, "a header that names x, y and z"));
        assert!(fault.found().ends_with("the first of which counts up: either x, or a number before x, y and z"), "{fault}");
    }
    let named = read("id,x,y,z\n1,0.5,0,7.25\n2,1.5,0,7.5\n3,2.5,1,7.75\n").unwrap().0.points;
    assert_eq!(named[1].map(f64::to_bits), [1.5, 0.0, 7.5].map(f64::to_bits));
    // With three columns, no column is left for the number of the point.
    assert_eq!(points("1,0.5,0\n2,1.5,0\n3,2.5,1\n").len(), 3);
}

#[test]
fn rows_of_another_length_than_the_header_are_refused() {
    for (file, sentence) in [
        ("x,y,z,note\n1,2,3\n", "line 2: expected 4 columns, as the header names, found 3"),
        ("x,y,z,note\n1,2,3,a\n1,2,3\n", "line 3: expected 4 columns, as the header names, found 3"),
        ("x y z\n1 2 3\n4 5 6 7\n", "line 3: expected 3 columns, as the header names, found 4"),
        ("x;y;z\n1;2;3\n4;5;6;7;8\n", "line 3: expected 3 columns, as the header names, found 5"),
    ] {
        assert_eq!(refusal(file), sentence, "{file:?}");
    }
    assert_eq!(points("x,y,z,note\n1,2,3,\n"), [[1.0, 2.0, 3.0]]);
}

#[test]
fn ascii_pcd_is_read() {
    let file = "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS rgb y x z\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 2 1 1 1\nWIDTH 3\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3\nDATA ascii\n7 8 -2 1.5 3.25\n0 0 nan nan nan\n9 9 5.5 4 -6\n";
    let (recorder, summary) = read(file).unwrap();
    assert_eq!((recorder.points, summary.format), (TWO.to_vec(), Format::Pcd));
    assert_eq!(summary.notes, Notes { further_columns: 2, missing_points: 1, ..Notes::default() });
    for (wrong, right, sentence) in [
        ("POINTS 3", "POINTS 4", "line 15: expected 4 points, as the header states, found the end of the file after 3"),
        ("5.5 4 -6", "5.5 4", "line 14: expected 5 numbers, as the header states, found 4"),
        (
            "DATA ascii",
            "DATA binary",
            "line 11: expected PCD with the data ascii, found PCD with the data \"binary\"; save it with the data ascii",
        ),
        ("rgb y x z", "rgb y x w", "line 11: expected the fields x, y and z, found a header without one of them"),
    ] {
        assert_eq!(refusal(file.replace(wrong, right)), sentence);
    }
}

#[test]
fn ragged_rows_without_a_header_are_refused_with_their_line() {
    for (file, sentence) in [
        ("0 0 1\n10 0 2\n1 2 3 4 5 6 7 8 9\n", "line 3: expected 3 columns, as the first line has, found 9"),
        ("0 0 1 5\n10 0 2 5\n1 2 3\n", "line 3: expected 4 columns, as the first line has, found 3"),
        ("0;0;1\n10;0;2;7\n", "line 2: expected 3 columns, as the first line has, found 4"),
        ("0,0,1.5,2\n10,0,2.5\n0,0,1,2\n", "line 2: expected 4 columns, as the first line has, found 3"),
        ("0\t0\t1\t2\t3\n10\t0\t2\t3\n", "line 2: expected 5 columns, as the first line has, found 4"),
        ("# a comment\n0 0 1\n\n1 0 1\n0 1 2 3\n", "line 5: expected 3 columns, as the first line has, found 4"),
    ] {
        assert_eq!(refusal(file), sentence, "{file}");
    }
    // A separator at the end of some lines adds no column.
    assert_eq!(points("0;0;1\n1;0;2;\n0;1;3\n"), points("0;0;1;\n1;0;2\n0;1;3;\n"));
    assert_eq!(points("0 0 1 \n1 0 2\n"), [[0.0, 0.0, 1.0], [1.0, 0.0, 2.0]]);
    assert_eq!(points("1.5,2,3,,\n4,5,6,,\n"), [[1.5, 2.0, 3.0], [4.0, 5.0, 6.0]]);
}

/// A grid of 3 x 2 points after these lines.
fn probed(head: &str) -> String {
    let grid = ["0 0 1.5", "5 0 2.5", "10 0 3.5", "0 4 1.25", "5 4 2.25", "10 4 3.25"];
    format!("{head}{}\n", grid.join("\n"))
}

#[test]
fn the_lines_before_a_probed_grid_are_no_points() {
    for blanks in ["\n", "\n\n", " \r\n\n\n"] {
        assert_eq!(points(probed(&format!("0 10 3\n0 4 2\n-1 5 100\n{blanks}"))).len(), 6);
    }
    let short = refusal(probed("0 10 3\n0 4 3\n-1 5 100\n\n"));
    assert_eq!(short, "line 1: expected 9 points of a grid, as the lines before it promise, found 6");
    // Without the blank line, with another first point or with counts that are none, the lines are points.
    for head in ["0 10 3\n0 4 2\n-1 5 100\n", "1 10 3\n0 4 2\n-1 5 100\n\n", "0 10 3.5\n0 4 2\n-1 5 100\n\n", "0 10 1\n0 4 6\n-1 5 100\n\n"]
    {
        assert_eq!(points(probed(head)).len(), 9, "{head}");
    }
    assert_eq!(points("0 10 3\n0 4 2\n-1 5 100\n").len(), 3);
    assert_eq!(points("0 10 3\n0 4 2\n-1 5 100\n\n").len(), 3);
    assert_eq!(points("0 0 1\n1 0 1\n\n0 1 2\n").len(), 3);
}

#[test]
fn a_number_for_a_missing_measurement_is_noted_with_its_line() {
    let table = |value: &str| {
        let lines = (0..30)
            .map(|index| if index == 12 { format!("8 4 {value}\n") } else { format!("{} {} {}.5\n", index % 6, index / 6, index % 4) });
        lines.collect::<String>()
    };
    for value in ["-9999", "-32768", "-99999.0", "9999", "-999", "1e10", "-1e9", "32767"] {
        let far = read(table(value)).unwrap().1.notes.far_outside.unwrap();
        assert_eq!((far.line, far.axis, far.points, far.others), (13, 2, 1, [0.5, 3.5]), "{value}");
        assert_eq!(far.value.to_string().parse::<f64>(), value.parse::<f64>(), "{value}");
    }
    for value in ["5", "-3.25", "20"] {
        assert_eq!(read(table(value)).unwrap().1.notes.far_outside, None, "{value}");
    }
    for value in ["1e38", "-3.4028235e38", "-1.7976931348623157e308"] {
        assert!(refusal(table(value)).starts_with("line 13: expected a finite coordinate"), "{value}");
    }
    let with_header = format!("x y z\n{}", table("-9999"));
    assert_eq!(read(with_header).unwrap().1.notes.far_outside.unwrap().line, 14);
}

#[test]
fn a_probe_log_of_nine_columns_is_points() {
    let line = |index: u32, rest: &str| format!("{}.000 {}.000 {}.25{rest}\n", 4 * (index % 5), 4 * (index / 5), index % 3);
    for rest in [" 0.000 0.000 0.000 0.000 0.000 0.000", " 0 0 0 1 1 1", " 90.0 0.0 0.0"] {
        let log: String = (0..25).map(|index| line(index, rest)).collect();
        let (recorder, summary) = read(&log).unwrap();
        assert_eq!((recorder.points.len(), summary.notes.further_columns), (25, rest.split_whitespace().count() as u64));
    }
    let plate = "1.5 1.5 1.5 1.5 1.5\n".repeat(5);
    assert!(refusal(plate).contains("either a matrix of heights"));
}

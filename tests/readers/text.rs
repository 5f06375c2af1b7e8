//! Points in text.

use super::*;

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
    // The first mark comes late.
    assert_eq!(points("1;2;3\n4;5;6,5\n"), [[1.0, 2.0, 3.0], [4.0, 5.0, 6.5]]);
}

#[test]
fn one_file_has_one_decimal_mark() {
    assert_eq!(refusal("1.5;2;3\n4;5,5;6\n"), "line 2: expected a number with a decimal point, as before, found \"5,5\"");
    assert_eq!(refusal("1,5;2;3\n4;5.5;6\n"), "line 2: expected a number with a decimal comma, as before, found \"5.5\"");
    assert_eq!(refusal("1.234,5;2;3\n"), "line 1: expected three numbers, or a header that names x, y and z, found \"1.234,5;2;3\"");
}

#[test]
fn the_separator_holds_once_it_is_found() {
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
fn line_ends_and_marks_of_other_systems_pass() {
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
fn further_columns_are_counted() {
    let (recorder, summary) = read("1.5 -2 3.25 255 0 0\n4 5.5 -6 note\n").unwrap();
    assert_eq!(recorder.points, TWO);
    assert_eq!(
        summary,
        Summary { format: Format::Text, points: 2, facets: 0, unit: None, notes: Notes { further_columns: 3, ..Notes::default() } }
    );
    assert_eq!(read("1,2,3").unwrap().1.notes, Notes::default());
}

#[test]
fn one_point_is_read() {
    assert_eq!(points("1 2 3"), [[1.0, 2.0, 3.0]]);
}

#[test]
fn what_is_not_three_numbers_is_refused_with_its_line() {
    for (file, sentence) in [
        ("1,2\n", "line 1: expected three numbers, found two"),
        ("6400\n1 2 3\n", "line 1: expected three numbers, found one"),
        ("x,y,z\n\n1,2,3\n\n1,2\n", "line 5: expected three numbers between commas, found two"),
        ("1;2;3\n4;5\n", "line 2: expected three numbers between semicolons, found two"),
        ("1 2 3\n4\n", "line 2: expected three numbers between blanks, found one"),
        ("1,2,3\n1,,3\n", "line 2: expected a number, found nothing"),
        ("1,2,3\n1,2,\n", "line 2: expected a number, found nothing"),
        ("1\t2\t3\n1\t\t3\n", "line 2: expected a number, found nothing"),
        ("1,2,3\n1,2x,3\n", "line 2: expected a number, found \"2x\""),
        ("1,2,3\nx,y,z\n", "line 2: expected a number, found \"x\""),
        ("a,x,y,z\n7,1,2\n", "line 2: expected numbers in the columns that the header names x, y and z, found \"7,1,2\""),
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
fn numbers_that_are_no_coordinates_are_refused() {
    for (file, found) in [
        ("1,2,nan\n", "\"nan\""),
        ("1 2 3\n4 -Infinity 6\n", "\"-Infinity\""),
        ("1;2;3\n4;1e400;6\n", "\"1e400\""),
        ("1\t2\t3\n4\t1.1e12\t6\n", "\"1.1e12\""),
    ] {
        let fault = read(file).unwrap_err();
        assert_eq!(fault.kind(), FaultKind::OutOfRange);
        assert_eq!((fault.expected(), fault.found()), ("a finite coordinate of at most 1e12 in magnitude", found), "{file:?}");
    }
    assert_eq!(points("1e12 -1e12 0"), [[1e12, -1e12, 0.0]]);
}

#[test]
fn text_in_other_encodings_is_named() {
    let utf_16: Vec<u8> = "\u{feff}1,2,3\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
    assert_eq!(refusal(utf_16), "byte 0: expected text with points, STL, OBJ or PLY, found UTF-16 text; save it as UTF-8");
    // A header in Latin-1 is no obstacle.
    assert_eq!(points(b"X [\xb5m];Y [\xb5m];Z [\xb5m]\n1;2;3\n"), [[1.0, 2.0, 3.0]]);
}

//! Small programs in the dialects that people have, each with its points or its fault.

use super::*;
use crate::path::{Move, MoveKind};
use approx::assert_relative_eq;

const SETTINGS: ReadSettings = ReadSettings { sagitta: 1e-3, most_points: 1000 };

fn program(text: &str) -> Program {
    read(text, &SETTINGS).unwrap_or_else(|faults| panic!("{text}\n{faults:?}"))
}

/// The points as text: `?` from an unknown place, `r` a rapid, `f` at the feed rate.
fn points(text: &str) -> String {
    let written = program(text).points.into_iter().map(|point| {
        let letter = match point.reached {
            Reached::FromUnknown => '?',
            Reached::Rapid => 'r',
            Reached::Feed => 'f',
        };
        let coordinates = point.point.map(|value| format!("{}", (value * 1e4).round() / 1e4 + 0.0)).join(",");
        let feed = point.feed_rate.map_or(String::new(), |feed| format!("@{feed}"));
        format!("{letter}{coordinates}{feed}")
    });
    written.collect::<Vec<_>>().join(" ")
}

#[test]
fn programs_are_read_as_their_controls_run_them() {
    for (text, expected) in [
        ("G21 G90\nG0 X0 Y0 Z5\nG1 Z0 F100\nX10", "?0,0,5 f0,0,0@100 f10,0,0@100"),
        ("g21 g90\ng0 x0 y0 z5\ng1 z0 f100\nx10", "?0,0,5 f0,0,0@100 f10,0,0@100"),
        ("G0X0Y0Z5\r\nG1Z-.5F100\r\nX+10.\r\n", "?0,0,5 f0,0,-0.5@100 f10,0,-0.5@100"),
        ("%\nO0001 (PART (1)\nN10 G0 X1 Y2 Z3\nN20 G00 Z1\nM30\n%", "?1,2,3 r1,2,1"),
        ("G0 X 1 Y 2 Z 3\nG01 X 2 F 50", "?1,2,3 f2,2,3@50"),
        ("G20\nG0 X1 Y0 Z1\nG1 X2 F10", "?25.4,0,25.4 f50.8,0,25.4@254"),
        ("G0 X0 Y0 Z0\nG91\nG1 X1 F10\nX1 Y1\nG90\nX0", "?0,0,0 f1,0,0@10 f2,1,0@10 f0,1,0@10"),
        ("G0 X0 Y0\nZ5\nX1", "?0,0,5 r1,0,5"),
        ("G0 Z5\nX0 Y0\nG1 X1 F5", "?0,0,5 f1,0,5@5"),
        ("/G0 X0 Y0 Z5\n/1 G0 X1", "?0,0,5 r1,0,5"),
        ("; a comment\n(another) G0 X0 Y0 Z1 ; and more\nG1 X1 (in between) Y1 F9", "?0,0,1 f1,1,1@9"),
        ("G0 X0 Y0 Z1\nG4 P0.5\nG4 X2\nG04 U3\nX1", "?0,0,1 r1,0,1"),
        ("G17 G40 G49 G80 G54 G64 P0.01\nG0 X0 Y0 Z1", "?0,0,1"),
        ("G0 X0 Y0 Z1\nG43 H1 Z5\nG1 Z1 F3", "?0,0,1 r0,0,5 f0,0,1@3"),
        ("G55 G0 X0 Y0 Z1 M3 S1000\nM8\nM9 M5", "?0,0,1"),
        ("S1000 G95\nG0 X0 Y0 Z1\nG1 X1 F0.1", "?0,0,1 f1,0,1@100"),
        ("G0 X0 Y0 Z1\nG94 G1 X1 F0.1\nM2\nX9", "?0,0,1 f1,0,1@0.1"),
        ("G0 X0 Y0 Z1\nG28 G91 Z0\nG90 G0 Z3\nG1 X1 F1", "?0,0,1 ?0,0,3 f1,0,3@1"),
        ("G0 X0 Y0 Z1\nG28\nG0 X0 Y0 Z3\nX1", "?0,0,1 ?0,0,3 r1,0,3"),
        ("G0 X0 Y0 Z1\nG30 Z5\nZ2", "?0,0,1 ?0,0,2"),
        ("G0 X0 Y0 Z1\nG53 G0 Z0\nZ2", "?0,0,1 ?0,0,2"),
        ("T1 M6\nG0 X0 Y0 Z1\nX1\nT2 M6\nG0 X5\nX6", "?0,0,1 r1,0,1 ?5,0,1 r6,0,1"),
        ("G0 X0 Y0 Z0\nG1 X1\nG1", "?0,0,0 f1,0,0"),
        ("G0 X0 Y0 Z0 G1 X1 F1", "!conflict"),
        ("G0 X0 Y0 Z0\nG1 F1 X1 Y\u{31}", "?0,0,0 f1,1,0@1"),
        ("G0 X0 Y0 Z0\nM98\n", "!macro"),
        ("X1,Y2", "!unknown"),
    ] {
        match expected.strip_prefix('!') {
            None => assert_eq!(points(text), expected, "{text}"),
            Some(_) => assert!(read(text, &SETTINGS).is_err(), "{text}"),
        }
    }
}

#[test]
fn what_is_not_followed_is_refused_with_its_line() {
    use FaultKind as F;
    let start = "G0 X0 Y0 Z0\n";
    for (text, kind) in [
        ("G41 D1 X1", F::Transformation),
        ("G42 X1", F::Transformation),
        ("G68 X0 Y0 R30", F::Transformation),
        ("G51 P2", F::Transformation),
        ("G16", F::Transformation),
        ("G52 X10", F::Transformation),
        ("G92 X0", F::Transformation),
        ("G10 L2 P1 X0", F::Transformation),
        ("G43.4 H1", F::Transformation),
        ("TRANS X10", F::Transformation),
        ("G93", F::InverseTimeFeed),
        ("G81 X1 Z-5 R1 F10", F::Cycle),
        ("G83 X1 Z-5 R1 Q1 F10", F::Cycle),
        ("CYCLE800(1)", F::Cycle),
        ("G5 X1 Y1 I1 J1", F::Spline),
        ("G5.1 X1 Y1", F::Spline),
        ("G65 P9000", F::Macro),
        ("#1=5", F::Macro),
        ("G1 X#1", F::Macro),
        ("G1 X[1+2]", F::Macro),
        ("M98 P100", F::Macro),
        ("M99", F::Macro),
        ("IF [1 EQ 1] GOTO 10", F::Macro),
        ("G1 X1 A30", F::Axis),
        ("G1 W5", F::Axis),
        ("G1 X", F::Number),
        ("G1 X1.2.3", F::Number),
        ("G1 X--1", F::Number),
        ("G12", F::UnknownWord),
        ("M77", F::UnknownWord),
        ("L5", F::UnknownWord),
        ("G1 X1 !", F::UnknownWord),
        ("G1 X1 (open", F::Comment),
        ("G95 G1 X1 F0.1", F::FeedPerRevolution),
        ("G2 X10", F::Arc),
        ("G2 X10 I4", F::Arc),
        ("G2 X10 R4", F::Arc),
        ("G2 R4", F::Arc),
        ("G2 X10 R5 I5", F::Arc),
        ("G2 X10 I5 K1", F::Arc),
        ("G1 X10 I5", F::Arc),
        ("L X+10 FMAX", F::Heidenhain),
    ] {
        let faults = read(&format!("{start}{text}"), &SETTINGS).expect_err(text);
        assert!(faults.iter().any(|fault| fault.kind == kind && fault.line == 2), "{text}: {faults:?}");
    }
    let heidenhain = read("BEGIN PGM 1 MM\nTOOL CALL 1 Z S1000\nL Z+100 FMAX", &SETTINGS).unwrap_err();
    assert_eq!((heidenhain[0].kind, heidenhain[0].line), (F::Heidenhain, 1));
    assert_eq!(read("G1 X1 F10", &SETTINGS).unwrap_err()[0].kind, F::UnknownPosition);
    assert_eq!(read("X1 Y1 Z1", &SETTINGS).unwrap_err()[0].kind, F::UnknownWord);
    assert_eq!(read("M30", &SETTINGS).unwrap_err()[0].kind, F::Empty);
    let long = "G1 X1 F1\nX2\n".repeat(1000);
    assert_eq!(read(&format!("{start}{long}"), &SETTINGS).unwrap_err()[0].kind, F::TooManyPoints);
    // All faults at once, a hundred at most.
    assert_eq!(read(&"G12\nM77\n".repeat(10), &SETTINGS).unwrap_err().len(), 20);
    assert_eq!(read(&"G12\n".repeat(500), &SETTINGS).unwrap_err().len(), 100);
}

/// The points of the second block lie on the circle within the sagitta, turn the right way and end where told.
#[test]
fn arcs_are_chords_of_their_circle_in_every_plane_unit_and_mode() {
    type Case = (&'static str, [f64; 3], [f64; 3], [usize; 3], f64);
    let cases: [Case; 11] = [
        ("G0 X10 Y0 Z1\nG3 X0 Y10 I-10 J0 F10", [0.0, 0.0, 1.0], [0.0, 10.0, 1.0], [0, 1, 2], 90.0),
        ("G0 X10 Y0 Z1\nG2 X0 Y10 I-10 J0 F10", [0.0, 0.0, 1.0], [0.0, 10.0, 1.0], [0, 1, 2], -270.0),
        ("G0 X10 Y0 Z1\nG3 X0 Y10 R10 F10", [0.0, 0.0, 1.0], [0.0, 10.0, 1.0], [0, 1, 2], 90.0),
        ("G0 X10 Y0 Z1\nG2 X0 Y10 R-10 F10", [0.0, 0.0, 1.0], [0.0, 10.0, 1.0], [0, 1, 2], -270.0),
        ("G0 X10 Y0 Z1\nG3 I-10 F10", [0.0, 0.0, 1.0], [10.0, 0.0, 1.0], [0, 1, 2], 360.0),
        ("G0 X10 Y0 Z1\nG90.1 G3 X0 Y10 I0 J0 F10", [0.0, 0.0, 1.0], [0.0, 10.0, 1.0], [0, 1, 2], 90.0),
        ("G20 G0 X1 Y0 Z0\nG3 X0 Y1 I-1 F1", [0.0; 3], [0.0, 25.4, 0.0], [0, 1, 2], 90.0),
        ("G0 X10 Y0 Z0\nG91 G3 X-10 Y10 I-10 F10", [0.0; 3], [0.0, 10.0, 0.0], [0, 1, 2], 90.0),
        ("G0 X0 Y2 Z10\nG18 G3 X10 Z0 K-10 F10", [0.0, 2.0, 0.0], [10.0, 2.0, 0.0], [2, 0, 1], 90.0),
        ("G0 X3 Y10 Z0\nG19 G3 Y0 Z10 J-10 F10", [3.0, 0.0, 0.0], [3.0, 0.0, 10.0], [1, 2, 0], 90.0),
        ("G0 X10 Y0 Z0\nG3 X-10 Y0 Z5 I-10 F10", [0.0; 3], [-10.0, 0.0, 5.0], [0, 1, 2], 180.0),
    ];
    for (text, centre, end, [first, second, third], sweep) in cases {
        let points: Vec<[f64; 3]> = program(text).points.iter().map(|point| point.point).collect();
        let about = |point: [f64; 3]| [point[first] - centre[first], point[second] - centre[second]];
        let radius = about(end)[0].hypot(about(end)[1]);
        let mut turned = 0.0_f64;
        for ends in points.windows(2) {
            let [a, b] = [about(ends[0]), about(ends[1])];
            assert_relative_eq!(b[0].hypot(b[1]), radius, max_relative = 1e-9);
            turned += (a[0] * b[1] - a[1] * b[0]).atan2(a[0] * b[0] + a[1] * b[1]);
            let middle = (0.5 * (a[0] + b[0])).hypot(0.5 * (a[1] + b[1]));
            assert!(radius - middle <= 1.001e-3, "{text}");
            // The third axis goes evenly with the angle.
            let expected = points[0][third] + (end[third] - points[0][third]) * turned.to_degrees() / sweep;
            assert_relative_eq!(ends[1][third], expected, epsilon = 1e-9);
        }
        assert_relative_eq!(turned.to_degrees(), sweep, epsilon = 1e-9);
        let last = points[points.len() - 1];
        (0..3).for_each(|axis| assert_relative_eq!(last[axis], end[axis], epsilon = 1e-12));
    }
}

#[test]
fn apt_and_columns_are_read() {
    for (text, expected) in [
        ("PARTNO A\nFEDRAT/100,MMPM\nRAPID\nGOTO/0,0,5\nGOTO/0,0,0\nGOTO/1,0,0,0,0,1\nFINI", "?0,0,5 f0,0,0@100 f1,0,0@100"),
        ("UNITS/INCHES\nGOTO/0,0,1\nRAPID\nGOTO/1,0,1", "?0,0,25.4 r25.4,0,25.4"),
        ("$$ a file\nFROM/0,0,5\nFEDRAT/ 50.0, MMPM\nGOTO/ 1.0, $\n 2.0, 3.0", "?0,0,5 f1,2,3@50"),
        ("SPINDL/1000,RPM,CLW\nFEDRAT/0.1,MMPR\nGOTO/0,0,1\nGOTO/1,0,1", "?0,0,1 f1,0,1@100"),
        ("LOADTL/3\nGOTO/0,0,1\nCOOLNT/ON\nGOTO/2,0,1", "?0,0,1 f2,0,1"),
        ("x,y,z\n0,0,1\n1,0,1\n", "?0,0,1 f1,0,1"),
        ("0;0;1;500\n1;0;1;500\n", "?0,0,1 f1,0,1@500"),
        ("# tips\n0\t0\t1\n2\t0\t1", "?0,0,1 f2,0,1"),
    ] {
        assert_eq!(points(text), expected, "{text}");
    }
    for (text, kind) in [
        ("GOTO/0,0,1\nCIRCLE/0,0,0,0,0,1,5\n", FaultKind::Cycle),
        ("GOTO/0,0,1\nGOTO/0,0\n", FaultKind::Number),
        ("GOTO/0,0,1\nGOTO/0,0,1,0.5,0,0.866\n", FaultKind::Axis),
        ("GOTO/0,0,1\nWIBBLE/1\n", FaultKind::UnknownWord),
        ("0,0,1\n1,0\n", FaultKind::Number),
        ("0,0,1\n1,0,a\n", FaultKind::Number),
    ] {
        let faults = read(text, &SETTINGS).unwrap_err();
        assert_eq!((faults[0].kind, faults[0].line), (kind, 2), "{text}");
    }
}

fn moves() -> Vec<Move> {
    let points = [[0.0, 0.0, 10.0], [3.3, 0.25, 10.0], [3.3, 0.25, -1.5], [7.125, 2.0, -1.0625], [7.125, 2.0, 10.0]];
    let kinds = [MoveKind::Rapid, MoveKind::Link, MoveKind::Cut, MoveKind::Rapid];
    points.windows(2).zip(kinds).map(|(ends, kind)| Move { from: ends[0], to: ends[1], kind }).collect()
}

#[test]
#[allow(clippy::float_cmp)] // the same words give the same numbers
fn a_written_program_is_read_back() {
    let moves = moves();
    let feed_rates = [1.0, 500.0, 1234.56, 1.0];
    let operation = Operation { tool: 3, name: Some("ball (R3)"), spindle_speed: Some(12_000.0), moves: &moves, feed_rates: &feed_rates };
    for (inches, number_lines, decimals) in [(false, false, 4), (true, true, 6)] {
        let header = ["(made for a test)".to_owned()];
        let settings = WriteSettings { inches, number_lines, decimals, header: &header, ..WriteSettings::default() };
        let text = write_iso(&[operation, operation], &settings).unwrap();
        let program = program(&text);
        assert_eq!(program.dialect, Dialect::GCode);
        // The second operation's first Z is where the first one left the tool.
        let read: Vec<Move> = program.moves().0.into_iter().filter(|each| each.from != each.to).collect();
        assert_eq!(read.len(), 8, "{text}");
        for (read, written) in read.iter().zip(moves.iter().chain(&moves)) {
            assert_eq!(read.kind == MoveKind::Rapid, written.kind == MoveKind::Rapid);
            // Half a unit of the last decimal.
            (0..3).for_each(|axis| assert_relative_eq!(read.to[axis], written.to[axis], epsilon = 5.1e-5));
        }
        let cut = program.points.iter().find(|point| point.feed_rate.is_some_and(|feed| feed > 600.0)).unwrap();
        let feed = cut.feed_rate.unwrap();
        assert!(feed <= 1234.56 && feed > 1234.4, "{feed}");
        assert_eq!((cut.tool, cut.spindle_speed), (3, Some(12_000.0)));
    }
}

#[test]
fn modal_words_are_not_repeated() {
    let moves = moves();
    let operation = Operation { tool: 1, name: None, spindle_speed: None, moves: &moves, feed_rates: &[500.0; 4] };
    let text = write_iso(&[operation], &WriteSettings::default()).unwrap();
    let expected = "%\nG17 G21 G90 G94\nT1 M6\nG0 X0 Y0\nZ10\nX3.3 Y0.25\nG1 Z-1.5 F500\nX7.125 Y2 Z-1.0625\nG0 Z10\nM5\nM30\n%\n";
    assert_eq!(text, expected);
    let gap = write_iso(&[Operation { moves: &[moves[0], moves[2]], ..operation }], &WriteSettings::default());
    assert_eq!(gap, Err(Gap { operation: 0, index: 1 }));
    let no_feed = write_iso(&[Operation { feed_rates: &[], ..operation }], &WriteSettings::default());
    assert_eq!(no_feed, Err(Gap { operation: 0, index: 1 }));
}

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
        ("G00G20G17G90G40G49G80\nG70G91.1\nG00 X 1.0000 Y 0.0000 Z 1\nG01 X 2 F 10", "?25.4,0,25.4 f50.8,0,25.4@254"),
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
        // Smoothing, look-ahead and offsets of Fanuc and Haas, functions of the machine, a rotary axis at zero, a named program.
        ("O<PART>\nG5.1 Q1 R1\nG0 X0 Y0 Z1\nG5.1 Q1 X0 Y0 Z0\nG5 P10000\nG1 X1 F9\nG5 P0\nG5.1 Q0", "?0,0,1 f1,0,1@9"),
        ("G8 P1\nG103 P1\nG187 P3 E0.01\nG154 P2\nG0 X0 Y0 Z1 A0. B-0\nG1 X1 F9\nG28 G91 A0", "?0,0,1 f1,0,1@9"),
        ("G92.1 G50.1\nG0 X0 Y0 Z1\nG52 X0 Y0.0\nX1", "?0,0,1 r1,0,1"),
        ("M11\nM10 M34 M88\nG0 X0 Y0 Z1\nM13 S900\nM83\nX1", "?0,0,1 r1,0,1"),
        // Siemens: values after `=`, tools by name, what sets the control, machine coordinates, frames ended.
        ("%_N_A_MPF\n;$PATH=/_N_WKS_DIR\nN1 G17 G90 G71 G505 T=\"BALL 6\" D1\nN2 M6\nG0 X=1 Y = 2 Z=+3\nG1 X-1 F=9", "?1,2,3 f-1,2,3@9"),
        (
            "CYCLE832(0.01,1,1)\nFFWON SOFT\nCOMPCAD G642 ADIS=0.01 G0 X0 Y0 Z1\nMSG(\"G1 X5\")\nTRANS\nCYCLE800()\nX1\nM17\nRET",
            "?0,0,1 r1,0,1",
        ),
        (
            "DEF REAL _X_HOME, _TOL\n_X_HOME=-350 _TOL = 0.01\nCYCLE832(_TOL,_FINISH,1)\nG0 X0 Y0 Z1\nSUPA G0 X=_X_HOME C=_X_HOME D1\nX2",
            "?0,0,1 ?2,0,1",
        ),
        (
            "TRANS X0 Y=0.0 ; off\nROT Z0\nCYCLE800(0,\"TC1\",0,57,0,0.,0,,0,0,0,0,0,-1,100,1) S1=8000 M1=3\nDYNFINISH FGROUP(X,Y,Z) G450\n\
            G0 X0 Y0 Z1\nG75 Z0\nG0 Z2 M1=5\nLIMS=9000 X1",
            "?0,0,1 ?0,0,2 r1,0,2",
        ),
        ("_F_CUT=900 R12 = +3\nG0 X0 Y0 Z1\nG1 X=R12 F=_F_Cut\nR12=-4.5\nX=r12", "?0,0,1 f3,0,1@900 f-4.5,0,1@900"),
        ("S1=1000 G95\nG0 X0 Y0 Z1\nG1 X1 F0.1", "?0,0,1 f1,0,1@100"),
        ("G710\nG0 X0 Y0 Z1\nSUPA G0 Z0 D0\nG0 Z2\nG1 X1 F9", "?0,0,1 ?0,0,2 f1,0,2@9"),
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
    use ProgramFaultKind as F;
    let start = "G0 X0 Y0 Z0\n";
    for (text, kind) in [
        ("G41 D1 X1", F::Transformation),
        ("G42 X1", F::Transformation),
        ("G68 X0 Y0 R30", F::Transformation),
        ("G51 P2", F::Transformation),
        ("G16", F::Transformation),
        ("G52 X10", F::Transformation),
        ("G92 X0", F::Transformation),
        ("G92.3", F::Transformation),
        ("G51.1 X0", F::Transformation),
        ("G10 L2 P1 X0", F::Transformation),
        ("G43.4 H1", F::Transformation),
        ("TRANS X10", F::Transformation),
        ("G93", F::InverseTimeFeed),
        ("G81 X1 Z-5 R1 F10", F::Cycle),
        ("G83 X1 Z-5 R1 Q1 F10", F::Cycle),
        ("CYCLE800(0,\"TC1\",0,57,0,0,0,0,30,0,0,0,0,-1)", F::Cycle),
        ("CYCLE800(0,\"TC1\",0,57,0,0,0,0,0,0,0,0,5,-1)", F::Cycle),
        ("ROT Z30", F::Transformation),
        ("MIRROR X0", F::Transformation),
        ("S2=8000", F::Macro),
        ("TRANS Z5", F::Transformation),
        ("G1 X=R1", F::Macro),
        ("R1=5*2", F::UnknownWord),
        ("_F=_G", F::Number),
        ("R1=R2", F::Macro),
        ("G1 X=_X_HOME", F::Macro),
        ("G1 X1 F=_FEED", F::Macro),
        ("T=\"BALL", F::Number),
        ("G70", F::UnknownWord),
        ("O<part> CALL", F::Macro),
        ("G5 X1 Y1 I1 J1 P1 Q1", F::Spline),
        ("G2 X10 I5 P2", F::Arc),
        ("G0 B-0.5", F::Axis),
        ("G53 G0 A90", F::Axis),
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
    ] {
        let faults = read(&format!("{start}{text}"), &SETTINGS).expect_err(text);
        assert!(faults.iter().any(|fault| fault.kind == kind && fault.line == 2), "{text}: {faults:?}");
    }
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
        ("$$-> CSYS / 1, 0, 0, 0, $\n 0, 1, 0, 0, $\n 0, 0, 1, 0\nGOTO / 1, $ $$ x\n 2, 3 $$\nGOTO/0,0,1", "?1,2,3 f0,0,1"),
        ("SPINDL/1000,RPM,CLW\nFEDRAT/0.1,MMPR\nGOTO/0,0,1\nGOTO/1,0,1", "?0,0,1 f1,0,1@100"),
        ("LOADTL/3\nGOTO/0,0,1\nCOOLNT/ON\nGOTO/2,0,1", "?0,0,1 f2,0,1"),
        (
            "TOOL PATH/CONTOUR,TOOL,BALL_6\nTLDATA/MILL,6.0,3.0,75.0,0.0,0.0\nMSYS/0,0,0,1,0,0,0,1,0\n$$ centerline data\nPAINT/PATH\nLOADTL/1\n\
             SPINDL/RPM,12000\nRAPID\nGOTO/0,0,5,0,0,1\nPAINT/COLOR,42\nFEDRAT/MMPM,250.0\nGOTO/0,0,1\nEND-OF-PATH",
            "?0,0,5 f0,0,1@250",
        ),
        (
            "PARTNO A PART\nINTOL /    0.01000\nOUTOL /    0.01000\nTLAXIS/ 0.000000, 0.000000, 1.000000\nCUTTER/ 6.0, 3.0, 0.0, 3.0, 0.0,$\n 0.0, 50.0\n\
             TOOLNO/1, 6.000000, 3.000000,, 100.0,$\n 60.0, 50.0,$\n 0.0,MMPM, 70.0,RPM,CLW,ON,,NOTE\nSWITCH/1\nLOADTL/1,1\nFEDRAT/ 250.0000,MMPM\n\
             RAPID\nGOTO  /    0.00000,    0.00000,    5.00000\nGOTO  /    0.00000,    0.00000,    1.00000, 0.000000, 0.000000, 1.000000\nCYCLE/OFF\nREWIND/0\nFINI",
            "?0,0,5 f0,0,1@250",
        ),
        ("OPER_NAME_A/FINE\nSELECT/TOOL,2\nCLEARP/XYPLAN,30\nSET/MODE,ABSOL\nHEAD/1\nGOTO/0,0,1\nGODLTA/1,0,-1", "?0,0,1 f1,0,0"),
        ("UNITS/INCHES\nFEDRAT/10,IPM\nCUTCOM/OFF\nGOTO/0,0,1\nGOTO/1,0,1", "?0,0,25.4 f25.4,0,25.4@254"),
        ("x,y,z\n0,0,1\n1,0,1\n", "?0,0,1 f1,0,1"),
        ("0;0;1;500\n1;0;1;500\n", "?0,0,1 f1,0,1@500"),
        (
            "run,move,x_mm,y_mm,z_mm,nx,feed_rate_mm_min\n0,rapid,0,0,5,,9000\n0,rapid,1,0,5,,9000\n0,link,1,0,0,,500\n0,cut,2,0,0,0.1,600\n",
            "?0,0,5 r1,0,5 f1,0,0@500 f2,0,0@600",
        ),
        ("\"Feed\";\"Z (mm)\";\"Y (mm)\";\"X (mm)\"\n500;1;0;0\n;1;0;2", "?0,0,1 f2,0,1"),
        ("# tips\n0\t0\t1\n2\t0\t1", "?0,0,1 f2,0,1"),
    ] {
        assert_eq!(points(text), expected, "{text}");
    }
    let wide = format!("x,y,z,n\n0,0,1{}", ",".repeat(1_000));
    for (text, kind) in [
        (wide.as_str(), ProgramFaultKind::Number),
        ("GOTO/0,0,1\nCIRCLE/0,0,0,0,0,1,5\n", ProgramFaultKind::Arc),
        ("GOTO/0,0,1\nCIRCLE/0,5,0,0,0,1,3\nGOTO/5,5,1", ProgramFaultKind::Arc),
        ("GOTO/0,0,1\nCIRCLE/0,5,0,0,0.6,0.8,5\nGOTO/5,5,1", ProgramFaultKind::Arc),
        ("GOTO/10,0,1\nMOVARC/0,0,1,0,0,1,10,ANGLE,270\nGOTO/0,10,1", ProgramFaultKind::Arc),
        ("GOTO/10,0,1\nTLON,GOFWD/(CIRCLE/0,0,1,10),ON,(LINE/0,0,1,0,10,1)", ProgramFaultKind::Arc),
        ("INDIRV/0,1,0\nTLON,GOFWD/(CIRCLE/0,0,1,10),ON,(LINE/0,0,1,0,10,1)\nGOTO/10,0,1", ProgramFaultKind::Arc),
        ("GOTO/10,0,1\nTLAXIS/0,0.5,0.866\n", ProgramFaultKind::Axis),
        ("GOTO/10,0,1\nRAPID,GOTO/0,0,5\n", ProgramFaultKind::UnknownWord),
        ("GOTO/0,0,1\nCYCLE/DRILL,5\n", ProgramFaultKind::Cycle),
        ("GOTO/0,0,1\nCUTCOM/LEFT\n", ProgramFaultKind::Transformation),
        ("MSYS/0,0,0,1,0,0,0,1,0\nMSYS/0,0,5,1,0,0,0,1,0\nGOTO/0,0,1", ProgramFaultKind::Transformation),
        ("GOTO/0,0,1\nFEDRAT/10,IPM\nGOTO/1,0,1", ProgramFaultKind::UnknownUnit),
        ("GOTO/0,0,1\nGOTO/0,0\n", ProgramFaultKind::Number),
        ("GOTO/0,0,1\nGOTO/0,0,1,0.5,0,0.866\n", ProgramFaultKind::Axis),
        ("GOTO/0,0,1\nWIBBLE/1\n", ProgramFaultKind::UnknownWord),
        ("0,0,1\n1,0\n", ProgramFaultKind::Number),
        ("x,y,z,move\n0,0,1,jump", ProgramFaultKind::Number),
        ("x,y,z,feed\n0,0,1,fast", ProgramFaultKind::Number),
        ("0,0,1\n1,0,1,500,2\n", ProgramFaultKind::Number),
        ("0,0,1\n1,0,a\n", ProgramFaultKind::Number),
    ] {
        let faults = read(text, &SETTINGS).unwrap_err();
        assert_eq!((faults[0].kind, faults[0].line), (kind, 2), "{text}");
    }
    for circle in [
        "(CIRCLE/CANON,0,0,1,0,0,1,10),ON,(PLANE/0,1,0,0)",
        "(CIRCLE/0,0,1,10),ON,(LINE/1,0,1,0,10,1)",
        "(CIRCLE/0,0,1,9),ON,(LINE/0,0,1,0,9,1)",
        "(CYLNDR/0,0,1,0,0.6,0.8,10),ON,(POINT/0,10,1)",
    ] {
        let faults = read(&format!("GOTO/10,0,1\nINDIRV/0,1,0\nTLON,GOFWD/{circle}"), &SETTINGS).unwrap_err();
        assert_eq!((faults[0].kind, faults[0].line), (ProgramFaultKind::Arc, 3), "{circle}");
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
        let text = write(&[operation, operation], &settings).unwrap();
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
    let text = write(&[operation], &WriteSettings::default()).unwrap();
    let expected = "%\nG17 G21 G90 G94\nT1 M6\nG0 X0. Y0.\nZ10.\nX3.3 Y0.25\nG1 Z-1.5 F500.\nX7.125 Y2. Z-1.0625\nG0 Z10.\nM5\nM30\n%\n";
    assert_eq!(text, expected);
    let with_offset = write(&[operation], &WriteSettings { length_offset: true, ..WriteSettings::default() }).unwrap();
    assert_eq!(with_offset, expected.replace("\nZ10.\n", "\nG43 H1 Z10.\n"));
    let gap = write(&[Operation { moves: &[moves[0], moves[2]], ..operation }], &WriteSettings::default());
    assert_eq!(gap, Err(Gap { operation: 0, index: 1 }));
    let no_feed = write(&[Operation { feed_rates: &[], ..operation }], &WriteSettings::default());
    assert_eq!(no_feed, Err(Gap { operation: 0, index: 1 }));
}

#[test]
#[allow(clippy::float_cmp)] // the same words give the same numbers
fn a_plan_in_klartext_is_read_back() {
    let moves = moves();
    let operation = Operation { tool: 3, name: Some("ball (R3)"), spindle_speed: Some(12_000.0), moves: &moves, feed_rates: &[500.0; 4] };
    let header = ["PLANE RESET STAY".to_owned()];
    let settings = WriteSettings { klartext: true, header: &header, coolant: true, length_offset: true, ..WriteSettings::default() };
    let expected = "BEGIN PGM FINISH MM\nPLANE RESET STAY\n; ball R3\nTOOL CALL 3 Z S12000\nM3\nM8\nL X+0 Y+0 R0 FMAX\nL Z+10 R0 FMAX\n\
        L X+3.3 Y+0.25 FMAX\nL Z-1.5 F500\nL X+7.125 Y+2 Z-1.0625\nL Z+10 FMAX\nM5\nM9\nM30\nEND PGM FINISH MM\n";
    assert_eq!(write(&[operation], &settings).unwrap(), expected);
    for (inches, number_lines) in [(false, false), (true, true)] {
        let written = |klartext| {
            let settings = WriteSettings { klartext, inches, number_lines, decimals: 6, ..WriteSettings::default() };
            program(&write(&[operation, Operation { spindle_speed: None, ..operation }], &settings).unwrap())
        };
        let (read, as_iso) = (written(true), written(false));
        assert_eq!((read.dialect, read.points.len()), (Dialect::Klartext, as_iso.points.len()));
        for (point, other) in read.points.iter().zip(&as_iso.points) {
            assert_eq!((point.point, point.reached, point.tool), (other.point, other.reached, other.tool));
            assert_relative_eq!(point.feed_rate.unwrap_or(0.0), other.feed_rate.unwrap_or(0.0), max_relative = 1e-4);
        }
    }
}

#[test]
fn a_refused_word_is_one_fault_with_its_parameters() {
    let start = "G0 X0 Y0 Z5\n";
    for text in ["G83 X1 Y2 Z-5 R1 Q0.5 F100", "G81 Z-1 R2 L3", "G68 X0 Y0 R30", "G76 P1 Q2 R3", "G5.1 X1 Y1 I2 J3", "G84 X1 R2 K3"] {
        let faults = read(&format!("{start}{text}\nX3\nG1 X4 F5"), &SETTINGS).unwrap_err();
        assert_eq!(faults.len(), 1, "{text}: {faults:?}");
        assert_eq!(faults[0].line, 2);
    }
}

#[test]
fn circles_of_cutter_location_files_are_chords() {
    for (text, sweep, radius) in [
        ("GOTO/10,0,1\nCIRCLE/0,0,1,0,0,1,10\nGOTO/0,10,1", 90.0_f64, 10.0_f64),
        ("GOTO/10,0,1\nCIRCLE/0,0,1,0,0,-1,10,0.01,0.5,20,5\nGOTO/0,10,1", 270.0, 10.0),
        ("GOTO/0,0,5\nCIRCLE/0,0,0,0,-1,0,5\nGOTO/5,0,0", 270.0, 5.0),
        ("GOTO/0,0,5\nCIRCLE/0,0,0,0,1,0,5\nGOTO/5,0,0", 90.0, 5.0),
        ("GOTO/10,0,1\nMOVARC/0,0,1,0,0,-1,10,ANGLE,270\nGOTO/0,10,1", 270.0, 10.0),
        ("GOTO/10,0,1\nMOVARC/ CENTER, 0, 0, 1, AXIS, 0, 0, 1, RADIUS, 10\nGOTO/ 10, 0, 1", 360.0, 10.0),
        ("GOTO/10,0,1\nINDIRV/ 0, 1, 0\nTLON,GOFWD/ (CIRCLE/ 0, 0, 1,$\n 10),ON,(LINE/ 0, 0, 1,$\n 0, 10, 1)", 90.0, 10.0),
        ("GOTO/10,0,1\nINDIRV/ 0, 1, 0\nTLON,GOFWD/ (CIRCLE/ 0, 0, 1,$\n 10),ON,2,INTOF,$\n (LINE/ 0, 0, 1, 0, -10, 1)", 270.0, 10.0),
        (
            "GOTO/0,0,5\nINDIRV/ 1, 0, 0\nTLON,GOFWD/ (CYLNDR/ 0, 0, 0,$\n 0, 1, 0, 5), ON,$\n (PLANE/PERPTO,$\n (PLANE/(POINT/0, 0, 0),PERPTO,$\n (VECTOR/0, 1, 0)),$\n \
             (POINT/ 0, 0, 0),$\n (POINT/ -5, 0, 0))",
            270.0,
            5.0,
        ),
    ] {
        let program = program(text);
        let length: f64 =
            program.moves().0.iter().map(|each| (0..3).map(|axis| (each.to[axis] - each.from[axis]).powi(2)).sum::<f64>().sqrt()).sum();
        let is_circle = |line: &&str| ["CIRCLE", "MOVARC", "TLON"].iter().any(|word| line.starts_with(word));
        let line = text.lines().zip(1..).find(|(line, _)| is_circle(line)).unwrap().1;
        // Chords are shorter than their arcs by a share of 4/3 of the sagitta over the radius.
        assert_relative_eq!(length, sweep.to_radians() * radius, max_relative = 3e-4);
        assert!(program.points.iter().skip(1).all(|point| point.line == line && point.reached == Reached::Feed));
    }
}

#[test]
fn new_feeds_change_nothing_but_feed_words() {
    let with = |text: &str, feed: f64, old: bool| {
        let program = program(text);
        with_feeds(text, &program, &vec![feed; program.points.len()], old)
    };
    for (text, feed, expected) in [
        ("G0 X0 Y0 Z5\nG1 Z0 F100\nX10\n", 500.0, "G0 X0 Y0 Z5\nG1 Z0 F500\nX10\n"),
        ("g0x0y0z5\r\ng1z0f100(down)\r\nx10 ; on\r\n", 87.65, "g0x0y0z5\r\ng1z0F87.6(down)\r\nx10 ; on\r\n"),
        ("G0 X0 Y0 Z5\nF100\nG1 Z0 (F is (above)\nX10", 250.0, "G0 X0 Y0 Z5\nF100\nG1 Z0 F250 (F is (above)\nX10"),
        ("G20\nG0 X0 Y0 Z1\nG1 X1 F10\nG0 X2\nG1 X3", 508.0, "G20\nG0 X0 Y0 Z1\nG1 X1 F20.\nG0 X2\nG1 X3"),
        ("G0 X0 Y0 Z5\nG1 Z0 F100.\nX10\n", 500.0, "G0 X0 Y0 Z5\nG1 Z0 F500.\nX10\n"),
        ("S1000 G95\nG0 X0 Y0 Z1\nG1 X1 F0.1", 250.0, "S1000 G95\nG0 X0 Y0 Z1\nG1 X1 F0.25"),
        ("%\nO1\nG0 X0 Y0 Z5\nG1 Z0 F500.\nG2 X0 Y0 I5\nM30\n%", 500.0, "%\nO1\nG0 X0 Y0 Z5\nG1 Z0 F500.\nG2 X0 Y0 I5\nM30\n%"),
        ("G0 X=0 Y=0 Z=5\nFFWON\nG1 Z=0 F=100 SOFT", 500.0, "G0 X=0 Y=0 Z=5\nFFWON\nG1 Z=0 F500 SOFT"),
        ("G0 X0 Y0 Z5\nG1 Z0 T=\"F2\"", 500.0, "G0 X0 Y0 Z5\nG1 Z0 T=\"F2\" F500"),
        ("G0 X0 Y0 Z5\n_F1=3 T=\"F2\" G1 Z0 F100", 500.0, "G0 X0 Y0 Z5\n_F1=3 T=\"F2\" G1 Z0 F500"),
        ("_F1=100 R1=200\nG0 X0 Y0 Z5\nG1 Z0 F=_F1 X1\nG1 Z1 F=R1", 500.0, "_F1=100 R1=200\nG0 X0 Y0 Z5\nG1 Z0 F500 X1\nG1 Z1 F500"),
        ("x,y,z,feed,n\n0,0,1,,a\n1,0,1,500,b\n", 321.0, "x,y,z,feed,n\n0,0,1,,a\n1,0,1,321,b\n"),
        ("n;X (mm);Y (mm);Z (mm)\na;0;0;1\nb;1;0;1\n", 321.0, "n;X (mm);Y (mm);Z (mm);feed_rate_mm_min\na;0;0;1\nb;1;0;1;321\n"),
        ("0;0;1;500\n1;0;1;500\n", 321.0, "0;0;1;500\n1;0;1;321\n"),
        ("GOTO/0,0,1\nGOTO/1,0,1\nGOTO/2,0,1\n", 300.0, "GOTO/0,0,1\nFEDRAT/300,MMPM\nGOTO/1,0,1\nGOTO/2,0,1\n"),
        (
            "GOTO/9,0,1\nFEDRAT/900\nGOTO/1,0,1\n fedrat/900\nCIRCLE/0,0,1,0,0,1,1\nGOTO/0,1,1\n",
            300.0,
            "GOTO/9,0,1\nFEDRAT/900\nFEDRAT/300,MMPM\nGOTO/1,0,1\n fedrat/900\nFEDRAT/300,MMPM\nCIRCLE/0,0,1,0,0,1,1\nGOTO/0,1,1\n",
        ),
    ] {
        let written = with(text, feed, false);
        assert_eq!(written, expected);
        let (read, before) = (program(&written), program(text));
        for (point, before) in read.points.iter().zip(&before.points) {
            assert_eq!((point.point, point.reached), (before.point, before.reached));
            if point.reached == Reached::Feed {
                let rate = point.feed_rate.unwrap();
                assert!(rate <= feed * (1.0 + 1e-12) && rate >= 0.99 * feed, "{text}: {rate}");
            }
        }
    }
    assert_eq!(with("G0 X0 Y0 Z5\nG1 Z0 F100", 50.0, true), "G0 X0 Y0 Z5\nG1 Z0 F50 (F100)");
    // Siemens' comments are behind semicolons.
    let siemens = "; FINISH\nG0 X0 Y0 Z5\nG1 Z0 F=100 M8\nX5 F200 ; off";
    assert_eq!(with(siemens, 50.0, true), "; FINISH\nG0 X0 Y0 Z5\nG1 Z0 F50 M8 ; F=100\nX5 F50 ; off ; F200");
}

/// LinuxCNC's own interpreter follows a written program along the same moves. `RS274` names it, if it is not on the path.
#[test]
#[ignore = "needs LinuxCNC's rs274"]
fn linuxcnc_reads_back_what_is_written() {
    let folder = std::env::temp_dir().join(format!("scallopd-rs274-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let (table, file) = (folder.join("tools.tbl"), folder.join("written.ngc"));
    std::fs::write(&table, "T3 P3 D6 Z50 ;\n").unwrap();
    let mut random = crate::numerics::random::Random::new(3);
    let mut moves = moves();
    for _ in 0..500 {
        let from = moves[moves.len() - 1].to;
        let to = [0, 1, 2].map(|_| 200.0 * random.unit() - 100.0);
        moves.push(Move { from, to, kind: if random.unit() < 0.2 { MoveKind::Rapid } else { MoveKind::Cut } });
    }
    let feed_rates: Vec<f64> = moves.iter().map(|_| 10.0 + 5000.0 * random.unit()).collect();
    let operation = Operation { tool: 3, name: Some("ball"), spindle_speed: Some(6000.0), moves: &moves, feed_rates: &feed_rates };
    for inches in [false, true] {
        let settings = WriteSettings {
            inches,
            decimals: if inches { 5 } else { 4 },
            number_lines: inches,
            coolant: true,
            length_offset: inches,
            ..WriteSettings::default()
        };
        std::fs::write(&file, write(&[operation], &settings).unwrap()).unwrap();
        let interpreter = std::env::var("RS274").unwrap_or_else(|_| "rs274".to_owned());
        let output = std::process::Command::new(interpreter).arg("-g").arg("-t").arg(&table).arg(&file).output().unwrap();
        let text = String::from_utf8(output.stdout).unwrap();
        assert_eq!(text.contains("USE_TOOL_LENGTH_OFFSET"), inches, "{text}");
        // `16 N..... STRAIGHT_FEED(3.3000, 0.2500, -1.5000, ...)`: canonical commands in mm, to four decimals.
        let scale = if text.contains("USE_LENGTH_UNITS(CANON_UNITS_INCHES)") { 25.4 } else { 1.0 };
        let mut read: Vec<(bool, [f64; 3])> = Vec::new();
        for line in text.lines() {
            let Some((command, arguments)) = line.split_once("STRAIGHT_").and_then(|(_, rest)| rest.split_once('(')) else {
                continue;
            };
            let values: Vec<f64> = arguments.trim_end_matches(')').split(", ").map(|value| value.parse().unwrap()).collect();
            read.push((command == "TRAVERSE", [0, 1, 2].map(|axis| scale * values[axis])));
        }
        let expected: Vec<(bool, [f64; 3])> = moves.iter().map(|each| (each.kind == MoveKind::Rapid, each.to)).collect();
        // The way to the first point comes first.
        let read = &read[read.len() - expected.len()..];
        for (read, expected) in read.iter().zip(&expected) {
            assert_eq!(read.0, expected.0);
            // Half of the last decimal written, and of the last one that the interpreter prints.
            let bound = if inches { 25.4 * 5.5e-5 } else { 1.01e-4 };
            (0..3).for_each(|axis| assert_relative_eq!(read.1[axis], expected.1[axis], epsilon = bound));
        }
    }
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn numbers_of_blocks_have_five_digits_at_most() {
    let moves: Vec<Move> = (0..10_010_u32)
        .map(|step| [f64::from(step), f64::from(step + 1)].map(|x| [x, 0.0, 0.0]))
        .map(|[from, to]| Move { from, to, kind: MoveKind::Cut })
        .collect();
    let operation = Operation { tool: 1, name: None, spindle_speed: None, moves: &moves, feed_rates: &vec![500.0; moves.len()] };
    let text = write(&[operation], &WriteSettings { number_lines: true, ..WriteSettings::default() }).unwrap();
    let numbers: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix('N')?.split(' ').next()).collect();
    assert_eq!((numbers[9998], numbers[9999]), ("99990", "10"));
}

/// A program in Klartext around these blocks.
fn klartext(blocks: &str) -> String {
    let start = "0 BEGIN PGM FINISH MM\n1 BLK FORM 0.1 Z X-50 Y-50 Z-20\n2 TOOL CALL 5 Z S8000 F1500\n3 L X+0 Y+0 Z+5 R0 FMAX M3\n";
    format!("{start}{blocks}\nEND PGM FINISH MM\nL X+99 FMAX\n")
}

#[test]
fn klartext_is_read_as_its_control_runs_it() {
    for (blocks, expected) in [
        ("4 L Z+0 F500 M8\n5 L X+10\n6 L Z+50 FMAX\n7 L Z+0", "f0,0,0@500 f10,0,0@500 r10,0,50 f10,0,0@500"),
        ("L IX+1 IY-2 FAUTO\nL IX1,5 F AUTO", "f1,-2,5@1500 f2.5,-2,5@1500"),
        ("* - Finishing\n; L X+1\n/ 4 L X+1 F9 ; L X+2\nSTOP M9\nM5\nLBL 1\nl y+1 r0 f8 m", "f1,0,5@9 f1,1,5@8"),
        ("CYCL DEF 32.0 TOLERANCE\nCYCL DEF 32.1 T0.01\nCYCL DEF 247 DATUM SETTING ~\nQ339=+1 ;NUMBER\nL X1 F9", "f1,0,5@9"),
        ("CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X+0\nCYCL DEF 7.1 #3\nCYCL DEF 11.1 SCL 1\nCYCL DEF 8.1\nL X1 F9", "f1,0,5@9"),
        ("PLANE RESET STAY\nPLANE SPATIAL SPA+0 SPB+0 SPC+0 TURN MB50 F1000 SEQ-\nFUNCTION MODE MILL\nL X1 A+0 F9 M128 F500", "f1,0,5@9"),
        ("FN 0: Q50 = +700\nQ2=-3\nL X+Q2 FQ50\nL X-Q2 F Q50", "f-3,0,5@700 f3,0,5@700"),
        ("L M140 MB MAX\nL Z+3 FMAX\nL X1 F9", "?0,0,3 f1,0,3@9"),
        ("TCH PROBE 587 TL-TOOL ~\nQ356=+0 ;DIRECTION\nL X+0 Y+0 FMAX\nL Z+3 FMAX\nL X1 F9", "?0,0,3 f1,0,3@9"),
        ("L Z-1 R0 FMAX M91\nL Z+3 FMAX\nL X1 F9", "?0,0,3 f1,0,3@9"),
        ("TOOL DEF 6\nTOOL CALL \"BALL 6\" Z S9000 DR-0.1 DL+0\nL X1 FMAX\nL X2 F9", "?1,0,5 f2,0,5@9"),
        ("TOOL  CALL Z S9000 ; M6\nM6\nM136\nL X2 F0.1", "f2,0,5@900"),
        ("L X2 F9 M30\nL X3", "f2,0,5@9"),
    ] {
        assert_eq!(points(&klartext(blocks)), format!("?0,0,5 {expected}"), "{blocks}");
    }
    assert_eq!(program(&klartext("")).dialect, Dialect::Klartext);
    assert_eq!((program(&klartext("")).points[0].tool, program(&klartext("")).points[0].spindle_speed), (5, Some(8000.0)));
    // In inches; feeds are tenths of an inch.
    assert_eq!(points("BEGIN PGM 1 INCH\nL X+1 Y+0 Z+1 FMAX\nL X+2 F100"), "?25.4,0,25.4 f50.8,0,25.4@254");
}

#[test]
fn circles_of_klartext_are_chords() {
    for (blocks, sweep, radius, rise) in [
        ("CC X+10 Y+0\nC X+10 Y-10 DR+ F9", 90.0_f64, 10.0_f64, 0.0_f64),
        ("CC IX+10 IY+0\nC X+10 Y-10 DR- F9", 270.0, 10.0, 0.0),
        ("CC X+10 Y+0\nC X+0 Y+0 DR- F9", 360.0, 10.0, 0.0),
        ("CR X+10 Y-10 R+10 DR+ R0 F9", 90.0, 10.0, 0.0),
        ("CR X+10 Y-10 R-10 DR+ F9 M8", 270.0, 10.0, 0.0),
        ("CC X+0 Y+4\nCP IPA+900 IZ-3 DR+ F9", 900.0, 4.0, -3.0),
        ("CC X+0 Y+4\nCP IPA-30 Z+4 DR- F9", 30.0, 4.0, -1.0),
        ("L X-7 F9\nCC\nL X+0\nCP IPA+90 DR+", 90.0, 7.0, 0.0),
    ] {
        let (moves, _) = program(&klartext(blocks)).moves();
        let of_arc = moves.iter().filter(|each| each.kind == MoveKind::Cut && !(each.from[1] == 0.0 && each.to[1] == 0.0));
        let (length, climbed) = of_arc.fold((0.0, 0.0), |(length, climbed), each| {
            let [x, y, z] = [0, 1, 2].map(|axis| each.to[axis] - each.from[axis]);
            (length + x.hypot(y), climbed + z)
        });
        // Chords are shorter by a part of the sagitta.
        assert_relative_eq!(length, sweep.to_radians() * radius, max_relative = 1e-3);
        assert_relative_eq!(climbed, rise, epsilon = 1e-9);
    }
}

#[test]
fn what_klartext_moves_and_is_not_followed_is_refused() {
    use ProgramFaultKind as F;
    for (block, kind) in [
        ("L X+1 RL F9", F::Transformation),
        ("L X+1 A+30 F9", F::Axis),
        ("L X+1 C+Q9 F9", F::Axis),
        ("L X+Q1 F9", F::Macro),
        ("Q1 = Q2 + 1\nL X+Q1", F::Macro),
        ("Q1 = 1\nFN 18: SYSREAD Q1 = ID50\nL X+Q1", F::Macro),
        ("FN 9: IF +Q1 EQU +Q2 GOTO LBL 5", F::Macro),
        ("CALL LBL 1 REP 5", F::Macro),
        ("CALL PGM TNC:\\SUB.H", F::Macro),
        ("CYCL DEF 200 DRILLING ~", F::Cycle),
        ("CYCL CALL M3", F::Cycle),
        ("L X+1 F9 M99", F::Cycle),
        ("CYCL DEF 7.1 X+5", F::Transformation),
        ("CYCL DEF 8.1 X", F::Transformation),
        ("CYCL DEF 10.1 ROT+30", F::Transformation),
        ("CYCL DEF 11.1 SCL 0.995", F::Transformation),
        ("CYCL DEF 19.1 A+0 B+30", F::Transformation),
        ("PLANE SPATIAL SPA+0 SPB+30 SPC+0 STAY", F::Transformation),
        ("PLANE EULER EULPR+0", F::Transformation),
        ("TRANS DATUM AXIS X+5", F::Transformation),
        ("TOOL CALL 5 Z S1000 DL+0.2", F::Transformation),
        ("TOOL CALL 5 Y S1000", F::Transformation),
        ("RND R5", F::UnknownWord),
        ("APPR LT X+1 Y+1 LEN15 F9", F::UnknownWord),
        ("L X+1 F9 M77", F::UnknownWord),
        ("L X+ F9", F::Number),
        ("L X1.2.3 F9", F::Number),
        ("C X+1 Y+1 DR+", F::Arc),
        ("CC X+5 Y+0\nC X+1 Y+1", F::Arc),
        ("CC X+5 Y+0\nC X+5 Y+1 DR+", F::Arc),
        ("CC Y+5 Z+5", F::Arc),
        ("CC X+5 Y+0\nCP IPA-90 DR+", F::Arc),
        ("CC X+5 Y+0\nCP IPA+5401 DR+", F::Arc),
        ("M91\nCP IPA+90 DR+", F::Arc),
    ] {
        let faults = read(&klartext(block), &SETTINGS).expect_err(block);
        let line = 4 + u32::try_from(block.lines().count()).unwrap();
        assert!(faults.iter().any(|fault| fault.kind == kind && fault.line == line), "{block}: {faults:?}");
    }
    let cut_first = "BEGIN PGM 1 MM\nL X+1 F9\nL IY+1";
    let faults = read(cut_first, &SETTINGS).unwrap_err();
    assert!(faults.iter().all(|fault| fault.kind == F::UnknownPosition) && faults.len() > 1, "{faults:?}");
}

#[test]
fn feeds_of_klartext_are_replaced_in_their_place() {
    let blocks = "4 L Z+0 F500 M8\n5 L X+10 M9\n6 L X+12 FMAX\n7 L Y+5\n8 L Y+6 F AUTO ; slow\n9 L Y+7 FQ1 M3";
    let text = klartext(&format!("Q1=300\n{blocks}"));
    let read = program(&text);
    let feeds = |rates: &[f64], old: bool| with_feeds(&text, &read, rates, old).lines().skip(5).take(6).collect::<Vec<_>>().join("\n");
    let new = "4 L Z+0 F400 M8\n5 L X+10 F200 M9\n6 L X+12 FMAX\n7 L Y+5\n8 L Y+6 F100 ; slow\n9 L Y+7 F250 M3";
    assert_eq!(feeds(&[1.0, 400.0, 200.0, 1.0, 200.0, 100.0, 250.0], false), new);
    let with_old = new.replace("M8", "M8 ; F500").replace("; slow", "; slow ; F AUTO").replace("M3", "M3 ; FQ1");
    assert_eq!(feeds(&[1.0, 400.0, 200.0, 1.0, 200.0, 100.0, 250.0], true), with_old);
    // Nothing changes where the feeds stay, but for parameters, which are replaced by their values.
    assert_eq!(feeds(&[1.0, 500.0, 500.0, 1.0, 500.0, 1500.0, 300.0], false), blocks.replace("F AUTO", "F1500").replace("FQ1", "F300"));
}

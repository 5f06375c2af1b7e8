//! How much memory uploads take: none that grows with their size.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};

use crate::service::launch::Program;
use crate::service::server::PATIENCE;

const UPLOADS: usize = 16;
const FACETS: u32 = 2_000_000;
/// 100 MB each: 84 bytes of head and 50 a facet.
const FILE: usize = 84 + 50 * FACETS as usize;
/// The bound on the whole process, in kB.
const MOST_KB: u64 = 300 * 1000;

/// A thousand facets of an inclined sawtooth, sent over and over.
fn facets() -> Vec<u8> {
    let corner = |x: u16, y: u16| [f32::from(x), f32::from(y), 0.3 * f32::from(x) + 0.05 * f32::from(x * y % 7)];
    let facet = |index: u16| {
        let (x, y) = (index % 40, index / 40);
        let corners = [[0.0; 3], corner(x, y), corner(x + 1, y), corner(x, y + 1)];
        corners.iter().flatten().flat_map(|number| number.to_le_bytes()).chain([0, 0]).collect::<Vec<u8>>()
    };
    (0..1000).flat_map(facet).collect()
}

fn upload(address: SocketAddr, facets: &[u8]) -> String {
    const PARAMETERS: &str = r#"{"cutters":[{"type":"ball_end","diameter_mm":10}],"directions_deg":[0],"max_uncut_share":1,"scallop_height_mm":0.01,"machine":{"preset":"five_axis_vmc"}}"#;
    let head = format!(
        "--part\r\ncontent-disposition: form-data; name=\"parameters\"\r\n\r\n{PARAMETERS}\r\n\
         --part\r\ncontent-disposition: form-data; name=\"surface\"; filename=\"part.stl\"\r\n\r\n"
    );
    let tail = "\r\n--part--\r\n";
    let length = head.len() + FILE + tail.len();
    let mut stream = TcpStream::connect(address).unwrap();
    stream.set_read_timeout(Some(4 * PATIENCE)).unwrap();
    write!(
        stream,
        "POST /v1/cutter-recommendation/upload HTTP/1.1\r\nhost: test\r\nconnection: close\r\ncontent-type: multipart/form-data; boundary=part\r\n\
         content-length: {length}\r\n\r\n{head}"
    )
    .unwrap();
    stream.write_all(&[0; 80]).unwrap();
    stream.write_all(&FACETS.to_le_bytes()).unwrap();
    for _ in 0..FACETS / 1000 {
        stream.write_all(facets).unwrap();
    }
    stream.write_all(tail.as_bytes()).unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    answer
}

#[test]
fn sixteen_uploads_of_100_mb_at_once_stay_under_300_mb() {
    let program = Program::start(&["--max-concurrent-work", &UPLOADS.to_string()]);
    let (address, facets) = (program.address, facets());
    std::thread::scope(|scope| {
        let clients: Vec<_> = (0..UPLOADS).map(|_| scope.spawn(|| upload(address, &facets))).collect();
        for client in clients {
            let answer = client.join().unwrap();
            assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
            assert!(answer.contains(&format!("\"facets\":{FACETS}")), "{answer}");
        }
    });
    let peak = program.peak_memory_kb();
    assert!(peak < MOST_KB, "{UPLOADS} uploads took {peak} kB");
}

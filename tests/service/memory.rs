//! The memory of uploads is bounded for any number and size.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::Duration;

use crate::app::PATIENCE;
use crate::service::launch::Program;

/// 100 MB: binary STL has 84 bytes of head and 50 a facet.
const FACETS: u32 = 2_000_000;
const UPLOADS: usize = 16;
/// The number of attempts of a refused upload, one second apart.
const ATTEMPTS: usize = 30;
/// The bound on the whole process with the default settings, in kB.
const MOST_KB: u64 = 1024 * 1024;

/// A thousand facets of an inclined sawtooth, which are sent repeatedly. The sawtooth is a strip, so few facets remain
/// after merging, and planning is quick.
fn facets() -> Vec<u8> {
    let corner = |x: u16, y: u16| [f32::from(x), f32::from(y), 0.3 * f32::from(x) + 0.05 * f32::from(x * y % 7)];
    let facet = |index: u16| {
        let (x, y) = (index % 250, index / 250);
        let corners = [[0.0; 3], corner(x, y), corner(x + 1, y), corner(x, y + 1)];
        corners.iter().flatten().flat_map(|number| number.to_le_bytes()).chain([0, 0]).collect::<Vec<u8>>()
    };
    (0..1000).flat_map(facet).collect()
}

fn send(stream: &mut TcpStream, facets: &[u8]) -> std::io::Result<()> {
    stream.write_all(&[0; 80])?;
    stream.write_all(&FACETS.to_le_bytes())?;
    (0..FACETS / 1000).try_for_each(|_| stream.write_all(facets))
}

fn upload(address: SocketAddr, facets: &[u8]) -> String {
    const PARAMETERS: &str = r#"{"cutters":[{"type":"ball_end","diameter_mm":10}],"scallop_height_mm":0.5,"machine":{"preset":"five_axis_vmc"},"directions_deg":[0]}"#;
    let head = format!(
        "--part\r\ncontent-disposition: form-data; name=\"parameters\"\r\n\r\n{PARAMETERS}\r\n\
         --part\r\ncontent-disposition: form-data; name=\"surface\"; filename=\"part.stl\"\r\n\r\n"
    );
    let tail = "\r\n--part--\r\n";
    let length = head.len() + 84 + 50 * FACETS as usize + tail.len();
    let mut stream = TcpStream::connect(address).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    write!(
        stream,
        "POST /v1/cutter-recommendation/upload HTTP/1.1\r\nhost: test\r\nconnection: close\r\ncontent-type: multipart/form-data; boundary=part\r\n\
         content-length: {length}\r\n\r\n{head}"
    )
    .unwrap();
    // A refused upload is answered before all of it is sent.
    let _ = send(&mut stream, facets).and_then(|()| stream.write_all(tail.as_bytes()));
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    answer
}

#[test]
fn sixteen_uploads_of_100_mb_take_less_than_a_gib() {
    let program = Program::start(&[]);
    let (address, facets) = (program.address, facets());
    std::thread::scope(|scope| {
        for _ in 0..UPLOADS {
            scope.spawn(|| {
                let attempts = (0..ATTEMPTS).take_while(|_| !is_answered(&upload(address, &facets))).count();
                assert!(attempts < ATTEMPTS, "an upload was refused {ATTEMPTS} times");
            });
        }
    });
    let peak = program.peak_memory_kb();
    assert!(peak < MOST_KB, "{UPLOADS} uploads took {peak} kB");
}

/// Whether the answer is a recommendation; the only other allowed answer is 503.
fn is_answered(answer: &str) -> bool {
    let answered = answer.starts_with("HTTP/1.1 200");
    assert!(answered || (answer.starts_with("HTTP/1.1 503") && answer.contains("retry-after")), "{answer}");
    if !answered {
        std::thread::sleep(Duration::from_secs(1));
    }
    answered
}

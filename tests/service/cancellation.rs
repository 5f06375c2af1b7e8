//! Cancelled recommendations: the program stops working when the client is gone.
//!
//! All bounds are processor times of the program, which other programs on the machine do not change.

use std::time::Duration;

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

use crate::app::PATIENCE;
use crate::service::launch::Program;

/// Cells on each side of the surface, of two facets each.
const CELLS: u16 = 150;

/// The number of cutters: as many as an upload may have. Simulating each in all directions would take minutes of
/// processor time.
const CUTTERS: u32 = 200;

/// The work begins to plan after this processor time, in s: the upload itself takes less.
const BEGUN: f64 = 1.5;

/// The largest processor time, in s, after the end of the request. Every processor may continue for 50 ms; a second more
/// allows for a slow machine.
fn most_afterwards() -> f64 {
    let processors = std::thread::available_parallelism().map_or(1, |count| u32::try_from(count.get()).unwrap_or(u32::MAX));
    0.5 + f64::from(processors)
}

/// Waves over 100 x 100 mm in binary STL.
fn surface() -> Vec<u8> {
    let step = 100.0 / f32::from(CELLS);
    let corner = |column: u16, row: u16| {
        let (x, y) = (f32::from(column) * step, f32::from(row) * step);
        [x, y, 6.0 * (0.1 * x).sin() * (0.12 * y).cos()]
    };
    let mut file = vec![0; 80];
    file.extend((2 * u32::from(CELLS) * u32::from(CELLS)).to_le_bytes());
    for (column, row) in (0..CELLS).flat_map(|row| (0..CELLS).map(move |column| (column, row))) {
        let [a, b, c, d] = [corner(column, row), corner(column + 1, row), corner(column + 1, row + 1), corner(column, row + 1)];
        for facet in [[[0.0; 3], a, b, c], [[0.0; 3], a, c, d]] {
            file.extend(facet.as_flattened().iter().flat_map(|number| number.to_le_bytes()));
            file.extend([0, 0]);
        }
    }
    file
}

/// The bytes of an upload of the surface with a library of cutters in a table, and with additional parameters.
fn upload_with(further: &str) -> Vec<u8> {
    let rows = (0..CUTTERS).map(|index| format!("B{index},ball_end,{:.2},2\n", 4.0 + 0.02 * f64::from(index)));
    let library = format!("name,type,diameter_mm,teeth\n{}", rows.collect::<String>());
    let parameters = format!(r#"{{"scallop_height_mm":0.001,"machine":{{"preset":"five_axis_vmc"}}{further}}}"#);
    let mut body = Vec::new();
    for (name, data) in [("surface", surface().as_slice()), ("library", library.as_bytes()), ("parameters", parameters.as_bytes())] {
        body.extend(format!("--part\r\ncontent-disposition: form-data; name=\"{name}\"\r\n\r\n").bytes());
        body.extend(data.iter().chain(b"\r\n"));
    }
    body.extend(b"--part--\r\n");
    let head = format!(
        "POST /v1/cutter-recommendation/upload HTTP/1.1\r\nhost: test\r\ncontent-type: multipart/form-data; boundary=part\r\ncontent-length: {}\r\n\r\n",
        body.len()
    );
    [head.into_bytes(), body].concat()
}

fn upload() -> Vec<u8> {
    upload_with("")
}

/// The bytes of a batch of the fastest parameters at many contacts, sent as columns, by the slower model.
fn column_batch() -> Vec<u8> {
    const CONTACTS: u32 = 250_000;
    let column = |most: f64, step: f64| {
        let items: Vec<String> = (0..CONTACTS).map(|index| format!("{:.3}", 1.0 + (step * f64::from(index)) % most)).collect();
        items.join(",")
    };
    let body = format!(
        r#"{{"cutter":{{"type":"toroidal","diameter_mm":10,"corner_radius_mm":2,"teeth":4}},"scallop_tolerance_mm":0.01,"max_feed_per_tooth_mm":0.3,"spindle_speed_rpm":9000,"model":"envelope","surface_radius_mm":-80,"contacts":{{"slope_deg":[{}],"feed_angle_deg":[{}]}}}}"#,
        column(85.0, 0.37),
        column(350.0, 1.7)
    );
    let head = "POST /v1/cutting-parameters/batch HTTP/1.1\r\nhost: test\r\ncontent-type: application/json\r\n";
    format!("{head}content-length: {}\r\n\r\n{body}", body.len()).into_bytes()
}

/// Sends the upload, and returns once the program is at work on it.
async fn begin(program: &Program) -> TcpStream {
    begin_with(program, &upload()).await
}

/// Sends a request, and returns once the program is at work on it.
async fn begin_with(program: &Program, request: &[u8]) -> TcpStream {
    let mut stream = TcpStream::connect(program.address).await.unwrap();
    stream.write_all(request).await.unwrap();
    let deadline = tokio::time::Instant::now() + PATIENCE;
    while program.processor_time_s() < BEGUN {
        assert!(tokio::time::Instant::now() < deadline, "the work does not begin");
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    stream
}

/// Asserts that the program becomes idle after little more processor time.
async fn assert_at_rest(program: &Program) {
    let at_end = program.processor_time_s();
    let mut last = at_end;
    loop {
        tokio::time::sleep(Duration::from_secs(1)).await;
        let now = program.processor_time_s();
        assert!(now - at_end < most_afterwards(), "{:.1} s of processor time afterwards", now - at_end);
        // An idle server takes a few ms.
        if now - last < 0.1 {
            return;
        }
        last = now;
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn work_on_a_recommendation_ends_soon_after_its_client_reset_the_connection() {
    let program = Program::start(&["--request-timeout-s", "600"]);
    let stream = begin(&program).await;
    stream.set_zero_linger().unwrap();
    drop(stream);
    assert_at_rest(&program).await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn work_ends_soon_after_its_client_closed_the_connection() {
    for request in [upload_with(r#","include":["map","passes"]"#), column_batch()] {
        let program = Program::start(&["--request-timeout-s", "600"]);
        drop(begin_with(&program, &request).await);
        assert_at_rest(&program).await;
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn work_on_a_recommendation_ends_soon_after_its_time_is_over() {
    // The time counts from the request's last byte.
    let program = Program::start(&["--request-timeout-s", "1"]);
    let mut stream = TcpStream::connect(program.address).await.unwrap();
    stream.write_all(&upload()).await.unwrap();
    let mut answer = [0; 12];
    tokio::time::timeout(PATIENCE, stream.read_exact(&mut answer)).await.expect("an answer").unwrap();
    assert_eq!(&answer, b"HTTP/1.1 408");
    assert_at_rest(&program).await;
}

//! Target `pgm`: PNM files, which is PBM, PGM, PPM and PAM, and the same pixels in other words.
//!
//! Input: a file. It is read as one of a camera of the size that its header names.

use crate::png::{pgm, picture, png, read, same};
use reference::camera::Camera;
use verify::scenes::Lines;

/// One input.
///
/// # Panics
/// If the same pixels are read in two ways that do not come to the same, or are refused in more than a line.
pub fn run(data: &[u8]) {
    // A file that begins otherwise is the other targets'.
    if !data.starts_with(b"P") {
        return;
    }
    let epuck = Camera::epuck();
    let camera = size(data).and_then(camera).unwrap_or(epuck);
    if let Ok(lines) = read(data, &camera) {
        in_other_words(&camera, &lines);
        behind_it(data, &camera, &lines);
    }
}

/// Width and height of a header: the first two numbers behind the kind, with remarks left out, or those that PAM names.
fn size(file: &[u8]) -> Option<[usize; 2]> {
    let header = String::from_utf8_lossy(&file[2.min(file.len())..file.len().min(256)]).into_owned();
    let lines = header.lines().map(|line| line.split('#').next().unwrap_or_default());
    let words: Vec<&str> = lines.flat_map(str::split_ascii_whitespace).collect();
    let after = |name: &str| {
        let place = words.iter().position(|word| *word == name)?;
        words.get(place + 1)?.parse().ok()
    };
    match (after("WIDTH"), after("HEIGHT")) {
        (Some(width), Some(height)) => Some([width, height]),
        _ => match words[..] {
            [width, height, ..] => Some([width.parse().ok()?, height.parse().ok()?]),
            _ => None,
        },
    }
}

/// A camera of so wide and high images that reads the first and the last row (CAM-7).
fn camera([width, height]: [usize; 2]) -> Option<Camera> {
    let focal_length = width as f64;
    let principal_column = (width as f64 - 1.0) / 2.0;
    let lower_row = height.checked_sub(1)?;
    Camera { width, height, focal_length, principal_column, upper_row: 0, lower_row, ..Camera::epuck() }.checked().ok()
}

/// The same pixels as bytes and as text, with remarks, in colour, as PAM, and as PNG.
fn in_other_words(camera: &Camera, lines: &Lines) {
    let pixels = picture(camera, lines);
    let Camera { width, height, .. } = *camera;
    same("P5", &read(&pgm(camera, &pixels), camera), lines);
    same("PNG", &read(&png(camera, &pixels), camera), lines);
    let text: Vec<String> = pixels.iter().map(u8::to_string).collect();
    let plain = format!("P2 {width} {height} 255\n{}\n", text.join("\n"));
    same("P2", &read(plain.as_bytes(), camera), lines);
    let remarked = [format!("P5\n# two scan lines\n{width}\t{height} 255\n").as_bytes(), &pixels].concat();
    same("P5 with a remark", &read(&remarked, camera), lines);
    let colours: Vec<u8> = pixels.iter().flat_map(|&grey| [grey; 3]).collect();
    let colour = [format!("P6 {width} {height} 255\n").as_bytes(), &colours].concat();
    same("P6", &read(&colour, camera), lines);
    let header = format!("P7\nWIDTH {width}\nHEIGHT {height}\nDEPTH 1\nMAXVAL 255\nTUPLTYPE GRAYSCALE\nENDHDR\n");
    same("P7", &read(&[header.as_bytes(), &pixels].concat(), camera), lines);
}

/// What stands behind a binary image changes nothing.
fn behind_it(file: &[u8], camera: &Camera, lines: &Lines) {
    let is_binary = matches!(file.get(1), Some(b'4'..=b'7'));
    if is_binary {
        same("with more behind it", &read(&[file, b"\n0 1 2"].concat(), camera), lines);
    }
}

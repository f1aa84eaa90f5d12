//! Target `png`: PNG files, and the same file and pixels in other words.
//!
//! Input: a file. Its chunks' check sums are repaired, and it is read as one of a camera of its own size; a camera of another
//! size refuses it.

mod chunks;

use crate::fault;
use crate::memory;
use chunks::Chunks;
use image::codecs::png::PngEncoder;
use image::{ColorType, ExtendedColorType, ImageEncoder};
use reference::camera::Camera;
use verify::input::InputError;
use verify::scenes::Lines;

/// What reading an image may take beside 16 bytes for a pixel of the camera and 4 for a byte of the file: the decoder's
/// buffers, and 8 MiB for what the file says beside its pixels.
const MOST: usize = 12 << 20;

/// One input.
///
/// # Panics
/// If the file is read in two ways that do not come to the same, or is refused in more than a line.
pub fn run(data: &[u8]) {
    let Some(chunks) = Chunks::of(data) else {
        // No PNG: whatever it is, there is an answer.
        let _ = read(data, &Camera::epuck());
        return;
    };
    let file = chunks.write();
    let Some(camera) = chunks.size().and_then(camera) else {
        let _ = read(&file, &Camera::epuck());
        return;
    };
    let lines = read(&file, &camera);
    if let Ok(lines) = &lines {
        in_other_words(&chunks, &camera, lines);
        is_of_its_size(&file, &camera);
    }
}

/// The camera of so wide and high images, if there is one (CAM-7); its rows are the last but one and the last.
fn camera([width, height]: [u32; 2]) -> Option<Camera> {
    let [width, height] = [width, height].map(|side| usize::try_from(side).unwrap_or(usize::MAX));
    let focal_length = width as f64;
    let rows = (height.checked_sub(2)?, height - 1);
    let principal_column = (width as f64 - 1.0) / 2.0;
    let (upper_row, lower_row) = rows;
    Camera { width, height, focal_length, principal_column, upper_row, lower_row, ..Camera::epuck() }.checked().ok()
}

/// What the command reads, within a bound on memory.
///
/// # Panics
/// If it is refused in more than a line.
pub(crate) fn read(file: &[u8], camera: &Camera) -> Result<Lines, InputError> {
    let most = MOST + 16 * camera.width * camera.height + 4 * file.len();
    let lines = memory::at_most(most, || fault::lines_of_image(file, camera));
    match &lines {
        Ok(lines) => assert!(lines.iter().all(|line| line.len() == camera.width), "LINE-1"),
        Err(refusal) => crate::replay::is_a_sentence(&refusal.to_string()),
    }
    lines
}

/// The same chunks otherwise laid out, and the same pixels as a new PNG and as PGM.
fn in_other_words(chunks: &Chunks<'_>, camera: &Camera, lines: &Lines) {
    for (name, file) in [("parted", chunks.parted()), ("joined", chunks.joined()), ("remarked", chunks.remarked())] {
        same(name, &read(&file, camera), lines);
    }
    let pixels = picture(camera, lines);
    same("PNG", &read(&png(camera, &pixels), camera), lines);
    same("PGM", &read(&pgm(camera, &pixels), camera), lines);
}

/// # Panics
/// If what was read is not these lines.
pub(crate) fn same(name: &str, read: &Result<Lines, InputError>, lines: &Lines) {
    match read {
        Ok(found) => assert!(found == lines, "{name}: other lines"),
        Err(refusal) => panic!("{name}: {refusal}"),
    }
}

/// Another camera's images are refused (LOG-5).
fn is_of_its_size(file: &[u8], camera: &Camera) {
    let wider = Camera { width: camera.width ^ 1, focal_length: 641.0, principal_column: 0.0, ..*camera };
    assert!(matches!(read(file, &wider), Err(InputError::Size(..))), "of another size");
}

/// Pixels with these lines in the camera's rows and grey elsewhere.
pub(crate) fn picture(camera: &Camera, [upper, lower]: &Lines) -> Vec<u8> {
    let row = |row: usize| {
        if row == camera.upper_row {
            upper.clone()
        } else if row == camera.lower_row {
            lower.clone()
        } else {
            vec![127; camera.width]
        }
    };
    (0..camera.height).flat_map(row).collect()
}

/// A PNG file by the library's writer.
pub(crate) fn png(camera: &Camera, pixels: &[u8]) -> Vec<u8> {
    let mut file = Vec::new();
    let [width, height] = [camera.width, camera.height].map(|side| u32::try_from(side).expect("CAM-7"));
    let written = PngEncoder::new(&mut file).write_image(pixels, width, height, ExtendedColorType::from(ColorType::L8));
    written.expect("written to memory");
    file
}

/// A PGM file.
pub(crate) fn pgm(camera: &Camera, pixels: &[u8]) -> Vec<u8> {
    [format!("P5\n{} {}\n255\n", camera.width, camera.height).as_bytes(), pixels].concat()
}

//! Images and camera files, with one sentence for everything that can be wrong with them.

use crate::scenes::Lines;
use core::fmt;
use image::error::{ImageError, LimitErrorKind};
use image::{ColorType, DynamicImage, ImageDecoder, ImageFormat, ImageReader};
use reference::camera::{Camera, CameraRefusal};
use serde::Deserialize;
use std::fs;
use std::io::{self, BufReader, Cursor, Read};
use std::path::Path;

/// Longest image file that is read: 640 x 4096 pixels of 4 bytes are 10 MiB.
const LONGEST: u64 = 32 << 20;

/// What is wrong with a file.
#[derive(Debug)]
pub enum InputError {
    /// It cannot be read.
    Unreadable(io::Error),
    /// It is neither PNG nor PGM.
    NotAnImage,
    /// It is longer than any image of two scan lines need be.
    TooLong,
    /// It begins like an image, but is none.
    Broken(String),
    /// It has more than 8 bits per sample.
    Depth,
    /// It is not as large as the camera's images: the image's and the camera's width and height.
    Size([usize; 2], [usize; 2]),
    /// It is not the description of a camera.
    NotACamera(Place, String),
    /// It describes a camera that is refused.
    Camera(Place, CameraRefusal),
}

impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unreadable(error) => write!(f, "cannot be read: {error}"),
            Self::NotAnImage => f.write_str("is neither a PNG nor a PNM (PGM, PPM, PBM, PAM) image"),
            Self::TooLong => write!(f, "is longer than {LONGEST} bytes"),
            Self::Broken(what) => write!(f, "is a broken image: {what}"),
            Self::Depth => f.write_str("has more than 8 bits per sample; only 8-bit images are read"),
            Self::Size([width, height], [camera_width, camera_height]) => {
                write!(f, "is {width} x {height} pixels, the camera's images are {camera_width} x {camera_height}")
            }
            Self::NotACamera(place, what) => write!(f, "{place}does not describe a camera: {what}"),
            Self::Camera(place, refusal) => write!(f, "{place}describes no camera that can be used: {refusal}"),
        }
    }
}

impl core::error::Error for InputError {}

/// The line of a text file, counted from 1, and the key on it, as far as they are known.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Place {
    line: Option<usize>,
    key: Option<String>,
}

impl Place {
    /// The line that holds a byte of the text, and its key.
    fn of_byte(text: &str, byte: usize) -> Self {
        let line = text.bytes().take(byte).filter(|&byte| byte == b'\n').count();
        let key = text.lines().nth(line).and_then(|line| line.split_once('=')).map(|(key, _)| key.trim().to_owned());
        Self { line: Some(line + 1), key: key.filter(|key| !key.is_empty()) }
    }

    /// The line that sets a key; of a key that is left out there is only its name.
    fn of_key(text: &str, key: &str) -> Self {
        let sets = |line: &str| line.split_once('=').is_some_and(|(name, _)| name.trim() == key);
        Self { line: text.lines().position(sets).map(|line| line + 1), key: Some(key.to_owned()) }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(line) = self.line {
            write!(f, "line {line}: ")?;
        }
        // A key may have any character in it.
        self.key.iter().try_for_each(|key| write!(f, "{}: ", one_line(key)))
    }
}

/// The key of a camera file that a refusal is about.
pub(crate) fn key_of(refusal: CameraRefusal) -> &'static str {
    match refusal {
        CameraRefusal::Width => "width_px",
        CameraRefusal::Height => "height_px",
        CameraRefusal::FocalLength => "focal_length_px",
        CameraRefusal::FocalLengthVertical => "focal_length_vertical_px",
        CameraRefusal::PrincipalColumn => "principal_column_px",
        CameraRefusal::Rows => "lower_row",
    }
}

/// One line of text, whatever an error from below says.
fn one_line(error: &impl fmt::Display) -> String {
    let text = error.to_string();
    let words = text.split(|c: char| c.is_whitespace() || c.is_control()).filter(|word| !word.is_empty());
    words.collect::<Vec<_>>().join(" ")
}

/// The camera's two scan lines from an 8-bit PNG or PNM image; colour is converted to grey, transparency ignored.
pub fn scan_lines(path: &Path, camera: &Camera) -> Result<Lines, InputError> {
    let mut bytes = Vec::new();
    // A device may have no end.
    let file = fs::File::open(path).map_err(InputError::Unreadable)?;
    file.take(LONGEST + 1).read_to_end(&mut bytes).map_err(InputError::Unreadable)?;
    if bytes.len() as u64 > LONGEST {
        return Err(InputError::TooLong);
    }
    lines_of_image(&bytes, camera)
}

/// The camera's two scan lines from the bytes of an image file.
pub fn lines_of_image(bytes: &[u8], camera: &Camera) -> Result<Lines, InputError> {
    let reader = ImageReader::new(BufReader::new(Cursor::new(bytes)));
    let reader = reader.with_guessed_format().map_err(InputError::Unreadable)?;
    if !matches!(reader.format(), Some(ImageFormat::Png | ImageFormat::Pnm)) {
        return Err(InputError::NotAnImage);
    }
    if reader.format() == Some(ImageFormat::Png) && has_broken_palette(bytes) {
        return Err(InputError::Broken("the length of its palette is no multiple of 3".to_owned()));
    }
    let decoder = reader.into_decoder().map_err(broken)?;
    // The size first: a file may claim to be larger than the memory.
    let (width, height) = decoder.dimensions();
    let size = [width as usize, height as usize];
    if size != [camera.width, camera.height] {
        return Err(InputError::Size(size, [camera.width, camera.height]));
    }
    if !matches!(decoder.color_type(), ColorType::L8 | ColorType::La8 | ColorType::Rgb8 | ColorType::Rgba8) {
        return Err(InputError::Depth);
    }
    let grey = DynamicImage::from_decoder(decoder).map_err(broken)?.into_luma8();
    let row = |row: usize| grey.as_raw()[row * camera.width..(row + 1) * camera.width].to_vec();
    Ok([row(camera.upper_row), row(camera.lower_row)])
}

/// Whether a PNG file has a palette chunk that ends within a colour, at which png 0.18.1 panics (its issue 694, mended after it).
fn has_broken_palette(bytes: &[u8]) -> bool {
    // A chunk is its length, its name, its content and a check sum of four bytes; the first one follows a signature of eight.
    let mut rest = bytes.get(8..).unwrap_or_default();
    while let [a, b, c, d, name @ ..] = rest
        && let Some((name, after)) = name.split_first_chunk::<4>()
    {
        let length = u32::from_be_bytes([*a, *b, *c, *d]);
        if name == b"PLTE" && !length.is_multiple_of(3) {
            return true;
        }
        rest = usize::try_from(length).ok().and_then(|length| after.get(length.checked_add(4)?..)).unwrap_or_default();
    }
    false
}

/// What the image library could not do.
fn broken(error: ImageError) -> InputError {
    match error {
        ImageError::Limits(limits) if matches!(limits.kind(), LimitErrorKind::InsufficientMemory) => {
            InputError::Broken("it asks for too much memory".to_owned())
        }
        error => InputError::Broken(one_line(&error)),
    }
}

/// A camera file. What is left out is the e-puck's, or follows from what is given.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct CameraFile {
    width_px: Option<usize>,
    height_px: Option<usize>,
    focal_length_px: Option<f64>,
    focal_length_vertical_px: Option<f64>,
    principal_column_px: Option<f64>,
    upper_row: Option<usize>,
    lower_row: Option<usize>,
}

/// The camera that a TOML file describes (CAM-5 to CAM-7).
pub fn camera(path: &Path) -> Result<Camera, InputError> {
    let text = fs::read_to_string(path).map_err(InputError::Unreadable)?;
    camera_of_toml(&text)
}

/// The camera that a TOML text describes.
pub fn camera_of_toml(text: &str) -> Result<Camera, InputError> {
    let file: CameraFile = toml::from_str(text).map_err(|error| {
        let place = error.span().map_or_else(Place::default, |span| Place::of_byte(text, span.start));
        InputError::NotACamera(place, one_line(&error.message()))
    })?;
    file.camera().map_err(|refusal| InputError::Camera(Place::of_key(text, key_of(refusal)), refusal))
}

impl CameraFile {
    /// The camera, if CAM-7 allows it.
    pub(crate) fn camera(&self) -> Result<Camera, CameraRefusal> {
        let epuck = Camera::epuck();
        let width = self.width_px.unwrap_or(epuck.width);
        let height = self.height_px.unwrap_or(epuck.height);
        let camera = Camera {
            width,
            height,
            focal_length: self.focal_length_px.unwrap_or(epuck.focal_length),
            focal_length_vertical: self.focal_length_vertical_px.unwrap_or(epuck.focal_length_vertical),
            principal_column: self.principal_column_px.unwrap_or((width as f64 - 1.0) / 2.0),
            upper_row: self.upper_row.unwrap_or(0),
            lower_row: self.lower_row.unwrap_or(height.saturating_sub(1)),
        };
        camera.checked()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    //= reference/SPEC.md#cam
    //= type=test
    //# - **CAM-5** The scan lines MUST be the rows that the camera's description names, by default the first (upper
    //# layer) and the last (lower layer).
    //= reference/SPEC.md#cam
    //= type=test
    //# - **CAM-6** The principal column MUST default to `(Q_x - 1)/2`.
    #[test]
    fn a_camera_file_may_leave_out_what_follows() {
        assert_eq!(camera_of_toml("").unwrap(), Camera::epuck());
        let found = camera_of_toml("width_px = 320\nheight_px = 16\nfocal_length_px = 400.5").unwrap();
        assert!((found.principal_column - 159.5).abs() < 1e-12);
        assert_eq!((found.upper_row, found.lower_row), (0, 15));
    }

    proptest::proptest! {
        /// Whatever the bytes, there is an answer: arbitrary ones, and images with bytes changed.
        #[test]
        fn no_bytes_make_it_panic(
            bytes in proptest::collection::vec(proptest::num::u8::ANY, 0..200),
            changes in proptest::collection::vec((0..1900_usize, proptest::num::u8::ANY), 1..6),
            length in 0..1900_usize,
        ) {
            let camera = Camera::epuck();
            let mut image = include_bytes!("../../tests/data/renders/000.png").to_vec();
            let mut pgm = b"P5 480 8 255 ".to_vec();
            pgm.extend(&image);
            for (place, value) in changes {
                if let Some(byte) = image.get_mut(place) {
                    *byte = value;
                }
                // In the header, mostly.
                if let Some(byte) = pgm.get_mut(place % 14) {
                    *byte = value;
                }
            }
            for bytes in [&bytes[..], &image, &image[..length.min(image.len())], &pgm] {
                if let Err(error) = lines_of_image(bytes, &camera) {
                    proptest::prop_assert!(!error.to_string().contains('\n'));
                }
            }
            if let Err(error) = camera_of_toml(&String::from_utf8_lossy(&bytes)) {
                proptest::prop_assert!(!error.to_string().contains('\n'));
            }
        }
    }

    /// An image of two colours, 1 bit a pixel, whose palette is six bytes long, and one of five.
    #[test]
    fn a_palette_ends_with_a_colour() {
        let chunk = |name: &[u8; 4], content: &[u8]| {
            let sum = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&[name, content].concat());
            [&u32::try_from(content.len()).unwrap().to_be_bytes(), &name[..], content, &sum.to_be_bytes()].concat()
        };
        // 8 rows of 60 bytes and a filter's in a stored block: no compression, then Adler-32 of 488 zeros.
        let data = [&[0x78, 0x01, 1, 0xE8, 0x01, 0x17, 0xFE][..], &[0; 488], &[0x01, 0xE8, 0, 1]].concat();
        let header = [0, 0, 1, 0xE0, 0, 0, 0, 8, 1, 3, 0, 0, 0];
        let image = |palette: &[u8]| {
            let parts = [chunk(b"IHDR", &header), chunk(b"PLTE", palette), chunk(b"IDAT", &data), chunk(b"IEND", &[])];
            [&b"\x89PNG\r\n\x1a\n"[..], &parts.concat()].concat()
        };
        let read = |palette: &[u8]| lines_of_image(&image(palette), &Camera::epuck());
        assert_eq!(read(&[40, 40, 40, 9, 9, 9]).unwrap()[0], [40; 480]);
        assert!(read(&[40, 40, 40, 9, 9]).unwrap_err().to_string().contains("palette"));
    }

    #[test]
    fn nonsense_is_named() {
        let error = |text: &str| camera_of_toml(text).unwrap_err().to_string();
        assert!(error("focal_length_px = 0.0").contains("focal length"));
        assert!(error("focal_length_px = nan").contains("focal length"));
        assert!(error("lower_row = 9").contains("rows"));
        assert!(error("focal_lenght_px = 640.0").contains("focal_lenght_px"));
        assert!(error("width_px = \"wide\"").contains("string"));
        assert!(error("width_px = -4").contains("-4"));
        assert!(!error("= 4\n= 5").contains('\n'));
        // Nothing that would speak to a terminal, in a key that is no TOML or in one that is.
        for text in ["\0\u{b}x=9", "\"\\u001B[31m\" = 1"] {
            assert!(!error(text).contains(char::is_control), "{:?}", error(text));
        }
    }

    #[test]
    fn line_and_key_are_named() {
        let error = |text: &str| camera_of_toml(text).unwrap_err().to_string();
        let begins = |text: &str, place: &str| assert!(error(text).starts_with(place), "{}", error(text));
        begins("width_px = 480\n\nfocal_length_px = -1.0\n", "line 3: focal_length_px: ");
        begins("width_px = 480\nlength = 4", "line 2: length: ");
        begins("# a camera\nheight_px = \"eight\"", "line 2: height_px: ");
        begins("width_px = 480\nheight_px = ", "line 2: height_px: ");
        begins("principal_column_px = 1e9", "line 1: principal_column_px: ");
        begins("height_px = 1", "line 1: height_px: ");
    }
}

//! Target `lines`: any two scan lines by any camera through both pipelines.
//!
//! Input: a byte of options, six bytes of the camera's focal length and principal column and of the stripes' width, and
//! then the upper and the lower line, of equal length, which is the camera's width.

use crate::draw::Draw;
use crate::lockstep;
use reference::camera::Camera;
use reference::crossing::CrossingRule;
use reference::landmark::{Format, Landmark};
use verify::lockstep::Setting;
use verify::port::{Cameras, Landmarks};

/// Widths that CAM-7 allows.
const WIDTHS: core::ops::RangeInclusive<usize> = 32..=640;

/// The bits of an input's first byte.
struct Options(u8);

impl Options {
    /// The formats that are searched, in their order (LINE-4).
    fn formats(&self) -> &'static [Format] {
        match self.0 & 3 {
            0 => &[Format::Paper, Format::Wide],
            1 => &[Format::Paper],
            2 => &[Format::Wide],
            _ => &[Format::Wide, Format::Paper],
        }
    }

    fn rule(&self) -> CrossingRule {
        if self.0 & 4 == 0 { CrossingRule::Interpolated } else { CrossingRule::WholePixel }
    }

    /// Whether the camera is the input's, and not one with the e-puck's field of view.
    fn own_camera(&self) -> bool {
        self.0 & 8 != 0
    }

    /// Whether the stripes' width is the input's.
    fn own_stripes(&self) -> bool {
        self.0 & 16 != 0
    }

    /// Whether the lower line lacks its last pixel (LINE-2, LINE-3).
    fn one_is_short(&self) -> bool {
        self.0 & 32 != 0
    }
}

/// One input.
///
/// # Panics
/// If the pipelines differ by more than `SAME` allows.
pub fn run(data: &[u8]) {
    let Some((setting, [upper, lower])) = parse(data) else { return };
    let _ = lockstep::run(&setting, upper, lower);
}

fn parse(data: &[u8]) -> Option<(Setting, [&[u8]; 2])> {
    let mut draw = Draw::new(data);
    let options = Options(draw.byte());
    let (length, column) = (draw.within(0.0..1.0), draw.within(0.0..1.0));
    let stripe_width = draw.within(0.5e-3..20e-3);
    let pixels = draw.rest();
    let width = pixels.len() / 2;
    if !WIDTHS.contains(&width) {
        return None;
    }
    let (upper, lower) = pixels[..2 * width].split_at(width);
    let camera = if options.own_camera() { any_camera(width, length, column) } else { like_epuck(width) };
    let landmark = |format: Format| {
        let default = Landmark::new(format);
        if options.own_stripes() { Landmark { stripe_width, ..default } } else { default }
    };
    let setting = Setting {
        cameras: Cameras::new(camera.checked().ok()?)?,
        landmarks: Landmarks::of(options.formats().iter().map(|&format| landmark(format)).collect())?,
        rule: options.rule(),
    };
    let shorter = if options.one_is_short() { &lower[1..] } else { lower };
    Some((setting, [upper, shorter]))
}

/// A focal length from half the width to 2048 px, and a principal column anywhere in the image (CAM-7).
fn any_camera(width: usize, length: f64, column: f64) -> Camera {
    let shortest = width as f64 / 2.0;
    Camera {
        width,
        focal_length: shortest * (2048.0 / shortest).powf(length),
        principal_column: column * (width as f64 - 1.0),
        ..Camera::epuck()
    }
}

/// The field of view of the e-puck's camera.
fn like_epuck(width: usize) -> Camera {
    let epuck = Camera::epuck();
    let pixels = width as f64;
    let focal_length = epuck.focal_length * pixels / epuck.width as f64;
    Camera { width, focal_length, principal_column: (pixels - 1.0) / 2.0, ..epuck }
}

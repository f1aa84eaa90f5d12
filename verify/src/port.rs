//! The port's configuration, from the reference's, and what the conversion costs.

use fixedpoint::formats::{Column, FocalLength, StripeWidth};
use reference::camera::Camera;
use reference::crossing::CrossingRule;
use reference::landmark::{Format, Landmark};

/// A camera and its copy in the port's number formats.
#[derive(Clone, Copy, Debug)]
pub struct Cameras {
    /// As described.
    pub reference: Camera,
    /// Rounded to the port's formats.
    pub port: fixedpoint::camera::Camera,
}

/// How far the port's configuration is from the reference's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConfigurationError {
    /// Principal column, pixels.
    pub principal_column: f64,
    /// Focal length, pixels.
    pub focal_length: f64,
}

impl Cameras {
    /// Both cameras. `None` if the port cannot hold the description, which CAM-7 rules out.
    #[must_use]
    pub fn new(reference: Camera) -> Option<Self> {
        let width = u16::try_from(reference.width).ok()?;
        let principal_column = Column::checked_from_num(reference.principal_column)?;
        let focal_length = FocalLength::checked_from_num(reference.focal_length)?;
        let port = fixedpoint::camera::Camera::new(width, principal_column, focal_length).ok()?;
        Some(Self { reference, port })
    }

    /// The errors of the conversion.
    #[must_use]
    pub fn configuration_error(&self) -> ConfigurationError {
        ConfigurationError {
            principal_column: (self.port.principal_column().to_num::<f64>() - self.reference.principal_column).abs(),
            focal_length: (self.port.focal_length().to_num::<f64>() - self.reference.focal_length).abs(),
        }
    }
}

/// Landmarks and their copies.
#[derive(Clone, Debug)]
pub struct Landmarks {
    /// As described.
    pub reference: Vec<Landmark>,
    /// Rounded to the port's formats.
    pub port: Vec<fixedpoint::landmark::Landmark>,
}

impl Landmarks {
    /// Landmarks of the default dimensions in the given formats. `None` if the port cannot hold their stripe width.
    #[must_use]
    pub fn new(formats: &[Format]) -> Option<Self> {
        Self::of(formats.iter().map(|&format| Landmark::new(format)).collect())
    }

    /// The given landmarks. `None` if the port cannot hold their stripe width (LAND-7).
    #[must_use]
    pub fn of(reference: Vec<Landmark>) -> Option<Self> {
        let port: Option<Vec<_>> = reference.iter().map(port_landmark).collect();
        Some(Self { reference, port: port? })
    }

    /// Both formats, `paper` first.
    ///
    /// # Panics
    /// Never: the port holds the default stripe width.
    #[must_use]
    pub fn both() -> Self {
        Self::new(&Format::ALL).expect("the default stripe width is one of the port's")
    }
}

fn port_landmark(landmark: &Landmark) -> Option<fixedpoint::landmark::Landmark> {
    landmark.checked().ok()?;
    let stripe_width = StripeWidth::checked_from_num(landmark.stripe_width)?;
    fixedpoint::landmark::Landmark::new(port_format(landmark.format), stripe_width).ok()
}

/// The error of the port's stripe width, metres.
#[must_use]
pub fn stripe_width_error(landmark: &Landmark) -> f64 {
    let held = StripeWidth::checked_from_num(landmark.stripe_width).unwrap_or(StripeWidth::ZERO);
    (held.to_num::<f64>() - landmark.stripe_width).abs()
}

/// The port's name of a format.
#[must_use]
pub fn port_format(format: Format) -> fixedpoint::landmark::Format {
    match format {
        Format::Paper => fixedpoint::landmark::Format::Paper,
        Format::Wide => fixedpoint::landmark::Format::Wide,
    }
}

/// The port's name of a rule.
#[must_use]
pub fn port_rule(rule: CrossingRule) -> fixedpoint::crossing::CrossingRule {
    match rule {
        CrossingRule::Interpolated => fixedpoint::crossing::CrossingRule::Interpolated,
        CrossingRule::WholePixel => fixedpoint::crossing::CrossingRule::WholePixel,
    }
}

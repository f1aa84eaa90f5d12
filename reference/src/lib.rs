//! The formal specification of barloc in float64: from two scan lines of a camera to the camera's pose in the frame of a
//! barcode landmark, from these and the wheels' steps to the robot's pose ([`localizer`]), and the forward model that draws such
//! scan lines and drives such robots ([`world`]).
//!
//! `SPEC.md` beside this crate is the text; its requirements are cited by name (`THRESH-2`) where they are implemented.
//! The crate `fixedpoint` implements the same text in integers, with the same modules and a function of the same name for
//! every stage, and shares no code with this one.
//!
//! ```
//! use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};
//! use reference::camera::Camera;
//! use reference::crossing::CrossingRule;
//! use reference::detect::detect;
//! use reference::frame::Pose;
//! use reference::landmark::{Format, Landmark};
//! use reference::observer::Silent;
//! use reference::render::{Light, Posted, Scene, Sensor, render};
//!
//! // A landmark at the world's origin that carries 0xcc0d, and a camera 30 cm in front of it.
//! let camera = Camera::epuck();
//! let landmark = Landmark::new(Format::Paper);
//! let scene = Scene {
//!     camera_in_world: Pose::new(0.3, 0.02, std::f64::consts::PI),
//!     landmarks: vec![Posted { landmark_in_world: Pose::new(0.0, 0.0, 0.0), landmark, payload: 0xcc0d }],
//!     clutter: vec![],
//!     light: Light::default(),
//!     sensor: Sensor::default(),
//! };
//! let [upper, lower] = render(&camera, &scene, &mut ChaCha8Rng::seed_from_u64(1))?;
//! let found = detect(&upper, &lower, &camera, &[landmark], CrossingRule::default(), &mut Silent);
//! assert_eq!(found[0].payload, 0xcc0d);
//! assert!((found[0].camera_in_landmark.x() - 0.3).abs() < 0.01);
//! # Ok::<(), reference::codeword::EncodeRefusal>(())
//! ```

pub mod accept;
pub mod area;
pub mod bound;
pub mod camera;
pub mod codeword;
pub mod covariance;
pub mod crossing;
pub mod decode;
pub mod detect;
pub mod edge;
pub mod exposure;
pub mod extents;
pub mod filter;
pub mod fit;
pub mod frame;
pub mod grid;
pub mod homography;
pub mod hypotheses;
pub mod landmark;
pub mod layers;
pub mod localizer;
pub mod merge;
pub mod motion;
pub mod observation;
pub mod observer;
pub mod places;
pub mod pose;
pub mod quiet_zone;
pub mod range;
pub mod refusal;
pub mod regions;
pub mod regression;
pub mod render;
pub mod sampling;
pub mod skew;
pub mod threshold;
pub mod timeline;
pub mod trellis;
pub mod whiteness;
pub mod world;

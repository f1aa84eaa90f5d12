#![allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // of numbers that are small and positive

use super::*;
use crate::codeword::encode;
use crate::crossing::CrossingRule;
use crate::detect::{Workspace, detect, detect_moving};
use crate::drawing::{View, draw, stripes};
use crate::fit::Illumination;
use crate::formats::{Angle, Displacement, Steps};
use crate::landmark::Format;
use crate::merge::{Decoder, Detections};
use crate::motion::{Drive, Ways};
use crate::observation::mounted_ahead;
use crate::observer::Silent;
use crate::skew::Skew;
use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::PI;
use std::vec;
use std::vec::Vec as List;

const PAYLOAD: u32 = 0xBEEF;

/// 13 mm ahead, a turn of 0.02 rad, 4 mm to the left, all of it, and back.
const MOTIONS: [[f64; 3]; 5] =
    [[0.013, 0.0, 0.0], [0.0, 0.0, 0.02], [0.0, 0.004, 0.0], [0.013, -0.002, -0.03], [-0.013, 0.002, 0.01]];

/// A motion, and the play of a robot at 5 cm/s.
fn skew([x, y, turn]: [f64; 3]) -> Skew {
    let turn = Angle::from_bits((turn / PI * 2_f64.powi(31)).round() as i32);
    let motion = Skew { x: Displacement::from_num(x), y: Displacement::from_num(y), turn, play: 0 };
    if motion.is_at_rest() { motion } else { Skew { play: 11, ..motion } }
}

/// At rest, 13 mm ahead, and all of it.
const LIT_MOTIONS: [[f64; 3]; 3] = [[0.0; 3], MOTIONS[0], MOTIONS[3]];

fn landmark(format: Format) -> Landmark {
    if format == Format::Paper { Landmark::paper() } else { Landmark::wide() }
}

/// Both lines as a camera sees them that moves in between.
struct Scene {
    motion: [f64; 3],
    views: [View; 2],
    lines: [List<u8>; 2],
}

impl Scene {
    fn new(upper: View, motion: [f64; 3], random: &mut ChaCha8Rng) -> Self {
        let views = [upper, upper.moved(motion)];
        let (above, below) = encode(upper.format, PAYLOAD).unwrap();
        let lines = [views[0].line(480, above, random), views[1].line(480, below, random)];
        Self { motion, views, lines }
    }

    /// A barcode straight ahead at a distance in m, turned by `angle`.
    fn at(format: Format, distance: f64, angle: f64, motion: [f64; 3], seed: u64) -> Self {
        let upper = View::turned(format, 640.0 * 0.0015 / distance * angle.cos(), angle);
        Self::new(upper, motion, &mut ChaCha8Rng::seed_from_u64(seed))
    }

    fn at_rest(&self) -> Detections {
        let [upper, lower] = &self.lines;
        let (camera, landmarks) = (Camera::epuck(), [landmark(self.views[0].format)]);
        detect(upper, lower, &camera, &landmarks, CrossingRule::Interpolated, &mut Workspace::new(), &mut Silent)
    }

    fn moving(&self, skew: &Skew) -> Detections {
        let [upper, lower] = &self.lines;
        let (camera, landmarks, rule) = (Camera::epuck(), [landmark(self.views[0].format)], CrossingRule::Interpolated);
        detect_moving(upper, lower, &camera, &landmarks, rule, skew, &mut Workspace::new(), &mut Silent)
    }

    /// The one detection by the true skew.
    fn found(&self) -> Detection {
        let found = self.moving(&skew(self.motion));
        assert_eq!(found.iter().map(|found| found.payload).collect::<List<_>>(), [PAYLOAD], "{:?}", self.views);
        found[0]
    }

    fn measured(&self, detection: &Detection) -> Measurements {
        let [upper, lower] = &self.lines;
        layers([upper, lower], &Camera::epuck(), &landmark(detection.format), detection)
    }
}

/// The Mahalanobis distance of a view's true `(a, s, k)` from an estimate: the square is chi-square of three.
fn distance(view: &View, homography: &Homography, covariance: &Covariance) -> f64 {
    let d = [
        homography.a.to_num::<f64>() - view.a,
        homography.s.to_num::<f64>() - view.s,
        homography.k.to_num::<f64>() - view.k,
    ];
    let Covariance { aa, as_, ak, ss, sk, kk } = *covariance;
    let mut rows =
        [[aa, as_, ak], [as_, ss, sk], [ak, sk, kk]].map(|row| row.map(|entry| entry as f64 / 2_f64.powi(50)));
    // Forward elimination, with what is left of d: dᵀ Σ⁻¹ d is the sum of its squares over the pivots.
    let mut rest = d;
    let mut sum = 0.0;
    for pivot in 0..3 {
        let above = rows[pivot];
        sum += rest[pivot] * rest[pivot] / above[pivot];
        for row in pivot + 1..3 {
            let share = rows[row][pivot] / above[pivot];
            rest[row] -= share * rest[pivot];
            rows[row].iter_mut().zip(above).for_each(|(entry, above)| *entry -= share * above);
        }
    }
    sum.sqrt()
}

/// One in 10,000 of a chi-square of three is above 4.6².
const FAR: f64 = 4.6;

/// All scenes whose distances are from 15 to 45 cm, 6.4 to 2.1 px per stripe, and whose barcode stays in the picture.
fn scenes() -> impl Iterator<Item = Scene> {
    let views = [Format::Paper, Format::Wide].into_iter().flat_map(|format| {
        [0.15, 0.2, 0.3, 0.45]
            .into_iter()
            .flat_map(move |distance| [0.0, 0.5, -0.7].into_iter().map(move |angle| (format, distance, angle)))
    });
    (0..)
        .zip(views.flat_map(|view| MOTIONS.map(|motion| (view, motion))))
        .map(|(seed, ((format, distance, angle), motion))| Scene::at(format, distance, angle, motion, seed))
}

/// With the true skew every barcode is found, where the upper row saw it (`SKEW-8`); each layer says where its own row did.
#[test]
fn each_row_s_own_homography_is_measured() {
    let mut seen = 0;
    for scene in scenes() {
        let found = scene.found();
        let measured = scene.measured(&found);
        let (upper, lower) = (found.fit.unwrap(), found.lower_fit.unwrap());
        assert_eq!((measured[0].homography, measured[0].covariance), (found.homography, Some(upper.covariance)));
        assert_eq!((measured[0].pose, measured[0].pose_covariance), (found.camera_in_landmark, found.covariance));
        assert_eq!((measured[1].homography, measured[1].covariance), (lower.homography, Some(lower.fit.covariance)));
        let layers: List<_> = measured.iter().map(|measurement| measurement.layer).collect();
        assert_eq!(layers, [MeasuredLayer::Upper, MeasuredLayer::Lower], "{:?}", scene.views);
        for (measurement, view) in measured.iter().zip(&scene.views) {
            let far = distance_of(view, measurement);
            assert!(far < FAR, "{far} {:?} {view:?} {:?}", measurement.layer, scene.motion);
            let pose = covariance::transform(
                &measurement.homography,
                &measurement.covariance.unwrap(),
                &Camera::epuck(),
                &landmark(view.format),
            );
            assert_eq!(pose, Ok((measurement.pose, measurement.pose_covariance)));
            assert_eq!(measurement.estimator, Estimator::Fit);
            seen += 1;
        }
    }
    assert_eq!(seen, 2 * 2 * 4 * 3 * 5);
}

/// Taken to be at rest, a camera that comes nearer or turns loses what is near, or sees it where it is not.
#[test]
fn motion_that_is_left_out_costs_detections_or_their_truth() {
    for (distances, motion) in [(&[0.15, 0.2][..], MOTIONS[0]), (&[0.15, 0.2, 0.3, 0.45], MOTIONS[1])] {
        for &distance in distances {
            let scene = Scene::at(Format::Paper, distance, 0.0, motion, 5);
            assert!(scene.at_rest().is_empty(), "{distance}");
        }
    }
    // At 30 cm 13 mm are 1.5 px at either end: both layers are fitted as one, and the upper row saw none of it.
    let scene = Scene::at(Format::Paper, 0.3, 0.0, MOTIONS[0], 5);
    let wrong = scene.at_rest();
    assert!(wrong.iter().all(|found| {
        found.fit.is_none_or(|fit| distance(&scene.views[0], &found.homography, &fit.covariance) > FAR)
    }));
}

/// Below 1.25 px per stripe only the trellis reads it, 0.64 px of blur, and of a moving camera it is not asked (`SKEW-9`).
//= reference/SPEC.md#skew
//= type=test
//# - **SKEW-9** Of a moving camera TRELLIS MUST NOT be asked.
#[test]
fn the_trellis_is_not_asked_of_a_moving_camera() {
    let view = View { blur: 0.64, ..View::turned(Format::Paper, 1.18, 0.2) };
    let scene = Scene::new(view, [0.0; 3], &mut ChaCha8Rng::seed_from_u64(3));
    let found: List<_> = scene.at_rest().iter().map(|found| (found.payload, found.decoder)).collect();
    assert_eq!(found, [(PAYLOAD, Decoder::Trellis)]);
    assert!(scene.moving(&Skew { play: 1, ..Skew::AT_REST }).is_empty());
}

/// A robot at 5 cm/s, 102 steps of both wheels between the rows, that turns by 3.3 mrad more than they say, 2 px. 3 cm ahead of the
/// axle its camera goes 0.12 mm aside. Both layers are measured where their own rows saw them: chi-square of three on average.
#[test]
fn odometry_that_is_off_leaves_both_layers_where_they_were_seen() {
    let steps = Steps::from_num(0.0131 / 0.128_805e-3);
    let ways = Ways { left: steps, right: steps };
    let told = Skew::of_ways([ways], &Drive::epuck(), &mounted_ahead(), &Camera::epuck());
    assert_eq!(told.play, 11);
    let (mut squares, mut seen) = (List::new(), 0_u8);
    for (distance, angle) in
        (0..10).flat_map(|i| [-0.7, -0.45, -0.2, 0.0, 0.3, 0.6].map(|angle| (0.15 + 0.03 * f64::from(i), angle)))
    {
        let format = if seen % 2 == 0 { Format::Paper } else { Format::Wide };
        let turn = if seen % 3 == 0 { -0.0033 } else { 0.0033 };
        let motion = [0.0131, 0.0131 * turn / 2.0 + 0.03 * turn, turn];
        let scene = Scene::at(format, distance, angle, motion, seen.into());
        let found = scene.moving(&told);
        assert_eq!(found.iter().map(|found| found.payload).collect::<List<_>>(), [PAYLOAD], "{distance} {angle}");
        let measured = scene.measured(&found[0]);
        assert_eq!([measured[0].layer, measured[1].layer], [MeasuredLayer::Upper, MeasuredLayer::Lower]);
        for (measurement, view) in measured.iter().zip(&scene.views) {
            squares.push(distance_of(view, measurement).powi(2));
        }
        seen += 1;
    }
    let mean = squares.iter().sum::<f64>() / squares.len() as f64;
    assert!(squares.len() == 120 && (2.0..4.5).contains(&mean), "{} {mean}", squares.len());
}

/// [`distance`] of a measurement.
fn distance_of(view: &View, measurement: &Measurement) -> f64 {
    distance(view, &measurement.homography, &measurement.covariance.unwrap())
}

/// The light falls at a pixel anywhere in the barcode to a half, or to a quarter: layers are fitted under a step as well, at rest
/// from the fit of both (`LAYER-1`), and say where their own rows are. What only the local threshold reads `TRELLIS-9` decides again,
/// at rest only. At the step itself a layer alone may be wrong, as both together; most are chi-square of three, whose median is 1.54².
//= reference/SPEC.md#layer
//= type=test
//# - **LAYER-1** Each layer of a detection with a fit MUST be fitted alone (FIT, with one layer), from that fit's `(a,
//# s, k, σ)` under the light, even or a step, that the fit was made under; of a moving camera these are the fits of
//# SKEW-7.
#[test]
fn layers_are_fitted_under_the_light_of_the_detection() {
    let (mut far, mut decided_again) = (List::new(), 0);
    for (shade, motion) in [2, 4].into_iter().flat_map(|shade| LIT_MOTIONS.map(|motion| (shade, motion))) {
        for edge in (190..300).step_by(2) {
            let mut scene = Scene::at(Format::Paper, 0.2, 0.1, motion, edge as u64);
            scene.lines.iter_mut().flat_map(|line| &mut line[edge..]).for_each(|pixel| *pixel /= shade);
            for found in scene.moving(&skew(motion)) {
                assert_eq!(found.payload, PAYLOAD);
                if found.fit.unwrap().illumination == Illumination::Even {
                    continue;
                }
                if found.decoder == Decoder::Trellis {
                    assert!(skew(motion).is_at_rest());
                    decided_again += 1;
                }
                for measurement in scene.measured(&found) {
                    let view = &scene.views[usize::from(measurement.layer == MeasuredLayer::Lower)];
                    far.push(distance(view, &measurement.homography, &measurement.covariance.unwrap()));
                }
            }
        }
    }
    far.sort_by(f64::total_cmp);
    let share = |part: usize| far[far.len() * part / 100];
    assert!(far.len() > 350 && decided_again > 0, "{} {decided_again}", far.len());
    assert!(share(50) < 1.7 && share(97) < FAR, "{} {}", share(50), share(97));
}

/// `LAYER-2`: what a layer alone does not say is not measured, and `LAYER-4`: unless neither does.
//= reference/SPEC.md#layer
//= type=test
//# - **LAYER-2** A layer whose own fit is refused, or whose `s²` is above ACCEPT-6's `v` of the detection's decoder
//# with its own gain, or which COV-4 calls undetermined, MUST give no measurement.
#[test]
fn a_layer_without_a_fit_of_its_own_gives_no_measurement() {
    let scene = Scene::at(Format::Paper, 0.2, 0.3, [0.0; 3], 3);
    let (camera, landmark, found) = (Camera::epuck(), Landmark::paper(), scene.found());
    let white = vec![200; 480];
    let [upper, lower] = [&scene.lines[0][..], &scene.lines[1][..]];
    let measured = |lines: [&[u8]; 2]| layers(lines, &camera, &landmark, &found);
    let layers_of =
        |lines: [&[u8]; 2]| measured(lines).iter().map(|measurement| measurement.layer).collect::<List<_>>();
    assert_eq!(layers_of([upper, lower]), [MeasuredLayer::Upper, MeasuredLayer::Lower]);
    assert_eq!(layers_of([upper, &white]), [MeasuredLayer::Upper]);
    assert_eq!(layers_of([&white, lower]), [MeasuredLayer::Lower]);
    let own = measured([&white, &white]);
    assert_eq!((own.len(), own[0].layer, own[0].homography), (1, MeasuredLayer::Both, found.homography));
    assert_eq!((own[0].pose, own[0].pose_covariance), (found.camera_in_landmark, found.covariance));
    assert_eq!((own[0].covariance, own[0].estimator), (Some(found.fit.unwrap().covariance), Estimator::Fit));
    // `s²` above `v`, 10 grey levels by 160 of contrast and 3 more: by 9 it is not yet, by 14 it is.
    let noisy = |amplitude: i16| {
        let mut line = lower.to_vec();
        for (pixel, sign) in line.iter_mut().zip([1, -1, -1, 1, 1].into_iter().cycle()) {
            *pixel = (i16::from(*pixel) + sign * amplitude).clamp(1, 254) as u8;
        }
        layers_of([upper, &line]).len()
    };
    assert_eq!((noisy(9), noisy(14)), (2, 1));
}

/// Times of what is measured (`LAYER-3`, `LAYER-4`).
//= reference/SPEC.md#layer
//= type=test
//# - **LAYER-3** A layer's measurement MUST be its `(a, s, k)` with the covariance of its own fit, at its row's time
//# (EXPOSE-1).
#[test]
fn measurements_have_their_layers_times() {
    let scene = Scene::at(Format::Paper, 0.2, 0.3, [0.0; 3], 3);
    let found = scene.found();
    let times = [1_000, 2_001].map(Time::from_micros);
    let of = |layer, estimator| Measurement { layer, estimator, ..Measurement::own(&found) }.time(times).as_micros();
    assert_eq!(of(MeasuredLayer::Upper, Estimator::Fit), 1_000);
    assert_eq!(of(MeasuredLayer::Lower, Estimator::Fit), 2_001);
    assert_eq!(of(MeasuredLayer::Both, Estimator::Fit), 1_000);
    assert_eq!(of(MeasuredLayer::Both, Estimator::Paper), 1_000);
}

/// `LAYER-4`: without a fit the merged homography's pose; black and white alone leave nothing to be fitted (`FIT-12`). 8 px to
/// the right by a turn of 8/640 at the image's middle, 2 px more than the odometry says: `a` is the upper layer's (`SKEW-8`).
//= reference/SPEC.md#layer
//= type=test
//# - **LAYER-4** A detection with a fit of which no layer gives a measurement MUST give one, the detection's own, and a
//# detection without a fit its pose with COV-5's covariance, both at the upper row's time (SKEW-8).
#[test]
fn a_detection_without_a_fit_is_one_measurement() {
    let (above, below) = encode(Format::Paper, PAYLOAD).unwrap();
    let mut lines = [vec![255; 480], vec![255; 480]];
    draw(&mut lines[0], 196, 4, &stripes(Format::Paper, above));
    draw(&mut lines[1], 206, 4, &stripes(Format::Paper, below));
    let scene = Scene { motion: [0.0, 0.0, 0.0125], views: [View::turned(Format::Paper, 4.0, 0.0); 2], lines };
    assert!(scene.at_rest().is_empty());
    let found = scene.found();
    assert_eq!(found.estimator(), Estimator::Paper);
    assert_eq!((found.transitions, found.lower_fit), (Some(found.homography), None));
    let off = found.homography.a.to_num::<f64>() - (235.5 - 239.5);
    assert!(off.abs() < 0.01, "{off}");
    let measured = scene.measured(&found);
    assert_eq!((measured.len(), measured[0].layer, measured[0].covariance), (1, MeasuredLayer::Both, None));
    assert_eq!((measured[0].pose, measured[0].pose_covariance), (found.camera_in_landmark, found.covariance));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// What a camera at rest detects it detects by [`detect_moving`]; and of what a threshold decodes there, a camera that hardly
    /// moves sees the same in the upper row, alone instead of together.
    #[test]
    fn a_camera_that_hardly_moves_sees_what_one_at_rest_does(
        wide in any::<bool>(),
        (pixels, angle, blur) in (2.0..6.0, -0.7..0.7, 0.4..0.7),
        seed in any::<u64>(),
    ) {
        let format = if wide { Format::Wide } else { Format::Paper };
        let view = View { blur, ..View::turned(format, pixels, angle) };
        let scene = Scene::new(view, [0.0; 3], &mut ChaCha8Rng::seed_from_u64(seed));
        let at_rest = scene.at_rest();
        prop_assert_eq!(&at_rest, &scene.moving(&Skew::AT_REST));
        prop_assert!(at_rest.iter().all(|found| found.lower_fit.is_none()));
        let hardly = Skew { x: Displacement::from_bits(1), play: 5, ..Skew::AT_REST };
        let moving = scene.moving(&hardly);
        for (one, other) in at_rest.iter().zip(&moving) {
            prop_assert_eq!((one.payload, one.upper, one.lower), (other.payload, other.upper, other.lower));
            let alone = scene.measured(one);
            for (one, other) in alone.iter().zip(scene.measured(other)) {
                // The same minimum from another start, up to a 15th of a standard deviation (FIT-11) each.
                let one = View { a: one.homography.a.to_num(), s: one.homography.s.to_num(), k: one.homography.k.to_num(), ..view };
                let apart = distance_of(&one, &other);
                prop_assert!(apart < 0.2, "{}", apart);
            }
        }
        prop_assert_eq!((at_rest.len(), moving.len()), (1, 1));
    }
}

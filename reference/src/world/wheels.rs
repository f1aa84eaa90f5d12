//! Imperfect wheels, and the counter of their steps (WORLD-1 to WORLD-4).

use super::Step;
use crate::frame::{Pose, Robot, World};
use crate::motion::{Drive, MotionModel, State, Ways, advance};
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

/// Standard deviations of what robots of one make differ by (WORLD-2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Imperfections {
    /// Of the wheels' difference `e`, a share.
    pub wheel_difference: f64,
    /// Of the axle's excess `g`, a share.
    pub axle_excess: f64,
    /// Of a wheel's way after one metre, m/√m; the same for every robot.
    pub slip: f64,
}

impl Default for Imperfections {
    /// Diameters unequal by 0.2 %, an axle off by 0.5 %, a slip of 1 mm per root metre.
    fn default() -> Self {
        Self { wheel_difference: 0.002, axle_excess: 0.005, slip: 1e-3 }
    }
}

impl Imperfections {
    /// A robot as it is drawn.
    #[must_use]
    pub fn none() -> Self {
        Self { wheel_difference: 0.0, axle_excess: 0.0, slip: 0.0 }
    }
}

/// The wheels of one robot; signs are those of [`State`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wheels {
    /// `e`: by how much the right wheel is larger than the left one, as a share of both.
    pub wheel_difference: f64,
    /// `g`: by how much the axle is longer than nominal, as a share.
    pub axle_excess: f64,
    /// Standard deviation of a wheel's way after one metre, m/√m.
    pub slip: f64,
}

impl Wheels {
    /// The wheels of a robot of this make; two normal deviates (WORLD-2).
    //= reference/SPEC.md#world
    //# - **WORLD-2** The wheels' `e` and `g` MUST be drawn once a run from normal distributions around 0, by default of
    //# standard deviation 0.002 and 0.005.
    pub fn draw<R: Rng + ?Sized>(sigma: &Imperfections, rng: &mut R) -> Self {
        let [e, g]: [f64; 2] = [StandardNormal.sample(rng), StandardNormal.sample(rng)];
        Self { wheel_difference: sigma.wheel_difference * e, axle_excess: sigma.axle_excess * g, slip: sigma.slip }
    }

    /// Where the robot is after its wheels have rolled `ways`, metres by their nominal diameter (WORLD-1, WORLD-3).
    ///
    /// `drive` gives the nominal axle; two normal deviates, the left wheel's first.
    //= reference/SPEC.md#world
    //# - **WORLD-1** The robot MUST move as MOTION-2 and MOTION-3 say, with the `e` and `g` of its own wheels and with
    //# what these rolled in a tick, slip included.
    //= reference/SPEC.md#world
    //# - **WORLD-3** A wheel that rolls `l` MUST slip by a normal deviate of variance `q |l|`, by default `q = 1e-6 m`,
    //# independent of everything else.
    pub fn roll<R: Rng + ?Sized>(
        &self,
        robot_in_world: &Pose<World, Robot>,
        ways: &Ways,
        drive: &Drive,
        rng: &mut R,
    ) -> Pose<World, Robot> {
        let mut slipped = |way: f64| {
            let deviate: f64 = StandardNormal.sample(rng);
            way + self.slip * way.abs().sqrt() * deviate
        };
        let ways = Ways { left: slipped(ways.left), right: slipped(ways.right) };
        let (wheel_difference, axle_excess) = (self.wheel_difference, self.axle_excess);
        let state = State { pose: *robot_in_world, wheel_difference, axle_excess };
        advance(&state, &ways, &Drive { model: MotionModel::Arc, ..*drive }).pose
    }
}

/// What a wheel has rolled by its nominal diameter, in whole steps (WORLD-4).
//= reference/SPEC.md#world
//# - **WORLD-4** Every 100 ms a reading MUST say how many whole steps (MOTION-1) each wheel has made since the one
//# before: the difference of what was rolled without slip, rounded down.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct StepCounter {
    rolled: Ways,
    read: [f64; 2],
}

impl StepCounter {
    pub(super) fn roll(&mut self, ways: &Ways) {
        self.rolled.left += ways.left;
        self.rolled.right += ways.right;
    }

    /// Steps of the left and the right wheel since this was last asked, by a step's way in metres.
    pub(super) fn read(&mut self, step: f64) -> [Step; 2] {
        let whole = [self.rolled.left, self.rolled.right].map(|way| (way / step).floor());
        let since = [whole[0] - self.read[0], whole[1] - self.read[1]];
        self.read = whole;
        #[expect(clippy::cast_possible_truncation, reason = "a reading's steps are far below 2^31")]
        since.map(|steps| steps as Step)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    /// Mean and variance over a sample of this size are within four of their standard errors.
    const SAMPLE: u16 = 4000;

    fn assert_deviates(deviates: &[f64]) {
        let count = deviates.len() as f64;
        let mean = deviates.iter().sum::<f64>() / count;
        let square = deviates.iter().map(|deviate| deviate * deviate).sum::<f64>() / count;
        assert!(mean.abs() < 4.0 / count.sqrt(), "mean {mean}");
        assert!((square - 1.0).abs() < 4.0 * (2.0 / count).sqrt(), "mean square {square}");
    }

    //= reference/SPEC.md#world
    //= type=test
    //# - **WORLD-2** The wheels' `e` and `g` MUST be drawn once a run from normal distributions around 0, by default of
    //# standard deviation 0.002 and 0.005.
    #[test]
    fn robots_differ_by_what_is_stated() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let drawn: Vec<_> = (0..SAMPLE).map(|_| Wheels::draw(&Imperfections::default(), &mut rng)).collect();
        assert_deviates(&drawn.iter().map(|wheels| wheels.wheel_difference / 0.002).collect::<Vec<_>>());
        assert_deviates(&drawn.iter().map(|wheels| wheels.axle_excess / 0.005).collect::<Vec<_>>());
        let both = drawn.iter().map(|wheels| wheels.wheel_difference / 0.002 * wheels.axle_excess / 0.005).sum::<f64>();
        assert!((both / f64::from(SAMPLE)).abs() < 4.0 / f64::from(SAMPLE).sqrt());
        assert!(drawn.iter().all(|wheels| (wheels.slip - 1e-3).abs() < 1e-12));
    }

    /// Half a metre straight on and a quarter of a metre back are 0.75 m of slip: at once or in small parts, a variance of
    /// 0.75e-6 m² per wheel, half of that along (both wheels' mean), twice by the axle across.
    //= reference/SPEC.md#world
    //= type=test
    //# - **WORLD-3** A wheel that rolls `l` MUST slip by a normal deviate of variance `q |l|`, by default `q = 1e-6 m`,
    //# independent of everything else.
    #[test]
    fn slip_is_a_millimetre_per_root_metre_and_wheel() {
        let wheels = Wheels { wheel_difference: 0.0, axle_excess: 0.0, slip: 1e-3 };
        let drive = Drive::epuck();
        for parts in [1_u32, 50] {
            let mut rng = ChaCha8Rng::seed_from_u64(2);
            let (mut along, mut across) = (Vec::new(), Vec::new());
            for _ in 0..SAMPLE {
                let mut pose = Pose::new(0.0, 0.0, 0.0);
                let mut rolled = 0.0;
                for way in [0.5, -0.25] {
                    let ways = Ways { left: way / f64::from(parts), right: way / f64::from(parts) };
                    for _ in 0..parts {
                        let next = wheels.roll(&pose, &ways, &drive, &mut rng);
                        let step = pose.inverse() * next;
                        // The chord is shorter than the way by a share of the turn's square over 24: below 1e-4.
                        rolled += step.x().signum() * step.x().hypot(step.y());
                        pose = next;
                    }
                }
                along.push((rolled - 0.25) / (0.75e-6_f64 / 2.0).sqrt());
                across.push(pose.theta() * 0.053 / (0.75e-6_f64 * 2.0).sqrt());
            }
            assert_deviates(&along);
            assert_deviates(&across);
        }
    }

    /// A right wheel that is larger turns the robot left, a longer axle turns it less.
    //= reference/SPEC.md#world
    //= type=test
    //# - **WORLD-1** The robot MUST move as MOTION-2 and MOTION-3 say, with the `e` and `g` of its own wheels and with
    //# what these rolled in a tick, slip included.
    #[test]
    fn signs_are_those_of_the_state() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut turn = |e: f64, g: f64, left: f64, right: f64| {
            let wheels = Wheels { wheel_difference: e, axle_excess: g, slip: 0.0 };
            wheels.roll(&Pose::new(0.0, 0.0, 0.0), &Ways { left, right }, &Drive::epuck(), &mut rng).theta()
        };
        // 0.01 m by 1 % over 53 mm.
        assert!((turn(0.01, 0.0, 0.01, 0.01) - 0.0001 / 0.053).abs() < 1e-12);
        assert!((turn(0.0, 0.01, -0.01, 0.01) - 0.02 / 0.053 / 1.01).abs() < 1e-12);
    }

    //= reference/SPEC.md#world
    //= type=test
    //# - **WORLD-4** Every 100 ms a reading MUST say how many whole steps (MOTION-1) each wheel has made since the one
    //# before: the difference of what was rolled without slip, rounded down.
    #[test]
    fn steps_are_whole_and_none_is_lost() {
        let mut counter = StepCounter::default();
        let mut read = |left: f64, right: f64| {
            counter.roll(&Ways { left, right });
            counter.read(1.0)
        };
        assert_eq!(read(0.6, -0.1), [0, -1]);
        assert_eq!(read(0.6, -0.1), [1, 0]);
        assert_eq!(read(2.9, -0.9), [3, -1]);
        assert_eq!(read(-4.2, 1.2), [-5, 2]);
    }
}

//! Who drives the robot (WORLD-5 to WORLD-8).

use super::TICK_SECONDS;
use crate::frame::{Point, Pose, Robot, World, wrap};
use core::f64::consts::FRAC_PI_2;
use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};

/// How far from its new heading a turn on the spot ends, radians (WORLD-6).
const TURNED: f64 = 0.01;

/// Slowest turn on the spot, rad/s (WORLD-6).
const SLOWEST_TURN: f64 = 0.05;

/// Turn rate per radian that is missing on the spot, 1/s (WORLD-6).
const TURN_GAIN: f64 = 6.0;

/// Correction of the heading, 1/s (WORLD-7).
const HEADING_GAIN: f64 = 1.0;

/// Heading that corrects an offset, rad/m (WORLD-7).
const OFFSET_GAIN: f64 = 4.0;

/// Fastest correction, rad/s (WORLD-7).
const FASTEST_CORRECTION: f64 = 0.3;

/// Time over which the wander forgets itself, seconds (WORLD-8).
const WANDER_SECONDS: f64 = 2.0;

/// Standard deviations to which random deviates are limited where they lead a robot between walls (WORLD-8, WORLD-21).
const LIMIT: f64 = 3.0;

/// A way to drive, lap after lap.
#[derive(Clone, Debug, PartialEq)]
pub struct Ride {
    /// Way-points of the axle's middle, at least two; from the last it goes on to the first. Neighbours differ.
    pub points: Vec<Point<World>>,
    /// Times around.
    pub laps: u32,
    /// Speed on a leg, m/s.
    pub speed: f64,
    /// Turn rate on the spot, rad/s.
    pub turn: f64,
    /// Standard deviation of the turn rate by which the pilot wanders, rad/s (WORLD-8).
    pub wander: f64,
}

impl Ride {
    /// A leg by its number within the lap.
    fn leg(&self, number: usize) -> Leg {
        let count = self.points.len();
        Leg { from: self.points[number % count], to: self.points[(number + 1) % count] }
    }

    /// Legs of all laps.
    fn legs(&self) -> usize {
        self.points.len() * self.laps as usize
    }

    /// Where the robot stands at first: on the first way-point, looking at the second.
    #[must_use]
    pub fn begin(&self) -> Pose<World, Robot> {
        self.leg(0).pose(0.0, 0.0, 0.0)
    }
}

/// From a way-point to the next.
#[derive(Clone, Copy, Debug)]
struct Leg {
    from: Point<World>,
    to: Point<World>,
}

impl Leg {
    fn length(&self) -> f64 {
        (self.to.x - self.from.x).hypot(self.to.y - self.from.y)
    }

    fn heading(&self) -> f64 {
        (self.to.y - self.from.y).atan2(self.to.x - self.from.x)
    }

    /// How far along the leg and how far to its left the robot is, metres.
    fn place(&self, robot: &Pose<World, Robot>) -> [f64; 2] {
        let (sin, cos) = self.heading().sin_cos();
        let (x, y) = (robot.x() - self.from.x, robot.y() - self.from.y);
        [x * cos + y * sin, y * cos - x * sin]
    }

    /// The pose that is so far along the leg and to its left, in metres, and turned from it by so many radians.
    fn pose(&self, along: f64, left: f64, turned: f64) -> Pose<World, Robot> {
        let heading = self.heading();
        let (sin, cos) = heading.sin_cos();
        Pose::new(
            self.from.x + along * cos - left * sin,
            self.from.y + along * sin + left * cos,
            wrap(heading + turned),
        )
    }
}

/// What the pilot asks of the robot.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Command {
    /// m/s ahead.
    pub speed: f64,
    /// rad/s to the left.
    pub turn: f64,
}

/// Somebody with a joystick who sees where the robot is.
#[derive(Clone, Debug)]
pub struct Pilot<'a> {
    ride: &'a Ride,
    /// Legs that are behind it.
    done: usize,
    /// The leg on which it is, by its number within the lap.
    leg: usize,
    /// On the spot at the leg's end: 1 to the left, -1 to the right.
    turning: Option<f64>,
    /// rad/s.
    wander: f64,
}

impl<'a> Pilot<'a> {
    /// A pilot at the beginning of a ride.
    #[must_use]
    pub fn new(ride: &'a Ride) -> Self {
        Self { ride, done: 0, leg: 0, turning: None, wander: 0.0 }
    }

    /// What to do for a tick, or nothing at the ride's end (WORLD-5). On a leg it takes one normal deviate.
    //= reference/SPEC.md#world
    //# - **WORLD-5** The pilot MUST command a speed and a turn rate for each tick, from the robot's true pose at its
    //# beginning, until all laps are driven; the run ends with the next reading.
    pub fn steer<R: Rng + ?Sized>(&mut self, robot: &Pose<World, Robot>, rng: &mut R) -> Option<Command> {
        if self.done == self.ride.legs() {
            return None;
        }
        if self.turning.is_none() && self.ride.leg(self.leg).place(robot)[0] >= self.ride.leg(self.leg).length() {
            if self.done + 1 == self.ride.legs() {
                self.done += 1;
                return None;
            }
            self.turning = Some(self.missing(robot).signum());
        }
        match self.turning {
            Some(_) if self.missing(robot).abs() < TURNED => {
                self.begin_leg(self.leg + 1);
                Some(self.along_the_leg(robot, rng))
            }
            Some(side) => Some(self.on_the_spot(robot, side)),
            None => Some(self.along_the_leg(robot, rng)),
        }
    }

    /// The turn that is still to do at the leg's end, radians.
    fn missing(&self, robot: &Pose<World, Robot>) -> f64 {
        wrap(self.ride.leg(self.leg + 1).heading() - robot.theta())
    }

    fn begin_leg(&mut self, leg: usize) {
        self.done += 1;
        self.leg = leg % self.ride.points.len();
        self.turning = None;
    }

    /// WORLD-6. Far from its end a turn keeps its side, also where the way round is as long.
    //= reference/SPEC.md#world
    //# - **WORLD-6** At the end of a leg the robot MUST turn on the spot towards the next, at 6/s of what is missing
    //# but at least at 0.05 rad/s and at most at the ride's rate, until less than 0.01 rad is missing.
    fn on_the_spot(&self, robot: &Pose<World, Robot>, side: f64) -> Command {
        let missing = self.missing(robot);
        let side = if missing.abs() < FRAC_PI_2 { missing.signum() } else { side };
        let slowest = SLOWEST_TURN.min(self.ride.turn);
        Command { speed: 0.0, turn: side * (TURN_GAIN * missing.abs()).clamp(slowest, self.ride.turn) }
    }

    /// WORLD-7, WORLD-8.
    //= reference/SPEC.md#world
    //# - **WORLD-7** On a leg the robot MUST go at the ride's speed and turn by `-(η + 4 λ)/s` plus the wander, within
    //# 0.3 rad/s, with its heading `η` from the leg's and its offset `λ` to the leg's left, in metres.
    //= reference/SPEC.md#world
    //# - **WORLD-8** The wander MUST be a normal process of the ride's standard deviation, by default 0.02 rad/s, that
    //# forgets itself over 2 s and is limited to three standard deviations.
    fn along_the_leg<R: Rng + ?Sized>(&mut self, robot: &Pose<World, Robot>, rng: &mut R) -> Command {
        let leg = self.ride.leg(self.leg);
        let kept = (-TICK_SECONDS / WANDER_SECONDS).exp();
        let deviate: f64 = StandardNormal.sample(rng);
        let (sigma, limit) = (self.ride.wander, LIMIT * self.ride.wander);
        self.wander = (kept * self.wander + sigma * (1.0 - kept * kept).sqrt() * deviate).clamp(-limit, limit);
        let [_, left] = leg.place(robot);
        let correction = -HEADING_GAIN * (wrap(robot.theta() - leg.heading()) + OFFSET_GAIN * left);
        let turn = (correction + self.wander).clamp(-FASTEST_CORRECTION, FASTEST_CORRECTION);
        Command { speed: self.ride.speed, turn }
    }

    /// The share of the ride's way that is done, legs counted alike.
    #[must_use]
    pub fn share(&self, robot: &Pose<World, Robot>) -> f64 {
        let leg = self.ride.leg(self.leg);
        let part = (leg.place(robot)[0] / leg.length()).clamp(0.0, 1.0);
        ((self.done as f64 + part) / self.ride.legs() as f64).min(1.0)
    }

    /// Puts the robot down on another leg, from where the ride goes on; the legs that are left stay as many (WORLD-21).
    //= reference/SPEC.md#world
    //# - **WORLD-21** It MUST be put down on another leg, 10 % to 50 % along it, with normal errors of 20 mm across and
    //# 0.05 rad, limited to three standard deviations, and drive on from there for as many legs as it would have.
    pub(super) fn put_elsewhere<R: Rng + ?Sized>(&mut self, rng: &mut R) -> Pose<World, Robot> {
        let count = self.ride.points.len();
        self.leg = (self.leg + rng.random_range(1..count)) % count;
        self.turning = None;
        let mut limited = |sigma: f64| {
            let deviate: f64 = StandardNormal.sample(rng);
            sigma * deviate.clamp(-LIMIT, LIMIT)
        };
        let [left, turned] = [limited(0.02), limited(0.05)];
        let leg = self.ride.leg(self.leg);
        leg.pose(leg.length() * rng.random_range(0.1..0.5), left, turned)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::{Drive, Ways};
    use crate::world::Wheels;
    use core::f64::consts::PI;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    const PERFECT: Wheels = Wheels { wheel_difference: 0.0, axle_excess: 0.0, slip: 0.0 };

    fn ride(points: &[[f64; 2]], wander: f64) -> Ride {
        let points = points.iter().map(|&[x, y]| Point::new(x, y)).collect();
        Ride { points, laps: 2, speed: 0.05, turn: 1.0, wander }
    }

    /// The poses and commands of all ticks.
    fn driven(ride: &Ride, wheels: &Wheels, begin: Pose<World, Robot>) -> Vec<(Pose<World, Robot>, Command)> {
        let (mut pilot, mut rng) = (Pilot::new(ride), ChaCha8Rng::seed_from_u64(1));
        let mut pose = begin;
        let mut all = Vec::new();
        while let Some(command) = pilot.steer(&pose, &mut rng) {
            all.push((pose, command));
            let aside = command.turn * 0.053 / 2.0;
            let ways =
                Ways { left: (command.speed - aside) * TICK_SECONDS, right: (command.speed + aside) * TICK_SECONDS };
            pose = wheels.roll(&pose, &ways, &Drive::epuck(), &mut rng);
            assert!(all.len() < 1_000_000, "the ride does not end");
        }
        all.push((pose, Command::default()));
        all
    }

    /// Two laps of a square of 0.4 m: 64 s of legs, 7 quarter turns on the spot.
    //= reference/SPEC.md#world
    //= type=test
    //# - **WORLD-6** At the end of a leg the robot MUST turn on the spot towards the next, at 6/s of what is missing
    //# but at least at 0.05 rad/s and at most at the ride's rate, until less than 0.01 rad is missing.
    #[test]
    fn legs_are_driven_and_corners_turned_at_the_stated_rates() {
        let ride = ride(&[[0.0, 0.0], [0.4, 0.0], [0.4, 0.4], [0.0, 0.4]], 0.0);
        let all = driven(&ride, &PERFECT, ride.begin());
        let spot: Vec<_> = all.iter().filter(|(_, command)| command.speed == 0.0 && command.turn != 0.0).collect();
        assert!(spot.iter().all(|(_, command)| command.turn >= 0.05 && command.turn <= 1.0));
        // All but the last sixth of a radian at 1 rad/s, that and the tail until 0.01 rad by 6/s.
        let corner = PI / 2.0 - 1.0 / 6.0 + (1.0 / 6.0 / 0.01_f64).ln() / 6.0;
        let seconds = spot.len() as f64 * TICK_SECONDS;
        assert!((seconds - 7.0 * corner).abs() < 7.0 * 3.0 * TICK_SECONDS, "{seconds} for {}", 7.0 * corner);
        let moving = all.iter().filter(|(_, command)| (command.speed - 0.05).abs() < 1e-12).count();
        assert!((moving as f64 * TICK_SECONDS - 64.0).abs() < 0.1);
        let last = all.last().unwrap().0;
        assert!(last.x().abs() < 1e-3 && last.y().abs() < 1e-3, "two laps end where they began");
    }

    #[test]
    fn a_way_there_and_back_turns_right_round() {
        let ride = ride(&[[0.0, 0.0], [0.3, 0.0]], 0.02);
        let wheels = Wheels { slip: 1e-3, ..PERFECT };
        let all = driven(&ride, &wheels, ride.begin());
        assert!(all.last().unwrap().0.x().abs() < 0.01);
        let turns = all.windows(2).filter(|pair| pair[0].1.speed > 0.0 && pair[1].1.speed == 0.0).count();
        assert_eq!(turns, 3 + 1, "three corners and the end");
    }

    /// `θ' = -θ - 4 y + w` and `y' = v θ` are overdamped, so that a wander of at most 0.06 rad/s leads at most to
    /// its steady state `y = w/4`, 15 mm.
    //= reference/SPEC.md#world
    //= type=test
    //# - **WORLD-7** On a leg the robot MUST go at the ride's speed and turn by `-(η + 4 λ)/s` plus the wander, within
    //# 0.3 rad/s, with its heading `η` from the leg's and its offset `λ` to the leg's left, in metres.
    //= reference/SPEC.md#world
    //= type=test
    //# - **WORLD-8** The wander MUST be a normal process of the ride's standard deviation, by default 0.02 rad/s, that
    //# forgets itself over 2 s and is limited to three standard deviations.
    #[test]
    fn wander_is_bounded_and_corrected() {
        let ride = Ride { laps: 1, ..ride(&[[0.0, 0.0], [60.0, 0.0]], 0.02) };
        let all = driven(&ride, &PERFECT, ride.begin());
        let left: Vec<f64> =
            all.iter().filter(|(pose, _)| pose.theta().abs() < 1.0).map(|(pose, _)| pose.y()).collect();
        assert!(left.iter().all(|y| y.abs() < 0.015), "off the leg");
        let spread = (left.iter().map(|y| y * y).sum::<f64>() / left.len() as f64).sqrt();
        // `y'' + y' + 0.2 y = 0.05 w` under noise of 0.02 rad/s that forgets itself at a = 1/2 a second: the spread is
        // 0.02 * 0.05 * sqrt((a + 1)/(0.2 (a^2 + a + 0.2))), 2.8 mm; 1200 s have about 240 independent samples.
        assert!((spread - 0.0028).abs() < 0.0006, "{spread}");
        // From 10 cm beside the leg it comes back, and does not turn faster than allowed.
        let beside = driven(&ride, &PERFECT, Pose::new(0.0, 0.1, 0.0));
        assert!(
            beside
                .iter()
                .filter(|(pose, _)| pose.x() > 1.5 && pose.theta().abs() < 1.0)
                .all(|(pose, _)| pose.y() < 0.02)
        );
        assert!(beside.iter().all(|(_, command)| command.speed == 0.0 || command.turn.abs() <= 0.3));
    }

    #[test]
    fn the_share_of_a_ride_grows_from_leg_to_leg() {
        let ride = ride(&[[0.0, 0.0], [0.4, 0.0], [0.4, 0.2]], 0.0);
        let mut pilot = Pilot::new(&ride);
        assert!((pilot.share(&Pose::new(0.1, 0.0, 0.0)) - 0.25 / 6.0).abs() < 1e-12);
        pilot.begin_leg(1);
        assert!((pilot.share(&Pose::new(0.4, 0.1, 0.0)) - 1.5 / 6.0).abs() < 1e-12);
    }

    //= reference/SPEC.md#world
    //= type=test
    //# - **WORLD-21** It MUST be put down on another leg, 10 % to 50 % along it, with normal errors of 20 mm across and
    //# 0.05 rad, limited to three standard deviations, and drive on from there for as many legs as it would have.
    #[test]
    fn put_elsewhere_is_near_another_leg() {
        let ride = ride(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], 0.0);
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let mut legs = [0; 4];
        for _ in 0..200 {
            let mut pilot = Pilot::new(&ride);
            let pose = pilot.put_elsewhere(&mut rng);
            let leg = ride.leg(pilot.leg);
            let [along, left] = leg.place(&pose);
            assert!((0.1..0.5).contains(&along) && left.abs() <= 0.06 + 1e-12);
            assert!(wrap(pose.theta() - leg.heading()).abs() <= 0.15 + 1e-12);
            legs[pilot.leg] += 1;
        }
        assert!(legs[0] == 0 && legs[1..].iter().all(|&count| count > 40), "{legs:?}");
    }
}

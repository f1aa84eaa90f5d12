//! What the robots of a ride are given: the reference's setup by what a robot knows.

use crate::log::knowledge::{Knowledge, Landmarks, Observe, Stamp, States};
use reference::crossing::CrossingRule;
use reference::filter::Estimate;
use reference::landmark::Landmark;
use reference::localizer::Setup;
use reference::motion::{Drive, MotionModel, State, StateCovariance};
use reference::places::{Entry, Places};

/// Standard deviations of the wheels' difference and of the axle's excess that are estimated (ROUTE-10).
//= reference/SPEC.md#route
//# - **ROUTE-10** The wheels' difference and the axle's excess MUST be estimated from standard deviations of 0.2 % and
//# 0.5 %, or be known to be 0 with three states *(choice: how unequal an e-puck's wheels are)*.
pub(super) const WHEELS: [f64; 2] = [0.002, 0.005];

/// Variances of a wheel's way by its length with five states and with three, metres (MOTION-6).
pub(super) const SLIPS: [f64; 2] = [1e-6, 3e-6];

/// The wheels of a robot, by the paper's linear model for the paper's estimator.
#[must_use]
pub(super) fn drive(knowledge: &Knowledge) -> Drive {
    let slip = match knowledge.states {
        States::Five => SLIPS[0],
        States::Three => SLIPS[1],
    };
    let model = if knowledge.observe == Observe::Paper { MotionModel::Linear } else { MotionModel::Arc };
    knowledge.wheels.drive(slip, model)
}

/// A robot and its site.
#[must_use]
pub(super) fn setup(knowledge: &Knowledge) -> Setup {
    let places = match &knowledge.landmarks {
        Landmarks::Grid(grid) => Places::Grid(*grid),
        Landmarks::Table(listed) => Places::Table(
            listed
                .iter()
                .map(|one| Entry {
                    format: one.format,
                    payload: one.identifier,
                    landmark_in_world: one.landmark_in_world(),
                })
                .collect(),
        ),
    };
    let observe = match knowledge.observe {
        Observe::Image => reference::localizer::Observe::Image,
        Observe::Pose => reference::localizer::Observe::Pose,
        Observe::Paper => reference::localizer::Observe::Paper,
    };
    let stamp = match knowledge.stamp {
        Stamp::Exposure => reference::exposure::Stamp::MidExposure,
        Stamp::Processing => reference::exposure::Stamp::Processing,
    };
    Setup {
        camera: knowledge.camera,
        camera_in_robot: knowledge.mounting.camera_in_robot(),
        drive: drive(knowledge),
        landmarks: knowledge.formats.iter().map(|&format| Landmark::new(format)).collect(),
        places,
        rule: CrossingRule::Interpolated,
        stamp,
        observe,
    }
}

/// Where a robot begins.
#[must_use]
pub(super) fn start(knowledge: &Knowledge) -> Estimate {
    let [x, y, theta] = knowledge.start.deviations;
    let [e, g] = if knowledge.states == States::Five { WHEELS } else { [0.0; 2] };
    let variances = [x, y, theta, e, g].map(|deviation| deviation * deviation);
    let state = State { pose: knowledge.start.robot_in_world(), wheel_difference: 0.0, axle_excess: 0.0 };
    Estimate { state, covariance: StateCovariance::from_diagonal(&variances.into()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: the variances of `e` and `g` with five states, none of them with three, and the slips of either.
    //= reference/SPEC.md#motion
    //= type=test
    //# - **MOTION-6** The slip MUST by default be `q = 1e-6 m` with five states, 1 mm per root metre, and `3e-6 m` with
    //# three, of which `e` and `g` are known to be 0 *(choice: what is not estimated is slip)*.
    //= reference/SPEC.md#route
    //= type=test
    //# - **ROUTE-10** The wheels' difference and the axle's excess MUST be estimated from standard deviations of 0.2 %
    //# and 0.5 %, or be known to be 0 with three states *(choice: how unequal an e-puck's wheels are)*.
    #[test]
    fn what_is_not_estimated_is_slip() {
        let knowing = |states| Knowledge { states, ..Knowledge::default() };
        let wheels = |states| {
            let covariance = start(&knowing(states)).covariance;
            [covariance[(3, 3)].sqrt(), covariance[(4, 4)].sqrt()]
        };
        let near = |found: [f64; 2], expected: [f64; 2]| (0..2).all(|i| (found[i] - expected[i]).abs() < 1e-15);
        assert!(near(wheels(States::Five), [0.002, 0.005]) && near(wheels(States::Three), [0.0; 2]));
        let slips = [States::Five, States::Three].map(|states| drive(&knowing(states)).slip);
        assert!(near(slips, [1e-6, 3e-6]));
        // The port's, which has 32 fraction bits.
        let port =
            [fixedpoint::motion::SLIP_OF_FIVE, fixedpoint::motion::SLIP_OF_THREE].map(|slip| slip.to_num::<f64>());
        assert!((0..2).all(|i| (port[i] - slips[i]).abs() <= 2_f64.powi(-33)), "{port:?}");
    }
}

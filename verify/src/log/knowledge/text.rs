//! What a robot knows as the text of `robot.toml` (LOG-19).

use super::{Knowledge, Landmarks, Observe, Stamp, States};
use crate::certificate::format_name;
use core::fmt::Write;
use reference::grid::Grid;

impl Knowledge {
    /// A text that is read as the same. A length or an angle that no number of millimetres or degrees comes to exactly,
    /// which no file has given then, is read as its neighbour.
    //= reference/SPEC.md#log
    //# - **LOG-19** What is read from a written log MUST be the numbers that were written.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let mut text = String::new();
        // A String takes everything.
        let _ = self.write(&mut text);
        text
    }

    fn write(&self, text: &mut String) -> core::fmt::Result {
        let states = if self.states == States::Three { 3 } else { 5 };
        let observe = match self.observe {
            Observe::Image => "image",
            Observe::Pose => "pose",
            Observe::Paper => "paper",
        };
        let stamp = if self.stamp == Stamp::Exposure { "exposure" } else { "processing" };
        let formats: Vec<&str> = self.formats.iter().map(|&format| format_name(format)).collect();
        writeln!(text, "states = {states}\nobserve = {observe:?}\nstamp = {stamp:?}\nformats = {formats:?}")?;
        self.write_landmarks(text)?;
        self.write_robot(text)
    }

    fn write_landmarks(&self, text: &mut String) -> core::fmt::Result {
        match &self.landmarks {
            Landmarks::Grid(Grid { origin, step, theta_steps }) => {
                let step = step.map(millimetres);
                writeln!(text, "\n[grid]\nstep_mm = {step:?}\norigin_m = {origin:?}")?;
                if let Some(steps) = theta_steps {
                    writeln!(text, "theta_steps = {steps}")?;
                }
            }
            Landmarks::Table(listed) => {
                for landmark in listed {
                    let (format, identifier) = (format_name(landmark.format), landmark.identifier);
                    writeln!(text, "\n[[landmark]]\nformat = {format:?}\nidentifier = {identifier}")?;
                    writeln!(text, "x_m = {:?}\ny_m = {:?}", landmark.x, landmark.y)?;
                    writeln!(text, "heading_deg = {:?}", degrees(landmark.heading))?;
                }
            }
        }
        Ok(())
    }

    fn write_robot(&self, text: &mut String) -> core::fmt::Result {
        let camera = &self.camera;
        writeln!(text, "\n[camera]\nwidth_px = {}\nheight_px = {}", camera.width, camera.height)?;
        writeln!(text, "focal_length_px = {:?}", camera.focal_length)?;
        writeln!(text, "focal_length_vertical_px = {:?}", camera.focal_length_vertical)?;
        writeln!(text, "principal_column_px = {:?}", camera.principal_column)?;
        writeln!(text, "upper_row = {}\nlower_row = {}", camera.upper_row, camera.lower_row)?;
        let (mounting, wheels) = (&self.mounting, &self.wheels);
        writeln!(text, "\n[robot]\ncamera_x_mm = {:?}", millimetres(mounting.x))?;
        writeln!(text, "camera_y_mm = {:?}", millimetres(mounting.y))?;
        writeln!(text, "camera_heading_deg = {:?}", degrees(mounting.heading))?;
        writeln!(text, "wheel_diameter_mm = {:?}", millimetres(wheels.diameter))?;
        writeln!(text, "axle_mm = {:?}", millimetres(wheels.axle))?;
        writeln!(text, "steps_per_turn = {:?}", wheels.steps_per_turn)?;
        let start = &self.start;
        writeln!(text, "\n[start]\nx_m = {:?}\ny_m = {:?}\ntheta_rad = {:?}", start.x, start.y, start.theta)?;
        let [x, y, theta] = start.deviations;
        writeln!(text, "deviation_x_m = {x:?}\ndeviation_y_m = {y:?}\ndeviation_theta_rad = {theta:?}")
    }
}

/// The millimetres that are read as so many metres.
fn millimetres(metres: f64) -> f64 {
    preimage(metres, metres * 1000.0, |millimetres| millimetres / 1000.0)
}

/// The degrees that are read as so many radians.
fn degrees(radians: f64) -> f64 {
    preimage(radians, radians.to_degrees(), f64::to_radians)
}

/// The number with the fewest digits, near a first guess, that is read as the value.
fn preimage(value: f64, guess: f64, read: impl Fn(f64) -> f64) -> f64 {
    #[expect(clippy::float_cmp, reason = "the same number, or it would be another log")]
    let same = |candidate: &f64| read(*candidate) == value;
    let rounded = (0..17).filter_map(|digits| format!("{guess:.digits$e}").parse().ok());
    let neighbours = [guess.next_down(), guess.next_up(), guess.next_down().next_down(), guess.next_up().next_up()];
    rounded.chain(neighbours).find(same).unwrap_or(guess)
}

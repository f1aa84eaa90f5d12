//! A log from numbers, so that most of its rows mean something.

use crate::draw::Draw;
use core::fmt::Write;

/// The most rows of one.
const MOST: usize = 64;

/// Texts of `odometry.csv`, of no images, and of `truth.csv`, parted by `between`.
///
/// A row is a byte that chooses the table and how its numbers are spelled, two bytes of milliseconds since the row before,
/// and two for each number.
pub(super) fn text(draw: &mut Draw<'_>, between: char) -> String {
    let mut odometry = "t_s,left_steps,right_steps\n".to_owned();
    let frames = "t_start_s,t_end_s,t_processed_s,file\n";
    let mut truth = "t_s,x_m,y_m,theta_rad\n".to_owned();
    let mut millis = [0_i64; 2];
    for _ in 0..MOST {
        if draw.is_empty() {
            break;
        }
        let how = draw.byte();
        let of_truth = usize::from(how & 1);
        let step = i64::from(draw.word());
        // Now and then a step back.
        millis[of_truth] += if how & 2 == 0 { step } else { -step };
        let time = format!("{}", millis[of_truth] as f64 / 1000.0);
        let numbers = [draw.word().cast_signed(), draw.word().cast_signed()];
        let [one, other] = numbers.map(|number| spelled(number, how));
        // A String takes everything.
        let _ = match of_truth {
            0 => writeln!(odometry, "{time},{one},{other}"),
            _ => writeln!(truth, "{time},{},{other},{one}", f64::from(numbers[0]) / 400.0),
        };
    }
    format!("{odometry}{between}{frames}{between}{truth}")
}

/// A number as it may be written; of one in four spellings a part is missing.
fn spelled(number: i16, how: u8) -> String {
    match how >> 2 & 7 {
        0 => format!("{number}"),
        1 => format!("\"{number}\""),
        2 => format!(" {number}\t"),
        3 => format!("{number}.0"),
        4 => format!("{number}e0"),
        5 => format!("{:+}", f64::from(number) / 8.0),
        6 => format!("\"{number}"),
        _ => format!("{number}-"),
    }
}

//! Extents, against their definition.

use fixedpoint::extents::Shade;
use fixedpoint::landmark::Format;
use fixedpoint::threshold::Threshold;

/// Pixels of a symbolic line.
const LENGTH: usize = 26;

/// Whether pixels of a line, dark or not, are an extent by EXTENT-2 and EXTENT-3 as they stand, of so many stripes.
fn defined(dark: &[bool; LENGTH], stripes: u32, first: u8, last: u8) -> bool {
    let pixels = (u32::from(last) + 1).saturating_sub(u32::from(first));
    let is = |pixel: i32, wanted: bool| {
        let mut found = false;
        for (i, &dark) in (0..).zip(dark) {
            found |= i == pixel && dark == wanted;
        }
        found
    };
    let (first, last) = (i32::from(first), i32::from(last));
    let mut defined = pixels >= stripes && 4 * pixels <= 9 * stripes && is(first, true) && is(last, true);
    for distance in 1..=4_u8 {
        // One pixel less would not be q, and q is at most 4, since 2 e is.
        let asked_for = stripes * u32::from(distance) < 2 * pixels;
        let beside = [first - i32::from(distance), last + i32::from(distance)];
        defined &= !asked_for || beside.iter().all(|&pixel| is(pixel, false));
    }
    defined
}

/// What is an extent is as EXTENT-2 and EXTENT-3 say.
///
/// - Domain: all lines of 26 dark and other pixels, any two of the first 32 pixels, format `paper`.
/// - Fault: `extents.rs`: `stripes * (u32::from(q) + 1) >= 2 * pixels` → `stripes * (u32::from(q) + 1) > 2 * pixels`:
///   a pixel more of quiet zone.
#[kani::proof]
#[kani::unwind(28)]
fn extents_are_as_defined() {
    let dark: [bool; LENGTH] = kani::any();
    let (first, last): (u8, u8) = (kani::any(), kani::any());
    kani::assume(first < 32 && last < 32);
    let line = dark.map(|dark| if dark { 0 } else { 255 });
    let shade = Shade::new(&line, &Threshold { darkest: 0, brightest: 255 });
    let found = shade.is_extent(Format::Paper, (u16::from(first), u16::from(last)));
    kani::cover!(found && last - first == 21);
    assert_eq!(found, defined(&dark, 20, first, last));
}

/// A pixel is dark as EXTENT-1 says.
///
/// - Domain: all thresholds, all pixels.
/// - Fault: `extents.rs`: `4 * u16::from(value) < self.limit` → `4 * u16::from(value) <= self.limit`: what is on the
///   limit is dark.
#[kani::proof]
#[kani::unwind(3)]
fn dark_is_as_defined() {
    let (darkest, brightest, pixel): (u8, u8, u8) = (kani::any(), kani::any(), kani::any());
    kani::assume(darkest <= brightest);
    let line = [pixel];
    let shade = Shade::new(&line, &Threshold { darkest, brightest });
    let [darkest, brightest, pixel] = [darkest, brightest, pixel].map(i32::from);
    kani::cover!(4 * (brightest - pixel) == brightest - darkest && darkest > 0);
    // More than a quarter of the range below the brightest.
    assert_eq!(shade.is_dark(0), Some(4 * (brightest - pixel) > brightest - darkest));
    assert_eq!(shade.is_dark(1), None);
}

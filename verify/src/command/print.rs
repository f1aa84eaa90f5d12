//! `barloc print`

use super::{Exit, Failure, LandmarkFormat};
use crate::certificate::{format_name, payload_hex};
use crate::print::files::write_whole;
use crate::print::layout::{self, Piece};
use crate::print::page::{Page, short};
use crate::print::sheet::{self, ID_COLUMN, POSE_COLUMNS, Wish};
use crate::print::{nearest, pdf, svg};
use crate::site;
use clap::{ArgGroup, Args};
use reference::codeword;
use reference::frame::{self, Pose, World};
use reference::grid::{Grid, GridRefusal};
use reference::landmark::{Format, Landmark};
use std::io::Write;
use std::path::{Path, PathBuf};

#[derive(Args)]
#[command(
    group = ArgGroup::new("what").required(true).args(["pose", "id", "sheet"]),
    after_help = "Examples:
  barloc print --pose 0.15,0.25,90 -o landmark.pdf
  barloc print --id 0x305e2a --landmark wide -o landmark.svg
  barloc print --sheet poses.csv --site site.toml -o landmarks.pdf

A sheet is CSV. Its first line names the columns, x_m,y_m,theta_deg or id:
  x_m,y_m,theta_deg
  0.15,0.25,90
  0.20,0.25,90

Pages are A4 in true size: print at 100 %, cut along the marks, mount the barcode's centre at the camera's height.
Several pages are one PDF file, or one SVG file each: FILE-1.svg, FILE-2.svg and so on."
)]
pub(super) struct Arguments {
    /// Pose of the landmark: metres, metres, degrees; on the site's grid
    #[arg(long, value_name = "X,Y,DEG", allow_hyphen_values = true, value_parser = sheet::parse_pose)]
    pose: Option<[f64; 3]>,
    /// Payload that stands for itself, decimal or hexadecimal after 0x
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = sheet::parse_id)]
    id: Option<u64>,
    /// Many landmarks, by pose or by identifier (CSV)
    #[arg(long, value_name = "FILE")]
    sheet: Option<PathBuf>,
    /// Landmark format
    #[arg(long, value_enum, value_name = "FORMAT", default_value_t = LandmarkFormat::Paper)]
    landmark: LandmarkFormat,
    /// Site whose grid the poses are on (TOML); steps of 50 mm from 0 and 16 headings if left out
    #[arg(long, value_name = "FILE", conflicts_with = "id")]
    site: Option<PathBuf>,
    /// Width of a stripe, 0.5 to 20 mm
    #[arg(long, value_name = "MM", default_value_t = 1.5, allow_hyphen_values = true)]
    stripe_mm: f64,
    /// Height of one layer
    #[arg(long, value_name = "MM", default_value_t = 25.0, allow_hyphen_values = true)]
    height_mm: f64,
    /// Where to write, a name that ends in .svg or .pdf
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

pub(super) fn run(arguments: &Arguments, out: &mut impl Write) -> Result<Exit, Failure> {
    let medium = Medium::of(&arguments.output)?;
    let landmark = Landmark {
        format: arguments.landmark.into(),
        stripe_width: arguments.stripe_mm / 1e3,
        stripe_height: arguments.height_mm / 1e3,
    };
    let pieces = pieces(arguments, landmark.format)?;
    let pages = layout::pages(&landmark, &pieces).map_err(|refusal| Failure::Input(refusal.to_string()))?;
    let files = medium.files(&arguments.output, &pages)?;
    write_whole(&files).map_err(|unwritten| Failure::Input(unwritten.to_string()))?;
    let [pieces, sheets] = [counted(pieces.len(), "landmark"), counted(pages.len(), "page")];
    match &files[..] {
        [(only, _)] => writeln!(out, "{}: {pieces} on {sheets}", only.display())?,
        [(first, _), .., (last, _)] => {
            writeln!(out, "{} to {}: {pieces} on {sheets}", first.display(), last.display())?;
        }
        [] => {}
    }
    Ok(Exit::Success)
}

fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// What the pages are written as.
#[derive(Clone, Copy)]
enum Medium {
    Svg,
    Pdf,
}

impl Medium {
    fn of(output: &Path) -> Result<Self, Failure> {
        let extension = output.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase());
        match extension.as_deref() {
            Some("svg") => Ok(Self::Svg),
            Some("pdf") => Ok(Self::Pdf),
            _ => Err(Failure::Input(format!("{}: the name must end in .svg or .pdf", output.display()))),
        }
    }

    fn files(self, output: &Path, pages: &[Page]) -> Result<Vec<(PathBuf, Vec<u8>)>, Failure> {
        match self {
            Self::Pdf if pages.len() > pdf::MOST_PAGES => {
                Err(Failure::Input(format!("{} pages are more than a PDF file can have", pages.len())))
            }
            Self::Pdf => Ok(vec![(output.to_owned(), pdf::write(pages))]),
            Self::Svg => {
                let name = |number: usize| if pages.len() == 1 { output.to_owned() } else { numbered(output, number) };
                Ok(pages.iter().zip(1..).map(|(page, number)| (name(number), svg::write(page).into_bytes())).collect())
            }
        }
    }
}

/// FILE-1.svg for FILE.svg and 1.
fn numbered(output: &Path, number: usize) -> PathBuf {
    let mut name = output.file_stem().unwrap_or_default().to_owned();
    name.push(format!("-{number}."));
    name.push(output.extension().unwrap_or_default());
    output.with_file_name(name)
}

/// What is to be printed, with its captions (PRINT-11).
fn pieces(arguments: &Arguments, format: Format) -> Result<Vec<Piece>, Failure> {
    let grid = match &arguments.site {
        Some(path) => site::load(path).map_err(|error| Failure::Input(error.to_string()))?.grid,
        None => Grid::default(),
    };
    let one = |wish: Wish, option: &str| {
        let piece =
            piece(&grid, format, &wish).map_err(|refusal| Failure::Input(format!("{option}: {}", refusal.what)));
        piece.map(|piece| vec![piece])
    };
    match (arguments.pose, arguments.id, &arguments.sheet) {
        (Some(pose), ..) => one(Wish::Pose(pose), "--pose"),
        (_, Some(id), _) => one(Wish::Id(id), "--id"),
        (_, _, Some(path)) => listed(path, &grid, format, arguments.site.is_some()),
        (None, None, None) => Err(Failure::Input("one of --pose, --id and --sheet is needed".to_owned())),
    }
}

/// The landmarks of a list.
fn listed(path: &Path, grid: &Grid, format: Format, on_site: bool) -> Result<Vec<Piece>, Failure> {
    let named = |what: String| Failure::Input(format!("{}: {what}", path.display()));
    let entries = sheet::load(path).map_err(|error| named(error.to_string()))?;
    if on_site && entries.iter().any(|entry| matches!(entry.wish, Wish::Id(_))) {
        return Err(named("line 1, column id: identifiers are on no site's grid; leave out --site".to_owned()));
    }
    let piece = |entry: &sheet::Entry| {
        piece(grid, format, &entry.wish)
            .map_err(|refusal| named(format!("line {}, {}: {}", entry.line, refusal.columns, refusal.what)))
    };
    entries.iter().map(piece).collect()
}

/// Why something cannot be printed, and in which columns of a list the reason lies.
struct Refusal {
    columns: String,
    what: String,
}

fn piece(grid: &Grid, format: Format, wish: &Wish) -> Result<Piece, Refusal> {
    match *wish {
        Wish::Pose(pose) => piece_of_pose(grid, format, pose),
        Wish::Id(id) => piece_of_id(format, id),
    }
}

//= reference/SPEC.md#print
//# - **PRINT-11** A caption MUST give the pose that the payload stands for, or the identifier, and the payload in
//# hexadecimal digits.
fn piece_of_pose(grid: &Grid, format: Format, [x, y, degrees]: [f64; 3]) -> Result<Piece, Refusal> {
    let wanted = Pose::new(x, y, degrees.to_radians());
    let refused = |refusal: GridRefusal| {
        let nearest: Vec<String> = nearest::poses(grid, format, &wanted).iter().map(pose_argument).collect();
        Refusal {
            columns: columns_at_fault(grid, format, &wanted),
            what: format!("{refusal}; the nearest that can be printed: {}", nearest.join("; ")),
        }
    };
    let payload = grid.payload(format, &wanted).map_err(refused)?;
    // What robots will take it for, not what was typed.
    let meant = grid.landmark_in_world(format, payload).map_err(refused)?;
    let caption = vec![
        format!("x {} m, y {} m", short(meant.x(), 6), short(meant.y(), 6)),
        format!("heading {}°", short(degrees_of(&meant), 4)),
        payload_line(format, payload),
    ];
    Ok(Piece { payload, caption })
}

fn piece_of_id(format: Format, id: u64) -> Result<Piece, Refusal> {
    let refused = |what: &dyn core::fmt::Display| {
        let nearest: Vec<String> = nearest::ids(format, id).iter().map(u32::to_string).collect();
        let what = format!("{id}: {what}; the nearest that can be printed: {}", nearest.join(", "));
        Refusal { columns: format!("column {ID_COLUMN}"), what }
    };
    let payload = u32::try_from(id).map_err(|_| refused(&codeword::EncodeRefusal::TooLarge))?;
    codeword::encode(format, payload).map_err(|refusal| refused(&refusal))?;
    Ok(Piece { payload, caption: vec![format!("id {payload}"), payload_line(format, payload)] })
}

fn payload_line(format: Format, payload: u32) -> String {
    format!("payload 0x{}, {}", payload_hex(format, payload), format_name(format))
}

/// Those columns of a pose that the grid refuses whatever the others are; all of them if it refuses only the whole.
fn columns_at_fault(grid: &Grid, format: Format, pose: &Pose<World, frame::Landmark>) -> String {
    let [x, y] = grid.origin;
    let alone = [Pose::new(pose.x(), y, 0.0), Pose::new(x, pose.y(), 0.0), Pose::new(x, y, pose.theta())];
    let wrong = |(_, pose): &(&str, Pose<World, frame::Landmark>)| grid.codes(format, pose).is_err();
    let names: Vec<&str> = POSE_COLUMNS.into_iter().zip(alone).filter(wrong).map(|(name, _)| name).collect();
    match &names[..] {
        [] => format!("columns {}", POSE_COLUMNS.join(", ")),
        [one] => format!("column {one}"),
        several => format!("columns {}", several.join(", ")),
    }
}

/// A pose as `--pose` takes it. Nine decimals are within GRID-4 of any step that a wall can have.
fn pose_argument(pose: &Pose<World, frame::Landmark>) -> String {
    format!("{},{},{}", short(pose.x(), 9), short(pose.y(), 9), short(degrees_of(pose), 9))
}

/// The heading from 0 to 360°.
fn degrees_of(pose: &Pose<World, frame::Landmark>) -> f64 {
    // -1e-15 is 0, not 360.
    let degrees = pose.theta().to_degrees();
    if degrees < -1e-9 { degrees + 360.0 } else { degrees.max(0.0) }
}

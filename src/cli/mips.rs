//! `texunit mips`: a texture into the planes of a pyramid.

use std::{
    path::{Path, PathBuf},
    process::ExitCode,
};

use clap::ValueEnum;
use comfy_table::{CellAlignment, Table, presets::ASCII_MARKDOWN};
use serde::Serialize;
use texunit_hw::{AddressMode, PyramidKind};

use crate::{
    error::Result,
    output::{create_folder, write_whole},
    pyramid::{Build, From, Kernel, PlaneRounding, Pyramid, build::is_premultiplied, image_file, planes_of},
};

/// Make the planes of a pyramid and write each as PNG and as raw RGBA8
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The texture: PNG, JPEG, BMP, TGA, PNM or GIF
    image: PathBuf,
    /// Which planes
    #[arg(long, value_enum, default_value = "mipmap")]
    pyramid: Planes,
    /// Folder for plane_LU_LV.png, plane_LU_LV.rgba and planes.json
    #[arg(short, long, value_name = "DIR")]
    out: PathBuf,
    /// What is averaged
    #[arg(long, value_enum, default_value = "box")]
    kernel: Kernel,
    /// Kernel width in source texels at 2:1, even, 2 to 64 [default: tent 4, lanczos and kaiser 14]
    #[arg(long, value_name = "N")]
    width: Option<u8>,
    /// Every plane from the texture itself (the default)
    #[arg(long, conflicts_with = "from_above")]
    from_top: bool,
    /// Every plane from the next larger one
    #[arg(long)]
    from_above: bool,
    /// The one rounding of each texel
    #[arg(long, value_enum, default_value = "half-even")]
    rounding: PlaneRounding,
    /// What a kernel finds outside the texture
    #[arg(long, value_enum, default_value = "wrap")]
    edge: Edge,
}

/// Names of [`PyramidKind`].
#[derive(Clone, Copy, Debug, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
enum Planes {
    /// Both axes halved together
    Mipmap,
    /// One axis halved at a time
    Dipmap,
    /// The whole grid
    Ripmap,
}

/// Names of [`AddressMode`].
#[derive(Clone, Copy, Debug, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
enum Edge {
    /// The texture again
    Wrap,
    /// The edge texel
    Clamp,
    /// The texture mirrored
    Mirror,
    /// Transparent black
    Clip,
}

/// What `planes.json` says.
#[derive(Serialize)]
struct Listing {
    schema: u32,
    image: String,
    pyramid: Planes,
    width: u32,
    height: u32,
    texels: u64,
    memory_multiple: f64,
    build: BuildListing,
    planes: Vec<PlaneListing>,
}

/// How the planes were made.
#[derive(Serialize)]
struct BuildListing {
    kernel: Kernel,
    kernel_width: Option<u8>,
    from: From,
    rounding: PlaneRounding,
    edge: Edge,
    premultiplied: bool,
}

/// One plane; `raw` is RGBA8, row after row, no header.
#[derive(Serialize)]
struct PlaneListing {
    lu: u8,
    lv: u8,
    width: u32,
    height: u32,
    png: String,
    raw: String,
}

/// Runs the command.
///
/// # Errors
/// An unreadable image, a width the kernel cannot have, a folder that cannot be written.
pub fn run(args: Args) -> Result<ExitCode> {
    let build = args.build();
    let kernel_width = build.kernel.width(build.width)?;
    let top = image_file::load(&args.image)?;
    create_folder(&args.out)?;
    let kind = args.pyramid.kind();
    let list = planes_of(kind, top.width, top.height);
    let progress = indicatif::ProgressBar::new(list.len() as u64).with_message("planes");
    let planes = build.planes(&top, &list, |_| progress.inc(1))?;
    progress.finish_and_clear();
    let pyramid = Pyramid { kind, width: top.width, height: top.height, planes };

    let listing = Listing {
        schema: 1,
        image: args.image.display().to_string(),
        pyramid: args.pyramid,
        width: pyramid.width,
        height: pyramid.height,
        texels: pyramid.texels(),
        memory_multiple: pyramid.memory_multiple(),
        build: BuildListing {
            kernel: build.kernel,
            kernel_width,
            from: build.from,
            rounding: build.rounding,
            edge: args.edge,
            premultiplied: is_premultiplied(&top.texels),
        },
        planes: pyramid.planes.iter().map(PlaneListing::of).collect(),
    };
    write_planes(&args.out, &pyramid, &listing)?;
    print_table(&listing);
    Ok(ExitCode::SUCCESS)
}

impl Args {
    fn build(&self) -> Build {
        Build {
            kernel: self.kernel,
            width: self.width,
            from: if self.from_above { From::Above } else { From::Top },
            rounding: self.rounding,
            edge: self.edge.address_mode(),
        }
    }
}

impl Planes {
    const fn kind(self) -> PyramidKind {
        match self {
            Self::Mipmap => PyramidKind::Mipmap,
            Self::Dipmap => PyramidKind::Dipmap,
            Self::Ripmap => PyramidKind::Ripmap,
        }
    }
}

impl Edge {
    const fn address_mode(self) -> AddressMode {
        match self {
            Self::Wrap => AddressMode::Wrap,
            Self::Clamp => AddressMode::Clamp,
            Self::Mirror => AddressMode::Mirror,
            Self::Clip => AddressMode::Clip,
        }
    }
}

impl PlaneListing {
    fn of(plane: &crate::pyramid::PlaneImage) -> Self {
        let stem = format!("plane_{}_{}", plane.lu, plane.lv);
        let (png, raw) = (format!("{stem}.png"), format!("{stem}.rgba"));
        Self { lu: plane.lu, lv: plane.lv, width: plane.width, height: plane.height, png, raw }
    }
}

/// The listing comes last: where it lies, all it names lies too.
fn write_planes(folder: &Path, pyramid: &Pyramid, listing: &Listing) -> Result<()> {
    for (plane, names) in pyramid.planes.iter().zip(&listing.planes) {
        image_file::write_png(&folder.join(&names.png), plane)?;
        image_file::write_raw(&folder.join(&names.raw), plane)?;
    }
    write_whole(&folder.join("planes.json"), |file| {
        serde_json::to_writer_pretty(&mut *file, listing)?;
        file.write_all(b"\n")
    })
}

fn print_table(listing: &Listing) {
    let mut table = Table::new();
    table.load_preset(ASCII_MARKDOWN).set_header(["lu", "lv", "width", "height", "bytes", "file"]);
    for plane in &listing.planes {
        let bytes = 4 * u64::from(plane.width) * u64::from(plane.height);
        table.add_row([
            plane.lu.to_string(),
            plane.lv.to_string(),
            plane.width.to_string(),
            plane.height.to_string(),
            bytes.to_string(),
            plane.png.clone(),
        ]);
    }
    for column in table.column_iter_mut().take(5) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    println!("{table}");
    println!("{} bytes in all: {:.4} times the texture", 4 * listing.texels, listing.memory_multiple);
}

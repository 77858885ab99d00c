//! `texunit mips`: a texture into the planes of a pyramid.

use std::{
    path::{Path, PathBuf},
    process::ExitCode,
};

use serde::Serialize;
use texunit_hw::{AddressMode, Format, PyramidKind};

use crate::{
    error::Result,
    names::{Named, by_name},
    output::{create_folder, write_whole},
    pyramid::{Build, From, Kernel, PlaneRounding, Pyramid, build::is_premultiplied, image_file, planes_of},
    report::table::plain,
    texel_format::{Stored, StoredPlane},
    texture_file,
};

/// A summed-area table has no planes to look at.
fn pyramid_of_planes(name: &str) -> std::result::Result<PyramidKind, String> {
    PyramidKind::from_name(name)
        .ok()
        .filter(|kind| *kind != PyramidKind::Sat)
        .ok_or_else(|| format!("no pyramid of planes is named `{name}`: use mipmap, dipmap, ripmap"))
}

/// Make the planes of a pyramid and write each as PNG and as raw bytes in a texel format
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The texture: PNG, JPEG, BMP, TGA, PNM or GIF, or level 0 of a KTX2 or DDS file
    image: PathBuf,
    /// Which planes: mipmap, dipmap or ripmap
    #[arg(long, default_value = "mipmap", value_parser = pyramid_of_planes)]
    pyramid: PyramidKind,
    /// Folder for plane_LU_LV.png, plane_LU_LV.FORMAT and planes.json
    #[arg(short, long, value_name = "DIR")]
    out: PathBuf,
    /// What is averaged: point, box, tent, lanczos or kaiser
    #[arg(long, default_value = "box", value_parser = Kernel::from_name)]
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
    /// The one rounding of each texel: half-even, half-up or truncate
    #[arg(long, default_value = "half-even", value_parser = PlaneRounding::from_name)]
    rounding: PlaneRounding,
    /// What a kernel finds outside the texture: wrap, clamp, clip or mirror
    #[arg(long, default_value = "wrap", value_parser = AddressMode::from_name)]
    edge: AddressMode,
    /// What planes are stored as: rgba8, rgb565, argb1555, argb4444, l8, a8, la8, palette8, bc1, bc3 or bc7; the PNGs show what
    /// that leaves of them
    #[arg(long, default_value = "rgba8", value_parser = Format::from_name)]
    format: Format,
}

/// What `planes.json` says.
#[derive(Serialize)]
struct Listing {
    schema: u32,
    image: String,
    #[serde(with = "by_name")]
    pyramid: PyramidKind,
    #[serde(with = "by_name")]
    format: Format,
    width: u32,
    height: u32,
    texels: u64,
    bytes: u64,
    memory_multiple: f64,
    premultiplied: bool,
    build: Build,
    /// 256 RGBA8 colours.
    #[serde(skip_serializing_if = "Option::is_none")]
    palette: Option<&'static str>,
    planes: Vec<PlaneListing>,
}

/// One plane; `raw` is its texels or 4 x 4 blocks, row after row, no header.
#[derive(Serialize)]
struct PlaneListing {
    lu: u8,
    lv: u8,
    width: u32,
    height: u32,
    bytes: usize,
    png: String,
    raw: String,
}

/// Runs the command.
///
/// # Errors
/// An unreadable image, a width the kernel cannot have, a folder that cannot be written.
pub fn run(args: Args) -> Result<ExitCode> {
    let build = args.build();
    build.kernel.width(build.width)?;
    let top = texture_file::load(&args.image)?.top;
    create_folder(&args.out)?;
    let kind = args.pyramid;
    let list = planes_of(kind, top.width, top.height);
    let progress = indicatif::ProgressBar::new(list.len() as u64).with_message("planes");
    let planes = build.planes(&top, &list, |_| progress.inc(1))?;
    progress.finish_and_clear();
    let stored = Stored::encode(&Pyramid { kind, width: top.width, height: top.height, planes }, args.format);
    let pyramid = stored.decode();

    let listing = Listing {
        schema: 1,
        image: args.image.display().to_string(),
        pyramid: args.pyramid,
        format: args.format,
        width: pyramid.width,
        height: pyramid.height,
        texels: pyramid.texels(),
        bytes: stored.planes.iter().map(|plane| plane.elements.len() as u64).sum(),
        memory_multiple: pyramid.memory_multiple(),
        premultiplied: is_premultiplied(&top.texels),
        // With the width the kernel has, asked for or not.
        build: Build { width: build.kernel.width(build.width)?, ..build },
        palette: stored.palette.as_ref().map(|_| PALETTE),
        planes: stored.planes.iter().map(|plane| PlaneListing::of(plane, args.format)).collect(),
    };
    write_planes(&args.out, &stored, &pyramid, &listing)?;
    print_table(&listing)?;
    Ok(ExitCode::SUCCESS)
}

impl Args {
    fn build(&self) -> Build {
        Build {
            kernel: self.kernel,
            width: self.width,
            from: if self.from_above { From::Above } else { From::Top },
            rounding: self.rounding,
            edge: self.edge,
        }
    }
}

impl PlaneListing {
    fn of(plane: &StoredPlane, format: Format) -> Self {
        let stem = format!("plane_{}_{}", plane.lu, plane.lv);
        let extension = if format == Format::Rgba8 { "rgba" } else { format.name() };
        let (png, raw) = (format!("{stem}.png"), format!("{stem}.{extension}"));
        let bytes = plane.elements.len();
        Self { lu: plane.lu, lv: plane.lv, width: plane.width, height: plane.height, bytes, png, raw }
    }
}

/// Name of the file with the colours of a palette.
const PALETTE: &str = "palette.rgba";

/// The listing comes last: where it lies, all it names lies too.
fn write_planes(folder: &Path, stored: &Stored, pyramid: &Pyramid, listing: &Listing) -> Result<()> {
    for ((plane, elements), names) in pyramid.planes.iter().zip(&stored.planes).zip(&listing.planes) {
        image_file::write_png(&folder.join(&names.png), plane)?;
        write_whole(&folder.join(&names.raw), |file| file.write_all(&elements.elements))?;
    }
    if let Some(palette) = &stored.palette {
        write_whole(&folder.join(PALETTE), |file| file.write_all(palette.as_flattened()))?;
    }
    write_whole(&folder.join("planes.json"), |file| {
        serde_json::to_writer_pretty(&mut *file, listing)?;
        file.write_all(b"\n")
    })
}

fn print_table(listing: &Listing) -> Result<()> {
    let mut table = plain(["lu", "lv", "width", "height", "bytes", "file"], ..5);
    for plane in &listing.planes {
        table.add_row([
            plane.lu.to_string(),
            plane.lv.to_string(),
            plane.width.to_string(),
            plane.height.to_string(),
            plane.bytes.to_string(),
            plane.png.clone(),
        ]);
    }
    say!("{table}");
    say!(
        "{} bytes in all: {:.4} times the texture, as {}",
        listing.bytes,
        listing.memory_multiple,
        listing.format.name()
    );
    Ok(())
}

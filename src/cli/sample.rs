//! `texunit sample`: coordinates in, filtered texels out, a row per row.

use std::{
    fs::File,
    io::{self, BufRead, BufReader, Write},
    path::{Path, PathBuf},
    process::ExitCode,
};

use texunit_hw::{AddressMode, Filter, LodSource, Request, Response, Sampler, Unit};

use crate::{
    coordinate_rows::{BLOCK, Columns, Row, RowDetail, Rows},
    error::{Error, Result},
    front_end::{FrontEnd, coordinates},
    machine::{Machine, parser, to_level},
    names::AnyFilter,
    output::write_or_print,
    pyramid::Pyramid,
    reference::{
        Reference,
        ewa::Ewa,
        ideal::{Detail, Ideal, IdealSampler},
    },
    texture_file,
    texture_memory::{Held, TextureMemory},
};

/// Sample a texture at coordinates from a CSV file
///
/// Columns of the input, named in its first line: `u,v,lod` (lod 0 is the texture itself, as in OpenGL), or
/// `u,v,dudx,dvdx,dudy,dvdy` (normalised coordinates, change of u and v per pixel step). Columns of the output: `r,g,b,a`
/// from 0 to 255 and `lod`, the level used; filters with a level per axis add `lod_v`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Texture to sample: PNG, JPEG, BMP, TGA, PNM, GIF, KTX2 or DDS
    #[arg(long, value_name = "FILE")]
    texture: PathBuf,
    /// Filter: point, bilinear, nearest-mip, trilinear, dipmap, ...; `ewa` with `--model ideal`
    #[arg(long, value_parser = AnyFilter::from_name)]
    filter: AnyFilter,
    /// Address mode of both axes: wrap, clamp, clip, mirror
    #[arg(long, value_parser = parser::<AddressMode>(), default_value = "wrap")]
    wrap: AddressMode,
    /// Address mode of the v axis, where it differs
    #[arg(long, value_parser = parser::<AddressMode>())]
    wrap_v: Option<AddressMode>,
    /// Coordinates, CSV; `-` for standard input
    #[arg(long, value_name = "COORDS.csv")]
    input: PathBuf,
    /// Texels, CSV; `-` for standard output
    #[arg(long, value_name = "OUT.csv")]
    output: PathBuf,
    /// Who answers: the chip, the float reference (the same bits), or the unquantised ideal (floats)
    #[arg(long, value_enum, default_value = "hw")]
    model: Model,
    #[command(flatten)]
    machine: super::MachineArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Model {
    Hw,
    Reference,
    Ideal,
}

/// Runs the command.
///
/// # Errors
/// Unreadable or malformed input, with its line; an output that cannot be written.
pub fn run(args: &Args) -> Result<ExitCode> {
    let machine = args.machine.load()?;
    if args.filter == AnyFilter::Ewa && args.model != Model::Ideal {
        let problem =
            "ewa weighs every texel of an ellipse in floats: no unit has it, so there are no bits to answer with";
        return Err(Error::setting(
            "--filter",
            "ewa",
            problem,
            "add `--model ideal`, or take feline, its nearest on the chip",
        ));
    }
    let address = [args.wrap, args.wrap_v.unwrap_or(args.wrap)];
    let texture = texture_file::load(&args.texture)?;
    let Held { pyramid, memory } = machine.texture.hold(args.filter.on_pyramid_of().pyramid(), &texture)?;
    let (name, input): (&Path, Box<dyn BufRead>) = if args.input.as_os_str() == "-" {
        (Path::new("standard input"), Box::new(io::stdin().lock()))
    } else {
        (&args.input, Box::new(BufReader::new(File::open(&args.input).map_err(Error::io(&args.input))?)))
    };
    let mut rows = Rows::new(name, input)?;
    let filter = args.filter.on_pyramid_of();
    let session = Session { args, filter, machine: &machine, address, pyramid: &pyramid, memory: &memory };
    // The rows are read while the output is written: an error of the former must not leave half of the latter.
    let mut failed = None;
    let written = write_or_print(&args.output, |output| match session.answer(&mut rows, output) {
        Ok(None) => Ok(()),
        Ok(Some(error)) => Err(error),
        Err(error) => {
            failed = Some(error);
            Err(io::Error::other("input"))
        }
    });
    failed.map_or(written, Err)?;
    Ok(ExitCode::SUCCESS)
}

/// Appends the answers of rows as CSV and counts coordinates without a place.
type RowSampler<'s> = Box<dyn FnMut(&[Row], &mut String) -> u64 + 's>;

/// Answers requests in bits.
type FixedSampler<'s> = Box<dyn FnMut(&[Request]) -> Vec<Response> + 's>;

struct Session<'a> {
    args: &'a Args,
    /// That of the unit; the one whose pyramid EWA reads.
    filter: Filter,
    machine: &'a Machine,
    address: [AddressMode; 2],
    pyramid: &'a Pyramid,
    memory: &'a TextureMemory,
}

impl Session<'_> {
    /// Answers every row; an error of the writer is returned inside, one of the rows outside.
    fn answer(&self, rows: &mut Rows<Box<dyn BufRead>>, output: &mut dyn Write) -> Result<Option<io::Error>> {
        let source = if rows.columns() == Columns::Level { LodSource::Explicit } else { LodSource::Gradient };
        let sampler = self.machine.sampler(self.filter, self.address, source);
        let per_axis = self.filter.level_per_axis();
        let mut text = format!("r,g,b,a,lod{}\n", if per_axis { ",lod_v" } else { "" });
        let mut block = Vec::with_capacity(BLOCK);
        let mut sampled = self.sampler(&sampler)?;
        let mut undefined = 0;
        loop {
            rows.block(&mut block)?;
            undefined += sampled(&block, &mut text);
            if let Err(error) = output.write_all(text.as_bytes()) {
                return Ok(Some(error));
            }
            text.clear();
            if block.is_empty() {
                break;
            }
        }
        if undefined > 0 {
            eprintln!("texunit: {undefined} coordinates were NaN or infinite and were read as 0");
        }
        Ok(output.flush().err())
    }

    /// A function that appends the answers of a block of rows as CSV and counts coordinates without a place.
    fn sampler<'s>(&'s self, sampler: &'s Sampler) -> Result<RowSampler<'s>> {
        use std::fmt::Write as _;
        let per_axis = sampler.filter.level_per_axis();
        if self.args.filter == AnyFilter::Ewa {
            let ewa = Ewa::new(self.pyramid, &IdealSampler::from(sampler))?;
            let size = [self.pyramid.width, self.pyramid.height];
            return Ok(Box::new(move |rows, text| {
                for row in rows {
                    let answer = ewa.sample([row.u, row.v], row.gradient(size));
                    let [r, g, b, a] = answer.texel;
                    let _ = writeln!(text, "{r},{g},{b},{a},{}", answer.lod);
                }
                0
            }));
        }
        if self.args.model == Model::Ideal {
            let ideal = Ideal::new(self.pyramid, IdealSampler::from(sampler))?;
            let front_end = self.front_end();
            return Ok(Box::new(move |rows, text| {
                for row in rows {
                    let detail = match row.detail {
                        RowDetail::Level(level) => Detail::Level([level; 2]),
                        RowDetail::Gradient(_) => front_end.ideal_detail(&row.fragment()),
                    };
                    let answer = ideal.sample([row.u, row.v], detail);
                    let [r, g, b, a] = answer.texel;
                    let _ = write!(text, "{r},{g},{b},{a},{}", answer.lod[0]);
                    let _ = if per_axis { writeln!(text, ",{}", answer.lod[1]) } else { writeln!(text) };
                }
                0
            }));
        }
        let mut fixed = self.fixed(sampler)?;
        Ok(Box::new(move |rows, text| {
            let mut undefined = 0;
            let requests: Vec<Request> = rows
                .iter()
                .map(|row| {
                    let (request, without_place) = self.request(row);
                    undefined += without_place;
                    request
                })
                .collect();
            for response in fixed(&requests) {
                let [r, g, b, a] = response.texel;
                let [lod, lod_v] = response.lod.map(|level| f64::from(level) / 256.0);
                let _ = write!(text, "{r},{g},{b},{a},{lod}");
                let _ = if per_axis { writeln!(text, ",{lod_v}") } else { writeln!(text) };
            }
            undefined
        }))
    }

    /// The two models that answer in bits.
    fn fixed<'s>(&'s self, sampler: &'s Sampler) -> Result<FixedSampler<'s>> {
        if self.args.model == Model::Reference {
            let reference = Reference::new(self.pyramid, sampler)?;
            return Ok(Box::new(move |requests| requests.iter().map(|request| reference.sample(request)).collect()));
        }
        Ok(Box::new(move |requests| {
            let mut responses = vec![Response::default(); requests.len()];
            let mut unit =
                Unit::new(sampler, &self.memory.surface, &self.memory.bytes).expect("the machine was checked");
            unit.run(requests, &mut responses, &mut ());
            responses
        }))
    }

    fn front_end(&self) -> FrontEnd {
        FrontEnd::new(self.machine, self.filter, self.address, [self.pyramid.width, self.pyramid.height])
    }

    fn request(&self, row: &Row) -> (Request, u64) {
        match row.detail {
            RowDetail::Level(level) => {
                let ([u, v], undefined) = coordinates(row.u, row.v, self.address);
                (Request { scale: [to_level(level).cast_unsigned(); 2], ..Request::at(u, v) }, undefined)
            }
            RowDetail::Gradient(_) => self.front_end().request(&row.fragment()),
        }
    }
}

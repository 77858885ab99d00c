//! `texunit kernels`: what each pyramid kernel keeps, leaks and rings.

use std::{path::PathBuf, process::ExitCode};

use crate::{
    error::Result,
    names::Named,
    output::{create_folder, write_whole},
    pyramid::{Kernel, response::Response},
    report::response_plot,
    report::table::plain,
};

/// Show the frequency response of the pyramid kernels: pass-band loss, stop-band leak, ringing
///
/// For one 2:1 halving along one axis, on the integer taps planes are made with. Loss and leak are mean squares of the
/// deviation from the ideal low-pass over 0..1/4 and 1/4..1/2 cycle per source texel; what leaks comes back as alias. Ringing is
/// the range a step edge from 0 to 255 takes before it is clamped: where the step lies between two texels of the smaller
/// plane, and where it cuts one in half.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Width of tent, lanczos and kaiser in source texels, even, 2 to 64 [default: tent 4, lanczos and kaiser 14]
    #[arg(long, value_name = "N")]
    width: Option<u8>,
    /// Folder for kernels.svg, the responses drawn
    #[arg(short, long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// A width no kernel can have, a folder that cannot be written.
pub fn run(args: Args) -> Result<ExitCode> {
    let responses = Kernel::ALL
        .iter()
        .map(|&(_, kernel)| Response::of(kernel, kernel.default_width().and(args.width)))
        .collect::<Result<Vec<_>>>()?;
    if let Some(folder) = &args.out {
        let drawing = response_plot::svg(&responses);
        create_folder(folder)?;
        write_whole(&folder.join("kernels.svg"), |file| file.write_all(drawing.as_bytes()))?;
    }
    let header = ["kernel", "taps", "pass-band loss", "stop-band leak", "step on the grid", "step off the grid"];
    let mut table = plain(header, 1..);
    for response in &responses {
        let range = |aligned| {
            let (low, high) = response.step_extremes(aligned);
            format!("{low:.1} to {high:.1}")
        };
        table.add_row([
            response.kernel.name().to_string(),
            response.width.to_string(),
            format!("{:.4}", response.pass_loss()),
            format!("{:.4}", response.stop_leak()),
            range(true),
            range(false),
        ]);
    }
    say!("{table}");
    Ok(ExitCode::SUCCESS)
}

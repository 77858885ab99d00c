//! The frequency responses of the pyramid kernels as one drawing.

use plotters::prelude::*;

use crate::{names::Named, pyramid::response::Response};

/// Points of a curve.
const STEPS: u32 = 512;

/// Colours told apart by most colour-blind eyes (Okabe & Ito 2008).
const COLOURS: [RGBColor; 5] =
    [RGBColor(0, 0, 0), RGBColor(230, 159, 0), RGBColor(86, 180, 233), RGBColor(0, 158, 115), RGBColor(213, 94, 0)];

/// Quietest decibel drawn.
const FLOOR_DECIBEL: f64 = -80.0;

/// Gain over frequency, linear above and in decibels below, with the ideal low-pass.
#[must_use]
pub fn svg(responses: &[Response]) -> String {
    let mut text = String::new();
    draw(&mut text, responses).expect("drawing into a string has nothing to fail on");
    text
}

fn draw(text: &mut String, responses: &[Response]) -> Result<(), Box<dyn std::error::Error>> {
    let area = SVGBackend::with_string(text, (860, 900)).into_drawing_area();
    area.fill(&WHITE)?;
    let area = area.titled("Pyramid kernels at 2:1", ("sans-serif", 22))?;
    let (upper, lower) = area.split_vertically(450);
    let ideal = |above: f64, below: f64| vec![(0.0, above), (0.25, above), (0.25, below), (0.5, below)];
    let decibel = |gain: f64| (20.0 * libm::log10(gain.abs().max(1e-9))).max(FLOOR_DECIBEL);
    panel(&upper, responses, "gain", -0.25..1.15, &ideal(1.0, 0.0), |gain| gain)?;
    panel(&lower, responses, "gain, dB", FLOOR_DECIBEL..5.0, &ideal(0.0, FLOOR_DECIBEL), decibel)?;
    area.present()?;
    Ok(())
}

fn panel(
    area: &DrawingArea<SVGBackend<'_>, plotters::coord::Shift>,
    responses: &[Response],
    label: &str,
    range: std::ops::Range<f64>,
    ideal: &[(f64, f64)],
    scale: impl Fn(f64) -> f64,
) -> Result<(), Box<dyn std::error::Error>> {
    let mut chart = ChartBuilder::on(area)
        .margin(12)
        .x_label_area_size(40)
        .y_label_area_size(56)
        .build_cartesian_2d(0.0..0.5, range)?;
    chart
        .configure_mesh()
        .x_desc("frequency, cycles per source texel (the smaller plane holds up to 0.25)")
        .y_desc(label)
        .x_labels(11)
        .x_label_formatter(&|x| format!("{x:.2}"))
        .label_style(("sans-serif", 13))
        .light_line_style(WHITE)
        .draw()?;
    let grey = RGBColor(150, 150, 150);
    chart
        .draw_series(LineSeries::new(ideal.iter().copied(), grey.stroke_width(2)))?
        .label("ideal")
        .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], grey.stroke_width(2)));
    for (response, colour) in responses.iter().zip(COLOURS) {
        let points = (0..=STEPS).map(|step| {
            let frequency = f64::from(step) / f64::from(2 * STEPS);
            (frequency, scale(response.at(frequency)))
        });
        chart
            .draw_series(LineSeries::new(points, colour.stroke_width(2)))?
            .label(format!("{} ({})", response.kernel.name(), response.width))
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], colour.stroke_width(2)));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::LowerLeft)
        .background_style(WHITE.mix(0.85))
        .border_style(grey)
        .label_font(("sans-serif", 14))
        .draw()?;
    Ok(())
}

//! One kind of plot for all: lines and points over two axes, linear or logarithmic, as SVG.

use plotters::prelude::*;

/// Colours told apart by most colour-blind eyes (Okabe & Ito 2008), without the yellow, which paper does not show.
pub const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
];

/// One axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// What it is, with its unit.
    pub label: String,
    /// Whether it is logarithmic; values that are not positive are then left out.
    pub logarithmic: bool,
}

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// Points joined by lines.
    Line,
    /// Points alone, each with a colour by its series.
    Points,
    /// A thin grey line without a legend.
    Thread,
}

/// A series.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Name in the legend.
    pub name: String,
    /// How it is drawn.
    pub style: Style,
    /// x, y, and what is written beside it, if anything.
    pub points: Vec<(f64, f64, String)>,
}

/// A plot.
#[derive(Clone, Debug, PartialEq)]
pub struct Plot {
    /// Title.
    pub title: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// What is drawn, later series on top.
    pub series: Vec<Series>,
}

impl Axis {
    fn place(&self, value: f64) -> Option<f64> {
        let place = if self.logarithmic { libm::log10(value) } else { value };
        place.is_finite().then_some(place)
    }

    fn tick(&self, place: f64) -> String {
        let value = if self.logarithmic { libm::pow(10.0, place) } else { place };
        match value.abs() {
            0.0 => "0".into(),
            large if large >= 1e7 => format!("{:.0} M", value / 1e6),
            large if large >= 1e4 => format!("{:.0} k", value / 1e3),
            large if large >= 100.0 => format!("{value:.0}"),
            large if large >= 1.0 => format!("{value:.1}"),
            large if large >= 0.01 => format!("{value:.3}"),
            _ => format!("{value:.1e}"),
        }
    }
}

impl Plot {
    /// The drawing, 860 x 520, on white.
    #[must_use]
    pub fn svg(&self) -> String {
        let mut text = String::new();
        self.draw(&mut text).expect("drawing into a string has nothing to fail on");
        text
    }

    fn places(&self, series: &Series) -> Vec<(f64, f64, String)> {
        let place = |(x, y, label): &(f64, f64, String)| Some((self.x.place(*x)?, self.y.place(*y)?, label.clone()));
        series.points.iter().filter_map(place).collect()
    }

    /// The range of all values of an axis, with a margin.
    fn range(values: impl Iterator<Item = f64>) -> std::ops::Range<f64> {
        let (low, high) =
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
        if low > high {
            return 0.0..1.0;
        }
        let margin = ((high - low) * 0.06).max(0.02 * high.abs()).max(1e-3);
        low - margin..high + margin
    }

    fn draw(&self, text: &mut String) -> Result<(), Box<dyn std::error::Error>> {
        let area = SVGBackend::with_string(text, (860, 520)).into_drawing_area();
        area.fill(&WHITE)?;
        let placed: Vec<Vec<(f64, f64, String)>> = self.series.iter().map(|series| self.places(series)).collect();
        let all = || placed.iter().flatten();
        let (across, up) = (Self::range(all().map(|place| place.0)), Self::range(all().map(|place| place.1)));
        let mut chart = ChartBuilder::on(&area)
            .caption(&self.title, ("sans-serif", 20))
            .margin(10)
            .x_label_area_size(44)
            .y_label_area_size(64)
            .build_cartesian_2d(across, up)?;
        chart
            .configure_mesh()
            .x_desc(&self.x.label)
            .y_desc(&self.y.label)
            .x_labels(8)
            .y_labels(8)
            .x_label_formatter(&|&place| self.x.tick(place))
            .y_label_formatter(&|&place| self.y.tick(place))
            .label_style(("sans-serif", 13))
            .bold_line_style(BLACK.mix(0.12))
            .light_line_style(TRANSPARENT)
            .draw()?;
        let mut coloured = 0;
        for (series, points) in self.series.iter().zip(&placed) {
            let colour = COLOURS[coloured % COLOURS.len()];
            let line = points.iter().map(|&(x, y, _)| (x, y));
            match series.style {
                Style::Thread => {
                    chart.draw_series(LineSeries::new(line, BLACK.mix(0.35).stroke_width(1)))?;
                }
                Style::Line if coloured < COLOURS.len() => {
                    let drawn = chart.draw_series(LineSeries::new(line, colour.stroke_width(2)))?;
                    drawn
                        .label(&series.name)
                        .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], colour.stroke_width(2)));
                }
                Style::Line => {
                    let drawn = chart.draw_series(DashedLineSeries::new(line, 6, 4, colour.stroke_width(2)))?;
                    drawn
                        .label(&series.name)
                        .legend(move |(x, y)| PathElement::new([(x, y), (x + 8, y)], colour.stroke_width(2)));
                }
                Style::Points => {
                    // A second round of the colours has rings for discs.
                    let style = if coloured < COLOURS.len() { colour.filled() } else { colour.stroke_width(2) };
                    let drawn = chart.draw_series(points.iter().map(|&(x, y, _)| Circle::new((x, y), 4, style)))?;
                    drawn.label(&series.name).legend(move |(x, y)| Circle::new((x + 10, y), 4, style));
                }
            }
            coloured += usize::from(series.style != Style::Thread);
            chart.draw_series(points.iter().filter(|(.., label)| !label.is_empty()).map(|(x, y, label)| {
                EmptyElement::at((*x, *y)) + Text::new(label.clone(), (7, -13), ("sans-serif", 12))
            }))?;
        }
        if coloured > 1 {
            chart
                .configure_series_labels()
                .position(SeriesLabelPosition::UpperRight)
                .background_style(WHITE.mix(0.8))
                .border_style(BLACK.mix(0.2))
                .label_font(("sans-serif", 12))
                .draw()?;
        }
        area.present()?;
        Ok(())
    }
}

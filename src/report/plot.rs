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

/// An axis with its range: where values go, and where the ticks are.
#[derive(Clone)]
struct Scale {
    logarithmic: bool,
    range: std::ops::Range<f64>,
}

impl Axis {
    /// Where a value stands on the axis; `None` where it has no place.
    fn place(&self, value: f64) -> Option<f64> {
        Some(value).filter(|value| value.is_finite() && (!self.logarithmic || *value > 0.0))
    }

    /// From the least to the largest value, and a little more.
    fn scale(&self, values: impl Iterator<Item = f64>) -> Scale {
        let logarithmic = self.logarithmic;
        let extremes = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) = values.fold(extremes, |(low, high), value| (low.min(value), high.max(value)));
        let range = match (low > high, logarithmic) {
            (true, _) => 1.0..10.0,
            (false, true) => {
                let margin = libm::pow(high / low, 0.05).max(1.1);
                low / margin..high * margin
            }
            (false, false) => {
                let margin = ((high - low) * 0.06).max(0.02 * high.abs()).max(1e-3);
                low - margin..high + margin
            }
        };
        Scale { logarithmic, range }
    }
}

impl Scale {
    fn stretch(&self, value: f64) -> f64 {
        if self.logarithmic { libm::log10(value) } else { value }
    }

    /// Powers of ten with 2 and 5 between them; the powers alone where that is too many.
    fn decades(&self, most: usize) -> Vec<f64> {
        let powers = libm::floor(libm::log10(self.range.start)) as i32..=libm::ceil(libm::log10(self.range.end)) as i32;
        let ticks = |steps: &[f64]| -> Vec<f64> {
            let all =
                powers.clone().flat_map(|power| steps.iter().map(move |step| step * libm::pow(10.0, power.into())));
            all.filter(|tick| self.range.contains(tick)).collect()
        };
        let fine = ticks(&[1.0, 2.0, 5.0]);
        if fine.len() <= most { fine } else { ticks(&[1.0]) }
    }
}

impl Ranged for Scale {
    type FormatOption = plotters::coord::ranged1d::NoDefaultFormatting;
    type ValueType = f64;

    #[allow(clippy::cast_possible_truncation, reason = "pixels of a drawing")]
    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        let [low, high, at] = [self.range.start, self.range.end, *value].map(|value| self.stretch(value));
        let share = (at - low) / (high - low);
        limit.0 + (f64::from(limit.1 - limit.0) * share).round() as i32
    }

    fn key_points<Hint: plotters::coord::ranged1d::KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        if self.logarithmic {
            self.decades(hint.max_num_points())
        } else {
            plotters::coord::types::RangedCoordf64::from(self.range.clone()).key_points(hint)
        }
    }

    fn range(&self) -> std::ops::Range<f64> {
        self.range.clone()
    }
}

impl plotters::coord::ranged1d::ValueFormatter<f64> for Scale {
    fn format(value: &f64) -> String {
        let (scaled, suffix) = match value.abs() {
            large if large >= 1e6 => (value / 1e6, " M"),
            large if large >= 1e4 => (value / 1e3, " k"),
            _ => (*value, ""),
        };
        // Ticks are round numbers; what is left of them beyond the sixth digit is rounding.
        let text = format!("{scaled:.6}");
        format!("{}{suffix}", text.trim_end_matches('0').trim_end_matches('.'))
    }
}

/// Where the legend begins, pixels from the left.
const LEGEND: i32 = 690;

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

    fn draw(&self, text: &mut String) -> Result<(), Box<dyn std::error::Error>> {
        let whole = SVGBackend::with_string(text, (860, 520)).into_drawing_area();
        whole.fill(&WHITE)?;
        let placed: Vec<Vec<(f64, f64, String)>> = self.series.iter().map(|series| self.places(series)).collect();
        let all = || placed.iter().flatten();
        let across = self.x.scale(all().map(|place| place.0));
        let up = self.y.scale(all().map(|place| place.1));
        let named = self.series.iter().filter(|series| series.style != Style::Thread).count();
        let (area, legend) = whole.split_horizontally(if named > 1 { LEGEND } else { 860 });
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
            .x_labels(12)
            .y_labels(12)
            .label_style(("sans-serif", 13))
            .bold_line_style(BLACK.mix(0.12))
            .light_line_style(TRANSPARENT)
            .draw()?;
        let mut number = 0;
        for (series, points) in self.series.iter().zip(&placed) {
            let colour = COLOURS[number % COLOURS.len()];
            // A second round of the colours has dashes for lines and rings for discs.
            let again = number >= COLOURS.len();
            let line = points.iter().map(|&(x, y, _)| (x, y));
            let disc = if again { colour.stroke_width(2) } else { colour.filled() };
            match series.style {
                Style::Thread => {
                    chart.draw_series(LineSeries::new(line, BLACK.mix(0.35).stroke_width(1)))?;
                }
                Style::Line if again => {
                    chart.draw_series(DashedLineSeries::new(line, 6, 4, colour.stroke_width(2)))?;
                }
                Style::Line => {
                    chart.draw_series(LineSeries::new(line, colour.stroke_width(2)))?;
                }
                Style::Points => {
                    chart.draw_series(points.iter().map(|&(x, y, _)| Circle::new((x, y), 4, disc)))?;
                }
            }
            // Labels of neighbours go to different heights.
            let beside = if number % 2 == 0 { (7, -14) } else { (7, 3) };
            chart.draw_series(points.iter().filter(|(.., label)| !label.is_empty()).map(|(x, y, label)| {
                EmptyElement::at((*x, *y)) + Text::new(label.clone(), beside, ("sans-serif", 13))
            }))?;
            if series.style == Style::Thread {
                continue;
            }
            if named > 1 {
                let top = 56 + 19 * number as i32;
                match series.style {
                    Style::Points => legend.draw(&Circle::new((12, top), 4, disc))?,
                    _ => {
                        let dashes: &[(i32, i32)] = if again { &[(0, 7), (13, 20)] } else { &[(0, 20)] };
                        for &(left, right) in dashes {
                            legend.draw(&PathElement::new([(left, top), (right, top)], colour.stroke_width(2)))?;
                        }
                    }
                }
                legend.draw(&Text::new(series.name.clone(), (26, top - 7), ("sans-serif", 13)))?;
            }
            number += 1;
        }
        whole.present()?;
        Ok(())
    }
}

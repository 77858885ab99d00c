//! Bars of parts that add up, as SVG.

use plotters::prelude::*;

use super::plot::COLOURS;

/// A bar a thing, a piece a part.
///
/// ```
/// use texunit::report::stack::Stack;
/// let stack = Stack {
///     title: "error".into(),
///     label: "LSB".into(),
///     parts: vec!["rounding".into()],
///     bars: vec![("bilinear".into(), vec![0.29])],
/// };
/// assert!(stack.svg().contains("bilinear"));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Stack {
    /// Title.
    pub title: String,
    /// What the length is, with its unit.
    pub label: String,
    /// Names of the parts.
    pub parts: Vec<String>,
    /// Each bar with its name and its parts; negative ones go to the left of zero.
    pub bars: Vec<(String, Vec<f64>)>,
}

/// Pixels of a bar with the gap to the next.
const BAR: u32 = 30;

impl Stack {
    /// The drawing, 860 wide and as high as it has bars, on white.
    #[must_use]
    pub fn svg(&self) -> String {
        let mut text = String::new();
        self.draw(&mut text).expect("drawing into a string has nothing to fail on");
        text
    }

    /// Lengths to the left and to the right of zero.
    fn extent(&self) -> (f64, f64) {
        let sum = |sign: f64, bar: &[f64]| bar.iter().map(|part| (part * sign).max(0.0)).sum::<f64>() * sign;
        let ends = self.bars.iter().map(|(_, bar)| (sum(-1.0, bar), sum(1.0, bar)));
        let (low, high) = ends.fold((0.0f64, 0.0f64), |(low, high), (left, right)| (low.min(left), high.max(right)));
        let margin = ((high - low) * 0.04).max(1e-6);
        (if low < 0.0 { low - margin } else { 0.0 }, high + margin)
    }

    fn draw(&self, text: &mut String) -> Result<(), Box<dyn std::error::Error>> {
        let count = self.bars.len();
        let whole = SVGBackend::with_string(text, (860, 110 + BAR * count as u32)).into_drawing_area();
        whole.fill(&WHITE)?;
        let (area, legend) = whole.split_horizontally(730);
        let (low, high) = self.extent();
        let mut chart = ChartBuilder::on(&area)
            .caption(&self.title, ("sans-serif", 20))
            .margin(10)
            .x_label_area_size(44)
            .y_label_area_size(130)
            .build_cartesian_2d(low..high, 0.0..count as f64)?;
        chart
            .configure_mesh()
            .x_desc(&self.label)
            .x_labels(10)
            .y_labels(0)
            .disable_y_mesh()
            .label_style(("sans-serif", 13))
            .bold_line_style(BLACK.mix(0.12))
            .light_line_style(TRANSPARENT)
            .draw()?;
        for (number, (name, parts)) in self.bars.iter().enumerate() {
            // The first bar on top.
            let bottom = (count - 1 - number) as f64;
            let name = Text::new(name.clone(), (-128, -7), ("sans-serif", 13));
            chart.draw_series([EmptyElement::at((low, bottom + 0.5)) + name])?;
            let (mut left, mut right) = (0.0, 0.0);
            for (part, &length) in parts.iter().enumerate() {
                let end = if length < 0.0 { &mut left } else { &mut right };
                let corners = [(*end, bottom + 0.15), (*end + length, bottom + 0.85)];
                chart.draw_series([Rectangle::new(corners, COLOURS[part % COLOURS.len()].filled())])?;
                *end += length;
            }
        }
        for (part, name) in self.parts.iter().enumerate() {
            let top = 56 + 19 * part as i32;
            let colour = COLOURS[part % COLOURS.len()];
            legend.draw(&Rectangle::new([(0, top - 6), (12, top + 6)], colour.filled()))?;
            legend.draw(&Text::new(name.clone(), (18, top - 7), ("sans-serif", 13)))?;
        }
        whole.present()?;
        Ok(())
    }
}

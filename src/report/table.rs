//! Tables on a terminal: words to the left, numbers to the right.

use std::ops::RangeBounds;

use comfy_table::{CellAlignment, Row, Table, TableStyle, presets};

fn table(style: TableStyle, header: Row, numbers: impl RangeBounds<usize>) -> Table {
    let mut table = Table::new();
    table.load_style(style).set_header(header);
    for (_, column) in table.column_iter_mut().enumerate().filter(|(place, _)| numbers.contains(place)) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

/// An empty table in a frame, with those of its columns that hold numbers.
pub fn framed(header: impl Into<Row>, numbers: impl RangeBounds<usize>) -> Table {
    table(presets::UTF8_BORDERS_ONLY, header.into(), numbers)
}

/// The same without any lines.
pub fn plain(header: impl Into<Row>, numbers: impl RangeBounds<usize>) -> Table {
    table(presets::NOTHING, header.into(), numbers)
}

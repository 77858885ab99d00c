//! Logic of a filter: what the units of hw/rtl that a machine's options ask for took in yosys (docs/hardware.md).

use std::sync::LazyLock;

use texunit_hw::{Filter, Log2, Rounding};

use crate::{experiment::report::Metric, machine::Machine};

/// The committed table: `make -C hw area`.
const TABLE: &str = include_str!("../hw/syn/area.csv");

/// A line of it.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Line {
    unit: String,
    option: String,
    area: Area,
}

/// What units take, flops and SRAM apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Area {
    /// CMOS transistors of the gates; divided by 4: NAND2 equivalents.
    pub transistors: u64,
    /// Look-up tables of a Xilinx 7.
    pub luts: u64,
    /// Multiplier blocks of the same.
    pub dsps: u64,
}

static LINES: LazyLock<Vec<Line>> = LazyLock::new(|| {
    let text = TABLE.lines().filter(|line| !line.starts_with('#')).collect::<Vec<_>>().join("\n");
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let header = reader.headers().cloned().unwrap_or_default();
    let column = |name: &str| header.iter().position(|column| column == name).unwrap_or(usize::MAX);
    let number = |record: &csv::StringRecord, name: &str| {
        record.get(column(name)).and_then(|value| value.parse().ok()).unwrap_or_default()
    };
    let line = |record: csv::StringRecord| Line {
        unit: record[0].to_owned(),
        option: record[1].to_owned(),
        area: Area {
            transistors: number(&record, "transistors"),
            luts: number(&record, "luts"),
            dsps: number(&record, "dsps"),
        },
    };
    reader.records().filter_map(Result::ok).map(line).collect()
});

/// The logic between a request and its answer, with taps, planes, address and datapath, and a LOD unit if the filter has one; without cache and
/// FIFOs. `None` for filters and options of which there is no RTL, or no line in the table.
///
/// ```
/// use texunit::{area, machine::Machine};
/// use texunit_hw::Filter;
/// let machine = Machine::default();
/// let [bilinear, trilinear] = [Filter::Bilinear, Filter::Trilinear].map(|filter| area::of(&machine, filter).unwrap());
/// assert!(bilinear.luts < trilinear.luts); // no logarithm
/// assert_eq!(area::of(&machine, Filter::Feline), None);
/// ```
#[must_use]
pub fn of(machine: &Machine, filter: Filter) -> Option<Area> {
    if !matches!(filter, Filter::Point | Filter::Bilinear | Filter::Trilinear | Filter::Dipmap) {
        return None;
    }
    let lod = match (machine.lod.log2, machine.lod.bits) {
        (Log2::Exact, 8) => "exact",
        (Log2::Exact, 4) => "exact-4-level-bits",
        (Log2::Herf, 8) => "herf",
        (Log2::Ilog2, 8) => "ilog2",
        _ if filter.uses_level() => return None,
        _ => "exact",
    };
    let rounding = match machine.filter.rounding {
        Rounding::Once => "once",
        Rounding::StagedRound => "staged-round",
        Rounding::StagedTruncate => "staged-truncate",
    };
    let datapath = format!("{rounding}-{}-bits", machine.filter.bits);
    // The address unit was measured with 8 filter bits; fewer are a few gates less.
    let mut units =
        vec![("taps", "all-filters"), ("surface", "tiled-4x4"), ("address", "8-bits"), ("datapath", &datapath)];
    if filter.uses_level() {
        units.push(("lod", lod));
    }
    units.into_iter().try_fold(Area::default(), |sum, (unit, option)| {
        let line = LINES.iter().find(|line| line.unit == unit && line.option == option)?;
        Some(Area {
            transistors: sum.transistors + line.area.transistors,
            luts: sum.luts + line.area.luts,
            dsps: sum.dsps + line.area.dsps,
        })
    })
}

/// The same as metrics, without a value where there is none.
#[must_use]
pub fn metrics(machine: &Machine, filter: Filter) -> [Metric; 2] {
    let area = of(machine, filter);
    [
        Metric { name: "area_transistors", value: area.map(|area| area.transistors as f64), unit: "transistor" },
        Metric { name: "area_luts", value: area.map(|area| area.luts as f64), unit: "LUT" },
    ]
}

//! X18: fragments that miss more lines than the reorder buffer holds.

use texunit_hw::{AddressMode, Filter, I12F20, LodSource, PyramidKind, Request};

use super::{Case, Options, Row, lab};
use crate::{error::Result, machine::Machine, timed_run::time_requests};

pub(super) const DEADLOCK: Case = Case {
    name: "X18",
    title: "one fragment misses eight lines",
    wrong: "a reorder buffer that holds a whole fragment's lines before it lets one go waits for ever when there are more of them",
    run: deadlock,
};

/// Requests asked.
const REQUESTS: usize = 64;

/// Fragments that leave a pipeline which gives up a place in the reorder buffer only when the whole fragment has its lines.
fn finished(misses_of_each: usize, places: usize) -> usize {
    let (mut taken, mut finished) = (0, 0);
    for _ in 0..REQUESTS {
        for _ in 0..misses_of_each {
            if taken == places {
                return finished; // nobody will ever make room
            }
            taken += 1;
        }
        taken -= misses_of_each;
        finished += 1;
    }
    finished
}

fn deadlock(_: &Options) -> Result<Vec<Row>> {
    // Far apart, so that every texel of both levels is a line of its own.
    let machine = Machine::default().with_settings(&["texture.layout=row-major".into(), "cache.line=4".into()])?;
    let top = lab::picture([1024, 1024], |x, y| (x ^ y) as u8);
    let held = machine.texture.hold(PyramidKind::Mipmap, &top.into())?;
    let sampler = machine.sampler(Filter::Trilinear, [AddressMode::Wrap; 2], LodSource::Explicit);
    let requests: Vec<Request> = (0..REQUESTS as i32)
        .map(|number| {
            let [u, v] = [number << 14, (number * 7 % 64) << 14].map(I12F20::from_bits);
            Request { scale: [128, 0], ..Request::at(u, v) }
        })
        .collect();
    let mut rows = Vec::new();
    for places in [4, 5, 8, 32] {
        let machine = machine.with_settings(&[format!("timing.reorder-buffer={places}")])?;
        let timed = time_requests(&machine, &sampler, &held.memory, &requests)?;
        rows.push(Row {
            input: format!("trilinear, 8 misses a request, a reorder buffer of {places}: requests answered"),
            unit: "requests",
            careless: finished(8, places) as f64,
            ours: timed.counters.requests as f64,
            ideal: REQUESTS as f64,
            allowed: 0.0,
        });
    }
    // What cannot work is refused before it runs.
    for places in [1, 2, 3] {
        let tight = machine.with_settings(&[format!("timing.reorder-buffer={places}")]);
        let refused = match tight {
            Ok(machine) => time_requests(&machine, &sampler, &held.memory, &requests).is_err(),
            Err(_) => true,
        };
        rows.push(Row {
            input: format!("a reorder buffer of {places}, less than one tap can miss: refused"),
            unit: "machines",
            careless: 0.0,
            ours: f64::from(u8::from(refused)),
            ideal: 1.0,
            allowed: 0.0,
        });
    }
    Ok(rows)
}

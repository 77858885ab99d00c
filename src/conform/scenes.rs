//! Every sample of a scene, as the chip answers it, before the judge.

use rayon::prelude::*;
use serde::Serialize;
use texunit_hw::{
    AddressMode, Filter, LodSource, PyramidKind, Response, Unit,
    peers::{Arithmetic, Blend},
};

use super::{Judge, Precision, Sample, Sampling, Verdict};
use crate::{
    error::{Error, Result},
    front_end::FrontEnd,
    lod_rules::polygon::LevelPer,
    machine::Machine,
    names::Named,
    peers::{Mipmap, coordinate, to_8_bits},
    pyramid::Pyramid,
    scene::{Fragment, Gradient, Norm, Scene},
    texture_memory::Held,
};

/// Which levels are right.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LevelRule {
    /// The level of the machine's own norm, and no other.
    #[default]
    Norm,
    /// Any between the limits the suite sets for a derivative: from log2 of the largest component to log2 of sqrt(2) times the sum of
    /// the largest of u and the largest of v (OpenGL allows the sum without the root).
    Suite,
}

/// What was found of one filter on one scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// The scene.
    pub scene: String,
    /// The filter.
    pub filter: &'static str,
    /// Samples judged.
    pub samples: u64,
    /// Those refused.
    pub refused: u64,
    /// Those there was nothing to say about: coordinates so large that they select any texel.
    pub undecided: u64,
    /// How far the worst refused answer lies from the allowed ones, at least, in units of the last bit.
    pub worst: f64,
    /// The first refused, and the worst.
    pub explained: Vec<String>,
}

impl Finding {
    /// Of answers, in the order they are in.
    #[must_use]
    pub fn of(
        scene: &str,
        filter: Filter,
        judge: &Judge<'_>,
        samples: &[Sample],
        name: impl Fn(usize) -> String,
    ) -> Self {
        let verdicts: Vec<Verdict> = samples.par_iter().map(|sample| judge.verdict(sample)).collect();
        let mut finding = Self {
            scene: scene.to_owned(),
            filter: filter.name(),
            samples: samples.len() as u64,
            refused: 0,
            undecided: 0,
            worst: 0.0,
            explained: Vec::new(),
        };
        let mut first = None;
        let mut worst = None;
        for (number, verdict) in verdicts.iter().enumerate() {
            match *verdict {
                Verdict::Allowed => {}
                Verdict::Undecided => finding.undecided += 1,
                Verdict::Refused { off, .. } => {
                    finding.refused += 1;
                    first.get_or_insert(number);
                    if off > finding.worst {
                        finding.worst = off;
                        worst = Some(number);
                    }
                }
            }
        }
        let shown = first.into_iter().chain(worst.filter(|worst| Some(*worst) != first));
        finding.explained = shown
            .filter_map(|number| Some(format!("{}: {}", name(number), judge.explain(&samples[number])?)))
            .collect();
        finding
    }
}

/// What the judge is to know of a machine.
#[must_use]
pub fn sampling(machine: &Machine, filter: Filter, address: [AddressMode; 2]) -> Sampling {
    let lod = &machine.lod;
    Sampling { filter, address, bias: lod.bias, min_lod: lod.min, max_lod: lod.max }
}

/// Smallest and largest right level of a gradient in texels.
#[must_use]
pub fn right_levels(rule: LevelRule, norm: Norm, texels: Gradient) -> [f64; 2] {
    match rule {
        LevelRule::Norm => [libm::log2(f64::from(norm.squared_ratio(texels))) / 2.0; 2],
        LevelRule::Suite => {
            let [u, v] = [[texels.ux, texels.uy], [texels.vx, texels.vy]].map(|[x, y]| x.abs().max(y.abs()));
            [libm::log2(u.max(v)), libm::log2(std::f64::consts::SQRT_2 * (u + v))]
        }
    }
}

/// The answers of the chip to fragments, as samples.
///
/// # Errors
/// A machine that cannot be built.
pub fn answers(
    machine: &Machine,
    held: &Held,
    front_end: &FrontEnd,
    fragments: &[Fragment],
    rule: LevelRule,
) -> Result<Vec<Sample>> {
    let (requests, _) = front_end.requests(fragments);
    let sampler = machine.sampler(front_end.filter, front_end.address, LodSource::Gradient);
    let mut unit = Unit::new(&sampler, &held.memory.surface, &held.memory.bytes)
        .map_err(|error| Error::setting("machine", &machine.name, error.to_string(), "see texunit explain"))?;
    let mut responses = vec![Response::default(); requests.len()];
    unit.run(&requests, &mut responses, &mut ());
    let sample = |(fragment, response): (&Fragment, &Response)| Sample {
        at: [fragment.u, fragment.v],
        level: right_levels(rule, machine.lod.norm, fragment.gradient.in_texels(front_end.size)),
        texel: response.texel,
    };
    Ok(fragments.iter().zip(&responses).map(sample).collect())
}

/// The front end a machine has for a filter of a mipmap.
///
/// # Errors
/// A machine with one level for all pixels of a shape: no API allows that.
pub fn front_end(machine: &Machine, filter: Filter, address: [AddressMode; 2], pyramid: &Pyramid) -> Result<FrontEnd> {
    if let LevelPer::Polygon(_) = machine.lod.per {
        let problem = "one level for all pixels of a shape, which no API allows";
        return Err(Error::setting("lod.per", machine.lod.per.name(), problem, "use lod.per=pixel"));
    }
    Ok(FrontEnd::new(machine, filter, address, [pyramid.width, pyramid.height]))
}

/// Judges every fragment of a scene, filter by filter.
///
/// # Errors
/// Filters without a rule; a machine that cannot be built.
pub fn judge_scene(
    machine: &Machine,
    scene: &Scene,
    filters: &[Filter],
    precision: Precision,
    rule: LevelRule,
    done: impl FnMut(&Finding),
) -> Result<Vec<Finding>> {
    judge(machine, scene, filters, precision, done, |held, fragments, filter| {
        let front_end = front_end(machine, filter, scene.texture.wrap, &held.pyramid)?;
        Ok((filter.name().into(), answers(machine, held, &front_end, fragments, rule)?))
    })
}

/// The same of the arithmetic of another machine, behind this one's front end: bilinear, and trilinear where it blends levels.
///
/// # Errors
/// Other filters.
pub fn judge_peer(
    peer: &Arithmetic,
    scene: &Scene,
    filters: &[Filter],
    precision: Precision,
    rule: LevelRule,
    done: impl FnMut(&Finding),
) -> Result<Vec<Finding>> {
    let machine = Machine::default();
    judge(&machine, scene, filters, precision, done, |held, fragments, filter| {
        peer_filter(peer, filter)?;
        let sample = |fragment: &Fragment| {
            let texels = fragment.gradient.in_texels([held.pyramid.width, held.pyramid.height]);
            let ratio = libm::sqrt(f64::from(machine.lod.norm.squared_ratio(texels))) as f32;
            let level = right_levels(rule, machine.lod.norm, texels);
            peer_sample(peer, &held.pyramid, filter, [fragment.u, fragment.v], (ratio, level), scene.texture.wrap)
        };
        Ok((format!("{} of {}", filter.name(), peer.name), fragments.par_iter().map(sample).collect()))
    })
}

/// `answer` gives, for a filter, who answers and the samples of the fragments.
fn judge(
    machine: &Machine,
    scene: &Scene,
    filters: &[Filter],
    precision: Precision,
    mut done: impl FnMut(&Finding),
    answer: impl Fn(&Held, &[Fragment], Filter) -> Result<(String, Vec<Sample>)>,
) -> Result<Vec<Finding>> {
    let held = machine.texture.hold(PyramidKind::Mipmap, &scene.texture.texture_image())?;
    let fragments: Vec<Fragment> = scene.fragments().collect();
    let mut findings = Vec::new();
    for &filter in filters {
        let judge = Judge::new(&held.pyramid, sampling(machine, filter, scene.texture.wrap), precision)?;
        let (who, samples) = answer(&held, &fragments, filter)?;
        let name = |number: usize| {
            let Fragment { x, y, .. } = fragments[number];
            format!("{}, {who}, pixel ({x}, {y})", scene.name)
        };
        let finding = Finding::of(&scene.name, filter, &judge, &samples, name);
        done(&finding);
        findings.push(finding);
    }
    Ok(findings)
}

/// The filters the arithmetic of another machine has.
///
/// # Errors
/// Another filter, with those.
pub fn peer_filter(peer: &Arithmetic, filter: Filter) -> Result<()> {
    let trilinear = peer.blend != Blend::None;
    if filter == Filter::Bilinear || filter == Filter::Trilinear && trilinear {
        return Ok(());
    }
    let remedy = if trilinear { "use bilinear or trilinear" } else { "use bilinear: it blends no levels" };
    Err(Error::setting("--filters", filter.name(), format!("not in the arithmetic of {}", peer.name), remedy))
}

/// What another machine answers; `lod` is the ratio it is given and the levels that are right, of which bilinear reads none.
#[must_use]
pub fn peer_sample(
    peer: &Arithmetic,
    pyramid: &Pyramid,
    filter: Filter,
    at: [f64; 2],
    lod: (f32, [f64; 2]),
    address: [AddressMode; 2],
) -> Sample {
    let (ratio, level) = if filter == Filter::Trilinear { lod } else { (1.0, [0.0; 2]) };
    let colour = peer.sample(&Mipmap(pyramid), at.map(coordinate), ratio.to_bits(), address);
    Sample { at, level, texel: to_8_bits(peer, colour) }
}

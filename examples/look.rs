use texunit::scene::*;
fn main() {
    for name in Scene::builtin_names() {
        let scene = Scene::builtin(name).unwrap();
        let t = std::time::Instant::now();
        let truth = GroundTruth::render(&scene, &scene.texture.image());
        let s = t.elapsed();
        truth.image().save(format!("/tmp/wb/{name}.png")).unwrap();
        let mut aniso = [0f64; 2];
        let mut n = 0f64;
        let mut lod = vec![];
        for f in scene.fragments() {
            let g = f.gradient.in_texels(scene.texture.size());
            let [a, b] = AxisRule::TextureAxes.squared_ratios(g);
            aniso[0] += (a as f64).log2() / 2.;
            aniso[1] += (b as f64).log2() / 2.;
            n += 1.;
            lod.push((Norm::Sigma1.squared_ratio(g) as f64).log2() / 2.);
        }
        lod.sort_by(|a, b| a.total_cmp(b));
        let q = |p: f64| lod[((lod.len() - 1) as f64 * p) as usize];
        println!(
            "{name}: {s:?} {:?} mean lod u {:.2} v {:.2}  sigma1 lod {:.2} {:.2} {:.2} {:.2} {:.2}",
            scene.coverage(),
            aniso[0] / n,
            aniso[1] / n,
            q(0.),
            q(0.1),
            q(0.5),
            q(0.9),
            q(1.)
        );
    }
    for order in [PixelOrder::Scanline, PixelOrder::Tiles, PixelOrder::Morton] {
        for method in [GradientMethod::Analytic, GradientMethod::Quad] {
            let mut scene = Scene::builtin("floor").unwrap();
            scene.size = [1920, 1080];
            scene.order = order;
            scene.gradient = method;
            scene.tile = 8;
            let t = std::time::Instant::now();
            let mut sum = 0.;
            let c = scene.for_each_block(|b| {
                for f in b {
                    sum += f.u + f.gradient.vy;
                }
            });
            println!(
                "{order:?} {method:?} {:.1} M fragments/s {sum}",
                c.covered as f64 / t.elapsed().as_secs_f64() / 1e6
            );
        }
    }
}

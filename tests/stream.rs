//! Requests from elsewhere: files of requests and meshes, against scenes and caches told one by one.

use std::{fs, path::Path, process::Command};

use image::{Rgba, RgbaImage};
use texunit::{
    experiment::{Bench, Pyramids, Stage},
    machine::Machine,
    scene::{Camera, Rotation, Scene},
    stream::{
        NamedTexture, Stream, StreamRequest, StreamRun,
        mesh::{Corner, Mesh, Triangle},
        raster::rasterize,
        requests_file,
    },
    texture_file::TextureImage,
};
use texunit_hw::{AddressMode, Filter};

/// A scene's fragments as a stream of its texture.
fn stream_of(stage: &Stage) -> Stream {
    let requests = stage.fragments.iter().map(|&fragment| StreamRequest { fragment, texture: 0, filter: None });
    Stream {
        textures: vec![NamedTexture { name: "it".into(), image: stage.texture.clone() }],
        requests: requests.collect(),
        size: Some(stage.scene.size),
    }
}

fn small(name: &str) -> Stage {
    Stage::new(Scene { size: [96, 72], ..Scene::builtin(name).unwrap() })
}

#[test]
fn the_stream_of_a_scene_is_the_scene() {
    let machine = Machine::default();
    let stage = small("floor");
    let stream = stream_of(&stage);
    for filter in [Filter::Trilinear, Filter::Dipmap, Filter::Feline, Filter::Sat] {
        let pyramids = Pyramids::for_filters(&machine, &stage.texture, &[filter]).unwrap();
        let (pyramid, memory) = pyramids.of(filter);
        let scene = Bench::new(&stage, &machine, filter, pyramid, memory).measure(&machine).unwrap();
        let run = StreamRun::new(&stream, &machine, filter, stage.scene.texture.wrap).unwrap();
        let outcome = run.measure().unwrap();
        assert_eq!(outcome.responses, scene.responses, "{filter:?}");
        assert_eq!(outcome.counters, scene.counters, "{filter:?}");
        assert_eq!(outcome.timing, scene.timed.unwrap().counters, "{filter:?}");
        assert_eq!((outcome.mismatches, outcome.parts.len()), (0, 1));
        assert_eq!(outcome.parts[0].traffic.misses, outcome.counters.misses);
    }
}

#[test]
fn textures_and_filters_share_one_cache_and_are_counted_apart() {
    let machine = Machine::default();
    let stages = ["rectangle-natural", "rectangle-pane"].map(small);
    let filters = [Filter::Bilinear, Filter::Trilinear, Filter::Dipmap];
    let textures =
        stages.iter().map(|stage| NamedTexture { name: stage.scene.name.clone(), image: stage.texture.clone() });
    let mut stream = Stream { textures: textures.collect(), ..Stream::default() };
    // Interleaved, so that runs of equal requests are short.
    for (number, (a, b)) in stages[0].fragments.iter().zip(&stages[1].fragments).enumerate() {
        let filter = Some(filters[number / 5 % 3]);
        stream.requests.push(StreamRequest { fragment: *a, texture: 0, filter });
        stream.requests.push(StreamRequest { fragment: *b, texture: 1, filter });
    }
    let run = StreamRun::new(&stream, &machine, Filter::Point, [AddressMode::Wrap; 2]).unwrap();
    let outcome = run.measure().unwrap();
    assert_eq!((outcome.mismatches, outcome.parts.len()), (0, 6));
    let sum = |of: fn(&texunit::stream::PartOutcome) -> u64| outcome.parts.iter().map(of).sum::<u64>();
    assert_eq!(sum(|part| part.traffic.lookups), outcome.counters.lookups);
    assert_eq!(sum(|part| part.traffic.misses), outcome.counters.misses);
    assert_eq!(sum(|part| part.requests), stream.requests.len() as u64);
    assert_eq!(outcome.timing.requests, stream.requests.len() as u64);
    // Each answer is that of the texture alone.
    for texture in [0, 1] {
        let only: Vec<_> = stream.requests.iter().copied().filter(|request| request.texture == texture).collect();
        let alone = Stream { requests: only, ..stream.clone() };
        let answers =
            StreamRun::new(&alone, &machine, Filter::Point, [AddressMode::Wrap; 2]).unwrap().measure().unwrap();
        let mixed = stream.requests.iter().zip(&outcome.responses).filter(|(request, _)| request.texture == texture);
        assert!(mixed.map(|(_, response)| response).eq(&answers.responses));
    }
}

#[test]
fn a_filter_with_wider_entries_needs_a_stream_of_its_own() {
    let mut stream = stream_of(&small("magnified"));
    stream.requests[0].filter = Some(Filter::Sat);
    let error = StreamRun::new(&stream, &Machine::default(), Filter::Point, [AddressMode::Wrap; 2]).unwrap_err();
    assert!(error.to_string().contains("sat"), "{error}");
}

/// A rectangle of two triangles, wound either way.
fn rectangle(size: [f64; 2], turn: Rotation, away: [f64; 3]) -> Mesh {
    let corner = |u: f64, v: f64| {
        let flat = glam::dvec3((u - 0.5) * size[0], (0.5 - v) * size[1], 0.0);
        Corner { position: turn.matrix() * flat + glam::DVec3::from_array(away), uv: glam::dvec2(u, v) }
    };
    let [a, b, c, d] = [corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)];
    let triangles = vec![Triangle { corners: [a, b, c], texture: 0 }, Triangle { corners: [a, d, c], texture: 0 }];
    Mesh { triangles, textures: vec![] }
}

#[test]
fn two_triangles_have_the_fragments_of_their_rectangle() {
    let scene = Scene { size: [160, 120], ..Scene::builtin("rectangle-natural").unwrap() };
    let texunit::scene::Shape::Rectangle(shape) = scene.shape else { unreachable!() };
    let mesh = rectangle(shape.size, shape.pose.rotation, shape.pose.translation);
    let stream = rasterize(mesh, scene.camera, scene.size);
    let mut found: Vec<_> = stream.requests.iter().map(|request| request.fragment).collect();
    found.sort_by_key(|fragment| (fragment.y, fragment.x));
    let mut expected: Vec<_> = scene.fragments().collect();
    expected.sort_by_key(|fragment| (fragment.y, fragment.x));
    assert!(expected.len() > 1000);
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(&expected) {
        assert_eq!((found.x, found.y), (expected.x, expected.y));
        let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
        assert!(near(found.u, expected.u) && near(found.v, expected.v), "{found:?} {expected:?}");
        assert!(near(found.gradient.ux, expected.gradient.ux) && near(found.gradient.vy, expected.gradient.vy));
        assert!(near(found.gradient.uy, expected.gradient.uy) && near(found.gradient.vx, expected.gradient.vx));
    }
}

#[test]
fn what_is_nearer_hides_what_comes_later_and_what_is_behind_the_eye_is_not_seen() {
    let camera = Camera { field_of_view: 60.0 };
    let flat = Rotation::Euler([0.0; 3]);
    let mut mesh = rectangle([1.0, 1.0], flat, [0.0, 0.0, -2.0]);
    let front = rasterize(mesh.clone(), camera, [64, 64]).requests.len();
    mesh.triangles.extend(rectangle([1.0, 1.0], flat, [0.0, 0.0, -4.0]).triangles);
    mesh.triangles.extend(rectangle([1.0, 1.0], flat, [0.0, 0.0, 4.0]).triangles);
    assert!(front > 100);
    assert_eq!(rasterize(mesh, camera, [64, 64]).requests.len(), front);
    // A floor that passes under the eye covers the lower half of the picture, to the horizon.
    let floor = rectangle([1e4, 1e4], Rotation::Euler([-90.0, 0.0, 0.0]), [0.0, -1.0, 0.0]);
    let stream = rasterize(floor, camera, [64, 64]);
    assert_eq!(stream.requests.len(), 64 * 32);
    assert!(stream.requests.iter().all(|request| request.fragment.y >= 32));
}

fn write_texture(path: &Path, colour: [u8; 4]) {
    RgbaImage::from_fn(8, 8, |x, y| if (x + y) % 2 == 0 { Rgba(colour) } else { Rgba([0, 0, 0, 255]) })
        .save(path)
        .unwrap();
}

fn texunit(folder: &Path, args: &[&str]) -> (i32, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_texunit")).current_dir(folder).args(args).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

#[test]
fn a_file_of_requests_drives_the_unit_from_the_command_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_texture(&path.join("brick.png"), [200, 80, 60, 255]);
    write_texture(&path.join("grass.png"), [60, 160, 40, 255]);
    let rows = "x,y,texture,u,v,dudx,dvdx,dudy,dvdy,filter\n\
                0,0,brick.png,0.1,0.2,0.01,0,0,0.01,\n\
                1,0,lawn,0.5,0.5,0.5,0,0,0.5,point\n\
                1,1,lawn,NaN,0.5,0.5,0,0,0.5,dipmap\n";
    fs::write(path.join("requests.csv"), rows).unwrap();
    let command = [
        "stream",
        "--requests",
        "requests.csv",
        "--texture",
        "lawn=grass.png",
        "-f",
        "bilinear,trilinear",
        "-o",
        "out",
    ];
    let (code, told, _) = texunit(path, &command);
    assert_eq!(code, 0);
    assert!(
        told.contains("brick.png") && told.contains("lawn") && told.contains("1 coordinates without a place"),
        "{told}"
    );
    let answers = fs::read_to_string(path.join("out/answers-trilinear.csv")).unwrap();
    assert_eq!(answers.lines().count(), 4);
    let picture = image::open(path.join("out/bilinear.png")).unwrap().to_rgba8();
    assert_eq!(picture.dimensions(), (2, 2));
    assert_eq!(picture.get_pixel(1, 0).0, [60, 160, 40, 255]);
    assert!(path.join("out/stream.json").exists() && path.join("out/stream.csv").exists());
}

#[test]
fn bad_requests_are_refused_with_their_row() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_texture(&path.join("brick.png"), [200, 80, 60, 255]);
    let header = "texture,u,v,dudx,dvdx,dudy,dvdy,filter\n";
    let cases = [
        (format!("{header}brick.png,0,0,0,0,0,0,\nbrick.png,0,zero,0,0,0,0,\n"), "line 3"),
        (format!("{header}brick.png,0,0,0,0,0,0,\nbrick.png,0,0\n"), "line 3"),
        (format!("{header}wall.png,0,0,0,0,0,0,\n"), "wall.png"),
        (format!("{header}brick.png,0,0,0,0,0,0,trilinaer\n"), "trilinaer"),
        (format!("{header},0,0,0,0,0,0,\n"), "names no texture"),
        (header.to_owned(), "there is no request"),
        ("texture,u,v,dudx,dvdx,dudy\nbrick.png,0,0,0,0,0\n".to_owned(), "dvdy"),
        ("texture,u,v,dudx,dvdx,dudy,dvdy,fliter\nbrick.png,0,0,0,0,0,0,point\n".to_owned(), "fliter"),
    ];
    for (text, expected) in cases {
        fs::write(path.join("requests.csv"), &text).unwrap();
        let error = requests_file::load(&path.join("requests.csv"), &[]).unwrap_err().to_string();
        assert!(error.contains("requests.csv") && error.contains(expected), "{text}: {error}");
    }
}

#[test]
fn a_mesh_is_drawn_with_the_textures_of_its_materials() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_texture(&path.join("brick.png"), [200, 80, 60, 255]);
    fs::write(path.join("box.mtl"), "newmtl wall\nmap_Kd brick.png\nnewmtl lid\nKd 0.0 0.5 1.0\n").unwrap();
    let corners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 1 -1\nv 1 1 -1\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";
    let faces = "usemtl wall\nf 1/1 2/2 3/3 4/4\nusemtl lid\nf 4/1 3/2 6/3 5/4\n";
    fs::write(path.join("box.obj"), format!("mtllib box.mtl\no box\n{corners}{faces}")).unwrap();
    let (code, told, error) =
        texunit(path, &["stream", "--mesh", "box.obj", "--turn", "30,20,0", "--size", "64x48", "-o", "out"]);
    assert_eq!(code, 0, "{error}");
    assert!(told.contains("wall") && told.contains("lid") && told.contains("0 mismatches"), "{told}");
    let picture = image::open(path.join("out/trilinear.png")).unwrap().to_rgba8();
    assert!(picture.pixels().any(|pixel| pixel.0 == [0, 128, 255, 255]), "the lid is seen");

    for (text, expected) in [
        ("v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n", "no texture coordinates"),
        ("v 0 0 0\n", "no face"),
        ("v 0 0\nf 1 2 3\n", "bad.obj"),
        ("v 0 0 0\nv 1 0 0\nvt 0 0\nf 1/1 2/1 9/1\n", "bad.obj"),
    ] {
        fs::write(path.join("bad.obj"), text).unwrap();
        let (code, _, error) = texunit(path, &["stream", "--mesh", "bad.obj"]);
        assert!(code == 2 && error.contains(expected), "{text}: {error}");
    }
    let (code, _, error) = texunit(path, &["stream", "--mesh", "absent.obj"]);
    assert!(code == 2 && error.contains("absent.obj"), "{error}");
}

#[test]
fn a_texture_without_a_request_takes_no_memory() {
    let stage = small("magnified");
    let mut stream = stream_of(&stage);
    let machine = Machine::default();
    let alone = StreamRun::new(&stream, &machine, Filter::Bilinear, [AddressMode::Wrap; 2]).unwrap();
    let memory = alone.measure().unwrap().memory;
    stream.textures.push(NamedTexture { name: "other".into(), image: TextureImage::clone(&stage.texture) });
    let both = StreamRun::new(&stream, &machine, Filter::Bilinear, [AddressMode::Wrap; 2]).unwrap();
    assert_eq!(both.measure().unwrap().memory, memory);
}

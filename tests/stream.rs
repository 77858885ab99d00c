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

#[test]
fn what_the_obj_loader_would_compute_with_unchecked_is_refused_with_its_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bad.obj");
    let corners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\n";
    for (faces, expected) in [
        ("f 1/1 2/2 3", "line 7: `3` has no texture coordinates"),
        ("f 1/1 2/2 /3", "line 7"),
        ("f 1/1 2/2 -4/3", "line 7"),
        ("f 1/1 2/2 9223372036854775807/3", "line 7"),
        ("f 1/1 2/2 3/-9223372036854775808", "line 7"),
        ("f 0/1 2/2 3/3", "line 7"),
    ] {
        fs::write(&path, format!("{corners}{faces}\n")).unwrap();
        let error = Mesh::load(&path).unwrap_err().to_string();
        assert!(error.contains("bad.obj") && error.contains(expected), "{faces}: {error}");
    }
    fs::write(folder.path().join("bad.mtl"), "newmtl wall\nKd 0.5 0.5\n").unwrap();
    fs::write(&path, format!("mtllib bad.mtl\n{corners}f -3/-3 -2/-2 -1/-1\n")).unwrap();
    let error = Mesh::load(&path).unwrap_err().to_string();
    assert!(error.contains("bad.mtl") && error.contains("line 2"), "{error}");
    fs::write(folder.path().join("bad.mtl"), "newmtl wall\nKd 0.5 0.5 1\n").unwrap();
    assert_eq!(Mesh::load(&path).unwrap().triangles.len(), 1);
}

#[test]
fn a_pixel_that_no_picture_has_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("requests.csv");
    write_texture(&folder.path().join("brick.png"), [200, 80, 60, 255]);
    let header = "x,y,texture,u,v,dudx,dvdx,dudy,dvdy\n";
    fs::write(&path, format!("{header}16383,0,brick.png,0,0,0,0,0,0\n")).unwrap();
    assert_eq!(requests_file::load(&path, &[]).unwrap().size, Some([16384, 1]));
    fs::write(&path, format!("{header}0,16384,brick.png,0,0,0,0,0,0\n")).unwrap();
    let error = requests_file::load(&path, &[]).unwrap_err().to_string();
    assert!(error.contains("row 1") && error.contains("16384"), "{error}");
}

#[cfg(not(feature = "gltf"))]
#[test]
fn without_its_feature_gltf_is_refused_by_name() {
    let error = Mesh::load(Path::new("model.glb")).unwrap_err().to_string();
    assert!(error.contains("--features gltf"), "{error}");
}

#[cfg(feature = "parquet")]
#[test]
fn requests_in_parquet_are_those_in_csv() {
    use std::sync::Arc;

    use parquet::{
        data_type::{ByteArray, ByteArrayType, DoubleType, Int32Type},
        file::{properties::WriterProperties, writer::SerializedFileWriter},
        schema::parser::parse_message_type,
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_texture(&path.join("brick.png"), [200, 80, 60, 255]);
    let rows = [
        [0.1, 0.2, 0.01, 0.0, 0.0, 0.01],
        [f64::NAN, 0.5, 0.3, -0.25, 1e-300, 0.1],
        [1.0 / 3.0, -2.5, 0.0, 0.0, 0.0, 1e9],
    ];
    let names = ["brick.png", "brick.png", "brick.png"];
    let filters = [None, Some("point"), Some("dipmap")];
    let mut csv = "x,y,texture,u,v,dudx,dvdx,dudy,dvdy,filter\n".to_owned();
    for (number, row) in rows.iter().enumerate() {
        let numbers = row.map(|value| value.to_string()).join(",");
        csv += &format!("{number},{},{},{numbers},{}\n", 2 * number, names[number], filters[number].unwrap_or(""));
    }
    fs::write(path.join("requests.csv"), csv).unwrap();
    let schema = "message requests { required int32 x; required int32 y; required binary texture (UTF8); required double u; \
                  required double v; required double dudx; required double dvdx; required double dudy; required double dvdy; \
                  optional binary filter (UTF8); }";
    let file = fs::File::create(path.join("requests.parquet")).unwrap();
    let schema = Arc::new(parse_message_type(schema).unwrap());
    let mut writer = SerializedFileWriter::new(file, schema, Arc::new(WriterProperties::default())).unwrap();
    let mut group = writer.next_row_group().unwrap();
    for step in [1, 2] {
        let mut column = group.next_column().unwrap().unwrap();
        column.typed::<Int32Type>().write_batch(&[0, step, 2 * step], None, None).unwrap();
        column.close().unwrap();
    }
    let text = |text: &str| ByteArray::from(text);
    let mut column = group.next_column().unwrap().unwrap();
    column.typed::<ByteArrayType>().write_batch(&names.map(text), None, None).unwrap();
    column.close().unwrap();
    for number in 0..6 {
        let mut column = group.next_column().unwrap().unwrap();
        column.typed::<DoubleType>().write_batch(&rows.map(|row| row[number]), None, None).unwrap();
        column.close().unwrap();
    }
    let mut column = group.next_column().unwrap().unwrap();
    let there: Vec<_> = filters.iter().flatten().map(|name| text(name)).collect();
    column.typed::<ByteArrayType>().write_batch(&there, Some(&[0, 1, 1]), None).unwrap();
    column.close().unwrap();
    group.close().unwrap();
    writer.close().unwrap();

    let [csv, parquet] =
        ["requests.csv", "requests.parquet"].map(|name| requests_file::load(&path.join(name), &[]).unwrap());
    // As text: NaN is not equal to itself.
    assert_eq!(format!("{:?}", csv.requests), format!("{:?}", parquet.requests));
    assert_eq!((csv.requests.len(), csv.size), (3, parquet.size));
    let answers = |stream: &Stream| {
        StreamRun::new(stream, &Machine::default(), Filter::Trilinear, [AddressMode::Wrap; 2])
            .unwrap()
            .measure()
            .unwrap()
            .responses
    };
    assert_eq!(answers(&csv), answers(&parquet));
    fs::write(path.join("cut.parquet"), &fs::read(path.join("requests.parquet")).unwrap()[..100]).unwrap();
    let error = requests_file::load(&path.join("cut.parquet"), &[]).unwrap_err().to_string();
    assert!(error.contains("cut.parquet"), "{error}");
}

#[cfg(feature = "gltf")]
mod gltf {
    use base64::{Engine, engine::general_purpose::STANDARD};
    use serde_json::{Value, json};

    use super::*;

    /// Two triangles of a unit square: positions, coordinates (v down), indices.
    fn buffer() -> Vec<u8> {
        let positions: [f32; 12] = [0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.];
        let coordinates: [f32; 8] = [0., 1., 1., 1., 1., 0., 0., 0.];
        let mut bytes: Vec<u8> = positions.iter().chain(&coordinates).flat_map(|value| value.to_le_bytes()).collect();
        bytes.extend([0_u16, 1, 2, 0, 2, 3].iter().flat_map(|index| index.to_le_bytes()));
        bytes
    }

    /// The square turned by a quarter about x, made twice as wide, and moved, through a node and its child.
    fn model() -> Value {
        let half = std::f32::consts::FRAC_1_SQRT_2;
        json!({
            "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }],
            "nodes": [
                { "children": [1], "rotation": [half, 0, 0, half], "translation": [5, 6, 7] },
                { "mesh": 0, "matrix": [2,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,3,1] },
            ],
            "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "TEXCOORD_1": 1 }, "indices": 2, "material": 0 }] }],
            "materials": [{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0, "texCoord": 1 } } }],
            "textures": [{ "source": 0 }], "images": [{ "uri": "brick%20wall.png" }],
            "accessors": [
                { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0,0,0], "max": [1,1,0] },
                { "bufferView": 0, "byteOffset": 48, "componentType": 5126, "count": 4, "type": "VEC2" },
                { "bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR" },
            ],
            "bufferViews": [{ "buffer": 0, "byteLength": 80 }, { "buffer": 0, "byteOffset": 80, "byteLength": 12 }],
            "buffers": [{ "byteLength": 92, "uri": data("application/octet-stream", &buffer()) }],
        })
    }

    fn data(kind: &str, bytes: &[u8]) -> String {
        format!("data:{kind};base64,{}", STANDARD.encode(bytes))
    }

    fn with(place: &str, value: Value) -> Value {
        let mut model = model();
        *model.pointer_mut(place).unwrap_or_else(|| panic!("{place}")) = value;
        model
    }

    fn load(path: &Path, model: &Value) -> texunit::error::Result<Mesh> {
        fs::write(path.join("a.gltf"), model.to_string()).unwrap();
        Mesh::load(&path.join("a.gltf"))
    }

    #[test]
    fn a_mesh_in_gltf_has_the_fragments_of_the_same_mesh_in_obj() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path();
        write_texture(&path.join("brick wall.png"), [200, 80, 60, 255]);
        let png = fs::read(path.join("brick wall.png")).unwrap();
        // (x, y, z) becomes (2x + 5, -3 + 6, y + 7): turned, y goes to z and z to -y.
        fs::write(path.join("a.mtl"), "newmtl wall\nmap_Kd brick wall.png\n").unwrap();
        let obj = "mtllib a.mtl\nv 5 3 7\nv 7 3 7\nv 7 3 8\nv 5 3 8\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl wall\n\
                   f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n";
        fs::write(path.join("a.obj"), obj).unwrap();
        let draw = |mut mesh: Mesh| {
            mesh.put_in_view(Rotation::Euler([70.0, 10.0, 0.0]).matrix(), 45.0);
            rasterize(mesh, Camera { field_of_view: 45.0 }, [96, 64])
        };
        let expected = draw(Mesh::load(&path.join("a.obj")).unwrap());
        assert!(expected.requests.len() > 500);

        // The same in a binary file, its image in a buffer view.
        let mut bytes = buffer();
        bytes.extend(&png);
        let mut inside = model();
        inside["buffers"] = json!([{ "byteLength": bytes.len() }]);
        inside["bufferViews"]
            .as_array_mut()
            .unwrap()
            .push(json!({ "buffer": 0, "byteOffset": 92, "byteLength": png.len() }));
        inside["images"] = json!([{ "bufferView": 2, "mimeType": "image/png" }]);
        let mut text = inside.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        bytes.resize(bytes.len().next_multiple_of(4), 0);
        let mut glb = b"glTF".to_vec();
        for word in [2, (28 + text.len() + bytes.len()) as u32, text.len() as u32] {
            glb.extend(word.to_le_bytes());
        }
        glb.extend([b"JSON".as_slice(), &text, &(bytes.len() as u32).to_le_bytes(), b"BIN\0", &bytes].concat());
        fs::write(path.join("a.glb"), &glb).unwrap();

        let embedded = with("/images/0", json!({ "uri": data("image/png", &png) }));
        let found =
            [load(path, &model()).unwrap(), load(path, &embedded).unwrap(), Mesh::load(&path.join("a.glb")).unwrap()];
        for mesh in found {
            let found = draw(mesh);
            assert_eq!((found.textures.len(), &found.textures[0].image), (1, &expected.textures[0].image));
            assert_eq!(found.requests.len(), expected.requests.len());
            for (found, expected) in found.requests.iter().zip(&expected.requests) {
                let numbers = |request: &StreamRequest| {
                    let fragment = request.fragment;
                    let gradient = fragment.gradient;
                    [fragment.u, fragment.v, gradient.ux, gradient.uy, gradient.vx, gradient.vy]
                };
                assert_eq!((found.fragment.x, found.fragment.y), (expected.fragment.x, expected.fragment.y));
                // A quarter turn is one in single precision only.
                assert!(numbers(found).iter().zip(numbers(expected)).all(|(a, b)| (a - b).abs() < 1e-6));
            }
        }
        let (code, told, error) = texunit(path, &["stream", "--mesh", "a.glb", "--turn", "70,0,0", "--size", "64x48"]);
        assert!(code == 0 && told.contains("0 mismatches"), "{told}{error}");

        // No binary file cut short is taken, nor does any make the reader panic.
        for length in 0..glb.len() {
            fs::write(path.join("cut.glb"), &glb[..length]).unwrap();
            assert!(Mesh::load(&path.join("cut.glb")).is_err(), "{length}");
        }
        glb[8..12].copy_from_slice(&4_u32.to_le_bytes());
        fs::write(path.join("cut.glb"), &glb).unwrap();
        assert!(Mesh::load(&path.join("cut.glb")).unwrap_err().to_string().contains("header"));
    }

    #[test]
    fn a_base_colour_without_a_texture_is_one_texel_of_its_srgb_code() {
        let folder = tempfile::tempdir().unwrap();
        // 0.2159 is code 128 of 255 (IEC 61966-2-1); alpha is no code.
        let plain =
            with("/materials/0", json!({ "pbrMetallicRoughness": { "baseColorFactor": [1.0, 0.2159, 0.0, 0.5] } }));
        let mesh = load(folder.path(), &plain).unwrap();
        assert_eq!(mesh.textures[0].image.top.texels, [[255, 128, 0, 128]]);
    }

    #[test]
    fn gltf_that_does_not_hold_together_is_refused_and_says_where() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path();
        write_texture(&path.join("brick wall.png"), [200, 80, 60, 255]);
        assert_eq!(load(path, &model()).unwrap().triangles.len(), 2);
        let huge = json!(u64::MAX);
        let mut required = model();
        required["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
        let mut strip = model();
        strip["meshes"][0]["primitives"][0]["mode"] = json!(5);
        let mut sparse = model();
        sparse["accessors"][1]["sparse"] =
            json!({ "count": 1, "indices": { "bufferView": 1, "componentType": 5123 }, "values": { "bufferView": 0 } });
        let mut stride = model();
        stride["bufferViews"][0]["byteStride"] = json!(4);
        for (model, expected) in [
            (required, "KHR_draco"),
            (strip, "TriangleStrip"),
            (sparse, "sparse"),
            (stride, "accessors[0]"),
            (with("/nodes/1", json!({ "children": [0] })), "reached twice"),
            (with("/nodes/1/mesh", json!(7)), "mesh"),
            (with("/scenes", json!([])), "scene"),
            (with("/meshes/0/primitives/0/attributes", json!({ "POSITION": 9 })), "accessors[9]"),
            (with("/meshes/0/primitives/0/attributes", json!({ "POSITION": 0, "TEXCOORD_0": 1 })), "TEXCOORD_1"),
            (with("/accessors/0/count", json!(1000)), "accessors[0]"),
            (with("/accessors/0/count", huge.clone()), "accessors[0]"),
            (with("/accessors/1/byteOffset", huge.clone()), "accessors[1]"),
            (with("/accessors/1/count", json!(3)), "4 positions and 3"),
            (with("/accessors/2/count", json!(5)), "5 corners"),
            (with("/accessors/2/count", json!(0)), "no triangle"),
            (with("/accessors/2/componentType", json!(5126)), "accessors[2]"),
            (with("/accessors/2/type", json!("MAT4")), "accessors[2]"),
            // The floats of the positions, read as indices.
            (
                with(
                    "/accessors/2",
                    json!({ "bufferView": 0, "byteOffset": 12, "componentType": 5123, "count": 6, "type": "SCALAR" }),
                ),
                "of 4 corners",
            ),
            (with("/bufferViews/0/byteLength", huge.clone()), "bufferViews[0]"),
            (with("/bufferViews/1/byteOffset", huge.clone()), "bufferViews[1]"),
            (with("/buffers/0/byteLength", huge), "buffers[0]"),
            (with("/buffers/0/uri", json!("data:;base64,@")), "base64"),
            (with("/buffers/0/uri", json!("data:text/plain,a")), "base64"),
            (with("/buffers/0/uri", json!("https://example.invalid/a.bin")), "no file of this computer"),
            (with("/buffers/0/uri", json!("absent.bin")), "absent.bin"),
            (with("/images/0", json!({})), "images[0]"),
            (with("/images/0", json!({ "bufferView": 1 })), "images[0]"),
            (with("/images/0", json!({ "bufferView": 1, "mimeType": "image/png" })), "images[0]"),
            (with("/images/0/uri", json!("absent.png")), "absent.png"),
            (with("/nodes/0/rotation", json!([0, 0, 0, 0])), "corner 0 is at"),
        ] {
            let error = load(path, &model).unwrap_err().to_string();
            assert!(error.contains(expected), "{expected}: {error}");
        }
    }
}

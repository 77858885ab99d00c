//! The corpora's files, made.

use std::{fs, io::Cursor, path::PathBuf};

use image::{DynamicImage, ImageFormat, Rgba, RgbaImage};

fn picture() -> RgbaImage {
    RgbaImage::from_fn(6, 4, |x, y| Rgba([(40 * x) as u8, (60 * y) as u8, ((x ^ y) * 30) as u8, 255 - (x * y) as u8]))
}

/// A KTX2 file without descriptors: RGBA8, as many levels as given.
fn ktx2(width: u32, height: u32, levels: &[Vec<u8>]) -> Vec<u8> {
    let start = 80 + 24 * levels.len() as u32;
    let mut bytes = ktx2::MAGIC.to_vec();
    for word in [37, 1, width, height, 0, 0, 1, levels.len() as u32, 0, start, 4, start + 4, 0] {
        bytes.extend(word.to_le_bytes());
    }
    bytes.extend([0; 16]);
    let mut offset = u64::from(start) + 4;
    for level in levels {
        for word in [offset, level.len() as u64, level.len() as u64] {
            bytes.extend(word.to_le_bytes());
        }
        offset += level.len() as u64;
    }
    bytes.extend(4_u32.to_le_bytes());
    bytes.extend(levels.concat());
    bytes
}

/// A DDS file with the old header: DXT1.
fn dds(width: u32, height: u32, levels: u32, data: &[u8]) -> Vec<u8> {
    let mut words = vec![124, 0x0002_1007, height, width, 8, 0, levels];
    words.extend([0; 11]);
    words.extend([32, 4, u32::from_le_bytes(*b"DXT1"), 0, 0, 0, 0, 0]);
    words.extend([0x0040_1008, 0, 0, 0, 0]);
    [b"DDS ".to_vec(), words.into_iter().flat_map(u32::to_le_bytes).collect(), data.to_vec()].concat()
}

/// The corpora, as they are made: the name says whether a reader is to take it.
pub fn made() -> Vec<(&'static str, String, Vec<u8>)> {
    let mut files: Vec<(&'static str, String, Vec<u8>)> = Vec::new();
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let read = |path: &str| fs::read(root.join(path)).unwrap();
    for scene in ["floor", "ellipsoid-natural", "walk"] {
        files.push(("scene", format!("good-{scene}"), read(&format!("scenes/{scene}.toml"))));
    }
    files.push(("scene", "bad-size".into(), b"size = [99999999999, -1]\n".to_vec()));
    for machine in ["herf-12.20", "mobile", "vortex"] {
        files.push(("machine", format!("good-{machine}"), read(&format!("hw/profiles/{machine}.toml"))));
    }
    files.push(("machine", "good-nothing".into(), Vec::new()));
    files.push(("machine", "bad-cache".into(), b"[cache]\nsets = 4294967295\nways = 4294967295\n".to_vec()));
    for trace in ["floor.trilinear", "ellipsoid.feline"] {
        let text = String::from_utf8(read(&format!("traces/{trace}.trace"))).unwrap();
        let head =
            text.lines().filter(|line| line.starts_with("//")).map(|line| line.replace("// count 64", "// count 2"));
        let records = text.lines().filter(|line| !line.starts_with("//")).take(2).map(str::to_owned);
        let lines: Vec<String> = head.chain(records).collect();
        files.push(("trace", format!("good-{trace}"), (lines.join("\n") + "\n").into_bytes()));
    }
    files.push(("trace", "bad-future".into(), b"// texunit trace 999\n".to_vec()));
    files.push(("coordinates", "good-levels".into(), b"u,v,lod\n0.5,0.25,1\n-1e300,NaN,inf\n".to_vec()));
    files.push(("coordinates", "good-gradients".into(), b"u,v,dudx,dvdx,dudy,dvdy\r\n0,1,2,3,4,5\r\n".to_vec()));
    files.push(("coordinates", "bad-columns".into(), b"u,u,v\n1,2,3\n".to_vec()));
    for (name, format) in [
        ("png", ImageFormat::Png),
        ("bmp", ImageFormat::Bmp),
        ("gif", ImageFormat::Gif),
        ("jpeg", ImageFormat::Jpeg),
        ("pnm", ImageFormat::Pnm),
        ("tga", ImageFormat::Tga),
    ] {
        let mut bytes = Cursor::new(Vec::new());
        let image = DynamicImage::ImageRgba8(picture());
        let image =
            if matches!(format, ImageFormat::Jpeg | ImageFormat::Pnm) { image.into_rgb8().into() } else { image };
        image.write_to(&mut bytes, format).unwrap();
        files.push(("texture", format!("good-{name}"), bytes.into_inner()));
    }
    let levels: Vec<Vec<u8>> = [24, 6, 2].iter().zip(0..).map(|(texels, seed)| vec![seed * 40; 4 * texels]).collect();
    files.push(("texture", "good-ktx2".into(), ktx2(6, 4, &levels[..2])));
    files.push(("texture", "good-dds".into(), dds(8, 4, 2, &[0x5A; 24])));
    files.push(("texture", "bad-nothing".into(), Vec::new()));
    files.push(("addresses", "good-binary".into(), (0..32_u64).flat_map(|n| (n * 64).to_le_bytes()).collect()));
    files.push(("addresses", "good-din".into(), b"0 1f40\n2 0x10 fetch\n\n1 ffffffffffffffff\n".to_vec()));
    files.push(("addresses", "bad-neither".into(), b"9 zz\n".to_vec()));
    files.push((
        "requests",
        "good-picture".into(),
        b"x,y,u,v,dudx,dvdx,dudy,dvdy,filter\n0,0,0.5,0.25,0.01,0,0,0.01,trilinear\n1,0,-1e300,NaN,inf,0,0,0,\n"
            .to_vec(),
    ));
    files.push(("requests", "good-named".into(), b"texture,u,v,dudx,dvdx,dudy,dvdy\r\nit,0,1,2,3,4,5\r\n".to_vec()));
    files.push(("requests", "bad-column".into(), b"u,v,dudx,dvdx,dudy,dvdy,w\n0,1,2,3,4,5,6\n".to_vec()));
    files.push(("requests", "bad-pixel".into(), b"x,y,u,v,dudx,dvdx,dudy,dvdy\n16384,0,0,1,2,3,4,5\n".to_vec()));
    for sweep in ["cache-size", "layout", "one-frame", "widths"] {
        files.push(("sweep", format!("good-{sweep}"), read(&format!("sweeps/{sweep}.toml"))));
    }
    files.push(("sweep", "bad-empty".into(), b"name = \"a\"\nscenes = []\nfilters = [\"point\"]\n".to_vec()));
    files.push(("obj", "good-quad".into(), OBJ.into()));
    files.push((
        "obj",
        "good-library".into(),
        format!("mtllib it.mtl\n{OBJ}\nusemtl it\nf -1/-1 -2/-2 -3/-3\n").into_bytes(),
    ));
    files.push(("obj", "bad-no-face".into(), b"v 0 0 0\nvt 0 0\n".to_vec()));
    files.push(("obj", "bad-corner".into(), b"v 0 0 0\nvt 0 0\nf 1/1 1/1 4294967295/1\n".to_vec()));
    files.push((
        "mtl",
        "good-colour".into(),
        b"# one\nnewmtl it\nKd 1 0.5 0\nKs 0 0 0\nNs 10\nd 0.5\nillum 2\n".to_vec(),
    ));
    files.push(("mtl", "good-image".into(), b"newmtl it\nmap_Kd texel.ppm\n".to_vec()));
    files.push(("mtl", "bad-colour".into(), b"newmtl it\nKd 1 2\n".to_vec()));
    files.push(("mtl", "bad-emission".into(), b"newmtl it\nKe \n".to_vec()));
    files.push(("mtl", "bad-image".into(), b"newmtl it\nmap_Kd nowhere.png\n".to_vec()));
    files.extend(gltf_files());
    files
}

/// Four corners, in both ways of numbering them.
const OBJ: &str = "o quad\nv 0 0 0\nv 1 0 0\nv 1 1 0 1.0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 1\nf 1/1/1 2/2/1 3/3/1 4/4/1\nf -4/-4 -3/-3 -2/-2\n";

/// A triangle: positions, texture coordinates, indices, and an image.
fn gltf_files() -> Vec<(&'static str, String, Vec<u8>)> {
    let corners = [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mut data: Vec<u8> = corners.iter().flatten().flat_map(|number| number.to_le_bytes()).collect();
    data.extend(corners.iter().flat_map(|corner| &corner[..2]).flat_map(|number| number.to_le_bytes()));
    data.extend([0_u16, 1, 2, 0].iter().flat_map(|index| index.to_le_bytes()));
    let mut png = Cursor::new(Vec::new());
    DynamicImage::ImageRgba8(picture()).write_to(&mut png, ImageFormat::Png).unwrap();
    data.extend(png.get_ref());
    let json = |uri: &str, material: &str| {
        let image = data.len() - 68;
        format!(
            r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],
"nodes":[{{"children":[1],"rotation":[0,0,0,1],"scale":[1,2,1]}},{{"mesh":0,"translation":[0,0,-2]}}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"TEXCOORD_0":1}},"indices":2,"material":0}}]}}],
"materials":[{{"pbrMetallicRoughness":{{{material}}}}}],"textures":[{{"source":0}}],
"images":[{{"bufferView":3,"mimeType":"image/png"}}],
"accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}},
{{"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"}},{{"bufferView":2,"componentType":5123,"count":3,"type":"SCALAR"}}],
"bufferViews":[{{"buffer":0,"byteLength":36}},{{"buffer":0,"byteOffset":36,"byteLength":24,"byteStride":8}},
{{"buffer":0,"byteOffset":60,"byteLength":6}},{{"buffer":0,"byteOffset":68,"byteLength":{image}}}],
"buffers":[{{"byteLength":{}{uri}}}]}}"#,
            data.len()
        )
    };
    let coded = base64::Engine::encode(&base64::engine::general_purpose::STANDARD, &data);
    let within = format!(",\"uri\":\"data:application/octet-stream;base64,{coded}\"");
    let text = json(&within, r#""baseColorFactor":[1,0.5,0,1]"#);
    let mut head = json("", r#""baseColorTexture":{"index":0}"#).into_bytes();
    head.resize(head.len().next_multiple_of(4), b' ');
    let mut rest = data.clone();
    rest.resize(rest.len().next_multiple_of(4), 0);
    let mut binary = b"glTF".to_vec();
    for word in [2, 12 + 8 + head.len() + 8 + rest.len(), head.len()] {
        binary.extend((word as u32).to_le_bytes());
    }
    binary.extend([b"JSON".as_slice(), head.as_slice(), &(rest.len() as u32).to_le_bytes(), b"BIN\0", &rest].concat());
    let far = text.replace("\"byteOffset\":36", "\"byteOffset\":18446744073709551615");
    vec![
        ("gltf", "good-text".into(), text.into_bytes()),
        ("gltf", "good-binary".into(), binary),
        ("gltf", "bad-view".into(), far.into_bytes()),
        ("gltf", "bad-nothing".into(), b"{}".to_vec()),
    ]
}

//! Every reader on the fuzz corpora, on mutations of them, and on headers that lie: no panic, no memory that the file does not pay for.

use std::{
    alloc::{GlobalAlloc, Layout, System},
    cell::Cell,
    collections::BTreeSet,
    fs,
    io::Cursor,
    path::PathBuf,
};

use image::{DynamicImage, ImageFormat, Rgba, RgbaImage};
use proptest::prelude::*;

#[path = "../fuzz/readers.rs"]
mod readers;

use readers::READERS;

/// Counts what each thread holds.
struct Counting;

thread_local! {
    static HELD: Cell<isize> = const { Cell::new(0) };
    static MOST: Cell<isize> = const { Cell::new(0) };
}

fn count(bytes: isize) {
    let _ = HELD.try_with(|held| {
        held.set(held.get() + bytes);
        let _ = MOST.try_with(|most| most.set(most.get().max(held.get())));
    });
}

#[allow(unsafe_code, reason = "an allocator cannot be counted without being one; all of it is handed on")]
// SAFETY: every call goes to the system's allocator as it came.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size() as isize);
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        count(-(layout.size() as isize));
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// The most bytes held at a time, beside those held before.
fn most_held<T>(work: impl FnOnce() -> T) -> (T, usize) {
    let before = HELD.get();
    MOST.set(before);
    let result = work();
    (result, usize::try_from(MOST.get() - before).unwrap_or(0))
}

/// A reader may hold so much for a file of so many bytes: a few MiB of its own, and an image of one colour.
fn budget(bytes: usize) -> usize {
    (96 << 20) + bytes * 8256 * 16
}

fn folder(reader: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus").join(reader)
}

fn corpus(reader: &str) -> Vec<(String, Vec<u8>)> {
    let mut files: Vec<_> = fs::read_dir(folder(reader))
        .unwrap_or_else(|error| panic!("{}: {error}", folder(reader).display()))
        .map(|entry| entry.unwrap().path())
        .map(|path| (path.file_name().unwrap().to_string_lossy().into_owned(), fs::read(&path).unwrap()))
        .collect();
    files.sort();
    files
}

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
fn made() -> Vec<(&'static str, String, Vec<u8>)> {
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

#[test]
fn the_corpora_are_what_is_made_and_readers_take_the_good_and_refuse_the_bad() {
    let made = made();
    if std::env::var_os("TEXUNIT_BLESS").is_some() {
        for (reader, name, bytes) in &made {
            fs::create_dir_all(folder(reader)).unwrap();
            fs::write(folder(reader).join(name), bytes).unwrap();
        }
    }
    for &(reader, read) in READERS {
        let expected: BTreeSet<_> =
            made.iter().filter(|file| file.0 == reader).map(|file| (&file.1, &file.2)).collect();
        let found = corpus(reader);
        for (name, bytes) in &expected {
            // Copies of what ships are older as it changes, and must go on being read.
            let copy = ["scene", "machine", "trace", "sweep"].contains(&reader) && name.starts_with("good-");
            let same = found.iter().any(|(known, stored)| known == *name && (copy || stored == *bytes));
            assert!(same, "fuzz/corpus/{reader}/{name} is not what is made: TEXUNIT_BLESS=1 makes it");
        }
        let mut good = 0;
        for (name, bytes) in &found {
            let (taken, held) = most_held(|| read(bytes));
            assert!(held < budget(bytes.len()), "{reader}/{name}: {held} bytes held for a file of {}", bytes.len());
            if name.starts_with("good-") {
                assert!(taken, "{reader}/{name} is refused");
                good += 1;
            } else if name.starts_with("bad-") {
                assert!(!taken, "{reader}/{name} is taken");
            }
        }
        assert!(good > 0, "{reader}");
    }
}

#[test]
fn a_header_that_claims_what_no_file_holds_is_refused_before_memory_is_asked_for() {
    let big = 0x8000_0000_u32;
    let mut liars: Vec<(String, Vec<u8>)> = Vec::new();
    let good = |name: &str| made().into_iter().find(|file| file.1 == name).unwrap().2;
    // Places of width and height.
    let sides: [(&str, usize, usize, bool); 4] = [
        ("good-png", 16, 20, true),
        ("good-bmp", 18, 22, false),
        ("good-ktx2", 20, 24, false),
        ("good-dds", 16, 12, false),
    ];
    for (name, width, height, big_endian) in sides {
        for side in [big, big - 1, u32::MAX, 1 << 20, 1 << 15] {
            let mut bytes = good(name);
            let digits = if big_endian { side.to_be_bytes() } else { side.to_le_bytes() };
            bytes[width..width + 4].copy_from_slice(&digits);
            bytes[height..height + 4].copy_from_slice(&digits);
            if name == "good-png" {
                // A right checksum: it is the size that is wrong.
                let checksum = crc32(&bytes[12..29]);
                bytes[29..33].copy_from_slice(&checksum.to_be_bytes());
            }
            liars.push((format!("{name} of {side}"), bytes));
        }
    }
    let mut gif = good("good-gif");
    gif[6..10].copy_from_slice(&[0xFF; 4]);
    liars.push(("gif of 65535".into(), gif));
    // The frame is larger than the image it is part of.
    let mut frame = good("good-gif");
    let descriptor = frame.windows(9).position(|bytes| bytes == [0x2C, 0, 0, 0, 0, 6, 0, 4, 0]).unwrap();
    frame[descriptor + 5..descriptor + 9].copy_from_slice(&[0xFF; 4]);
    liars.push(("gif with a frame of 65535".into(), frame));
    let mut tga = good("good-tga");
    tga[12..16].copy_from_slice(&[0xFF; 4]);
    liars.push(("tga of 65535".into(), tga));
    liars.push(("pnm".into(), b"P6\n2147483648 2147483648\n255\nabc".to_vec()));
    liars.push(("pnm of 2^30".into(), b"P6\n32768 32768\n255\nabc".to_vec()));
    for (name, bytes) in liars {
        let (taken, held) = most_held(|| readers::texture(&bytes));
        assert!(!taken, "{name} is taken");
        assert!(held < 1 << 20, "{name}: {held} bytes held");
    }
    // A line without end, and a head that counts more records than there are.
    let line = vec![b'1'; 8 << 20];
    let trace = good("good-floor.trilinear");
    let counted = String::from_utf8(trace).unwrap().replace("// count 2", "// count 18446744073709551615").into_bytes();
    for (name, bytes) in [("coordinates", &line), ("trace", &line), ("trace", &counted), ("addresses", &line)] {
        let read = READERS.iter().find(|reader| reader.0 == name).unwrap().1;
        let (_, held) = most_held(|| read(bytes));
        assert!(held < (4 << 20) + 2 * bytes.len(), "{name}: {held} bytes held");
    }
}

/// As in PNG (ISO 3309).
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| if crc & 1 == 1 { crc >> 1 ^ 0xEDB8_8320 } else { crc >> 1 })
    })
}

#[derive(Clone, Debug)]
enum Mutation {
    Cut(prop::sample::Index),
    Flip(prop::sample::Index, u8),
    Insert(prop::sample::Index, Vec<u8>),
    Remove(prop::sample::Index, usize),
    Repeat(prop::sample::Index, usize),
    /// The digits at a place become another number.
    Number(prop::sample::Index, &'static str),
}

fn mutation() -> impl Strategy<Value = Mutation> {
    let index = any::<prop::sample::Index>;
    let numbers =
        ["-1", "0", "2147483648", "4294967295", "18446744073709551616", "1e308", "nan", "-inf", "0.0000001", "16384"];
    prop_oneof![
        index().prop_map(Mutation::Cut),
        (index(), any::<u8>()).prop_map(|(at, bits)| Mutation::Flip(at, bits)),
        (index(), prop::collection::vec(any::<u8>(), 1..6)).prop_map(|(at, bytes)| Mutation::Insert(at, bytes)),
        (index(), 1..40_usize).prop_map(|(at, count)| Mutation::Remove(at, count)),
        (index(), 1..40_usize).prop_map(|(at, count)| Mutation::Repeat(at, count)),
        (index(), prop::sample::select(numbers.to_vec())).prop_map(|(at, number)| Mutation::Number(at, number)),
    ]
}

fn apply(bytes: &mut Vec<u8>, mutation: &Mutation) {
    if bytes.is_empty() {
        return;
    }
    match mutation {
        Mutation::Cut(at) => bytes.truncate(at.index(bytes.len())),
        Mutation::Flip(at, bits) => {
            let at = at.index(bytes.len());
            bytes[at] ^= bits | 1;
        }
        Mutation::Insert(at, more) => {
            let at = at.index(bytes.len());
            bytes.splice(at..at, more.iter().copied());
        }
        Mutation::Remove(at, count) => {
            let at = at.index(bytes.len());
            bytes.drain(at..bytes.len().min(at + count));
        }
        Mutation::Repeat(at, count) => {
            let at = at.index(bytes.len());
            let piece = bytes[at..bytes.len().min(at + count)].to_vec();
            bytes.splice(at..at, piece);
        }
        Mutation::Number(at, number) => {
            // The next digits from there on.
            let at = at.index(bytes.len());
            let Some(first) = bytes[at..].iter().position(u8::is_ascii_digit).map(|first| at + first) else { return };
            let digits = bytes[first..].iter().take_while(|byte| byte.is_ascii_digit()).count();
            bytes.splice(first..first + digits, number.bytes());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_mutation_of_a_file_makes_a_reader_panic_or_take_memory_without_end(
        reader in 0..READERS.len(), file in any::<prop::sample::Index>(), mutations in prop::collection::vec(mutation(), 1..5),
    ) {
        let (name, read) = READERS[reader];
        let corpus = corpus(name);
        let mut bytes = file.get(&corpus).1.clone();
        for mutation in &mutations {
            apply(&mut bytes, mutation);
        }
        let (_, held) = most_held(|| read(&bytes));
        prop_assert!(held < budget(bytes.len()), "{}: {} bytes held for {}", name, held, bytes.len());
    }
}

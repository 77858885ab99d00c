//! Every reader on the fuzz corpora, on mutations of them, and on headers that lie: no panic, no memory that the file does not pay for.

mod held;
mod made;
#[path = "../../fuzz/readers.rs"]
mod readers;

use std::{collections::BTreeSet, fs, path::PathBuf};

use proptest::prelude::*;

use held::most_held;
use made::made;
use readers::READERS;

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

//! Files of requests, as CSV and as Parquet.

use std::fs;

use texunit::stream::requests_file;

use crate::{texunit, write_texture};

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

#[cfg(feature = "parquet")]
#[test]
fn requests_in_parquet_are_those_in_csv() {
    use std::sync::Arc;

    use parquet::{
        data_type::{ByteArray, ByteArrayType, DoubleType, Int32Type},
        file::{properties::WriterProperties, writer::SerializedFileWriter},
        schema::parser::parse_message_type,
    };
    use texunit::{
        machine::Machine,
        stream::{Stream, StreamRun},
    };
    use texunit_hw::{AddressMode, Filter};

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

//! The merged table of a sweep as Parquet: text columns as UTF-8, numbers as numbers, one row group.

use std::{io::Write, sync::Arc};

use parquet::{
    basic::{ConvertedType, Repetition, Type as Physical},
    data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type},
    errors::ParquetError,
    file::{properties::WriterProperties, writer::SerializedFileWriter},
    schema::types::Type,
};

use super::store::Row;

/// Columns that hold whole numbers, or nothing.
const WHOLE: [&str; 5] = ["point", "width", "height", "cache.sets", "cache.ways"];

/// The merged table as Parquet.
///
/// # Errors
/// Those of the writer.
pub fn write_parquet(writer: &mut (dyn Write + '_), columns: &[String], rows: &[Row]) -> std::io::Result<()> {
    let mut bytes = Vec::new();
    encode(&mut bytes, columns, rows).map_err(std::io::Error::other)?;
    writer.write_all(&bytes)
}

fn encode(bytes: &mut Vec<u8>, columns: &[String], rows: &[Row]) -> Result<(), ParquetError> {
    let whole = |name: &str| WHOLE.contains(&name);
    let names: Vec<&str> =
        ["point"].into_iter().chain(columns.iter().map(String::as_str)).chain(["metric", "value", "unit"]).collect();
    let field = |name: &&str| -> Result<Arc<Type>, ParquetError> {
        let builder = match *name {
            "value" => Type::primitive_type_builder(name, Physical::DOUBLE),
            name if whole(name) => Type::primitive_type_builder(name, Physical::INT64),
            name => Type::primitive_type_builder(name, Physical::BYTE_ARRAY).with_converted_type(ConvertedType::UTF8),
        };
        Ok(Arc::new(builder.with_repetition(Repetition::OPTIONAL).build()?))
    };
    let fields = names.iter().map(field).collect::<Result<_, _>>()?;
    let schema = Arc::new(Type::group_type_builder("sweep").with_fields(fields).build()?);
    let mut file = SerializedFileWriter::new(bytes, schema, Arc::new(WriterProperties::builder().build()))?;
    let mut group = file.next_row_group()?;
    for (number, name) in names.iter().enumerate() {
        let text = |row: &Row| match *name {
            "point" => row.point.to_string(),
            "metric" => row.metric.clone(),
            "unit" => row.unit.clone(),
            _ => row.place[number - 1].clone(),
        };
        let mut column = group.next_column()?.ok_or_else(|| ParquetError::General("a column is missing".into()))?;
        if *name == "value" {
            let (levels, values) = present(rows.iter().map(|row| row.value));
            column.typed::<DoubleType>().write_batch(&values, Some(&levels), None)?;
        } else if whole(name) {
            let (levels, values) = present(rows.iter().map(|row| text(row).parse::<i64>().ok()));
            column.typed::<Int64Type>().write_batch(&values, Some(&levels), None)?;
        } else {
            let (levels, values) = present(rows.iter().map(|row| Some(ByteArray::from(text(row).into_bytes()))));
            column.typed::<ByteArrayType>().write_batch(&values, Some(&levels), None)?;
        }
        column.close()?;
    }
    group.close()?;
    file.close()?;
    Ok(())
}

/// Definition levels (1 where there is a value) and the values there are.
fn present<T>(values: impl Iterator<Item = Option<T>>) -> (Vec<i16>, Vec<T>) {
    let (mut levels, mut there) = (Vec::new(), Vec::new());
    for value in values {
        levels.push(i16::from(value.is_some()));
        there.extend(value);
    }
    (levels, there)
}

//! Answers as a table for other programs: CSV, and Parquet for those that read columns.

use crate::args::TableArgs;
use crate::failure::Failure;
use crate::output;
use parquet::basic::{ConvertedType, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use serde_json::Value;
use std::path::Path;
use std::sync::Arc;

/// Writes the tables that are asked for: a column for each of `head`.
pub(super) fn write(args: &TableArgs, rows: &[Value], head: &[&str]) -> Result<(), Failure> {
    if let Some(path) = &args.csv {
        write_csv(path, rows, head)?;
    }
    if let Some(path) = &args.parquet {
        let bytes = parquet(rows, head)
            .map_err(|why| Failure::System(format!("{}: Parquet: {why}", path.display())))?;
        output::write(path, bytes)?;
    }
    Ok(())
}

/// Answers as CSV: every number with its digits, text in quotes where it must be.
fn write_csv(path: &Path, rows: &[Value], head: &[&str]) -> Result<(), Failure> {
    let quoted = |value: &Value| match value {
        Value::Null => String::new(),
        Value::String(text) if text.contains([',', '"', '\n']) => {
            format!("\"{}\"", text.replace('"', "\"\""))
        }
        Value::String(text) => text.clone(),
        other => other.to_string(),
    };
    let mut text = head.join(",");
    text.push('\n');
    for row in rows {
        let cells: Vec<String> = head.iter().map(|key| quoted(&row[*key])).collect();
        text.push_str(&cells.join(","));
        text.push('\n');
    }
    Ok(output::write(path, text)?)
}

/// What a column holds.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Whole,
    Number,
    Text,
}

impl Kind {
    /// Of values that may be missing: whole numbers, else numbers, else text.
    fn of<'a>(values: impl Iterator<Item = &'a Value> + Clone) -> Self {
        let mut there = values.filter(|value| !value.is_null());
        let numbers = there.clone().all(Value::is_number);
        let whole = numbers && there.clone().all(Value::is_i64);
        match there.next() {
            Some(_) if whole => Self::Whole,
            Some(_) if numbers => Self::Number,
            _ => Self::Text,
        }
    }

    fn column(self, name: &str) -> Result<Arc<Type>, ParquetError> {
        let (physical, logical, converted) = match self {
            Self::Whole => (Physical::INT64, None, ConvertedType::NONE),
            Self::Number => (Physical::DOUBLE, None, ConvertedType::NONE),
            Self::Text => (
                Physical::BYTE_ARRAY,
                Some(LogicalType::String),
                ConvertedType::UTF8,
            ),
        };
        Type::primitive_type_builder(name, physical)
            .with_repetition(Repetition::OPTIONAL)
            .with_logical_type(logical)
            .with_converted_type(converted)
            .build()
            .map(Arc::new)
    }
}

/// Rows as Parquet, in one row group; what is missing is null.
fn parquet(rows: &[Value], head: &[&str]) -> Result<Vec<u8>, ParquetError> {
    let mut bytes = Vec::new();
    let values = |name: &str| rows.iter().map(move |row| &row[name]).collect::<Vec<_>>();
    let kinds: Vec<Kind> = head
        .iter()
        .map(|name| Kind::of(values(name).into_iter()))
        .collect();
    let columns = head.iter().zip(&kinds);
    let columns: Result<Vec<_>, _> = columns.map(|(name, kind)| kind.column(name)).collect();
    let schema = Type::group_type_builder("rows")
        .with_fields(columns?)
        .build()?;
    let properties = WriterProperties::builder()
        .set_created_by(concat!("rarma ", env!("CARGO_PKG_VERSION")).to_owned())
        .build();
    let mut file = SerializedFileWriter::new(&mut bytes, Arc::new(schema), Arc::new(properties))?;
    let mut group = file.next_row_group()?;
    for (name, kind) in head.iter().zip(kinds) {
        let Some(mut column) = group.next_column()? else {
            break;
        };
        let values = values(name);
        let levels: Vec<i16> = values.iter().map(|v| i16::from(!v.is_null())).collect();
        let there = values.into_iter().filter(|value| !value.is_null());
        match kind {
            Kind::Whole => {
                let values: Vec<i64> = there.filter_map(Value::as_i64).collect();
                let column = column.typed::<Int64Type>();
                column.write_batch(&values, Some(&levels), None)?;
            }
            Kind::Number => {
                let values: Vec<f64> = there.filter_map(Value::as_f64).collect();
                let column = column.typed::<DoubleType>();
                column.write_batch(&values, Some(&levels), None)?;
            }
            Kind::Text => {
                let text = there.map(|value| match value {
                    Value::String(text) => text.as_str().into(),
                    other => other.to_string().as_str().into(),
                });
                let values: Vec<ByteArray> = text.collect();
                let column = column.typed::<ByteArrayType>();
                column.write_batch(&values, Some(&levels), None)?;
            }
        }
        column.close()?;
    }
    group.close()?;
    file.close()?;
    Ok(bytes)
}

//! MATLAB level 5 files, little endian, not compressed.
//!
//! A header of 128 bytes, then a matrix element for each variable: flags, dimensions, name, numbers,
//! each with a tag of 8 bytes and padded to a multiple of 8.

use super::{Along, Table};

/// Types of elements.
const INT8: u32 = 1;
const UINT16: u32 = 4;
const INT32: u32 = 5;
const UINT32: u32 = 6;
const DOUBLE: u32 = 9;
const MATRIX: u32 = 14;
/// Classes of arrays.
const CHAR_CLASS: u32 = 4;
const DOUBLE_CLASS: u32 = 6;
/// Bytes of a variable at most.
const MOST: usize = 1 << 31;

/// Variables `fs` or `f_Hz` (first column of a spectrum), `x` or `psd` (a column for each channel),
/// `names` and `units` (one line each, parted by `; `), `title`. None if a variable is too large.
pub(super) fn bytes(table: &Table) -> Option<Vec<u8>> {
    let n = table.rows();
    let text = b"MATLAB 5.0 MAT-file, written by rarma";
    let mut out = vec![b' '; 116];
    out[..text.len()].copy_from_slice(text);
    out.extend([0; 8]);
    out.extend(0x0100u16.to_le_bytes());
    out.extend(b"IM");
    let (first, step) = table.along.grid();
    let values = match table.along {
        Along::Time { fs } => {
            numbers(&mut out, "fs", 1, 1, std::iter::once(fs))?;
            "x"
        }
        Along::Frequency { .. } => {
            let grid = (0..n).map(|k| first + step * k as f64);
            numbers(&mut out, "f_Hz", n, 1, grid)?;
            "psd"
        }
    };
    let all = table
        .columns
        .iter()
        .flat_map(|c| c.values[..n].iter().copied());
    numbers(&mut out, values, n, table.columns.len(), all)?;
    let list = |pick: fn(&super::Column) -> &str| -> String {
        let words: Vec<&str> = table.columns.iter().map(pick).collect();
        words.join("; ")
    };
    line(&mut out, "names", &list(|c| &c.name))?;
    line(&mut out, "units", &list(|c| &c.unit))?;
    line(&mut out, "title", &table.title)?;
    Some(out)
}

/// A variable of numbers, column by column.
fn numbers(
    out: &mut Vec<u8>,
    name: &str,
    rows: usize,
    columns: usize,
    values: impl Iterator<Item = f64>,
) -> Option<()> {
    let data: Vec<u8> = values.flat_map(f64::to_le_bytes).collect();
    variable(out, name, DOUBLE_CLASS, (rows, columns), (DOUBLE, &data))
}

/// A variable of one line of text.
fn line(out: &mut Vec<u8>, name: &str, text: &str) -> Option<()> {
    let units: Vec<u16> = text.encode_utf16().collect();
    let data: Vec<u8> = units.iter().copied().flat_map(u16::to_le_bytes).collect();
    variable(out, name, CHAR_CLASS, (1, units.len()), (UINT16, &data))
}

fn variable(
    out: &mut Vec<u8>,
    name: &str,
    class: u32,
    (rows, columns): (usize, usize),
    (kind, data): (u32, &[u8]),
) -> Option<()> {
    if data.len() >= MOST {
        return None;
    }
    let dimension = |n: usize| i32::try_from(n).ok();
    let mut inside = Vec::with_capacity(data.len() + 128);
    let flags = [class.to_le_bytes(), [0; 4]].concat();
    element(&mut inside, UINT32, &flags)?;
    let dimensions = [
        dimension(rows)?.to_le_bytes(),
        dimension(columns)?.to_le_bytes(),
    ]
    .concat();
    element(&mut inside, INT32, &dimensions)?;
    element(&mut inside, INT8, name.as_bytes())?;
    element(&mut inside, kind, data)?;
    element(out, MATRIX, &inside)
}

fn element(out: &mut Vec<u8>, kind: u32, data: &[u8]) -> Option<()> {
    out.extend(kind.to_le_bytes());
    out.extend(u32::try_from(data.len()).ok()?.to_le_bytes());
    out.extend(data);
    out.resize(out.len().next_multiple_of(8), 0);
    Some(())
}

#[cfg(test)]
mod tests {
    use super::super::tests::table;

    /// The layout of the format's description, byte by byte, of the first variable.
    #[test]
    fn the_first_variable_lies_where_the_format_says() {
        let bytes = super::bytes(&table(10)).expect("small");
        assert_eq!(
            (bytes[124..126].to_vec(), &bytes[126..128]),
            (vec![0, 1], &b"IM"[..])
        );
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four"));
        // Tag of the matrix: 16 of flags, 16 of dimensions, 16 of the name, 16 of the number.
        assert_eq!([word(128), word(132)], [14, 64]);
        assert_eq!([word(136), word(140), word(144)], [6, 8, 6]);
        assert_eq!([word(152), word(156), word(160), word(164)], [5, 8, 1, 1]);
        assert_eq!([word(168), word(172)], [1, 2]);
        assert_eq!(&bytes[176..178], b"fs");
        assert_eq!([word(184), word(188)], [9, 8]);
        let fs = f64::from_le_bytes(bytes[192..200].try_into().expect("eight"));
        assert_eq!(fs, 44_100.0);
        assert_eq!(bytes.len() % 8, 0);
    }
}

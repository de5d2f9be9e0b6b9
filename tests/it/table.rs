//! Reading of measurements: CSV as laboratories write it.

use elastogeo::description::table::{ColumnKind, Dialect, ExpectedColumn, Sheet, Table, read_table};
use elastogeo::diagnostic::Diagnostic;
use rand::{RngExt, SeedableRng};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::{self, Read};

fn expected() -> Vec<ExpectedColumn> {
    let column = |name: &str, kind, required| ExpectedColumn::new(name, kind, required);
    vec![
        column("pose", ColumnKind::Text, true),
        column("q1", ColumnKind::Number, true),
        column("x", ColumnKind::Number, true),
        column("marker", ColumnKind::Text, false),
    ]
}

fn dialect(delimiter: Option<char>, decimal: char) -> Dialect {
    Dialect { delimiter, decimal: Some(decimal), of_campaign: true, ..Dialect::default() }
}

fn read_as(bytes: &[u8], dialect: &Dialect) -> Result<Table, Vec<Diagnostic>> {
    read_table("m.csv", bytes, &expected(), &BTreeMap::new(), &["note".into()], dialect, 1000)
}

fn read(bytes: &[u8]) -> Result<Table, Vec<Diagnostic>> {
    read_as(bytes, &Dialect { of_campaign: true, ..Dialect::default() })
}

/// Each diagnostic as `line:column [what is highlighted] message | remedy`.
fn reported(result: Result<Table, Vec<Diagnostic>>) -> String {
    let mut told = String::new();
    for diagnostic in result.unwrap_err() {
        let place = diagnostic.place.as_ref().unwrap();
        let meant = &place.excerpt[place.highlight.clone()];
        let _ = write!(told, "{}:{} [{meant}] {}", place.line, place.column, diagnostic.message);
        for (place, why) in &diagnostic.related {
            let _ = write!(told, " ({}:{} {why})", place.line, place.column);
        }
        let _ = writeln!(told, " | {}", diagnostic.remedy.as_deref().unwrap_or_default());
    }
    told
}

#[test]
fn what_laboratories_write_is_read() {
    let plain = "pose,q1,x\n1,0.5,-2e-3\n2,+1,.5\n";
    let variants: [(&[u8], char); 7] = [
        (plain.as_bytes(), '.'),
        (b"\xef\xbb\xbfpose,q1,x\r\n1,0.5,-2e-3\r\n2,+1,.5\r\n\r\n\r\n", '.'),
        (b"pose;q1;x;\n1;0,5;-2e-3;\n2;+1;,5;\n;;;\n", ','),
        (b"\n\"pose\" ; \"q1\" ;x\n \"1\" ; 0.5 ;\"-2e-3\"\n\n2;+1;.5", '.'),
        (b"pose\tq1\tx\tnote\n1\t0.5\t-2e-3\t\xff\n2\t+1\t.5\t \n   \n", '.'),
        (b"q1,note,x,pose\n0.5,\"a, \"\"b\"\"\nc\",-2e-3,1\n1,,.5,2\n", '.'),
        (b"pose,q1,x\n1,\xc2\xa00.5,-2e-3\n2,1,0.5", '.'),
    ];
    for (bytes, decimal) in variants {
        let table = read_as(bytes, &dialect(None, decimal)).unwrap();
        let name = String::from_utf8_lossy(bytes);
        assert_eq!(table.row_count(), 2, "{name}");
        assert_eq!(table.numbers("q1").unwrap(), [0.5, 1.0], "{name}");
        assert_eq!(table.numbers("x").unwrap(), [-2e-3, 0.5], "{name}");
        let poses = table.texts("pose").unwrap();
        assert_eq!((poses.get(0), poses.get(1), poses.get(2)), (Some("1"), Some("2"), None), "{name}");
        assert!(!table.has("marker"));
    }
    let table = read(b"note,pose,q1,x\n\n\"a\nb\",1,2,3\r\n\r\nc, 1 ,2,4\n").unwrap();
    assert_eq!((table.line(0), table.line(1)), (Some(3), Some(6)), "lines are those of the file");
    assert_eq!(table.texts("pose").unwrap().texts(), ["1"], "one text is kept once");
    let place = table.place(1, "x").unwrap();
    assert_eq!((place.line, place.column, place.excerpt.as_str()), (6, 9, "c, 1 ,2,4"));
    assert_eq!(&place.excerpt[place.highlight], "4");
}

#[test]
fn the_first_number_with_a_sign_settles_the_decimal_sign() {
    let table = read(b"pose;q1;x\n1;2;3\n2;0,5;-1,5e-3\n3;1;,25\n").unwrap();
    assert_eq!(table.numbers("q1").unwrap(), [2.0, 0.5, 1.0]);
    assert_eq!(table.numbers("x").unwrap(), [3.0, -1.5e-3, 0.25]);
    let table = read(b"pose\tq1\tx\n1\t0.5\t3\n").unwrap();
    assert_eq!(table.numbers("q1").unwrap(), [0.5]);
    // A thousands' separator, or two signs in one file, is not guessed at.
    for (bytes, place) in [
        (&b"pose;q1;x\n1;1.5;3\n2;1,234;3\n"[..], "3:3 [1,234]"),
        (b"pose;q1;x\n1;1,5;3\n2;1.234;3\n", "3:3 [1.234]"),
        (b"pose;q1;x\n1;1,234,5;3\n", "2:3 [1,234,5]"),
        (b"pose;q1;x\n1;1.234,5;3\n", "2:3 [1.234,5]"),
        (b"pose,q1,x\n1,\"1,5\",3\n", "2:3 [\"1,5\"]"),
    ] {
        assert!(reported(read(bytes)).starts_with(place), "{}", reported(read(bytes)));
    }
}

#[test]
fn remedies_name_keys_only_where_a_campaign_has_them() {
    let all: [&[u8]; 6] = [
        b"pose,Q1,x\n1,2,3\n",
        b"pose,q1,x,temp\n1,2,3,4\n",
        b"pose,x\n1,2\n",
        b"pose,q1,x\n1,\"2,5\",3\n",
        b"\"a;b\"\n1\n",
        b"1,2,3\n4,5,6\n",
    ];
    for bytes in all {
        let plain = reported(read_as(bytes, &Dialect::default()));
        assert!(!plain.contains("columns:") && !plain.contains("ignore:") && !plain.contains("csv:"), "{plain}");
        assert!(!plain.contains("| \n"), "no remedy: {plain}");
    }
    assert!(reported(read(all[0])).contains("columns: {q1: Q1}") && reported(read(all[1])).contains("`ignore:`"));
    let numbers = reported(read(all[5]));
    assert!(numbers.starts_with("1:1 [1,2,3] the first line must be a header"), "{numbers}");
    assert!(numbers.ends_with("start it with a header line that names pose, q1, x\n"), "{numbers}");
    // A column may well be called by a number, where that is declared.
    let rename = BTreeMap::from([("q1".to_owned(), "1".to_owned()), ("x".to_owned(), "2".to_owned())]);
    let dialect = dialect(None, '.');
    assert!(read_table("m.csv", &b"pose,1,2\na,1,2\n"[..], &expected(), &rename, &[], &dialect, 9).is_ok());
}

#[test]
fn renamed_columns_are_read() {
    let rename = BTreeMap::from([("q1".to_owned(), "joint 1".to_owned())]);
    let bytes: &[u8] = b"pose,joint 1,x\na,1,2\n";
    let table = read_table("m.csv", bytes, &expected(), &rename, &[], &dialect(None, '.'), 9).unwrap();
    assert_eq!(table.numbers("q1").unwrap(), [1.0]);
    let rename = BTreeMap::from([("q1".to_owned(), "joint1".to_owned()), ("qq".to_owned(), "x".to_owned())]);
    let result = read_table("m.csv", bytes, &expected(), &rename, &[], &dialect(None, '.'), 9);
    insta::assert_snapshot!(reported(result));
}

#[test]
fn every_fault_of_the_header_and_cells_is_found() {
    let bytes = b"pose, Q1,x,x,temp\n1,2,3,4,5\n,abc,1,2,3\n2,3,nan,1,1\n3,4,\"1,5\",1,2\n4,5\n5,6,7,8,9,10\n6,1,1e999,\xff,1\n\xff\xfe,1,\xe9,1,1\n7,1,\xe2\x88\x923,1,1\n";
    insta::assert_snapshot!(reported(read(bytes)));
}

#[test]
fn faults_of_the_whole_file_are_reported() {
    let utf16: Vec<u8> = std::iter::once(0xfeff).chain("pose,q1".encode_utf16()).flat_map(u16::to_le_bytes).collect();
    let cases: [(&[u8], Dialect); 14] = [
        (b"", dialect(None, '.')),
        (b"\n  \r\n", dialect(None, '.')),
        (b"pose,q1,x\n\n", dialect(None, '.')),
        (b"pose;q1;x\n1;2;3\n", dialect(Some(','), '.')),
        (b"pose\tq1\tx\n1\t2\t3\n", dialect(Some(';'), '.')),
        (b"pose;q1;x\n1;1.5;3\n", dialect(None, ',')),
        (b"pose,q1,x\n1,1,5,2,5\n", dialect(None, '.')),
        (b"pose,q1,x\n1,\"2,3\n2,3,4\n", dialect(None, '.')),
        (b"pose,q1,x\n1,2,3\n\"2,3,4\n5,6,7\n", dialect(None, '.')),
        (b"pose,q1,x\r1,2,3\r", dialect(None, '.')),
        (&utf16, dialect(None, '.')),
        (b"pose,q1,x,\n1,2,3,\n2,2,3,oops\n", dialect(None, '.')),
        (b"pose,q1,x\n1,2,3\n", dialect(Some(','), ',')),
        (b"pose,q1,\"x\n1,2,3\n", dialect(None, '.')),
    ];
    let all: Vec<String> = cases.iter().map(|(bytes, dialect)| reported(read_as(bytes, dialect))).collect();
    insta::assert_snapshot!(all.join(""));
}

#[test]
fn many_faults_are_counted() {
    let text = format!("pose,q1,x\n{}", "1,a,b\n".repeat(50));
    let faults = read(text.as_bytes()).unwrap_err();
    assert_eq!(faults.len(), 21);
    assert!(reported(read(b"pose,q1,x\n\n\r\n\n1,2,z\n")).starts_with("5:5 [z]"), "empty lines count");
    let last = faults.last().unwrap();
    assert_eq!(last.message, "and 80 more; the first of them is here");
    assert_eq!(last.place.as_ref().unwrap().line, 12);
}

/// A file that never ends.
struct Endless {
    unit: &'static [u8],
    header: &'static [u8],
    given: usize,
}

impl Read for Endless {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        for byte in buffer.iter_mut() {
            let below = self.given.wrapping_sub(self.header.len());
            *byte = *self.header.get(self.given).unwrap_or(&self.unit[below % self.unit.len()]);
            self.given += 1;
        }
        Ok(buffer.len())
    }
}

#[test]
fn no_file_is_too_long_to_be_refused() {
    let endless = |header, unit| {
        let file = Endless { unit, header, given: 0 };
        read_table("m.csv", file, &expected(), &BTreeMap::new(), &[], &Dialect::default(), 5000)
    };
    assert!(reported(endless(b"pose,q1,x\n", b"1,2,3\n")).starts_with("5002:1 [1] more than 5000 rows"));
    assert!(reported(endless(b"pose,q1,x\n", b"1,b,3\n")).contains("more than 5000 rows"));
    assert!(reported(endless(b"pose,q1,x\n", b"11111111")).contains("a row longer than"));
    assert!(reported(endless(b"pose,q1,x\n\"", b"a\n")).starts_with("2:1 [\"] this quote is not closed within"));
    assert!(reported(endless(b"", b"pose,")).starts_with("1:1 [] the file cannot be read: a row is longer"));
    assert!(reported(endless(b"", b"\n")).starts_with("1:1 [] the file cannot be read: a row is longer"));
}

#[test]
fn a_large_file_is_read_in_bounded_memory() {
    let rows = 200_000;
    let unit: &[u8] = b"pose17,1.25,-3.5\n";
    let file = Endless { unit, header: b"pose,q1,x\n", given: 0 }.take((10 + unit.len() * rows) as u64);
    let table = read_table("m.csv", file, &expected(), &BTreeMap::new(), &[], &Dialect::default(), rows).unwrap();
    assert_eq!((table.row_count(), table.line(rows - 1)), (rows, Some(rows + 1)));
    assert!(table.numbers("x").unwrap().iter().all(|&x| x == -3.5));
    let wide = format!("pose,q1,x,note\n1,2,3,{}\n2,y,3,-\n", "z".repeat(500_000));
    assert_eq!(reported(read(wide.as_bytes())).lines().count(), 1);
}

#[test]
fn mutated_files_are_read_or_refused_with_a_place() {
    let samples: [&[u8]; 5] = [
        b"pose,q1,x,marker\n1,0.5,-2e-3,wrist\n2,+1,.5,\"a, b\"\n",
        b"\xef\xbb\xbfpose;q1;x\r\n1;0,5;7\r\n\"2\";1;,5\r\n",
        b"pose\tq1\tx\tnote\n1\t0.5\t-2e-3\thot\n\n2\t1\t5\t\n",
        b"sep=;\n# a comment\npose;q1;x\n-;mm;mm\n1;0.5;7\n#2;1;5\n3;4;5\n",
        b"pose   q1 \t x\n\"a b\"  1  2\n // note\n2  +1   .5  \n",
    ];
    let pieces: [&[u8]; 20] = [
        b"#",
        b"//",
        b"mm",
        b"\nsep=;",
        b",",
        b";",
        b"\t",
        b"\"",
        b"\n",
        b"\r",
        b"\r\n",
        b"nan",
        b"1,5",
        b"\xff",
        b"\0",
        b" ",
        b"\xc3\xa9",
        b"x",
        b"9",
        b"\xef\xbb\xbf",
    ];
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(7);
    let mut sound = 0;
    for _ in 0..20_000 {
        let mut bytes = samples[random.random_range(0..samples.len())].to_vec();
        for _ in 0..random.random_range(1..4) {
            let at = random.random_range(0..=bytes.len());
            let end = (at + random.random_range(0..4)).min(bytes.len());
            bytes.splice(at..end, pieces[random.random_range(0..pieces.len())].iter().copied());
        }
        let decimal = if random.random_bool(0.5) { '.' } else { ',' };
        let delimiter = [None, None, Some(','), Some(';'), Some('\t'), Some(' ')][random.random_range(0..6)];
        match read_as(&bytes, &dialect(delimiter, decimal)) {
            Ok(table) => {
                sound += 1;
                for row in 0..table.row_count() {
                    let place = table.place(row, "q1").unwrap();
                    assert!(!place.excerpt.is_empty(), "{:?}", String::from_utf8_lossy(&bytes));
                }
                assert_eq!(table.numbers("q1").unwrap().len(), table.row_count());
                assert_eq!(table.texts("pose").unwrap().indices().len(), table.row_count());
            }
            Err(faults) => {
                assert!(!faults.is_empty());
                let lines = 1 + bytes.iter().filter(|&&byte| byte == b'\n').count();
                for fault in &faults {
                    let place = fault.place.as_ref().unwrap_or_else(|| panic!("no place: {fault:?}"));
                    assert!((1..=lines).contains(&place.line), "{place:?} of {:?}", String::from_utf8_lossy(&bytes));
                }
                elastogeo::render::diagnostics::render(&faults, false);
            }
        }
    }
    assert!(sound > 200, "the mutations leave some files sound: {sound}");
}

#[test]
fn names_that_need_quotes_are_written_and_read_back() {
    let names = ["plain", "with, comma", "with \"quotes\"", "two\nlines"];
    let mut sheet = Sheet::new();
    sheet.column("pose", |row| names[row].into());
    sheet.column("q1", |row| format!("{:.3}", 0.25 * row as f64));
    sheet.column("x", |row| row.to_string());
    let text = sheet.csv(0..names.len()).expect("written");
    assert!(text.starts_with("pose,q1,x\nplain,0.000,0\n\"with, comma\",0.250,1\n"), "{text}");
    let table = read(text.as_bytes()).expect("read");
    let back: Vec<&str> = (0..names.len()).filter_map(|row| table.texts("pose")?.get(row)).collect();
    assert_eq!(back, names);
    assert_eq!(table.numbers("q1"), Some(&[0.0, 0.25, 0.5, 0.75][..]));
}

//! Tables as programs export them: a declared separator, comments, a row of units, columns set apart by blanks.

use elastogeo::description::table::{ColumnKind, Dialect, ExpectedColumn, Table, read_table};
use elastogeo::description::units::{Angle, Length, Unit};
use elastogeo::diagnostic::Diagnostic;
use std::collections::BTreeMap;
use std::fmt::Write as _;

fn expected() -> Vec<ExpectedColumn> {
    let column = |name: &str, kind, required| ExpectedColumn::new(name, kind, required);
    vec![
        column("pose", ColumnKind::Text, false),
        column("q1", ColumnKind::Quantity(Unit::Angle(Angle::Degree)), true),
        column("x", ColumnKind::Quantity(Unit::Length(Length::Millimetre)), true),
        column("time", ColumnKind::Quantity(Unit::named("s").unwrap()), false),
        column("temperature", ColumnKind::Number, false),
    ]
}

fn read_as(bytes: &[u8], delimiter: Option<char>, decimal: Option<char>) -> Result<Table, Vec<Diagnostic>> {
    let dialect = Dialect { delimiter, decimal, of_campaign: true, ..Dialect::default() };
    read_table("m.csv", bytes, &expected(), &BTreeMap::new(), &[], &dialect, 1000)
}

fn read(text: &str) -> Result<Table, Vec<Diagnostic>> {
    read_as(text.as_bytes(), None, None)
}

/// Each diagnostic as `line:column [what is highlighted] message | remedy`.
fn told(diagnostics: &[Diagnostic]) -> String {
    let mut told = String::new();
    for diagnostic in diagnostics {
        let place = diagnostic.place.as_ref().unwrap();
        let meant = &place.excerpt[place.highlight.clone()];
        let remedy = diagnostic.remedy.as_deref().unwrap_or_default();
        let _ = writeln!(told, "{}:{} [{meant}] {} | {remedy}", place.line, place.column, diagnostic.message);
    }
    told
}

fn refused(text: &str) -> String {
    told(&read(text).unwrap_err())
}

#[test]
fn a_first_line_may_declare_the_delimiter() {
    for text in [
        "sep=;\npose;q1;x\na,b;1,5;2\n",
        "\u{feff}SEP=;\r\npose;q1;x\r\na,b;1,5;2\r\n",
        "\"sep=;\"\npose;q1;x\na,b;1,5;2\n",
    ] {
        let table = read(text).unwrap();
        assert_eq!(table.texts("pose").unwrap().get(0), Some("a,b"), "{text}");
        assert_eq!((table.numbers("q1"), table.line(0)), (Some(&[1.5][..]), Some(3)), "{text}");
    }
    // Short headers lose nothing of what follows.
    assert_eq!(read("x;q1\n1;2\n").unwrap().numbers("x"), Some(&[1.0][..]));
    let column = [ExpectedColumn::new("x", ColumnKind::Number, true)];
    let one = |text: &str| {
        read_table("m.csv", text.as_bytes(), &column, &BTreeMap::new(), &[], &Dialect::default(), 9).unwrap()
    };
    assert_eq!(one("x\n1\n2\n").numbers("x"), Some(&[1.0, 2.0][..]));
    assert_eq!(one("\n\nx\n1\n").line(0), Some(4));
    assert_eq!(one("\nx\n1").numbers("x"), Some(&[1.0][..]));
    // It counts where the header holds more of another.
    let table = read("sep=|\npose|q1|x\na,b|1|2\n").unwrap();
    assert_eq!(table.numbers("x"), Some(&[2.0][..]));
    assert_eq!(read("sep=\t\nq1\tx\n1\t2\n").unwrap().numbers("x"), Some(&[2.0][..]));
    let twice = read_as(b"sep=;\nq1;x\n1;2\n", Some(','), None).unwrap_err();
    assert!(told(&twice).contains("`sep=;`, and the campaign `csv: {delimiter: \",\"}`"), "{}", told(&twice));
    assert!(read_as(b"sep=,\nq1,x\n1,2\n", None, Some(',')).is_err(), "the decimal sign cannot separate columns");
}

#[test]
fn comments_are_passed_over_and_places_stay_those_of_the_file() {
    let text = "# tracker, 22.4 degC\n// \"not closed\n\npose,q1,x\n  # a note\na,1,2\n#\nb,3,4\n";
    let table = read(text).unwrap();
    assert_eq!((table.row_count(), table.line(0), table.line(1)), (2, Some(6), Some(8)));
    let place = table.place(1, "x").unwrap();
    assert_eq!((place.line, place.column, place.excerpt.as_str()), (8, 5, "b,3,4"));
    assert!(table.notes().is_empty());
    // A row in a comment is worth a word; a quoted text that begins with the mark is none.
    let table = read("pose,q1,x\n#a,1,2\nb,3,4\n# c, 5, 6\n\"#d\",7,8\n\"e\n#f\",9,10\n").unwrap();
    assert_eq!(table.numbers("q1"), Some(&[3.0, 7.0, 9.0][..]));
    let notes = told(table.notes());
    assert_eq!(notes.lines().count(), 1);
    assert!(notes.starts_with("2:1 [#a,1,2] 2 rows are passed over as a comment, the first of them here"), "{notes}");
    // A column may be called so.
    let table = read_table(
        "m.csv",
        &b"#,q1,x\n1,2,3\n"[..],
        &expected(),
        &BTreeMap::new(),
        &["#".into()],
        &Dialect::default(),
        9,
    );
    assert_eq!(table.unwrap().row_count(), 1);
    // A header behind the mark is not guessed at.
    let mut faults = read("# from the tracker\n# q1 x\n1 2\n3 4\n").unwrap_err();
    let fault = faults.pop().unwrap();
    assert!(fault.remedy.as_deref().unwrap().contains("remove its mark"), "{fault:?}");
    assert_eq!(fault.related.first().map(|(place, _)| place.line), Some(2));
}

#[test]
fn columns_may_be_set_apart_by_blanks() {
    let text = "  pose     q1        x \r\n  a      0.5     -2e-3\r\n \"b c\"\t 1        4  \r\n\r\n# end\r\n";
    let table = read(text).unwrap();
    assert_eq!(table.numbers("q1"), Some(&[0.5, 1.0][..]));
    assert_eq!(table.numbers("x"), Some(&[-2e-3, 4.0][..]));
    assert_eq!(table.texts("pose").unwrap().texts(), ["a", "b c"]);
    let place = table.place(1, "x").unwrap();
    assert_eq!((place.line, place.column, &place.excerpt[place.highlight]), (3, 18, "4"));
    assert_eq!(read("q1 x\n1,5 2,5\n").unwrap().numbers("q1"), Some(&[1.5][..]), "a decimal comma");
    assert_eq!(read_as(b"q1 \t x\n1\t\t2\n", Some(' '), None).unwrap().numbers("x"), Some(&[2.0][..]));
    assert_eq!(refused("pose q1   x\na  oops  1\n").lines().next().unwrap().split(" col").next(), Some("2:4 [oops]"));
    assert!(refused("pose q1 x\na 1\n").starts_with("2:4 [] 2 fields in this row, expected 3"));
    assert!(refused("pose q1 x\n\"a 1 2\n").contains("[\"] this quote is never closed"));
}

#[test]
fn a_row_of_units_counts_for_its_columns() {
    let table = read("pose,q1,x,time,temperature\n-,[rad],(in),min,degC\na,1,2,3,20\nb,0.5,-1,0,21\n").unwrap();
    assert_eq!((table.row_count(), table.line(0)), (2, Some(3)));
    let close = |column: &str, values: [f64; 2]| {
        let found = table.numbers(column).unwrap();
        assert!(found.iter().zip(values).all(|(a, b)| (a - b).abs() < 1e-12), "{column}: {found:?}");
    };
    close("q1", [180.0 / std::f64::consts::PI, 90.0 / std::f64::consts::PI]);
    close("x", [50.8, -25.4]);
    close("time", [180.0, 0.0]);
    close("temperature", [20.0, 21.0]);
    // What is declared and differs is said; the SI unit may be what nobody declared.
    let notes = told(table.notes());
    assert_eq!(notes.lines().count(), 1, "{notes}");
    let said =
        "2:3 [[rad]] the row of units says rad where deg is declared, of `q1`, and in where mm is declared, of `x`;";
    assert!(notes.starts_with(said), "{notes}");
    for row in ["\u{b0};mm", "degrees;Millimeters", "deg;", ";mm", "deg;-"] {
        let table = read(&format!("q1;x\n{row}\n1;2\n")).unwrap();
        assert_eq!((table.numbers("x"), table.notes().len()), (Some(&[2.0][..]), 0), "{row}");
    }
    assert!(refused("q1,x\ndeg,furlong\n1,2\n").starts_with("2:5 [furlong] `furlong` is no unit of lengths"));
    let fault = refused("q1,x\nmm,mm\n1,2\n");
    assert!(fault.starts_with("2:1 [mm] the column `q1` holds angles, and its unit is `mm`"), "{fault}");
    assert!(refused("q1,x,temperature\ndeg,mm,s\n1,2,3\n").contains("`temperature` is read as it is"));
    // Only the first row can be one of units.
    assert!(refused("q1,x\n1,2\ndeg,mm\n").contains("must hold a finite number, found `deg`"));
}

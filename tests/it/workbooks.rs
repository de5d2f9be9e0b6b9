//! Workbooks: sheets read like any other table, faults named by cells, and tables written as sheets.

use std::collections::BTreeMap;

use elastogeo::description::table::{ColumnKind, Dialect, ExpectedColumn, Sheet, Table, read_table};
use elastogeo::description::units::{Angle, Length, Unit};
use elastogeo::diagnostic::Diagnostic;
use rust_xlsxwriter::{Format, Formula, Workbook, Worksheet};

use super::cli::{PLANAR, run};

fn expected() -> Vec<ExpectedColumn> {
    let column = |name: &str, kind, required| ExpectedColumn::new(name, kind, required);
    vec![
        column("pose", ColumnKind::Text, false),
        column("q1", ColumnKind::Quantity(Unit::Angle(Angle::Degree)), true),
        column("x", ColumnKind::Quantity(Unit::Length(Length::Millimetre)), true),
    ]
}

fn read(file: &str, bytes: &[u8]) -> Result<Table, Vec<Diagnostic>> {
    let dialect = Dialect { delimiter: Some('\t'), decimal: Some(','), of_campaign: true, ..Dialect::default() };
    read_table(file, bytes, &expected(), &BTreeMap::new(), &["note".into()], &dialect, 1000)
}

type Fill<'a> = &'a dyn Fn(&mut Worksheet);

/// A workbook of sheets, each filled by a function.
fn workbook(sheets: &[(&str, Fill)]) -> Vec<u8> {
    let mut workbook = Workbook::new();
    for (name, fill) in sheets {
        let sheet = workbook.add_worksheet();
        sheet.set_name(*name).expect("a name");
        fill(sheet);
    }
    workbook.save_to_buffer().expect("written")
}

fn header(sheet: &mut Worksheet, line: u32, left: u16) {
    for (at, name) in (left..).zip(["pose", "q1", "x", "note"]) {
        sheet.write(line, at, name).expect("written");
    }
}

/// The first fault as `place message`.
fn refused(file: &str, bytes: &[u8]) -> String {
    read(file, bytes).unwrap_err().first().map(ToString::to_string).unwrap_or_default()
}

fn sound(sheet: &mut Worksheet) {
    sheet.write(0, 2, "# from the tracker").expect("written");
    header(sheet, 2, 2);
    sheet.write(3, 3, "rad").expect("written").write(3, 4, "mm").expect("written");
    sheet.write(4, 2, 7).expect("written").write(4, 3, 0.1 + 0.2).expect("written");
    sheet.write(4, 4, Formula::new("=1/3").set_result("0.333333333333333314829616256247")).expect("written");
    sheet
        .write(6, 2, "a;\"b\"\nc")
        .expect("written")
        .write(6, 3, -1e-17)
        .expect("written")
        .write(6, 4, 2)
        .expect("written");
    sheet.write(6, 5, "seen; twice").expect("written");
}

#[test]
fn a_sheet_is_read_with_all_digits() {
    let bytes = workbook(&[("Empty", &|_| {}), ("Day 1", &sound)]);
    for file in ["m.xlsx", "dir/m.XLSX", "m.xlsx#Day 1"] {
        let table = read(file, &bytes).unwrap();
        let degrees = 180.0 / std::f64::consts::PI;
        assert_eq!(table.row_count(), 2);
        let q = table.numbers("q1").unwrap();
        assert!((q[0] / (0.1 + 0.2) / degrees - 1.0).abs() < 1e-15 && (q[1] / -1e-17 / degrees - 1.0).abs() < 1e-15);
        assert_eq!(table.numbers("x"), Some(&[1.0 / 3.0, 2.0][..]));
        let poses = table.texts("pose").unwrap();
        assert_eq!((poses.get(0), poses.get(1)), (Some("7"), Some("a;\"b\" c")));
        assert!(table.notes().len() == 1, "rad is said");
        let place = table.place(1, "x").unwrap();
        assert_eq!((place.address().rsplit('#').next(), place.line, place.column), (Some("Day 1!E7"), 7, 5));
    }
}

#[test]
fn faults_are_named_by_their_cells() {
    let with = |line: u32, column: u16, text: &'static str| {
        move |sheet: &mut Worksheet| {
            header(sheet, 0, 0);
            for row in 1..4 {
                sheet.write(row, 0, "p").expect("written").write(row, 1, 1).expect("written");
                sheet.write(row, 2, 2).expect("written");
            }
            if text.is_empty() {
                sheet.write_blank(line, column, &Format::new()).expect("written");
            } else {
                sheet.write(line, column, text).expect("written");
            }
        }
    };
    let one = |fill: &dyn Fn(&mut Worksheet)| workbook(&[("S", fill)]);
    let cases: [(u32, u16, &str, &str, &str); 6] = [
        (2, 1, "1,5", "m.xlsx#S!B3: ", "make the cell a number"),
        (3, 2, "oops", "m.xlsx#S!C4: ", "found `oops`"),
        (2, 2, "", "m.xlsx#S!C3: ", "empty cell in column `x`"),
        (0, 2, "X", "m.xlsx#S!C1: ", "the column `x` is missing"),
        (0, 26, "extra", "m.xlsx#S!AA1: ", "unknown column `extra`"),
        (2, 4, "9", "m.xlsx#S!E3: ", "5 fields in this row"),
    ];
    for (line, column, text, place, message) in cases {
        let mut faults = read("m.xlsx", &one(&with(line, column, text))).unwrap_err();
        faults.retain(|fault| fault.to_string().starts_with(place) && fault.to_string().contains(message));
        assert_eq!(faults.len(), 1, "{place} {message}: {:?}", read("m.xlsx", &one(&with(line, column, text))));
        let drawn = elastogeo::render::diagnostics::render(&faults, false);
        assert!(drawn.contains(&format!("--> {}", place.trim_end_matches(": "))), "{drawn}");
    }
    let date = one(&|sheet| {
        header(sheet, 0, 0);
        let date = Format::new().set_num_format("d mmm");
        sheet
            .write(1, 0, "p")
            .expect("written")
            .write(1, 1, 1)
            .expect("written")
            .write_with_format(1, 2, 45_000.5, &date)
            .expect("written");
    });
    assert!(
        refused("m.xlsx", &date)
            .contains("m.xlsx#S!C2: error: column `x` must hold a finite number, found `2023-03-15 12:00:00`")
    );
}

#[test]
fn what_is_no_single_sheet_is_refused() {
    let two = workbook(&[("One", &sound), ("Two", &sound), ("Empty", &|_| {})]);
    assert!(refused("m.xlsx", &two).contains("the sheets `One`, `Two`, and none is named (name one: `m.xlsx#One`)"));
    assert!(read("m.xlsx#Two", &two).is_ok());
    assert!(refused("m.xlsx#Tow", &two).contains("no sheet `Tow` (did you mean `Two`?)"));
    assert!(refused("m.xlsx", &workbook(&[("A", &|_| {})])).contains("no sheet of the workbook holds anything"));
    assert!(refused("m.xlsx", b"pose,q1,x\n1,2,3\n").contains("this is no workbook that can be read"));
    assert!(refused("m.csv", &two).contains("the file is a workbook or an archive"));
    // Cut short or damaged, it is refused or read, and never stops the program.
    for cut in (0..two.len()).step_by(97) {
        let _ = read("m.xlsx#One", &two[..cut]);
        let mut damaged = two.clone();
        damaged[cut] ^= 0x5a;
        let _ = read("m.xlsx#One", &damaged);
    }
    // The farthest cell of a sheet takes no memory.
    let far = workbook(&[("S", &|sheet| {
        header(sheet, 0, 0);
        sheet.write(1_048_575, 16_383, 1).expect("written");
    })]);
    assert!(refused("m.xlsx", &far).contains("m.xlsx#S!"), "{}", refused("m.xlsx", &far));
}

#[test]
fn what_is_written_as_a_sheet_is_read_back() {
    let names = ["007", "1.10", "plain"];
    let mut sheet = Sheet::new();
    sheet.texts("pose", |row| names[row].into());
    sheet.column("q1", |row| (row as f64 / 3.0).to_string());
    sheet.column("x", |row| format!("{:.3}", row as f64 * 0.125));
    let bytes = sheet.file(std::path::Path::new("out.xlsx"), 0..3).expect("written");
    let table = read("out.xlsx", &bytes).unwrap();
    assert_eq!(table.texts("pose").unwrap().texts(), names);
    assert_eq!(table.numbers("q1"), Some(&[0.0, 1.0 / 3.0, 2.0 / 3.0][..]));
    assert_eq!(table.numbers("x"), Some(&[0.0, 0.125, 0.25][..]));
}

/// The same campaign from a CSV and from the workbook of its rows; and every table that a command writes.
#[test]
fn commands_read_and_write_workbooks() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let ran = |arguments: &[&str]| {
        let ran = run(folder.path(), arguments);
        assert_eq!(ran.status, 0, "{arguments:?}\n{}", ran.err);
        ran
    };
    std::fs::write(at("arm.yaml"), PLANAR).expect("written");
    ran(&["simulate", "arm.yaml", "--poses", "12", "--into", "c"]);
    let csv = std::fs::read_to_string(at("c/measurements.csv")).expect("read");
    let bytes = workbook(&[("Readings", &|sheet| {
        for (row, line) in (0..).zip(csv.lines()) {
            for (column, cell) in (0..).zip(line.split(',')) {
                match cell.parse::<f64>() {
                    Ok(number) => sheet.write(row, column, number).expect("written"),
                    Err(_) => sheet.write(row, column, cell).expect("written"),
                };
            }
        }
    })]);
    std::fs::write(at("c/readings.xlsx"), bytes).expect("written");
    let yaml = std::fs::read_to_string(at("c/campaign.yaml")).expect("read");
    let of_workbook = yaml.replace("measurements.csv", "readings.xlsx#Readings");
    assert_ne!(yaml, of_workbook);
    std::fs::write(at("c/book.yaml"), of_workbook).expect("written");
    // The same but for the name of the file in which a reading stands.
    let residuals = |campaign: &str, file: &str| {
        ran(&["residuals", "arm.yaml", campaign, "--format", "json"]).out.replace(file, "FILE")
    };
    assert_eq!(
        residuals("c/campaign.yaml", "c/measurements.csv"),
        residuals("c/book.yaml", "c/readings.xlsx#Readings")
    );

    ran(&["residuals", "arm.yaml", "c", "--table", "r.csv"]);
    ran(&["residuals", "arm.yaml", "c", "--table", "r.xlsx"]);
    ran(&["identify", "c", "--table", "p.csv"]);
    ran(&["identify", "c", "--table", "p.xlsx"]);
    ran(&["plan", "arm.yaml", "--poses", "8", "--table", "poses.xlsx"]);
    ran(&["plan", "arm.yaml", "--poses", "8", "--table", "poses.csv"]);
    ran(&["compensate", "arm.yaml", "poses.xlsx", "--table", "corrected.xlsx"]);
    ran(&["compensate", "arm.yaml", "poses.csv", "--table", "corrected.csv"]);
    assert_eq!(
        ran(&["pose", "arm.yaml", "--table", "poses.csv"]).out,
        ran(&["pose", "arm.yaml", "--table", "poses.xlsx"]).out
    );
    let mut compared = 0;
    for (name, texts) in [
        ("r", &["pose", "marker", "set"][..]),
        ("p", &["parameter", "unit", "estimated", "at_bound"][..]),
        ("poses", &["pose"][..]),
        ("corrected", &["pose"][..]),
    ] {
        let text = std::fs::read_to_string(at(&format!("{name}.csv"))).expect("read");
        let header: Vec<&str> = text.lines().next().expect("a header").split(',').collect();
        let column = |column: &&str| {
            let kind = if texts.contains(column) { ColumnKind::Text } else { ColumnKind::Number };
            ExpectedColumn::new(*column, kind, true)
        };
        // An interval is empty where nothing was estimated.
        let expected: Vec<_> = header.iter().filter(|name| **name != "ci95").map(column).collect();
        let read = |file: String, bytes: &[u8]| {
            let ignore = ["ci95".to_owned()];
            read_table(&file, bytes, &expected, &BTreeMap::new(), &ignore, &Dialect::default(), 1000).expect("read")
        };
        let csv = read(format!("{name}.csv"), text.as_bytes());
        let book = read(format!("{name}.xlsx"), &std::fs::read(at(&format!("{name}.xlsx"))).expect("read"));
        assert_eq!(csv.row_count(), book.row_count());
        for column in &expected {
            assert_eq!(csv.numbers(&column.name), book.numbers(&column.name), "{name}: {}", column.name);
            assert_eq!(csv.texts(&column.name), book.texts(&column.name), "{name}: {}", column.name);
            compared += 1;
        }
    }
    assert!(compared > 20, "{compared} columns");
    // Residuals of the table are those of the JSON.
    let json: serde_json::Value =
        serde_json::from_str(&residuals("c/campaign.yaml", "c/measurements.csv")).expect("JSON");
    let text = std::fs::read_to_string(at("r.csv")).expect("read");
    let second: Vec<&str> = text.lines().nth(2).expect("a row").split(',').collect();
    let error = json.pointer("/readings/1/error/0").and_then(serde_json::Value::as_f64).expect("a number");
    let at_x = text.lines().next().expect("a header").split(',').position(|name| name == "error.x").expect("a column");
    assert!((second[at_x].parse::<f64>().expect("a number") - error).abs() < 1e-9);

    let refused = run(folder.path(), &["plan", "arm.yaml", "--poses", "8", "--table", "poses.ods"]);
    assert!(
        refused.status == 2 && refused.err.contains("give a name that ends in .xlsx, or in .csv"),
        "{}",
        refused.err
    );
    let over = run(folder.path(), &["compensate", "arm.yaml", "poses.xlsx", "--table", "poses.xlsx"]);
    assert!(over.status == 2 && over.err.contains("written over"), "{}", over.err);
}

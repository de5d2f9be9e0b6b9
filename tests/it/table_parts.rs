//! What files split: joints in one, points in another; and orientations as programs write them.

use std::collections::BTreeMap;

use elastogeo::description::table::{
    ColumnKind, Dialect, ExpectedColumn, Join, Orientation, Points, QuaternionOrder, Table, read_table,
};
use elastogeo::description::units::{Angle, Length, Unit};
use elastogeo::diagnostic::Diagnostic;
use nalgebra::{Matrix3, Vector3};

const DEGREES: Unit = Unit::Angle(Angle::Degree);

fn column(name: &str, unit: Unit, required: bool) -> ExpectedColumn {
    ExpectedColumn::new(name, ColumnKind::Quantity(unit), required)
}

fn text(name: &str) -> ExpectedColumn {
    ExpectedColumn::new(name, ColumnKind::Text, false)
}

fn read_with(
    file: &str,
    bytes: &str,
    expected: &[ExpectedColumn],
    dialect: &Dialect,
) -> Result<Table, Vec<Diagnostic>> {
    read_table(file, bytes.as_bytes(), expected, &BTreeMap::new(), &[], dialect, 1000)
}

fn of_campaign() -> Dialect {
    Dialect { of_campaign: true, ..Dialect::default() }
}

fn told(diagnostics: &[Diagnostic]) -> String {
    diagnostics.iter().map(|diagnostic| diagnostic.to_string() + "\n").collect()
}

fn readings(bytes: &str) -> Table {
    let expected = [text("pose"), text("marker"), column("x", Unit::Length(Length::Millimetre), true)];
    read_with("points.csv", bytes, &expected, &of_campaign()).unwrap()
}

fn joints(bytes: &str) -> Table {
    let expected = [text("pose"), column("q1", DEGREES, true), column("x", DEGREES, false)];
    read_with("joints.csv", bytes, &expected, &of_campaign()).unwrap()
}

#[test]
fn joints_are_joined_by_name() {
    let (points, angles) = ("pose,marker,x\nb,m,1\na,m,2\nb,n,3\n", "# robot\npose,q1\na,10\nc,30\nb,20\n");
    let table = readings(points).with_joints(joints(angles), None).unwrap();
    assert_eq!(table.numbers("q1"), Some(&[20.0, 10.0, 20.0][..]));
    assert_eq!(table.numbers("x"), Some(&[1.0, 2.0, 3.0][..]));
    assert_eq!(table.texts("pose").unwrap().get(2), Some("b"));
    // A fault of a joint is one of the file of joints.
    let place = table.place(2, "q1").unwrap();
    assert_eq!((place.file.as_str(), place.line, &place.excerpt[place.highlight]), ("joints.csv", 5, "20"));
    assert_eq!(table.place(2, "x").unwrap().file, "points.csv");
    assert!(
        table.has("q1") && told(table.notes()).contains("joints.csv:4:1: warning: 1 pose has joints and no reading")
    );
    // As said, by order: the first name of the readings has the first row.
    let table =
        readings("pose,x\nu,1\nv,2\nu,3\n").with_joints(joints("pose,q1\na,10\nb,20\n"), Some(Join::Order)).unwrap();
    assert_eq!(table.numbers("q1"), Some(&[10.0, 20.0, 10.0][..]));
}

#[test]
fn joints_are_joined_by_session_and_name_where_both_name_sessions() {
    let expected = [text("pose"), text("session"), column("x", Unit::Length(Length::Millimetre), true)];
    let angles = [text("pose"), text("session"), column("q1", DEGREES, true)];
    let joined = |points: &str, joints: &str, how| {
        let read = |file, bytes: &str, expected: &[ExpectedColumn]| {
            read_with(file, bytes, expected, &of_campaign()).expect("read")
        };
        read("points.csv", points, &expected).with_joints(read("joints.csv", joints, &angles), how)
    };
    let joints = "session,pose,q1\nfriday,a,30\nmonday,a,10\nmonday,b,20\n";
    let table = joined("session,pose,x\nmonday,b,1\nmonday,a,2\nfriday,a,3\n", joints, None).expect("joined");
    assert_eq!(table.numbers("q1"), Some(&[20.0, 10.0, 30.0][..]));
    let lacking = told(&joined("session,pose,x\nfriday,b,1\n", joints, None).expect_err("refused"));
    let expected_words = "points.csv:2:8: error: the pose `b` of session `friday` has readings";
    assert!(lacking.contains(expected_words) && lacking.lines().count() == 1, "{lacking}");
    let twice = "session,pose,q1\nmonday,a,1\nmonday,a,2\n";
    let twice = told(&joined("session,pose,x\nmonday,a,1\n", twice, None).expect_err("refused"));
    assert!(
        twice.contains("joints.csv:3:8: error: the pose `a` of session `monday` has two rows of joints"),
        "{twice}"
    );
    let both = joined("session,pose,x\nmonday,a,1\n", "session,pose,q1\nmonday,a,1\n", Some(Join::Order));
    assert!(told(&both.expect_err("refused")).contains("the column `session` is in"));
}

#[test]
fn joints_are_joined_by_order_where_names_are_lacking() {
    let table = readings("x\n1\n2\n").with_joints(joints("pose,q1\na,10\nb,20\n"), None).unwrap();
    assert_eq!(table.numbers("q1"), Some(&[10.0, 20.0][..]));
    assert_eq!(table.texts("pose").unwrap().texts(), ["a", "b"], "names of the joints hold for the readings");
    let table = readings("pose,x\na,1\nb,2\na,3\n").with_joints(joints("q1\n10\n20\n"), None).unwrap();
    assert_eq!(table.numbers("q1"), Some(&[10.0, 20.0, 10.0][..]));
}

#[test]
fn what_does_not_fit_together_is_refused_with_its_place() {
    let refused =
        |points: &str, angles: &str, how| told(&readings(points).with_joints(joints(angles), how).unwrap_err());
    let lacking = refused("pose,x\np01,1\np2,2\np3,3\np3,4\n", "pose,q1\np1,1\np2,2\n", None);
    assert!(lacking.contains("points.csv:2:1: error: the pose `p01` has readings, and `joints.csv` has no joints of it (did you mean `p1`?)"), "{lacking}");
    assert!(lacking.contains("points.csv:4:1: error: the pose `p3`") && lacking.lines().count() == 2, "{lacking}");
    let twice = refused("pose,x\na,1\n", "pose,q1\na,1\nb,2\na,3\n", None);
    assert!(twice.contains("joints.csv:4:1: error: the pose `a` has two rows of joints"), "{twice}");
    let counts = refused("x\n1\n2\n3\n", "q1\n1\n2\n", None);
    assert!(
        counts.contains("points.csv:4:1: error: `points.csv` has 3 readings, and `joints.csv` 2 rows of joints"),
        "{counts}"
    );
    let counts = refused("pose,x\na,1\na,2\n", "q1\n1\n2\n3\n", None);
    assert!(counts.contains("joints.csv:3:1") || counts.contains("joints.csv:4:1"), "{counts}");
    assert!(counts.contains("2 readings of 1 poses"), "{counts}");
    let unnamed = refused("x\n1\n", "pose,q1\na,1\n", Some(Join::Name));
    assert!(unnamed.contains("`points.csv` has no column `pose`"), "{unnamed}");
    let both = refused("x\n1\n", "q1,x\n1,2\n", None);
    assert!(both.contains("points.csv:2:1: error: the column `x` is in `points.csv` and in `joints.csv`"), "{both}");
}

fn points(bytes: &str, points: Points) -> Result<Table, Vec<Diagnostic>> {
    let millimetres = Unit::Length(Length::Millimetre);
    let expected = [
        text("pose"),
        text("marker"),
        column("x", millimetres, true),
        column("y", millimetres, true),
        column("z", millimetres, true),
        column("time", Unit::named("s").unwrap(), false),
    ];
    read_with("list.txt", bytes, &expected, &Dialect { points: Some(points), ..of_campaign() })
}

fn taken(pairs: &[(&str, &str)], fields: &[&str]) -> Points {
    let columns = pairs.iter().map(|(ours, field)| ((*ours).to_owned(), (*field).to_owned())).collect();
    Points { columns, fields: fields.iter().map(ToString::to_string).collect() }
}

#[test]
fn lists_of_points_are_read() {
    let by_group = || taken(&[("pose", "name"), ("marker", "group")], &[]);
    let variants = [
        "// SA 2024\n// Frame: WORLD\nA\tSMR 1\tp1\t1.5\t2\t-3e0\nA\tSMR 2\tp2\t4\t5\t6\n",
        "A,SMR 1,p1,1.5,2,-3.0\n;later\nA,SMR 2,p2,4,5,6\n",
        "Collection,Group Name,Point Name,X,Y,Z\r\nA,SMR 1,p1,1.5,2,-3\r\nA,SMR 2,p2,4,5,6\r\n",
        "# x\n\"SMR 1\"  p1  1.5   2 -3\n\"SMR 2\"  p2  4 5 6\n",
        // As many decimal commas as separators.
        "A;SMR 1;p1;1,5;2,0;-3,0e0\nA;SMR 2;p2;4,0;5,0;6,0\n",
        "SMR 1\tp1\t1,50\t2,00\t-3,00\nSMR 2\tp2\t4,00\t5,00\t6,00\n",
    ];
    for text in variants {
        let table = points(text, by_group()).unwrap_or_else(|faults| panic!("{text}\n{}", told(&faults)));
        assert_eq!(table.numbers("x"), Some(&[1.5, 4.0][..]), "{text}");
        assert_eq!(table.numbers("z"), Some(&[-3.0, 6.0][..]), "{text}");
        assert_eq!(table.texts("pose").unwrap().texts(), ["p1", "p2"]);
        assert_eq!(table.texts("marker").unwrap().texts(), ["SMR 1", "SMR 2"]);
    }
    let bare = points("1 2 3\n4 5 6\n", Points::default()).unwrap();
    assert!(bare.numbers("y") == Some(&[2.0, 5.0][..]) && bare.texts("pose").is_none());
    let timed =
        points("p1;0.5;1;2;3\np2;0.7;4;5;6\n", taken(&[("pose", "name")], &["name", "time", "x", "y", "z"])).unwrap();
    assert_eq!((timed.numbers("time"), timed.numbers("z")), (Some(&[0.5, 0.7][..]), Some(&[3.0, 6.0][..])));
    assert_eq!(timed.line(0), Some(1));
    for (text, from, message) in [
        ("p1 1.0 2.0 3.0 0.1\n", Points::default(), "this is no point as expected"),
        ("1 2 3 4 5 6 7\n", Points::default(), "list.txt:1:1: error: this is no point"),
        (
            "p1 1 2 3\n",
            by_group(),
            "takes `marker` from the field `group`, which the lines do not have (they have name)",
        ),
        ("p1 1 2 3\np2 1 2\n", Points::default(), "list.txt:2:7: error: 3 fields in this row, expected 4"),
        ("p1 1 2 3\np2 1 oops 3\n", Points::default(), "list.txt:2:6: error: column `y` must hold a finite number"),
        ("p1 1 2 3\n", taken(&[("pose", "name")], &["name", "x", "y"]), "`fields:` names 3, and the line has 4"),
        ("name,X,Y,Z,Quality\np1,1,2,3,4\n", Points::default(), "unknown column `Quality`"),
    ] {
        let faults = told(&points(text, from).unwrap_err());
        assert!(faults.contains(message), "`{message}` is not said of {text}:\n{faults}");
    }
}

/// Axis of a rotation matrix times its angle, from the antisymmetric part and the trace.
fn vector_of(matrix: &Matrix3<f64>) -> Vector3<f64> {
    let axis =
        Vector3::new(matrix[(2, 1)] - matrix[(1, 2)], matrix[(0, 2)] - matrix[(2, 0)], matrix[(1, 0)] - matrix[(0, 1)]);
    let angle = axis.norm().atan2(matrix.trace() - 1.0);
    axis.normalize() * angle
}

/// About z by a, then y' by b, then x'' by c, element by element.
fn kuka(a: f64, b: f64, c: f64) -> Matrix3<f64> {
    let ((sa, ca), (sb, cb), (sc, cc)) = (a.sin_cos(), b.sin_cos(), c.sin_cos());
    Matrix3::new(
        ca * cb,
        ca * sb * sc - sa * cc,
        ca * sb * cc + sa * sc,
        sa * cb,
        sa * sb * sc + ca * cc,
        sa * sb * cc - ca * sc,
        -sb,
        cb * sc,
        cb * cc,
    )
}

fn vectors(orientation: Orientation, bytes: &str) -> Result<Vec<Vector3<f64>>, Vec<Diagnostic>> {
    let vector = ["rx", "ry", "rz"].map(|name| column(name, DEGREES, true));
    let dialect = Dialect { orientation, ..of_campaign() };
    let mut table = read_with("o.csv", bytes, &orientation.expected(vector.to_vec()), &dialect)?;
    table.add_rotation_vectors(orientation, Angle::Degree)?;
    let [x, y, z] = ["rx", "ry", "rz"].map(|name| table.numbers(name).unwrap().to_vec());
    Ok((0..x.len()).map(|row| Vector3::new(x[row], y[row], z[row]).map(f64::to_radians)).collect())
}

#[test]
fn every_way_to_write_an_orientation_says_the_same() {
    for (a, b, c) in [(0.3, -0.7, 1.9), (-2.8, 1.2, 0.1), (3.0, 0.02, -2.5), (1e-4, -2e-4, 3e-4)] {
        let matrix = kuka(a, b, c);
        let expected = vector_of(&matrix);
        let close = |found: Result<Vec<Vector3<f64>>, Vec<Diagnostic>>, what: &str| {
            let found = found.unwrap_or_else(|faults| panic!("{what}: {}", told(&faults)))[0];
            assert!((found - expected).norm() < 1e-9, "{what}: {found} {expected}");
        };
        let degrees = [a, b, c].map(f64::to_degrees);
        let [da, db, dc] = degrees;
        close(vectors(Orientation::KukaAbc, &format!("A,B,C\n{da},{db},{dc}\n")), "ABC");
        close(vectors(Orientation::KukaAbc, &format!("A,B,C\nrad,rad,rad\n{a},{b},{c}\n")), "ABC in rad");
        close(vectors(Orientation::RollPitchYaw, &format!("yaw,roll,pitch\n{da},{dc},{db}\n")), "RPY");
        let rows: Vec<String> = matrix.transpose().iter().map(f64::to_string).collect();
        let names = "r11,r12,r13,r21,r22,r23,r31,r32,r33";
        close(vectors(Orientation::Matrix, &format!("{names}\n{}\n", rows.join(","))), "matrix");
        // The quaternion by its definition: cos and sin of half the angle.
        let (angle, axis) = (expected.norm(), expected.normalize());
        let (s, w) = (angle / 2.0).sin_cos();
        let [x, y, z] = [axis.x * s, axis.y * s, axis.z * s];
        let xyzw = Orientation::Quaternion(QuaternionOrder::Xyzw);
        let wxyz = Orientation::Quaternion(QuaternionOrder::Wxyz);
        close(vectors(xyzw, &format!("qx,qy,qz,qw\n{x},{y},{z},{w}\n")), "qx..");
        close(vectors(wxyz, &format!("qw,qx,qy,qz\n{},{},{},{}\n", -w, -x, -y, -z)), "the same, negated");
        close(vectors(xyzw, &format!("q0,q1,q2,q3\n{x},{y},{z},{w}\n")), "scalar last");
        close(vectors(wxyz, &format!("q0,q1,q2,q3\n{w},{x},{y},{z}\n")), "scalar first");
        close(
            vectors(
                Orientation::RotationVector,
                &format!(
                    "rx,ry,rz\n{},{},{}\n",
                    expected.x.to_degrees(),
                    expected.y.to_degrees(),
                    expected.z.to_degrees()
                ),
            ),
            "vector",
        );
    }
}

#[test]
fn orientations_that_are_none_or_not_declared_are_refused() {
    let refused = |orientation, bytes: &str| told(&vectors(orientation, bytes).unwrap_err());
    let xyzw = Orientation::Quaternion(QuaternionOrder::Xyzw);
    let long = refused(xyzw, "qx,qy,qz,qw\n0,0,0,1\n0,0,0.05,1\n");
    assert!(long.contains("o.csv:3:1: error: the quaternion has the length 1.001249, and must have 1"), "{long}");
    assert!(vectors(xyzw, "qx,qy,qz,qw\n0,0,0,1.0009\n").is_ok());
    let names = "r11,r12,r13,r21,r22,r23,r31,r32,r33";
    assert!(refused(Orientation::Matrix, &format!("{names}\n1,0,0,0,1,0,0,0,-1\n")).contains("the matrix mirrors"));
    assert!(
        refused(Orientation::Matrix, &format!("{names}\n1,0.01,0,0,1,0,0,0,1\n"))
            .contains("o.csv:2:1: error: the rows of the matrix")
    );
    for (header, remedy) in [
        ("qx,qy,qz,qw", "`orientation: {quaternion: xyzw}` or `orientation: {quaternion: wxyz}`"),
        ("q0,q1,q2,q3", "`orientation: {quaternion: xyzw}` or"),
        ("A,B,C", "`orientation: kuka-abc`"),
        ("roll,pitch,yaw", "`orientation: roll-pitch-yaw`"),
        (names, "`orientation: matrix`"),
    ] {
        let row = vec!["0"; header.split(',').count()].join(",");
        let said = refused(Orientation::RotationVector, &format!("{header}\n{row}\n"));
        assert!(said.contains(remedy) && said.lines().count() == 1, "{header}: {said}");
        assert!(said.starts_with("o.csv:1:1: error: the columns"), "{said}");
    }
    // Joints may be called so: then the components need names of their own.
    let mut expected = xyzw.expected(["rx", "ry", "rz"].map(|name| column(name, DEGREES, true)).to_vec());
    expected.extend(["q1", "q2", "q3"].map(|name| column(name, DEGREES, true)));
    let dialect = Dialect { orientation: xyzw, ..of_campaign() };
    let fault = read_with("o.csv", "q0,q1,q2,q3\n0,0,0,1\n", &expected, &dialect).unwrap_err();
    assert!(told(&fault).contains("the column `qx` is missing"), "{}", told(&fault));
}

const ARM: &str = "robot: arm\nunits: {length: mm, angle: deg}\nvariables: [q1]\nframes:
  1: {antecedent: 0, joint: revolute, variable: q1}
  E: {antecedent: 1, d: 500}
tool: {frame: E}
markers: {a: {frame: E, at: [10, 0, 0]}, b: {frame: E, at: [0, 10, 0]}}
";

/// A campaign about that arm, of files by name; the last is the table.
fn of_arm(entry: &str, files: &[(&str, &str)]) -> Result<Vec<(String, usize, usize, f64)>, String> {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let campaign = "robot: arm.yaml\nunits: {length: mm, angle: deg}\nobserves: position\n";
    files.iter().for_each(|(name, text)| write(name, text));
    write("arm.yaml", ARM);
    write("campaign.yaml", &format!("{campaign}measurements: {entry}\n"));
    let name = folder.path().join("campaign.yaml");
    let loaded = elastogeo::files::load_campaign(name.to_str().unwrap(), None).map_err(|faults| faults.to_string())?;
    let campaign = loaded.campaign;
    let seen = campaign.readings.iter().map(|reading| {
        let marker = reading.marker.map_or("TCP".to_owned(), |marker| loaded.robot.robot.markers[marker].name.clone());
        (marker, reading.pose, reading.line, (1e3 * reading.measured[1]).round())
    });
    Ok(seen.collect())
}

#[test]
fn several_markers_in_a_row_are_readings_of_one_configuration() {
    let log = "q1,a_x,a_y,a_z,TCP_x,TCP_y,TCP_z\n0,510,1,0,500,2,0\n90,0,513,0,0,504,0\n";
    let found = of_arm("{file: log.csv, markers: [a, TCP]}", &[("log.csv", log)]).unwrap();
    let of = |marker: &str, pose, line, y| (marker.to_owned(), pose, line, y);
    let expected = vec![of("a", 0, 2, 1.0), of("TCP", 0, 2, 2.0), of("a", 1, 3, 513.0), of("TCP", 1, 3, 504.0)];
    assert_eq!(found, expected);
    // With the joints in a file of their own, by order, and after a file with one marker in a row.
    let (points, joints) = ("a_x,a_y,a_z,b_x,b_y,b_z\n510,1,0,500,12,0\n0,513,0,-10,504,0\n", "q1\n0\n90\n");
    let long = "q1,marker,x,y,z\n30,b,1,7,0\n";
    let entries = "[long.csv, {file: points.csv, joints: joints.csv, markers: [a, b]}]";
    let found = of_arm(entries, &[("points.csv", points), ("joints.csv", joints), ("long.csv", long)]).unwrap();
    let wide = [of("a", 1, 2, 1.0), of("b", 1, 2, 12.0), of("a", 2, 3, 513.0), of("b", 2, 3, 504.0)];
    assert_eq!(found, [vec![of("b", 0, 2, 7.0)], wide.to_vec()].concat());
}

#[test]
fn faults_of_several_markers_in_a_row_are_told() {
    let log = "q1,a_x,a_y,a_z,c_x,c_y,c_z\n0,510,0,0,500,10,0\n";
    let told = |entry: &str| of_arm(entry, &[("log.csv", log)]).unwrap_err();
    assert!(told("{file: log.csv, markers: [a, b]}").contains("`b_x`"), "{}", told("{file: log.csv, markers: [a, b]}"));
    assert!(told("{file: log.csv, markers: [a, c]}").contains("unknown marker `c`"));
    assert!(told("{file: log.csv, markers: [a, c, a]}").contains("`markers:` names `a` twice"));
    assert!(told("{file: log.csv, markers: [a]}").contains("c_x"));
    // What stands there under another name is not asked for.
    assert!(told("log.csv").contains("markers: [a, c]}`"), "{}", told("log.csv"));
    let commanded = of_arm("log.csv", &[("log.csv", "commanded.q1,recorded.q1,x,y,z\n0,0,500,0,0\n")]).unwrap_err();
    assert!(
        commanded.contains("`commanded.q1` and `recorded.q1`") && commanded.contains("`joints: commanded`"),
        "{commanded}"
    );
    // A marker that was not seen is no reading; half of one is a fault.
    let hidden = "q1,a_x,a_y,a_z,b_x,b_y,b_z\n0,510,1,0,,,\n90,0,513,0,-10,504,0\n";
    let entry = "{file: log.csv, markers: [a, b]}";
    let lines: Vec<(String, usize)> = of_arm(entry, &[("log.csv", hidden)])
        .expect("readings")
        .into_iter()
        .map(|(marker, _, line, _)| (marker, line))
        .collect();
    assert_eq!(lines, [("a".to_owned(), 2), ("a".to_owned(), 3), ("b".to_owned(), 3)]);
    let half = of_arm(entry, &[("log.csv", &hidden.replace(",,,", ",500,,"))]).unwrap_err();
    assert!(half.contains("log.csv:2") && half.contains("`b_y`, where the row has others"), "{half}");
    let none = of_arm(entry, &[("log.csv", "q1,a_x,a_y,a_z,b_x,b_y,b_z\n0,,,,,,\n")]).unwrap_err();
    assert!(none.contains("no row holds a reading"), "{none}");
    let torques = of_arm("{file: log.csv, observes: torque, markers: [a]}", &[("log.csv", "q1,torque.q1\n0,1\n")]);
    assert!(torques.unwrap_err().contains("`markers:` means nothing here"));
}

//! One tiny broken URDF a mistake: what is said of it, and where.

use std::fmt::Write;

use elastogeo::description::urdf::{export, import};
use elastogeo::diagnostic::{Diagnostic, Severity};
use proptest::prelude::*;

/// A sound robot of two joints, to be broken.
const SOUND: &str = r#"<robot name="r">
  <link name="base"/>
  <link name="arm">
    <inertial>
      <origin xyz="0 0 0.1"/>
      <mass value="2"/>
      <inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/>
    </inertial>
  </link>
  <link name="hand"/>
  <joint name="first" type="revolute">
    <parent link="base"/>
    <child link="arm"/>
    <origin xyz="0 0 1" rpy="0 0 0"/>
    <axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/>
  </joint>
  <joint name="second" type="continuous">
    <parent link="arm"/>
    <child link="hand"/>
    <axis xyz="0 1 0"/>
    <mimic joint="first" multiplier="2"/>
  </joint>
</robot>
"#;

fn broken(find: &str, replace: &str) -> Vec<Diagnostic> {
    assert!(SOUND.contains(find), "{find}");
    let text = SOUND.replacen(find, replace, 1);
    match import("r.urdf", &text) {
        Ok((_, diagnostics)) => diagnostics,
        Err(diagnostics) => {
            assert!(diagnostics.iter().any(Diagnostic::is_error));
            diagnostics
        }
    }
}

/// The one diagnostic on this change: its line, what is highlighted, its message and its remedy.
#[track_caller]
fn assert_diagnostic(
    find: &str,
    replace: &str,
    severity: Severity,
    line: usize,
    highlight: &str,
    message: &str,
    remedy: &str,
) {
    let diagnostics = broken(find, replace);
    assert_eq!(diagnostics.len(), 1, "{diagnostics:#?}");
    let diagnostic = &diagnostics[0];
    assert_eq!(diagnostic.severity, severity, "{diagnostic:#?}");
    assert!(diagnostic.message.contains(message), "{diagnostic:#?}");
    assert!(diagnostic.remedy.as_deref().unwrap_or("").contains(remedy), "{diagnostic:#?}");
    let place = diagnostic.place.as_ref().unwrap();
    let text = SOUND.replacen(find, replace, 1);
    assert_eq!(place.line, line, "{diagnostic:#?}");
    assert_eq!(text.lines().nth(place.line - 1), Some(place.excerpt.as_str()));
    assert_eq!(&place.excerpt[place.highlight.clone()], highlight, "{diagnostic:#?}");
    assert_eq!(place.excerpt[..place.highlight.start].chars().count() + 1, place.column);
    assert_eq!(place.file, "r.urdf");
}

#[track_caller]
fn error(find: &str, replace: &str, line: usize, highlight: &str, message: &str, remedy: &str) {
    assert_diagnostic(find, replace, Severity::Error, line, highlight, message, remedy);
}

#[track_caller]
fn warning(find: &str, replace: &str, line: usize, highlight: &str, message: &str, remedy: &str) {
    assert_diagnostic(find, replace, Severity::Warning, line, highlight, message, remedy);
}

#[test]
fn the_sound_one_is_read_without_a_word() {
    let (robot, diagnostics) = import("r.urdf", SOUND).unwrap();
    assert_eq!(diagnostics, []);
    assert_eq!(robot.frames.keys().collect::<Vec<_>>(), ["first", "second"]);
    let with_mark = format!("\u{feff}{}", SOUND.replace('\n', "\r\n"));
    assert_eq!(import("r.urdf", &with_mark).unwrap(), (robot, vec![]));
}

#[test]
fn a_joint_with_the_name_of_the_base() {
    let text = SOUND.replace("first", "0");
    let said = import("r.urdf", &text).unwrap_err();
    assert!(said.len() == 1 && said[0].message.contains("named `0`"), "{said:#?}");
    assert_eq!(said[0].place.as_ref().unwrap().line, 11);
}

#[test]
fn names_given_twice_or_unknown() {
    error(
        r#"<link name="hand"/>"#,
        r#"<link name="hand"/><link name="hand"/>"#,
        10,
        "hand",
        "two links are named `hand`",
        "",
    );
    error(r#"name="second""#, r#"name="first""#, 18, "first", "two joints are named `first`", "");
    error(r#"<parent link="arm"/>"#, r#"<parent link="amr"/>"#, 19, "amr", "unknown parent link `amr`", "`arm`");
    error(r#"<child link="hand"/>"#, r#"<child link="hnad"/>"#, 20, "hnad", "unknown child link `hnad`", "`hand`");
    error(r#"<mimic joint="first""#, r#"<mimic joint="frist""#, 22, "frist", "unknown joint `frist`", "`first`");
    error(r#"link name="base""#, r#"link name="""#, 2, r#"name="""#, "`name` is empty", "");
    error(r#"link name="base""#, r#"link nam="base""#, 2, "<link", "lacks `name`", "");
}

#[test]
fn links_that_form_no_tree() {
    let twice = r#"</joint><joint name="third" type="fixed"><parent link="base"/><child link="hand"/></joint></robot>"#;
    error("</joint>\n</robot>", twice, 23, "hand", "`hand` has two parents", "closed loops");
    error(
        r#"<link name="hand"/>"#,
        r#"<link name="hand"/><link name="lost"/>"#,
        10,
        "lost",
        "`base`, `lost`",
        "the base",
    );
    error(
        r#"<parent link="base"/>"#,
        r#"<parent link="hand"/>"#,
        20,
        "hand",
        "in a circle: `arm`, `hand`, `arm`",
        "tree",
    );
    error(r#"<child link="hand"/>"#, r#"<child link="arm"/>"#, 20, "arm", "two parents", "");
}

#[test]
fn a_circle_without_a_base() {
    let text = r#"<robot name="r"><link name="a"/><joint name="j" type="fixed"><parent link="a"/><child link="a"/></joint></robot>"#;
    let said = import("r.urdf", text).unwrap_err();
    assert!(said.len() == 1 && said[0].message.contains("circle: `a`, `a`"), "{said:#?}");
    let said = import("r.urdf", r#"<robot name="r"/>"#).unwrap_err();
    assert!(said.len() == 1 && said[0].message == "the file holds no link", "{said:#?}");
    let said = import("r.urdf", r#"<robot name="r"><link name="a"/></robot>"#).unwrap_err();
    assert!(said.len() == 1 && said[0].message == "the file holds no joint", "{said:#?}");
}

#[test]
fn joints_and_their_axes() {
    error("continuous", "floating", 18, "floating", "not supported", "supported: `revolute`");
    error("continuous", "continous", 18, "continous", "unknown type of joint", "`continuous`");
    error(r#"axis xyz="0 1 0""#, r#"axis xyz="0 0 0""#, 21, "0 0 0", "the axis is zero", "unit vector");
    error(r#"axis xyz="0 1 0""#, r#"axis xyz="0 nan 0""#, 21, "nan", "not a finite number", "");
    error(
        r#"axis xyz="0 1 0""#,
        r#"axis xyz="0 1""#,
        21,
        "0 1",
        "must hold 3 numbers, it holds 2",
        "write xyz=\"0 0 0\"",
    );
    error(r#"<axis xyz="0 1 0"/>"#, "<axis/>", 21, "<axis", "lacks `xyz`", "");
    warning(r#"axis xyz="0 1 0""#, r#"axis xyz="0 2 0""#, 21, "0 2 0", "the axis is 2 long", "direction is taken");
    let (robot, _) = import("r.urdf", &SOUND.replace("0 1 0", "0 2 0")).unwrap();
    assert_eq!(robot, import("r.urdf", SOUND).unwrap().0);
    let limit = r#"<limit lower="-1" upper="1" effort="1" velocity="1"/>"#;
    warning(limit, "", 11, "<joint", "`first` has no <limit>", "no limits");
    warning(limit, r#"<limit effort="1" velocity="1"/>"#, 16, "<limit", "neither `lower` nor `upper`", "no limits");
    error(r#"lower="-1""#, r#"lower="2""#, 16, "2", "the lower limit 2 is above the upper limit 1", "");
    error(r#"velocity="1""#, "", 16, "<limit", "lacks `velocity`", "");
    error(r#"<mimic joint="first""#, r#"<mimic joint="second""#, 22, "second", "circle", "");
    warning("continuous", "fixed", 22, "<mimic", "a fixed joint cannot mimic", "");
}

#[test]
fn numbers() {
    error(r#"xyz="0 0 1" rpy"#, r#"xyz="0 0,5 1" rpy"#, 14, "0,5", "not a number", "decimal point");
    error(r#"rpy="0 0 0""#, r#"rpy="0 inf 0""#, 14, "inf", "not a finite number", "");
    error(
        r#"rpy="0 0 0""#,
        r#"rpy="0 0 0 1""#,
        14,
        "0 0 0 1",
        "must hold 3 numbers, it holds 4",
        "write rpy=\"0 0 0\"",
    );
    error(r#"rpy="0 0 0""#, r#"quat_xyzw="0 0 0 1""#, 14, "0 0 0 1", "`quat_xyzw`", "rpy");
    warning(r#"rpy="0 0 0""#, r#"rpyy="0 0 0""#, 14, "rpyy", "`rpyy` is not an attribute of `origin`", "`rpy`");
    error(r#"<mass value="2"/>"#, r#"<mass value="-2"/>"#, 6, "-2", "is negative", "");
    error(r#"<mass value="2"/>"#, "", 4, "<inertial", "lacks `<mass>`", "");
    error(r#"ixy="0" "#, r#"ixy="O" "#, 7, "O", "not a number", "");
    error(
        r#"multiplier="2""#,
        r#"multiplier="""#,
        22,
        "",
        "must hold one number, it holds 0",
        "write multiplier=\"1\"",
    );
}

#[test]
fn elements() {
    error(
        "<origin xyz=\"0 0 1\"",
        "<orign xyz=\"0 0 1\"",
        14,
        "<orign",
        "`orign` is not an element of `joint`",
        "`origin`",
    );
    error("<axis xyz=\"0 1 0\"/>", "<axis xyz=\"0 1 0\"/><axis xyz=\"1 0 0\"/>", 21, "<axis", "given twice", "");
    error("<child link=\"hand\"/>", "", 18, "<joint", "lacks `<child>`", "");
    warning("</robot>", "<gazebo/><sensor/><gazebo/></robot>", 24, "<gazebo", "`gazebo` (2), `sensor` (1)", "");
    let said = import("r.urdf", "<sdf version=\"1.7\"/>").unwrap_err();
    assert!(said.len() == 1 && said[0].message.contains("the outermost element is `sdf`"), "{said:#?}");
}

#[test]
fn all_faults_in_one_run() {
    let text = SOUND
        .replace(r#"<parent link="arm"/>"#, r#"<parent link="amr"/>"#)
        .replace("0 0 1\" rpy", "0 zero 1\" rpy")
        .replace("continuous", "planar")
        .replace(r#"<mimic joint="first""#, r#"<mimic joint="frist""#)
        .replace(r#"name="arm""#, r#"name="base""#);
    let said = import("r.urdf", &text).unwrap_err();
    let lines: Vec<usize> = said.iter().map(|diagnostic| diagnostic.place.as_ref().unwrap().line).collect();
    assert_eq!(said.len(), 6, "{said:#?}");
    for line in [3, 13, 14, 18, 19, 22] {
        assert!(lines.contains(&line), "{line}: {said:#?}");
    }
    let twice = said.iter().find(|diagnostic| diagnostic.message.contains("two links")).unwrap();
    assert_eq!((twice.related[0].0.line, twice.related[0].1.as_str()), (2, "named first here"));
}

#[test]
fn a_xacro_file() {
    let said = broken("<link name=\"hand\"/>", "<link name=\"hand\"/><xacro:wrist/>");
    assert!(said.len() == 1 && said[0].remedy.as_deref().unwrap().contains("run xacro first"), "{said:#?}");
    assert_eq!(said[0].place.as_ref().unwrap().line, 10);
    error("0 0 1\" rpy", "0 0 ${height}\" rpy", 14, "0 0 ${height}", "xacro", "run xacro first");
    let other = "<x:macro xmlns:x=\"http://ros.org/wiki/macros\" name=\"m\"/>";
    let said = broken("<link name=\"hand\"/>", &format!("<link name=\"hand\"/>{other}"));
    assert!(said.len() == 1 && said[0].remedy.as_deref().unwrap().contains("run xacro first"), "{said:#?}");
    let declared = "<robot name=\"r\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\"><xacro:arg name=\"a\"/>";
    error("<robot name=\"r\">", declared, 1, "<xacro:arg", "xacro", "run xacro first");
    let prefixed = "<robot name=\"r\" xmlns:xacro=\"http://example.org/tools\"><xacro:if value=\"1\"/>";
    error("<robot name=\"r\">", prefixed, 1, "<xacro:if", "xacro", "run xacro first");
    let included = "<xi:include xmlns:xi=\"http://www.w3.org/2001/XInclude\" href=\"more.xml\"/>";
    let said = broken("<link name=\"hand\"/>", &format!("<link name=\"hand\"/>{included}"));
    assert!(said.len() == 1 && said[0].message.contains("elements that are not read: `include` (1)"), "{said:#?}");
}

#[test]
fn what_is_no_xml() {
    for (text, part) in [
        ("", "not well-formed"),
        ("hello", "not well-formed"),
        (&SOUND[..400], "not well-formed"),
        ("<robot name=\"r\"><link name=\"a\"></robot>", "expected 'link' tag, not 'robot'"),
        ("<!DOCTYPE r [<!ENTITY a \"b\">]><robot name=\"&a;\"/>", "not well-formed"),
        ("<robot name='a' name='b'/>", "already defined"),
    ] {
        let said = import("r.urdf", text).unwrap_err();
        assert!(said.len() == 1 && said[0].message.contains(part), "{text}: {said:#?}");
    }
}

#[test]
fn hostile_files_end_soon_on_a_small_stack() {
    let run = |text: String| {
        let thread = std::thread::Builder::new().stack_size(2 << 20);
        thread.spawn(move || import("r.urdf", &text)).unwrap().join().unwrap()
    };
    let started = std::time::Instant::now();
    let nested = |tag: &str, depth: usize| format!("<robot name=\"r\">{}", tag.repeat(depth));
    for text in [nested("<link name=\"a\">", 10_000), nested("<a>", 1_000_000), "<".repeat(1_000_000)] {
        let said = run(text).unwrap_err();
        assert_eq!(said.len(), 1, "{said:#?}");
        assert!(said[0].place.as_ref().is_some_and(|place| place.excerpt.len() < 1000));
    }
    let attributes: String = (0..50_000).fold(String::new(), |mut text, k| {
        write!(text, " a{k}=\"\"").unwrap();
        text
    });
    assert!(run(format!("<robot{attributes}/>")).unwrap_err()[0].message.contains("attributes"));
    assert!(run(" ".repeat(20_000_001)).unwrap_err()[0].message.contains("MB"));
    let many = "<joint name=\"x\" type=\"fixed\"><parent link=\"p\"/><child link=\"c\"/></joint>".repeat(10_000);
    let said = run(format!("<robot name=\"r\"><link name=\"l\"/>{many}</robot>")).unwrap_err();
    let links = "<link name=\"l\"/>".repeat(1_000_000);
    let crowd = run(format!("<robot name=\"r\">{links}</robot>")).unwrap_err();
    assert!(crowd[0].message.contains("at most 10001"), "{:?}", crowd[0]);
    assert!(said.len() == 101 && said[100].message.contains("more errors"), "{}", said.len());
    assert!(started.elapsed().as_secs() < 20, "{:?}", started.elapsed());
}

#[test]
fn crowded_elements_take_no_time() {
    let shapes = "<visual/>".repeat(100_000) + &"<sensor/>".repeat(100_000);
    let started = std::time::Instant::now();
    assert!(import("r.urdf", &SOUND.replace("<inertial>", &format!("{shapes}<inertial>"))).is_ok());
    assert!(started.elapsed().as_secs() < 10, "{:?}", started.elapsed());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// Whatever is done to a file, it is read or refused, and what is read can be written or not.
    #[test]
    fn a_damaged_file_never_panics(
        edits in prop::collection::vec((any::<prop::sample::Index>(), 0_usize..12, any::<prop::sample::Index>()), 1..5)
    ) {
        const BITS: [&str; 14] = [
            "", "<", ">", "/>", "\"", "&", "0", "-", "e999", "first", "<joint", "<!--", "\u{e9}\u{0}", " xmlns:a=\"b\" a:c=\"d\"",
        ];
        let mut text: Vec<char> = SOUND.chars().collect();
        for (at, length, bit) in edits {
            let at = at.index(text.len());
            let end = (at + length).min(text.len());
            text.splice(at..end, BITS[bit.index(BITS.len())].chars());
        }
        let text: String = text.into_iter().collect();
        match import("r.urdf", &text) {
            Ok((robot, _)) => drop(export(&robot)),
            Err(diagnostics) => prop_assert!(diagnostics.iter().any(Diagnostic::is_error)),
        }
    }
}

#[test]
fn a_chain_of_ten_thousand_joints_is_read() {
    let mut text = String::from("<robot name=\"r\"><link name=\"l0\"/>");
    for k in 1..=10_000 {
        let before = k - 1;
        write!(
            text,
            "<link name=\"l{k}\"/><joint name=\"j{k}\" type=\"continuous\"><parent link=\"l{before}\"/><child link=\"l{k}\"/>
             <origin xyz=\"0 0 1\"/><axis xyz=\"0 0 1\"/></joint>"
        )
        .unwrap();
    }
    let text = text + "</robot>";
    let read = std::thread::Builder::new().stack_size(2 << 20).spawn(move || import("r.urdf", &text)).unwrap();
    assert_eq!(read.join().unwrap().unwrap().0.frames.len(), 10_000);
}

#[test]
fn several_ends() {
    let add = |first: &str, second: &str| {
        let end = |name: &str, parent: &str| {
            format!(
                r#"<link name="{name}"/><joint name="to-{name}" type="fixed"><parent link="{parent}"/><child link="{name}"/></joint>"#
            )
        };
        let ends = format!("{}{}{}</robot>", end(first, "hand"), end(second, "hand"), end("frame", "base"));
        import("r.urdf", &SOUND.replace("</robot>", &ends)).unwrap()
    };
    let (robot, diagnostics) = add("flange", "Tool0");
    assert_eq!(robot.tool.frame.as_deref(), Some("to-Tool0"));
    assert!(diagnostics.len() == 1 && diagnostics[0].message.ends_with("`to-flange`, `to-Tool0`"), "{diagnostics:#?}");
    let (robot, diagnostics) = add("left", "right");
    assert_eq!(robot.tool.frame, None);
    assert!(diagnostics[0].message.contains("`to-left`, `to-right`"), "{diagnostics:#?}");
}

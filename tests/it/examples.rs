//! Each example prints the lines that its first comment shows.

#[path = "../../examples/calibrate.rs"]
mod calibrate;
#[path = "../../examples/compensate_path.rs"]
mod compensate_path;
#[path = "../../examples/forward_and_inverse.rs"]
mod forward_and_inverse;
#[path = "../../examples/where_is_the_gap.rs"]
mod where_is_the_gap;

use crate::docs::{root, text};

/// The lines of the `text` block of an example's first comment.
fn shown(example: &str) -> Vec<String> {
    let source = text(&root().join("examples").join(example));
    let comment = source.lines().map_while(|line| line.strip_prefix("//!")).map(|line| line.trim_start_matches(' '));
    comment.skip_while(|line| *line != "```text").skip(1).take_while(|line| *line != "```").map(String::from).collect()
}

fn plain(line: &str) -> String {
    line.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn examples_print_what_they_show() {
    let printed = [
        ("calibrate.rs", calibrate::report("kr270-simulated")),
        ("where_is_the_gap.rs", where_is_the_gap::report("kr270-rigid-joint-1")),
        ("forward_and_inverse.rs", forward_and_inverse::report()),
        ("compensate_path.rs", compensate_path::report()),
    ];
    for (example, printed) in printed {
        let printed = printed.unwrap_or_else(|error| panic!("{example}: {error}"));
        let lines: Vec<String> = printed.lines().map(plain).collect();
        let shown = shown(example);
        assert!(shown.len() > 2, "{example} shows what it prints");
        for line in shown {
            assert!(lines.contains(&plain(&line)), "{example} shows `{line}`, and prints\n{printed}");
        }
    }
}

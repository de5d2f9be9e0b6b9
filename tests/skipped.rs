//! Runs after the tests: says last how many of them were skipped because no measurements of real robots are there.

fn main() {
    let noted = concat!(env!("CARGO_TARGET_TMPDIR"), "/skipped");
    let skipped = std::fs::read_dir(noted).map_or(0, Iterator::count);
    let _ = std::fs::remove_dir_all(noted);
    let tests = if skipped == 1 { "test" } else { "tests" };
    println!(
        "skipped: {skipped} {tests} that read measurements of real robots (../shared/data, or the folder in ELASTOGEO_DATA)"
    );
}

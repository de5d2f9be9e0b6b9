//! Small plots of block characters for the terminal.

use super::table::Screen;

/// Columns of the longest bar.
const LONGEST: usize = 40;
/// Eighths of a character, from the left.
const EIGHTHS: [&str; 8] = ["", "▏", "▎", "▍", "▌", "▋", "▊", "▉"];
/// Classes of a histogram.
const CLASSES: usize = 9;
/// A bar this many times the next is shown by its number and not drawn to scale: the others would be nothing.
const OFF: f64 = 20.0;

/// Bars from zero: what each is of, its size, and its number in words. No bars, no text.
pub fn bars(rows: &[(String, f64, String)], screen: Screen) -> String {
    let wide = |text: &str| text.chars().count();
    let names = rows.iter().map(|row| wide(&row.0)).max().unwrap_or(0);
    let numbers = rows.iter().map(|row| wide(&row.2)).max().unwrap_or(0);
    let width =
        screen.columns().map_or(LONGEST, |screen| LONGEST.min(screen.saturating_sub(names + numbers + 5)).max(8));
    let mut sizes: Vec<f64> = rows.iter().map(|row| row.1).filter(|size| size.is_finite()).collect();
    sizes.sort_by(|a, b| b.total_cmp(a));
    let full = match sizes[..] {
        [first, second, ..] if second > 0.0 && first > OFF * second => second,
        [first, ..] => first,
        [] => 0.0,
    };
    let mut out = String::new();
    for (name, size, number) in rows {
        let drawn = if *size > full {
            format!("{}»", "█".repeat(width - 1))
        } else if full > 0.0 && *size > 0.0 {
            // At most `width` full characters, since `size` is at most `full`.
            let eighths = (size / full * 8.0 * width as f64).round() as usize;
            "█".repeat(eighths / 8) + EIGHTHS[eighths % 8]
        } else {
            String::new()
        };
        let gap = " ".repeat(names - wide(name));
        let before = " ".repeat(numbers - wide(number));
        out += format!(" {name}{gap}  {before}{number}  {drawn}").trim_end();
        out.push('\n');
    }
    out
}

/// How values (m) are distributed, in classes of one width; values beyond are in the outermost. Fewer than ten: no text.
pub fn histogram(values: &[f64], screen: Screen) -> String {
    let n = values.len() as f64;
    let rms = (values.iter().map(|v| v * v).sum::<f64>() / n).sqrt();
    if values.len() < 10 || !rms.is_normal() {
        return String::new();
    }
    // The classes reach to 2.7 rms on each side.
    let width = 0.6 * rms;
    let half = (CLASSES / 2) as f64;
    let mut counts = [0_usize; CLASSES];
    for value in values {
        let class = (value / width).round().clamp(-half, half) + half;
        counts[class as usize] += 1;
    }
    let rows: Vec<(String, f64, String)> = counts
        .iter()
        .enumerate()
        .map(|(k, &count)| {
            let name = format!("{:+.4} mm", (k as f64 - half) * width * 1e3);
            (name, count as f64, count.to_string())
        })
        .collect();
    bars(&rows, screen)
}

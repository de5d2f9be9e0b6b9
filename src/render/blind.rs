//! The score of sealed campaigns as text.

use std::fmt::Write;

use super::table::Screen;
use crate::blind::{Examined, Score};

/// Text of `blind score`.
pub fn score_text(score: &Score, all: &[Examined], screen: Screen) -> String {
    let mut text = String::new();
    let rows = score.classes.iter().map(|(name, class)| {
        let of_sites = if name.starts_with("null") || name.starts_with("unknown") {
            String::new()
        } else {
            class.sites.to_string()
        };
        vec![name.clone(), class.count.to_string(), class.right.to_string(), of_sites]
    });
    text += &screen.table(&["kind, gap over noise", "campaigns", "right", "site too"], rows);
    let rows = score.confusion.iter().map(|(name, row)| {
        let mut named: Vec<(&String, &usize)> = row.iter().collect();
        named.sort_by_key(|(other, count)| (*other != name, std::cmp::Reverse(**count)));
        let named: Vec<String> = named.iter().map(|(other, count)| format!("{count} {other}")).collect();
        vec![name.clone(), row.values().sum::<usize>().to_string(), named.join(", ")]
    });
    let _ = write!(text, "\n{}", screen.table(&["true effect", "times", "named (-: nothing)"], rows));
    let _ = writeln!(
        text,
        "\n{} campaigns with causes named: group {:.2} on average, shrinkage promised {:.3}, realised {:.3}; {:.0} % inside \
         the promised 95 % interval",
        score.named,
        score.group,
        score.shrinkage[0],
        score.shrinkage[1],
        100.0 * score.coverage
    );
    let [true_ones, found, marked] = score.outliers;
    let _ = writeln!(text, "outliers: {true_ones}, {found} of them found, {marked} marked in all");
    let missed: Vec<&Examined> = all.iter().filter(|one| !one.is_right()).collect();
    if !missed.is_empty() {
        let named = |one: &Examined| {
            let each = one.named.iter().map(|n| format!("{} {} ({})", n.effect, n.site, n.group()));
            each.collect::<Vec<_>>().join(" + ")
        };
        let causes = |one: &Examined| {
            let each = one.truth.causes.iter().map(|c| format!("{} {} {:.1}", c.effect, c.site, c.gap));
            each.collect::<Vec<_>>().join(" + ")
        };
        let rows = missed.iter().map(|one| {
            let truth = &one.truth;
            let which = format!("{} {}", truth.robot, truth.observes);
            let gap = format!("{:.2}", truth.gap);
            vec![truth.name.clone(), which, causes(one), gap, one.verdict.to_string(), named(one)]
        });
        let _ = write!(text, "\n{}", screen.table(&["missed", "campaign", "truth", "gap", "verdict", "named"], rows));
    }
    text
}

//! The score of sealed campaigns as text.

use std::fmt::Write;

use super::table::Screen;
use crate::blind::{Bin, Examined, Rate, Rates, Score};
use crate::results::{BlindScore, ScoredCampaign};

/// Text of `blind score`.
pub fn score_text(found: &BlindScore, screen: Screen) -> String {
    let mut text = scored(&found.score, &found.campaigns, screen);
    if let Some(left_out) = &found.left_out {
        let _ = writeln!(text, "\nwith the true effect of each single one taken out of the catalogue:\n");
        text += &scored(&left_out.score, &left_out.campaigns, screen);
    }
    text
}

fn scored(score: &Score, all: &[ScoredCampaign], screen: Screen) -> String {
    let mut text = String::new();
    let rows = score.classes.iter().map(|(name, class)| {
        let has_sites = ["single", "pair", "triple", "mixture"].iter().any(|kind| name.starts_with(kind));
        let of_sites = if has_sites { class.sites.to_string() } else { String::new() };
        vec![name.clone(), class.count.to_string(), class.right.to_string(), of_sites]
    });
    text += &screen.table(&["kind, gap over noise", "campaigns", "right", "site too"], rows);
    let _ = write!(text, "\n{}", rates(&score.rates, screen));
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
    for (what, bins) in [("stability", &score.reliability.stability), ("probability", &score.reliability.probability)] {
        if !bins.is_empty() {
            let header = [what, "mean", "causes with a law", "right"];
            let _ = write!(text, "\n{}", screen.table(&header, bins.iter().map(bin)));
        }
    }
    if let Some(brier) = score.reliability.brier {
        let _ = writeln!(text, "\nBrier score of the probability: {brier:.3}");
    }
    let missed: Vec<&ScoredCampaign> = all.iter().filter(|one| !one.right || one.false_name).collect();
    if !missed.is_empty() {
        let rows = missed.iter().map(|one| miss(&one.said));
        let _ = write!(text, "\n{}", screen.table(&["missed", "campaign", "truth", "gap", "verdict", "named"], rows));
    }
    text
}

/// A share with its interval and what it is of.
fn share(rate: &Rate) -> String {
    let [low, high] = rate.ci95.map(|end| 100.0 * end);
    match rate.share {
        Some(share) => format!("{:.0} % ({low:.0} to {high:.0}), {} of {}", 100.0 * share, rate.count, rate.of),
        None => String::new(),
    }
}

fn rates(all: &[Rates], screen: Screen) -> String {
    let rows = all.iter().map(|of| {
        let whose = format!("{}, {}", of.kind, of.among);
        let rates = [&of.right, &of.false_names, &of.open, &of.kept];
        std::iter::once(whose).chain(rates.into_iter().map(share)).collect()
    });
    screen.table(&["kind, of which", "right", "with a false name", "open", "promise kept"], rows)
}

fn bin(bin: &Bin) -> Vec<String> {
    let [from, to] = bin.range;
    vec![format!("{from:.2} to {to:.2}"), format!("{:.2}", bin.mean), bin.right.of.to_string(), share(&bin.right)]
}

fn miss(one: &Examined) -> Vec<String> {
    let truth = &one.truth;
    let named = one.named.iter().map(|n| {
        let tied = if n.tied { ", tied" } else { "" };
        format!("{} {} ({}{tied})", n.effect, n.site, n.group())
    });
    let causes = truth.causes.iter().map(|c| format!("{} {} {:.1}", c.effect, c.site, c.gap));
    vec![
        truth.name.clone(),
        format!("{} {} {}", truth.kind, truth.robot, truth.observes),
        causes.collect::<Vec<_>>().join(" + "),
        format!("{:.2}", truth.gap),
        one.verdict.to_string(),
        named.collect::<Vec<_>>().join(" + "),
    ]
}

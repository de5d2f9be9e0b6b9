//! Several laws at one site that a single curve there can stand for.
//!
//! Laws are tried in their known shapes. A cause of another shape is imitated by two or three of them at the same site, which
//! together leave nothing but noise. That a joint has one law that is not known is then as good an explanation as that it
//! has several that are: none of them is named.

use super::projection::Subset;
use super::selection::Selector;

/// The members of a fit, laws of different effects at one site replaced by the free curve there that leaves least, wherever
/// one of them with all other members leaves no more than noise and none of the laws takes `near` of what the curve does.
pub fn curves_for_laws(
    selector: &Selector,
    members: &[usize],
    near: f64,
    is_noise: impl Fn(&Subset) -> bool,
) -> Vec<usize> {
    let hypotheses = &selector.projection.problem.hypotheses;
    let site = |h: usize| hypotheses[h].site.name.as_str();
    let mut kept = members.to_vec();
    for &member in members {
        let (here, others): (Vec<usize>, Vec<usize>) = kept.iter().partition(|&&h| site(h) == site(member));
        let is_other = |h: &usize| !hypotheses[*h].is_same(&hypotheses[member]);
        if !here.contains(&member) || !here.iter().any(is_other) {
            continue;
        }
        let free = (0..hypotheses.len()).filter(|&h| hypotheses[h].is_free() && site(h) == site(member));
        let fits = free.map(|h| (h, selector.fit(&[&others[..], &[h]].concat())));
        let best = fits.min_by(|(_, a), (_, b)| a.squares.total_cmp(&b.squares));
        let before = selector.fit(&others).squares;
        let taken = |h: usize| before - selector.fit(&[&others[..], &[h]].concat()).squares;
        let is_near = |h: usize, curve: &Subset| taken(h) >= near * (before - curve.squares);
        let is_one_law = |curve: &Subset| here.iter().any(|&h| !hypotheses[h].is_free() && is_near(h, curve));
        if let Some((curve, _)) = best.filter(|(_, fit)| is_noise(fit) && !is_one_law(fit)) {
            kept = others;
            kept.push(curve);
        }
    }
    kept
}

//! Springs in series and in parallel, within each other: `1/(1/k1 + 1/(k2 + k3))`.
//!
//! Readings that see springs as one see a single number, the network's compliance, and how much each member takes part in it. Two
//! members stand side by side in the network where the ratio of their parts goes with the square of either's compliance, and one
//! after the other where it stays whatever either's is. Such a pair counts as one spring from then on; every network of series
//! and parallel connections has a pair, until one spring is left (Duffin, J. Math. Anal. Appl. 10, 1965).

use crate::parameter::Slot;

/// How springs act together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Together {
    /// One after the other: compliances add.
    Series,
    /// Next to each other: stiffnesses add.
    Parallel,
}

/// Factor by which compliances are changed to see how a pair is connected: large compared with the rounding of columns, small
/// enough to stay in the same regime.
pub const CHANGED: f64 = 1.5;
/// The logarithm of a ratio may differ by this from what a connection predicts; of a pair that is none it differs by some per cent.
const AGREES: f64 = 1e-3;

/// A network of springs. Each part of a group counts so many times: in series its compliance, in parallel its stiffness.
#[derive(Debug, Clone, PartialEq)]
pub enum Network {
    /// A spring.
    Spring(Slot),
    /// Parts that act together.
    Group(Together, Vec<(f64, Network)>),
}

impl Network {
    /// Compliance, by those of its springs.
    pub fn compliance(&self, of: &dyn Fn(Slot) -> f64) -> f64 {
        match self {
            Self::Spring(slot) => of(*slot),
            Self::Group(Together::Series, parts) => {
                parts.iter().map(|(weight, part)| weight * part.compliance(of)).sum()
            }
            Self::Group(Together::Parallel, parts) => {
                parts.iter().map(|(weight, part)| weight / part.compliance(of)).sum::<f64>().recip()
            }
        }
    }

    /// Derivative of the compliance by that of one of its springs.
    pub fn derivative(&self, of: &dyn Fn(Slot) -> f64, by: Slot) -> f64 {
        match self {
            Self::Spring(slot) => f64::from(u8::from(*slot == by)),
            Self::Group(together, parts) => {
                let Some((weight, part)) = parts.iter().find(|(_, part)| part.has(by)) else { return 0.0 };
                let outer = match together {
                    Together::Series => *weight,
                    Together::Parallel => weight * (self.compliance(of) / part.compliance(of)).powi(2),
                };
                outer * part.derivative(of, by)
            }
        }
    }

    /// Its springs.
    pub fn springs(&self) -> Vec<Slot> {
        match self {
            Self::Spring(slot) => vec![*slot],
            Self::Group(_, parts) => parts.iter().flat_map(|(_, part)| part.springs()).collect(),
        }
    }

    fn has(&self, spring: Slot) -> bool {
        match self {
            Self::Spring(slot) => *slot == spring,
            Self::Group(_, parts) => parts.iter().any(|(_, part)| part.has(spring)),
        }
    }

    /// Whether a group lies in another.
    pub fn is_nested(&self) -> bool {
        matches!(self, Self::Group(_, parts) if parts.iter().any(|(_, part)| matches!(part, Self::Group(..))))
    }

    /// Springs next to a member that must be rigid, and those that must not hold, for it alone to stand for the network; and how
    /// many times its compliance then counts.
    pub fn alone(&self, member: Slot) -> (Vec<Slot>, Vec<Slot>, f64) {
        let Self::Group(together, parts) = self else { return (Vec::new(), Vec::new(), 1.0) };
        let (mut rigid, mut loose, mut times) = (Vec::new(), Vec::new(), 1.0);
        for (weight, part) in parts {
            let others = match part.has(member) {
                false => part.springs(),
                true => {
                    let (stiff, soft, count) = part.alone(member);
                    rigid.extend(stiff);
                    loose.extend(soft);
                    times = count * if *together == Together::Series { *weight } else { weight.recip() };
                    continue;
                }
            };
            if *together == Together::Series { rigid.extend(others) } else { loose.extend(others) }
        }
        (rigid, loose, times)
    }

    /// Its stiffness as a formula of those of its springs.
    pub fn formula(&self, name: &dyn Fn(Slot) -> String) -> String {
        let times = |weight: f64| if (weight - 1.0).abs() < AGREES { None } else { Some(format!("{weight:.4}")) };
        match self {
            Self::Spring(slot) => name(*slot),
            Self::Group(Together::Parallel, parts) => {
                let part = |(weight, part): &(f64, Self)| match times(*weight) {
                    Some(times) => format!("{times}*{}", part.formula(name)),
                    None => part.formula(name),
                };
                parts.iter().map(part).collect::<Vec<_>>().join(" + ")
            }
            Self::Group(Together::Series, parts) => {
                let part = |(weight, part): &(f64, Self)| {
                    let own = part.formula(name);
                    let own = if matches!(part, Self::Spring(_)) { own } else { format!("({own})") };
                    format!("{}/{own}", times(*weight).unwrap_or_else(|| "1".into()))
                };
                format!("1/({})", parts.iter().map(part).collect::<Vec<_>>().join(" + "))
            }
        }
    }

    /// The network of springs that readings see as one. `parts` gives by how much each of them takes part in what the readings see,
    /// in proportion to its derivative by the spring's compliance, with the compliances of some multiplied by [`CHANGED`].
    ///
    /// # Errors
    /// Those of `parts`. `None` where the springs are no network of series and parallel connections.
    pub fn of<E>(
        springs: &[Slot],
        compliance: &dyn Fn(Slot) -> f64,
        mut parts: impl FnMut(&[Slot]) -> Result<Vec<f64>, E>,
    ) -> Result<Option<Self>, E> {
        let base = parts(&[])?;
        let mut items = Vec::with_capacity(springs.len());
        for &spring in springs {
            items.push(Item { network: Self::Spring(spring), changed: parts(&[spring])? });
        }
        // Of a network its first spring; infinite where there is none, which is no network.
        let at = |of: &[f64], network: &Self| -> f64 {
            let first = network.springs().first().copied();
            let place = springs.iter().position(|spring| Some(*spring) == first);
            place.and_then(|k| of.get(k)).copied().unwrap_or(f64::INFINITY)
        };
        // The part of a whole network: that of its first spring, less how that takes part in the network.
        let part = |of: &[f64], network: &Self| {
            let first = network.springs().first().copied().unwrap_or_default();
            at(of, network) / network.derivative(compliance, first)
        };
        while items.len() > 1 {
            let found = (0..items.len()).flat_map(|b| (0..b).map(move |a| (a, b))).find_map(|(a, b)| {
                let [one, other] = [items.get(a)?, items.get(b)?];
                let ratio = |of: &[f64]| at(of, &one.network) / at(of, &other.network);
                // All of a network's compliances changed alike change its own alike, and what its springs take part in it not.
                let follows = |of: &[f64]| (ratio(of) / ratio(&base)).ln() / CHANGED.ln();
                let is = |wanted: [f64; 2]| {
                    let found = [follows(&one.changed), follows(&other.changed)];
                    found.iter().zip(wanted).all(|(found, wanted)| (found - wanted).abs() * CHANGED.ln() < AGREES)
                };
                let together = match (is([0.0, 0.0]), is([-2.0, 2.0])) {
                    (true, _) => Together::Series,
                    (_, true) => Together::Parallel,
                    _ => return None,
                };
                Some((a, b, together, part(&base, &one.network) / part(&base, &other.network)))
            });
            let Some((a, b, together, ratio)) = found else { return Ok(None) };
            let other = items.remove(b).network;
            let one = items.remove(a).network;
            let weight = match together {
                Together::Series => ratio.recip(),
                Together::Parallel => (other.compliance(compliance) / one.compliance(compliance)).powi(2) / ratio,
            };
            if !(weight > 0.0 && weight.is_finite()) {
                return Ok(None);
            }
            let network = joined(together, one, other, weight);
            let changed = parts(&network.springs())?;
            items.insert(a, Item { network, changed });
        }
        Ok(items.pop().map(|item| item.network))
    }
}

/// A part of the network, and how much each spring takes part with its compliances changed.
struct Item {
    network: Network,
    changed: Vec<f64>,
}

/// Two networks as one; groups of the same kind become one group.
fn joined(together: Together, one: Network, other: Network, weight: f64) -> Network {
    let mut parts = Vec::new();
    for (weight, network) in [(1.0, one), (weight, other)] {
        match network {
            Network::Group(own, inner) if own == together => {
                parts.extend(inner.into_iter().map(|(inner, part)| (weight * inner, part)));
            }
            network => parts.push((weight, network)),
        }
    }
    Network::Group(together, parts)
}

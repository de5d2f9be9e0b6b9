//! Strong partitions of the inputs into fuzzy sets, and the numbering of the rules that they make.

/// Modal values by input, rad or m; a single one where the input has no influence.
pub type Partition = Vec<Vec<f64>>;

/// Number of rules of a partition.
pub fn rules(modes: &[Vec<f64>]) -> usize {
    modes.iter().map(Vec::len).product()
}

/// Where the rules of each of several partitions begin in one list, and how many there are.
pub fn starts(parts: &[Partition]) -> (Vec<usize>, usize) {
    let mut sum = 0;
    let mut starts = Vec::with_capacity(parts.len());
    for modes in parts {
        starts.push(sum);
        sum += rules(modes);
    }
    (starts, sum)
}

/// Pairs of rules that differ by one set of one input.
pub fn neighbours(modes: &[Vec<f64>]) -> Vec<[usize; 2]> {
    let mut pairs = Vec::new();
    let mut stride = 1;
    for own in modes.iter().rev() {
        let last = (own.len() - 1) * stride;
        pairs.extend(
            (0..rules(modes)).filter(|rule| rule % (own.len() * stride) < last).map(|rule| [rule, rule + stride]),
        );
        stride *= own.len();
    }
    pairs
}

/// One set more: in the middle of the widest gap, or all spread evenly. Both ends of the range first.
pub fn widened(modes: &[f64], [low, high]: [f64; 2], evenly: bool) -> Vec<f64> {
    let widest = (1..modes.len()).max_by(|&a, &b| (modes[a] - modes[a - 1]).total_cmp(&(modes[b] - modes[b - 1])));
    match widest {
        Some(k) if !evenly => {
            let mut more = modes.to_vec();
            more.insert(k, 0.5 * (modes[k - 1] + modes[k]));
            more
        }
        _ => (0..=modes.len()).map(|k| low + (high - low) * k as f64 / modes.len() as f64).collect(),
    }
}

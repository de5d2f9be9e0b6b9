//! Sums of joints as written: couplings `6 = -1 * 5`, `3 = 2 - 0.5 * 4`, and what limits are of, `q3 - q2`.

/// What stands behind a coupling that the controller computes from the joints it commands: errors of these do not pass on.
const OF_CONTROLLER: &str = "(controller)";

/// Whether a coupling is the controller's, and not a mechanism.
pub fn is_of_controller(text: &str) -> bool {
    text.trim_end().ends_with(OF_CONTROLLER)
}

/// The joint that follows, and the joints it follows with their factors.
pub type Coupling<'a> = (&'a str, Vec<(f64, &'a str)>);

/// The joint that follows, and the factors and names of those it follows.
///
/// # Errors
/// Says what is wrong with the text.
pub fn parse_coupling(text: &str) -> Result<Coupling<'_>, String> {
    let (joint, rest) = text.split_once('=').ok_or("there is no `=`")?;
    let joint = joint.trim();
    if joint.is_empty() || joint.contains(char::is_whitespace) {
        return Err("one joint name is needed before `=`".into());
    }
    let rest = rest.trim_end();
    let terms = parse_sum(rest.strip_suffix(OF_CONTROLLER).unwrap_or(rest))?;
    if terms.is_empty() { Err("there is no joint after `=`".into()) } else { Ok((joint, terms)) }
}

/// The factors and names of a sum of joints; none where nothing stands there.
///
/// # Errors
/// Says what is wrong with the text.
pub fn parse_sum(text: &str) -> Result<Vec<(f64, &str)>, String> {
    let (mut rest, mut terms) = (text, Vec::new());
    while !rest.trim().is_empty() {
        rest = rest.trim_start();
        let (sign, body) = match rest.strip_prefix('-') {
            Some(body) => (-1.0, body.trim_start()),
            None => (1.0, rest.strip_prefix('+').unwrap_or(rest).trim_start()),
        };
        // Names may hold a hyphen: only a sign between blanks begins the next term.
        let end = [" + ", " - "].iter().filter_map(|sign| body.find(sign)).min().unwrap_or(body.len());
        let (term, next) = body.split_at(end);
        let (factor, name) = match term.split_once('*') {
            Some((factor, name)) => {
                let factor = factor.trim();
                let value = factor.parse().ok().filter(|value: &f64| value.is_finite());
                (value.ok_or_else(|| format!("`{factor}` is no factor"))?, name.trim())
            }
            None => (1.0, term.trim()),
        };
        if name.is_empty() || name.contains(char::is_whitespace) || name.contains('*') {
            return Err(format!("`{name}` is no joint name"));
        }
        terms.push((sign * factor, name));
        rest = next;
    }
    Ok(terms)
}

//! The order in which readings were taken: the move by which each configuration was reached, and the time since its session
//! began.

use std::collections::BTreeMap;

use super::conditions::{EARLIER_MOVES, OrderBy};
use super::raw::RowOrder;
use super::{Campaign, InSession, Reading};
use crate::diagnostic::{Diagnostic, Place};

/// Place of a reading among those of its session: its number in the order of measurement, its time, or nothing (its place in
/// the files, also where that is stated).
fn place(campaign: &Campaign, orders: &[Option<i64>], by_rows: bool, reading: usize) -> (f64, usize) {
    if by_rows {
        return (0.0, reading);
    }
    let time = || campaign.conditions.time.as_ref().map(|all| all[reading]).filter(|time| time.is_finite());
    let number = orders[reading].map(|number| number as f64).or_else(time);
    (number.unwrap_or(0.0), reading)
}

/// Sets [`super::Conditions::last_move`], [`super::Conditions::rank`] and [`super::Conditions::session_time`]. `orders` are the numbers in the column
/// `order`, by reading: consecutive numbers follow one another, after a gap the predecessor is unknown. Without them times
/// order the readings, and without times their places in the files; so they do where that is `stated`. Where it is stated that the order is
/// unknown, nothing is set but the time.
pub fn order_readings(campaign: &mut Campaign, orders: &[Option<i64>], stated: Option<RowOrder>) {
    let by_rows = stated == Some(RowOrder::Rows);
    campaign.count_session_time();
    if stated == Some(RowOrder::Unknown) {
        campaign.conditions.order = OrderBy::Unknown;
        return;
    }
    let mut sessions: BTreeMap<InSession, Vec<usize>> = BTreeMap::new();
    for (index, reading) in campaign.readings.iter().enumerate() {
        sessions.entry(reading.session).or_default().push(index);
    }
    let count = campaign.readings.len();
    // By age, then by variable.
    let mut moves = vec![vec![vec![f64::NAN; count]; campaign.variables]; 1 + EARLIER_MOVES];
    let mut rank = vec![0.0; count];
    let mut places = 0..count;
    for mut own in sessions.into_values() {
        own.sort_by(|&a, &b| {
            let [a, b] = [a, b].map(|reading| place(campaign, orders, by_rows, reading));
            a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
        });
        // The first readings of the configuration at hand and of those before it, the later first.
        let mut path: Vec<usize> = Vec::new();
        for reading in own {
            rank[reading] = places.next().unwrap_or(count) as f64;
            let is_same = |known: &usize| campaign.configuration(*known) == campaign.configuration(reading);
            if !path.first().is_some_and(is_same) {
                let follows = |known: &usize| match (orders[*known], orders[reading]) {
                    (Some(last), Some(this)) => this - last <= 1,
                    _ => true,
                };
                if !path.first().is_some_and(follows) {
                    path.clear();
                }
                path.insert(0, reading);
                path.truncate(2 + EARLIER_MOVES);
            }
            for (age, moves) in moves.iter_mut().enumerate() {
                let [Some(&after), Some(&before)] = [path.get(age), path.get(age + 1)] else { break };
                for (variable, moves) in moves.iter_mut().enumerate() {
                    let at = |reading: usize| campaign.configuration(reading)[variable];
                    moves[reading] = at(after) - at(before);
                }
            }
        }
    }
    campaign.conditions.rank = rank;
    let earlier = moves.split_off(1);
    campaign.conditions.last_move = moves.pop().unwrap_or_default();
    campaign.conditions.earlier_moves = earlier;
    campaign.conditions.order = if orders.iter().any(Option::is_some) {
        OrderBy::Numbers
    } else if by_rows {
        OrderBy::StatedRows
    } else if are_told_apart_by_times(campaign) {
        OrderBy::Times
    } else if campaign.conditions.time.as_ref().is_some_and(|times| times.iter().any(|time| time.is_finite())) {
        OrderBy::TimesAndRows
    } else {
        OrderBy::Rows
    };
}

/// Whether every reading has a time that no other configuration of its session has.
fn are_told_apart_by_times(campaign: &Campaign) -> bool {
    let Some(times) = &campaign.conditions.time else { return false };
    let mut timed: Vec<(InSession, f64, usize)> = campaign
        .readings
        .iter()
        .zip(times)
        .enumerate()
        .map(|(k, (reading, time))| (reading.session, *time, k))
        .collect();
    timed.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let is_distinct = |pair: &[(InSession, f64, usize)]| {
        let is_same_moment = pair[0].0 == pair[1].0 && pair[0].1 == pair[1].1;
        !is_same_moment || campaign.configuration(pair[0].2) == campaign.configuration(pair[1].2)
    };
    timed.iter().all(|(_, time, _)| time.is_finite()) && timed.windows(2).all(is_distinct)
}

/// A number in the column `order` that two configurations of a session have: nothing says which of them came first.
pub fn numbered_twice(campaign: &Campaign, orders: &[Option<i64>]) -> Option<Diagnostic> {
    let mut first: BTreeMap<(InSession, i64), usize> = BTreeMap::new();
    let mut twice: Vec<(i64, usize, usize)> = Vec::new();
    for (index, reading) in campaign.readings.iter().enumerate() {
        let Some(number) = orders.get(index).copied().flatten() else { continue };
        let known = *first.entry((reading.session, number)).or_insert(index);
        let is_other = campaign.readings[known].pose != reading.pose
            && campaign.configuration(known) != campaign.configuration(index);
        if is_other {
            twice.push((number, known, index));
        }
    }
    let &(number, one, other) = twice.first()?;
    let [at_one, at_other] = [one, other].map(|index| campaign.address(&campaign.readings[index]));
    let more = if twice.len() > 1 { format!(", and {} more like this", twice.len() - 1) } else { String::new() };
    let message =
        format!("column `order`: `{number}` numbers two configurations, that of {at_one} and that of {at_other}{more}");
    let reading = &campaign.readings[other];
    let place = campaign.file(reading).filter(|_| reading.line > 0).map(|file| Place::line_of(file, reading.line));
    let remedy = "number configurations 1, 2, 3 as they were measured; where numbers begin anew, name the session in a column `session` \
                  or in the entry of the file";
    Some(Diagnostic::error(message).at(place).remedy(remedy))
}

impl Campaign {
    /// Place of a reading in the order of measurement, where that is known; else its row in the files.
    pub fn rank(&self, reading: usize) -> f64 {
        let known = self.conditions.rank.get(reading).copied();
        known.unwrap_or_else(|| self.readings.get(reading).map_or(0.0, |own| own.row as f64))
    }

    /// Sets [`super::Conditions::session_time`] from the times of the readings.
    pub fn count_session_time(&mut self) {
        let Some(times) = &self.conditions.time else { return };
        let mut starts: BTreeMap<InSession, f64> = BTreeMap::new();
        for (reading, time) in self.readings.iter().zip(times) {
            let start = starts.entry(reading.session).or_insert(f64::INFINITY);
            *start = start.min(*time);
        }
        let since =
            |(reading, time): (&Reading, &f64)| starts.get(&reading.session).map_or(f64::NAN, |start| time - start);
        self.conditions.session_time = Some(self.readings.iter().zip(times).map(since).collect());
    }

    /// Numbers the readings in the order of their configurations: each was reached from the one before.
    pub fn number_in_order(&mut self) {
        let orders: Vec<Option<i64>> = self.readings.iter().map(|reading| i64::try_from(reading.pose).ok()).collect();
        order_readings(self, &orders, None);
    }
}

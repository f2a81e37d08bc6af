//! Retention: what a store keeps, and for how long.
//!
//! Alarms, advice, outcomes and capabilities are kept for ever: they are few, and what trends are made of.
//! Verdicts are nearly all of a store; those before a day are summed into `days` (seconds in each
//! state by machine and day) and taken out. Which question is asked afterwards does not matter: `states`
//! gives the same answer before and after.

use super::backend::StoreError;
use super::{Store, put, sums};
use crate::record::DAY_US;

/// What thinning did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Thinned {
    /// Verdicts taken out.
    pub verdicts: i64,
    /// Rows of days that stand for them.
    pub days: i64,
}

impl Store {
    /// Thins verdicts before a day (whole days since 1970, UTC). Verdicts of before that come later are
    /// counted and left out ([`super::Taken::thinned`]): choose a day before which every box has delivered.
    ///
    /// Killed at any point, no question is answered otherwise: all of it is one transaction. Where the database has
    /// none, what is valid is the number that is written between the sums and the deletion, and the next
    /// thinning ends what was begun.
    ///
    /// # Errors
    /// The database refuses.
    pub fn thin(&mut self, before_day: i64) -> Result<Thinned, StoreError> {
        let before = before_day.saturating_mul(DAY_US);
        let done = self.meta("thinned_before_us")?.unwrap_or(0);
        let cut = before.max(done);
        let mut statements = leavings(done).to_vec();
        if cut > done {
            statements.push(format!(
                "INSERT INTO days SELECT machine, day, state, {cut}, min(month), count(*), sum(seconds) \
                 FROM records{} WHERE {} GROUP BY machine, day, state",
                if self.backend.dialect().has_transactions() {
                    ""
                } else {
                    " FINAL"
                },
                verdicts_before(cut)
            ));
        }
        if self.backend.dialect().has_transactions() {
            statements.push(put("thinned_before_us", cut));
            statements.push(format!(
                "DELETE FROM records WHERE {}",
                verdicts_before(cut)
            ));
            statements.extend(sums::anew("kind = 'verdict'"));
            self.backend.execute_all(&statements)?;
        } else {
            self.backend.execute_all(&statements)?;
            self.set_meta("thinned_before_us", cut)?;
            self.backend.execute(&format!(
                "DELETE FROM records WHERE {}",
                verdicts_before(cut)
            ))?;
        }
        if cut == done {
            return Ok(Thinned {
                verdicts: 0,
                days: 0,
            });
        }
        let rows = self.backend.query(
            "SELECT CAST(coalesce(sum(verdicts), 0) AS BIGINT), count(*) FROM @days WHERE thinned_us = ?",
            &[cut.into()],
        )?;
        let row = rows
            .first()
            .ok_or_else(|| StoreError::Answer("no count of days".to_owned()))?;
        Ok(Thinned {
            verdicts: row[0].int()?,
            days: row[1].int()?,
        })
    }
}

fn verdicts_before(time_us: i64) -> String {
    format!("kind = 'verdict' AND time_us < {time_us}")
}

/// Statements that take away what a thinning that was killed left behind.
pub(super) fn leavings(done_us: i64) -> [String; 2] {
    [
        format!("DELETE FROM days WHERE thinned_us > {done_us}"),
        format!("DELETE FROM records WHERE {}", verdicts_before(done_us)),
    ]
}

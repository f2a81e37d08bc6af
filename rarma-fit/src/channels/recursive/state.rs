//! All that the model knows, number by number: to be kept, and to go on from later.
//!
//! Slow path. Settings and order are not part of it.

use super::RecursiveChannels;
use rarma_core::estimate::StateVisitor;

impl RecursiveChannels {
    /// Shows every number of the state to `visitor`, as
    /// [`RecursiveArma::visit_state`](rarma_core::estimate::RecursiveArma::visit_state) does;
    /// false where what it has put in is not the state of a model of this order and these
    /// settings, and the model is then of no use.
    #[must_use]
    pub fn visit_state(&mut self, visitor: &mut impl StateVisitor<f64>) -> bool {
        // All of them by name, so that none is forgotten.
        let Self {
            p: _,
            q: _,
            config,
            theta,
            channels,
            covariance,
            noise,
            scores,
            moments,
            stored,
            ready,
            known,
            count,
            turn,
            at_ceiling,
            scratch: _,
        } = self;
        let n = theta.len();
        theta.iter_mut().for_each(|x| visitor.number(x));
        for channel in channels.iter_mut() {
            channel.all().for_each(|x| visitor.number(x));
        }
        covariance.visit_part(n, visitor);
        noise.all().for_each(|x| visitor.number(x));
        for (run, sum) in noise.runs() {
            visitor.count(run);
            visitor.number(sum);
        }
        scores.visit(visitor);
        moments.all().for_each(|x| visitor.number(x));
        let mut is_ready = u32::from(*ready);
        visitor.count(&mut is_ready);
        *ready = is_ready != 0;
        visitor.count(known);
        visitor.count(count);
        let mut places = [*turn, *at_ceiling, stored.len()].map(|n| n as u32);
        places.iter_mut().for_each(|n| visitor.count(n));
        let [t, c, s] = places.map(|n| n as usize);
        (*turn, *at_ceiling) = (t, c);
        let most = config.start_samples as usize * channels.len();
        let sound = t <= n && c <= n && s <= most && s % channels.len() == 0 && is_ready <= 1;
        if sound {
            stored.resize(s, 0.0);
            stored.iter_mut().for_each(|x| visitor.number(x));
        }
        sound
    }
}

use super::*;
use crate::estimate::Gradient;
use crate::spectrum::modal;

const FS: f64 = 6000.0;

/// Two modes in noise; a loud sample, a bad one and a stretch of silence on the way.
fn signal() -> Vec<f32> {
    let (mut seed, mut y) = (7u32, [0.0f64; 4]);
    (0..6000)
        .map(|n| {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let noise = f64::from(seed >> 8) / 8_388_608.0 - 1.0;
            let first = noise + 0.95 * y[0] - 0.9 * y[1];
            let second = noise - 0.4 * y[2] - 0.97 * y[3];
            y = [first, y[0], second, y[2]];
            match n {
                2500 => 1e4,
                3000 => f32::NAN,
                3500..=3600 => 0.0,
                _ => (first + 0.3 * second) as f32,
            }
        })
        .collect()
}

/// Bits of what a model says after a sample.
type Said = (Vec<u32>, Vec<u32>, Vec<u32>, u32, Vec<[u32; 2]>, bool, bool);

fn bits<'a>(x: impl IntoIterator<Item = &'a f32>) -> Vec<u32> {
    x.into_iter().map(|x| x.to_bits()).collect()
}

/// The same model and roots by themselves.
fn plain<const P: usize, const Q: usize, const N: usize>(config: RarmaConfig<f32>) -> Vec<Said> {
    let mut model = RecursiveArma::<f32, P, Q, N>::new(config);
    let mut roots = FactorTracker::<f32, P>::new();
    let mut lost = true;
    let each = signal().into_iter().map(|y| {
        match model.update(y).status {
            Status::Rejected => {}
            Status::Starting => {
                roots.search();
                lost = true;
            }
            _ => lost = roots.track(model.a()) == Tracking::Searching,
        }
        let factors = roots.factors(P);
        let own: Vec<f32> = factors
            .iter()
            .map(|factor| isolate(model.a(), factor, model.filtered_outputs()))
            .collect();
        let scale = model.covariance_factor();
        let sd = factors
            .iter()
            .filter_map(|q| deviation(model.a(), N, q, FS as f32, model.covariance(), scale))
            .map(|sd| [sd.frequency.to_bits(), sd.damping.to_bits()])
            .collect();
        (
            bits(model.theta()),
            bits(factors.iter().flat_map(|q| [&q.u, &q.v])),
            bits(&own),
            model.sigma2().to_bits(),
            sd,
            model.ready(),
            lost,
        )
    });
    each.collect()
}

fn erased(identifier: &mut Identifier<f32>) -> Vec<Said> {
    let each = signal().into_iter().map(|y| {
        let mut own = [0.0; MAX_MODES];
        let modes = identifier.update(y, &mut own);
        let factors = identifier.factors();
        assert_eq!(modes, factors.len());
        let sd = identifier.deviations(FS as f32);
        let sd = sd
            .iter()
            .flatten()
            .map(|sd| [sd.frequency.to_bits(), sd.damping.to_bits()])
            .collect();
        (
            bits(identifier.a().iter().chain(identifier.c())),
            bits(factors.iter().flat_map(|q| [&q.u, &q.v])),
            bits(&own[..modes]),
            identifier.sigma2().to_bits(),
            sd,
            identifier.is_ready(),
            identifier.is_lost(),
        )
    });
    each.collect()
}

#[test]
fn every_order_gives_what_its_model_gives_bit_by_bit_whatever_was_there_before() {
    let config = RarmaConfig {
        gradient: Gradient::Filtered,
        forgetting: 0.998,
        variance_gain: 0.002,
        random_walk: 1e-7,
        ..RarmaConfig::default()
    };
    // One after the other in the same place.
    let mut identifier = Identifier::default();
    for order in Order::ALL {
        let wanted = match order {
            Order::O21 => plain::<2, 1, 3>(config),
            Order::O22 => plain::<2, 2, 4>(config),
            Order::O43 => plain::<4, 3, 7>(config),
            Order::O44 => plain::<4, 4, 8>(config),
            Order::O65 => plain::<6, 5, 11>(config),
            Order::O66 => plain::<6, 6, 12>(config),
            Order::O87 => plain::<8, 7, 15>(config),
            Order::O88 => plain::<8, 8, 16>(config),
        };
        for run in 0..2 {
            identifier.restart(order, config);
            assert_eq!(identifier.order(), Some(order));
            let said = erased(&mut identifier);
            let differs = said.iter().zip(&wanted).position(|(a, b)| a != b);
            assert_eq!(differs, None, "{order:?}, run {run}");
        }
        assert!(
            identifier.is_ready() && identifier.is_definite(),
            "{order:?}"
        );
        // Those with room for both modes have found the first: a sixth of the rate.
        let near = |q: &Quadratic<f32>| {
            modal(q, FS as f32).is_some_and(|mode| (mode.frequency - 1000.0).abs() < 60.0)
        };
        assert!(
            order.p() < 4 || identifier.factors().iter().any(near),
            "{order:?}"
        );
    }
}

#[test]
fn before_it_is_started_it_says_nothing() {
    let mut identifier = Identifier::<f32>::default();
    assert_eq!(identifier.update(1.0, &mut [0.0; MAX_MODES]), 0);
    assert!(!identifier.is_ready() && identifier.is_lost());
    assert!(identifier.order().is_none() && identifier.factors().is_empty());
    assert!(identifier.a().is_empty() && identifier.c().is_empty());
    assert!(identifier.sigma2() == 0.0 && identifier.is_definite());
}

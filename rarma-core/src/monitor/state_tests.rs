use super::{Monitor, MonitorConfig};
use crate::order::Order;
use crate::visit::StateVisitor;

const FS_HZ: f64 = 12_000.0;
const TURN_HZ: f64 = 75.0;

/// Numbers and counts as they come, as bits.
#[derive(Debug, Default, Clone, PartialEq)]
struct Kept(Vec<(bool, u32)>);

impl StateVisitor<f32> for Kept {
    fn number(&mut self, x: &mut f32) {
        self.0.push((true, x.to_bits()));
    }
    fn count(&mut self, n: &mut u32) {
        self.0.push((false, *n));
    }
}

/// Puts them back; what is asked for beyond them is 0.
struct Back<'a>(core::slice::Iter<'a, (bool, u32)>);

impl Back<'_> {
    fn take(&mut self) -> u32 {
        self.0.next().map_or(0, |(_, bits)| *bits)
    }
}

impl StateVisitor<f32> for Back<'_> {
    fn number(&mut self, x: &mut f32) {
        *x = f32::from_bits(self.take());
    }
    fn count(&mut self, n: &mut u32) {
        *n = self.take();
    }
}

struct Random(u32);

impl Random {
    fn below(&mut self, n: u32) -> u32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        ((u64::from(self.0 >> 8) * u64::from(n)) >> 24) as u32
    }

    fn part(&mut self) -> f64 {
        f64::from(self.below(1 << 20)) / f64::from(1 << 20)
    }
}

/// Idle, a cut with the lines of a turning mill, a chatter that grows and dies, another speed, and
/// what is wrong with samples now and then.
fn cut() -> Vec<f32> {
    let mut random = Random(7);
    let mut angle = 0.0;
    let sample = |n: usize| {
        let t = n as f64 / FS_HZ;
        let speed = if t < 3.0 { TURN_HZ } else { 1.08 * TURN_HZ };
        angle += core::f64::consts::TAU * speed / FS_HZ;
        let noise = 0.02 * (random.part() + random.part() - random.part() - random.part());
        if t < 0.4 {
            return noise as f32;
        }
        let lines: f64 = [4.0, 8.0, 12.0, 16.0, 20.0, 24.0]
            .iter()
            .map(|k| 0.05 * libm::sin(k * angle))
            .sum();
        let loud = if (1.4..2.4).contains(&t) {
            (0.004 * libm::exp(12.0 * (t - 1.4))).min(0.6)
        } else {
            0.0
        };
        let chatter = loud * libm::sin(core::f64::consts::TAU * 1013.0 * t);
        let rings = 0.05 * libm::sin(core::f64::consts::TAU * 611.0 * t) * (random.part() - 0.5);
        let x = noise + lines + chatter + rings;
        match n {
            30_000..30_003 => f32::NAN,
            31_000..31_200 => 0.25,
            _ => x.clamp(-0.7, 0.7) as f32,
        }
    };
    (0..(4.5 * FS_HZ) as usize).map(sample).collect()
}

fn settings() -> Vec<MonitorConfig> {
    let usual = MonitorConfig {
        full_scale: Some(0.7),
        ..MonitorConfig::new(FS_HZ)
    };
    let told = MonitorConfig {
        spindle_hz: Some(TURN_HZ),
        teeth: Some(4),
        ..usual
    };
    vec![
        MonitorConfig {
            order: Order::O43,
            ..usual
        },
        told,
        MonitorConfig {
            order: Order::O22,
            tacho_pulses: Some(1),
            idle_s: Some((0.0, 0.3)),
            ..told
        },
        MonitorConfig {
            order: Order::O66,
            aliased: true,
            ..usual
        },
    ]
}

/// Sample `n`, and what else happens then.
fn push(monitor: &mut Monitor<f32>, config: &MonitorConfig, n: usize, x: f32, said: &mut String) {
    if n == 33_000 {
        monitor.missing(700);
    }
    if n == 37_000 {
        monitor.tell_speed(81.0).expect("in range");
    }
    if config.tacho_pulses.is_some() && n.is_multiple_of(160) && n < 35_000 {
        monitor.pulse(0.25);
    }
    if let Some(report) = monitor.push(x) {
        *said = format!("{report:?}");
    }
}

fn kept(monitor: &mut Monitor<f32>) -> Kept {
    let mut kept = Kept::default();
    assert!(monitor.visit_state(&mut kept));
    kept
}

/// What the cut must have led to, so that each of them was cut through.
const EACH: [&str; 7] = [
    "state: Starting",
    "state: Idle",
    "state: Stable",
    "state: Warning",
    "state: Chatter",
    "state: Invalid",
    "locked: true",
];

#[test]
fn goes_on_from_any_sample_as_if_nothing_had_been() {
    let cut = cut();
    let mut random = Random(11);
    let mut shown = std::collections::BTreeSet::<&str>::new();
    for config in settings() {
        let mut cuts: Vec<usize> = (0..14)
            .map(|_| random.below(cut.len() as u32) as usize)
            .collect();
        // Each stage of a window's work takes a few samples: three within one.
        cuts.extend([0, 1, 25_000, 25_031, 25_118, 37_001]);
        let mut whole = Monitor::new(&config).expect("in range");
        let mut others: Vec<(usize, Monitor<f32>, String)> = Vec::new();
        let mut said = String::new();
        for (n, x) in cut.iter().enumerate() {
            if cuts.contains(&n) {
                let state = kept(&mut whole);
                let mut again = Monitor::new(&config).expect("in range");
                let mut back = Back(state.0.iter());
                assert!(again.visit_state(&mut back), "{n}");
                assert_eq!(back.0.len(), 0, "all of it is read");
                // Every field, those that are taken for settings, too.
                assert!(format!("{again:?}") == format!("{whole:?}"), "{n}");
                others.push((n, again, said.clone()));
            }
            push(&mut whole, &config, n, *x, &mut said);
            // For a third of a second each: what is the same then stays so.
            others.retain_mut(|(from, other, told)| {
                push(other, &config, n, *x, told);
                assert!(*told == said, "cut at {from}, sample {n}");
                let is_over = n == *from + 4000 || n + 1 == cut.len();
                assert!(!is_over || kept(other) == kept(&mut whole), "{from}");
                !is_over
            });
            if n.is_multiple_of(500) {
                shown.extend(EACH.iter().filter(|word| said.contains(**word)));
            }
        }
        assert!(others.is_empty());
    }
    assert_eq!(shown.len(), EACH.len(), "{shown:?}");
}

#[test]
fn what_is_put_in_by_force_is_refused_or_harmless() {
    let cut = cut();
    let config = MonitorConfig {
        tacho_pulses: Some(1),
        ..settings()[1]
    };
    let mut whole = Monitor::new(&config).expect("in range");
    let mut said = String::new();
    let (mut refused, mut taken) = (0, 0);
    let mut random = Random(5);
    for (n, x) in cut.iter().enumerate() {
        push(&mut whole, &config, n, *x, &mut said);
        if ![9_000, 25_003, 25_031, 36_000].contains(&n) {
            continue;
        }
        let state = kept(&mut whole);
        let counts: Vec<usize> = (0..state.0.len()).filter(|k| !state.0[*k].0).collect();
        let mut places: Vec<usize> = counts.iter().flat_map(|k| [*k; 8]).collect();
        places.extend((0..300).map(|_| random.below(state.0.len() as u32) as usize));
        for place in places {
            let mut wrong = state.clone();
            let (is_number, bits) = &mut wrong.0[place];
            *bits = if *is_number {
                [f32::NAN, f32::INFINITY, -3e38, 3e38, 0.0, -1.0][random.below(6) as usize]
                    .to_bits()
            } else {
                let near = bits.wrapping_add(random.below(5)).wrapping_sub(2);
                [0, 1, near, 17, 255, 1023, 65_535, 1 << 30, u32::MAX][random.below(9) as usize]
            };
            let mut other = Monitor::new(&config).expect("in range");
            if !other.visit_state(&mut Back(wrong.0.iter())) {
                refused += 1;
                continue;
            }
            taken += 1;
            // Whatever it says now: it goes on, and does not break off.
            for (n, x) in cut.iter().enumerate().skip(n + 1).take(700) {
                push(&mut other, &config, n, *x, &mut said);
            }
        }
    }
    assert!(refused > 100 && taken > 100, "{refused} {taken}");
}

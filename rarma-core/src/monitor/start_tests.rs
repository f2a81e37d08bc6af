use super::*;
use crate::condition::BandError;
use crate::order::Order;

/// A second of a mode in noise over the teeth of a cutter.
fn listen(monitor: &mut Monitor<f32>, fs: f32) -> Vec<String> {
    let mut seed = 1u32;
    let samples = (0..fs as usize).filter_map(|n| {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let noise = (seed >> 8) as f32 / 8_388_608.0 - 1.0;
        let t = n as f32 / fs;
        if n % 101 == 0 {
            monitor.pulse(0.25);
        }
        monitor.push(0.3 * noise + (5200.0 * t).sin() + (2400.0 * t).sin())
    });
    samples.map(|report| format!("{report:?}")).collect()
}

fn settings(order: Order, fs: f64, spindle_hz: Option<f64>) -> MonitorConfig {
    MonitorConfig {
        order,
        spindle_hz,
        teeth: spindle_hz.map(|_| 5),
        tacho_pulses: spindle_hz.map(|_| 1),
        full_scale: Some(2.0),
        idle_s: Some((0.0, 0.1)),
        ..MonitorConfig::new(fs)
    }
}

#[test]
fn begun_anew_it_is_as_a_new_one_whatever_it_was() {
    let mut monitor = Monitor::<f32>::unstarted();
    for config in [
        settings(Order::O87, 8000.0, Some(76.4)),
        settings(Order::O21, 48_000.0, None),
        // Too slow for lines, and the told speed too low to be looked for.
        settings(Order::O88, 6000.0, Some(0.5)),
        settings(Order::O88, 8000.0, None),
        settings(Order::O43, 192_000.0, Some(100.0)),
    ] {
        let mut new = Monitor::<f32>::new(&config).unwrap();
        for _ in 0..2 {
            monitor.restart(&config).unwrap();
            assert_eq!(format!("{monitor:?}"), format!("{new:?}"));
            listen(&mut monitor, config.fs_hz as f32);
        }
        monitor.restart(&config).unwrap();
        let said = listen(&mut monitor, config.fs_hz as f32);
        assert!(said.len() > 400);
        assert!(said == listen(&mut new, config.fs_hz as f32));
    }
}

#[test]
fn settings_out_of_range_leave_it_as_it_was() {
    let good = settings(Order::O43, 8000.0, None);
    let mut monitor = Monitor::<f32>::new(&good).unwrap();
    listen(&mut monitor, 8000.0);
    let before = format!("{monitor:?}");
    let bad = [
        (
            MonitorConfig { fs_hz: 0.0, ..good },
            MonitorError::Band(BandError::Rate),
        ),
        (
            MonitorConfig {
                threshold: 1.0,
                ..good
            },
            MonitorError::Threshold,
        ),
        (
            MonitorConfig {
                teeth: Some(0),
                ..good
            },
            MonitorError::Teeth,
        ),
    ];
    for (config, why) in bad {
        assert_eq!(monitor.restart(&config), Err(why));
        assert_eq!(format!("{monitor:?}"), before);
    }
}

#[test]
fn before_it_is_started_it_says_nothing() {
    let mut monitor = Monitor::<f32>::unstarted();
    assert!(listen(&mut monitor, 8000.0).is_empty());
    monitor.missing(5);
    assert_eq!(monitor.samples(), 8005);
    assert!(monitor.model().order().is_none());
}

/// What the box has to find room for, once, whatever the order.
#[test]
fn it_is_as_large_as_told() {
    let bytes = size_of::<Monitor<f32>>();
    println!(
        "monitor {bytes} bytes: model {}, spindle {}, filter {}, modes {}",
        size_of::<Identifier<f32>>(),
        size_of::<Spindle<f32>>(),
        size_of::<BandFilter<f32>>(),
        size_of::<[Slot<f32>; MAX_MODES]>(),
    );
    assert!((50_500..52_500).contains(&bytes), "{bytes}");
}

#[test]
fn samples_in_a_row_are_samples_one_by_one() {
    for (order, fs) in [
        (Order::O43, 6000.0),
        (Order::O21, 48_000.0),
        (Order::O22, 192_000.0),
    ] {
        let config = settings(order, fs, Some(76.4));
        let mut singly = Monitor::<f32>::new(&config).expect("settings");
        let mut rows = singly.clone();
        let mut seed = 1u32;
        let mut random = move |below: u32| {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 8) % below
        };
        let (mut n, mut reports) = (0u32, 0);
        while n < fs as u32 / 2 {
            let row: Vec<f32> = (0..1 + random(200))
                .map(|_| {
                    n += 1;
                    let t = n as f32 / fs as f32;
                    let noise = random(1000) as f32 / 500.0 - 1.0;
                    match random(5000) {
                        0 => f32::NAN,
                        1 => 5.0,
                        _ => 0.3 * noise + (5200.0 * t).sin() + (2400.0 * t).sin(),
                    }
                })
                .collect();
            if random(50) == 0 {
                singly.missing(3);
                rows.missing(3);
            }
            let wanted: Vec<String> = row
                .iter()
                .filter_map(|x| singly.push(*x).map(|report| format!("{report:?}")))
                .collect();
            let (mut left, mut got) = (row.iter(), Vec::new());
            while let Some(report) = rows.push_row(&mut left) {
                got.push(format!("{report:?}"));
            }
            assert_eq!(got, wanted, "{fs} Hz, sample {n}");
            assert!(left.as_slice().is_empty());
            reports += got.len();
        }
        assert!(reports > 100, "{reports}");
        assert_eq!(
            (rows.samples(), rows.fault()),
            (singly.samples(), singly.fault())
        );
    }
}

//! Advice in words a machinist can act on.

use super::{AdviceRecord, HelpRecord, MachineRecord, Missing, SpeedRecord, VariationRecord};

/// What to do about one alarm, a sentence each.
pub fn sentences(advice: &AdviceRecord) -> Vec<String> {
    let [low, high] = advice.reach_rpm;
    let mut out = Vec::new();
    match advice.machine {
        Some(MachineRecord::Contradicts) => out.push(
            "The machine that is told does not chatter at this speed, nor do machines like it: the file is of another tool, cut or set-up. What follows is without it."
                .to_owned(),
        ),
        Some(MachineRecord::Expects) => out.push(
            "The machine that is told chatters where this cut does, but at another frequency: something else may be heard, or the file be of another tool. The speeds are those of the file."
                .to_owned(),
        ),
        _ => {}
    }
    match advice.speeds.split_first() {
        Some((first, others)) => {
            out.push(format!(
                "Turn {:.0} 1/min instead of {:.0}{}: stable with a chance of {:.0} %. Its pocket goes from {:.0} to {:.0} 1/min.",
                first.rpm,
                advice.rpm,
                feed(first),
                100.0 * first.chance,
                first.pocket_rpm[0],
                first.pocket_rpm[1],
            ));
            if !others.is_empty() {
                let list = others.iter().map(|s| {
                    let chance = 100.0 * s.chance;
                    format!("{:.0} 1/min ({chance:.0} %{})", s.rpm, feed(s))
                });
                let list: Vec<String> = list.collect();
                out.push(format!(
                    "If it chatters there, try {}.",
                    list.join(", then ")
                ));
            }
        }
        None => {
            let why = if advice.waves > advice.most_waves {
                format!(
                    " The chatter swings {:.1} times between two teeth, and from about {:.0} times on there is no stable speed between two others.",
                    advice.waves, advice.most_waves
                )
            } else {
                String::new()
            };
            out.push(format!(
                "No stable speed within reach ({low:.0} to {high:.0} 1/min).{why}"
            ));
            let helps: Vec<&str> = advice.helps.iter().map(|h| help(*h)).collect();
            out.push(format!("What helps: {}.", helps.join("; ")));
            out.extend(advice.variation.as_ref().map(swing));
            if let Some(rpm) = advice.beyond_rpm {
                out.push(format!(
                    "Above the reach the next pocket lies just below {rpm:.0} 1/min."
                ));
            }
        }
    }
    out
}

/// A speed that swings, and what to expect of it.
fn swing(v: &VariationRecord) -> String {
    let chance = 100.0 * v.chance;
    if v.helps {
        format!(
            "A swing of the speed is likely to help: from {:.0} to {:.0} 1/min and back, a sine {} times a second (RVA {:.2}, RVF {:.3}): stable with a chance of {chance:.0} %.",
            v.rpm[0], v.rpm[1], v.swing, v.rva, v.rvf
        )
    } else {
        format!(
            "A swing of the speed is not likely to help (chance {chance:.0} %): the best that the drive can do, {:.0} to {:.0} 1/min {} times a second, swings the phase of the wave between two teeth by {:.1} rad to either side.",
            v.rpm[0], v.rpm[1], v.swing, v.phase
        )
    }
}

/// How the feed follows.
fn feed(speed: &SpeedRecord) -> String {
    let percent = 100.0 * (speed.feed_ratio - 1.0);
    if percent.abs() < 0.5 {
        String::new()
    } else {
        format!(", feed {percent:+.0} %")
    }
}

fn help(help: HelpRecord) -> &'static str {
    match help {
        HelpRecord::LessDepth => "less depth of cut",
        HelpRecord::SpeedVariation => "a spindle speed that swings all the time",
        HelpRecord::OtherTeeth => "a cutter with fewer or unequally spaced teeth",
    }
}

/// What must be told before a speed can be, if anything.
pub fn missing_words(missing: &[Missing]) -> Option<String> {
    if missing.is_empty() {
        return None;
    }
    let parts: Vec<&str> = missing
        .iter()
        .map(|one| match one {
            Missing::Speed => "the speed of the spindle (--rpm, --speed-from or --tacho)",
            Missing::Teeth => "the number of teeth (--teeth)",
        })
        .collect();
    Some(format!(
        "Which speed to turn instead cannot be said: tell {}.",
        parts.join(" and ")
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn speed(rpm: f64, feed_ratio: f64) -> SpeedRecord {
        SpeedRecord {
            rpm,
            rpm_sd: 50.0,
            pocket_rpm: [0.97 * rpm, 1.03 * rpm],
            pocket: 3,
            chance: 0.71,
            margin: 2.0,
            ratio: feed_ratio,
            feed_ratio,
        }
    }

    fn advice(speeds: Vec<SpeedRecord>) -> AdviceRecord {
        AdviceRecord {
            rpm: 9000.0,
            reach_rpm: [4500.0, 13_500.0],
            waves: 3.76,
            most_waves: 20.0,
            mode: 1100.0,
            of_structure: false,
            speeds,
            beyond_rpm: Some(16_500.0),
            helps: vec![HelpRecord::LessDepth, HelpRecord::OtherTeeth],
            variation: None,
            lobes: None,
            known: Vec::new(),
            machine: None,
        }
    }

    #[test]
    fn a_speed_and_what_comes_after_it() {
        let said = sentences(&advice(vec![speed(10_700.0, 1.189), speed(8155.0, 0.906)]));
        assert!(said[0].starts_with(
            "Turn 10700 1/min instead of 9000, feed +19 %: stable with a chance of 71 %."
        ));
        assert_eq!(
            said[1],
            "If it chatters there, try 8155 1/min (71 %, feed -9 %)."
        );
    }

    #[test]
    fn none_within_reach_and_what_helps() {
        let said = sentences(&advice(Vec::new()));
        assert_eq!(
            said[0],
            "No stable speed within reach (4500 to 13500 1/min)."
        );
        assert!(said[1].contains("less depth of cut; a cutter"));
        assert!(said[2].contains("16500"));
        let many = AdviceRecord {
            waves: 90.0,
            ..advice(Vec::new())
        };
        assert!(sentences(&many)[0].contains("swings 90.0 times"));
    }

    #[test]
    fn a_swing_is_said_with_its_chance() {
        let swing = VariationRecord {
            rva: 0.2,
            rvf: 0.08,
            rpm: [1200.0, 1800.0],
            swing: 2.0,
            acceleration: 395.0,
            phase: 31.4,
            chance: 0.85,
            growth_ratio: -2.0,
            helps: true,
        };
        let with = |variation| AdviceRecord {
            variation: Some(variation),
            ..advice(Vec::new())
        };
        let said = sentences(&with(swing.clone()));
        assert!(said[2].starts_with("A swing of the speed is likely to help: from 1200 to 1800"));
        assert!(said[2].contains("2 times a second") && said[2].ends_with("85 %."));
        let not = VariationRecord {
            helps: false,
            chance: 0.1,
            phase: 1.3,
            ..swing
        };
        let said = sentences(&with(not));
        assert!(
            said[2].contains("not likely to help (chance 10 %)") && said[2].contains("1.3 rad")
        );
    }

    #[test]
    fn a_machine_that_does_not_chatter_so_is_said_first() {
        let with = |machine| AdviceRecord {
            machine,
            ..advice(vec![speed(10_700.0, 1.0)])
        };
        let said = sentences(&with(Some(MachineRecord::Contradicts)));
        assert!(said[0].contains("does not chatter at this") && said[1].starts_with("Turn 10700"));
        let said = sentences(&with(Some(MachineRecord::Expects)));
        assert!(said[0].contains("at another frequency") && said[1].starts_with("Turn 10700"));
        let plain = sentences(&with(None));
        assert_eq!(sentences(&with(Some(MachineRecord::Explains))), plain);
    }

    #[test]
    fn what_is_missing_is_named() {
        assert_eq!(missing_words(&[]), None);
        let all = missing_words(&[Missing::Speed, Missing::Teeth]).unwrap();
        assert!(all.contains("--rpm") && all.contains(" and ") && all.contains("--teeth"));
    }
}

//! Which commands the gallery shows.

use crate::inputs::roles::Input;

/// A command that makes a page of pictures.
#[derive(Debug, Clone, Copy)]
pub struct Shown {
    /// Its part of the gallery, and of the names of its pictures.
    pub name: &'static str,
    /// What it is about.
    pub title: &'static str,
    /// Files that it reads and no command makes.
    pub inputs: &'static [(Input, &'static str)],
    /// Commands that make what it reads.
    pub before: &'static [&'static str],
    /// The command itself. It writes its page into `page/`.
    pub line: &'static str,
}

/// Commands with the pictures of another one.
pub const ALIKE: [(&str, &str); 2] = [
    // It needs an emulator, or a sound card.
    ("target", "monitor"),
    ("listen", "monitor"),
];

const CHATTERS: &str = "rarma simulate three-mode-chatter --out cut.wav";

const TURNS: &str = "rarma simulate turning-980 --out cut.wav";

const fn shown(
    name: &'static str,
    title: &'static str,
    before: &'static [&'static str],
    line: &'static str,
) -> Shown {
    Shown {
        name,
        title,
        inputs: &[],
        before,
        line,
    }
}

/// All of them, in the order of the gallery.
pub const SHOWN: &[Shown] = &[
    shown(
        "demo",
        "The demonstration: a face mill into chatter and out again",
        &[],
        "rarma demo --out page/",
    ),
    shown(
        "monitor",
        "A recording, listened to",
        &["rarma simulate slotted-workpiece --out cut.wav"],
        "rarma monitor cut.wav --report page/",
    ),
    shown(
        "monitor-two",
        "Two recordings beside each other: a boring bar, and one with more damping",
        &[
            "rarma simulate slender-bar --out before.wav",
            "rarma simulate damped-bar --out after.wav",
        ],
        "rarma monitor before.wav after.wav --rpm 420 --report page/",
    ),
    shown(
        "advise",
        "Which speed to turn instead",
        &[CHATTERS],
        "rarma advise cut.wav --rpm 11000 --teeth 3 --report page/",
    ),
    shown(
        "act",
        "What it would order of the machine's controller",
        &[CHATTERS],
        "rarma act cut.wav --rpm 11000 --teeth 3 --controller dry --override 80:120 --report page/",
    ),
    shown(
        "identify",
        "One model of a whole recording, beside other orders and methods",
        &[TURNS],
        "rarma identify cut.wav --order 4,3 --report page/",
    ),
    shown(
        "identify-channels",
        "Modes and their shapes from several sensors",
        &["rarma cers run cers-rest --quick --out rest/"],
        "rarma identify rest/signals.wav --channels 8,9 --order 24,0 --report page/",
    ),
    shown(
        "order",
        "How many poles a recording needs",
        &[TURNS],
        "rarma order cut.wav --band 300:2500 --report page/",
    ),
    shown(
        "lobes",
        "Stability lobes of two machines",
        &[],
        "rarma lobes two-tooth-benchmark two-tooth-up --rpm 5000:25000 --max-depth-mm 3 --report page/",
    ),
    shown(
        "sweep",
        "True damping and what is read of it, over depth",
        &[],
        "rarma sweep turning-980 --rpm 12000,1500 --depth-mm 0.02:0.6 --report page/",
    ),
    shown(
        "population",
        "How often the verdict is right, on machines drawn at random",
        &[],
        "rarma population --seeds 0:20 --told 1,none --report page/",
    ),
    shown(
        "els-model",
        "A machine under load, from its beams and joints",
        &[],
        "rarma els model els-load-bar --report page/",
    ),
    shown(
        "els-limit",
        "Limit of stability all round, from receptances",
        &["rarma els model els-load-bar --uff machine.uff"],
        "rarma els limit machine.uff --chip-angle 60 --static 30:250 --report page/",
    ),
    Shown {
        inputs: &[
            (Input::Force, "force.wav"),
            (Input::Acceleration, "response.wav"),
        ],
        ..shown(
            "els-hammer",
            "A hammer record to its modes",
            &[],
            "rarma els hammer force.wav response.wav --band 500:3000 --report page/",
        )
    },
    shown(
        "ldbb-run",
        "Loaded ball bar: errors, stiffness all round, hysteresis",
        &[],
        "rarma ldbb run ldbb-m3 --out m3/ --report page/",
    ),
    shown(
        "ldbb-analyse",
        "Readings of a ball bar, judged by a tolerance",
        &["rarma ldbb run ldbb-weak --out weak/"],
        "rarma ldbb analyse weak/ --tolerance 10 --report page/",
    ),
    shown(
        "ldbb-compare",
        "Two machines under the same load",
        &[
            "rarma ldbb run ldbb-m3 --out m3/",
            "rarma ldbb run ldbb-m5 --out m5/",
        ],
        "rarma ldbb compare m3/ m5/ --report page/",
    ),
    shown(
        "cers-run",
        "Exciter: responses and modes of a spindle that turns",
        &[],
        "rarma cers run cers-turning --quick --report page/",
    ),
    shown(
        "cers-sweep",
        "Exciter: the same over speed",
        &[],
        "rarma cers run cers-sweep --quick --report page/",
    ),
    shown(
        "cers-analyse",
        "Exciter: a record, evaluated again",
        &["rarma cers run cers-rest --out rest/"],
        "rarma cers analyse rest/ --report page/",
    ),
    shown(
        "trends",
        "Machines over a year: what has changed, since when, and what it does",
        &[
            "rarma plant --machines 10 --months 12 --seed 1 --out plant/",
            "rarma store add plant/records.jsonl --store plant.db",
        ],
        "rarma trends --store plant.db --report page/",
    ),
];

impl Shown {
    /// All its lines, in the order in which they are run.
    pub fn lines(&self) -> impl Iterator<Item = &'static str> {
        self.before.iter().copied().chain([self.line])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_is_one_of_rarma_and_writes_its_page() {
        let mut names: Vec<&str> = SHOWN.iter().map(|shown| shown.name).collect();
        for shown in SHOWN {
            for line in shown.lines() {
                assert!(line.starts_with("rarma "), "{line}");
            }
            assert!(shown.line.ends_with(" page/"), "{}", shown.line);
        }
        names.sort_unstable();
        let all = names.len();
        names.dedup();
        assert_eq!(names.len(), all, "two of one name");
    }
}

//! Promise: bad input of every kind, to every command that reads one, is one line with file,
//! place, reason and remedy, in the words of people.

use host_tests::files::{FLOAT, Folder, PCM, wav};
use host_tests::process::Rarma;
use host_tests::rarma;
use host_tests::refusal::assert_one_line;
use std::fs::File;
use std::path::Path;

fn program() -> Rarma {
    rarma!()
}

/// Runs `rarma` with these words, FILE among them standing for the path.
fn run(line: &str, file: &Path) -> host_tests::process::Ended {
    let words = line.split_whitespace().map(|word| match word {
        "FILE" => file.as_os_str().to_owned(),
        word => word.into(),
    });
    program().run(words)
}

/// Every command that takes a scenario, and a line of that kind of scenario.
const SCENARIOS: [(&str, &str); 8] = [
    ("simulate FILE --json", "[milling]"),
    ("lobes FILE", "[milling]"),
    ("choose-order FILE", "[turning]"),
    ("sweep FILE --depth-mm 1:2", "[turning]"),
    ("box --sim FILE", "[[host]]"),
    ("cers run FILE", "[excitation]"),
    ("ldbb run FILE", "plane = \"XY\""),
    ("els model FILE", "[[holder]]"),
];

#[test]
fn scenarios_that_are_none() {
    let folder = Folder::default();
    let cases: [(&str, Vec<u8>, &[&str]); 12] = [
        ("empty", Vec::new(), &["line 1", "is missing"]),
        ("word", b"name".to_vec(), &["line 1, column ", "not TOML"]),
        (
            "open-text",
            b"name = \"a\nb = 1\n".to_vec(),
            &["line 1", "not TOML", "text in quotes"],
        ),
        (
            "open-lines",
            b"name = \"\"\"a\nb = 1\n".to_vec(),
            &["not TOML"],
        ),
        ("open-list", b"seed = [1,\n2,\n".to_vec(), &["not TOML"]),
        (
            "open-table",
            b"name = \"a\"\n[link\n".to_vec(),
            &["line 2, column ", "not TOML"],
        ),
        (
            "twice",
            b"name = \"a\"\nname = \"b\"\n".to_vec(),
            &["line 2", "not TOML"],
        ),
        (
            "number",
            b"name = \"a\"\nseed = 1.2.3\n".to_vec(),
            &["line 2", "not TOML"],
        ),
        (
            "bytes",
            b"name = \"a\"\nabout = \"\xff\xfe\"\n".to_vec(),
            &["line 2", "plain text"],
        ),
        ("nul", b"name = \"a\0\"\n".to_vec(), &["line 1", "not TOML"]),
        (
            "broken-name",
            b"\"na\\nme\" = 1\n".to_vec(),
            &["line 1", "na\\nme", "no known name"],
        ),
        (
            "escape",
            b"name = \"a\\u001b[2J\"\n".to_vec(),
            &["line 1", "name"],
        ),
    ];
    for (line, own) in SCENARIOS {
        for (name, text, words) in &cases {
            // What is of no kind yet is made one of the kind that the command reads.
            let mut text = text.clone();
            if *name == "broken-name" || *name == "escape" {
                text.extend(own.as_bytes());
            }
            let file = folder.file(&format!("{name}.toml"), &text);
            assert_one_line(&run(line, &file), 3, &file.display().to_string(), words);
        }
    }
}

#[test]
fn files_that_cannot_be_read() {
    let folder = Folder::default();
    let large = folder.path().join("large.toml");
    let made = File::create(&large).and_then(|f| f.set_len(3 << 30));
    made.expect("a file with a hole");
    let missing = folder.path().join("nowhere.toml");
    let inside = large.join("below.toml");
    for (line, _) in SCENARIOS {
        for (file, word, remedy) in [
            (
                missing.as_path(),
                "no such file",
                "name a TOML file, or one of",
            ),
            (folder.path(), "is a directory", "name one file inside it"),
            (&large, "goes on", "the right file"),
            (&inside, "needs a directory", "name a TOML file"),
        ] {
            let name = file.display().to_string();
            assert_one_line(&run(line, file), 3, &name, &[word, remedy]);
        }
    }
}

#[test]
fn a_device_without_an_end_is_not_read_to_its_end() {
    let zero = Path::new("/dev/zero");
    if !zero.exists() {
        return;
    }
    for line in [
        "simulate FILE --json",
        "els model FILE",
        "ldbb compare FILE FILE",
    ] {
        let ended = run(line, zero);
        assert_one_line(&ended, 3, "/dev/zero", &["goes on", "the right file"]);
    }
}

#[test]
fn measurements_that_are_none() {
    let folder = Folder::default();
    let fit = "els fit els-load-bar --unknown joint.0 --loads FILE";
    let compare = "ldbb compare FILE FILE";
    let few = b"freq_hz,re_m_per_N,im_m_per_N\n1,1,1\n2,1,1\n";
    let cases: [(&str, &str, &[u8], &[&str]); 18] = [
        (
            "ldbb analyse FILE",
            "a.csv",
            b"",
            &["data", "no line with numbers"],
        ),
        (
            "ldbb analyse FILE",
            "b.csv",
            b"a,b\n1,2\n",
            &["line 1", "no column"],
        ),
        (
            "ldbb analyse FILE",
            "c.csv",
            b"angle_deg,dr_um,dir,run,p_bar,F_N\n0,0,ccw,1.5,1,1\n",
            &["line 2, column 4", "1.5", "whole numbers"],
        ),
        (
            "ldbb analyse FILE",
            "d.csv",
            b"angle_deg,dr_um,dir,run,p_bar,F_N\n0,0,ccw,-1,1,1\n",
            &["line 2, column 4", "-1", "whole numbers"],
        ),
        (
            "ldbb analyse FILE",
            "e.csv",
            b"# plane = UV\n",
            &["line 1", "XY, YZ or ZX"],
        ),
        // Finite, and infinite in SI units.
        (
            "ldbb analyse FILE",
            "o.csv",
            b"angle_deg,dr_um,dir,run,p_Pa,F_kN\n0,0,ccw,1,1,1e307\n",
            &["line 2, column 6", "1e307", "at most"],
        ),
        // Would be infinite in the units of the tables that are written.
        (
            "ldbb analyse FILE",
            "p.csv",
            b"angle_deg,dr_m,dir,run,p_bar,F_N\n0,1e305,ccw,1,1,1\n",
            &["line 2, column 2", "1e305", "at most"],
        ),
        (
            "ldbb analyse FILE",
            "q.csv",
            b"# radius_mm = 1e308\n",
            &["line 1", "radius_mm is 1e308"],
        ),
        // Its square is infinite.
        (
            fit,
            "r.csv",
            b"angle_deg,load_n,deflection_um\n0,1e200,1\n",
            &["line 2, column 2", "1e200", "at most"],
        ),
        (fit, "f.csv", b"x\n", &["line 1", "angle_deg"]),
        (
            fit,
            "g.csv",
            b"angle_deg,load_n,deflection_um\n0,1,\n",
            &["line 2", "column 3"],
        ),
        (
            fit,
            "h.csv",
            b"angle_deg,load_n,deflection_um\n0,1,1\n",
            &["whole file"],
        ),
        ("els limit FILE", "i.csv", few, &[]),
        (
            "els limit FILE",
            "j.uff",
            b"    -1\n    58\n",
            &["line", "ends inside"],
        ),
        ("els limit FILE", "k.xlsx", b"PK", &["name", ".csv or .uff"]),
        (compare, "l.json", b"{\"a\":\n[1,", &["line 2", "not JSON"]),
        (compare, "m.json", b"{}", &["whole file"]),
        (compare, "n.json", b"\xff", &["line 1", "plain text"]),
    ];
    for (line, name, bytes, words) in cases {
        let file = folder.file(name, bytes);
        assert_one_line(&run(line, &file), 3, &file.display().to_string(), words);
    }
}

#[test]
fn a_band_with_too_few_lines() {
    let folder = Folder::default();
    let samples: Vec<f32> = (0..4000).map(|k| (0.3 * k as f32).sin()).collect();
    let file = folder.float("blow.wav", 8000, &samples);
    let ended = run("els hammer FILE FILE --band 500:510", &file);
    let words = ["whole file", "lines between 500 and 510 Hz", "wider --band"];
    assert_one_line(&ended, 3, &file.display().to_string(), &words);
}

#[test]
fn records_of_the_exciter_that_are_none() {
    let folder = Folder::default();
    let path = folder.path();
    let refused = |file: &str, words: &[&str]| {
        let name = path.join(file).display().to_string();
        assert_one_line(&run("cers analyse FILE", path), 3, &name, words);
    };
    refused("record.toml", &["open", "no such file"]);
    let _ = folder.file("record.toml", b"name = [\n");
    refused("record.toml", &["line 1, column 9", "not TOML"]);
    let ended = program().run(
        ["cers", "run", "cers-rest", "--quick", "--out"]
            .map(str::to_owned)
            .into_iter()
            .chain([path.display().to_string()]),
    );
    assert_eq!(ended.code, Some(0), "{ended:?}");
    let _ = folder.file("signals.wav", b"RIFF");
    refused("signals.wav", &["header", "copy it again"]);
    let _ = folder.file("signals.wav", &wav(PCM, 11, 10_000, 16, &[0; 44]));
    refused("signals.wav", &["header", "integer samples", "floats"]);
    let _ = folder.file("signals.wav", &wav(FLOAT, 1, 10_000, 32, &[0; 44]));
    refused("signals.wav", &["header", "1 channels, a record has 11"]);
    std::fs::remove_file(path.join("signals.wav")).expect("it was there");
    refused("signals.wav", &["open", "no such file"]);
}

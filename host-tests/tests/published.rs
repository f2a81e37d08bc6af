//! Promise: the batch estimators give the coefficients that books and other
//! programs publish for the same series, each within the digits they state. Print the table
//! with `cargo test --release -p host-tests --test published -- --nocapture`.
//!
//! Published conventions: y = Σ ar·y(t−i) + e + Σ ma·e(t−j), so ar = −a and ma = c.

use host_tests::resources;
use rarma_fit::{
    Before, FitError, Ml, MlConfig, Pem, PemConfig, burg, innovations_algorithm, likelihood, mean,
    yule_walker,
};
use serde_json::Value;
use std::path::Path;

/// Parameters, or states of the likelihood, at most.
const N: usize = 20;
/// Where a file states none (figures of search programs, given to twelve digits but
/// searched to fewer): no tolerance is stated with them, and four decimals are asked for here.
const OF_A_SEARCH: f64 = 1e-4;
/// Cases that are models; one more is an autocovariance.
const MODELS: usize = 31;

/// A model with the signs of the publications.
struct Model {
    name: &'static str,
    coefficients: Vec<f64>,
    sigma2: f64,
    log_likelihood: Option<f64>,
}

impl Model {
    fn of(name: &'static str, a: &[f64], c: &[f64], sigma2: f64) -> Self {
        Self {
            name,
            coefficients: a.iter().map(|x| -x).chain(c.iter().copied()).collect(),
            sigma2,
            log_likelihood: None,
        }
    }

    /// Largest distance of a coefficient.
    fn distance(&self, theirs: &[f64]) -> f64 {
        assert_eq!(self.coefficients.len(), theirs.len(), "{}", self.name);
        let pairs = self.coefficients.iter().zip(theirs);
        pairs.map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
    }
}

fn numbers(value: &Value) -> Vec<f64> {
    let list = value.as_array().map(Vec::as_slice).unwrap_or_default();
    list.iter().filter_map(Value::as_f64).collect()
}

fn integer(value: &Value) -> usize {
    usize::try_from(value.as_u64().unwrap_or(0)).expect("small")
}

/// The series as the case wants it: differenced, trend or mean removed.
fn prepared(file: &str, all: &Value, case: &Value) -> Vec<f64> {
    let mut y = numbers(&all["data"]);
    let differences = if file.ends_with("dowj") {
        1
    } else {
        integer(&case["d"])
    };
    for _ in 0..differences {
        y = y.windows(2).map(|w| w[1] - w[0]).collect();
    }
    let trend = numbers(&case["trend"]);
    if let [start, slope] = trend[..] {
        for (t, x) in (1..).zip(&mut y) {
            *x -= start + slope * f64::from(t);
        }
        return y;
    }
    // Simulated about 0; or stated without a constant.
    let about_zero = all["true"]["mean"] == 0.0 || case["const"] == 0;
    if !about_zero {
        let m = mean(&y);
        y.iter_mut().for_each(|x| *x -= m);
    }
    y
}

/// A published model of a series.
struct Published<'a> {
    method: &'a str,
    order: (usize, usize),
    /// The series as it was fitted.
    y: Vec<f64>,
    /// Coefficients of A, then of C.
    theirs: Vec<f64>,
}

impl<'a> Published<'a> {
    fn of(file: &str, all: &Value, case: &'a Value) -> Self {
        let mut theirs = numbers(&case["ar"]);
        theirs.extend(numbers(&case["ma"]));
        Self {
            method: case["method"].as_str().expect("method"),
            order: (integer(&case["p"]), integer(&case["q"])),
            y: prepared(file, all, case),
            theirs,
        }
    }
}

fn ml(y: &[f64], p: usize, q: usize) -> Result<Model, FitError> {
    let fit = Ml::new(MlConfig::default())?.fit::<N, N>(y, p, q)?;
    Ok(Model {
        log_likelihood: Some(fit.log_likelihood()),
        ..Model::of("Ml", fit.a(), fit.c(), fit.sigma2())
    })
}

/// As the statistics packages take the errors before the first.
fn conditional() -> PemConfig<f64> {
    PemConfig {
        before: Before::Zero,
        ..PemConfig::default()
    }
}

fn pem(y: &[f64], p: usize, q: usize) -> Result<Model, FitError> {
    let fit = Pem::new(conditional())?.fit::<N>(y, p, q)?;
    Ok(Model {
        log_likelihood: Some(fit.log_likelihood()),
        ..Model::of("Pem", fit.a(), fit.c(), fit.sigma2())
    })
}

/// The estimators of the same kind; none if the case is no model.
fn fits(method: &str, y: &[f64], p: usize, q: usize) -> Result<Vec<Model>, FitError> {
    Ok(match method.split([' ', ':', ',']).next().unwrap_or("") {
        "Yule-Walker" | "Durbin-Levinson" => {
            let fit = yule_walker::<f64, N>(y, p)?;
            vec![Model::of("yule_walker", fit.a(), &[], fit.sigma2())]
        }
        "Burg" => {
            let fit = burg::<f64, N>(y, p)?;
            vec![Model::of("burg", fit.a(), &[], fit.sigma2())]
        }
        "innovations" => {
            let fit = innovations_algorithm::<f64, N>(y, q, q)?;
            vec![Model::of(
                "innovations_algorithm",
                &[],
                fit.c(),
                fit.sigma2(),
            )]
        }
        "Hannan-Rissanen" => {
            let fit = Pem::new(conditional())?.hannan_rissanen::<N>(y, p, q, 22)?;
            vec![Model::of("hannan_rissanen", fit.a(), fit.c(), fit.sigma2())]
        }
        "CSS" => vec![pem(y, p, q)?],
        // About the stated trend: at the joint maximum the model is the best for it.
        "exact" | "GLS" => vec![ml(y, p, q)?],
        "Box-Jenkins" => vec![ml(y, p, q)?, pem(y, p, q)?],
        _ => Vec::new(),
    })
}

/// All files of the folder: name and content, sorted.
fn files(folder: &Path) -> Vec<(String, Value)> {
    let list = std::fs::read_dir(folder).expect("folder of the series");
    let mut all: Vec<(String, Value)> = list
        .map(|entry| entry.expect("entry").path())
        .filter(|path| path.extension().is_some_and(|x| x == "json"))
        .map(|path| {
            let text = std::fs::read(&path).expect("series");
            let name = path.file_stem().unwrap_or_default().to_string_lossy();
            let content = serde_json::from_slice(&text);
            (name.into_owned(), content.expect("JSON"))
        })
        .collect();
    all.sort_by(|x, y| x.0.cmp(&y.0));
    all
}

#[test]
fn coefficients_are_those_published() {
    let Some(folder) = resources::series_or_skip("coefficients_are_those_published") else {
        return;
    };
    println!("| series | order | published method | estimator | worst difference | tolerance |");
    println!("|---|---|---|---|---|---|");
    let mut models = 0;
    for (file, all) in files(&folder) {
        for case in all["cases"].as_array().expect("cases") {
            let Published {
                method,
                order: (p, q),
                y,
                theirs,
            } = Published::of(&file, &all, case);
            let stated = case["tol"].as_f64().or(all["tolerance_abs"].as_f64());
            let tolerance = stated.unwrap_or(OF_A_SEARCH);
            let found = fits(method, &y, p, q).unwrap_or_else(|why| panic!("{file}: {why}"));
            models += usize::from(!found.is_empty());
            if found.is_empty() {
                assert_eq!(method, "autocovariance", "{file}");
            }
            for model in found {
                let name = model.name;
                let worst = model.distance(&theirs);
                println!(
                    "| {file} | ({p},{q}) | {method} | {name} | {worst:.1e} | {tolerance:.0e} |"
                );
                // Published figures are rounded: a difference of 0 would mean that
                // nothing was compared.
                assert!(
                    worst > 0.0 && worst <= tolerance,
                    "{file} ({p},{q}) {name}: {:?} for {theirs:?}",
                    model.coefficients
                );
                levels(&file, case, &y, tolerance, &model);
            }
        }
    }
    assert_eq!(models, MODELS);
}

/// Innovation variance and likelihood, where they are published.
fn levels(file: &str, case: &Value, y: &[f64], tolerance: f64, model: &Model) {
    let p = integer(&case["p"]);
    let name = model.name;
    if let Some(theirs) = case["sigma2"].as_f64() {
        // R divides by the samples less the parameters and the mean.
        let n = y.len() as f64;
        let r = file.starts_with("R_");
        let ours = model.sigma2 * if r { n / (n - p as f64 - 1.0) } else { 1.0 };
        let off = (ours - theirs).abs();
        // R prints four digits.
        let tolerance = if r { 0.05 } else { tolerance };
        println!("| | | | {name}: σ² | {off:.1e} | {tolerance:.0e} |");
        assert!(
            off > 0.0 && off <= tolerance,
            "{file} {name}: {ours} for {theirs}"
        );
    }
    if let Some(theirs) = case["sigma2_innovations"].as_f64() {
        let a: Vec<f64> = model.coefficients[..p].iter().map(|x| -x).collect();
        let ours = likelihood::<f64, N>(y, &a, &model.coefficients[p..]);
        let ours = ours.expect("stable").sigma2;
        let off = (ours / theirs - 1.0).abs();
        println!("| | | | likelihood: σ² relative | {off:.1e} | 1e-9 |");
        assert!(
            off > 0.0 && off < 1e-9,
            "{file} {name}: {ours} for {theirs}"
        );
    }
    if let (Some(theirs), Some(ours)) = (case["loglik"].as_f64(), model.log_likelihood) {
        let off = ours - theirs;
        println!("| | | | {name}: ln L, ours less theirs | {off:.1e} | ±2e-5 |");
        assert!(
            off != 0.0 && off.abs() < 2e-5,
            "{file}: {ours} for {theirs}"
        );
    }
}

/// The comparison can fail: the wrong method misses the tolerance of the right one.
#[test]
fn methods_are_told_apart() {
    let Some(folder) = resources::series_or_skip("methods_are_told_apart") else {
        return;
    };
    let mut compared = 0;
    for (file, all) in files(&folder) {
        for case in all["cases"].as_array().expect("cases") {
            let Published {
                method,
                order: (p, q),
                y,
                theirs,
            } = Published::of(&file, &all, case);
            let other = match method.split(' ').next().unwrap_or("") {
                "Burg" => fits("Yule-Walker", &y, p, 0),
                "Yule-Walker" | "Durbin-Levinson" => fits("Burg", &y, p, 0),
                "CSS" => fits("exact", &y, p, q),
                "exact" => fits("CSS", &y, p, q),
                _ => continue,
            };
            let off = other.expect("a model")[0].distance(&theirs);
            println!("{file} ({p},{q}) {method}: the other method is {off:.1e} away");
            assert!(off > 3e-4, "{file} {method}: {off}");
            compared += 1;
        }
    }
    assert!(compared > 15, "{compared}");
}

//! Scales that a card's driver leaves beside whole numbers: y = slope·x + intercept, or a polynomial.

use super::object::{Object, Property};

/// Input that is the value in the file.
const RAW: f64 = 4_294_967_295.0;
/// Scales of a channel, and coefficients of a polynomial, at most.
const MOST: usize = 64;

/// The scales of one channel, each of the raw value or of one before it; the last gives the sample.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Scales(Vec<Scale>);

/// Coefficients in ascending powers, and which scale they are of; none: the raw value.
#[derive(Debug, Clone, PartialEq)]
struct Scale {
    coefficients: Vec<f64>,
    input: Option<usize>,
}

impl Scales {
    /// Of a channel, or else of its group or of the file, where they say that it is not scaled yet.
    ///
    /// # Errors
    /// What kind of scale is not known here.
    pub(super) fn of(objects: [Option<&Object>; 3]) -> Result<Self, String> {
        let with = objects.into_iter().flatten().find(|object| {
            object
                .number("NI_Number_Of_Scales")
                .is_some_and(|n| n > 0.0)
        });
        let Some(object) = with.filter(|o| o.text("NI_Scaling_Status") != Some("scaled")) else {
            return Ok(Self::default());
        };
        let count = object.number("NI_Number_Of_Scales").unwrap_or(0.0);
        if count > MOST as f64 {
            return Err(format!("{count} scales"));
        }
        let one = |k: usize| Scale::of(object, k);
        (0..count as usize)
            .map(one)
            .collect::<Result<_, _>>()
            .map(Self)
    }

    /// A value as it is measured.
    pub(super) fn apply(&self, raw: f64) -> f64 {
        let mut done: Vec<f64> = Vec::with_capacity(self.0.len());
        for scale in &self.0 {
            let x = scale.input.and_then(|k| done.get(k)).copied();
            let x = x.unwrap_or(raw);
            let horner = |sum: f64, c: &f64| sum * x + c;
            done.push(scale.coefficients.iter().rev().fold(0.0, horner));
        }
        done.last().copied().unwrap_or(raw)
    }
}

impl Scale {
    fn of(object: &Object, k: usize) -> Result<Self, String> {
        let key = |rest: &str| format!("NI_Scale[{k}]_{rest}");
        let number = |rest: &str| object.number(&key(rest)).filter(|x| x.is_finite());
        let missing = |rest: &str| format!("a scale without its {rest}");
        let coefficients = match object.property(&key("Scale_Type")) {
            Some(Property::Text(kind)) if kind == "Linear" => {
                let slope = number("Linear_Slope").ok_or_else(|| missing("slope"))?;
                let intercept = number("Linear_Y_Intercept").ok_or_else(|| missing("intercept"))?;
                vec![intercept, slope]
            }
            Some(Property::Text(kind)) if kind == "Polynomial" => {
                let size = number("Polynomial_Coefficients_Size").unwrap_or(4.0);
                let each = (0..(size.max(0.0) as usize).min(MOST))
                    .map(|i| number(&format!("Polynomial_Coefficients[{i}]")));
                each.collect::<Option<_>>()
                    .ok_or_else(|| missing("coefficients"))?
            }
            Some(Property::Text(kind)) => return Err(format!("a scale of the kind '{kind}'")),
            _ => return Err("a scale of the card itself".to_owned()),
        };
        let source = ["Linear_Input_Source", "Polynomial_Input_Source"];
        let source = source.iter().find_map(|name| object.number(&key(name)));
        let input = source.filter(|source| *source != RAW);
        match input {
            Some(source) if !(source >= 0.0 && source < k as f64) => {
                Err("a scale of one that comes after it".to_owned())
            }
            _ => Ok(Self {
                coefficients,
                input: input.map(|source| source as usize),
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn object(properties: &[(&str, Property)]) -> Object {
        let mut object = Object::of("/'g'/'c'");
        for (name, value) in properties {
            object.set(name, value.clone());
        }
        object
    }

    fn text(text: &str) -> Property {
        Property::Text(text.to_owned())
    }

    #[test]
    fn a_polynomial_of_a_line() {
        let number = Property::Number;
        let mut all = vec![
            ("NI_Number_Of_Scales", number(2.0)),
            ("NI_Scale[0]_Scale_Type", text("Linear")),
            ("NI_Scale[0]_Linear_Slope", number(0.5)),
            ("NI_Scale[0]_Linear_Y_Intercept", number(1.0)),
            ("NI_Scale[0]_Linear_Input_Source", number(RAW)),
            ("NI_Scale[1]_Scale_Type", text("Polynomial")),
            ("NI_Scale[1]_Polynomial_Coefficients_Size", number(3.0)),
            ("NI_Scale[1]_Polynomial_Coefficients[0]", number(7.0)),
            ("NI_Scale[1]_Polynomial_Coefficients[1]", number(0.0)),
            ("NI_Scale[1]_Polynomial_Coefficients[2]", number(2.0)),
            ("NI_Scale[1]_Polynomial_Input_Source", number(0.0)),
        ];
        let scales = Scales::of([None, Some(&object(&all)), None]).expect("known");
        // 4 → 3 → 2·9 + 7
        assert_eq!(scales.apply(4.0), 25.0);
        all.push(("NI_Scaling_Status", text("scaled")));
        let scales = Scales::of([Some(&object(&all)), None, None]).expect("known");
        assert_eq!(scales.apply(4.0), 4.0);
        all.pop();
        all[4].1 = number(1.0);
        assert!(
            Scales::of([Some(&object(&all)), None, None]).is_err(),
            "a circle"
        );
        all[1].1 = text("Thermocouple");
        let why = Scales::of([Some(&object(&all)), None, None]).expect_err("not known");
        assert_eq!(why, "a scale of the kind 'Thermocouple'");
    }
}

//! Reads a scenario field by field, and describes it from the same calls.
//!
//! Each field is asked for once, with its range, default and meaning. Reading, the
//! refusal of what is wrong, and the JSON schema all come from that one place: a
//! section without a file behind it answers every question with its default and
//! only keeps the description.

pub(super) use super::value::{Allowed, Refusal, Text};
use super::value::{integer, is_tiny, number, shown};
use serde_json::{Map, Value, json};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Entries of a list at most.
const MOST_ENTRIES: usize = 1000;

/// One table of the file.
#[derive(Debug)]
pub(super) struct Section<'a> {
    text: Text<'a>,
    path: String,
    line: usize,
    table: Option<&'a DeTable<'a>>,
    properties: Map<String, Value>,
    required: Vec<&'static str>,
}

impl<'a> Section<'a> {
    /// The whole file.
    pub(super) fn root(text: Text<'a>, table: &'a DeTable<'a>) -> Self {
        Self::new(text, String::new(), 1, Some(table))
    }

    /// No file: for the schema.
    pub(super) fn description() -> Self {
        Self::new(Text(""), String::new(), 1, None)
    }

    fn new(text: Text<'a>, path: String, line: usize, table: Option<&'a DeTable<'a>>) -> Self {
        Self {
            text,
            path,
            line,
            table,
            properties: Map::new(),
            required: Vec::new(),
        }
    }

    /// Whether only the description is wanted: values mean nothing then.
    pub(super) fn describes(&self) -> bool {
        self.table.is_none()
    }

    fn name_of(&self, field: &str) -> String {
        if self.path.is_empty() {
            field.to_owned()
        } else {
            format!("{}.{field}", self.path)
        }
    }

    fn found(&self, field: &str) -> Option<&'a Spanned<DeValue<'a>>> {
        let table = self.table?;
        table
            .iter()
            .find(|(key, _)| key.get_ref() == field)
            .map(|(_, value)| value)
    }

    /// Whether the file has this field; it must be asked for as well.
    pub(super) fn has(&self, field: &str) -> bool {
        self.found(field).is_some()
    }

    /// A refusal of this field.
    pub(super) fn refuse(&self, field: &str, what: impl Into<String>) -> Refusal {
        let line = self
            .found(field)
            .map_or(self.line, |v| self.text.line(&v.span()));
        Refusal {
            line,
            field: self.name_of(field),
            what: what.into(),
        }
    }

    fn wrong(&self, field: &str, value: &DeValue<'_>, allowed: &str) -> Refusal {
        let shown = shown(value);
        let near = match number(value) {
            Some(x) if is_tiny(x) => "; so near to 0 write 0",
            _ => "",
        };
        self.refuse(field, format!("is {shown} (allowed: {allowed}{near})"))
    }

    fn missing(&self, field: &str, allowed: &str) -> Refusal {
        self.refuse(field, format!("is missing (allowed: {allowed})"))
    }

    fn describe(&mut self, field: &'static str, required: bool, mut schema: Value, doc: &str) {
        if let Some(object) = schema.as_object_mut() {
            object.insert("description".to_owned(), json!(doc));
        }
        self.properties.insert(field.to_owned(), schema);
        if required {
            self.required.push(field);
        }
    }

    /// A number in the unit its name says.
    pub(super) fn number(
        &mut self,
        field: &'static str,
        allowed: Allowed,
        default: Option<f64>,
        doc: &str,
    ) -> Result<f64, Refusal> {
        let mut schema =
            json!({ "type": "number", "minimum": allowed.low, "maximum": allowed.high });
        if let Some(x) = default {
            schema["default"] = json!(x);
        }
        self.describe(field, default.is_none(), schema, doc);
        match (self.found(field), default) {
            (Some(value), _) => number(value.get_ref())
                .filter(|x| allowed.holds(*x))
                .ok_or_else(|| self.wrong(field, value.get_ref(), &allowed.words())),
            (None, Some(x)) => Ok(x),
            (None, None) if self.describes() => Ok(allowed.low.max(1.0)),
            (None, None) => Err(self.missing(field, &allowed.words())),
        }
    }

    /// A list of numbers; empty if it is not there.
    pub(super) fn numbers(
        &mut self,
        field: &'static str,
        allowed: Allowed,
        doc: &str,
    ) -> Result<Vec<f64>, Refusal> {
        let item = json!({ "type": "number", "minimum": allowed.low, "maximum": allowed.high });
        let schema =
            json!({ "type": "array", "items": item, "maxItems": MOST_ENTRIES, "default": [] });
        self.describe(field, false, schema, doc);
        let Some(value) = self.found(field) else {
            return Ok(Vec::new());
        };
        let words = format!("a list of numbers, each {}", &allowed.words()[9..]);
        let refused = || self.wrong(field, value.get_ref(), &words);
        let items = value.get_ref().as_array().ok_or_else(refused)?;
        self.few(field, items.len())?;
        items
            .iter()
            .map(|item| {
                number(item.get_ref())
                    .filter(|x| allowed.holds(*x))
                    .ok_or_else(|| {
                        let shown = shown(item.get_ref());
                        self.refuse(field, format!("holds {shown} (allowed: {words})"))
                    })
            })
            .collect()
    }

    /// That a list is no longer than any use.
    fn few(&self, field: &str, entries: usize) -> Result<(), Refusal> {
        if entries > MOST_ENTRIES {
            return Err(self.refuse(
                field,
                format!("has {entries} entries (allowed: up to {MOST_ENTRIES})"),
            ));
        }
        Ok(())
    }

    /// A whole number.
    pub(super) fn whole(
        &mut self,
        field: &'static str,
        (low, high): (i64, i64),
        default: Option<i64>,
        doc: &str,
    ) -> Result<i64, Refusal> {
        let mut schema = json!({ "type": "integer", "minimum": low, "maximum": high });
        if let Some(x) = default {
            schema["default"] = json!(x);
        }
        self.describe(field, default.is_none(), schema, doc);
        let words = format!("a whole number from {low} to {high}");
        match (self.found(field), default) {
            (Some(value), _) => integer(value.get_ref())
                .filter(|x| (low..=high).contains(x))
                .ok_or_else(|| self.wrong(field, value.get_ref(), &words)),
            (None, Some(x)) => Ok(x),
            (None, None) if self.describes() => Ok(low),
            (None, None) => Err(self.missing(field, &words)),
        }
    }

    /// True or false.
    pub(super) fn flag(
        &mut self,
        field: &'static str,
        default: bool,
        doc: &str,
    ) -> Result<bool, Refusal> {
        let schema = json!({ "type": "boolean", "default": default });
        self.describe(field, false, schema, doc);
        match self.found(field) {
            Some(value) => value
                .get_ref()
                .as_bool()
                .ok_or_else(|| self.wrong(field, value.get_ref(), "true or false")),
            None => Ok(default),
        }
    }

    /// One of several words; its place among them. The first is the default, if
    /// there is one.
    pub(super) fn choice(
        &mut self,
        field: &'static str,
        words: &[&str],
        required: bool,
        doc: &str,
    ) -> Result<usize, Refusal> {
        let mut schema = json!({ "type": "string", "enum": words });
        if !required {
            schema["default"] = json!(words[0]);
        }
        self.describe(field, required, schema, doc);
        let allowed = words
            .iter()
            .map(|w| format!("\"{w}\""))
            .collect::<Vec<_>>()
            .join(", ");
        match self.found(field) {
            Some(value) => value
                .get_ref()
                .as_str()
                .and_then(|s| words.iter().position(|w| *w == s))
                .ok_or_else(|| self.wrong(field, value.get_ref(), &allowed)),
            None if required && !self.describes() => Err(self.missing(field, &allowed)),
            None => Ok(0),
        }
    }

    /// A line of text.
    pub(super) fn words(&mut self, field: &'static str, doc: &str) -> Result<String, Refusal> {
        self.describe(
            field,
            true,
            json!({ "type": "string", "minLength": 1 }),
            doc,
        );
        let allowed = "a line of text";
        match self.found(field) {
            Some(value) => value
                .get_ref()
                .as_str()
                .filter(|s| !s.trim().is_empty() && !s.contains(char::is_control))
                .map(str::to_owned)
                .ok_or_else(|| self.wrong(field, value.get_ref(), allowed)),
            None if self.describes() => Ok(String::new()),
            None => Err(self.missing(field, allowed)),
        }
    }

    /// A table, `None` if it is not there.
    pub(super) fn table<V>(
        &mut self,
        field: &'static str,
        doc: &str,
        read: impl FnOnce(&mut Section<'a>) -> Result<V, Refusal>,
    ) -> Result<Option<V>, Refusal> {
        let path = self.name_of(field);
        let Some(table) = self.table else {
            let mut inner = Section::new(self.text, path, 1, None);
            let value = read(&mut inner)?;
            self.describe(field, false, inner.schema(), doc);
            return Ok(Some(value));
        };
        let Some((key, value)) = table.iter().find(|(key, _)| key.get_ref() == field) else {
            return Ok(None);
        };
        let inner = value
            .get_ref()
            .as_table()
            .ok_or_else(|| self.wrong(field, value.get_ref(), "a table"))?;
        let line = self.text.line(&key.span());
        let mut section = Section::new(self.text, path, line, Some(inner));
        Ok(Some(read(&mut section)?))
    }

    /// A list of tables; empty if it is not there.
    pub(super) fn tables<V>(
        &mut self,
        field: &'static str,
        doc: &str,
        mut read: impl FnMut(&mut Section<'a>) -> Result<V, Refusal>,
    ) -> Result<Vec<V>, Refusal> {
        let path = self.name_of(field);
        if self.describes() {
            let mut inner = Section::new(self.text, path, 1, None);
            let value = read(&mut inner)?;
            let schema =
                json!({ "type": "array", "items": inner.schema(), "maxItems": MOST_ENTRIES });
            self.describe(field, false, schema, doc);
            return Ok(vec![value]);
        }
        let Some(value) = self.found(field) else {
            return Ok(Vec::new());
        };
        let refused = || self.wrong(field, value.get_ref(), "a list of tables");
        let items = value.get_ref().as_array().ok_or_else(refused)?;
        self.few(field, items.len())?;
        let mut out = Vec::with_capacity(items.len());
        for (k, item) in items.iter().enumerate() {
            let inner = item.get_ref().as_table().ok_or_else(refused)?;
            let line = self.text.line(&item.span());
            let path = format!("{path}[{k}]");
            let mut section = Section::new(self.text, path, line, Some(inner));
            out.push(read(&mut section)?);
        }
        Ok(out)
    }

    /// JSON schema of what has been asked for.
    pub(super) fn schema(&self) -> Value {
        json!({
            "type": "object",
            "properties": self.properties,
            "required": self.required,
            "additionalProperties": false,
        })
    }
}

/// The first name in the file that its schema does not know.
pub(super) fn unknown(text: Text<'_>, table: &DeTable<'_>, schema: &Value) -> Option<Refusal> {
    let mut all = Vec::new();
    strangers(text, table, schema, "", &mut all);
    all.into_iter().min_by_key(|(at, _)| *at).map(|(_, r)| r)
}

fn strangers(
    text: Text<'_>,
    table: &DeTable<'_>,
    schema: &Value,
    path: &str,
    out: &mut Vec<(usize, Refusal)>,
) {
    // A table where none may be is refused for its type, not for the names in it.
    if !schema["properties"].is_object() {
        return;
    }
    for (key, value) in table {
        let name: &str = key.get_ref();
        let field = if path.is_empty() {
            name.to_owned()
        } else {
            format!("{path}.{name}")
        };
        let known = &schema["properties"][name];
        if known.is_null() {
            let names: Vec<&str> = schema["properties"]
                .as_object()
                .map(|o| o.keys().map(String::as_str).collect())
                .unwrap_or_default();
            let refusal = Refusal {
                line: text.line(&key.span()),
                field,
                what: format!("is no known name (allowed: {})", names.join(", ")),
            };
            out.push((key.span().start, refusal));
            continue;
        }
        match value.get_ref() {
            DeValue::Table(inner) => strangers(text, inner, known, &field, out),
            DeValue::Array(items) => {
                for (k, item) in items.iter().enumerate() {
                    if let Some(inner) = item.get_ref().as_table() {
                        let field = format!("{field}[{k}]");
                        strangers(text, inner, &known["items"], &field, out);
                    }
                }
            }
            _ => {}
        }
    }
}

//! Reads licence expressions such as `(MIT OR Apache-2.0) AND Unicode-3.0`.

/// Whether the allowed licences satisfy an expression.
///
/// `OR` needs one side, `AND` both; `A WITH B` is allowed where `A` is, because an exception
/// only permits more. A `/`, as older packages write it, is an `OR`.
///
/// # Errors
/// When the expression is malformed.
pub fn satisfied(expression: &str, allowed: &[String]) -> Result<bool, String> {
    let spaced = expression
        .replace('/', " OR ")
        .replace('(', " ( ")
        .replace(')', " ) ");
    let words: Vec<&str> = spaced.split_whitespace().collect();
    let mut reader = Reader {
        words: &words,
        allowed,
    };
    let answer = reader.any_of().filter(|_| reader.words.is_empty());
    answer.ok_or_else(|| format!("`{expression}` is no licence expression"))
}

/// What is left to read. Each method returns whether its part is satisfied.
struct Reader<'a> {
    words: &'a [&'a str],
    allowed: &'a [String],
}

impl<'a> Reader<'a> {
    fn any_of(&mut self) -> Option<bool> {
        let mut satisfied = self.all_of()?;
        while self.take("OR") {
            // Read in any case: `||` alone would leave the right side unread.
            satisfied = self.all_of()? || satisfied;
        }
        Some(satisfied)
    }

    fn all_of(&mut self) -> Option<bool> {
        let mut satisfied = self.one()?;
        while self.take("AND") {
            satisfied = self.one()? && satisfied;
        }
        Some(satisfied)
    }

    fn one(&mut self) -> Option<bool> {
        if self.take("(") {
            let satisfied = self.any_of()?;
            return self.take(")").then_some(satisfied);
        }
        let name = self
            .next()
            .filter(|word| !matches!(*word, ")" | "OR" | "AND" | "WITH"))?;
        let satisfied = self.allowed.iter().any(|allowed| allowed == name);
        if self.take("WITH") {
            self.next()?;
        }
        Some(satisfied)
    }

    fn take(&mut self, word: &str) -> bool {
        let found = self.words.first() == Some(&word);
        if found {
            self.words = &self.words[1..];
        }
        found
    }

    fn next(&mut self) -> Option<&'a str> {
        let (first, rest) = self.words.split_first()?;
        self.words = rest;
        Some(first)
    }
}

#[cfg(test)]
mod tests {
    use super::satisfied;

    fn ok(expression: &str) -> Result<bool, String> {
        satisfied(expression, &["MIT".to_owned(), "Unicode-3.0".to_owned()])
    }

    #[test]
    fn or_needs_one_and_needs_both() {
        assert_eq!(ok("MIT"), Ok(true));
        assert_eq!(ok("GPL-3.0 OR MIT"), Ok(true));
        assert_eq!(ok("MIT/Apache-2.0"), Ok(true));
        assert_eq!(ok("GPL-3.0 AND MIT"), Ok(false));
        assert_eq!(ok("(MIT OR Apache-2.0) AND Unicode-3.0"), Ok(true));
        assert_eq!(ok("MIT OR (Apache-2.0 AND GPL-3.0)"), Ok(true));
        assert_eq!(ok("Apache-2.0 WITH LLVM-exception OR MIT"), Ok(true));
        assert_eq!(ok("Apache-2.0 WITH LLVM-exception"), Ok(false));
    }

    #[test]
    fn nonsense_is_refused() {
        for expression in ["", "MIT OR", "(MIT", "MIT Apache-2.0", "AND MIT", "MIT)"] {
            assert!(ok(expression).is_err(), "{expression}");
        }
    }
}

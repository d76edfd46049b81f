//! Comma separated values as RFC 4180 has them: fields in quotes may hold commas, quotes are doubled.

use anyhow::{Context, bail};
use std::collections::HashMap;

/// Rows of a table by column name.
///
/// # Errors
/// The line with a quote left open or another number of fields than the head has.
pub(super) fn rows(text: &str) -> anyhow::Result<Vec<HashMap<String, String>>> {
    let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    let (_, head) = lines.next().context("the table is empty")?;
    let head = fields(head).context("line 1")?;
    let mut rows = vec![];
    for (number, line) in lines {
        let fields = fields(line).with_context(|| format!("line {}", number + 1))?;
        if fields.len() != head.len() {
            bail!("line {}: {} fields, the head has {}", number + 1, fields.len(), head.len());
        }
        rows.push(head.iter().cloned().zip(fields).collect());
    }
    Ok(rows)
}

fn fields(line: &str) -> anyhow::Result<Vec<String>> {
    let (mut fields, mut field, mut quoted) = (vec![], String::new(), false);
    let mut letters = line.trim_end_matches('\r').chars().peekable();
    while let Some(letter) = letters.next() {
        match letter {
            '"' if quoted && letters.peek() == Some(&'"') => {
                letters.next();
                field.push('"');
            }
            '"' => quoted = !quoted,
            ',' if !quoted => fields.push(std::mem::take(&mut field)),
            other => field.push(other),
        }
    }
    if quoted {
        bail!("a quote is left open");
    }
    fields.push(field);
    Ok(fields)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quoted_field_keeps_its_commas_and_quotes() {
        let rows = rows("file,boxes\na.jpg,\"[[1, 2]], \"\"x\"\"\"\n\nb.jpg,\n").unwrap();
        assert_eq!(rows[0]["boxes"], "[[1, 2]], \"x\"");
        assert_eq!((rows.len(), rows[1]["boxes"].as_str()), (2, ""));
    }

    #[test]
    fn a_torn_table_is_refused_with_its_line() {
        assert!(rows("a,b\n1,2\n3").unwrap_err().to_string().starts_with("line 3: 1 fields"));
        assert_eq!(format!("{:#}", rows("a\n\"1").unwrap_err()), "line 2: a quote is left open");
        assert!(rows("").is_err());
    }
}

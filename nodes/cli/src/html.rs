//! What every page that the command writes has in common.

use maud::{Markup, PreEscaped, html};

/// Head of a page that stands by itself: readable on a phone, and forbidden to fetch anything.
#[must_use]
pub fn head(title: &str, style: &str) -> Markup {
    html! {
        head {
            meta charset="utf-8";
            meta name="viewport" content="width=device-width, initial-scale=1";
            meta http-equiv="Content-Security-Policy"
                content="default-src 'none'; style-src 'unsafe-inline'; img-src data:";
            title { (title) }
            link rel="icon" href="data:,";
            style { (PreEscaped(style)) }
        }
    }
}

//! Two prints on one page.

use super::print::USUAL;
use super::{bag, is_self_contained, section};
use cli::report::{page, page_against};

/// Both prints on the same axes, in one page that needs nothing else; the other bag's figures beside this one's.
#[test]
fn a_print_is_drawn_against_another_one() {
    let (closed, open) = (bag("closed", &USUAL), bag("open", &USUAL));
    let text = page_against(&closed, None, Some(&open)).unwrap();
    is_self_contained(&text);
    let section = section(&text, "against");
    for title in [
        "Width error",
        "Flow out of the nozzle, as nominal filament",
        "Filament delivered less commanded, over roads",
        "Slip in the drive gear",
        "Nozzle less what counts as right, while roads are laid",
        "Trim of the flow",
        "Trim of the speed",
    ] {
        let at = section.find(&format!("<b>{title}</b>")).unwrap_or_else(|| panic!("no plot {title}"));
        let legend = &section[at..at + section[at..].find("</figcaption>").unwrap()];
        assert!(legend.contains("open") && legend.contains("closed"), "{legend}");
    }
    for row in ["times smaller", "Feed error", "Width error, RMS", "Mean Q", "First fault"] {
        assert!(section.contains(row), "no {row}");
    }
    assert!(!page(&closed, None).unwrap().contains("id=\"against\""), "only where it is asked for");
}

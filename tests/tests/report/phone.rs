//! The page on a phone.

use super::print::USUAL;
use super::{bag, browser};
use cli::report::page;

/// As wide as a phone, 390 px: every link of the bar is there to be touched, and nothing reaches beyond the edge. Chromium
/// makes no window below 500 px, so the page is held to less in it; its narrow form begins at 640 px.
#[test]
fn a_phone_shows_every_link_and_nothing_reaches_beyond_it() {
    let folder = bag("phone", &USUAL);
    let path = folder.join("page.html");
    let text = page(&folder, None).unwrap();
    let script = "<style>html{width:390px;overflow:hidden}</style><script>\
        const beyond = what => [...document.querySelectorAll(what)].filter(e => e.getBoundingClientRect().right > 390.5);\
        const named = list => list.map(e => e.tagName + ' ' + e.textContent.slice(0, 20)).join(', ');\
        const links = document.querySelectorAll('nav a').length;\
        document.title = `links ${links} cut [${named(beyond('nav a'))}] beyond [${named(beyond('h1,h2,h3,p,dl,svg,figure,.scroll'))}]`;\
        </script></body>";
    let (open, allowed) = ("default-src 'none'", "default-src 'none'; script-src 'unsafe-inline'");
    assert!(text.contains(open));
    std::fs::write(&path, text.replace(open, allowed).replace("</body>", script)).unwrap();
    let document = browser::document(&path, (500, 1600));
    let title = document.split_once("<title>").and_then(|(_, rest)| rest.split_once("</title>")).unwrap().0;
    assert_eq!(title, "links 15 cut [] beyond []");
}

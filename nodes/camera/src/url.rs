//! Addresses of cameras in the local network: `http://host[:port]/path`.

/// A plain HTTP address.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Url {
    /// Name or address, IPv6 without its brackets.
    pub host: String,
    /// Port; 80 where none is given.
    pub port: u16,
    /// Path and query, beginning with a slash.
    pub path: String,
}

/// Why a text is no address that is read from.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum UrlError {
    /// Another scheme.
    #[error("{0:?} does not begin with http://; cameras behind https or a log-in need a proxy on this host")]
    Scheme(String),
    /// No host, a bad port, a log-in, or a character that does not belong into an address.
    #[error("{0:?} is no http://host:port/path without a log-in, spaces and control characters")]
    Form(String),
}

impl Url {
    /// Reads an address.
    ///
    /// # Errors
    /// [`UrlError`]
    pub fn parse(text: &str) -> Result<Self, UrlError> {
        let rest = text.strip_prefix("http://").ok_or_else(|| UrlError::Scheme(text.to_owned()))?;
        parts(rest).ok_or_else(|| UrlError::Form(text.to_owned()))
    }
}

fn parts(rest: &str) -> Option<Url> {
    // What could end a line of the request early is no part of an address.
    if !rest.bytes().all(|byte| byte.is_ascii_graphic()) {
        return None;
    }
    let (authority, path) = match rest.find(['/', '?']) {
        Some(at) => rest.split_at(at),
        None => (rest, "/"),
    };
    let path = if path.starts_with('/') { path.to_owned() } else { format!("/{path}") };
    let (host, port) = match authority.strip_prefix('[') {
        Some(inside) => inside.split_once(']')?,
        None => authority.find(':').map_or((authority, ""), |at| authority.split_at(at)),
    };
    let port = match port.strip_prefix(':') {
        Some(number) => number.parse().ok().filter(|port| *port != 0)?,
        None if port.is_empty() => 80,
        None => return None,
    };
    let sound = !host.is_empty() && !host.contains(['@', '#', '[']) && !path.contains('#');
    sound.then(|| Url { host: host.to_owned(), port, path })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn parsed(text: &str) -> Option<(String, u16, String)> {
        Url::parse(text).ok().map(|url| (url.host, url.port, url.path))
    }

    fn is(host: &str, port: u16, path: &str) -> Option<(String, u16, String)> {
        Some((host.into(), port, path.into()))
    }

    #[test]
    fn addresses_of_the_usual_hosts() {
        assert_eq!(
            parsed("http://octopi.local/webcam/?action=stream"),
            is("octopi.local", 80, "/webcam/?action=stream")
        );
        assert_eq!(parsed("http://10.0.0.7:8080"), is("10.0.0.7", 8080, "/"));
        assert_eq!(parsed("http://cam?a"), is("cam", 80, "/?a"));
        assert_eq!(parsed("http://[::1]:81/x"), is("::1", 81, "/x"));
    }

    #[test]
    fn what_is_none_is_refused() {
        for text in [
            "https://cam/",
            "cam/",
            "http://",
            "http:///x",
            "http://cam:0/",
            "http://cam:99999/",
            "http://me:pw@cam/",
            "http://cam/a b",
            "http://cam/\r\nHost: x",
            "http://[::1",
            "http://cam/ü",
        ] {
            assert_eq!(parsed(text), None, "{text}");
        }
    }

    proptest! {
        /// A request made of an address has the lines it is given.
        #[test]
        fn no_address_ends_a_line(text in "http://[ -~\r\n]{0,40}") {
            if let Ok(url) = Url::parse(&text) {
                let ends = [url.host, url.path].concat().contains(['\r', '\n', ' ']);
                prop_assert!(!ends);
            }
        }
    }
}

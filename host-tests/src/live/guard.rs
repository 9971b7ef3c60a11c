//! Who is answered: the page that was opened by the printed address, and nobody else.
//!
//! A page of another site may send requests to this computer, under a name of its own that it lets point here
//! (DNS rebinding). So the host must be this computer's by number or `localhost`, the origin, where a browser names
//! one, this page's own; and every request has the token of the printed address.

/// What a request says of itself.
#[derive(Debug, Clone, Copy, Default)]
pub struct Asked<'a> {
    /// `Host`.
    pub host: Option<&'a str>,
    /// `Origin`.
    pub origin: Option<&'a str>,
    /// `Sec-Fetch-Site`.
    pub fetched_from: Option<&'a str>,
    /// The token, from the header `X-Token` or from the address.
    pub token: Option<&'a str>,
}

/// Decides.
#[derive(Debug, Clone)]
pub struct Guard {
    token: String,
}

impl Guard {
    /// With the token of this run.
    pub fn new(token: String) -> Self {
        Self { token }
    }

    /// The token.
    pub fn token(&self) -> &str {
        &self.token
    }

    /// Whether it is answered by a server at this port.
    ///
    /// # Errors
    /// Why not.
    pub fn admit(&self, asked: &Asked, port: u16) -> Result<(), &'static str> {
        let hosts = [format!("127.0.0.1:{port}"), format!("localhost:{port}")];
        let is_own_host = |host: &str| hosts.iter().any(|own| own.eq_ignore_ascii_case(host));
        if !asked.host.is_some_and(is_own_host) {
            return Err("another host");
        }
        let is_own_origin = |origin: &str| origin.strip_prefix("http://").is_some_and(is_own_host);
        if !asked.origin.is_none_or(is_own_origin) {
            return Err("another origin");
        }
        // Typed in or followed from a terminal: none. From the page itself: same-origin.
        if !asked
            .fetched_from
            .is_none_or(|site| matches!(site, "none" | "same-origin"))
        {
            return Err("another site");
        }
        if asked.token != Some(&self.token) {
            return Err("no token, or another one; open the printed address");
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pages_own_requests_are_admitted_and_no_others() {
        let guard = Guard::new("secret".to_owned());
        let own = Asked {
            host: Some("127.0.0.1:8080"),
            origin: Some("http://127.0.0.1:8080"),
            fetched_from: Some("same-origin"),
            token: Some("secret"),
        };
        let admitted = [
            own,
            Asked {
                origin: None,
                fetched_from: Some("none"),
                ..own
            },
            Asked {
                host: Some("localhost:8080"),
                origin: Some("http://localhost:8080"),
                ..own
            },
        ];
        for asked in admitted {
            assert_eq!(guard.admit(&asked, 8080), Ok(()), "{asked:?}");
        }
        let refused = [
            Asked {
                host: Some("evil.example:8080"),
                ..own
            },
            Asked {
                host: Some("127.0.0.1:80"),
                ..own
            },
            Asked { host: None, ..own },
            Asked {
                origin: Some("http://evil.example"),
                ..own
            },
            Asked {
                origin: Some("http://127.0.0.1:9090"),
                ..own
            },
            Asked {
                origin: Some("https://127.0.0.1:8080"),
                ..own
            },
            Asked {
                origin: Some("null"),
                ..own
            },
            Asked {
                fetched_from: Some("cross-site"),
                ..own
            },
            Asked {
                fetched_from: Some("same-site"),
                ..own
            },
            Asked { token: None, ..own },
            Asked {
                token: Some("secre"),
                ..own
            },
            Asked {
                token: Some(""),
                ..own
            },
        ];
        for asked in refused {
            assert!(guard.admit(&asked, 8080).is_err(), "{asked:?}");
        }
    }
}

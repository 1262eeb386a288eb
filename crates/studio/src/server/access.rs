//! Who may open the socket.

use std::net::{IpAddr, SocketAddr};

/// Why somebody may not.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Refusal {
    /// A page of another origin asks.
    Origin,
    /// The token is missing or wrong.
    Token,
}

/// The rules of one server.
#[derive(Debug, Clone)]
pub(super) struct Access {
    /// What must be known to get in; nobody needs to know anything on this computer itself.
    token: Option<String>,
}

impl Access {
    /// Rules for an address. What can be reached from other computers needs a token.
    pub fn new(address: &SocketAddr, token: Option<String>) -> Result<Self, getrandom::Error> {
        let token = match token {
            Some(token) => Some(token),
            None if address.ip().is_loopback() => None,
            None => Some(random_token()?),
        };
        Ok(Self { token })
    }

    /// What must be known.
    pub fn token(&self) -> Option<&str> {
        self.token.as_deref()
    }

    /// Checks a request. `host` and `origin` are its headers, `token` is what it knows.
    ///
    /// Browsers always say from which origin a page comes. Other programs need not, and could say anything; for them there is the
    /// token. Without one, the host must be this computer by name or number, so that a name that somebody else has pointed here
    /// opens nothing.
    pub fn check(
        &self,
        host: Option<&str>,
        origin: Option<&str>,
        token: Option<&str>,
    ) -> Result<(), Refusal> {
        if let Some(origin) = origin {
            let authority = origin.strip_prefix("http://").or_else(|| origin.strip_prefix("https://"));
            if authority.is_none() || authority != host {
                return Err(Refusal::Origin);
            }
        }
        match &self.token {
            None if host.is_some_and(is_loopback_host) => Ok(()),
            None => Err(Refusal::Origin),
            Some(expected) if token.is_some_and(|token| is_equal(token, expected)) => Ok(()),
            Some(_) => Err(Refusal::Token),
        }
    }
}

fn is_loopback_host(host: &str) -> bool {
    if let Ok(address) = host.parse::<SocketAddr>() {
        return address.ip().is_loopback();
    }
    if let Ok(address) = host.trim_matches(['[', ']']).parse::<IpAddr>() {
        return address.is_loopback();
    }
    host.split(':').next().is_some_and(|name| name.eq_ignore_ascii_case("localhost"))
}

/// Compares without telling by its time where the difference is.
fn is_equal(a: &str, b: &str) -> bool {
    a.len() == b.len() && a.bytes().zip(b.bytes()).fold(0, |sum, (a, b)| sum | (a ^ b)) == 0
}

/// 128 random bits in hexadecimal digits.
pub(super) fn random_token() -> Result<String, getrandom::Error> {
    let mut bytes = [0_u8; 16];
    getrandom::fill(&mut bytes)?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn access(address: &str) -> Access {
        Access::new(&address.parse().unwrap(), None).unwrap()
    }

    #[test]
    fn other_origins_are_refused() {
        let access = access("127.0.0.1:7878");
        let host = Some("127.0.0.1:7878");
        assert_eq!(access.check(host, Some("http://127.0.0.1:7878"), None), Ok(()));
        assert_eq!(access.check(host, None, None), Ok(()), "a program without pages");
        for origin in ["http://example.org", "http://127.0.0.1:1", "null", "file://", ""] {
            assert_eq!(access.check(host, Some(origin), None), Err(Refusal::Origin), "{origin}");
        }
    }

    #[test]
    fn a_name_that_points_here_opens_nothing() {
        let access = access("127.0.0.1:7878");
        for host in ["evil.example:7878", "127.0.0.1.evil.example", ""] {
            let origin = format!("http://{host}");
            assert_eq!(access.check(Some(host), Some(&origin), None), Err(Refusal::Origin), "{host}");
        }
        assert_eq!(access.check(None, None, None), Err(Refusal::Origin));
        for host in ["localhost:7878", "[::1]:7878", "127.0.0.1"] {
            assert_eq!(access.check(Some(host), None, None), Ok(()), "{host}");
        }
    }

    #[test]
    fn whoever_comes_from_outside_needs_the_token() {
        let access = access("0.0.0.0:7878");
        let token = access.token().unwrap().to_owned();
        assert!(token.len() == 32 && Some(token.as_str()) != self::access("0.0.0.0:1").token());
        let (host, origin) = (Some("robot:7878"), Some("http://robot:7878"));
        assert_eq!(access.check(host, origin, None), Err(Refusal::Token));
        assert_eq!(access.check(host, origin, Some(&token[1..])), Err(Refusal::Token));
        assert_eq!(access.check(host, origin, Some(&token)), Ok(()));
        assert_eq!(access.check(host, Some("http://other"), Some(&token)), Err(Refusal::Origin));
    }
}

//! The token of a run: the secret that admits its coordinator and its partner.

use crate::hex::hex;
use tonic::metadata::{Ascii, MetadataMap, MetadataValue};

use crate::limits::{MAX_NAME_BYTES, MIN_TOKEN_BYTES};

/// Metadata key of the run's token.
pub(crate) const TOKEN_KEY: &str = "fsi-token";

/// Secret of a run: who knows it may speak for the run.
#[derive(Clone)]
pub(crate) struct Token(String);

impl std::fmt::Debug for Token {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Token(hidden)")
    }
}

impl Token {
    /// A token that cannot be guessed.
    pub(crate) fn fresh() -> Result<Self, String> {
        let mut bytes = [0; 32];
        getrandom::fill(&mut bytes).map_err(|e| format!("no random numbers for a token: {e}"))?;
        Ok(Self(hex(&bytes)))
    }

    /// A token from the wire.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        let printable = text.bytes().all(|byte| byte.is_ascii_graphic());
        if printable && (MIN_TOKEN_BYTES..=MAX_NAME_BYTES).contains(&text.len()) {
            Ok(Self(text.to_owned()))
        } else {
            // The value stays unsaid: it may be a secret with a slip.
            Err(format!("must have {MIN_TOKEN_BYTES} to {MAX_NAME_BYTES} printable ASCII characters"))
        }
    }

    /// Text for the message that opens a run.
    pub(crate) fn text(&self) -> &str {
        &self.0
    }

    /// `message` with the token in its metadata.
    pub(crate) fn attach<T>(&self, message: T) -> tonic::Request<T> {
        let mut request = tonic::Request::new(message);
        // Printable ASCII is always a valid value.
        if let Ok(value) = self.0.parse::<MetadataValue<Ascii>>() {
            request.metadata_mut().insert(TOKEN_KEY, value);
        }
        request
    }

    /// Whether `metadata` carry this token.
    pub(crate) fn admits(&self, metadata: &MetadataMap) -> bool {
        self.is_in(metadata.get(TOKEN_KEY))
    }

    /// Whether `given` is this token; takes the same time wherever the first difference lies.
    pub(crate) fn is_in(&self, given: Option<&MetadataValue<Ascii>>) -> bool {
        let Some(given) = given else { return false };
        let (given, own) = (given.as_bytes(), self.0.as_bytes());
        if given.len() != own.len() {
            return false;
        }
        let difference = given.iter().zip(own).fold(0, |sum, (a, b)| sum | std::hint::black_box(a ^ b));
        std::hint::black_box(difference) == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tokens_admit_themselves_only() {
        let token = Token::fresh().unwrap();
        assert!(token.admits(token.attach(()).metadata()));
        assert!(!token.admits(&MetadataMap::new()));
        assert!(!token.admits(Token::fresh().unwrap().attach(()).metadata()));
        let mut other = token.text().to_owned();
        other.pop();
        assert!(!token.admits(Token::parse(&other).unwrap().attach(()).metadata()));
        assert!(!format!("{token:?}").contains(token.text()));
        assert!(Token::parse("short").is_err());
        assert!(Token::parse(&"a b".repeat(10)).is_err());
    }
}

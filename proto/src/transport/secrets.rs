//! Secrets and where they come from: files, and the pipe from the program that started this one.

use std::fs::Metadata;
use std::io::Read;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

use tonic::transport::Identity;

use crate::limits::MAX_NAME_BYTES;
use crate::transport::token::Token;

/// Largest certificate, key or token file \[bytes\]: a chain of some hundred certificates.
const LARGEST_FILE: u64 = 1 << 20;

/// Access token that a program makes for a server that it starts.
///
/// It goes through the pipe to the standard input of that server, as its first line: neither arguments nor environment, which
/// other users may read, hold it.
#[derive(Clone, Debug)]
pub struct AccessToken(pub(crate) Token);

impl AccessToken {
    /// Environment variable that says `1` to a program whose first line of standard input is its access token.
    pub const ANNOUNCEMENT: &'static str = "TIDELOCK_TOKEN_STDIN";

    /// A token that cannot be guessed.
    ///
    /// # Errors
    /// When the system has no random numbers.
    pub fn fresh() -> Result<Self, String> {
        Token::fresh().map(Self)
    }

    /// The line for the pipe.
    pub fn line(&self) -> String {
        format!("{}\n", self.0.text())
    }

    /// The token in the first line of `input`; what follows stays unread.
    ///
    /// # Errors
    /// When there is none.
    pub(crate) fn receive(input: &mut impl Read) -> Result<Self, String> {
        let (mut line, mut byte) = (Vec::new(), [0]);
        loop {
            match input.read(&mut byte) {
                Ok(0) => return Err("standard input ended before the access token in its first line".into()),
                Ok(_) if byte == *b"\n" => break,
                Ok(_) if line.len() > MAX_NAME_BYTES => break,
                Ok(_) => line.extend(byte),
                Err(e) if e.kind() == std::io::ErrorKind::Interrupted => {}
                Err(e) => return Err(format!("the access token cannot be read from standard input: {e}")),
            }
        }
        let text = std::str::from_utf8(&line).unwrap_or_default();
        Token::parse(text.trim())
            .map(Self)
            .map_err(|problem| format!("the first line of standard input, the access token, {problem}"))
    }
}

/// Reads files of secrets and notes which of them other users can read.
#[derive(Debug, Default)]
pub(crate) struct Secrets {
    /// Warnings.
    pub(crate) exposed: Vec<String>,
}

impl Secrets {
    /// A certificate with its private key.
    pub(crate) fn identity(&mut self, certificate: &Path, key: &Path) -> Result<Identity, String> {
        let certificate = read("certificate", certificate)?;
        Ok(Identity::from_pem(certificate, self.read("private key", key)?))
    }

    /// A token.
    pub(crate) fn token(&mut self, path: &Path) -> Result<Token, String> {
        let content = self.read("token file", path)?;
        let text = std::str::from_utf8(&content).unwrap_or_default();
        Token::parse(text.trim())
            .map_err(|problem| format!("token file `{}`: its text {problem}", path.display()))
    }

    fn read(&mut self, what: &str, path: &Path) -> Result<Vec<u8>, String> {
        let content = read(what, path)?;
        let mode = std::fs::metadata(path).map_or(0, |facts: Metadata| facts.permissions().mode());
        if mode & 0o077 != 0 {
            self.exposed.push(format!(
                "{what} `{0}` has mode {1:03o}, by which other users can use it; run `chmod 600 {0}`",
                path.display(),
                mode & 0o777
            ));
        }
        Ok(content)
    }
}

/// The content of a small file; `what` says what it is for.
pub(crate) fn read(what: &str, path: &Path) -> Result<Vec<u8>, String> {
    let fail = |problem: String| format!("{what} `{}`: {problem}", path.display());
    // A device or pipe could be endless.
    let facts = std::fs::metadata(path).map_err(|e| fail(format!("cannot be read: {e}")))?;
    if !facts.is_file() {
        return Err(fail("is not a regular file".into()));
    }
    let file = std::fs::File::open(path).map_err(|e| fail(format!("cannot be read: {e}")))?;
    let mut content = Vec::new();
    file.take(LARGEST_FILE + 1)
        .read_to_end(&mut content)
        .map_err(|e| fail(format!("cannot be read: {e}")))?;
    if content.is_empty() || content.len() as u64 > LARGEST_FILE {
        return Err(fail(format!("has {} bytes or more, must have 1 to {LARGEST_FILE}", content.len())));
    }
    Ok(content)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_token_comes_in_the_first_line_and_what_follows_stays() {
        let token = AccessToken::fresh().unwrap();
        let sent = format!("{}rest", token.line());
        let mut input = sent.as_bytes();
        assert_eq!(AccessToken::receive(&mut input).unwrap().line(), token.line());
        assert_eq!(input, b"rest");
        for (sent, words) in
            [("", "ended before"), ("0123456789abcdef", "ended before"), ("short\n", "16 to 256")]
        {
            let problem = AccessToken::receive(&mut sent.as_bytes()).unwrap_err();
            assert!(problem.contains(words) && !problem.contains("0123"), "{problem}");
        }
        let endless = AccessToken::receive(&mut std::io::repeat(b'a')).unwrap_err();
        assert!(endless.contains("16 to 256"), "{endless}");
    }

    #[test]
    fn files_of_secrets_that_others_can_read_are_named_with_the_remedy() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("token");
        std::fs::write(&path, "0123456789abcdef\n").unwrap();
        for (mode, exposed) in [(0o600, false), (0o400, false), (0o604, true), (0o640, true), (0o644, true)] {
            std::fs::set_permissions(&path, std::fs::Permissions::from_mode(mode)).unwrap();
            let mut secrets = Secrets::default();
            secrets.token(&path).unwrap();
            assert_eq!(!secrets.exposed.is_empty(), exposed, "{mode:o}");
            if let Some(warning) = secrets.exposed.first() {
                let remedy = format!("chmod 600 {}", path.display());
                assert!(warning.contains(&remedy) && warning.contains(&format!("{mode:o}")), "{warning}");
                assert!(!warning.contains("0123456789"), "{warning}");
            }
        }
    }
}

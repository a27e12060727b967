//! Certificates and tokens of a server and its callers.

use std::path::Path;

use crate::PROGRAM;
use proto::transport::security::ClientFiles;
use tempfile::TempDir;
use tests::bench::text;
use tests::certificates::{Authority, token};
use tests::nodes::Node;

/// What a server demands.
#[derive(Clone, Copy, Debug)]
pub struct Demands {
    pub tls: bool,
    pub certificate: bool,
    pub token: bool,
}

/// What a caller does.
#[derive(Clone, Copy, Debug)]
pub struct Shows {
    pub tls: bool,
    /// None, the right or another authority's.
    pub certificate: Option<bool>,
    pub token: Option<bool>,
    /// Whether it knows the server's authority.
    pub trusts: bool,
}

pub struct Secrets {
    pub folder: TempDir,
    pub own: Authority,
    pub other: Authority,
}

impl Secrets {
    pub fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let (own, other) = (Authority::new(folder.path(), "own"), Authority::new(folder.path(), "other"));
        token(folder.path(), "a");
        token(folder.path(), "b");
        Self { folder, own, other }
    }

    pub fn token(&self, right: bool) -> std::path::PathBuf {
        self.folder.path().join(if right { "token-a" } else { "token-b" })
    }

    /// Arguments of a server.
    pub fn server(&self, demands: Demands) -> Vec<String> {
        let mut arguments = Vec::new();
        let mut add = |option: &str, path: &Path| {
            arguments.extend([option.to_owned(), text(path).to_owned()]);
        };
        if demands.tls {
            add("--tls-cert", &self.own.file("server"));
            add("--tls-key", &self.own.key("server"));
            add("--partner-ca", &self.own.file("ca"));
        }
        if demands.certificate {
            add("--tls-client-ca", &self.own.file("ca"));
        }
        if demands.token {
            add("--token-file", &self.token(true));
        }
        arguments
    }

    pub fn start(&self, role: &str, demands: Demands) -> Node {
        let arguments = self.server(demands);
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        Node::start(Path::new(PROGRAM), role, &arguments)
    }

    /// Files of a caller.
    pub fn caller(&self, shows: Shows) -> ClientFiles {
        let trusted = if shows.trusts { &self.own } else { &self.other };
        let identity = shows.certificate.map(|right| {
            let of = if right { &self.own } else { &self.other };
            (of.file("caller"), of.key("caller"))
        });
        ClientFiles {
            authority: shows.tls.then(|| trusted.file("ca")),
            identity: identity.filter(|_| shows.tls),
            token: shows.token.map(|right| self.token(right)),
        }
    }

    /// Options of the coordinator for servers that demand all; it shows the certificate of `holder`.
    pub fn options(&self, holder: &str, right: bool) -> Vec<String> {
        let (ca, cert, key) = (self.own.file("ca"), self.own.file(holder), self.own.key(holder));
        let token = self.token(right);
        let files = [("--tls-ca", &ca), ("--tls-cert", &cert), ("--tls-key", &key), ("--token-file", &token)];
        files.iter().flat_map(|(option, path)| [(*option).to_owned(), text(path).to_owned()]).collect()
    }
}

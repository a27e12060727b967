//! Authorities, certificates and tokens for one test, made by the test.

use std::path::{Path, PathBuf};

use proto::transport::security::ClientFiles;
use rcgen::{BasicConstraints, CertificateParams, CertifiedIssuer, IsCa, KeyPair};

/// An authority with a certificate for a server of this machine and one for a caller.
#[derive(Debug)]
pub struct Authority {
    folder: PathBuf,
    name: String,
}

impl Authority {
    /// A new authority called `name`; its files go to `folder`.
    pub fn new(folder: &Path, name: &str) -> Self {
        let mut params = CertificateParams::new(Vec::new()).unwrap();
        params.is_ca = IsCa::Ca(BasicConstraints::Unconstrained);
        params.distinguished_name.push(rcgen::DnType::CommonName, name);
        let issuer = CertifiedIssuer::self_signed(params, KeyPair::generate().unwrap()).unwrap();
        let authority = Self { folder: folder.into(), name: name.into() };
        std::fs::write(authority.file("ca"), issuer.pem()).unwrap();
        for (holder, hosts) in [("server", vec!["127.0.0.1", "localhost"]), ("caller", vec!["caller"])] {
            let hosts: Vec<String> = hosts.into_iter().map(String::from).collect();
            let key = KeyPair::generate().unwrap();
            let certificate = CertificateParams::new(hosts).unwrap().signed_by(&key, &issuer).unwrap();
            std::fs::write(authority.file(holder), certificate.pem()).unwrap();
            std::fs::write(authority.key(holder), key.serialize_pem()).unwrap();
        }
        authority
    }

    /// Certificate of `ca`, `server` or `caller`.
    pub fn file(&self, holder: &str) -> PathBuf {
        self.folder.join(format!("{}-{holder}.pem", self.name))
    }

    /// Private key of `server` or `caller`.
    pub fn key(&self, holder: &str) -> PathBuf {
        self.folder.join(format!("{}-{holder}.key", self.name))
    }

    /// What a caller needs that trusts this authority, with its certificate where it shows one.
    pub fn caller(&self, shows: bool) -> ClientFiles {
        let identity = shows.then(|| (self.file("caller"), self.key("caller")));
        ClientFiles { authority: Some(self.file("ca")), identity, token: None }
    }
}

/// Writes a token of 20 times `letter` to `folder`.
pub fn token(folder: &Path, letter: &str) -> PathBuf {
    let path = folder.join(format!("token-{letter}"));
    std::fs::write(&path, letter.repeat(20) + "\n").unwrap();
    path
}

//! Who may speak: certificates, and the secret that a server asks of its callers.
//!
//! A server holds a certificate (TLS), may demand one of its callers (mutual TLS), and may demand an access token with
//! every call of the control plane. The exchange between solvers is guarded by the run's own token, which only they and
//! the coordinator know.

use std::net::{IpAddr, SocketAddr};
use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use tonic::metadata::{Ascii, MetadataValue};
use tonic::service::Interceptor;
use tonic::service::interceptor::InterceptedService;
use tonic::transport::{Certificate, Channel, ClientTlsConfig, Endpoint, Server, ServerTlsConfig};
use tonic::{Request, Status};

use crate::error::with_causes;
use crate::transport::connection::Caller;
pub use crate::transport::secrets::AccessToken;
use crate::transport::secrets::{Secrets, read};
use crate::transport::token::Token;

/// Metadata key of a server's access token.
const ACCESS_KEY: &str = "fsi-access";
/// Wait for a caller's part of the TLS handshake.
const HANDSHAKE_TIMEOUT: Duration = Duration::from_secs(10);

/// What a caller trusts and shows.
#[derive(Clone, Default)]
pub struct ClientSecurity {
    tls: Option<ClientTlsConfig>,
    access: Option<Token>,
    /// Whether it shows a certificate of its own.
    identified: bool,
    warnings: Vec<String>,
}

/// What a server shows and demands.
#[derive(Clone, Default)]
pub struct ServerSecurity {
    tls: Option<ServerTlsConfig>,
    access: Option<Token>,
    /// Health and reflection, too, are for those with the access token only.
    private: bool,
    /// How it calls its partner.
    partner: ClientSecurity,
    warnings: Vec<String>,
}

// Neither keys nor tokens belong into a log.
impl std::fmt::Debug for ClientSecurity {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "ClientSecurity {{ tls: {}, access: {} }}", self.tls.is_some(), self.access.is_some())
    }
}

impl std::fmt::Debug for ServerSecurity {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "ServerSecurity {{ tls: {}, access: {} }}", self.tls.is_some(), self.access.is_some())
    }
}

/// Files with what a caller trusts and presents.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ClientFiles {
    /// Certificates (PEM) of the authorities that servers at `https://` addresses must be signed by.
    pub authority: Option<PathBuf>,
    /// The own certificate (PEM), for servers that demand one, and its private key (PEM).
    pub identity: Option<(PathBuf, PathBuf)>,
    /// Access token of the servers.
    pub token: Option<PathBuf>,
}

/// Options of a server program that say who may speak.
#[derive(Clone, Debug, Default, Args)]
pub struct ServerFiles {
    /// Certificate chain of this server (PEM); it then speaks TLS only, at `https://HOST:PORT`.
    #[arg(long, value_name = "FILE", requires = "tls_key")]
    pub tls_cert: Option<PathBuf>,
    /// Private key of the certificate (PEM).
    #[arg(long, value_name = "FILE", requires = "tls_cert")]
    pub tls_key: Option<PathBuf>,
    /// Demand a certificate signed by one of these (PEM) of everyone who calls, the partner included.
    #[arg(long, value_name = "FILE", requires = "tls_cert")]
    pub tls_client_ca: Option<PathBuf>,
    /// Demand the token in this file (16 to 256 printable ASCII characters) of every coordinator.
    #[arg(long, value_name = "FILE")]
    pub token_file: Option<PathBuf>,
    /// Authorities (PEM) that a partner at an `https://` address must be signed by.
    #[arg(long, value_name = "FILE")]
    pub partner_ca: Option<PathBuf>,
    /// Certificate (PEM) to show to a partner that demands one [default: that of --tls-cert].
    #[arg(long, value_name = "FILE", requires = "partner_key")]
    pub partner_cert: Option<PathBuf>,
    /// Private key of that certificate (PEM).
    #[arg(long, value_name = "FILE", requires = "partner_cert")]
    pub partner_key: Option<PathBuf>,
}

impl ClientSecurity {
    /// Reads what `files` name.
    ///
    /// # Errors
    /// Which file cannot be read or is no certificate, key or token.
    pub fn load(files: &ClientFiles) -> Result<Self, String> {
        let mut secrets = Secrets::default();
        let access = files.token.as_deref().map(|path| secrets.token(path)).transpose()?;
        let Some(authority) = &files.authority else {
            return if files.identity.is_some() {
                Err("a certificate to show is of no use without the authority's, by which servers are known"
                    .into())
            } else {
                Ok(Self { access, warnings: secrets.exposed, ..Self::default() })
            };
        };
        let certificates = Certificate::from_pem(read("authority's certificate", authority)?);
        let mut tls = ClientTlsConfig::new().ca_certificate(certificates);
        if let Some((certificate, key)) = &files.identity {
            tls = tls.identity(secrets.identity(certificate, key)?);
        }
        // Any address does: what is wrong with the files shows here.
        Endpoint::from_static("https://localhost:1").tls_config(tls.clone()).map_err(|e| {
            let text = with_causes(&e);
            format!("`{}` or the certificate to show cannot be used: {text}", authority.display())
        })?;
        let identified = files.identity.is_some();
        Ok(Self { tls: Some(tls), access, identified, warnings: secrets.exposed })
    }

    /// The same for a server that demands `access`.
    pub fn with_access(&self, access: &AccessToken) -> Self {
        Self { access: Some(access.0.clone()), ..self.clone() }
    }

    /// The access token that is shown to servers.
    pub fn access(&self) -> Option<AccessToken> {
        self.access.clone().map(AccessToken)
    }

    /// Whether a certificate is shown to servers that demand one.
    pub fn shows_certificate(&self) -> bool {
        self.identified
    }

    /// Files of secrets that other users can read.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Prepares `endpoint` at `uri` for TLS where the address asks for it.
    pub(crate) fn apply(&self, endpoint: Endpoint) -> Result<Endpoint, String> {
        let uri = endpoint.uri().clone();
        if uri.scheme_str() == Some("https") {
            let Some(tls) = &self.tls else {
                return Err(
                    "is an `https://` address, but no authority's certificate is given by which it is known"
                        .into(),
                );
            };
            let failed = |e| format!("cannot be called by TLS: {}", with_causes(&e));
            return endpoint.tls_config(tls.clone()).map_err(failed);
        }
        if self.access.is_some() && !uri.host().is_some_and(is_this_machine) {
            return Err("is beyond this machine, and the access token would travel unencrypted; write \
                        `https://HOST:PORT`, or reach the server through a tunnel"
                .into());
        }
        Ok(endpoint)
    }

    /// `channel`, by which every call carries the access token.
    pub(crate) fn over(&self, channel: Channel) -> SecuredChannel {
        InterceptedService::new(channel, self.shower())
    }

    /// Adds the access token to every call.
    pub(crate) fn shower(&self) -> ShowAccess {
        ShowAccess(self.access.as_ref().and_then(|token| token.text().parse().ok()))
    }
}

fn is_this_machine(host: &str) -> bool {
    let bare = host.trim_start_matches('[').trim_end_matches(']');
    bare == "localhost" || bare.parse::<IpAddr>().is_ok_and(|address| address.is_loopback())
}

impl ServerSecurity {
    /// Reads what `files` name.
    ///
    /// # Errors
    /// Which file cannot be read or is no certificate, key or token.
    pub fn load(files: &ServerFiles) -> Result<Self, String> {
        let pair =
            |certificate: &Option<PathBuf>, key: &Option<PathBuf>| certificate.clone().zip(key.clone());
        let own = pair(&files.tls_cert, &files.tls_key);
        let mut secrets = Secrets::default();
        let mut tls = None;
        if let Some((certificate, key)) = &own {
            let mut settings = ServerTlsConfig::new()
                .identity(secrets.identity(certificate, key)?)
                .timeout(HANDSHAKE_TIMEOUT);
            if let Some(authority) = &files.tls_client_ca {
                settings =
                    settings.client_ca_root(Certificate::from_pem(read("client authority", authority)?));
            }
            Server::builder().tls_config(settings.clone()).map_err(|e| {
                let text = with_causes(&e);
                format!("`{}` with its key cannot be used: {text}", certificate.display())
            })?;
            tls = Some(settings);
        }
        let shown = pair(&files.partner_cert, &files.partner_key).or(own);
        let partner = ClientSecurity::load(&ClientFiles {
            authority: files.partner_ca.clone(),
            identity: shown.filter(|_| files.partner_ca.is_some()),
            token: None,
        })?;
        let access = files.token_file.as_deref().map(|path| secrets.token(path)).transpose()?;
        secrets.exposed.extend(partner.warnings.iter().cloned());
        secrets.exposed.dedup();
        Ok(Self { tls, access, private: false, partner, warnings: secrets.exposed })
    }

    /// These, for a server that one program has for itself: every call needs `access`.
    pub(crate) fn private(self, access: AccessToken) -> Self {
        Self { access: Some(access.0), private: true, ..self }
    }

    /// Files of secrets that other users can read.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// What stands between the servers of a run needs: with a certificate in `files` it speaks TLS by that one, and demands
    /// one signed by the same authority. It shows the same to servers.
    ///
    /// # Errors
    /// As [`ServerSecurity::load`].
    pub fn between(files: &ClientFiles) -> Result<Self, String> {
        let (tls_cert, tls_key) = files.identity.clone().unzip();
        let tls_client_ca = tls_cert.as_ref().and(files.authority.clone());
        let own = Self::load(&ServerFiles { tls_cert, tls_key, tls_client_ca, ..ServerFiles::default() })?;
        Ok(Self { partner: ClientSecurity::load(files)?, ..own })
    }

    /// A server of this machine that calls its partner by `partner`.
    pub(crate) fn calling(partner: ClientSecurity) -> Self {
        Self { partner, ..Self::default() }
    }

    /// Whether it speaks TLS only.
    pub fn has_tls(&self) -> bool {
        self.tls.is_some()
    }

    /// Why a server with these settings must not listen on `address`; `None` when it may.
    pub(crate) fn refusal(&self, address: &SocketAddr) -> Option<String> {
        if address.ip().is_loopback() || (self.tls.is_some() && self.access.is_some()) {
            return None;
        }
        let mut missing = Vec::new();
        if self.tls.is_none() {
            missing.push("a certificate (`--tls-cert`, `--tls-key`), as it would speak unencrypted");
        }
        if self.access.is_none() {
            missing.push("a token (`--token-file`), as everyone who reaches the port could use the server");
        }
        Some(format!(
            "`--listen {address}` reaches beyond this machine, which needs {}; listen on 127.0.0.1, or add `--insecure` \
             to accept that risk",
            missing.join(" and ")
        ))
    }

    pub(crate) fn tls(&self) -> Option<&ServerTlsConfig> {
        self.tls.as_ref()
    }

    pub(crate) fn partner(&self) -> &ClientSecurity {
        &self.partner
    }

    /// Lets calls with the access token pass.
    pub(crate) fn gate(&self) -> AccessGate {
        AccessGate { access: self.access.clone(), note: Caller::admitted }
    }

    /// Lets all calls pass, unless the server is for one program only.
    pub(crate) fn open_gate(&self) -> AccessGate {
        AccessGate { access: self.access.clone().filter(|_| self.private), note: Caller::called }
    }
}

/// A connection by which every call carries the access token.
pub(crate) type SecuredChannel = InterceptedService<Channel, ShowAccess>;

/// A caller's end: shows the access token.
#[derive(Clone, Debug)]
pub(crate) struct ShowAccess(Option<MetadataValue<Ascii>>);

impl Interceptor for ShowAccess {
    fn call(&mut self, mut request: Request<()>) -> Result<Request<()>, Status> {
        if let Some(token) = &self.0 {
            request.metadata_mut().insert(ACCESS_KEY, token.clone());
        }
        Ok(request)
    }
}

/// A server's end: refuses calls without the access token, and does not say what was wrong with it.
#[derive(Clone)]
pub(crate) struct AccessGate {
    access: Option<Token>,
    /// What a call that passes means for its connection.
    note: fn(&Caller),
}

impl Interceptor for AccessGate {
    fn call(&mut self, request: Request<()>) -> Result<Request<()>, Status> {
        match &self.access {
            Some(token) if !token.is_in(request.metadata().get(ACCESS_KEY)) => {
                Err(Status::permission_denied("not allowed"))
            }
            _ => {
                Caller::of(request.extensions()).into_iter().for_each(self.note);
                Ok(request)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with_access(token: &str) -> ClientSecurity {
        ClientSecurity { access: Some(Token::parse(token).unwrap()), ..ClientSecurity::default() }
    }

    #[test]
    fn an_access_token_never_leaves_the_machine_unencrypted() {
        let security = with_access("0123456789abcdef");
        for (address, allowed) in [
            ("http://127.0.0.1:1", true),
            ("http://[::1]:1", true),
            ("http://localhost:1", true),
            ("http://192.0.2.1:1", false),
            ("http://127.0.0.1.example.org:1", false),
        ] {
            let endpoint = Endpoint::from_shared(address.to_owned()).unwrap();
            assert_eq!(security.apply(endpoint.clone()).is_ok(), allowed, "{address}");
            assert!(ClientSecurity::default().apply(endpoint).is_ok());
        }
        let secured = Endpoint::from_static("https://192.0.2.1:1");
        assert!(security.apply(secured).unwrap_err().contains("authority"));
    }

    #[test]
    fn the_gate_passes_its_token_only_and_without_one_everybody() {
        let gate =
            |token: &str| ServerSecurity { access: Token::parse(token).ok(), ..Default::default() }.gate();
        let shown = |token: &str| with_access(token).shower().call(Request::new(())).unwrap();
        assert!(gate("0123456789abcdef").call(shown("0123456789abcdef")).is_ok());
        for wrong in ["0123456789abcdeF", "0123456789abcdefg", "0123456789abcde0"] {
            let refused = gate("0123456789abcdef").call(shown(wrong)).unwrap_err();
            assert_eq!((refused.code(), refused.message()), (tonic::Code::PermissionDenied, "not allowed"));
        }
        assert!(gate("0123456789abcdef").call(Request::new(())).is_err());
        assert!(ServerSecurity::default().gate().call(Request::new(())).is_ok());
    }

    #[test]
    fn files_that_are_no_secrets_are_named() {
        let folder = std::env::temp_dir();
        let problem = ServerSecurity::load(&ServerFiles { token_file: Some(folder), ..Default::default() });
        assert!(problem.unwrap_err().contains("not a regular file"));
        let missing = ClientFiles { authority: Some("/nowhere/ca.pem".into()), ..Default::default() };
        assert!(ClientSecurity::load(&missing).unwrap_err().contains("/nowhere/ca.pem"));
    }
}

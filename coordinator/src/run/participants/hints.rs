//! What to do after a failure: about a server that does not answer as a solver of the run, and how to continue.

use std::path::Path;

use proto::transport::security::ClientSecurity;
use proto::{RpcCode, RpcError};

use crate::PROGRAM;
use crate::failure::Failure;
use crate::run::participants::launch::Server;
use crate::run::participants::logs;

/// The failure of a first call to `server`, with what to do about it.
pub(crate) async fn unreachable(error: RpcError, server: &mut Server) -> Failure {
    let (role, at) = (server.role, server.address.clone());
    let ended = server.ended().await;
    if let (Some(status), Some((program, log))) = (ended, server.program()) {
        return Failure::server(format!(
            "the {role} server `{program}` ended before its run began, by {status}{}",
            logs::tail(log)
        ));
    }
    let remedy = of_secrets(&error, &server.security).map_or_else(
        || {
            format!(
                "start a {role} server that listens at {at}, or give another address by `--{role}` or `[servers]` of the case"
            )
        },
        |remedy| format!("{remedy}, or by `[servers]` of the case"),
    );
    Failure::server(format!("{error}; {remedy}"))
}

/// What to do about an `error` by which either side does not trust the other, which was shown `security`.
pub(crate) fn of_secrets(error: &RpcError, security: &ClientSecurity) -> Option<&'static str> {
    let says = |words: &[&str]| words.iter().any(|word| error.message.contains(word));
    Some(if error.code == RpcCode::PermissionDenied && security.access().is_none() {
        "the server demands an access token; give the file that holds it by `--token-file`"
    } else if error.code == RpcCode::PermissionDenied {
        "the access token is not the one that the server demands; give the file that holds that by \
         `--token-file`"
    } else if says(&["CertificateRequired"]) {
        "the server demands a certificate of its callers; give one by `--tls-cert` and `--tls-key`"
    } else if says(&["UnknownCA", "DecryptError", "BadCertificate", "CertificateUnknown"]) {
        "the server does not accept the certificate that it was shown; give one that its authority has signed by `--tls-cert` \
         and `--tls-key`"
    } else if error.call == "Describe"
        && error.address.starts_with("https://")
        && error.code == RpcCode::Unavailable
    {
        // Its reason may be lost with the connection.
        if security.shows_certificate() {
            "if the server does not accept the certificate that it was shown, give one that its authority has signed by \
             `--tls-cert` and `--tls-key`"
        } else {
            "if the server demands a certificate of its callers, give one by `--tls-cert` and `--tls-key`"
        }
    } else if says(&["UnknownIssuer", "no authority's certificate"]) {
        "the certificate of the authority that has signed the server's is needed; give it by `--tls-ca`"
    } else {
        return None;
    })
}

/// The command that continues the run in `folder`.
pub(crate) fn resume_command(folder: &Path) -> String {
    format!("{PROGRAM} resume {}", folder.display())
}

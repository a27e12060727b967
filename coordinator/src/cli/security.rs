//! TLS and token options.

use std::path::PathBuf;

use clap::Args;
use proto::transport::security::ClientFiles;

use super::headings::SECURITY;

/// TLS and token settings for remote servers, over the case's `[servers]`.
#[derive(Debug, Args)]
pub(super) struct SecurityArguments {
    /// Authorities' certificates (PEM) that servers at `https://` addresses must be signed by.
    #[arg(long, value_name = "FILE", help_heading = SECURITY, hide_short_help = true)]
    tls_ca: Option<PathBuf>,
    /// Certificate (PEM) to show to servers that demand one.
    #[arg(long, value_name = "FILE", help_heading = SECURITY, hide_short_help = true, requires = "tls_key")]
    tls_cert: Option<PathBuf>,
    /// Private key of that certificate (PEM).
    #[arg(long, value_name = "FILE", help_heading = SECURITY, hide_short_help = true, requires = "tls_cert")]
    tls_key: Option<PathBuf>,
    /// File with the access token of the servers.
    #[arg(long, value_name = "FILE", help_heading = SECURITY, hide_short_help = true)]
    token_file: Option<PathBuf>,
}

impl From<SecurityArguments> for ClientFiles {
    fn from(arguments: SecurityArguments) -> Self {
        Self {
            authority: arguments.tls_ca,
            identity: arguments.tls_cert.zip(arguments.tls_key),
            token: arguments.token_file,
        }
    }
}

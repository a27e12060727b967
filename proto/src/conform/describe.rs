//! What a participant says of itself.

use prost::Message;
use tonic::Code;

use super::bench::{Bench, open_request};
use super::scene::Scene;
use super::{Finding, passed};
use crate::description::PROTOCOL;
use crate::transport::token::Token;
use crate::wire;

/// Number of a field that no message of this package has.
const UNKNOWN_FIELD: u32 = 1000;

pub(super) async fn complete(bench: &Bench) -> Finding {
    let d = &bench.description;
    let [lowest, highest] = d.protocols;
    let limits = &d.limits;
    let wrong: Vec<&str> = [
        (d.name.is_empty(), "the name is empty"),
        (d.version.is_empty(), "the version is empty"),
        (d.language.is_empty(), "the language is empty"),
        (d.arithmetic.is_empty(), "the arithmetic is empty"),
        (d.roles.is_empty(), "no role that this kit knows"),
        (d.dimensions.iter().any(|d| ![2, 3].contains(d)), "dimensions other than 2 and 3"),
        (d.coupling_kinds.is_empty(), "no kind of coupling that this kit knows"),
        (d.interface_laws.is_empty(), "no interface law that this kit knows"),
        (
            lowest.major > PROTOCOL.major || highest.major < PROTOCOL.major,
            "it does not speak the major protocol version of this kit",
        ),
        (lowest > highest, "the lowest protocol version exceeds the highest"),
        (limits.runs == 0, "it takes no run at all"),
        (limits.max_message_bytes < 4 << 20, "messages of 4 MiB are too large for it"),
        (limits.max_frame_bytes < 4 << 20, "frames of 4 MiB are too large for it"),
        (limits.lease.is_zero(), "the lease is zero"),
    ]
    .into_iter()
    .filter_map(|(wrong, text)| wrong.then_some(text))
    .collect();
    if wrong.is_empty() {
        passed(format!("{} {} in {}, protocol {lowest} to {highest}", d.name, d.version, d.language))
    } else {
        Err(wrong.join("; "))
    }
}

pub(super) async fn idempotent(bench: &Bench) -> Finding {
    let (mut client, _) = bench.raw().await?;
    let setup = bench.fit(Scene { coupled: false, ..bench.still() }).setup(bench.role);
    let mut answers = Vec::new();
    for around_run in [false, true, false] {
        let opened = if around_run { Some(bench.open(&setup).await?) } else { None };
        let answer = bench.within("Describe", client.describe(wire::DescribeRequest {})).await?;
        answers.push(answer.map_err(|status| format!("Describe is refused: {status}"))?.encode_to_vec());
        if let Some((mut client, _)) = opened {
            client.close().await.map_err(|e| e.to_string())?;
        }
    }
    if answers.iter().all(|answer| *answer == answers[0]) {
        passed("three answers alike, one during a run")
    } else {
        Err("the answers differ".into())
    }
}

pub(super) async fn versions(bench: &Bench) -> Finding {
    let (mut client, _) = bench.raw().await?;
    let setup = bench.fit(Scene { coupled: false, ..bench.still() }).setup(bench.role);
    let token = Token::fresh()?;
    let of = |major: u32, minor: u32| {
        let mut request = open_request(&setup, &token);
        let known = bench.description.protocols[1];
        request.protocol =
            Some(wire::ProtocolVersion { major: known.major + major, minor: known.minor + minor });
        request
    };
    bench.opens(setup.run_id(), &token);
    match bench.within("Open", client.open(of(1, 0))).await? {
        Err(status) if status.code() == Code::Unimplemented => {}
        Err(status) => return Err(format!("another major version: expected UNIMPLEMENTED, got {status}")),
        Ok(_) => return Err("another major version is accepted".into()),
    }
    match bench.within("Open", client.open(of(0, 1))).await? {
        Ok(_) => passed("the next minor version is welcome, the next major one refused"),
        Err(status) => Err(format!("a later minor version is refused: {status}")),
    }
}

/// A message that any other one can be read as, with an unknown field.
#[derive(Clone, PartialEq, Message)]
struct Extended {
    #[prost(string, tag = "1000")]
    later: String,
}

pub(super) async fn unknown_fields(bench: &Bench) -> Finding {
    let channel = super::connect(&bench.address, bench).await?;
    let mut client = tonic::client::Grpc::new(channel);
    client.ready().await.map_err(|e| e.to_string())?;
    let codec = tonic_prost::ProstCodec::<Extended, wire::Description>::default();
    let path = tonic::codegen::http::uri::PathAndQuery::from_static("/fsi.v2.Participant/Describe");
    let request = tonic::Request::new(Extended { later: "from a later version".into() });
    let answer = bench.within("Describe", client.unary(request, path, codec)).await?;
    match answer {
        Ok(_) => passed(format!("Describe with a field number {UNKNOWN_FIELD}")),
        Err(status) => Err(format!("a message with an unknown field is refused: {status}")),
    }
}

//! Messages as MPI carries them: pieces of less than 1 GiB, since MPI counts in `i32`.
//!
//! MPI keeps the order of messages between two processes: the tag says which channel one is for and whether more of it
//! follows, and no header is needed. Pieces of messages on several channels may alternate.

use fluid::Channel;
use mpi::point_to_point::{Message, Status};
use mpi::traits::*;

/// Largest piece.
pub(super) const PIECE: usize = 1 << 29;

/// Tag of the last pieces of messages on the first channel; those on others follow.
const LAST: i32 = 0;
/// Tag of other pieces, likewise.
const MORE: i32 = 16;
/// No message: the sender takes leave.
pub(super) const BYE: i32 = 32;
/// What is sent with it.
pub(super) const NOTHING: &[u8] = &[];

/// The pieces of `message` on `channel` with their tags; one empty piece for an empty message.
pub(super) fn pieces(channel: Channel, message: &[u8], piece: usize) -> impl Iterator<Item = (i32, &[u8])> {
    // Channels are few.
    let channel = channel.index() as i32;
    let count = message.len().div_ceil(piece).max(1);
    (0..count).map(move |number| {
        let start = number * piece;
        let end = message.len().min(start + piece);
        let tag = if number + 1 == count { LAST } else { MORE };
        (tag + channel, &message[start..end])
    })
}

/// What a piece of a message led to.
#[derive(Debug)]
pub(super) enum Arrival {
    /// A whole message is here.
    Whole(Channel, Vec<u8>),
    /// A piece of a message, more are to come.
    Part,
    /// The sender has taken leave.
    Bye,
}

/// Puts the pieces of each sender on each channel together again.
#[derive(Debug)]
pub(super) struct Assembly {
    begun: Vec<[Option<Vec<u8>>; Channel::ALL.len()]>,
}

impl Assembly {
    pub(super) fn new(size: usize) -> Self {
        Self { begun: vec![Default::default(); size] }
    }

    /// Receives a piece that was matched by a probe; returns it with the number of its sender.
    pub(super) fn take(&mut self, piece: (Message, Status)) -> (usize, Arrival) {
        let tag = piece.1.tag();
        let from = index(piece.1.source_rank());
        if tag >= BYE {
            drop(piece.matched_receive_vec::<u8>());
            return (from, Arrival::Bye);
        }
        // Tags of this program are not negative, and less than those of a leave.
        let channel = Channel::ALL[index(tag % MORE)];
        let begun = &mut self.begun[from][channel.index()];
        let whole = match begun.take() {
            None => piece.matched_receive_vec::<u8>().0,
            Some(mut begun) => {
                let (message, status) = piece;
                let start = begun.len();
                let length = index(status.count(u8::equivalent_datatype()));
                begun.resize(start + length, 0);
                message.matched_receive_into(&mut begun[start..]);
                begun
            }
        };
        if tag >= MORE {
            *begun = Some(whole);
            return (from, Arrival::Part);
        }
        (from, Arrival::Whole(channel, whole))
    }
}

/// A rank or count of MPI as an index; MPI gives no negative ones here.
pub(super) fn index(number: i32) -> usize {
    usize::try_from(number).unwrap_or(usize::MAX)
}

/// An index as a rank of MPI; callers check that it is less than the number of parts, which MPI
/// gave as an `i32`.
pub(super) fn rank(index: usize) -> i32 {
    i32::try_from(index).unwrap_or(i32::MAX)
}

#[cfg(test)]
mod tests {
    use fluid::Channel;

    use super::{LAST, MORE, pieces};

    #[test]
    fn messages_are_cut_into_pieces_the_last_of_which_is_marked() {
        let all = |length: usize| -> Vec<(i32, usize)> {
            let message = vec![0; length];
            let pieces = pieces(Channel::Copies, &message, 4);
            pieces.map(|(tag, bytes)| (tag - Channel::Copies.index() as i32, bytes.len())).collect()
        };
        assert_eq!(all(0), [(LAST, 0)]);
        assert_eq!(all(4), [(LAST, 4)]);
        assert_eq!(all(5), [(MORE, 4), (LAST, 1)]);
        assert_eq!(all(8), [(MORE, 4), (LAST, 4)]);
    }
}

//! Messages as MPI carries them: pieces of less than 1 GiB, since MPI counts in `i32`.
//!
//! MPI keeps the order of all messages between two processes, whatever their tags: the tag says whether more of a message
//! follows, and no header is needed.

use mpi::point_to_point::{Message, Status};
use mpi::traits::*;

/// Largest piece.
pub(super) const PIECE: usize = 1 << 29;

/// The message ends with this piece.
pub(super) const LAST: i32 = 0;
/// More of the message follows.
pub(super) const MORE: i32 = 1;
/// No message: the sender takes leave.
pub(super) const BYE: i32 = 2;
/// What is sent with it.
pub(super) const NOTHING: &[u8] = &[];

/// The pieces of `message` with their tags; one empty piece for an empty message.
pub(super) fn pieces(message: &[u8], piece: usize) -> impl Iterator<Item = (i32, &[u8])> {
    let count = message.len().div_ceil(piece).max(1);
    (0..count).map(move |number| {
        let start = number * piece;
        let end = message.len().min(start + piece);
        let tag = if number + 1 == count { LAST } else { MORE };
        (tag, &message[start..end])
    })
}

/// What a piece of a message led to.
#[derive(Debug)]
pub(super) enum Arrival {
    /// A whole message is here.
    Whole(Vec<u8>),
    /// A piece of a message, more are to come.
    Part,
    /// The sender has taken leave.
    Bye,
}

/// Puts the pieces of each sender together again.
#[derive(Debug)]
pub(super) struct Assembly {
    begun: Vec<Option<Vec<u8>>>,
}

impl Assembly {
    pub(super) fn new(size: usize) -> Self {
        Self { begun: vec![None; size] }
    }

    /// Receives a piece that was matched by a probe; returns it with the number of its sender.
    pub(super) fn take(&mut self, piece: (Message, Status)) -> (usize, Arrival) {
        let tag = piece.1.tag();
        let from = index(piece.1.source_rank());
        let whole = match self.begun[from].take() {
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
        let arrival = match tag {
            LAST => Arrival::Whole(whole),
            MORE => {
                self.begun[from] = Some(whole);
                Arrival::Part
            }
            _ => Arrival::Bye,
        };
        (from, arrival)
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
    use super::{LAST, MORE, pieces};

    #[test]
    fn messages_are_cut_into_pieces_the_last_of_which_is_marked() {
        let all = |length: usize| -> Vec<(i32, usize)> {
            pieces(&vec![0; length], 4).map(|(tag, bytes)| (tag, bytes.len())).collect()
        };
        assert_eq!(all(0), [(LAST, 0)]);
        assert_eq!(all(4), [(LAST, 4)]);
        assert_eq!(all(5), [(MORE, 4), (LAST, 1)]);
        assert_eq!(all(8), [(MORE, 4), (LAST, 4)]);
    }
}

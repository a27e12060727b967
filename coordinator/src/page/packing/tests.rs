//! Frames packed and read back, as the page reads them.

use std::io::Read;

use flate2::read::ZlibDecoder;

use super::*;

/// A reader written from the description of the format alone.
struct Reader {
    columns: Vec<Column>,
    slots: Vec<Slot>,
    codes: Option<Vec<Vec<u16>>>,
}

impl Reader {
    fn read(&mut self, packed: &[u8], n: usize) -> Vec<Vec<f64>> {
        let mut raw = Vec::new();
        ZlibDecoder::new(packed).read_to_end(&mut raw).unwrap();
        let mut at = 0;
        let mut take = |bytes: usize| -> Vec<u32> {
            let numbers = (0..n).map(|i| (0..bytes).map(|b| u32::from(raw[at + b * n + i]) << (8 * b)).sum());
            let numbers = numbers.collect();
            at += bytes * n;
            numbers
        };
        if self.codes.is_none() {
            let sums = |list: Vec<u32>| -> Vec<u32> {
                list.iter()
                    .scan(0u32, |sum, d| {
                        *sum = sum.wrapping_add(*d);
                        Some(*sum)
                    })
                    .collect()
            };
            let (groups, ids) = (sums(take(2)), sums(take(4)));
            self.slots =
                groups.iter().zip(ids).map(|(group, id)| Slot { group: *group as u16, id }).collect();
        }
        let mut all = Vec::new();
        for (c, column) in self.columns.iter().enumerate() {
            let modulus = 1u32 << column.bits;
            let mut codes: Vec<u16> = Vec::new();
            for (i, folded) in take(column.bits as usize / 8).into_iter().enumerate() {
                let difference = if folded % 2 == 0 { folded / 2 } else { modulus - folded / 2 - 1 };
                let reference = match &self.codes {
                    Some(before) => before[c][i],
                    None => {
                        if i > 0 {
                            codes[i - 1]
                        } else {
                            0
                        }
                    }
                };
                codes.push(((u32::from(reference) + difference) % modulus) as u16);
            }
            all.push(codes);
        }
        assert_eq!(at, raw.len(), "nothing is left over");
        let values = |(column, codes): (&Column, &Vec<u16>)| codes.iter().map(|c| column.value(*c)).collect();
        let values = self.columns.iter().zip(&all).map(values).collect();
        self.codes = Some(all);
        values
    }
}

/// A cloud that moves, in which particle 40 leaves after the first frame.
fn cloud(frame: u32) -> Particles {
    let mut particles = Particles { time: f64::from(frame), ..Particles::default() };
    for id in (0..300u32).filter(|id| *id != 40 || frame == 0) {
        particles.slots.push(Slot { group: u16::from(id >= 200), id: 7 * id });
        let x = (id as f32 * 0.37).sin() + 0.01 * frame as f32;
        let values = [x, -x, 0.0, 1000.0 * x, x.abs(), 1000.0 + x, if id < 200 { f32::NAN } else { 5e6 * x }];
        for (column, value) in particles.columns.iter_mut().zip(values) {
            column.push(value);
        }
    }
    particles
}

#[test]
fn every_value_comes_back_within_half_a_quantum() {
    let frames: Vec<Particles> = (0..4).map(cloud).collect();
    for (bits, in_space) in [(8, false), (16, false), (16, true)] {
        let columns = columns(frames.iter(), in_space, bits);
        let mut packer = Packer::new(columns.clone(), frames[0].slots.clone(), Compression::default());
        let mut reader = Reader { columns: columns.clone(), slots: Vec::new(), codes: None };
        for frame in &frames {
            let read = reader.read(&packer.pack(frame).unwrap(), 300);
            assert_eq!(reader.slots, frames[0].slots);
            for (column, values) in columns.iter().zip(read) {
                for (slot, value) in reader.slots.iter().zip(values) {
                    let place = frame.slots.iter().position(|other| other == slot);
                    let packed = place.map_or(f64::NAN, |i| f64::from(frame.columns[index(column.name)][i]));
                    // Half a quantum, and the round-off of its arithmetic.
                    let allowed = 0.5 * column.quantum() * (1.0 + 1e-9);
                    let near = (packed - value).abs() <= allowed || (packed.is_nan() && value.is_nan());
                    assert!(near, "{} of {slot:?}: {packed} became {value}", column.name);
                }
            }
        }
    }
}

#[test]
fn frames_that_repeat_cost_next_to_nothing() {
    let frame = cloud(0);
    let columns = columns([&frame].into_iter(), false, 16);
    let mut packer = Packer::new(columns, frame.slots.clone(), Compression::default());
    let first = packer.pack(&frame).unwrap().len();
    let second = packer.pack(&frame).unwrap().len();
    assert!(second * 30 < first, "{first} and {second} bytes");
}

#[test]
fn a_constant_column_has_a_range() {
    let mut frame = cloud(0);
    frame.columns[3].fill(0.0);
    frame.columns[6].fill(f32::NAN);
    let columns = columns([&frame].into_iter(), false, 8);
    assert!(columns.iter().all(|c| c.upper > c.lower && c.name != "von_mises"), "{columns:?}");
}

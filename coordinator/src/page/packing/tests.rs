//! Frames packed and read back, as the page reads them.

use std::io::Read;

use flate2::read::ZlibDecoder;

use super::*;

/// A reader written from the description of the format alone.
#[derive(Default)]
struct Reader {
    columns: Vec<Column>,
    slots: Vec<Slot>,
    /// Of all frames so far.
    codes: Vec<Vec<Vec<u16>>>,
    /// Forecasts of the columns of the last frame.
    names: Vec<u8>,
}

impl Reader {
    fn read(&mut self, packed: &[u8], n: usize) -> Vec<Vec<f64>> {
        let mut raw = Vec::new();
        ZlibDecoder::new(packed).read_to_end(&mut raw).unwrap();
        let mut at = 0;
        let take = |raw: &[u8], at: &mut usize, bytes: usize| -> Vec<u32> {
            let numbers =
                (0..n).map(|i| (0..bytes).map(|b| u32::from(raw[*at + b * n + i]) << (8 * b)).sum());
            let numbers = numbers.collect();
            *at += bytes * n;
            numbers
        };
        if self.codes.is_empty() {
            let sums = |list: Vec<u32>| -> Vec<u32> {
                list.iter()
                    .scan(0u32, |sum, d| {
                        *sum = sum.wrapping_add(*d);
                        Some(*sum)
                    })
                    .collect()
            };
            let (groups, ids) = (sums(take(&raw, &mut at, 2)), sums(take(&raw, &mut at, 4)));
            self.slots =
                groups.iter().zip(ids).map(|(group, id)| Slot { group: *group as u16, id }).collect();
        }
        self.names.clear();
        let mut all = Vec::new();
        for (c, column) in self.columns.iter().enumerate() {
            let modulus = 1i64 << column.bits;
            let name = raw[at];
            at += 1;
            self.names.push(name);
            let frame = |back: usize, i: Option<usize>| -> i64 {
                i.map_or(0, |i| i64::from(self.codes[self.codes.len() - back][c][i]))
            };
            let mut codes: Vec<u16> = Vec::new();
            for (i, folded) in take(&raw, &mut at, column.bits as usize / 8).into_iter().enumerate() {
                let folded = i64::from(folded);
                let difference = if folded % 2 == 0 { folded / 2 } else { -(folded + 1) / 2 };
                let left = i.checked_sub(1);
                let beside = left.map_or(0, |k| i64::from(codes[k]));
                let i = Some(i);
                let forecast = match name {
                    0 => beside,
                    1 => frame(1, i),
                    2 => frame(1, i) + beside - frame(1, left),
                    3 => 2 * frame(1, i) - frame(2, i),
                    4 => 2 * frame(1, i) - frame(2, i) + beside - 2 * frame(1, left) + frame(2, left),
                    _ => panic!("forecast {name}"),
                };
                codes.push((forecast + difference).rem_euclid(modulus) as u16);
            }
            all.push(codes);
        }
        assert_eq!(at, raw.len(), "nothing is left over");
        let values = |(column, codes): (&Column, &Vec<u16>)| codes.iter().map(|c| column.value(*c)).collect();
        let values = self.columns.iter().zip(&all).map(values).collect();
        self.codes.push(all);
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
        let mut reader = Reader { columns: columns.clone(), ..Reader::default() };
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
fn every_forecast_is_taken_where_it_fits() {
    // Values of the columns x, y, pressure, speed and density at particle i and time t; between particles, noise.
    let noise = |i: u32| f64::from(i.wrapping_mul(2_654_435_761) >> 20);
    let motion: [fn(f64, f64) -> f64; 5] = [
        |noise, _| noise,
        |noise, t| noise + 40.0 * t,
        |noise, t| noise + noise * t,
        |noise, t| noise + noise * t + 300.0 * t * t,
        |_, _| 0.0,
    ];
    let frame = |t: u32| {
        let mut particles = Particles { time: f64::from(t), ..Particles::default() };
        for id in 0..500u32 {
            particles.slots.push(Slot { group: 0, id });
            for (column, motion) in [0, 1, 3, 4, 5].into_iter().zip(motion) {
                particles.columns[column].push(motion(noise(id), f64::from(t)) as f32);
            }
            for unused in [2, 6] {
                particles.columns[unused].push(f32::NAN);
            }
        }
        particles
    };
    let frames: Vec<Particles> = (0..4).map(frame).collect();
    let columns = columns(frames.iter(), false, 16);
    let mut packer = Packer::new(columns.clone(), frames[0].slots.clone(), Compression::default());
    let mut reader = Reader { columns: columns.clone(), ..Reader::default() };
    let mut names = Vec::new();
    for frame in &frames {
        let read = reader.read(&packer.pack(frame).unwrap(), 500);
        names.push(reader.names.clone());
        for (column, values) in columns.iter().zip(read) {
            for (packed, value) in frame.columns[index(column.name)].iter().zip(values) {
                let allowed = 0.5 * column.quantum() * (1.0 + 1e-9);
                assert!((f64::from(*packed) - value).abs() <= allowed, "{}", column.name);
            }
        }
    }
    assert_eq!(names, [[0; 5], [1, 2, 1, 1, 1], [1, 2, 3, 4, 1], [1, 2, 3, 4, 1]]);
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

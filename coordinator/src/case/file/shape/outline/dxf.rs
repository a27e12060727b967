//! The entities of a DXF drawing that make outlines.
//!
//! A DXF file in words is a list of pairs of lines, a group code and a value. The one crate that reads such files takes
//! some twenty others along and panics on files that are not as it expects, so that the few entities are read here.

use super::curves::Curve;

/// An entity of a drawing, in units of the drawing.
#[derive(Clone, Debug, PartialEq)]
pub struct Entity {
    /// Its layer.
    pub layer: String,
    /// Line of the file on which it starts, from 1.
    pub line: usize,
    /// What it is, or why it cannot be part of an outline.
    pub curve: Result<Curve, String>,
}

/// A group code with its value.
#[derive(Clone, Copy)]
struct Pair<'a> {
    code: i32,
    value: &'a str,
    line: usize,
}

/// Entities that write or measure, and are no part of a shape.
const NOTES: [&str; 12] = [
    "TEXT",
    "MTEXT",
    "ATTDEF",
    "DIMENSION",
    "ARC_DIMENSION",
    "LEADER",
    "MULTILEADER",
    "TOLERANCE",
    "POINT",
    "VIEWPORT",
    "HATCH",
    "IMAGE",
];

/// First bytes of a drawing that is not in words.
const BINARY: &[u8] = b"AutoCAD Binary DXF";

/// The entities of the model that are visible and no notes.
///
/// # Errors
/// What is wrong with the file, with the line.
pub fn read(bytes: &[u8]) -> Result<Vec<Entity>, String> {
    if bytes.starts_with(BINARY) {
        return Err("is a binary DXF file; save the drawing as ASCII DXF".into());
    }
    // Names may have the letters of an old code page; numbers do not.
    let text = String::from_utf8_lossy(bytes);
    let mut lines = text.lines().enumerate();
    let mut pairs = Vec::new();
    while let Some((index, code)) = lines.next() {
        let line = index + 1;
        let code = match code.trim().parse() {
            Ok(code) => code,
            Err(_) if code.trim().is_empty() && lines.next().is_none() => break,
            Err(_) => {
                return Err(format!("line {line}: no group code, a whole number, where a DXF file has one"));
            }
        };
        let (_, value) = lines.next().ok_or_else(|| format!("line {line}: ends after a group code"))?;
        pairs.push(Pair { code, value: value.trim(), line });
    }
    let is = |pair: &Pair<'_>, word: &str| pair.code == 0 && pair.value == word;
    let start = pairs
        .windows(2)
        .position(|two| is(&two[0], "SECTION") && two[1].code == 2 && two[1].value == "ENTITIES")
        .ok_or("has no section ENTITIES: it is no DXF drawing")?;
    let body = &pairs[start + 2..];
    let end = body.iter().position(|pair| is(pair, "ENDSEC")).ok_or("ends within its entities")?;
    let mut groups = body[..end].chunk_by(|_, next| next.code != 0).peekable();
    let mut found = Vec::new();
    while let Some(group) = groups.next() {
        let mut parts = Vec::new();
        while matches!(group[0].value, "POLYLINE" | "INSERT")
            && groups.peek().is_some_and(|next| matches!(next[0].value, "VERTEX" | "ATTRIB" | "SEQEND"))
        {
            parts.extend(groups.next());
        }
        found.extend(entity(group, &parts)?);
    }
    Ok(found)
}

/// The entity of the pairs `group` with the entities that belong to it; none for notes and what is not shown.
fn entity(group: &[Pair<'_>], parts: &[&[Pair<'_>]]) -> Result<Option<Entity>, String> {
    let (kind, line) = (group[0].value, group[0].line);
    let group = Group(group);
    let (on_paper, hidden) = (group.whole(67)? == 1, group.whole(60)? == 1);
    if group.0[0].code != 0 || on_paper || hidden || NOTES.contains(&kind) {
        return Ok(None);
    }
    let layer = group.text(8).unwrap_or("0").to_owned();
    let curve = match (kind, facing(&group)?) {
        ("LINE", _) => Ok(Curve::line(group.point(10)?, group.point(11)?)),
        (_, None) => Err("does not lie in the plane of the drawing".into()),
        ("CIRCLE", Some(facing)) => Ok(Curve::circle(mirrored(group.point(10)?, facing), group.number(40)?)),
        ("ARC", Some(facing)) => {
            let (from, to) = (group.number(50)?.to_radians(), group.number(51)?.to_radians());
            Ok(Curve::arc(group.point(10)?, group.number(40)?, from, to).facing(facing))
        }
        ("ELLIPSE", Some(facing)) => {
            let span = [group.number_or(41, 0.0)?, group.number_or(42, std::f64::consts::TAU)?];
            Ok(Curve::ellipse(group.point(10)?, group.point(11)?, facing * group.number(40)?, span))
        }
        ("SPLINE", Some(_)) => spline(&group)?,
        ("LWPOLYLINE", Some(facing)) => {
            Ok(Curve::polyline(&group.corners()?, group.whole(70)? & 1 == 1).facing(facing))
        }
        ("POLYLINE", Some(facing)) => polyline(&group, parts, facing)?,
        ("INSERT", _) => Err("is an inserted block: explode blocks before the drawing is saved".into()),
        (kind, _) => {
            Err(format!("{kind} is not read: draw it with lines, arcs, ellipses, splines or polylines"))
        }
    };
    Ok(Some(Entity { layer, line, curve }))
}

/// 1 where the entity is seen from above, -1 from below; none where it is tilted.
fn facing(group: &Group<'_>) -> Result<Option<f64>, String> {
    let normal = [group.number_or(210, 0.0)?, group.number_or(220, 0.0)?, group.number_or(230, 1.0)?];
    let flat = normal[0].abs().max(normal[1].abs()) <= 1e-9 * normal[2].abs();
    Ok((flat && normal[2] != 0.0).then(|| normal[2].signum()))
}

/// A point of coordinates that are seen from below when `facing` is -1.
fn mirrored([x, y]: [f64; 2], facing: f64) -> [f64; 2] {
    [facing * x, y]
}

fn spline(group: &Group<'_>) -> Result<Result<Curve, String>, String> {
    let poles = group.points(10, 20)?;
    if poles.is_empty() {
        return Ok(Err(
            "is a spline without control points: convert it into one with them, or into a polyline".into(),
        ));
    }
    let (knots, weights) = (group.numbers(40)?, group.numbers(41)?);
    let degree = usize::try_from(group.whole(71)?).unwrap_or(0);
    Ok(Curve::spline(degree, knots, poles, weights))
}

fn polyline(group: &Group<'_>, parts: &[&[Pair<'_>]], facing: f64) -> Result<Result<Curve, String>, String> {
    const MESH: i64 = 16 + 64;
    /// Corners of the frame of a smoothed polyline, which its smoothed corners follow.
    const FRAME: i64 = 16;
    let flags = group.whole(70)?;
    if flags & MESH != 0 {
        return Ok(Err("is a mesh, not a line".into()));
    }
    let mut corners = Vec::new();
    for part in parts.iter().filter(|part| part[0].value == "VERTEX").map(|part| Group(part)) {
        if part.whole(70)? & FRAME == 0 {
            corners.push((part.point(10)?, part.number_or(42, 0.0)?));
        }
    }
    Ok(Ok(Curve::polyline(&corners, flags & 1 == 1).facing(facing)))
}

/// The pairs of one entity.
struct Group<'a>(&'a [Pair<'a>]);

impl Group<'_> {
    fn text(&self, code: i32) -> Option<&str> {
        self.0[1..].iter().find(|pair| pair.code == code).map(|pair| pair.value)
    }

    /// A whole number, 0 where it is left out.
    fn whole(&self, code: i32) -> Result<i64, String> {
        Ok(self.number_or(code, 0.0)? as i64)
    }

    fn number(&self, code: i32) -> Result<f64, String> {
        let pair = &self.0[0];
        self.numbers(code)?
            .first()
            .copied()
            .ok_or_else(|| format!("line {}: {} has no group {code}", pair.line, pair.value))
    }

    fn number_or(&self, code: i32, default: f64) -> Result<f64, String> {
        Ok(self.numbers(code)?.first().copied().unwrap_or(default))
    }

    /// All values of a group code.
    fn numbers(&self, code: i32) -> Result<Vec<f64>, String> {
        self.0[1..].iter().filter(|pair| pair.code == code).map(value).collect()
    }

    /// The point of x under `code` and y under the code 10 above.
    fn point(&self, code: i32) -> Result<[f64; 2], String> {
        Ok([self.number(code)?, self.number(code + 10)?])
    }

    /// All points, whose y follow their x.
    fn points(&self, x: i32, y: i32) -> Result<Vec<[f64; 2]>, String> {
        let (xs, ys) = (self.numbers(x)?, self.numbers(y)?);
        if xs.len() != ys.len() {
            return Err(format!("line {}: {} x of points, {} y", self.0[0].line, xs.len(), ys.len()));
        }
        Ok(xs.into_iter().zip(ys).map(|(x, y)| [x, y]).collect())
    }

    /// Corners of a light polyline with the bulges behind them.
    fn corners(&self) -> Result<Vec<([f64; 2], f64)>, String> {
        let mut corners: Vec<_> = self.points(10, 20)?.into_iter().map(|point| (point, 0.0)).collect();
        let mut at = 0;
        for pair in &self.0[1..] {
            match pair.code {
                10 => at += 1,
                42 if at > 0 => corners[at - 1].1 = value(pair)?,
                _ => {}
            }
        }
        Ok(corners)
    }
}

/// The number of a pair.
fn value(pair: &Pair<'_>) -> Result<f64, String> {
    let number = pair.value.parse().ok().filter(|number: &f64| number.is_finite());
    number.ok_or_else(|| format!("line {}: no finite number in group {}", pair.line + 1, pair.code))
}

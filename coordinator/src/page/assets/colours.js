// Colours and numbers.

/** Viridis (Smith & van der Walt 2015) and cool-warm (Moreland 2009) at equal distances. */
const MAPS = {
  viridis: [[68, 1, 84], [72, 24, 106], [71, 45, 123], [66, 64, 134], [59, 82, 139], [51, 99, 141], [44, 114, 142], [38, 130, 142],
    [31, 148, 139], [31, 160, 136], [40, 174, 128], [63, 188, 115], [94, 201, 98], [132, 212, 75], [173, 220, 48], [216, 226, 25],
    [253, 231, 37]],
  coolwarm: [[59, 76, 192], [78, 104, 216], [98, 130, 234], [119, 154, 247], [141, 176, 254], [163, 194, 254], [185, 208, 249],
    [204, 217, 237], [221, 220, 220], [236, 211, 197], [245, 196, 172], [247, 176, 147], [244, 152, 122], [235, 125, 98], [221, 95, 75],
    [202, 59, 55], [180, 4, 38]],
  inferno: [[24, 12, 60], [49, 10, 92], [75, 12, 107], [99, 21, 110], [122, 29, 109], [146, 38, 103], [169, 46, 94], [191, 57, 80],
    [210, 70, 66], [227, 87, 48], [240, 108, 29], [248, 132, 13], [252, 156, 8], [251, 182, 27], [246, 208, 61], [243, 231, 104],
    [252, 255, 164]],
};
const PLAIN = { fluid: [66, 146, 198], solid: [214, 112, 48], wall: [150, 155, 160] };
const INVALID = [255, 0, 200];
/** Okabe & Ito (2008), the blue lighter, so that it is seen on dark pages too. */
const LINE_COLOURS = ["#2684c8", "#d55e00", "#009e73", "#cc79a7", "#b07900", "#56b4e9", "#808080", "#8a63d2"];

/** A map as 256 colours. */
function table(name) {
  const stops = MAPS[name];
  const colours = new Uint8Array(256 * 3);
  for (let k = 0; k < 256; k++) {
    const x = (k / 255) * (stops.length - 1);
    const j = Math.min(Math.floor(x), stops.length - 2);
    for (let c = 0; c < 3; c++) colours[3 * k + c] = Math.round(stops[j][c] + (x - j) * (stops[j + 1][c] - stops[j][c]));
  }
  return colours;
}
const TABLES = Object.fromEntries(Object.keys(MAPS).map((name) => [name, table(name)]));

/** The map of a scale: two hues where zero is in its middle, and another one for solids, so that matter stays apart. */
const mapOf = (scale) => (scale.signed ? "coolwarm" : scale.matter === "solid" ? "inferno" : "viridis");

const css = (rgb) => `rgb(${rgb[0]}, ${rgb[1]}, ${rgb[2]})`;

/** Colour bar as a CSS gradient. */
const gradient = (name) => `linear-gradient(to right, ${MAPS[name].map(css).join(", ")})`;

const SUPERSCRIPTS = { "-": "⁻", 0: "⁰", 1: "¹", 2: "²", 3: "³", 4: "⁴", 5: "⁵", 6: "⁶", 7: "⁷", 8: "⁸", 9: "⁹" };
const superscript = (n) => [...String(n)].map((c) => SUPERSCRIPTS[c]).join("");

/** The power of ten, and the prefix of the unit, by which numbers of this size are written. */
function magnitude(largest, unit) {
  if (!(largest > 0) || !Number.isFinite(largest)) return { divisor: 1, unit };
  const decade = Math.floor(Math.log10(largest) + 1e-12);
  const third = Math.floor(decade / 3);
  const short = unit === "m" || unit === "s";
  const prefixed = short || /^(Pa|N|J|W)/.test(unit);
  const prefix = { 3: "G", 2: "M", 1: "k", "-1": "m", "-2": "µ", "-3": "n" }[third];
  if (third === 0 || (short && third > 0) || (unit === "m" && decade === -1) || (unit === "s" && third === -1) || (!prefixed && decade >= -3 && decade < 5)) return { divisor: 1, unit };
  if (prefixed && prefix) return { divisor: 10 ** (3 * third), unit: prefix + unit };
  return { divisor: 10 ** decade, unit: `·10${superscript(decade)}${unit ? " " + unit : ""}` };
}

/** A number as a person writes it. */
function plain(value, unit = "") {
  if (value === 0) return unit ? `0 ${unit}` : "0";
  if (!Number.isFinite(value)) return "no value";
  const { divisor, unit: shown } = magnitude(Math.abs(value), unit);
  const scaled = value / divisor;
  const decimals = Math.max(0, 3 - Math.floor(Math.log10(Math.abs(scaled))));
  let text = scaled.toFixed(Math.min(decimals, 8));
  if (text.includes(".")) text = text.replace(/\.?0+$/, "");
  const gap = shown && !shown.startsWith("·") ? "\u00a0" : "";
  return text.replace("-", "−") + gap + shown;
}

/** Round numbers within a range, and how many decimals tell them apart. */
function ticks(lower, upper, wanted) {
  const span = upper - lower;
  if (!(span > 0) || !Number.isFinite(span)) return { marks: [], decimals: 0 };
  const raw = span / wanted;
  const decade = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((f) => f * decade).find((s) => s >= raw * 0.999);
  const marks = [];
  for (let k = Math.ceil(lower / step - 1e-3); k * step <= upper + 1e-3 * step; k++) marks.push(k * step);
  return { marks, decimals: Math.max(0, Math.ceil(-Math.log10(step) - 1e-9)) };
}

const fixed = (value, decimals) => (Math.abs(value) < 0.5 * 10 ** -decimals ? 0 : value).toFixed(decimals).replace("-", "−");
/** Seconds with four decimals at most. */
const seconds = (t) => `${t.toFixed(4)}\u00a0s`;

/** An element with attributes and children; `on…` are listeners. */
function element(tag, attributes = {}, ...children) {
  const isSvg = ["svg", "path", "line", "text", "circle", "g", "rect", "title"].includes(tag);
  const node = isSvg ? document.createElementNS("http://www.w3.org/2000/svg", tag) : document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
    else if (value !== null && value !== undefined && value !== false) node.setAttribute(name, value === true ? "" : value);
  }
  node.append(...children.flat().filter((child) => child !== null && child !== undefined));
  return node;
}

// Colours of workers, and of values: the same in tables, outlines and maps.
"use strict";

/// A hue for a name: the same on every page, and far apart for names that differ little (FNV-1a).
function hueOf(name) {
  let hash = 2166136261;
  for (let i = 0; i < name.length; ++i) hash = Math.imul(hash ^ name.charCodeAt(i), 16777619);
  return ((hash >>> 0) * 0.6180339887) % 1 * 360;
}

/// IEEE 754 binary16 to a number.
function fromHalf(bits) {
  const sign = bits & 0x8000 ? -1 : 1, exponent = bits >> 10 & 31, mantissa = bits & 1023;
  if (exponent === 0) return sign * mantissa * 2 ** -24;
  if (exponent === 31) return mantissa ? NaN : sign * Infinity;
  return sign * (1 + mantissa / 1024) * 2 ** (exponent - 15);
}

function digits(value) {
  if (!Number.isFinite(value)) return "-";
  const size = Math.abs(value);
  return size !== 0 && (size < 0.001 || size >= 1e6) ? value.toExponential(2) : value.toPrecision(4);
}

function duration(seconds) {
  if (!(seconds >= 0)) return "";
  seconds = Math.round(seconds);
  const whole = (unit) => Math.floor(seconds / unit);
  const parts = [whole(86400), whole(3600) % 24, whole(60) % 60, seconds % 60];
  if (parts[0]) return parts[0] + " d " + parts[1] + " h";
  if (parts[1]) return parts[1] + " h " + String(parts[2]).padStart(2, "0") + " min";
  if (parts[2]) return parts[2] + " min " + String(parts[3]).padStart(2, "0") + " s";
  return parts[3] + " s";
}

function coreHours(seconds) {
  return seconds < 3600 ? (seconds / 3600).toFixed(3) : (seconds / 3600).toFixed(1);
}

#include "render/sensor/shutter.h"

#include "render/core/wide_memory.h"
#include "render/sensor/shutter_table.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// The last knot, but for the very last, whose `member` is at most `value`; else the first.
Int knot_before(const ShutterTable& shutter, float ShutterTable::Knot::*member, Float value) {
  const auto last = static_cast<std::int32_t>(shutter.knots.size()) - 2;
  Int low(0), high(last);
  for (std::int32_t left = last; left > 0; left /= 2) {
    const Int middle = shift_right<1>(low + high + 1);
    const Mask up = gather_member(shutter.knots.data(), member, middle, Mask::all()) <= value;
    low = select(up, middle, low);
    high = select(up, high, max(middle - 1, low));
  }
  return low;
}

/// A straight piece of the curve, from its beginning on.
struct Piece {
  Float time, length, open, slope, cdf;
};
Piece piece_at(const ShutterTable& shutter, Int knot) {
  using Knot = ShutterTable::Knot;
  const auto of = [&](float Knot::*member, Int at) {
    return gather_member(shutter.knots.data(), member, at, Mask::all());
  };
  Piece piece{of(&Knot::time, knot), of(&Knot::time, knot + Int(1)), of(&Knot::openness, knot),
              of(&Knot::openness, knot + Int(1)), of(&Knot::cdf, knot)};
  piece.length = piece.length - piece.time;
  piece.slope = (piece.slope - piece.open) / piece.length;
  return piece;
}

/// The inverse of the integral of the openness.
Float inverse_cdf(const ShutterTable& shutter, Float u) {
  if (shutter.knots.empty()) return u;
  const Piece piece = piece_at(shutter, knot_before(shutter, &ShutterTable::Knot::cdf, u));
  // open x + slope x^2 / 2 = rest, without cancellation where the slope is small.
  const Float rest = max(u - piece.cdf, 0.0f);
  const Float root = safe_sqrt(fma(piece.open, piece.open, 2.0f * piece.slope * rest));
  const Float x = 2.0f * rest / max(piece.open + root, 1e-30f);
  return piece.time + min(x, piece.length);
}

/// 0 outside of [0, 1].
Float openness_at(const ShutterTable& shutter, Float time) {
  const Mask inside = (time >= 0.0f) & (time <= 1.0f);
  if (shutter.knots.empty()) return select_or_zero(inside, Float(1.0f));
  const Piece piece = piece_at(shutter, knot_before(shutter, &ShutterTable::Knot::time, time));
  return select_or_zero(inside, max(fma(time - piece.time, piece.slope, piece.open), 0.0f));
}

Float mirrored(Float place, float size) {
  const Float within = abs(place);
  return select(within > size, 2.0f * size - within, within);
}

/// The coordinate along which rows follow each other, of the place within the raster that sees the same.
Float across_rows(const SensorRecord& sensor, bool across, Vec2 raster) {
  const RasterEdges edges = edges_of(sensor);
  const auto width = static_cast<float>(sensor.width), height = static_cast<float>(sensor.height);
  if (!across) {
    const bool open = edges == RasterEdges::kOpen || edges == RasterEdges::kRound;
    return open ? raster.y : mirrored(raster.y, height);
  }
  if (edges == RasterEdges::kOpen) return raster.x;
  if (edges == RasterEdges::kMirrored) return mirrored(raster.x, width);
  Float x = raster.x;
  if (edges == RasterEdges::kOverPole) {
    // Over a pole, the meridian is the opposite one.
    const Mask beyond = (raster.y < 0.0f) | (raster.y > height);
    x = select(beyond, x + width / 2, x);
  }
  x = select(x < 0.0f, x + width, x);
  return select(x >= width, x - width, x);
}

/// When the row of this place begins to be exposed.
Float begin_of_row(const SensorRecord& sensor, const ShutterTable& shutter, Vec2 raster) {
  const auto last = static_cast<float>(shutter.rows - 1);
  const Float place = min(max(across_rows(sensor, shutter.across, raster), 0.0f), last);
  const Float row = to_float(to_int(place));
  const float delay = last > 0 ? (1 - shutter.duration) / last : 0;
  return (shutter.from_last ? last - row : row) * delay;
}

}  // namespace

Float time_at(const SensorRecord& sensor, Vec2 raster, Float u) {
  if (sensor.shutter == nullptr) return u;
  const ShutterTable& shutter = *sensor.shutter;
  const Float time = inverse_cdf(shutter, u);
  if (shutter.rows == 0) return time;
  return min(fma(time, Float(shutter.duration), begin_of_row(sensor, shutter, raster)), 1.0f);
}

Float time_of_light(const SensorRecord& sensor, Float u) {
  const bool warped = sensor.shutter != nullptr && sensor.shutter->rows == 0;
  return warped ? inverse_cdf(*sensor.shutter, u) : u;
}

Float exposure_at(const SensorRecord& sensor, Vec2 raster, Float time) {
  if (sensor.shutter == nullptr || sensor.shutter->rows == 0) return Float(1.0f);
  const ShutterTable& shutter = *sensor.shutter;
  const Float since = time - begin_of_row(sensor, shutter, raster);
  return openness_at(shutter, since / shutter.duration) / shutter.duration;
}

Exposure exposure_of_groups(const SensorRecord& sensor, Vec2 raster, Float u, int group) {
  if (sensor.shutter == nullptr || sensor.shutter->rows == 0 || group == 1)
    return {time_at(sensor, raster, u), Float(1.0f)};
  // The number picks a member of the group, whose row counts.
  const auto count = static_cast<float>(group);
  const Int member = min(to_int(u * count), Int(group - 1)), first = Int::iota(0) & Int(-group);
  alignas(64) float x[kWidth], y[kWidth];
  raster.x.store(x), raster.y.store(y);
  const auto place_of = [&](Int lane) { return Vec2{gather(x, lane), gather(y, lane)}; };
  const Float rest = min(fma(u, Float(count), -to_float(member)), 0x1.fffffep-1f);
  const Float time = time_at(sensor, place_of(first + member), rest);
  Float sum(0.0f);
  for (int i = 0; i < group; ++i) sum = sum + exposure_at(sensor, place_of(first + Int(i)), time);
  return {time, count * exposure_at(sensor, raster, time) / max(sum, 1e-30f)};
}

}  // namespace tessera::render::TESSERA_ISA

#include "import/geometry/motion_keys.h"

#include <ImathMatrixAlgo.h>
#include <ImathQuat.h>

#include <algorithm>
#include <cmath>

namespace tessera::client {
namespace {

using Imath::M33d;
using Imath::M44d;
using Imath::Quatd;
using Imath::V3d;

/// A matrix that acts on row vectors: a stretch, then a rotation, then a translation.
struct Pose {
  M33d stretch;
  Quatd rotation;
  V3d translation;
};

M33d mean(const M33d& a, const M33d& b) {
  M33d result;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) result[i][k] = 0.5 * (a[i][k] + b[i][k]);
  }
  return result;
}

/// Polar decomposition: the rotation is the limit of averaging a matrix with its inverse's transpose.
std::optional<Pose> decomposed(const M44d& matrix) {
  const double determinant = determinant3(matrix);
  if (!is_finite(matrix) || determinant == 0 || !std::isfinite(determinant)) return std::nullopt;
  M33d linear;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) linear[i][k] = matrix[i][k];
  }
  M33d rotation = linear;
  for (int i = 0; i < 60; ++i) {
    const M33d next = mean(rotation, rotation.inverse().transposed());
    const bool settled = next.equalWithAbsError(rotation, 1e-15);
    rotation = next;
    if (settled) break;
  }
  // Mirrors are part of the stretch.
  if (determinant < 0) rotation *= -1;
  M44d turn;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) turn[i][k] = rotation[i][k];
  }
  return Pose{
      linear * rotation.transposed(), Imath::extractQuat(turn), {matrix[3][0], matrix[3][1], matrix[3][2]}};
}

M44d composed(const Pose& pose) {
  const M33d linear = pose.stretch * pose.rotation.toMatrix33();
  M44d matrix;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) matrix[i][k] = linear[i][k];
    matrix[3][i] = pose.translation[i];
  }
  return matrix;
}

/// How far two placings are apart, relative to the size of what they place or, for translations, to `way`.
double distance(const M44d& a, const M44d& b, double way) {
  double turn = 0, size = 0, shift = 0;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) {
      turn += (a[i][k] - b[i][k]) * (a[i][k] - b[i][k]);
      size += a[i][k] * a[i][k];
    }
    shift += (a[3][i] - b[3][i]) * (a[3][i] - b[3][i]);
  }
  return std::max(std::sqrt(turn / size), way > 0 ? std::sqrt(shift) / way : 0.0);
}

double shift_between(const M44d& a, const M44d& b) {
  return std::hypot(a[3][0] - b[3][0], a[3][1] - b[3][1], a[3][2] - b[3][2]);
}

}  // namespace

M44d placing_between(const M44d& from, const M44d& to, double t) {
  if (t <= 0) return from;
  if (t >= 1) return to;
  const Pose a = *decomposed(from), b = *decomposed(to);
  Pose between{M33d(), Imath::slerpShortestArc(a.rotation, b.rotation, t),
               a.translation * (1 - t) + b.translation * t};
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) between.stretch[i][k] = (1 - t) * a.stretch[i][k] + t * b.stretch[i][k];
  }
  return composed(between);
}

bool is_decomposable(const M44d& placing) { return decomposed(placing).has_value(); }

std::vector<TimedPlacing> followed(const std::function<M44d(double)>& at, std::vector<double> times) {
  constexpr double kTolerance = 1e-4;
  constexpr std::size_t kMost = 33, kPieces = 8;
  std::vector<TimedPlacing> placings;
  for (const double time : times) placings.push_back({time, at(time)});
  // A turn all the way round between two moments would not be seen from them.
  for (std::size_t i = 1; i < kPieces; ++i) {
    const double time = static_cast<double>(i) / kPieces;
    const auto after = std::ranges::find_if(placings, [&](const TimedPlacing& p) { return p.time >= time; });
    if (after->time > time) placings.insert(after, {time, at(time)});
  }
  double way = 0;
  for (std::size_t i = 1; i < placings.size(); ++i)
    way += shift_between(placings[i].place, placings[i - 1].place);
  const auto is_between = [&](const TimedPlacing& a, const TimedPlacing& b, const TimedPlacing& middle) {
    const double t = (middle.time - a.time) / (b.time - a.time);
    if (!is_decomposable(a.place) || !is_decomposable(b.place)) return true;  // told by whoever looks at them
    return distance(placing_between(a.place, b.place, t), middle.place, way) < kTolerance;
  };
  const std::size_t most = std::max(kMost, 2 * placings.size());
  for (bool finer = true; finer && placings.size() < most;) {
    finer = false;
    for (std::size_t i = 0; i + 1 < placings.size() && placings.size() < most; ++i) {
      // The renderer follows no finer steps.
      if (placings[i + 1].time - placings[i].time < 1.0 / 64) continue;
      const double time = (placings[i].time + placings[i + 1].time) / 2;
      const TimedPlacing middle{time, at(time)};
      if (is_between(placings[i], placings[i + 1], middle)) continue;
      placings.insert(placings.begin() + static_cast<std::ptrdiff_t>(++i), middle);
      finer = true;
    }
  }
  const bool straight = std::ranges::all_of(placings, [&](const TimedPlacing& placing) {
    return is_between(placings.front(), placings.back(), placing);
  });
  if (straight) placings.erase(placings.begin() + 1, placings.end() - 1);
  if (placings.size() == 2 && placings[0].place == placings[1].place) placings.pop_back();
  return placings;
}

std::vector<TimedPlacing> placings_of(const MovingTransform& moving) {
  std::vector<TimedPlacing> placings = {{0, moving.start}};
  if (!moving.moves()) return placings;
  if (moving.begins > 0) placings.push_back({moving.begins, moving.start});
  placings.push_back({moving.ends, moving.end});
  return placings;
}

std::vector<TimedPlacing> during_shutter(const std::vector<TimedPlacing>& keys, double open, double close) {
  const auto at = [&](double time) {
    const auto after = std::ranges::find_if(keys, [&](const TimedPlacing& key) { return key.time >= time; });
    if (after == keys.begin()) return after->place;
    if (after == keys.end()) return keys.back().place;
    const TimedPlacing& before = *(after - 1);
    return placing_between(before.place, after->place, (time - before.time) / (after->time - before.time));
  };
  std::vector<TimedPlacing> placings = {{0, at(open)}};
  if (!(close > open)) return placings;
  constexpr double kNear = 1e-6;  // no bend is told apart from one so near
  for (const TimedPlacing& key : keys) {
    const double time = (key.time - open) / (close - open);
    if (time > kNear && time < 1 - kNear) placings.push_back({time, key.place});
  }
  placings.push_back({1, at(close)});
  const bool moves = std::ranges::any_of(
      placings, [&](const TimedPlacing& placing) { return !(placing.place == placings[0].place); });
  if (!moves) placings.resize(1);
  return placings;
}

namespace {

/// Turned as the placing turns its z axis, and what it makes of x, and shifted; nothing where those have no
/// plane.
std::optional<M44d> unstretched(const M44d& placing) {
  const V3d z = transformed_vector({0, 0, 1}, placing), y = z.cross(transformed_vector({1, 0, 0}, placing));
  if (!is_finite(placing) || !(length(y) > 0)) return std::nullopt;
  const V3d axis = z / length(z), up = y / length(y), side = up.cross(axis);
  return M44d(side.x, side.y, side.z, 0, up.x, up.y, up.z, 0, axis.x, axis.y, axis.z, 0, placing[3][0],
              placing[3][1], placing[3][2], 1);
}

}  // namespace

bool write_light_motion(const std::vector<TimedPlacing>& placings, v1::Light& light) {
  if (placings.size() < 2) return true;
  std::vector<TimedPlacing> rigid;
  for (const TimedPlacing& placing : placings) {
    const std::optional<M44d> own =
        light.has_point() ? translation(placing.place[3][0], placing.place[3][1], placing.place[3][2])
                          : unstretched(placing.place);
    if (!own || !is_finite(*own)) return false;
    rigid.push_back({placing.time, *own});
  }
  const M44d start = rigid.front().place;
  const bool moves =
      std::ranges::any_of(rigid, [&](const TimedPlacing& placing) { return !(placing.place == start); });
  if (!moves) return true;
  for (TimedPlacing& placing : rigid) placing.place = *inverse(start) * placing.place;
  write_motion(rigid, light);
  return true;
}

}  // namespace tessera::client

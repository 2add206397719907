#include "render/textbook/preview/shadow_map.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "render/core/constants.h"

namespace tessera::render::TESSERA_ISA {

namespace {

constexpr int kTaps = 16;
/// Radius of the filter that hides texels, in texels.
constexpr float kTexelFilter = 1.5f;
/// Blockers are looked for as far off as light from the lamp's rim passes by a third of the way from the
/// lamp: (1 - f) / f of the lamp's radius.
constexpr float kSearch = 2;
/// Widest filter, as a part of the distance.
constexpr float kWidest = 0.5f;
/// Cones up to this angle, 70 degrees, have one face.
constexpr float kNarrow = 1.2217f;
/// Angle between a face's axis and its corners.
constexpr float kCorner = 0.9553167f;
/// Roundings of positions, here and in the map, in parts of the coordinates.
constexpr float kPositionRounding = 0x1p-20f;

/// The point of the unit disk that tap `i` has before it is turned [Vogel 1979].
std::pair<float, float> disk_point(int i) {
  constexpr double kGoldenAngle = 2.39996322972865332;
  const double radius = std::sqrt((i + 0.5) / kTaps), angle = i * kGoldenAngle;
  return {static_cast<float>(radius * std::cos(angle)), static_cast<float>(radius * std::sin(angle))};
}

const std::pair<float, float>* disk() {
  static const auto points = [] {
    std::array<std::pair<float, float>, kTaps> all;
    for (int i = 0; i < kTaps; ++i) all[static_cast<std::size_t>(i)] = disk_point(i);
    return all;
  }();
  return points.data();
}

TESSERA_INLINE Vec3 wide(const float (&v)[3]) { return {Float(v[0]), Float(v[1]), Float(v[2])}; }

}  // namespace

ShadowMap::ShadowMap(const SceneTables& scene, const Lamp& lamp) : lamp_(lamp) {
  const Frame frame = Frame::from_normal(wide(lamp.axis));
  int row = 0;
  for (const Vec3& axis : {frame.x, frame.y, frame.z}) {
    frame_[row][0] = axis.x.lane(0), frame_[row][1] = axis.y.lane(0), frame_[row][2] = axis.z.lane(0);
    ++row;
  }
  std::copy_n(lamp.place, 3, depth_origin_);
  constexpr int kAlong = 4;  // the face about the axis
  if (lamp.at_infinity) {
    reach_ = scene.lights.scene_radius;
    for (int c = 0; c < 3; ++c) depth_origin_[c] = scene.lights.scene_centre[c] - lamp.axis[c] * reach_;
    side_ = kOnlyFaceSide;
    add_face(kAlong, reach_);
    faces_.back().sensor.kind = SensorKind::kOrthographic;
  } else if (lamp.cone <= kNarrow) {
    reach_ = std::tan(lamp.cone);
    side_ = kOnlyFaceSide;
    add_face(kAlong, reach_);
  } else {
    reach_ = 1;
    side_ = kFaceSide;
    for (int number = 0; number < 6; ++number) {
      const float from_axis = number == kAlong ? 0 : number == kAlong + 1 ? kPi : kPi / 2;
      if (from_axis <= lamp.cone + kCorner) add_face(number, reach_);
    }
  }
  const std::size_t count = faces_.size() == 1 ? 1 : 6;
  texels_.assign(count * static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_),
                 -std::numeric_limits<float>::infinity());
}

void ShadowMap::add_face(int number, float half_tangent) {
  Face& face = faces_.emplace_back();
  face.number = number;
  const int axis = number / 2;
  const float sign = number % 2 == 0 ? 1.0f : -1.0f;
  float* const m = face.sensor.render_from_sensor.m;
  for (int c = 0; c < 3; ++c) {
    m[4 * c] = frame_[(axis + 1) % 3][c];
    m[4 * c + 1] = frame_[(axis + 2) % 3][c];
    m[4 * c + 2] = frame_[axis][c] * sign;
    m[4 * c + 3] = depth_origin_[c];
  }
  face.sensor.scale_x = face.sensor.scale_y = 2 * half_tangent / static_cast<float>(side_);
  face.sensor.offset_x = face.sensor.offset_y = -half_tangent;
  face.sensor.width = face.sensor.height = side_;
}

void ShadowMap::put(std::size_t face, int column, int row, const float* nearness) {
  const std::size_t number = faces_.size() == 1 ? 0 : static_cast<std::size_t>(faces_[face].number);
  const auto side = static_cast<std::size_t>(side_);
  float* const first = texels_.data() + number * side * side +
                       static_cast<std::size_t>(row) * kBinSide * side +
                       static_cast<std::size_t>(column) * kBinSide;
  for (std::size_t y = 0; y < kBinSide; ++y) std::copy_n(nearness + y * kBinSide, kBinSide, first + y * side);
}

ShadowMap::Local ShadowMap::localise(const ShadowReceiver& at) const {
  const auto turn = [&](Vec3 w) {
    return Vec3{dot(w, wide(frame_[0])), dot(w, wide(frame_[1])), dot(w, wide(frame_[2]))};
  };
  Local local;
  local.v = turn(at.p - wide(depth_origin_));
  const Vec3 light = lamp_.at_infinity ? Vec3{Float(0.0f), Float(0.0f), Float(1.0f)} : local.v;
  local.n = face_forward(turn(at.n), -light);
  local.lamp_height = max(-dot(local.n, light), 1e-30f);
  const Vec3 size = abs(at.p) + abs(wide(depth_origin_));
  local.position_rounding = max(max(size.x, size.y), size.z) * kPositionRounding;
  const Frame across = Frame::from_normal(normalize(light));
  local.across_u = across.x;
  local.across_v = across.y;
  return local;
}

Float ShadowMap::depth_of(const Local& at) const {
  if (faces_.size() == 1) return at.v.z;
  return max(max(abs(at.v.x), abs(at.v.y)), abs(at.v.z));
}

/// A texel of a face that the lamp is the eye of.
ShadowMap::Tap ShadowMap::tap_face(const Local& at, Vec3 v, Mask active) const {
  // The face that `v` goes through, its sign, and the coordinates along its three axes.
  const Vec3 size = abs(v);
  const bool only = faces_.size() == 1;
  const Mask by_x = only ? Mask::none() : (size.x >= size.y) & (size.x >= size.z);
  const Mask by_y = only ? Mask::none() : and_not(size.y >= size.z, by_x);
  const auto along = [&](Vec3 a) {
    return Vec3{select(by_x, a.x, select(by_y, a.y, a.z)), select(by_x, a.y, select(by_y, a.z, a.x)),
                select(by_x, a.z, select(by_y, a.x, a.y))};
  };
  const Vec3 d = along(v), n = along(at.n), own = along(at.v);
  const Float sign = only ? Float(1.0f) : copysign(Float(1.0f), d.x);
  const Float depth = d.x * sign;
  const Mask inside = active & (depth > 0.0f);
  const float half = 0.5f * static_cast<float>(side_), texel = reach_ / half;
  const Float inverse = 1.0f / select(inside, depth, 1.0f);
  const auto index = [&](Float a) {
    return to_int(
        clamp(floor(fma(a * inverse, Float(1 / texel), Float(half))), 0.0f, static_cast<float>(side_ - 1)));
  };
  const Int column = index(d.y), row = index(d.z);
  const auto middle = [&](Int i) { return (to_float(i) + (0.5f - half)) * texel; };
  // The plane through the receiver, where the ray through the texel's middle meets it: 1 / depth is linear
  // there. Beyond the receiver's own depth the plane may stand for what lies behind another surface.
  const Float on_plane = -fma(n.x, sign, fma(n.y, middle(column), n.z * middle(row))) / at.lamp_height;
  const Float own_depth = own.x * sign;
  const Float own_nearness = 1.0f / select(own_depth > 0.0f, own_depth, 1e-30f);
  const Float reference = max(on_plane, own_nearness);
  // Places in the map are off by half a sub-pixel in either coordinate; twice that for its slopes.
  const Float snapped = (abs(n.y) + abs(n.z)) * (texel / kSubPixels) / at.lamp_height;
  const Float bias = fma(reference, at.position_rounding / at.lamp_height + kPositionRounding, snapped);

  const Int face =
      only ? Int(0)
           : select(by_x, Int(0), select(by_y, Int(2), Int(4))) + select(sign < 0.0f, Int(1), Int(0));
  const Float there = gather(texels_.data(), (face * side_ + row) * side_ + column, inside);
  const Mask blocked = inside & (there > reference + bias);
  return {blocked, 1.0f / select(blocked, there, 1.0f)};
}

/// A texel of a map whose rays are parallel.
ShadowMap::Tap ShadowMap::tap_parallel(const Local& at, Vec3 v, Mask active) const {
  const float half = 0.5f * static_cast<float>(side_), texel = reach_ / half;
  const auto index = [&](Float a) {
    return to_int(clamp(floor(fma(a, Float(1 / texel), Float(half))), 0.0f, static_cast<float>(side_ - 1)));
  };
  const Int column = index(v.x), row = index(v.y);
  const auto middle = [&](Int i) { return (to_float(i) + (0.5f - half)) * texel; };
  const Float aside = at.n.x * (middle(column) - at.v.x) + at.n.y * (middle(row) - at.v.y);
  const Float plane_depth = at.v.z + aside / at.lamp_height;  // lamp_height is -n.z
  const Float reference = -min(plane_depth, at.v.z);
  const Float slope = (abs(at.n.x) + abs(at.n.y)) / at.lamp_height;
  const Float bias = fma(slope, Float(texel / kSubPixels), at.position_rounding / at.lamp_height);
  const Float there = gather(texels_.data(), row * side_ + column, active);
  const Mask blocked = active & (there > reference + bias);
  return {blocked, -select(blocked, there, 0.0f)};
}

ShadowMap::Tap ShadowMap::tap(const Local& at, Vec3 v, Mask active) const {
  return lamp_.at_infinity ? tap_parallel(at, v, active) : tap_face(at, v, active);
}

Vec3 ShadowMap::tap_place(const Local& at, int i, Float radius, Float cosine, Float sine) const {
  const auto [x, y] = disk()[i];
  const Float u = (cosine * x - sine * y) * radius, w = (sine * x + cosine * y) * radius;
  return fma(at.across_u, u, fma(at.across_v, w, at.v));
}

Float ShadowMap::visible(const ShadowReceiver& receiver, ShadowKind kind, Mask active) const {
  const Local at = localise(receiver);
  if (kind == ShadowKind::kHard) return select(tap(at, at.v, active).blocked, Float(0.0f), Float(1.0f));
  const Float cosine = cos(receiver.tap_angle), sine = sin(receiver.tap_angle);
  const Float depth = depth_of(at);
  const Float texel =
      Float(2 * reach_ / static_cast<float>(side_)) * (lamp_.at_infinity ? Float(1.0f) : depth);
  const Float least = texel * kTexelFilter;
  Float radius = least, share(1.0f);
  Mask filtered = active;
  if (kind == ShadowKind::kSoft && lamp_.radius > 0) {
    const Float widest = depth * kWidest;
    const Float search = max(min(Float(kSearch * lamp_.radius), widest), least);
    Float count(0.0f), sum(0.0f);
    for (int i = 0; i < kTaps; ++i) {
      const Tap one = tap(at, tap_place(at, i, search, cosine, sine), active);
      count += select(one.blocked, Float(1.0f), Float(0.0f));
      sum += select_or_zero(one.blocked, one.texel_depth);
    }
    // All of it blocked is the umbra; none of it, full light.
    share = select(count < static_cast<float>(kTaps), Float(1.0f), Float(0.0f));
    filtered = active & (count > 0.0f) & (count < static_cast<float>(kTaps));
    if (none(filtered)) return share;
    const Float blocker = sum / select(filtered, count, 1.0f);
    const Float penumbra = (depth - blocker) / select(filtered, blocker, 1.0f) * lamp_.radius;
    radius = max(min(penumbra, widest), least);
  }
  Float lit(0.0f);
  for (int i = 0; i < kTaps; ++i) {
    const Tap one = tap(at, tap_place(at, i, radius, cosine, sine), filtered);
    lit += select(one.blocked, Float(0.0f), Float(1.0f));
  }
  return select(filtered, lit * (1.0f / kTaps), share);
}

}  // namespace tessera::render::TESSERA_ISA

// Pixels that read light instead of making a picture: each ray is a sample of an integral over places and
// directions, whose value is the pixel's mean.
#include "render/sensor/probe.h"

#include "render/sampling/hash.h"
#include "render/sampling/warp.h"
#include "render/sensor/probe_table.h"
#include "render/sensor/sensor.h"

namespace tessera::render::TESSERA_ISA {

namespace {

constexpr float kTwoPi = 2 * kPi;

Vec3 broadcast(const float (&v)[3]) { return {Float(v[0]), Float(v[1]), Float(v[2])}; }
Vec3 load_vector(const float* base, Int index, Mask active) {
  return {gather(base, index, active), gather(base, index + 1, active), gather(base, index + 2, active)};
}

/// A frame about the axis, whose x is the probe's front where it has one axis.
Frame frame_at(const ProbeRecord& probe, Vec3 axis) {
  if (probe.place == ProbePlace::kMesh || probe.place == ProbePlace::kSphere) return Frame::from_normal(axis);
  const Vec3 front = broadcast(probe.front);
  return {front, cross(axis, front), axis};
}

/// A place that a probe reads.
struct Place {
  Vec3 point, axis;
};

/// A point of a mesh, even in area. `u.x` finds the triangle, and what is left of it a place on that.
Place place_on_mesh(const ProbeTable& table, const ProbeRecord& probe, Vec2 u, Mask active) {
  const float* const before = table.area_before_triangle.data();
  Int low(probe.first_triangle), high(probe.last_triangle);
  for (std::int32_t left = probe.last_triangle - probe.first_triangle; left > 1; left -= left / 2) {
    const Int middle = shift_right<1>(low + high);
    const Mask below = gather(before, middle, active) <= u.x;
    low = select(below, middle, low), high = select(below, high, middle);
  }
  const Float from = gather(before, low, active);
  const Float to = select(low + 1 < probe.last_triangle, gather(before, low + 1, active), Float(1.0f));
  u.x = clamp((u.x - from) / max(to - from, 1e-30f), 0.0f, 1.0f);
  const Barycentric b = square_to_triangle(u);
  const float* const triangles = table.triangles.data();
  const Int first = low * 9;
  const Vec3 e1 = load_vector(triangles, first + 3, active), e2 = load_vector(triangles, first + 6, active);
  const Vec3 point = fma(e2, b.b2, fma(e1, b.b1, load_vector(triangles, first, active)));
  return {point, normalize(cross(e1, e2)) * Float(probe.side)};
}

Place place_of(const ProbeTable& table, const ProbeRecord& probe, Int pixel, Vec2 u, Mask active) {
  const Vec3 origin = broadcast(probe.origin), axis = broadcast(probe.axis);
  switch (probe.place) {
    case ProbePlace::kPlane: {
      if (probe.at_middles) u = {Float(0.5f), Float(0.5f)};
      const Float column = gather(table.column_of_pixel.data(), pixel, active) + u.x,
                  row = gather(table.row_of_pixel.data(), pixel, active) + u.y;
      return {fma(broadcast(probe.edge_v), row, fma(broadcast(probe.edge_u), column, origin)), axis};
    }
    case ProbePlace::kMesh:
      return place_on_mesh(table, probe, u, active);
    case ProbePlace::kDisk: {
      const Vec2 disk = square_to_disk(u);
      const Frame frame = frame_at(probe, axis);
      return {fma(frame.y, disk.y * probe.radius, fma(frame.x, disk.x * probe.radius, origin)), axis};
    }
    case ProbePlace::kSphere: {
      const Vec3 outward = square_to_sphere(u);
      return {fma(outward, Float(probe.radius), origin), outward * Float(probe.side)};
    }
    case ProbePlace::kPoint:
      break;
  }
  return {origin, axis};
}

/// A direction that light comes from, before `axis` is z; its importance over its density is the weight.
struct Direction {
  Vec3 local;
  Float weight, pdf;
};
Direction direction_of(const ProbeRecord& probe, Vec2 u) {
  switch (probe.kind) {
    case ProbeKind::kCone:
      return {square_to_cone(u, Float(probe.one_minus_cos)), Float(1.0f), Float(0.0f)};
    case ProbeKind::kPlane:
    case ProbeKind::kExitance: {
      const Vec3 w = square_to_cosine_hemisphere(u);
      return {w, Float(kPi), cosine_hemisphere_pdf(w.z)};
    }
    case ProbeKind::kFarField:
      return {{Float(0.0f), Float(0.0f), Float(1.0f)}, Float(kPi * probe.radius * probe.radius), Float(0.0f)};
    case ProbeKind::kHalfSphere: {
      // The density of the cosine grows from 0 at -1: (1 + cos) / 2.
      const Float cosine = fma(sqrt(u.x), Float(2.0f), Float(-1.0f));
      const Float sine = safe_sqrt(fnma(cosine, cosine, Float(1.0f))), turn = kTwoPi * u.y;
      return {{sine * cos(turn), sine * sin(turn), cosine}, Float(kPi), (1.0f + cosine) * (1 / (2 * kTwoPi))};
    }
    default:
      break;
  }
  const Vec3 w = square_to_sphere(u);
  const Vec3 axis{Float(0.0f), Float(0.0f), Float(1.0f)};
  ProbeRecord local = probe;
  local.front[0] = 1, local.front[1] = local.front[2] = 0;
  const ProbeWeight weight = weigh_at_probe(local, axis, w);
  return {w, weight.importance / weight.pdf, weight.pdf};
}

/// Rays end at these places instead of beginning there.
bool looks_back(const ProbeRecord& probe) {
  return probe.kind == ProbeKind::kExitance || probe.kind == ProbeKind::kFarField;
}

class ProbeSensor final : public SensorModel {
 public:
  explicit ProbeSensor(bool connects_to_points)
      : SensorModel({.has_lens = true,
                     .connects = connects_to_points,
                     .has_axis = false,
                     .may_fail = true,
                     .weighs = true}) {}

  LocalRay start(const SensorRecord& sensor, Vec2 place, Vec2 u_lens) const override {
    const ProbeTable& table = *sensor.probes;
    const Float x = floor(place.x), y = floor(place.y);
    const auto within = [](Float part) {
      constexpr float kStretch = 0.5f / kProbeFilterRadius;
      return clamp(fma(part - 0.5f, Float(kStretch), Float(0.5f)), 0.0f, 0x1.fffffep-1f);
    };
    const Vec2 u{within(place.x - x), within(place.y - y)};
    const Mask on_raster = (x >= 0.0f) & (y >= 0.0f) & (x < static_cast<float>(sensor.width)) &
                           (y < static_cast<float>(sensor.height));
    const Int pixel =
        to_int(select_or_zero(on_raster, y)) * sensor.width + to_int(select_or_zero(on_raster, x));
    const Int number = gather(table.probe_of_pixel.data(), pixel, on_raster);
    LocalRay ray{.origin = {Float(0.0f), Float(0.0f), Float(0.0f)},
                 .direction = {Float(0.0f), Float(0.0f), Float(1.0f)},
                 .weight = Float(0.0f),
                 .valid = on_raster & (number >= 0)};
    for_each_distinct(number, ray.valid, [&](std::int32_t key, Mask lanes) {
      const ProbeRecord& probe = table.probes[static_cast<std::size_t>(key)];
      const Place read = place_of(table, probe, pixel, u, lanes);
      const Direction way = direction_of(probe, u_lens);
      const Vec3 w = frame_at(probe, read.axis).to_world(way.local);
      const bool back = looks_back(probe);
      // Rays that look at a surface end at their place, however flat they are.
      const Vec3 origin = fma(back ? w : read.axis, Float(probe.offset), read.point);
      ray.origin = select(lanes, origin, ray.origin);
      ray.direction = select(lanes, back ? -w : w, ray.direction);
      ray.normal = select(lanes, read.axis, ray.normal);
      ray.weight = select(lanes, way.weight, ray.weight);
      ray.pdf = select(lanes, samples_lights(probe) && !back ? way.pdf : Float(0.0f), ray.pdf);
    });
    return ray;
  }

  LocalConnection connect(const SensorRecord& sensor, Vec3 point, Vec2 u_lens) const override {
    const ProbeTable& table = *sensor.probes;
    // One pixel of all, by chance, and a place that it reads.
    const Int pixel = min(to_int(u_lens.x * static_cast<float>(table.pixels)), table.pixels - 1);
    const UInt bits = hash(bit_cast<std::uint32_t>(u_lens.x), bit_cast<std::uint32_t>(u_lens.y));
    const Vec2 u{to_unit_float(bits), to_unit_float(hash(bits))};
    const Int number = gather(table.probe_of_pixel.data(), pixel, Mask::all());
    const Int y = to_int(floor((to_float(pixel) + 0.5f) * (1.0f / static_cast<float>(sensor.width))));
    const Int x = pixel - y * sensor.width;
    LocalConnection seen{.place = {to_float(x) + 0.5f, to_float(y) + 0.5f},
                         .lens = point,
                         .importance = Float(0.0f),
                         .density = Float(0.0f),
                         .valid = Mask::none()};
    constexpr float kArea = 4 * kProbeFilterRadius * kProbeFilterRadius;
    const float all = kArea * static_cast<float>(table.pixels);
    for_each_distinct(number, number >= 0, [&](std::int32_t key, Mask lanes) {
      const ProbeRecord& probe = table.probes[static_cast<std::size_t>(key)];
      if (!connects(probe)) return;
      Place read = place_of(table, probe, pixel, u, lanes);
      if (probe.kind == ProbeKind::kFarField) {
        const Float height = dot(read.point - point, read.axis) + probe.offset;
        seen.lens = select(lanes, fma(read.axis, height, point), seen.lens);
        seen.importance = select(lanes, Float(all), seen.importance);
        seen.valid |= lanes & (height > 0.0f);
        return;
      }
      read.point = fma(read.axis, Float(probe.offset), read.point);
      const Vec3 way = point - read.point;
      const Float squared = length_squared(way);
      const Vec3 w = way * (1.0f / sqrt(max(squared, 1e-30f)));
      const Float importance = weigh_at_probe(probe, read.axis, w).importance * all / max(squared, 1e-30f);
      seen.lens = select(lanes, read.point, seen.lens);
      seen.importance = select(lanes, importance, seen.importance);
      seen.valid |= lanes & (importance > 0.0f);
    });
    seen.density = seen.importance;
    return seen;
  }

  Float pixel_width(const SensorRecord&, Float distance) const override { return distance; }
};

}  // namespace

Int probe_of_pixels(const SensorRecord& sensor, UInt x, UInt y, Mask active) {
  const ProbeTable& table = *sensor.probes;
  const UInt pixel = y * static_cast<std::uint32_t>(sensor.width) + x;
  const Mask inside = active & (x < static_cast<std::uint32_t>(sensor.width)) &
                      (y < static_cast<std::uint32_t>(sensor.height));
  return select(inside, gather(table.probe_of_pixel.data(), bit_cast<std::int32_t>(pixel), inside), Int(-1));
}

ProbeWeight weigh_at_probe(const ProbeRecord& probe, Vec3 axis, Vec3 wi) {
  const Float cosine = dot(axis, wi);
  const Float sine = safe_sqrt(fnma(cosine, cosine, Float(1.0f)));
  const Float everywhere(1 / (2 * kTwoPi));
  switch (probe.kind) {
    case ProbeKind::kPlane:
      return {max(cosine, 0.0f), cosine_hemisphere_pdf(cosine)};
    case ProbeKind::kCone: {
      const Mask inside = 1.0f - cosine <= probe.one_minus_cos;
      const Float pdf = select_or_zero(inside, cone_pdf(Float(probe.one_minus_cos)));
      return {pdf, pdf};
    }
    case ProbeKind::kSphere:
      return {Float(1.0f), everywhere};
    case ProbeKind::kCylinder:
      return {sine * kInvPi, everywhere};
    case ProbeKind::kHalfCylinder:
      return {(sine + dot(broadcast(probe.front), wi)) * kInvPi, everywhere};
    case ProbeKind::kHalfSphere:
      return {(1.0f + cosine) * 0.25f, (1.0f + cosine) * everywhere};
    default:
      return {Float(0.0f), Float(0.0f)};
  }
}

const ModelOf<ProbeSensor> probes(SensorKind::kProbes, false);
const ModelOf<ProbeSensor> connecting_probes(SensorKind::kConnectingProbes, true);

}  // namespace tessera::render::TESSERA_ISA

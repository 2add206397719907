#include "render/integrator/irradiance_cache/cache.h"

#include <algorithm>
#include <utility>

namespace tessera::render::TESSERA_ISA {

namespace {

constexpr std::size_t kLeaf = 4;      // records
constexpr std::size_t kDeepest = 64;  // nodes one within the other: each halves its records

/// The record's irradiance at `p`, where the normal is `n`. Light is not negative.
Spectrum extrapolated(const IrradianceRecord& record, Vec3 p, Vec3 n) {
  const Vec3 d{p.x - record.p[0], p.y - record.p[1], p.z - record.p[2]};
  const Vec3 axis = cross({Float(record.n[0]), Float(record.n[1]), Float(record.n[2])}, n);
  const auto along = [](const float(&gradient)[3], Vec3 v) {
    return fma(v.x, Float(gradient[0]), fma(v.y, Float(gradient[1]), v.z * gradient[2]));
  };
  return spectrum_of([&](int band) {
    return max(
        record.irradiance[band] + along(record.rotation[band], axis) + along(record.translation[band], d),
        0.0f);
  });
}

}  // namespace

IrradianceCache::IrradianceCache(std::vector<IrradianceRecord> records, float error)
    : error_(error), records_(std::move(records)) {
  if (!records_.empty()) build(0, records_.size());
}

void IrradianceCache::build(std::size_t begin, std::size_t end) {
  const std::size_t index = nodes_.size();
  nodes_.push_back({.low = {1e30f, 1e30f, 1e30f},
                    .high = {-1e30f, -1e30f, -1e30f},
                    .first = static_cast<std::int32_t>(begin),
                    .count = static_cast<std::int32_t>(end - begin),
                    .other = -1});
  float low[3] = {1e30f, 1e30f, 1e30f}, high[3] = {-1e30f, -1e30f, -1e30f};  // of the records' places
  for (std::size_t i = begin; i < end; ++i) {
    const IrradianceRecord& record = records_[i];
    Node& node = nodes_[index];
    // Rounding must not lose what the error would still allow.
    const float reach = reach_of(record, error_) * 1.0001f;
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], record.p[axis]), high[axis] = std::max(high[axis], record.p[axis]);
      node.low[axis] = std::min(node.low[axis], record.p[axis] - reach);
      node.high[axis] = std::max(node.high[axis], record.p[axis] + reach);
    }
  }
  if (end - begin <= kLeaf) return;
  int longest = 0;
  for (int axis = 1; axis < 3; ++axis) {
    if (high[axis] - low[axis] > high[longest] - low[longest]) longest = axis;
  }
  const auto at = [&](std::size_t i) { return records_.begin() + static_cast<std::ptrdiff_t>(i); };
  // Stable, so that records at one place keep their order with every library.
  std::stable_sort(at(begin), at(end), [longest](const IrradianceRecord& a, const IrradianceRecord& b) {
    return a.p[longest] < b.p[longest];
  });
  const std::size_t middle = begin + (end - begin) / 2;
  build(begin, middle);
  nodes_[index].count = 0;
  nodes_[index].other = static_cast<std::int32_t>(nodes_.size());
  build(middle, end);
}

template <class Visit>
void IrradianceCache::visit(Vec3 p, Mask active, Visit&& visit) const {
  if (nodes_.empty()) return;
  std::int32_t waiting[kDeepest];
  int size = 0;
  waiting[size++] = 0;
  while (size > 0) {
    const std::int32_t index = waiting[--size];
    const Node& node = nodes_[static_cast<std::size_t>(index)];
    const Mask inside = active & (p.x >= node.low[0]) & (p.x <= node.high[0]) & (p.y >= node.low[1]) &
                        (p.y <= node.high[1]) & (p.z >= node.low[2]) & (p.z <= node.high[2]);
    if (none(inside)) continue;
    for (std::int32_t i = 0; i < node.count; ++i) visit(records_[static_cast<std::size_t>(node.first + i)]);
    if (node.other < 0) continue;
    waiting[size++] = node.other;
    waiting[size++] = index + 1;
  }
}

Irradiance IrradianceCache::look_up(Vec3 p, Vec3 n, Mask active) const {
  Float weights(0.0f);
  Spectrum sum(0.0f);
  visit(p, active, [&](const IrradianceRecord& record) {
    const Float weight = max(fnma(split_sphere_error(record, p, n), Float(1 / error_), Float(1.0f)), 0.0f);
    if (none(active & (weight > 0.0f))) return;
    weights += weight;
    sum += extrapolated(record, p, n) * weight;
  });
  const Mask found = active & (weights > 0.0f);
  return {sum * (1.0f / select(found, weights, 1.0f)), found};
}

Mask IrradianceCache::covers(Vec3 p, Vec3 n, float error, Mask active) const {
  Mask covered = Mask::none();
  visit(p, active, [&](const IrradianceRecord& record) {
    covered |= active & (split_sphere_error(record, p, n) < error);
  });
  return covered;
}

Mask IrradianceCache::at_record(Vec3 p, Mask active) const {
  constexpr float kPointRadius = 1.2f;  // pixels
  Mask near = Mask::none();
  visit(p, active, [&](const IrradianceRecord& record) {
    const Vec3 d{p.x - record.p[0], p.y - record.p[1], p.z - record.p[2]};
    near |= active & (length_squared(d) < sqr(Float(kPointRadius * record.pixel)));
  });
  return near;
}

}  // namespace tessera::render::TESSERA_ISA

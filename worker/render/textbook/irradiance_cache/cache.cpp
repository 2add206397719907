#include "render/textbook/irradiance_cache/cache.h"

#include <utility>

namespace tessera::render::TESSERA_ISA {

namespace {

/// The record's irradiance at `p`, where the normal is `n`. Light is not negative.
Spectrum extrapolated(const IrradianceRecord& record, Vec3 p, Vec3 n) {
  const Vec3 d{p.x - record.p[0], p.y - record.p[1], p.z - record.p[2]};
  const Vec3 axis = cross({Float(record.n[0]), Float(record.n[1]), Float(record.n[2])}, n);
  const auto along = [](const float(&gradient)[3], Vec3 v) {
    return fma(v.x, Float(gradient[0]), fma(v.y, Float(gradient[1]), v.z * gradient[2]));
  };
  return color_of([&](int band) {
    return max(
        record.irradiance[band] + along(record.rotation[band], axis) + along(record.translation[band], d),
        0.0f);
  });
}

std::vector<RecordSite> sites_of(const std::vector<IrradianceRecord>& records) {
  return {records.begin(), records.end()};
}

Mask is_covered(const RecordTree& tree, const auto& records, Vec3 p, Vec3 n, float error, Mask active) {
  Mask covered = Mask::none();
  tree.visit(p, active,
             [&](std::size_t i) { covered |= active & (split_sphere_error(records[i], p, n) < error); });
  return covered;
}

Mask is_at_site(const RecordTree& tree, const auto& records, Vec3 p, Mask active) {
  constexpr float kPointRadius = 1.2f;  // pixels
  Mask near = Mask::none();
  tree.visit(p, active, [&](std::size_t i) {
    const RecordSite& site = records[i];
    const Vec3 d{p.x - site.p[0], p.y - site.p[1], p.z - site.p[2]};
    near |= active & (length_squared(d) < sqr(Float(kPointRadius * site.pixel)));
  });
  return near;
}

}  // namespace

IrradianceCache::IrradianceCache(std::vector<IrradianceRecord> records, float error, GlossyRecords glossy)
    : error_(error),
      tree_(sites_of(records), error),
      records_in_tree_order_(in_order(records, tree_)),
      glossy_(std::move(glossy), error) {}

Irradiance IrradianceCache::look_up(Vec3 p, Vec3 n, Mask active) const {
  Float weights(0.0f);
  Spectrum sum(0.0f);
  tree_.visit(p, active, [&](std::size_t i) {
    const IrradianceRecord& record = records_in_tree_order_[i];
    const Float weight = max(fnma(split_sphere_error(record, p, n), Float(1 / error_), Float(1.0f)), 0.0f);
    if (none(active & (weight > 0.0f))) return;
    weights += weight;
    sum += extrapolated(record, p, n) * weight;
  });
  const Mask found = active & (weights > 0.0f);
  return {sum * (1.0f / select(found, weights, 1.0f)), found};
}

Mask IrradianceCache::covers(Vec3 p, Vec3 n, float error, Mask glossy, Mask active) const {
  return is_covered(tree_, records_in_tree_order_, p, n, error, and_not(active, glossy)) |
         is_covered(glossy_.tree(), glossy_.sites(), p, n, error, active & glossy);
}

Mask IrradianceCache::at_record(Vec3 p, Mask glossy, Mask active) const {
  return is_at_site(tree_, records_in_tree_order_, p, and_not(active, glossy)) |
         is_at_site(glossy_.tree(), glossy_.sites(), p, active & glossy);
}

}  // namespace tessera::render::TESSERA_ISA

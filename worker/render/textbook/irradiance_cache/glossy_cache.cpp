#include "render/textbook/irradiance_cache/glossy_cache.h"

#include <algorithm>
#include <utility>

namespace tessera::render::TESSERA_ISA {

/// A lobe's coefficients in the frame of a record. Records of one plane share it.
class GlossyCache::Projection {
 public:
  Projection(const Harmonics& harmonics, const Lobe& lobe) : harmonics_(harmonics), lobe_(lobe) {}

  /// Turns the lobe into the frame of the normal `n`.
  void turn_to(const float (&n)[3]) {
    if (known_ && std::equal(std::begin(n), std::end(n), n_)) return;
    known_ = true;
    std::copy(std::begin(n), std::end(n), n_);
    frame_ = Frame::from_normal({Float(n[0]), Float(n[1]), Float(n[2])});
    const int count = harmonics_.count();
    std::fill_n(coefficients_, count, Spectrum(0.0f));
    Float values[Harmonics::kMost];
    for (int k = 0; k < Lobe::kDirections; ++k) {
      harmonics_.evaluate(frame_.to_local(lobe_.wi[k]), values);
      for (int i = 0; i < count; ++i) coefficients_[i] += lobe_.weight[k] * values[i];
    }
  }

  /// The product with a record's light, at points `d` away from it.
  Spectrum product(std::span<const float> numbers, Vec3 d) const {
    const Float x = dot(d, frame_.x), y = dot(d, frame_.y);
    Spectrum sum(0.0f);
    const float* number = numbers.data();
    for (int i = 0; i < harmonics_.count(); ++i, number += GlossyRecords::kOfCoefficient) {
      const Spectrum light = color_of([&](int band) {
        return fma(x, Float(number[kBands + band]), fma(y, Float(number[2 * kBands + band]), number[band]));
      });
      sum += coefficients_[i] * light;
    }
    return sum;
  }

 private:
  const Harmonics& harmonics_;
  const Lobe& lobe_;
  bool known_ = false;
  float n_[3] = {};
  Frame frame_;
  Spectrum coefficients_[Harmonics::kMost];
};

GlossyCache::GlossyCache(GlossyRecords records, float error)
    : error_(error), tree_(records.sites, error), harmonics_(records.bands) {
  records_.bands = records.bands;
  records_.sites = in_order(records.sites, tree_);
  records_.numbers.reserve(records.numbers.size());
  for (const std::uint32_t i : tree_.order()) {
    const std::span<const float> numbers = records.numbers_of(i);
    records_.numbers.insert(records_.numbers.end(), numbers.begin(), numbers.end());
  }
}

GlossyCache::Light GlossyCache::look_up(Vec3 p, Vec3 n, const Lobe& lobe, Mask active) const {
  Float weights(0.0f);
  Spectrum sum(0.0f);
  Projection projection(harmonics_, lobe);
  tree_.visit(p, active, [&](std::size_t i) {
    const RecordSite& site = records_.sites[i];
    const Float weight = max(fnma(split_sphere_error(site, p, n), Float(1 / error_), Float(1.0f)), 0.0f);
    if (none(active & (weight > 0.0f))) return;
    projection.turn_to(site.n);
    const Vec3 d{p.x - site.p[0], p.y - site.p[1], p.z - site.p[2]};
    weights += weight;
    sum += projection.product(records_.numbers_of(i), d) * weight;
  });
  const Mask found = active & (weights > 0.0f);
  // The harmonics' waves may fall below zero where light is nearly none. Such samples are left as they are:
  // their mean is right, and clamped, dark surfaces would be too bright.
  return {sum * (1.0f / select(found, weights, 1.0f)), found};
}

}  // namespace tessera::render::TESSERA_ISA

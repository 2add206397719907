// Scattering of paths that follow a guide as often as it pays: one of two densities is sampled, and light is
// weighed by both together [Müller, Gross & Novák 2017, section 4.2].
#pragma once

#include "render/transport/guide/guide_field.h"
#include "render/transport/vertex/path_observer.h"

namespace tessera::render::TESSERA_ISA {

/// Lanes of `events` that a guide is for: surfaces that scatter light evenly. Guided glossy ones lose
/// (docs/decisions/0045-path-guiding.md).
TESSERA_INLINE Mask guidable(const Vertex& v, Mask events) {
  return and_not(joinable(v, events) & reflects_only(v.at) & ((v.at.traits & kLambertian) != 0), v.in_medium);
}

/// The cells of the guide that vertices are in.
GuideCells guide_cells_at(const Encounter& e, const SampleBatch& batch);

/// A vertex is steered by the density that it follows, or by -1.
class GuideSteering final : public Steering {
 public:
  GuideSteering(const SceneTables& scene, const GuideField& field, const SampleBatch& batch)
      : scene_(scene), field_(field), batch_(batch) {}

  void met(Encounter& e) override;
  void scattered(const Encounter& e, Scattering& s) override;
  Float pdf(Int steered, Vec3 wi, Float bsdf_pdf, Mask lanes) const override;
  BsdfSample sample(const Encounter& e, Vec2 u, Mask lanes) override;

  const GuideField& field() const { return field_; }
  // These are of the latest encounter.
  const GuideCells& cells() const { return cells_; }
  const Guided& guided() const { return guided_; }
  /// The density of the BSDF alone at the direction that was sampled.
  Float bsdf_pdf() const { return bsdf_pdf_; }

 private:
  const SceneTables& scene_;
  const GuideField& field_;
  const SampleBatch& batch_;
  GuideCells cells_;
  Guided guided_;
  Float bsdf_pdf_;
};

}  // namespace tessera::render::TESSERA_ISA

// Lights that are surfaces.
#pragma once

#include "render/light/light_access.h"

namespace tessera::render::TESSERA_ISA {

/// A point of an emitting surface, in render space.
struct AreaPoint {
  Vec3 point, normal;                          // unit, on the side that counts as the front
  Float density;                               // probability density of the point, by area
  Float extent;                                // largest coordinate of the shape about its own origin
  Vec2 barycentric{Float(0.0f), Float(0.0f)};  // triangles
};

/// The part that is the same for all of them, by points that a model chooses on its surface.
class AreaLight : public LightModel {
 public:
  explicit AreaLight(LightTraits model_traits = {}) : LightModel(model_traits) {}

  LightSample sample(const LightTable& table, Int light, const Receiver& from, Vec2 u,
                     Mask active) const override;
  Float pdf(const LightTable& table, Int light, const Receiver& from, Vec3 wi, Vec3 point, Vec3 normal,
            Mask active) const override;
  Emission emit(const LightTable& table, Int light, Float time, Vec2 u_place, Vec2 u_direction,
                Mask active) const final;
  EmissionDensity emission_density(const LightTable& table, Int light, Float time, Vec3 point, Float cosine,
                                   Vec3 direction, Mask active) const final;
  double power(const LightTable& table, const LightRecord& light) const final;
  LightBounds bounds(const LightTable& table, const LightRecord& light) const final;
  /// One light that is the whole shape.
  void append(const ShapeTable& shapes, const ShapeRecord& shape, const LightRecord& light, float,
              std::vector<LightRecord>& lights) const override;

 protected:
  virtual AreaPoint sample_point(const LightLanes& lanes, Vec2 u) const = 0;
  /// The density by area with which sample_point() gives `point`.
  virtual Float density_at(const LightLanes& lanes, Vec3 point) const;
  /// Fills the area, and what sampling needs, of a light that is a whole shape.
  virtual void describe(const ShapeTable& shapes, const ShapeRecord& shape, LightRecord& light) const {}
  /// Fills box, axis and angle.
  virtual void bound(const LightTable& table, const LightRecord& light, LightBounds& b) const = 0;
};

}  // namespace tessera::render::TESSERA_ISA

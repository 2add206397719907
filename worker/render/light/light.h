// The interface of the light models. One model a file; all models are stateless.
#pragma once

#include <array>

#include "render/color/spectrum.h"
#include "render/core/model_table.h"
#include "render/core/vec.h"
#include "render/light/light_source.h"
#include "render/light/light_table.h"
#include "render/shape/surface.h"

namespace tessera::render::TESSERA_ISA {

/// A point that light falls on, in render space.
struct Receiver {
  Vec3 p;
  // Where light is scattered back by a surface only: its unit shading normal, on that side. Lights may be
  // sampled in proportion to the cosine with it. Zero: not known, or no surface.
  Vec3 normal;

  // In all lanes: so far down a path that sampling a light precisely would cost more than it saves.
  bool roughly = false;

  // When light falls on it, from 0 (the shutter opens) to 1: lights that move are where they are then.
  Float time = Float(0.0f);

  TESSERA_INLINE Receiver(Vec3 point) : Receiver(point, {Float(0.0f), Float(0.0f), Float(0.0f)}) {}
  TESSERA_INLINE Receiver(Vec3 point, Vec3 shading_normal) : p(point), normal(shading_normal) {}
};

/// A direction towards a light, as seen from a reference point.
struct LightSample {
  Vec3 wi;  // unit, from the reference point towards the light
  /// Length of a shadow ray that ends just before the light (its own error bound taken off); huge for lights
  /// at infinity.
  Float distance;
  /// Radiance that arrives along wi if nothing is between. For lights with one point, intensity / distance^2;
  /// for lights with one direction, irradiance.
  Color radiance;
  Float pdf;   // density of wi by solid angle, given the light; 1 for lights with one point or direction
  Mask valid;  // there is a direction with radiance > 0 and pdf > 0
  Mask delta;  // No other strategy can find this direction.
  Vec2 barycentric{Float(0.0f), Float(0.0f)};  // place of the point on a triangle light
  Float cosine = Float(1.0f);  // |cos| of wi with the light's geometric normal; 1 for lights without one
};

/// A ray that carries light.
struct Emission {
  Vec3 origin;     // a point of the emitter, or one outside of the scene
  Vec3 offset;     // the ray starts at origin + offset, off the surface; along its normal
  Vec3 direction;  // unit
  /// Flux that the ray stands for: emitted radiance (or intensity) times cosine over the density of the ray.
  Color flux;
  Mask valid;
  /// The emitter's geometric normal, on the ray's side; unit length. Zero for lights without one.
  Vec3 normal{Float(0.0f), Float(0.0f), Float(0.0f)};
  Vec2 barycentric{Float(0.0f), Float(0.0f)};  // place of the origin on a triangle light
};

/// The densities of such a ray.
struct EmissionDensity {
  /// Density of the origin by area of the emitter, given the direction where it depends on that. For lights
  /// at infinity, by area of a disk across the direction; for lights at a point, 1.
  Float place;
  Float direction;  // density by solid angle; 1 for lights that shine in one direction
};

class LightModel : public LightSource {
 public:
  using LightSource::LightSource;
  /// Samples light `light` (lanes may hold different lights of this kind) as seen from `from`.
  virtual LightSample sample(const LightTable& table, Int light, const Receiver& from, Vec2 u,
                             Mask active) const = 0;
  /// Density with which sample() gives the direction `wi`, which from `from` hits the light's surface at
  /// `point` with unit geometric normal `normal` (both unused at infinity). Zero for lights with one point or
  /// direction.
  virtual Float pdf(const LightTable& table, Int light, const Receiver& from, Vec3 wi, Vec3 point,
                    Vec3 normal, Mask active) const = 0;
  /// A ray that leaves the light at `time`; `u_place` and `u_direction` are uniform in the unit square.
  virtual Emission emit(const LightTable& table, Int light, Float time, Vec2 u_place, Vec2 u_direction,
                        Mask active) const = 0;
  /// The densities with which emit() gives, at `time`, a ray along `direction` from `point`, where the
  /// light's geometric normal has this cosine with it (both unused by lights without one).
  virtual EmissionDensity emission_density(const LightTable& table, Int light, Float time, Vec3 point,
                                           Float cosine, Vec3 direction, Mask active) const = 0;

  std::array<double, kBands> emitted_flux(const LightTable& table, std::int32_t light,
                                          std::int32_t rays) const final;
};

/// The model of a kind.
const LightModel& light_model(LightKind kind);

/// Models for those that build: LightTable::sources of tables for these kernels.
LightSources light_sources();

/// ModelOf calls this.
void set_model(LightKind kind, const LightModel& model);

/// Adds a model that has no kind of its own; records of the kind returned have it. Before anything is
/// rendered: not thread-safe.
LightKind add_light_model(const LightModel& model);

/// LightModel::sample and pdf for lanes that may hold lights of any kind.
LightSample sample_light(const LightTable& table, Int light, const Receiver& from, Vec2 u, Mask active);
Float light_pdf(const LightTable& table, Int light, const Receiver& from, Vec3 wi, Vec3 point, Vec3 normal,
                Mask active);

/// Radiance that an area light emits towards `wo` from `surface` (zero from the back of a one-sided emitter).
Color emitted_radiance(const LightTable& table, Int light, const Surface& surface, Vec3 wo, Mask active);

/// Radiance of one environment light that arrives at `from` along direction `wi`; `light` is the same for all
/// lanes.
Color environment_radiance(const LightTable& table, int light, const Receiver& from, Vec3 wi, Mask active);
/// The same of one that stands still.
Color still_environment_radiance(const LightTable& table, int light, const Receiver& from, Vec3 wi,
                                 Mask active);

}  // namespace tessera::render::TESSERA_ISA

// Vertices of paths from lights joined to the camera: light that lands anywhere on the film.
#pragma once

#include <array>
#include <vector>

#include "render/integrator/integrator.h"
#include "render/sensor/respond.h"
#include "render/sensor/sensor.h"
#include "render/transport/vertex/transit.h"
#include "render/transport/vertex/vertex.h"

namespace tessera::render::TESSERA_ISA {

/// Sixteen vertices and the camera.
struct SensorJoin {
  SensorConnection eye;
  Vec3 w;                      // unit, towards the lens
  BsdfEval back;               // value of what scatters there, and density of going back to the light
  Spectrum value;              // value of the splat if nothing is between
  Mask seen;                   // seen from the rectangle's pixels
  Int layers{0};               // bits of those that the light belongs to; where there are layers
  Float inverse_weight{1.0f};  // ConnectionFields::inverse_weight
};

/// `beta` is what the path carries to the vertex; `dispersed`: PathFields::dispersed.
SensorJoin sensor_join(const SceneTables& scene, const Vertex& v, Spectrum beta, Int dispersed,
                       const Wavelengths& wavelengths, Vec2 u_lens, const FilmRect& rect, Mask wanted);

/// The ray of such a join, with what it carries. Lanes of `shines` whose light cannot be summed, or that have
/// none, are taken from it.
WideConnection ray_of(const SceneTables& scene, const Vertex& v, const SensorJoin& join, Mask& shines);

/// Joins that wait to be traced.
class SensorJoins {
 public:
  explicit SensorJoins(const IntegratorContext& context)
      : scene_(context.scene), rays_(context.rays), stats_(context.stats), transit_(context) {}

  /// Adds joins, no more than a batch has paths before they are traced. `key` is that of random numbers on
  /// the way, in volumetric scenes.
  void add(const Vertex& v, const SensorJoin& join, UInt key, const Wavelengths& wavelengths, Mask shines);
  /// Adds rays that bring light to these places of the film, in pixels, if nothing is in their way.
  void add(const WideConnection& ray, Vec2 raster, Mask shines);
  void trace(Film& film);

 private:
  void splat(int place, const std::array<float, kResponseChannels>& light, std::int32_t layers,
             float inverse_weight);
  /// Those of 16 joins, at places place(k), whose bits are set: what lane(i) of their light brings to bands.
  template <class Place, class Lane>
  void splat_bands(const Wavelengths& wavelengths, const Channels& channels, std::uint32_t arrived,
                   Place&& place, Lane&& lane);

  const SceneTables& scene_;
  const RayQuery& rays_;
  RenderStats& stats_;
  ConnectionQueue connections_;               // connections whose slots are places in the next arrays
  alignas(64) Lanes<float> film_x_, film_y_;  // places where they land
  [[no_unique_address]] WavelengthLanes wavelengths_;
  Transit transit_;  // volumetric scenes only, like the next
  HitState hits_;
  std::vector<Splat> splats_;
  std::vector<BandSplat> band_splats_;
};

}  // namespace tessera::render::TESSERA_ISA

// All that an integrator sees of a scene: tables of plain data, the same for every ISA.
#pragma once

#include <cstdint>
#include <vector>

#include "render/bsdf/material_table.h"
#include "render/color/spectral_tables.h"
#include "render/color/texture_table.h"
#include "render/film/pixel_filter.h"
#include "render/integrator/integrator_settings.h"
#include "render/integrator/layer_table.h"
#include "render/light/light_table.h"
#include "render/medium/medium_table.h"
#include "render/sampling/sampler_config.h"
#include "render/sensor/footprint_record.h"
#include "render/sensor/sensor_record.h"
#include "render/shape/shape_table.h"
#include "wire/aov_list.h"

namespace tessera::render {

/// AOVs that a job asks for.
struct AovRequest {
  std::uint32_t hit_aovs = 0;  // a bit for each wire::HitAov
  bool halves = false;

  void add(wire::HitAov aov) { hit_aovs |= 1u << static_cast<int>(aov); }
  bool has(wire::HitAov aov) const { return (hit_aovs >> static_cast<int>(aov) & 1) != 0; }
  /// Whether hits themselves matter: SampleBatch::record_hit().
  bool of_hits() const { return (hit_aovs & kOfShape) != 0; }

 private:
  static constexpr std::uint32_t kOfShape = [] {
    std::uint32_t bits = 0;
    for (const wire::HitAovRow& row : wire::kHitAovs)
      if (row.of_shape) bits |= 1u << static_cast<int>(row.aov);
    return bits;
  }();
};

/// So that counting those of a batch costs nothing.
inline constexpr std::int32_t kMostShadingGroups = 255;

/// The arrays of a scene, which do not depend on how it is looked at.
struct SceneArrays {
  ShapeTable shapes;
  MaterialTable materials;
  TextureTable textures;
  LightTable lights;
  MediumTable media;
  SpectralTables spectral;  // jobs of wavelengths only
};

/// Copies share the arrays, which must outlive them, and may be given another sensor, filter and sampler.
struct SceneTables {
  explicit SceneTables(const SceneArrays& arrays)
      : shapes(arrays.shapes),
        materials(arrays.materials),
        textures(arrays.textures),
        lights(arrays.lights),
        media(arrays.media) {}

  const ShapeTable& shapes;
  const MaterialTable& materials;
  const TextureTable& textures;
  const LightTable& lights;
  const MediumTable& media;
  const SpectralTables* spectral = nullptr;  // jobs of wavelengths only
  SensorRecord sensor;
  FootprintRecord footprint;
  PixelFilterRecord filter;
  float render_origin[3] = {0, 0, 0};  // world space
  SamplerConfig sampler;
  std::int32_t max_depth = 5;  // scattering events on a path
  float shared_caution = 1;    // factor of kRouletteCaution, once neighbours share what a path finds
  AovRequest aovs;
  LayerTable layers;
  OwnSettings own;  // the integrator's
  IrradianceCacheSettings irradiance_cache;
  RadiositySettings radiosity;
  PhotonSettings photon;
  MetropolisSettings metropolis;
  // Shapes that are shaded alike: hits are sorted by group (a byte a shape) before they are shaded, so that
  // 16 of them mostly have one material. Empty where all shapes are alike.
  std::vector<std::uint8_t> shading_group;
  std::int32_t shading_groups = 0;
  bool any_textures = false;  // some material looks a texture up
  bool any_tangents = false;  // some material needs dp/du: bump, normal map, anisotropy, filtered textures
  bool any_filtered = false;  // some texture or bump map is looked up by footprints
  bool any_mix = false;
  bool any_opacity = false;  // some material lets part of the light straight through
  // Paths look for media and for surfaces that light passes without being scattered.
  bool paths_pass = false;
  // Paths, or rays to lights alone (straight_shadows), do.
  bool volumetric = false;
  // Light passes clear glass (is_clear_glass()) unbent on its way to what it lights.
  bool straight_shadows = false;
  bool any_motion = false;      // the sensor or shapes move: paths have times
  bool any_dispersion = false;  // jobs of wavelengths only: some material has kDisperses
};

}  // namespace tessera::render

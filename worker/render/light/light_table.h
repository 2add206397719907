// Lights as the kernels read them: plain records, filled by build/, the same for every ISA.
#pragma once

#include <cstdint>
#include <vector>

#include "render/sampling/alias_table.h"
#include "render/sampling/piecewise2d.h"
#include "render/shape/shape_table.h"

namespace tessera::render {

enum class LightKind : std::int32_t { kPoint, kSpot, kDistant, kInfinite, kTriangle, kSphere, kDisk, kCount };

/// One light: a delta light, an environment, or one emitting primitive (a triangle, a sphere, a disk). Render space.
struct LightRecord {
  LightKind kind = LightKind::kPoint;
  std::int32_t shape = -1;      // kTriangle, kSphere, kDisk
  std::int32_t primitive = 0;   // kTriangle: within the shape
  std::int32_t two_sided = 0;
  float radiance[3] = {0, 0, 0};  // radiance, W/(m2 sr); kPoint, kSpot: intensity, W/sr; kDistant: irradiance, W/m2
  float area = 0;                 // kTriangle, kSphere, kDisk: render-space units squared
  float position[3] = {0, 0, 0};  // kPoint, kSpot; kSphere: the centre
  float radius = 0;               // kSphere, render space; 0 when cut or not evenly scaled: then sampled by area
  float direction[3] = {0, 0, 1};  // kSpot: axis; kDistant: in which the light travels; unit length
  float cos_outer = 0;            // kSpot: of the whole cone
  float cos_inner = 0;            // kSpot: where the falloff begins
  std::int32_t environment = -1;  // kInfinite: index into LightTable::environments
  float vertices[9] = {};         // kTriangle: its corners
  std::int32_t padding[5] = {};
};
static_assert(sizeof(LightRecord) == 128);

enum class EnvironmentMapping : std::int32_t { kUniform, kEqualAreaOctahedral, kLatitudeLongitude };

/// An environment light: a map of directions with its sampling distribution.
struct Environment {
  EnvironmentMapping mapping = EnvironmentMapping::kUniform;
  Affine light_from_render;  // rotation (scale allowed) of directions
  Affine render_from_light;
  std::int32_t width = 0, height = 0;
  std::vector<float> texels;  // four floats a texel (R, G, B, density of its cell), rows from the top, scale applied
  Piecewise2d distribution;   // over the unit square of the map, density proportional to luminance x Jacobian
};

struct LightTable {
  std::vector<LightRecord> lights;
  std::vector<Environment> environments;
  std::vector<std::int32_t> infinite_lights;  // indices of the kInfinite lights
  AliasTable selection;                       // over lights, by power
  const ShapeTable* shapes = nullptr;
  float scene_radius = 1;  // of a sphere about the scene's bounds, render-space units
};

}  // namespace tessera::render

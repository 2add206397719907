// Lights as the kernels read them: plain records, filled by scene/, the same for every ISA.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "render/color/texture_table.h"
#include "render/core/big_array.h"
#include "render/light/selection/light_tree.h"
#include "render/sampling/alias_table.h"
#include "render/sampling/piecewise2d.h"
#include "render/shape/shape_table.h"

namespace tessera::render {

/// Each kind has a model, at the end of whose file it is named; kinds from kCount on are those that
/// add_light_model() gives.
enum class LightKind : std::int32_t {
  kPoint,
  kSpot,
  kDistant,
  kInfinite,
  kTriangle,
  kRectangle,
  kSphere,
  kDisk,
  kCylinder,
  kProjection,
  kGoniometric,
  kSoftPoint,
  kSoftSpot,
  kDeformingTriangle,
  kMovingSurface,
  kMovingPoint,
  kMovingSoft,
  kMovingDistant,
  kMovingInfinite,
  kCount
};

/// Whether it is light from all around, which paths that miss everything meet.
inline bool is_environment(LightKind kind) {
  return kind == LightKind::kInfinite || kind == LightKind::kMovingInfinite;
}

/// One light: a delta light, an environment, or one emitting primitive (a triangle, a sphere, a disk). Two
/// triangles that make a rectangle are one light: both have the same record, but for their primitives. Render
/// space.
struct LightRecord {
  LightKind kind = LightKind::kPoint;
  std::int32_t shape = -1;     // lights on shapes
  std::int32_t primitive = 0;  // lights on meshes: within the shape
  std::int32_t two_sided = 0;
  float radiance[kBands] = {
      0, 0, 0};    // radiance, W/(m2 sr); kPoint, kSpot and soft ones: intensity, W/sr; kDistant: W/m2
  float area = 0;  // lights with a shape; kRectangle: both triangles; render-space units squared
  float position[3] = {0, 0, 0};  // kPoint, kSpot; kSphere, kSoftPoint, kSoftSpot: the centre
  // kSoftPoint, kSoftSpot; kSphere, render space; 0 when cut or not evenly scaled: then sampled by area
  float radius = 0;
  float direction[3] = {
      0, 0, 1};  // kSpot: axis; kDistant: in which the light travels; kRectangle: its normal; unit length
  float cos_outer = 0;            // kSpot: of the whole cone (all that kSpot has, kSoftSpot has, too)
  float cos_inner = 0;            // kSpot: where the falloff begins
  std::int32_t environment = -1;  // kInfinite: index into LightTable::environments
  // kTriangle: its corners. kRectangle: a corner, and the unit vectors along the two sides from it. kSpot,
  // kProjection, kGoniometric: rows of the rotation of directions from render to light space.
  float vertices[9] = {};
  std::int32_t texture = -1;  // factor of the radiance, a node of LightTable::textures; -1: none
  std::int32_t profile = 0;   // LightProfile; of lights that move, their number in LightTable::lights
  // kProjection, kSpot with a texture: half of the picture's sides at distance 1; kRectangle: its sides;
  // kInterpolated: the probability with which Mitsuba picks the mesh, and the mesh's area.
  float tan_x = 0, tan_y = 0;
  std::int32_t same_as = -1;  // kRectangle, its second triangle: the light that is picked for both; else -1
};
static_assert(sizeof(LightRecord) == 128);

/// LightRecord::profile: how intensity varies off the axis.
enum LightProfile : std::int32_t {
  kPlainProfile = 0,  // kSpot: a smoothstep of the cosine [pbrt-v4]; kProjection: the same for all directions
  kLinearAngle = 1,   // kSpot: linear in the angle [Mitsuba 3]
  kEvenScreen = 2,    // kProjection: 1 / cos^3, so that a screen across the axis is lit evenly [Mitsuba 3]
  kInterpolated = 3,  // kTriangle: as interpolated_normal.h says [Mitsuba 3]
};

enum class EnvironmentMapping : std::int32_t { kUniform, kEqualAreaOctahedral, kLatitudeLongitude };

/// An environment light: a map of directions with its sampling distribution.
struct Environment {
  EnvironmentMapping mapping = EnvironmentMapping::kUniform;
  Affine light_from_render;  // rotation (scale allowed) of directions
  Affine render_from_light;
  std::int32_t width = 0, height = 0;
  BigArray<float>
      texels;  // four floats a texel (R, G, B, density of its cell), rows from the top, scale applied
  Piecewise2d distribution;  // domain: the map's unit square; density proportional to luminance x Jacobian
  double flux = 0;          // environments with a map: integral of the mean of R, G and B over all directions
  float sampled_share = 1;  // share of the light that the distribution covers; BSDF sampling finds the rest
  // Light comes through this parallelogram only, if it has an area: corner, and sides from it, render space.
  // It travels to the side that the cross product of the sides points to.
  float portal[9] = {};
  float portal_area = 0;
};

class LightSource;
struct MovingLights;  // moving_lights.h
/// The models of the kernels that are to read a table (light_source.h).
struct LightSources {
  const LightSource& (*of_kind)(LightKind) = nullptr;
  std::optional<LightKind> (*on_shape)(ShapeKind) = nullptr;  // the kind of the lights of such shapes

  const LightSource& operator()(LightKind kind) const { return of_kind(kind); }
};

struct LightTable {
  std::vector<LightRecord> lights;
  std::vector<Environment> environments;
  std::vector<std::int32_t> infinite_lights;  // indices of the lights that are is_environment()
  AliasTable selection;                       // over lights; only zeros in pmf when nothing is to be sampled
  LightTree tree;                             // over lights; where it is empty, `selection` is used
  bool uses_normals = false;                  // sampling and its density look at Receiver::normal
  LightSources sources;
  const ShapeTable* shapes = nullptr;
  const TextureTable* textures = nullptr;
  bool any_textures = false;          // some light has one
  bool any_interpolated = false;      // some light is kInterpolated
  float scene_centre[3] = {0, 0, 0};  // render space
  float scene_radius = 1;             // radius of a sphere about the scene's bounds, render-space units
  std::shared_ptr<const MovingLights> moving;  // null: all lights stand still
};

}  // namespace tessera::render

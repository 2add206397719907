// What explicit paths carry, and how likely each of their vertices is to be found from either side.
#pragma once

#include "render/integrator/mlt/path_space/explicit_path.h"
#include "render/integrator/scene_tables.h"
#include "render/light/light.h"

namespace tessera::render::TESSERA_ISA {

/// The part of the film's plane that some pixel sees, in pixels.
struct FilmPlane {
  explicit FilmPlane(const SceneTables& scene);
  bool contains(float x, float y) const {
    return x >= left && y >= top && x < left + width && y < top + height;
  }
  float area() const { return width * height; }

  float left, top, width, height;
};

class PathMeasure {
 public:
  explicit PathMeasure(const SceneTables& scene) : scene_(scene), film_(scene) {}

  /// Fills the film's place, the light and the densities of sixteen paths in the lanes `wanted`. It looks at
  /// their points, times and places on the lens alone, so that a path always has the same value. Nothing is
  /// asked of what is in the way.
  void measure(ExplicitPath* const (&paths)[kWidth], Mask wanted) const;

 private:
  struct Vertices;
  struct Scattering;
  struct End;

  Scattering scattering_at(const Vertices& v, Vec3 wi, Mask specular, Mask lanes) const;
  End end_at(const Vertices& v, const WidePoint& end, Vec3 wi, Mask lanes) const;
  Spectrum radiance_of(const WidePoint& end, Vec3 from, Vec3 wi, Mask lanes) const;

  const SceneTables& scene_;
  const FilmPlane film_;
};

}  // namespace tessera::render::TESSERA_ISA

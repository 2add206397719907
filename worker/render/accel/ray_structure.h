// The structure that a scene has built to answer its rays, Embree's or one of our own.
#pragma once

#include <cstddef>

#include "render/accel/structure/figures.h"

namespace tessera::render {

class RayStructure {
 public:
  virtual ~RayStructure() = default;
  /// Bytes of the structures alone, without the tables that they were built from.
  virtual std::size_t memory_bytes() const = 0;
  /// Returns what is known of the structure: of Embree's, its memory alone.
  virtual StructureFigures figures() const { return {.bytes = memory_bytes()}; }
  /// A sphere about the centre of the scene's bounds, without half-spaces; zero radius for an empty scene.
  virtual float bounding_radius() const = 0;
  virtual const float* bounding_centre() const = 0;
  /// How many shadow rays are asked at a time by work that may be stopped.
  virtual int shadow_rays_at_a_time() const { return 64; }
};

}  // namespace tessera::render

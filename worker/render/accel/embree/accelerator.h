// The acceleration structure: an Embree BVH over the world, and one over each object that instances place.
#pragma once

#include <atomic>
#include <deque>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "render/accel/embree/alpha_geometry.h"
#include "render/accel/embree/embree.h"
#include "render/accel/embree/embree_kernel.h"
#include "render/accel/embree/inner_geometry.h"
#include "render/accel/embree/shape_geometry.h"
#include "render/accel/ray_structure.h"
#include "render/core/affine_data.h"

namespace tessera::render {

struct ObjectRange;
struct ShapeTable;
struct TextureTable;

struct BuildOptions {
  int threads = 1;
  std::string
      isa;  // Embree traverses with the same ISA as the kernels, so that bits do not depend on the CPU
  bool robust = false;  // watertight at edges, 11-23 % slower (measured, docs/architecture.md)
  std::stop_token stop = {};
};

/// "3.13.5", of the library that is loaded, whatever this was compiled with.
std::string embree_version();

class Accelerator final : public RayStructure {
 public:
  ~Accelerator() override;
  Accelerator(const Accelerator&) = delete;
  Accelerator& operator=(const Accelerator&) = delete;

  /// The tables must outlive the result: Embree reads vertices in place. Internal when Embree fails, for
  /// example for want of memory. Throws Stopped once a stop is requested.
  static absl::StatusOr<std::unique_ptr<Accelerator>> build(const ShapeTable& shapes,
                                                            const TextureTable& textures,
                                                            const GeometryCallbacks& callbacks,
                                                            const BuildOptions& options);

  RTCScene scene() const { return world_; }
  /// Bytes of Embree's own structures.
  std::size_t memory_bytes() const override { return static_cast<std::size_t>(memory_bytes_.load()); }
  float bounding_radius() const override { return bounding_radius_; }
  const float* bounding_centre() const override { return bounding_centre_; }
  /// Embree sorts as many by direction as one stream.
  int shadow_rays_at_a_time() const override { return 1024; }

 private:
  Accelerator() = default;
  RTCScene new_scene(const BuildOptions& options) const;
  void attach_shape(RTCScene scene, std::int32_t index, const ShapeTable& shapes,
                    const TextureTable& textures, const GeometryCallbacks& callbacks);
  /// The instances in an object, whose own objects have been built.
  void attach_inner(RTCScene scene, const ObjectRange& object, const ShapeTable& shapes,
                    const GeometryCallbacks& callbacks);
  void set_bounds();
  void attach_instance(std::int32_t index, const ShapeTable& shapes);
  absl::Status status(const std::string& what) const;

  RTCDevice device_ = nullptr;
  RTCScene world_ = nullptr;
  std::vector<RTCScene> objects_;
  std::deque<ShapeGeometry> shapes_;  // user pointers: their addresses stay
  std::deque<AlphaGeometry> alphas_;
  std::deque<InnerGeometry> inner_;
  std::atomic<std::int64_t> memory_bytes_{0};
  float bounding_radius_ = 0;
  float bounding_centre_[3] = {0, 0, 0};
};

}  // namespace tessera::render

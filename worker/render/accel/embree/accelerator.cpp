#include "render/accel/embree/accelerator.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "render/accel/embree/curve_geometry.h"
#include "render/accel/structure/primitive_list.h"
#include "render/core/stopped.h"
#include "render/shape/shape_table.h"

namespace tessera::render {

namespace {

bool count_memory(void* counter, ssize_t bytes, bool) {
  static_cast<std::atomic<std::int64_t>*>(counter)->fetch_add(bytes);
  return true;
}

/// Embree's progress monitor: false ends the build.
bool goes_on(void* stop, double) { return !static_cast<const std::stop_token*>(stop)->stop_requested(); }

/// Bounds function of an InnerGeometry.
void bound_inner(const RTCBoundsFunctionArguments* args) {
  const auto& geometry = *static_cast<const InnerGeometry*>(args->geometryUserPtr);
  const InstanceRecord& inner =
      geometry.table->inner[static_cast<std::size_t>(geometry.first) + args->primID];
  RTCBounds own;
  rtcGetSceneBounds((*geometry.objects)[static_cast<std::size_t>(inner.object)], &own);
  const Box object{{own.lower_x, own.lower_y, own.lower_z}, {own.upper_x, own.upper_y, own.upper_z}};
  Box box = box_of_instance(*geometry.table, inner, object);
  // Rays are moved in floats.
  const float room = box.empty() ? 0 : 0x1p-21f * box.largest_coordinate();
  for (int k = 0; k < 3; ++k) box.low[k] -= room, box.high[k] += room;
  args->bounds_o->lower_x = box.low[0], args->bounds_o->upper_x = box.high[0];
  args->bounds_o->lower_y = box.low[1], args->bounds_o->upper_y = box.high[1];
  args->bounds_o->lower_z = box.low[2], args->bounds_o->upper_z = box.high[2];
}

}  // namespace

std::string embree_version() {
  static const std::string version = [] {
    RTCDevice device = rtcNewDevice("threads=1");
    const auto number = device ? rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_VERSION) : 0;
    if (device) rtcReleaseDevice(device);
    return absl::StrCat(number / 10000, ".", number / 100 % 100, ".", number % 100);
  }();
  return version;
}

Accelerator::~Accelerator() {
  if (world_) rtcReleaseScene(world_);
  for (RTCScene object : objects_) rtcReleaseScene(object);
  if (device_) rtcReleaseDevice(device_);
}

absl::Status Accelerator::status(const std::string& what) const {
  const RTCError error = rtcGetDeviceError(device_);
  if (error == RTC_ERROR_NONE) return absl::OkStatus();
  if (error == RTC_ERROR_OUT_OF_MEMORY)
    return absl::ResourceExhaustedError(absl::StrCat(what, ": out of memory"));
  if (error == RTC_ERROR_CANCELLED) throw Stopped();
  return absl::InternalError(absl::StrCat(what, ": Embree error ", static_cast<int>(error)));
}

RTCScene Accelerator::new_scene(const BuildOptions& options) const {
  RTCScene scene = rtcNewScene(device_);
  rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_MEDIUM);
  rtcSetSceneFlags(scene, options.robust ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
  rtcSetSceneProgressMonitorFunction(scene, goes_on, const_cast<std::stop_token*>(&options.stop));
  return scene;
}

void Accelerator::attach_shape(RTCScene scene, std::int32_t index, const ShapeTable& table,
                               const TextureTable& textures, const GeometryCallbacks& callbacks) {
  const ShapeRecord& shape = table.shapes[index];
  RTCGeometry geometry = nullptr;
  if (shape.kind == ShapeKind::kTriangles) {
    geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    if (shape.key_segments > 0)
      rtcSetGeometryTimeStepCount(geometry, static_cast<unsigned>(shape.key_segments) + 1);
    for (std::int32_t key = 0; key <= shape.key_segments; ++key) {
      const std::size_t first =
          std::size_t(shape.first_vertex) + std::size_t(key) * std::size_t(shape.vertex_count);
      rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, static_cast<unsigned>(key),
                                 RTC_FORMAT_FLOAT3, table.vertices.data(), first * sizeof(Vertex),
                                 sizeof(Vertex), shape.vertex_count);
    }
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, table.triangles.data(),
                               std::size_t(shape.first_triangle) * 12, 12, shape.triangle_count);
  } else if (shape.kind == ShapeKind::kCurves) {
    geometry = new_curve_geometry(device_, table.curves[static_cast<std::size_t>(shape.quadric)]);
  } else {
    geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, callbacks.count_primitives(table, index));
    rtcSetGeometryUserData(geometry, &shapes_.emplace_back(ShapeGeometry{&table, &textures, index}));
    rtcSetGeometryBoundsFunction(geometry, callbacks.bound, nullptr);
    rtcSetGeometryIntersectFunction(geometry, callbacks.intersect);
    rtcSetGeometryOccludedFunction(geometry, callbacks.occluded);
  }
  if ((shape.flags & kHasAlpha) &&
      (shape.kind == ShapeKind::kTriangles || shape.kind == ShapeKind::kCurves)) {
    rtcSetGeometryUserData(geometry, &alphas_.emplace_back(AlphaGeometry{&table, &textures, index}));
    rtcSetGeometryIntersectFilterFunction(geometry, callbacks.filter_alpha);
    rtcSetGeometryOccludedFilterFunction(geometry, callbacks.filter_alpha);
  }
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(scene, geometry, static_cast<unsigned>(index));
  rtcReleaseGeometry(geometry);
}

void Accelerator::attach_instance(std::int32_t index, const ShapeTable& table) {
  const InstanceRecord& instance = table.instances[index];
  RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(geometry, objects_[instance.object]);
  if (instance.segments == 0) {
    rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, instance.render_from_instance.m);
  } else {
    rtcSetGeometryTimeStepCount(geometry, static_cast<unsigned>(instance.segments) + 1);
    for (std::int32_t k = 0; k <= instance.segments; ++k) {
      const Affine& step = table.motion_steps[static_cast<std::size_t>(instance.first_step + k)];
      rtcSetGeometryTransform(geometry, static_cast<unsigned>(k), RTC_FORMAT_FLOAT3X4_ROW_MAJOR, step.m);
    }
  }
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(world_, geometry,
                        static_cast<unsigned>(table.shapes.size()) + static_cast<unsigned>(index));
  rtcReleaseGeometry(geometry);
}

void Accelerator::attach_inner(RTCScene scene, const ObjectRange& object, const ShapeTable& table,
                               const GeometryCallbacks& callbacks) {
  if (object.inner_count == 0) return;
  RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(object.inner_count));
  rtcSetGeometryUserData(geometry,
                         &inner_.emplace_back(InnerGeometry{&table, &objects_, object.first_inner}));
  rtcSetGeometryBoundsFunction(geometry, bound_inner, nullptr);
  rtcSetGeometryIntersectFunction(geometry, callbacks.intersect_inner);
  rtcSetGeometryOccludedFunction(geometry, callbacks.occluded_inner);
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(scene, geometry, static_cast<unsigned>(table.shapes.size()));
  rtcReleaseGeometry(geometry);
}

void Accelerator::set_bounds() {
  RTCBounds b;
  rtcGetSceneBounds(world_, &b);
  if (b.upper_x < b.lower_x) return;
  bounding_centre_[0] = (b.lower_x + b.upper_x) / 2;
  bounding_centre_[1] = (b.lower_y + b.upper_y) / 2;
  bounding_centre_[2] = (b.lower_z + b.upper_z) / 2;
  bounding_radius_ = 0.5f * std::hypot(b.upper_x - b.lower_x, b.upper_y - b.lower_y, b.upper_z - b.lower_z);
}

absl::StatusOr<std::unique_ptr<Accelerator>> Accelerator::build(const ShapeTable& shapes,
                                                                const TextureTable& textures,
                                                                const GeometryCallbacks& callbacks,
                                                                const BuildOptions& options) {
  throw_if_stopped(options.stop);
  std::unique_ptr<Accelerator> self(new Accelerator);
  const std::string isa =
      options.isa.empty() || options.isa == "neon" ? "" : absl::StrCat(",isa=", options.isa);
  // Leaves with the corners of triangles that move, not their numbers: rays take three quarters of the time.
  // There is no robust form of them.
  const char* const moving = isa.empty() || options.robust ? "" : ",tri_accel_mb=bvh8.triangle4vmb";
  self->device_ = rtcNewDevice(absl::StrCat("threads=", std::max(1, options.threads), isa, moving).c_str());
  if (!self->device_) return absl::InternalError("Embree device: cannot be made");
  rtcSetDeviceMemoryMonitorFunction(self->device_, count_memory, &self->memory_bytes_);

  for (const ObjectRange& object : shapes.objects) {
    throw_if_stopped(options.stop);
    RTCScene scene = self->objects_.emplace_back(self->new_scene(options));
    for (std::int32_t i = 0; i < object.shape_count; ++i) {
      self->attach_shape(scene, object.first_shape + i, shapes, textures, callbacks);
    }
    self->attach_inner(scene, object, shapes, callbacks);
    rtcCommitScene(scene);
    if (auto s = self->status("building the BVH of an object"); !s.ok()) return s;
  }
  self->world_ = self->new_scene(options);
  // Shapes without an end come after the bounds of all others.
  const auto attach = [&](bool unbounded) {
    for (std::int32_t i = 0; i < shapes.world_shape_count; ++i) {
      throw_if_stopped(options.stop, static_cast<std::size_t>(i));
      if (is_unbounded(shapes.shapes[static_cast<std::size_t>(i)]) == unbounded)
        self->attach_shape(self->world_, i, shapes, textures, callbacks);
    }
    for (std::size_t i = 0; i < shapes.instances.size(); ++i) {
      throw_if_stopped(options.stop, i);
      if (is_unbounded(shapes, shapes.instances[i]) == unbounded)
        self->attach_instance(static_cast<std::int32_t>(i), shapes);
    }
    rtcCommitScene(self->world_);
    return self->status("building the BVH");
  };
  if (auto s = attach(false); !s.ok()) return s;
  self->set_bounds();
  if (any_unbounded(shapes)) {
    if (auto s = attach(true); !s.ok()) return s;
  }
  return self;
}

}  // namespace tessera::render

// Render space: world space about an origin of the scene's, so that floats are finest there.
#pragma once

#include "absl/status/statusor.h"
#include "render/scene/placement/transform.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::render {

struct RenderSpace {
  Imath::V3d origin;     // world space
  Transform from_world;  // a translation
};

RenderSpace render_space_about(Imath::V3d origin);

/// Where the scene wants the origin of render space, else where its camera stands. InvalidArgument where
/// that is not finite, and for a camera without a usable transform.
absl::StatusOr<Imath::V3d> render_origin(const v1::Scene& scene);

}  // namespace tessera::render

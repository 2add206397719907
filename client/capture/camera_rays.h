// Rays of cameras of scenes, for pictures that are looked up instead of rendered.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "absl/status/statusor.h"
#include "capture/plan.h"
#include "light_field/interpolate.h"
#include "tessera/v1/camera.pb.h"

namespace tessera::client {

using RayRow = std::function<void(std::uint32_t y, std::span<light_field::Ray> row)>;

/// The rays through the middles of a film's pixels, by the conventions of docs/cameras.md: of `perspective`,
/// `orthographic`, `fisheye`, `cylindrical`, `panorama` and `spherical` (latitudes and longitudes). Lenses
/// are taken for pinholes. InvalidArgument, with what there is, for other cameras and for distortion.
absl::StatusOr<RayRow> camera_rays(const v1::Camera& camera, const ViewSize& size);

/// Reads a Camera message in protobuf's text form. InvalidArgument with file, line and column.
absl::StatusOr<v1::Camera> read_camera(const std::string& path);

}  // namespace tessera::client

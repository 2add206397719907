// Light fields of scenes that are formulas.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <string>

#include "capture/plan.h"
#include "capture/set_writer.h"
#include "light_field/interpolate.h"
#include "light_field/light_field.h"
#include "unit/client/files.h"

namespace tessera::client::light_field_test {

using Imath::V3d;
using light_field::CameraGrid;
using light_field::LightField;
using light_field::Manifest;
using light_field::Pinhole;
using light_field::Ray;

/// Light along a ray: the mean of red; green and blue are half and a quarter of it. Distance 0: nothing.
struct Shade {
  double red = 0, distance = 0;
};
using Shader = std::function<Shade(const V3d& origin, const V3d& direction)>;

/// The plane z = height + slope x, of a colour that is a function of the place.
inline Shader plane(double height, double slope, std::function<double(const V3d&)> colour) {
  return [=](const V3d& origin, const V3d& direction) {
    const double t = (height + slope * origin.x - origin.z) / (direction.z - slope * direction.x);
    if (!(t > 0)) return Shade{};
    return Shade{colour(origin + t * direction), t * direction.length()};
  };
}

/// 16 waves of amplitude 0.3 about 0.5, across x and y.
inline double waves(const V3d& p) { return 0.5 + 0.15 * (std::sin(4 * p.x) + std::sin(4 * p.y)); }

inline Image shaded(const Pinhole& camera, std::uint32_t width, std::uint32_t height, const Shader& shade) {
  Image image;
  image.data = image.display = {0, 0, static_cast<std::int32_t>(width), static_cast<std::int32_t>(height)};
  for (const char* const name : {"R", "G", "B", "A", "depth.Z"}) image.add(name);
  for (std::size_t i = 0; i < image.pixel_count(); ++i) {
    const auto x = static_cast<double>(i % width), y = static_cast<double>(i / width);
    const Shade seen = shade(camera.place(), camera.direction(x + 0.5, y + 0.5));
    const float red = static_cast<float>(seen.red);
    image.channels[0].values[i] = red;
    image.channels[1].values[i] = red / 2;
    image.channels[2].values[i] = red / 4;
    image.channels[3].values[i] = seen.distance > 0 ? 1.0f : 0.0f;
    image.channels[4].values[i] = static_cast<float>(seen.distance);
  }
  return image;
}

struct SetFormat {
  light_field::Compression compression = light_field::Compression::kZip;
  bool half = false;
  std::uint32_t tile_size = 16;
};

/// Writes the views of a plan, and returns the manifest.
inline Manifest write_set(const std::string& folder, const CapturePlan& plan, const ViewSize& size,
                          const Shader& shade, const SetFormat& format = {}) {
  Manifest manifest;
  manifest.width = size.width, manifest.height = size.height;
  manifest.tile_size = format.tile_size;
  manifest.half = format.half;
  manifest.compression = format.compression;
  manifest.dwa_level = format.compression == light_field::Compression::kDwaa ? 45 : 0;
  manifest.arrangement = plan.arrangement;
  for (const Pinhole& camera : plan.cameras) manifest.views.emplace_back().camera = camera;
  SetWriter writer(folder, manifest);
  EXPECT_TRUE(writer.begin().ok());
  for (std::uint32_t view = 0; view < plan.cameras.size(); ++view) {
    const absl::Status written =
        writer.write(view, shaded(plan.cameras[view], size.width, size.height, shade));
    EXPECT_TRUE(written.ok()) << written;
  }
  EXPECT_TRUE(writer.finish().ok());
  return manifest;
}

/// A grid that looks along z from the origin, with a field of view of 40 degrees.
inline CapturePlan grid_plan(std::uint32_t side, double spacing, double focus, const ViewSize& size) {
  TwoPlaneRequest request;
  request.columns = request.rows = side;
  request.spacing_x = request.spacing_y = spacing;
  request.focus = focus;
  return plan_two_plane(request, v1::Camera(), 40, size).value();
}

inline std::unique_ptr<LightField> open(const std::string& folder) {
  auto field = LightField::open(folder);
  EXPECT_TRUE(field.ok()) << field.status();
  return *std::move(field);
}

/// A picture of a pinhole.
inline light_field::PictureRequest request_of(const Pinhole& eye, std::uint32_t width, std::uint32_t height,
                                              light_field::Interpolation by) {
  light_field::PictureRequest request;
  request.width = width, request.height = height, request.by = by;
  request.rays = [eye](std::uint32_t y, std::span<Ray> row) {
    for (std::size_t x = 0; x < row.size(); ++x)
      row[x] = {eye.place(), eye.direction(static_cast<double>(x) + 0.5, y + 0.5)};
  };
  return request;
}

/// The largest difference in red from what the rays would see, over pixels that are known.
inline double worst_error(const light_field::Picture& picture, const Pinhole& eye, const Shader& shade) {
  double worst = 0;
  for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
    if (picture.known[i] == 0) continue;
    const auto x = static_cast<double>(i % picture.width), y = static_cast<double>(i / picture.width);
    const Shade truth = shade(eye.place(), eye.direction(x + 0.5, y + 0.5));
    worst = std::max(worst, std::abs(static_cast<double>(picture.pixels[i][0]) - truth.red));
  }
  return worst;
}

}  // namespace tessera::client::light_field_test

// Sensors of cameras in text form, for tests of where their films look.
#pragma once

#include <google/protobuf/text_format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "absl/strings/str_cat.h"
#include "render/scene/placement/render_space.h"
#include "render/scene/view/sensor.h"
#include "wire/algorithm.h"

namespace tessera::render::test {

struct Point2 {
  double x, y;
};

/// A PFM whose pixels say, by `seen`, where they would see without distortion: both from 0 to 1, y upwards.
template <class Seen>
std::string map_of(int width, int height, Seen&& seen) {
  std::string pfm = absl::StrCat("PF\n", width, " ", height, "\n-1.0\n");
  for (int row = 0; row < height; ++row) {  // from the bottom
    for (int column = 0; column < width; ++column) {
      const Point2 at = seen(Point2{(column + 0.5) / width, (row + 0.5) / height});
      const float texel[3] = {static_cast<float>(at.x), static_cast<float>(at.y), 0};
      pfm.append(reinterpret_cast<const char*>(texel), sizeof(texel));
    }
  }
  return pfm;
}

/// Swirls, squeezes and shifts a little.
inline Point2 moved_by_map(Point2 at) {
  return {at.x + 0.02 * std::sin(5 * at.y) - 0.01, 0.96 * at.y + 0.03 * at.x * at.x};
}

/// Blobs of whatever digest are a map of moved_by_map().
inline absl::StatusOr<SensorRecord> sensor_of(const std::string& camera, FilmSize film) {
  v1::Camera message;
  EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(camera, &message)) << camera;
  const std::string map = map_of(40, 20, moved_by_map);
  const BlobSource blobs = [&](const std::string&) -> absl::StatusOr<BlobBytes> {
    return BlobBytes{map, nullptr};
  };
  return build_sensor(message, film, render_space_about({0, 0, 0}), *wire::find_algorithm(""), false,
                      {.blobs = &blobs});
}

/// The error of a camera that is no sensor.
inline std::string refusal(const std::string& camera, FilmSize film = {200, 100}) {
  const auto sensor = sensor_of(camera, film);
  EXPECT_FALSE(sensor.ok()) << camera;
  return std::string(sensor.status().message());
}

inline constexpr const char* kOpenCv =
    "perspective { fov_degrees: 50 } distortion { opencv { k1: -0.28 k2: 0.09 p1: 0.002 p2: -0.003 k3: -0.01 "
    "k4: 0.02 k5: 0.01 k6: 0.001 s1: 0.003 s2: -0.001 s3: -0.002 s4: 0.001 tau_x_radians: 0.02 "
    "tau_y_radians: "
    "-0.03 } }";

}  // namespace tessera::render::test

// A camera with a lens system as kernels have it, beside the lens of the optics library.
#pragma once

#include <google/protobuf/text_format.h>
#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "optics/lens_system.h"
#include "render/scene/placement/render_space.h"
#include "render/scene/view/sensor.h"
#include "render/sensor/lens_table.h"
#include "wire/algorithm.h"
#include "wire/lens_message.h"

namespace tessera::render {

struct LensOnFilm {
  SensorRecord sensor;
  std::optional<optics::LensSystem> lens;
};

struct LensUses {
  bool takes_light = false;  // LensSurroundings::takes_light
  bool spectral = false;
};

/// `lens`: what is within `lens { }` of a camera. It must be sound.
inline LensOnFilm lens_on_film(const std::string& lens, FilmSize film, const LensUses& uses) {
  v1::Camera message;
  EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(absl::StrCat("lens { ", lens, " }"), &message));
  const auto sensor = build_sensor(message, film, render_space_about({0, 0, 0}), *wire::find_algorithm(""),
                                   uses.spectral, {.takes_light = uses.takes_light});
  EXPECT_TRUE(sensor.ok()) << sensor.status();
  std::vector<optics::Fault> faults;
  return {*sensor, wire::lens_system_of(message.lens(), faults)};
}

/// The point of the film, in millimetres, at a place of the raster in pixels.
inline optics::Vector film_at(const SensorRecord& sensor, double x, double y) {
  const double d = sensor.lens->film_distance;
  return {-(x * sensor.scale_x + sensor.offset_x) * d, -(y * sensor.scale_y + sensor.offset_y) * d, 0};
}

}  // namespace tessera::render

// Pictures of small scenes with layers, for tests of these.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "support/picture/render_image.h"

namespace tessera::test::layers_of_pictures {

using Layers = std::vector<std::pair<std::string, std::string>>;

inline constexpr std::uint32_t kSide = 32;

inline std::string ball(const char* name, const char* material, double x, double y, double z, double radius) {
  return absl::StrCat(" shapes { name: '", name, "' sphere { radius: ", radius, " } material: '", material,
                      "' world_from_object { elements: [1,0,0,", x, ",0,1,0,", y, ",0,0,1,", z,
                      ",0,0,0,1] } }");
}

/// A floor in white paint seen from above, along -y.
inline constexpr const char* kFloor =
    "camera { perspective { fov_degrees: 50 } world_from_camera { elements: [1,0,0,0, 0,0,-1,4, 0,1,0,0, "
    "0,0,0,1] } } "
    "materials { name: 'white' diffuse { reflectance { constant { constant: 0.7 } } } } "
    "shapes { name: 'floor' disk { radius: 9 } material: 'white' world_from_object { elements: [1,0,0,0, "
    "0,0,1,0, 0,-1,0,0, 0,0,0,1] } } ";

inline constexpr const char* kMaterials =
    "materials { name: 'glass' dielectric { eta { constant: 1.5 } } } "
    "materials { name: 'pane' thin_dielectric { eta { constant: 1.5 } passes_straight: true } } "
    "materials { name: 'brushed' conductor { reflectance { constant { constant: 0.8 } } roughness { u { "
    "constant: 0.3 } v { constant: 0.3 } } } } "
    "materials { name: 'lacquer' coated_diffuse { reflectance { constant { constant: 0.5 } } eta { constant: "
    "1.5 } roughness { u { constant: 0.2 } v { constant: 0.2 } } } } "
    "materials { name: 'plastic' plastic { reflectance { constant { constant: 0.4 } } } } "
    "materials { name: 'varnish' phong { diffuse { constant { constant: 0.4 } } specular { constant { "
    "constant: 0.4 } } exponent { constant: 30 } } } "
    "materials { name: 'disney' principled { base_color { constant { constant: 0.6 } } spec_trans { "
    "constant: 0.3 } sheen { constant: 0.5 } clearcoat { constant: 0.5 } } } "
    "materials { name: 'paper' diffuse_transmission { reflectance { constant { constant: 0.4 } } "
    "transmittance { constant { constant: 0.3 } } } } "
    "materials { name: 'mixed' mix { a: 'varnish' b: 'glass' amount { constant: 0.4 } } } "
    "materials { name: 'lace' diffuse { reflectance { constant { constant: 0.5 } } } opacity { constant: 0.5 "
    "} } ";

inline constexpr const char* kLights =
    "shapes { name: 'lamp' sphere { radius: 0.2 } material: 'white' area_light { radiance { constant: 40 } "
    "group: 'key' } world_from_object { elements: [1,0,0,0.9, 0,1,0,1.6, 0,0,1,0.9, 0,0,0,1] } } "
    "lights { name: 'spot' point { position { x: -2 y: 3 z: -1 } intensity { constant: 6 } } } "
    "lights { name: 'sky' infinite { radiance { constant: 0.3 } } } ";

/// One ball of each material under three kinds of light.
inline std::string many_materials() {
  std::string scene = absl::StrCat(kFloor, kMaterials, kLights);
  int i = 0;
  for (const char* material :
       {"glass", "pane", "brushed", "lacquer", "plastic", "varnish", "disney", "paper", "mixed", "lace"}) {
    absl::StrAppend(
        &scene, ball(absl::StrCat("ball ", material).c_str(), material, i % 4 - 1.5, 0.4, i / 4 - 1.0, 0.38));
    ++i;
  }
  return scene;
}

struct Request {
  std::string scene;
  std::string integrator = "path";
  Layers layers = {};
  std::uint32_t spp = 8;
  std::uint32_t max_depth = 6;
  double noise = 0;
  v1::DirectLight direct_light{};
  std::vector<v1::AOV> aovs = {};
  // 0: as the algorithm has them
  double photon_radius = 0;
  std::uint32_t photons = 0;
};

inline absl::StatusOr<LoadedFile> load(const Request& request) {
  SceneJob job;
  job.width = job.height = kSide;
  job.settings.set_integrator(request.integrator);
  job.settings.set_spp(request.spp);
  job.settings.set_max_depth(request.max_depth);
  job.settings.set_noise(request.noise);
  job.settings.set_direct_light(request.direct_light);
  job.aovs = request.aovs;
  if (request.photons > 0) job.settings.mutable_photon()->set_photons(request.photons);
  if (request.photon_radius > 0) job.settings.mutable_photon()->set_radius(request.photon_radius);
  for (const auto& [name, expression] : request.layers) {
    v1::Layer& layer = *job.settings.add_layers();
    layer.set_name(name);
    layer.set_expression(expression);
  }
  return load_scene_text(request.scene, job, render::supported_isas().front());
}

inline client::Image picture(const Request& request, std::uint64_t seed = 0) {
  const auto file = load(request);
  EXPECT_TRUE(file.ok()) << file.status();
  return file.ok() ? render_image(*file, seed) : client::Image{};
}

inline const std::vector<float>& plane(const client::Image& image, const std::string& name) {
  static const std::vector<float> none(kSide * kSide, std::numeric_limits<float>::quiet_NaN());
  const client::Channel* const channel = image.find(name);
  EXPECT_NE(channel, nullptr) << name;
  return channel == nullptr ? none : channel->values;
}

inline double mean(const client::Image& image, const std::string& name) {
  double sum = 0;
  for (const float value : plane(image, name)) sum += value;
  return sum / (kSide * kSide);
}

}  // namespace tessera::test::layers_of_pictures

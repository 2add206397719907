// Prints a digest of the pixels of each scene file given, for each ISA of this machine and each way to
// render: a change of the renderer's shape must leave every line as it is. Run by hand, before and after
// (CONTRIBUTING: measuring).
//
//   pixel_hashes SCENE...
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <string_view>
#include <thread>

#include "image/image.h"
#include "support/picture/render_image.h"
#include "support/picture/scene_file.h"
#include "wire/digest.h"

namespace tessera::test {
namespace {

/// Longest side of the film, pixels: small, for there are many pictures.
constexpr std::uint32_t kLongestSide = 96;

struct Way {
  const char* name;
  const char* integrator;
  std::uint32_t spp;
  double noise;
  bool aovs;
};
constexpr Way kWays[] = {
    {"path", "path", 4, 0, false},
    {"path+aovs", "path", 2, 0, true},
    {"path+noise", "path", 32, 0.2, true},
    {"volpath", "volpath", 4, 0, true},
    {"volpath+noise", "volpath", 32, 0.2, true},
    {"light", "light", 2, 0, false},
};

std::string digest_of(const client::Image& image) {
  wire::Sha256 digest;
  for (const client::Channel& channel : image.channels) {
    digest.update(channel.name);
    digest.update(
        {reinterpret_cast<const char*>(channel.values.data()), channel.values.size() * sizeof(float)});
  }
  return digest.finish_hex();
}

/// The digest, or why there is no picture.
std::string render(const std::string& path, const Way& way, const std::string& isa) {
  test::SceneJob job;
  job.settings.set_integrator(way.integrator);
  job.settings.set_spp(way.spp);
  job.settings.set_noise(way.noise);
  job.settings.set_seed(20);
  if (way.aovs) job.aovs = {v1::AOV_VARIANCE, v1::AOV_ALBEDO, v1::AOV_NORMAL, v1::AOV_DEPTH};
  const auto shrink = [](v1::Scene& scene) {
    const std::uint32_t longest = std::max(scene.film().width(), scene.film().height());
    const auto scaled = [&](std::uint32_t size) { return std::max(1u, size * kLongestSide / longest); };
    scene.mutable_film()->set_width(scaled(scene.film().width()));
    scene.mutable_film()->set_height(scaled(scene.film().height()));
  };
  const auto file =
      load_scene_file(path, job, isa, static_cast<int>(std::thread::hardware_concurrency()), shrink);
  return file.ok() ? digest_of(render_image(*file)) : "refused: " + std::string(file.status().message());
}

}  // namespace
}  // namespace tessera::test

int main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    for (const std::string& isa : tessera::render::supported_isas()) {
      for (const auto& way : tessera::test::kWays) {
        std::printf("%s %s %s %s\n", argv[i], isa.c_str(), way.name,
                    tessera::test::render(argv[i], way, isa).c_str());
        std::fflush(stdout);
      }
    }
  }
  return argc > 1 ? 0 : 2;
}

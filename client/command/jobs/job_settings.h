// From what a user asks for and what the scene says to a job in which everything is settled.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "command/jobs/layer_request.h"
#include "denoise/denoise.h"
#include "import/input/imported_scene.h"
#include "tessera/v1/camera.pb.h"
#include "tessera/v1/job.pb.h"

namespace tessera::client {

struct Resolution {
  std::uint32_t width = 0, height = 0;  // pixels
};

/// Settings that the command line gives; absent, empty or UNSPECIFIED: as the scene has it, or the default.
struct JobSettings {
  std::optional<Resolution> resolution;
  std::optional<v1::PixelRect> crop;
  std::uint32_t overscan = 0;                   // pixels on each side that the film has more
  std::optional<std::uint32_t> view;            // alone, which the scene's camera is already
  v1::RenderSettings settings;                  // over those of the scene, field by field
  std::optional<v1::PixelFilter::Kind> filter;  // its radius is the usual one
  // The same settings are for several integrators: those that one has not are left out, else refused.
  bool several_integrators = false;
  std::optional<std::uint32_t> tile_size;
  std::vector<v1::AOV> aovs;
  std::optional<DenoiseMethod> denoise;  // how the picture is denoised, once it is rendered
  LayerRequest layers;
  std::string isa;
  // On the farm.
  std::string user;
  std::int32_t priority = 0;
  std::vector<std::string> required_tags;
  std::uint32_t max_workers = 0;  // workers at a time; 0: any number
  v1::Bits bits{};                // UNSPECIFIED: as the farm has it
  std::string comment, webhook;
};

/// A job, and the bytes that it needs.
struct PreparedJob {
  v1::JobSpec spec;
  SceneBlob scene;  // the Scene message
  std::vector<const SceneBlob*>
      blobs;  // all, `scene` included; they point into this object and the imported scene
  std::vector<std::string> warnings;
};

/// "640x480". InvalidArgument, with what was expected, otherwise.
absl::StatusOr<Resolution> parse_resolution(std::string_view text);

/// "x0,y0,x1,y1" in pixels. InvalidArgument, with what was expected, otherwise.
absl::StatusOr<v1::PixelRect> parse_crop(std::string_view text);

/// Defaults are those of wire/resolve_settings.h. OutOfRange when the crop is not within the film, or what
/// the command line asks for does not go with the rest; InvalidArgument when the scene itself asks for what
/// does not exist. `scene` must outlive the result.
absl::StatusOr<std::unique_ptr<PreparedJob>> prepare_job(const JobSettings& request,
                                                         const ImportedScene& scene, const std::string& name);

/// The power of two that makes a unit of a tile of `pixels` pixels of at most 2^14 samples, but no larger
/// than what covers `spp`; more where the job's tiles would otherwise have more than 2^20 units together.
std::uint32_t samples_per_unit(std::uint64_t pixels, std::uint64_t tiles, std::uint32_t spp);

}  // namespace tessera::client

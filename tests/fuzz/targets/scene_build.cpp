// A worker's input: the parts are a JobSpec that a coordinator lets through, a Scene, and the blobs "0",
// "1", ... that it may refer to. The scene is built, and a corner of it is rendered where this machine has
// kernels.
#include <algorithm>
#include <memory>

#include "fuzz/mutate_message.h"
#include "fuzz/target.h"
#include "render/scene/load_scene.h"
#include "scheduler/work_plan.h"
#include "tessera/v1/job.pb.h"
#include "tessera/v1/scene.pb.h"
#include "wire/algorithm.h"
#include "wire/job_check.h"

namespace tessera::fuzz {
namespace {

// Choices of the user that would only cost time.
constexpr std::uint32_t kMaxSide = 64;
constexpr std::uint32_t kMaxDepth = 6;

/// Aligned as a mapped file is, and with nothing behind it.
render::BlobBytes aligned(const std::string& bytes) {
  const auto size = bytes.size();
  std::shared_ptr<char> copy(static_cast<char*>(::operator new (size + 1, std::align_val_t{64})),
                             [](char* p) { ::operator delete (p, std::align_val_t{64}); });
  std::copy(bytes.begin(), bytes.end(), copy.get());
  return {{copy.get(), size}, copy};
}

bool accepts_scene_build(std::string_view bytes) {
  static const std::vector<std::string> isas = render::supported_isas();
  if (isas.empty()) return false;
  const std::vector<std::string> parts = split_parts(bytes);
  v1::JobSpec job;
  v1::Scene scene;
  if (parts.size() < 2 || !job.ParseFromString(parts[0]) || !scene.ParseFromString(parts[1])) return false;
  if (std::max(job.view().width(), job.view().height()) > kMaxSide || !server::WorkPlan::make(job).ok())
    return false;
  job.mutable_view()->set_max_depth(std::min(job.view().max_depth(), kMaxDepth));

  const auto blobs = [&](const std::string& digest) -> absl::StatusOr<render::BlobBytes> {
    const std::size_t index = digest.size() == 1 ? static_cast<std::size_t>(digest[0] - '0') : parts.size();
    if (index + 2 >= parts.size()) return absl::NotFoundError("there is no blob " + digest);
    return aligned(parts[index + 2]);
  };
  const auto loaded = render::load_scene(scene, job, blobs, {.isa = isas.front(), .threads = 1});
  if (!loaded.ok()) {
    require(!loaded.status().message().empty(), "an error without a message");
    return false;
  }
  const v1::PixelRect& crop = job.cut().crop();
  const bool passes = wire::works_in_passes(job);
  const render::TileRequest tile = {crop.x0(),
                                    crop.y0(),
                                    passes ? crop.x1() : std::min(crop.x1(), crop.x0() + 8),
                                    passes ? crop.y1() : std::min(crop.y1(), crop.y0() + 8),
                                    0,
                                    1};
  render::RenderStats stats;
  const auto result = (*loaded)->render_tile(tile, {}, stats);
  require(result.ok(), "a scene that was built cannot be rendered");
  return true;
}

std::string mutate_scene_build(std::string bytes, std::mt19937& random) {
  std::vector<std::string> parts = split_parts(bytes);
  if (parts.size() < 2) return mutate_bytes(std::move(bytes), random);
  const unsigned which = random() % 16;
  if (which == 0 && parts.size() > 2) {
    std::string& blob = parts[2 + random() % (parts.size() - 2)];
    blob = mutate_bytes(std::move(blob), random);
    return join_parts(parts);
  }
  v1::JobSpec job;
  v1::Scene scene;
  if (!job.ParseFromString(parts[0]) || !scene.ParseFromString(parts[1])) {
    return mutate_bytes(std::move(bytes), random);
  }
  which == 1 ? mutate_message(job, random) : mutate_message(scene, random);
  parts[0] = job.SerializeAsString();
  parts[1] = scene.SerializeAsString();
  return join_parts(parts);
}

}  // namespace

const Target kSceneBuild = {"scene_build", accepts_scene_build, mutate_scene_build};

}  // namespace tessera::fuzz

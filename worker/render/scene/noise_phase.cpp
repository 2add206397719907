#include "render/scene/noise_phase.h"

#include <utility>

#include "render/film/noise_pilot.h"
#include "render/film/noise_plan.h"

namespace tessera::render {

bool make_noise_pilot(const Algorithm& algorithm, const IntegratorContext& context, const PartRequest& part,
                      const FilmRect& crop, const NoiseTarget& target, bool scatters, PixelGroup group,
                      std::stop_token stop, std::string& blob) {
  const std::uint64_t samples = context.stats.samples;
  const auto width = static_cast<std::uint32_t>(context.scene.sensor.width),
             height = static_cast<std::uint32_t>(context.scene.sensor.height);
  const FilmRect pixels = crop.x0 < crop.x1 ? crop : FilmRect{0, 0, width, height};
  const auto integrator = algorithm.make(context);
  NoisePilot pilot(pixels, {width, height}, part, target, scatters, group, context.seed, context.stats);
  const bool finished = integrator->render(pilot, pilot, std::move(stop));
  context.stats.samples = samples;  // a phase's samples are none of the picture's
  if (finished) blob = pilot_blob(pilot.result());
  return finished;
}

bool merge_noise_pilots(std::span<const std::string_view> blobs, std::string& merged) {
  Pilot pilot;
  for (const std::string_view blob : blobs) {
    if (!append_pilot_blob(blob, pilot)) return false;
  }
  merged = pilot_blob(pilot);
  return true;
}

absl::StatusOr<std::shared_ptr<const Prepared>> prepare_noise(std::string_view blob,
                                                              std::shared_ptr<const Prepared> algorithm,
                                                              const NoiseTarget& target,
                                                              const SceneTables& scene, bool scatters) {
  Pilot pilot;
  const bool is_one = append_pilot_blob(blob, pilot) && !pilot.values.empty();
  const auto holds = [](std::uint32_t end, std::int32_t film) {
    return std::int64_t{end} * wire::kNoiseBlock < std::int64_t{film} + wire::kNoiseBlock;
  };
  if (!is_one || !holds(pilot.blocks.x1, scene.sensor.width) || !holds(pilot.blocks.y1, scene.sensor.height))
    return absl::InvalidArgumentError("a blob is no pilot of the noise of this film's blocks");
  auto prepared = std::make_shared<NoisePrepared>();
  prepared->algorithm = std::move(algorithm);
  prepared->counts = plan_samples(target, pilot, scatters ? scattered_noise_share(scene.filter) : 1);
  return prepared;
}

}  // namespace tessera::render

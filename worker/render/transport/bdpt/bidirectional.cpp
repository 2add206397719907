#include "render/transport/bdpt/bidirectional.h"

#include "render/integrator/algorithm_list.h"
#include "render/sensor/sensor.h"
#include "render/transport/bdpt/merging.h"
#include "render/transport/vertex/dimensions.h"
#include "render/transport/vertex/ghost_light.h"
#include "render/transport/vertex/layers.h"
#include "render/transport/vertex/pass_share.h"

namespace tessera::render::TESSERA_ISA {

Bidirectional::Bidirectional(const IntegratorContext& context, StrategyFilter filter,
                             std::unique_ptr<Merging> merging)
    : scene_(context.scene),
      sampler_seed_(context.seed),
      stats_(context.stats),
      filter_(filter),
      batch_(context),
      lights_(context, filter),
      merging_(std::move(merging)),
      transit_(context),
      shadow_layers_(make_shadow_layers(context)) {
  shared_.times_of_lights = true;
}

Bidirectional::~Bidirectional() = default;

bool Bidirectional::render(SampleSource& work, Film& film, std::stop_token stop) {
  const std::uint32_t pass = work.pass();
  if (merging_) {
    // All photons of a pass are caught, and joined to the camera, before any of them is looked for.
    if (!merging_->knows_what_to_expect()) merging_->expect(photons_a_path());
    shared_ = share_of_pass(scene_, sampler_seed_, pass);
    merging_->begin(pass);
    lights_.merge(merging_->photons_a_join());
    if (!trace_lights(pass, {}, film, stop)) return false;
    merging_->end();
  }
  // Probes are the first vertex of their paths: light sampled there is the way of one vertex from each end.
  while (batch_.start(work, frontier_.paths, kSubpaths, shared_, &joins_)) {
    if (stop.stop_requested()) return false;
    if (joins_.size > 0) trace_joins(dimension::kDeepest);
    lights_.trace(batch_.keys(), batch_.size(),
                  {.keep = true, .film = merging_ ? nullptr : &film, .shared = shared_});
    frontier_.begin(batch_.size());
    for (int depth = 0; frontier_.size() > 0; ++depth) advance(depth);
    batch_.finish(film, scene_.max_depth > 0);
  }
  return merging_ != nullptr || !connects_to_points(scene_.sensor) ||
         trace_lights(pass, film.rect(), film, stop);
}

double Bidirectional::photons_a_path() {
  // The numbers are none of the film's: any will do.
  constexpr std::uint32_t kBatches = 8;
  merging_->begin(0);
  for (std::uint32_t batch = 0; batch < kBatches; ++batch) {
    for (int slot = 0; slot < kSubpaths; slot += kWidth) {
      Sampler::pixel_hash(sampler_seed_, UInt::iota(batch * kSubpaths + static_cast<std::uint32_t>(slot)),
                          UInt(0x70686f74u))
          .store(other_keys_.pixel_hash + slot);
      UInt(0u).store(other_keys_.reversed_sample + slot);
    }
    lights_.trace(other_keys_, kSubpaths, {.sink = merging_.get()});
  }
  return static_cast<double>(merging_->photons()) / (kBatches * kSubpaths);
}

bool Bidirectional::trace_lights(std::uint32_t pass, const FilmRect& but, Film& film, std::stop_token stop) {
  const auto width = static_cast<std::uint32_t>(scene_.sensor.width),
             height = static_cast<std::uint32_t>(scene_.sensor.height);
  const UInt reversed = reverse_bits(UInt(pass));
  alignas(64) std::uint32_t x[kSubpaths], y[kSubpaths];
  int count = 0;
  std::uint32_t batch = 0;
  const auto trace = [&] {
    for (int slot = 0; slot < count; slot += kWidth) {
      Sampler::pixel_hash(sampler_seed_, UInt::load(x + slot), UInt::load(y + slot))
          .store(other_keys_.pixel_hash + slot);
      reversed.store(other_keys_.reversed_sample + slot);
    }
    const bool caught = merging_ && merging_->wants_batch(batch++);
    lights_.trace(other_keys_, count,
                  {.film = &film, .sink = caught ? merging_.get() : nullptr, .shared = shared_});
    count = 0;
  };
  for (std::uint32_t py = 0; py < height; ++py) {
    const bool row_inside = py >= but.y0 && py < but.y1;
    for (std::uint32_t px = 0; px < width; ++px) {
      if (row_inside && px >= but.x0 && px < but.x1) continue;
      x[count] = px;
      y[count] = py;
      if (++count < kSubpaths) continue;
      if (stop.stop_requested()) return false;
      trace();
    }
  }
  if (count > 0) trace();
  return true;
}

void Bidirectional::advance(int depth) {
  batch_.find_hits(frontier_.paths, frontier_.size(), depth, frontier_.hits);
  if (scene_.volumetric) {
    const StageTimer timer(stats_.times, Stage::kTransit);
    transit_.move(frontier_.paths, frontier_.hits, frontier_.size(), depth,
                  {batch_.keys(), dimension::kFlight, 0}, filter_.all() ? &batch_ : nullptr);
  }
  shade(depth);
  trace_joins(depth);
  if (shadow_layers_) shadow_layers_->trace(batch_, depth);
}

void Bidirectional::shade(int depth) {
  shading_.emplace(stats_.times, Stage::kShading);
  for (int k = 0; k < kPackets; ++k) {
    if (any(frontier_.lanes(k))) shade_packet(k, depth);
  }
  frontier_.end_step();
  shading_.reset();
}

void Bidirectional::trace_joins(int depth) {
  const StageTimer timer(stats_.times, Stage::kShadow);
  if (scene_.volumetric) {
    transit_.march(Passenger::kPath, joins_, join_hits_, depth, [&](const WideConnection& ray, Mask arrived) {
      batch_.add_each(ray.contribution, ray.slot, arrived);
      if (tells_layers(scene_)) batch_.add_to_layers(ray, arrived);
    });
    return;
  }
  batch_.trace(joins_);
}

const ListedAlgorithm bdpt{{"bdpt", &make_with_ghost_light<Bidirectional>}};

}  // namespace tessera::render::TESSERA_ISA

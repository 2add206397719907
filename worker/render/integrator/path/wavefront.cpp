#include "render/integrator/path/wavefront.h"

#include "render/integrator/vertex/dimensions.h"
#include "render/integrator/vertex/layers.h"

namespace tessera::render::TESSERA_ISA {

bool Wavefront::render(SampleSource& work, Film& film, std::stop_token stop) {
  const int group = work.group().count();
  if (group > 1) reuse_ = std::make_unique<PathReuse>(context_, group, guide_, transit_, hits_);
  while (batch_.start(work, paths_)) {
    if (stop.stop_requested()) return false;
    trace(0, batch_.size());
    if (reuse_) reuse_->finish(batch_, shadows_);
    batch_.finish(film, max_depth_ > 0);
  }
  return true;
}

void Wavefront::trace(int depth, int n) {
  shading_timer_.begin_batch(scene_.materials.materials.size());
  for (alive_ = n; alive_ > 0; ++depth) advance(depth);
}

void Wavefront::advance(int depth) {
  if (depth > 0) stats_.bounce_rays += static_cast<std::uint64_t>(alive_);
  intersect(depth);
  if (scene_.paths_pass) {
    const StageTimer timer(stats_.times, Stage::kTransit);
    transit_.move(paths_, hits_, alive_, depth, {batch_.keys(), dimension::kFlight, 0}, &batch_);
  }
  if (reuse_ && depth == 0) reuse_->begin(paths_, hits_, alive_);
  shade(depth);
  trace_to_lights(depth);
  if (reuses(depth)) reuse_->lights_traced(depth, batch_);
  if (recorder_ != nullptr) recorder_->all_found(batch_, paths_, alive_);
}

void Wavefront::trace_to_lights(int depth) {
  const StageTimer timer(stats_.times, Stage::kShadow);
  if (shadow_layers_) shadow_layers_->trace(batch_, depth);
  if (scene_.volumetric) {
    // The nearest hits of the paths are no longer needed: their arrays serve the shadow rays.
    transit_.march(Passenger::kLight, shadows_, hits_, depth, [&](const WideConnection& ray, Mask arrived) {
      batch_.add_radiance(ray.contribution, ray.slot, arrived);
      if (tells_layers(scene_)) batch_.add_to_layers(ray.contribution, ray.layers, ray.slot, arrived);
    });
  } else {
    trace_shadow_rays();
  }
}

void Wavefront::intersect(int depth) {
  const StageTimer timer(stats_.times, Stage::kIntersection);
  find_hits(scene_, rays_, paths_, alive_, depth, PathOrder::kNeighbours, hits_);
  if (depth == 0) batch_.miss_unsampled(hits_);
}

void Wavefront::trace_shadow_rays() {
  rays_.occluded(arrays_of(shadows_.origin, shadows_.direction, times_of(shadows_.time)), shadows_.size,
                 shadows_.distance);
  stats_.shadow_rays += static_cast<std::uint64_t>(shadows_.size);
  batch_.add_contributions(shadows_);
  shadows_.size = 0;
}

}  // namespace tessera::render::TESSERA_ISA

#include "render/transport/path/wavefront.h"

#include "render/integrator/algorithm_list.h"
#include "render/transport/vertex/dimensions.h"
#include "render/transport/vertex/ghost_light.h"
#include "render/transport/vertex/layer_observer.h"
#include "render/transport/vertex/straight_shadows.h"

namespace tessera::render::TESSERA_ISA {

Wavefront::Wavefront(const IntegratorContext& context, std::int32_t max_depth)
    : context_(context),
      scene_(context.scene),
      stats_(context.stats),
      batch_(context),
      max_depth_(max_depth),
      transit_(context),
      layers_(make_layer_observer(context, batch_)),
      straight_shadows_(scene_.straight_shadows ? std::make_unique<StraightShadows>(scene_) : nullptr) {
  for (PathObserver* observer : {layers_.get(), straight_shadows_.get()})
    if (observer != nullptr) add(*observer);
}

bool Wavefront::render(SampleSource& work, Film& film, std::stop_token stop) {
  if (const int group = work.group().count(); group > 1) {
    std::erase(observers_, reuse_.get());
    reuse_ = std::make_unique<PathReuse>(context_, batch_, group, steering_, transit_, hits_);
    add(*reuse_);
  }
  while (batch_.start(work, paths_, kBatch, {}, &shadows_)) {
    if (stop.stop_requested()) return false;
    if (shadows_.size > 0) trace_to_lights(dimension::kDeepest);
    trace(0, batch_.size());
    if (reuse_) reuse_->finish(shadows_);
    batch_.finish(film, max_depth_ > 0);
  }
  return true;
}

void Wavefront::trace(int depth, int n) {
  shading_timer_.begin_batch(scene_.materials.materials.size());
  for (alive_ = n; alive_ > 0; ++depth) advance(depth);
}

void Wavefront::advance(int depth) {
  batch_.find_hits(paths_, alive_, depth, hits_);
  if (scene_.paths_pass) {
    const StageTimer timer(stats_.times, Stage::kTransit);
    transit_.move(paths_, hits_, alive_, depth, {batch_.keys(), dimension::kFlight, 0}, &batch_);
  }
  if (depth == 0)
    for (PathObserver* observer : observers_) observer->begun(paths_, hits_, alive_);
  shade(depth);
  for (PathObserver* observer : observers_) observer->all_scattered(depth);
  trace_to_lights(depth);
  for (PathObserver* observer : observers_) observer->all_lit(depth, paths_, alive_);
}

void Wavefront::trace_to_lights(int depth) {
  const StageTimer timer(stats_.times, Stage::kShadow);
  if (!scene_.volumetric) {
    batch_.trace(shadows_);
    return;
  }
  // The nearest hits of the paths are no longer needed: their arrays serve the shadow rays.
  transit_.march(Passenger::kLight, shadows_, hits_, depth,
                 [&](const WideConnection& ray, Mask arrived) { batch_.add_contribution(ray, arrived); });
}

const ListedAlgorithm path{{"path", &make_with_ghost_light<Wavefront>}};
const ListedAlgorithm volpath{{"volpath", &make_with_ghost_light<Wavefront>}};
const ListedAlgorithm direct{{"direct", &make_for_one_event<Wavefront>}};

}  // namespace tessera::render::TESSERA_ISA

#include "render/transport/light/light_tracer.h"

#include <algorithm>

#include "render/integrator/algorithm_list.h"
#include "render/transport/vertex/dimensions.h"
#include "render/transport/vertex/layers.h"
#include "render/transport/vertex/light_start.h"

namespace tessera::render::TESSERA_ISA {

bool LightTracer::render(SampleSource& work, Film& film, std::stop_token stop) {
  if (!eye_.render(work, film, stop)) return false;
  if (!emits_paths(scene_) || scene_.max_depth == 0) return true;
  const FilmRect rect = film.rect();
  const std::int32_t paths = scene_.sensor.width * scene_.sensor.height;
  for (std::int32_t first = 0; first < paths; first += kBatch) {
    if (stop.stop_requested()) return false;
    paths_.start(first, std::min<std::int32_t>(kBatch, paths - first), work.pass());
    for (int depth = 0; paths_.alive(); ++depth) {
      paths_.advance(depth, [&](const LightEvent& e, Mask hit) { join_to_sensor(e, hit, rect); });
      joins_.trace(film);
    }
  }
  return true;
}

void LightTracer::join_to_sensor(const LightEvent& e, Mask hit, const FilmRect& rect) {
  const Mask wanted = joinable(e.vertex, hit);
  if (none(wanted)) return;
  const Vec2 lens = e.sampler.get_2d(e.first_pair + dimension::kJoinLens);
  SensorJoin join =
      sensor_join(scene_, e.vertex, e.path.beta, e.path.dispersed, e.path.wavelengths, lens, rect, wanted);
  if (none(join.seen)) return;
  if (tells_layers(scene_)) {
    const Int state = light_state_after(scene_, e.vertex, e.path.layer_state, join.w, e.vertex.wo,
                                        Mask::none(), {e.sampler, e.depth, true}, join.seen);
    join.layers = layers_at_eye(scene_.layers, state, join.seen);
  }
  joins_.add(e.vertex, join, UInt(0), e.path.wavelengths, join.seen);
}

const ListedAlgorithm light{{"light", &make<LightTracer>}};

}  // namespace tessera::render::TESSERA_ISA

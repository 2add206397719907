#include "render/textbook/ambient_occlusion/ambient_occlusion.h"

#include "render/integrator/algorithm_list.h"
#include "render/integrator/stage_timer.h"
#include "render/light/light_access.h"
#include "render/sampling/warp.h"
#include "render/transport/vertex/encounter.h"

namespace tessera::render::TESSERA_ISA {

bool AmbientOcclusion::render(SampleSource& work, Film& film, std::stop_token stop) {
  while (batch_.start(work, camera_rays_)) {
    if (stop.stop_requested()) return false;
    batch_.find_hits(camera_rays_, batch_.size(), 0, hits_);
    look_around();
    trace();
    batch_.finish(film, true);
  }
  return true;
}

void AmbientOcclusion::look_around() {
  const StageTimer timer(stats_.times, Stage::kShading);
  const auto distance = static_cast<float>(scene_.own["distance"]);
  const float reach = distance > 0 ? distance : kInfiniteDistance;
  for (int i = 0; i < batch_.size(); i += kWidth) {
    Encounter e(scene_, batch_, camera_rays_, hits_, 0, i, Mask::first(batch_.size() - i));
    const Mask hit = e.on_surface;
    if (none(hit)) continue;
    e.find_surface(scene_, hit);
    Vertex& v = e.vertex;
    interact(scene_, v.surface, v.wo, e.random(dimension::kRoulette).y, spectra_of(scene_, e.path), hit,
             v.at);
    batch_.record_first_hit(v, e.hit, e.path.slot, hit);

    const Frame frame = Frame::from_normal(face_forward(v.surface.ng, v.wo));
    const Vec3 wi = frame.to_world(square_to_cosine_hemisphere(e.random(dimension::kBsdfDirection)));
    WideConnection around = connect(scene_, v, wi, fma(wi, Float(reach), v.surface.p), hit);
    around.contribution = spectra_of(scene_, e.path).light(Color(1.0f), Int(-1), hit);
    around.slot = e.path.slot;
    around_.size += append(scene_, around, hit, around_, around_.size);
  }
}

void AmbientOcclusion::trace() {
  const StageTimer timer(stats_.times, Stage::kShadow);
  batch_.trace(around_);
}

const ListedAlgorithm ambient_occlusion{{"ao", &make<AmbientOcclusion>}};

}  // namespace tessera::render::TESSERA_ISA

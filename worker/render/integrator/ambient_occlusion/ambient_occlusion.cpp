#include "render/integrator/ambient_occlusion/ambient_occlusion.h"

#include "render/integrator/stage_timer.h"
#include "render/integrator/vertex/dimensions.h"
#include "render/light/light_access.h"
#include "render/sampling/warp.h"

namespace tessera::render::TESSERA_ISA {

namespace {

constexpr int kDirection = dimension::kFirstEvent + dimension::kBsdfDirection;
constexpr int kMaterial = dimension::kFirstEvent + dimension::kRoulette;

}  // namespace

bool AmbientOcclusion::render(SampleSource& work, Film& film, std::stop_token stop) {
  while (batch_.start(work, camera_rays_)) {
    if (stop.stop_requested()) return false;
    intersect();
    look_around();
    trace();
    batch_.finish(film, true);
  }
  return true;
}

void AmbientOcclusion::intersect() {
  const StageTimer timer(stats_.times, Stage::kIntersection);
  find_hits(scene_, rays_, camera_rays_, batch_.size(), 0, PathOrder::kNeighbours, hits_);
}

void AmbientOcclusion::look_around() {
  const StageTimer timer(stats_.times, Stage::kShading);
  const float reach = scene_.occlusion_distance > 0 ? scene_.occlusion_distance : kInfiniteDistance;
  around_.size = 0;
  for (int i = 0; i < batch_.size(); i += kWidth) {
    Hit found = load_hit(hits_, i);
    const WidePath ray = load(scene_, camera_rays_, i);
    const Mask hit = Mask::first(batch_.size() - i) & (found.shape >= 0);
    if (none(hit)) continue;
    if (scene_.any_motion) found.time = ray.time;
    Vertex v;
    v.wo = -ray.direction;
    v.time = found.time;
    v.surface = surface_at(scene_.shapes, found, ray.origin, ray.direction, hit, scene_.any_tangents);
    const Sampler random = batch_.sampler(ray.slot, hit);
    interact(scene_, v.surface, v.wo, random.get_2d(kMaterial).y, hit, v.at);
    batch_.record_first_hit(v, found.t, ray.slot, hit);
    if (scene_.aovs.of_hits()) batch_.record_hit(found, ray.slot, hit);

    const Frame frame = Frame::from_normal(face_forward(v.surface.ng, v.wo));
    const Vec3 wi = frame.to_world(square_to_cosine_hemisphere(random.get_2d(kDirection)));
    WideConnection around = connect(scene_, v, wi, fma(wi, Float(reach), v.surface.p), hit);
    around.contribution = Spectrum(1.0f);
    around.slot = ray.slot;
    around_.size += append(scene_, around, hit, around_, around_.size);
  }
}

void AmbientOcclusion::trace() {
  const StageTimer timer(stats_.times, Stage::kShadow);
  const float* const times = scene_.any_motion ? around_.time : nullptr;
  rays_.occluded(arrays_of(around_.origin, around_.direction, times), around_.size, around_.distance);
  stats_.shadow_rays += static_cast<std::uint64_t>(around_.size);
  batch_.add_contributions(around_);
}

}  // namespace tessera::render::TESSERA_ISA

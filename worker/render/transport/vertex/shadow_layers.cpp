#include "render/transport/vertex/shadow_layers.h"

namespace tessera::render::TESSERA_ISA {

void ShadowLayers::add(const WideConnection& ray, Mask shines, SampleBatch& batch, int event) {
  shines = and_not(shines & (ray.layers != 0), is_black(ray.contribution));
  if (none(shines)) return;
  if (waiting_.size + kWidth > kBatch) trace(batch, event);
  // Through media some of it arrives, which is taken away again.
  if (scene_.volumetric) batch.add_to_layers(ray.contribution, ray.layers, ray.slot, shines);
  waiting_.size += append(scene_, ray, shines, waiting_, waiting_.size);
}

void ShadowLayers::trace(SampleBatch& batch, int event) {
  if (scene_.volumetric) {
    transit_.march(Passenger::kLight, waiting_, hits_, event, [&](const WideConnection& ray, Mask arrived) {
      batch.add_to_layers(-1.0f * ray.contribution, ray.layers, ray.slot, arrived);
    });
    return;
  }
  const float* const times = scene_.any_motion ? waiting_.time : nullptr;
  rays_.occluded(arrays_of(waiting_.origin, waiting_.direction, times), waiting_.size, waiting_.distance);
  stats_.shadow_rays += static_cast<std::uint64_t>(waiting_.size);
  for (int i = 0; i < waiting_.size; i += kWidth) {
    const WideConnection ray = load(scene_, static_cast<const ConnectionFields<InMemory>&>(waiting_), i);
    const Mask blocked = Mask::first(waiting_.size - i) & (ray.distance < 0.0f);
    batch.add_to_layers(ray.contribution, ray.layers, ray.slot, blocked);
  }
  waiting_.size = 0;
}

}  // namespace tessera::render::TESSERA_ISA

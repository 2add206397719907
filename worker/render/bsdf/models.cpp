// The table of the BSDF models.
#include "render/bsdf/models.h"

#include <cassert>
#include <cstddef>

namespace tessera::render::TESSERA_ISA {
namespace {

constexpr std::size_t kMostModels = 64;

/// In the order of BsdfKind; filled when the kernels are loaded, so that asking costs one load.
const Bsdf* models[kMostModels] = {&interface_bsdf(),
                                   &diffuse_bsdf(),
                                   &conductor_bsdf(),
                                   &dielectric_bsdf(),
                                   &thin_dielectric_bsdf(),
                                   &coated_diffuse_bsdf(),
                                   &diffuse_transmission_bsdf(),
                                   &plastic_bsdf(),
                                   &coated_conductor_bsdf(),
                                   &hair_bsdf(),
                                   &principled_bsdf(),
                                   &principled_thin_bsdf(),
                                   &phong_bsdf(),
                                   &gltf_bsdf(),
                                   nullptr};
std::size_t model_count = static_cast<std::size_t>(BsdfKind::kCount);

}  // namespace

const Bsdf* bsdf_model(BsdfKind kind) { return models[static_cast<std::size_t>(kind)]; }

BsdfKind add_bsdf(const Bsdf& model) {
  assert(model_count < kMostModels);
  models[model_count] = &model;
  return static_cast<BsdfKind>(model_count++);
}

}  // namespace tessera::render::TESSERA_ISA

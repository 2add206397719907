// The table of the BSDF models.
#include "render/bsdf/models.h"

#include <cassert>
#include <vector>

namespace tessera::render::TESSERA_ISA {
namespace {

/// In the order of BsdfKind.
std::vector<const Bsdf*>& models() {
  static std::vector<const Bsdf*> table = {&interface_bsdf(),
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
                                           nullptr};
  return table;
}

}  // namespace

const Bsdf* bsdf_model(BsdfKind kind) {
  const std::vector<const Bsdf*>& table = models();
  assert(static_cast<std::size_t>(kind) < table.size());
  return table[static_cast<std::size_t>(kind)];
}

BsdfKind add_bsdf(const Bsdf& model) {
  assert(models().size() >= static_cast<std::size_t>(BsdfKind::kCount));
  models().push_back(&model);
  return static_cast<BsdfKind>(models().size() - 1);
}

}  // namespace tessera::render::TESSERA_ISA

// Materials for the tests of the BSDF models.
#pragma once

#include "support/kernel/gltf_cases.h"
#include "support/kernel/microfacet_cases.h"
#include "support/kernel/principled_cases.h"
#include "support/kernel/simple_cases.h"

namespace tessera::test {

/// Every model with parameters from one end of their range to the other.
inline std::vector<BsdfCase> all_cases() {
  std::vector<BsdfCase> cases{diffuse({0.9f, 0.5f, 0.1f}),
                              diffuse_transmission({0.5f, 0.2f, 0.1f}, {0.1f, 0.3f, 0.4f}),
                              diffuse_transmission({0, 0, 0}, {0.9f, 0.9f, 0.9f}), thin_dielectric(1.5f)};
  for (const std::vector<BsdfCase>& family :
       {microfacet_cases(), principled_cases(), gltf_cases(), hair_and_phong_cases()})
    cases.insert(cases.end(), family.begin(), family.end());
  return cases;
}

/// Where the path comes from: along the normal, oblique, grazing, from below.
inline std::vector<Direction> all_wo() {
  return {direction(0, 0),     direction(30, 40),  direction(60, 200), direction(85, -70),
          direction(89.9, 10), direction(150, 25), direction(92, 100)};
}

}  // namespace tessera::test

// Diffuse surfaces, sheets, hair, and Phong's lobes.
#pragma once

#include "support/kernel/bsdf_case.h"

namespace tessera::test {

inline BsdfCase diffuse(BsdfCase::Color reflectance) {
  return {"diffuse", render::BsdfKind::kDiffuse, reflectance};
}
inline BsdfCase diffuse_transmission(BsdfCase::Color reflectance, BsdfCase::Color transmittance) {
  return {"diffuse transmission", render::BsdfKind::kDiffuseTransmission, reflectance, transmittance};
}

inline BsdfCase thin_dielectric(float eta) {
  return {"thin dielectric eta " + number(eta), render::BsdfKind::kThinDielectric, {}, {}, {0, 0, eta}};
}
/// Brown hair hit at `h` across, with scales tilted by 2 degrees.
inline BsdfCase hair(float beta_m, float beta_n, float h, BsdfCase::Color sigma_a = {0.5f, 0.9f, 1.8f}) {
  return {"hair " + number(beta_m) + " " + number(beta_n) + " h " + number(h),
          render::BsdfKind::kHair,
          sigma_a,
          {},
          {beta_m, beta_n, 1.55f},
          0,
          {0.035f, h}};
}

inline BsdfCase phong(float exponent, std::int32_t lobe, BsdfCase::Color base = {0.3f, 0.5f, 0.1f},
                      BsdfCase::Color gloss = {0.6f, 0.3f, 0.4f}) {
  const char* const name = lobe == render::kBlinn        ? "blinn "
                           : lobe == render::kMirrorLobe ? "mirror "
                                                         : "phong ";
  return {name + number(exponent), render::BsdfKind::kPhong, base, gloss, {0, 0, exponent}, lobe};
}

/// From one end of their parameters to the other.
inline std::vector<BsdfCase> hair_and_phong_cases() {
  std::vector<BsdfCase> cases;
  for (const auto& [m, n] : {std::array{0.3f, 0.3f}, std::array{0.1f, 0.9f}, std::array{0.9f, 0.1f}}) {
    for (const float h : {0.0f, -0.7f, 0.99f}) cases.push_back(hair(m, n, h));
  }
  for (const float exponent : {0.0f, 1.0f, 30.0f, 1000.0f}) {
    cases.push_back(phong(exponent, 0));
    cases.push_back(phong(exponent, render::kBlinn));
  }
  cases.push_back(phong(0, render::kMirrorLobe));
  cases.push_back(phong(50, 0, {0, 0, 0}, {1, 1, 1}));
  cases.push_back(phong(50, render::kBlinn, {0.9f, 0.9f, 0.9f}, {0.9f, 0.5f, 0}));
  return cases;
}

}  // namespace tessera::test

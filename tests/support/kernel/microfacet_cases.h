// Conductors, dielectrics and coats.
#pragma once

#include "support/kernel/bsdf_case.h"

namespace tessera::test {

/// Copper, at wavelengths of about red, green and blue.
inline constexpr BsdfCase::Color kCopperEta{0.20f, 0.92f, 1.10f}, kCopperK{3.91f, 2.45f, 2.14f};

/// "beckmann", "separable" and so on.
inline std::string names_of(std::int32_t variants, std::int32_t flags = 0) {
  std::string names;
  if (variants & render::kBeckmann) names += " beckmann";
  if (variants & render::kSeparableMasking) names += " separable";
  if (variants & render::kTinted) names += " tinted";
  if (variants & render::kNonlinear) names += " nonlinear";
  if (variants & render::kBalanced) names += " balanced";
  if (flags & render::kHasTextures) names += " textured";
  return names;
}

inline BsdfCase conductor(float alpha_x, float alpha_y, BsdfCase::Color eta = kCopperEta,
                          BsdfCase::Color k = kCopperK, std::int32_t variants = 0, std::int32_t flags = 0) {
  return {"conductor " + number(alpha_x) + " " + number(alpha_y) + names_of(variants, flags),
          render::BsdfKind::kConductor,
          eta,
          k,
          {alpha_x, alpha_y},
          variants,
          {},
          flags};
}
inline BsdfCase dielectric(float alpha_x, float alpha_y, float eta, std::int32_t variants = 0,
                           std::int32_t flags = 0) {
  return {"dielectric " + number(alpha_x) + " " + number(alpha_y) + " eta " + number(eta) +
              names_of(variants, flags),
          render::BsdfKind::kDielectric,
          {0.7f, 0.9f, 0.2f},  // used with kTinted
          {0.7f, 0.5f, 1.0f},
          {alpha_x, alpha_y, eta},
          variants,
          {},
          flags};
}
inline BsdfCase coated_diffuse(float alpha_x, float alpha_y, float eta,
                               BsdfCase::Color rho = {0.8f, 0.4f, 0.1f}) {
  return {"coated diffuse " + number(alpha_x) + " " + number(alpha_y) + " eta " + number(eta),
          render::BsdfKind::kCoatedDiffuse,
          rho,
          {},
          {alpha_x, alpha_y, eta}};
}
inline BsdfCase plastic(float alpha, float eta, std::int32_t variants,
                        BsdfCase::Color rho = {0.8f, 0.4f, 0.1f}) {
  return {"plastic " + number(alpha) + " eta " + number(eta) + names_of(variants),
          render::BsdfKind::kPlastic,
          rho,
          {1.0f, 0.5f, 0.8f},
          {alpha, alpha, eta},
          variants};
}

/// From one end of their parameters to the other.
inline std::vector<BsdfCase> microfacet_cases() {
  std::vector<BsdfCase> cases;
  constexpr std::array<float, 2> kAlphas[] = {{0, 0},        {1e-3f, 1e-3f}, {0.02f, 0.02f},
                                              {0.2f, 0.2f},  {1, 1},         {0.05f, 0.5f},
                                              {0.9f, 0.01f}, {1e-4f, 1e-4f}, {0.3f, 1e-4f}};
  for (const auto& [x, y] : kAlphas) {
    cases.push_back(conductor(x, y));
    for (const float eta : {1.5f, 1 / 1.5f, 3.0f}) {
      cases.push_back(dielectric(x, y, eta));
      cases.push_back(coated_diffuse(x, y, eta));
    }
  }
  for (const float eta : {1.0f, 1 + 1e-6f, 1.01f}) {
    cases.push_back(dielectric(0.2f, 0.2f, eta));
    cases.push_back(coated_diffuse(0.2f, 0.2f, eta));
  }
  constexpr std::int32_t kMitsuba = render::kBeckmann | render::kSeparableMasking;
  for (const std::int32_t variants :
       {kMitsuba, std::int32_t{render::kSeparableMasking}, std::int32_t{render::kBeckmann}}) {
    for (const auto& [x, y] :
         {std::array{0.02f, 0.02f}, std::array{0.3f, 0.3f}, std::array{1.0f, 1.0f}, std::array{0.1f, 0.5f}}) {
      cases.push_back(conductor(x, y, kCopperEta, kCopperK, variants | render::kTinted));
      cases.push_back(dielectric(x, y, 1.5f, variants | render::kTinted));
      if (x == y) cases.push_back(plastic(x, 1.5f, variants));
    }
    cases.push_back(dielectric(0.2f, 0.2f, 1 / 1.5f, variants));
  }
  // With multiple scattering between the facets.
  for (const auto& [x, y] :
       {std::array{0.02f, 0.02f}, std::array{0.3f, 0.3f}, std::array{1.0f, 1.0f}, std::array{0.1f, 0.6f}}) {
    cases.push_back(conductor(x, y, kCopperEta, kCopperK, render::kBalanced));
    for (const float eta : {1 / 1.5f, 1.1f, 1.5f}) cases.push_back(dielectric(x, y, eta, render::kBalanced));
  }
  cases.push_back(
      conductor(0.4f, 0.4f, kCopperEta, kCopperK, kMitsuba | render::kBalanced | render::kTinted));
  cases.push_back(dielectric(0.4f, 0.4f, 1.5f, render::kBalanced, render::kHasTextures));
  cases.push_back(plastic(0, 1.5f, 0));
  cases.push_back(plastic(0, 1.9f, render::kNonlinear));
  return cases;
}

}  // namespace tessera::test

// Disney's material.
#pragma once

#include "support/kernel/bsdf_case.h"

namespace tessera::test {

struct PrincipledParameters {
  float roughness = 0.5f, anisotropic = 0, eta = 1.5f;
  float metallic = 0, spec_trans = 0, spec_tint = 0, sheen = 0, sheen_tint = 0, flatness = 0, clearcoat = 0,
        clearcoat_gloss = 0, diff_trans = 0;
};
inline BsdfCase principled(const std::string& what, const PrincipledParameters& p, bool thin = false) {
  return {(thin ? "principled thin " : "principled ") + what,
          thin ? render::BsdfKind::kPrincipledThin : render::BsdfKind::kPrincipled,
          {0.8f, 0.5f, 0.2f},
          {},
          {p.roughness, p.anisotropic, p.eta},
          render::kSeparableMasking,
          {p.metallic, p.spec_trans, p.spec_tint, p.sheen, p.sheen_tint, p.flatness, p.clearcoat,
           p.clearcoat_gloss, p.diff_trans},
          !thin && p.spec_trans > 0 ? render::kHasInside : 0};
}

/// All lobes, and single ones.
inline std::vector<BsdfCase> principled_cases() {
  std::vector<BsdfCase> cases;
  const PrincipledParameters all{.roughness = 0.3f,
                                 .anisotropic = 0.6f,
                                 .metallic = 0.3f,
                                 .spec_trans = 0.5f,
                                 .spec_tint = 0.4f,
                                 .sheen = 0.5f,
                                 .sheen_tint = 0.5f,
                                 .flatness = 0.5f,
                                 .clearcoat = 0.8f,
                                 .clearcoat_gloss = 0.3f,
                                 .diff_trans = 0.7f};
  for (const bool thin : {false, true}) {
    cases.push_back(principled("all", all, thin));
    cases.push_back(principled("plain", {}, thin));
    cases.push_back(principled("glass", {.roughness = 0.3f, .spec_trans = 1}, thin));
  }
  cases.push_back(principled("metal", {.roughness = 0.2f, .metallic = 1}));
  cases.push_back(principled("coat", {.clearcoat = 1, .clearcoat_gloss = 0}));
  cases.push_back(principled("leaf", {.diff_trans = 2}, true));
  return cases;
}

}  // namespace tessera::test

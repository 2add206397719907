// glTF's layers.
#pragma once

#include "render/bsdf/kinds.h"
#include "support/kernel/bsdf_case.h"

namespace tessera::test {

struct GltfParameters {
  float roughness = 0.5f, anisotropic = 0, eta = 1.5f;
  float metallic = 0, transmission = 0, specular = 1, coat = 0, coat_roughness = 0, sheen_roughness = 0,
        rotation = 0, behind = 0;
  bool volume = false;
  BsdfCase::Color base{0.8f, 0.5f, 0.2f}, specular_color{1, 1, 1};
  float film = 0, film_eta = 1.3f, film_nm = 400;
  float spread = 0;                   // half of that of the indices
  Direction coat_normal{0, 0, 1};     // unit length
  BsdfCase::Color along{1, 0.5f, 1};  // anisotropy, as a texture has it
};

/// With the sheen and the colour behind that all cases have.
inline BsdfCase gltf(const std::string& what, const GltfParameters& p) {
  const bool further = p.film > 0 || p.spread != 0 || p.coat_normal[2] != 1 || p.along[1] != 0.5f;
  BsdfCase bsdf{"glTF " + what,
                render::BsdfKind::kGltf,
                p.base,
                p.specular_color,
                {p.roughness, p.anisotropic, p.eta},
                0,
                {p.metallic, p.transmission, p.specular, p.coat, p.coat_roughness, p.sheen_roughness,
                 p.rotation, p.behind},
                (p.volume ? render::kHasInside : 0) | (p.anisotropic > 0 ? render::kAnisotropic : 0) |
                    (further ? render::kUsesFurther : 0) | (p.film > 0 ? render::kPrepared : 0)};
  bsdf.further[render::slot::kFilm] = p.film;
  bsdf.further[render::slot::kFilmEta] = p.film_eta;
  bsdf.further[render::slot::kFilmThickness] = p.film_nm;
  bsdf.further[render::slot::kSpread] = p.spread;
  bsdf.further_color = p.along;
  bsdf.upper_normal = p.coat_normal;
  return bsdf;
}

/// Films, dispersion, coats with a normal of their own, and directions of the anisotropy, alone and among all
/// layers.
inline std::vector<BsdfCase> further_gltf_cases(const GltfParameters& layers) {
  const Direction leaning = direction(25, 50);
  GltfParameters all = layers, solid;
  all.film = 0.7f, all.film_eta = 1.8f, all.film_nm = 330;
  all.coat_normal = leaning, all.along = {0.3f, 0.9f, 1};
  solid = all;
  solid.volume = true, solid.spread = 0.1f;
  return {
      gltf("film", {.roughness = 0.3f, .film = 1, .film_eta = 1.7f, .film_nm = 300}),
      gltf("film on metal", {.roughness = 0.6f, .metallic = 1, .film = 0.9f, .film_nm = 550}),
      gltf("film on glass",
           {.roughness = 0.4f, .transmission = 1, .volume = true, .film = 1, .film_eta = 2, .film_nm = 250}),
      gltf("dispersing", {.roughness = 0.4f, .transmission = 1, .volume = true, .spread = 0.12f}),
      gltf("leaning coat", {.coat = 1, .coat_roughness = 0.3f, .coat_normal = leaning}),
      gltf("turned", {.roughness = 0.5f, .anisotropic = 0.7f, .metallic = 1, .along = {0.2f, 0.1f, 1}}),
      gltf("all further", all),
      gltf("all further of a volume", solid)};
}

/// Single layers, and all of them.
inline std::vector<BsdfCase> gltf_cases() {
  std::vector<BsdfCase> cases;
  cases.push_back(gltf("plain", {}));
  cases.push_back(gltf("smooth", {.roughness = 0.2f}));
  cases.push_back(gltf("metal", {.roughness = 0.7f, .metallic = 1}));
  cases.push_back(gltf("glass", {.roughness = 0.5f, .transmission = 1, .volume = true}));
  cases.push_back(gltf("sheet", {.roughness = 0.5f, .transmission = 1}));
  const GltfParameters layers{.roughness = 0.6f,
                              .anisotropic = 0.4f,
                              .metallic = 0.2f,
                              .transmission = 0.4f,
                              .specular = 0.8f,
                              .coat = 0.8f,
                              .coat_roughness = 0.4f,
                              .sheen_roughness = 0.5f,
                              .rotation = 0.7f,
                              .behind = 0.4f,
                              .specular_color = {1, 0.5f, 2}};
  cases.push_back(gltf("all", layers));
  GltfParameters solid = layers;
  solid.volume = true;
  cases.push_back(gltf("all of a volume", solid));
  for (const BsdfCase& further : further_gltf_cases(layers)) cases.push_back(further);
  return cases;
}

}  // namespace tessera::test

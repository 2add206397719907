// Materials for the tests of the BSDF models, and the models called with plain double directions.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "render/bsdf/bsdf.h"
#include "render/bsdf/tables/balance_table.h"
#include "render/bsdf/tables/coat_table.h"
#include "render/bsdf/tables/layer_table.h"
#include "render/bsdf/tables/plastic_table.h"

namespace tessera::test {

namespace kernel = render::TESSERA_ISA;

using Direction = std::array<double, 3>;

inline Direction direction(double theta_degrees, double phi_degrees) {
  const double theta = theta_degrees * M_PI / 180, phi = phi_degrees * M_PI / 180;
  return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

inline double dot(const Direction& a, const Direction& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// Sixteen directions in, sixteen out.
inline kernel::Vec3 wide(const Direction& w) {
  return {static_cast<float>(w[0]), static_cast<float>(w[1]), static_cast<float>(w[2])};
}
inline kernel::Vec3 wide(const Direction (&w)[kernel::kWidth]) {
  alignas(64) float x[kernel::kWidth], y[kernel::kWidth], z[kernel::kWidth];
  for (int i = 0; i < kernel::kWidth; ++i) {
    x[i] = static_cast<float>(w[i][0]);
    y[i] = static_cast<float>(w[i][1]);
    z[i] = static_cast<float>(w[i][2]);
  }
  return {kernel::Float::load(x), kernel::Float::load(y), kernel::Float::load(z)};
}
inline void store(kernel::Float value, float (&lanes)[kernel::kWidth]) { value.store_unaligned(lanes); }

/// One lane of a BsdfEval.
struct Eval {
  std::array<double, 3> f_cos;
  double pdf;
};

/// One lane of a BsdfSample.
struct Sample {
  Direction wi;
  std::array<double, 3> weight;
  double pdf, eta;
  bool valid, specular, transmission;
};

/// n evenly spread points of the unit cube [Hammersley 1960], bases 2 and 3; n is a multiple of 16.
struct HammersleySet {
  std::vector<float> x, y, z;

  /// Made once for every n.
  static const HammersleySet& of(int n) {
    static std::map<int, HammersleySet> sets;
    HammersleySet& set = sets[n];
    for (int i = static_cast<int>(set.x.size()); i < n; ++i) {
      set.x.push_back(radical_inverse(i, 2));
      set.y.push_back(static_cast<float>((i + 0.5) / n));
      set.z.push_back(radical_inverse(i, 3));
    }
    return set;
  }

  /// The digits of `index` mirrored at the point.
  static float radical_inverse(int index, int base) {
    double result = 0;
    for (double digit = 1.0 / base; index > 0; index /= base, digit /= base) result += index % base * digit;
    return std::min(static_cast<float>(result), 0x1.fffffep-1f);
  }
};

/// A model with constant parameters.
class BsdfCase {
 public:
  using Color = std::array<float, 3>;

  BsdfCase(std::string case_name, render::BsdfKind bsdf_kind, Color spectrum0 = {}, Color spectrum1 = {},
           std::vector<float> scalars = {}, std::int32_t material_flags = 0, std::vector<float> extended = {})
      : name(std::move(case_name)),
        kind(bsdf_kind),
        flags(material_flags),
        spectra_{spectrum0, spectrum1},
        scalars_(std::move(scalars)),
        extended_(std::move(extended)) {
    scalars_.resize(render::kMaterialScalars);
    extended_.resize(render::kExtendedScalars);
    if (kind == render::BsdfKind::kCoatedDiffuse) render::append_coat_table(scalars_[2], 0, table_);
    const bool beckmann = (flags & render::kBeckmann) != 0,
               separable = (flags & render::kSeparableMasking) != 0;
    if (flags & render::kBalanced) {
      const bool textured = (flags & render::kHasTextures) != 0;
      render::append_balance_table(
          {textured ? 0 : scalars_[0], textured ? 0 : scalars_[1], textured, beckmann, separable,
           kind == render::BsdfKind::kDielectric ? scalars_[2] : 0},
          table_);
    }
    if (kind == render::BsdfKind::kGltf) render::append_layer_table(table_);
    if (kind == render::BsdfKind::kPlastic) {
      const double alpha = scalars_[0] < 1e-3f ? 0 : scalars_[0];
      render::append_plastic_table(scalars_[2], {alpha, beckmann, separable}, table_);
    }
  }

  std::string name;
  render::BsdfKind kind;
  std::int32_t flags;  // render::MaterialFlags
  kernel::Transport transport = kernel::Transport::kRadiance;
  Color extended_color{0.9f, 0.5f,
                       0.2f};  // tint of conductors with kTinted; sheen of glTF, and its light behind

  float scalar(int i) const { return scalars_[static_cast<std::size_t>(i)]; }

  kernel::BsdfParams params() const {
    kernel::BsdfParams params;
    for (int s = 0; s < render::kMaterialSpectra; ++s) {
      for (int c = 0; c < kernel::kSpectrumLanes; ++c) params.spectra[s].c[c] = spectra_[s][c % 3];
    }
    for (int s = 0; s < render::kMaterialScalars; ++s) params.scalars[s] = scalar(s);
    params.flags = kernel::Int(flags);
    params.some_flags = flags;
    for (kernel::Spectrum& tint : params.extended_spectra) {
      for (int c = 0; c < kernel::kSpectrumLanes; ++c)
        tint.c[c] = extended_color[static_cast<std::size_t>(c % 3)];
    }
    for (int s = 0; s < render::kExtendedScalars; ++s)
      params.extended[s] = extended_[static_cast<std::size_t>(s)];
    params.coat_table = kernel::Int(0);
    params.coat_tables = table_.coat_tables.data();
    return params;
  }

  kernel::BsdfEval eval(kernel::Vec3 wo, kernel::Vec3 wi) const {
    return kernel::bsdf_model(kind)->eval(params(), wo, wi, transport, kernel::Mask::all());
  }
  kernel::BsdfSample sample(kernel::Vec3 wo, kernel::Float u_lobe, kernel::Vec2 u) const {
    return kernel::bsdf_model(kind)->sample(params(), wo, u_lobe, u, transport, kernel::Mask::all());
  }

  Eval eval(const Direction& wo, const Direction& wi) const {
    const kernel::BsdfEval e = eval(wide(wo), wide(wi));
    return {{e.f_cos.c[0].lane(0), e.f_cos.c[1].lane(0), e.f_cos.c[2].lane(0)}, e.pdf.lane(0)};
  }
  Sample sample(const Direction& wo, float u_lobe, float u0, float u1) const {
    return lane(sample(wide(wo), u_lobe, {u0, u1}), 0);
  }

  /// Calls f(sample) for each of about n samples of wo, made from independent random numbers.
  template <class F>
  void for_each_sample(const Direction& wo, int n, std::uint64_t seed, F&& f) const {
    std::mt19937_64 random(seed);
    const auto uniform = [&] {
      alignas(64) float u[kernel::kWidth];
      for (float& x : u) x = static_cast<float>(random() >> 40) * 0x1p-24f;
      return kernel::Float::load(u);
    };
    for (int i = 0; i < n; i += kernel::kWidth) {
      const kernel::Float u_lobe = uniform(), u0 = uniform(), u1 = uniform();
      for_each_lane(sample(wide(wo), u_lobe, {u0, u1}), f);
    }
  }

  /// Does what for_each_sample does, from the n points of a Hammersley set. For means.
  template <class F>
  void for_each_even_sample(const Direction& wo, int n, F&& f) const {
    const HammersleySet& set = HammersleySet::of(n);
    for (std::size_t i = 0; i < set.x.size(); i += kernel::kWidth) {
      const auto load = [i](const std::vector<float>& u) { return kernel::Float::load_unaligned(&u[i]); };
      for_each_lane(sample(wide(wo), load(set.x), {load(set.y), load(set.z)}), f);
    }
  }

  template <class F>
  static void for_each_lane(const kernel::BsdfSample& s, F&& f) {
    float x[16], y[16], z[16], weight[3][16], pdf[16], eta[16];
    store(s.wi.x, x), store(s.wi.y, y), store(s.wi.z, z), store(s.pdf, pdf), store(s.eta, eta);
    for (int c = 0; c < 3; ++c) store(s.weight.c[c], weight[c]);
    const std::uint32_t valid = s.valid.bits(), specular = s.specular.bits(),
                        transmission = s.transmission.bits();
    for (int i = 0; i < kernel::kWidth; ++i) {
      f(Sample{{x[i], y[i], z[i]},
               {weight[0][i], weight[1][i], weight[2][i]},
               pdf[i],
               eta[i],
               (valid >> i & 1) != 0,
               (specular >> i & 1) != 0,
               (transmission >> i & 1) != 0});
    }
  }

 private:
  static Sample lane(const kernel::BsdfSample& s, int index) {
    Sample result{};
    int i = 0;
    for_each_lane(s, [&](const Sample& sample) {
      if (i++ == index) result = sample;
    });
    return result;
  }

  std::array<float, 3> spectra_[render::kMaterialSpectra];
  std::vector<float> scalars_, extended_;
  render::MaterialTable table_;
};

/// Copper, at wavelengths of about red, green and blue.
inline constexpr BsdfCase::Color kCopperEta{0.20f, 0.92f, 1.10f}, kCopperK{3.91f, 2.45f, 2.14f};

inline std::string number(float x) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", x);
  return text;
}

/// "beckmann", "separable" and so on.
inline std::string names_of(std::int32_t flags) {
  std::string names;
  if (flags & render::kBeckmann) names += " beckmann";
  if (flags & render::kSeparableMasking) names += " separable";
  if (flags & render::kTinted) names += " tinted";
  if (flags & render::kNonlinear) names += " nonlinear";
  if (flags & render::kBalanced) names += " balanced";
  if (flags & render::kHasTextures) names += " textured";
  return names;
}

inline BsdfCase conductor(float alpha_x, float alpha_y, BsdfCase::Color eta = kCopperEta,
                          BsdfCase::Color k = kCopperK, std::int32_t flags = 0) {
  return {"conductor " + number(alpha_x) + " " + number(alpha_y) + names_of(flags),
          render::BsdfKind::kConductor,
          eta,
          k,
          {alpha_x, alpha_y},
          flags};
}
inline BsdfCase dielectric(float alpha_x, float alpha_y, float eta, std::int32_t flags = 0) {
  return {"dielectric " + number(alpha_x) + " " + number(alpha_y) + " eta " + number(eta) + names_of(flags),
          render::BsdfKind::kDielectric,
          {0.7f, 0.9f, 0.2f},  // with kTinted
          {0.7f, 0.5f, 1.0f},
          {alpha_x, alpha_y, eta},
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
inline BsdfCase plastic(float alpha, float eta, std::int32_t flags,
                        BsdfCase::Color rho = {0.8f, 0.4f, 0.1f}) {
  return {"plastic " + number(alpha) + " eta " + number(eta) + names_of(flags),
          render::BsdfKind::kPlastic,
          rho,
          {1.0f, 0.5f, 0.8f},
          {alpha, alpha, eta},
          flags};
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
          render::kSeparableMasking | (!thin && p.spec_trans > 0 ? render::kHasInside : 0),
          {p.metallic, p.spec_trans, p.spec_tint, p.sheen, p.sheen_tint, p.flatness, p.clearcoat,
           p.clearcoat_gloss, p.diff_trans}};
}
struct GltfParameters {
  float roughness = 0.5f, anisotropic = 0, eta = 1.5f;
  float metallic = 0, transmission = 0, specular = 1, coat = 0, coat_roughness = 0, sheen_roughness = 0,
        rotation = 0, behind = 0;
  bool volume = false;
  BsdfCase::Color base{0.8f, 0.5f, 0.2f}, specular_color{1, 1, 1};
};
/// With the sheen and the colour behind that all cases have.
inline BsdfCase gltf(const std::string& what, const GltfParameters& p) {
  return {"glTF " + what,
          render::BsdfKind::kGltf,
          p.base,
          p.specular_color,
          {p.roughness, p.anisotropic, p.eta},
          (p.volume ? render::kHasInside : 0) | (p.anisotropic > 0 ? render::kAnisotropic : 0),
          {p.metallic, p.transmission, p.specular, p.coat, p.coat_roughness, p.sheen_roughness, p.rotation,
           p.behind}};
}
inline BsdfCase thin_dielectric(float eta) {
  return {"thin dielectric eta " + number(eta), render::BsdfKind::kThinDielectric, {}, {}, {0, 0, eta}};
}
inline BsdfCase diffuse(BsdfCase::Color reflectance) {
  return {"diffuse", render::BsdfKind::kDiffuse, reflectance};
}
inline BsdfCase diffuse_transmission(BsdfCase::Color reflectance, BsdfCase::Color transmittance) {
  return {"diffuse transmission", render::BsdfKind::kDiffuseTransmission, reflectance, transmittance};
}

inline BsdfCase phong(float exponent, std::int32_t lobe, BsdfCase::Color base = {0.3f, 0.5f, 0.1f},
                      BsdfCase::Color gloss = {0.6f, 0.3f, 0.4f}) {
  const char* const name = lobe == render::kBlinn        ? "blinn "
                           : lobe == render::kMirrorLobe ? "mirror "
                                                         : "phong ";
  return {name + number(exponent), render::BsdfKind::kPhong, base, gloss, {0, 0, exponent}, lobe};
}

/// Every model with parameters from one end of their range to the other.
inline std::vector<BsdfCase> all_cases() {
  std::vector<BsdfCase> cases{diffuse({0.9f, 0.5f, 0.1f}),
                              diffuse_transmission({0.5f, 0.2f, 0.1f}, {0.1f, 0.3f, 0.4f}),
                              diffuse_transmission({0, 0, 0}, {0.9f, 0.9f, 0.9f}), thin_dielectric(1.5f)};
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
  for (const std::int32_t flags :
       {kMitsuba, std::int32_t{render::kSeparableMasking}, std::int32_t{render::kBeckmann}}) {
    for (const auto& [x, y] :
         {std::array{0.02f, 0.02f}, std::array{0.3f, 0.3f}, std::array{1.0f, 1.0f}, std::array{0.1f, 0.5f}}) {
      cases.push_back(conductor(x, y, kCopperEta, kCopperK, flags | render::kTinted));
      cases.push_back(dielectric(x, y, 1.5f, flags | render::kTinted));
      if (x == y) cases.push_back(plastic(x, 1.5f, flags));
    }
    cases.push_back(dielectric(0.2f, 0.2f, 1 / 1.5f, flags));
  }
  // With multiple scattering between the facets.
  for (const auto& [x, y] :
       {std::array{0.02f, 0.02f}, std::array{0.3f, 0.3f}, std::array{1.0f, 1.0f}, std::array{0.1f, 0.6f}}) {
    cases.push_back(conductor(x, y, kCopperEta, kCopperK, render::kBalanced));
    for (const float eta : {1 / 1.5f, 1.1f, 1.5f}) cases.push_back(dielectric(x, y, eta, render::kBalanced));
  }
  cases.push_back(
      conductor(0.4f, 0.4f, kCopperEta, kCopperK, kMitsuba | render::kBalanced | render::kTinted));
  cases.push_back(dielectric(0.4f, 0.4f, 1.5f, render::kBalanced | render::kHasTextures));
  cases.push_back(plastic(0, 1.5f, 0));
  cases.push_back(plastic(0, 1.9f, render::kNonlinear));
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

/// Where the path comes from: along the normal, oblique, grazing, from below.
inline std::vector<Direction> all_wo() {
  return {direction(0, 0),     direction(30, 40),  direction(60, 200), direction(85, -70),
          direction(89.9, 10), direction(150, 25), direction(92, 100)};
}

}  // namespace tessera::test

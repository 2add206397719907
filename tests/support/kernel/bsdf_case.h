// One material for the tests of the BSDF models, and the models called with plain double directions.
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
#include "render/bsdf/tables/film_table.h"
#include "render/bsdf/tables/gltf_layer_table.h"
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

/// A number for each component of light: red, green and blue, or wavelengths where the test is compiled for
/// those (TESSERA_SPECTRAL).
inline constexpr std::size_t kComponents = kernel::kSpectrumLanes;
using Components = std::array<double, kComponents>;

/// One lane of a BsdfEval.
struct Eval {
  Components f_cos;
  double pdf;
};

/// One lane of a BsdfSample.
struct Sample {
  Direction wi;
  Components weight;
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
           std::vector<float> scalars = {}, std::int32_t material_variants = 0,
           std::vector<float> extended = {}, std::int32_t material_flags = 0)
      : name(std::move(case_name)),
        kind(bsdf_kind),
        flags(material_flags),
        variants(material_variants),
        spectra_{spectrum0, spectrum1},
        scalars_(std::move(scalars)),
        extended_(std::move(extended)) {
    scalars_.resize(render::kMaterialScalars);
    extended_.resize(render::kExtendedScalars);
    if (kind == render::BsdfKind::kCoatedDiffuse) render::append_coat_table(scalars_[2], 0, table_);
    const bool beckmann = (variants & render::kBeckmann) != 0,
               separable = (variants & render::kSeparableMasking) != 0;
    if (variants & render::kBalanced) {
      const bool textured = (flags & render::kHasTextures) != 0;
      render::append_balance_table(
          {textured ? 0 : scalars_[0], textured ? 0 : scalars_[1], textured, beckmann, separable,
           kind == render::BsdfKind::kDielectric ? scalars_[2] : 0},
          table_);
    }
    if (kind == render::BsdfKind::kGltf) render::append_layer_table(table_);
    if (flags & render::kUsesFurther) table_.film_table = films();
    if (kind == render::BsdfKind::kPlastic) {
      const double alpha = scalars_[0] < 1e-3f ? 0 : scalars_[0];
      render::append_plastic_table(scalars_[2], {alpha, beckmann, separable}, table_);
    }
  }

  std::string name;
  render::BsdfKind kind;
  std::int32_t flags;  // render::MaterialFlags
  std::int32_t variants;
  kernel::Transport transport = kernel::Transport::kRadiance;
  Color extended_color{0.9f, 0.5f,
                       0.2f};  // tint of conductors with kTinted; sheen of glTF, and its light behind

  // With kUsesFurther
  Color further_color{1, 0.5f, 1};  // direction of glTF's anisotropy
  std::vector<float> further = std::vector<float>(render::kFurtherScalars);
  Direction upper_normal{0, 0, 1};

  float scalar(int i) const { return scalars_[static_cast<std::size_t>(i)]; }

  float extended(int i) const { return extended_[static_cast<std::size_t>(i)]; }

  /// The index of a dielectric for a component, where it disperses as glTF has it.
  double index(std::size_t component) const {
#ifdef TESSERA_SPECTRAL
    // Cauchy's formula through the Fraunhofer lines.
    constexpr double kD = 587.56, kF = 486.13, kC = 656.27;
    const double nm = wavelengths_nm_[component];
    const double part = 2 * (1 / (nm * nm) - 1 / (kD * kD)) / (1 / (kF * kF) - 1 / (kC * kC));
#else
    const double part = static_cast<double>(component) - 1;
#endif
    return scalar(render::slot::kEta) + double{further[render::slot::kSpread]} * part;
  }

  kernel::BsdfParams params() const {
    kernel::BsdfParams params;
    for (int s = 0; s < render::kMaterialSpectra; ++s) {
      for (int c = 0; c < kernel::kSpectrumLanes; ++c) params.spectra[s].c[c] = spectra_[s][c % 3];
    }
    for (int s = 0; s < render::kMaterialScalars; ++s) params.scalars[s] = scalar(s);
    params.flags = kernel::Int(flags);
    params.some_flags = flags;
    params.variants = kernel::Int(variants);
    params.some_variants = variants;
    for (kernel::Spectrum& tint : params.extended_spectra) {
      for (int c = 0; c < kernel::kSpectrumLanes; ++c)
        tint.c[c] = extended_color[static_cast<std::size_t>(c % 3)];
    }
    for (int s = 0; s < render::kExtendedScalars; ++s)
      params.extended[s] = extended_[static_cast<std::size_t>(s)];
#ifdef TESSERA_SPECTRAL
    for (std::size_t c = 0; c < kComponents; ++c) params.wavelengths.c[c] = kernel::Float(wavelengths_nm_[c]);
    params.luminance = kernel::luminance(spectra_[0][0], spectra_[0][1], spectra_[0][2]);
#endif
    params.coat_table = kernel::Int(0);
    params.coat_tables = table_.coat_tables.data();
    if (flags & render::kUsesFurther) set_further(params);
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
    Eval result{{}, e.pdf.lane(0)};
    for (std::size_t c = 0; c < kComponents; ++c) result.f_cos[c] = e.f_cos.c[c].lane(0);
    return result;
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
    float x[16], y[16], z[16], weight[kComponents][16], pdf[16], eta[16];
    store(s.wi.x, x), store(s.wi.y, y), store(s.wi.z, z), store(s.pdf, pdf), store(s.eta, eta);
    for (std::size_t c = 0; c < kComponents; ++c) store(s.weight.c[c], weight[c]);
    const std::uint32_t valid = s.valid.bits(), specular = s.specular.bits(),
                        transmission = s.transmission.bits();
    for (int i = 0; i < kernel::kWidth; ++i) {
      Sample sample{
          {x[i], y[i], z[i]},          {}, pdf[i], eta[i], (valid >> i & 1) != 0, (specular >> i & 1) != 0,
          (transmission >> i & 1) != 0};
      for (std::size_t c = 0; c < kComponents; ++c) sample.weight[c] = weight[c][i];
      f(sample);
    }
  }

 private:
  void set_further(kernel::BsdfParams& params) const {
    params.film_table = table_.film_table.data();
    for (kernel::Color& color : params.further_colors) {
      for (std::size_t c = 0; c < 3; ++c) color.c[c] = further_color[c];
    }
    for (int s = 0; s < render::kFurtherScalars; ++s)
      params.further[s] = further[static_cast<std::size_t>(s)];
    params.upper_normal = wide(upper_normal);
    if (flags & render::kPrepared)
      kernel::bsdf_model(kind)->prepare(kernel::TexturePoint::at({0.5f, 0.5f}), kernel::Mask::all(), params);
  }
  static const std::vector<float>& films() {
    static const std::vector<float> table = render::film_table();
    return table;
  }
  static Sample lane(const kernel::BsdfSample& s, int index) {
    Sample result{};
    int i = 0;
    for_each_lane(s, [&](const Sample& sample) {
      if (i++ == index) result = sample;
    });
    return result;
  }

  /// A random set for each name.
  static std::array<float, kComponents> wavelengths_of(const std::string& name) {
    std::seed_seq seed(name.begin(), name.end());
    std::mt19937 random(seed);
    std::array<float, kComponents> nm;
    for (float& one : nm) one = std::uniform_real_distribution<float>(380, 780)(random);
    return nm;
  }

  std::array<float, 3> spectra_[render::kMaterialSpectra];
  std::array<float, kComponents> wavelengths_nm_ = wavelengths_of(name);
  std::vector<float> scalars_, extended_;
  render::MaterialTable table_;
};

inline std::string number(float x) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", x);
  return text;
}

}  // namespace tessera::test

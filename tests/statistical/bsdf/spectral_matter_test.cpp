// Closed forms at single wavelengths: metals by Fresnel's formulas, and thin films by matrices of layers.
// Compiled with TESSERA_SPECTRAL.
#include <gtest/gtest.h>

#include <complex>

#include "render/bsdf/model/gltf/thin_film.h"
#include "spectra/matter/metals.h"
#include "support/kernel/bsdf_cases.h"

namespace tessera::test {
namespace {

using Complex = std::complex<double>;

/// The part of light that a boundary reflects at this cosine, of both polarisations [Born & Wolf, 14.2].
double fresnel(double cosine, Complex index) {
  const Complex within = std::sqrt(index * index - (1 - cosine * cosine));
  const Complex s = (cosine - within) / (cosine + within),
                p = (index * index * cosine - within) / (index * index * cosine + within);
  return (std::norm(s) + std::norm(p)) / 2;
}

TEST(Metals, ReflectAsFresnelHasItAtFiveWavelengths) {
  for (const char* name : {"Au", "Cu", "Al"}) {
    const auto metal = spectra::find_metal(name);
    ASSERT_TRUE(metal.has_value());
    // In the components of two materials.
    for (const std::array<double, 3>& nm : {std::array{420.0, 480.0, 540.0}, {540.0, 600.0, 680.0}}) {
      BsdfCase::Color eta, k;
      for (std::size_t c = 0; c < 3; ++c) {
        eta[c] = static_cast<float>(metal->eta.at(nm[c]));
        k[c] = static_cast<float>(metal->k.at(nm[c]));
      }
      const BsdfCase mirror = conductor(0, 0, eta, k);
      for (const double theta : {0.0, 45.0, 70.0, 85.0}) {
        const Sample sample = mirror.sample(direction(theta, 20), 0.5f, 0.5f, 0.5f);
        ASSERT_TRUE(sample.valid);
        for (std::size_t c = 0; c < 3; ++c) {
          EXPECT_NEAR(sample.weight[c], fresnel(std::cos(theta * M_PI / 180), {eta[c], k[c]}), 2e-5)
              << name << " at " << nm[c] << " nm, " << theta << " degrees";
        }
      }
    }
  }
}

/// The reflectance of layers between air and a base, by the product of their characteristic matrices
/// [Abeles 1950; Born & Wolf, 1.6.2], in the mean of both polarisations.
double layered(double cosine, const std::vector<std::array<double, 2>>& index_and_nm, double base,
               double nm) {
  double sum = 0;
  for (const bool is_p : {false, true}) {
    const auto inner_cosine = [&](double index) {
      return std::sqrt(Complex(1 - (1 - cosine * cosine) / (index * index)));
    };
    const auto admittance = [&](double index) {
      return is_p ? index / inner_cosine(index) : index * inner_cosine(index);
    };
    Complex b = 1, c = admittance(base);
    for (auto layer = index_and_nm.rbegin(); layer != index_and_nm.rend(); ++layer) {
      const auto& [index, thickness] = *layer;
      const Complex phase = 2 * M_PI * index * thickness * inner_cosine(index) / nm, eta = admittance(index);
      const Complex i(0, 1), next = std::cos(phase) * b + i * std::sin(phase) / eta * c;
      c = i * eta * std::sin(phase) * b + std::cos(phase) * c;
      b = next;
    }
    const Complex air = admittance(1);
    sum += std::norm((air * b - c) / (air * b + c)) / 2;
  }
  return sum;
}

/// Upper bound of what ThinFilm::reflectance() leaves out: from where a round trip's part is below 1e-3, or
/// from the 24th, all are taken to interfere like the last one, which is off by at most twice their sum.
double left_out(double cosine, double film, double base) {
  const auto inner_cosine = [&](double index) {
    return std::sqrt(std::max(0.0, 1 - (1 - cosine * cosine) / (index * index)));
  };
  const double c2 = inner_cosine(film), c3 = inner_cosine(base);
  const auto part = [](double above, double below) {
    const double trip = std::abs(above * below);
    const double all = (1 - above * above) * (1 - below * below) / (1 - trip * trip);
    return 2 * std::min(all * trip, std::max(1e-3, all * std::pow(trip, 24))) / (1 - trip);
  };
  return part((cosine - film * c2) / (cosine + film * c2),
              (film * c2 - base * c3) / (film * c2 + base * c3)) +
         part((film * cosine - c2) / (film * cosine + c2), (base * c2 - film * c3) / (base * c2 + film * c3));
}

TEST(ThinFilm, IsThatOfMatricesOfLayersAtEveryWavelength) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(0, 1);
  double worst = 0, sum = 0;
  constexpr int kFilms = 4000;
  for (int i = 0; i < kFilms; ++i) {
    const double eta = 1 + 1.5 * uniform(random), base = 1 + 2 * uniform(random),
                 thickness = 1500 * uniform(random), cosine = 0.05 + 0.95 * uniform(random);
    const double f0 = (base - 1) * (base - 1) / ((base + 1) * (base + 1));
    kernel::ThinFilm film;
    std::array<double, kComponents> nm;
    for (std::size_t c = 0; c < kComponents; ++c) {
      nm[c] = 380 + 400 * uniform(random);
      film.wavelengths.c[c] = kernel::Float(static_cast<float>(nm[c]));
    }
    film.table = nullptr;
    film.eta = static_cast<float>(eta), film.thickness_nm = static_cast<float>(thickness);
    const kernel::Spectrum reflected = film.reflectance(
        static_cast<float>(cosine), kernel::Spectrum(static_cast<float>(f0)), kernel::Mask::all());
    for (std::size_t c = 0; c < kComponents; ++c) {
      const double error =
          std::abs(reflected.c[c].lane(0) - layered(cosine, {{eta, thickness}}, base, nm[c]));
      // Phases of floats are off by 1e-4.
      EXPECT_LT(error, left_out(cosine, eta, base) + 3e-4)
          << eta << " over " << base << ", " << thickness << " nm at " << nm[c] << " nm, cosine " << cosine;
      worst = std::max(worst, error);
      sum += error / kComponents;
    }
  }
  EXPECT_LT(sum / kFilms, 1e-3);
  std::printf("films at single wavelengths: worst error %.5f, mean %.5f\n", worst, sum / kFilms);
}

/// What one wavelength has of a material is the same, whatever others the path has: pictures do not depend on
/// how wavelengths are sampled.
TEST(Layers, WavelengthsKnowNothingOfEachOther) {
  const auto layers = [](float others, float film) {
    return gltf("layers " + std::to_string(film), {.roughness = 0.4f,
                                                   .base = {0.8f, others / 4, others / 4},
                                                   .specular_color = {1, others, others},
                                                   .film = film});
  };
  const auto plastic = [](float others) {
    return phong(20, 0, {0.9f, others / 3, others / 3}, {0.7f, others / 3, others / 3});
  };
  const std::array<std::array<BsdfCase, 2>, 3> pairs = {
      {{layers(0.2f, 0), layers(3, 0)}, {layers(0.2f, 1), layers(3, 1)}, {plastic(0.1f), plastic(3)}}};
  for (const auto& [one, other] : pairs) {
    for (const double theta : {5.0, 40.0, 75.0}) {
      const Direction wo = direction(theta, 10), wi = direction(30, 200);
      const Eval a = one.eval(wo, wi), b = other.eval(wo, wi);
      // The series of a film ends where the parts of all wavelengths are below 1e-3.
      const double tolerance = one.flags & render::kPrepared ? 2e-3 : 1e-6;
      EXPECT_NEAR(a.f_cos[0], b.f_cos[0], tolerance * a.f_cos[0]) << one.name << ", " << theta;
      EXPECT_GT(std::abs(a.f_cos[1] - b.f_cos[1]), 0.01 * b.f_cos[1]) << one.name << ", " << theta;
    }
  }
}

}  // namespace
}  // namespace tessera::test

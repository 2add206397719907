// Refraction by an index that varies with the wavelength, as kernels for wavelengths have it. Compiled with
// TESSERA_SPECTRAL.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "render/bsdf/material_slots.h"
#include "render/scene/spectral/spectral_builder.h"
#include "spectra/matter/dispersion.h"

namespace tessera::render::TESSERA_ISA {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

/// Smooth boundaries of a measured glass, met by paths of one hero wavelength.
class DispersionTest : public testing::Test {
 protected:
  void set_glass(const std::string& name, BsdfKind kind = BsdfKind::kDielectric) {
    formula_ = *spectra::find_dispersion(name);
    MaterialRecord& record = materials_.materials.emplace_back();
    record.kind = kind;
    record.flags = kAllDelta | kUsesAlphas | kUsesEta | kTransmits | kDisperses;
    const auto curve = builder_.add_varying([this](double nm) { return formula_.eta(nm); });
    ASSERT_TRUE(curve.has_value());
    record.scalars[slot::kEta].value = static_cast<float>(formula_.eta(589.3));
    record.eta_curve = *curve;
  }

  BsdfParams params_at(const Wavelengths& wavelengths) const {
    BsdfParams params;
    const MaterialRecord& record = materials_.materials.front();
    load_constants(materials_, Int(0), &record, Int(record.flags), Spectra(&tables_, wavelengths),
                   Mask::all(), params);
    return params;
  }
  BsdfParams params_at(double nm) const {
    Wavelengths wavelengths;
    for (int i = 0; i < kSpectrumLanes; ++i) wavelengths.c[i] = Float(static_cast<float>(nm) + 40.0f * i);
    return params_at(wavelengths);
  }

  /// Where light along `d` goes on from a boundary with this outward normal.
  static Vec3 go_on(const BsdfParams& params, Vec3 d, Vec3 normal, bool refracted) {
    const Frame frame = Frame::from_normal(normal);
    const BsdfSample sample = bsdf_model(BsdfKind::kDielectric)
                                  ->sample(params, frame.to_local(-d), Float(refracted ? 0.999999f : 0.0f),
                                           {Float(0.5f), Float(0.5f)}, Transport::kRadiance, Mask::all());
    EXPECT_TRUE(none(~sample.valid));
    EXPECT_EQ(none(~sample.transmission), refracted);
    return frame.to_world(sample.wi);
  }

  SpectralTables tables_;
  SpectralBuilder builder_{tables_};
  MaterialTable materials_;
  spectra::Dispersion formula_;
};

TEST_F(DispersionTest, PrismOfBk7TurnsLightOfEachLineByItsAngle) {
  set_glass("N-BK7");
  // Indices of Schott's catalogue, rounded to 5 digits, at the lines C, d, F and g.
  struct Line {
    double nm, index;
  };
  const double incidence = std::asin(1.5168 * 0.5);  // light of the line d passes the prism evenly
  for (const Line& line :
       {Line{656.2725, 1.51432}, {587.5618, 1.5168}, {486.1327, 1.52238}, {435.8343, 1.52668}}) {
    const double inside = std::asin(std::sin(incidence) / line.index);
    const double out = std::asin(line.index * std::sin(60 * kDegree - inside));
    const double expected = incidence + out - 60 * kDegree;

    // Faces whose outward normals are 120 degrees apart.
    const auto at = [](double angle) {
      return Vec3{Float(static_cast<float>(std::cos(angle))), Float(static_cast<float>(std::sin(angle))),
                  Float(0.0f)};
    };
    const Vec3 first = at(150 * kDegree), second = at(30 * kDegree);
    const BsdfParams params = params_at(line.nm);
    const Vec3 d = at(-30 * kDegree + incidence);
    const Vec3 behind = go_on(params, go_on(params, d, first, true), second, true);
    const double turned = std::atan2(double{d.y.lane(0)}, double{d.x.lane(0)}) -
                          std::atan2(double{behind.y.lane(0)}, double{behind.x.lane(0)});
    EXPECT_NEAR(turned / kDegree, expected / kDegree, 0.01) << line.nm;
  }
}

/// The angle from the point opposite the sun under which drops of water are brightest: the largest of rays
/// that are reflected once within them.
double rainbow(const BsdfParams& params, auto&& go_on) {
  double largest = 0;
  for (int first = 0; first < 4096; first += kWidth) {
    const Float height = (to_float(Int::iota(first)) + 0.5f) * (1.0f / 4096);
    const Vec3 d{Float(1.0f), Float(0.0f), Float(0.0f)};
    Vec3 at{-safe_sqrt(1.0f - sqr(height)), height, Float(0.0f)};
    Vec3 w = go_on(params, d, at, true);
    const auto across = [&] { at = normalize(at - w * (2.0f * dot(at, w))); };
    across();
    w = go_on(params, w, at, false);
    across();
    w = go_on(params, w, at, true);
    for (int lane = 0; lane < kWidth; ++lane)
      largest = std::max(largest, std::atan2(std::abs(double{w.y.lane(lane)}), -double{w.x.lane(lane)}));
  }
  return largest / kDegree;
}

TEST_F(DispersionTest, DropsOfWaterMakeARainbow) {
  set_glass("water");
  const auto seen_at = [&](double nm) {
    return rainbow(params_at(nm), [](const BsdfParams& params, Vec3 d, Vec3 normal, bool refracted) {
      return go_on(params, d, normal, refracted);
    });
  };
  for (const double nm : {380.0, 436.0, 486.0, 546.0, 589.3, 650.0, 700.0}) {
    // Descartes: the angle of incidence i of the ray that is turned least has cos^2 i = (n^2 - 1) / 3.
    const double n = formula_.eta(nm), i = std::acos(std::sqrt((n * n - 1) / 3));
    EXPECT_NEAR(seen_at(nm), (4 * std::asin(std::sin(i) / n) - 2 * i) / kDegree, 0.02) << nm;
  }
  EXPECT_NEAR(seen_at(650), 42.1, 0.2);
  EXPECT_NEAR(seen_at(380), 40.2, 0.2);
}

/// Means over all lobes of what is reflected at each wavelength, and of what is refracted at the first.
struct Shares {
  double reflected[kSpectrumLanes] = {}, refracted = 0;
};
Shares shares_of(const BsdfParams& params, BsdfKind kind, Vec3 wo) {
  constexpr int kSteps = 1 << 14;
  Shares shares;
  for (int first = 0; first < kSteps; first += kWidth) {
    const Float u = (to_float(Int::iota(first)) + 0.5f) * (1.0f / kSteps);
    const BsdfSample sample = bsdf_model(kind)->sample(params, wo, u, {Float(0.5f), Float(0.5f)},
                                                       Transport::kImportance, Mask::all());
    for (int lane = 0; lane < kWidth; ++lane) {
      const bool through = (sample.transmission.bits() >> lane & 1) != 0;
      for (int i = 0; i < kSpectrumLanes; ++i) {
        const double weight = double{sample.weight.c[i].lane(lane)} / kSteps;
        if (!through) shares.reflected[i] += weight;
        if (through && i == 0) shares.refracted += weight;
      }
    }
  }
  return shares;
}

TEST_F(DispersionTest, SmoothGlassReflectsAllWavelengthsAndRefractsTheFirst) {
  set_glass("diamond");
  const BsdfParams params = params_at(400);
  for (const double cosine : {1.0, 0.6, 0.2}) {
    for (const bool below : {false, true}) {
      const double sine = std::sqrt(1 - cosine * cosine);
      const Shares shares = shares_of(params, BsdfKind::kDielectric,
                                      {Float(static_cast<float>(sine)), Float(0.0f),
                                       Float(static_cast<float>(below ? -cosine : cosine))});
      const auto expected = [&](double nm) {
        const double eta = below ? 1 / formula_.eta(nm) : formula_.eta(nm),
                     cos_t2 = 1 - sine * sine / (eta * eta);
        if (cos_t2 <= 0) return 1.0;
        const double cos_t = std::sqrt(cos_t2), s = (cosine - eta * cos_t) / (cosine + eta * cos_t),
                     p = (eta * cosine - cos_t) / (eta * cosine + cos_t);
        return (s * s + p * p) / 2;
      };
      // A step of u and a sample's share of the mean of one lane.
      for (int i = 0; i < kSpectrumLanes; ++i)
        EXPECT_NEAR(shares.reflected[i], expected(400 + 40 * i), 3e-4) << cosine << " " << below << " " << i;
      const double eta = below ? 1 / formula_.eta(400) : formula_.eta(400);
      EXPECT_NEAR(shares.refracted, 1 - expected(400), 3e-4) << cosine << " " << below << " " << eta;
    }
  }
}

TEST_F(DispersionTest, SheetsKeepAllWavelengths) {
  set_glass("diamond", BsdfKind::kThinDielectric);
  const Shares shares =
      shares_of(params_at(400), BsdfKind::kThinDielectric, {Float(0.0f), Float(0.0f), Float(1.0f)});
  for (int i = 0; i < kSpectrumLanes; ++i) {
    const double eta = formula_.eta(400 + 40 * i), once = std::pow((eta - 1) / (eta + 1), 2);
    EXPECT_NEAR(shares.reflected[i], 2 * once / (1 + once), 3e-4);
  }
  const Passing passing = bsdf_model(BsdfKind::kThinDielectric)->passing(params_at(400), Float(1.0f));
  for (int i = 0; i < kSpectrumLanes; ++i) {
    const double eta = formula_.eta(400 + 40 * i), once = std::pow((eta - 1) / (eta + 1), 2);
    EXPECT_NEAR(double{(passing.weight.c[i] * passing.probability).lane(0)}, (1 - once) / (1 + once), 1e-5);
  }
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA

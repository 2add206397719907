// Reflection and refraction at angles where the answer is known.
#include <gtest/gtest.h>

#include "render/bsdf/fresnel.h"
#include "support/kernel/bsdf_cases.h"

namespace tessera::test {
namespace {

constexpr double kRounding = 2e-6;  // some tens of operations of 6e-8 each, on numbers of at most 1

double dielectric_reflectance(double cos_i, double eta) {
  return kernel::fresnel_dielectric(kernel::Float(static_cast<float>(cos_i)), static_cast<float>(eta))
      .reflectance.lane(0);
}
double conductor_reflectance(double cos_i, double eta, double k) {
  return kernel::fresnel_conductor(kernel::Float(static_cast<float>(cos_i)), static_cast<float>(eta),
                                   kernel::Float(static_cast<float>(k)))
      .lane(0);
}

TEST(Fresnel, NormalIncidence) {
  EXPECT_NEAR(dielectric_reflectance(1, 1.5), 0.04, kRounding);
  EXPECT_NEAR(dielectric_reflectance(1, 1 / 1.5), 0.04, kRounding);
  EXPECT_NEAR(dielectric_reflectance(1, 3), 0.25, kRounding);
  // ((n - 1)^2 + k^2) / ((n + 1)^2 + k^2)
  EXPECT_NEAR(conductor_reflectance(1, 0.2, 3.9), (0.64 + 15.21) / (1.44 + 15.21), kRounding);
}

TEST(Fresnel, BrewsterAngle) {
  // There only the perpendicular component is left: R = ((eta^2 - 1) / (eta^2 + 1))^2 / 2.
  for (const double eta : {1.33, 1.5, 3.0, 1 / 1.5}) {
    const double cosine = 1 / std::sqrt(1 + eta * eta);
    EXPECT_NEAR(dielectric_reflectance(cosine, eta), 0.5 * std::pow((eta * eta - 1) / (eta * eta + 1), 2),
                kRounding);
  }
}

TEST(Fresnel, TotalReflection) {
  const double critical = std::sqrt(1 - 1 / 2.25);  // cosine, from the inside of index 1.5
  EXPECT_EQ(dielectric_reflectance(critical - 1e-4, 1 / 1.5), 1);
  EXPECT_EQ(dielectric_reflectance(0, 1 / 1.5), 1);
  EXPECT_LT(dielectric_reflectance(critical + 1e-3, 1 / 1.5), 0.95);
}

TEST(Fresnel, EqualIndicesReflectNothing) {
  for (const double cosine : {1.0, 0.5, 1e-3, 1e-6}) EXPECT_EQ(dielectric_reflectance(cosine, 1), 0);
}

TEST(Fresnel, ConductorWithoutAbsorptionIsADielectric) {
  for (const double eta : {1.3, 1.5, 3.0}) {
    for (const double cosine : {1.0, 0.8, 0.4, 0.05}) {
      EXPECT_NEAR(conductor_reflectance(cosine, eta, 0), dielectric_reflectance(cosine, eta), 5 * kRounding);
    }
  }
}

TEST(Fresnel, StaysInRangeForAnyIndex) {
  for (const double eta : {0.0, 1e-6, 1.0, 1e4, 1e20}) {
    for (const double k : {0.0, 1e-6, 1.0, 1e4, 1e20}) {
      for (const double cosine : {0.0, 1e-7, 0.5, 1.0}) {
        const double r = conductor_reflectance(cosine, eta, k);
        EXPECT_TRUE(r >= -kRounding && r <= 1 + kRounding) << eta << " " << k << " " << cosine << ": " << r;
      }
    }
  }
}

TEST(Dielectric, ObeysSnell) {
  for (const float eta : {1.5f, 1 / 1.5f, 3.0f}) {
    const BsdfCase bsdf = dielectric(0, 0, eta);
    for (const double theta : {10.0, 40.0, 70.0, 130.0, 170.0}) {
      SCOPED_TRACE(bsdf.name + ", theta_o = " + std::to_string(theta));
      const Direction wo = direction(theta, 30);
      const double relative = wo[2] > 0 ? eta : 1 / eta;
      const double sine = std::sqrt(1 - wo[2] * wo[2]) / relative;
      const Sample s = bsdf.sample(wo, 0x1.fffffep-1f, 0.5f, 0.5f);
      ASSERT_TRUE(s.valid && s.specular);
      EXPECT_EQ(s.transmission, sine < 1);
      if (!s.transmission) continue;
      EXPECT_NEAR(std::hypot(s.wi[0], s.wi[1]), sine, kRounding);
      EXPECT_NEAR(s.wi[0] * wo[1], s.wi[1] * wo[0], kRounding);  // wi lies in the plane of incidence
      EXPECT_LT(s.wi[0] * wo[0], 0);
      EXPECT_LT(s.wi[2] * wo[2], 0);
      EXPECT_NEAR(s.eta, relative, kRounding);
      EXPECT_NEAR(s.weight[0] * relative * relative, 1, kRounding);
      EXPECT_NEAR(s.pdf, 1 - dielectric_reflectance(std::abs(wo[2]), relative), kRounding);
    }
  }
}

TEST(Dielectric, EqualIndicesLetLightGoStraightOn) {
  for (const float alpha : {0.0f, 0.5f}) {
    const Direction wo = direction(50, 20);
    const Sample s = dielectric(alpha, alpha, 1).sample(wo, 0, 0.3f, 0.7f);
    ASSERT_TRUE(s.valid && s.specular && s.transmission);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(s.wi[i], -wo[i], kRounding);
  }
}

TEST(ThinDielectric, SumsAllOrders) {
  // R + T^2 R / (1 - R^2) with R = 0.04: 2 R / (1 + R).
  const Direction wo = direction(0, 0);
  EXPECT_NEAR(thin_dielectric(1.5f).sample(wo, 0, 0.5f, 0.5f).pdf, 0.08 / 1.04, kRounding);
  const Sample through = thin_dielectric(1.5f).sample(wo, 0.99f, 0.5f, 0.5f);
  EXPECT_TRUE(through.transmission);
  EXPECT_EQ(through.wi[2], -1);
  EXPECT_EQ(through.eta, 1);
}

TEST(Conductor, MirrorReflectsByFresnel) {
  const Direction wo = direction(60, 45);
  const Sample s = conductor(0, 0).sample(wo, 0.5f, 0.5f, 0.5f);
  ASSERT_TRUE(s.valid && s.specular);
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(s.weight[c], conductor_reflectance(wo[2], kCopperEta[c], kCopperK[c]), kRounding);
  EXPECT_NEAR(s.wi[0], -wo[0], kRounding);
  EXPECT_NEAR(s.wi[2], wo[2], kRounding);
}

}  // namespace
}  // namespace tessera::test

// Models of the Mitsuba format against closed forms and against models that they contain.
#include <gtest/gtest.h>

#include "support/kernel/bsdf_cases.h"

namespace tessera::test {
namespace {

constexpr double kMitsubaRounding = 1e-5;

TEST(Principled, WhiteGlassIsARoughDielectric) {
  constexpr float kRoughness = 0.6f;
  const BsdfCase glass("white glass", render::BsdfKind::kPrincipled, {1, 1, 1}, {}, {kRoughness, 0, 1.5f},
                       render::kSeparableMasking, {0, 1}, render::kHasInside);
  const BsdfCase boundary =
      dielectric(kRoughness * kRoughness, kRoughness * kRoughness, 1.5f, render::kSeparableMasking);
  for (const Direction& wo : {direction(20, 0), direction(70, 30), direction(130, 60)}) {
    for (const Direction& wi :
         {direction(40, 100), direction(75, 210), direction(110, 200), direction(165, 300)}) {
      const Eval mine = glass.eval(wo, wi), expected = boundary.eval(wo, wi);
      EXPECT_NEAR(mine.f_cos[0], expected.f_cos[0], kMitsubaRounding * (1 + expected.f_cos[0]));
      EXPECT_NEAR(mine.pdf, expected.pdf, kMitsubaRounding * (1 + expected.pdf));
    }
  }
}

TEST(Principled, MetalIsSchlicksMirror) {
  // Along the normal the reflectance is the base colour: f cos = colour D / 4 with D = 1 / (pi alpha^2).
  const BsdfCase metal = principled("metal", {.roughness = 0.5f, .metallic = 1});
  const Direction up{0, 0, 1};
  const double density = 1 / (M_PI * 0.25 * 0.25);
  const double colour[] = {0.8, 0.5, 0.2};
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(metal.eval(up, up).f_cos[c], colour[c] * density / 4, 1e-4);
}

TEST(PrincipledThin, FullDiffuseTransmissionIsLambertian) {
  const BsdfCase leaf = principled("leaf", {.diff_trans = 2}, true);
  const Direction wo = direction(30, 0), through = direction(140, 80);
  EXPECT_NEAR(leaf.eval(wo, through).f_cos[0], 0.8 * -through[2] / M_PI, kMitsubaRounding);
  EXPECT_EQ(leaf.eval(wo, direction(40, 80)).f_cos[0], 0);
}

TEST(Plastic, SmoothCoatHasAClosedForm) {
  // Along the normal T = 0.96; inside 1.5 the fitted diffuse reflectance is R.
  const double r = -1.4399 / 2.25 + 0.7099 / 1.5 + 0.6681 + 0.0636 * 1.5;
  const Direction up{0, 0, 1};
  for (const bool nonlinear : {false, true}) {
    const BsdfCase bsdf = plastic(0, 1.5f, nonlinear ? render::kNonlinear : 0, {0.8f, 0.4f, 0.1f});
    const double rho[] = {0.8, 0.4, 0.1};
    for (int c = 0; c < 3; ++c) {
      const double base = rho[c] / (1 - (nonlinear ? rho[c] : 1) * r);
      EXPECT_NEAR(bsdf.eval(up, up).f_cos[c], base * 0.96 * 0.96 / (M_PI * 2.25), kMitsubaRounding);
    }
  }
}

TEST(Tints, AreFactorsOfTheLight) {
  const Direction wo = direction(40, 0), mirrored = direction(40, 180), through = direction(155, 180);
  const BsdfCase plain = dielectric(0.3f, 0.3f, 1.5f), tinted = dielectric(0.3f, 0.3f, 1.5f, render::kTinted);
  const double reflection[] = {0.7, 0.9, 0.2}, transmission[] = {0.7, 0.5, 1.0};
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(tinted.eval(wo, mirrored).f_cos[c], reflection[c] * plain.eval(wo, mirrored).f_cos[c],
                kMitsubaRounding);
    EXPECT_NEAR(tinted.eval(wo, through).f_cos[c], transmission[c] * plain.eval(wo, through).f_cos[c],
                kMitsubaRounding);
  }
  EXPECT_EQ(tinted.eval(wo, through).pdf, plain.eval(wo, through).pdf);
}

}  // namespace
}  // namespace tessera::test

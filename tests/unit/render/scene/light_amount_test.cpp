// Lights as bright as their amounts and their photometric files say.
#include "render/scene/light/light_amount.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "photometry/lamps/lamp_file.h"
#include "render/light/light_source.h"
#include "render/scene/light/light_builder.h"
#include "render/scene/light/photometric_map.h"
#include "render/scene/spectral/spectral_builder.h"
#include "unit/lib/photometry/sample_lamps.h"
#include "unit/render/scene/builder_inputs.h"

namespace tessera::render {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kPi = std::numbers::pi;
constexpr double kFloat = 1e-6;  // some roundings of a float

/// Stands for the kernels' models: a plane of 2 m^2, or a ball with textures of mean 0.25.
class FakeSource final : public LightSource {
 public:
  FakeSource() : LightSource({}) {}
  double power(const LightTable&, const LightRecord&) const override { return 1; }
  LightBounds bounds(const LightTable&, const LightRecord&) const override {
    LightBounds bounds;
    bounds.angle = is_curved ? kPi : 0;
    return bounds;
  }
  std::array<double, kBands> emitted_flux(const LightTable& table, std::int32_t light,
                                          std::int32_t) const override {
    std::array<double, kBands> flux{};
    for (std::size_t band = 0; band < flux.size(); ++band)
      flux[band] = 0.25 * 2 * kPi * table.lights[static_cast<std::size_t>(light)].radiance[band];
    return flux;
  }
  void append(const ShapeTable&, const ShapeRecord&, const LightRecord& light, float,
              std::vector<LightRecord>& lights) const override {
    lights.push_back(light);
    lights.back().area = 2;
    // Two triangles of one rectangle.
    lights.push_back(lights.back());
    lights.back().same_as = static_cast<std::int32_t>(lights.size()) - 2;
  }
  static inline bool is_curved = false;
};

const LightSource& fake_source_of(LightKind) {
  static const FakeSource source;
  return source;
}

std::optional<LightKind> fake_kind_on_shape(ShapeKind) { return LightKind::kRectangle; }

class LightAmountTest : public testing::Test {
 protected:
  LightAmountTest() { textures_.add_constant("grey", 0.25f); }
  void SetUp() override {
    FakeSource::is_curved = false;
    table_.sources = {&fake_source_of, &fake_kind_on_shape};
    shapes_.shapes.resize(1);
    shapes_.shapes[0].kind = ShapeKind::kDisk;
    blobs_.add("downlight", photometry::symmetric_ies());
    blobs_.add("street", photometry::full_ies());
    blobs_.add("broken", "IES:LM-63-2019\nTILT=NONE\n1 -1 x");
  }

  LightInputs inputs() {
    return {.space = space_,
            .blobs = blobs_.source,
            .algorithm = kSurfacesAlone,
            .textures = textures_,
            .spectral = spectral_,
            .warnings = &warnings_,
            .scale = scale_};
  }
  absl::Status add(const std::string& light) {
    LightBuilder builder(inputs(), table_);
    if (auto s = builder.add_lights(message<v1::Scene>("lights { name: 'lamp' " + light + " }").lights());
        !s.ok())
      return s;
    return builder.settle_amounts();
  }
  absl::Status add_area_light(const std::string& text) {
    const auto light = message<v1::AreaLight>(text);
    LightBuilder builder(inputs(), table_);
    if (auto s = builder.add_area_lights({{0, &light, "shape 0 (panel)"}}, shapes_); !s.ok()) return s;
    return builder.settle_amounts();
  }
  /// The green of the light that was added last.
  double brightness(const std::string& light) {
    const absl::Status status = add(light);
    EXPECT_TRUE(status.ok()) << status << " " << light;
    return table_.lights.empty() ? 0 : table_.lights.back().radiance[1];
  }
  double area_brightness(const std::string& light) {
    const absl::Status status = add_area_light(light);
    EXPECT_TRUE(status.ok()) << status << " " << light;
    return table_.lights.empty() ? 0 : table_.lights.back().radiance[1];
  }
  std::string refusal(const std::string& light) { return std::string(add(light).message()); }

  const RenderSpace space_ = render_space_about({0, 0, 0});
  BlobsInMemory blobs_;
  NamedTextures textures_;
  ShapeTable shapes_;
  LightTable table_;
  SceneScale scale_{.says_metres = true};
  SpectralBuilder* spectral_ = nullptr;
  std::vector<std::string> warnings_;
};

constexpr const char* kWhite = "intensity { constant: 7 } ";

TEST_F(LightAmountTest, PointsHaveTheirFluxOrIntensity) {
  const std::string point = absl::StrCat("point { ", kWhite, "} scale: 3 ");
  EXPECT_NEAR(brightness(point + "amount { value: 800 unit: 'lm' }"), 800 / 683.0 / (4 * kPi), kFloat);
  EXPECT_NEAR(brightness(point + "amount { value: 5 unit: 'W' }"), 5 / (4 * kPi), kFloat);
  EXPECT_NEAR(brightness(point + "amount { value: 1.366 unit: 'kcd' }"), 2, kFloat);
  EXPECT_NEAR(brightness(point + "amount { value: 3 unit: 'W/sr' }"), 3, kFloat);
  EXPECT_EQ(brightness(point + "amount { value: 0 unit: 'lm' }"), 0);
  EXPECT_THAT(warnings_, IsEmpty());
}

TEST_F(LightAmountTest, ColoursKeepTheirHueAndLoseTheirLuminance) {
  const std::string orange =
      "point { intensity { rgb { r: 10 g: 5 b: 1 } } } amount { value: 683 unit: 'cd' }";
  ASSERT_EQ(add(orange), absl::OkStatus());
  const float* const rgb = table_.lights.back().radiance;
  EXPECT_NEAR(luminance_of({rgb[0], rgb[1], rgb[2]}), 1, kFloat);
  EXPECT_NEAR(rgb[0] / rgb[1], 2, kFloat);
  EXPECT_THAT(refusal("point { intensity { constant: 0 } } amount { value: 1 unit: 'cd' }"),
              HasSubstr("its colour is black"));
}

TEST_F(LightAmountTest, SpotsFillTheirCones) {
  // A hemisphere, sharp; a cone that falls off; the same linear in the angle.
  const auto spot = [](const char* shape) {
    return absl::StrCat("spot { target { z: 1 } ", kWhite, shape, " } amount { value: 683 unit: 'lm' }");
  };
  EXPECT_NEAR(brightness(spot("cone_angle_degrees: 90")), 1 / (2 * kPi), kFloat);
  // Midpoints of the falloff.
  const auto summed = [](auto&& falloff) {
    double sum = 0;
    for (int i = 0; i < 100000; ++i) {
      const double a = (i + 0.5) / 100000 * kPi / 3;
      sum += 2 * kPi * std::sin(a) * falloff(a) * kPi / 3 / 100000;
    }
    return sum;
  };
  const double inner = kPi / 4, outer = kPi / 3;
  const double smooth = summed([&](double a) {
    const double t =
        std::clamp((std::cos(a) - std::cos(outer)) / (std::cos(inner) - std::cos(outer)), 0.0, 1.0);
    return t * t * (3 - 2 * t);
  });
  const double linear = summed([&](double a) { return std::clamp((outer - a) / (outer - inner), 0.0, 1.0); });
  EXPECT_NEAR(brightness(spot("cone_angle_degrees: 60 cone_delta_degrees: 15")) * smooth, 1, 1e-5);
  EXPECT_NEAR(brightness(spot("cone_angle_degrees: 60 cone_delta_degrees: 15 falloff: LINEAR")) * linear, 1,
              1e-5);
  EXPECT_NEAR(
      brightness(absl::StrCat("spot { target { z: 1 } ", kWhite, " } amount { value: 683 unit: 'cd' }")), 1,
      kFloat);
}

TEST_F(LightAmountTest, ProjectionsFillTheirPyramids) {
  // A sixth of all directions; an even screen is 4 tan^2 of itself.
  const std::string slide = absl::StrCat("projection { fov_degrees: 90 ", kWhite);
  EXPECT_NEAR(brightness(slide + "} amount { value: 683 unit: 'lm' }") * 4 * kPi / 6, 1, kFloat);
  EXPECT_NEAR(brightness(slide + "even_screen: true } amount { value: 683 unit: 'lm' }") * 4, 1, kFloat);
}

TEST_F(LightAmountTest, ParallelLightAndSkiesHaveIrradiance) {
  EXPECT_NEAR(
      brightness(
          "distant { direction { z: -1 } irradiance { constant: 9 } } amount { value: 68300 unit: 'lx' }"),
      100, 1e-4);
  EXPECT_NEAR(
      brightness(
          "distant { direction { z: -1 } irradiance { constant: 9 } } amount { value: 5 unit: 'W/m2' }"),
      5, kFloat);
  EXPECT_NEAR(
      brightness("infinite { radiance { constant: 9 } scale: 4 } amount { value: 1366 unit: 'cd/m2' }"), 2,
      kFloat);
  EXPECT_NEAR(brightness("infinite { radiance { constant: 9 } } amount { value: 683 unit: 'lx' }") * kPi, 1,
              kFloat);
}

TEST_F(LightAmountTest, AreasHaveFluxIntensityOrRadiance) {
  const std::string white = "radiance { constant: 5 } scale: 2 ";
  EXPECT_NEAR(area_brightness(white + "amount { value: 683 unit: 'lm' }") * kPi * 2, 1, kFloat);
  EXPECT_NEAR(area_brightness(white + "two_sided: true amount { value: 683 unit: 'lm' }") * kPi * 4, 1,
              kFloat);
  EXPECT_NEAR(area_brightness(white + "amount { value: 683 unit: 'cd' }") * 2, 1, kFloat);
  EXPECT_NEAR(area_brightness(white + "amount { value: 683 unit: 'nit' }"), 1, kFloat);
  EXPECT_NEAR(area_brightness(white + "amount { value: 3 unit: 'W/(m2 sr)' }"), 3, kFloat);
  // The texture sends a quarter; both parts of a rectangle are the same light.
  EXPECT_NEAR(area_brightness(white + "texture: 'grey' amount { value: 683 unit: 'lm' }") * kPi * 2 * 0.25, 1,
              kFloat);
  EXPECT_EQ(table_.lights[0].radiance[0], table_.lights[1].radiance[0]);
  FakeSource::is_curved = true;
  EXPECT_THAT(std::string(add_area_light(white + "amount { value: 1 unit: 'cd' }").message()),
              AllOf(HasSubstr("shape 0 (panel): area light: amount: intensity is that along the normal"),
                    HasSubstr("lm, W, cd/m2")));
  EXPECT_NEAR(area_brightness(white + "amount { value: 683 unit: 'lm' }") * kPi * 2, 1, kFloat);
}

TEST_F(LightAmountTest, TheUnitOfLengthCounts) {
  const std::string point = absl::StrCat("point { ", kWhite, "} amount { value: 683 unit: 'cd' }"),
                    area = "radiance { constant: 1 } amount ";
  scale_ = {.metres = 0.01, .says_metres = true};
  EXPECT_NEAR(brightness(point), 1e4, 1e-2);
  EXPECT_NEAR(area_brightness(area + "{ value: 683 unit: 'lm' }") * kPi * 2e-4, 1, kFloat);
  EXPECT_NEAR(area_brightness(area + "{ value: 683 unit: 'nit' }"), 1, kFloat);
  EXPECT_THAT(warnings_, IsEmpty());
  scale_ = {};
  EXPECT_NEAR(brightness(point), 1, kFloat);
  EXPECT_THAT(warnings_, ElementsAre(AllOf(HasSubstr("light 0 (lamp)"),
                                           HasSubstr("if the scene's unit of length is the metre"))));
  scale_ = {.cd_per_m2 = 1, .says_metres = true};
  EXPECT_NEAR(brightness(point), 683, 1e-3);
}

TEST_F(LightAmountTest, UnitsOfTheSceneAreChecked) {
  const auto fault = [](const char* units) {
    return std::string(SceneScale::of(message<v1::SceneUnits>(units)).status().message());
  };
  EXPECT_EQ(SceneScale::of(v1::SceneUnits())->metres, 1);
  EXPECT_FALSE(SceneScale::of(v1::SceneUnits())->says_metres);
  EXPECT_THAT(fault("metres: -1"), HasSubstr("units: metres is negative or not finite"));
  EXPECT_THAT(fault("metres: nan"), HasSubstr("units: metres"));
  EXPECT_THAT(fault("cd_per_m2: -5"), HasSubstr("units: cd_per_m2"));
}

TEST_F(LightAmountTest, UnitsThatDoNotFitAreRefusedWithThoseThatDo) {
  const std::string point = absl::StrCat("point { ", kWhite, "} amount ");
  EXPECT_THAT(refusal(point + "{ value: 1 unit: 'lx' }"),
              HasSubstr("light 0 (lamp): amount: lx is a unit of illuminance, which a point light does not "
                        "have; lm or W, cd or W/sr was expected"));
  EXPECT_THAT(refusal(point + "{ value: 1 unit: 'lumne' }"), HasSubstr("did you mean 'lumen'?"));
  EXPECT_THAT(refusal(point + "{ value: 1 unit: 'melanopic lx' }"), HasSubstr("is a measure of effects"));
  for (const char* const value : {"-1", "nan", "inf"})
    EXPECT_THAT(refusal(absl::StrCat(point, "{ value: ", value, " unit: 'lm' }")),
                HasSubstr("its value is negative or not finite"));
  EXPECT_THAT(refusal(point + "{ value: 1e300 unit: 'lm' }"), HasSubstr("it is too large"));
  EXPECT_THAT(
      refusal("distant { direction { z: 1 } irradiance { constant: 1 } } amount { value: 1 unit: 'lm' }"),
      HasSubstr("lx or W/m2 was expected"));
  EXPECT_THAT(refusal("infinite { radiance { constant: 1 } } amount { value: 1 unit: 'lm' }"),
              HasSubstr("cd/m2 (nit) or W/(m2 sr), lx or W/m2 was expected"));
  EXPECT_THAT(
      std::string(add_area_light("radiance { constant: 1 } amount { value: 1 unit: 'lx' }").message()),
      HasSubstr("an area light does not have"));
}

TEST_F(LightAmountTest, SpectraHaveTheLuminanceOfTheJob) {
  SpectralTables tables;
  SpectralBuilder spectral(tables);
  spectral_ = &spectral;
  // A lamp of one line at 555 nm, 10 nm wide, has 683 lm/W.
  const std::string line =
      "point { intensity { sampled { wavelengths_nm: [549, 550, 560, 561] values: [0, 1, 1, 0] } } } amount ";
  const auto added = [&](const std::string& amount) {
    EXPECT_EQ(add(line + amount), absl::OkStatus());
    return table_.lights.back().radiance[1];
  };
  const double by_lumens = added("{ value: 683 unit: 'lm' }"), by_watts = added("{ value: 1 unit: 'W' }");
  // V is above 0.9949 there; the curve has a sample a nanometre.
  EXPECT_NEAR(by_watts / by_lumens, 1, 0.005);
  // D65 has 184.4 lm within 360 and 830 nm for each watt there.
  const std::string white = absl::StrCat("point { ", kWhite, "} amount ");
  EXPECT_EQ(add(white + "{ value: 1 unit: 'lm' }"), absl::OkStatus());
  const double lumen = table_.lights.back().radiance[1];
  EXPECT_EQ(add(white + "{ value: 1 unit: 'W' }"), absl::OkStatus());
  EXPECT_NEAR(table_.lights.back().radiance[1] / lumen, 184.4, 0.3);
  EXPECT_NEAR(lumen, 1 / (683 * 4 * kPi), 1e-7);
}

TEST_F(LightAmountTest, PhotometricFilesSayHowBrightTheyAre) {
  std::vector<std::string> notes;
  const auto lamp = *photometry::read_ies(photometry::symmetric_ies(), {.name = "lamp"}, notes);
  const double mean = photometry::flux(lamp) / (4 * kPi);
  const std::string file = "goniometric { photometric_file { digest: 'downlight' path: 'lamp.ies' } ";
  EXPECT_NEAR(brightness(file + "}") * 683, mean, 1e-5 * mean);
  EXPECT_EQ(table_.lights.back().kind, LightKind::kGoniometric);
  EXPECT_TRUE(table_.any_textures);
  EXPECT_NEAR(brightness(file + "} scale: 0.5") * 683 * 2, mean, 1e-5 * mean);
  EXPECT_NEAR(brightness(file + kWhite + "}") * 683, mean, 1e-5 * mean);
  // Dimmed: by its flux, or by its intensity at gamma 0.
  EXPECT_NEAR(brightness(file + "} amount { value: 1000 unit: 'lm' }") * 683 * 4 * kPi, 1000, 1e-2);
  EXPECT_NEAR(brightness(file + "} amount { value: 80 unit: 'cd' }") * 683, mean / 10, 1e-5 * mean);
  EXPECT_EQ(table_.lights[0].texture, table_.lights[0].texture);
  EXPECT_EQ(textures_.table().nodes.size(), 1u + 5u) << "a map for each builder, none for each light";
  EXPECT_THAT(warnings_, IsEmpty());
  scale_ = {};
  add(file + "}").IgnoreError();
  EXPECT_THAT(warnings_, ElementsAre(HasSubstr("if the scene's unit of length is the metre")));
}

TEST_F(LightAmountTest, FaultsOfPhotometricFilesNameTheirPlace) {
  const auto light = [](const char* digest, const char* more) {
    return absl::StrCat("goniometric { photometric_file { digest: '", digest, "' path: 'lamp.ies' } ", more,
                        " }");
  };
  EXPECT_THAT(refusal(light("broken", "")), HasSubstr("light 0 (lamp): lamp.ies:3:6: 'x' is no number"));
  EXPECT_THAT(refusal(light("none", "")), HasSubstr("lamp.ies: there is no blob none"));
  EXPECT_THAT(refusal(light("street", "texture: 'grey'")), HasSubstr("a texture and a photometric file"));
  EXPECT_THAT(refusal(light("street", "") + " scale: -1"), HasSubstr("its scale is negative"));
}

/// Directions that fill the sphere evenly.
std::vector<Imath::V3d> directions(int count) {
  std::vector<Imath::V3d> result;
  for (int i = 0; i < count; ++i) {
    const double z = (2 * i + 1.0) / count - 1, r = std::sqrt(1 - z * z), phi = 2.399963229728653 * i;
    result.emplace_back(r * std::cos(phi), r * std::sin(phi), z);
  }
  return result;
}

double told(const photometry::Luminaire& lamp, const Imath::V3d& w) {
  const Imath::V3d unit = w.normalized();
  return photometry::intensity(lamp, unit.x, unit.y, unit.z);
}

/// Whether the intensities about a direction, three degrees away, lie on no plane: an edge is near.
bool is_edge(const photometry::Luminaire& lamp, const Imath::V3d& w, double peak) {
  const Imath::V3d u = (std::abs(w.z) < 0.9 ? w.cross({0, 0, 1}) : w.cross({1, 0, 0})).normalized(),
                   v = u.cross(w);
  for (int i = 0; i < 8; ++i) {
    const Imath::V3d step = 0.05 * (std::cos(i * kPi / 8) * u + std::sin(i * kPi / 8) * v);
    if (std::abs(told(lamp, w + step) + told(lamp, w - step) - 2 * told(lamp, w)) > 0.004 * peak) return true;
  }
  return false;
}

TEST(PhotometricMap, IsAsFineAsTheFile) {
  constexpr int kDirections = 20000;
  for (const std::string& text :
       {photometry::symmetric_ies(), photometry::quadrant_ies(), photometry::bilateral_ies(),
        photometry::full_ies(), photometry::beam_ies(2), photometry::beam_ies(3)}) {
    std::vector<std::string> notes;
    const auto lamp = *photometry::read_ies(text, {.name = "lamp"}, notes);
    const PhotometricMap map = build_photometric_map(lamp);
    EXPECT_NEAR(4 * kPi * map.mean_candelas / photometry::flux(lamp), 1, 1e-12);
    const double peak = std::ranges::max(lamp.values) * lamp.candelas_per_value();
    double sum = 0, worst = 0;
    int smooth = 0;
    for (const Imath::V3d& w : directions(kDirections)) {
      const double found = candelas_of_map(map, w.x, w.y, w.z), wanted = told(lamp, w);
      sum += found;
      if (wanted < 0.05 * peak || is_edge(lamp, w, peak)) continue;
      ++smooth;
      worst = std::max(worst, std::abs(found / wanted - 1));
    }
    // Beams that end abruptly are summed with an error of the share of directions that their edge is.
    EXPECT_NEAR(4 * kPi * sum / kDirections / photometry::flux(lamp), 1,
                lamp.system == photometry::PlaneSystem::kC ? 1e-3 : 1e-2)
        << text;
    EXPECT_GT(smooth, 20) << text;
    EXPECT_LT(worst, 0.005) << text;
  }
}

TEST(PhotometricMap, HasTheRotationThatLightsGet) {
  // A rotation, and gamma 0 in the middle.
  const double* const m = kMapFromLuminaire;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) {
      double product = 0;
      for (int c = 0; c < 3; ++c) product += m[3 * i + c] * m[3 * k + c];
      EXPECT_NEAR(product, i == k ? 1 : 0, 1e-15);
    }
  }
  EXPECT_EQ(m[8], -1);
}

}  // namespace
}  // namespace tessera::render

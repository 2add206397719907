// Rooms after CIE 171:2006, "Test cases to assess the accuracy of lighting computer programs", section 5:
// what is measured in them follows in closed form, or from an integral that is done here. The reference
// figures are not the report's tables but these integrals; where a case differs from the report's, its test
// says so.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "agreement.h"
#include "photometry/lamps/lamp_file.h"
#include "photometry/sky/cie_sky.h"
#include "photometry/sky/sky.h"
#include "scene_text.h"
#include "support/light/closed_forms.h"
#include "support/long_form.h"
#include "unit/lib/photometry/sample_lamps.h"

namespace tessera::test {
namespace {

// ---------------------------------------------------------------- rooms

/// The report's room: 4 m x 4 m, 3 m high, the origin in the middle of its floor.
const Room kOfficeRoom = {{-2, -2, 0}, {2, 2, 3}};
/// Points are so far before their walls.
constexpr double kBefore = 1e-3;

struct Spot {
  Point position, normal;
};
/// On the floor in a row from the middle to a corner, and up the wall in the west.
std::vector<Spot> office_spots() {
  const Point up = {0, 0, 1}, east = {1, 0, 0};
  return {{{0, 0, kBefore}, up},           {{1.25, 0.75, kBefore}, up},     {{-1.75, 1.75, kBefore}, up},
          {{kBefore - 2, 0.5, 0.5}, east}, {{kBefore - 2, 0.5, 1.5}, east}, {{kBefore - 2, 0.5, 2.5}, east}};
}

/// A wall of number `wall` of the room with a rectangular hole, from (u0, v0) to (u1, v1) in parts of its
/// edges.
std::string wall_with_hole(const Room& room, std::size_t wall, double u0, double v0, double u1, double v1,
                           const std::string& material = "black") {
  const Room::Wall whole = room.wall(wall);
  const auto part = [&](double from_u, double from_v, double to_u, double to_v) -> std::string {
    if (!(to_u > from_u) || !(to_v > from_v)) return "";
    Point corner = whole.corner, u = whole.edge_u, v = whole.edge_v;
    for (std::size_t a = 0; a < 3; ++a) {
      corner[a] += from_u * u[a] + from_v * v[a];
      u[a] *= to_u - from_u, v[a] *= to_v - from_v;
    }
    return panel(corner, u, v, "", material);
  };
  return part(0, 0, 1, v0) + part(0, v1, 1, 1) + part(0, v0, u0, v1) + part(u1, v0, 1, v1);
}

std::string closed_walls(const Room& room, const std::vector<std::size_t>& walls,
                         const std::string& material = "black") {
  std::string text;
  for (const std::size_t number : walls) {
    const Room::Wall wall = room.wall(number);
    text += panel(wall.corner, wall.edge_u, wall.edge_v, "", material);
  }
  return text;
}

std::string meters_of(const std::vector<Spot>& spots, const std::string& unit) {
  std::string receivers;
  for (const Spot& spot : spots) receivers += point_at(spot.position, spot.normal);
  return irradiance_meter("E", receivers, "PLANE", unit);
}

// ---------------------------------------------------------------- integrals

/// The integral over a rectangle by Gauss-Legendre rules of two points in `panels` x `panels` parts.
double over_rectangle(const Point& corner, const Point& edge_u, const Point& edge_v,
                      const std::function<double(const Point&)>& f, int panels = 64) {
  const double nodes[] = {0.5 - std::sqrt(1.0 / 12), 0.5 + std::sqrt(1.0 / 12)};
  double sum = 0;
  const auto place = [&](int i) {
    const int panel = i / 2;
    return (panel + nodes[i % 2]) / panels;
  };
  for (int i = 0; i < 2 * panels; ++i) {
    const double u = place(i);
    for (int k = 0; k < 2 * panels; ++k) {
      const double v = place(k);
      Point p = corner;
      for (std::size_t a = 0; a < 3; ++a) p[a] += u * edge_u[a] + v * edge_v[a];
      sum += f(p);
    }
  }
  return sum * forms::length(forms::cross(edge_u, edge_v)) / (4.0 * panels * panels);
}

/// Irradiance at a spot by what is seen through a rectangle: the integral of radiance and cosines over it.
double irradiance_through(const Spot& spot, const Point& corner, const Point& edge_u, const Point& edge_v,
                          const std::function<double(const Point& direction, double cosine)>& radiance) {
  Point normal = forms::cross(edge_u, edge_v);
  const double area = forms::length(normal);
  for (double& x : normal) x /= area;
  return over_rectangle(corner, edge_u, edge_v, [&](const Point& p) {
    Point d = p - spot.position;
    const double distance = forms::length(d);
    for (double& x : d) x /= distance;
    const double here = forms::dot(spot.normal, d), there = std::abs(forms::dot(normal, d));
    if (here <= 0) return 0.0;
    return radiance(d, there) * here * there / (distance * distance);
  });
}

/// Transmittance of a clear pane, of unpolarised light by both faces [Fresnel 1823], all inner reflections
/// counted.
double pane_transmittance(double cosine, double n) {
  const double inner = std::sqrt(1 - (1 - cosine * cosine) / (n * n));
  const double s = (cosine - n * inner) / (cosine + n * inner),
               p = (n * cosine - inner) / (n * cosine + inner);
  const double r = (s * s + p * p) / 2;
  return (1 - r) / (1 + r);
}

// ---------------------------------------------------------------- lamps

TEST(Cie171, PointSources) {
  // 5.2: lamps with a photometric file. The report's is a compact lamp; here it is one that can be told by a
  // formula, in steps of 5 degrees. Renderers look it up in a map that is good to .3 %.
  const auto candelas = [](double c, double gamma) {
    const double g = gamma * forms::kPi / 180;
    return 900 * std::pow(std::cos(g / 2), 4) * (1 + 0.3 * std::sin(g) * std::cos(c * forms::kPi / 180));
  };
  photometry::Luminaire lamp = photometry::luminaire_of(candelas, 15, 5);
  const auto file = photometry::write_ies(lamp);
  ASSERT_TRUE(file.ok()) << file.status();
  MeasuredCase test{
      .name = "5.2",
      .scene = closed_walls(kOfficeRoom, {0, 1, 2, 3, 4, 5}) +
               "lights { goniometric { photometric_file { path: 'lamp.ies' } world_from_light { "
               "elements: [1,0,0,0, 0,1,0,0, 0,0,1,2.9, 0,0,0,1] } } } ",
      .meters = meters_of(office_spots(), "lx"),
      .rounding = 2e-3,
      .files = {{"lamp.ies", *file}}};
  for (const Spot& spot : office_spots()) {
    Point d = spot.position - Point{0, 0, 2.9};
    const double distance = forms::length(d);
    for (double& x : d) x /= distance;
    test.truths.push_back(forms::irradiance_of_point(photometry::intensity(lamp, d[0], d[1], d[2]), distance,
                                                     -forms::dot(spot.normal, d)));
  }
  expect_agreement({test});
}

TEST(Cie171, AreaSources) {
  // 5.3: a square of 1 m in the ceiling, and one of 4 m x .5 m.
  std::vector<MeasuredCase> cases;
  for (const auto& [x, y] : {std::array{0.5, 0.5}, {2.0, 0.25}}) {
    MeasuredCase& test = cases.emplace_back();
    test.name = "5.3";
    test.scene = closed_walls(kOfficeRoom, {0, 1, 2, 3, 4}) +
                 wall_with_hole(kOfficeRoom, 5, 0.5 - y / 4, 0.5 - x / 4, 0.5 + y / 4, 0.5 + x / 4) +
                 panel({-x, -y, 3}, {0, 2 * y, 0}, {2 * x, 0, 0}, glow());
    test.meters = meters_of(office_spots(), "W/m2");
    for (const Spot& spot : office_spots()) {
      // Corners in the spot's frame, whose third axis is the normal.
      std::vector<Point> corners;
      for (const auto& [u, v] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
        const Point p = Point{u * x, v * y, 3} - spot.position;
        corners.push_back(spot.normal[2] == 1 ? p : Point{p[1], p[2], p[0]});
      }
      test.truths.push_back(forms::irradiance_of_radiance(1, forms::element_to_polygon(corners)));
    }
  }
  expect_agreement(cases);
}

// ---------------------------------------------------------------- skies

constexpr double kSkyLux = 10000;
constexpr double kGround = 0.3;
/// Cells of the sky's map are a third of a degree wide.
constexpr double kSkyMap = 5e-4;

photometry::Sky sky_of(int type) {
  const auto pattern = photometry::cie_pattern(type);
  return photometry::make_sky(*pattern, photometry::toward(35, 60), {.diffuse_horizontal = kSkyLux}, kGround);
}

/// The light of that sky, without its sun.
std::string sky_text(int type) {
  const photometry::HorizonDirection sun = photometry::toward(35, 60);
  return absl::StrCat("lights { sky { cie_type: ", type, " toward_sun { ",
                      text_of(Point{sun.east, sun.north, sun.up}),
                      " } diffuse_horizontal_illuminance: ", kSkyLux,
                      " sun_normal_illuminance: 0 ground_reflectance: ", kGround, " } } ");
}

double sky_luminance(const photometry::Sky& sky, const Point& d) {
  return photometry::luminance(sky, {d[0], d[1], d[2]});
}

std::vector<int> sky_types() {
  if (!long_form()) return {1, 8, 12, 16};
  std::vector<int> all;
  for (int type = 1; type <= photometry::kTraditionalOvercast; ++type) all.push_back(type);
  return all;
}

/// An opening in a wall of the office; what is seen through it is up to the case.
struct Opening {
  Point corner, edge_u, edge_v;
};

MeasuredCase sky_case(const std::string& name, int type, const std::string& scene,
                      const std::vector<Spot>& spots) {
  return {.name = absl::StrCat(name, ", sky ", type),
          .scene = sky_text(type) + scene,
          .meters = meters_of(spots, "lx"),
          .samples = 1 << 15,
          .rounding = kSkyMap,
          .largest_error = 0.05};
}

TEST(Cie171, SkyThroughARoof) {
  // 5.9 and 5.10: the sky component below an opening in the roof, bare and with a pane. The report's opening
  // has walls of .2 m, and its pane the transmittance of 6 mm glass; here there is no thickness, and the pane
  // is clear, with Fresnel's reflectance.
  constexpr double kIndex = 1.52;
  std::vector<MeasuredCase> cases;
  for (const int type : sky_types()) {
    const photometry::Sky sky = sky_of(type);
    for (const double half : {0.5, 2.0}) {
      for (const bool glazed : {false, true}) {
        if (glazed && (half == 2.0 || (type != 1 && type != 12))) continue;
        const Opening roof = {{-half, -half, 3}, {2 * half, 0, 0}, {0, 2 * half, 0}};
        const double from = 0.5 - half / 4, to = 0.5 + half / 4;
        std::string scene =
            closed_walls(kOfficeRoom, {0, 1, 2, 3, 4}) + wall_with_hole(kOfficeRoom, 5, from, from, to, to);
        if (glazed)
          scene += absl::StrCat("materials { name: 'pane' thin_dielectric { eta { constant: ", kIndex,
                                " } } } ", panel(roof.corner, roof.edge_u, roof.edge_v, "", "pane"));
        MeasuredCase test = sky_case(glazed ? "5.10" : "5.9", type, scene, office_spots());
        test.samples = 1 << 14;
        for (const Spot& spot : office_spots())
          test.truths.push_back(irradiance_through(
              spot, roof.corner, roof.edge_u, roof.edge_v, [&](const Point& d, double cosine) {
                return sky_luminance(sky, d) * (glazed ? pane_transmittance(cosine, kIndex) : 1);
              }));
        if (!glazed) {
          // Daylight factors are over what the open sky gives.
          std::string receivers;
          for (const Spot& spot : office_spots()) receivers += point_at(spot.position, spot.normal);
          test.meters += "meters { name: 'D' daylight_factor { part: SKY_COMPONENT " + receivers + "} } ";
          for (std::size_t i = 0; i < office_spots().size(); ++i)
            test.truths.push_back(100 * test.truths[i] / kSkyLux);
        }
        cases.push_back(std::move(test));
      }
    }
  }
  expect_agreement(cases);
}

TEST(Cie171, FluxIsConserved) {
  // 5.4: what comes in through a roof's opening is what black walls and the floor receive.
  std::vector<MeasuredCase> cases;
  for (const int type : sky_types()) {
    std::string surfaces;
    for (std::size_t wall = 0; wall < 5; ++wall) {
      const Room::Wall w = kOfficeRoom.wall(wall);
      surfaces += plane_receiver(w.corner, w.edge_u, w.edge_v, kBefore);
    }
    MeasuredCase test = sky_case("5.4", type,
                                 closed_walls(kOfficeRoom, {0, 1, 2, 3, 4}) +
                                     wall_with_hole(kOfficeRoom, 5, 0.375, 0.375, 0.625, 0.625),
                                 {});
    test.meters = "meters { name: 'in' flux { side: FRONT " +
                  plane_receiver({-0.5, -0.5, 3}, {1, 0, 0}, {0, 1, 0}, kBefore) +
                  "} } meters { name: 'received' flux { side: FRONT " + surfaces + "} } ";
    // A small part of the light that comes in within a millimetre of edges meets no receiver.
    test.rounding = 2e-3;
    test.truths = {kSkyLux, kSkyLux};
    cases.push_back(std::move(test));
  }
  expect_agreement(cases);
}

/// A window in the south wall, 2 m wide, from 1 m to 2 m above the floor.
const Opening kWindow = {{-1, -2, 1}, {2, 0, 0}, {0, 0, 1}};

std::string room_with_window() {
  // The wall's edges are z and x.
  return closed_walls(kOfficeRoom, {0, 1, 3, 4, 5}) +
         wall_with_hole(kOfficeRoom, 2, 1.0 / 3, 0.25, 2.0 / 3, 0.75);
}

/// A row on the floor away from the window, and points up the wall that faces it.
std::vector<Spot> window_spots() {
  const Point up = {0, 0, 1}, south = {0, -1, 0};
  return {{{0, -1.5, kBefore}, up},         {{0.5, 0, kBefore}, up},
          {{-1, 1.5, kBefore}, up},         {{0.5, 2 - kBefore, 0.5}, south},
          {{0.5, 2 - kBefore, 1.5}, south}, {{0.5, 2 - kBefore, 2.5}, south}};
}

TEST(Cie171, SkyAndGroundThroughAWindow) {
  // 5.11 to 5.14: the sky component and what the ground reflects, by a window: bare, with a pane, below an
  // endless overhang of 1 m, and across from an endless wall 6 m away and 4 m high. The overhang is black;
  // the wall has a luminance of its own, so that its part is known.
  constexpr double kIndex = 1.52, kOverhang = 1, kAway = 6, kWallTop = 4, kEndless = 400;
  constexpr double kWallLuminance = 0.25 * 683;
  enum class Outside { kBare, kPane, kUnderOverhang, kOppositeWall };
  std::vector<MeasuredCase> cases;
  for (const int type : sky_types()) {
    const photometry::Sky sky = sky_of(type);
    for (const Outside outside :
         {Outside::kBare, Outside::kPane, Outside::kUnderOverhang, Outside::kOppositeWall}) {
      if (outside == Outside::kPane && type != 1 && type != 12) continue;
      std::string scene = room_with_window();
      const char* name = "5.11";
      if (outside == Outside::kPane) {
        name = "5.12";
        scene += absl::StrCat("materials { name: 'pane' thin_dielectric { eta { constant: ", kIndex,
                              " } } } ", panel(kWindow.corner, kWindow.edge_u, kWindow.edge_v, "", "pane"));
      } else if (outside == Outside::kUnderOverhang) {
        name = "5.13";
        scene += panel({-kEndless, -2 - kOverhang, 2}, {0, kOverhang, 0}, {2 * kEndless, 0, 0});
      } else if (outside == Outside::kOppositeWall) {
        name = "5.14";
        // Its lower end is far below the horizon of all points.
        scene += panel({-kEndless, -2 - kAway, kWallTop - kEndless}, {0, 0, kEndless}, {2 * kEndless, 0, 0},
                       glow(kWallLuminance / 683));
      }
      MeasuredCase test = sky_case(name, type, scene, window_spots());
      for (const Spot& spot : window_spots()) {
        const double z = spot.position[2], a = spot.position[1] + 2;
        const auto seen = [&](double from, double to,
                              const std::function<double(const Point&, double)>& radiance) {
          from = std::max(from, 1.0), to = std::min(to, 2.0);
          if (!(to > from)) return 0.0;
          return irradiance_through(spot, {-1, -2, from}, kWindow.edge_u, {0, 0, to - from}, radiance);
        };
        const auto open = [&](const Point& d, double cosine) {
          return sky_luminance(sky, d) * (outside == Outside::kPane ? pane_transmittance(cosine, kIndex) : 1);
        };
        // The height in the window's plane up to which a ray goes below what is outside.
        double truth = 0;
        if (outside == Outside::kOppositeWall) {
          const double top = z + (kWallTop - z) * a / (a + kAway);
          truth = seen(1, top, [&](const Point&, double) { return kWallLuminance; }) + seen(top, 2, open);
        } else {
          // Rays that rise meet the overhang, which begins at the window's head, unless they pass its edge
          // lower.
          const double reach = outside == Outside::kUnderOverhang ? z + (2 - z) * a / (a + kOverhang) : 2;
          // The horizon divides sky and ground.
          truth = seen(1, std::min(z, reach), open) + seen(std::max(1.0, z), reach, open);
        }
        test.truths.push_back(truth);
      }
      cases.push_back(std::move(test));
    }
  }
  expect_agreement(cases);
}

// ---------------------------------------------------------------- reflection

/// Irradiance of a wall's element at a height above ground that reaches from `from` to `to` before it, and is
/// as wide to both sides as `half_width`.
double factor_to_ground(double height, double from, double to, double half_width) {
  const auto up_to = [&](double end) {
    return end > 0 ? 2 * forms::element_to_perpendicular_rectangle(end, half_width, height) : 0;
  };
  return to > from ? up_to(to) - up_to(from) : 0;
}

TEST(Cie171, ReflectionOverDiffuseSurfaces) {
  // 5.6 and 5.7: a diffuse ground of .5, 4 and 500 m that the sun lights evenly, as seen by a wall; without
  // anything, and with a black screen between them, .5 m high and 1 m away. The report's sun shines from 35
  // degrees; here it is in the zenith, so that neither wall nor screen has direct light.
  constexpr double kSun = 1000, kReflectance = 0.3, kScreen = 0.5, kAway = 1;
  const std::vector<double> heights = {0.25, 0.75, 1.5, 3};
  std::vector<MeasuredCase> cases;
  for (const double side : {0.5, 4.0, 500.0}) {
    for (const bool screened : {false, true}) {
      if (screened && side <= kAway) continue;
      MeasuredCase& test = cases.emplace_back();
      test.name = absl::StrCat(screened ? "5.7" : "5.6", ", ", side, " m");
      test.scene = diffuse("ground", kReflectance) +
                   panel({0, -side / 2, 0}, {side, 0, 0}, {0, side, 0}, "", "ground") +
                   "lights { distant { direction { z: -1 } irradiance { " + grey(kSun) + " } } } ";
      if (screened) test.scene += panel({kAway, -1000, 0}, {0, 2000, 0}, {0, 0, kScreen});
      for (const double z : heights) {
        test.meters += irradiance_meter("wall", point_at({0, 0, z}, {1, 0, 0}));
        // Behind the screen, rays come down on the ground further away.
        const double behind = z > kScreen ? kAway * z / (z - kScreen) : side;
        const double factor =
            screened ? factor_to_ground(z, 0, kAway, side / 2) + factor_to_ground(z, behind, side, side / 2)
                     : factor_to_ground(z, 0, side, side / 2);
        test.truths.push_back(kSun * kReflectance * factor);
      }
      // No light is sampled on the ground: it is found by rays, of which few meet a small one.
      test.samples = 1 << 18, test.largest_error = 0.05;
      test.rounding = 1e-5;
    }
  }
  expect_agreement(cases);
}

TEST(Cie171, InternallyReflectedLight) {
  // 5.8: a cube of 4 m and a lamp in its middle. The report's reference is that of an integrating sphere;
  // what is exact is that the walls absorb all of the lamp's light: each of them receives a sixth of it over
  // 1 - rho. And the sphere: light that has been reflected is the same everywhere, wherever the lamp is
  // [Walsh 1965].
  const Room cube = {{-2, -2, -2}, {2, 2, 2}};
  std::vector<MeasuredCase> cases;
  const std::vector<double> reflectances =
      long_form() ? std::vector{0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95}
                  : std::vector{0.0, 0.3, 0.7, 0.9};
  for (const double rho : reflectances) {
    MeasuredCase& test = cases.emplace_back();
    test.name = absl::StrCat("5.8, rho ", rho);
    test.scene = diffuse("paint", rho) + closed_walls(cube, {0, 1, 2, 3, 4, 5}, "paint") +
                 "lights { point { intensity { " + grey(5) + " } } } ";
    for (const std::size_t wall : {0, 4}) {
      const Room::Wall w = cube.wall(wall);
      test.meters += irradiance_meter("wall", plane_receiver(w.corner, w.edge_u, w.edge_v, 1e-5));
      test.truths.push_back(forms::flux_of_point(5) / (6 * 16 * (1 - rho)));
    }
    test.rounding = kMargin;
    MeasuredCase& ball = cases.emplace_back();
    ball.name = absl::StrCat("ball, rho ", rho);
    const Point lamp = {0.7, -0.4, 0.9};
    ball.scene = diffuse("paint", rho) + sphere_text(2, {0, 0, 0}, "reverse_orientation: true", "paint") +
                 "lights { point { position { " + text_of(lamp) + " } intensity { " + grey(5) + " } } } ";
    for (const Point& normal : {Point{0, 0, 1}, {-1, 0, 0}, {0, 0.6, -0.8}}) {
      Point position = normal;
      for (double& x : position) x *= -2 + 1e-5;
      Point d = lamp - position;
      const double distance = forms::length(d);
      ball.meters += irradiance_meter("wall", point_at(position, normal));
      ball.truths.push_back(forms::irradiance_of_point(5, distance, forms::dot(normal, d) / distance) +
                            forms::indirect_irradiance_in_sphere(forms::flux_of_point(5), 2, rho));
    }
    ball.rounding = kMargin;
  }
  expect_agreement(cases);
}

}  // namespace
}  // namespace tessera::test

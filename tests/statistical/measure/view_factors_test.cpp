// Meters against the catalogue of view factors: a surface with a radiance of 1, seen by another or by a
// point.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "agreement.h"
#include "scene_text.h"
#include "support/light/closed_forms.h"

namespace tessera::test {
namespace {

const Point kOrigin = {0, 0, 0}, kX = {1, 0, 0}, kZ = {0, 0, 1}, kDown = {0, 0, -1}, kToMinusX = {-1, 0, 0};

/// A receiver that has a view factor to all light of the scene: its irradiance is pi times that, the
/// spherical irradiance of a point four times as much.
struct View {
  std::string receivers;
  double factor;
  const char* shape = "PLANE";
};

struct Catalogue {
  std::vector<MeasuredCase> cases;

  void add(const std::string& name, const std::string& scene, const std::vector<View>& views,
           double rounding = kRounding) {
    MeasuredCase& made = cases.emplace_back();
    made.name = name, made.scene = scene, made.rounding = rounding, made.samples = 1 << 17;
    for (const View& view : views) {
      made.meters += irradiance_meter("irradiance", view.receivers, view.shape);
      made.truths.push_back((std::string(view.shape) == "SPHERE" ? 4 : 1) * forms::kPi * view.factor);
    }
  }
};

/// A point at the origin that looks up.
View at_origin(double factor, const char* shape = "PLANE") { return {point_at(kOrigin, kZ), factor, shape}; }

/// A rectangle in z = 0 with a corner at the origin, which looks up.
View floor_view(double x, double y, double factor) {
  return {plane_receiver(kOrigin, {x, 0, 0}, {0, y, 0}), factor};
}

/// A strip of a round wall at x = radius, which stands for all of it; it looks away from the axis, or to it.
/// It is a thousandth wide, within 2e-7 of the wall, and lies further than that before it.
View wall_strip(double radius, double height, bool inward, double factor) {
  constexpr double kWidth = 1e-3, kOffset = 1e-5;
  const Point across = {0, kWidth, 0}, up = {0, 0, height}, corner = {radius, -kWidth / 2, 0};
  return {inward ? plane_receiver(corner, up, across, kOffset) : plane_receiver(corner, across, up, kOffset),
          factor};
}

TEST(ViewFactors, FromAnElement) {
  Catalogue all;
  all.add("parallel rectangle", panel({0, 0, 0.8}, {0, 0.7, 0}, {1.3, 0, 0}, glow()),
          {at_origin(forms::element_to_parallel_rectangle(1.3, 0.7, 0.8))});
  all.add("perpendicular rectangle", panel({0.6, 0, 0}, {0, 0, 0.9}, {0, 1.1, 0}, glow()),
          {at_origin(forms::element_to_perpendicular_rectangle(0.9, 1.1, 0.6))});
  all.add("triangle", shape_text("polygon { corners: [0, 0, 1, 0, 1, 0, 1, 0, 0] }", glow()),
          {at_origin(forms::element_to_polygon(std::vector<Point>{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}))});
  all.add("disk", disk_text(0.7, {0, 0, 1.2}, kDown, glow()), {at_origin(forms::element_to_disk(0.7, 1.2))});
  all.add("disk aside", disk_text(0.7, {1.5, 0, 1.2}, kDown, glow()),
          {at_origin(forms::element_to_offset_disk(0.7, 1.2, 1.5))});
  all.add("perpendicular disk", disk_text(0.6, {1.1, 0, 0.9}, kToMinusX, glow()),
          {at_origin(forms::element_to_perpendicular_disk(0.6, 0.9, 1.1))});
  const double angle = 50 * forms::kPi / 180;
  all.add("ball", sphere_text(0.5, {1.5 * std::sin(angle), 0, 1.5 * std::cos(angle)}, glow()),
          {at_origin(forms::element_to_sphere(0.5, 1.5, std::cos(angle)))});
  all.add("ball on the horizon", sphere_text(0.5, {1.5, 0, 0}, glow()),
          {at_origin(forms::element_to_half_sphere(0.5, 1.5))});
  for (const auto& [radius, height, away] : {std::array{0.4, 1.7, 1.3}, {0.05, 4.0, 1.0}})
    all.add("cylinder", cylinder_text(radius, height, away, glow()),
            {{point_at(kOrigin, kX), forms::element_to_cylinder(radius, height, away)}});
  // Without ends the strip would add 2e-6: what is beyond a distance d is less than (1 / d)^2 / 2 of it.
  const double from = std::tan(0.3), to = std::tan(1.1);
  all.add("strip", panel({from, -500, 1}, {0, 1000, 0}, {to - from, 0, 0}, glow()),
          {at_origin(forms::element_to_strip(0.3, 1.1))}, 1e-5);
  expect_agreement(all.cases);
}

TEST(ViewFactors, FromBalls) {
  Catalogue all;
  all.add("rectangle", panel({0, 0, 0.5}, {0, 2, 0}, {1, 0, 0}, glow()),
          {at_origin(forms::point_to_rectangle(1, 2, 0.5), "SPHERE")});
  all.add("disk", disk_text(1.2, {0, 0, 0.7}, kDown, glow()),
          {at_origin(forms::sphere_to_disk(1.2, 0.7), "SPHERE")});
  all.add("disk and a ball of some size",
          disk_text(1.2, {0, 0, 0.7}, kDown, glow()) + sphere_text(0.4, kOrigin, "name: 'ball'"),
          {{surface_receiver("ball"), forms::sphere_to_disk(1.2, 0.7)}}, 3e-5);
  all.add("inner ball", sphere_text(0.7, kOrigin, glow()) + sphere_text(2, kOrigin, "name: 'wall'"),
          {{surface_receiver("wall", true), forms::sphere_to_inner_sphere(2, 0.7)}}, 3e-5);
  // A cap of height .5: all of the ball sees it alike, also the cap itself.
  const double cap = forms::within_sphere(2, 2 * forms::kPi * 2 * 0.5);
  all.add("cap of a ball",
          shape_text("sphere { radius: 2 z_min: 1.5 z_max: 2 }", "reverse_orientation: true " + glow()),
          {{point_at({0, 0, -2}, kZ), cap},
           {point_at({2, 0, 0}, kToMinusX), cap},
           {point_at({0, 1.2 - 6e-6, 1.6 - 8e-6}, {0, -0.6, -0.8}), cap}},
          3e-5);
  expect_agreement(all.cases);
}

TEST(ViewFactors, BetweenRectangles) {
  Catalogue all;
  all.add("opposed", panel({0, 0, 0.9}, {0, 0.8, 0}, {1.2, 0, 0}, glow()),
          {floor_view(1.2, 0.8, forms::opposed_rectangles(1.2, 0.8, 0.9))});
  all.add("parallel", panel({0.5, -1, 0.9}, {0, 1.3, 0}, {1.5, 0, 0}, glow()),
          {floor_view(1.2, 0.8, forms::parallel_rectangles({0, 1.2}, {0, 0.8}, {0.5, 2}, {-1, 0.3}, 0.9))});
  all.add("perpendicular", panel(kOrigin, {0, 1, 0}, {0, 0, 1.3}, glow()),
          {floor_view(0.7, 1, forms::perpendicular_rectangles(1, 0.7, 1.3))});
  expect_agreement(all.cases);
}

/// The side of a pyramid of so many faces, whose apex is the origin and whose base lies in z = 1, as a PLY
/// file; the faces look inward.
std::string pyramid_ply(int faces, double base_radius) {
  std::string text = absl::StrCat("ply\nformat ascii 1.0\nelement vertex ", faces + 1,
                                  "\nproperty float x\nproperty float y\nproperty float z\nelement face ",
                                  faces, "\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n");
  for (int i = 0; i < faces; ++i) {
    const double angle = 2 * forms::kPi * i / faces;
    absl::StrAppend(&text, number(base_radius * std::cos(angle)), " ", number(base_radius * std::sin(angle)),
                    " 1\n");
  }
  for (int i = 0; i < faces; ++i) absl::StrAppend(&text, "3 0 ", i + 1, " ", (i + 1) % faces + 1, "\n");
  return text;
}

TEST(ViewFactors, OfRoundSurfaces) {
  Catalogue all;
  for (const double other : {1.3, 0.8}) {
    all.add("coaxial disks",
            disk_text(0.8, kOrigin, kZ, "name: 'base'") + disk_text(other, {0, 0, 0.6}, kDown, glow()),
            {{surface_receiver("base"), forms::coaxial_disks(0.8, other, 0.6)}}, 3e-5);
  }
  const std::string inside = "reverse_orientation: true " + glow();
  all.add("within a cylinder",
          cylinder_text(0.8, 0.6, 0, inside) + disk_text(0.8, kOrigin, kZ, "name: 'base'"),
          {{surface_receiver("base"), forms::base_to_wall(0.8, 0.6)},
           wall_strip(0.8, 0.6, true, forms::wall_to_itself(0.8, 0.6))},
          5e-5);
  all.add("between cylinders", cylinder_text(1, 0.9, 0, inside) + cylinder_text(0.4, 0.9, 0, ""),
          {wall_strip(0.4, 0.9, false, forms::cylinder_to_outer_cylinder(0.4, 1, 0.9))}, 5e-5);
  all.add("disk and ball",
          disk_text(0.9, kOrigin, kZ, "name: 'base'") + sphere_text(0.5, {0, 0, 1.2}, glow()),
          {{surface_receiver("base"), forms::disk_to_sphere(0.9, 0.5, 1.2)}}, 3e-5);
  // A pyramid is to itself what a cone within it is: its base sees the side alone, and the areas are in the
  // same ratio.
  constexpr int kFaces = 48;
  const double base_radius = std::tan(0.5);
  all.add("cone", shape_text("mesh { blob { path: 'pyramid.ply' } }", "name: 'side' " + glow()),
          {{surface_receiver("side"),
            forms::cone_to_itself(std::atan(base_radius * std::cos(forms::kPi / kFaces)))}},
          1e-4);
  all.cases.back().files = {{"pyramid.ply", pyramid_ply(kFaces, base_radius)}};
  expect_agreement(all.cases);
}

}  // namespace
}  // namespace tessera::test

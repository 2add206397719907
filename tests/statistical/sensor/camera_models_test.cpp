// Which places of a film see what: distortion against its published models, tilted lenses against
// Scheimpflug's rule, stereo, panoramas and cube maps.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

#include "render/sensor/sensor.h"
#include "statistical/sensor/camera_messages.h"
#include "support/kernel/random_lanes.h"

namespace tessera::render::TESSERA_ISA {
namespace {

using std::numbers::pi;
using test::kOpenCv;
using test::moved_by_map;
using test::Point2;
using test::refusal;
using test::sensor_of;

/// The published model, in double precision: where OpenCV's projectPoints puts the point (x, y, 1), y
/// downwards.
Point2 projected_by_opencv(const v1::OpenCvDistortion& k, double x, double y) {
  const double r2 = x * x + y * y, r4 = r2 * r2, r6 = r4 * r2;
  const double radial =
      (1 + k.k1() * r2 + k.k2() * r4 + k.k3() * r6) / (1 + k.k4() * r2 + k.k5() * r4 + k.k6() * r6);
  const double x2 = x * radial + 2 * k.p1() * x * y + k.p2() * (r2 + 2 * x * x) + k.s1() * r2 + k.s2() * r4;
  const double y2 = y * radial + k.p1() * (r2 + 2 * y * y) + 2 * k.p2() * x * y + k.s3() * r2 + k.s4() * r4;
  const double cx = std::cos(k.tau_x_radians()), sx = std::sin(k.tau_x_radians());
  const double cy = std::cos(k.tau_y_radians()), sy = std::sin(k.tau_y_radians());
  const double r13 = -sy * cx, r23 = sx, r33 = cy * cx;
  const double turned_x = cy * x2 + sy * sx * y2 + r13, turned_y = cx * y2 + r23,
               turned_z = sy * x2 - cy * sx * y2 + r33;
  return {(r33 * turned_x - r13 * turned_z) / turned_z, (r33 * turned_y - r23 * turned_z) / turned_z};
}

TEST(Distortion, PixelsSeeWhatOpenCvSaysTheySee) {
  constexpr FilmSize kFilm{640, 480};
  v1::Camera message;
  ASSERT_TRUE(google::protobuf::TextFormat::ParseFromString(kOpenCv, &message));
  const auto sensor = sensor_of(kOpenCv, kFilm);
  ASSERT_TRUE(sensor.ok()) << sensor.status();
  // cx and cy are in the middle of the film; fx and fy follow from the field of view.
  const double focal_length = 240 / std::tan(25 * pi / 180);
  RandomLanes numbers(5);
  double squares = 0;
  int count = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec2 raster{numbers(0, 640), numbers(0, 480)};
    const SensorRay ray = start_ray(*sensor, middle_sample(raster));
    ASSERT_TRUE(all(ray.valid));
    const SensorConnection back =
        connect_to_sensor(*sensor, ray.direction, {Float(0.5f), Float(0.5f)}, Float(0.0f), Mask::all());
    ASSERT_TRUE(all(back.valid));
    for (int l = 0; l < kWidth; ++l) {
      const double z = ray.direction.z.lane(l);
      const Point2 at = projected_by_opencv(message.distortion().opencv(), ray.direction.x.lane(l) / z,
                                            -ray.direction.y.lane(l) / z);
      const double x = 320 + focal_length * at.x, y = 240 + focal_length * at.y;
      // A place of the raster, single precision, is known to 3e-5, and so is that of a direction.
      ASSERT_NEAR(x, raster.x.lane(l), 2.5e-4);
      ASSERT_NEAR(y, raster.y.lane(l), 2.5e-4);
      ASSERT_NEAR(back.raster.x.lane(l), raster.x.lane(l), 2.5e-4);
      ASSERT_NEAR(back.raster.y.lane(l), raster.y.lane(l), 2.5e-4);
      squares += (x - raster.x.lane(l)) * (x - raster.x.lane(l));
      ++count;
    }
  }
  EXPECT_LT(std::sqrt(squares / count), 5e-5);
}

TEST(Distortion, FisheyesSeeWhatTheirPolynomialsSay) {
  constexpr FilmSize kFilm{400, 400};
  const auto opencv = sensor_of(
      "fisheye { fov_degrees: 190 } distortion { opencv_fisheye { k1: 0.03 k2: -0.01 k3: 0.002 k4: -0.0002 } "
      "}",
      kFilm);
  const auto polynomial = sensor_of(
      "fisheye { fov_degrees: 190 } distortion { polynomial { angle: [1.01, -0.02, 0.03, -0.005] } }", kFilm);
  ASSERT_TRUE(opencv.ok() && polynomial.ok()) << opencv.status() << polynomial.status();
  const double focal_length = 200 / (95 * pi / 180);  // pixels a radian
  RandomLanes numbers(5);
  for (int i = 0; i < 500; ++i) {
    const Vec2 raster{numbers(0, 400), numbers(0, 400)};
    const SensorRay a = start_ray(*opencv, middle_sample(raster)),
                    b = start_ray(*polynomial, middle_sample(raster));
    for (int l = 0; l < kWidth; ++l) {
      const double x = raster.x.lane(l) - 200, y = 200 - raster.y.lane(l);
      const double r = std::hypot(x, y) / focal_length;
      const auto angle_of = [&](const SensorRay& ray) {
        return std::atan2(std::hypot(ray.direction.x.lane(l), ray.direction.y.lane(l)),
                          ray.direction.z.lane(l));
      };
      if (a.valid.bits() >> l & 1) {
        const double t = angle_of(a), t2 = t * t;
        const double distorted = t * (1 + t2 * (0.03 + t2 * (-0.01 + t2 * (0.002 - 0.0002 * t2))));
        ASSERT_NEAR(distorted * focal_length, r * focal_length, 1e-4);
      }
      if (!(b.valid.bits() >> l & 1)) continue;
      ASSERT_NEAR(angle_of(b) * focal_length,
                  r * (1.01 + r * (-0.02 + r * (0.03 - 0.005 * r))) * focal_length, 1e-4);
    }
  }
}

TEST(Distortion, PixelsOfAMapSeeWhatItSays) {
  const auto sensor =
      sensor_of("perspective { fov_degrees: 60 } distortion { map { image { path: 'map.pfm' } } }", {40, 20});
  ASSERT_TRUE(sensor.ok()) << sensor.status();
  const double half = std::tan(30 * pi / 180);
  for (int row = 0; row < 20; ++row) {
    for (int column = 0; column < 40; ++column) {
      const SensorRay ray = start_ray(*sensor, middle_sample({Float(static_cast<float>(column) + 0.5f),
                                                              Float(static_cast<float>(row) + 0.5f)}));
      const Point2 seen = moved_by_map({(column + 0.5) / 40, 1 - (row + 0.5) / 20});
      ASSERT_NEAR(ray.direction.x.lane(0) / ray.direction.z.lane(0), (4 * seen.x - 2) * half, 2e-6);
      ASSERT_NEAR(ray.direction.y.lane(0) / ray.direction.z.lane(0), (2 * seen.y - 1) * half, 2e-6);
    }
  }
}

TEST(Distortion, ThatFoldsTheFilmIsToldWhereItDoes) {
  // x (1 - 0.5 x^2) has its largest value, 0.544, where x is 0.816.
  const std::string folds = refusal("perspective { fov_degrees: 90 } distortion { opencv { k1: -0.5 } }");
  EXPECT_THAT(folds, testing::HasSubstr("camera: its distortion folds the film at pixel ("));
  int x = 0, y = 0;
  ASSERT_EQ(std::sscanf(folds.c_str(), "camera: its distortion folds the film at pixel (%d, %d)", &x, &y), 2);
  EXPECT_GT(std::hypot(x - 100, y - 50), 26);
  EXPECT_LT(std::hypot(x - 100, y - 50), 45);  // within some cells of the table
  EXPECT_THAT(refusal("fisheye { fov_degrees: 180 } distortion { polynomial { angle: [1, -0.5] } }"),
              testing::HasSubstr("folds the film at pixel"));
  EXPECT_THAT(refusal("fisheye { fov_degrees: 90 } distortion { polynomial { } }"),
              testing::HasSubstr("polynomial has no coefficients"));
  EXPECT_THAT(refusal("fisheye { fov_degrees: 90 } distortion { opencv { } }"),
              testing::HasSubstr("opencv is the distortion of a perspective camera"));
  EXPECT_THAT(refusal("perspective { fov_degrees: 90 } distortion { polynomial { angle: 1 } }"),
              testing::HasSubstr("polynomial is the distortion of a fisheye"));
  EXPECT_THAT(refusal("spherical { } distortion { map { } }"), testing::HasSubstr("a distortion map is of"));
  EXPECT_THAT(refusal("perspective { fov_degrees: 90 } distortion { }"), testing::HasSubstr("has no kind"));
  EXPECT_THAT(
      refusal("perspective { fov_degrees: 90 } distortion { map { image { path: 'm.pfm' } } }", {90, 90}),
      testing::HasSubstr("'m.pfm' has 40 x 20 pixels, which are not of the film's proportions"));
}

// ---------------------------------------------------------------- tilted lenses

/// The plane of focus contains the line in which film and lens meet, and the point of focus on the axis
/// [Scheimpflug 1904]; the film's distance is that of the thin lens equation, along the lens's axis.
TEST(TiltedLens, RaysOfAPlaceMeetOnScheimpflugsPlane) {
  constexpr double kDistance = 3, kFocalLength = 0.5, kTilt = -10 * pi / 180;
  const auto sensor = sensor_of(
      "perspective { fov_degrees: 50 lens_radius: 0.2 focal_distance: 3 tilt { x_degrees: -10 focal_length: "
      "0.5 } }",
      {40, 20});
  ASSERT_TRUE(sensor.ok()) << sensor.status();
  const double film = 1 / (std::cos(kTilt) / kFocalLength - 1 / kDistance);
  // In the plane x = 0: the lens has the normal (sin, cos) of (y, z); the film is z = -film.
  const double line_y = film * std::cos(kTilt) / std::sin(kTilt), line_z = -film;
  // From the line to the point of focus.
  const double along_y = -line_y, along_z = kDistance - line_z;
  RandomLanes numbers(3);
  for (int i = 0; i < 200; ++i) {
    const Vec2 raster{numbers(0, 40), numbers(0, 20)};
    const SensorRay a = start_ray(*sensor, {raster, {numbers(), numbers()}, Float(0.0f)}),
                    b = start_ray(*sensor, {raster, {numbers(), numbers()}, Float(0.0f)});
    for (int l = 0; l < kWidth; ++l) {
      const auto meet = [&](const SensorRay& ray) {
        // Distance from the plane, whose normal in (y, z) is (along_z, -along_y).
        const double before =
            along_z * (ray.origin.y.lane(l) - line_y) - along_y * (ray.origin.z.lane(l) - line_z);
        const double slope = along_z * ray.direction.y.lane(l) - along_y * ray.direction.z.lane(l);
        const double t = -before / slope;
        return std::array{ray.origin.x.lane(l) + t * ray.direction.x.lane(l),
                          ray.origin.y.lane(l) + t * ray.direction.y.lane(l),
                          ray.origin.z.lane(l) + t * ray.direction.z.lane(l)};
      };
      const auto p = meet(a), q = meet(b);
      // Rays cross at an angle of a hundredth or more where the plane is up to ten units away.
      if (!(p[2] > 0 && p[2] < 10)) continue;
      for (std::size_t axis = 0; axis < 3; ++axis) ASSERT_NEAR(p[axis], q[axis], 1e-3);
      // The origins lie in the lens's own plane.
      ASSERT_NEAR(a.origin.y.lane(l) * std::sin(kTilt) + a.origin.z.lane(l) * std::cos(kTilt), 0, 1e-6);
    }
  }
}

TEST(TiltedLens, ThatCannotFocusIsRefused) {
  const std::string lens = "perspective { fov_degrees: 50 lens_radius: 0.2 focal_distance: 3 tilt { ";
  EXPECT_THAT(refusal(lens + "x_degrees: 90 focal_length: 0.1 } }"),
              testing::HasSubstr("camera: a lens is tilted by less than 90 degrees, not by 90 and 0"));
  EXPECT_THAT(refusal(lens + "x_degrees: 5 } }"), testing::HasSubstr("needs a focal length above 0"));
  EXPECT_THAT(refusal(lens + "x_degrees: 60 focal_length: 1.6 } }"),
              testing::HasSubstr("cannot focus at 3, but only beyond 3.2"));
  EXPECT_THAT(refusal(lens + "x_degrees: 60 focal_length: 0.05 } }"),
              testing::HasSubstr("the plane of focus passes through the lens"));
  EXPECT_THAT(
      refusal("perspective { fov_degrees: 120 lens_radius: 0.01 focal_distance: 3 tilt { x_degrees: 50 "
              "focal_length: 0.1 } }"),
      testing::HasSubstr("the film reaches through the plane of the lens"));
  // A pinhole looks the same with any.
  EXPECT_TRUE(
      sensor_of("perspective { fov_degrees: 50 tilt { x_degrees: 60 focal_length: 1 } }", {40, 20}).ok());
}

// ---------------------------------------------------------------- stereo, panoramas and cube maps

Vec3 lanes(double x, double y, double z) {
  return {Float(static_cast<float>(x)), Float(static_cast<float>(y)), Float(static_cast<float>(z))};
}

TEST(Viewpoint, ThoseOffTheAxisSeeOneWindowAtTheConvergenceDistance) {
  const std::string camera = "perspective { fov_degrees: 60 } viewpoint { x: ";
  for (const char* const more : {" convergence_distance: 2 }", " axes: TOE_IN convergence_distance: 2 }"}) {
    const auto middle = sensor_of("perspective { fov_degrees: 60 }", {40, 20}),
               left = sensor_of(camera + "-0.2" + more, {40, 20}),
               right = sensor_of(camera + "0.2" + more, {40, 20});
    ASSERT_TRUE(middle.ok() && left.ok() && right.ok());
    const auto seen = [](const SensorRecord& sensor, Vec3 point) {
      return connect_to_sensor(sensor, point, {Float(0.5f), Float(0.5f)}, Float(0.0f), Mask::all()).raster;
    };
    const Vec3 focus = lanes(0, 0, 2), before = lanes(0, 0, 1), off = lanes(0.6, 0.3, 2);
    for (const SensorRecord& eye : {*left, *right}) {
      EXPECT_NEAR(seen(eye, focus).x.lane(0), 20, 1e-4);
      EXPECT_NEAR(seen(eye, focus).y.lane(0), 10, 1e-4);
      const Vec2 at = seen(eye, off), expected = seen(*middle, off);
      const bool is_toe_in = std::string(more).find("TOE_IN") != std::string::npos;
      EXPECT_EQ(std::abs(at.x.lane(0) - expected.x.lane(0)) < 1e-4, !is_toe_in);
    }
    // Things before it are crossed: the left eye sees them to the right.
    EXPECT_GT(seen(*left, before).x.lane(0), 20.5);
    EXPECT_LT(seen(*right, before).x.lane(0), 19.5);
  }
  const auto parallel = sensor_of(camera + "-0.2 axes: PARALLEL convergence_distance: 2 }", {40, 20});
  ASSERT_TRUE(parallel.ok());
  const SensorRay ray = start_ray(*parallel, middle_sample({Float(20.0f), Float(10.0f)}));
  EXPECT_NEAR(ray.direction.z.lane(0), 1, 1e-6);
  EXPECT_NEAR(ray.origin.x.lane(0), -0.2, 1e-6);
}

TEST(Panorama, EyesGoAroundOnACircle) {
  const auto left = sensor_of(
      "panorama { } viewpoint { x: -0.03 y: 0.5 convergence_distance: 2 pole_merge_from_degrees: 60 "
      "pole_merge_to_degrees: 75 }",
      {360, 180});
  ASSERT_TRUE(left.ok()) << left.status();
  const auto ray_at = [&](double longitude, double latitude) {
    return start_ray(*left, middle_sample({Float(static_cast<float>(180 + longitude)),
                                           Float(static_cast<float>(90 - latitude))}));
  };
  // Ahead, to the right and behind: the eye is to the left of where it looks, and its rays meet the middle's.
  for (const double turn : {0.0, 90.0, 180.0, -37.0}) {
    const SensorRay ray = ray_at(turn, 0);
    const double s = std::sin(turn * pi / 180), c = std::cos(turn * pi / 180);
    EXPECT_NEAR(ray.origin.x.lane(0), -0.03 * c, 1e-6);
    EXPECT_NEAR(ray.origin.y.lane(0), 0.5, 1e-6);
    EXPECT_NEAR(ray.origin.z.lane(0), 0.03 * s, 1e-6);
    const double t = std::hypot(2, 0.03);
    EXPECT_NEAR(ray.origin.x.lane(0) + t * ray.direction.x.lane(0), 2 * s, 1e-5);
    EXPECT_NEAR(ray.origin.z.lane(0) + t * ray.direction.z.lane(0), 2 * c, 1e-5);
  }
  // Between the two latitudes the circle shrinks by a quarter of a cosine.
  EXPECT_NEAR(ray_at(0, 60).origin.x.lane(0), -0.03, 1e-6);
  EXPECT_NEAR(ray_at(0, -65).origin.x.lane(0), -0.03 * std::cos(pi / 6), 1e-6);
  EXPECT_NEAR(ray_at(0, 75.5).origin.x.lane(0), 0, 1e-6);
  EXPECT_THAT(refusal("panorama { } viewpoint { pole_merge_from_degrees: 80 pole_merge_to_degrees: 75 }"),
              testing::HasSubstr("not from 80 to 75"));
  EXPECT_THAT(
      refusal(
          "perspective { fov_degrees: 50 } viewpoint { pole_merge_to_degrees: 75 convergence_distance: -1 }"),
      testing::AllOf(testing::HasSubstr("only panoramas merge"), testing::HasSubstr("not -1")));
  EXPECT_THAT(refusal("panorama { longitude_min_degrees: 10 longitude_max_degrees: 5 }"),
              testing::HasSubstr("not from 10 to 5 and from -90 to 90"));
}

TEST(CubeMap, FacesLieWhereTheirLayoutSays) {
  struct Face {
    double column, row;  // of the middle of its cell
    std::array<float, 3> forward, up;
  };
  struct Layout {
    const char* camera;
    FilmSize film;
    std::vector<Face> faces;
  };
  constexpr std::array<float, 3> kX{1, 0, 0}, kY{0, 1, 0}, kZ{0, 0, 1}, kLeft{-1, 0, 0}, kDown{0, -1, 0},
      kBack{0, 0, -1};
  const Layout layouts[] = {{"cube_map { }",
                             {40, 30},
                             {{1.5, 0.5, kY, kBack},
                              {0.5, 1.5, kLeft, kY},
                              {1.5, 1.5, kZ, kY},
                              {2.5, 1.5, kX, kY},
                              {3.5, 1.5, kBack, kY},
                              {1.5, 2.5, kDown, kZ}}},
                            {"cube_map { layout: VERTICAL_CROSS }",
                             {30, 40},
                             {{1.5, 0.5, kY, kBack},
                              {0.5, 1.5, kLeft, kY},
                              {1.5, 1.5, kZ, kY},
                              {2.5, 1.5, kX, kY},
                              {1.5, 2.5, kDown, kZ},
                              {1.5, 3.5, kBack, kDown}}},
                            {"cube_map { layout: STRIP }",
                             {60, 10},
                             {{0.5, 0.5, kX, kY},
                              {1.5, 0.5, kLeft, kY},
                              {2.5, 0.5, kY, kBack},
                              {3.5, 0.5, kDown, kZ},
                              {4.5, 0.5, kZ, kY},
                              {5.5, 0.5, kBack, kY}}}};
  for (const Layout& layout : layouts) {
    const auto sensor = sensor_of(layout.camera, layout.film);
    ASSERT_TRUE(sensor.ok()) << sensor.status();
    for (const Face& face : layout.faces) {
      const auto ray_at = [&](double row) {
        return start_ray(*sensor, middle_sample({Float(static_cast<float>(10 * face.column)),
                                                 Float(static_cast<float>(10 * row))}));
      };
      const SensorRay middle = ray_at(face.row), upper = ray_at(face.row - 0.4);
      ASSERT_TRUE(all(middle.valid & upper.valid));
      const auto along = [](const SensorRay& ray, const std::array<float, 3>& axis) {
        return ray.direction.x.lane(0) * axis[0] + ray.direction.y.lane(0) * axis[1] +
               ray.direction.z.lane(0) * axis[2];
      };
      EXPECT_NEAR(along(middle, face.forward), 1, 1e-6);
      // Eight tenths of the way to the upper edge, which is at 45 degrees.
      EXPECT_NEAR(along(upper, face.up) / along(upper, face.forward), 0.8, 1e-5);
    }
  }
  EXPECT_THAT(
      refusal("cube_map { }", {100, 100}),
      testing::HasSubstr("layout CROSS has 4 x 3 square faces: a film of 100 x 100 pixels does not, one of "
                         "100 x 75 does"));
  EXPECT_THAT(refusal("cube_map { layout: STRIP }", {601, 100}), testing::HasSubstr("one of 600 x 100 does"));
  EXPECT_THAT(refusal("cube_map { layout: FRONT } screen_window: [-1, 1, -1, 1]", {10, 10}),
              testing::HasSubstr("no screen window"));
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA

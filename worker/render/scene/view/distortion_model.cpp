#include "render/scene/view/distortion_model.h"

#include <cmath>
#include <utility>
#include <vector>

namespace tessera::render {

namespace {

/// A number, and its derivatives by the two coordinates that all numbers come from.
struct Dual {
  double value = 0, by_x = 0, by_y = 0;
};
Dual operator+(Dual a, Dual b) { return {a.value + b.value, a.by_x + b.by_x, a.by_y + b.by_y}; }
Dual operator+(double a, Dual b) { return {a + b.value, b.by_x, b.by_y}; }
Dual operator*(Dual a, Dual b) {
  return {a.value * b.value, a.by_x * b.value + a.value * b.by_x, a.by_y * b.value + a.value * b.by_y};
}
Dual operator*(double a, Dual b) { return {a * b.value, a * b.by_x, a * b.by_y}; }
Dual operator/(Dual a, Dual b) {
  const double quotient = a.value / b.value;
  return {quotient, (a.by_x - quotient * b.by_x) / b.value, (a.by_y - quotient * b.by_y) / b.value};
}

PlaceAndSlopes place_of(Dual x, Dual y) { return {{x.value, y.value}, x.by_x, x.by_y, y.by_x, y.by_y}; }

/// [OpenCV, calib3d: Camera Calibration and 3D Reconstruction; Zhang 2000, Weng et al. 1992, Louhichi et al.
/// 2007]
class OpenCv final : public DistortionModel {
 public:
  explicit OpenCv(const v1::OpenCvDistortion& k) : k_(k) {
    const double cx = std::cos(k.tau_x_radians()), sx = std::sin(k.tau_x_radians());
    const double cy = std::cos(k.tau_y_radians()), sy = std::sin(k.tau_y_radians());
    // R, which turns the film about x, then about y; its places are projected back along its normal.
    const double turn[3][3] = {{cy, sy * sx, -sy * cx}, {0, cx, sx}, {sy, -cy * sx, cy * cx}};
    for (int i = 0; i < 3; ++i) {
      tilt_[0][i] = turn[2][2] * turn[0][i] - turn[0][2] * turn[2][i];
      tilt_[1][i] = turn[2][2] * turn[1][i] - turn[1][2] * turn[2][i];
      tilt_[2][i] = turn[2][i];
    }
  }

  bool leads_to_film() const override { return true; }
  PlaceAndSlopes move(PlanePoint from) const override {
    // OpenCV's y points downwards.
    const Dual x{from.x, 1, 0}, y{-from.y, 0, -1};
    const Dual xx = x * x, yy = y * y, xy = x * y, r2 = xx + yy;
    const auto cubic = [&](double a, double b, double c) { return 1 + r2 * (a + r2 * (b + c * r2)); };
    const Dual radial = cubic(k_.k1(), k_.k2(), k_.k3()) / cubic(k_.k4(), k_.k5(), k_.k6());
    const Dual moved_x =
        x * radial + 2 * k_.p1() * xy + k_.p2() * (r2 + 2 * xx) + r2 * (k_.s1() + k_.s2() * r2);
    const Dual moved_y =
        y * radial + k_.p1() * (r2 + 2 * yy) + 2 * k_.p2() * xy + r2 * (k_.s3() + k_.s4() * r2);
    const auto row = [&](int i) { return tilt_[i][2] + (tilt_[i][0] * moved_x + tilt_[i][1] * moved_y); };
    const Dual scale = row(2);
    return place_of(row(0) / scale, -1.0 * (row(1) / scale));
  }

 private:
  const v1::OpenCvDistortion k_;
  double tilt_[3][3] = {};
};

/// Distances from the middle that are multiplied by a function of themselves.
class Radial final : public DistortionModel {
 public:
  /// The factor is the sum of coefficients[i] times the distance to the power of i.
  Radial(std::vector<double> coefficients, bool leads_to_film)
      : coefficients_(std::move(coefficients)), leads_to_film_(leads_to_film) {}

  bool leads_to_film() const override { return leads_to_film_; }
  PlaceAndSlopes move(PlanePoint from) const override {
    const Dual x{from.x, 1, 0}, y{from.y, 0, 1};
    const double distance = std::hypot(from.x, from.y);
    const Dual r = distance > 0 ? Dual{distance, from.x / distance, from.y / distance} : Dual{};
    Dual factor;
    for (auto i = coefficients_.rbegin(); i != coefficients_.rend(); ++i) factor = *i + factor * r;
    return place_of(x * factor, y * factor);
  }

 private:
  const std::vector<double> coefficients_;
  const bool leads_to_film_;
};

}  // namespace

std::unique_ptr<const DistortionModel> distortion_model(const v1::LensDistortion& distortion) {
  switch (distortion.kind_case()) {
    case v1::LensDistortion::kOpencv:
      return std::make_unique<OpenCv>(distortion.opencv());
    case v1::LensDistortion::kOpencvFisheye: {
      // [Kannala & Brandt 2006]
      const v1::OpenCvFisheyeDistortion& k = distortion.opencv_fisheye();
      return std::make_unique<Radial>(std::vector<double>{1, 0, k.k1(), 0, k.k2(), 0, k.k3(), 0, k.k4()},
                                      true);
    }
    case v1::LensDistortion::kPolynomial: {
      const auto& angle = distortion.polynomial().angle();
      return std::make_unique<Radial>(std::vector<double>{angle.begin(), angle.end()}, false);
    }
    default:
      return nullptr;
  }
}

std::optional<PlaceAndSlopes> find_origin(const DistortionModel& model, PlanePoint to, PlanePoint near) {
  constexpr int kSteps = 30;
  constexpr double kEnough = 1e-13;
  PlanePoint at = near;
  for (int i = 0; i < kSteps; ++i) {
    const PlaceAndSlopes moved = model.move(at);
    const double determinant = moved.determinant();
    // Negated, so that NaN ends it, too.
    if (!(determinant > 0)) return std::nullopt;
    const double rest_x = to.x - moved.place.x, rest_y = to.y - moved.place.y;
    const double step_x = (moved.yy * rest_x - moved.xy * rest_y) / determinant,
                 step_y = (moved.xx * rest_y - moved.yx * rest_x) / determinant;
    at = {at.x + step_x, at.y + step_y};
    if (std::hypot(step_x, step_y) <= kEnough * (1 + std::hypot(at.x, at.y))) {
      return PlaceAndSlopes{at, moved.yy / determinant, -moved.xy / determinant, -moved.yx / determinant,
                            moved.xx / determinant};
    }
  }
  return std::nullopt;
}

}  // namespace tessera::render

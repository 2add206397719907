#include "image/view/display_view.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "base/nearest_name.h"
#include "image/view/ocio_view.h"

namespace tessera::client {

float srgb_encoded(float linear) {
  if (!(linear > 0)) return 0;  // NaN too
  if (linear >= 1) return 1;
  return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1 / 2.4f) - 0.055f;
}

namespace {

using spectra::Matrix3;
using spectra::Triple;

/// A number that curves can take: colours without bound are as bright as half floats can be.
double bounded(double value) { return value > 0 ? std::min(value, 65504.0) : 0; }

Triple srgb(const Triple& color) {
  Triple codes;
  for (std::size_t c = 0; c < 3; ++c) codes[c] = srgb_encoded(static_cast<float>(color[c]));
  return codes;
}

Triple filmic(const Triple& color) {
  Triple shown;
  for (std::size_t c = 0; c < 3; ++c) {
    const double x = bounded(color[c]);
    shown[c] = x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
  }
  return srgb(shown);
}

Triple aces(const Triple& color) {
  // From Rec.709 to the rendering space with its loss of saturation, and back from the screen's.
  constexpr Matrix3 kIn = {
      {{0.59719, 0.35458, 0.04823}, {0.07600, 0.90834, 0.01566}, {0.02840, 0.13383, 0.83777}}};
  constexpr Matrix3 kOut = {
      {{1.60475, -0.53108, -0.07367}, {-0.10208, 1.10813, -0.00605}, {-0.00327, -0.07276, 1.07602}}};
  Triple rendered = spectra::times(kIn, {bounded(color[0]), bounded(color[1]), bounded(color[2])});
  for (double& x : rendered)
    x = (x * (x + 0.0245786) - 0.000090537) / (x * (0.983729 * x + 0.4329510) + 0.238081);
  return srgb(spectra::times(kOut, rendered));
}

/// The half of a sigmoid on one side of its pivot: it leaves the pivot with `slope` and reaches `height` at
/// the distance `length`, the more suddenly the higher the power.
double half_sigmoid(double distance, double slope, double length, double height, double power) {
  const double scale = slope * length / std::pow(std::pow(slope * length / height, power) - 1, 1 / power);
  const double along = slope * distance / scale;
  return scale * along / std::pow(1 + std::pow(along, power), 1 / power);
}

Triple agx(const Triple& color) {
  constexpr Matrix3 kInset = {{{0.842479062253094, 0.0784335999999992, 0.0792237451477643},
                               {0.0423282422610123, 0.878468636469772, 0.0791661274605434},
                               {0.0423756549057051, 0.0784336, 0.879142973793104}}};
  static const Matrix3 kOutset = spectra::inverse(kInset);
  // Exposures from 10 stops below middle grey to 6.5 above; grey comes to the middle of a screen of
  // gamma 2.2.
  constexpr double kGrey = 0.18, kStopsBelow = 10, kStops = 16.5, kPivot = kStopsBelow / kStops;
  constexpr double kGreyCode = 0.5, kSlope = 2, kToePower = 3, kShoulderPower = 3.25, kGamma = 2.2;
  Triple code = spectra::times(kInset, {bounded(color[0]), bounded(color[1]), bounded(color[2])});
  for (double& x : code) {
    const double stops = std::log2(std::max(x, 1e-10) / kGrey);
    const double place = std::clamp((stops + kStopsBelow) / kStops, 0.0, 1.0);
    x = place < kPivot
            ? kGreyCode - half_sigmoid(kPivot - place, kSlope, kPivot, kGreyCode, kToePower)
            : kGreyCode + half_sigmoid(place - kPivot, kSlope, 1 - kPivot, 1 - kGreyCode, kShoulderPower);
  }
  Triple shown = spectra::times(kOutset, code);
  for (double& x : shown) x = std::pow(std::clamp(x, 0.0, 1.0), kGamma);
  return srgb(shown);
}

class ColorFunctionView final : public DisplayView {
 public:
  explicit ColorFunctionView(Triple (*function)(const Triple&)) : function_(function) {}
  void show(std::span<Triple> row) const override {
    for (Triple& color : row) color = function_(color);
  }

 private:
  Triple (*function_)(const Triple&);
};

}  // namespace

const std::vector<std::string>& builtin_views() {
  static const std::vector<std::string> views = {"srgb", "filmic", "aces", "agx"};
  return views;
}

absl::StatusOr<std::unique_ptr<DisplayView>> make_display_view(const ViewOptions& options) {
  if (!options.ocio_config.empty()) return make_ocio_view(options);
  constexpr Triple (*kFunctions[])(const Triple&) = {srgb, filmic, aces, agx};
  const std::vector<std::string>& views = builtin_views();
  const auto view = std::ranges::find(views, options.name.empty() ? views.front() : options.name);
  if (view == views.end()) {
    return absl::InvalidArgumentError(
        absl::StrCat("there is no view \"", options.name, "\" but ", absl::StrJoin(views, ", "),
                     " without a configuration of OpenColorIO", base::did_you_mean(options.name, views)));
  }
  return std::make_unique<ColorFunctionView>(kFunctions[view - views.begin()]);
}

}  // namespace tessera::client

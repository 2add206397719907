#include "render/scene/shape/intersection.h"

#include "absl/strings/str_format.h"
#include "render/scene/shape/blocked_light.h"

namespace tessera::render {
namespace {

std::string name_of(std::int32_t shape, const std::vector<std::string>& names) {
  return shape < 0 ? std::string() : names[static_cast<std::size_t>(shape)];
}

}  // namespace

bool wants_robust_intersection(const IntersectionProbe& probe, const std::vector<std::string>& names,
                               v1::Intersection wanted, std::vector<std::string>& warnings) {
  constexpr double kNoticeable = 0.01;
  if (probe.too_fine > kNoticeable) {
    warnings.push_back(absl::StrFormat(
        "%s: seen from the camera, %.0f %% of the scene's surfaces have features smaller than a "
        "millionth of their distance; 32-bit floats do "
        "not hold them, and shadows at contacts are off",
        name_of(probe.finest_shape, names), 100 * probe.too_fine));
  }
  if (wanted == v1::INTERSECTION_FAST || wanted == v1::INTERSECTION_ROBUST)
    return wanted == v1::INTERSECTION_ROBUST;
  if (!probe.wants_robust()) return false;
  const bool border = probe.border_leak > IntersectionProbe::kSafeBorderLeak;
  const bool shape = probe.shape_leak > IntersectionProbe::kSafeShapeLeak;
  const double leak = border ? probe.border_leak : shape ? probe.shape_leak : probe.leak;
  warnings.push_back(absl::StrFormat(
      "%s: fast intersection would let %.1g of the rays through %s; the robust one is used, which is "
      "10 to 25 %% slower (--intersection fast "
      "or robust decides)",
      name_of(border ? probe.leaking_border : probe.leaking_shape, names), leak,
      border  ? "this border of a medium"
      : shape ? "this mesh"
              : "the scene's meshes, this one most"));
  return true;
}

bool leaks_would_show(const IntersectionProbe& probe, const SceneArrays& arrays, const RayQuery& rays,
                      const std::vector<std::string>& names, std::vector<std::string>& warnings) {
  if (!(probe.leak > 0) || !measure_blocked_light(arrays, rays).shows(probe.leak)) return false;
  warnings.push_back(
      absl::StrFormat("%s: fast intersection would let %.1g of the rays through the scene's meshes, this one "
                      "most, and much brighter light is behind them than arrives; the robust one is used, "
                      "which is 10 to 25 %% slower (--intersection fast or robust decides)",
                      name_of(probe.leaking_shape, names), probe.leak));
  return true;
}

}  // namespace tessera::render

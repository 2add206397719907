#include "render/build/shape/intersection.h"

#include "absl/strings/str_format.h"
#include "render/accel/intersection_probe.h"

namespace tessera::render {

bool wants_robust_intersection(const ShapeTable& shapes, const std::vector<std::string>& names,
                               v1::Intersection wanted, std::vector<std::string>& warnings) {
  const IntersectionProbe probe = probe_intersection(shapes);
  const auto name = [&](std::int32_t shape) {
    return shape < 0 ? std::string() : names[static_cast<std::size_t>(shape)];
  };
  constexpr double kNoticeable = 0.01;
  if (probe.too_fine > kNoticeable) {
    warnings.push_back(absl::StrFormat(
        "%s: seen from the camera, %.0f %% of the scene's surfaces have features smaller than a "
        "millionth of their distance; 32-bit floats do "
        "not hold them, and shadows at contacts are off",
        name(probe.finest_shape), 100 * probe.too_fine));
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
      name(border ? probe.leaking_border : probe.leaking_shape), leak,
      border  ? "this border of a medium"
      : shape ? "this mesh"
              : "the scene's meshes, this one most"));
  return true;
}

}  // namespace tessera::render

#include "absl/strings/str_format.h"
#include "render/accel/intersection_probe.h"
#include "render/build/scene_builder.h"

namespace tessera::render {

bool SceneBuilder::wants_robust_intersection() {
  const IntersectionProbe probe = probe_intersection(arrays_.shapes);
  const auto name = [&](std::int32_t shape) {
    return shape < 0 ? std::string() : shape_names_[static_cast<std::size_t>(shape)];
  };
  constexpr double kNoticeable = 0.01;
  if (probe.too_fine > kNoticeable) {
    warnings_.push_back(absl::StrFormat(
        "%s: seen from the camera, %.0f %% of the scene's surfaces have features smaller than a "
        "millionth of their distance; 32-bit floats do "
        "not hold them, and shadows at contacts are off",
        name(probe.finest_shape), 100 * probe.too_fine));
  }
  if (intersection_ == v1::INTERSECTION_FAST || intersection_ == v1::INTERSECTION_ROBUST)
    return intersection_ == v1::INTERSECTION_ROBUST;
  if (!probe.wants_robust()) return false;
  const bool border = probe.border_leak > IntersectionProbe::kSafeBorderLeak;
  const bool shape = probe.shape_leak > IntersectionProbe::kSafeShapeLeak;
  const double leak = border ? probe.border_leak : shape ? probe.shape_leak : probe.leak;
  warnings_.push_back(absl::StrFormat(
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

// Where the cameras of a light field stand.
#pragma once

#include <ImathBox.h>

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "light_field/manifest.h"
#include "tessera/v1/camera.pb.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::client {

/// Size of all views.
struct ViewSize {
  std::uint32_t width = 512, height = 512;
};

struct CapturePlan {
  light_field::Arrangement arrangement;
  std::vector<light_field::Pinhole> cameras;
};

/// Boxes about what is seen, world space.
struct SceneBounds {
  Imath::Box3d all;
  std::vector<std::pair<std::string, Imath::Box3d>> shapes;  // names
};

/// Directions that all cameras share.
struct Uprightness {
  Imath::V3d up{0, 1, 0};
  bool mirrored = false;  // the handedness of cameras is not that of the world (light_field::mirrors())
};

struct TwoPlaneRequest {
  std::uint32_t columns = 17, rows = 17;
  double spacing_x = 0, spacing_y = 0;  // world units
  double focus = 0;                     // from the cameras' plane to that of (u, v), world units
};
/// Cameras beside the scene's own, in the plane of its x and y axes, with the window that it has at the
/// focus. InvalidArgument where that camera is no perspective and no field of view is given.
absl::StatusOr<CapturePlan> plan_two_plane(const TwoPlaneRequest& request, const v1::Camera& middle,
                                           std::optional<double> fov_degrees, const ViewSize& size);

struct SphereRequest {
  std::uint32_t cameras = 100;
  std::optional<Imath::V3d> target;  // absent: the middle of the scene's bounds
  std::optional<double> radius;      // absent: three times that of the ball around the bounds
};
/// Cameras on a sphere that look at its middle, evenly spread [Swinbank & Purser 2006], with the ball around
/// the scene's bounds in view unless a field of view is given. InvalidArgument where they would stand in it.
absl::StatusOr<CapturePlan> plan_sphere(const SphereRequest& request, const SceneBounds& bounds,
                                        const Uprightness& upright, std::optional<double> fov_degrees,
                                        const ViewSize& size);

struct BoxRequest {
  std::uint32_t columns = 9, rows = 9;  // of each face
  std::optional<Imath::Box3d> box;      // absent: a quarter larger than the scene's bounds
  bool outwards = false;                // rays that enter the box, for eyes within it
};
/// Grids of cameras on the six faces of a box. They look inwards, each with all that lies in the box in view:
/// the rays that leave it. InvalidArgument names the shapes that the box cuts.
absl::StatusOr<CapturePlan> plan_box(const BoxRequest& request, const SceneBounds& bounds,
                                     const Uprightness& upright, std::optional<double> fov_degrees,
                                     const ViewSize& size);

/// That of the scene's own camera.
Uprightness uprightness_of(const v1::Camera& camera);

/// Gives the scene these cameras, as its camera and views. The medium and the shutter of its own camera stay;
/// lenses, distortion and clipping do not.
void set_cameras(const std::vector<light_field::Pinhole>& cameras, const ViewSize& size, v1::Scene& scene);

/// Bytes that a capture takes: on disk at most, and of memory while it is rendered.
struct CaptureSize {
  std::uint64_t pixels = 0, disk = 0, memory = 0;
};
CaptureSize size_of_capture(std::size_t views, const ViewSize& size, bool half);
/// OutOfRange, with what would fit, where the set needs more than there is.
absl::Status check_size(std::size_t views, const ViewSize& size, bool half, std::uint64_t free_disk,
                        std::uint64_t free_memory);

}  // namespace tessera::client

#include "render/scene/view/lens_faults.h"

#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "wire/lens_message.h"

namespace tessera::render {

namespace {

class Faults {
 public:
  template <class Message>
  void add(const Message& element, const char* field, std::string message) {
    found_.push_back({&element, Message::descriptor()->FindFieldByName(field)->number(), std::move(message)});
  }
  void add(LensFault fault) { found_.push_back(std::move(fault)); }
  std::vector<LensFault> take() { return std::move(found_); }

 private:
  std::vector<LensFault> found_;
};

/// `barrel_fault`: why the lens has no barrel; null: it may have one.
void check_aperture(const v1::LensAperture& aperture, const char* barrel_fault, Faults& faults) {
  if (aperture.has_blades() && !(aperture.blades() >= 3 && aperture.blades() <= 64))
    faults.add(aperture, "blades", absl::StrCat("an aperture has 3 to 64 blades, not ", aperture.blades()));
  if (aperture.has_blades() && aperture.has_image())
    faults.add(aperture, "image", "an aperture's blades and its image exclude each other");
  if (!std::isfinite(aperture.blade_degrees()))
    faults.add(aperture, "blade_degrees",
               absl::StrCat("an aperture's blades are not turned by ", aperture.blade_degrees(), " degrees"));
  if (aperture.has_ratio() && !(aperture.ratio() >= 1e-3 && aperture.ratio() <= 1e3))
    faults.add(aperture, "ratio",
               absl::StrCat("an aperture's ratio is from 0.001 to 1000, not ", aperture.ratio()));
  const double length = aperture.barrel_length(), radius = aperture.barrel_radius();
  if (!(length >= 0 && length <= 1e6))
    faults.add(aperture, "barrel_length",
               absl::StrCat("a barrel is 0 to 1e6 radii of the lens long, not ", length));
  if (aperture.has_barrel_radius() && !(radius >= 1e-3 && radius <= 1e6))
    faults.add(aperture, "barrel_radius",
               absl::StrCat("a barrel's circle has 0.001 to 1e6 radii of the lens, not ", radius));
  if (barrel_fault != nullptr && length > 0) faults.add(aperture, "barrel_length", barrel_fault);
}

/// `lens`: a message that has a lens_radius, a focal_distance and an aperture. `focused`: something else says
/// what is sharp.
template <class CameraKind>
void check_thin_lens(const CameraKind& lens, const char* barrel_fault, bool focused, Faults& faults) {
  const float radius = lens.lens_radius(), distance = lens.focal_distance();
  constexpr const char* kWhat = "a lens needs a finite radius and a focal distance above 0";
  if (!(radius >= 0) || !std::isfinite(radius)) {
    faults.add(lens, "lens_radius", kWhat);
  } else if (radius > 0 && !focused && !(distance > 0 && std::isfinite(distance))) {
    faults.add(lens, "focal_distance", kWhat);
  }
  check_aperture(lens.aperture(), barrel_fault, faults);
}

}  // namespace

std::vector<LensFault> lens_faults_of(const v1::Camera& camera) {
  Faults faults;
  const bool focused = camera.has_focus_point();
  if (camera.has_perspective()) {
    const v1::PerspectiveCamera& perspective = camera.perspective();
    check_thin_lens(perspective, nullptr, focused, faults);
    if (perspective.has_tilt() && perspective.aperture().barrel_length() > 0)
      faults.add(perspective.aperture(), "barrel_length", "a lens that is tilted has no barrel");
  }
  if (camera.has_orthographic()) {
    check_thin_lens(camera.orthographic(),
                    "orthographic cameras have no barrel, which would look the same from all of the film",
                    focused, faults);
  }
  if (camera.has_panorama()) {
    const v1::PanoramaCamera& panorama = camera.panorama();
    check_thin_lens(panorama, "panoramas have no barrel, which would look the same from all of the film",
                    false, faults);
    if (panorama.lens_radius() > 0 && camera.viewpoint().x() != 0) {
      faults.add(panorama, "lens_radius",
                 absl::StrCat("a panorama with a lens has its eye in the middle, not at a viewpoint x of ",
                              camera.viewpoint().x()));
    }
  }
  if (camera.has_lens()) {
    std::vector<optics::Fault> of_lens;
    static_cast<void>(wire::lens_system_of(camera.lens(), of_lens));
    for (const optics::Fault& fault : of_lens) {
      const wire::LensFaultPlace place = wire::place_of(fault, camera.lens());
      faults.add({place.message, place.field, absl::StrCat("the lens: ", fault.message)});
    }
  }
  return faults.take();
}

}  // namespace tessera::render

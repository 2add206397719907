// A lens as it is used: focused at a distance, its stop opened so far; and rays through it.
//
// The film lies in the plane z = 0, its middle on the axis, and the scene at larger z. Lengths are in
// millimetres, wavelengths in nanometres.
#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "optics/paraxial.h"
#include "optics/prescription.h"
#include "optics/ray.h"

namespace tessera::optics {

struct LensUse {
  double focus = std::numeric_limits<double>::infinity();  // distance from the film to what is sharp
  double f_number = 0;       // focal length over the diameter of the entrance pupil; 0: as below
  double stop_diameter = 0;  // 0: the stop is open as far as its surface says
  int blades = 0;            // the stop is a polygon within its circle; 0: round
  double blade_degrees = 0;  // direction of the polygon's first corner, from x towards y
};

/// Two surfaces that reflect light on its way, the one nearer to the film first; numbers of elements.
struct Bounce {
  std::size_t near_scene = 0, near_film = 0;
};

/// A ray that has lost light to Fresnel's reflections.
struct DimmedRay {
  Ray ray;
  double part = 1;  // of its light
};

class LensSystem {
 public:
  struct Element {
    Surface surface;   // as it was prescribed, but for the stop's diameter
    double z = 0;      // of its vertex
    double curvature;  // of z over height, so that it is below 0 where the prescription's radius is above
  };

  /// Focuses a lens, by paraxial optics and then so that rays along the axis meet best. `faults` gets those
  /// of the prescription, and why it cannot be used like this; nothing is returned then. Rays through the
  /// middle of the stop reach the film of a lens that is returned.
  static std::optional<LensSystem> focus(const Prescription& lens, const LensUse& use,
                                         std::vector<Fault>& faults);

  /// Follows a ray that starts before the film, or before the first surface, through all surfaces; nothing
  /// where it is blocked, totally reflected, or misses one.
  std::optional<Ray> to_scene(Ray ray, double nm) const;
  std::optional<Ray> to_film(Ray ray, double nm) const;
  /// The surface at which a ray that starts before the film ends; size() where it gets through.
  std::size_t end_of(Ray ray, double nm) const;
  /// Where a ray that starts before the film crosses the stop, whatever apertures are in its way; nothing
  /// where it misses a surface.
  std::optional<Vector> at_stop(Ray ray, double nm) const;
  /// Where a ray that starts before the film meets the surfaces, as far as it gets.
  std::vector<Vector> path(Ray ray, double nm) const;
  /// to_scene() without apertures.
  std::optional<Ray> unstopped(Ray ray, double nm) const;

  /// to_film() and to_scene(), with what surfaces let through of the light.
  std::optional<DimmedRay> refracted_to_film(Ray ray, double nm) const;
  std::optional<DimmedRay> refracted_to_scene(Ray ray, double nm) const;
  /// Follows a ray that both surfaces reflect, and all that it crosses refract: to the film, or from it to
  /// the scene. Nothing where it does not come so far; with `stopped` false apertures let all through.
  std::optional<DimmedRay> reflected_to_film(Ray ray, const Bounce& bounce, double nm,
                                             bool stopped = true) const;
  std::optional<DimmedRay> reflected_to_scene(Ray ray, const Bounce& bounce, double nm) const;
  /// All pairs of surfaces that reflect anything along the axis.
  std::vector<Bounce> bounces(double nm) const;

  const std::vector<Element>& elements() const { return elements_; }  // from the scene to the film
  std::size_t stop() const { return stop_; }
  const LensUse& use() const { return use_; }
  const Prescription& prescription() const { return lens_; }
  /// At line d.
  const Paraxial& paraxial() const { return paraxial_; }
  double back_distance() const { return elements_.back().z; }  // from the film to the last vertex
  double front() const { return elements_.front().z; }
  /// Distance of the plane that is sharp from the film.
  double focus_distance() const { return use_.focus; }
  bool is_round() const { return round_; }       // all surfaces and the stop are bodies of revolution
  bool disperses() const { return disperses_; }  // some index depends on the wavelength

 private:
  struct Walk;

  LensSystem() = default;
  void place(double back_distance);
  bool set_stop(std::vector<Fault>& faults);
  bool set_focus(std::vector<Fault>& faults);
  bool refine_focus(std::vector<Fault>& faults);
  bool check_light(std::vector<Fault>& faults) const;
  bool passes(const Element& element, Vector at) const;
  bool step(const Element& element, double eta_before, double eta_behind, Ray& ray) const;
  static std::optional<Vector> meet(const Element& element, Ray& ray);
  std::optional<DimmedRay> follow(Ray ray, bool to_scene, const Bounce* bounce, double nm,
                                  bool stopped) const;

  Prescription lens_;
  LensUse use_;
  std::vector<Element> elements_;
  std::size_t stop_ = 0;
  bool round_ = true, disperses_ = false;
  Paraxial paraxial_;
};

}  // namespace tessera::optics

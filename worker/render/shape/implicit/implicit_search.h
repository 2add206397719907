// Searches of an implicit surface, whichever way it asks for.
#pragma once

#include "render/shape/implicit/function_roots.h"
#include "render/shape/implicit/polynomial_roots.h"

namespace tessera::render::TESSERA_ISA {

/// The first root in each chord, or a negative number; with `any`, a number above 0 where there is one.
inline Double first_roots(const ImplicitRecord& surface, const ObjectChord& chord, bool any) {
  if (surface.roots == ImplicitRoots::kSphereTracing) return first_roots_by_sphere_tracing(surface, chord);
  return surface.degree > 0 ? first_polynomial_roots(surface, chord, any)
                            : first_roots_by_enclosure(surface, chord, any);
}

inline Double value_at(const ImplicitRecord& surface, const Point3& p) {
  return run_program(surface.program, p.x, p.y, p.z);
}

/// Amount by which f may be off at `p`: below it, a value is as good as zero.
inline Double noise_floor(const ImplicitRecord& surface, const Point3& p) {
  if (surface.roots == ImplicitRoots::kSphereTracing) return Double(2 * sphere_tracing_tolerance(surface));
  if (surface.degree > 0) return Double(2 * polynomial_error(surface));
  const auto at = [](Double x) { return Interval(x, x); };
  const Interval f = run_program(surface.program, at(p.x), at(p.y), at(p.z));
  return (f.high - f.low) * Double(2.0);
}

}  // namespace tessera::render::TESSERA_ISA

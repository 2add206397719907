// First roots of functions that are no polynomials, along 16 rays.
#pragma once

#include "render/shape/implicit/object_ray.h"
#include "render/shape/implicit/run_program.h"

namespace tessera::render::TESSERA_ISA {

/// The ray parameter of the first root in each chord, or a negative number. Parts of the chord over which an
/// enclosure of f has no zero are left behind; over the others f', enclosed, tells whether there is one root,
/// or they are halved [Mitchell1990]. What is still undecided at 2^-34 of the chord is a hit, if f is
/// bounded there: the surface is touched, or is beyond what doubles tell apart. Where the surface has cells
/// (mark_cells.h), only the marked ones are searched. With `any`, a number above 0 where there is a root.
Double first_roots_by_enclosure(const ImplicitRecord& surface, const ObjectChord& chord, bool any);

/// Appends the ray parameters of all roots in the first lane's chord, in any order; of a place where the
/// surface is only touched, two. At most 65,536 parts are looked at.
void all_roots_by_enclosure(const ImplicitRecord& surface, const ObjectChord& chord,
                            std::vector<double>& found);

/// The root in each chord at whose ends f has two signs, found by Newton's method within it; a negative
/// number for others. For chords that are as short as the rounding of a hit.
Double roots_between_signs(const ImplicitRecord& surface, const ObjectChord& chord);

/// The same by steps of |f| / lipschitz, which no root is nearer than [Hart1996]; after 512 of them, by
/// enclosures.
Double first_roots_by_sphere_tracing(const ImplicitRecord& surface, const ObjectChord& chord);

/// Values of f below this are as good as zero for sphere tracing.
double sphere_tracing_tolerance(const ImplicitRecord& surface);

}  // namespace tessera::render::TESSERA_ISA

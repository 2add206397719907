// A photon as radiance estimates need it.
#pragma once

namespace tessera::render::TESSERA_ISA {

template <class Form>
struct alignas(64) PhotonFields {
  typename Form::Vector position;   // render space
  typename Form::Vector direction;  // unit, to where the light came from
  typename Form::Scalar way;        // length of its last flight
  typename Form::Colour flux;
  typename Form::Integer steps;  // events that scattered it on the way: photon_steps.h
  // 1 where it comes from a delta light by perfect mirrors and glass alone, if by anything: no path from the
  // eye finds that light. Else 0.
  typename Form::Integer alone;

  /// Calls f for each field, in all of these forms at once.
  template <class F, class... Photons>
  static void for_each(F&& f, Photons&... photons) {
    f(photons.position...);
    f(photons.direction...);
    f(photons.way...);
    f(photons.flux...);
    f(photons.steps...);
    f(photons.alone...);
  }
};

}  // namespace tessera::render::TESSERA_ISA

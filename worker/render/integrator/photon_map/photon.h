// A photon as radiance estimates need it.
#pragma once

namespace tessera::render::TESSERA_ISA {

template <class Form>
struct alignas(64) PhotonFields {
  typename Form::Vector position;   // render space
  typename Form::Vector direction;  // unit, to where the light came from
  typename Form::Colour flux;
  typename Form::Integer depth;  // events that scattered it on the way

  /// Calls f for each field, in all of these forms at once.
  template <class F, class... Photons>
  static void for_each(F&& f, Photons&... photons) {
    f(photons.position...);
    f(photons.direction...);
    f(photons.flux...);
    f(photons.depth...);
  }
};

}  // namespace tessera::render::TESSERA_ISA

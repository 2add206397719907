// Metropolis light transport [Veach & Guibas 1997] in primary sample space, with the ways of bidirectional
// path tracing as a coordinate [Hachisuka, Kaplanyan & Dachsbacher 2014].
//
// A pass is as many mutations as the film has pixels, or one family of chains where that is more. What the
// camera sees of lights without any scattering is added by camera rays.
#pragma once

#include "render/integrator/integrator.h"
#include "render/transport/mlt/chains.h"
#include "render/transport/mlt/path_maker.h"
#include "render/transport/path/wavefront.h"

namespace tessera::render::TESSERA_ISA {

class Metropolis final : public Integrator {
 public:
  explicit Metropolis(const IntegratorContext& context);

  bool render(SampleSource& work, Film& film, std::stop_token stop) override;

 private:
  const SceneTables& scene_;
  const std::uint64_t seed_;
  Wavefront eye_;  // finds lights that are seen directly
  PathMaker paths_;
  Chains chains_;
  std::uint32_t families_;  // a pass
};

}  // namespace tessera::render::TESSERA_ISA

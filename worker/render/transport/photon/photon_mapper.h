// Progressive photon mapping: a pass traces photons and gathers those within a radius that is a function of
// the pass alone; the mean of all passes tends to the right picture [Hachisuka, Ogaki & Jensen 2008; Knaus &
// Zwicker 2011].
//
// Paths from the eye follow mirrors, glass and narrow lobes, and gather wherever there is more to scatter
// light. Light that comes straight from its source is sampled there; the photons bring all that was scattered
// on its way, caustics and diffuse light alike. Where following would find the same light as photons do, it
// is left to following. Caustics, the light that mirrors, glass and narrow lobes bundle, have a map of their
// own, and by option another radius. With the same maps for all passes it is the classic algorithm [Jensen
// 1996].
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>

#include "render/integrator/integrator.h"
#include "render/transport/photon/radiance_estimate.h"
#include "render/transport/vertex/layer_observer.h"
#include "render/transport/vertex/light_paths.h"
#include "render/transport/vertex/sample_batch.h"

namespace tessera::render::TESSERA_ISA {

class PhotonMapper final : public Integrator {
 public:
  explicit PhotonMapper(const IntegratorContext& context);

  bool render(SampleSource& work, Film& film, std::stop_token stop) override;

  /// Most photons that both maps keep. Where paths leave more, each is kept with the same probability, a
  /// power of 1/2.
  static constexpr std::int32_t kMostKept = 1 << 21;

 private:
  /// Photons of one kind.
  struct Kind {
    float first_pass_radius;
    std::uint32_t salt;  // makes its random numbers its own
    float radius = 0;
    RadianceMap map = {};
  };

  bool trace_photons(std::uint32_t pass, std::stop_token stop);
  void keep_photons(const LightEvent& e, Mask hit, int depth);
  /// Lanes of photons `names`, numbers of their own, that are among those kept.
  Mask are_kept(UInt names) const;

  void advance(int depth);
  void add_emission(const Encounter& e);
  void sample_one_light(const Encounter& e, Mask wanted);
  void gather(const Kind& kind, const Encounter& e, Mask wanted);
  /// Lanes that see a place on the last flight of their photon, drawn within a few radii of its end.
  Mask sees(const Encounter& e, const DrawnPhoton& photon, float radius, Mask wanted);
  void follow(const Encounter& e, int& kept);
  void trace_shadow_rays();

  const SceneTables& scene_;
  const RayQuery& rays_;
  RenderStats& stats_;
  const std::uint64_t seed_;
  const std::int32_t photons_;  // paths of a pass

  LightPaths light_paths_;
  Kind caustics_, others_;
  std::optional<std::uint32_t> mapped_;  // the pass whose photons the maps have
  std::uint32_t photons_named_ = 0;
  int halvings_ = 0;  // times that the photons kept have been halved

  SampleBatch batch_;
  int alive_ = 0;
  PathState paths_;
  HitState hits_;
  ConnectionQueue shadows_, ways_;              // rays to lights; rays to photons
  const std::unique_ptr<PathObserver> layers_;  // null where there are none
};

}  // namespace tessera::render::TESSERA_ISA
